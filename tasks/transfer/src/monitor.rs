//! What a run shows: how far the tools leave their relative pose, and how hard they press on the body.
//!
//! In: what the robots' EDPs report and the true state of the simulated world. Out: peaks, and samples for pictures.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::observe::Observation;
use mrroc::prelude::*;
use mrroc::robot::RobotView;
use mrroc_robots::grasp::Hand;

use crate::clear::EVERY;
use crate::places::{CLOSED, End, grasp};
use crate::plant::Plant;

/// How far a pose is from where it should be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Apart {
    /// \[m\].
    pub distance: f64,
    /// \[rad\].
    pub angle: f64,
}

impl Apart {
    /// The relative pose `X_E1E2` of two tools, from the one that the grasps have.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn of(X_WE: &[Pose; 2]) -> Apart {
        Apart::between(&grasp(End::Near).inv_mul(&grasp(End::Far)), &X_WE[0].inv_mul(&X_WE[1]))
    }

    /// One pose from another.
    fn between(nominal: &Pose, pose: &Pose) -> Apart {
        let error = nominal.inv_mul(pose);
        Apart { distance: error.translation.vector.norm(), angle: error.rotation.scaled_axis().norm() }
    }

    /// The larger of each.
    #[must_use]
    pub fn max(self, other: Apart) -> Apart {
        Apart { distance: self.distance.max(other.distance), angle: self.angle.max(other.angle) }
    }
}

/// The state of a run at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// \[s\].
    pub time: f64,
    /// Relative pose error of the tools as the encoders say; none while a hand is open.
    pub measured: Apart,
    /// By how much the true tools have left the relative pose in which their hands closed: what strains the body.
    pub strain: Apart,
    /// The internal force \[N\].
    pub internal: f64,
}

/// What was seen of a run.
#[derive(Debug, Default)]
pub struct RunMeasurements {
    /// The largest relative pose error of the demands while the body was carried.
    pub demanded: Apart,
    /// The largest of each quantity of the samples, over all servo periods.
    pub measured: Apart,
    /// See [`Sample::strain`].
    pub strain: Apart,
    /// See [`Sample::internal`].
    pub internal: f64,
    /// A sample every 10 ms.
    pub samples: Vec<Sample>,
    /// Servo periods in which the hands were told to be closed.
    pub carried: u64,
    /// Those of them in which a hand did not truly hold the body; 0 where there is no body.
    pub loose: u64,
    held: bool,
    rnt: Option<Pose>,
    /// The true relative pose in which the hands closed.
    closed: Option<Pose>,
    periods: u64,
}

/// Watches a cell.
#[derive(Clone, Debug, Default)]
pub struct CellMonitor(Rc<RefCell<RunMeasurements>>);

impl CellMonitor {
    /// One that has seen nothing yet.
    #[must_use]
    pub fn new() -> CellMonitor {
        CellMonitor::default()
    }

    /// What it has seen.
    #[must_use]
    pub fn into_seen(self) -> RunMeasurements {
        self.0.take()
    }

    /// Looks at a cell, and into the world of its plant if there is one; the guard `clear` looks on, as often as before.
    #[must_use]
    pub fn watch(
        &self,
        cell: Cell,
        plant: Option<&Plant>,
        mut clear: impl FnMut(&[RobotView]) -> Result<(), Fault> + 'static,
    ) -> Cell {
        let demands = Rc::clone(&self.0);
        let encoders = Rc::clone(&self.0);
        let hands = plant.and_then(|plant| Some([plant.hand_of("rnt")?, plant.hand_of("polycrank")?]));
        let mut looks = 0_u32;
        // A cell has one guard: this one takes the place of its own.
        cell.guard(1, move |robots| {
            demands.borrow_mut().see_demands(robots);
            looks += 1;
            if looks.is_multiple_of(EVERY) { clear(robots) } else { Ok(()) }
        })
        .watch(move |robot| encoders.borrow_mut().see_period(robot, hands.as_ref()))
    }
}

impl RunMeasurements {
    /// Whether the hands closed, and held the body, if there is one, for as long as they were told to.
    #[must_use]
    pub const fn is_held(&self) -> bool {
        self.carried > 0 && self.loose == 0
    }

    fn see_demands(&mut self, robots: &[RobotView]) {
        let find = |name: &str| robots.iter().find(|robot| robot.name.as_str() == name);
        if let (Some(rnt), Some(polycrank), Some(hand)) = (find("rnt"), find("polycrank"), find("rnt-hand")) {
            self.held = (hand.demanded.joints[0] - CLOSED).abs() < 1e-9;
            if self.held {
                self.demanded = self.demanded.max(Apart::of(&[rnt.demanded.pose, polycrank.demanded.pose]));
            }
        }
    }

    fn see_period(&mut self, robot: &Observation<'_>, hands: Option<&[Hand; 2]>) {
        let mut tool = Pose::identity();
        match robot.robot {
            "rnt" => {
                robot.frames(&mut |frame| tool = *frame);
                self.rnt = Some(tool);
            }
            "polycrank" => {
                robot.frames(&mut |frame| tool = *frame);
                if let Some(rnt) = self.rnt {
                    self.see_tools(robot.time, [rnt, tool], hands);
                }
            }
            _ => {}
        }
    }

    fn see_tools(&mut self, time: f64, tools: [Pose; 2], hands: Option<&[Hand; 2]>) {
        let measured = if self.held { Apart::of(&tools) } else { Apart::default() };
        if self.held {
            self.carried += 1;
            self.loose += u64::from(hands.is_some_and(|hands| !hands.iter().all(Hand::is_closed)));
        }
        let (strain, internal) = hands.map_or_else(Default::default, |hands| self.stress(hands));
        self.measured = self.measured.max(measured);
        self.strain = self.strain.max(strain);
        self.internal = self.internal.max(internal);
        if self.periods.is_multiple_of(5) {
            self.samples.push(Sample { time, measured, strain, internal });
        }
        self.periods += 1;
    }

    /// How far the true hands are from where they closed, and their internal force \[N\].
    #[allow(non_snake_case)]
    fn stress(&mut self, hands: &[Hand; 2]) -> (Apart, f64) {
        if !hands.iter().all(Hand::is_closed) {
            self.closed = None;
            return Default::default();
        }
        let X_E1E2 = hands[0].pose().inv_mul(&hands[1].pose());
        let closed = *self.closed.get_or_insert(X_E1E2);
        (Apart::between(&closed, &X_E1E2), hands[0].world().internal_force())
    }
}
