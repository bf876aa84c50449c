//! The simple rules of style sheets: by class, id or element.

use roxmltree::{Document, Node};
use std::collections::HashMap;

/// Rules of all `style` elements.
#[derive(Debug, Default)]
pub(super) struct StyleSheet {
    /// Declarations by selector: `.class`, `#id`, `element` or `*`; of each name the last, in the order
    /// of the sheet.
    rules: HashMap<String, Vec<(String, String)>>,
    /// Number of rules with other selectors, which are not applied.
    pub not_applied: usize,
}

impl StyleSheet {
    /// Reads the style sheets of a document.
    pub fn new(xml: &Document) -> StyleSheet {
        let mut sheet = StyleSheet::default();
        let styles = xml.descendants().filter(|n| n.tag_name().name() == "style");
        for style in styles {
            let texts = style.children().filter_map(|n| n.text());
            let text: String = texts.collect();
            sheet.add(&without_remarks(&text));
        }
        sheet
    }

    fn add(&mut self, text: &str) {
        for rule in text.split('}') {
            let Some((selectors, body)) = rule.split_once('{') else {
                continue;
            };
            let declarations: Vec<(String, String)> = (body.split(';'))
                .filter_map(|d| d.split_once(':'))
                .map(|(name, value)| (name.trim().to_owned(), value.trim().to_owned()))
                .filter(|(name, _)| matters(name))
                .collect();
            if declarations.is_empty() {
                continue;
            }
            for selector in selectors.split(',').map(str::trim) {
                if is_simple(selector) {
                    let rules = self.rules.entry(selector.to_owned()).or_default();
                    for declaration in &declarations {
                        // Only the last of a name counts, and every element of the class looks at
                        // all that are kept.
                        rules.retain(|(name, _)| *name != declaration.0);
                        rules.push(declaration.clone());
                    }
                } else {
                    self.not_applied += 1
                }
            }
        }
    }

    /// The declarations for an element, lowest priority first: by element, by class, by id.
    pub fn declarations<'s>(
        &'s self,
        element: Node<'s, '_>,
    ) -> impl Iterator<Item = (&'s str, &'s str)> {
        let classes = element.attribute("class").unwrap_or("").split_whitespace();
        let classes = classes.map(|class| format!(".{class}"));
        let id = element.attribute("id").map(|id| format!("#{id}"));
        let tag = ["*".to_owned(), element.tag_name().name().to_owned()];
        let selectors = tag.into_iter().chain(classes).chain(id);
        let rules = selectors.filter_map(|selector| self.rules.get(&selector));
        rules.flatten().map(|(name, value)| (&**name, &**value))
    }
}

fn matters(name: &str) -> bool {
    const NAMES: [&str; 15] = [
        "fill",
        "fill-rule",
        "fill-opacity",
        "opacity",
        "display",
        "visibility",
        "color",
        "clip-path",
        "clip-rule",
        "mask",
        "filter",
        "overflow",
        "font",
        "letter-spacing",
        "text-anchor",
    ];
    let is_of_group = |group: &str| name.starts_with(group);
    NAMES.contains(&name)
        || ["stroke", "font-", "marker", "vector-effect"]
            .into_iter()
            .any(is_of_group)
}

/// Whether a selector is a single name.
fn is_simple(selector: &str) -> bool {
    let name = selector.strip_prefix(['.', '#']).unwrap_or(selector);
    let is_name = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_');
    selector == "*" || (!name.is_empty() && name.chars().all(is_name))
}

fn without_remarks(text: &str) -> String {
    let mut result = String::new();
    let mut rest = text;
    while let Some((before, behind)) = rest.split_once("/*") {
        result.push_str(before);
        rest = behind.split_once("*/").map_or("", |(_, behind)| behind);
    }
    result.push_str(rest);
    result
}
