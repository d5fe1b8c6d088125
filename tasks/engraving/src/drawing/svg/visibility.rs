//! Which elements are seen: `display`, `visibility` and zero opacity, as attribute or in `style`.

use roxmltree::Node;

/// A presentation property of an element: its `style` wins over its attribute.
#[must_use]
pub fn property<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    let styled = node.attribute("style").and_then(|style| {
        style.split(';').rev().find_map(|rule| {
            let (key, value) = rule.split_once(':')?;
            (key.trim() == name).then(|| value.trim().trim_end_matches("!important").trim())
        })
    });
    styled.or_else(|| node.attribute(name).map(str::trim))
}

/// Whether the element and all below it are left out.
#[must_use]
pub fn is_switched_off(node: Node<'_, '_>) -> bool {
    property(node, "display") == Some("none")
        || property(node, "opacity").and_then(|o| o.parse::<f64>().ok()).is_some_and(|o| o <= 0.0)
}

/// The visibility of the element given that of its parent: it is inherited, and children may be seen again.
#[must_use]
pub fn inherited(node: Node<'_, '_>, parent: Visibility) -> Visibility {
    match property(node, "visibility") {
        Some("hidden" | "collapse") => Visibility::Hidden,
        Some("visible") => Visibility::Visible,
        _ => parent,
    }
}

/// Whether a shape is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Visibility {
    /// It is.
    Visible,
    /// It is not.
    Hidden,
}
