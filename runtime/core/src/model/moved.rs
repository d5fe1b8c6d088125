//! Which handles go with a generator in a Move.
//!
//! The compiler learns the list from either side: from the generator, or, where the generator is for any list
//! (`RigidCarry::along(..)`), from the handles. It must not take it from the handles while it does not know the generator,
//! or a wrong list would be reported as a wrong generator. So [`RobotsMovedBy`] has two implementations, and the compiler
//! waits for the generator's language, which says which of them counts.

use crate::model::generator::Generator;
use crate::model::list::{ListOf, RobotList, RobotsOf, Spoken};

/// Handles of the robots that the generator `G` moves: one `&mut` handle for each robot of its list `L`, in its order.
///
/// `O` and `L` are [`Generator::Language`] and [`Generator::Robots`] of `G`.
#[diagnostic::on_unimplemented(
    message = "expected one `&mut` handle for each robot of the list",
    label = "these are `{Self}`",
    note = "the list is `{L}`: pass the handles in its order",
    note = "a list of one robot needs a comma: `(&mut rnt,)`; a handle is asked for once, by `let mut rnt = mp.robot::<Rnt>(\"rnt\")?`",
    note = "a motion of one robot, whose list is `Rnt` alone, is moved by `move_robot`: `mp.move_robot(&mut rnt, (), motion)`; such motions of several robots at once by `mp.move_robots((&mut a, &mut b), (), Each::of((motion, motion)))`"
)]
pub trait RobotsMovedBy<G, O, L: RobotList>: RobotsOf<L> {}

impl<G, O, L, H> RobotsMovedBy<G, O, L> for H
where
    G: Generator<Robots = L, Language = O>,
    O: Spoken,
    L: RobotList,
    H: ListOf<L>,
{
}

/// The language of a generator whose attribute reported a mistake: goes with all handles.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct AnyLanguage;

impl<G, L: RobotList, H: RobotsOf<L>> RobotsMovedBy<G, AnyLanguage, L> for H {}
