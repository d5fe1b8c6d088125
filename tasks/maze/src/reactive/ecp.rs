//! The reactive controller: in every step the behaviour of the arm that matters most, by what it feels.

use std::rc::Rc;

use mrroc::prelude::*;
use mrroc_generators::combinators::{Arbitrate, Blind};
use mrroc_generators::generators::StraightLine;
use mrroc_robots::Irp6;

use super::behaviours::{Follow, Heading, Retreat};
use super::sensor::{Line, Seeking, Sought};
use crate::ecp::{go, hop};
use crate::orders::Task;
use crate::places::{LOW, Sizes, tool};
use crate::plant::TouchProbe;

/// A behaviour is braked within so much time before another one takes over \[s\].
const BRAKING: f64 = 0.06;
/// The ball is off a wall so long after it touched that \[s\].
const OFF: f64 = 0.25;

/// It goes at this share of the speed of an arm with a map, because each behaviour is braked before another one takes over.
const SHARE: f64 = 0.65;

fn sought(v: &Reading<(Seeking,)>) -> Sought {
    v.0.reading().unwrap_or_default()
}

/// The arm: out of the maze by itself. Where the maze stands, it is led to find, as any arm.
///
/// # Errors
/// The first fault of the cell; no path leads to the exit.
pub fn arm(ecp: &mut Ecp<Irp6>, sizes: &Sizes) -> Result<(), Fault> {
    let mut probe = ecp.sensor::<TouchProbe>("probe")?;
    let mut seeker = ecp.sensor::<Seeking>("way")?;
    ecp.serve_all(|ecp, task| match task {
        Task::Go { x, y } => go(ecp, &mut probe, [x, y], sizes),
        Task::Hop { x, y } => hop(ecp, [x, y], sizes),
        Task::Leave { x, y, near } => {
            let from = ecp.image().demanded().pose.translation.vector.xy();
            seeker.configure(Line { from: from.into(), to: [x, y], near });
            let heading = Heading::default();
            let sizes = Sizes { velocity: SHARE * sizes.velocity, ..*sizes };
            let of_follow = Rc::clone(&heading);
            let retreat = move || Retreat::of(&heading, &sizes);
            let follow = move || Follow::along(&of_follow, &sizes);
            let head = move || Blind::new(StraightLine::to(tool(x, y, LOW), sizes.careful()));
            let is_astray = |v: &Reading<(Seeking,)>| !sought(v).is_on_line;
            let is_on_line = |v: &Reading<(Seeking,)>| sought(v).is_on_line;
            let usual = move || Arbitrate::of(follow.clone(), is_astray, is_on_line, BRAKING, head);
            let touches = |v: &Reading<(Seeking,)>| sought(v).touch.touching;
            let is_clear = |v: &Reading<(Seeking,)>| !sought(v).touch.touching && sought(v).touch.since > OFF;
            let motion = Arbitrate::of(retreat, touches, is_clear, BRAKING, usual);
            ecp.move_robot((&mut seeker,), motion).map(drop)
        }
    })
}
