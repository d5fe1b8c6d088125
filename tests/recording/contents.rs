//! What is in a recording, read by the MCAP library alone.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use mrroc::cell::{InputSetup, OutputSetup};
use mrroc::observe::solid::Solid;
use mrroc::prelude::*;
use mrroc::recording::{CutOff, Replay};
use mrroc::robot::{Channel, Input};
use mrroc_generators::generators::Tell;
use mrroc_robots::{Irp6, SimulatedIrp6};
use mrroc_tests::{Gantry, MS, gantry};
use serde_json::{Value, json};

use crate::recording::cell::{Change, Count, Counted, Counting, START, STEP, arms};
use crate::recording::recorded;
use crate::runtime::kit::Smooth;

/// A message: its topic, its time since the start \[ns\], its contents.
#[derive(Debug, PartialEq)]
pub struct Message {
    pub topic: String,
    pub time: u64,
    pub body: Value,
}

/// The messages of a recording, and the date at which it started \[ns since 1970\].
pub fn read(file: &Path) -> (u64, Vec<Message>) {
    let bytes = fs::read(file).expect("a recording");
    let summary = mcap::Summary::read(&bytes).expect("an MCAP file").expect("a summary");
    let about = summary.metadata_indexes.iter().find(|index| index.name == "mrroc.start").expect("a start");
    let about = mcap::read::metadata(&bytes, about).expect("metadata");
    let start: u64 = about.metadata["start_ns"].parse().expect("a number");
    let messages = mcap::MessageStream::new(&bytes).expect("an MCAP file").map(|message| {
        let message = message.expect("a message");
        let body = serde_json::from_slice(&message.data).expect("JSON");
        Message { topic: message.channel.topic.clone(), time: message.log_time - start, body }
    });
    (start, messages.collect())
}

fn of<'a>(messages: &'a [Message], topic: &str) -> Vec<&'a Message> {
    messages.iter().filter(|message| message.topic == topic).collect()
}

/// Without the dates that Foxglove's messages have in them.
fn without_dates(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            fields.remove("timestamp");
            fields.values_mut().for_each(without_dates);
        }
        Value::Array(items) => items.iter_mut().for_each(without_dates),
        _ => {}
    }
}

#[test]
fn two_recordings_of_the_same_run_differ_in_their_dates_alone() {
    let since =
        |time: SystemTime| time.duration_since(SystemTime::UNIX_EPOCH).expect("after 1970").as_nanos();
    let before = since(SystemTime::now());
    let runs = ["once.mcap", "twice.mcap"].map(|name| {
        let (start, mut messages) = read(&recorded(name));
        messages.iter_mut().for_each(|message| without_dates(&mut message.body));
        (start, messages)
    });
    let after = since(SystemTime::now());
    let [(first, one), (second, other)] = runs;
    assert!(before <= first.into() && first < second && u128::from(second) <= after, "{first} {second}");
    assert_eq!(one.len(), other.len());
    for (one, other) in one.iter().zip(&other) {
        assert_eq!(one, other);
    }
    // A message is as far from the start as its step: the MP's step n begins at n times its length.
    for step in of(&one, "/steps") {
        assert_eq!(step.body["step"], json!(step.time / STEP.as_nanos() as u64));
    }
}

#[test]
fn instructions_are_recorded_as_they_begin_and_end() {
    let (_, messages) = read(&recorded("instructions.mcap"));
    let mut of_process = BTreeMap::<_, Vec<_>>::new();
    for message in of(&messages, "/instructions") {
        let text = |field: &str| message.body[field].as_str().expect("a text").to_owned();
        of_process.entry(text("process")).or_default().push(format!("{} {}", text("doing"), text("by")));
    }
    let ecp = |out: &str| {
        [out, "GoTo", "Follow"].map(|by| [format!("move {by}"), format!("nothing {by}")]).concat()
    };
    // The left one feels with its sensor, the right one has none.
    assert_eq!(of_process["ecp left"], ecp("Feel"));
    assert_eq!(of_process["ecp right"], ecp("GoTo"));
    let mp = ["wait Counted3", "move Ask", "move Ask", "move Swing"];
    let begun = of_process["mp"].iter().filter(|line| mp.iter().any(|known| known == line));
    assert_eq!(begun.collect::<Vec<_>>(), mp);
}

#[test]
fn the_currents_of_motors_are_recorded_where_drives_measure_them() {
    let (_, messages) = read(&recorded("currents.mcap"));
    let currents = of(&messages, "/robots/left/currents");
    assert_eq!(currents.len(), of(&messages, "/robots/left").len());
    // Before it moves, what holds it where it stands.
    let held = SimulatedIrp6::new(Irp6::nominal(), &START).currents();
    let numbers = |message: &Message| {
        let list = message.body["currents"].as_array().expect("a list");
        list.iter().map(|x| x.as_f64().expect("a number")).collect::<Vec<_>>()
    };
    assert_eq!(numbers(currents[0]), held.as_slice());
    assert!(currents.iter().any(|message| numbers(message)[0] != held[0]), "its column turns");
    // A robot that is not recorded has none.
    let file = file("without-left.mcap");
    arms(Change::Nothing)
        .record(mrroc::recording::to(&file).robots(["right"]))
        .run()
        .expect("keeps the limits");
    assert!(of(&read(&file).1, "/robots/left/currents").is_empty());
}

#[test]
fn inputs_and_outputs_are_recorded_by_their_names_and_a_replay_reads_what_they_read() {
    /// Waits for the switch of a vacuum, and moves then.
    fn cell() -> Cell {
        let (robot, _) = gantry("g");
        let robot = robot
            .output(OutputSetup::new("vacuum", Channel::Digital(0)))
            .output(OutputSetup::new("flow", Channel::Analog(1)))
            .input(InputSetup::new("sucked", Channel::Digital(9)).follows("vacuum", 20 * MS));
        Cell::new(MS).robot(robot).program(|mp| {
            let mut g = mp.robot::<Gantry>("g")?;
            let (vacuum, flow) = (g.output::<bool>("vacuum")?, g.output::<f64>("flow")?);
            let sucked = g.input::<bool>("sucked")?;
            mp.move_robot(&mut g, (), Tell::output(vacuum, true).and(flow, 2.5))?;
            mp.wait_until((&mut g,), (), On(sucked))?;
            mp.move_robot(&mut g, (), Smooth::to(0.2, 0.4)).map(drop)
        })
    }

    let file = file("signals.mcap");
    cell().record(mrroc::recording::to(&file)).run().expect("keeps the limits");
    let (_, messages) = read(&file);
    let signals = of(&messages, "/robots/g/signals");
    assert_eq!(signals.len(), of(&messages, "/robots/g").len());
    let off = serde_json::json!({"inputs": {"sucked": false}, "outputs": {"vacuum": false, "flow": 0.0}});
    let (first, last) = (&signals[0].body, &signals[signals.len() - 1].body);
    assert_eq!((&first["inputs"], &first["outputs"]), (&off["inputs"], &off["outputs"]));
    assert_eq!(last["inputs"]["sucked"], true);
    assert_eq!(
        (last["outputs"]["vacuum"].as_bool(), last["outputs"]["flow"].as_f64()),
        (Some(true), Some(2.5))
    );
    let first_on = |of: &str, name: &str| signals.iter().position(|message| message.body[of][name] == true);
    let after =
        first_on("inputs", "sucked").zip(first_on("outputs", "vacuum")).map(|(input, output)| input - output);
    assert_eq!(after, Some(20), "steps");
    // Without what the input read, the replay would wait for ever.
    let compared = cell().replay(&file, CutOff::Refused).expect("a recording of this cell");
    assert!(compared.is_identical() && compared.steps > 400, "{compared:?}");
}

/// Counts, as [`Counting`] does, and is hardware.
#[derive(Default)]
struct Camera;

impl VirtualSensor for Camera {
    type Kind = Count;

    fn hardware(&self) -> Option<String> {
        Some("camera /dev/video0".to_owned())
    }

    fn open(&mut self) -> Result<(), Fault> {
        panic!("a replay opens no hardware")
    }

    fn aggregate(&mut self, _: &ReadingOrder<()>) -> Result<Counted, Fault> {
        panic!("a replay reads no hardware")
    }
}

struct CountedTo(u64);

#[condition(mp)]
fn counted_to(c: &mut CountedTo, v: &Reading<(Count,)>) -> bool {
    v.0.reading().is_some_and(|counted| counted.count >= c.0)
}

#[test]
fn fault_120_a_recording_of_a_sensor_that_is_hardware_is_replayed_without_the_hardware() {
    fn cell() -> Cell {
        let sensor = SensorSetup::new("camera", Camera).stand_in(Counting::default());
        Cell::new(MS).robot(gantry("g").0).sensor(sensor).program(|mp| {
            let (mut g, mut camera) = (mp.robot::<Gantry>("g")?, mp.sensor::<Count>("camera")?);
            mp.wait_until((), (&mut camera,), CountedTo(30))?;
            mp.move_robot(&mut g, (), Smooth::to(0.2, 0.4)).map(drop)
        })
    }
    let file = file("hardware.mcap");
    let simulated = cell().simulated().expect("a sensor stands in");
    simulated.record(mrroc::recording::to(&file)).run().expect("keeps the limits");
    let compared = cell().replay(&file, CutOff::Refused).expect("a recording of this cell");
    assert!(compared.is_identical() && compared.steps > 400, "{compared:?}");
}

struct On(Input<bool>);

#[condition(mp)]
fn on(c: &mut On, e: &State<(Gantry,)>) -> bool {
    e.0.value(c.0)
}

#[test]
fn bodies_are_recorded_where_they_are_fifty_times_a_second() {
    let file = file("bodies.mcap");
    let mut looks = 0.0;
    let brick = move || {
        looks += 1.0;
        Pose::translation(looks, 0.0, 0.5)
    };
    let arm = RobotSetup::new("arm", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &START));
    let cell = Cell::new(STEP).robot(arm).shows_body("brick", [0.1, 0.2, 0.3], brick);
    let post = Solid::Cylinder { radius: 0.05, length: 1.0 };
    let cell = cell.shows_obstacle("post", Pose::translation(1.0, 0.0, 0.5), post);
    let cell = cell.program(|mp| {
        let mut arm = mp.robot::<Irp6>("arm")?;
        mp.wait_until((&mut arm,), (), Second(0)).map(drop)
    });
    cell.record(mrroc::recording::to(&file)).run().expect("it stands");
    let (_, messages) = read(&file);
    let bricks = of(&messages, "/bodies/brick");
    assert!((50..=52).contains(&bricks.len()), "{}", bricks.len());
    for (i, brick) in bricks.iter().enumerate() {
        assert_eq!(brick.body["pose"]["position"], json!({"x": (i + 1) as f64, "y": 0.0, "z": 0.5}));
        assert!(i == 0 || brick.time - bricks[i - 1].time <= Duration::from_millis(20).as_nanos() as u64);
    }
    let drawn =
        of(&messages, "/scene").into_iter().filter(|message| message.body["entities"][0]["id"] == "brick");
    assert_eq!(drawn.count(), bricks.len());
    // What never moves is drawn once.
    let standing = of(&messages, "/obstacles");
    assert_eq!(standing.len(), 1);
    let entity = &standing[0].body["entities"][0];
    assert_eq!((&entity["id"], &entity["cylinders"][0]["size"]["z"]), (&json!("post"), &json!(1.0)));
}

struct Second(u32);

#[condition(mp)]
fn second(c: &mut Second) -> bool {
    c.0 += 1;
    c.0 == 500
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}
