//! Simulated drives that do not know where they are find out, from anywhere, and exactly.

use mrroc::fault::Excess;
use mrroc::random::Random;
use mrroc::robot::{DriveFault, Driver, Homing, Search};
use mrroc_launch::cell_file::CellFile;
use mrroc_robots::{
    Conveyor, Driven, Five, Gripper, Irp6, Irp6FiveDof, Irp6Track, Kinematics, One, Polycrank, Rnt, Serial,
    Seven, Simulated, Six, Unhomed, homing_conformance, simulated,
};
use nalgebra::SVector;

use crate::support::engraving;

fn home<const N: usize, R: Driven<N>>(mut homing: Unhomed<R, N>) -> Result<Simulated<R, N>, DriveFault> {
    loop {
        match homing.search()? {
            Search::Searching(on) => homing = on,
            Search::Found(drives) => return Ok(drives),
        }
    }
}

fn jammed<const N: usize, R: Driven<N>>(robot: R, q: &SVector<f64, N>, joint: usize) -> Unhomed<R, N> {
    let mut homing = Unhomed::new(robot, q);
    homing.block(joint);
    homing
}

fn five() -> Five {
    Five::new(0.3, -1.6, 0.1, 0.2, 1.0)
}

fn tracked() -> Seven {
    let arm = engraving();
    Seven::from_fn(|i, _| if i == 0 { 0.5 } else { arm[i - 1] })
}

fn drawn() -> Six {
    Six::new(0.1, 0.5, 0.55, 0.2, 1.3, 0.3)
}

fn bent() -> Seven {
    Seven::from([0.3, 0.2, -0.4, 0.5, 0.1, -0.3, 0.2])
}

fn weighted() -> Serial<6> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/urdf/weighted_arm.urdf");
    Serial::<6>::from_urdf_file(path, "base_link", "tool0")
        .and_then(|robot| robot.with_acceleration(SVector::repeat(10.0)))
        .expect("sound")
}

homing_conformance!(
    irp6,
    Irp6::nominal(),
    |q| Unhomed::new(Irp6::nominal(), q),
    [engraving(), Six::new(2.0, -1.4, 0.2, -0.5, 1.0, -2.0)],
    |joint| jammed(Irp6::nominal(), &engraving(), joint)
);
homing_conformance!(
    irp6_calibrated,
    Irp6::calibrated(),
    |q| Unhomed::new(Irp6::calibrated(), q),
    [engraving(), Six::new(-2.0, -1.4, 0.2, 0.0, 0.0, 2.0)],
    |joint| jammed(Irp6::calibrated(), &engraving(), joint)
);
homing_conformance!(
    irp6_5dof,
    Irp6FiveDof::nominal(),
    |q| Unhomed::new(Irp6FiveDof::nominal(), q),
    [five(), -five() + Five::new(0.0, -3.1, 0.0, 0.0, 0.0)],
    |joint| jammed(Irp6FiveDof::nominal(), &five(), joint)
);
homing_conformance!(
    irp6_track,
    Irp6Track::nominal(),
    |q| Unhomed::new(Irp6Track::nominal(), q),
    [tracked(), tracked() + Seven::from([-0.6, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0])],
    |joint| jammed(Irp6Track::nominal(), &tracked(), joint)
);
homing_conformance!(
    rnt,
    Rnt::new(),
    |q| Unhomed::new(Rnt::new(), q),
    [drawn(), Six::new(-0.5, 0.49, 0.56, -1.0, -0.5, 2.0)],
    |joint| jammed(Rnt::new(), &drawn(), joint)
);
homing_conformance!(
    polycrank,
    Polycrank::new(),
    |q| Unhomed::new(Polycrank::new(), q),
    [bent(), -bent()],
    |joint| jammed(Polycrank::new(), &bent(), joint)
);
homing_conformance!(
    conveyor,
    Conveyor::new(),
    |q| Unhomed::new(Conveyor::new(), q),
    [One::new(0.3), One::new(-0.1)],
    |joint| jammed(Conveyor::new(), &One::new(0.3), joint)
);
homing_conformance!(
    gripper,
    Gripper::new(),
    |q| Unhomed::new(Gripper::new(), q),
    [One::new(0.06), One::new(0.09)],
    |joint| jammed(Gripper::new(), &One::new(0.06), joint)
);
homing_conformance!(
    weighted_arm,
    weighted(),
    |q| Unhomed::new(weighted(), q),
    [Six::from([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]), Six::from([-1.0, -0.5, 0.5, -2.0, -1.0, 3.0])],
    |joint| jammed(weighted(), &Six::from([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]), joint)
);

/// The truth at rest and what is measured there differ by less than a pulse of each motor.
fn found_is_true<const N: usize, R: Driven<N>>(robot: &R, start: &SVector<f64, N>) {
    let homing = Unhomed::new(robot.clone(), start);
    let shaft = homing.shaft();
    let drives = home(homing).unwrap_or_else(|fault| panic!("from {start}: {fault}"));
    let (truth, measured) = (
        robot.motors(&shaft.state().position),
        robot.motors(&drives.measured().expect("simulated").position),
    );
    for (i, data) in robot.motor_data().iter().enumerate() {
        let off = (truth[i] - measured[i]).abs();
        assert!(off <= data.encoder.pulse() * (1.0 + 1e-6), "motor {i}: {off} rad off from {start}");
    }
}

#[test]
fn two_hundred_arms_find_where_they_truly_are() {
    let robot = Irp6::nominal();
    let limits = *mrroc::robot::Robot::limits(&robot);
    let mut random = Random::seeded(20_080_131);
    let mut starts = 0;
    while starts < 200 {
        let q = Six::from_fn(|i, _| random.between(limits.lower[i], limits.upper[i]));
        if robot.is_attainable(&q) {
            found_is_true(&robot, &q);
            starts += 1;
        }
    }
}

#[test]
fn marks_between_two_pulses_are_found_to_one() {
    // Its marks are no multiples of a pulse.
    found_is_true(&Irp6::calibrated(), &engraving());
    found_is_true(&Rnt::new(), &drawn());
    found_is_true(&weighted(), &Six::repeat(0.2));
    found_is_true(&Gripper::new(), &One::new(0.06));
}

#[test]
fn marks_are_where_mrroc_has_its_synchronisation_positions() {
    let motors = |q: &Six| Irp6::nominal().motors(q);
    let nominal = Six::new(-15.9, -5.0, -8.527, 151.31, 435.25, 791.0);
    assert_eq!(Irp6::nominal().marks(), nominal);
    // The arm ends a little above them, and stands.
    let drives = home(Unhomed::new(Irp6::nominal(), &engraving())).expect("found");
    let above = motors(&drives.measured().expect("simulated").position) - nominal;
    assert!(above.iter().all(|above| (0.0..0.2).contains(above)), "{above}");
    let track = Seven::from([0.0, -10.819, -4.012, -6.219, 158.997, 479.5, 769.7]);
    assert_eq!(Irp6Track::nominal().marks(), track);
}

#[test]
fn a_switch_that_never_closes_ends_the_search_at_the_motors_range() {
    for joint in [0, 3] {
        let mut homing = Unhomed::new(Irp6::nominal(), &engraving());
        homing.cut_switch(joint);
        let fault = home(homing).expect_err("there is no switch");
        let range = (Irp6::MOTOR_UPPER - Irp6::MOTOR_LOWER)[joint];
        assert_eq!((fault.joint(), fault.what()), (Some(joint), "distance to the synchronisation switch"));
        let Excess { actual, limit, .. } = fault.excess().expect("a distance and its limit");
        assert!(limit == range && actual > range && actual < range + 0.1, "{fault}");
    }
}

fn cell(homed: &str) -> CellFile {
    let text = format!(
        "step_ms = 2\n[robots.arm]\nkind = \"irp6\"\nstart = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]\nhomed = {homed}\n"
    );
    CellFile::parse("cell.toml", &text).expect("well-formed")
}

#[test]
fn a_cell_file_asks_for_homing() {
    let began = |homed: &str| {
        let begin = std::rc::Rc::new(std::cell::Cell::new((0, Six::zeros())));
        let seen = std::rc::Rc::clone(&begin);
        cell(homed)
            .cell(&simulated())
            .expect("known")
            .program(move |mp| {
                let mut arm = mp.robot::<Irp6>("arm")?;
                let step = mp.step();
                mp.wait_until((&mut arm,), (), at_once {})?;
                seen.set((step, arm.measured().joints));
                Ok(())
            })
            .run()
            .expect("runs");
        begin.get()
    };
    let (early, there) = began("true");
    assert!(early < 3 && (there - Irp6::READY).amax() < 1e-4);
    let (late, there) = began("false");
    // The N motor alone goes some hundred rad at 15 rad/s.
    assert!(late > 10_000, "step {late}");
    let above = Irp6::nominal().motors(&there) - Irp6::nominal().marks();
    assert!(above.iter().all(|above| (0.0..0.2).contains(above)), "{above}");
}

#[mrroc::condition(mp)]
fn at_once() -> bool {
    true
}
