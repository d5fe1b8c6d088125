//! A controller of Universal Robots with a simulated arm, for tests: `cargo run -p mrroc-ur-controller -- ur5e`.
//!
//! It serves on the ports of a robot, at 127.0.0.1 or the address that follows the model, with the calibration of the file that may
//! follow that. Then it takes a command a line:
//! what is pressed at the robot (`emergency-stop`, `release`, `open`, `close`, `collide`, `violate`, `freedrive`,
//! `let-go`, `stop`, `pause`, `play`, `take-over`, `give-back`), `external ADDRESS:PORT`, where its program asks for a script when it is
//! played, `push` with force and torque at the flange [N, N m], `tool` with the tool centre point (x, y, z and a rotation vector [m, rad]),
//! `analog` with four inputs [V or A], `payload` with the mass and the centre in its installation [kg, m], `record FILE`, which writes every period from then on into a file of text, `say`,
//! which prints what it is doing and for how long a set-point was missing at most, and `end`. It ends with its input.

use std::fs::File;
use std::io::{self, BufRead, BufWriter, Write};
use std::net::IpAddr;
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};

use mrroc::pose::{Pose, Wrench};
use mrroc::robot::Load;
use mrroc_robots::Six;
use mrroc_ur::rtde::Value;
use mrroc_ur::{Calibration, Ports, UrModel};
use mrroc_ur_controller::{Controller, Press, Server};
use nalgebra::Vector3;

/// What is recorded of a period, after the timestamp.
const RECORDED: [&str; 13] = [
    "actual_q",
    "actual_qd",
    "target_q",
    "actual_TCP_pose",
    "robot_mode",
    "safety_mode",
    "safety_status_bits",
    "robot_status_bits",
    "actual_digital_output_bits",
    "actual_TCP_force",
    "standard_analog_input1",
    "standard_analog_output0",
    "standard_analog_output1",
];

type Record = Arc<Mutex<Option<BufWriter<File>>>>;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("ur-controller: {why}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), String> {
    let mut arguments = std::env::args().skip(1);
    let kind = arguments.next().unwrap_or_else(|| "ur5e".to_owned());
    let model = UrModel::ALL.into_iter().find(|model| model.kind() == kind);
    let model = model.ok_or(format!("no model `{kind}`: write ur3e, ur5e, ur10e, ur16e, ur20 or ur30"))?;
    let address = arguments.next().unwrap_or_else(|| "127.0.0.1".to_owned());
    let address: IpAddr =
        address.parse().map_err(|_| format!("`{address}` is no address of this machine"))?;
    let start = Six::new(0.0, -1.5, 1.5, -1.5, -1.5, 0.0);
    let record = Record::default();
    let recorded = Arc::clone(&record);
    let watch = Box::new(move |controller: &Controller| {
        let mut record = recorded.lock().unwrap_or_else(PoisonError::into_inner);
        let failed = record.as_mut().is_some_and(|file| write(file, controller).is_err());
        if failed {
            *record = None;
        }
    });
    let server = Server::watched(model, start, address, Ports::default(), watch)
        .map_err(|why| format!("cannot serve at {address}: {why}"))?;
    if let Some(file) = arguments.next() {
        let text = std::fs::read_to_string(&file).map_err(|why| format!("{file}: {why}"))?;
        let (_, calibration) = Calibration::parse(&text).map_err(|why| format!("{file}: {why}"))?;
        let calibrated = server.with(move |controller| controller.calibrate(&calibration));
        calibrated.ok_or("it serves no more")?.map_err(|why| format!("{file}: {why}"))?;
    }
    println!("{kind} at {address}");
    for line in io::stdin().lock().lines() {
        let line = line.map_err(|why| format!("its input: {why}"))?;
        let words: Vec<_> = line.split_whitespace().collect();
        match words[..] {
            [] => {}
            ["end"] => break,
            ["say"] => {
                let said = server.with(|controller| {
                    let lines = ["robotmode", "safetymode", "programState"];
                    let lines = lines.map(|line| controller.dashboard(line)).join(", ");
                    format!("{lines}, longest gap: {} ms", 2 * controller.longest_gap())
                });
                println!("{}", said.ok_or("it serves no more")?);
            }
            ["record", file] => {
                let file = File::create(file).map_err(|why| format!("{file}: {why}"))?;
                *record.lock().unwrap_or_else(PoisonError::into_inner) = Some(BufWriter::new(file));
                println!("records");
            }
            ["external", at] => match at.parse() {
                Ok(at) => drop(server.with(move |controller| controller.set_external_control(at))),
                Err(_) => println!("`{at}` is no address with a port"),
            },
            ["push", .., _] if numbers::<6>(&words).is_some() => {
                let [fx, fy, fz, tx, ty, tz] = numbers(&words).unwrap_or_default();
                let wrench = Wrench::new(Vector3::new(fx, fy, fz), Vector3::new(tx, ty, tz));
                server.with(move |controller| controller.push(wrench));
            }
            ["tool", .., _] if numbers::<6>(&words).is_some() => {
                let [x, y, z, rx, ry, rz] = numbers(&words).unwrap_or_default();
                let pose = Pose::translation(x, y, z) * Pose::rotation(Vector3::new(rx, ry, rz));
                server.with(move |controller| controller.set_tool(pose));
            }
            ["analog", .., _] if numbers::<4>(&words).is_some() => {
                let values = numbers(&words).unwrap_or_default();
                server.with(move |controller| controller.set_analog_inputs(values));
            }
            ["payload", .., _] if numbers::<4>(&words).is_some() => {
                let [mass, x, y, z] = numbers(&words).unwrap_or_default();
                let load = Load::point(mass, Vector3::new(x, y, z));
                server.with(move |controller| controller.install_payload(&load));
            }
            [word] => match press(word) {
                Some(press) => drop(server.with(move |controller| controller.press(press))),
                None => println!("no command `{word}`"),
            },
            _ => println!("no command `{line}`"),
        }
    }
    drop(server);
    if let Some(mut file) = record.lock().unwrap_or_else(PoisonError::into_inner).take() {
        file.flush().map_err(|why| format!("the record: {why}"))?;
    }
    Ok(())
}

/// The numbers behind the first word, if they are so many.
fn numbers<const N: usize>(words: &[&str]) -> Option<[f64; N]> {
    let numbers: Option<Vec<f64>> = words.get(1..)?.iter().map(|word| word.parse().ok()).collect();
    numbers?.try_into().ok()
}

fn press(word: &str) -> Option<Press> {
    Some(match word {
        "emergency-stop" => Press::EmergencyStop,
        "release" => Press::ReleaseEmergencyStop,
        "open" => Press::OpenDoor,
        "close" => Press::CloseDoor,
        "collide" => Press::Collide,
        "violate" => Press::Violate,
        "freedrive" => Press::Freedrive,
        "let-go" => Press::ReleaseFreedrive,
        "stop" => Press::StopProgram,
        "pause" => Press::PauseProgram,
        "play" => Press::Play,
        "take-over" => Press::TakeOver,
        "give-back" => Press::GiveBack,
        _ => return None,
    })
}

/// Writes one period: the timestamp and the fields, with all digits.
fn write(file: &mut impl Write, controller: &Controller) -> io::Result<()> {
    write!(file, "{:?}", controller.timestamp())?;
    for name in RECORDED {
        match controller.output(name) {
            Some(Value::Vector6d(values)) => {
                for value in values {
                    write!(file, " {value:?}")?;
                }
            }
            Some(Value::Double(value)) => write!(file, " {value:?}")?,
            Some(Value::Int32(value)) => write!(file, " {value}")?,
            Some(Value::Uint32(value)) => write!(file, " {value}")?,
            Some(Value::Uint64(value)) => write!(file, " {value}")?,
            Some(_) | None => {}
        }
    }
    writeln!(file)
}
