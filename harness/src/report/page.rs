//! The HTML page: title, sections, paragraphs, tables, figures.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::colour::Colour;
use super::drawn::{COLUMNS, Drawn};
use super::plotly_script::{figure_script, plotly_script};
use super::table::Table;

/// Something that can be drawn.
pub trait Figure {
    /// The figure as Plotly reads it. Of a longer series each of so many columns of the picture keeps its lowest and its
    /// highest point.
    fn draw(&self, columns: usize) -> Drawn;
    /// One sentence that says what it shows.
    fn caption(&self) -> &str;
    /// Height in px beside a legend of one line.
    fn height(&self) -> f64;
    /// A copy for the page to keep.
    fn boxed(&self) -> Box<dyn Figure>;
    /// `data` and `layout` of the figure, for any program that draws with Plotly; colours are those of light mode.
    fn figure_json(&self) -> serde_json::Value {
        self.draw(COLUMNS).json
    }
}

/// A self-contained page, filled from top to bottom. A page with figures folds its sections; the first is
/// open unless a figure stands before it.
pub struct Page {
    title: String,
    parts: Vec<Part>,
    foot: String,
}

enum Part {
    Html(String),
    Section(String),
    Figure(Box<dyn Figure>),
}

/// A page takes no more than this, bytes: it is to be sent by mail, and to open at once.
const LARGEST: usize = 5_900_000;

/// How figures are used; the scripts beside this file act on it.
const KEYS: &str = "Figures: point at a line for its values; drag to zoom, double-click to go back; click a name in the \
    legend to hide or show it. With keys: Tab to a figure, + and - zoom, arrows move, 0 goes back, Tab on to buttons and \
    legend, Enter presses.";

impl Page {
    /// A page with its title and a leading sentence.
    pub fn new(title: &str, lead: &str) -> Page {
        let head = html! { h1 { (title) } p.lead { (lead) } };
        Page {
            title: title.to_owned(),
            parts: vec![Part::Html(head.into_string())],
            foot: String::new(),
        }
    }

    fn add(mut self, part: Markup) -> Page {
        self.parts.push(Part::Html(part.into_string()));
        self
    }

    fn side_by_side(mut self, class: &str, figures: &[&dyn Figure]) -> Page {
        self.parts
            .push(Part::Html(format!("<div class=\"{class}\">")));
        let figures = figures.iter().map(|f| Part::Figure(f.boxed()));
        self.parts.extend(figures);
        self.parts.push(Part::Html("</div>".into()));
        self
    }

    /// A bar that stays in sight while the page is scrolled, where the screen has room for it: a verdict in a few words, and
    /// links to sections.
    pub fn banner(self, colour: Colour, headline: &str, text: &str, sections: &[&str]) -> Page {
        let style = format!("border-color:{}", colour.css());
        self.add(html! {
            header.banner style=(style) {
                strong { (headline) } " " span { (text) }
                @if !sections.is_empty() { nav { @for title in sections { a href={ "#" (anchor(title)) } { (title) } } } }
            }
        })
    }

    /// A command line or other text to be copied.
    pub fn code(self, text: &str) -> Page {
        self.add(html! { pre { code { (text) } } })
    }

    /// Starts a section.
    pub fn section(mut self, title: &str) -> Page {
        self.parts.push(Part::Section(title.to_owned()));
        self
    }

    /// Starts a part of a section.
    pub fn subsection(self, title: &str) -> Page {
        self.add(html! { h3 { (title) } })
    }

    /// A paragraph.
    pub fn paragraph(self, text: &str) -> Page {
        self.add(html! { p { (text) } })
    }

    /// A bulleted list.
    pub fn list(self, items: &[String]) -> Page {
        self.add(html! { ul { @for item in items { li { (item) } } } })
    }

    /// A table.
    pub fn table(self, table: &Table) -> Page {
        self.add(table.html())
    }

    /// A figure over the whole width.
    pub fn figure(mut self, figure: &dyn Figure) -> Page {
        self.parts.push(Part::Figure(figure.boxed()));
        self
    }

    /// Figures side by side, where the window is wide enough.
    pub fn figures(self, figures: &[&dyn Figure]) -> Page {
        self.side_by_side("figures", figures)
    }

    /// Small figures, three side by side where the window is wide enough; about 400 px wide each.
    pub fn small_figures(self, figures: &[&dyn Figure]) -> Page {
        self.side_by_side("figures small", figures)
    }

    /// The page's foot: names and values, small, in the order given.
    pub fn foot(mut self, lines: &[(&str, String)]) -> Page {
        let foot = html! {
            footer { dl { @for (name, value) in lines { dt { (name) } dd { (value) } } } }
        };
        self.foot = foot.into_string();
        self
    }

    /// The finished document, its figures thinned until it is small enough.
    pub fn html(&self) -> String {
        let mut columns = COLUMNS;
        loop {
            let document = self.document(columns);
            if document.len() <= LARGEST || columns <= COLUMNS / 16 {
                return document;
            }
            columns /= 2;
        }
    }

    fn document(&self, columns: usize) -> String {
        let has_figures = self.parts.iter().any(|p| matches!(p, Part::Figure(_)));
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { (self.title) }
                    style { (PreEscaped(include_str!("style.css"))) }
                }
                body {
                    main {
                        (PreEscaped(self.body(columns, has_figures)))
                        @if has_figures {
                            noscript { p { "Figures need JavaScript; tables and text do not." } }
                            p.keys { (KEYS) }
                        }
                        (PreEscaped(&self.foot))
                    }
                    @if has_figures {
                        script { (PreEscaped(plotly_script())) }
                        script { (PreEscaped(figure_script())) }
                    }
                }
            }
        }
        .into_string()
    }

    fn body(&self, columns: usize, folds: bool) -> String {
        let (mut body, mut sections, mut figures) = (String::new(), 0, 0);
        for part in &self.parts {
            if matches!(part, Part::Section(_)) && folds && sections > 0 {
                body.push_str("</details>");
            }
            match part {
                Part::Html(text) => body.push_str(text),
                Part::Section(title) if folds => {
                    let open = if figures == 0 && sections == 0 {
                        " open"
                    } else {
                        ""
                    };
                    let head = html! { summary { h2 { (title) } } }.into_string();
                    let id = anchor(title);
                    body.push_str(&format!("<details id=\"{id}\"{open}>{head}"));
                    sections += 1;
                }
                Part::Section(title) => {
                    let head = html! { h2 id=(anchor(title)) { (title) } };
                    body.push_str(&head.into_string());
                }
                Part::Figure(figure) => {
                    figures += 1;
                    body.push_str(&markup(figure.as_ref(), figures, columns).into_string());
                }
            }
        }
        if folds && sections > 0 {
            body.push_str("</details>");
        }
        body
    }
}

/// A title as the name of a link's target.
fn anchor(title: &str) -> String {
    let keep = |c: char| {
        if c.is_ascii_alphanumeric() {
            c.to_ascii_lowercase()
        } else {
            '-'
        }
    };
    title.chars().map(keep).collect()
}

fn markup(figure: &dyn Figure, number: usize, columns: usize) -> Markup {
    let drawn = figure.draw(columns);
    // Inside a script element nothing is escaped, so no text may look like its end.
    let json = drawn.json.to_string().replace("</", "<\\/");
    let size = format!(
        "--height:{:.0}px;--legend:{}",
        figure.height(),
        drawn.legend()
    );
    html! {
        figure id={ "figure-" (number) } {
            div.plot tabindex="0" role="group" aria-label=(figure.caption()) style=(size) {}
            script type="application/json" { (PreEscaped(json)) }
            figcaption {
                (figure.caption())
                @if let Some(note) = drawn.thinned() { " " (note) }
                span.downloads {
                    @for kind in ["PNG", "SVG", "CSV"] { button type="button" data-kind=(kind) { (kind) } }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Axis, Plot};

    fn plot(points: usize) -> Plot {
        let x: Vec<f64> = (0..points).map(|i| 1e-4 * i as f64).collect();
        let y: Vec<f64> = x.iter().map(|x| (300.0 * x).sin()).collect();
        Plot::new(Axis::linear("time", "s"), Axis::linear("way", "mm"))
            .line("</script>", Colour::Blue, &x, &y)
            .caption("A wave.")
    }

    #[test]
    fn a_page_of_long_records_stays_small() {
        let record = plot(100_000);
        let page = (0..60).fold(Page::new("a", "b"), |page, _| page.figure(&record));
        let html = page.html();
        assert!(html.len() <= LARGEST, "{}", html.len());
        assert_eq!(html.matches("<figure ").count(), 60);
        assert!(html.contains("of 100000 points are drawn: extremes are kept"));
    }

    #[test]
    fn sections_fold_where_there_are_figures() {
        let page = |first: bool| {
            let page = Page::new("a", "b");
            let page = if first { page.figure(&plot(9)) } else { page };
            let page = page.section("One").figure(&plot(9)).section("Two");
            page.paragraph("End.")
                .foot(&[("version", "1".into())])
                .html()
        };
        let (behind, at_once) = (page(true), page(false));
        assert_eq!(behind.matches("<details id=").count(), 2);
        assert_eq!(behind.matches("</details>").count(), 2);
        assert!(!behind.contains("\" open>") && at_once.contains("<details id=\"one\" open>"));
        assert!(behind.find("</details>").unwrap() < behind.find("<footer>").unwrap());
        assert_eq!(behind.matches(plotly_script()).count(), 1, "one copy");
    }

    #[test]
    fn a_page_without_figures_has_neither_folds_nor_scripts() {
        let html = Page::new("a", "b").section("One").paragraph("c").html();
        assert!(!html.contains("<script") && !html.contains("<details"));
        assert!(html.contains("<h2 id=\"one\">One</h2>"));
    }

    #[test]
    fn no_name_ends_the_script_that_holds_it() {
        let html = Page::new("a", "b").figure(&plot(9)).html();
        let (_, rest) = html
            .split_once("<script type=\"application/json\">")
            .unwrap();
        let json = rest.split("</script>").next().unwrap();
        let figure: serde_json::Value = serde_json::from_str(json).unwrap();
        assert_eq!(figure["data"][0]["name"], "</script>");
    }
}
