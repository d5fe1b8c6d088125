//! All profiles of a path scalar, against closed forms.

use mrroc_generators::profile::*;

const LIMITS: JerkLimits = JerkLimits { velocity: 0.7, acceleration: 2.3, jerk: 19.0 };
const PLAIN: ProfileLimits = ProfileLimits { velocity: 0.7, acceleration: 2.3 };

/// At rest outside, exact at the end, derivatives those of the positions, limits kept; then the same when stretched.
fn keeps_its_word<P: Profile + Clone>(profile: &P, velocity: f64, acceleration: f64) {
    let (d, t) = (profile.distance(), profile.duration());
    assert_eq!(profile.at(-1.0).s, 0.0);
    assert_eq!(profile.at(t), ProfilePoint { s: d, v: 0.0, a: 0.0 });
    assert!((profile.at(t.next_down()).s - d).abs() < 1e-12 * (1.0 + d));
    let h = 1e-6 * t;
    for i in 1..500 {
        let x = (f64::from(i) + 0.123) * t / 500.1;
        let (before, here, after) = (profile.at(x - h), profile.at(x), profile.at(x + h));
        assert!(here.v <= velocity * (1.0 + 1e-12) && here.a.abs() <= acceleration * (1.0 + 1e-12));
        assert!(((after.s - before.s) / (2.0 * h) - here.v).abs() < 1e-5 * velocity, "{x} of {t}");
        if acceleration.is_finite() {
            assert!(((after.v - before.v) / (2.0 * h) - here.a).abs() < 1e-3 * acceleration, "{x} of {t}");
        }
    }
    let slow = profile.clone().stretched_to(1.7 * t).unwrap();
    for i in 0..=50 {
        let x = f64::from(i) * 0.02 * t;
        let (there, here) = (slow.at(1.7 * x), profile.at(x));
        assert!((there.s - here.s).abs() < 1e-12 * (1.0 + d));
        if i < 50 && i > 0 {
            assert!((there.v * 1.7 - here.v).abs() < 1e-9 * velocity);
        }
    }
    assert!(profile.clone().stretched_to(0.9 * t).is_err());
    let mut cursor = profile.clone().cursor();
    let points: Vec<_> = std::iter::from_fn(|| cursor.advance(1e-3)).collect();
    assert_eq!(points.last().unwrap().s, d);
    assert_eq!(points.len(), (t / 1e-3 - 1e-9).ceil() as usize);
}

#[test]
fn every_profile_keeps_its_word() {
    for d in [1e-3, 0.1, 0.5, 3.0] {
        keeps_its_word(&Rectangular::new(d, 0.7).unwrap(), 0.7, f64::INFINITY);
        keeps_its_word(&Trapezoid::new(d, PLAIN).unwrap(), 0.7, 2.3);
        keeps_its_word(&Trapezoid::triangular(d, 2.3).unwrap(), 9.0, 2.3);
        keeps_its_word(&Cubic::new(d, PLAIN).unwrap(), 0.7, 2.3);
        keeps_its_word(&Quintic::new(d, LIMITS).unwrap(), 0.7, 2.3);
        keeps_its_word(&SevenPhase::new(d, LIMITS).unwrap(), 0.7, 2.3);
    }
}

#[test]
fn durations_equal_the_closed_forms() {
    let close = |x: f64, y: f64| assert!((x - y).abs() < 1e-12, "{x} {y}");
    close(Rectangular::new(1.4, 0.7).unwrap().duration(), 2.0);
    close(Trapezoid::triangular(3.0, 1.0).unwrap().duration(), 12.0_f64.sqrt());
    // A short distance is limited by the acceleration (quintic: by the jerk), a long one by the velocity.
    close(Cubic::new(0.01, PLAIN).unwrap().duration(), (0.06_f64 / 2.3).sqrt());
    close(Cubic::new(7.0, PLAIN).unwrap().duration(), 15.0);
    close(Quintic::new(0.001, LIMITS).unwrap().duration(), (0.06_f64 / 19.0).cbrt());
    close(Quintic::new(5.6, LIMITS).unwrap().duration(), 15.0);
    close(SevenPhase::new(7.0, LIMITS).unwrap().duration(), 10.0 + 0.7 / 2.3 + 2.3 / 19.0);
    close(SevenPhase::new(1e-3, LIMITS).unwrap().duration(), 4.0 * (1e-3_f64 / 38.0).cbrt());
}

/// Corke's robotics toolbox: `quintic(0, 1, 9)`.
#[test]
fn the_quintic_equals_the_robotics_toolbox() {
    let limits = JerkLimits { velocity: 15.0 / 64.0, acceleration: f64::INFINITY, jerk: f64::INFINITY };
    let quintic = Quintic::new(1.0, limits).unwrap();
    assert!((quintic.duration() - 8.0).abs() < 1e-12);
    let expected = [0.0, 0.016_052_246_093_75, 0.103_515_625, 0.275_207_519_531_25, 0.5];
    for (t, s) in expected.into_iter().enumerate() {
        assert!((quintic.at(t as f64).s - s).abs() < 1e-14, "t = {t}");
    }
}

#[test]
fn no_distance_takes_no_time_and_what_is_no_limit_is_refused() {
    let points = [
        Rectangular::new(0.0, 1.0).unwrap().at(0.0),
        Cubic::new(0.0, PLAIN).unwrap().at(0.0),
        Quintic::new(0.0, LIMITS).unwrap().at(0.0),
        SevenPhase::new(0.0, LIMITS).unwrap().at(0.0),
    ];
    assert_eq!(points, [ProfilePoint::default(); 4]);
    for bad in [0.0, -1.0, f64::NAN] {
        let plain = ProfileLimits { acceleration: bad, ..PLAIN };
        assert!(matches!(Rectangular::new(1.0, bad), Err(ProfileError::Velocity(_))));
        assert!(matches!(Cubic::new(1.0, plain), Err(ProfileError::Acceleration(_))));
        assert!(matches!(Quintic::new(1.0, JerkLimits { jerk: bad, ..LIMITS }), Err(ProfileError::Jerk(_))));
        assert!(matches!(
            SevenPhase::new(1.0, JerkLimits { jerk: bad, ..LIMITS }),
            Err(ProfileError::Jerk(_))
        ));
    }
    assert!(matches!(Rectangular::new(1e300, 1e-300), Err(ProfileError::Precision(_))));
    assert!(Rectangular::new(f64::INFINITY, 1.0).is_err() && Cubic::new(-1.0, PLAIN).is_err());
}
