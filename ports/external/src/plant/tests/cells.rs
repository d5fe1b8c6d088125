//! Whole cells under the virtual clock.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use super::simulator::{Simulator, follow};
use super::{Folder, MOTION, two_arms};
use crate::plant::message::PlantRequest;

/// What each arm was told, and where it was, in each servo period of a run: the column of `left`, and that of `right`.
#[derive(Clone, Debug, Default, PartialEq)]
struct Seen(Vec<(String, u64, u64)>);

impl Seen {
    fn of(&self, robot: &str) -> Vec<(f64, f64)> {
        let of = self.0.iter().filter(|(name, ..)| name == robot);
        of.map(|&(_, demanded, measured)| (f64::from_bits(demanded), f64::from_bits(measured))).collect()
    }
}

/// Runs the two arms in a simulator that takes so long for every twentieth period.
fn run(folder: &Folder, nap: Duration) -> (Seen, u64) {
    let simulator = Simulator::answering(&folder.0, &["left", "right"], move |_, order, state| {
        if order.period % 20 == 7 {
            std::thread::sleep(nap);
        }
        Some(state)
    });
    let seen = Rc::new(RefCell::new(Seen::default()));
    let into = Rc::clone(&seen);
    let cell = folder.cell(&two_arms("")).watch(move |robot| {
        let column = |joints: &[f64]| joints[0].to_bits();
        let told = (robot.robot.to_owned(), column(robot.demanded), column(robot.measured));
        into.borrow_mut().0.push(told);
    });
    let report = cell.run().expect("a run without faults");
    let periods = simulator.end();
    let both: Vec<_> = periods.iter().filter(|(_, asked)| asked.len() == 2).collect();
    assert!(both.iter().zip(0..).all(|((period, _), i)| *period == i), "no period is left out");
    assert!(periods.iter().all(|(_, asked)| asked.values().all(|&kind| kind == PlantRequest::Follow as u32)));
    (seen.take(), report.steps)
}

#[test]
fn two_arms_in_one_simulator_follow_its_equations_and_run_the_same_twice_however_long_it_takes() {
    let (first, steps) = run(&Folder::new("once"), Duration::ZERO);
    assert!(steps as u128 >= MOTION.as_millis() / 2);
    for (robot, end) in [("left", 0.2), ("right", -0.2)] {
        let seen = first.of(robot);
        // What is measured in a period is the state at the end of the one before: x' = x + SHARE (demanded - x).
        let start = seen[0].1;
        let (mut at, mut last) = (start, start);
        for (i, &(demanded, measured)) in seen.iter().enumerate() {
            assert_eq!(
                measured.to_bits(),
                f64::to_bits(at),
                "{robot} in period {i}: {measured} {at} {:?}",
                &seen[i.saturating_sub(3)..i + 2]
            );
            at = follow(at, demanded);
            last = demanded;
        }
        assert!(seen.len() as u64 >= steps - 1, "{} of {steps}", seen.len());
        assert!((last - start - end).abs() < 1e-12, "{robot}: {last}");
    }
    let (second, again) = run(&Folder::new("twice"), Duration::from_millis(3));
    assert_eq!(steps, again);
    assert!(first == second, "the same to the bit");
}

#[test]
fn a_dry_run_needs_no_simulator() {
    let folder = Folder::new("dry");
    let cell = folder.cell(&two_arms(""));
    assert_eq!(
        cell.hardware(),
        ["robot left in the simulator at port world", "robot right in the simulator at port world"]
    );
    let cell = cell.simulated().expect("their own simulated drives stand in");
    assert!(cell.hardware().is_empty());
    cell.run().expect("a run without faults");
    assert!(!folder.0.exists(), "no port was opened");
}

#[test]
fn the_module_for_python_has_the_robots_of_the_simulator() {
    let folder = Folder::new("python");
    let cell = folder.cell(&two_arms(""));
    let module = cell.python("right").expect("a simulator of others");
    for line in ["PORT = \"world\"", "ROBOTS = (\"left\", \"right\",)", "external left", "def _hash(text"] {
        assert!(module.contains(line), "{line}: {module}");
    }
    let blank = module.lines().find(|line| line.contains('@') && !line.contains("@static"));
    assert_eq!(blank, None, "a blank that was not filled");
}
