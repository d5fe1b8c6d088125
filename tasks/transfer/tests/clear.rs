//! The arms keep clear of each other and of the table.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::robot::RobotView;
use mrroc_robots::clearance::{Clearance, DryRun};
use mrroc_robots::{Polycrank, Rnt};
use nalgebra::Vector3;
use transfer::clear::{Around, BRAKING, EVERY, FASTEST, MARGINS, Margins, SINKING, STOP, clearance, guard};
use transfer::variant::{Bases, Sensors, Variant};
use transfer::{cell, file, mp, plant};

/// The step of the cell [s].
const STEP: f64 = 2e-3;

#[test]
fn a_dry_run_of_the_whole_program_finds_nothing_nearer_than_the_margins() {
    let file = file().expect("in order");
    for (around, margin) in [(Around::Nothing, MARGINS.arms), (Around::Table, MARGINS.table)] {
        let dry_run = Rc::new(RefCell::new(DryRun::new(clearance(&file, around).expect("in order"))));
        let watching = Rc::clone(&dry_run);
        let cell = cell(&file, &plant::drives()).expect("in order").program(mp::coordinate);
        cell.watch(move |robot| watching.borrow_mut().observe(robot)).run().expect("within all limits");
        let mut dry_run = dry_run.borrow_mut();
        let closest = dry_run.closest().expect("checked").expect("both arms were seen");
        let [a, b] = &closest.nearest.sides;
        println!("{a} and {b} are {:.3} m apart at {:.2} s", closest.nearest.distance, closest.time);
        assert!(closest.nearest.distance > margin, "{closest:?}");
    }
}

#[test]
fn arms_that_come_too_near_are_stopped_with_the_names_of_what_was_near() {
    let file = file().expect("in order");
    // They come to less than 0.1 m from the table, and to less than 0.4 m from each other.
    for (margins, near) in [
        (Margins { table: 0.1, ..MARGINS }, "wrist and table"),
        (Margins { arms: 0.4, ..MARGINS }, "rnt tool and polycrank tool"),
    ] {
        let wide = guard(&file, margins).expect("in order");
        let cell =
            cell(&file, &plant::drives()).expect("in order").program(mp::coordinate).guard(EVERY, wide);
        let Err(CellError::Fault(fault)) = cell.run() else { panic!("they come nearer than {margins:?}") };
        assert_eq!(fault.kind(), FaultKind::ProtectiveStop, "{fault}");
        assert!(fault.to_string().contains(near), "{fault}");
        // What is compared is the distance until the cell stands; beyond it nothing must be left.
        let distance = if margins.table == MARGINS.table { margins.arms } else { margins.table };
        let text = format!("{:.1} mm to stop, 0.0 mm to be left", 1e3 * distance);
        assert!(fault.to_string().contains(&text), "{fault}");
    }
}

/// The ends of the axes of all links, RNT's and Polycrank's.
type Ends = [Vec<Vector3<f64>>; 2];

/// Where the clearance saw them last.
fn ends(clearance: &Clearance) -> Ends {
    let mut ends = Ends::default();
    clearance.capsules(&mut |robot, _, capsule| ends[usize::from(robot != "rnt")].extend(capsule.ends));
    ends
}

/// The largest displacement of a link of each arm [m]: no point of a straight axis goes farther than one of its ends.
fn displacements(from: &Ends, to: &Ends) -> [f64; 2] {
    [0, 1].map(|arm| {
        let both = from[arm].iter().zip(&to[arm]);
        both.map(|(from, to)| (to - from).norm()).fold(0.0, f64::max)
    })
}

/// What the margins rest on.
#[derive(Debug, Default)]
struct Fast {
    /// The largest speed of a link of each arm [m/s].
    links: [f64; 2],
    /// The step in which Polycrank's was.
    step: usize,
    /// The largest speed of a link downwards [m/s].
    down: f64,
    /// The largest v/a of a joint [s].
    braking: f64,
    last: Option<Ends>,
    looks: usize,
}

impl Fast {
    fn see(&mut self, clearance: &mut Clearance, robots: &[RobotView]) -> Result<(), Fault> {
        clearance.nearest(robots)?;
        let now = ends(clearance);
        if let Some(last) = self.last.take() {
            let links = displacements(&last, &now).map(|distance| distance / STEP);
            if links[1] > self.links[1] {
                self.step = self.looks;
            }
            self.links = [0, 1].map(|arm| self.links[arm].max(links[arm]));
            let drops = last.iter().flatten().zip(now.iter().flatten()).map(|(last, now)| last.z - now.z);
            self.down = drops.fold(self.down, |down, drop| down.max(drop / STEP));
        }
        for robot in robots {
            let brakes: Vec<f64> = match robot.name.as_str() {
                "rnt" => Rnt::new().limits().acceleration.iter().copied().collect(),
                "polycrank" => Polycrank::new().limits().acceleration.iter().copied().collect(),
                _ => continue,
            };
            let times = brakes.iter().zip(robot.demanded.velocity.iter()).map(|(a, v)| v.abs() / a);
            self.braking = times.fold(self.braking, f64::max);
        }
        self.last = Some(now);
        self.looks += 1;
        Ok(())
    }

    /// Of a run of a variant.
    fn of(variant: Variant) -> Fast {
        let file = file().expect("in order");
        let fast = Rc::new(RefCell::new(Fast::default()));
        let seen = Rc::clone(&fast);
        let mut clearance = clearance(&file, Around::Nothing).expect("in order");
        let cell = variant.ready(&file).expect("in order").cell;
        let cell = cell.guard(1, move |robots| seen.borrow_mut().see(&mut clearance, robots));
        cell.run().expect("within all limits");
        fast.take()
    }
}

#[test]
fn no_link_is_faster_than_the_margins_have_it_and_none_much_slower() {
    for variant in [Variant::Empty, Variant::Bar { bases: Bases::Off, sensors: Sensors::Used }] {
        let Fast { links, down, braking, .. } = Fast::of(variant);
        println!("{links:.4?} m/s, down {down:.4} m/s, {braking:.3} s to brake");
        for (seen, figure) in links.into_iter().zip(FASTEST).chain([(down, SINKING), (braking, BRAKING)]) {
            assert!(seen <= figure && seen > 0.9 * figure, "{seen}, taken for {figure}");
        }
    }
}

#[test]
fn stopped_where_links_are_fastest_the_arms_stand_apart_and_within_the_margin() {
    let file = file().expect("in order");
    let fastest = Fast::of(Variant::Empty).step;
    // From this step on all is too near: the look at the arms comes at the worst time, 20 steps later.
    let mut guard = guard(&file, Margins { arms: 10.0, table: 0.0 }).expect("in order");
    let seen = Rc::new(RefCell::new(None));
    let began = Rc::clone(&seen);
    let mut looking = clearance(&file, Around::Nothing).expect("in order");
    let mut step = 0;
    let joints = Rc::new(RefCell::new([[0.0; 7]; 2]));
    let last = Rc::clone(&joints);
    let outcome = cell(&file, &plant::drives())
        .expect("in order")
        .program(mp::coordinate)
        .guard(1, move |robots| {
            if step == fastest {
                let distance = looking.nearest(robots)?.distance;
                *began.borrow_mut() = Some((distance, ends(&looking)));
            }
            let since = step.saturating_sub(fastest);
            step += 1;
            if since == EVERY as usize || since == 2 * EVERY as usize { guard(robots) } else { Ok(()) }
        })
        .watch(move |robot| {
            if let Some(arm) = ["rnt", "polycrank"].iter().position(|name| *name == robot.robot) {
                last.borrow_mut()[arm][..robot.demanded.len()].copy_from_slice(robot.demanded);
            }
        })
        .run();
    let Err(CellError::Fault(fault)) = outcome else { panic!("the guard stops the cell") };
    assert_eq!(fault.kind(), FaultKind::ProtectiveStop, "{fault}");
    let (distance, from) = seen.take().expect("the step was reached");
    let mut clearance = clearance(&file, Around::Nothing).expect("in order");
    let joints = joints.borrow();
    let stand = clearance.nearest_at(&[&joints[0][..6], &joints[1]]).expect("a posture").distance;
    let distances = displacements(&from, &ends(&clearance));
    println!("{distance:.3} m apart, {stand:.3} m at standstill, links have gone {distances:.3?} m");
    assert!(stand > 0.0 && stand >= distance - MARGINS.arms, "{stand}");
    assert!(distances[0] <= FASTEST[0] * STOP && distances[1] <= FASTEST[1] * STOP, "{distances:?}");
    // It was on its way: 40 ms alone are a fifteenth of the time.
    assert!(distances[1] > 0.04 * 0.9 * FASTEST[1], "{distances:?}");
}
