//! The modes that G and M words switch.

use super::block::Word;
use super::steps::Signal;
use super::stop::{Stop, malformed, unsupported};
use crate::drawing::{Vec2, Vec3};

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
    /// G6.2, up to the next word of motion.
    KnottedNurbs,
    /// G73, G81 to G83, G85, G86, G89.
    Cycle(Cycle),
    /// After G80 or at the start: coordinates mean nothing.
    None,
}

impl Motion {
    /// As `#<_motion_mode>` counts: ten times the number of the G word.
    pub fn tenths(self) -> f64 {
        match self {
            Self::Rapid => 0.0,
            Self::Line => 10.0,
            Self::Clockwise => 20.0,
            Self::CounterClockwise => 30.0,
            Self::Cubic => 50.0,
            Self::Quadratic => 51.0,
            Self::Nurbs => 52.0,
            Self::KnottedNurbs => 62.0,
            Self::Cycle(Cycle::Peck { out: false }) => 730.0,
            Self::None => 800.0,
            Self::Cycle(Cycle::Drill { rests: false }) => 810.0,
            Self::Cycle(Cycle::Drill { rests: true }) => 820.0,
            Self::Cycle(Cycle::Peck { out: true }) => 830.0,
            Self::Cycle(Cycle::Bore { rests: false, .. }) => 850.0,
            Self::Cycle(Cycle::Bore { feeds_out: false, .. }) => 860.0,
            Self::Cycle(Cycle::Bore { .. }) => 890.0,
        }
    }
}

/// A cycle for holes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cycle {
    /// G81, and G82 with its rest at the bottom.
    Drill { rests: bool },
    /// G83: out of the hole after every peck. G73: back by a little.
    Peck { out: bool },
    /// G85, G86, G89: down, and out at the feed or rapidly.
    Bore { rests: bool, feeds_out: bool },
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

impl Plane {
    /// A place as the plane's two axes, turning from the first to the second counter-clockwise, and the third.
    pub fn split(self, p: Vec3) -> (Vec2, f64) {
        match self {
            Self::Xy => (Vec2::new(p.x, p.y), p.z),
            Self::Zx => (Vec2::new(p.z, p.x), p.y),
            Self::Yz => (Vec2::new(p.y, p.z), p.x),
        }
    }

    /// The place of two axes and the third.
    pub fn join(self, p: Vec2, third: f64) -> Vec3 {
        match self {
            Self::Xy => Vec3::new(p.x, p.y, third),
            Self::Zx => Vec3::new(p.y, third, p.x),
            Self::Yz => Vec3::new(third, p.x, p.y),
        }
    }

    /// The letters of the centre along the two axes, and the one that has no meaning.
    pub fn centre_letters(self) -> (char, char) {
        match self {
            Self::Xy => ('i', 'j'),
            Self::Zx => ('k', 'i'),
            Self::Yz => ('j', 'k'),
        }
    }
}

/// What an F word counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeedMode {
    /// G93: moves of this kind in a minute.
    InverseTime,
    /// G94: units in a minute.
    Minute,
    /// G95: units in a turn of the spindle.
    Turn,
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
    pub feed_mode: FeedMode,
    /// G98: a cycle ends at the height from which it began; G99: at its R.
    pub back_to_start: bool,
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
            feed_mode: FeedMode::Minute,
            back_to_start: true,
            beam_on: false,
            power: None,
        }
    }
}

/// Words of cycles that hold for the next line of the same series.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sticky {
    /// Z and R as they were written.
    pub z: Option<f64>,
    pub r: Option<f64>,
    pub q: Option<f64>,
    pub p: Option<f64>,
    /// The height at which the series began \[mm, machine\].
    pub began: Option<f64>,
}

impl Sticky {
    /// The series is over.
    pub fn forget(&mut self) {
        *self = Self::default();
    }
}

/// What else a G word asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Nothing: a mode was switched, or it does not matter here.
    Nothing,
    /// G4.
    Dwell,
    /// G10.
    SetData,
    /// G28 or G30, from 0: through the place that the line says.
    Home(usize),
    /// G28.1 or G30.1.
    StoreHome(usize),
    /// G52.
    Shift,
    /// G53: this line's coordinates are the machine's.
    MachineCoordinates,
    /// G54 to G59.3, from 0.
    System(usize),
    /// G92, and G92.1 to G92.3.
    ShiftHere,
    ForgetShift,
    PutShiftBy,
    RestoreShift,
    /// G5.3: the NURBS is complete.
    EndNurbs,
    /// Words of this line that are the G word's own and change nothing here: tolerances, numbers of tools.
    Takes(&'static str),
    /// Something that is left out with a warning, with words of its own.
    LeftOut(&'static str, &'static str),
}

/// The group of a G word in tenths: two of one group contradict each other in one line. 0 for those without.
fn group(tenths: i64) -> u8 {
    match tenths {
        0..=39 | 50..=69 | 330..=389 | 730 | 760 | 810..=890 => 1,
        170..=199 => 2,
        900 | 910 => 3,
        901 | 911 => 4,
        930..=950 => 5,
        200 | 210 => 6,
        400..=429 => 7,
        980 | 990 => 10,
        540..=593 => 12,
        100 | 280..=301 | 520 | 920..=923 => 100,
        _ => 0,
    }
}

/// Refuses two words of one group in a line.
pub fn check_groups<'a>(words: impl Iterator<Item = &'a Word>) -> Result<(), Stop> {
    let mut seen: Vec<(u8, f64)> = Vec::new();
    for word in words {
        let group = group(tenths(word));
        if let Some((_, other)) = seen.iter().find(|(known, other)| *known == group && *other != word.value)
            && group > 0
        {
            let what = format!("G{other} and G{} in one line", word.value);
            return malformed(word.byte, what, "each excludes the other: write them in two lines");
        }
        seen.push((group, word.value));
    }
    Ok(())
}

/// A G word in tenths: G5.2 is 52.
pub fn tenths(word: &Word) -> i64 {
    (word.value * 10.0).round() as i64
}

impl Modes {
    /// A G word in tenths.
    pub fn g(&mut self, tenths: i64, byte: usize) -> Result<Request, Stop> {
        let motion = match tenths {
            0 => Some(Motion::Rapid),
            10 => Some(Motion::Line),
            20 => Some(Motion::Clockwise),
            30 => Some(Motion::CounterClockwise),
            50 => Some(Motion::Cubic),
            51 => Some(Motion::Quadratic),
            52 => Some(Motion::Nurbs),
            62 => Some(Motion::KnottedNurbs),
            730 => Some(Motion::Cycle(Cycle::Peck { out: false })),
            800 => Some(Motion::None),
            810 => Some(Motion::Cycle(Cycle::Drill { rests: false })),
            820 => Some(Motion::Cycle(Cycle::Drill { rests: true })),
            830 => Some(Motion::Cycle(Cycle::Peck { out: true })),
            850 => Some(Motion::Cycle(Cycle::Bore { rests: false, feeds_out: true })),
            860 => Some(Motion::Cycle(Cycle::Bore { rests: true, feeds_out: false })),
            890 => Some(Motion::Cycle(Cycle::Bore { rests: true, feeds_out: true })),
            _ => None,
        };
        if let Some(motion) = motion {
            self.motion = motion;
            return Ok(Request::Nothing);
        }
        match tenths {
            53 => return Ok(Request::EndNurbs),
            40 => return Ok(Request::Dwell),
            100 => return Ok(Request::SetData),
            170 => self.plane = Plane::Xy,
            180 => self.plane = Plane::Zx,
            190 => self.plane = Plane::Yz,
            200 => self.mm_per_unit = Some(25.4),
            210 => self.mm_per_unit = Some(1.0),
            900 => self.distance = Distance::Absolute,
            910 => self.distance = Distance::Relative,
            901 => self.centres = Distance::Absolute,
            911 => self.centres = Distance::Relative,
            930 => self.feed_mode = FeedMode::InverseTime,
            940 => self.feed_mode = FeedMode::Minute,
            950 => self.feed_mode = FeedMode::Turn,
            980 => self.back_to_start = true,
            990 => self.back_to_start = false,
            280 => return Ok(Request::Home(0)),
            300 => return Ok(Request::Home(1)),
            281 => return Ok(Request::StoreHome(0)),
            301 => return Ok(Request::StoreHome(1)),
            520 => return Ok(Request::Shift),
            530 => return Ok(Request::MachineCoordinates),
            540 | 550 | 560 | 570 | 580 | 590 => return Ok(Request::System((tenths as usize - 540) / 10)),
            591..=593 => return Ok(Request::System(tenths as usize - 585)),
            920 => return Ok(Request::ShiftHere),
            921 => return Ok(Request::ForgetShift),
            922 => return Ok(Request::PutShiftBy),
            923 => return Ok(Request::RestoreShift),
            // What changes nothing here: radius mode, compensation and turning off, exact paths and speeds of the spindle. The
            // program's Z is that of the tool's tip, as it is with the length compensation of G43.
            80 | 400 | 440 | 490 | 610 | 611 | 690 | 970 => {}
            430 => return Ok(Request::Takes("h")),
            640 => return Ok(Request::Takes("pq")),
            960 => return Ok(Request::Takes("d")),
            410 | 411 | 420 | 421 => {
                return Ok(Request::LeftOut("cutter compensation: the path as programmed is engraved", "dl"));
            }
            431 | 432 => return Ok(Request::LeftOut("a tool's length: Z is that of the tool's tip", "hxyz")),
            _ => return refuse_g(tenths, byte),
        }
        Ok(Request::Nothing)
    }

    /// A whole M word.
    pub fn m(&mut self, number: i64) -> MachineWord {
        match number {
            2 | 30 => MachineWord::End,
            3 | 4 => {
                self.beam_on = true;
                MachineWord::Spindle
            }
            106 => {
                self.beam_on = true;
                MachineWord::Fan
            }
            5 | 107 => {
                self.beam_on = false;
                MachineWord::Fan
            }
            280 => MachineWord::Pen(Signal::Servo),
            300 => MachineWord::Pen(Signal::Tone),
            98 => MachineWord::Call,
            99 => MachineWord::Return,
            0 | 1 | 60 => MachineWord::LeftOut("a pause", ""),
            6 => MachineWord::LeftOut("a tool change: one tool engraves all", ""),
            7..=9 => MachineWord::LeftOut("coolant, of which the arm has none", ""),
            48..=53 => MachineWord::LeftOut("a switch for the operator's speed", "p"),
            _ => MachineWord::LeftOut("an M word of another machine", "pqels"),
        }
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
    /// M3, M4: may say what is a cut, and lift a pen by S.
    Spindle,
    /// M5, and M106 and M107 of lasers that are driven as fans.
    Fan,
    /// M280, M300: may lift a pen.
    Pen(Signal),
    /// M98, M99.
    Call,
    Return,
    /// Something that does not matter here, with words of its own.
    LeftOut(&'static str, &'static str),
}

fn refuse_g(tenths: i64, byte: usize) -> Result<Request, Stop> {
    let name = if tenths % 10 == 0 {
        format!("G{}", tenths / 10)
    } else {
        format!("G{}.{}", tenths / 10, tenths % 10)
    };
    let (what, help) = match tenths {
        60..=63 => {
            ("a NURBS of a dialect that is not read", "export G5.2 or G6.2 splines, or arcs and lines")
        }
        70 => ("a lathe's diameters for X", "a plate is engraved by a mill's program"),
        740 | 840..=849 => ("tapping", "an engraving has no threads; remove it"),
        870 | 880 => ("a boring cycle that needs an operator", "use G81 to G83, G85, G86 or G89"),
        330 | 331 | 760 => ("threading", "an engraving has no threads; remove it"),
        541 => ("one of more than nine coordinate systems", "use G54 to G59.3"),
        500 | 510 | 680 => ("scaling or turning of coordinates", "export the program without it"),
        120 | 130 | 150 | 160 => ("a pocket or polar mode of another dialect", "export it as G1, G2 and G3"),
        650..=670 => ("a call of a macro", "write it by O-words: o<name> sub and o<name> call"),
        380..=389 => ("probing", "remove it: the plate's height is found by the arm itself"),
        _ => (
            "no G word that is known",
            "known are G0 to G5.3 G6.2 G10 G17 to G21 G28 G30 G40 G43 G49 G52 to G59.3 G61 G64 G73 G80 to G86 G89 to G99",
        ),
    };
    unsupported(byte, format!("{name}: {what}"), help)
}
