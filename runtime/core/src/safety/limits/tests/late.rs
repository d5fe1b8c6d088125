//! Demands after some that were missing: a robot goes on and comes back onto its path.

use super::*;
use crate::safety::limits::catching_up::{FARTHEST, velocity_back};
use crate::safety::limits::path::OffPath;

/// A path of the first joint that begins and ends at rest, with trapezoidal velocity; the second one turns by half of it.
struct Trapezoid {
    /// Velocity [m/s], acceleration [m/s2] and the time in which the velocity is constant \[s\].
    v: f64,
    a: f64,
    cruise: f64,
}

impl Trajectory for Trapezoid {
    fn duration(&self) -> f64 {
        2.0 * self.v / self.a + self.cruise
    }

    fn at(&self, t: f64) -> Two {
        let (ramp, t) = (self.v / self.a, t.clamp(0.0, self.duration()));
        let whole = self.v * (ramp + self.cruise);
        let rest = self.duration() - t;
        let x = match t {
            t if t < ramp => 0.5 * self.a * t * t,
            t if t < ramp + self.cruise => 0.5 * self.v * ramp + self.v * (t - ramp),
            _ => whole - 0.5 * self.a * rest * rest,
        };
        Two::new(x, 0.5 * x)
    }
}

/// A quintic of the first joint, whose acceleration changes all the time; the second joint turns by half of it.
pub(super) struct Quintic {
    /// Its length [m] and its duration \[s\].
    pub length: f64,
    pub duration: f64,
}

impl Trajectory for Quintic {
    fn duration(&self) -> f64 {
        self.duration
    }

    fn at(&self, t: f64) -> Two {
        let u = (t / self.duration).clamp(0.0, 1.0);
        let x = self.length * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        Two::new(x, 0.5 * x)
    }
}

/// What a robot did that missed `n` demands after step `k`.
struct Went {
    end: Two,
    /// The largest offset from the path [m], and for how many steps there was one after the late demand.
    off: f64,
    steps: usize,
}

/// A path from rest to rest.
pub(super) trait Trajectory {
    /// In which time \[s\].
    fn duration(&self) -> f64;
    /// Where it is at a time.
    fn at(&self, t: f64) -> Two;
}

/// Follows the path, without the demands of steps `k + 1` to `k + n`, and then holds where it ends.
fn go(path: &impl Trajectory, k: usize, n: usize) -> Result<Went, FaultKind> {
    let mut acceptor = acceptor(Turntable::with(|limits| limits.lower[0] = -9.0));
    acceptor.checks.robot.limits.upper[0] = 9.0;
    let last = (path.duration() / T).ceil() as usize + 1;
    let mut went = Went { end: Two::zeros(), off: 0.0, steps: 0 };
    let mut before = (Two::zeros(), Two::zeros());
    for step in 1..last + 2000 {
        let at = path.at(step as f64 * T);
        let is_late = (k + 1..=k + n).contains(&step);
        let accepted = if is_late {
            acceptor.extrapolate(T)
        } else if step <= last.max(k + n + 1) {
            let dt = if step == k + n + 1 { (n + 1) as f64 * T } else { T };
            acceptor.accept(&Demand::joints(at), dt, T).map_err(|fault| fault.kind())?
        } else if acceptor.is_on_path() {
            break;
        } else {
            acceptor.hold(T).map_err(|fault| fault.kind())?
        };
        let q = *accepted.joints();
        let velocity = (q - before.0) / T;
        let acceleration = (velocity - before.1) / T;
        for (i, limit) in [10.0, 20.0].into_iter().enumerate() {
            assert!(velocity[i].abs() <= 1.0 + 1e-9, "{velocity} in step {step} of {k}, {n}");
            assert!(acceleration[i].abs() <= limit + 1e-4, "{acceleration} in step {step} of {k}, {n}");
        }
        before = (q, velocity);
        if step > k + n {
            went.off = went.off.max((q - at).amax());
            went.steps += usize::from(!acceptor.is_on_path());
            if acceptor.is_on_path() {
                assert!(n > 0 && step == k + n + 1 || q == at, "{q}, not {at}, in step {step} of {k}, {n}");
            } else {
                // Generators are shown the path that they made.
                assert_eq!(acceptor.demanded().0, at, "step {step} of {k}, {n}");
            }
        }
    }
    went.end = before.0;
    Ok(went)
}

#[test]
fn fault_06_a_path_of_nine_tenths_goes_on_after_any_demands_that_were_missing() {
    let path = Trapezoid { v: 0.9, a: 9.0, cruise: 0.05 };
    let (mut farthest, mut longest) = (0.0_f64, 0);
    for n in [1, 2, 5, 10, 20] {
        // Seen by the limits, `(0.9²/(2 (1 - 0.9)) + 0.9/2) a t²`, and one step of each more.
        let t = (n + 1) as f64 * T;
        let bound = (0.81 / 0.2 + 0.45) * 10.0 * t * t + 0.9 * 10.0 * t * T;
        for k in 0..250 {
            let went = go(&path, k, n).unwrap_or_else(|fault| panic!("{fault:?} of {k}, {n}"));
            assert_eq!(went.end, path.at(1.0), "{k}, {n}");
            assert!(went.off <= bound, "{} m off, not {bound}, {k}, {n}", went.off);
            farthest = farthest.max(went.off / bound);
            longest = longest.max(went.steps);
        }
    }
    // The equation is no idle one.
    assert!(farthest > 0.5, "{farthest} {longest}");
}

/// A path of nine tenths leaves a tenth to come back with: less than what a machine costs that is late in every third step.
#[test]
fn fault_06_a_robot_that_never_comes_back_because_demands_are_late_again_and_again_says_so() {
    let path = Trapezoid { v: 0.9, a: 9.0, cruise: 0.05 };
    let mut acceptor = acceptor(Turntable::new());
    let refused = (1..100).find_map(|step| {
        if step % 3 == 0 {
            acceptor.extrapolate(T);
            return None;
        }
        let dt = if step % 3 == 1 && step > 1 { 2.0 * T } else { T };
        acceptor.accept(&Demand::joints(path.at(f64::from(step) * T)), dt, T).err()
    });
    let refused = refused.expect("it falls behind while the path accelerates");
    assert_eq!((refused.kind(), refused.message()), (FaultKind::DemandedAcceleration, "after late demands"));
    // A jump of a program that is in step says nothing of late demands.
    let mut punctual = super::acceptor(Turntable::new());
    let jump = punctual.accept(&Demand::joints(Two::new(0.1, 0.0)), T, T).expect_err("a jump");
    assert!(!jump.message().contains("late"), "{jump}");
}

#[test]
fn fault_06_a_path_whose_acceleration_changes_goes_on_after_any_demands_that_were_missing() {
    // Its acceleration is 10/√3 length/duration² at most: nine tenths of the limit.
    let duration = 0.12;
    let path = Quintic { length: 9.0 * duration * duration * 3.0_f64.sqrt() / 10.0, duration };
    for (k, n) in (0..130).flat_map(|k| (1..=20).map(move |n| (k, n))) {
        let went = go(&path, k, n).unwrap_or_else(|fault| panic!("{fault:?} of {k}, {n}"));
        let t = (n + 1) as f64 * T;
        assert!(went.end == path.at(1.0) && went.off <= FARTHEST * 10.0 * t * t, "{k}, {n}");
    }
}

#[test]
fn fault_06_a_motion_whose_last_demand_is_late_ends_where_it_says() {
    // Ends between two steps, and so many steps late.
    for (part, n) in (0..10).flat_map(|part| (1..=20).map(move |n| (part, n))) {
        let path = Trapezoid { v: 0.9, a: 9.0, cruise: 0.05 + 1e-4 * f64::from(part) };
        let last = (path.duration() / T).ceil() as usize;
        let mut acceptor = acceptor(Turntable::with(|limits| limits.lower[0] = -9.0));
        acceptor.checks.robot.limits.upper[0] = 9.0;
        for step in 1..last {
            acceptor.accept(&Demand::joints(path.at(step as f64 * T)), T, T).expect("in time");
        }
        for _ in 0..n {
            acceptor.extrapolate(T);
        }
        assert_ne!(acceptor.accepted().0, path.at(1.0));
        acceptor.note_late(&Demand::joints(path.at(1.0))).expect("a demand");
        let (mut velocity, mut steps) = (acceptor.accepted().1, 0);
        while !(acceptor.is_on_path() && acceptor.is_at_rest()) {
            assert!(acceptor.can_hold(T), "step {steps} of {part}, {n}");
            acceptor.hold(T).expect("within the limits");
            let change = (acceptor.accepted().1 - velocity) / T;
            assert!(change[0].abs() <= 10.0 + 1e-6 && change[1].abs() <= 20.0 + 1e-6, "{change}");
            (velocity, steps) = (acceptor.accepted().1, steps + 1);
            assert!(steps < 200, "{part}, {n}");
        }
        assert_eq!(acceptor.accepted().0, path.at(1.0), "{part}, {n}");
    }
}

#[test]
fn fault_22_a_motion_whose_first_demand_is_late_begins_late_unless_that_is_far_from_the_robot() {
    let path = Trapezoid { v: 0.9, a: 9.0, cruise: 0.05 };
    for n in 1..=20 {
        let mut acceptor = acceptor(Turntable::with(|limits| limits.lower[0] = -9.0));
        acceptor.begin();
        let far = acceptor.begin_late(&joints(2e-3, 0.0), T, n as f64, false);
        assert_eq!(far.map_err(|fault| fault.kind()), Err(FaultKind::StartPoseMismatch));
        assert!(acceptor.is_on_path() && acceptor.track.path.missing == 0.0);
        acceptor.begin_late(&Demand::joints(path.at(T)), T, n as f64, false).expect("near");
        let mut velocity = Two::zeros();
        for step in n + 1..400 {
            let at = path.at(step as f64 * T);
            let dt = if step == n + 1 { n as f64 * T } else { T };
            acceptor.accept(&Demand::joints(at), dt, T).expect("within the limits");
            let change = (acceptor.accepted().1 - velocity) / T;
            assert!(change[0].abs() <= 10.0 + 1e-6 && change[1].abs() <= 20.0 + 1e-6, "{change}");
            velocity = acceptor.accepted().1;
            assert!(step < 350 || acceptor.accepted().0 == at, "step {step} of {n}");
        }
    }
}

#[test]
fn a_path_that_leaves_nothing_of_the_limit_goes_on_or_is_given_up_before_the_robot_is_far_off() {
    let path = Trapezoid { v: 1.0, a: 10.0, cruise: 0.05 };
    let (mut went_on, mut given_up) = (0, 0);
    for (k, n) in (0..250).flat_map(|k| [1, 10, 20].map(|n| (k, n))) {
        match go(&path, k, n) {
            Ok(went) => {
                let t = (n + 1) as f64 * T;
                assert!(went.end == path.at(1.0) && went.off <= FARTHEST * 10.0 * t * t, "{k}, {n}");
                went_on += 1;
            }
            Err(kind) => {
                let kinds = [FaultKind::DemandedAcceleration, FaultKind::DemandedVelocity];
                assert!(kinds.contains(&kind), "{kind:?} of {k}, {n}");
                given_up += 1;
            }
        }
    }
    assert!(went_on > 300 && given_up > 10, "{went_on} {given_up}");
}

#[test]
fn fault_21_what_no_path_within_the_limits_comes_to_is_refused_however_late_it_is() {
    for n in 1..=20_usize {
        // At v for n + 1 steps, the furthest that 10 m/s² come to is off by (n + 1)(n + 2)/2 of 1e-5 m.
        let most = 1e-5 * ((n + 1) * (n + 2) / 2) as f64;
        for (part, taken) in [(0.999, true), (-0.999, true), (1.001, false), (-1.001, false)] {
            let mut acceptor = acceptor(Turntable::new());
            (acceptor.state.velocity[0], acceptor.track.path.velocity[0], acceptor.track.path.span) =
                (0.3, 0.3, T);
            for _ in 0..n {
                acceptor.extrapolate(T);
            }
            let held = 0.3 * (n + 1) as f64 * T;
            let outcome = acceptor.accept(&joints(held + part * most, 0.0), (n + 1) as f64 * T, T);
            assert_eq!(outcome.is_ok(), taken, "{n}, {part}: {outcome:?}");
            if let Err(fault) = outcome {
                assert_eq!(fault.kind(), FaultKind::DemandedAcceleration);
            }
        }
    }
}

#[test]
fn a_jump_is_refused_while_a_robot_is_off_its_path() {
    let mut acceptor = acceptor(Turntable::new());
    let path = |t: f64| joints(0.3 * t - 4.5 * t * t, 0.0);
    (acceptor.state.velocity[0], acceptor.track.path.velocity[0], acceptor.track.path.span) = (0.3, 0.3, T);
    for _ in 0..5 {
        acceptor.extrapolate(T);
    }
    acceptor.accept(&path(6.0 * T), 6.0 * T, T).expect("within the limits");
    assert!(!acceptor.is_on_path() && !acceptor.is_at_rest());
    acceptor.accept(&path(7.0 * T), T, T).expect("within the limits");
    let before = (acceptor.state.position, acceptor.demanded());
    // 2e-5 m more than the path: 20 m/s².
    let Coordinates::Joints(next) = path(8.0 * T).coordinates else { panic!("joints") };
    let fault = acceptor.accept(&joints(next[0] + 2e-5, 0.0), T, T).expect_err("a jump");
    assert_eq!(fault.kind(), FaultKind::DemandedAcceleration);
    assert_eq!((acceptor.state.position, acceptor.demanded()), before);
    acceptor.accept(&path(8.0 * T), T, T).expect("within the limits");
}

#[test]
fn demands_that_are_lost_on_the_return_are_bridged_at_the_robots_own_velocity() {
    let mut acceptor = acceptor(Turntable::new());
    let path = |t: f64| 0.3 * t - 4.5 * t * t;
    // The mean of the path's last step.
    let v = 0.3 + 4.5 * T;
    (acceptor.state.velocity[0], acceptor.track.path.velocity[0], acceptor.track.path.span) = (v, v, T);
    for _ in 0..5 {
        acceptor.extrapolate(T);
    }
    let t = 6.0 * T;
    acceptor.accept(&joints(path(t), 0.0), t, T).expect("within the limits");
    // 10 m/s² in one step.
    near(acceptor.state.velocity[0], v - 0.01);
    let at = acceptor.state.position[0];
    acceptor.extrapolate(T);
    near(acceptor.state.velocity[0], v - 0.01);
    near(acceptor.state.position[0], at + (v - 0.01) * T);
    // What is shown of the path goes on at its own velocity, the mean of its last step.
    let (shown, velocity) = acceptor.demanded();
    near(velocity[0], (path(t) - path(t - T)) / T);
    near(shown[0], path(t) + velocity[0] * T);
}

#[test]
fn fault_18_joints_of_an_inverse_that_are_no_numbers_are_refused_on_the_common_return() {
    let mut acceptor = acceptor(Turntable::new());
    (acceptor.state.velocity[0], acceptor.track.path.velocity[0], acceptor.track.path.span) = (0.3, 0.3, T);
    acceptor.go_on(&Pose::translation(0.3 * T, 0.0, 0.0), T).expect("on the twist");
    acceptor.checks.robot.off = f64::NAN;
    let before = acceptor.state.position;
    let fault = acceptor.rejoin(&joints(0.6 * T, 0.0), 2.0 * T, T).expect_err("no joints");
    assert_eq!((fault.kind(), acceptor.state.position), (FaultKind::DemandNotFinite, before));
}

#[test]
fn an_offset_ends_in_the_fewest_steps_that_the_acceleration_allows() {
    let a = 5.0;
    for offset in [1e-9_f64, 4.9e-6, 5e-6, 5.1e-6, 1e-5, 1.5e-5, 3.3e-4, 2e-2] {
        for offset in [offset, -offset] {
            let (mut x, mut before, mut steps) = (offset, None::<f64>, 0);
            while x.abs() > 1e-15 {
                let v = velocity_back(x, a, T);
                if let Some(before) = before {
                    let change = v - before;
                    assert!(change.abs() <= a * T * (1.0 + 1e-9), "{change} of {offset} at {x}");
                }
                (x, before, steps) = (x + v * T, Some(v), steps + 1);
                assert!(x * offset >= -1e-18, "{offset} is passed: {x}");
            }
            let last = before.unwrap_or_default();
            assert!(last.abs() <= a * T * (1.0 + 1e-9), "{last} m/s are left of {offset}");
            // m steps with velocities that fall by a T to at most a T cover at most m (m + 1)/2 a T².
            let covered = |m: f64| 0.5 * m * (m + 1.0) * a * T * T;
            let fewest = (1..).find(|&m| covered(f64::from(m)) >= offset.abs() * (1.0 - 1e-9)).unwrap();
            assert_eq!(steps, fewest, "{offset}");
        }
    }
}

/// After a demand that was missing on a twist, of a path of 2 m/s².
fn on_a_twist() -> Acceptor<Turntable> {
    let mut acceptor = acceptor(Turntable::new());
    acceptor.accept(&joints(1e-6, 0.0), T, T).expect("slow");
    let twist = acceptor.bridging(T).twist;
    acceptor.go_on(&twist.part(1.0), T).expect("within the limits");
    acceptor
}

#[test]
fn an_arm_that_missed_a_demand_alone_goes_straight_to_the_next_and_arms_that_all_did_come_back_together() {
    let demand = joints(9e-6, 0.0);
    let mut alone = on_a_twist();
    alone.accept(&demand, 2.0 * T, T).expect("6 m/s²");
    assert!(alone.is_on_path() && alone.state.position == Two::new(9e-6, 0.0), "{}", alone.state.position);
    let mut together = on_a_twist();
    together.rejoin(&demand, 2.0 * T, T).expect("within the limits");
    assert!(
        matches!(together.track.off_path, Some(OffPath::Together(_))) && together.state.position[0] < 8e-6
    );
    // 12 m/s² are too much at once: whether the others missed it, too, is not known.
    let mut unknown = acceptor(Turntable::new());
    unknown.accept(&joints(2e-6, 0.0), T, T).expect("slow");
    let twist = unknown.bridging(T).twist;
    unknown.go_on(&twist.part(1.0), T).expect("within the limits");
    unknown.accept(&joints(18e-6, 0.0), 2.0 * T, T).expect("on the return");
    assert!(matches!(unknown.track.off_path, Some(OffPath::Together(_))));
    // One that was bridged by its joints since is beside the others anyway, and comes back by itself.
    together.extrapolate(T);
    together.accept(&joints(25e-6, 0.0), 2.0 * T, T).expect("within the limits");
    assert!(!matches!(together.track.off_path, Some(OffPath::Together(_))));
}

#[test]
fn a_stop_ends_the_path_where_the_robot_is_if_one_step_can_take_its_velocity_away() {
    let late = || {
        let mut acceptor = acceptor(Turntable::new());
        acceptor.accept(&joints(5e-6, 0.0), T, T).expect("slow");
        acceptor.extrapolate(T);
        acceptor.note_late(&joints(11e-6, 0.0)).expect("a demand");
        acceptor
    };
    let mut stopped = late();
    assert!(stopped.stop_at_once(T) && stopped.is_at_its_end());
    stopped.hold(T).expect("5 m/s²");
    assert_eq!(stopped.state.position, Two::new(10e-6, 0.0));
    // To hold is to come to where the path ends.
    let mut held = late();
    assert!(held.can_hold(T) && !held.is_at_its_end());
    held.hold(T).expect("1 m/s²");
    assert_eq!(held.state.position, Two::new(11e-6, 0.0));
    // 11 m/s² are more than 10.
    let mut fast = late();
    fast.state.velocity[0] = 11e-3;
    assert!(!fast.stop_at_once(T) && !fast.is_at_its_end());
    // One that is off its path brakes.
    let mut off = acceptor(Turntable::new());
    (off.state.velocity[0], off.track.path.velocity[0], off.track.path.span) = (5e-3, 5e-3, T);
    off.extrapolate(T);
    off.accept(&joints(24e-6, 0.0), T, T).expect("on the return");
    assert!(!off.is_on_path() && !off.stop_at_once(T));
}
