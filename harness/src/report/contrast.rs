//! Contrast of the page's colours, read off its style sheet.
//!
//! WCAG 2.2: text needs a ratio of 4.5 to its background (1.4.3, level AA), lines and points of pictures 3 (1.4.11).

use std::collections::BTreeMap;

const STYLE: &str = include_str!("style.css");
const TEXT: f64 = 4.5;
const GRAPHICS: f64 = 3.0;

type Palette = BTreeMap<String, [f64; 3]>;

/// The colours of a `:root` block, as `#rrggbb`.
fn palette(block: &str) -> Palette {
    let channel =
        |code: &str, i: usize| f64::from(u8::from_str_radix(&code[i..i + 2], 16).unwrap()) / 255.0;
    block
        .split(';')
        .filter_map(|rule| rule.trim().strip_prefix("--")?.split_once(": #"))
        .map(|(name, code)| (name.to_owned(), [0, 2, 4].map(|i| channel(code, i))))
        .collect()
}

/// The palettes for light and for dark mode.
fn palettes() -> [(&'static str, Palette); 2] {
    let mut blocks = STYLE
        .match_indices(":root {")
        .map(|(at, start)| &STYLE[at + start.len()..at + STYLE[at..].find('}').unwrap()]);
    let light = palette(blocks.next().unwrap());
    let mut dark = light.clone();
    dark.extend(palette(blocks.next().unwrap()));
    [("light", light), ("dark", dark)]
}

/// Relative luminance, WCAG 2.2.
fn luminance(colour: [f64; 3]) -> f64 {
    let [r, g, b] = colour.map(|c| {
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    });
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

fn ratio(a: [f64; 3], b: [f64; 3]) -> f64 {
    let (a, b) = (luminance(a), luminance(b));
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

/// The names of colours that rules give to `property`.
fn used_for(property: &str) -> Vec<&'static str> {
    STYLE
        .split(['{', ';'])
        .filter_map(|rule| rule.trim().strip_prefix(property)?.strip_prefix(": var(--"))
        .filter_map(|rest| rest.split(')').next())
        .collect()
}

#[test]
fn val_ratios_are_those_of_the_standard() {
    // WCAG 2.2: black on white is 21:1; #767676 on white is the lightest grey that passes, 4.54:1.
    assert!((ratio([0.0; 3], [1.0; 3]) - 21.0).abs() < 1e-9);
    assert!((ratio([118.0 / 255.0; 3], [1.0; 3]) - 4.54).abs() < 0.005);
}

#[test]
fn every_text_can_be_read_in_light_and_dark_mode() {
    // Text of pictures is filled, other text is coloured; captions and leads are among the latter.
    let texts: Vec<&str> = used_for("color").into_iter().chain(["ink"]).collect();
    assert!(
        texts.contains(&"muted") && texts.contains(&"red"),
        "{texts:?}"
    );
    for (mode, colours) in palettes() {
        for text in &texts {
            let found = ratio(colours[*text], colours["paper"]);
            assert!(found >= TEXT, "{mode}: {text} has {found:.2}, needs {TEXT}");
        }
    }
}

#[test]
fn every_line_and_point_can_be_seen_in_light_and_dark_mode() {
    for (mode, colours) in palettes() {
        for colour in [
            "ink", "grey", "blue", "orange", "green", "red", "purple", "sky",
        ] {
            let found = ratio(colours[colour], colours["paper"]);
            assert!(
                found >= GRAPHICS,
                "{mode}: {colour} has {found:.2}, needs {GRAPHICS}"
            );
        }
    }
}

#[test]
fn pictures_as_files_have_the_page_s_colours() {
    let [(_, light), _] = palettes();
    let standalone = super::standalone::STYLE.replace(":#", ": #");
    let root = &standalone[standalone.find('{').unwrap() + 1..standalone.find('}').unwrap()];
    let own = root.replace("--paper: #fff;", "--paper: #ffffff;");
    for (name, colour) in palette(&own) {
        assert_eq!(Some(&colour), light.get(&name), "{name}");
    }
}

#[test]
fn figures_have_the_page_s_colours() {
    let [(_, light), _] = palettes();
    for colour in super::Colour::ALL {
        let name = colour
            .css()
            .trim_start_matches("var(--")
            .trim_end_matches(')');
        let own = palette(&format!("--{name}: {}", colour.hex()));
        assert_eq!(own.get(name), light.get(name), "{name}");
    }
    let ground = palette(&format!(
        "--paper: {};--grid: {}",
        super::plotly_script::PAPER,
        super::plotly_script::GRID
    ));
    assert_eq!(ground["paper"], light["paper"]);
    assert_eq!(ground["grid"], light["grid"]);
}
