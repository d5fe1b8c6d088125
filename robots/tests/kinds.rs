//! The kinds of robots that a `cell.toml` may name: each runs in a cell made of such a file, or is refused there.

use std::f64::consts::TAU;

use mrroc::prelude::*;
use mrroc::robot::{JointKind, JointVector};
use mrroc_launch::cell_file::CellFile;
use mrroc_robots::{
    Conveyor, Gripper, Irp6, Irp6FiveDof, Irp6Track, Kinematics, Polycrank, Rnt, Seven, Six, simulated,
};

const DURATION: f64 = 2.0;

/// Moves all joints a little, there and back; the speed begins and ends with zero.
#[derive(Clone)]
struct Wave<R: Robot> {
    start: R::Joints,
    size: R::Joints,
    t: f64,
}

impl<R: Robot> Wave<R> {
    /// About `start`, by 0.02 rad or 2 mm, which is within half of every robot's limits.
    fn about(robot: &R, start: R::Joints) -> Self {
        let size = R::Joints::from_joints(|i| match robot.joint(i) {
            JointKind::Revolute => 0.02,
            JointKind::Prismatic => 0.002,
        });
        Wave { start, size, t: 0.0 }
    }
}

#[generator(mp, first = begin)]
fn wave<R: Robot>(c: &mut Wave<R>, t: Tick) -> Step<(R,)> {
    if c.t >= DURATION {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(DURATION);
    let part = 0.5 * (1.0 - (TAU * c.t / DURATION).cos());
    Step::Next((Demand::joints(c.start + c.size * part),))
}

fn begin<R: Robot>(c: &mut Wave<R>, e: &State<(R,)>, t: Tick) -> Step<(R,)> {
    c.start = e.0.demanded().joints;
    wave(c, t)
}

fn file(kind: &str, start: &[f64]) -> CellFile {
    file_with(kind, start, "")
}

/// The same with a line more.
fn file_with(kind: &str, start: &[f64], line: &str) -> CellFile {
    let text = format!(
        "step_ms = 2\nstop_ms = 5000\n[robots.a]\nkind = \"{kind}\"\nstart = {start:?}\nbase = {{ xyz = [0.1, -0.2, 0.3], zyz = [0.4, 0.5, 0.6] }}\n{line}\n"
    );
    CellFile::parse("cell.toml", &text).expect("well-formed")
}

/// `robot` is what the kind is expected to be: it must hold its start, and its drives must follow the wave.
fn waves<const N: usize, R: Kinematics<N>>(kind: &str, robot: &R, start: [f64; N]) {
    for line in ["", "coupled = true"] {
        waves_in(&file_with(kind, &start, line), kind, robot, start);
    }
}

fn waves_in<const N: usize, R: Kinematics<N>>(file: &CellFile, kind: &str, robot: &R, start: [f64; N]) {
    let start = nalgebra::SVector::from(start);
    let wave = Wave::about(robot, start);
    let base = file.robots()[0].base();
    let expected = base * robot.forward(&start);
    let report = file
        .cell(&simulated())
        .unwrap_or_else(|why| panic!("{kind}: {why}"))
        .program(move |mp| {
            let mut robot = mp.robot::<R>("a")?;
            mp.move_robots((&mut robot,), (), wave.clone())?;
            let (measured, flange) = (robot.measured().joints, robot.demanded().pose);
            assert!((measured - start).amax() < 1e-3, "{measured}");
            let off = flange.translation.vector - expected.translation.vector;
            // It begins where the encoders are, a pulse from the start.
            assert!(off.norm() < 1e-4 && flange.rotation.angle_to(&expected.rotation) < 1e-3, "{off}");
            Ok(())
        })
        .run()
        .unwrap_or_else(|why| panic!("{kind}: {why}"));
    assert!((report.time.as_secs_f64() - DURATION).abs() < 0.05, "{kind}: {:?}", report.time);
}

const ARM: [f64; 6] = Irp6::READY.data.0[0];

#[test]
fn every_kind_moves_in_a_cell_made_of_its_file_with_its_motors_coupled_too() {
    waves("irp6", &Irp6::nominal(), ARM);
    waves("irp6-calibrated", &Irp6::calibrated(), ARM);
    waves("irp6-5dof", &Irp6FiveDof::nominal(), [0.0, -1.57, 0.16, 0.6, 1.0]);
    waves("irp6-track", &Irp6Track::nominal(), [0.5, 0.0, -1.57, 0.16, -0.16, 4.71, 0.0]);
    waves("rnt", &Rnt::new(), [0.0, 0.5, 0.55, 0.0, 1.3, 0.0]);
    waves("polycrank", &Polycrank::new(), [0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2]);
    waves("gripper", &Gripper::new(), [0.07]);
    waves("conveyor", &Conveyor::new(), [0.0]);
}

fn refusal(kind: &str, start: &[f64]) -> String {
    match file(kind, start).cell(&simulated()) {
        Ok(_) => panic!("{kind} takes {start:?}"),
        Err(why) => why.to_string(),
    }
}

/// Their joints keep the joint limits, but not those that joints share.
#[test]
fn a_start_that_the_drives_cannot_take_is_refused_where_it_stands() {
    let start = [0.0, -0.9, -0.4, -1.5, 4.71, 0.0];
    let limits = *Irp6::nominal().limits();
    let q = Six::from(start);
    assert!((0..6).all(|i| (limits.lower[i]..=limits.upper[i]).contains(&q[i])));
    assert!(!Irp6::nominal().is_feasible(&q));
    let on_track = Seven::from_fn(|i, _| if i == 0 { 0.5 } else { start[i - 1] });
    let five = [0.0, -0.9, -0.4, -1.5, 1.0];
    // Both actuators far out: the linkage is beyond its dead centre.
    let stretched = [0.0, 0.64, 0.6, 0.0, 1.3, 0.0];
    assert!(!Rnt::new().is_attainable(&Six::from(stretched)));
    for (kind, start, told) in [
        ("irp6", &start[..], "angle of the motor"),
        ("irp6-calibrated", &start[..], "angle of the motor"),
        ("irp6-5dof", &five[..], "angle of the motor"),
        ("irp6-track", on_track.as_slice(), "angle of the motor"),
        ("rnt", &stretched[..], "transmission angle"),
    ] {
        let why = refusal(kind, start);
        assert!(
            why.starts_with("cell.toml:5:9: the drives cannot take this `start`: joint "),
            "{kind}: {why}"
        );
        assert!(why.contains(told) && why.contains("such as ["), "{kind}: {why}");
        println!("{why}");
    }
}

#[test]
fn a_missing_start_is_asked_for_with_the_units_of_its_joints() {
    let text = "step_ms = 2\n[robots.a]\nkind = \"irp6-track\"\n";
    let file = CellFile::parse("cell.toml", text).expect("well-formed");
    let Err(why) = file.cell(&simulated()) else { panic!("there is no start") };
    assert!(why.to_string().contains("write start = [..], 7 joint positions [m, rad]"), "{why}");
}
