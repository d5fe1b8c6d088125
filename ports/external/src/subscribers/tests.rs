//! Subscribers of whole cells, in this process.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use mrroc::cell::Cell;
use mrroc::fault::{Fault, ProcessId};
use mrroc::generator::RobotHandle;
use mrroc::observe::step_observer::{STATE_WORDS, StepEvent, StepObserver, StepRecord};
use mrroc::payload::Wire;
use mrroc::prelude::*;
use mrroc::robot::RobotState;
use mrroc_generators::generators::JointMove;
use mrroc_launch::cell_file::CellFile;
use mrroc_robots::{Irp6, Six, simulated};

use super::{Image, StepShown, Subscriber, Subscribers};
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

/// Keeps the words of all images that are shown in this process.
#[derive(Default)]
struct Seen(RefCell<Vec<(u64, u64, Vec<u64>)>>);

impl StepObserver for Seen {
    fn see(&self, time: u64, _: ProcessId, what: &StepEvent, words: &[u64]) {
        if let StepEvent::Image { step, .. } = what {
            self.0.borrow_mut().push((*step, time, words.to_vec()));
        }
    }
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

const AWRY: &str = "the work is not where it should be";

/// What a program sees that subscribes until the cell is over, and says when it has seen something.
fn subscribe(folder: &Folder, has_begun: &AtomicBool, has_seen: &AtomicBool) -> (Vec<Image>, Vec<StepShown>) {
    let mut subscriber = subscriber(folder);
    has_begun.store(true, Ordering::Release);
    let (mut images, mut steps) = (Vec::new(), Vec::new());
    while steps.last().is_none_or(|step: &StepShown| !step.over) {
        images.extend(core::iter::from_fn(|| subscriber.image()));
        steps.extend(core::iter::from_fn(|| subscriber.step()));
        if !images.is_empty() && !steps.is_empty() {
            has_seen.store(true, Ordering::Release);
        }
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
    let seen = Rc::new(Seen::default());
    let (images, steps) = std::thread::scope(|scope| {
        let subscriber = scope.spawn(|| subscribe(&folder, &has_begun, &has_seen));
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
        assert!(ended.is_err());
        subscriber.join().expect("it has seen the end")
    });
    let seen = seen.0.take();
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
