//! What a cell calls by names beside its robots and sensors: signals of a robot, frames, tools.
//!
//! In: names of a program. Out: what they name, or a fault that says what there is.

use crate::model::fault::{Fault, FaultKind};
use crate::model::load::Tool;
use crate::model::pose::Pose;
use crate::model::signals::{Channel, Input, Level, Output, Value};
use crate::suggestion::suggestion;

/// The names of a robot's inputs and outputs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SignalNames {
    pub inputs: Vec<(String, Channel)>,
    pub outputs: Vec<(String, Channel)>,
    /// What those of them are at a stop that drive tools.
    pub tools: Vec<(String, Value)>,
}

impl SignalNames {
    /// The input of this name.
    ///
    /// # Errors
    /// `Config`: there is none, or it is of the other type.
    pub fn input<T: Level>(&self, robot: &str, name: &str) -> Result<Input<T>, Fault> {
        Input::of(find(&self.inputs, "input", robot, name)?)
            .ok_or_else(|| of_other_type::<T>("input", robot, name))
    }

    /// The output of this name.
    ///
    /// # Errors
    /// As of [`input`](Self::input).
    pub fn output<T: Level>(&self, robot: &str, name: &str) -> Result<Output<T>, Fault> {
        let channel = find(&self.outputs, "output", robot, name)?;
        Output::of(channel).ok_or_else(|| of_other_type::<T>("output", robot, name))
    }
}

fn find(known: &[(String, Channel)], what: &str, robot: &str, name: &str) -> Result<Channel, Fault> {
    if let Some((_, channel)) = known.iter().find(|(known, _)| known == name) {
        return Ok(*channel);
    }
    let names: Vec<_> = known.iter().map(|(name, _)| name).collect();
    let there = match names.is_empty() {
        true => format!("write it into [robots.{robot}.{what}s] of cell.toml, {name} = \"digital 0\""),
        false => suggestion(name, &names, "it has"),
    };
    Err(Fault::new(FaultKind::Config).text(&format!("robot `{robot}` has no {what} `{name}`: {there}")))
}

fn of_other_type<T: Level>(what: &str, robot: &str, name: &str) -> Fault {
    let (other, value) = if T::NAME == "digital" { ("analog", "f64") } else { ("digital", "bool") };
    let text = format!(
        "the {what} `{name}` of robot `{robot}` is {other}: ask for it by `{what}::<{value}>(\"{name}\")`"
    );
    Fault::new(FaultKind::Config).text(&text)
}

/// The frames and tools that a cell names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellNames {
    pub frames: Vec<(String, Pose)>,
    pub tools: Vec<(String, Tool)>,
}

impl CellNames {
    /// The frame of this name, in the world.
    ///
    /// # Errors
    /// `Config`: there is none.
    pub fn frame(&self, name: &str) -> Result<Pose, Fault> {
        named(&self.frames, "frame", name)
    }

    /// The tool of this name.
    ///
    /// # Errors
    /// `Config`: there is none.
    pub fn tool(&self, name: &str) -> Result<Tool, Fault> {
        named(&self.tools, "tool", name)
    }
}

fn named<T: Copy>(known: &[(String, T)], what: &str, name: &str) -> Result<T, Fault> {
    if let Some((_, found)) = known.iter().find(|(known, _)| known == name) {
        return Ok(*found);
    }
    let names: Vec<_> = known.iter().map(|(name, _)| name).collect();
    let there = match names.is_empty() {
        true => format!("write a table [{what}s.{name}] into cell.toml"),
        false => suggestion(name, &names, "the cell has"),
    };
    Err(Fault::new(FaultKind::Config).text(&format!("there is no {what} `{name}`: {there}")))
}
