//! A guard that knows the plans that robots follow.
//!
//! In: the plan that a program is about to move the robots along, and in every step the states of all robots. Out: nothing, or
//! [`GuardError`], for which the cell makes a protective stop on the path.
//!
//! A guard that does not know the path must take every path that the robots could be on, and stops most motions near an obstacle. This one
//! finds where on its plan all robots are ([`Followed`]). From there a stop passes at most the path time
//!
//! ```text
//! P = reaction + path time of a stop on the path    (Stopping::on_path)
//! ```
//!
//! of the plan, and stays on it. All pairs must be proven to keep their margins that far ahead ([`Clearance::prove`]), with all robots at one path
//! time: they slow down together. What is proven is remembered, so a step looks only at what is new: at what an obstacle that was replaced
//! may be near.
//!
//! Fault stops leave the path. The planner has proven them for the world that it knew; for an obstacle that was replaced they are proven from everywhere in `P`
//! as well ([`fault_stops`](crate::fault_stops)). That takes more time: it may last some checks until it is caught up. Where the robots are not on the plan, [`Clearance::check`] is asked.

// Errors hold both bodies and their points; in a box they would have to be allocated within a step.
#![allow(clippy::result_large_err)]

use core::cell::RefCell;
use std::rc::Rc;

use mrroc::fault::Fault;
use mrroc::robot::RobotView;
use mrroc_robots::clearance::{
    Against, CheckError, Clearance, ClearanceError, Joints, Nearest, Obstacle, TooClose,
};

use crate::error::PlanError;
use crate::fault_stops::Proof;
use crate::followed::Followed;
use crate::plan::Plan;

/// The most stretches of the path that a check looks at: more would be an unbounded time in a step.
const PARTS: u32 = 256;

/// The most boxes of fault stops that it looks at beside, and in how many checks in a row it may leave some for the next one.
const STOP_PARTS: u32 = 256;
const BEHIND: u32 = 128;

/// Where a proof begins before a place [rad or m], so that the place itself is looked at also where robots go no farther.
const BEFORE: f64 = 1e-9;

/// A guard that knows the plans that robots follow. Clones are the same guard: one goes to the cell, one to the program.
///
/// It must be in the process of the program that calls [`follow`](Self::follow): the MP.
///
/// ```
/// use std::time::Duration;
/// use mrroc::prelude::*;
/// use mrroc_planning::{HereAll, PlanGuard, Planner};
/// use mrroc_robots::clearance::{Clearance, Obstacle, Stopping};
/// use mrroc_robots::{Irp6, Six};
/// use nalgebra::Vector3;
///
/// # fn cell(goal: Six) -> Result<Cell, Box<dyn std::error::Error>> {
/// let step = Duration::from_millis(2);
/// let clearance = Clearance::with_margin(0.03)
///     .robot("irp6", Irp6::nominal())?
///     .obstacle("post", Obstacle::ball(Vector3::new(0.9, 0.4, 0.8), 0.1))?
///     .build(Stopping::of_guard(step, 1))?;
/// let mut planner = Planner::new(clearance.clone())?;
/// let guard = PlanGuard::new(clearance)?;
/// let watch = guard.clone();
/// let cell = Cell::new(step)
///     .guard(1, move |robots| watch.check(robots).map(drop).map_err(Fault::from))
///     .program(move |mp| {
///         let mut arm = mp.robot::<Irp6>("irp6")?;
///         let here = mp.wait_until((&mut arm,), (), HereAll::<(Irp6,)>::default())?.joints();
///         let plan = planner.plan(&here, &[goal.as_slice().to_vec()])?;
///         guard.follow(&plan)?;
///         mp.move_robot(&mut arm, (), plan.motion("irp6")?).map(drop)
///     });
/// # Ok(cell) }
/// # cell(Irp6::READY).unwrap();
/// ```
#[derive(Clone)]
pub struct PlanGuard(Rc<RefCell<Inner>>);

struct Inner {
    clearance: Clearance,
    followed: Option<Followed>,
    /// How far along the plan each obstacle, and at last the links among themselves, are proven clear.
    proven: Vec<f64>,
    /// The same of fault stops, for each obstacle that has been replaced; infinite for those that the planner knows.
    stops: Vec<Proof>,
    /// In how many checks in a row there was not enough time for fault stops.
    behind: u32,
    demanded: Vec<Joints>,
    velocity: Vec<Joints>,
}

/// What a check has looked at.
#[derive(Clone, Debug, PartialEq)]
pub enum Watched {
    /// The stop on the plan, from this path time \[s\] on.
    Plan(f64),
    /// Any stop on any path: robots are not on a plan. Told is the pair that has the least distance beyond its margin.
    AnyPath(Nearest),
}

/// Why a guard stops a cell.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GuardError {
    /// A stop on the plan that began now would not keep a margin.
    #[error(
        "at {time:.3} s of the plan: {} and {} are {:.4} m apart where a stop may end, and may be {:.4} m nearer there; {:.4} m must be left: plan anew from where the robots come to rest",
        .nearest.sides[0], .nearest.sides[1], .nearest.distance, .nearest.travel, .nearest.margin
    )]
    Ahead {
        /// The path time of the plan at which the robots are \[s\].
        time: f64,
        /// The pair, where it is too near on the plan or not proven to be apart.
        nearest: Nearest,
    },
    /// Robots that are on no plan might not keep a margin; or there are no states to check.
    #[error(transparent)]
    AnyPath(#[from] CheckError),
}

impl GuardError {
    fn ahead(time: f64, error: CheckError) -> Self {
        match error {
            CheckError::TooClose(TooClose(nearest)) => GuardError::Ahead { time, nearest },
            CheckError::Missing { .. } | CheckError::NothingToCheck | CheckError::NoPosture { .. } => {
                GuardError::AnyPath(error)
            }
        }
    }
}

impl From<GuardError> for Fault {
    fn from(error: GuardError) -> Self {
        match error {
            GuardError::Ahead { nearest, .. } => {
                let [a, b] = &nearest.sides;
                let what = if nearest.distance < nearest.margin { "too close" } else { "not proven apart" };
                let text = format!(
                    "{a} and {b} {what} ahead on the plan: {:.1} mm there, {:.1} mm to be left",
                    1e3 * nearest.distance,
                    1e3 * nearest.margin
                );
                Fault::thrown(&text)
            }
            GuardError::AnyPath(error) => error.into(),
        }
    }
}

impl PlanGuard {
    /// With the robots, bodies, pairs and margins of `clearance`, whose stops stay on the path: built with
    /// [`Stopping::of_guard`](mrroc_robots::clearance::Stopping::of_guard).
    ///
    /// # Errors
    /// [`PlanError::GuardBrakes`].
    pub fn new(clearance: Clearance) -> Result<Self, PlanError> {
        if clearance.stopping().on_path(0.0, 0.0).is_none() {
            return Err(PlanError::GuardBrakes);
        }
        let robots = clearance.robot_parts().len();
        let obstacles = clearance.obstacle_parts().len();
        let (proven, stops) = (vec![0.0; obstacles + 1], vec![Proof::NOT_NEEDED; obstacles]);
        let [demanded, velocity] = [(); 2].map(|()| vec![Joints::default(); robots]);
        Ok(PlanGuard(Rc::new(RefCell::new(Inner {
            clearance,
            followed: None,
            proven,
            stops,
            behind: 0,
            demanded,
            velocity,
        }))))
    }

    /// From now on the robots follow `plan`, from its beginning: call it before the Move, between instructions. It proves all of the plan by what the
    /// guard knows now, which takes milliseconds. What it cannot prove the guard looks at again when the robots come near, and stops them.
    ///
    /// # Errors
    /// [`PlanError::NoRobot`]: a robot of the clearance is none of the plan; [`PlanError::Joints`]: it is another one.
    pub fn follow(&self, plan: &Plan) -> Result<(), PlanError> {
        self.follow_from(plan, plan.motion.speed.begins)
    }

    /// The same where the robots are at a path time \[s\] of the plan already, such as [`Following::time`](crate::Following::time) when they have been
    /// handed over to it.
    ///
    /// # Errors
    /// As of [`follow`](Self::follow).
    pub fn follow_from(&self, plan: &Plan, time: f64) -> Result<(), PlanError> {
        let mut inner = self.0.borrow_mut();
        let Inner { clearance, followed, proven, stops, .. } = &mut *inner;
        let parts = clearance.robot_parts();
        let reaction = clearance.stopping().reaction;
        let mut new =
            Followed::new(plan, parts.iter().map(|part| (part.name.as_str(), part.shape.kinds().len())))?;
        let from = new.put_at(time, reaction);
        let mut all = from - BEFORE;
        // What stands in the way is told in the step in which it is too near.
        drop(clearance.prove(&new, &mut all, new.end(), Against::Everything, &mut u32::MAX.clone()));
        proven.fill(all);
        for (i, proof) in stops.iter_mut().enumerate().filter(|(_, proof)| proof.proven.is_finite()) {
            *proof = Proof { proven: from, ..Proof::NOTHING };
            drop(proof.extend(clearance, &new, new.end(), Against::Obstacle(i), &mut u32::MAX.clone()));
        }
        *followed = Some(new);
        Ok(())
    }

    /// Puts another body in the place of an obstacle, as [`Clearance::replace_obstacle`], also in a step.
    ///
    /// # Errors
    /// [`ClearanceError::BadBody`], [`ClearanceError::NoLink`] where no obstacle has this name.
    pub fn replace_obstacle(&self, name: &str, obstacle: Obstacle) -> Result<Obstacle, ClearanceError> {
        let mut inner = self.0.borrow_mut();
        let old = inner.clearance.replace_obstacle(name, obstacle)?;
        let place = inner.clearance.place_of_obstacle(name);
        if let Some(proven) = place.and_then(|place| inner.proven.get_mut(place)) {
            *proven = f64::NEG_INFINITY;
        }
        if let Some(proof) = place.and_then(|place| inner.stops.get_mut(place)) {
            *proof = Proof::NOTHING;
        }
        inner.behind = 0;
        Ok(old)
    }

    /// Changes what it knows, by [`Clearance::grasp`] or [`Clearance::release`], between instructions. It then knows no plan.
    pub fn change<T>(&self, change: impl FnOnce(&mut Clearance) -> T) -> T {
        let mut inner = self.0.borrow_mut();
        inner.followed = None;
        change(&mut inner.clearance)
    }

    /// Checks that a stop of all robots keeps all margins, if it begins now. It allocates nothing, and looks at no more than 256 stretches of the
    /// path, and after an obstacle has been replaced at 256 boxes of fault stops. If these are not enough it goes on in the next check, 128 times.
    ///
    /// # Errors
    /// [`GuardError`].
    pub fn check(&self, states: &[RobotView]) -> Result<Watched, GuardError> {
        self.0.borrow_mut().check(states)
    }
}

impl Inner {
    fn check(&mut self, states: &[RobotView]) -> Result<Watched, GuardError> {
        let Inner { clearance, followed, proven, stops, behind, demanded, velocity } = self;
        let on_plan = followed.as_mut().and_then(|followed| {
            followed.see(states, demanded, velocity)?;
            let now = followed.locate(demanded, velocity, clearance.stopping().reaction)?;
            let time = clearance.stopping().on_path(followed.slowest(), followed.jerkiest())?;
            Some((now, followed.after(now, time), &*followed))
        });
        let Some((now, to, followed)) = on_plan else {
            return Ok(Watched::AnyPath(clearance.check(states)?));
        };
        let mut parts = PARTS;
        let links = proven.len() - 1;
        for (i, proven) in proven.iter_mut().enumerate() {
            if *proven < now.u {
                *proven = now.u - BEFORE;
            }
            if *proven >= to.u {
                continue;
            }
            let against = if i == links { Against::Links } else { Against::Obstacle(i) };
            let result = clearance.prove(followed, proven, to.u, against, &mut parts);
            result.map_err(|error| GuardError::ahead(now.time, error))?;
        }
        let mut parts = STOP_PARTS;
        let mut left = None;
        for (i, proof) in stops.iter_mut().enumerate() {
            proof.proven = proof.proven.max(now.u);
            let result = proof.extend(clearance, followed, to.u, Against::Obstacle(i), &mut parts);
            left = result.map_err(|error| GuardError::ahead(now.time, error))?.or(left);
        }
        *behind = if left.is_some() { *behind + 1 } else { 0 };
        if let Some(error) = left.filter(|_| *behind > BEHIND) {
            return Err(GuardError::ahead(now.time, error));
        }
        Ok(Watched::Plan(now.time))
    }
}
