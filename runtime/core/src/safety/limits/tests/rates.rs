//! How fast the rate may change, and how fast robots slow down on their twist.

use super::*;
use crate::safety::braking::BrakingLaw;
use crate::safety::limits::rates::least_margin;
use crate::safety::rate::{DEFAULT_CHANGE, Feed, path_stop_time};

/// At 0.3 m/s and -0.2 rad/s.
fn moving(robot: Turntable) -> Acceptor<Turntable> {
    let mut acceptor = acceptor(robot);
    (acceptor.state.velocity, acceptor.state.acceleration) = (Two::new(0.3, -0.2), Two::new(1.0, 2.0));
    (acceptor.pace.path_speed, acceptor.pace.period) = (Two::new(0.3, 0.2), 2e-3);
    acceptor
}

#[test]
fn the_rate_may_change_by_what_a_path_leaves_of_the_acceleration() {
    // (0.98 - 0.9 r²) a / (v + a T), of 10 m/s² at 0.3 m/s in 2 ms; the turn's 20 rad/s² at 0.2 rad/s are more.
    let mut acceptor = moving(Turntable::new());
    let margin = acceptor.rate_margin();
    near(margin.rise, 0.08 * 10.0 / 0.32);
    near(margin.fall, 0.08 * 10.0 / 0.32);
    assert_eq!(margin.bend, f64::INFINITY);
    // At half the rate, which may be 0.51 at the end of a step in which it rises by 5 / s.
    acceptor.pace.rate = 0.5;
    near(acceptor.rate_margin().fall, (0.98 - 0.9 * 0.25) * 10.0 / 0.32);
    near(acceptor.rate_margin().rise, (0.98 - 0.9 * 0.51 * 0.51) * 10.0 / 0.32);
    // Where two of three demands are lost, a ninth.
    acceptor.pace.bridged = 2.0;
    near(acceptor.rate_margin().fall, (0.98 - 0.9 * 0.25) * 10.0 / 9.0 / 0.32);
    // The joint that leaves less counts: 20 / (2.0 + 0.04).
    (acceptor.pace.bridged, acceptor.pace.path_speed[1]) = (0.0, 2.0);
    near(acceptor.rate_margin().fall, (0.98 - 0.9 * 0.25) * 20.0 / 2.04);
}

#[test]
fn with_a_jerk_limit_the_rate_may_change_by_what_a_path_leaves_of_that_as_well() {
    // Of 0.08 j a half for 3 r' q'', with q'' = 0.9 a, a half for r'' q', with q' = v + a T of the velocity limit, 1 m/s.
    let margin = moving(Turntable::with_jerk(100.0, 1e6)).rate_margin();
    near(margin.rise, 0.04 * 100.0 / (3.0 * 0.9 * 10.0));
    near(margin.fall, 0.04 * 100.0 / (3.0 * 0.9 * 10.0));
    near(margin.bend, 0.04 * 100.0 / 1.02);
    let margin = moving(Turntable::with_jerk(1e4, 1e6)).rate_margin();
    near(margin.fall, 0.08 * 10.0 / 1.02);
    near(margin.bend, 0.04 * 1e4 / 1.02);
    // At half the rate a path has a quarter of its acceleration and an eighth of its jerk.
    let mut acceptor = moving(Turntable::with_jerk(100.0, 1e6));
    acceptor.pace.rate = 0.5;
    near(acceptor.rate_margin().fall, 0.5 * (0.98 - 0.9 / 8.0) * 100.0 / (3.0 * 0.9 * 10.0 * 0.5));
    near(acceptor.rate_margin().bend, 0.5 * (0.98 - 0.9 * 0.51_f64.powi(3)) * 100.0 / 1.02);
    // A path that is planned faster than the robot may be, to be gone along slowly.
    acceptor.pace.path_speed[0] = 1.5;
    near(acceptor.rate_margin().bend, 0.5 * (0.98 - 0.9 * 0.51_f64.powi(3)) * 100.0 / 1.52);
}

#[test]
fn a_stop_on_the_path_takes_the_time_that_the_limits_leave() {
    // Without a jerk limit from the velocity limit 2.05 v/a, see `docs/decisions/0005`: the integral of
    // dr v / (0.98 - 0.9 r²) a from 0 to 1, with v + a T for v.
    let limits =
        Turntable::with(|l| (l.velocity, l.acceleration) = (Two::repeat(1.0), Two::repeat(2.0))).limits;
    let (p, u) = (0.9_f64.sqrt(), 0.98_f64.sqrt());
    let integral = (p / u).atanh() / (p * u);
    let time = path_stop_time(DEFAULT_CHANGE, T, |rate| least_margin(&limits, rate, T));
    assert!((time - 1.002 / 2.0 * integral).abs() < 3e-3, "{time}, {integral}");
    // With one, by quadrature in time of the same bounds and those of the jerk, r'' among them: see
    // `tests/benches/peers/path_stop.py`.
    for (v, a, jerk, seconds) in [(1.0, 10.0, 100.0, 0.736), (2.62, 10.0, 5000.0, 0.541)] {
        let limits = Limits {
            velocity: Two::repeat(v),
            acceleration: Two::repeat(a),
            ..Turntable::with_jerk(jerk, jerk).limits
        };
        let time = path_stop_time(DEFAULT_CHANGE, T, |rate| least_margin(&limits, rate, T));
        assert!((time - seconds).abs() < 5e-3, "{time}, {seconds}");
    }
}

/// A path of random pieces of constant jerk, within a share of the limits of a robot, by time: at which time it has which
/// position, velocity, acceleration and jerk.
fn random_path(
    limits: &Limits<Two>,
    share: f64,
    seconds: f64,
    random: &mut impl FnMut() -> f64,
) -> Vec<[f64; 5]> {
    let (limit, fastest) = (limits.acceleration[0], limits.velocity[0]);
    let most = limits.jerk.map_or(1e3 * limit, |jerk| jerk[0]);
    let (limit, most) = (share * limit, share * most);
    let (mut t, mut q, mut v, mut a) = (0.0, 0.0, 0.0_f64, 0.0_f64);
    let mut pieces = Vec::new();
    while t < seconds {
        let mut jerk = [-most, most, 0.0][(random() * 3.0) as usize];
        let room = if jerk > 0.0 {
            (limit - a) / jerk
        } else if jerk < 0.0 {
            (limit + a) / -jerk
        } else {
            0.2
        };
        let mut time = room * random();
        // The velocity keeps its limit also while the acceleration is taken away afterwards.
        let fits = |jerk: f64, time: f64| {
            let (v, a) = (v + time * (a + 0.5 * time * jerk), a + time * jerk);
            v.abs() <= fastest && (v + a * a.abs() / (2.0 * most)).abs() <= fastest
        };
        while time > 1e-9 && !fits(jerk, time) {
            time *= 0.5;
        }
        if time <= 1e-9 {
            (jerk, time) = (-a.signum() * most, (a.abs() / most).max(1e-6));
            if a.abs() < 1e-9 * limit {
                (jerk, a, time) = (0.0, 0.0, 0.05);
            }
        }
        pieces.push([t, q, v, a, jerk]);
        q += time * (v + time * (0.5 * a + time * jerk / 6.0));
        v += time * (a + 0.5 * time * jerk);
        a += time * jerk;
        t += time;
    }
    pieces
}

#[test]
fn fault_80_a_path_of_nine_tenths_keeps_all_limits_however_its_rate_changes() {
    let mut seed = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    for run in 0..300 {
        let v = 10.0_f64.powf(random() - 0.5);
        let a = v * 10.0_f64.powf(1.3 * random());
        let jerk = (run % 4 != 0).then(|| a * 10.0_f64.powf(0.7 + 2.0 * random()));
        let period = [1e-3, 2e-3, 4e-3, 1e-2, 2e-2][(random() * 5.0) as usize];
        if jerk.is_some_and(|jerk| jerk * period > 0.7 * a) {
            continue;
        }
        let limits = Limits {
            lower: Two::repeat(-1e6),
            upper: Two::repeat(1e6),
            velocity: Two::repeat(v),
            acceleration: Two::repeat(a),
            jerk: jerk.map(Two::repeat),
        };
        let seconds = 4.0 * (v / a + 2.0 * jerk.map_or(0.0, |jerk| a / jerk)).max(0.5);
        let path = random_path(&limits, 0.9, seconds + 1.0, &mut random);
        let mut acceptor = acceptor(Turntable { limits, sum: 1e7, ..Turntable::new() });
        acceptor.begin();
        let mut feed = Feed::new(DEFAULT_CHANGE);
        let (mut time, mut wanted) = (0.0, 1.0);
        for step in 0..20_000 {
            if random() < 0.02 {
                wanted = [0.0, 1.0, random()][(random() * 3.0) as usize];
            }
            feed.limit(acceptor.rate_margin());
            let dt = feed.advance(wanted, period) * period;
            time += dt;
            if time > seconds {
                break;
            }
            let [t, q, v, a, jerk] = path[path.partition_point(|piece| piece[0] <= time) - 1];
            let d = time - t;
            let demand = joints(q + d * (v + d * (0.5 * a + d * jerk / 6.0)), 0.0);
            let limits = &acceptor.robot().limits;
            let told = format!("run {run}, step {step} of {period} s, {limits:?}");
            acceptor.accept(&demand, dt, period).unwrap_or_else(|fault| panic!("{told}: {fault}"));
        }
    }
}

#[test]
fn a_robot_slows_down_on_a_twist_by_the_share_of_its_acceleration() {
    let mut acceptor = moving(Turntable::with_jerk(1000.0, 1e6));
    // 0.3 m/s grows by 1 m/s² for 2 ms, and by a tenth of 10 m/s² for 2 ms.
    let faster = 0.3 + 0.002 + 0.002;
    let law = acceptor.braking_law(2e-3);
    near(law.fall, 0.8 * 10.0 / faster);
    near(law.bend, 0.5 * 0.8 * 1000.0 / faster);
    // -0.8 rad/s become slower: -0.8 + 0.004, and a tenth of 20 rad/s² for 2 ms.
    acceptor.state.velocity[1] = -0.8;
    acceptor.checks.robot.limits.velocity[1] = 2.0;
    near(acceptor.braking_law(2e-3).fall, 0.8 * 20.0 / (0.796 + 0.004));
    // No longer than from its velocity limits: of 1 m/s and 10 m/s² 0.1 s, of 2 rad/s and 20 rad/s² as long.
    acceptor.state.velocity[0] = 0.99;
    near(acceptor.braking_law(2e-3).fall, 10.0);
    assert_eq!(self::acceptor(Turntable::new()).braking_law(2e-3), BrakingLaw::UNLIMITED);
    assert_eq!(moving(Turntable::new()).braking_law(2e-3).bend, f64::INFINITY);
}

#[test]
fn a_robot_slows_down_on_a_bent_twist_by_what_that_leaves_of_its_acceleration() {
    let mut acceptor = moving(Turntable::new());
    let faster = 0.3 + 0.002 + 0.002;
    let mut fall = |curvature: [f64; 2]| {
        acceptor.see_curvature(curvature.into());
        acceptor.braking_law(2e-3).fall
    };
    // 0.3 m/s that become less by 4 m/s², a quarter more meanwhile, leave 5 of 10 m/s²; those that become more, or less by
    // 1.5 m/s², leave 8.
    near(fall([-4.0, 0.0]), 5.0 / faster);
    near(fall([4.0, 0.0]), 8.0 / faster);
    near(fall([-1.5, 0.0]), 8.0 / faster);
    // -0.2 rad/s that go towards 0 by 15 of 20 rad/s² leave 1.25: less than with 0.8 from the velocity limits, of 0.1 s.
    near(fall([0.0, 15.0]), 8.0);
    near(fall([0.0, -15.0]), 8.0 / faster);
}

/// An arm that turns about z and reaches out: `X_WF = Rot(z, q1) Trans(q2, 0, 0)`.
#[derive(Clone, Debug)]
struct Polar(Limits<Two>);

impl Robot for Polar {
    const KIND: &'static str = "polar";
    type Joints = Two;

    fn limits(&self) -> &Limits<Two> {
        &self.0
    }

    fn forward(&self, q: &Two) -> Pose {
        Pose::rotation(Vector3::z() * q[0]) * Pose::translation(q[1], 0.0, 0.0)
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, _: &Two) -> Result<Two, NoInverse> {
        let t = X_WF.translation.vector;
        Ok(Two::new(t.y.atan2(t.x), t.xy().norm()))
    }
}

/// At constant spatial twist `(omega, v_s)` the flange's origin goes by p' = v_s + omega x p, p'' = omega x p'. In polar
/// coordinates, where r' is along p: v_s = r' e_r, r'' = 0 and theta'' = -r' theta' / r.
#[test]
fn the_curvature_of_a_twist_is_the_acceleration_of_joints_that_follow_it() {
    let period = 1e-4;
    let mut acceptor =
        Acceptor::new(Polar(Turntable::new().limits), Pose::identity(), Two::zeros(), REACTION);
    acceptor.state.position = Two::new(0.7, 0.5);
    acceptor.state.velocity = Two::new(0.4, 0.3);
    acceptor.look_along_twist(period);
    let found = acceptor.curvature();
    // Differences over steps are those of their middles: off by less than the change in a step.
    assert!((found[0] + 0.3 * 0.4 / 0.5).abs() < 1e-4 && found[1].abs() < 1e-4, "{found}");
    // It is that at the present speed: of half the speed a quarter.
    acceptor.state.velocity = Two::new(0.2, 0.15);
    near(acceptor.curvature()[0], 0.25 * found[0]);
    // It holds for 16 ms.
    acceptor.state.velocity = Two::new(0.4, -0.3);
    for _ in 0..159 {
        acceptor.look_along_twist(period);
        near(acceptor.curvature()[0], found[0]);
    }
    acceptor.look_along_twist(period);
    let found = acceptor.curvature();
    assert!((found[0] - 0.3 * 0.4 / 0.5).abs() < 1e-4 && found[1].abs() < 1e-4, "{found}");
    acceptor.leave_twist();
    assert_eq!(acceptor.curvature(), Two::zeros());
}
