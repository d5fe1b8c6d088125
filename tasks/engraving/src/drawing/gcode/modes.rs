//! The modes that G and M words switch.

use super::{Stop, unsupported};

/// The motion that coordinates without a G word mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// G0.
    Rapid,
    /// G1.
    Line,
    /// G2.
    Clockwise,
    /// G3.
    CounterClockwise,
    /// G5.
    Cubic,
    /// G5.1.
    Quadratic,
    /// Between G5.2 and G5.3.
    Nurbs,
    /// After G80 or at the start: coordinates mean nothing.
    None,
}

/// Absolute or relative coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distance {
    /// G90, G90.1.
    Absolute,
    /// G91, G91.1.
    Relative,
}

/// The plane of arcs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    /// G17.
    Xy,
    /// G18.
    Zx,
    /// G19.
    Yz,
}

/// All modes.
#[derive(Clone, Debug)]
pub struct Modes {
    pub motion: Motion,
    pub distance: Distance,
    pub centres: Distance,
    pub plane: Plane,
    /// 1 or 25.4; `None` until G20 or G21.
    pub mm_per_unit: Option<f64>,
    pub beam_on: bool,
    pub power: Option<f64>,
}

impl Default for Modes {
    fn default() -> Self {
        Self {
            motion: Motion::None,
            distance: Distance::Absolute,
            centres: Distance::Relative,
            plane: Plane::Xy,
            mm_per_unit: None,
            beam_on: false,
            power: None,
        }
    }
}

/// What else a G word asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Nothing: a mode was switched, or it does not matter here.
    Nothing,
    /// The words of this line are no motion (G4, G10, G28, G92.1).
    NoMotion,
    /// G28 or G30: away to a place that the program does not say.
    Home,
    /// G5.3: the NURBS is complete.
    EndNurbs,
    /// Something that is left out with a warning.
    LeftOut(&'static str),
}

impl Modes {
    /// A G word in tenths: G5.2 is 52.
    pub fn g(&mut self, tenths: i64, byte: usize) -> Result<Request, Stop> {
        let motion = match tenths {
            0 => Some(Motion::Rapid),
            10 => Some(Motion::Line),
            20 => Some(Motion::Clockwise),
            30 => Some(Motion::CounterClockwise),
            50 => Some(Motion::Cubic),
            51 => Some(Motion::Quadratic),
            52 => Some(Motion::Nurbs),
            800 => Some(Motion::None),
            _ => None,
        };
        if let Some(motion) = motion {
            self.motion = motion;
            return Ok(Request::Nothing);
        }
        match tenths {
            53 => return Ok(Request::EndNurbs),
            40 => return Ok(Request::NoMotion),
            170 => self.plane = Plane::Xy,
            180 => self.plane = Plane::Zx,
            190 => self.plane = Plane::Yz,
            200 => self.mm_per_unit = Some(25.4),
            210 => self.mm_per_unit = Some(1.0),
            900 => self.distance = Distance::Absolute,
            910 => self.distance = Distance::Relative,
            901 => self.centres = Distance::Absolute,
            911 => self.centres = Distance::Relative,
            280 | 300 => return Ok(Request::Home),
            281 | 301 | 921 | 922 | 923 => return Ok(Request::NoMotion),
            // Modes that change nothing in the plane: compensation off, offsets of the plate, path control, feed modes.
            70 | 80 | 400 | 430 | 431 | 440 | 490 | 540 | 610 | 611 | 640 | 930 | 940 | 950 | 960 | 970
            | 980 | 990 => {}
            410 | 411 | 420 | 421 => {
                return Ok(Request::LeftOut("cutter compensation: the path as programmed is engraved"));
            }
            550..=593 => {
                return Ok(Request::LeftOut("a work offset: the placement on the plate decides"));
            }
            _ => return refuse_g(tenths, byte),
        }
        Ok(Request::Nothing)
    }

    /// A whole M word: whether the program ends, or what is left out.
    pub fn m(&mut self, number: i64, byte: usize) -> Result<Option<MachineWord>, Stop> {
        match number {
            2 | 30 => return Ok(Some(MachineWord::End)),
            3 | 4 | 106 => self.beam_on = true,
            5 | 107 => self.beam_on = false,
            98 | 99 => {
                return unsupported(
                    byte,
                    format!("M{number}: a subprogram"),
                    "write the program out without subprograms",
                );
            }
            0 | 1 | 60 => return Ok(Some(MachineWord::LeftOut("a pause"))),
            6 => return Ok(Some(MachineWord::LeftOut("a tool change: one tool engraves all"))),
            7..=9 | 48..=53 => {}
            _ => return Ok(Some(MachineWord::LeftOut("an M word of another machine"))),
        }
        Ok(None)
    }

    /// Whether a laser or spindle is on.
    pub fn is_on(&self) -> bool {
        self.beam_on && self.power != Some(0.0)
    }
}

/// What an M word asks for beyond modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MachineWord {
    /// M2, M30.
    End,
    /// Something that does not matter here.
    LeftOut(&'static str),
}

fn refuse_g(tenths: i64, byte: usize) -> Result<Request, Stop> {
    let name = if tenths % 10 == 0 {
        format!("G{}", tenths / 10)
    } else {
        format!("G{}.{}", tenths / 10, tenths % 10)
    };
    let (what, help) = match tenths {
        60..=63 => ("a NURBS of another dialect", "export G5.2 splines, or arcs and lines"),
        730 | 810..=899 => ("a drilling cycle", "export the drilling as G0 and G1 moves, or leave it out"),
        330 | 331 | 760 => ("threading", "an engraving has no threads; remove it"),
        100 | 520 | 530 | 920 => ("a shift of coordinates", "export the program in one coordinate system"),
        500 | 510 | 680 | 690 => ("scaling or turning of coordinates", "export the program without it"),
        380..=389 => ("probing", "remove it: the plate's height is found by the arm itself"),
        _ => ("no G word that is known", "known are G0 G1 G2 G3 G5 G5.1 G5.2 G5.3 G17 to G21 G90 G91"),
    };
    unsupported(byte, format!("{name}: {what}"), help)
}
