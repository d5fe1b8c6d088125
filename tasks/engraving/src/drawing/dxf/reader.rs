//! The entities of a drawing on their way to chains of pieces: which are shown, where they lie, what is left out.

use std::collections::{BTreeMap, BTreeSet};

use super::blocks::Blocks;
use super::curves;
use super::entity::Entity;
use super::hidden::HiddenEntities;
use super::layers::{Hidden, Layers};
use super::space::{Lie, Space};
use super::text;
use crate::drawing::hershey::Font;
use crate::drawing::{Budget, Piece, Vec3};
use crate::error::DrawingError;

/// What has been read of a drawing.
pub struct Reader<'a> {
    file: &'a str,
    pub budget: &'a mut Budget,
    /// What hidden entities may cost: they must not use up the budget of those that are engraved.
    hidden_budget: Budget,
    pub layers: Layers,
    pub blocks: Blocks<'a>,
    /// Chains of pieces in the drawing's units.
    pub chains: Vec<Vec<Piece>>,
    hidden: HiddenEntities,
    left_out: BTreeMap<String, usize>,
    /// Entities that are not parallel to the plate.
    inclined: usize,
    upright: BTreeMap<String, usize>,
    texts: usize,
    /// Letters that the font does not have, and how many texts have such.
    missing: BTreeSet<char>,
    texts_with_missing: usize,
    font: Option<Font>,
    warnings: Vec<String>,
}

/// Where an entity stands: in model space, or in a block that is inserted.
#[derive(Clone)]
pub struct Scope<'s> {
    map: Space,
    /// The layer that the entities on layer 0 of a block take.
    layer: Option<&'s str>,
    /// Why nothing of it is shown, and on which layer.
    hidden: Option<(Hidden, &'s str)>,
    depth: usize,
}

impl Scope<'_> {
    /// Model space.
    pub fn model() -> Self {
        Self { map: Space::identity(), layer: None, hidden: None, depth: 0 }
    }
}

/// An entity's chains of pieces as seen from above, and how it lies.
struct Drawn {
    chains: Vec<Vec<Piece>>,
    lie: Lie,
    missing: Vec<char>,
}

/// The most sentences about single entities.
const MOST_WARNINGS: usize = 20;
/// The most letters that a sentence names.
const MOST_LETTERS: usize = 40;
/// Columns or rows of an array of inserts: the file has them as numbers of 16 bits.
const MOST_ROWS: i64 = 32_767;

impl<'a> Reader<'a> {
    /// Nothing yet.
    pub fn new(file: &'a str, budget: &'a mut Budget) -> Self {
        let hidden_budget = Budget::new(*budget.limits());
        Self {
            file,
            budget,
            hidden_budget,
            layers: Layers::default(),
            blocks: Blocks::default(),
            chains: Vec::new(),
            hidden: HiddenEntities::default(),
            left_out: BTreeMap::new(),
            inclined: 0,
            upright: BTreeMap::new(),
            texts: 0,
            missing: BTreeSet::new(),
            texts_with_missing: 0,
            font: None,
            warnings: Vec::new(),
        }
    }

    /// Takes an entity of model space.
    pub fn model_entity(&mut self, entity: &Entity<'_>) -> Result<(), DrawingError> {
        // The blocks lie outside while entities are taken, which may change everything else.
        let blocks = std::mem::take(&mut self.blocks);
        let taken = self.entity(entity, &blocks, &Scope::model());
        self.blocks = blocks;
        taken
    }

    fn entity(
        &mut self,
        entity: &Entity<'_>,
        blocks: &Blocks<'_>,
        scope: &Scope<'_>,
    ) -> Result<(), DrawingError> {
        let in_paper_space = entity.flags(67) == 1;
        if in_paper_space {
            return Ok(());
        }
        let own = entity.layer();
        let layer = scope.layer.filter(|_| own == "0").unwrap_or(own);
        let invisible = (entity.flags(60) == 1).then_some((Hidden::Invisible, layer));
        let of_layer = self.layers.hides(layer).map(|why| (why, layer));
        let hidden = scope.hidden.or(invisible);
        if entity.kind == "INSERT" {
            // A layer that is off or not plotted hides what is on it, not the other layers of a block on it.
            let hidden = hidden.or(of_layer.filter(|(why, _)| *why == Hidden::LayerFrozen));
            return self.insert(
                entity,
                blocks,
                &Scope { layer: Some(layer), hidden, ..scope.clone() },
                scope,
            );
        }
        let is_attribute = matches!(entity.kind, "ATTRIB" | "ATTDEF");
        if entity.kind == "ATTDEF" && scope.depth > 0 && !text::is_constant(entity) {
            // The attributes behind the INSERT stand for it.
            return Ok(());
        }
        let attribute = (is_attribute && entity.flags(70) & 1 == 1).then_some((Hidden::Attribute, layer));
        match hidden.or(of_layer).or(attribute) {
            Some((why, layer)) => {
                self.hide(entity, why, layer, &scope.map);
                Ok(())
            }
            None => self.show(entity, &scope.map),
        }
    }

    fn show(&mut self, entity: &Entity<'_>, map: &Space) -> Result<(), DrawingError> {
        if text::is_text(entity) {
            self.texts += 1;
            // Every letter has its cost before its curves are computed.
            self.budget.take(text::cost(entity), || entity.place(self.file))?;
        }
        let Some(Drawn { chains, lie, missing }) = self.drawn(entity, map)? else {
            *self.left_out.entry(entity.kind.to_owned()).or_insert(0) += 1;
            return Ok(());
        };
        if !missing.is_empty() {
            self.texts_with_missing += 1;
            self.missing.extend(missing);
        }
        match lie {
            Lie::Flat => {}
            Lie::Inclined => self.inclined += 1,
            Lie::Upright => {
                *self.upright.entry(entity.kind.to_owned()).or_insert(0) += 1;
                return Ok(());
            }
        }
        for chain in chains {
            self.budget.take(chain.len().max(1), || entity.place(self.file))?;
            if let Some(bad) = chain.iter().find(|piece| !piece.is_sane()) {
                let what = format!("a coordinate of {}", entity.kind);
                let value = bad.start().amax();
                return Err(DrawingError::OutOfRange { at: entity.place(self.file), what, value });
            }
            self.chains.push(chain);
        }
        Ok(())
    }

    /// Counts an entity that is not shown, with its length; what is wrong with it does not matter.
    fn hide(&mut self, entity: &Entity<'_>, why: Hidden, layer: &str, map: &Space) {
        let cost = text::cost(entity) + entity.tags.len() + entity.parts.len() + 1;
        if self.hidden_budget.take(cost, || entity.place(self.file)).is_err() {
            self.hidden.more = true;
            return;
        }
        let length = match self.drawn(entity, map) {
            Ok(None) => return,
            Ok(Some(drawn)) => {
                drawn.chains.iter().flatten().filter(|piece| piece.is_sane()).map(Piece::length).sum()
            }
            Err(_) => 0.0,
        };
        self.hidden.add(why, layer, length);
    }

    /// What an entity looks like; `None` for a kind that is not engraved.
    fn drawn(&mut self, entity: &Entity<'_>, map: &Space) -> Result<Option<Drawn>, DrawingError> {
        if !text::is_text(entity) {
            let chain = curves::chain(entity, map, self.file)?;
            return Ok(chain.map(|(chain, lie)| Drawn { chains: vec![chain], lie, missing: Vec::new() }));
        }
        let font = match self.font.take() {
            Some(font) => font,
            None => Font::open("futural")?,
        };
        let written = text::written(entity, &font, self.file);
        self.font = Some(font);
        let text::Written { chains, plane, missing } = written?;
        let plane = map.after(&plane);
        let seen = plane.seen();
        let placed = |chain: &Vec<Piece>| chain.iter().map(|piece| piece.transformed(&seen)).collect();
        Ok(Some(Drawn { chains: chains.iter().map(placed).collect(), lie: plane.lie(), missing }))
    }

    /// An INSERT: what is in its block, in the scope `inside` but for its place, and its attributes, which stand in the
    /// scope around it.
    fn insert(
        &mut self,
        entity: &Entity<'_>,
        blocks: &Blocks<'_>,
        inside: &Scope<'_>,
        around: &Scope<'_>,
    ) -> Result<(), DrawingError> {
        let at = || entity.place(self.file);
        let depth = inside.depth + 1;
        self.budget.depth(depth, "blocks", at)?;
        let columns = entity.flags(70).clamp(1, MOST_ROWS);
        let rows = entity.flags(71).clamp(1, MOST_ROWS);
        // An insert costs a piece of the budget itself: empty blocks in blocks would be free otherwise.
        let cost = usize::try_from(1 + columns * rows).unwrap_or(usize::MAX);
        if inside.hidden.is_none() {
            self.budget.take(cost, at)?;
        } else if self.hidden_budget.take(cost, at).is_err() {
            self.hidden.more = true;
            return Ok(());
        }
        let name = entity.text(2).unwrap_or("");
        match blocks.get(name) {
            Some(block) => {
                let object = inside.map.after(&Space::of_object(entity, self.file)?);
                let base = Space::translation(-block.base);
                for row in 0..rows {
                    for column in 0..columns {
                        let placed = insertion(entity, column as f64, row as f64, self.file)?;
                        let map = object.after(&placed).after(&base);
                        let scope = Scope { map, depth, ..inside.clone() };
                        for inner in &block.entities {
                            self.entity(inner, blocks, &scope)?;
                        }
                    }
                }
            }
            None if inside.hidden.is_none() => {
                let what = format!("INSERT of the block {name:?}, which is not in the file, left out");
                self.warn(entity, &what);
            }
            None => {}
        }
        for attribute in &entity.parts {
            self.entity(attribute, blocks, &Scope { hidden: inside.hidden, ..around.clone() })?;
        }
        Ok(())
    }

    fn warn(&mut self, entity: &Entity<'_>, what: &str) {
        if self.warnings.len() < MOST_WARNINGS {
            self.warnings.push(format!("{}: {what}", entity.place(self.file)));
        }
    }

    /// What is to be told, where a unit of the drawing is so many millimetres.
    pub fn told(&mut self, mm_per_unit: f64) -> Vec<String> {
        let mut told = self.hidden.sentences(mm_per_unit);
        for (kind, count) in &self.upright {
            told.push(format!(
                "{count} {kind} left out: upright on the plate, nothing of it is seen from above"
            ));
        }
        if self.inclined > 0 {
            let (entities, are) = if self.inclined == 1 { ("entity", "is") } else { ("entities", "are") };
            told.push(format!(
                "{} {entities} not parallel to the plate: what is seen from above {are} engraved",
                self.inclined
            ));
        }
        if self.texts > 0 {
            let what =
                if self.texts == 1 { "a text is".to_owned() } else { format!("{} texts are", self.texts) };
            told.push(format!(
                "{what} written in a single-stroke font; explode to curves what must keep its own (TXTEXP)"
            ));
        }
        if !self.missing.is_empty() {
            let letters: Vec<String> = self
                .missing
                .iter()
                .take(MOST_LETTERS)
                .map(|c| format!("{c} (U+{:04X})", u32::from(*c)))
                .collect();
            let texts = if self.texts_with_missing == 1 {
                "a text".to_owned()
            } else {
                format!("{} texts", self.texts_with_missing)
            };
            told.push(format!(
                "letters left out of {texts}, which the font does not have: {}; explode such a text to curves (TXTEXP)",
                letters.join(", ")
            ));
        }
        for (kind, count) in &self.left_out {
            told.push(format!(
                "{count} {kind} left out: explode it to lines, arcs and splines to engrave it"
            ));
        }
        told.append(&mut self.warnings);
        told
    }
}

/// Where an INSERT puts its block: the one of a column and a row of its array, in its object coordinates.
fn insertion(entity: &Entity<'_>, column: f64, row: f64, file: &str) -> Result<Space, DrawingError> {
    let number = |code: i32, otherwise: f64| Ok(entity.number(code, file)?.unwrap_or(otherwise));
    let (sin, cos) = number(50, 0.0)?.to_radians().sin_cos();
    let turned = |x: f64, y: f64, z: f64| Vec3::new(x * cos - y * sin, x * sin + y * cos, z);
    let axes = [
        turned(number(41, 1.0)?, 0.0, 0.0),
        turned(0.0, number(42, 1.0)?, 0.0),
        Vec3::new(0.0, 0.0, number(43, 1.0)?),
    ];
    let shift = turned(number(44, 0.0)? * column, number(45, 0.0)? * row, 0.0);
    Ok(Space::new(axes, entity.point_in_space(10, file)? + shift))
}
