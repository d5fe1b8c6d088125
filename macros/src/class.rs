//! The classification of section 6 of the paper, as far as a signature shows it.
//!
//! In: the roles of a function's arguments, and its level. Out: whether the paper has such a class, and its name.

use core::fmt;

/// The level at which a motion is generated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// In the coordinator.
    Mp,
    /// In the control process of one robot.
    Ecp,
}

impl Level {
    /// The level as it is written in the attribute.
    pub fn key(self) -> &'static str {
        match self {
            Level::Mp => "mp",
            Level::Ecp => "ecp",
        }
    }
}

/// The role of an argument of a step function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// `&Order<P>`, `c0` of an ECP.
    Order,
    /// `&mut T`, the function's own state.
    State,
    /// `&State<L>`, `e`.
    Robots,
    /// `&Reading<V>`, `v`.
    Sensors,
    /// `Tick`, a part of `c`.
    Tick,
}

impl Role {
    pub const ALL: [Role; 5] = [Role::Order, Role::State, Role::Robots, Role::Sensors, Role::Tick];

    /// The field of `mrroc::generator::Uses`.
    pub fn field(self) -> &'static str {
        match self {
            Role::Order => "order",
            Role::State => "state",
            Role::Robots => "robots",
            Role::Sensors => "sensors",
            Role::Tick => "tick",
        }
    }

    /// What the argument contains, for messages.
    pub fn noun(self) -> &'static str {
        match self {
            Role::Order => "order",
            Role::State => "state of its own",
            Role::Robots => "state of the robots",
            Role::Sensors => "reading of the sensors",
            Role::Tick => "tick",
        }
    }
}

/// Which arguments a function takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Uses(u8);

impl Uses {
    pub fn has(self, role: Role) -> bool {
        self.0 & (1 << role as u8) != 0
    }

    /// Adds an argument; returns false if it is present already.
    pub fn insert(&mut self, role: Role) -> bool {
        let new = !self.has(role);
        self.0 |= 1 << role as u8;
        new
    }

    /// Whether a generator of this level may take these arguments (`mrroc::generator::Class::is_legal`).
    pub fn is_legal(self, level: Level) -> bool {
        let c = self.has(Role::State) || self.has(Role::Tick);
        match level {
            Level::Ecp => true,
            Level::Mp => {
                !self.has(Role::Order) && (c || !(self.has(Role::Robots) || self.has(Role::Sensors)))
            }
        }
    }

    /// The function's name in the paper: `f*2(c0, e)`.
    pub fn in_paper(self, level: Level) -> InPaper {
        InPaper { level, uses: self }
    }
}

/// The name of a transfer function in the paper.
pub struct InPaper {
    level: Level,
    uses: Uses,
}

impl fmt::Display for InPaper {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let has = |role| self.uses.has(role);
        let index = 2 * u8::from(has(Role::Robots)) + u8::from(has(Role::Sensors));
        let e = if has(Role::Robots) { ", e" } else { "" };
        let v = if has(Role::Sensors) { ", v" } else { "" };
        match self.level {
            Level::Mp if self.uses == Uses::default() => f.write_str("f**() = const"),
            Level::Mp => write!(f, "f*{index}(c0{e}{v})"),
            Level::Ecp if has(Role::Order) => write!(f, "f*{}(c0, c{e}{v})", 4 + index),
            Level::Ecp => write!(f, "f*{index}(c{e}{v})"),
        }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Level::Mp => "MP",
            Level::Ecp => "ECP",
        })
    }
}
