//! What is not engraved, counted, and told in sentences at the end.

use std::collections::{BTreeMap, BTreeSet};

use super::layers::Hidden;

/// Entities that are hidden for one reason.
#[derive(Debug, Default)]
struct Count {
    layers: BTreeSet<String>,
    entities: usize,
    /// In the drawing's units.
    length: f64,
}

/// Hidden entities by reason.
#[derive(Debug, Default)]
pub struct HiddenEntities {
    counts: BTreeMap<Hidden, Count>,
    /// There are more than were counted.
    pub more: bool,
}

/// The most names of layers in a sentence.
const MOST_NAMES: usize = 6;

impl HiddenEntities {
    /// One more, on this layer and of this length in the drawing's units.
    pub fn add(&mut self, why: Hidden, layer: &str, length: f64) {
        let count = self.counts.entry(why).or_default();
        count.entities += 1;
        count.length += length;
        if count.layers.len() <= MOST_NAMES && !count.layers.contains(layer) {
            count.layers.insert(layer.to_owned());
        }
    }

    /// A sentence for each reason; a unit of the drawing is so many millimetres.
    pub fn sentences(&self, mm_per_unit: f64) -> Vec<String> {
        if self.more && self.counts.is_empty() {
            return vec![
                "more entities than are counted are hidden by the drawing, left out: show their layers to engrave them"
                    .to_owned(),
            ];
        }
        let at_least = if self.more { "at least " } else { "" };
        self.counts
            .iter()
            .map(|(why, Count { layers, entities, length })| {
                let mut names: Vec<&str> = layers.iter().take(MOST_NAMES).map(String::as_str).collect();
                if layers.len() > MOST_NAMES {
                    names.push("..");
                }
                let (on, which) =
                    if layers.len() == 1 { ("the layer", "which is") } else { ("the layers", "which are") };
                let on = format!("on {on} {}, {which}", names.join(", "));
                let (entity, them) = if *entities == 1 { ("entity", "it") } else { ("entities", "them") };
                let length = length * mm_per_unit;
                let start = format!("{at_least}{entities} {entity}, {length:.1} mm long,");
                match why {
                    Hidden::LayerOff => {
                        format!("{start} {on} off, left out: turn the layer on to engrave {them}")
                    }
                    Hidden::LayerFrozen => {
                        format!("{start} {on} frozen, left out: thaw the layer to engrave {them}")
                    }
                    Hidden::LayerNotPlotted => {
                        format!("{start} {on} not plotted, left out: let the layer be plotted to engrave {them}")
                    }
                    Hidden::Invisible => {
                        format!("{start} invisible (group 60), left out: show {them} to engrave {them}")
                    }
                    Hidden::Attribute => {
                        format!("{start} attributes of blocks that are invisible, left out: show {them} to engrave {them}")
                    }
                }
            })
            .collect()
    }
}
