//! The HTML page: title, sections, paragraphs, tables, figures.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::colour::Colour;
use super::table::Table;

/// Something that can be drawn.
pub trait Figure {
    /// The picture as an `<svg>` element.
    fn svg(&self) -> String;
    /// The picture laid out anew for a screen as narrow as a phone's; without one the wide picture is moved sideways there.
    fn narrow_svg(&self) -> Option<String> {
        None
    }
    /// One sentence that says what it shows.
    fn caption(&self) -> &str;
}

/// A self-contained page, filled from top to bottom.
#[derive(Debug, Clone)]
pub struct Page {
    title: String,
    body: String,
}

impl Page {
    /// A page with its title and a leading sentence.
    pub fn new(title: &str, lead: &str) -> Page {
        Page {
            title: title.to_owned(),
            body: html! { h1 { (title) } p.lead { (lead) } }.into_string(),
        }
    }

    fn add(mut self, part: Markup) -> Page {
        self.body.push_str(&part.into_string());
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
    pub fn section(self, title: &str) -> Page {
        self.add(html! { h2 id=(anchor(title)) { (title) } })
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
    pub fn figure(self, figure: &dyn Figure) -> Page {
        self.add(markup(figure))
    }

    /// Figures side by side, where the window is wide enough.
    pub fn figures(self, figures: &[&dyn Figure]) -> Page {
        self.add(html! { div.figures { @for figure in figures { (markup(*figure)) } } })
    }

    /// Small figures, three side by side where the window is wide enough; about 400 px wide each.
    pub fn small_figures(self, figures: &[&dyn Figure]) -> Page {
        self.add(html! { div.figures.small { @for figure in figures { (markup(*figure)) } } })
    }

    /// The page's foot: names and values, small, in the order given.
    pub fn foot(self, lines: &[(&str, String)]) -> Page {
        self.add(html! {
            footer { dl { @for (name, value) in lines { dt { (name) } dd { (value) } } } }
        })
    }

    /// The finished document.
    pub fn html(&self) -> String {
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { (self.title) }
                    style { (PreEscaped(include_str!("style.css"))) }
                }
                body { main { (PreEscaped(&self.body)) } }
            }
        }
        .into_string()
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

fn markup(figure: &dyn Figure) -> Markup {
    html! {
        figure {
            @match figure.narrow_svg() {
                Some(narrow) => {
                    div.wide { (PreEscaped(figure.svg())) }
                    div.narrow { (PreEscaped(narrow)) }
                }
                None => div.sideways tabindex="0" { (PreEscaped(figure.svg())) }
            }
            figcaption { (figure.caption()) }
        }
    }
}
