//! Two arms that hold one body along a joint trajectory of others: in a cancellation, a suspension and an operator's stop their tools keep their relative pose.

use std::sync::OnceLock;

use mrroc::operator::Operator;
use mrroc::prelude::*;
use mrroc_generators::trajectory::{JointBounds, JointTrajectory, Outcome, TrajectoryGroup, TrajectoryPoint};
use mrroc_robots::{Irp6, Six};
use nalgebra::Vector3;

use super::kit::{STEP, Trace, apart, arm, irp6_facing, irp6_start, relative_error};

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

/// What became of the relative pose in a run.
struct Run {
    /// Its largest error \[m, rad\].
    error: (f64, f64),
    /// How far the body went \[m\].
    far: f64,
    /// The demanded joints of both arms, step by step.
    joints: [Vec<Vec<f64>>; 2],
}

fn run(end: End, step: u64) -> Run {
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
    let joints = [&here, &there].map(|trace: &Trace| trace.joints.borrow()[HOME as usize..].to_vec());
    let (here, there) = (here.demanded.borrow(), there.demanded.borrow());
    let (here, there) = (&here[HOME as usize..], &there[HOME as usize..]);
    let error = relative_error(here, there, &here[0].inv_mul(&there[0]));
    Run { error, far: apart(&here[0], here.last().expect("it moved")).0, joints }
}

/// How far the relative pose of two arms may be off that begin to brake in the same step, each by itself \[m, rad\], by the last two demands of each before that.
///
/// Each arm goes on along a straight line of its joints, on which its joints would have the velocities of its last step, and loses these in a time `T`: after
/// `T` it is `T / 2` farther on its line. Where both arms are as far on their lines, their tools have had the same displacement in their last step. On its line a
/// tool's twist, with the body's point that the other arm holds, leaves that of this step by at most `k (s + Ts / 2)`, with its acceleration `k` on the line.
/// Integrated over the time, the difference of both tools' twists is at most `v |T1 - T2| / 2` plus `k (T^2 / 8 + T Ts / 4)` of each arm. An arm that one step can bring
/// to rest (`T <= Ts`) rests at once, `T / 2` before the end of its line.
fn braking_bound(arms: &[Irp6; 2], last: [[&[f64]; 2]; 2]) -> (f64, f64) {
    const PARTS: usize = 40;
    let ts = STEP.as_secs_f64();
    let held = arms[1].forward(&Six::from_column_slice(last[1][1])).translation.vector;
    let (mut times, mut bound) = ([0.0; 2], (0.0, 0.0));
    for (k, arm) in arms.iter().enumerate() {
        let [before, here] = last[k].map(Six::from_column_slice);
        let velocity = (here - before) / ts;
        let limits = arm.limits().acceleration;
        times[k] = velocity.iter().zip(limits.iter()).map(|(v, a)| v.abs() / a).fold(0.0, f64::max);
        let point = arm.forward(&here).inverse_transform_point(&held.into());
        let h = (ts + times[k] / 2.0) / PARTS as f64;
        let on_line = (0..=PARTS).map(|n| arm.forward(&(before + velocity * (h * n as f64))));
        let twists: Vec<_> = on_line
            .map(|pose| (pose.transform_point(&point).coords, pose.rotation))
            .collect::<Vec<_>>()
            .windows(2)
            .map(|of| [(of[1].0 - of[0].0) / h, (of[1].1 * of[0].1.inverse()).scaled_axis() / h])
            .collect();
        let bend = |of: usize| {
            twists.windows(2).map(|of_two| (of_two[1][of] - of_two[0][of]).norm() / h).fold(0.0, f64::max)
        };
        let share = times[k] * (times[k] + 2.0 * ts) / 8.0;
        bound = (bound.0 + bend(0) * share, bound.1 + bend(1) * share);
        if k == 1 {
            let by = arm.forward(&before).inv_mul(&arm.forward(&here));
            let apart = (times[0] - times[1]).abs() + ts;
            bound.0 += by.translation.vector.norm() / ts * apart / 2.0;
            bound.1 += by.rotation.angle() / ts * apart / 2.0;
        }
    }
    bound
}

/// The largest share of [`braking_bound`] that faults at so many instants take, and the largest errors \[m, rad\].
fn faults_at_instants(count: u32) -> (f64, (f64, f64)) {
    let (arms, undisturbed) = (arms(), run(End::Nothing, 0).joints);
    let (mut share, mut worst) = (0.0_f64, (0.0_f64, 0.0_f64));
    for step in instants(count) {
        let Run { error, joints, .. } = run(End::Fault, step);
        let brakes = |k: usize| joints[k].iter().zip(&undisturbed[k]).position(|(braked, on)| braked != on);
        let first = brakes(0);
        assert_eq!(first, brakes(1), "they begin to brake in the same step, fault at {step}");
        // Near the ends of the motion one step brings both to rest where they are.
        let Some(first) = first else {
            assert!(error.0 <= 1e-9 && error.1 <= 1e-9, "fault at {step}: {error:?}");
            continue;
        };
        let last = [0, 1].map(|k| [&joints[k][first - 2][..], &joints[k][first - 1][..]]);
        let bound = braking_bound(&arms, last);
        assert!(error.0 <= bound.0 && error.1 <= bound.1, "fault at {step}: {error:?} beyond {bound:?}");
        share = share.max(error.0 / bound.0).max(error.1 / bound.1);
        worst = (worst.0.max(error.0), worst.1.max(error.1));
    }
    (share, worst)
}

#[test]
fn two_arms_of_one_trajectory_keep_their_relative_pose_when_it_is_halted_suspended_or_stopped() {
    let Run { error, far, .. } = run(End::Nothing, 0);
    assert!(error.0 < 1e-7 && error.1 < 1e-7 && far > 0.09, "{error:?}, {far} m");
    for end in [End::Halt, End::Suspension, End::Stop] {
        let (worst, least, farthest) = at_instants(end, 100);
        assert!(worst.0 <= 1e-6 && worst.1 <= 1e-6, "{end:?}: {worst:?}, {least} m");
        assert!(farthest > 0.08, "{end:?}: {farthest} m");
    }
}

#[test]
fn fault_257_two_arms_of_one_trajectory_that_a_fault_stops_each_by_itself_come_apart_by_no_more_than_their_braking_explains()
 {
    let (share, worst) = faults_at_instants(100);
    // The bound is not so large that it says nothing.
    assert!(share > 0.1 && worst.0 > 1e-4 && worst.1 > 2e-4, "{share} of the bound, {worst:?}");
}

#[test]
#[ignore = "thousands of runs: `just sweep-goals`"]
fn at_a_thousand_instants_two_arms_of_one_trajectory_keep_their_relative_pose_or_nearly_so_after_a_fault() {
    for end in [End::Halt, End::Suspension, End::Stop] {
        let (worst, least, farthest) = at_instants(end, 1_000);
        println!(
            "{end:?}: {:.1e} m, {:.1e} rad; the body went {least:.4} to {farthest:.4} m",
            worst.0, worst.1
        );
        assert!(worst.0 <= 1e-9 && worst.1 <= 1e-9, "{end:?}: {worst:?}");
    }
    let (share, worst) = faults_at_instants(1_000);
    println!("Fault: {:.1e} m, {:.1e} rad; at most {share:.2} of the bound", worst.0, worst.1);
}

/// So many steps of the motion, spread over it.
fn instants(count: u32) -> impl Iterator<Item = u64> {
    let most = carried().duration() / STEP.as_secs_f64();
    (0..count).map(move |k| 15 + (f64::from(k) * (most - 30.0) / f64::from(count)) as u64)
}

/// The largest error of the relative pose \[m, rad\] where that happens at so many instants of the motion, and how far the
/// body went at least and at most \[m\].
fn at_instants(end: End, count: u32) -> ((f64, f64), f64, f64) {
    let (mut worst, mut least, mut farthest) = ((0.0_f64, 0.0_f64), f64::INFINITY, 0.0_f64);
    for step in instants(count) {
        let Run { error: (off, turned), far, .. } = run(end, step);
        worst = (worst.0.max(off), worst.1.max(turned));
        (least, farthest) = (least.min(far), farthest.max(far));
    }
    (worst, least, farthest)
}
