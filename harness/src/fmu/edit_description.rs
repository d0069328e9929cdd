//! Changes single attributes of a modelDescription.xml; every other byte stays as it is.

use std::collections::HashMap;
use std::ops::Range;

use roxmltree::{Document, Node, ParsingOptions};

/// The text with these start values, by variable name.
///
/// # Errors
/// What is not well-formed, or the variable that is missing or has no number to start from.
pub fn with_starts(xml: &str, starts: &[(String, f64)]) -> Result<String, String> {
    let document = parse(xml)?;
    let is_variable = |n: &Node| n.has_tag_name("ScalarVariable");
    let variables: HashMap<&str, Node> = document
        .descendants()
        .filter(is_variable)
        .filter_map(|n| Some((n.attribute("name")?, n)))
        .collect();
    let mut edits = Vec::new();
    for (name, value) in starts {
        let numeric = |n: &Node| NUMERIC.contains(&n.tag_name().name());
        let body = variables
            .get(name.as_str())
            .ok_or_else(|| format!("there is no variable '{name}'"))?
            .children()
            .find(numeric)
            .ok_or_else(|| format!("variable '{name}' is no number"))?;
        let text = match body.tag_name().name() {
            "Real" => format!("{value:?}"),
            _ => format!("{value:.0}"),
        };
        edits.push(set(xml, &body, "start", &text));
    }
    Ok(apply(xml, edits))
}

/// Elements of a variable whose start value is a number.
const NUMERIC: [&str; 3] = ["Real", "Integer", "Enumeration"];

/// The text with this GUID.
///
/// # Errors
/// What is not well-formed.
pub fn with_guid(xml: &str, guid: &str) -> Result<String, String> {
    let document = parse(xml)?;
    let edit = set(xml, &document.root_element(), "guid", guid);
    Ok(apply(xml, vec![edit]))
}

fn parse(xml: &str) -> Result<Document<'_>, String> {
    let options = ParsingOptions {
        allow_dtd: true,
        ..ParsingOptions::default()
    };
    Document::parse_with_options(xml, options).map_err(|e| format!("not well-formed XML: {e}"))
}

/// The change that gives an element's attribute a value: what to replace, and by what.
fn set(xml: &str, node: &Node, name: &str, value: &str) -> (Range<usize>, String) {
    match node.attribute_node(name) {
        Some(attribute) => (attribute.range_value(), value.to_owned()),
        None => {
            // Behind the element's name, which ends at a blank, '/' or '>'.
            let begin = node.range().start;
            let end = xml[begin..]
                .find(|c: char| c.is_whitespace() || c == '/' || c == '>')
                .map_or(xml.len(), |length| begin + length);
            (end..end, format!(" {name}=\"{value}\""))
        }
    }
}

fn apply(xml: &str, mut edits: Vec<(Range<usize>, String)>) -> String {
    // Of two changes of one place the later counts.
    edits.reverse();
    edits.sort_by_key(|(range, _)| range.start);
    edits.dedup_by_key(|(range, _)| range.start);
    let mut out = String::with_capacity(xml.len() + 64);
    let mut at = 0;
    for (range, text) in edits {
        out += &xml[at..range.start];
        out += &text;
        at = range.end;
    }
    out + &xml[at..]
}

#[cfg(test)]
mod tests {
    use super::*;

    const XML: &str = "<?xml version='1.0'?>\n<!DOCTYPE x>\n<fmiModelDescription  guid='{1}'><!-- a -->\n\
        <ModelVariables><ScalarVariable name=\"a\"><Real\n  unit='m' start='1'\tmax=\"9\"/></ScalarVariable>\n\
        <ScalarVariable name=\"b &amp; c\"><Integer/></ScalarVariable>\n\
        <ScalarVariable name=\"d\"><String start=\"\"/></ScalarVariable></ModelVariables></fmiModelDescription>\n";

    #[test]
    fn only_the_attributes_asked_for_change() {
        let starts = [("b & c".to_owned(), 3.0), ("a".to_owned(), 0.25)];
        let text = with_starts(XML, &starts).unwrap();
        let expected = XML
            .replace("start='1'", "start='0.25'")
            .replace("<Integer/>", "<Integer start=\"3\"/>");
        assert_eq!(text, expected);
        let twice = [("a".to_owned(), 7.0), starts[0].clone(), starts[1].clone()];
        assert_eq!(with_starts(XML, &twice).unwrap(), expected);
        let text = with_guid(XML, "{2}").unwrap();
        assert_eq!(text, XML.replace("{1}", "{2}"));
    }

    #[test]
    fn what_cannot_be_changed_is_named() {
        for (name, part) in [("x", "no variable 'x'"), ("d", "'d' is no number")] {
            let error = with_starts(XML, &[(name.to_owned(), 1.0)]).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
        assert!(with_guid("<a", "").unwrap_err().contains("well-formed"));
    }
}
