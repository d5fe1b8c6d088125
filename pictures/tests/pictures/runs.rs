//! Pictures of whole runs: what is in them is read back with an XML parser.

use std::f64::consts::PI;
use std::time::Duration;

use mrroc::cell::RunPicture;
use mrroc::observe::solid::Solid;
use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Driver, JointKind, Limits, Measured, NoInverse};
use mrroc_pictures::Film;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};
use nalgebra::{SVector, Translation3, Vector3};
use roxmltree::{Document, Node};

type Eight = SVector<f64, 8>;

/// Three slides along x, y, z and five joints at their end, all of links of 0.1 m in a row.
#[derive(Clone)]
struct Gantry {
    base: Vector3<f64>,
    limits: Limits<Eight>,
}

impl Gantry {
    fn at(x: f64, y: f64) -> Gantry {
        let all = Eight::repeat;
        let limits = Limits {
            lower: all(-4.0),
            upper: all(4.0),
            velocity: all(5.0),
            acceleration: all(50.0),
            jerk: None,
        };
        Gantry { base: Vector3::new(x, y, 1.0), limits }
    }
}

impl Robot for Gantry {
    const KIND: &'static str = "gantry";
    type Joints = Eight;

    fn joint(&self, i: usize) -> JointKind {
        if i < 3 { JointKind::Prismatic } else { JointKind::Revolute }
    }

    fn limits(&self) -> &Limits<Eight> {
        &self.limits
    }

    fn forward(&self, q: &Eight) -> Pose {
        let mut flange = Pose::identity();
        self.frames(q, &mut |frame| flange = *frame);
        flange
    }

    fn frames(&self, q: &Eight, visit: &mut dyn FnMut(&Pose)) {
        let mut frame = Pose::from_parts(self.base.into(), Pose::identity().rotation);
        visit(&frame);
        for i in 0..3 {
            frame.translation.vector[i] += q[i];
            visit(&frame);
        }
        for i in 3..8 {
            let axis = if i % 2 == 0 { Vector3::x() } else { Vector3::y() };
            frame = frame * Pose::rotation(axis * q[i]) * Translation3::new(0.0, 0.0, -0.1);
            visit(&frame);
        }
    }

    fn inverse(&self, _: &Pose, _: &Eight) -> Result<Eight, NoInverse> {
        Err(NoInverse::Singular { name: "untaught" })
    }
}

/// Drives that stay 0.004 m or rad behind in every joint.
struct Lagging(Eight);

const LAG: f64 = 0.004;

impl<R: Robot<Joints = Eight>> Driver<R> for Lagging {
    fn period(&self) -> Duration {
        Duration::from_millis(10)
    }

    fn measured(&self) -> Result<Measured<Eight>, DriveFault> {
        Ok(Measured { position: self.0, velocity: Eight::zeros() })
    }

    fn tick(&mut self, demanded: &Eight) -> Result<Measured<Eight>, DriveFault> {
        self.0 = demanded.map(|q| q - LAG);
        Driver::<R>::measured(self)
    }
}

/// A gantry that says nothing of its links.
#[derive(Clone)]
struct Flange(Gantry);

impl Robot for Flange {
    const KIND: &'static str = "flange";
    type Joints = Eight;

    fn limits(&self) -> &Limits<Eight> {
        self.0.limits()
    }

    fn forward(&self, q: &Eight) -> Pose {
        self.0.forward(q)
    }

    fn inverse(&self, pose: &Pose, near: &Eight) -> Result<Eight, NoInverse> {
        self.0.inverse(pose, near)
    }
}

/// Joint positions over path time, for any robot.
struct Along<R: Robot> {
    motion: fn(f64, R::Joints) -> R::Joints,
    from: Option<R::Joints>,
    t: f64,
    duration: f64,
}

#[generator(ecp)]
impl<R: Robot> Along<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Step<R> {
        self.from = Some(e.demanded().joints);
        self.next_step(t)
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        match self.from {
            Some(from) if self.t < self.duration => {
                self.t = (self.t + t.dt).min(self.duration);
                Step::Next(Demand::joints((self.motion)(self.t, from)))
            }
            Some(_) | None => Step::Done,
        }
    }
}

const START: Six = Irp6::READY;

fn arm(name: &str, base: Pose, duration: f64, motion: fn(f64, Six) -> Six) -> RobotSetup<Irp6> {
    let robot = Irp6::nominal().with_base(base);
    let drives = SimulatedIrp6::new(robot.clone(), &START);
    RobotSetup::new(name, robot, drives).program(move |ecp| {
        ecp.move_robot((), Along { motion, from: None, t: 0.0, duration })?;
        Ok(())
    })
}

/// Half a radian to the left and back in 2 s.
fn wave(t: f64, from: Six) -> Six {
    from + Six::new(0.25 * (1.0 - (PI * t).cos()), 0.0, 0.0, 0.0, 0.0, 0.0)
}

fn still(_: f64, from: Six) -> Six {
    from
}

fn gantry(name: &str, x: f64, y: f64, duration: f64) -> RobotSetup<Gantry> {
    let motion = |t: f64, from: Eight| {
        from + Eight::from_fn(|i, _| {
            0.05 * (1.0 + 0.4 * i as f64) * (1.0 - (t * (1.0 + 0.2 * i as f64)).cos())
        })
    };
    RobotSetup::new(name, Gantry::at(x, y), Lagging(Eight::zeros())).program(move |ecp| {
        ecp.move_robot((), Along { motion, from: None, t: 0.0, duration })?;
        Ok(())
    })
}

fn picture(cell: Cell) -> String {
    let mut film = Film::new();
    film.watch(cell).run().unwrap();
    film.svg()
}

fn cell() -> Cell {
    Cell::new(Duration::from_millis(10))
}

fn with_class<'a>(document: &'a Document<'a>, class: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    document.descendants().filter(move |node| node.attribute("class") == Some(class))
}

fn points(text: &str) -> Vec<(f64, f64)> {
    let number = |text: &str| text.parse::<f64>().unwrap();
    text.split_whitespace()
        .map(|pair| pair.split_once(',').unwrap())
        .map(|(x, y)| (number(x), number(y)))
        .collect()
}

fn texts(document: &Document<'_>) -> String {
    let lines: Vec<&str> = document
        .descendants()
        .filter(|node| node.has_tag_name("text"))
        .filter_map(|node| node.text())
        .collect();
    lines.join("\n")
}

#[test]
fn each_view_has_the_first_pose_the_last_pose_and_ghosts_between() {
    let svg = picture(cell().robot(arm("one", Pose::identity(), 2.0, wave)).robot(arm(
        "two",
        Pose::translation(0.0, 1.5, 0.0),
        2.0,
        wave,
    )));
    let document = Document::parse(&svg).unwrap();
    for class in ["start", "end"] {
        let poses: Vec<_> = with_class(&document, class).collect();
        assert_eq!(poses.len(), 2 * 3, "two robots in three views");
        for pose in poses {
            let links = pose.descendants().find(|node| node.attribute("class") == Some("links")).unwrap();
            // Shoulder, elbow, wrist, flange.
            assert_eq!(points(links.attribute("points").unwrap()).len(), 4);
        }
    }
    assert!(with_class(&document, "ghost").count() >= 12);
    // Six joints of two robots: positions and velocities demanded and measured; errors; the tool.
    assert_eq!(with_class(&document, "demanded").count(), 2 * 12);
    assert_eq!(with_class(&document, "measured").count(), 2 * (18 + 1));
}

#[test]
fn obstacles_stand_in_every_view_by_their_names() {
    let at = Pose::translation;
    let cloud: Vec<_> = (0..500)
        .map(|k| f64::from(k) * 0.02)
        .map(|t| Vector3::new(t.sin(), t.cos(), 0.05 * t) * 0.3)
        .collect();
    let run = cell()
        .robot(arm("one", Pose::identity(), 2.0, wave))
        .shows_obstacle("bench", at(1.3, 0.0, 0.2), Solid::Box { edges: [0.6, 1.2, 0.4] })
        .shows_obstacle("drum", at(0.2, 1.2, 0.5), Solid::Cylinder { radius: 0.3, length: 1.0 })
        .shows_obstacle(
            "rail",
            at(0.0, -1.0, 0.4) * Pose::rotation(Vector3::y() * 1.2),
            Solid::Capsule { radius: 0.05, length: 1.5 },
        )
        .shows_obstacle("lamp", at(0.6, 0.8, 1.5), Solid::Ball { radius: 0.15 })
        .shows_obstacle("scan", at(1.3, 0.0, 0.4), Solid::Points { points: cloud.into(), radius: 0.01 })
        .shows_obstacle("floor", at(0.0, 0.0, 0.0), Solid::HalfSpace);
    let svg = picture(run);
    let document = Document::parse(&svg).unwrap();
    let titles = with_class(&document, "obstacle").map(|group| {
        let title = group.descendants().find(|node| node.has_tag_name("title"));
        title.and_then(|title| title.text()).unwrap()
    });
    // A half space has no end and is not drawn.
    let names = ["bench", "drum", "rail", "lamp", "scan"];
    assert_eq!(titles.collect::<Vec<_>>(), [names; 3].concat());
    // Six faces of a box, two ends and a shell, one outline.
    let of = |name: &str| {
        let group = with_class(&document, "obstacle")
            .find(|group| group.descendants().any(|node| node.text() == Some(name)));
        group.unwrap().descendants().filter(|node| node.has_tag_name("polygon")).count()
    };
    assert_eq!(["bench", "drum", "rail", "lamp"].map(of), [6, 3, 1, 0]);
    no_words_overlap(&document);
}

/// From above, a column that turns from 0 to pi / 2 puts the arm from along x to along y, at the same length.
#[test]
fn the_view_from_above_shows_the_turn_of_a_column() {
    let turn = |t: f64, from: Six| {
        from + Six::new(0.25 * PI * (1.0 - (PI * t / 4.0).cos()), 0.0, 0.0, 0.0, 0.0, 0.0)
    };
    let svg = picture(cell().robot(arm("one", Pose::identity(), 4.0, turn)));
    let document = Document::parse(&svg).unwrap();
    let links = |class| {
        let pose = with_class(&document, class).nth(2).unwrap();
        let links = pose.descendants().find(|node| node.attribute("class") == Some("links")).unwrap();
        points(links.attribute("points").unwrap())
    };
    let (start, end) = (links("start"), links("end"));
    let reach = start[3].0 - start[0].0;
    assert!(reach > 50.0 && (start[3].1 - start[0].1).abs() < 0.3, "{start:?}");
    assert!((end[3].0 - end[0].0).abs() < 0.3 && ((end[0].1 - end[3].1) - reach).abs() < 0.3, "{end:?}");
    // In proportion to the elbow's distance from the column, by the forward kinematics.
    let arm = Irp6::nominal();
    let mut frames = Vec::new();
    arm.frames(&START, &mut |frame| frames.push(frame.translation.vector));
    let share = frames[3].x / arm.forward(&START).translation.vector.x;
    assert!((start[2].0 - start[0].0 - share * reach).abs() < 0.3);
}

#[test]
fn every_animation_has_as_many_times_as_values_from_0_to_1() {
    let svg = picture(cell().robot(arm("one", Pose::identity(), 2.0, wave)));
    let document = Document::parse(&svg).unwrap();
    let animations: Vec<_> = document.descendants().filter(|node| node.has_tag_name("animate")).collect();
    // Links and gripper in three views, and the lines over the robot's curves and over the rate.
    assert_eq!(animations.len(), 8);
    for animation in animations {
        let of = |name| animation.attribute(name).unwrap();
        let times: Vec<f64> = of("keyTimes").split(';').map(|time| time.parse().unwrap()).collect();
        let values: Vec<&str> = of("values").split(';').collect();
        assert_eq!(times.len(), values.len());
        assert_eq!((times[0], times[times.len() - 1]), (0.0, 1.0));
        assert!(times.windows(2).all(|w| w[0] <= w[1]));
        // 2 s in real time with a few steps of START and END, and a pause of 1.5 s.
        let seconds: f64 = of("dur").trim_end_matches('s').parse().unwrap();
        assert!((times[times.len() - 2] * seconds - 2.0).abs() < 0.05, "{seconds}");
        if of("attributeName") == "points" {
            let own = points(animation.parent_element().unwrap().attribute("points").unwrap());
            assert!(values.iter().all(|value| points(value).len() == own.len()));
            assert_eq!(points(values[0]), own);
        }
    }
}

#[test]
fn the_same_run_gives_the_same_bytes() {
    let make =
        || picture(cell().robot(arm("one", Pose::identity(), 1.0, wave)).robot(gantry("two", 2.0, 0.0, 1.0)));
    assert_eq!(make(), make());
}

#[test]
fn a_run_without_motion_says_so_and_moves_nothing() {
    let svg = picture(cell().robot(arm("one", Pose::identity(), 0.5, still)));
    let document = Document::parse(&svg).unwrap();
    assert!(texts(&document).contains("Nothing moved in"));
    assert!(texts(&document).contains("The tool stayed where it was."));
    assert_eq!(document.descendants().filter(|node| node.has_tag_name("animate")).count(), 0);
    assert_eq!(with_class(&document, "ghost").count(), 0);
}

#[test]
fn a_film_that_saw_nothing_is_a_picture_too() {
    let svg = Film::new().svg();
    assert!(texts(&Document::parse(&svg).unwrap()).contains("Nothing was seen"));
}

#[test]
fn the_largest_following_error_is_told_by_unit() {
    let svg = picture(cell().robot(gantry("portal", 0.0, 0.0, 1.0)));
    let document = Document::parse(&svg).unwrap();
    let texts = texts(&document);
    assert!(texts.contains("0.0040 rad"), "{texts}");
    assert!(texts.contains("0.0040 m"), "{texts}");
    assert!(
        texts.contains("Slides since the start [m]") && texts.contains("Joint angles since the start [rad]")
    );
}

#[test]
fn after_a_fault_the_picture_is_saved() {
    let leap = |t: f64, from: Six| if t < 0.5 { from } else { from + Six::repeat(1.0) };
    let mut film = Film::new();
    assert!(film.watch(cell().robot(arm("one", Pose::identity(), 1.0, leap))).run().is_err());
    let file = std::env::temp_dir().join(format!("mrroc-picture-{}.svg", std::process::id()));
    film.save(&file).unwrap();
    let saved = std::fs::read_to_string(&file).unwrap();
    std::fs::remove_file(&file).unwrap();
    assert_eq!(saved, film.svg());
    Document::parse(&saved).unwrap();
}

#[test]
fn a_robot_that_shows_its_flange_alone_has_a_gripper_and_a_path() {
    let motion = |t: f64, from: Eight| from + Eight::repeat(0.1 * (1.0 - t.cos()));
    let robot = RobotSetup::new("flange", Flange(Gantry::at(0.0, 0.0)), Lagging(Eight::zeros()));
    let svg = picture(cell().robot(robot.program(move |ecp| {
        ecp.move_robot((), Along { motion, from: None, t: 0.0, duration: 2.0 })?;
        Ok(())
    })));
    let document = Document::parse(&svg).unwrap();
    // Three views and the path alone.
    assert_eq!(with_class(&document, "path").count(), 4);
    assert!(document.descendants().filter(|node| node.has_tag_name("animate")).count() >= 4);
    no_words_overlap(&document);
}

/// Eight robots of eight joints for a minute: the most that a picture has to bear.
#[test]
fn the_largest_picture_is_small_and_its_words_do_not_overlap() {
    let mut whole = cell();
    for i in 0..8 {
        let name = format!("gantry_{i}");
        whole = whole.robot(gantry(&name, 1.2 * f64::from(i % 4), 1.5 * f64::from(i / 4), 60.0));
    }
    let svg = picture(whole);
    assert!(svg.len() < 1_400_000, "{} bytes", svg.len());
    let document = Document::parse(&svg).unwrap();
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    no_words_overlap(&document);
}

#[test]
fn the_usual_picture_is_below_half_a_megabyte_and_its_words_do_not_overlap() {
    let svg = picture(cell().robot(arm("one", Pose::identity(), 8.0, wave)).robot(arm(
        "two",
        Pose::translation(0.0, 0.02, 0.0),
        8.0,
        wave,
    )));
    assert!(svg.len() < 500_000, "{} bytes", svg.len());
    no_words_overlap(&Document::parse(&svg).unwrap());
}

/// Boxes of texts, at 0.56 of their height per character, are within the page and apart.
fn no_words_overlap(document: &Document<'_>) {
    let size = |name| document.root_element().attribute(name).unwrap().parse::<f64>().unwrap();
    let (width, height) = (size("width"), size("height"));
    let mut boxes: Vec<(f64, f64, f64, f64, &str)> = Vec::new();
    for node in document.descendants().filter(|node| node.has_tag_name("text")) {
        // A halo lies below its own words.
        if node.parent_element().is_some_and(|parent| parent.attribute("stroke-width") == Some("4")) {
            continue;
        }
        let of = |name| node.attribute(name).unwrap().parse::<f64>().unwrap();
        let Some(text) = node.text() else { continue };
        let (x, y, size) = (of("x"), of("y"), of("font-size"));
        let long = 0.56 * size * text.chars().count() as f64;
        let left = match node.attribute("text-anchor") {
            Some("middle") => x - 0.5 * long,
            Some("end") => x - long,
            _ => x,
        };
        let this = (left, y - 0.72 * size, left + long, y, text);
        assert!(
            this.0 >= 0.0 && this.2 <= width && this.1 >= 0.0 && this.3 <= height,
            "{this:?} leaves the page"
        );
        for other in &boxes {
            let apart = this.2 <= other.0 || other.2 <= this.0 || this.3 <= other.1 || other.3 <= this.1;
            assert!(apart, "{this:?} overlaps {other:?}");
        }
        boxes.push(this);
    }
}

/// A Wait between two Moves of an ECP's own program, and of the MP another two; the operator suspends the cell for a while.
#[test]
fn moves_waits_and_suspensions_are_marked_below_the_time_axes() {
    let base = Pose::translation(0.0, 1.5, 0.0);
    let robot = Irp6::nominal().with_base(base);
    let drives = SimulatedIrp6::new(robot.clone(), &START);
    let own = RobotSetup::new("own", robot, drives).program(|ecp| {
        for _ in 0..2 {
            ecp.serve(|ecp, _: Go| {
                ecp.move_robot((), Along { motion: wave, from: None, t: 0.0, duration: 2.0 })?;
                ecp.wait_until((), Dwell(500))?;
                ecp.move_robot((), Along { motion: wave, from: None, t: 0.0, duration: 2.0 }).map(drop)
            })?;
        }
        Ok(())
    });
    let mut film = Film::new();
    let cell = Cell::new(Duration::from_millis(2)).robot(own).on_step(|step, operator| match step {
        500 => operator.suspend(),
        1500 => operator.resume(),
        _ => {}
    });
    let cell = cell.program(|mp| {
        let mut own = mp.robot::<Irp6>("own")?;
        mp.move_robots((&mut own,), (), ask {})?;
        mp.wait_until((&mut own,), (), Pause(750))?;
        mp.move_robots((&mut own,), (), ask {}).map(drop)
    });
    film.watch(cell).run().expect("keeps the limits");
    let svg = film.svg();
    std::fs::write(std::env::temp_dir().join("marks.svg"), &svg).expect("a file");
    let document = Document::parse(&svg).expect("an SVG");
    let of_class = |class: &'static str| {
        document.descendants().filter(move |node| node.attribute("class") == Some(class)).collect::<Vec<_>>()
    };
    let words: Vec<_> = of_class("words").iter().filter_map(Node::text).collect();
    let ecp = |wait| ["Move Along", wait, "Move Along"];
    let mp = ["suspended", "Move ask", "Wait Pause", "Move ask"];
    // For a Wait of a second there is no room for both words.
    // Below the rate, the MP's once more.
    let expected = [&mp[..], &ecp("Dwell"), &ecp("Dwell"), &mp].concat();
    assert_eq!(words, expected);
    // Told with their times: the operator suspends at 1 s and resumes at 3 s.
    let told: Vec<_> = document
        .descendants()
        .filter(|node| node.has_tag_name("title"))
        .filter_map(|node| node.text())
        .collect();
    let at = |begins: &str| {
        let told =
            told.iter().find(|told| told.starts_with(begins)).unwrap_or_else(|| panic!("{begins}: {told:?}"));
        let numbers = told.split(' ').filter_map(|word| word.parse::<f64>().ok()).collect::<Vec<_>>();
        (numbers[0], numbers[1])
    };
    let suspended = at("suspended");
    assert!((suspended.0 - 1.0).abs() < 0.01 && (suspended.1 - 3.0).abs() < 0.01, "{suspended:?}");
    // 2 s of path time, and 2 s of suspension; the feed comes down and up again meanwhile.
    let along = at("Move Along");
    assert!(along.0 < 0.05 && along.1 > 3.9 && along.1 < 5.0, "{along:?}");
    let dwell = at("Wait Dwell");
    assert!((dwell.0 - along.1).abs() < 0.01 && (dwell.1 - dwell.0 - 1.0).abs() < 0.05, "{dwell:?}");
    let pause = at("Wait Pause");
    assert!((pause.1 - pause.0 - 1.5).abs() < 0.05, "{pause:?}");
    // One shade over the charts of the one robot, and one over the rate; bands side by side, none over another one.
    assert_eq!(of_class("suspended").len(), 2);
    let number =
        |node: &Node<'_, '_>, name: &str| node.attribute(name).expect(name).parse::<f64>().expect("a number");
    let bands: Vec<_> =
        of_class("band").iter().map(|node| ["x", "y", "width"].map(|name| number(node, name))).collect();
    assert_eq!(bands.len(), expected.len());
    for [one, next] in bands.array_windows::<2>() {
        assert!(one[1] < next[1] || one[0] + one[2] <= next[0] + 0.2, "{one:?} {next:?}");
    }
}

#[derive(Clone, Copy, Payload)]
enum Go {
    There,
}

#[generator(mp)]
fn ask() -> Always<(Irp6,), Go> {
    Always((Go::There,))
}

struct Dwell(u32);

#[condition(ecp)]
fn dwell(c: &mut Dwell) -> bool {
    c.0 = c.0.saturating_sub(1);
    c.0 == 0
}

struct Pause(u32);

#[condition(mp)]
fn pause(c: &mut Pause) -> bool {
    c.0 = c.0.saturating_sub(1);
    c.0 == 0
}
