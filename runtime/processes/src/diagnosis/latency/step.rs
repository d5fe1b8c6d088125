//! How long a whole step takes, from the MP to 1 to 4 ECPs, to their EDPs, and back, compared with the same processes
//! on bare shared memory and futexes: `just bench-step`.
//!
//! Both kinds take turns in one run, at the same priority and on the same cores, at a step of 1 ms. The time counts from
//! the MP's wake-up to its last reply. Raw samples go to `target/latency/steps.csv`.

use std::fmt::Write as _;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::process::Command;

use iceoryx2::prelude::{LogLevel, set_log_level};
use rustix::fs::{MemfdFlags, ftruncate, memfd_create};
use rustix::thread::{ClockId, CpuSet, clock_nanosleep_absolute, sched_getaffinity, sched_setaffinity};
use rustix::time::Timespec;

use super::topology::{MEMORY, ROBOTS, Topology, bare, id, ours};
use super::{barrier, folder, path, remove_segments, samples_folder, start, words};
use crate::control::{Control, Frame};
use crate::link::monotonic;
use crate::machine::scheduling::set_priority;
use mrroc_core::cell::{Permission, Realtime};
use mrroc_core::fault::Role;

const WARM_UP: usize = 200;
const STEPS: usize = 2000;
const ROUNDS: usize = 3;
/// The step \[ns\].
const PERIOD: u64 = 1_000_000;
const PRIORITY: u8 = 50;
const KINDS: [&str; 2] = ["mrroc", "futex"];
/// What each ECP and each EDP computes in a step \[us\].
const WORK: [u64; 2] = [0, 10];

/// Where the processes run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Placement {
    /// As the launcher places them.
    Launcher,
    /// The processes of a robot share a core, the robots alternate between the cores, the MP runs on any core.
    RobotsByTurns,
    /// The same, with the MP on the core of the first robot.
    MpWithFirst,
    /// All on one core.
    OneCore,
    /// Where the system puts them.
    Anywhere,
}

impl Placement {
    const ALL: [Placement; 4] =
        [Placement::MpWithFirst, Placement::RobotsByTurns, Placement::OneCore, Placement::Anywhere];

    /// The core of the process at a place.
    fn core(self, place: usize, robots: usize) -> Option<usize> {
        let set = sched_getaffinity(None).expect("known");
        let usable: Vec<_> = (0..CpuSet::MAX_CPU).filter(|&core| set.is_set(core)).collect();
        let turn = |place: usize| usable[(place - 1) % robots % usable.len()];
        match self {
            Placement::Launcher => {
                let ecps: Vec<_> = (1..=robots).map(|place| id(place, robots)).collect();
                let realtime = Realtime {
                    permission: Permission::BestEffort,
                    priority: PRIORITY,
                    lock_memory: false,
                    cores: None,
                };
                realtime.core(id(place, robots), &ecps, &usable)
            }
            Placement::RobotsByTurns => (place > 0).then(|| turn(place)),
            Placement::MpWithFirst => Some(turn(place.max(1))),
            Placement::OneCore => Some(usable[0]),
            Placement::Anywhere => None,
        }
    }
}

/// Real time on a core.
fn be_real_time(core: Option<usize>) {
    assert!(set_priority(PRIORITY), "the measurement needs SCHED_FIFO\n help: run it as root");
    if let Some(core) = core {
        let mut set = CpuSet::new();
        set.set(core);
        sched_setaffinity(None, &set).expect("permitted");
    }
}

fn compute(micros: u64) {
    let until = monotonic() + 1000 * micros;
    while micros > 0 && monotonic() < until {
        core::hint::spin_loop();
    }
}

fn await_on(topology: &mut dyn Topology, line: usize) {
    while !topology.take(line) {
        topology.wait();
    }
}

/// What an ECP or an EDP does in a step.
fn take_part(topology: &mut dyn Topology, role: Role, work: u64) {
    await_on(topology, 0);
    compute(work);
    if role == Role::Ecp {
        topology.send(1);
        await_on(topology, 1);
    }
    topology.send(0);
}

/// What the MP does in a step.
fn coordinate(topology: &mut dyn Topology, robots: usize) {
    (0..robots).for_each(|line| topology.send(line));
    let mut pending = (1_u32 << robots) - 1;
    loop {
        for line in 0..robots {
            if pending & 1 << line != 0 && topology.take(line) {
                pending &= !(1 << line);
            }
        }
        if pending == 0 {
            return;
        }
        topology.wait();
    }
}

/// What a process of the measurement is and does.
#[derive(Clone, Copy, Debug)]
struct Part {
    kind: &'static str,
    place: usize,
    robots: usize,
    work: u64,
    core: Option<usize>,
}

impl Part {
    /// The arguments that the process `of` gives this part's process.
    fn words(self, of: u32) -> String {
        let core = self.core.map_or_else(|| "any".to_owned(), |core| core.to_string());
        format!("{} {of} {} {} {} {core}", self.kind, self.place, self.robots, self.work)
    }

    fn read(words: &str) -> (Part, u32) {
        let words: Vec<_> = words.split(' ').collect();
        let [kind, of, place, robots, work, core] = words[..] else { panic!("no part: {words:?}") };
        let number = |word: &str| word.parse::<usize>().expect("a number");
        let part = Part {
            kind: KINDS.into_iter().find(|known| *known == kind).expect("a kind"),
            place: number(place),
            robots: number(robots),
            work: number(work) as u64,
            core: core.parse().ok(),
        };
        (part, number(of) as u32)
    }

    /// Its lines to the others; `meet` returns when all processes have come to the same point.
    fn connect(self, of: u32, shared: &OwnedFd, meet: &dyn Fn()) -> Box<dyn Topology> {
        match self.kind {
            "mrroc" => ours(self.place, self.robots, of, meet),
            _ => {
                meet();
                meet();
                bare(self.place, self.robots, shared)
            }
        }
    }
}

#[test]
#[ignore = "an ECP or an EDP of the measurement"]
fn part() {
    let Some(words) = words(&path(module_path!(), "part")) else { return };
    let (part, of) = Part::read(&words);
    let stdin = std::io::stdin().as_fd().try_clone_to_owned().expect("a descriptor");
    let shared = std::io::stdout().as_fd().try_clone_to_owned().expect("a descriptor");
    let control = Control::new(UnixStream::from(stdin));
    let mut topology = part.connect(of, &shared, &|| barrier(&control));
    be_real_time(part.core);
    barrier(&control);
    let role = id(part.place, part.robots).role;
    for _ in 0..WARM_UP + STEPS {
        take_part(&mut *topology, role, part.work);
    }
    // The process does not return to the test harness, whose output would go to the shared memory.
    std::process::exit(0);
}

/// The times of the steps of one round \[ns\].
fn round(kind: &'static str, robots: usize, work: u64, placement: Placement) -> Vec<u64> {
    let of = std::process::id();
    let shared = memfd_create("steps", MemfdFlags::empty()).expect("memory");
    ftruncate(&shared, MEMORY).expect("memory");
    let part = |place| Part { kind, place, robots, work, core: placement.core(place, robots) };
    let (children, controls): (Vec<_>, Vec<_>) = (1..=2 * robots)
        .map(|place| {
            let (ours, theirs) = UnixStream::pair().expect("sockets");
            let words = part(place).words(of);
            (start(&path(module_path!(), "part"), &words, theirs, &shared), Control::new(ours))
        })
        .unzip();
    let meet = || {
        controls.iter().for_each(|control| assert_eq!(control.receive().expect("came"), Frame::Connect));
        controls.iter().for_each(|control| control.send(&Frame::Connect).expect("sent"));
    };
    let mut samples = std::thread::scope(|scope| {
        // A thread of its own, so that its priority and core end with it.
        let mp = scope.spawn(|| {
            let mut topology = part(0).connect(of, &shared, &meet);
            meet();
            be_real_time(part(0).core);
            steps(&mut *topology, robots)
        });
        mp.join().expect("it ends")
    });
    for mut child in children {
        assert!(child.wait().expect("a child").success());
    }
    remove_segments();
    samples.drain(..WARM_UP);
    samples
}

/// Steps every millisecond, and how long each takes \[ns\].
fn steps(topology: &mut dyn Topology, robots: usize) -> Vec<u64> {
    let mut samples = Vec::with_capacity(WARM_UP + STEPS);
    let mut due = monotonic() + 20 * PERIOD;
    for _ in 0..WARM_UP + STEPS {
        let (tv_sec, tv_nsec) = (due / 1_000_000_000, due % 1_000_000_000);
        let until = Timespec { tv_sec: tv_sec.cast_signed(), tv_nsec: tv_nsec.cast_signed() };
        let _ = clock_nanosleep_absolute(ClockId::Monotonic, &until);
        let began = monotonic();
        coordinate(topology, robots);
        let ended = monotonic();
        samples.push(ended - began);
        // Missed periods are skipped.
        due += PERIOD * (1 + ended.saturating_sub(due) / PERIOD);
    }
    samples
}

/// The median, the 99th percentile and the maximum of the samples \[us\].
fn summary(samples: &[u64]) -> [f64; 3] {
    let mut sorted = samples.to_vec();
    sorted.sort_unstable();
    [0.5, 0.99, 1.0].map(|share| sorted[(share * (sorted.len() - 1) as f64) as usize] as f64 * 1e-3)
}

/// The same figures of cyclictest's wake-ups at present; `None` where the program is not installed.
fn cyclictest() -> Option<[f64; 3]> {
    let arguments = ["--quiet", "--priority=50", "--interval=1000", "--loops=2000", "--histogram=20000"];
    let output = Command::new("cyclictest").args(arguments).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout);
    let lines = text.lines().filter_map(|line| {
        let (micros, count) = line.split_once(' ')?;
        Some((micros.parse::<u64>().ok()?, count.trim().parse::<usize>().ok()?))
    });
    let late: Vec<_> = lines.flat_map(|(micros, count)| vec![1000 * micros; count]).collect();
    (!late.is_empty()).then(|| summary(&late))
}

#[test]
#[ignore = "measures: `just bench-step`"]
fn whole_steps_beside_bare_futexes() {
    set_log_level(LogLevel::Fatal);
    let root = folder(std::process::id());
    std::fs::create_dir_all(&root).expect("a folder");
    let placements = match std::env::var("MRROC_PLACEMENTS").as_deref() {
        Ok("all") => &Placement::ALL[..],
        _ => &[Placement::Launcher],
    };
    let mut raw = String::from("placement,robots,work_us,kind,round,step_ns\n");
    for &placement in placements {
        println!("{placement:?}: p50 / p99 / max us of {ROUNDS} x {STEPS} steps");
        for (robots, work) in (1..=ROBOTS).flat_map(|robots| WORK.map(|work| (robots, work))) {
            let mut all = KINDS.map(|_| Vec::new());
            for turn in 0..ROUNDS {
                for (kind, all) in KINDS.into_iter().zip(&mut all) {
                    let samples = round(kind, robots, work, placement);
                    for sample in &samples {
                        // Writing to a text does not fail.
                        let _ = writeln!(raw, "{placement:?},{robots},{work},{kind},{turn},{sample}");
                    }
                    all.extend(samples);
                }
            }
            let [ours, bare] = all.map(|samples| summary(&samples));
            let ratio = ours[0] / bare[0];
            print!("{robots} robots, {work:2} us each: ours {}, bare {}", shown(ours), shown(bare));
            println!(", {ratio:.2} at p50");
        }
        match cyclictest() {
            Some(late) => println!("cyclictest in the same minute: {}", shown(late)),
            None => println!("no cyclictest\n help: tests/benches/peers/realtime step installs it"),
        }
    }
    let file = samples_folder().join("steps.csv");
    std::fs::write(&file, raw).expect("written");
    println!("raw samples: {}", file.display());
    let _ = std::fs::remove_dir_all(root);
}

fn shown([half, most, all]: [f64; 3]) -> String {
    format!("{half:6.1} / {most:6.1} / {all:7.1}")
}
