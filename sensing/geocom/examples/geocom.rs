//! A simulated instrument on a serial port, or sights by one.
//!
//! ```text
//! cargo run -p mrroc-examples --example geocom -- instrument /dev/pts/3
//! cargo run -p mrroc-examples --example geocom -- sight /dev/ttyUSB0 0.7 -0.3     # about where, rad: in both faces
//! ```

use std::error::Error;
use std::time::Duration;

use mrroc_geocom::{Connection, Face, Line, Lines, Simulated, Targets, Timeouts};

/// What the simulated one sees.
const DIRECTIONS: [[f64; 2]; 2] = [[0.7, -0.3], [-2.0, 0.1]];
const AXES: [f64; 3] = [4e-5, -7e-5, 6e-5];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match &arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["instrument", port] => {
            let mut line = Line::open(port, 9600)?;
            let mut instrument = Simulated::new(Targets { directions: DIRECTIONS.to_vec(), axes: AXES });
            let (mut lines, mut bytes) = (Lines::new(), [0; 256]);
            println!("ready");
            loop {
                let count = line.receive(&mut bytes, Duration::from_secs(1))?;
                lines.push(&bytes[..count]);
                while let Some(asked) = lines.next_line()? {
                    // So that a test of another program sees what a compensator out of range does.
                    match &*asked {
                        "tilt" => instrument.is_level = false,
                        "level" => instrument.is_level = true,
                        _ => {
                            let answer = instrument.answer(&asked).map(|answer| format!("{answer}\r\n"));
                            let mut rest = answer.as_deref().unwrap_or("").as_bytes();
                            while !rest.is_empty() {
                                rest = &rest[line.send(rest, Duration::from_secs(2))?..];
                            }
                        }
                    }
                }
            }
        }
        ["sight", port, hz, v] => {
            let mut instrument = Connection::new(Line::open(port, 9600)?, Timeouts::default());
            instrument.greet()?;
            let about = [hz.parse()?, v.parse()?];
            for face in [Face::One, Face::Two] {
                let [hz, v] = instrument.sight(about, face)?.angles;
                println!("{face:?} {hz:.9} {v:.9}");
            }
            Ok(())
        }
        _ => Err("write `instrument PORT` or `sight PORT HZ V`".into()),
    }
}
