//! The classification of section 6 of the paper: which of `c0`, `c_j`, `e`, `v` a transfer function takes.

use core::fmt;

/// Which arguments a step function takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Uses {
    /// `c0`: the coordinator's order (ECP only).
    pub order: bool,
    /// The function's own state: `c0` in an MP, `c_j` in an ECP.
    pub state: bool,
    /// `e`: the states of the robots.
    pub robots: bool,
    /// `v`: the readings of the virtual sensors.
    pub sensors: bool,
    /// The step's index and path time increment, a part of `c`.
    pub tick: bool,
}

impl Uses {
    /// Takes nothing.
    pub const NOTHING: Uses = Uses { order: false, state: false, robots: false, sensors: false, tick: false };

    /// Takes what either of the two takes.
    #[must_use]
    pub const fn and(self, other: Uses) -> Uses {
        Uses {
            order: self.order || other.order,
            state: self.state || other.state,
            robots: self.robots || other.robots,
            sensors: self.sensors || other.sensors,
            tick: self.tick || other.tick,
        }
    }
}

/// Where a motion is generated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// In the coordinator, for any number of robots.
    Mp,
    /// In the effector control process of one robot.
    Ecp,
}

/// The class of a generator or of a condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Class {
    /// The level of its process.
    pub level: Level,
    /// What the first step takes; for a condition the same as `next`.
    pub first: Uses,
    /// What the next steps take.
    pub next: Uses,
    /// What the terminal condition `f_T` takes, when it is a function of its own (`until = ..`).
    pub until: Option<Uses>,
}

impl Class {
    /// The class of a generator whose steps all take the same.
    #[must_use]
    pub const fn new(level: Level, uses: Uses) -> Class {
        Class { level, first: uses, next: uses, until: None }
    }

    /// What the first step and the terminal condition with it take.
    #[must_use]
    pub const fn first_uses(self) -> Uses {
        match self.until {
            Some(until) => self.first.and(until),
            None => self.first,
        }
    }

    /// What a next step and the terminal condition with it take.
    #[must_use]
    pub const fn next_uses(self) -> Uses {
        match self.until {
            Some(until) => self.next.and(until),
            None => self.next,
        }
    }

    /// Whether the paper knows a class for these uses at this level (section 6): all eight in an ECP; in an
    /// MP, feedback without a state of the coordinator has no meaning, and nobody gives it orders.
    #[must_use]
    pub const fn is_legal(level: Level, uses: Uses) -> bool {
        match level {
            Level::Ecp => true,
            Level::Mp => !uses.order && (uses.state || uses.tick || !(uses.robots || uses.sensors)),
        }
    }
}

/// The function's name in the paper: `f*2(c0, e)`.
fn write_function(f: &mut fmt::Formatter<'_>, level: Level, uses: Uses) -> fmt::Result {
    let index = 2 * usize::from(uses.robots) + usize::from(uses.sensors);
    let e = if uses.robots { ", e" } else { "" };
    let v = if uses.sensors { ", v" } else { "" };
    match level {
        Level::Mp if !(uses.state || uses.tick || uses.robots || uses.sensors) => {
            f.write_str("f**() = const")
        }
        Level::Mp => write!(f, "f*{index}(c0{e}{v})"),
        Level::Ecp if uses.order => write!(f, "f*{}(c0, c{e}{v})", 4 + index),
        Level::Ecp => write!(f, "f*{index}(c{e}{v})"),
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.level {
            Level::Mp => "MP ",
            Level::Ecp => "ECP ",
        })?;
        write_function(f, self.level, self.next)?;
        if self.first != self.next {
            f.write_str(", first step ")?;
            write_function(f, self.level, self.first)?;
        }
        if let Some(until) = self.until {
            f.write_str(", until ")?;
            write_function(f, self.level, until)?;
        }
        Ok(())
    }
}
