//! Joint trajectories as other programs plan them: scipy's polynomials between their points, what is refused, and robots that are given another one, or
//! brought to rest, at any time.

use mrroc::generator::Generator;
use mrroc::prelude::*;
use mrroc::random::Random;
use mrroc_generators::generators::FollowTrajectory;
use mrroc_generators::rehearsal::at_rest;
use mrroc_generators::trajectory::*;
use mrroc_robots::{Irp6, Six};
use std::collections::BTreeMap;

use crate::usage::reference::rows;

const DT: f64 = 0.002;

/// A joint that nothing limits.
const FREE: JointBounds = JointBounds {
    lower: f64::NEG_INFINITY,
    upper: f64::INFINITY,
    velocity: f64::INFINITY,
    acceleration: f64::INFINITY,
    jerk: f64::INFINITY,
};

fn point(time: f64, positions: &[f64]) -> TrajectoryPoint {
    TrajectoryPoint { time, positions: positions.to_vec(), ..TrajectoryPoint::default() }
}

#[test]
fn between_points_it_is_what_scipy_makes_of_them() {
    type Case = BTreeMap<String, Vec<Vec<f64>>>;
    let mut cases: BTreeMap<(String, String), Case> = BTreeMap::new();
    for (label, numbers) in rows("trajectories.csv", 3) {
        let case = cases.entry((label[0].clone(), label[1].clone())).or_default();
        case.entry(label[2].clone()).or_default().push(numbers);
    }
    assert_eq!(cases.len(), 60);
    for ((kind, _), case) in &cases {
        let points = case["point"].iter().map(|told| TrajectoryPoint {
            time: told[0],
            positions: vec![told[1]],
            velocities: if kind == "bare" { vec![] } else { vec![told[2]] },
            accelerations: if kind == "five" { vec![told[3]] } else { vec![] },
        });
        let trajectory = JointTrajectory::new(vec![FREE], points.collect()).expect("sound");
        let [position, velocity, acceleration] = case["start"][0][..] else { panic!("{case:?}") };
        let path = TimedPath::from(&trajectory, &[JointState { position, velocity, acceleration }]);
        let path = path.expect("without limits");
        for at in &case["at"] {
            for (actual, expected) in path.at(at[0], 0).into_iter().zip(&at[1..]) {
                assert!((actual - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{kind} {at:?}: {actual}");
            }
        }
    }
}

#[test]
fn points_that_are_no_trajectory_are_refused_by_what_is_wrong_with_them() {
    let two = vec![FREE; 2];
    let refused = |points: Vec<TrajectoryPoint>| {
        JointTrajectory::new(two.clone(), points).expect_err("it is no trajectory").to_string()
    };
    assert_eq!(refused(vec![]), "the trajectory has no points");
    assert_eq!(refused(vec![point(1.0, &[0.0])]), "point 1 has 1 values for 2 joints");
    for value in [f64::NAN, f64::INFINITY] {
        let points = vec![point(0.0, &[0.0; 2]), point(1.0, &[0.0, value])];
        assert_eq!(refused(points), "point 2 has a value that is no finite number, for joint 2");
    }
    for times in [[0.0, 0.0], [1.0, 0.5], [-0.1, 0.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
        let told = refused(times.map(|time| point(time, &[0.0; 2])).to_vec());
        assert!(told.contains("times must rise from point to point"), "{told}");
    }
    let fast =
        |time, velocity: f64| TrajectoryPoint { velocities: vec![0.0, velocity], ..point(time, &[0.0; 2]) };
    assert!(
        refused(vec![point(0.0, &[0.0; 2]), fast(1.0, 0.0)]).contains("all points have velocities, or none")
    );
    let alone = TrajectoryPoint { accelerations: vec![0.0; 2], ..point(1.0, &[0.0; 2]) };
    assert!(refused(vec![alone]).contains("accelerations, which need velocities"));
    assert!(refused(vec![fast(1.0, 0.2)]).contains("the robots must be at rest there"));
    let wrong = JointBounds { velocity: -1.0, ..FREE };
    for limits in [vec![], vec![wrong], vec![FREE; MOST_JOINTS + 1]] {
        let told = JointTrajectory::new(limits, vec![point(1.0, &[0.0])]);
        assert!(matches!(told, Err(TrajectoryError::Limits { .. })), "{told:?}");
    }
}

#[test]
fn a_path_beyond_a_limit_or_from_elsewhere_is_refused_and_one_at_its_share_is_not() {
    // A quintic from rest to rest: 15/8 D/T, 10/sqrt(3) D/T^2, 60 D/T^3 at most.
    let (distance, time) = (0.3, 0.9);
    let most = [
        1.875 * distance / time,
        10.0 / 3.0_f64.sqrt() * distance / f64::powi(time, 2),
        60.0 * distance / f64::powi(time, 3),
    ];
    let made = |share: f64, which: usize, at: f64| {
        let limit = |k: usize| if k == which { most[k] * share } else { 2.0 * most[k] };
        let limits = JointBounds {
            lower: -0.1,
            upper: distance + 0.1,
            velocity: limit(0),
            acceleration: limit(1) / SHARE,
            jerk: limit(2) / JERK_SHARE,
        };
        let points = [0.0, time].map(|at| TrajectoryPoint {
            velocities: vec![0.0],
            accelerations: vec![0.0],
            ..point(at, &[distance * at / time])
        });
        TimedPath::from(
            &JointTrajectory::new(vec![limits], points.to_vec()).expect("sound"),
            &[JointState::resting(at)],
        )
    };
    for (which, name) in ["velocity", "acceleration", "jerk"].into_iter().enumerate() {
        made(1.0 + 1e-5, which, 0.0).expect("at the limit");
        let told = made(1.0 - 1e-3, which, 0.0).expect_err("beyond it").to_string();
        assert!(
            told.starts_with(&format!("joint 1: {name} ")) && told.contains("on the way to point 2"),
            "{told}"
        );
    }
    let told = made(2.0, 0, 0.02).expect_err("it is elsewhere").to_string();
    assert_eq!(
        told,
        "joint 1 is at 0.020000, the trajectory begins at 0.000000: plan from where the robot is"
    );
    // A little beside it, it comes to the same end.
    let path = made(2.0, 0, 0.002).expect("near enough");
    assert_eq!(path.at(0.0, 0), [0.002, 0.0, 0.0]);
    assert!((path.at(time, 0)[0] - distance).abs() < 1e-12);
    // Below its lower limit in between: velocities that make it swing back.
    let swings = [(0.0, 0.0), (0.5, -2.0), (1.0, 0.0)];
    let swings = swings.map(|(at, v)| TrajectoryPoint { velocities: vec![v], ..point(at, &[0.0]) });
    let limits = JointBounds { lower: -0.1, upper: 1.0, ..FREE };
    let swings = JointTrajectory::new(vec![limits], swings.to_vec()).expect("sound");
    let told = TimedPath::from(&swings, &[JointState::resting(0.0)]).expect_err("it swings").to_string();
    assert!(told.starts_with("joint 1: position -0.1"), "{told}");
    // Degree 3 has steps of the acceleration, which a joint with a limit of jerk cannot take.
    let limits = JointBounds { acceleration: 10.0, jerk: 1e3, ..FREE };
    let cubic =
        [(0.0, 0.0), (1.0, 0.1)].map(|(at, q)| TrajectoryPoint { velocities: vec![0.0], ..point(at, &[q]) });
    let cubic = JointTrajectory::new(vec![limits], cubic.to_vec()).expect("sound");
    let told = TimedPath::from(&cubic, &[JointState::resting(0.0)]).expect_err("a step").to_string();
    assert!(told.starts_with("joint 1: step of the acceleration 0.6"), "{told}");
}

/// Robots of a group, which do exactly as they are told.
struct Rig {
    group: TrajectoryGroup,
    motions: Vec<FollowTrajectory<Irp6>>,
    joints: Vec<Six>,
    steps: u64,
}

const NAMES: [&str; 2] = ["left", "right"];

impl Rig {
    fn new() -> Rig {
        let group = TrajectoryGroup::new(&NAMES);
        let motions = NAMES.map(|name| group.motion(name).expect("it has one"));
        let mut rig = Rig { group, motions: motions.into(), joints: vec![Irp6::READY; 2], steps: 0 };
        rig.go(DT);
        rig
    }

    /// A step of `dt` \[s\] of path time; what is demanded of both robots, or nothing where their motion is over.
    fn go(&mut self, dt: f64) -> bool {
        let t = Tick { step: self.steps, dt, duration: DT };
        let (order, reading) = (Order::new(()), Reading::new(()));
        for (motion, joints) in self.motions.iter_mut().zip(&mut self.joints) {
            let e = State::new(at_rest(&Irp6::nominal(), *joints));
            let told = if t.step == 0 {
                motion.first_step(&order, &e, &reading, t)
            } else {
                motion.next_step(&order, &e, &reading, t)
            };
            match told.expect("no fault") {
                Step::Next(demand) => *joints = demand.as_joints().expect("joints"),
                Step::Done => return false,
            }
        }
        self.steps += 1;
        true
    }

    fn both(&self) -> Vec<f64> {
        self.joints.iter().flat_map(|joints| joints.as_slice().to_vec()).collect()
    }

    fn is_moving(&self) -> bool {
        self.group.following() > 0
    }
}

/// Limits of joints that make nothing of the IRp-6's own.
fn limits(jerk: f64) -> JointBounds {
    JointBounds { lower: -10.0, upper: 10.0, velocity: 1.5, acceleration: 4.0, jerk }
}

/// The same points, so many times as late.
fn stretched(trajectory: &JointTrajectory, by: f64) -> JointTrajectory {
    let points = trajectory.points().iter();
    let later = points.map(|told| TrajectoryPoint { time: by * told.time, ..told.clone() });
    JointTrajectory::new(trajectory.limits().to_vec(), later.collect()).expect("sound")
}

/// A trajectory of `joints` joints that begins `wait` after now and goes through a few random points, as fast as the limits allow, about.
fn random(from: &[f64], limits: JointBounds, seed: u64) -> JointTrajectory {
    let mut random = Random::seeded(seed);
    let count = 1 + random.below(4);
    let mut points = Vec::new();
    let mut time = 0.0;
    for _ in 0..count {
        time += random.between(0.5, 1.2);
        let positions: Vec<f64> = from.iter().map(|q| q + random.within(0.3)).collect();
        points.push(point(time, &positions));
    }
    // The shortest time in which it is within the limits, by halving.
    let as_told = JointTrajectory::new(vec![limits; from.len()], points).expect("sound");
    let made = |scale: f64| stretched(&as_told, scale);
    let rests: Vec<_> = from.iter().copied().map(JointState::resting).collect();
    let (mut short, mut long) = (0.05, 20.0);
    for _ in 0..40 {
        let scale = 0.5 * (short + long);
        match TimedPath::from(&made(scale), &rests) {
            Ok(_) => long = scale,
            Err(_) => short = scale,
        }
    }
    made(long)
}

/// The largest acceleration and jerk that a joint was asked for, as an EDP sees them: by differences of demands.
fn largest(demands: &[Vec<f64>]) -> [f64; 3] {
    let mut most = [0.0_f64; 3];
    for joint in 0..demands[0].len() {
        let mut values: Vec<f64> = demands.iter().map(|demand| demand[joint]).collect();
        for most in &mut most {
            values = values.windows(2).map(|pair| (pair[1] - pair[0]) / DT).collect();
            *most = values.iter().fold(*most, |most, value| most.max(value.abs()));
        }
    }
    most
}

/// Brings both robots to rest on one trajectory, at an instant of it.
fn halted(limits: JointBounds, seed: u64, share: f64) -> (Vec<Vec<f64>>, TimedPath, usize) {
    let mut rig = Rig::new();
    let from = rig.both();
    let trajectory = random(&from, limits, seed);
    rig.group.begin(&NAMES, &trajectory).expect("within the limits");
    let rests: Vec<_> = from.iter().copied().map(JointState::resting).collect();
    let path = TimedPath::from(&trajectory, &rests).expect("the same");
    let at = (share * path.duration() / DT) as usize;
    let mut demands = vec![from; 3];
    for _ in 0..at {
        rig.go(DT);
        demands.push(rig.both());
    }
    rig.group.halt("right").expect("it is there");
    while rig.is_moving() {
        rig.go(DT);
        demands.push(rig.both());
    }
    let outcomes = NAMES.map(|name| rig.group.outcome(name).expect("it is there"));
    assert!([[Some(Outcome::Halted); 2], [Some(Outcome::Done); 2]].contains(&outcomes), "{outcomes:?}");
    demands.extend(vec![rig.both(); 3]);
    (demands, path, at)
}

#[test]
fn robots_come_to_rest_on_their_path_within_their_limits_whenever_they_are_halted() {
    for (jerk, seeds) in [(f64::INFINITY, 0..60), (60.0, 100..160)] {
        let limits = limits(jerk);
        let (mut worst, mut before_the_end) = ([0.0_f64; 3], 0);
        for seed in seeds.clone() {
            for k in 0..8 {
                let share = 0.02 + 0.9 * (f64::from(k) + Random::seeded(seed).unit()) / 8.0;
                let (demands, path, at) = halted(limits, seed, share);
                let most = largest(&demands);
                for (worst, most) in worst.iter_mut().zip(most) {
                    *worst = worst.max(most);
                }
                // The halt is on the path: one path time that only grows explains all joints of each step.
                let mut time = at as f64 * DT;
                for demand in &demands[3 + at..demands.len() - 3] {
                    time = path_time(&path, demand, time - 0.1 * DT, time + 1.1 * DT);
                }
                if time < path.duration() - 0.1 {
                    before_the_end += 1;
                }
                // By what the acceleration leaves at a rate r, (0.9 - 0.8 r^2) A: the integral from 1 to 0 of dr over that is 2.077.
                let steps = demands.len() - 6 - at;
                if jerk.is_infinite() {
                    let fastest = 2.077 * limits.velocity / limits.acceleration;
                    assert!(steps as f64 * DT <= fastest + 3.0 * DT, "seed {seed}, {share}: {steps} steps");
                }
            }
        }
        assert!(worst[0] <= limits.velocity && worst[1] <= 0.92 * limits.acceleration, "{worst:?}");
        assert!(worst[2] <= 0.95 * jerk, "{worst:?}");
        assert!(before_the_end > 4 * seeds.count(), "{before_the_end} of jerk {jerk}");
    }
}

/// The path time at which all joints are where they are demanded to be, between two times.
fn path_time(path: &TimedPath, demand: &[f64], least: f64, most: f64) -> f64 {
    let off = |time: f64| {
        let joints = demand.iter().enumerate().map(|(joint, q)| (path.at(time, joint)[0] - q).powi(2));
        joints.sum::<f64>().sqrt()
    };
    // Gauss' and Newton's method on the square of the distance, from the beginning: at its end the path has no velocity.
    let mut time = least;
    for _ in 0..30 {
        let (mut slope, mut bend) = (0.0, 0.0);
        for (joint, q) in demand.iter().enumerate() {
            let [position, velocity, _] = path.at(time, joint);
            slope += (position - q) * velocity;
            bend += velocity * velocity;
        }
        if bend > 0.0 {
            time = (time - slope / bend).clamp(least, most);
        }
    }
    assert!(off(time) < 1e-9, "off by {} between {least} and {most}", off(time));
    time
}

#[test]
fn another_trajectory_replaces_one_at_any_time_without_a_step_of_velocity_or_acceleration() {
    for (jerk, seeds) in [(f64::INFINITY, 0..100), (60.0, 100..200)] {
        let limits = limits(jerk);
        let (mut replaced, mut refused) = (0, 0);
        for seed in seeds {
            let mut random_ = Random::seeded(1000 + seed);
            let mut rig = Rig::new();
            let mut demands = vec![rig.both(); 3];
            rig.group.begin(&NAMES, &random(&rig.both(), limits, seed)).expect("within the limits");
            for round in 0..4 {
                for _ in 0..30 + random_.below(300) {
                    rig.go(DT);
                    demands.push(rig.both());
                }
                let next = random(&rig.both(), limits, seed + 10_000 * (round + 1));
                let next = stretched(&next, 1.6);
                if round == 2 {
                    rig.group.halt("left").expect("it is there");
                    for _ in 0..random_.below(60) {
                        rig.go(DT);
                        demands.push(rig.both());
                    }
                }
                match rig.group.begin(&NAMES, &next) {
                    Ok(()) => replaced += 1,
                    Err(TrajectoryError::Limit { .. }) => refused += 1,
                    Err(other) => panic!("{other}"),
                }
            }
            while rig.is_moving() {
                rig.go(DT);
                demands.push(rig.both());
            }
            demands.extend(vec![rig.both(); 3]);
            let most = largest(&demands);
            assert!(most[0] <= limits.velocity * (1.0 + 1e-9), "seed {seed}: {most:?}");
            assert!(most[1] <= 0.92 * limits.acceleration, "seed {seed}: {most:?}");
            assert!(most[2] <= 0.95 * jerk, "seed {seed}: {most:?}");
        }
        assert!(replaced > 200, "{replaced} replaced, {refused} refused, of jerk {jerk}");
    }
}

#[test]
fn robots_that_hardly_move_as_after_a_suspension_stand_at_once_when_they_are_halted() {
    for (jerk, share) in [(f64::INFINITY, 0.012), (60.0, 1e-4)] {
        let mut rig = Rig::new();
        rig.group.begin(&NAMES, &random(&rig.both(), limits(jerk), 3)).expect("within the limits");
        for _ in 0..150 {
            rig.go(DT);
        }
        // The rate of path time has fallen to 0, and rises again.
        rig.go(share * DT);
        rig.group.halt("left").expect("it is there");
        let before = rig.both();
        rig.go(2.0 * share * DT);
        assert_eq!((rig.both(), rig.is_moving()), (before, false), "jerk {jerk}");
        assert_eq!(rig.group.outcome("right"), Ok(Some(Outcome::Halted)));
    }
}

#[test]
fn a_trajectory_that_has_begun_is_joined_where_it_is_now_and_no_other_line_is_gone() {
    let swing = |time: f64| {
        let s = time / 2.0;
        0.3 * s.powi(3) * (10.0 + s * (6.0 * s - 15.0))
    };
    let points: Vec<_> = (0..=20).map(|k| point(0.1 * f64::from(k), &[swing(0.1 * f64::from(k))])).collect();
    let made = |passed: f64, at: f64| {
        let trajectory = JointTrajectory::new(vec![limits(f64::INFINITY)], points.clone()).expect("sound");
        TimedPath::from(&trajectory.passed(passed), &[JointState::resting(at)])
    };
    for passed in [0.0, 0.005, 0.15, 0.4] {
        let path = made(passed, swing(passed) + 0.001).expect("near enough");
        assert!((path.at(0.0, 0)[0] - swing(passed) - 0.001).abs() < 1e-9);
        for later in [0.6, 1.0, 1.4] {
            assert!((path.at(later, 0)[0] - swing(passed + later)).abs() < 1e-4, "{passed} {later}");
        }
        let refused = made(passed, swing(passed) + 0.3);
        assert!(matches!(refused, Err(TrajectoryError::Start { joint: 1, .. })), "{passed}: {refused:?}");
    }
    // One that begins with an acceleration is not bent where a step of it is allowed.
    let parabola = [0.0, 0.5, 1.0].map(|time: f64| TrajectoryPoint {
        velocities: vec![if time < 1.0 { 2.0 * time } else { 0.0 }],
        accelerations: vec![if time < 0.5 { 2.0 } else { -2.0 }],
        ..point(time, &[if time < 1.0 { time * time } else { 0.75 }])
    });
    let parabola = JointTrajectory::new(vec![FREE], parabola.to_vec()).expect("sound");
    let path = TimedPath::from(&parabola, &[JointState::resting(0.0)]).expect("without limits");
    assert!((path.at(0.0, 0)[2] - 2.0).abs() < 1e-12 && path.at(1e-3, 0)[0] > 0.99e-6);
}

#[test]
fn trapezoids_sampled_as_moveit_does_are_taken_at_the_share_that_is_written_for_it() {
    let limits = limits(f64::INFINITY);
    // As `joint_limits.yaml` of the bridge to ROS 2 has them.
    let (velocity, acceleration) = (0.98 * limits.velocity, SHARE / 1.78 * limits.acceleration);
    let mut random = Random::seeded(21);
    for case in 0..2000 {
        let distance = random.between(0.01, 2.0);
        let (speed, rise) = if distance > velocity * velocity / acceleration {
            (velocity, velocity / acceleration)
        } else {
            ((distance * acceleration).sqrt(), (distance / acceleration).sqrt())
        };
        let duration = distance / speed + rise;
        let at = |time: f64| {
            let left = duration - time;
            if time < rise {
                [
                    0.5 * acceleration * time * time,
                    acceleration * time,
                    if time > 0.0 { acceleration } else { 0.0 },
                ]
            } else if left < rise {
                [distance - 0.5 * acceleration * left * left, acceleration * left, -acceleration]
            } else {
                [speed * (time - 0.5 * rise), speed, 0.0]
            }
        };
        let mut times: Vec<f64> =
            (0..).map(|k| 0.1 * f64::from(k)).take_while(|time| duration - time > 1e-3).collect();
        times.push(duration);
        let points = times.iter().map(|&time| {
            let [q, v, a] = at(time);
            TrajectoryPoint { velocities: vec![v], accelerations: vec![a], ..point(time, &[q]) }
        });
        let trajectory = JointTrajectory::new(vec![limits], points.collect()).expect("sound");
        let taken = TimedPath::from(&trajectory, &[JointState::resting(0.0)]);
        assert!(taken.is_ok(), "case {case}, {distance} m: {taken:?}");
    }
}

#[test]
fn robots_of_one_trajectory_are_one_and_others_go_their_own_ways() {
    let mut rig = Rig::new();
    let of = |robots: usize, seed| random(&vec![0.0; 6 * robots], limits(f64::INFINITY), seed);
    let from =
        |rig: &Rig, robot: usize, seed| random(rig.joints[robot].as_slice(), limits(f64::INFINITY), seed);
    rig.group.begin(&["left"], &from(&rig, 0, 1)).expect("free");
    rig.group.begin(&["right"], &from(&rig, 1, 2)).expect("free");
    assert_eq!(
        rig.group.begin(&["left"], &of(2, 1)),
        Err(TrajectoryError::Joints { expected: 12, actual: 6 })
    );
    let nobody = TrajectoryError::Robot("nobody".to_owned());
    assert_eq!(rig.group.begin(&["nobody"], &of(1, 1)), Err(nobody.clone()));
    assert_eq!(rig.group.halt("nobody"), Err(nobody));
    assert_eq!(rig.group.begin(&["left", "left"], &of(2, 1)), Err(TrajectoryError::Robot("left".to_owned())));
    for _ in 0..40 {
        rig.go(DT);
    }
    // One halts, and the other goes on; then one trajectory takes both.
    rig.group.halt("left").expect("it is there");
    let both = random(&rig.both(), limits(f64::INFINITY), 3);
    let both = stretched(&both, 2.0);
    while rig.group.outcome("left") == Ok(None) {
        assert_eq!(rig.group.outcome("right"), Ok(None));
        rig.go(DT);
    }
    assert_eq!(rig.group.outcome("left"), Ok(Some(Outcome::Halted)));
    rig.group.begin(&NAMES, &both).expect("slow enough");
    assert_eq!(rig.group.following(), 2);
    assert_eq!(
        rig.group.begin(&["right"], &from(&rig, 1, 4)),
        Err(TrajectoryError::Shared("right".to_owned()))
    );
    rig.group.finish();
    while rig.go(DT) {}
    for name in NAMES {
        assert_eq!(rig.group.outcome(name), Ok(Some(Outcome::Done)));
    }
    let ends: Vec<f64> = both.points().last().expect("points").positions.clone();
    assert!(rig.both().iter().zip(&ends).all(|(q, end)| (q - end).abs() < 1e-12));
    let over = rig.group.begin(&NAMES, &both);
    assert_eq!(over, Err(TrajectoryError::NotFollowing("left".to_owned())));
}

#[test]
fn what_has_passed_is_left_out_and_what_is_to_begin_later_is_waited_for() {
    let one = |passed: f64| {
        let points = [(0.5, 0.1), (1.0, 0.2), (2.0, 0.4)].map(|(time, q)| point(time, &[q]));
        let trajectory = JointTrajectory::new(vec![FREE], points.to_vec()).expect("sound").passed(passed);
        TimedPath::from(&trajectory.starting_within(1.0), &[JointState::resting(0.0)])
    };
    for (passed, duration) in [(0.0, 2.0), (0.3, 1.7), (0.7, 1.3), (1.999, 0.001)] {
        assert!((one(passed).expect("some is left").duration() - duration).abs() < 1e-12);
    }
    assert_eq!(one(2.0), Err(TrajectoryError::Past { duration: 2.0, passed: 2.0 }));
    let mut rig = Rig::new();
    let trajectory = random(Irp6::READY.as_slice(), limits(f64::INFINITY), 5);
    rig.group.begin_after(&["left"], &trajectory, 100.0 * DT).expect("at rest");
    let mut moved = 0;
    for step in 1.. {
        if (rig.joints[0] - Irp6::READY).amax() > 1e-12 && moved == 0 {
            moved = step - 1;
        }
        if !rig.is_moving() {
            break;
        }
        rig.go(DT);
    }
    assert_eq!(moved, 101);
    // What waits is halted at once.
    rig.group
        .begin_after(&["right"], &random(Irp6::READY.as_slice(), limits(f64::INFINITY), 6), 1.0)
        .expect("at rest");
    rig.group.halt("right").expect("it is there");
    rig.go(DT);
    assert_eq!(rig.group.outcome("right"), Ok(Some(Outcome::Halted)));
    assert_eq!(rig.joints[1], Irp6::READY);
}
