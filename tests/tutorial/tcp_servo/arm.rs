//! A turntable, and the drives of the servo that turns it, over TCP.

use std::net::SocketAddr;
use std::time::Duration;

use mrroc::cell::RobotSetup;
use mrroc::cell_file::Kinds;
use mrroc::robot::{DriveFault, Driver, Measured, Pace, Pulse, Recovery, RobotStop, StopCause};
use mrroc_driver_kit::{Cutting, Line};
use mrroc_robots::{One, Serial, Simulated, urdf_arm};

/// One joint, as table.urdf says.
pub type Arm = Serial<1>;

/// The kind "tcp-servo" in cell.toml; where nothing real may move, simulated drives stand in.
pub fn kinds() -> Kinds {
    mrroc_robots::simulated().with("tcp-servo", |entry| {
        let table = urdf_arm::<1>(entry)?;
        let simulated = Simulated::new(table.clone(), &entry.start(&table)?);
        let servo = Servo::at(entry.address_and_port(2000)?);
        Ok(RobotSetup::new(entry.name(), table, servo).stand_in(simulated))
    })
}

/// The servo's own period, and how long it may be silent, which counts in the time of a stop.
const PERIOD: Duration = Duration::from_millis(4);
const TIMEOUT: Duration = Duration::from_millis(100);
/// How long it may take to accept a connection: when it is opened, and at a reset, which must not wait.
const OPENING: Duration = Duration::from_secs(1);
const AGAIN: Duration = Duration::from_millis(5);

const fn stop(cause: StopCause) -> DriveFault {
    DriveFault::Stopped(RobotStop::new(cause))
}

const LOST: DriveFault = stop(StopCause::CommunicationLost);

/// What the servo says in each period: its count, position [rad], velocity [rad/s], and why it stands, 0 if it does not.
const SAID: usize = 8 + 8 + 8 + 1;

fn read(said: &[u8]) -> Option<(u64, Measured<One>, u8)> {
    let (count, said) = said.split_first_chunk()?;
    let (position, said) = said.split_first_chunk()?;
    let (velocity, said) = said.split_first_chunk()?;
    let [position, velocity] = [position, velocity].map(|bytes| One::new(f64::from_le_bytes(*bytes)));
    Some((u64::from_le_bytes(*count), Measured { position, velocity }, *said.first()?))
}

/// The drives: what the robot's EDP calls.
pub struct Servo {
    address: SocketAddr,
    line: Option<Line>,
    measured: Measured<One>,
    /// Whether it has said anything since it was called.
    has_spoken: bool,
    /// Why it does not move.
    stands: Option<DriveFault>,
}

impl Servo {
    /// Nothing is called before it is opened.
    pub fn at(address: SocketAddr) -> Servo {
        let measured = Measured { position: One::zeros(), velocity: One::zeros() };
        Servo { address, line: None, measured, has_spoken: false, stands: None }
    }

    fn call(&mut self, timeout: Duration) -> Result<(), DriveFault> {
        self.line = None; // it takes one connection at a time
        self.has_spoken = false;
        let line = Line::call(self.address, timeout, |_| Cutting::Frame(SAID));
        self.line = Some(line.map_err(|_| LOST)?);
        Ok(())
    }

    /// Reads all that has come, and returns when the last period began.
    fn hear(&mut self) -> Result<Option<Pulse>, DriveFault> {
        let line = self.line.as_mut().ok_or(LOST)?;
        let mut pulse = None;
        while let Some(frame) = line.oldest() {
            let (count, measured, state) = read(frame.bytes()).ok_or(LOST)?;
            self.measured = measured;
            self.has_spoken = true;
            self.stands = match state {
                0 => None,
                1 => Some(stop(StopCause::EmergencyStop)), // which a person at the robot clears
                2 => Some(stop(StopCause::PendantInControl)), // which its pendant gives back
                _ => Some(stop(StopCause::Failure)),
            };
            pulse = Some(Pulse { count, age: frame.age() });
        }
        if pulse.is_none() && !line.is_open() { Err(LOST) } else { Ok(pulse) }
    }

    fn may_move(&self) -> Result<(), DriveFault> {
        self.stands.map_or(Ok(()), Err)
    }
}

impl Driver<Arm> for Servo {
    fn period(&self) -> Duration {
        PERIOD
    }

    fn pace(&self) -> Pace {
        Pace::Robot { timeout: TIMEOUT }
    }

    fn hardware(&self) -> Option<String> {
        Some(format!("servo {}", self.address))
    }

    /// Before the cell begins: the one call that may wait.
    fn open(&mut self) -> Result<(), DriveFault> {
        self.call(OPENING)?;
        for _ in 0..OPENING.as_millis() {
            if self.hear()?.is_some() {
                return self.may_move();
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        Err(LOST) // it has accepted, and says nothing
    }

    fn close(&mut self) {
        self.line = None;
    }

    /// A period begins when the servo says so.
    fn pulse(&mut self, _: Duration) -> Result<Option<Pulse>, DriveFault> {
        let pulse = self.hear()?;
        self.may_move().map(|()| pulse)
    }

    fn measured(&self) -> Result<Measured<One>, DriveFault> {
        self.line.as_ref().map(|_| self.measured).ok_or(LOST)
    }

    /// The demand is within all limits already.
    fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
        let line = self.line.as_ref().ok_or(LOST)?;
        line.send(&demanded[0].to_le_bytes()).map_err(|_| LOST)?;
        Ok(self.measured)
    }

    /// Only an operator's reset calls it: if the line has ended, the servo is called again.
    fn recover(&mut self) -> Result<Recovery, DriveFault> {
        if self.line.as_ref().is_none_or(|line| !line.is_open()) {
            self.call(AGAIN)?;
        }
        self.hear()?; // what has come until now `pulse` may have taken already
        Ok(if self.has_spoken { Recovery::Over } else { Recovery::GoesOn })
    }

    /// Where it is now, and whether it may go on.
    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.hear()?;
        self.may_move()
    }
}
