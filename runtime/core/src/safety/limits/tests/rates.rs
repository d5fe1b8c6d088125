//! How fast the rate may change, and how fast robots slow down on their screw.

use super::*;
use crate::safety::braking::BrakingLaw;

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
    let headroom = acceptor.headroom();
    near(headroom.rise, 0.08 * 10.0 / 0.32);
    near(headroom.fall, 0.08 * 10.0 / 0.32);
    assert_eq!(headroom.bend, f64::INFINITY);
    // At half the rate, which may be 0.51 at the end of a step in which it rises by 5 / s.
    acceptor.pace.rate = 0.5;
    near(acceptor.headroom().fall, (0.98 - 0.9 * 0.25) * 10.0 / 0.32);
    near(acceptor.headroom().rise, (0.98 - 0.9 * 0.51 * 0.51) * 10.0 / 0.32);
    // Where two of three demands are lost, a ninth.
    acceptor.pace.bridged = 2.0;
    near(acceptor.headroom().fall, (0.98 - 0.9 * 0.25) * 10.0 / 9.0 / 0.32);
    // The joint that leaves less counts: 20 / (2.0 + 0.04).
    (acceptor.pace.bridged, acceptor.pace.path_speed[1]) = (0.0, 2.0);
    near(acceptor.headroom().fall, (0.98 - 0.9 * 0.25) * 20.0 / 2.04);
}

#[test]
fn with_a_jerk_limit_the_rate_may_change_by_what_a_path_leaves_of_that_as_well() {
    // Of 0.08 j a half for 3 r' q'', with q'' = 0.9 a, a half for r'' q', with q' = v + a T.
    let headroom = moving(Turntable::with_jerk(100.0, 1e6)).headroom();
    near(headroom.rise, 0.04 * 100.0 / (3.0 * 0.9 * 10.0));
    near(headroom.fall, 0.04 * 100.0 / (3.0 * 0.9 * 10.0));
    near(headroom.bend, 0.04 * 100.0 / 0.32);
    let headroom = moving(Turntable::with_jerk(1e4, 1e6)).headroom();
    near(headroom.fall, 0.08 * 10.0 / 0.32);
    near(headroom.bend, 0.04 * 1e4 / 0.32);
}

#[test]
fn a_robot_slows_down_on_a_screw_by_the_share_of_its_acceleration() {
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
