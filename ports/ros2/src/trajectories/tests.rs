//! Requests and what becomes of them, without DDS and without a cell.

use byteorder::LittleEndian;
use cdr_encoding::{from_bytes, to_vec};
use mrroc_core::cell::Cell;
use mrroc_external::goals::{GoalNews, GoalState, refusal};
use mrroc_launch::cell_file::CellFile;
use mrroc_robots::simulated;
use proptest::prelude::*;
use ros2_client::action_msgs::{CancelGoalResponseEnum, GoalId, GoalInfo, GoalStatusEnum};
use ros2_client::builtin_interfaces::Time;

use super::goals::{Goals, Now, Told};
use super::messages::*;
use super::request::Offered;
use crate::messages::Stamp;

const CELL: &str = r#"
step_ms = 2
robots.left = { kind = "irp6", start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0] }
robots.right-arm = { kind = "irp6", start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0], base = { xyz = [2.2, 0.0, 0.0] } }
"#;
const HOME: [f64; 6] = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0];
/// A time since 1970 \[ns\].
const TODAY: u64 = 1_700_000_000_000_000_000;
const MS: u64 = 1_000_000;

fn offered() -> Offered {
    let file = CellFile::parse("cell.toml", CELL).expect("nothing is wrong with it");
    let cell: Cell = file.cell(&simulated()).expect("nor with this");
    let joints = ["a", "b", "c", "d", "e", "f"].map(str::to_owned).to_vec();
    Offered { layout: cell.layout(), joints: vec![joints.clone(), joints] }
}

/// To a place of the column, in so many seconds.
fn request(names: &[&str], column: f64, seconds: f64) -> Request {
    let mut request = Request::default();
    request.trajectory.joint_names = names.iter().map(|&name| name.to_owned()).collect();
    let mut positions = Vec::new();
    for joint in 0..names.len() {
        positions.push(if joint % 6 == 0 { column } else { HOME[joint % 6] });
    }
    let whole = seconds.floor();
    let time_from_start = Duration { sec: whole as i32, nanosec: ((seconds - whole) * 1e9) as u32 };
    request.trajectory.points = vec![Point { positions, time_from_start, ..Point::default() }];
    request
}

const ONE: [&str; 6] = ["a", "b", "c", "d", "e", "f"];
const BOTH: [&str; 12] = [
    "left/a",
    "left/b",
    "left/c",
    "left_d",
    "left_e",
    "left_f",
    "right_arm/a",
    "right_arm/b",
    "right_arm/c",
    "right_arm/d",
    "right_arm/e",
    "right_arm/f",
];

#[test]
fn joints_are_found_by_their_names_in_any_order_and_whole_robots_alone() {
    let offered = offered();
    let read = |request: &Request, only| offered.read(request, only, TODAY);
    let mut mixed = request(&["c", "a", "f", "b", "e", "d"], 0.0, 2.0);
    mixed.trajectory.points[0].positions = vec![3.0, 1.0, 6.0, 2.0, 5.0, 4.0];
    let asked = read(&mixed, Some(1)).expect("all joints of one robot");
    assert_eq!(asked.robots, [1]);
    assert_eq!(asked.goal.trajectory.points()[0].positions, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(asked.names[0], ("c".to_owned(), 2));
    let asked = read(&request(&BOTH, 0.1, 2.0), None).expect("both");
    assert_eq!(asked.robots, [0, 1]);
    for (request, only, code, text) in [
        (request(&ONE, 0.0, 2.0), None, INVALID_JOINTS, "several robots have a joint `a`"),
        (
            request(&BOTH, 0.0, 2.0),
            Some(0),
            INVALID_JOINTS,
            "no joint is called `right_arm/a`: there are: left/a,",
        ),
        (request(&["left/a", "lefft/b"], 0.0, 2.0), None, INVALID_JOINTS, "did you mean `left/b`?"),
        (
            request(&["a", "zz"], 0.0, 2.0),
            Some(1),
            INVALID_JOINTS,
            "no joint is called `zz`: there are: a, b,",
        ),
        (request(&ONE[1..], 0.0, 2.0), Some(0), INVALID_JOINTS, "joint `a` of robot `left` is missing"),
        (request(&["a"; 6], 0.0, 2.0), Some(0), INVALID_JOINTS, "named twice"),
        (request(&[], 0.0, 2.0), Some(0), INVALID_GOAL, "limits of 0 joints"),
    ] {
        let refused = read(&request, only).expect_err(text);
        assert!(refused.error_code == code && refused.error_string.contains(text), "{refused:?}");
    }
}

#[test]
fn tolerances_and_stamps_are_those_of_the_message() {
    let offered = offered();
    let tolerance = |name: &str, position, acceleration| Tolerance {
        name: name.to_owned(),
        position,
        velocity: 0.0,
        acceleration,
    };
    let mut asks = request(&ONE, 0.1, 2.0);
    asks.path_tolerance = vec![tolerance("b", 0.1, 0.0), tolerance("c", -1.0, 0.0)];
    let asked = offered.read(&asks, Some(0), TODAY).expect("sound");
    let bounds: Vec<f64> = asked.path.iter().map(|bounds| bounds.position).collect();
    assert_eq!(bounds[..3], [f64::INFINITY, 0.1, f64::INFINITY]);
    assert_eq!(asked.time, 10.0);
    for wrong in [
        tolerance("z", 0.1, 0.0),
        tolerance("a", -0.5, 0.0),
        tolerance("a", f64::NAN, 0.0),
        tolerance("a", 0.0, 1.0),
    ] {
        asks.goal_tolerance = vec![wrong];
        offered.read(&asks, Some(0), TODAY).expect_err("no tolerance");
    }
    let stamped = |ahead: i64| {
        let mut asks = request(&ONE, 0.1, 2.0);
        asks.trajectory.header.stamp = Stamp::of((TODAY.cast_signed() + ahead).cast_unsigned());
        offered.read(&asks, Some(0), TODAY)
    };
    let asked = stamped(1_500_000_000).expect("later");
    assert!((asked.goal.delay - 1.5).abs() < 1e-9 && asked.goal.trajectory.has_passed() == 0.0);
    let asked = stamped(-500_000_000).expect("some is left");
    assert!((asked.goal.trajectory.has_passed() - 0.5).abs() < 1e-9 && asked.goal.delay == 0.0);
    assert_eq!(stamped(-2_500_000_000).expect_err("past").error_code, OLD_HEADER_TIMESTAMP);
}

#[test]
fn limits_are_looked_at_before_anything_is_sent_also_those_that_joints_share() {
    let offered = offered();
    let check = |column: f64, seconds: f64| {
        let asked = offered.read(&request(&ONE, column, seconds), Some(0), TODAY).expect("sound");
        offered.check(&asked, &HOME)
    };
    assert_eq!(check(0.5, 2.0), Ok(()));
    assert!(check(0.5, 0.2).expect_err("too fast").error_string.starts_with("joint `left/a`: "));
    assert!(check(3.0, 9.0).expect_err("too far").error_string.contains("position"));
    // The IRp-6's motors of lower and upper arm: each joint is within its limits, and their difference is not.
    let mut asks = request(&ONE, 0.0, 9.0);
    asks.trajectory.points[0].positions[1] = -0.9;
    asks.trajectory.points[0].positions[2] = -0.4;
    let asked = offered.read(&asks, Some(0), TODAY).expect("sound");
    let refused = offered.check(&asked, &HOME).expect_err("beyond the angle of a motor").error_string;
    assert!(refused.starts_with("robot `left`, ") && refused.contains("motor"), "{refused}");
}

/// Several points of one robot, each with its time \[s\] and the place of the column there.
fn points(columns: &[(f64, f64)]) -> Request {
    let mut goal = request(&ONE, 0.0, 0.0);
    let point = |&(seconds, column)| request(&ONE, column, seconds).trajectory.points.remove(0);
    goal.trajectory.points = columns.iter().map(point).collect();
    goal
}

#[test]
fn a_goal_of_a_bag_that_is_too_fast_wherever_the_robots_are_is_told_before_it_is_sent() {
    let Offered { layout, joints } = offered();
    let wrong = |goals: &[Request]| super::mistakes(&layout, joints.clone(), goals, Some(0));
    // From rest to rest over 0.5 rad: the mean velocity alone is 0.25 rad/s, and 5 rad/s; the column of the IRp-6 has 1.5 rad/s.
    let [slow, fast] = [2.0, 0.1].map(|seconds| points(&[(0.0, 0.0), (seconds, 0.5)]));
    let found = wrong(&[slow.clone(), fast.clone()]);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].starts_with("bag: trajectory 2: joint `left/a`: "), "{found:?}");
    // Where the first point is on their path, its limits depend on where they come from, unless they rest there.
    let later = |velocities: &[f64]| {
        let mut goal = points(&[(1.0, 0.0), (1.1, 0.5)]);
        goal.trajectory.points.iter_mut().for_each(|point| point.velocities = velocities.to_vec());
        goal
    };
    assert_eq!(wrong(&[later(&[0.0; 6])]).len(), 1);
    // From the first point on a joint has the mean velocity of 5 rad/s at some instant, however it comes there; of 0.5 rad/s nothing is certain.
    let found = wrong(&[later(&[])]);
    assert!(
        found.len() == 1 && found[0].contains("velocity 5.0000 rad/s on the way to point 2"),
        "{found:?}"
    );
    assert_eq!(wrong(&[points(&[(1.0, 0.0), (2.0, 0.5)])]), Vec::<String>::new());
    let found = wrong(&[points(&[(1.0, 0.0), (21.0, 3.0)])]);
    assert!(found.len() == 1 && found[0].contains("position 3.0000 rad"), "{found:?}");
    // A cubic that passes both points at 0.2 rad/s, 0.5 rad apart in a second, is as fast as 1.5 * 0.5 - 0.5 * 0.2 = 0.65 rad/s in the middle; in 0.4 s it is 1.775 rad/s.
    let passing = |seconds: f64| {
        let mut goal = points(&[(1.0, 0.0), (1.0 + seconds, 0.5), (3.0 + seconds, 0.7)]);
        for (point, velocity) in goal.trajectory.points.iter_mut().zip([0.2, 0.2, 0.0]) {
            point.velocities = vec![velocity, 0.0, 0.0, 0.0, 0.0, 0.0];
        }
        goal
    };
    assert_eq!(wrong(&[passing(1.0)]), Vec::<String>::new());
    let found = wrong(&[passing(0.4)]);
    assert!(found.len() == 1 && found[0].contains("on the way to point 2"), "{found:?}");
}

/// Goals, and a cell that does with them what a test says.
struct Rig {
    goals: Goals,
    now: u64,
    state: GoalState,
    robots: Vec<Option<Now>>,
}

impl Rig {
    fn new() -> Rig {
        let at = || [HOME.to_vec(), vec![0.0; 6]];
        let robot = || Some(Now { stamp: Stamp::default(), demanded: at(), measured: at() });
        let mut rig = Rig {
            goals: Goals::new(offered()),
            now: 1_000 * MS,
            state: GoalState::default(),
            robots: vec![robot(), robot()],
        };
        rig.hear();
        rig
    }

    fn hear(&mut self) {
        self.goals.hear(self.state, self.now);
    }

    /// 2 ms later.
    fn go(&mut self, fault: Option<&str>) -> Told {
        self.now += 2 * MS;
        self.goals.advance(self.now, &self.robots, fault)
    }

    fn ask(&mut self, server: usize, request: &Request) -> GoalId {
        let id = GoalId::new_random();
        let only = (server < 2).then_some(server);
        assert!(self.goals.request(server, only, id, request, [self.now, TODAY]));
        assert!(!self.goals.request(server, only, id, request, [self.now, TODAY]), "the same one twice");
        id
    }

    /// The cell begins the newest goal, of the robots at these places.
    fn begin(&mut self, places: &[usize]) -> u64 {
        self.go(None);
        let newest = self.goals.news().newest;
        self.state.taken = newest;
        for &place in places {
            self.state.goals[place] = newest;
            self.state.over &= !(1 << place);
            self.state.done &= !(1 << place);
        }
        self.hear();
        self.go(None);
        newest
    }

    fn end(&mut self, place: usize, done: bool) {
        self.state.over |= 1 << place;
        self.state.done |= u32::from(done) << place;
        self.hear();
        self.go(None);
        self.go(None);
    }

    fn result(&self, id: GoalId) -> (GoalStatusEnum, i32, String) {
        let (status, outcome) = self.goals.result(id).expect("known").expect("it has ended");
        (status, outcome.error_code, outcome.error_string)
    }
}

fn info(goal_id: GoalId) -> GoalInfo {
    GoalInfo { goal_id, stamp: Time::ZERO }
}

#[test]
fn a_goal_that_the_cell_follows_succeeds_and_has_feedback() {
    let mut rig = Rig::new();
    let id = rig.ask(0, &request(&ONE, 0.5, 2.0));
    assert_eq!(rig.goals.news(), GoalNews::default(), "nothing is sent before it is looked at");
    assert_ne!(rig.begin(&[0]), 0);
    let mut feedback = 0;
    for _ in 0..100 {
        let told = rig.go(None);
        feedback += told.feedback.len();
        rig.hear();
    }
    // Every 50 ms.
    assert!((3..=5).contains(&feedback), "{feedback}");
    assert_eq!(rig.goals.result(id), Ok(None));
    rig.end(0, true);
    assert_eq!(rig.result(id), (GoalStatusEnum::Succeeded, SUCCESSFUL, String::new()));
    assert_eq!(rig.goals.result(GoalId::new_random()), Err(()));
}

#[test]
fn goals_are_sent_one_after_the_other_and_cancelled_wherever_they_are() {
    let mut rig = Rig::new();
    let first = rig.ask(0, &request(&ONE, 0.5, 2.0));
    let second = rig.ask(1, &request(&ONE, 0.5, 2.0));
    let third = rig.ask(1, &request(&ONE, 0.4, 2.0));
    let one = rig.begin(&[0]);
    let two = rig.begin(&[1]);
    assert_ne!(one, two);
    // The third one waits for the cell's answer now; it is cancelled before, and the first one in its motion.
    let cancelled = rig.goals.cancel(1, &info(third));
    assert_eq!((cancelled.return_code, cancelled.goals_canceling.len()), (CancelGoalResponseEnum::None, 1));
    assert_eq!(
        rig.goals.cancel(0, &info(third)).return_code,
        CancelGoalResponseEnum::UnknownGoal,
        "of another server"
    );
    rig.goals.cancel(0, &info(first));
    rig.go(None);
    assert!(rig.goals.news().cancelled.contains(&one) && !rig.goals.news().cancelled.contains(&two));
    rig.end(0, false);
    assert_eq!(rig.result(first).0, GoalStatusEnum::Canceled);
    assert_eq!(rig.goals.cancel(0, &info(first)).return_code, CancelGoalResponseEnum::GoalTerminated);
    // All of a server.
    let all = rig.goals.cancel(1, &info(GoalId::ZERO));
    assert_eq!(all.goals_canceling.len(), 2);
    rig.end(1, true);
    assert_eq!(rig.result(second).0, GoalStatusEnum::Canceled, "though it came to its end");
}

#[test]
fn a_goal_that_cannot_be_followed_says_why() {
    let mut rig = Rig::new();
    let fast = rig.ask(0, &request(&ONE, 0.5, 0.1));
    rig.go(None);
    let (status, code, why) = rig.result(fast);
    assert!(status == GoalStatusEnum::Aborted && code == INVALID_GOAL && why.contains("at most"), "{why}");
    assert_eq!(rig.goals.news().newest, 0, "it was sent to the cell");

    // Of robots that move the cell alone can say it.
    rig.robots[0].as_mut().expect("there").demanded[1][0] = 0.1;
    let moving = rig.ask(0, &request(&ONE, 0.5, 2.0));
    rig.go(None);
    rig.state = GoalState {
        taken: rig.goals.news().newest,
        refusal: refusal::VELOCITY,
        about: [1.0, 1.0, 2.5, 1.5],
        ..rig.state
    };
    rig.hear();
    rig.go(None);
    let expected = "joint `left/a`: velocity 2.5000 rad/s on the way to point 1, at most 1.5000 rad/s";
    assert_eq!(rig.result(moving), (GoalStatusEnum::Aborted, INVALID_GOAL, expected.to_owned()));

    // Beside its path by more than it may be: halted, and told when it rests.
    rig.state.refusal = 0;
    let mut asks = request(&ONE, 0.5, 2.0);
    asks.path_tolerance = vec![Tolerance { name: "b".to_owned(), position: 0.01, ..Tolerance::default() }];
    let beside = rig.ask(0, &asks);
    let number = rig.begin(&[0]);
    rig.robots[0].as_mut().expect("there").measured[0][1] += 0.02;
    rig.go(None);
    assert!(rig.goals.news().cancelled.contains(&number));
    assert_eq!(rig.goals.result(beside), Ok(None));
    rig.end(0, false);
    let (_, code, why) = rig.result(beside);
    assert!(code == PATH_TOLERANCE_VIOLATED && why.starts_with("joint `b`: position off by -0.02"), "{why}");

    // At its end, but not where it should be, for longer than it may take.
    let mut asks = request(&ONE, 0.5, 2.0);
    asks.goal_tolerance = vec![Tolerance { name: "b".to_owned(), position: 0.01, ..Tolerance::default() }];
    asks.goal_time_tolerance = Duration { sec: 0, nanosec: 100_000_000 };
    let late = rig.ask(0, &asks);
    rig.begin(&[0]);
    rig.end(0, true);
    assert_eq!(rig.goals.result(late), Ok(None));
    for _ in 0..60 {
        rig.go(None);
        rig.hear();
    }
    assert_eq!(rig.result(late).1, GOAL_TOLERANCE_VIOLATED);
}

#[test]
fn no_goal_outlives_its_cell_or_its_program() {
    let mut rig = Rig::new();
    let stopped = rig.ask(0, &request(&ONE, 0.5, 2.0));
    rig.begin(&[0]);
    rig.go(Some("edp left: the drives are gone"));
    assert_eq!(rig.result(stopped).2, "the cell has stopped: edp left: the drives are gone");

    let again = rig.ask(0, &request(&ONE, 0.5, 2.0));
    rig.begin(&[0]);
    rig.state = GoalState { taken: rig.state.taken, refusal: refusal::OLD, ..GoalState::default() };
    rig.hear();
    rig.go(None);
    assert_eq!(rig.result(again).2, "the cell's program has begun anew");

    rig.state = GoalState::default();
    rig.hear();
    let silent = rig.ask(0, &request(&ONE, 0.5, 2.0));
    rig.begin(&[0]);
    for _ in 0..600 {
        rig.go(None);
    }
    assert_eq!(rig.result(silent).2, "no cell is running whose program takes goals now");
    // Where the program has only done something else, its robots follow it still: they are to halt.
    assert!(rig.goals.news().cancelled.contains(&rig.state.taken));

    // Where the robots do something else, or another goal took them.
    rig.hear();
    let taken = rig.ask(0, &request(&ONE, 0.5, 2.0));
    rig.begin(&[0]);
    rig.state.goals[0] += 1;
    rig.hear();
    rig.go(None);
    assert_eq!(rig.result(taken).2, "replaced by a newer goal");
    let moved = rig.ask(0, &request(&ONE, 0.5, 2.0));
    rig.begin(&[0]);
    rig.end(0, false);
    assert_eq!(rig.result(moved).2, "the cell's program moves the robots otherwise");

    // A minute later nobody asks for it.
    rig.now += 61_000 * MS;
    rig.hear();
    rig.go(None);
    assert_eq!(rig.goals.result(moved), Err(()));
}

#[test]
fn more_goals_than_are_looked_after_are_rejected_and_those_that_have_ended_make_room() {
    let mut rig = Rig::new();
    let asks = request(&ONE, 0.5, 2.0);
    let accepted = (0..1000)
        .filter(|_| rig.goals.request(0, Some(0), GoalId::new_random(), &asks, [rig.now, TODAY]))
        .count();
    assert_eq!(accepted, 100);
    // They fail when a fault comes, and the next hundred have their turn.
    rig.go(Some("gone"));
    let accepted = (0..1000)
        .filter(|_| rig.goals.request(0, Some(0), GoalId::new_random(), &asks, [rig.now, TODAY]))
        .count();
    assert_eq!(accepted, 100);
}

#[test]
fn what_takes_too_long_to_look_at_is_refused_at_once() {
    let offered = offered();
    let mut long = request(&ONE, 0.0, 2.0);
    long.trajectory.points[0].time_from_start.sec = i32::MAX;
    let refused = offered.read(&long, Some(0), TODAY).expect_err("too long");
    assert!(refused.error_string.contains("at most 600 s"), "{refused:?}");
    let mut many = request(&ONE, 0.0, 2.0);
    many.trajectory.points = vec![many.trajectory.points[0].clone(); 3000];
    let refused = offered.read(&many, Some(0), TODAY).expect_err("too many");
    assert!(refused.error_string.contains("16384 are possible"), "{refused:?}");
}

#[test]
fn fault_258_a_second_bridge_that_would_send_goals_is_refused_and_the_first_one_stays() {
    let port = format!("test-{}", std::process::id());
    let Offered { layout, joints } = offered();
    let begin = || super::Trajectories::at(&port, &layout, joints.clone());
    let first = begin().expect("nobody sends goals");
    let why = begin().err().expect("the first one sends them");
    assert!(why.contains("another program of this machine sends what the sensor reads"), "{why}");
    drop(first);
    begin().expect("the first one has gone");
}

/// A whole request, with all that a message may have.
fn encoded() -> Vec<u8> {
    let mut asks = request(&ONE, 0.5, 2.0);
    asks.path_tolerance = vec![Tolerance { name: "b".to_owned(), position: 0.01, ..Tolerance::default() }];
    to_vec::<_, LittleEndian>(&asks).expect("a message")
}

#[test]
fn fault_260_a_length_that_a_request_does_not_have_is_refused_before_it_is_believed() {
    let whole = encoded();
    assert_eq!(from_bytes::<Request, LittleEndian>(&whole).expect("a request").1, whole.len());
    for at in 0..whole.len() {
        from_bytes::<Request, LittleEndian>(&whole[..at]).expect_err("it is cut off");
    }
    // Wherever a length may be: were it believed, the memory of the machine would not do.
    for at in (0..whole.len() - 4).step_by(4) {
        let mut changed = whole.clone();
        changed[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
        if let Ok((read, _)) = from_bytes::<Request, LittleEndian>(&changed) {
            drop(offered().read(&read, Some(0), TODAY));
        }
    }
}

proptest! {
    #[test]
    fn fault_260_any_bytes_are_a_request_or_are_refused(
        bytes in prop::collection::vec(any::<u8>(), 0..600),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let mut changed = encoded();
        for (at, byte) in &changes {
            let at = at.index(changed.len());
            changed[at] = *byte;
        }
        let offered = offered();
        for bytes in [bytes, changed] {
            let Ok((request, _)) = from_bytes::<Request, LittleEndian>(&bytes) else { continue };
            // What is read of it has whole robots, and finite numbers within what is looked at.
            if let Ok(asked) = offered.read(&request, Some(0), TODAY) {
                prop_assert_eq!(asked.robots, [0]);
                let points = asked.goal.trajectory.points();
                prop_assert!(points.iter().all(|point| point.positions.iter().all(|q| q.is_finite())));
                prop_assert!(asked.goal.trajectory.duration() <= 600.0);
            }
        }
    }
}
