//! How much a document is once each `use` stands for what it uses: usvg builds all of that, so it is counted before.

use super::cascade::attribute;
use super::source::Source;
use crate::drawing::Budget;
use crate::error::DrawingError;
use roxmltree::{Node, NodeId};
use std::collections::HashMap;

/// Most elements that usvg is to build: with all that is known of each it takes some 2 kB.
const MOST_ELEMENTS: usize = 100_000;
/// Most elements that are used.
const MOST_USES: usize = 100_000;
/// Most attributes that usvg compares while it looks for inherited properties: those of all elements round each element.
const MOST_COMPARED: usize = 10_000_000;

const XLINK: &str = "http://www.w3.org/1999/xlink";

/// Elements by their ids.
pub type Ids<'a> = HashMap<&'a str, Node<'a, 'a>>;

/// The elements of a document by their ids; of two with the same id the first.
pub fn ids<'a>(source: &Source<'a>) -> Ids<'a> {
    let mut ids = HashMap::new();
    for node in source.document.descendants() {
        if let Some(id) = node.attribute("id") {
            ids.entry(id).or_insert(node);
        }
    }
    ids
}

/// What a `use` refers to.
pub fn href<'a>(node: Node<'a, '_>) -> &'a str {
    attribute(node, "href").or_else(|| node.attribute((XLINK, "href"))).unwrap_or("")
}

/// What a `use` uses; `None` where that is not in the file.
pub fn used<'a>(node: Node<'a, 'a>, ids: &Ids<'a>) -> Option<Node<'a, 'a>> {
    href(node).trim().strip_prefix('#').and_then(|id| ids.get(id)).copied()
}

/// What an element and all in it come to.
#[derive(Clone, Copy, Default)]
struct Size {
    elements: usize,
    uses: usize,
    /// Levels of elements.
    height: usize,
    /// Most attributes on a path from the element down to the end.
    attributes: usize,
}

/// How many uses there are. Refuses a document that is too much.
///
/// # Errors
/// [`DrawingError::TooDeep`], also for a `use` of itself; [`DrawingError::TooManyPieces`].
pub fn check<'a>(source: &Source<'a>, ids: &Ids<'a>, budget: &Budget) -> Result<usize, DrawingError> {
    let root = source.document.root_element();
    let mut known = HashMap::new();
    let all = Count { source, ids, budget }.of(root, 0, &mut known)?;
    let too_many = |limit| Err(DrawingError::TooManyPieces { at: source.place(root), limit });
    if all.uses > MOST_USES {
        return too_many(MOST_USES);
    }
    if all.elements > MOST_ELEMENTS {
        let what = "elements, those that are used counted each time";
        return Err(DrawingError::TooMany { at: source.place(root), what, limit: MOST_ELEMENTS });
    }
    if all.elements.saturating_mul(all.attributes) > MOST_COMPARED {
        let what = "attributes round its elements, counted for each element";
        return Err(DrawingError::TooMany { at: source.place(root), what, limit: MOST_COMPARED });
    }
    Ok(all.uses)
}

struct Count<'b, 'a> {
    source: &'b Source<'a>,
    ids: &'b Ids<'a>,
    budget: &'b Budget,
}

impl<'a> Count<'_, 'a> {
    fn of(
        &self,
        node: Node<'a, 'a>,
        depth: usize,
        known: &mut HashMap<NodeId, Size>,
    ) -> Result<Size, DrawingError> {
        if let Some(size) = known.get(&node.id()) {
            self.budget.depth(depth + size.height, "elements", || self.source.place(node))?;
            return Ok(*size);
        }
        self.budget.depth(depth, "elements", || self.source.place(node))?;
        let mut sum = Size { elements: 1, ..Size::default() };
        let is_use = super::source::name_of(node) == "use";
        let used = is_use.then(|| used(node, self.ids)).flatten();
        for inner in node.children().filter(Node::is_element).chain(used) {
            let inner = self.of(inner, depth + 1, known)?;
            sum.elements = sum.elements.saturating_add(inner.elements);
            sum.uses = sum.uses.saturating_add(inner.uses);
            sum.height = sum.height.max(inner.height + 1);
            sum.attributes = sum.attributes.max(inner.attributes);
        }
        sum.uses = sum.uses.saturating_add(usize::from(used.is_some()));
        sum.attributes += node.attributes().len();
        known.insert(node.id(), sum);
        Ok(sum)
    }
}
