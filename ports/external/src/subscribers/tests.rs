//! Subscribers of whole cells, in this process.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use mrroc::cell::Cell;
use mrroc::fault::{Fault, Name, ProcessId, Role};
use mrroc::generator::RobotHandle;
use mrroc::observe::step_observer::{STATE_WORDS, StepEvent, StepObserver, StepRecord};
use mrroc::payload::Wire;
use mrroc::prelude::*;
use mrroc::robot::RobotState;
use mrroc_generators::generators::JointMove;
use mrroc_launch::cell_file::CellFile;
use mrroc_robots::{Irp6, Six, simulated};

use super::{Image, KEPT, ReadingShown, StepShown, Subscriber, Subscribers};
use crate::plant::tests::Folder;

/// A cell of one arm, which is shown at a port of this folder.
fn cell(folder: &Folder) -> Cell {
    let text = "step_ms = 2\nrobots.arm = { kind = \"irp6\", start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0] }";
    let file = CellFile::parse("cell.toml", text).expect("nothing is wrong with it");
    let subscribers = Subscribers { port: "cell".to_owned(), folder: folder.0.clone() };
    file.cell(&simulated()).expect("a kind that is known").shown_to(subscribers)
}

fn subscriber(folder: &Folder) -> Subscriber {
    Subscriber::below(&folder.0, "cell", &["arm"]).expect("there is room")
}

/// Who has shown a reading; its step, the step in which it was taken, and its time; and its words.
type SeenReading = (ProcessId, [u64; 3], Vec<u64>);

/// Keeps the words of all images and readings that are shown in this process, with the steps and times of them.
#[derive(Default)]
struct Seen {
    images: RefCell<Vec<(u64, u64, Vec<u64>)>>,
    readings: RefCell<Vec<SeenReading>>,
}

impl StepObserver for Seen {
    fn see(&self, time: u64, by: ProcessId, what: &StepEvent, words: &[u64]) {
        match *what {
            StepEvent::Image { step, .. } => self.images.borrow_mut().push((step, time, words.to_vec())),
            StepEvent::Reading { step, taken, .. } => {
                self.readings.borrow_mut().push((by, [step, taken, time], words.to_vec()));
            }
            _ => {}
        }
    }
}

/// The sensor of a cell with one: what it reads depends on the step alone.
struct Gauge;

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
struct Gap {
    width: f64,
    is_wide: bool,
}

impl Gap {
    fn of(step: u64) -> Gap {
        let width = 0.1 * (0.37 * step as f64).sin();
        Gap { width, is_wide: width > 0.05 }
    }
}

impl Sensor for Gauge {
    const KIND: &'static str = "gauge";
    type Reading = Gap;
    type Configuration = ();
}

impl VirtualSensor for Gauge {
    type Kind = Gauge;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Gap, Fault> {
        Ok(Gap::of(order.step))
    }
}

/// A condition that reads so often.
struct Often(usize);

#[condition(mp)]
fn often(c: &mut Often, _: &Reading<(Gauge,)>) -> bool {
    c.0 -= 1;
    c.0 == 0
}

/// A motion that reads so often, and stands.
struct Watch(usize);

#[generator(ecp)]
fn watch(c: &mut Watch, _: &Reading<(Gauge,)>) -> Step<Irp6> {
    c.0 -= 1;
    if c.0 == 0 { Step::Done } else { Step::Next(Demand::hold()) }
}

#[derive(Clone, Copy, Payload)]
enum Go {
    There,
}

#[generator(mp)]
fn ask() -> Always<(Irp6,), Go> {
    Always((Go::There,))
}

const OFTEN: usize = 2 * KEPT;

/// A cell in which the MP reads a sensor often, and then the ECP of the arm does; each reading counts for three steps.
fn gauged(folder: &Folder, has_seen: &Arc<AtomicBool>) -> Cell {
    let text = "step_ms = 2\nrobots.arm = { kind = \"irp6\", start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0] }\n\
                sensors.gauge = { of = \"arm\", every = 3 }";
    let file = CellFile::parse("cell.toml", text).expect("nothing is wrong with it");
    let subscribers = Subscribers { port: "cell".to_owned(), folder: folder.0.clone() };
    let gauge = file.sensor("gauge", Gauge).expect("it is in the file");
    let cell = file.cell(&simulated()).expect("a kind that is known").sensor(gauge).shown_to(subscribers);
    let serve = |ecp: &mut Ecp<Irp6>| {
        let mut gauge = ecp.sensor::<Gauge>("gauge")?;
        ecp.serve(|ecp, _: Go| ecp.move_robot((&mut gauge,), Watch(OFTEN)).map(drop))
    };
    let has_seen = Arc::clone(has_seen);
    cell.ecp::<Irp6>("arm", serve).program(move |mp| {
        let (mut arm, mut gauge) = (mp.robot::<Irp6>("arm")?, mp.sensor::<Gauge>("gauge")?);
        mp.wait_until((), (&mut gauge,), Often(OFTEN))?;
        wait_for(&has_seen);
        mp.wait_until((), (&mut gauge,), Often(OFTEN))?;
        mp.move_robots((&mut arm,), (), ask {}).map(drop)
    })
}

fn lift(mp: &mut Mp) -> Result<(), Fault> {
    let mut arm = mp.robot::<Irp6>("arm")?;
    raise(mp, &mut arm, 0.05)?;
    Err(Fault::thrown(AWRY))
}

fn raise(mp: &mut Mp, arm: &mut RobotHandle<Irp6>, by: f64) -> Result<(), Fault> {
    let to = arm.demanded().joints.map(|q| q + by);
    mp.move_robot(arm, (), JointMove::to(to, Six::repeat(0.5), Six::repeat(1.0))).map(drop)
}

fn name(text: &str) -> Name {
    Name::new(text).expect("a name")
}

const AWRY: &str = "the work is not where it should be";

/// Sets a flag when it goes, also where a test has failed: who waits for the other side then waits no more.
struct Set<'a>(&'a AtomicBool);

impl Drop for Set<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// What a program sees that subscribes until the cell is over, and says when it has seen something, or never will.
fn subscribe(
    folder: &Folder,
    has_begun: &AtomicBool,
    has_seen: &AtomicBool,
    has_ended: &AtomicBool,
) -> (Vec<Image>, Vec<StepShown>) {
    let (_begun, _seen) = (Set(has_begun), Set(has_seen));
    let mut subscriber = subscriber(folder);
    has_begun.store(true, Ordering::Release);
    let (mut images, mut steps) = (Vec::new(), Vec::new());
    while steps.last().is_none_or(|step: &StepShown| !step.over) {
        let is_last = has_ended.load(Ordering::Acquire);
        images.extend(core::iter::from_fn(|| subscriber.image()));
        steps.extend(core::iter::from_fn(|| subscriber.step()));
        if !images.is_empty() && !steps.is_empty() {
            has_seen.store(true, Ordering::Release);
        }
        assert!(
            !is_last || steps.last().is_some_and(|step| step.over),
            "the cell has ended, and shown no end"
        );
        std::thread::yield_now();
    }
    images.extend(core::iter::from_fn(|| subscriber.image()));
    (images, steps)
}

fn wait_for(it: &AtomicBool) {
    while !it.load(Ordering::Acquire) {
        std::thread::yield_now();
    }
}

#[test]
fn subscribers_see_the_images_of_each_step_to_the_bit_and_the_fault_that_ends_it() {
    let folder = Folder::new("subscriber");
    let (has_begun, has_seen) = (AtomicBool::new(false), Arc::new(AtomicBool::new(false)));
    let has_ended = AtomicBool::new(false);
    let seen = Rc::new(Seen::default());
    let (images, steps) = std::thread::scope(|scope| {
        let subscriber = scope.spawn(|| subscribe(&folder, &has_begun, &has_seen, &has_ended));
        let ended_or_failed = Set(&has_ended);
        wait_for(&has_begun);
        let has_seen = Arc::clone(&has_seen);
        // It subscribes from a first motion, until which the cell waits.
        let program = move |mp: &mut Mp| {
            let mut arm = mp.robot::<Irp6>("arm")?;
            raise(mp, &mut arm, 0.01)?;
            wait_for(&has_seen);
            raise(mp, &mut arm, 0.05)?;
            Err(Fault::thrown(AWRY))
        };
        let ended =
            cell(&folder).observed_by(Rc::clone(&seen) as Rc<dyn StepObserver>).program(program).run();
        drop(ended_or_failed);
        assert!(ended.is_err());
        subscriber.join().expect("it has seen the end")
    });
    let seen = seen.images.take();
    assert!(seen.len() > 100 && !images.is_empty(), "{} of {}", images.len(), seen.len());
    let mut from = seen.iter();
    for image in &images {
        // Messages that it was too slow for are missing; the others come in their order.
        let (step, time, words) = from.find(|(step, ..)| *step == image.step).expect("it was shown");
        assert_eq!((image.robot, image.step, image.time), (0, *step, *time));
        for (state, words) in [&image.demanded, &image.measured].into_iter().zip(words.chunks(STATE_WORDS)) {
            let shown = RobotState::<Irp6>::get(words).expect("a state");
            assert_eq!(state.joints, shown.joints.as_slice());
            assert_eq!((&state.velocity[..], state.X_WE), (shown.velocity.as_slice(), shown.pose));
        }
    }
    assert!(steps.windows(2).all(|two| two[0].time <= two[1].time && two[0].step <= two[1].step));
    assert!(steps.iter().all(|step| !step.suspended));
    let fault = steps.last().and_then(|last| last.fault.as_deref());
    assert!(fault.is_some_and(|text| text.contains(AWRY)), "{fault:?}");
}

/// All readings that have come.
fn readings(subscriber: &mut Subscriber) -> Vec<ReadingShown> {
    core::iter::from_fn(|| subscriber.reading()).collect()
}

#[test]
fn subscribers_see_the_readings_of_the_mp_and_of_an_ecp_to_the_bit() {
    let folder = Folder::new("subscriber-readings");
    let (has_begun, has_seen) = (AtomicBool::new(false), Arc::new(AtomicBool::new(false)));
    let has_ended = AtomicBool::new(false);
    let seen = Rc::new(Seen::default());
    let found = std::thread::scope(|scope| {
        let heard = scope.spawn(|| {
            let (_begun, _seen) = (Set(&has_begun), Set(&has_seen));
            let mut subscriber = subscriber(&folder);
            has_begun.store(true, Ordering::Release);
            let (mut found, mut is_over) = (Vec::new(), false);
            while !is_over {
                let is_last = has_ended.load(Ordering::Acquire);
                while let Some(step) = subscriber.step() {
                    is_over |= step.over;
                }
                assert!(is_over || !is_last, "the cell has ended, and shown no end");
                found.extend(readings(&mut subscriber));
                has_seen.fetch_or(!found.is_empty(), Ordering::AcqRel);
                std::thread::yield_now();
            }
            found.extend(readings(&mut subscriber));
            found
        });
        let ended_or_failed = Set(&has_ended);
        wait_for(&has_begun);
        let cell = gauged(&folder, &has_seen).observed_by(Rc::clone(&seen) as Rc<dyn StepObserver>);
        let ended = cell.run();
        drop(ended_or_failed);
        ended.expect("it ends in order");
        heard.join().expect("it has seen the end")
    });
    let seen = seen.readings.take();
    for (robot, by) in [(None, ProcessId::MP), (Some(0), ProcessId::new(Role::Ecp, name("arm")))] {
        let mut from = seen.iter().filter(|(who, ..)| *who == by);
        let of_it: Vec<_> = found.iter().filter(|reading| reading.robot == robot).collect();
        assert!(!of_it.is_empty() && of_it.len() <= 2 * OFTEN, "{} of {by}", of_it.len());
        for reading in of_it {
            // Messages that it was too slow for are missing; the others come in their order.
            let (_, times, words) = from.find(|(_, [step, ..], _)| *step == reading.step).expect("shown");
            assert_eq!(([reading.step, reading.taken, reading.time], &reading.words), (*times, words));
            assert_eq!(reading.sensor, name("gauge"));
            assert_eq!(reading.reading(), Some(Gap::of(reading.taken)));
            assert_eq!(reading.reading::<f64>(), None, "a reading of another type");
            assert!(reading.age() < 3, "{} steps old", reading.age());
        }
    }
    assert!((0..3).all(|age| found.iter().any(|reading| reading.age() == age)));
}

#[test]
fn fault_255_a_subscriber_that_stands_still_misses_the_oldest_readings_and_the_cell_does_not_wait() {
    let folder = Folder::new("subscriber-still");
    let (has_begun, has_seen) = (AtomicBool::new(false), Arc::new(AtomicBool::new(false)));
    let is_over = AtomicBool::new(false);
    let found = std::thread::scope(|scope| {
        let heard = scope.spawn(|| {
            let (_begun, _seen) = (Set(&has_begun), Set(&has_seen));
            let mut subscriber = subscriber(&folder);
            has_begun.store(true, Ordering::Release);
            while readings(&mut subscriber).is_empty() {
                assert!(!is_over.load(Ordering::Acquire), "the cell has ended, and shown no reading");
                std::thread::yield_now();
            }
            has_seen.store(true, Ordering::Release);
            wait_for(&is_over);
            readings(&mut subscriber)
        });
        let ended_or_failed = Set(&is_over);
        wait_for(&has_begun);
        let ended = gauged(&folder, &has_seen).run();
        drop(ended_or_failed);
        ended.expect("it ends in order");
        heard.join().expect("it has seen a reading")
    });
    for robot in [None, Some(0)] {
        let steps: Vec<_> =
            found.iter().filter(|reading| reading.robot == robot).map(|reading| reading.step).collect();
        assert_eq!(steps.len(), KEPT);
        assert!(steps.windows(2).all(|two| two[1] == two[0] + 1), "{steps:?}");
    }
}

#[test]
fn a_second_cell_at_the_same_port_runs_unseen_and_the_first_one_stays_shown() {
    let folder = Folder::new("subscriber-twice");
    let mut subscriber = subscriber(&folder);
    let shown = cell(&folder).begin_subscriptions(None, mrroc::link::Clock::Virtual);
    assert_eq!(shown.len(), 1);
    // Its thread has opened the port when it has shown something.
    let step = StepEvent::Step(StepRecord {
        step: 7,
        dt: 0.002,
        duration: 0.002,
        speed: 1.0,
        suspended: true,
        reduced: false,
        aborting: false,
        stopping: false,
        resetting: false,
    });
    shown[0].see(14_000_000, ProcessId::MP, &step, &[]);
    let first = loop {
        if let Some(first) = subscriber.step() {
            break first;
        }
        std::thread::yield_now();
    };
    assert_eq!((first.step, first.time, first.suspended, first.stopping), (7, 14_000_000, true, false));
    assert!(cell(&folder).program(lift).run().is_err());
    assert_eq!(subscriber.image(), None);
    shown[0].see(16_000_000, ProcessId::MP, &step, &[]);
    shown[0].finish();
    assert!(subscriber.step().is_some() && subscriber.step().is_none());
}

#[test]
fn a_cell_that_nobody_may_subscribe_runs_all_the_same() {
    let folder = Folder::new("subscriber-refused");
    std::fs::write(&folder.0, "a file where the folder should be").expect("a file");
    assert!(cell(&folder).program(lift).run().is_err());
    std::fs::remove_file(&folder.0).expect("it is there");
}
