//! Every pair alone is the reference of the trees.

use std::time::Duration;

use mrroc::pose::Pose;
use mrroc::random::Random;
use mrroc::robot::{MAX_JOINTS, Robot};
use nalgebra::Vector3;

use super::*;
use crate::clearance::obstacle::Obstacle;
use crate::clearance::placement::travel;
use crate::clearance::posture::Joints;
use crate::clearance::{Against, Bodies, Cloud, Stopping};
use crate::models::{Capsule, Irp6, Link, Motion, Outline, Serial, SerialOutline, Six};

/// An arm with many capsules on each link, which are told in their frames or not.
struct Covered {
    inner: SerialOutline<6>,
    bodies: Vec<(usize, Capsule)>,
    is_rigid: bool,
}

impl Covered {
    fn new(base: Pose, random: &mut Random, is_rigid: bool) -> Self {
        let urdf = include_str!("../../../tests/reference/urdf/three_parallel.urdf");
        let robot = Serial::<6>::from_urdf(urdf, "base", "wrist_3").unwrap();
        let robot = robot.with_acceleration(Six::repeat(5.0)).unwrap().with_base(base);
        let mut bodies = Vec::new();
        for _ in 0..90 {
            let mut point = |size: f64| Vector3::from_fn(|_, _| random.within(size));
            let (end, along) = (point(0.15), point(0.06));
            let capsule = Capsule::new(end, end + along, random.between(0.005, 0.03));
            let frame = random.between(0.0, 6.99) as usize;
            bodies.push((frame, capsule));
            // Twice the same: neither is nearer.
            if random.between(0.0, 1.0) < 0.2 {
                bodies.push((frame, capsule));
            }
        }
        Self { inner: SerialOutline::new(robot, 0.05), bodies, is_rigid }
    }
}

impl Outline for Covered {
    type Robot = Serial<6>;

    fn robot(&self) -> &Serial<6> {
        self.inner.robot()
    }

    fn links(&self) -> Vec<Link> {
        let link = |frame: usize| Link {
            name: format!("link {frame}").into(),
            rank: frame as u32,
            moved_by: Link::first(frame as u32 + 1) & !1,
        };
        self.bodies.iter().map(|(frame, _)| link(*frame)).collect()
    }

    fn capsules(&self, q: &Six, visit: &mut dyn FnMut(Capsule)) {
        let mut frames = Vec::new();
        self.robot().frames(q, &mut |frame| frames.push(*frame));
        self.bodies.iter().for_each(|(frame, capsule)| visit(capsule.moved(&frames[*frame])));
    }

    fn rigid(&self) -> Option<Vec<(usize, Capsule)>> {
        self.is_rigid.then(|| self.bodies.clone())
    }

    fn link_frames(&self, q: &Six, visit: &mut dyn FnMut(&Pose)) {
        self.robot().frames(q, visit);
    }

    fn motions(&self, q: &Six, distances: &Six, visit: &mut dyn FnMut(Motion)) {
        Outline::motions(&self.inner, q, distances, visit);
    }

    fn flange_motions(&self) -> u32 {
        Outline::flange_motions(&self.inner)
    }
}

fn cloud(random: &mut Random, centre: Vector3<f64>) -> Vec<Vector3<f64>> {
    (0..300).map(|_| centre + Vector3::from_fn(|_, _| random.within(0.3))).collect()
}

/// Two covered arms and an IRp-6 with tools and bodies they hold, among obstacles of all kinds.
fn cell(seed: u64, is_rigid: bool) -> Clearance {
    let mut random = Random::seeded(seed);
    let turned = Pose::new(Vector3::new(random.between(0.6, 1.3), 0.0, 0.0), Vector3::z() * 2.5);
    let left = Covered::new(Pose::identity(), &mut random, is_rigid);
    let right = Covered::new(turned, &mut random, is_rigid);
    let irp6 = Irp6::nominal().with_base(Pose::translation(0.4, 1.2, 0.7));
    let end = |x: f64| Vector3::new(x, 0.02, 0.15);
    let tool = [Capsule::new(Vector3::zeros(), end(0.0), 0.02), Capsule::new(end(0.0), end(0.1), 0.01)];
    let held = [Capsule::new(end(0.1), end(0.3), 0.03), Capsule::new(end(0.1), end(-0.2), 0.03)];
    let points = cloud(&mut random, Vector3::new(0.5, -0.9, 0.3));
    let bodies: Vec<Capsule> = cloud(&mut random, Vector3::new(-0.7, -0.7, 0.6))
        .windows(2)
        .map(|ends| Capsule::new(ends[0], ends[0] + 0.1 * (ends[1] - ends[0]), 0.01))
        .collect();
    let build = Clearance::with_margin(0.02)
        .robot("left", left)
        .unwrap()
        .robot("right", right)
        .unwrap()
        .robot("irp6", irp6)
        .unwrap()
        .tool("left", &tool)
        .unwrap()
        .tool("irp6", &tool)
        .unwrap()
        .obstacle("table", Obstacle::table(-0.2))
        .unwrap()
        .obstacle("box", Obstacle::Box { X_WO: Pose::translation(0.5, 0.6, 0.1), half: Vector3::repeat(0.2) })
        .unwrap()
        .obstacle("cloud", Obstacle::Cloud(std::sync::Arc::new(Cloud::new(&points, 0.01).unwrap())))
        .unwrap()
        .obstacle("bodies", Obstacle::Bodies(std::sync::Arc::new(Bodies::new(&bodies).unwrap())))
        .unwrap()
        .ignore(("left", "link 5"), ("right", "link 6"))
        .ignore(("right", "link 1"), ("table", "table"))
        .margin_between("left", "right", 0.05)
        .margin_between("left", "box", 0.0)
        .margin_between("right", "right", 0.01);
    let mut clearance = build.build(Stopping::of_guard(Duration::from_millis(2), 5)).unwrap();
    clearance.grasp("right", "held", &held).unwrap();
    clearance
}

/// Of the wanted pairs, looked at one by one, the one with the least left, if that is less than `least`.
fn one_by_one(
    clearance: &Clearance,
    standing: &[(Joints, Joints)],
    purpose: Purpose,
    is_wanted: impl Fn(&Group) -> bool,
    least: f64,
) -> Option<(f64, Pair)> {
    let motions: Vec<Vec<Motion>> = clearance
        .robots
        .iter()
        .zip(standing)
        .map(|(robot, (q, half))| {
            let mut motions = Vec::new();
            robot.shape().motions(q, half, &mut |motion| motions.push(motion));
            motions
        })
        .collect();
    let far = |limb: &Limb, since: usize| {
        let robot = &clearance.robots[limb.robot];
        let capsule = robot.capsule(limb.link).unwrap();
        travel(robot.links[limb.link].moved_by, &capsule, &motions[limb.robot])[since]
    };
    let mut best: Option<(f64, Pair)> = None;
    for group in clearance.checked().iter().filter(|group| is_wanted(group)) {
        for (pair, _) in group.pairs(&clearance.robots).filter(|(_, is_checked)| *is_checked) {
            let other = match &pair.other {
                Other::Limb(limb) => far(limb, group.since),
                Other::Obstacle(_) => 0.0,
            };
            let taken = match purpose {
                Purpose::Slack => far(&pair.limb, group.since) + other + group.margin,
                Purpose::Distance => 0.0,
            };
            let left = clearance.gap(&pair).unwrap().distance - taken;
            if left < least && best.is_none_or(|best| (left, pair) < best) {
                best = Some((left, pair));
            }
        }
    }
    best
}

/// The joints of all robots, and by how much they may be off, from nothing to a wide sweep.
fn draw(clearance: &mut Clearance, random: &mut Random) -> Vec<(Joints, Joints)> {
    let wide = random.between(-0.1, 0.3).max(0.0);
    loop {
        let drawn: Vec<(Joints, Joints)> = clearance
            .robots
            .iter()
            .map(|robot| {
                let part: [f64; MAX_JOINTS] = core::array::from_fn(|_| random.between(0.1, 0.9));
                let half = core::array::from_fn(|_| random.between(0.0, 1.0) * wide);
                (robot.shape().between_limits(&|i| part[i]), half)
            })
            .collect();
        let robots = clearance.robots.iter_mut().zip(&drawn);
        if robots.fold(true, |all, (robot, (q, half))| robot.stand(q, Some(half)) && all) {
            return drawn;
        }
    }
}

#[test]
fn trees_find_the_pair_that_all_pairs_one_by_one_show_to_be_nearest_whatever_was_nearest_before() {
    let mut overlapping = 0;
    for seed in [1, 2] {
        let mut clearance = cell(seed, true);
        let mut random = Random::seeded(seed + 10);
        for _ in 0..25 {
            let standing = draw(&mut clearance, &mut random);
            let mut compare = |purpose: Purpose, is_wanted: &dyn Fn(&Group) -> bool, least: f64| {
                let expected = one_by_one(&clearance, &standing, purpose, is_wanted, least);
                let found = clearance.least(purpose, is_wanted, least);
                // From the pair that has just been found, and from none.
                assert_eq!(clearance.least(purpose, is_wanted, least), found);
                clearance.search.forget();
                assert_eq!(clearance.least(purpose, is_wanted, least), found);
                assert_eq!(expected.is_some(), found.is_some(), "{expected:?} {found:?}");
                let (Some((left, pair)), Some(found)) = (expected, found) else { return };
                assert_eq!(clearance.sides(&pair, &clearance.gap(&pair).unwrap()), found.sides);
                assert_eq!(left, found.distance - (found.travel + found.margin));
                overlapping += usize::from(found.distance < 0.0);
            };
            compare(Purpose::Slack, &|_| true, f64::INFINITY);
            compare(Purpose::Slack, &|_| true, 0.0);
            compare(Purpose::Distance, &|group| !group.is_own(), f64::INFINITY);
            compare(Purpose::Distance, &Group::is_own, f64::INFINITY);
            for against in [Against::Links, Against::Obstacle(1), Against::Obstacle(2), Against::Obstacle(3)]
            {
                compare(Purpose::Slack, &|group| against.takes(group), f64::INFINITY);
            }
        }
    }
    assert!(overlapping > 10, "{overlapping}");
}

#[test]
fn all_pairs_within_a_distance_are_found_by_trees_as_one_by_one() {
    let mut clearance = cell(4, true);
    let mut random = Random::seeded(5);
    for _ in 0..10 {
        draw(&mut clearance, &mut random);
        let within = random.between(0.0, 0.2);
        let pairs = clearance.checked().iter().flat_map(|group| group.pairs(&clearance.robots));
        let gaps = pairs.filter(|(_, is_checked)| *is_checked);
        let gaps = gaps.map(|(pair, _)| (pair, clearance.gap(&pair).unwrap()));
        let mut expected: Vec<(Pair, Gap)> = gaps.filter(|(_, gap)| gap.distance < within).collect();
        expected.sort_by(|(a, p), (b, q)| p.distance.total_cmp(&q.distance).then(a.cmp(b)));
        assert_eq!(clearance.within(within), expected);
    }
}

#[test]
fn what_capsules_are_told_in_frames_is_checked_as_if_the_outline_placed_them() {
    let [mut rigid, mut placed] = [true, false].map(|is_rigid| cell(6, is_rigid));
    assert_eq!(rigid.pairs(), placed.pairs());
    let [a, b] = [&rigid, &placed].map(|clearance| {
        let mut unchecked: Vec<String> = clearance.unchecked().collect();
        unchecked.sort();
        unchecked
    });
    assert!(a.len() > 100 && a == b, "{} and {}", a.len(), b.len());
    for seed in 0..15 {
        let standing = draw(&mut rigid, &mut Random::seeded(seed));
        assert_eq!(draw(&mut placed, &mut Random::seeded(seed)), standing);
        let least = |clearance: &mut Clearance| clearance.least(Purpose::Slack, |_| true, f64::INFINITY);
        assert_eq!(least(&mut rigid), least(&mut placed));
    }
}
