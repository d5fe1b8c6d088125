//! A little of it over real lines, by the machine's clock.

use std::fs::File;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::time::Instant;

use super::*;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

/// No answer takes so long.
const LONG_TIMEOUTS: Timeouts =
    Timeouts { answer: Duration::from_secs(60), turn: Duration::from_secs(60), times: 1 };

/// Answers so many questions over a line, and then hangs up.
fn serve(port: impl AsFd + Send + 'static, questions: usize) {
    std::thread::spawn(move || {
        let (mut line, since) = (Line::over(port), Instant::now());
        let mut instrument = Instrument::new(|_, answer| vec![answer]);
        let (mut bytes, mut count, mut is_due) = ([0; 256], 0, false);
        while instrument.asked < questions || is_due {
            let (sent, next) = instrument.poll(since.elapsed(), &bytes[..count]);
            is_due = next.is_some();
            let mut rest = &sent[..];
            while !rest.is_empty() {
                rest = &rest[line.send(rest, Duration::from_secs(60)).expect("open")..];
            }
            let time = next.map_or(MS(1000), |next| next.saturating_sub(since.elapsed()));
            let Ok(came) = line.receive(&mut bytes, time) else { return };
            count = came;
        }
    });
}

/// Orders a sight until there is something to say of it.
fn ordered(sensor: &mut Theodolite, sight: Sight) -> Result<Angles, Fault> {
    loop {
        let read = sensor.aggregate(&ReadingOrder { configuration: sight, robot: None, step: 0 })?;
        if read.settled {
            return Ok(read);
        }
        std::thread::yield_now();
    }
}

#[test]
fn a_sensor_on_a_serial_port_reads_what_it_is_told_to_sight() {
    let instrument = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a pseudo-terminal");
    grantpt(&instrument).and_then(|()| unlockpt(&instrument)).expect("its other end");
    let port = ptsname(&instrument, Vec::new()).expect("its name").into_string().expect("text");
    // It hangs up no more than a cable does: by nobody who has it open.
    let _kept = File::options().read(true).write(true).open(&port).expect("its other end");
    serve(instrument, usize::MAX);
    let mut sensor = Theodolite::on(&port, 9600, LONG_TIMEOUTS);
    assert_eq!(sensor.hardware(), Some(format!("serial port {port}")));
    sensor.open().expect("it answers");
    let [hz, v] = DIRECTION;
    let read = ordered(&mut sensor, Sight { index: 1, hz, v, turned: true }).expect("a reading");
    assert!(read.turned && (read.hz - hz).abs() < 2e-4 && (read.v - v).abs() < 2e-4, "{read:?}");
}

#[test]
fn fault_185_a_line_whose_other_end_is_gone_is_a_fault_and_never_a_reading() {
    let serving = |questions| {
        let (here, there) = UnixStream::pair().expect("a socket");
        serve(there, questions);
        Line::over(here)
    };
    assert!(matches!(Theodolite::over(serving(0), LONG_TIMEOUTS), Err(GeocomError::Closed)));
    let mut sensor = Theodolite::over(serving(3), LONG_TIMEOUTS).expect("a sensor");
    let [hz, v] = DIRECTION;
    let why = ordered(&mut sensor, Sight { index: 1, hz, v, turned: true }).expect_err("closed");
    assert!(why.to_string().contains("closed"), "{why}");
}
