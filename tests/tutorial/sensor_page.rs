//! The program of the book's page about virtual sensors, shown there word for word.

use std::io::Read;
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::sensor::Plausible;
use mrroc_robots::{Irp6, simulated};

// ANCHOR: sensor
/// The kind: what is read, and what programs name.
pub struct Distance;

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Metres {
    pub metres: f64,
}

impl Sensor for Distance {
    const KIND: &'static str = "distance";
    type Reading = Metres;
    type Configuration = (); // nothing is chosen with an order
}

/// A laser that sends a line of text for each measurement: `0.153` and a newline.
pub struct Laser {
    address: SocketAddr,
    stream: Option<TcpStream>,
    begun: Vec<u8>,             // a line that is not whole yet
    newest: Option<(u64, f64)>, // the step in which it came, and the distance [m]
}

impl VirtualSensor for Laser {
    type Kind = Distance;

    fn hardware(&self) -> Option<String> {
        Some(format!("laser {}", self.address)) // one cell at a time, and none under the virtual clock
    }

    fn open(&mut self) -> Result<(), Fault> {
        let failed = |error: std::io::Error| Fault::new(FaultKind::SensorFailed).text(&error.to_string());
        let stream = TcpStream::connect_timeout(&self.address, Duration::from_secs(2)).map_err(failed)?;
        stream.set_nonblocking(true).map_err(failed)?; // an order never waits for the laser
        self.stream = Some(stream);
        Ok(())
    }

    fn taken(&mut self, order: &ReadingOrder<()>) -> Option<u64> {
        let mut bytes = [0; 256];
        while let Some(Ok(read @ 1..)) = self.stream.as_mut().map(|stream| stream.read(&mut bytes)) {
            self.begun.extend_from_slice(&bytes[..read]);
            while let Some(end) = self.begun.iter().position(|&byte| byte == b'\n') {
                let line: Vec<u8> = self.begun.drain(..=end).collect();
                let metres = core::str::from_utf8(&line).ok().and_then(|line| line.trim().parse().ok());
                self.newest = metres.map(|metres| (order.step, metres)).or(self.newest);
            }
            self.begun.truncate(256); // what has no end is no measurement
        }
        self.newest.map(|(taken, _)| taken) // none yet: no reading
    }

    fn aggregate(&mut self, _: &ReadingOrder<()>) -> Result<Metres, Fault> {
        let (_, metres) = self.newest.ok_or_else(|| Fault::new(FaultKind::SensorFailed))?;
        Ok(Metres { metres })
    }
}

/// In its place where nothing real is read: how far the tool is above the table.
pub struct Table;

impl VirtualSensor for Table {
    type Kind = Distance;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Metres, Fault> {
        let arm = order.robot.ok_or_else(|| Fault::thrown("write `of` in its table of cell.toml"))?;
        Ok(Metres { metres: arm.pose.translation.z - 0.05 })
    }
}

fn measured(file: &CellFile, address: SocketAddr) -> Result<Cell, CellError> {
    let laser = Laser { address, stream: None, begun: Vec::new(), newest: None };
    // 0 to 2 m, never the same to the bit for 500 steps: a real one has noise.
    let laser = Plausible::new(laser, |at| [at.metres]).range([0.0], [2.0]).stuck_after(500);
    let sensor = file.sensor("laser", laser)?.stand_in(Table);
    Ok(file.cell(&simulated())?.sensor(sensor))
}
// ANCHOR_END: sensor

/// The cell of the page.
const LASER: &str = r#"step_ms = 2

[robots.arm]
kind = "irp6"
start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]

[sensors.laser]
of = "arm"
mode = "free running"
period_ms = 2
stale_after_ms = 100
"#;

#[test]
fn a_laser_is_read_line_by_line_and_a_table_stands_in_for_it() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("loopback");
    let address = listener.local_addr().expect("bound");
    let mut laser = Laser { address, stream: None, begun: Vec::new(), newest: None };
    laser.open().expect("somebody listens");
    let (mut sends, _) = listener.accept().expect("it has connected");
    let order = |step| ReadingOrder { configuration: (), robot: None, step };
    assert_eq!(laser.taken(&order(3)), None, "nothing has come");
    // Two measurements, of which the newer one counts, and the beginning of a third.
    std::io::Write::write_all(&mut sends, b"0.500\n0.153\n0.1").expect("sent");
    while laser.taken(&order(4)).is_none() {
        std::thread::yield_now();
    }
    while laser.newest != Some((4, 0.153)) {
        assert_eq!(laser.taken(&order(4)), Some(4));
    }
    assert_eq!(laser.taken(&order(9)), Some(4), "as old as it is");
    assert_eq!(laser.aggregate(&order(9)), Ok(Metres { metres: 0.153 }));
    // Nothing is opened where its simulated sensor stands in.
    let file = CellFile::parse("cell.toml", LASER).expect("a cell");
    let nowhere = SocketAddr::from(([127, 0, 0, 1], 9));
    let height = |mp: &mut Mp| {
        let mut laser = mp.sensor::<Distance>("laser")?;
        let mut arm = mp.robot::<Irp6>("arm")?;
        mp.wait_until((&mut arm,), (&mut laser,), Below(2.0))?;
        let read = laser.reading().ok_or_else(|| Fault::thrown("it was read"))?;
        assert!((read.metres - (arm.measured().pose.translation.z - 0.05)).abs() < 1e-3);
        Ok(())
    };
    let cell = measured(&file, nowhere).expect("its table is there").program(height);
    assert_eq!(cell.hardware(), ["laser 127.0.0.1:9"]);
    cell.simulated().expect("the table stands in").run().expect("it is read");
    assert!(
        measured(&file, nowhere).expect("a cell").program(|_| Ok(())).run().is_err(),
        "not under the virtual clock"
    );
}

/// The distance is less \[m\].
struct Below(f64);

#[condition(mp)]
fn below(c: &mut Below, v: &Reading<(Distance,)>) -> bool {
    v.0.reading().is_some_and(|reading| reading.metres < c.0)
}
