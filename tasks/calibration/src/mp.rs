//! The task as a program: Move both arms to a posture, Wait until both theodolites have sighted, and so on.

use core::cell::RefCell;
use core::time::Duration;
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc_generators::generators::{ConstantOrder, Settle, SmoothJointMove};
use mrroc_generators::jerk::JointLimits;
use mrroc_robots::{Irp6, Six};

use crate::drives::{Believed, Shared};
use crate::estimate::{Sight as Found, Sighted, Sights};
use crate::scene::{ARMS, BALLS, BAR_SIGHTS, BARS, MUTUAL_SIGHTS, NAMES, SETS, Scene};
use crate::sensor::{Sight, Sighting, Simulated};
use crate::theodolite::mean;
use crate::visits::Visit;

/// Sights of one target: each set in both faces.
const FACES: usize = 2 * SETS;

/// Where the arms are to go: the number of a posture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Payload)]
pub enum Go {
    /// The posture of this number.
    Posture(u32),
}

/// Both theodolites have sighted what they were told: what was read, and what the encoders read on the mean.
#[derive(Default)]
pub struct Measured {
    read: [Option<[f64; 2]>; 2],
    sum: [Six; ARMS],
    steps: f64,
}

#[condition(mp)]
fn measured(c: &mut Measured, e: &State<(Irp6, Irp6)>, v: &Reading<(Sighting, Sighting)>) -> bool {
    c.sum[0] += e.0.measured().joints;
    c.sum[1] += e.1.measured().joints;
    c.steps += 1.0;
    let (Some(north), Some(south)) = (v.0.reading(), v.1.reading()) else { return false };
    c.read = [north, south].map(|one| (!one.blocked).then_some([one.hz, one.v]));
    north.settled && south.settled
}

/// The coordinator's program: makes all visits, has masses hung on the flanges by `hang` \[kg\], and writes what was sighted into `sights`.
///
/// # Errors
/// The first fault of the cell.
pub fn coordinate(
    mp: &mut Mp,
    visits: &[Visit],
    hang: &dyn Fn(f64),
    sights: &RefCell<Sights>,
) -> Result<(), Fault> {
    let (mut left, mut right) = (mp.robot::<Irp6>(NAMES[0])?, mp.robot::<Irp6>(NAMES[1])?);
    let (mut north, mut south) = (mp.sensor::<Sighting>("north")?, mp.sensor::<Sighting>("south")?);
    let mut all_faces = |mp: &mut Mp, left: &mut _, right: &mut _, of: &dyn Fn(u32) -> Sight| {
        let mut faces = [(); FACES].map(|()| Measured::default());
        for (face, measured) in (0..).zip(&mut faces) {
            north.configure(of(face));
            south.configure(of(face));
            *measured =
                mp.wait_until((&mut *left, &mut *right), (&mut north, &mut south), Measured::default())?;
        }
        Ok::<_, Fault>(faces)
    };
    for _ in 0..MUTUAL_SIGHTS {
        let faces = all_faces(mp, &mut left, &mut right, &|face| Sight::Other { face })?;
        note(sights, &faces, &Sighted::Other);
    }
    for bar in 0..BARS {
        for _ in 0..BAR_SIGHTS {
            for end in 0..2 {
                let order = |face| Sight::End { bar: bar as u32, end, face };
                let faces = all_faces(mp, &mut left, &mut right, &order)?;
                note(sights, &faces, &Sighted::End { bar, end: end as usize });
            }
        }
    }
    for (visit, made) in (0..).zip(visits) {
        hang(made.payload);
        let order = ConstantOrder::<(Irp6, Irp6), Go>::to_all(Go::Posture(visit));
        mp.move_robots((&mut left, &mut right), (), order)?;
        let mut stood = Measured::default();
        for arm in 0..ARMS {
            for ball in 0..BALLS.len() {
                let order = |face| Sight::Ball { arm: arm as u32, ball: ball as u32, face };
                let faces = all_faces(mp, &mut left, &mut right, &order)?;
                for face in &faces {
                    stood.steps += face.steps;
                    stood.sum = core::array::from_fn(|arm| stood.sum[arm] + face.sum[arm]);
                }
                note(sights, &faces, &Sighted::Ball { arm, ball, posture: visit as usize });
            }
        }
        // An encoder reads whole pulses, and a regulator may go to and fro between two: the mean is finer.
        let mut sights = sights.borrow_mut();
        for (arm, sum) in stood.sum.into_iter().enumerate() {
            sights.postures[arm].push(sum / stood.steps);
            sights.payloads[arm].push(made.payload);
        }
    }
    Ok(())
}

/// Notes the mean of all faces of each theodolite that saw the target in all.
fn note(sights: &RefCell<Sights>, faces: &[Measured; FACES], of: &Sighted) {
    for theodolite in 0..2 {
        let read: Option<Vec<[f64; 2]>> = faces.iter().map(|face| face.read[theodolite]).collect();
        if let Some(read) = read {
            sights.borrow_mut().sights.push(Found { theodolite, of: of.clone(), read: mean(read) });
        }
    }
}

/// An arm's program: goes to the posture that is ordered, and stands.
///
/// # Errors
/// The first fault of the cell.
pub fn arm(ecp: &mut Ecp<Irp6>, postures: &[Six]) -> Result<(), Fault> {
    let limits =
        JointLimits { velocity: Six::repeat(0.4), acceleration: Six::repeat(0.6), jerk: Six::repeat(4.0) };
    ecp.serve_all(|ecp, Go::Posture(number): Go| {
        let goal = postures.get(number as usize).copied();
        let goal = goal.ok_or_else(|| Fault::thrown("there is no posture of this number"))?;
        ecp.move_robot((), SmoothJointMove::to(goal, limits))?;
        ecp.move_robot((), Settle::within(Six::repeat(2e-4), 0.3, 10.0)).map(drop)
    })
}

/// Puts the cell together and runs it: what was sighted, and how long it took on the cell's clock.
///
/// # Errors
/// The first cause when it ends with a fault.
pub fn run(
    scene: Scene,
    visits: &[Visit],
    pointing: Duration,
) -> Result<(Sights, Duration, Shared), CellError> {
    run_telling(scene, visits, pointing, |_| {})
}

/// The same; `tell` is told which visit begins, from 1.
///
/// # Errors
/// The first cause when it ends with a fault.
pub fn run_telling(
    scene: Scene,
    visits: &[Visit],
    pointing: Duration,
    tell: impl Fn(usize) + 'static,
) -> Result<(Sights, Duration, Shared), CellError> {
    let start = visits.first().map_or([Six::zeros(); ARMS], |visit| visit.both);
    let shared = Shared::new(scene, &start);
    let bases = crate::scene::believed_bases();
    let step = Duration::from_millis(2);
    let mut cell = Cell::new(step);
    for (arm, name) in NAMES.iter().enumerate() {
        let drives = Believed::new(arm, &start[arm], shared.clone());
        let postures: Vec<Six> = visits.iter().map(|visit| visit.both[arm]).collect();
        let setup = RobotSetup::new(name, Irp6::nominal().with_base(bases[arm]), drives);
        cell = cell.robot(setup.program(move |ecp| self::arm(ecp, &postures)));
    }
    let steps = u64::try_from(pointing.as_millis() / step.as_millis()).unwrap_or(u64::MAX);
    for (which, name) in ["north", "south"].into_iter().enumerate() {
        cell = cell.sensor(SensorSetup::new(name, Simulated::new(which, shared.clone(), steps)));
    }
    let sights = Rc::new(RefCell::new(Sights::default()));
    let (own, all, plant) = (Rc::clone(&sights), visits.to_vec(), shared.clone());
    // A person does it while the arms stand.
    let made = core::cell::Cell::new(0);
    let hang = move |mass: f64| {
        plant.scene.borrow_mut().payload = [mass; ARMS];
        made.set(made.get() + 1);
        tell(made.get());
    };
    let report = cell.program(move |mp: &mut Mp| coordinate(mp, &all, &hang, &own)).run()?;
    shared.scene.borrow_mut().payload = [0.0; ARMS];
    let sights = sights.borrow().clone();
    Ok((sights, report.time, shared))
}
