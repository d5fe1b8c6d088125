//! The program of the book's page about virtual sensors, shown there word for word.

use std::net::SocketAddr;
use std::time::Duration;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::sensor::{Plausible, Taken};
use mrroc_driver_kit::Lines;
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
    lines: Lines,
    newest: Option<(u64, f64)>, // the step in which it came, and the distance [m]
}

impl Laser {
    /// At this address; one that sends nothing for two seconds is connected anew.
    pub fn at(address: SocketAddr) -> Laser {
        Laser { lines: Lines::over_tcp(address).silent_after(Duration::from_secs(2)), newest: None }
    }
}

impl VirtualSensor for Laser {
    type Kind = Distance;

    fn hardware(&self) -> Option<String> {
        Some(format!("laser {}", self.lines)) // one cell at a time, and none under the virtual clock
    }

    fn open(&mut self) -> Result<(), Fault> {
        self.lines.open().map_err(|why| Fault::new(FaultKind::SensorFailed).text(&why.to_string()))
    }

    fn taken(&mut self, order: &ReadingOrder<()>) -> Taken {
        // An order never waits for the laser; what is no number is no measurement.
        while let Some(line) = self.lines.next_line() {
            self.newest = line.trim().parse().map(|metres| (order.step, metres)).ok().or(self.newest);
        }
        self.newest.map_or(Taken::NotYet, |(step, _)| Taken::In(step))
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
    // 0 to 2 m, never the same to the bit for 500 steps: a real one has noise.
    let laser = Plausible::new(Laser::at(address), |at| [at.metres]).range([0.0], [2.0]).stuck_after(500);
    let sensor = file.sensor("laser", laser)?.stand_in(Table);
    Ok(file.cell(&simulated())?.sensor(sensor))
}
// ANCHOR_END: sensor

use std::sync::{Arc, Mutex};

use mrroc_driver_kit::testing::{Device, Reply, VirtualNetwork};

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

/// A laser of a test.
#[derive(Default)]
struct Server {
    says: Vec<u8>,
    closes: bool,
    connections: usize,
}

impl Device for Server {
    fn connected(&mut self) {
        self.connections += 1;
    }

    fn poll(&mut self, now: Duration, _: &[u8], reply: &mut Reply) -> Duration {
        reply.bytes = core::mem::take(&mut self.says);
        reply.closes = core::mem::take(&mut self.closes);
        now + Duration::from_millis(1)
    }
}

#[test]
fn a_laser_is_read_line_by_line_and_a_table_stands_in_for_it() {
    // On a virtual network: a laser that sends, sends rubbish, hangs, closes its connection and comes back.
    let server = Arc::new(Mutex::new(Server::default()));
    let network = VirtualNetwork::with(Arc::clone(&server));
    let mut laser = Laser::at(([10, 0, 0, 7], 5000).into());
    laser.lines = laser.lines.over(network.network());
    laser.open().expect("somebody listens");
    let order = |step| ReadingOrder { configuration: (), robot: None, step };
    let mut told = |says: &[u8], step: u64, ms: u64| {
        server.lock().expect("whole").says.extend(says);
        for _ in 0..ms {
            network.advance(Duration::from_millis(1));
            laser.taken(&order(step));
        }
        (laser.taken(&order(step)), laser.aggregate(&order(step)).map(|at| at.metres).ok())
    };
    assert_eq!(told(b"", 3, 5), (Taken::NotYet, None), "nothing has come");
    // Two measurements, of which the newer one counts, and the beginning of a third.
    assert_eq!(told(b"0.500\n0.153\n0.1", 4, 5), (Taken::In(4), Some(0.153)));
    assert_eq!(told(b"", 9, 5), (Taken::In(4), Some(0.153)), "as old as it is");
    assert_eq!(
        told(b"75\nERR 7\n\xff\xfe\n\n", 10, 5),
        (Taken::In(10), Some(0.175)),
        "rubbish is no measurement"
    );
    // It hangs for so long that it is connected anew, and then closes its connection.
    assert_eq!(told(b"", 11, 4000), (Taken::In(10), Some(0.175)));
    assert_eq!(server.lock().expect("whole").connections, 2);
    assert_eq!(told(b"0.2\n", 12, 5), (Taken::In(12), Some(0.2)));
    server.lock().expect("whole").closes = true;
    assert_eq!(told(b"", 13, 1500), (Taken::In(12), Some(0.2)));
    assert_eq!(told(b"0.3\n", 14, 5), (Taken::In(14), Some(0.3)));
    assert_eq!(server.lock().expect("whole").connections, 3);
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
    assert_eq!(cell.hardware(), ["laser tcp 127.0.0.1:9"]);
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
