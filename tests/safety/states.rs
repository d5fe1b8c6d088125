//! Stops on the path in every state that the robots of a cell may be in. How long they take is a property of the cell, whoever
//! of its robots moves, waits, has finished or is jogged.

use std::time::Duration;

use mrroc::cell::{LowerCell, RobotSetup};
use mrroc::fault::{FaultKind, Name};
use mrroc::generator::RobotHandle;
use mrroc::prelude::*;
use mrroc::robot::Limits;
use mrroc::testing::{OperatorReport, RandomOperator};
use mrroc_generators::generators::{Delay, PanelJog};
use mrroc_generators::jerk::{JointLimits, JointState, JointTarget, MoveCursor, SynchronisedMove};
use mrroc_tests::{ExactDrive, Gantry, MS, Q};

use super::operators::Random;

/// What the robots of a cell do.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Activity {
    /// Each goes by a program of its own and stands now and then; one program is over after a while, in every second cell.
    OwnPrograms,
    /// The MP moves one after the other.
    OneByOne,
    /// One moves in the background, while the MP moves the other or waits.
    Background,
    /// Motions of one follow one another without a standstill, beside which the other stands.
    Blended,
    /// The cell serves another one.
    Serving,
    /// A person jogs one or the other.
    Jogged,
}

/// To a goal of its own, at which it stands or goes on, within a share of the limits.
struct Go {
    random: Random,
    limits: JointLimits<Q<3>>,
    /// The state on the path of the motion before, from which it goes on.
    from: Option<JointState<Q<3>>>,
    /// Whether the next motion takes over before the end, and how much path time this one has gone \[s\].
    goes_on: bool,
    time: f64,
    cursor: Option<MoveCursor<Q<3>>>,
}

impl Go {
    fn new(random: &mut Random, limits: &JointLimits<Q<3>>) -> Go {
        Go { random: random.fork(), limits: *limits, from: None, goes_on: false, time: 0.0, cursor: None }
    }

    /// Where its path ends.
    fn end(&self) -> Option<JointState<Q<3>>> {
        self.cursor.as_ref().map(|cursor| JointState::from(cursor.here()))
    }
}

#[generator(ecp)]
impl Go {
    fn first_step(&mut self, e: &State<Gantry>, t: Tick) -> Result<Step<Gantry>, Fault> {
        let start = self.from.unwrap_or_else(|| JointState::rest(e.demanded().joints));
        let goal = Q::from_fn(|_, _| 1.2 * self.random.next() - 0.6);
        let motion = SynchronisedMove::new(&start, &JointTarget::rest(goal), &self.limits);
        self.cursor = Some(MoveCursor::new(motion.map_err(|error| Fault::thrown(&error.to_string()))?));
        Ok(self.next_step(t))
    }

    fn next_step(&mut self, t: Tick) -> Step<Gantry> {
        let Some(cursor) = &mut self.cursor else { return Step::Done };
        if self.goes_on && self.time > 0.6 * cursor.motion().duration() {
            return Step::Done;
        }
        self.time += t.dt;
        let next = cursor.advance(t.dt);
        next.map_or(Step::Done, |point| Step::Next(Demand::joints(point.position)))
    }
}

/// What an upper cell tells a lower one: nothing in particular.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
enum Work {
    Go,
}

#[generator(mp)]
fn let_work(_c: &mut LetWork) -> Always<[LowerCell; 1], Work> {
    Always([Work::Go])
}

struct LetWork;

/// Goes on where an abort has ended a motion, as a program may.
fn unless_aborted<T>(ended: Result<T, Fault>) -> Result<(), Fault> {
    match ended {
        Err(fault) if fault.kind() == FaultKind::Aborted => Ok(()),
        ended => ended.map(drop),
    }
}

/// The limits of a robot, and what its motions are planned with. As the seed says, with a jerk limit or without one.
fn limits(random: &mut Random, ts: f64, fastest: f64) -> (Limits<Q<3>>, JointLimits<Q<3>>) {
    let has_jerk = random.next() < 0.6;
    let velocity = Q::from_fn(|_, _| fastest * (0.2 + 0.8 * random.next()));
    let acceleration = Q::from_fn(|i, _| velocity[i] * (2.0 + 8.0 * random.next()));
    // From an acceleration that takes a fifth of a second to one that takes two steps.
    let jerk = Q::from_fn(|i, _| acceleration[i] / (2.0 * ts + (0.2 - 2.0 * ts).max(0.0) * random.next()));
    let (lower, upper) = (Q::repeat(-1.6), Q::repeat(1.6));
    let planned =
        JointLimits { velocity: velocity * 0.9, acceleration: acceleration * 0.9, jerk: jerk * 0.9 };
    (Limits { lower, upper, velocity, acceleration, jerk: has_jerk.then_some(jerk) }, planned)
}

/// A cell of two gantries that do this, as its seed says.
fn cell(seed: u64, doing: Activity, fastest: f64) -> Cell {
    let mut random = Random::of(seed);
    let step = MS * [1, 2, 4, 5, 10][(random.next() * 5.0) as usize];
    let ts = step.as_secs_f64();
    let mut cell = Cell::new(step).stop_time(Duration::from_secs(3));
    let mut planned = Vec::new();
    for (i, name) in ["left", "right"].into_iter().enumerate() {
        let (limits, plan) = limits(&mut random, ts, fastest);
        planned.push(plan);
        let robot = RobotSetup::new(name, Gantry::with_limits(limits), ExactDrive::new(Q::zeros(), step));
        let mut own = random.fork();
        let is_over_after = if i == 1 && seed.is_multiple_of(2) { 1 } else { u32::MAX };
        cell = cell.robot(match doing {
            Activity::OwnPrograms => robot.program(move |ecp| {
                for _ in 0..is_over_after {
                    ecp.move_robot((), Go::new(&mut own, &plan))?;
                    ecp.move_robot((), Delay::lasting(0.3 * own.next()))?;
                }
                Ok(())
            }),
            Activity::Jogged => robot.program(move |ecp| {
                loop {
                    let panel = ecp.jog_panel();
                    ecp.move_robot((), PanelJog::by(panel))?;
                }
            }),
            Activity::OneByOne | Activity::Background | Activity::Blended | Activity::Serving => robot,
        });
    }
    let work = move |mp: &mut Mp, left: &mut RobotHandle<Gantry>, right: &mut RobotHandle<Gantry>| {
        let go = |random: &mut Random, i: usize| Go::new(random, &planned[i]);
        match doing {
            Activity::Background => {
                mp.start_robot(left, go(&mut random, 0))?;
                if random.next() < 0.5 {
                    mp.move_robot(right, (), Delay::lasting(0.2 * random.next()))?;
                }
                mp.move_robot(right, (), go(&mut random, 1))?;
                mp.end_robot(left)
            }
            Activity::Blended => {
                let mut from = None;
                for _ in 0..3 {
                    let on = Go { from, goes_on: true, ..go(&mut random, 0) };
                    from = mp.blend_robot(left, (), on)?.end();
                }
                mp.move_robot(left, (), Go { from, ..go(&mut random, 0) })?;
                mp.move_robot(right, (), go(&mut random, 1)).map(drop)
            }
            Activity::OneByOne | Activity::Serving | Activity::OwnPrograms | Activity::Jogged => {
                mp.move_robot(left, (), go(&mut random, 0))?;
                mp.move_robot(right, (), go(&mut random, 1)).map(drop)
            }
        }
    };
    let mut work = work;
    match doing {
        Activity::OwnPrograms | Activity::Jogged => cell,
        Activity::OneByOne | Activity::Background | Activity::Blended => cell.program(move |mp| {
            let (mut left, mut right) = (mp.robot("left")?, mp.robot("right")?);
            loop {
                unless_aborted(work(mp, &mut left, &mut right))?;
            }
        }),
        Activity::Serving => {
            let lower = cell.program(move |mp| {
                let (mut left, mut right) = (mp.robot("left")?, mp.robot("right")?);
                mp.serve_all(|mp, Work::Go| work(mp, &mut left, &mut right))
            });
            Cell::new(step).stop_time(Duration::from_secs(3)).cell("lower", lower).program(|mp| {
                let mut lower = mp.robot::<LowerCell>("lower")?;
                loop {
                    unless_aborted(mp.move_robots([&mut lower], (), LetWork))?;
                }
            })
        }
    }
}

fn run(doing: Activity, runs: u64) -> OperatorReport {
    let report = RandomOperator::new(|seed| cell(seed, doing, 1.0)).runs(runs).steps(1500).run();
    println!("{doing:?}: {report}");
    report
}

/// At reduced speed: with holds, of what moves by its program or is jogged.
fn run_held(doing: Activity, runs: u64) -> OperatorReport {
    let name = |name| Name::new(name).expect("a name");
    let jogged = if doing == Activity::Jogged { vec![name("left"), name("right")] } else { Vec::new() };
    // No tool is faster than 250 mm/s: three slides of 130 mm/s each at most.
    let fastest = if doing == Activity::Jogged { 1.0 } else { 0.13 };
    let cells = RandomOperator::new(|seed| cell(seed, doing, fastest)).holding(jogged);
    let report = cells.runs(runs).steps(1500).run();
    println!("{doing:?}, held: {report}");
    report
}

const MOVING: [Activity; 5] =
    [Activity::OwnPrograms, Activity::OneByOne, Activity::Background, Activity::Blended, Activity::Serving];

fn sweep(runs: u64) -> Vec<String> {
    let mut wrong = Vec::new();
    let moving = MOVING.map(|doing| run(doing, 2 * runs));
    let held = MOVING.map(|doing| run_held(doing, runs));
    for report in moving.into_iter().chain(held).chain([run_held(Activity::Jogged, 2 * runs)]) {
        wrong.extend(report.failures().iter().chain(report.false_stops()).cloned());
    }
    wrong
}

#[test]
fn fault_247_a_stop_on_the_path_keeps_its_bound_in_every_state_of_the_robots() {
    let wrong = sweep(10);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
#[ignore = "takes minutes: `just sweep-states`"]
fn stops_in_every_state_of_the_robots_of_many_cells() {
    let wrong = sweep(1000);
    assert!(wrong.is_empty(), "{wrong:#?}");
}
