//! Goals as words and as files, and a cell that is told of them.

use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;

use mrroc::cell::Cell;
use mrroc::fault::Name;
use mrroc::generator::Each;
use mrroc::observe::ServoRecord;
use mrroc::prelude::*;
use mrroc::program::Recorded;
use mrroc::random::Random;
use mrroc_generators::trajectory::{JointBounds, JointTrajectory, TrajectoryPoint};
use mrroc_robots::{Irp6, SimulatedIrp6};

use super::{Goal, GoalEnd, GoalFile, GoalNews, GoalState, Goals, TrajectoryGoals, refusal};

/// A goal that turns the columns of robots by angles, in a time \[s\].
fn goal(robots: &[(&str, f64)], time: f64) -> Goal {
    let limits = robots.iter().flat_map(|_| JointBounds::of(Irp6::nominal().limits())).collect();
    let mut positions = Vec::new();
    for (_, turned) in robots {
        let mut joints = Irp6::READY;
        joints[0] = *turned;
        positions.extend_from_slice(joints.as_slice());
    }
    let point = TrajectoryPoint { time, positions, ..TrajectoryPoint::default() };
    let trajectory = JointTrajectory::new(limits, vec![point]).expect("sound");
    let robots = robots.iter().map(|(name, _)| Name::new(name).expect("a name")).collect();
    Goal { robots, trajectory, delay: 0.0 }
}

#[test]
fn a_goal_is_the_same_of_its_words_and_other_words_are_none() {
    let mut given = goal(&[("left", 0.3), ("right", -0.2)], 1.5);
    given.trajectory = given.trajectory.starting_within(0.02).passed(0.25);
    let words = given.to_words();
    assert_eq!(Goal::from_words(&words), Some(given.clone()));
    let points: Vec<TrajectoryPoint> = (1..=3)
        .map(|k| TrajectoryPoint {
            time: f64::from(k),
            positions: vec![0.1; 12],
            velocities: vec![0.0; 12],
            accelerations: vec![0.2; 12],
        })
        .collect();
    let all = JointTrajectory::new(given.trajectory.limits().to_vec(), points).expect("sound");
    let all = Goal { trajectory: all, delay: 0.5, ..given };
    let told = all.to_words();
    assert_eq!(Goal::from_words(&told), Some(all));
    for len in 0..told.len() {
        assert_eq!(Goal::from_words(&told[..len]), None, "{len} of {} words", told.len());
    }
    assert_eq!(Goal::from_words(&[told.as_slice(), &[0]].concat()), None);
    // Whatever is in a file: a goal, or none, and no panic.
    let mut random = Random::seeded(7);
    for _ in 0..20_000 {
        let mut hostile = told.clone();
        for _ in 0..=random.below(3) {
            let place = random.below(hostile.len());
            hostile[place] = match random.below(4) {
                0 => u64::MAX,
                1 => f64::NAN.to_bits(),
                2 => random.below(1 << 16) as u64,
                _ => hostile[place] ^ (1 << random.below(64)),
            };
        }
        if let Some(goal) = Goal::from_words(&hostile) {
            assert!(
                goal.trajectory.points().iter().flat_map(|point| &point.positions).all(|q| q.is_finite())
            );
        }
    }
}

#[test]
fn a_goals_file_has_a_number_of_its_own_and_goes_with_what_has_written_it() {
    let given = goal(&[("left", 0.3)], 1.5);
    let [one, two] = [(); 2].map(|()| GoalFile::write(&given).expect("written"));
    assert_ne!(one.number(), two.number());
    assert_eq!(GoalFile::read(one.number()), Ok(given.clone()));
    let gone = one.number();
    drop(one);
    GoalFile::read(gone).expect_err("it is not there any more");
    assert_eq!(GoalFile::read(two.number()), Ok(given.clone()));
    // What a killed program left long ago goes when the next goal is written; what a program still has stays, such as for a cell that is suspended.
    let [left, kept] = ["17", "18"].map(|number| crate::port::folder().join("goals").join(number));
    std::fs::write(&left, "of long ago").expect("written");
    let owner = std::fs::File::create(&kept).expect("created");
    owner.lock().expect("locked");
    drop(GoalFile::write(&given).expect("written"));
    assert!(!left.exists() && kept.exists() && GoalFile::read(two.number()).is_ok());
    drop(owner);
    drop(GoalFile::write(&given).expect("written"));
    assert!(!kept.exists());
    let point = given.trajectory.points()[0].clone();
    let points = (1..3000).map(|k| TrajectoryPoint { time: f64::from(k), ..point.clone() }).collect();
    let long = JointTrajectory::new(given.trajectory.limits().to_vec(), points).expect("sound");
    let told = GoalFile::write(&Goal { trajectory: long, ..given }).expect_err("too long");
    assert!(told.contains("16384 are possible"), "{told}");
}

/// What a program that sends goals says from a step on.
type Script = Vec<(u64, GoalNews)>;

/// A sensor that says what a script does, and keeps what it is told.
struct Scripted {
    script: Script,
    told: Rc<RefCell<Vec<GoalState>>>,
}

impl VirtualSensor for Scripted {
    type Kind = Goals;

    fn aggregate(&mut self, order: &ReadingOrder<GoalState>) -> Result<GoalNews, Fault> {
        let mut told = self.told.borrow_mut();
        if told.last() != Some(&order.configuration) {
            told.push(order.configuration);
        }
        let news = self.script.iter().rev().find(|(from, _)| *from <= order.step);
        Ok(news.map_or_else(GoalNews::default, |(_, news)| *news))
    }
}

/// How a cell of two arms ends so many goals of a script, what the script was told, and the columns of both arms at the end \[rad\].
fn run(script: Script, ends: usize) -> (Vec<GoalEnd>, Vec<GoalState>, [f64; 2]) {
    let told = Rc::new(RefCell::new(Vec::new()));
    let columns = Rc::new(RefCell::new([0.0; 2]));
    let arm = |place: usize, name: &str| {
        let columns = Rc::clone(&columns);
        RobotSetup::new(name, Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &Irp6::READY))
            .observe(move |record: &ServoRecord<Irp6>| columns.borrow_mut()[place] = record.demanded[0])
    };
    let sensor = SensorSetup::new("goals", Scripted { script, told: Rc::clone(&told) });
    let got = Rc::new(RefCell::new(Vec::new()));
    let ended = Rc::clone(&got);
    let cell =
        Cell::new(Duration::from_millis(2)).robot(arm(0, "left")).robot(arm(1, "right")).sensor(sensor);
    let cell = cell.program(move |mp| {
        let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
        let mut goals = TrajectoryGoals::new(mp, "goals", &["left", "right"])?;
        let arms = Each::of((goals.motion::<Irp6>("left")?, goals.motion::<Irp6>("right")?));
        mp.start_robots((&mut left, &mut right), arms)?;
        for _ in 0..ends {
            let end = goals.next(mp)?;
            ended.borrow_mut().push(end);
        }
        Ok(())
    });
    cell.run().expect("within the limits");
    let columns = *columns.borrow();
    (got.take(), told.take(), columns)
}

fn news(newest: u64, cancelled: &[u64]) -> GoalNews {
    let mut news = GoalNews { newest, ..GoalNews::default() };
    news.cancelled[..cancelled.len()].copy_from_slice(cancelled);
    news
}

#[test]
fn a_cell_follows_goals_of_one_arm_and_of_both_and_tells_what_became_of_them() {
    let files = [
        goal(&[("left", 0.3)], 1.0),
        goal(&[("right", -0.2)], 1.5),
        goal(&[("right", 0.1), ("left", 0.1)], 1.0),
        goal(&[("left", 3.0)], 0.1),
        goal(&[("third", 0.1)], 1.0),
    ];
    let files = files.map(|goal| GoalFile::write(&goal).expect("written"));
    let [one, two, both, fast, strange] = files.each_ref().map(GoalFile::number);
    let script = vec![
        (50, news(one, &[])),
        (100, news(two, &[])),
        (1000, news(both, &[])),
        // Refused while the others move.
        (1100, news(fast, &[])),
        (1110, news(strange, &[])),
        (2000, news(1, &[])),
    ];
    let (ends, told, columns) = run(script, 6);
    use GoalEnd::{Done, Refused};
    assert_eq!(ends, [Done, Done, Refused, Refused, Done, Refused]);
    assert!((columns[0] - 0.1).abs() < 1e-9 && (columns[1] - 0.1).abs() < 1e-9, "{columns:?}");
    let refusals: Vec<_> =
        told.iter().filter(|state| state.refusal != 0).map(|state| (state.taken, state.refusal)).collect();
    // Each of them as often as something else changed meanwhile.
    let mut once = refusals.clone();
    once.dedup();
    assert_eq!(once, [(fast, refusal::SHARED), (strange, refusal::NOT_OFFERED)]);
    let last = told.iter().rev().find(|state| state.taken == strange).expect("told");
    assert_eq!(
        (last.ended(both), last.ended(one)),
        (Some(true), Some(false)),
        "another one took the place of the first"
    );
}

#[test]
fn a_goal_is_cancelled_replaced_or_as_old_as_the_program() {
    let files = [goal(&[("left", 0.4)], 2.0), goal(&[("left", -0.4)], 2.0), goal(&[("left", 0.2)], 2.0)];
    let files = files.map(|goal| GoalFile::write(&goal).expect("written"));
    let [old, first, second] = files.each_ref().map(GoalFile::number);
    let script = vec![
        (0, news(old, &[])),
        (50, news(first, &[])),
        (300, news(second, &[first])),
        (500, news(second, &[second])),
    ];
    let (ends, told, columns) = run(script, 2);
    // The cancellation of one that is replaced in the same step is no cancellation of the other.
    assert_eq!(ends, [GoalEnd::Replaced, GoalEnd::Cancelled]);
    assert!(told.iter().any(|state| (state.taken, state.refusal) == (old, refusal::OLD)), "{told:?}");
    assert!(columns[0].abs() < 0.19 && columns[0] != 0.0, "{columns:?}");
}
