//! Layers: which of them are shown, from the LAYER table.

use std::collections::HashMap;

use super::entity;
use super::tags::Tags;
use crate::error::DrawingError;

/// Why an entity is not shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Hidden {
    /// Its layer is off: a negative colour.
    LayerOff,
    /// Its layer is frozen.
    LayerFrozen,
    /// Its layer is shown on the screen and not plotted.
    LayerNotPlotted,
    /// The entity itself is invisible, group 60.
    Invisible,
    /// An attribute with the flag "invisible".
    Attribute,
}

/// Layers that are not shown, by name without regard to case.
#[derive(Clone, Debug, Default)]
pub struct Layers {
    hidden: HashMap<String, Hidden>,
}

impl Layers {
    /// Reads the section TABLES up to its ENDSEC.
    pub fn read(tags: &mut Tags<'_>) -> Result<Self, DrawingError> {
        let mut hidden = HashMap::new();
        entity::each(tags, "ENDSEC", |entry| {
            if entry.kind != "LAYER" {
                return Ok(());
            }
            let why = if entry.flags(70) & 1 == 1 {
                Some(Hidden::LayerFrozen)
            } else if entry.flags(62) < 0 {
                Some(Hidden::LayerOff)
            } else if entry.text(290) == Some("0") {
                Some(Hidden::LayerNotPlotted)
            } else {
                None
            };
            if let (Some(why), Some(name)) = (why, entry.text(2)) {
                hidden.insert(name.to_uppercase(), why);
            }
            Ok(())
        })?;
        Ok(Self { hidden })
    }

    /// Why what is on the layer is not shown; `None` where it is, and for a layer that the table does not have.
    pub fn hides(&self, layer: &str) -> Option<Hidden> {
        if self.hidden.is_empty() && !layer.eq_ignore_ascii_case("Defpoints") {
            return None;
        }
        let name = layer.to_uppercase();
        // CAD programs never plot the layer of definition points, whatever the table says.
        let never = (name == "DEFPOINTS").then_some(Hidden::LayerNotPlotted);
        self.hidden.get(&name).copied().or(never)
    }
}
