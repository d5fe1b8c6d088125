//! Plans anew on a thread of its own, while robots move and the program goes on.
//!
//! In: the plan that robots follow, new goals, and how much path time there is for planning. Out: the new plan, handed over at an instant of
//! path time, or why the robots keep the old one.
//!
//! Only what a program does between two instructions changes the plan that is followed: steps wait for nothing, allocate nothing and take no lock. The
//! instant is one of path time, so a suspension or a lower speed leaves more time for planning. Under the virtual clock, where time stands still while a program
//! computes, the program waits there for the planner; in real time it does not. What became of a query is recorded, so a replay hands over the same plan
//! at the same instant, or none.

use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

use mrroc::fault::FaultKind;
use mrroc::prelude::*;

use crate::error::PlanError;
use crate::follow::Following;
use crate::plan::Plan;
use crate::planner::Planner;

/// The path time before the hand-over at which a new plan must be there \[s\]: what the program and its guard need until then.
const BEFORE: f64 = 0.02;
/// The least path time from a query to the hand-over \[s\].
const LEAST: f64 = 0.05;

/// Plans anew while robots follow a plan, on a thread of its own.
///
/// Make it where the cell is made: in a process with real time, a thread that is started by its program would be as urgent as its steps.
///
/// ```
/// use mrroc::generator::RobotHandle;
/// use mrroc::prelude::*;
/// use mrroc_planning::{Following, Replanned, Replanner};
/// use mrroc_robots::Irp6;
///
/// /// The robot goes to `first`, and to `then` as soon as that is known.
/// fn pursue(
///     mp: &mut Mp,
///     arm: &mut RobotHandle<Irp6>,
///     replanner: &mut Replanner,
///     here: &[f64],
///     [first, then]: [Vec<f64>; 2],
/// ) -> Result<(), Fault> {
///     let plan = replanner.planner().plan(here, &[first])?;
///     let following = Following::new(&plan);
///     mp.start_robot(arm, following.motion("irp6")?)?;
///     // .. the program waits for a sensor, then:
///     match replanner.hand_over(mp, &following, 0.2, &[then])? {
///         Replanned::HandedOver(plan) => println!("reached at {:.3} s of path time", plan.duration()),
///         Replanned::Kept(why) => println!("{why}"),
///     }
///     mp.wait_until((), (), following.reached(f64::INFINITY))?;
///     mp.end_robot(arm)
/// }
/// ```
pub struct Replanner {
    planner: Planner,
    /// The number of the last query, and whether its answer is to come.
    asked: u64,
    is_open: bool,
    queries: Sender<Query>,
    answers: Receiver<(u64, Result<Plan, PlanError>)>,
}

struct Query {
    number: u64,
    planner: Planner,
    plan: Plan,
    at: f64,
    goals: Vec<Vec<f64>>,
}

/// What became of a new goal.
#[derive(Clone, Debug)]
#[must_use]
pub enum Replanned {
    /// The robots follow this plan, which leads to the new goal.
    HandedOver(Plan),
    /// They follow the plan that they had, to its end: there is no new plan, or it came too late.
    Kept(Fault),
}

impl Replanner {
    /// With a thread that plans as `planner` does.
    ///
    /// # Errors
    /// [`PlanError::Thread`].
    pub fn new(planner: Planner) -> Result<Self, PlanError> {
        let (queries, asked) = channel::<Query>();
        let (tells, answers) = channel();
        let run = move || {
            while let Ok(oldest) = asked.recv() {
                // Nobody waits for the answers to those before.
                let Query { number, mut planner, plan, at, goals } =
                    asked.try_iter().last().unwrap_or(oldest);
                // Without a program that waits for it the answer is nothing.
                let _ = tells.send((number, planner.replan(&plan, at, &goals)));
            }
        };
        let thread = std::thread::Builder::new().name("planner".to_owned()).spawn(run);
        thread.map_err(|error| PlanError::Thread(error.to_string()))?;
        Ok(Replanner { planner, asked: 0, is_open: false, queries, answers })
    }

    /// The planner of the next queries. Put another one in its place where the world has changed.
    pub fn planner(&mut self) -> &mut Planner {
        &mut self.planner
    }

    /// Begins to plan for robots that will be at the end of `lead` \[s\], at least 0.05 s, of path time from now; returns that instant of path time. An older
    /// query is forgotten; if its plan is in the making, that is finished first.
    ///
    /// # Errors
    /// [`PlanError::Lead`].
    pub fn ask(&mut self, following: &Following, lead: f64, goals: &[Vec<f64>]) -> Result<f64, PlanError> {
        if !(lead.is_finite() && lead >= LEAST) {
            return Err(PlanError::Lead { lead, least: LEAST });
        }
        let (plan, now) = (following.plan(), following.time());
        let at = (now + lead).min(plan.duration());
        self.asked += 1;
        self.is_open = true;
        let (number, planner, goals) = (self.asked, self.planner.clone(), goals.to_vec());
        // Where the thread has ended there is no answer, which is told then.
        let _ = self.queries.send(Query { number, planner, plan: plan.since(now), at, goals });
        Ok(at)
    }

    /// Hands the robots over to the plan that was asked for last, if there is one. Under the virtual clock it waits for it.
    ///
    /// # Errors
    /// As of [`Mp::recorded`].
    pub fn take(&mut self, mp: &mut Mp, following: &Following) -> Result<Replanned, Fault> {
        let waits = mp.time_stands_still();
        let answer = mp.recorded("replanned", || self.answer(waits).map_err(Fault::from));
        let plan = match answer {
            Ok(plan) => plan,
            Err(fault) if fault.kind() == FaultKind::Program => return Ok(Replanned::Kept(fault)),
            Err(fault) => return Err(fault),
        };
        Ok(match following.hand_over(&plan) {
            Ok(()) => Replanned::HandedOver(plan),
            Err(error) => Replanned::Kept(error.into()),
        })
    }

    /// Leads the robots to one of `goals` from where they will be after `lead` \[s\], at least 0.05 s, of path time: asks, waits until shortly before, and
    /// hands them over. `lead` is what there is for planning, less 20 ms. If a suspension has led the robots past that place, it asks again.
    ///
    /// # Errors
    /// The [`Fault`] of the Wait, as of [`ask`](Self::ask), or as of [`Mp::recorded`].
    pub fn hand_over(
        &mut self,
        mp: &mut Mp,
        following: &Following,
        lead: f64,
        goals: &[Vec<f64>],
    ) -> Result<Replanned, Fault> {
        loop {
            let at = self.ask(following, lead, goals)?;
            mp.wait_until((), (), following.reached(at - BEFORE))?;
            let was_passed = following.time() > at && !following.is_over();
            let outcome = self.take(mp, following)?;
            // A Wait does not look while robots slow down to a suspension.
            if !was_passed || matches!(outcome, Replanned::HandedOver(_)) {
                return Ok(outcome);
            }
        }
    }

    fn answer(&mut self, waits: bool) -> Result<Plan, PlanError> {
        if !core::mem::take(&mut self.is_open) {
            return Err(PlanError::NotYet);
        }
        loop {
            let answer = if waits {
                self.answers.recv().map_err(|_| TryRecvError::Disconnected)
            } else {
                self.answers.try_recv()
            };
            match answer {
                Ok((number, answer)) if number == self.asked => return answer,
                // Of a query that is forgotten.
                Ok(_) => {}
                Err(TryRecvError::Empty) => return Err(PlanError::NotYet),
                Err(TryRecvError::Disconnected) => {
                    return Err(PlanError::Thread("it has ended".to_owned()));
                }
            }
        }
    }
}
