//! What a run shows: how far the tools leave their relative pose, and how hard they press on the body.
//!
//! In: what the robots' EDPs report and the true state of the simulated world. Out: peaks, and samples for pictures.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::{Cell, Fault, Observation, Pose, RobotView};

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
        let nominal = grasp(End::Near).inv_mul(&grasp(End::Far));
        let error = nominal.inv_mul(&X_WE[0].inv_mul(&X_WE[1]));
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
    /// Both hands hold the body.
    pub held: bool,
    /// Of the tools as the encoders say.
    pub measured: Apart,
    /// The internal force \[N\].
    pub internal: f64,
    /// `X_WB` of the body.
    pub body: Pose,
}

/// What was seen of a run.
#[derive(Debug, Default)]
pub struct Seen {
    /// The largest relative pose error of the demands while the body was carried.
    pub demanded: Apart,
    /// The same of what the encoders read.
    pub measured: Apart,
    /// Peak of the internal force \[N\].
    pub internal: f64,
    /// A sample every 10 ms.
    pub samples: Vec<Sample>,
    held: bool,
    rnt: Option<Pose>,
    periods: u64,
}

/// Watches a cell.
#[derive(Clone, Debug, Default)]
pub struct Witness(Rc<RefCell<Seen>>);

impl Witness {
    /// One that has seen nothing yet.
    #[must_use]
    pub fn new() -> Witness {
        Witness::default()
    }

    /// What it has seen.
    pub fn seen(&self) -> std::cell::Ref<'_, Seen> {
        self.0.borrow()
    }

    /// Looks at a cell, and into the world of its plant if there is one.
    #[must_use]
    pub fn watch(&self, cell: Cell, plant: Option<Plant>) -> Cell {
        let (demands, encoders) = (Rc::clone(&self.0), Rc::clone(&self.0));
        cell.guard(1, move |robots| {
            demands.borrow_mut().see_demands(robots);
            Ok::<(), Fault>(())
        })
        .watch(move |robot| encoders.borrow_mut().see_period(robot, plant.as_ref()))
    }
}

impl Seen {
    fn see_demands(&mut self, robots: &[RobotView]) {
        let find = |name: &str| robots.iter().find(|robot| robot.name.as_str() == name);
        if let (Some(rnt), Some(polycrank), Some(hand)) = (find("rnt"), find("polycrank"), find("rnt-hand")) {
            self.held = (hand.demanded.joints[0] - CLOSED).abs() < 1e-9;
            if self.held {
                self.demanded = self.demanded.max(Apart::of(&[rnt.demanded.pose, polycrank.demanded.pose]));
            }
        }
    }

    fn see_period(&mut self, robot: &Observation<'_>, plant: Option<&Plant>) {
        let tool = || {
            let mut tool = Pose::identity();
            robot.frames(&mut |frame| tool = *frame);
            tool
        };
        match robot.robot {
            "rnt" => self.rnt = Some(tool()),
            "polycrank" => {
                let Some(rnt) = self.rnt else { return };
                let measured = Apart::of(&[rnt, tool()]);
                let internal = plant.map_or(0.0, |plant| plant.world.internal_force());
                self.internal = self.internal.max(internal);
                if self.held {
                    self.measured = self.measured.max(measured);
                }
                if self.periods.is_multiple_of(5) {
                    let body = plant.map_or_else(Pose::identity, |plant| plant.world.body().pose);
                    let (time, held) = (robot.time, self.held);
                    self.samples.push(Sample { time, held, measured, internal, body });
                }
                self.periods += 1;
            }
            _ => {}
        }
    }
}
