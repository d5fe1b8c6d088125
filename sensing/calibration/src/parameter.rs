//! A parameter: its name and unit, and how far it may be from what is believed of it.

use core::fmt;

/// The unit of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Metres; shown in mm.
    Metre,
    /// Radians; shown in mrad.
    Radian,
    /// Pixels of an image.
    Pixel,
    /// A ratio; shown in parts per million.
    One,
    /// Compliances of joints [rad/(N m)]; shown in µrad/(N m).
    RadianPerNewtonMetre,
}

impl Unit {
    /// The unit in which it is shown, and the factor to it.
    #[must_use]
    pub const fn shown(self) -> (&'static str, f64) {
        match self {
            Unit::Metre => ("mm", 1e3),
            Unit::Radian => ("mrad", 1e3),
            Unit::Pixel => ("px", 1.0),
            Unit::One => ("ppm", 1e6),
            Unit::RadianPerNewtonMetre => ("urad/Nm", 1e6),
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Unit::Metre => "m",
            Unit::Radian => "rad",
            Unit::Pixel => "pixel",
            Unit::One => "1",
            Unit::RadianPerNewtonMetre => "rad/(N m)",
        })
    }
}

/// A parameter of an arm, an instrument or a frame: how far something is from what is believed of it, 0 if nothing is.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name, such as `joint 2 zero`.
    pub name: String,
    /// Its unit.
    pub unit: Unit,
    /// How far it is from 0, as one standard deviation before anything is measured (finite, > 0); `None`: nothing is known.
    pub tolerance: Option<f64>,
    /// Of parameters that cannot be told apart, the one with the lower importance is left at 0.
    pub importance: u8,
}

impl Parameter {
    /// A parameter of which nothing is known.
    #[must_use]
    pub fn new(name: impl Into<String>, unit: Unit) -> Self {
        Self { name: name.into(), unit, tolerance: None, importance: 5 }
    }

    /// The same, 0 to within a standard deviation (finite, > 0).
    #[must_use]
    pub fn within(self, tolerance: f64) -> Self {
        Self { tolerance: Some(tolerance), ..self }
    }

    /// The same with another importance than 5.
    #[must_use]
    pub fn important(self, importance: u8) -> Self {
        Self { importance, ..self }
    }
}
