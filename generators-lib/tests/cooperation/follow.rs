//! Two arms that hold one body along a joint trajectory of others: in a cancellation, a suspension and an operator's stop their tools keep their relative pose.

use std::sync::OnceLock;

use mrroc::operator::Operator;
use mrroc::prelude::*;
use mrroc_generators::trajectory::{JointBounds, JointTrajectory, Outcome, TrajectoryGroup, TrajectoryPoint};
use mrroc_robots::Irp6;
use nalgebra::Vector3;

use super::kit::{STEP, apart, arm, irp6_facing, irp6_start, relative_error};

const NAMES: [&str; 2] = ["left", "right"];

fn arms() -> [Irp6; 2] {
    [irp6_facing(1.1, 0.0), irp6_facing(1.1, 2.5)]
}

/// Where a body goes that both arms hold, as joint positions of both every 10 ms, by their inverse kinematics: what another program would have planned.
fn carried() -> &'static JointTrajectory {
    static CARRIED: OnceLock<JointTrajectory> = OnceLock::new();
    CARRIED.get_or_init(|| {
        let arms = arms();
        let held = arms.each_ref().map(|arm| arm.forward(&irp6_start()));
        let mut joints = [irp6_start(); 2];
        let count = 200;
        let points = (0..=count).map(|k| {
            let s = f64::from(k) / f64::from(count);
            let s = s.powi(3) * (10.0 + s * (6.0 * s - 15.0));
            let by = Pose::new(Vector3::new(0.02, 0.05, 0.09) * s, Vector3::new(0.1, 0.05, 0.3) * s);
            for i in 0..2 {
                joints[i] = arms[i].inverse(&(by * held[i]), &joints[i]).expect("in reach");
            }
            let positions = joints.iter().flat_map(|joints| joints.as_slice().to_vec()).collect();
            TrajectoryPoint { time: 0.01 * f64::from(k), positions, ..TrajectoryPoint::default() }
        });
        let limits = arms.iter().flat_map(|arm| JointBounds::of(arm.limits())).collect();
        JointTrajectory::new(limits, points.collect()).expect("sound")
    })
}

/// Steps in which they go to where the plan begins, and some.
const HOME: u64 = 110;

/// From a step of the motion on, something happens.
#[derive(Clone, Copy, Debug, PartialEq)]
enum End {
    Nothing,
    Halt,
    Suspension,
    Stop,
    /// The program ends with a fault: each arm brakes by itself.
    Fault,
}

struct At(u64);

#[condition(mp)]
fn at(c: &mut At, t: Tick) -> bool {
    t.step >= c.0
}

/// Waits until the trajectory is over.
struct Over(TrajectoryGroup);

#[condition(mp)]
impl Over {
    fn is_met(&mut self) -> bool {
        self.0.following() == 0
    }
}

/// The largest error of the relative pose in a run, and how far the body went \[m\].
fn run(end: End, step: u64) -> ((f64, f64), f64) {
    let [near, far] = arms();
    let (left, here, _) = arm("left", &near, &irp6_start());
    let (right, there, _) = arm("right", &far, &irp6_start());
    let cell = Cell::new(STEP).robot(left).robot(right).program(move |mp| {
        let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
        let group = TrajectoryGroup::new(&NAMES);
        let thrown = |why: mrroc_generators::trajectory::TrajectoryError| Fault::thrown(&why.to_string());
        let both = Each::of((
            group.motion::<Irp6>("left").map_err(thrown)?,
            group.motion::<Irp6>("right").map_err(thrown)?,
        ));
        mp.start_robots((&mut left, &mut right), both)?;
        // Their encoders say that they begin some micrometres beside where the plan does.
        let home: Vec<f64> = [irp6_start(); 2].iter().flat_map(|joints| joints.as_slice().to_vec()).collect();
        let home = TrajectoryPoint { time: 0.2, positions: home, ..TrajectoryPoint::default() };
        let home = JointTrajectory::new(carried().limits().to_vec(), vec![home]).map_err(thrown)?;
        group.begin(&NAMES, &home).map_err(thrown)?;
        mp.wait_until((), (), Over(group.clone()))?;
        group.begin(&NAMES, carried()).map_err(thrown)?;
        mp.wait_until((), (), At(step))?;
        match end {
            End::Halt => group.halt("left").map_err(thrown)?,
            End::Fault => return Err(Fault::thrown("a fault")),
            End::Nothing | End::Suspension | End::Stop => {}
        }
        mp.wait_until((), (), Over(group.clone()))?;
        let expected = if end == End::Halt { Outcome::Halted } else { Outcome::Done };
        assert_eq!(group.outcome("right"), Ok(Some(expected)), "{end:?} at {step}");
        Ok(())
    });
    let act = move |now: u64, operator: &Operator| match end {
        End::Suspension if now == HOME + step => operator.suspend(),
        End::Suspension if now == HOME + step + 120 => operator.resume(),
        End::Stop if now == HOME + step => operator.protective_stop(),
        End::Nothing | End::Halt | End::Suspension | End::Stop | End::Fault => {}
    };
    let ended = cell.on_step(act).run();
    assert_eq!(ended.is_ok(), !matches!(end, End::Stop | End::Fault), "{end:?} at {step}: {ended:?}");
    let (here, there) = (here.demanded.borrow(), there.demanded.borrow());
    let (here, there) = (&here[HOME as usize..], &there[HOME as usize..]);
    let error = relative_error(here, there, &here[0].inv_mul(&there[0]));
    (error, apart(&here[0], here.last().expect("it moved")).0)
}

#[test]
fn two_arms_of_one_trajectory_keep_their_relative_pose_when_it_is_halted_suspended_or_stopped() {
    let (error, far) = run(End::Nothing, 0);
    assert!(error.0 < 1e-7 && error.1 < 1e-7 && far > 0.09, "{error:?}, {far} m");
    for end in [End::Halt, End::Suspension, End::Stop] {
        let (worst, least, farthest) = at_instants(end, 100);
        assert!(worst.0 <= 1e-6 && worst.1 <= 1e-6, "{end:?}: {worst:?}, {least} m");
        assert!(farthest > 0.08, "{end:?}: {farthest} m");
    }
}

#[test]
#[ignore = "thousands of runs: `just sweep-goals`"]
fn at_a_thousand_instants_two_arms_of_one_trajectory_keep_their_relative_pose_or_nearly_so_after_a_fault() {
    for end in [End::Halt, End::Suspension, End::Stop, End::Fault] {
        let (worst, least, farthest) = at_instants(end, 1_000);
        println!(
            "{end:?}: {:.1e} m, {:.1e} rad; the body went {least:.4} to {farthest:.4} m",
            worst.0, worst.1
        );
        let bound = if end == End::Fault { [1e-3, 2e-3] } else { [1e-9; 2] };
        assert!(worst.0 <= bound[0] && worst.1 <= bound[1], "{end:?}: {worst:?}");
    }
}

/// The largest error of the relative pose \[m, rad\] where that happens at so many instants of the motion, and how far the
/// body went at least and at most \[m\].
fn at_instants(end: End, count: u32) -> ((f64, f64), f64, f64) {
    let most = carried().duration() / STEP.as_secs_f64();
    let (mut worst, mut least, mut farthest) = ((0.0_f64, 0.0_f64), f64::INFINITY, 0.0_f64);
    for k in 0..count {
        let step = 15 + (f64::from(k) * (most - 30.0) / f64::from(count)) as u64;
        let ((off, turned), went) = run(end, step);
        worst = (worst.0.max(off), worst.1.max(turned));
        (least, farthest) = (least.min(went), farthest.max(went));
    }
    (worst, least, farthest)
}
