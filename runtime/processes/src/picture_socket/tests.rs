//! Both ends of the socket, and a plant that is slow, stands still or is gone.

use std::os::unix::net::UnixDatagram;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver as Permits, Sender as Tells, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use mrroc_core::fault::{Name, ProcessId, Role};
use mrroc_core::link::{Clock, Nanos};
use mrroc_core::observe::layout::{Layout, SensorLayout};
use mrroc_core::observe::recording::RunRecord;
use mrroc_core::observe::ring::Ring;
use mrroc_core::observe::step_observer::{ReadingState, StepEvent, StepObserver, StepRecord};
use mrroc_core::payload::Shape;
use mrroc_core::sensor::VspMode;
use proptest::prelude::*;

use super::datagram::{PictureRecord, read, socket};
use super::receiver::Receiver;
use super::sender::send;

/// More than the ring and the socket take.
const MANY: u64 = 200_000;

/// A folder of a session, which is removed.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let folder = std::env::temp_dir().join(format!("mrp{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        Folder(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn layout() -> Layout {
    let eye = SensorLayout {
        name: "eye".to_owned(),
        kind: "eye",
        of: None,
        readers: Vec::new(),
        every: 1,
        stale_after: Duration::from_millis(40),
        mode: VspMode::Interactive,
        latency: Duration::ZERO,
        reading: &Shape::Float,
        reading_layout: 0,
        hardware: mrroc_core::observe::layout::HardwareLayout::Nothing,
    };
    Layout {
        obstacles: Vec::new(),
        step: Duration::from_millis(2),
        stop_time: Duration::from_millis(600),
        path_stop: Duration::from_secs(1),
        protective_stop: Duration::from_secs(1),
        detection: 0.0,
        mp_program: true,
        cells: Vec::new(),
        robots: Vec::new(),
        sensors: vec![eye],
        frames: Vec::new(),
        tools: Vec::new(),
        bodies: Vec::new(),
    }
}

fn name(text: &str) -> Name {
    Name::new(text).expect("a name")
}

fn step(step: u64) -> StepEvent {
    StepEvent::Step(StepRecord {
        step,
        dt: 0.001,
        duration: 0.002,
        speed: 0.5,
        suspended: false,
        reduced: true,
        aborting: false,
        stopping: false,
        resetting: true,
    })
}

fn reading(step: u64, state: ReadingState) -> StepEvent {
    StepEvent::Reading { sensor: name("eye"), step, state, taken: step - 1, shape: &Shape::Float }
}

/// What an observer saw.
type Sight = (Nanos, ProcessId, String, Vec<u64>);

/// Keeps what it sees.
#[derive(Default)]
struct Keeps(Mutex<Vec<Sight>>);

impl StepObserver for Keeps {
    fn see(&self, time: Nanos, by: ProcessId, what: &StepEvent, words: &[u64]) {
        let sight = (time, by, format!("{what:?}"), words.to_vec());
        self.0.lock().expect("no panic").push(sight);
    }
}

#[test]
fn the_plant_sees_what_a_picture_needs_as_the_processes_have_shown_it() {
    let folder = Folder::new("same");
    let keeps = Arc::<Keeps>::default();
    let receiver = Receiver::open(&folder.0, layout(), vec![keeps.clone()]).expect("a socket");
    let ring = send(socket(&folder.0), Clock::Virtual, Duration::from_secs(60)).expect("a thread");
    let (ecp, edp) = (ProcessId::new(Role::Ecp, name("arm")), ProcessId::new(Role::Edp, name("arm")));
    let needed: [(ProcessId, StepEvent, &[u64]); 5] = [
        (ProcessId::MP, step(7), &[]),
        (ProcessId::MP, reading(7, ReadingState::There), &[2.5_f64.to_bits()]),
        (ecp, reading(8, ReadingState::Lost), &[]),
        (edp, StepEvent::Signals { step: 8 }, &[1, 2, 3]),
        (ProcessId::MP, step(8), &[]),
    ];
    for (i, (by, what, words)) in needed.iter().enumerate() {
        ring.see(1000 * i as u64, *by, what, words);
        ring.see(1000 * i as u64, *by, &StepEvent::Late { step: 8 }, words);
        ring.see(1000 * i as u64, *by, &StepEvent::Currents { step: 8 }, words);
    }
    ring.finish();
    receiver.finish();
    let expected: Vec<Sight> = needed
        .iter()
        .enumerate()
        .map(|(i, (by, what, words))| (1000 * i as u64, *by, format!("{what:?}"), words.to_vec()))
        .collect();
    assert_eq!(*keeps.0.lock().expect("no panic"), expected);
}

/// Looks on as slowly as it is allowed to.
struct Waits(Mutex<(Permits<()>, u64)>);

impl StepObserver for Waits {
    fn see(&self, _: Nanos, _: ProcessId, what: &StepEvent, _: &[u64]) {
        let mut seen = self.0.lock().expect("no panic");
        let expected = seen.1;
        assert!(
            matches!(what, StepEvent::Step(StepRecord { step, .. }) if *step == expected),
            "{what:?}, not {expected}"
        );
        seen.1 += 1;
        // Once; then the other end is gone.
        let _ = seen.0.recv();
    }
}

fn waits() -> (Tells<()>, Arc<Waits>) {
    let (lets, waits) = channel();
    (lets, Arc::new(Waits(Mutex::new((waits, 0)))))
}

#[test]
fn under_the_virtual_clock_nothing_is_lost_however_slow_the_plant_is() {
    let folder = Folder::new("slow");
    let (lets, observer) = waits();
    let receiver = Receiver::open(&folder.0, layout(), vec![observer.clone()]).expect("a socket");
    let ring = send(socket(&folder.0), Clock::Virtual, Duration::from_secs(60)).expect("a thread");
    // Time in which the ring becomes full; the result does not depend on it.
    let later = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(200));
        drop(lets);
    });
    (0..MANY).for_each(|i| ring.see(i, ProcessId::MP, &step(i), &[]));
    ring.finish();
    receiver.finish();
    later.join().expect("it ends");
    assert_eq!(observer.0.lock().expect("no panic").1, MANY);
}

/// Reads a socket to the end of what a process shows: how much of it came, and how much the process has dropped.
fn read_all(socket: &UnixDatagram) -> (u64, u64) {
    let (mut bytes, mut came) = (vec![0; 64 * 1024], 0);
    loop {
        let len = socket.recv(&mut bytes).expect("a datagram");
        let words: Vec<u64> =
            bytes[..len].as_chunks::<8>().0.iter().map(|word| u64::from_le_bytes(*word)).collect();
        for shown in read(&words, &layout()) {
            match shown {
                PictureRecord::Something(..) => came += 1,
                PictureRecord::End(lost) => return (came, lost),
            }
        }
    }
}

fn show_many(ring: &Ring) {
    (0..MANY).for_each(|i| ring.see(i, ProcessId::MP, &step(i), &[]));
}

#[test]
fn a_plant_that_stands_still_delays_no_step_in_real_time_and_what_it_lacks_is_told() {
    let folder = Folder::new("still");
    let plant = UnixDatagram::bind(socket(&folder.0)).expect("a socket");
    let ring = send(socket(&folder.0), Clock::Real, Duration::from_secs(60)).expect("a thread");
    // Nobody reads meanwhile: a step that waited would wait for ever.
    show_many(&ring);
    let reads = std::thread::spawn(move || read_all(&plant));
    ring.finish();
    let (came, lost) = reads.join().expect("it ends");
    assert!(lost > 0 && came > 0, "{came} came, {lost} lost");
    assert_eq!(came + lost, MANY);
}

#[test]
fn a_process_ends_though_its_plant_stands_still_for_ever() {
    let folder = Folder::new("ends");
    let _plant = UnixDatagram::bind(socket(&folder.0)).expect("a socket");
    for clock in [Clock::Real, Clock::Virtual] {
        let ring = send(socket(&folder.0), clock, Duration::from_millis(20)).expect("a thread");
        show_many(&ring);
        ring.finish();
    }
}

#[test]
fn a_process_runs_on_when_there_is_no_plant_or_it_is_gone() {
    let folder = Folder::new("gone");
    for was_there in [false, true] {
        if was_there {
            // Its file stays when it is killed.
            drop(UnixDatagram::bind(socket(&folder.0)).expect("a socket"));
        }
        for clock in [Clock::Real, Clock::Virtual] {
            let ring = send(socket(&folder.0), clock, Duration::from_secs(60)).expect("a thread");
            show_many(&ring);
            ring.finish();
        }
    }
}

proptest! {
    #[test]
    fn any_words_are_read_without_a_panic(words in proptest::collection::vec(prop_oneof![0..6_u64, any::<u64>()], 0..64)) {
        prop_assert!(read(&words, &layout()).count() <= words.len());
    }
}
