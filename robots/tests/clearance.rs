//! Clearances of whole cells: which bodies are nearest, which are named, and what is refused.

use std::cell::RefCell;
use std::f64::consts::{FRAC_PI_2, PI};
use std::rc::Rc;
use std::time::Duration;

use mrroc::fault::Name;
use mrroc::prelude::*;
use mrroc::robot::RobotView;
use mrroc_robots::clearance::{
    Against, Capsule, CheckError, Clearance, ClearanceError, DryRun, KnownPath, Obstacle, Outline, Stop,
    Stopping, Stretch, TooClose, smallest_distance,
};
use mrroc_robots::{Five, Irp6, Irp6FiveDof, Irp6Track, Kinematics, Polycrank, Rnt, Seven, Simulated, Six};
use nalgebra::{SVector, Vector3};

/// Stretched forwards, its tool level: theta2 = -90 deg, theta3 = theta4 = 0.
const LEVEL: [f64; 6] = [0.0, -FRAC_PI_2, 0.0, 0.0, FRAC_PI_2 * 3.0, 0.0];

const AT_ONCE: Stopping = Stopping { reaction: 0.0, stop: Stop::Braking };

fn state(name: &str, q: &[f64], velocity: &[f64]) -> RobotView {
    let padded = |values: &[f64]| core::array::from_fn(|i| values.get(i).copied().unwrap_or_default());
    let state = mrroc::sensor::EffectorState {
        joints: padded(q),
        velocity: padded(velocity),
        pose: Pose::identity(),
        wrench: None,
    };
    RobotView { name: Name::new(name).unwrap(), measured: state, demanded: state }
}

/// Two IRp-6 that face one another along x, their shoulders `apart` \[m\], 1 m above the floor.
fn facing(apart: f64) -> (Irp6, Irp6) {
    let left = Irp6::nominal().with_base(Pose::translation(0.0, 0.0, 1.0));
    let right = Irp6::nominal().with_base(Pose::new(Vector3::new(apart, 0.0, 1.0), Vector3::z() * PI));
    (left, right)
}

/// A rod of 0.2 m on the flange, along the tool.
fn rod() -> [Capsule; 1] {
    [Capsule::new(Vector3::zeros(), Vector3::new(0.0, 0.0, 0.2), 0.02)]
}

fn two_arms(apart: f64, stopping: Stopping) -> Result<Clearance, ClearanceError> {
    let (left, right) = facing(apart);
    Clearance::with_margin(0.05)
        .robot("left", left)?
        .robot("right", right)?
        .tool("left", &rod())?
        .tool("right", &rod())?
        .obstacle("floor", Obstacle::table(-1.0))?
        .build(stopping)
}

#[test]
fn tools_of_two_arms_that_face_one_another_are_as_far_apart_as_direct_kinematics_says() {
    let (left, right) = facing(2.8);
    let mut clearance = two_arms(2.8, AT_ONCE).unwrap();
    // Tools down, both flanges 0.86 m in front of their shoulders: 2.8 - 2 x 0.86 m between the flanges.
    let q = Six::from(LEVEL);
    let [a, b] = [&left, &right].map(|arm| arm.forward(&q).translation.vector);
    assert!((a - Vector3::new(0.86, 0.0, 1.455)).amax() < 1e-12);
    assert!((b - Vector3::new(1.94, 0.0, 1.455)).amax() < 1e-12);
    let nearest = clearance.nearest_at(&[&LEVEL, &LEVEL]).unwrap();
    // The wrists' capsules end in the flanges, 0.06 m stout; the tools are 0.02 m.
    assert!((nearest.distance - ((b - a).norm() - 0.12)).abs() < 1e-12, "{nearest:?}");
    assert_eq!(nearest.sides.each_ref().map(|side| side.to_string()), ["left wrist", "right wrist"]);
    // T down and V turned: tools level and on one line, 0.2 m from each flange.
    let mut towards = q;
    (towards[3], towards[4]) = (FRAC_PI_2, FRAC_PI_2);
    let [a, b] = [&left, &right].map(|arm| arm.forward(&towards) * Pose::translation(0.0, 0.0, 0.2));
    let tips = b.translation.vector - a.translation.vector;
    assert!((tips - Vector3::new(2.8 - 2.0 * 0.87, 0.0, 0.0)).amax() < 1e-12);
    let nearest = clearance.nearest_at(&[towards.as_slice(), towards.as_slice()]).unwrap();
    assert!((nearest.distance - (tips.norm() - 0.04)).abs() < 1e-12, "{nearest:?}");
    assert_eq!(nearest.sides.each_ref().map(|side| side.to_string()), ["left tool", "right tool"]);
}

#[test]
fn which_robot_is_named_first_does_not_matter() {
    let (left, right) = facing(1.9);
    let build = |names: [&str; 2], arms: [Irp6; 2]| {
        let [a, b] = arms;
        let build = Clearance::with_margin(0.05).robot(names[0], a).unwrap();
        build.robot(names[1], b).unwrap().build(AT_ONCE).unwrap()
    };
    let other = [0.3, -1.4, 0.1, 0.5, 4.0, 0.0];
    let one = build(["left", "right"], [left.clone(), right.clone()]).nearest_at(&[&LEVEL, &other]).unwrap();
    let two = build(["right", "left"], [right, left]).nearest_at(&[&other, &LEVEL]).unwrap();
    assert!((one.distance - two.distance).abs() < 1e-12);
    assert_eq!(one.sides[0].link, two.sides[1].link);
}

#[test]
fn too_close_names_both_robots_and_links_the_distance_and_the_margin() {
    // 1.88 m apart the flanges have 0.16 m between them: 0.04 m between the wrists' surfaces.
    let mut clearance = two_arms(1.88, AT_ONCE).unwrap();
    let still = [state("right", &LEVEL, &[]), state("left", &LEVEL, &[])];
    let error = clearance.check(&still).unwrap_err();
    let CheckError::TooClose(TooClose(nearest)) = &error else { panic!("{error}") };
    assert!((nearest.distance - 0.04).abs() < 1e-12);
    assert!((nearest.slack() + 0.01).abs() < 1e-12);
    assert_eq!(
        error.to_string(),
        "too close: left wrist and right wrist are 40.0 mm apart, 0.0 mm to stop, 50.0 mm to be left"
    );
    let fault = Fault::from(error);
    assert!(fault.message().contains("left wrist and right wrist"), "{fault}");
    // One more centimetre and it passes.
    assert!(two_arms(1.90, AT_ONCE).unwrap().check(&still).is_ok());
}

#[test]
fn a_moving_arm_needs_room_to_stop() {
    let mut clearance = two_arms(1.96, AT_ONCE).unwrap();
    let right = state("right", &LEVEL, &[]);
    // 0.12 m between the wrists, 0.07 m beyond the margin. Column and T at 2 rad/s, 7 rad/s^2: 2/7 rad each.
    let at_rest = clearance.check(&[state("left", &LEVEL, &[]), right]).unwrap();
    assert!((at_rest.distance - 0.12).abs() < 1e-12 && at_rest.travel == 0.0);
    let error =
        clearance.check(&[state("left", &LEVEL, &[2.0, 0.0, 0.0, 2.0, 0.0, 0.0]), right]).unwrap_err();
    let CheckError::TooClose(TooClose(nearest)) = error else { panic!("{error}") };
    // The wrist's end is 0.86 m from the column's axis and 0.19 m from T's, and 0.06 m stout.
    let wrist = (0.19 + 0.06) * 2.0 / 7.0;
    assert!((nearest.travel - (wrist + (0.86 + 0.06 + wrist) * 2.0 / 7.0)).abs() < 1e-12, "{nearest:?}");
    // Slowly, there is enough: a tenth of the speed needs a hundredth of the distance.
    let slow = clearance.check(&[state("left", &LEVEL, &[0.2, 0.0, 0.0, 0.2, 0.0, 0.0]), right]);
    assert!(slow.unwrap().travel < 0.011 * nearest.travel);
    // At half the speed the wrists may come 0.085 m nearer from where they are, but 0.044 m from the middle of the braking.
    let passing = clearance.check(&[state("left", &LEVEL, &[1.0, 0.0, 0.0, 1.0, 0.0, 0.0]), right]).unwrap();
    let wrist = 0.25 / 28.0;
    assert!((passing.travel - (wrist + (0.92 + wrist) / 28.0)).abs() < 2e-3, "{passing:?}");
    // For pictures the arm stands where it is.
    let mut stands = 0.0_f64;
    clearance.capsules(&mut |robot, link, capsule| {
        if robot == "left" && &*link.name == "wrist" {
            stands = stands.max(capsule.ends[1].y.abs());
        }
    });
    assert!(stands < 1e-12, "{stands}");
}

#[test]
fn what_passes_keeps_its_margin_until_both_arms_stand() {
    let mut random = mrroc::random::Random::seeded(11);
    let (mut passed, mut refused) = (0, 0);
    for _ in 0..400 {
        let mut clearance = two_arms(random.between(1.2, 2.2), AT_ONCE).unwrap();
        let mut drawn = || -> ([f64; 6], [f64; 6]) {
            (
                core::array::from_fn(|i| LEVEL[i] + random.between(-0.4, 0.4)),
                core::array::from_fn(|_| random.between(-1.2, 1.2)),
            )
        };
        let ([one, v], [other, w]) = (drawn().into(), drawn().into());
        let states = [state("left", &one, &v), state("right", &other, &w)];
        if clearance.check(&states).is_err() {
            refused += 1;
            continue;
        }
        passed += 1;
        // All joints of an arm brake evenly within the time of the slowest: along a straight line. The arms need not do so together.
        let limits = Irp6::nominal().limits().acceleration;
        let time = |v: &[f64; 6]| (0..6).map(|i| v[i].abs() / limits[i]).fold(0.0, f64::max);
        let at = |q: &[f64; 6], v: &[f64; 6], share: f64| -> [f64; 6] {
            core::array::from_fn(|i| q[i] + 0.5 * v[i] * time(v) * share)
        };
        for (a, b) in (0..=10).flat_map(|a| (0..=10).map(move |b| (f64::from(a) * 0.1, f64::from(b) * 0.1))) {
            let nearest = clearance.nearest_at(&[&at(&one, &v, a), &at(&other, &w, b)]).unwrap();
            let own = nearest.sides[0].robot == nearest.sides[1].robot;
            assert!(nearest.distance >= if own { 0.0 } else { 0.05 } - 1e-9, "{nearest:?}");
        }
    }
    assert!(passed > 50 && refused > 50, "{passed} {refused}");
}

#[test]
fn a_turning_column_does_not_bring_links_of_its_own_arm_nearer() {
    let build = Clearance::with_margin(0.05).robot("left", facing(3.0).0).unwrap();
    // A tool so long that it can reach the lower arm. The postument does not turn with the column.
    let build = build.ignore(("left", "tool"), ("left", "postument"));
    let long = [Capsule::new(Vector3::zeros(), Vector3::new(0.0, 0.0, 0.8), 0.02)];
    let mut clearance = build.tool("left", &long).unwrap().build(AT_ONCE).unwrap();
    let turning = clearance.check(&[state("left", &LEVEL, &[1.5, 0.0, 0.0, 0.0, 0.0, 0.0])]).unwrap();
    assert_eq!(turning.travel, 0.0);
    assert!(turning.distance > 0.0);
}

#[test]
fn states_that_say_nothing_are_refused() {
    let mut clearance = two_arms(3.0, AT_ONCE).unwrap();
    let right = state("right", &LEVEL, &[]);
    assert!(
        matches!(clearance.check(&[right]), Err(CheckError::Missing { robot }) if robot.as_str() == "left")
    );
    let nan = state("left", &[f64::NAN; 6], &[]);
    assert!(
        matches!(clearance.check(&[nan, right]), Err(CheckError::NoPosture { robot }) if robot.as_str() == "left")
    );
    let fast = state("left", &LEVEL, &[f64::NAN; 6]);
    assert!(matches!(clearance.check(&[fast, right]), Err(CheckError::NoPosture { .. })));
    let mut rnt = Clearance::with_margin(0.0).robot("rnt", Rnt::new()).unwrap().build(AT_ONCE).unwrap();
    // No linkage has actuators of 5 m.
    let apart = rnt.check(&[state("rnt", &[0.0, 5.0, 5.0, 0.0, 0.0, 0.0], &[])]);
    assert!(matches!(apart, Err(CheckError::NoPosture { .. })));
}

#[test]
fn what_cannot_be_checked_is_not_built() {
    let one = || Clearance::with_margin(0.05).robot("a", Irp6::nominal()).unwrap();
    assert!(matches!(one().robot("a", Irp6::nominal()), Err(ClearanceError::SecondRobot { .. })));
    assert!(matches!(one().robot("a b", Irp6::nominal()), Err(ClearanceError::Name(_))));
    assert!(matches!(one().tool("b", &rod()), Err(ClearanceError::NoRobot { .. })));
    let flat = [Capsule::new(Vector3::zeros(), Vector3::z(), 0.0)];
    assert!(matches!(one().tool("a", &flat), Err(ClearanceError::BadBody { .. })));
    let long = Obstacle::HalfSpace { normal: Vector3::new(0.0, 0.0, 2.0), height: 0.0 };
    assert!(matches!(one().obstacle("floor", long), Err(ClearanceError::BadBody { .. })));
    let build = one().margin_between("a", "b", 0.1).build(AT_ONCE);
    assert!(matches!(build, Err(ClearanceError::NoRobot { .. })));
    let build = one().margin_between("a", "a", -0.1).build(AT_ONCE);
    assert!(matches!(build, Err(ClearanceError::BadMargin { .. })));
    let build = one().ignore(("a", "base"), ("a", "wrist")).build(AT_ONCE);
    let Err(ClearanceError::NoLink { link, known, .. }) = build else { panic!("there is no such link") };
    assert_eq!((&*link, known.as_str()), ("base", "postument, lower arm, upper arm, wrist"));
    assert!(one().will_grasp("a", "box").ignore(("a", "box"), ("a", "wrist")).build(AT_ONCE).is_ok());
    let never = Stopping { reaction: 0.0, stop: Stop::OnPath { rate_change: 0.0, step: 0.002 } };
    assert!(matches!(one().build(never), Err(ClearanceError::BadStopping)));
}

#[test]
fn what_is_mounted_on_the_floor_is_not_checked_against_it() {
    let clearance = Clearance::with_margin(0.02)
        .robot("five", Irp6FiveDof::nominal())
        .unwrap()
        .obstacle("floor", Obstacle::table(0.05))
        .unwrap()
        .build(AT_ONCE)
        .unwrap();
    let overlapping: Vec<String> =
        clearance.unchecked().filter(|why| why.ends_with("always overlap")).collect();
    assert_eq!(overlapping, ["five postument - floor: always overlap"]);
}

#[test]
fn a_grasped_body_is_checked_until_it_is_released() {
    let build = Clearance::with_margin(0.0).robot("left", facing(3.0).0).unwrap();
    let build = build.obstacle("floor", Obstacle::table(0.0)).unwrap();
    let mut clearance = build.ignore(("left", "postument"), ("floor", "floor")).build(AT_ONCE).unwrap();
    let before = clearance.pairs();
    let distance = |clearance: &mut Clearance| clearance.nearest_at(&[&LEVEL]).unwrap().distance;
    // The shoulder is 1 m above the floor, the lower arm 0.09 m stout.
    assert!((distance(&mut clearance) - 0.91).abs() < 1e-12);
    // Tool down: the flange is 1.455 m above the floor, the body's end 0.8 m below it, its radius 0.1 m.
    let body = [Capsule::new(Vector3::new(0.0, 0.0, 0.2), Vector3::new(0.0, 0.0, 0.8), 0.1)];
    clearance.grasp("left", "body", &body).unwrap();
    assert!((distance(&mut clearance) - 0.555).abs() < 1e-12);
    clearance.release("left", "body").unwrap();
    assert!((distance(&mut clearance) - 0.91).abs() < 1e-12);
    assert_eq!(clearance.pairs(), before);
    assert!(matches!(clearance.release("left", "body"), Err(ClearanceError::NoLink { .. })));
}

/// The least distance between links of one arm at `q` that no joint connects, without tool.
fn own_distance<O: Outline>(outline: O, q: &<O::Robot as Robot>::Joints) -> f64 {
    let (links, mut capsules) = (outline.links(), Vec::new());
    outline.capsules(q, &mut |capsule| capsules.push(capsule));
    assert_eq!(links.len(), capsules.len());
    let pairs = (0..links.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
    let apart = pairs.filter(|(a, b)| links[*a].rank.abs_diff(links[*b].rank) > 1);
    apart.map(|(a, b)| capsules[a].gap(&capsules[b]).distance).fold(f64::INFINITY, f64::min)
}

#[test]
fn no_arm_touches_itself_where_it_starts() {
    // The starts of the simulated robots of cell files.
    assert!(own_distance(Irp6::nominal(), &Irp6::READY) > 0.05);
    assert!(own_distance(Irp6::calibrated(), &Irp6::READY) > 0.05);
    assert!(own_distance(Irp6FiveDof::nominal(), &Five::from([0.0, -1.57, 0.16, 0.6, 1.0])) > 0.05);
    let track = Seven::from_fn(|i, _| if i == 0 { 0.5 } else { Irp6::READY[i - 1] });
    assert!(own_distance(Irp6Track::nominal(), &track) > 0.05);
    assert!(own_distance(Rnt::new(), &Six::from([0.0, 0.5, 0.55, 0.0, 1.3, 0.0])) > 0.05);
    let polycrank = Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2]);
    assert!(own_distance(Polycrank::new(), &polycrank) > 0.02);
}

/// How many of the attainable postures on a grid over the ranges of joints 2 to 4 touch themselves, of how many.
fn touching<const N: usize, O>(
    outline: O,
    ranges: [(usize, f64, f64); 3],
    rest: SVector<f64, N>,
) -> (usize, usize)
where
    O: Outline,
    O::Robot: Kinematics<N>,
    O: Clone,
{
    let (mut touching, mut all) = (0, 0);
    for sample in 0..9 * 9 * 9 {
        let mut q = rest;
        for (k, (joint, lower, upper)) in ranges.into_iter().enumerate() {
            q[joint] = lower + (upper - lower) * f64::from(sample / 9_i32.pow(k as u32) % 9) / 8.0;
        }
        if outline.robot().is_attainable(&q) {
            all += 1;
            touching += usize::from(own_distance(outline.clone(), &q) < 0.0);
        }
    }
    (touching, all)
}

#[test]
fn an_irp6_without_tool_touches_itself_nowhere_within_its_limits() {
    let degrees = PI / 180.0;
    let ranges = [(1, -130.0, -50.0), (2, -25.0, 40.0), (3, -90.0, 92.0)]
        .map(|(joint, lower, upper)| (joint, lower * degrees, upper * degrees));
    let (touching, all) = touching(Irp6::nominal(), ranges, Six::from([0.0, 0.0, 0.0, 0.0, 4.7, 0.0]));
    assert!(all > 100, "{all}");
    assert_eq!(touching, 0);
}

/// Turns the column of the left arm from 1 rad to -1 rad, 0.5 rad/s, gently begun and ended.
struct Swing {
    t: f64,
}

#[generator(mp)]
fn swing(c: &mut Swing, t: Tick) -> Step<(Irp6,)> {
    const DURATION: f64 = 8.0;
    if c.t >= DURATION {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(DURATION);
    let mut q = Six::from(LEVEL);
    q[0] = (PI * c.t / DURATION).cos();
    Step::Next((Demand::joints(q),))
}

/// Runs the swing past another arm whose shoulder is `apart` \[m\] away, guarded; gives how it ended, where the left column
/// was last demanded \[rad\], and the least distance as measured.
fn guarded(apart: f64) -> (Result<(), String>, f64, f64) {
    let (left, right) = facing(apart);
    let mut start = LEVEL;
    start[0] = 1.0;
    let mut watched = two_arms(apart, Stopping::of_guard(Duration::from_millis(2), 5)).unwrap();
    let dry_run = Rc::new(RefCell::new(DryRun::new(two_arms(apart, AT_ONCE).unwrap())));
    let (seen, last) = (dry_run.clone(), Rc::new(RefCell::new(f64::NAN)));
    let demanded = last.clone();
    let report = Cell::new(Duration::from_millis(2))
        .robot(RobotSetup::new("left", left.clone(), Simulated::new(left, &Six::from(start))))
        .robot(RobotSetup::new("right", right.clone(), Simulated::new(right, &Six::from(LEVEL))))
        .guard(5, move |robots| watched.check(robots).map(|_| ()).map_err(Fault::from))
        .watch(move |observation| {
            seen.borrow_mut().observe(observation);
            if observation.robot == "left" {
                *demanded.borrow_mut() = observation.demanded[0];
            }
        })
        .program(move |mp| {
            let mut left = mp.robot::<Irp6>("left")?;
            mp.move_robots((&mut left,), (), Swing { t: 0.0 })?;
            Ok(())
        })
        .run();
    let ended = report.map(|_| ()).map_err(|error| error.to_string());
    let least = dry_run.borrow_mut().closest().unwrap().unwrap().nearest.distance;
    let last = *last.borrow();
    (ended, last, least)
}

#[test]
fn a_guarded_arm_stops_on_its_path_before_the_margin_is_broken() {
    // In front of one another, 0.06 m would be left between the wrists: less than distances to stop and 0.05 m.
    let (ended, column, least) = guarded(1.9);
    let text = ended.unwrap_err();
    assert!(text.contains("too close: left wrist and right wrist are"), "{text}");
    assert!(column > 0.0, "it stopped before: {column}");
    // The drives follow to 1 mm.
    assert!(least >= 0.05 - 1e-3, "{least}");
    // The bound is not so cautious that the arms could not come near.
    assert!(least < 0.25, "{least}");
}

#[test]
fn a_guarded_arm_with_room_enough_runs_on() {
    let (ended, column, least) = guarded(2.3);
    assert_eq!(ended, Ok(()));
    assert!((column + 1.0).abs() < 1e-9);
    assert!((least - (2.3 - 2.0 * 0.86 - 0.12)).abs() < 1e-3, "{least}");
}

#[test]
fn a_dry_run_finds_when_and_where_arms_were_nearest() {
    let clearance = || two_arms(2.8, AT_ONCE).unwrap();
    // The left arm turns away from 0.3 rad through 0 and on: nearest at 0, at 0.3 s.
    let turned: Vec<[f64; 6]> = (0..7)
        .map(|k| {
            let mut q = LEVEL;
            q[0] = 0.3 - 0.1 * f64::from(k);
            q
        })
        .collect();
    let times: Vec<f64> = (0..7).map(|k| 0.1 * f64::from(k)).collect();
    let run = times
        .iter()
        .zip(&turned)
        .flat_map(|(time, q)| [(*time, "left", &q[..]), (*time, "right", &LEVEL[..])]);
    let closest = smallest_distance(clearance(), run).unwrap().unwrap();
    assert!((closest.time - 0.3).abs() < 1e-12);
    assert!((closest.nearest.distance - (2.8 - 2.0 * 0.86 - 0.12)).abs() < 1e-12);
    let alone = times.iter().map(|time| (*time, "left", &LEVEL[..]));
    assert_eq!(smallest_distance(clearance(), alone), Ok(None));
}

#[test]
fn cranks_in_planes_side_by_side_do_not_stop_polycrank() {
    let mut clearance = Clearance::with_margin(0.05)
        .robot("polycrank", Polycrank::new())
        .unwrap()
        .obstacle("far floor", Obstacle::table(-1.0))
        .unwrap()
        .build(Stopping::of_guard(Duration::from_millis(2), 5))
        .unwrap();
    // Shaft 3 and crank 4 are 0.12 m apart along the axis of joint 4, in every posture, and 0.09 m stout together.
    assert!(clearance.unchecked().any(|why| why == "polycrank shaft 3 - polycrank crank 4: never meet"));
    // At half of its velocity limits in the posture where it starts.
    let q = [0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2];
    assert!(clearance.check(&[state("polycrank", &q, &[0.5; 7])]).is_ok());
}

#[test]
fn own_links_are_left_out_on_request() {
    let long = [Capsule::new(Vector3::zeros(), Vector3::new(0.0, 0.0, 0.8), 0.02)];
    let build =
        || Clearance::with_margin(0.0).robot("left", facing(3.0).0).unwrap().tool("left", &long).unwrap();
    assert!(build().build(AT_ONCE).unwrap().pairs() > 0);
    let nothing = build().ignore_own("left").build(AT_ONCE).unwrap().nearest_at(&[&LEVEL]);
    assert_eq!(nothing, Err(CheckError::NothingToCheck));
    assert!(matches!(build().ignore_own("right").build(AT_ONCE), Err(ClearanceError::NoRobot { .. })));
}

/// Postures of an arm spread over its limits: `sample` of a Halton sequence in the bases 2, 3, 5 ..
fn spread(sample: usize) -> [f64; 6] {
    let arm = Irp6::nominal();
    let (lower, upper) = (&arm.limits().lower, &arm.limits().upper);
    core::array::from_fn(|j| lower[j] + (upper[j] - lower[j]) * mrroc::random::halton(sample, j))
}

#[test]
fn an_arm_that_is_obstacles_is_as_far_away_as_the_arm_that_stands_there() {
    let build = |margin: f64| {
        let (left, right) = facing(2.0);
        Clearance::with_margin(0.05)
            .robot("left", left)?
            .robot("right", right)?
            .tool("left", &rod())?
            .obstacle("floor", Obstacle::table(-1.0))?
            .margin_between("left", "right", margin)
            .will_grasp("right", "hand")
            .ignore(("left", "tool"), ("right", "hand"))
            .build(AT_ONCE)
    };
    let mut both = build(0.3).unwrap();
    let mut tried = 0;
    for sample in 1..200 {
        let (there, here) = (spread(sample), spread(1000 - sample));
        let shape = both.robot_parts()[0].clone();
        let padded = core::array::from_fn(|j| there.get(j).copied().unwrap_or_default());
        let mut capsules = Vec::new();
        if !shape.around(&padded, &[0.0; 8], &mut |link, capsule, more| {
            assert_eq!(more, 0.0);
            capsules.push((link, capsule));
        }) {
            continue;
        }
        let mut alone = both.with_robot_as_obstacles("left", &capsules).unwrap();
        let (Ok(one), Ok(other)) = (both.nearest_at(&[&there, &here]), alone.nearest_at(&[&here])) else {
            continue;
        };
        // What is nearest may be what the left arm is near to itself.
        let of_right = |side: &mrroc_robots::clearance::Side| side.robot == Some(Name::new("right").unwrap());
        if one.sides.iter().any(of_right) {
            tried += 1;
            assert!((one.distance - other.distance).abs() < 1e-12, "{one}, and {other}");
        }
    }
    assert!(tried > 50, "{tried}");
}

#[test]
fn an_arm_that_is_obstacles_keeps_its_margins_and_its_names_also_when_a_body_is_grasped() {
    let (left, right) = facing(2.0);
    let build = |margin: f64| {
        let clearance = Clearance::with_margin(0.05).robot("left", left.clone()).unwrap();
        let clearance = clearance.robot("right", right.clone()).unwrap();
        clearance.margin_between("right", "left", margin).ignore_own("right").build(AT_ONCE).unwrap()
    };
    let both = build(0.4);
    let mut capsules = Vec::new();
    let padded = core::array::from_fn(|j| LEVEL.get(j).copied().unwrap_or_default());
    assert!(
        both.robot_parts()[0]
            .around(&padded, &[0.0; 8], &mut |link, capsule, _| capsules.push((link, capsule)))
    );
    let mut alone = both.with_robot_as_obstacles("left", &capsules).unwrap();
    assert_eq!(alone.robot_parts().len(), 1);
    for _ in 0..2 {
        assert!(alone.checked_pairs().all(|pair| pair.margin == 0.4), "all pairs are of the two");
        let links: Vec<String> = alone.obstacle_parts().map(|(name, _)| name.to_string()).collect();
        assert!(links.iter().all(|name| name.starts_with("left ")), "{links:?}");
        // Each capsule of the right arm with each obstacle, none of them left out because they overlap.
        assert_eq!(alone.pairs(), alone.robot_parts()[0].links.len() * links.len());
        alone.grasp("right", "rod", &rod()).unwrap();
    }
    let refused = both.with_robot_as_obstacles("middle", &capsules).err().unwrap().to_string();
    assert_eq!(refused, "no robot `middle` in this clearance");
    assert!(both.with_robot_as_obstacles("left", &[]).unwrap().obstacle_parts().len() == 0);
    let bad = [(0, Capsule::new(Vector3::zeros(), Vector3::x(), f64::NAN))];
    assert!(both.with_robot_as_obstacles("left", &bad).is_err());
}

#[test]
fn an_obstacle_that_is_replaced_is_seen_where_it_is_now_and_costs_no_allocation() {
    let ball = |x: f64| Obstacle::ball(Vector3::new(x, 0.0, 1.455), 0.1);
    let build = Clearance::with_margin(0.05).robot("left", facing(3.0).0).unwrap();
    let mut clearance = build.obstacle("ball", ball(5.0)).unwrap().build(AT_ONCE).unwrap();
    let standing = [state("left", &LEVEL, &[0.0; 6])];
    // Stretched forwards along x at the height of the ball, to 0.86 m, its wrist 0.06 m stout.
    let far = clearance.check(&standing).unwrap();
    assert!((far.distance - (5.0 - 0.1 - 0.86 - 0.06)).abs() < 1e-9, "{far}");
    let (replaced, allocations) =
        mrroc_counting_allocator::count(|| clearance.replace_obstacle("ball", ball(1.05)));
    assert_eq!((replaced, allocations), (Ok(ball(5.0)), 0));
    let Err(CheckError::TooClose(TooClose(near))) = clearance.check(&standing) else { panic!("too close") };
    assert!((near.distance - (1.05 - 0.1 - 0.86 - 0.06)).abs() < 1e-9, "{near}");
    let none = clearance.replace_obstacle("post", ball(1.0));
    assert!(
        matches!(none, Err(ClearanceError::NoLink { link, known, .. }) if &*link == "post" && known == "ball")
    );
    let bad = Obstacle::ball(Vector3::zeros(), f64::NAN);
    assert!(matches!(clearance.replace_obstacle("ball", bad), Err(ClearanceError::BadBody { .. })));
}

#[test]
fn a_link_that_always_overlapped_with_an_obstacle_is_checked_where_the_obstacle_is_replaced() {
    // The shoulder is 1 m above the floor: within a ball around it the column and the lower arm always are.
    let shoulder = Obstacle::ball(Vector3::new(0.0, 0.0, 1.0), 0.05);
    let build = Clearance::with_margin(0.0).robot("left", facing(3.0).0).unwrap().ignore_own("left");
    let mut clearance = build.obstacle("ball", shoulder).unwrap().build(AT_ONCE).unwrap();
    let overlapping: Vec<String> = clearance.unchecked().collect();
    assert!(overlapping.contains(&"left lower arm - ball: always overlap".to_owned()), "{overlapping:?}");
    let before = clearance.pairs();
    clearance.replace_obstacle("ball", Obstacle::ball(Vector3::new(0.0, 3.0, 1.0), 0.05)).unwrap();
    let still: Vec<String> = clearance.unchecked().collect();
    assert!(still.iter().all(|why| why.contains("postument")), "{still:?}");
    assert_eq!(clearance.pairs() - before, overlapping.len() - still.len());
    assert!(clearance.check(&[state("left", &LEVEL, &[0.0; 6])]).is_ok());
}

/// The column of an arm from 1 rad on at 0.5 rad for each unit of the parameter, the other joints as stretched forwards.
struct Turn;

impl KnownPath for Turn {
    fn stretch(&self, from: f64, to: f64, robots: &mut [Stretch]) -> f64 {
        // No longer than 0.4, to be asked again.
        let to = to.min(from + 0.4);
        let mut middle = [0.0; 8];
        middle[..6].copy_from_slice(&LEVEL);
        middle[0] = 1.0 - 0.25 * (from + to);
        let mut half = [0.0; 8];
        half[0] = 0.25 * (to - from);
        robots[0] = Stretch { middle, half };
        to
    }
}

#[test]
fn a_path_is_proven_up_to_where_it_comes_nearer_than_the_margin() {
    // A post 0.6 m ahead of the shoulder. The arm, 0.09 m stout there at most, passes it at the angle whose sine is the distance of the axes by 0.6 m.
    let post = Vector3::new(0.6, 0.0, 0.0);
    let build = Clearance::with_margin(0.05).robot("left", facing(3.0).0).unwrap().ignore_own("left");
    let post = Obstacle::Capsule(Capsule::new(post, post + Vector3::z() * 2.0, 0.02));
    let mut clearance = build.obstacle("post", post).unwrap().build(AT_ONCE).unwrap();
    let (mut proven, mut parts) = (0.0, 10_000);
    let error = clearance.prove(&Turn, &mut proven, 4.0, Against::Everything, &mut parts).unwrap_err();
    assert!(
        matches!(&error, CheckError::TooClose(TooClose(near)) if &*near.sides[1].link == "post"),
        "{error}"
    );
    let mut at = |parameter: f64| {
        let mut q = LEVEL;
        q[0] = 1.0 - 0.5 * parameter;
        clearance.nearest_at(&[&q]).unwrap().distance
    };
    // Everywhere before it is far enough, and within the stretch behind it is not.
    assert!(
        proven > 0.5 && (0..=1000).all(|k| at(proven * f64::from(k) / 1000.0) >= 0.05 - 1e-12),
        "{proven}"
    );
    assert!((0..=1000).any(|k| at(proven + 0.4 * f64::from(k) / 1000.0) < 0.05), "{proven}");
    // With few parts it proves less, and says so.
    let (mut less, mut few) = (0.0, 3);
    assert!(clearance.prove(&Turn, &mut less, 4.0, Against::Obstacle(0), &mut few).is_err());
    assert!(less < proven && few == 0);
    // The links among themselves are in nobody's way: there is no pair of them.
    let (mut links, mut parts) = (0.0, 20);
    assert_eq!(clearance.prove(&Turn, &mut links, 4.0, Against::Links, &mut parts), Ok(()));
    assert_eq!(links, 4.0);
}

/// The distance of a ball from a point `p` of the arm changes by `(z x p) . n` when the column turns, `n` from the ball to the point.
#[test]
fn distances_change_with_the_joints_as_kinematics_says() {
    let (left, right) = facing(1.0);
    let at = Vector3::new(0.9, 0.6, 1.2);
    let clearance = Clearance::with_margin(0.05).robot("left", left.clone()).unwrap();
    let clearance =
        clearance.robot("right", right.clone()).unwrap().obstacle("ball", Obstacle::ball(at, 0.1)).unwrap();
    let mut clearance = clearance.build(AT_ONCE).unwrap();
    let (mut with_ball, mut between) = (0, 0);
    for sample in 1..60 {
        let q = [spread(sample), spread(500 + sample)];
        let Ok(found) = clearance.gradients_at(&[&q[0], &q[1]], 0.6) else { continue };
        assert!(found.windows(2).all(|pair| pair[0].0.distance <= pair[1].0.distance));
        for (nearest, gradient) in found {
            assert_eq!(gradient.len(), 12);
            if nearest.distance < 1e-3 {
                continue; // bodies that overlap have no direction from one to the other
            }
            let [one, other] = &nearest.sides;
            let n = (one.point - other.point).normalize();
            // Of each side the robot, where it turns by its column about the vertical through its base.
            let column = |side: &mrroc_robots::clearance::Side, base: f64| {
                Vector3::z().cross(&(side.point - Vector3::new(base, 0.0, 0.0)))
            };
            let moves = |side: &mrroc_robots::clearance::Side| &*side.link != "postument";
            let mut expected = [0.0; 2];
            for (side, n) in [(one, n), (other, -n)] {
                match side.robot.as_ref().map(Name::as_str) {
                    Some("left") if moves(side) => expected[0] += column(side, 0.0).dot(&n),
                    Some("right") if moves(side) => expected[1] += column(side, 1.0).dot(&n),
                    _ => {}
                }
            }
            assert!((gradient[0] - expected[0]).abs() < 1e-5, "{nearest}: {} {}", gradient[0], expected[0]);
            assert!((gradient[6] - expected[1]).abs() < 1e-5, "{nearest}: {} {}", gradient[6], expected[1]);
            with_ball += u32::from(&*other.link == "ball");
            between += u32::from(one.robot != other.robot && other.robot.is_some());
        }
    }
    assert!(with_ball > 20 && between > 20, "{with_ball} {between}");
    assert!(
        clearance
            .gradients_at(&[&LEVEL, &LEVEL], 0.0)
            .is_ok_and(|found| found.iter().all(|(n, _)| n.distance < 0.0))
    );
}
