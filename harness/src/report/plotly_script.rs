//! The scripts that draw figures: Plotly's, as the crate `plotly` carries it, and the page's own.

use std::sync::LazyLock;

use super::colour::Colour;

/// The text of plotly.js (MIT licence): what a page needs to draw [`super::Figure::figure_json`] without a network.
pub fn plotly_script() -> &'static str {
    static SCRIPT: LazyLock<String> = LazyLock::new(|| {
        // The crate offers its scripts as HTML: plotly.js first, then one for formulas, which no figure here has.
        let html = plotly::Plot::offline_js_sources();
        let first = html.split("</script>").next().unwrap_or_default();
        first
            .split_once('>')
            .map_or("", |(_, text)| text)
            .to_owned()
    });
    &SCRIPT
}

/// The page's own script: it draws each `figure` that is in sight, in the colours of light or dark mode, and adds downloads
/// and keys. It needs [`plotly_script`] before it.
pub fn figure_script() -> &'static str {
    static SCRIPT: LazyLock<String> = LazyLock::new(|| {
        let role = |c: &Colour| (c.hex(), c.css());
        let roles: Vec<String> = Colour::ALL
            .iter()
            .map(role)
            .chain([(PAPER, "var(--paper)"), (GRID, "var(--grid)")])
            .map(|(hex, css)| {
                let name = css.trim_start_matches("var(").trim_end_matches(')');
                format!("\"{hex}\":\"{name}\"")
            })
            .collect();
        include_str!("figures.js").replace("{/* colours */}", &format!("{{{}}}", roles.join(",")))
    });
    &SCRIPT
}

/// Background and grid of figures in light mode.
pub(super) const PAPER: &str = "#ffffff";
pub(super) const GRID: &str = "#eceff2";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_script_is_plotly_alone_and_ends_no_element() {
        let script = plotly_script();
        assert!(script.contains("plotly.js v") && script.contains("newPlot"));
        assert!(!script.contains("MathJax.loader") && !script.contains("</script"));
        assert!(
            (1_000_000..5_000_000).contains(&script.len()),
            "{}",
            script.len()
        );
    }

    #[test]
    fn the_page_s_script_knows_every_colour() {
        let script = figure_script();
        assert!(script.contains(r##""#d55e00":"--orange""##) && !script.contains("/* colours */"));
        assert_eq!(script.matches(":\"--").count(), Colour::ALL.len() + 2);
    }
}
