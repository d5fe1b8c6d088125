//! The arm's program: finds the plate, engraves stroke by stroke, parks.

use mrroc::observe::Shown;
use mrroc::prelude::*;
use mrroc_generators::bspline::{Junction, Method, SplinePoint, SplineSettings};
use mrroc_generators::feed::FeedLimits;
use mrroc_generators::generators::{GuardedApproach, JointMove, Sleep, SplineTrack, StraightLine};
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_robots::{Irp6, Six};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::drawing::{Drawing, Manner, Stroke, Vec2};
use crate::mp::Phase;
use crate::probe::{Open, Touch, TouchProbe};
use crate::sampling::{Mark, Sample, Sampling};

/// What the arm is doing, for those who look on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Activity {
    /// Ordinal of the stroke that is being engraved, from 1; 0: none.
    ordinal: u64,
    /// Whether the plate has been found, and at which height [m, world].
    found: bool,
    height: f64,
}

impl Activity {
    /// The stroke that is being engraved, from 0.
    #[must_use]
    pub fn stroke(&self) -> Option<usize> {
        usize::try_from(self.ordinal.checked_sub(1)?).ok()
    }

    /// Height at which the plate was found [m, world].
    #[must_use]
    pub fn plate_height(&self) -> Option<f64> {
        self.found.then_some(self.height)
    }
}

/// Everything that the arm must know.
pub struct Job {
    /// The strokes, placed on the plate and [sunk](Drawing::sunk) into it \[mm\].
    pub drawing: Drawing,
    /// How the strokes become points.
    pub sampling: Sampling,
    /// Where the plate lies, as far as it is known: its lower left corner, x to the right, y up [m, world].
    pub plate: Pose,
    /// The middle of the plate, where the probe goes down \[mm\].
    pub middle: Vec2,
    /// The orientation of the tool on the plate.
    pub orientation: UnitQuaternion<f64>,
    /// Feed along the strokes that have none of their own [m/s], > 0.
    pub feed: f64,
    /// The step \[s\].
    pub step: f64,
    /// Where the arm parks \[rad\].
    pub park: Six,
    /// What the arm is doing.
    pub activity: Shown<Activity>,
}

/// Height above the plate at which the tool travels, unless a stroke's file asks for more \[m\].
pub const TRAVEL_HEIGHT: f64 = 0.002;
/// The greatest height at which the tool travels, whatever a file asks for \[m\].
pub const HIGHEST_TRAVEL: f64 = 0.020;
/// A stroke that goes on from the one before it begins so near to its end \[mm\].
const GOES_ON: f64 = 1e-4;
/// Height above the expected plate from which the probe goes down \[m\].
pub const PROBE_HEIGHT: f64 = 0.010;
/// How far below the expected height the probe looks for the plate \[m\].
pub const PROBE_DEPTH: f64 = 0.010;
/// Acceleration along and across a stroke [m/s²].
const STROKE_ACCELERATION: f64 = 0.25;
/// The feed may leave a chord of a step this far from the curve \[m\].
const CHORD_ERROR: f64 = 1e-6;

/// Limits of a straight motion of the tool [m/s, m/s²].
fn straight(velocity: f64, acceleration: f64) -> ToolLimits {
    ToolLimits {
        translation: ProfileLimits { velocity, acceleration },
        rotation: ProfileLimits { velocity: 0.5, acceleration: 2.0 },
    }
}

impl Job {
    /// The tool's pose over a place of the plate \[mm\], `height` above its surface \[m\].
    #[must_use]
    pub fn over(&self, place: Vec2, height: f64) -> Pose {
        let position = Translation3::new(place.x * 1e-3, place.y * 1e-3, height);
        self.plate * Pose::from_parts(position, self.orientation)
    }

    /// The program of the ECP.
    ///
    /// # Errors
    /// The fault that ended it.
    pub fn run(&mut self, ecp: &mut Ecp<Irp6>) -> Result<(), Fault> {
        ecp.serve_all(|ecp, phase: Phase| match phase {
            Phase::FindPlate => self.find_plate(ecp),
            Phase::Engrave => self.engrave(ecp),
            Phase::Park => self.go_and_park(ecp),
        })
    }

    /// Goes down twice, fast and slowly; where the probe first touched is the height of the plate from then on.
    fn find_plate(&mut self, ecp: &mut Ecp<Irp6>) -> Result<(), Fault> {
        let mut probe = ecp.sensor::<TouchProbe>("probe")?;
        ecp.move_robot((), StraightLine::to(self.over(self.middle, PROBE_HEIGHT), straight(0.1, 0.5)))?;
        ecp.wait_at_most((&mut probe,), Open::for_steps(50), 500)?;
        for (speed, back) in [(0.010, 0.001), (0.001, TRAVEL_HEIGHT)] {
            let down = -Vector3::z_axis();
            let distance = PROBE_HEIGHT + PROBE_DEPTH;
            let touch = GuardedApproach::along(down, speed, 0.2, distance, |touch: &Touch| touch.contact);
            ecp.move_robot((&mut probe,), touch)?;
            // The tool's z points down, into the plate.
            ecp.move_robot((), StraightLine::by(Pose::translation(0.0, 0.0, -back), straight(0.02, 0.2)))?;
        }
        let touch = probe.reading().filter(|touch| touch.contact);
        let height =
            touch.ok_or_else(|| Fault::thrown("the probe lost the plate while it touched it"))?.height;
        self.plate.translation.z = height;
        self.activity.set(Activity { found: true, height, ..self.activity.get() });
        Ok(())
    }

    fn engrave(&self, ecp: &mut Ecp<Irp6>) -> Result<(), Fault> {
        let spline =
            SplineSettings { method: Method::C2, corner: std::f64::consts::PI, ..SplineSettings::default() };
        let feed = FeedLimits {
            feed: self.feed,
            tangential: STROKE_ACCELERATION,
            normal: STROKE_ACCELERATION,
            step: self.step,
            chord_error: CHORD_ERROR,
            jerk: f64::INFINITY,
        };
        let strokes = &self.drawing.strokes;
        for (index, stroke) in strokes.iter().enumerate() {
            match index.checked_sub(1).map(|before| &strokes[before]).filter(|last| goes_on(last, stroke)) {
                None => self.approach(ecp, stroke)?,
                Some(last) if (stroke.tip(0.0) - last.end_tip()).norm() > GOES_ON => {
                    let start = self.over(stroke.start(), stroke.tip(0.0).z * 1e-3);
                    ecp.move_robot((), StraightLine::to(start, straight(0.005, 0.2)))?;
                }
                Some(_) => {}
            }
            let points: Vec<_> = self.sampling.stroke(stroke, index).iter().map(point).collect();
            let feed =
                FeedLimits { feed: stroke.manner().feed.map_or(feed.feed, |feed| feed * 1e-3), ..feed };
            let track = SplineTrack::through(points, spline, feed, self.plate, self.orientation);
            let track = track.map_err(|error| Fault::thrown(&error.to_string()))?;
            self.activity.set(Activity { ordinal: index as u64 + 1, ..self.activity.get() });
            ecp.move_robot((), track)?;
            self.activity.set(Activity { ordinal: 0, ..self.activity.get() });
            if stroke.manner().dwell > 0.0 {
                ecp.move_robot((), Sleep::lasting(stroke.manner().dwell))?;
            }
            if strokes.get(index + 1).is_none_or(|next| !goes_on(stroke, next)) {
                let above = self.over(stroke.end(), TRAVEL_HEIGHT);
                ecp.move_robot((), StraightLine::to(above, straight(0.02, 0.2)))?;
            }
        }
        Ok(())
    }

    /// Goes to the start of a stroke from wherever the tool travels: slowly on the last piece, into the material.
    fn approach(&self, ecp: &mut Ecp<Irp6>, stroke: &Stroke) -> Result<(), Fault> {
        let height = travel_height(stroke.manner());
        if height > TRAVEL_HEIGHT {
            let up = Pose::translation(0.0, 0.0, TRAVEL_HEIGHT - height);
            ecp.move_robot((), StraightLine::by(up, straight(0.1, 1.0)))?;
            ecp.move_robot((), StraightLine::to(self.over(stroke.start(), height), straight(0.1, 1.0)))?;
        }
        ecp.move_robot((), StraightLine::to(self.over(stroke.start(), TRAVEL_HEIGHT), straight(0.1, 1.0)))?;
        let start = self.over(stroke.start(), stroke.tip(0.0).z * 1e-3);
        ecp.move_robot((), StraightLine::to(start, straight(0.005, 0.2)))?;
        Ok(())
    }

    fn go_and_park(&self, ecp: &mut Ecp<Irp6>) -> Result<(), Fault> {
        let up = Pose::translation(0.0, 0.0, -0.05);
        ecp.move_robot((), StraightLine::by(up, straight(0.1, 0.5)))?;
        ecp.move_robot((), JointMove::to(self.park, Six::repeat(0.3), Six::repeat(1.5)))?;
        Ok(())
    }
}

/// Whether the tool goes on from one stroke to the next without lifting out of the plate.
#[must_use]
pub fn goes_on(stroke: &Stroke, next: &Stroke) -> bool {
    next.manner().goes_on && (next.start() - stroke.end()).norm() < GOES_ON
}

/// The height at which the tool travels to a stroke \[m\].
#[must_use]
pub fn travel_height(manner: &Manner) -> f64 {
    manner.approach.map_or(TRAVEL_HEIGHT, |mm| (mm * 1e-3).clamp(TRAVEL_HEIGHT, HIGHEST_TRAVEL))
}

/// A sample in the plate's frame \[m\].
fn point(sample: &Sample) -> SplinePoint {
    SplinePoint {
        position: sample.position * 1e-3,
        junction: if sample.mark == Mark::Corner { Junction::Corner } else { Junction::Smooth },
        ..SplinePoint::default()
    }
}
