//! The drives of an arm behind a controller with the Robot Sensor Interface.
//!
//! In: positions for the ends of the controller's periods. Out: an answer to each of its messages, with corrections against
//! where the arm was when the interface was switched on; what the axes read.

#![expect(
    clippy::disallowed_methods,
    reason = "before the cell runs, and after it was stopped, the controller is waited for"
)]

use core::time::Duration;
use std::net::{IpAddr, SocketAddr};
use std::time::Instant;

use mrroc::robot::{DriveFault, Driver, Measured, Pace, Pulse, Robot};
use mrroc_driver_kit::{Counted, Datagram, Guest};
use nalgebra::SVector;

use crate::message::{AXES, FromController, ToController};

/// Joint positions [rad].
type Joints = SVector<f64, AXES>;

/// Periods for which the controller may say nothing: as many as its own `Timeout` usually allows to be late.
const SILENCE: u32 = 100;

/// How long to wait for the first message, when the drives are opened.
const FIRST: Duration = Duration::from_secs(2);

/// A controller, and where this machine listens for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RsiSettings {
    /// This machine's address on the controller's network, and the port there: the `IP_NUMBER` and `PORT` of its
    /// configuration.
    pub listen: SocketAddr,
    /// The controller's address: messages of anybody else are not looked at.
    pub robot: IpAddr,
    /// The name that the controller's configuration gives this end, its `SENTYPE`; `ImFree` by default, as in KUKA's examples.
    pub sensor: String,
    /// The controller's period, 4 ms by default, or 12.
    pub period: Duration,
}

impl RsiSettings {
    /// With the defaults.
    #[must_use]
    pub fn new(listen: SocketAddr, robot: IpAddr) -> RsiSettings {
        RsiSettings { listen, robot, sensor: "ImFree".to_owned(), period: Duration::from_millis(4) }
    }
}

/// The drives. They are paced by the controller.
#[derive(Debug)]
pub struct Rsi {
    settings: RsiSettings,
    link: Option<Link>,
}

/// The connection, once the controller has said something.
#[derive(Debug)]
struct Link {
    guest: Guest,
    /// Where the axes were when the interface was switched on, against which it counts corrections \[deg\].
    start: [f64; AXES],
    /// The corrections that the controller was told last \[deg\].
    told: [f64; AXES],
    /// The controller's last message, and when it was read.
    said: FromController,
    read: Instant,
    /// The same as a datagram while it is to be answered.
    unanswered: Option<Datagram>,
    /// Whether nobody demands anything: then messages are answered as soon as they are read, so that the controller does
    /// not break off.
    is_idle: bool,
    measured: Measured<Joints>,
}

impl Rsi {
    /// Drives that connect to nothing before they are opened.
    #[must_use]
    pub fn new(settings: RsiSettings) -> Rsi {
        Rsi { settings, link: None }
    }

    /// What was not taken of what came to this port; `None` while it is closed.
    #[must_use]
    pub fn counted(&self) -> Option<Counted> {
        self.link.as_ref().map(|link| link.guest.counted())
    }

    fn link(&mut self) -> Result<&mut Link, DriveFault> {
        self.link.as_mut().ok_or(CLOSED)
    }

    fn patience(&self) -> Duration {
        self.settings.period * SILENCE
    }
}

const CLOSED: DriveFault = DriveFault::Other("the controller is not connected");
const SILENT: DriveFault =
    DriveFault::Other("the controller sends nothing: start its program with RSI at the pendant, then reset");
const ANEW: DriveFault = DriveFault::Other(
    "the controller's program was started anew: reset, and the motion begins where the robot is",
);

impl Link {
    /// Answers the message that is to be answered, with what was told last.
    fn answer(&mut self, sensor: &str) -> Result<(), DriveFault> {
        let Some(datagram) = self.unanswered.take() else { return Ok(()) };
        let answer = ToController::corrections(sensor, self.said.ipoc, &self.told);
        let answer = answer.map_err(|_| DriveFault::Other("the name of the sensor is too long"))?;
        let sent = self.guest.answer(&datagram, answer.bytes());
        sent.map_err(|_| DriveFault::Other("the network takes nothing: is the cable plugged in?"))
    }

    /// Takes over what the controller says.
    fn hear(&mut self, said: FromController, datagram: Datagram, period: Duration) {
        let periods = said.ipoc.saturating_sub(self.said.ipoc) as f64 / (period.as_secs_f64() * 1e3);
        let position = radians(&said.axes);
        let velocity = match periods > 0.0 {
            true => (position - self.measured.position) / (periods * period.as_secs_f64()),
            false => Joints::zeros(),
        };
        self.measured = Measured { position, velocity };
        (self.said, self.read, self.unanswered) = (said, Instant::now(), Some(datagram));
    }

    /// The interface was switched on where the robot is now.
    fn begin(&mut self) {
        self.start = self.said.axes;
        self.told = [0.0; AXES];
        self.measured.velocity = Joints::zeros();
        self.is_idle = true;
    }
}

fn radians(degrees: &[f64; AXES]) -> Joints {
    Joints::from_fn(|i, _| degrees[i].to_radians())
}

impl<R: Robot<Joints = Joints>> Driver<R> for Rsi {
    fn period(&self) -> Duration {
        self.settings.period
    }

    fn pace(&self) -> Pace {
        Pace::Robot { patience: self.patience() }
    }

    fn hardware(&self) -> Option<String> {
        Some(format!("KUKA RSI {} at {}", self.settings.robot, self.settings.listen))
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        // The port is let go before.
        self.link = None;
        let guest = Guest::expect(self.settings.listen, self.settings.robot);
        let mut guest =
            guest.map_err(|_| DriveFault::Other("this machine has no such address, or its port is taken"))?;
        let until = Instant::now() + FIRST;
        while Instant::now() < until {
            let datagram = guest.newest();
            let said = datagram.as_ref().and_then(|datagram| FromController::read(datagram.bytes()));
            if let (Some(said), Some(datagram)) = (said, datagram) {
                let measured = Measured { position: radians(&said.axes), velocity: Joints::zeros() };
                let mut link = Link {
                    guest,
                    start: said.axes,
                    told: [0.0; AXES],
                    said,
                    read: Instant::now(),
                    unanswered: Some(datagram),
                    is_idle: true,
                    measured,
                };
                link.answer(&self.settings.sensor)?;
                self.link = Some(link);
                return Ok(());
            }
            std::thread::sleep(Duration::from_micros(200));
        }
        Err(SILENT)
    }

    fn close(&mut self) {
        // Without answers the controller stops the robot, which stands, and ends its program.
        self.link = None;
    }

    fn pulse(&mut self, _: Duration) -> Result<Option<Pulse>, DriveFault> {
        let period = self.settings.period;
        let link = self.link.as_mut().ok_or(CLOSED)?;
        let Some(datagram) = link.guest.newest() else { return Ok(None) };
        // What cannot be read is not answered: the controller counts that, and so does its patience.
        let Some(said) = FromController::read(datagram.bytes()) else { return Ok(None) };
        if said.ipoc < link.said.ipoc {
            link.hear(said, datagram, period);
            link.begin();
            link.answer(&self.settings.sensor)?;
            return Err(ANEW);
        }
        let age = datagram.age();
        link.is_idle |= link.unanswered.is_some();
        link.hear(said, datagram, period);
        if link.is_idle {
            link.answer(&self.settings.sensor)?;
        }
        let count = said.ipoc / (period.as_millis() as u64).max(1);
        Ok(Some(Pulse { count, age }))
    }

    fn measured(&self) -> Result<Measured<Joints>, DriveFault> {
        self.link.as_ref().map(|link| link.measured).ok_or(CLOSED)
    }

    fn tick(&mut self, demanded: &Joints) -> Result<Measured<Joints>, DriveFault> {
        let sensor = &self.settings.sensor;
        let link = self.link.as_mut().ok_or(CLOSED)?;
        link.told = core::array::from_fn(|i| demanded[i].to_degrees() - link.start[i]);
        link.is_idle = false;
        link.answer(sensor)?;
        Ok(link.measured)
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        let (period, patience) = (self.settings.period, self.patience());
        let sensor = self.settings.sensor.clone();
        let link = self.link()?;
        let silent = link.read.elapsed() > patience;
        let newest = link.guest.newest();
        let said = newest.as_ref().and_then(|datagram| FromController::read(datagram.bytes()));
        if let (Some(said), Some(datagram)) = (said, newest) {
            link.hear(said, datagram, period);
        } else if silent {
            return Err(SILENT);
        }
        // After a silence the interface was switched on anew, and counts corrections from where the robot stands.
        if silent {
            link.begin();
        }
        link.answer(&sensor)
    }
}

#[cfg(test)]
mod tests {
    use core::sync::atomic::{AtomicBool, Ordering};
    use std::net::UdpSocket;

    use mrroc::pose::Pose;
    use mrroc::robot::{Limits, NoInverse};

    use super::*;

    #[derive(Clone)]
    struct Arm(Limits<Joints>);

    impl Robot for Arm {
        const KIND: &'static str = "arm";
        type Joints = Joints;
        fn limits(&self) -> &Limits<Joints> {
            &self.0
        }
        fn forward(&self, _: &Joints) -> Pose {
            Pose::identity()
        }
        fn inverse(&self, _: &Pose, near: &Joints) -> Result<Joints, NoInverse> {
            Ok(*near)
        }
    }

    /// A controller on loopback, and the drives that it talks to.
    struct Bench {
        controller: UdpSocket,
        drives: Box<dyn Driver<Arm>>,
        listen: SocketAddr,
    }

    impl Bench {
        fn opened() -> Bench {
            let controller = UdpSocket::bind("127.0.0.1:0").expect("a socket");
            // A port that was free a moment ago.
            let listen = UdpSocket::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("a port");
            let robot = controller.local_addr().expect("bound").ip();
            let mut drives: Box<dyn Driver<Arm>> = Box::new(Rsi::new(RsiSettings::new(listen, robot)));
            assert!(drives.measured().is_err(), "nothing is open yet");
            let says = controller.try_clone().expect("the same socket");
            // It says the same until somebody listens.
            let done = AtomicBool::new(false);
            let opened = std::thread::scope(|scope| {
                scope.spawn(|| {
                    while !done.load(Ordering::Acquire) {
                        says.send_to(&said(4000, 10.0), listen).expect("sent");
                        std::thread::sleep(Duration::from_millis(4));
                    }
                });
                let opened = drives.open();
                done.store(true, Ordering::Release);
                opened
            });
            opened.expect("the controller speaks");
            Bench { controller, drives, listen }
        }

        fn says(&self, ipoc: u64, a1: f64) {
            self.controller.send_to(&said(ipoc, a1), self.listen).expect("sent");
        }

        /// The next answer, as text.
        fn answer(&self) -> String {
            let mut bytes = [0; 512];
            let len = self.controller.recv(&mut bytes).expect("an answer");
            String::from_utf8(bytes[..len].to_vec()).expect("text")
        }

        fn pulse(&mut self) -> Result<Pulse, DriveFault> {
            loop {
                if let Some(pulse) = self.drives.pulse(Duration::ZERO)? {
                    return Ok(pulse);
                }
                std::thread::sleep(Duration::from_micros(100));
            }
        }
    }

    fn said(ipoc: u64, a1: f64) -> Vec<u8> {
        let axes = r#"A2="-90" A3="90" A4="0" A5="45" A6="0""#;
        format!(r#"<Rob Type="KUKA"><AIPos A1="{a1}" {axes}/><IPOC>{ipoc}</IPOC></Rob>"#).into_bytes()
    }

    fn at(a1: f64) -> Joints {
        radians(&[a1, -90.0, 90.0, 0.0, 45.0, 0.0])
    }

    #[test]
    fn every_message_gets_one_answer_with_its_clock_and_corrections_against_the_start() {
        let mut bench = Bench::opened();
        assert_eq!(bench.drives.measured().map(|measured| measured.position), Ok(at(10.0)));
        let first = bench.answer();
        assert!(first.contains(r#"A1="0.000000""#) && first.contains("<IPOC>4000</IPOC>"), "{first}");

        // What had come while the drives were opened is not what comes now.
        bench.says(4004, 10.0);
        while bench.pulse().expect("it goes on").count != 1001 {}
        bench.drives.tick(&at(10.5)).expect("sent");
        bench.says(4008, 10.25);
        assert_eq!(bench.pulse().map(|pulse| pulse.count), Ok(1002));
        let measured = bench.drives.tick(&at(11.0)).expect("sent");
        assert_eq!(measured.position, at(10.25));
        let velocity = 0.25_f64.to_radians() / 4e-3;
        assert!((measured.velocity[0] - velocity).abs() < 1e-9, "{}", measured.velocity[0]);
        let mut answer = bench.answer();
        while !answer.contains("<IPOC>4008</IPOC>") {
            answer = bench.answer();
        }
        assert!(answer.contains(r#"A1="1.000000" A2="0.000000""#), "{answer}");

        // Nobody demands anything: the next message is left unanswered, and from then on the drives hold by themselves.
        bench.says(4012, 11.0);
        bench.pulse().expect("it goes on");
        bench.says(4016, 11.0);
        bench.pulse().expect("it goes on");
        let held = bench.answer();
        assert!(held.contains(r#"A1="1.000000""#) && held.contains("<IPOC>4016</IPOC>"), "{held}");
    }

    #[test]
    fn fault_89_a_controller_that_was_started_anew_moves_by_nothing_until_a_reset() {
        let mut bench = Bench::opened();
        bench.says(4004, 10.0);
        while bench.pulse().expect("it goes on").count != 1001 {}
        bench.drives.tick(&at(20.0)).expect("sent");
        // Its clock counts from the beginning, and corrections from where it stands.
        bench.says(8, 20.0);
        assert_eq!(bench.pulse(), Err(ANEW));
        let mut answer = bench.answer();
        while !answer.contains("<IPOC>8</IPOC>") {
            answer = bench.answer();
        }
        assert!(answer.contains(r#"A1="0.000000""#), "{answer}");
        bench.drives.switch_on().expect("it speaks");
        bench.says(12, 20.0);
        assert_eq!(bench.pulse().map(|pulse| pulse.count), Ok(3));
        bench.drives.tick(&at(20.5)).expect("sent");
        while !answer.contains("<IPOC>12</IPOC>") {
            answer = bench.answer();
        }
        // Held by the drives, or demanded: the message may have been answered before the tick.
        bench.says(16, 20.0);
        bench.pulse().expect("it goes on");
        bench.drives.tick(&at(20.5)).expect("sent");
        while !answer.contains("<IPOC>16</IPOC>") {
            answer = bench.answer();
        }
        assert!(answer.contains(r#"A1="0.500000""#), "{answer}");
    }

    #[test]
    fn fault_89_what_is_no_message_of_the_controller_is_not_answered() {
        let mut bench = Bench::opened();
        bench.says(4004, 10.0);
        while bench.pulse().expect("it goes on").count != 1001 {}
        let stranger = UdpSocket::bind("127.0.0.2:0").expect("a socket");
        stranger.send_to(&said(4008, 90.0), bench.listen).expect("sent");
        bench.controller.send_to(b"<Rob Type=\"KUKA\"><IPOC>4008</IPOC></Rob>", bench.listen).expect("sent");
        bench.says(4012, 10.0);
        while bench.pulse().expect("it goes on").count != 1003 {}
        assert_eq!(bench.drives.measured().map(|measured| measured.position), Ok(at(10.0)));
    }
}
