//! Parameters: `#1` to `#5602`, `#<name>` local to a subroutine, `#<_name>` global, and those that the machine keeps.

use std::collections::HashMap;

use crate::drawing::Vec3;

/// What a `#` names.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Parameter {
    /// `#n`.
    Numbered(u32),
    /// `#<name>`, in lower case without blanks; global if it begins with `_`.
    Named(String),
}

/// The parameters that a subroutine has for itself: `#1` to `#30`.
const ARGUMENTS: u32 = 30;

/// Parameters that the machine keeps: positions, homes, offsets.
const KEPT: std::ops::RangeInclusive<u32> = 5061..=5430;

/// What the machine tells of itself, in the units of the program.
#[derive(Clone, Copy, Debug, Default)]
pub struct MachineReport {
    /// Coordinates in the active system.
    pub position: Vec3,
    /// Coordinates of the machine.
    pub machine: Vec3,
    /// The shift of G92 and G52.
    pub shift: Vec3,
    /// The origins of G54 to G59.3.
    pub systems: [Vec3; 9],
    /// The active one of them, from 0.
    pub active: usize,
    /// 25.4 with G20, else 1.
    pub mm_per_unit: f64,
    /// Whether G91 holds.
    pub relative: bool,
    /// F and S, 0 if never said.
    pub feed: f64,
    pub speed: f64,
    /// Whether M3 or M4 holds.
    pub spindle_on: bool,
    /// The tool of the latest T.
    pub tool: f64,
    /// The plane, 170 to 190, and the motion, in tenths as `#<_motion_mode>` counts.
    pub plane: f64,
    pub motion: f64,
}

/// The parameters' values: a numbered one that was never set is 0, as on the machine; a named one is an error.
#[derive(Debug, Default)]
pub struct Parameters {
    numbered: HashMap<u32, f64>,
    global: HashMap<String, f64>,
    /// Named ones of the main program and of each subroutine that was called and has not returned.
    local: Vec<HashMap<String, f64>>,
    /// `#1` to `#30` of each caller.
    callers: Vec<Vec<f64>>,
    pub told: MachineReport,
}

impl Parameters {
    /// The value, if it has one.
    pub fn value(&self, parameter: &Parameter) -> Option<f64> {
        match parameter {
            Parameter::Numbered(n) => {
                Some(self.kept(*n).or_else(|| self.numbered.get(n).copied()).unwrap_or(0.0))
            }
            Parameter::Named(name) if name.starts_with('_') => {
                self.global.get(name).copied().or_else(|| self.known(name))
            }
            Parameter::Named(name) => self.local.last().and_then(|local| local.get(name)).copied(),
        }
    }

    /// Whether the program may set it.
    pub fn is_free(parameter: &Parameter) -> bool {
        match parameter {
            Parameter::Numbered(n) => !KEPT.contains(n),
            Parameter::Named(_) => true,
        }
    }

    /// Gives the parameter a value.
    pub fn set(&mut self, parameter: Parameter, value: f64) {
        match parameter {
            Parameter::Numbered(n) => {
                self.numbered.insert(n, value);
            }
            Parameter::Named(name) if name.starts_with('_') => {
                self.global.insert(name, value);
            }
            Parameter::Named(name) => {
                if self.local.is_empty() {
                    self.local.push(HashMap::new());
                }
                if let Some(local) = self.local.last_mut() {
                    local.insert(name, value);
                }
            }
        }
    }

    /// A subroutine is called: its arguments are `#1` and on; the others of the thirty keep the caller's values.
    pub fn enter(&mut self, arguments: &[f64]) {
        if self.local.is_empty() {
            self.local.push(HashMap::new());
        }
        self.callers.push((1..=ARGUMENTS).map(|n| self.numbered.get(&n).copied().unwrap_or(0.0)).collect());
        self.local.push(HashMap::new());
        for (n, value) in (1..=ARGUMENTS).zip(arguments) {
            self.numbered.insert(n, *value);
        }
        self.returned(None);
    }

    /// A subroutine returns, with a value or without: the caller has its thirty back.
    pub fn leave(&mut self, value: Option<f64>) {
        if let Some(caller) = self.callers.pop() {
            self.numbered.extend((1..=ARGUMENTS).zip(caller));
            self.local.pop();
        }
        self.returned(value);
    }

    fn returned(&mut self, value: Option<f64>) {
        self.global.insert("_value".to_owned(), value.unwrap_or(0.0));
        self.global.insert("_value_returned".to_owned(), f64::from(u8::from(value.is_some())));
    }

    /// Numbered parameters that the machine keeps.
    fn kept(&self, n: u32) -> Option<f64> {
        let MachineReport { position, shift, systems, active, .. } = &self.told;
        let axis = |v: &Vec3, n: u32| v.get(n as usize).copied();
        match n {
            5211..=5213 => axis(shift, n - 5211),
            5220 => Some(*active as f64 + 1.0),
            5221..=5390 => {
                let (system, one) = ((n - 5221) / 20, (n - 5221) % 20);
                systems.get(system as usize).and_then(|origin| axis(origin, one))
            }
            5420..=5422 => axis(position, n - 5420),
            _ => None,
        }
    }

    /// Named parameters that the machine keeps.
    fn known(&self, name: &str) -> Option<f64> {
        let told = &self.told;
        let truth = |t: bool| Some(f64::from(u8::from(t)));
        match name {
            "_x" => Some(told.position.x),
            "_y" => Some(told.position.y),
            "_z" => Some(told.position.z),
            "_abs_x" => Some(told.machine.x),
            "_abs_y" => Some(told.machine.y),
            "_abs_z" => Some(told.machine.z),
            "_metric" => truth(told.mm_per_unit == 1.0),
            "_imperial" => truth(told.mm_per_unit != 1.0),
            "_absolute" => truth(!told.relative),
            "_incremental" => truth(told.relative),
            "_feed" => Some(told.feed),
            "_rpm" => Some(told.speed),
            "_spindle_on" => truth(told.spindle_on),
            "_current_tool" | "_selected_tool" => Some(told.tool),
            "_plane" => Some(told.plane),
            "_motion_mode" => Some(told.motion),
            "_coord_system" => {
                Some([540.0, 550.0, 560.0, 570.0, 580.0, 590.0, 591.0, 592.0, 593.0][told.active])
            }
            "_call_level" => Some(self.callers.len() as f64),
            _ => None,
        }
    }
}
