//! Conservation: belt work + external work = stored + contact heat + structural heat, on every path of the base model.

use beam_physics::beam::Beam;
use beam_physics::belt::Inputs;
use beam_physics::friction::{Exponential, FrictionLaw};
use beam_physics::integrate::MAX_STATES;
use beam_physics::parameters::ModelParameters;
use beam_physics::simulate::{Simulation, Start, StartContact};

fn balance(parameters: &ModelParameters, inputs: Inputs) {
    let mut state = [0.0; MAX_STATES];
    state[0] = 9e-4;
    let start = Start {
        state,
        contact: StartContact::Stick,
        ..Start::default()
    };
    let mut run = Simulation::new(parameters, inputs, &start, 1e-12).unwrap();
    let before = run.model().stored_energy(&run.state());
    run.account_energy();
    let mut heat = 0.0;
    for i in 1..=40 {
        run.advance_to(0.0121 * f64::from(i)).unwrap();
        let e = run.energy().unwrap();
        let gain = e.stored - before + e.contact_dissipation + e.structural_dissipation;
        let size = e.belt_work.abs() + e.external_work.abs() + e.contact_dissipation + before;
        let work = e.belt_work + e.external_work;
        assert!(
            (work - gain).abs() <= 1e-9 * size,
            "{inputs:?}: {work} J of work against {gain} J",
        );
        assert!(e.contact_dissipation >= heat - 1e-15);
        assert!(e.structural_dissipation >= 0.0);
        heat = e.contact_dissipation;
    }
}

#[test]
fn val_energy_is_balanced() {
    // Source: first law, F v_belt = F w' - F v_r.
    let friction = [
        FrictionLaw::default(),
        FrictionLaw::StelterAsPrinted(Exponential::default()),
        FrictionLaw::Coulomb {
            mu_s: 0.6,
            mu_k: 0.4,
        },
        FrictionLaw::Stribeck {
            mu_s: 0.6,
            mu_k: 0.3,
            velocity: 0.03,
            exponent: 1.5,
            viscous: 0.1,
        },
    ];
    for law in friction {
        for modes in [1, 2, 4] {
            let parameters = ModelParameters {
                beam: Beam::from_frequencies(&[80.0, 510.0], &[1.5e-4, 8.5e-4], 0.427, modes)
                    .unwrap(),
                friction: law,
                ..ModelParameters::default()
            };
            balance(&parameters, Inputs::constant(0.1, 100.0));
            balance(&parameters, Inputs::constant(-0.05, 60.0));
            let ramp = Inputs {
                belt_acceleration: -0.5,
                normal_force_rate: 40.0,
                ..Inputs::constant(0.12, 80.0)
            };
            balance(&parameters, ramp);
            let pushed = Inputs {
                external_force: -30.0,
                external_force_rate: 200.0,
                ..ramp
            };
            balance(&parameters, pushed);
            let shaken = Inputs {
                clamp_acceleration: 4.0,
                clamp_acceleration_rate: -50.0,
                ..pushed
            };
            balance(&parameters, shaken);
        }
    }
}
