//! What holds for every diagnosis, whatever its verdict.

use serde_json::Value;

/// Effects without an amplitude: within their bounds they are never quite off.
const NEVER_OFF: [&str; 5] = [
    "third_mode",
    "presliding_compliance",
    "belt_drive_compliance",
    "frictional_lag",
    "sensor_lag",
];

/// The invariants that hold for every diagnosis, whatever its verdict.
pub fn check_invariants(diagnosis: &Value) {
    for candidate in diagnosis["candidates"].as_array().unwrap() {
        let id = candidate["id"].as_str().unwrap();
        // As good as off, at a billionth of its usual strength, an effect with an amplitude is the calibrated model itself, so
        // its best fit can't be worse by anything that changes odds.
        let fall = candidate["misfit_fall"].as_f64().unwrap_or(f64::NAN);
        if !NEVER_OFF.contains(&id) {
            assert!(
                fall > -0.05,
                "{id} ends {fall} above the model that it extends"
            );
        }
    }
    let ladder = diagnosis["error_ladder"].as_array().unwrap();
    assert_eq!(ladder[0]["step"], "as given");
    assert_eq!(ladder[1]["step"], "calibrated");
    let named = diagnosis["effects"].as_array().unwrap().len();
    match diagnosis["verdict"].as_str().unwrap() {
        "effect_found" => assert_eq!(ladder.len(), 2 + named),
        _ => assert_eq!(named, 0),
    }
}
