//! The value of a property at an element: of its attribute, of the rules that match it, and of its `style`, which win in
//! this order. usvg does the same for what it reads; this is for texts, dashes and transforms, whose numbers are read here.

use super::css;
use roxmltree::{Document, Node, NodeId};
use simplecss::{AttributeOperator, PseudoClass, StyleSheet};
use std::collections::HashMap;

/// The style sheets of a document, and which of their rules match which element.
pub struct Cascade<'a> {
    sheet: StyleSheet<'a>,
    matching: HashMap<NodeId, Vec<usize>>,
}

/// All style sheets of a document as one, as usvg is to read it.
pub fn sheets(document: &Document<'_>) -> String {
    let styles = document.descendants().filter(|node| node.tag_name().name() == "style" && node.is_element());
    let styles = styles.filter(|node| matches!(attribute(*node, "type"), None | Some("text/css" | "")));
    styles.flat_map(|node| node.children()).filter_map(|node| node.text()).map(css::sheet).collect()
}

/// An attribute that is in no namespace.
pub fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    node.attributes().find(|a| a.name() == name && a.namespace().is_none()).map(|a| a.value())
}

impl<'a> Cascade<'a> {
    /// The rules of a sheet that match the elements of a document.
    pub fn new(sheet: StyleSheet<'a>, document: &Document<'_>) -> Self {
        let mut matching: HashMap<NodeId, Vec<usize>> = HashMap::new();
        for node in document.descendants().filter(|node| node.is_element() && !sheet.rules.is_empty()) {
            for (k, rule) in sheet.rules.iter().enumerate() {
                if rule.selector.matches(&Selected(node)) {
                    matching.entry(node.id()).or_default().push(k);
                }
            }
        }
        Self { sheet, matching }
    }

    /// What rules and `style` declare for an element, in the order in which later ones win.
    ///
    /// A `style` in which the word does not occur is not taken apart.
    fn declared(&self, node: Node<'_, '_>, word: &str, mut each: impl FnMut(&str, &str, bool)) {
        for &k in self.matching.get(&node.id()).into_iter().flatten() {
            for declaration in &self.sheet.rules[k].declarations {
                each(declaration.name, declaration.value, declaration.important);
            }
        }
        let may_say =
            |style: &&str| style.contains(word) || style.bytes().any(|byte| byte.is_ascii_uppercase());
        if let Some(style) = attribute(node, "style").filter(may_say) {
            for declaration in css::declarations(&css::without_comments(style)) {
                each(&declaration.name, &declaration.value, declaration.important);
            }
        }
    }

    /// All that rules and `style` declare for an element, as a `style`.
    pub fn style(&self, node: Node<'_, '_>) -> String {
        let mut style = String::new();
        self.declared(node, "", |name, value, important| {
            style += &format!("{name}:{value}{};", if important { "!important" } else { "" });
        });
        style
    }

    /// The element's own value of a property.
    pub fn own(&self, node: Node<'_, '_>, property: &str) -> Option<String> {
        let mut found = attribute(node, property).map(|value| (value.trim().to_owned(), false));
        let word = if property.starts_with("font-") { "font" } else { property };
        self.declared(node, word, |name, value, important| {
            if found.as_ref().is_some_and(|(_, wins)| *wins) {
                return;
            }
            if name == property {
                found = Some((value.to_owned(), important));
            } else if name == "font"
                && property.starts_with("font-")
                && let Ok(font) = svgtypes::FontShorthand::from_str(value)
            {
                let part = if property == "font-size" { font.font_size } else { font.font_family };
                found = Some((part.to_owned(), important));
            }
        });
        found.map(|(value, _)| value)
    }

    /// The value of a property that is inherited.
    pub fn inherited(&self, node: Node<'_, '_>, property: &str) -> Option<String> {
        let elements = node.ancestors().filter(Node::is_element);
        elements.filter_map(|node| self.own(node, property)).find(|value| value != "inherit")
    }
}

/// An element as selectors see it.
struct Selected<'a, 'b>(Node<'a, 'b>);

impl simplecss::Element for Selected<'_, '_> {
    fn parent_element(&self) -> Option<Self> {
        self.0.parent_element().map(Selected)
    }

    fn prev_sibling_element(&self) -> Option<Self> {
        self.0.prev_sibling_element().map(Selected)
    }

    fn has_local_name(&self, name: &str) -> bool {
        self.0.tag_name().name() == name
    }

    fn attribute_matches(&self, name: &str, operator: AttributeOperator<'_>) -> bool {
        attribute(self.0, name).is_some_and(|value| operator.matches(value))
    }

    fn pseudo_class_matches(&self, class: PseudoClass<'_>) -> bool {
        matches!(class, PseudoClass::FirstChild) && self.0.prev_sibling_element().is_none()
    }
}
