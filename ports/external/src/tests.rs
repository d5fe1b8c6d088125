//! The sensor against a program of another, which is played by a second node in this process.

use std::fs;

use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use mrroc::payload::Payload;

use super::*;
use crate::port::{node, prefix, service};

/// The step of the cell \[ns\].
const STEP: u64 = 2_000_000;

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
struct Part {
    x: f64,
    seen: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
struct Which {
    number: u32,
}

struct Camera;

impl Sensor for Camera {
    const KIND: &'static str = "camera";
    type Reading = Part;
    type Configuration = Which;
}

/// A folder of ports of this test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        Folder(std::env::temp_dir().join(format!("mrp{}-{name}", std::process::id())))
    }

    /// The sensor of this cell file, opened.
    fn sensor(&self, per_second: &str) -> External<Camera> {
        let mut sensor = self.closed(per_second);
        sensor.open().expect("the port is this test's alone");
        sensor
    }

    fn closed(&self, per_second: &str) -> External<Camera> {
        let text = format!(
            "step_ms = 2\n[robots.arm]\nkind = \"irp6\"\n[sensors.camera]\nmode = \"free running\"\nperiod_ms = 4\n\
             stale_after_ms = 100\n[sensors.camera.external]\nrate_hz = 30.0\nleast = [-1.0]\nlargest = [1.0]\n{per_second}"
        );
        let file = CellFile::parse("cell.toml", &text).expect("nothing is wrong with it");
        let mut sensor =
            External::<Camera>::new(file.external("camera").expect("it is there")).expect("one bound");
        sensor.folder.clone_from(&self.0);
        sensor.timeout = 0;
        sensor
    }

    /// A program of another.
    fn program(&self) -> Program {
        let node = node(&self.0, &prefix(&self.0)).expect("a node");
        let readings = service(&node, "camera", "readings").expect("a service");
        let orders = service(&node, "camera", "orders").expect("a service");
        Program {
            readings: readings.publisher_builder().create().expect("the only writer"),
            orders: orders.subscriber_builder().create().expect("one of eight"),
            _node: node,
        }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let names = fs::read_dir("/dev/shm").into_iter().flatten().flatten();
        let prefix = prefix(&self.0);
        let ours =
            names.filter(|entry| entry.file_name().to_str().is_some_and(|name| name.starts_with(&prefix)));
        ours.for_each(|entry| drop(fs::remove_file(entry.path())));
        drop(fs::remove_dir_all(&self.0));
    }
}

struct Program {
    readings: Publisher<ipc::Service, Message, ()>,
    orders: Subscriber<ipc::Service, Message, ()>,
    _node: Node<ipc::Service>,
}

impl Program {
    fn send(&self, message: Message) {
        self.readings.send_copy(message).expect("sent");
    }
}

/// A message with a reading, measured some nanoseconds ago.
fn reading(x: f64, ago: u64) -> Message {
    let mut message =
        Message { len: 2, layout: <Part as Wire>::LAYOUT, time: monotonic() - ago, ..Message::EMPTY };
    Part { x, seen: true }.put(&mut message.words);
    message
}

fn order(step: u64) -> ReadingOrder<Which> {
    ReadingOrder { configuration: Which { number: 7 }, robot: None, step }
}

/// What is read for the order of a step: the step in which it was taken, and the reading or the fault.
fn read(sensor: &mut External<Camera>, step: u64) -> Option<(u64, Result<Part, String>)> {
    let Taken::In(taken) = sensor.taken(&order(step)) else { return None };
    Some((taken, sensor.aggregate(&order(step)).map_err(|fault| fault.to_string())))
}

#[test]
fn a_reading_is_as_old_as_its_measurement_and_an_order_reaches_the_program() {
    let folder = Folder::new("age");
    let mut sensor = folder.sensor("");
    let program = folder.program();
    assert_eq!(read(&mut sensor, 100), None, "nothing has been sent");
    let ordered = program.orders.receive().expect("no failure").expect("an order");
    assert_eq!((ordered.version, ordered.len, ordered.step, ordered.words[0]), (VERSION, 16, 100, 7));
    assert_eq!(ordered.layout, <Which as Wire>::LAYOUT);
    program.send(reading(0.25, 10 * STEP));
    let (taken, part) = read(&mut sensor, 200).expect("a reading");
    assert_eq!(part, Ok(Part { x: 0.25, seen: true }));
    // Ten steps, and those that this test took.
    assert!(taken <= 190, "{taken}");
    assert_eq!(read(&mut sensor, 250), Some((taken, part)), "a program that hangs: the reading gets older");
    // The newest of two counts, an older one after it does not.
    program.send(reading(0.5, 0));
    assert_eq!(read(&mut sensor, 300).expect("a reading").1.map(|part| part.x), Ok(0.5));
    program.send(reading(0.75, 10 * STEP));
    assert_eq!(read(&mut sensor, 301).expect("a reading").1.map(|part| part.x), Ok(0.5));
}

#[test]
fn an_order_carries_the_state_of_the_sensors_robot() {
    let folder = Folder::new("state");
    let mut sensor = folder.sensor("");
    let program = folder.program();
    let state = EffectorState {
        joints: [0.5; mrroc::robot::MAX_JOINTS],
        velocity: [0.25; mrroc::robot::MAX_JOINTS],
        pose: mrroc::pose::Pose::translation(1.0, 2.0, 3.0),
        wrench: None,
    };
    let order = ReadingOrder { robot: Some(state), ..order(3) };
    assert_eq!(sensor.taken(&order), Taken::NotYet);
    let ordered = program.orders.receive().expect("no failure").expect("an order");
    // 16 words, 8 positions, 8 velocities, a position and a quaternion.
    assert_eq!(ordered.len, 16 + 8 + 8 + 7);
    assert_eq!(f64::from_bits(ordered.words[16]), 0.5);
    assert_eq!(
        ordered.words[32..39].iter().map(|&word| f64::from_bits(word)).collect::<Vec<_>>(),
        [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0]
    );
}

#[test]
fn a_measurement_from_before_the_cell_began_is_none_of_it() {
    let folder = Folder::new("before");
    let mut sensor = folder.sensor("");
    let program = folder.program();
    program.send(reading(0.0, 50 * STEP));
    assert_eq!(read(&mut sensor, 20), None);
    program.send(reading(0.1, 5 * STEP));
    assert!(read(&mut sensor, 10_000).is_some());
}

#[test]
fn fault_121_what_is_not_to_be_believed_is_a_fault_until_something_is() {
    let folder = Folder::new("lies");
    let mut sensor = folder.sensor("per_second = [0.001]");
    let program = folder.program();
    let mut step = 1_000_000;
    let mut told = |message: Message| {
        step += 1;
        program.send(message);
        read(&mut sensor, step).expect("a fault is told at once").1
    };
    assert!(told(reading(0.5, 0)).is_ok());
    for (message, words) in [
        (Message { version: 2, ..reading(0.5, 0) }, "another version of the port"),
        (Message { layout: 1, ..reading(0.5, 0) }, "make its module anew"),
        (Message { len: 3, ..reading(0.5, 0) }, "another number of words"),
        (Message { len: u32::MAX, ..reading(0.5, 0) }, "another number of words"),
        (Message { time: u64::MAX, ..reading(0.5, 0) }, "a reading of the future"),
        (reading(1.5, 0), "`x` is above its range"),
        (reading(f64::NAN, 0), "`x` is not finite"),
        (reading(0.9, 0), "`x` jumps"),
        (Message { words: [2; message::WORDS], ..reading(0.5, 0) }, "`x` "),
    ] {
        let fault = told(message).expect_err(words);
        assert!(fault.contains(words), "{fault}");
    }
    let mut truth = reading(0.5, 0);
    truth.words[1] = 2;
    assert!(told(truth).expect_err("no bool").contains("a value that its type does not have"));
    assert_eq!(told(reading(0.5, 0)), Ok(Part { x: 0.5, seen: true }));
}

#[test]
fn fault_121_a_second_program_and_a_second_sensor_are_refused_and_the_first_stays() {
    let folder = Folder::new("second");
    let mut sensor = folder.sensor("");
    let program = folder.program();
    let other = node(&folder.0, &prefix(&folder.0)).expect("a node");
    let readings = service(&other, "camera", "readings").expect("the same service");
    let refused = readings.publisher_builder().create().map(drop);
    assert_eq!(refused, Err(PublisherCreateError::ExceedsMaxSupportedPublishers));
    let told = folder.closed("").open().expect_err("a sensor has the port").to_string();
    assert!(told.contains("another sensor reads it"), "{told}");
    program.send(reading(0.5, 0));
    assert!(read(&mut sensor, 1000).is_some_and(|(_, part)| part.is_ok()));
    // A program that ends gives its place to the next one.
    drop(program);
    let next = folder.program();
    next.send(reading(0.25, 0));
    assert_eq!(read(&mut sensor, 2000).expect("a reading").1.map(|part| part.x), Ok(0.25));
}

#[test]
fn fault_121_a_port_that_others_made_differently_is_refused() {
    let folder = Folder::new("foreign");
    // Make the folder, and nothing that stays in it.
    drop(folder.sensor(""));
    let other = node(&folder.0, &prefix(&folder.0)).expect("a node");
    let name = ServiceName::new("mrroc/camera/readings").expect("a name");
    let small = other.service_builder(&name).publish_subscribe::<u64>().create().expect("a service");
    let told = folder.closed("").open().expect_err("eight bytes").to_string();
    assert!(told.contains("it has other messages or writers"), "{told}");
    drop(small);
    let many = other.service_builder(&name).publish_subscribe::<Message>().max_publishers(2).create();
    let many = many.expect("a service");
    let told = folder.closed("").open().expect_err("two writers").to_string();
    assert!(told.contains("port `camera`"), "{told}");
    drop(many);
    folder.sensor("");
}

#[test]
fn the_module_for_python_has_the_fields_of_the_reading_and_of_the_order() {
    let folder = Folder::new("python");
    let module = folder.closed("").python().expect("a program of another");
    let layout = format!("LAYOUT = 0x{:016X}", <Part as Wire>::LAYOUT);
    for line in [
        "PORT = \"camera\"",
        "RATE_HZ = 30.0",
        &layout,
        "    x: float\n    seen: bool\n",
        "READING = (\"fields\", Reading, (\"float\", \"truth\"))",
        "CONFIGURATION = (\"fields\", Configuration, (\"unsigned\",))",
        "Reading(x=0.0, seen=True)",
    ] {
        assert!(module.contains(line), "{line}: {module}");
    }
    assert!(!module.contains('@') || !module.contains("@C"), "a blank that was not filled");
}
