//! Files of users' effects: what they become, and what is said of those that can't be used.

use beam_model_description::{
    FIRST_USER_REFERENCE, Layout, MAX_USER_EFFECTS, UserCard, UserEffectError, guid, variables, xml,
};

const GOOD: &str = "\
id = \"direction\"
title = \"Friction depends on the direction\"
target = \"friction_factor\"
expression = \"1 + a*tanh(w_dot/v)\"

[[parameter]]
name = \"a\"
unit = \"1\"
min = -0.5
max = 0.5
typical = 0.1

[[parameter]]
name = \"v\"
unit = \"furlong/s\"
min = 1e-3
max = 0.2
typical = 0.02
role = \"shape\"
";

#[test]
fn a_file_becomes_a_card_and_parameters_behind_the_fixed_table() {
    let card = UserCard::parse(GOOD).unwrap();
    assert_eq!(card.equation(), "mu -> mu (1 + a*tanh(w_dot/v))");
    assert!(card.effect(&[0.0, 0.02]).is_none(), "off");
    assert!(card.effect(&[0.1, 0.02]).is_some(), "on");
    let mut other = card.clone();
    other.id = "another".into();
    let layout = Layout::with(vec![card.clone(), other.clone()]).unwrap();
    assert!(std::ptr::eq(
        layout,
        Layout::with(vec![card, other]).unwrap()
    ));
    let fixed = variables().len();
    for (i, v) in variables().iter().enumerate() {
        assert_eq!(layout.variables()[i].reference, v.reference);
        assert_eq!(layout.index_of_name(&v.name), Some(i));
    }
    let own: Vec<_> = layout.variables()[fixed..]
        .iter()
        .map(|v| (v.name.as_str(), v.reference, v.start))
        .collect();
    let first = FIRST_USER_REFERENCE;
    assert_eq!(
        own,
        [
            ("direction.a", first, Some(0.0)),
            ("direction.v", first + 1, Some(0.02)),
            ("another.a", first + 100, Some(0.0)),
            ("another.v", first + 101, Some(0.02)),
        ]
    );
    assert_eq!(layout.index_of_reference(first + 101), Some(fixed + 3));
    assert_eq!(layout.index_of_reference(first + 2), None);
}

#[test]
fn the_description_has_the_card_and_is_else_the_plain_one() {
    let layout = Layout::with(vec![UserCard::parse(GOOD).unwrap()]).unwrap();
    let none: [(&str, f64); 0] = [];
    let (text, its_guid) = layout.xml_with_starts(&none).unwrap();
    assert_ne!(its_guid, guid());
    let mut rest = text.lines();
    for line in xml().lines().filter(|l| !l.contains("guid=")) {
        assert!(rest.any(|l| l == line), "{line}");
    }
    for part in [
        "<Effect id=\"direction\" title=\"Friction depends on the direction\"",
        "role=\"shape\"",
        "<Unit name=\"furlong/s\"/>",
        "name=\"direction.v\" valueReference=\"9001\"",
    ] {
        assert!(text.contains(part), "{part}");
    }
    let toml = layout
        .start_values_toml(&[("direction.a", 0.2)], &its_guid)
        .unwrap();
    assert!(toml.contains("file = \"effects/direction.toml\""), "{toml}");
    assert!(toml.ends_with("[start]\n\"direction.a\" = 0.2\n"), "{toml}");
}

#[test]
fn files_that_cannot_be_used_are_refused_with_line_value_and_remedy() {
    let many = |name: &str, from: &str, count: usize| {
        let one = |i: usize| from.replace(name, &format!("{name}{i}"));
        (0..count).map(one).collect::<String>()
    };
    let parameter =
        &GOOD[GOOD.find("[[parameter]]").unwrap()..GOOD.rfind("[[parameter]]").unwrap()];
    let too_many = many("name = \"a", parameter, 49);
    let cases: [(&str, &str, usize, &str); 24] = [
        ("id = ", "id ", 1, "key"),
        ("title = ", "titel = ", 2, "unknown field `titel`"),
        ("min = -0.5\n", "", 6, "missing field `min`"),
        ("= 0.1", "= \"x\"", 11, "invalid type"),
        (
            "\"direction\"",
            "\"third_mode\"",
            1,
            "id = 'third_mode' can't be used: an effect of the catalogue has it",
        ),
        (
            "\"direction\"",
            "\"two words\"",
            1,
            "letters (a-z), digits and '_'",
        ),
        (
            "\"direction\"",
            "\"friction\"",
            1,
            "variables of the FMU begin with it",
        ),
        (
            "\"direction\"",
            "\"mode\"",
            1,
            "variables of the FMU begin with it",
        ),
        (
            "Friction depends on the direction",
            " ",
            2,
            "title is empty",
        ),
        (
            "friction_factor",
            "friction",
            3,
            "target = 'friction' is unknown; write friction_factor, normal_force_factor, tip_force, belt_velocity",
        ),
        (
            "tanh(w_dot/v)",
            "tanh(w_dt/v)",
            4,
            "column 12: unknown name 'w_dt'; known are t, w, w_dot",
        ),
        ("tanh(w_dot/v)", "tanh(w_dot/v", 4, "')'"),
        (
            "a*tanh(w_dot/v)",
            "a*w_dot",
            4,
            "parameter 'v' is not in the formula",
        ),
        (
            "1 + a*",
            "a*",
            4,
            "with all amplitudes 0 the expression gives 0 instead of 1",
        ),
        ("friction_factor", "tip_force", 4, "gives 1 instead of 0"),
        (
            "friction_factor",
            "belt_velocity",
            4,
            "may depend on t, F_N and v0 only",
        ),
        (
            "name = \"a\"",
            "name = \"w\"",
            4,
            "'w' can't name a parameter",
        ),
        (
            "name = \"a\"",
            "name = \"\u{e4}\"",
            7,
            "name = '\u{e4}' is unknown; write letters",
        ),
        (
            "role = \"shape\"",
            "role = \"form\"",
            19,
            "role = 'form' is unknown; write amplitude, shape, phase, setting",
        ),
        (
            "max = 0.5",
            "max = -0.6",
            10,
            "parameter 'a': max = -0.6 1 is not possible; it must be finite and greater than min",
        ),
        ("min = -0.5", "min = nan", 9, "min = NaN 1 is not possible"),
        (
            "typical = 0.1",
            "typical = 0.9",
            11,
            "typical = 0.9 1 is not possible; it must be from min to max",
        ),
        ("typical = 0.1", "typical = 0.0", 11, "different from 0"),
        (
            "min = -0.5",
            "min = 0.05",
            9,
            "0 or less: an amplitude of 0 means off",
        ),
    ];
    for (from, to, line, part) in cases {
        let text = GOOD.replacen(from, to, 1);
        assert_ne!(text, GOOD, "{from}");
        let error = UserCard::parse(&text).expect_err(to);
        assert!(error.to_string().contains(part), "{to}: {error}");
        assert_eq!(error.line(), Some(line), "{to}: {error}");
    }
    let text = GOOD.replacen(parameter, &too_many, 1);
    let error = UserCard::parse(&text).unwrap_err();
    assert!(
        error.to_string().contains("50 parameters; at most 48"),
        "{error}"
    );
    let text = GOOD.replacen("typical = 0.1\n", "typical = 0.1\nrole = \"setting\"\n", 1);
    assert!(matches!(
        UserCard::parse(&text),
        Err(UserEffectError::NoAmplitude { line: 4 })
    ));
}

#[test]
fn effects_with_one_id_and_too_many_effects_are_refused() {
    let card = UserCard::parse(GOOD).unwrap();
    let error = Layout::with(vec![card.clone(); 2]).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("two effects have the id 'direction'")
    );
    let all: Vec<UserCard> = (0..=MAX_USER_EFFECTS)
        .map(|i| UserCard {
            id: format!("e{i}"),
            ..card.clone()
        })
        .collect();
    let error = Layout::with(all).unwrap_err();
    assert!(error.to_string().contains("81 effects"), "{error}");
}

const WITH_MEMORY: &str = r#"id = "warm"
title = "Friction falls with a temperature"
target = "friction_factor"
expression = "1 - k*heat + table(v_abs, g)"

[[parameter]]
name = "k"
unit = "1/J"
min = -1
max = 1
typical = 0.01

[[state]]
name = "heat"
unit = "J"
nominal = 5.0
rate = "abs(F*v_r) - heat/0.1"

[[table]]
name = "g"
unit = "1"
at = [0.0, 0.1, 0.3]
min = -0.5
max = 0.5
typical = 0.02
"#;

#[test]
fn states_and_tables_are_read_and_bring_variables() {
    let card = UserCard::parse(WITH_MEMORY).unwrap();
    assert_eq!(
        card.equation(),
        "mu -> mu (1 - k*heat + table(v_abs, g)),  heat' = abs(F*v_r) - heat/0.1"
    );
    let layout = Layout::with(vec![card]).unwrap();
    for name in [
        "warm.k",
        "warm.g_1",
        "warm.g_3",
        "warm.state.heat",
        "der(warm.state.heat)",
    ] {
        assert!(layout.index_of_name(name).is_some(), "{name}");
    }
    let list = WITH_MEMORY.replace("typical = 0.02", "typical = [0.01, 0.02, 0.03]");
    let typical = UserCard::parse(&list).unwrap().parameters[3].typical;
    assert_eq!(typical, 0.03);
}

#[test]
fn states_and_tables_that_cannot_be_are_refused_with_line_and_remedy() {
    for (from, to, line, part) in [
        ("nominal = 5.0", "nominal = 0.0", 16, "it must be positive"),
        ("heat/0.1", "cold/0.1", 4, "unknown name 'cold'"),
        (
            "unit = \"J\"",
            "unit = \"K\"",
            4,
            "expression: 1 - k*heat + table(v_abs, g) is in kg^-1.m^-2.s^2.K, but what it stands for is in a plain number",
        ),
        (
            "- heat/0.1",
            "- w",
            4,
            "rate of state 'heat': the two sides of '-' are in kg.m^2.s^-3 and in m",
        ),
        (
            "at = [0.0, 0.1, 0.3]",
            "at = [0.0, 0.3, 0.1]",
            22,
            "each behind the one before",
        ),
        (
            "typical = 0.02",
            "typical = [0.1, 0.2]",
            25,
            "one number, or 3 as at has",
        ),
        (
            "title",
            "mode = 1\ntitle",
            2,
            "with target = 'frequency_factor'",
        ),
        (
            "name = \"heat\"",
            "name = \"F\"",
            4,
            "'F' can't name a state",
        ),
    ] {
        let text = WITH_MEMORY.replacen(from, to, 1);
        assert_ne!(text, WITH_MEMORY, "{from}");
        let error = UserCard::parse(&text).expect_err(to);
        assert!(error.to_string().contains(part), "{to}: {error}");
        assert_eq!(error.line(), Some(line), "{to}: {error}");
    }
}
