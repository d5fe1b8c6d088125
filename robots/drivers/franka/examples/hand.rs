//! Closes a Franka Hand on a part, carries it by a simulated arm and opens it: `cargo run -p mrroc-examples --example hand -- --cell
//! robots/drivers/franka/examples/hand.toml --simulated`, and with `--processes` in its place where a hand is at the address of
//! that file.
//!
//! `--times` behind a `--` says how often, once by default.

use mrroc::launch::own_number;
use mrroc::prelude::*;
use mrroc::robot::{Input, Regulators};
use mrroc_franka::with_franka_hand;
use mrroc_generators::conditions::{ConditionExt, elapsed};
use mrroc_generators::generators::JointMove;
use mrroc_robots::{Irp6, One, Six, TwoFingers, simulated};

/// Openings around the part and, pressing on it, beyond it \[m\].
const OPEN: f64 = 0.07;
const AROUND: f64 = 0.05;
const CLOSED: f64 = 0.01;

/// Parameter sets of the hand: it grasps what it closes on, or presses on nothing.
const GRASPS: Regulators = Regulators::uniform(0);
const MOVES: Regulators = Regulators::uniform(1);

fn main() -> std::process::ExitCode {
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    Ok(file.cell(&with_franka_hand(simulated()))?.program(carry))
}

/// How its fingers close from then on.
struct Close(Regulators, bool);

#[generator(mp)]
fn close(c: &mut Close) -> Step<(TwoFingers,)> {
    if std::mem::replace(&mut c.1, true) {
        Step::Done
    } else {
        Step::Next((Demand::hold().with_regulators(c.0),))
    }
}

/// The fingers stand: they are where they were told to be, or something stops them.
struct Stand;

#[condition(mp)]
fn stand(_c: &mut Stand, e: &State<(TwoFingers,)>) -> bool {
    e.0.measured().velocity[0].abs() < 1e-3
}

fn carry(mp: &mut Mp) -> Result<(), Fault> {
    let times = own_number("times", 1)?;
    let (mut arm, mut hand) = (mp.robot::<Irp6>("arm")?, mp.robot::<TwoFingers>("hand")?);
    let holds: Input<bool> = hand.input("holds")?;
    let here = arm.demanded().joints;
    let there = here + Six::x() * 0.3;
    // The fingers begin when the demand stands.
    let go = |mp: &mut Mp, hand: &mut _, how, opening| {
        mp.move_robots((&mut *hand,), (), Close(how, false))?;
        mp.move_robot(hand, (), JointMove::to(One::new(opening), One::new(0.09), One::new(0.35)))?;
        mp.wait_until((&mut *hand,), (), elapsed(0.4))?;
        mp.wait_until((hand,), (), Stand.held_for(0.3)).map(drop)
    };
    for _ in 0..times {
        go(mp, &mut hand, MOVES, OPEN)?;
        go(mp, &mut hand, MOVES, AROUND)?;
        println!("around: {:.4} m, {}", hand.measured().joints[0], hand.value(holds));
        go(mp, &mut hand, GRASPS, CLOSED)?;
        println!("closed: {:.4} m, {}", hand.measured().joints[0], hand.value(holds));
        if hand.value(holds) {
            for goal in [there, here] {
                mp.move_robot(&mut arm, (), JointMove::to(goal, Six::repeat(0.4), Six::repeat(0.8)))?;
            }
        }
        go(mp, &mut hand, MOVES, OPEN)?;
        println!("opened: {:.4} m, {}", hand.measured().joints[0], hand.value(holds));
    }
    Ok(())
}
