//! Two arms and a virtual sensor as processes at 1 kHz, in real time, for a given time: `just soak 600`.
//!
//! The test asserts only what does not depend on the other load of the machine: the memory of the processes does not
//! grow, the rate of steps is the demanded one, and the cell ends without remains. Skipped steps are counted, and for
//! comparison the wake-ups that are late by more than a step in cyclictest at the same time. If the machine stands
//! still for too long, the cell stops; this test then acknowledges and resets as its operator, and counts the stop.

use std::collections::BTreeMap;
use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use mrroc_tests::fixture::{COUNT, SECONDS, SOAK};

use crate::launch::{Launch, Place};

/// How long a cell may take to start, before its memory is looked at.
const STARTING: Duration = Duration::from_secs(5);
/// How much the memory of a process may grow \[kB\]: pages that are touched once, by chance late.
const GROWTH: i64 = 256;
/// How far the measured rate may be from the demanded one.
const RATE: f64 = 1e-4;
/// The shortest run whose rate is looked at \[s\]: the least late of a thousand steps is known to some microseconds.
const RATED: u32 = 10;
/// How often a reset may be refused in a row, once in half a second: a robot may still move.
const MOST_REFUSALS: u32 = 20;
/// A step \[us\].
const STEP: u64 = 1000;

#[test]
fn a_cell_in_real_time_keeps_its_rate_and_its_memory() {
    let seconds: u32 = std::env::var("MRROC_SOAK").ok().and_then(|s| s.parse().ok()).unwrap_or(RATED);
    let place = Place::of(50, SOAK, include_str!("soak.toml"));
    let mut launch = place.start_with(&[(SECONDS, &seconds.to_string())], "records", &["--processes"]);
    let cyclictest = cyclictest(seconds);
    launch.let_run(STARTING);
    let first = memory(&mut launch);
    let mut last = first.clone();
    let (mut resets, mut refused) = (0, 0);
    let until = Instant::now() + Duration::from_secs(u64::from(seconds));
    while launch.end_if_over().is_none() {
        launch.let_run(Duration::from_millis(500));
        match reset_if_latched(&place) {
            Some(Ok(())) => (resets, refused) = (resets + 1, 0),
            Some(Err(why)) => {
                refused += 1;
                assert!(refused < MOST_REFUSALS, "no reset: {why}");
            }
            None => {}
        }
        let now = memory(&mut launch);
        // Processes that have ended have returned their memory.
        if now.len() == first.len() {
            last = now;
        }
        assert!(Instant::now() < until + Duration::from_secs(120), "it does not end: {}", launch.said());
    }
    let status = launch.end();
    println!("{}", launch.said());
    for (role, kilobytes) in &first {
        println!("{role:12} {kilobytes:6} kB after {STARTING:?}, {:6} kB at the end", last[role]);
        assert!(last[role] - kilobytes <= GROWTH, "{role} takes ever more memory");
    }
    match late_wake_ups(cyclictest) {
        Some((late, all)) => {
            println!("cyclictest: {late} of {all} wake-ups were late by more than {STEP} us")
        }
        None => println!("no cyclictest\n help: tests/benches/peers/realtime soak {seconds} installs it"),
    }
    launch.assert_nothing_left(&[]);
    match launch.record(COUNT).first().map(|line| read(line)) {
        Some((begun, skipped, slow)) => {
            println!("{begun} steps, {skipped} skipped; their rate is {:.6} % slow", 100.0 * slow);
            println!("resets, after the machine stood still for longer than a cell goes on: {resets}");
            assert!(status.success(), "{}", launch.said());
            assert!(seconds < RATED || slow.abs() < RATE, "the rate is {slow:e} slow");
        }
        None => panic!("no step: {}", launch.said()),
    }
}

/// Lets a cell go on that a late machine has stopped, or returns why it cannot; after any other stop it must not go on.
fn reset_if_latched(place: &Place) -> Option<Result<(), String>> {
    let ask = |word| {
        let output = place.program(&[word]).output().expect("a console starts");
        let said = [output.stdout, output.stderr].concat();
        (output.status.success(), String::from_utf8_lossy(&said).into_owned())
    };
    let (_, said) = ask("status");
    if !said.starts_with("latched: ") {
        return None;
    }
    let kinds = ["too many steps were missed", "the process at the other end is gone"];
    assert!(kinds.iter().any(|kind| said.contains(kind)), "{said}");
    ask("acknowledge");
    let (is_reset, why) = ask("reset");
    Some(if is_reset { Ok(()) } else { Err(format!("{said}{why}")) })
}

/// Begun, skipped, and by which part of its time the clock of the steps is slow.
fn read(line: &str) -> (u64, u64, f64) {
    let words: Vec<_> = line.split(' ').collect();
    let [begun, skipped, slow] = words[..] else { panic!("no count: {line}") };
    let number = |word: &str| word.parse().expect("a number");
    (number(begun), number(skipped), slow.parse().expect("a number"))
}

/// Memory in use by each process \[kB\].
fn memory(launch: &mut Launch) -> BTreeMap<String, i64> {
    let used = |pid| {
        let status = fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
        let of = |key: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(key))?;
            line.trim().strip_suffix("kB")?.trim().parse::<i64>().ok()
        };
        // Pages of files, mostly of code, are loaded and dropped by the system at any time.
        Some(of("RssAnon:")? + of("RssShmem:")?)
    };
    let launcher = used(launch.pid()).map(|used| ("launcher".to_owned(), used));
    let processes = launch.processes();
    let all = processes.into_iter().filter_map(|process| Some((process.role.clone(), used(process.pid)?)));
    all.chain(launcher).collect()
}

/// cyclictest for as long, at the priority of the cell, where there is one.
fn cyclictest(seconds: u32) -> Option<Child> {
    let loops = format!("--loops={}", seconds * 1000);
    let arguments =
        ["--quiet", "--priority=50", "--interval=1000", "--threads=1", "--histogram=100000", &loops];
    Command::new("cyclictest").args(arguments).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().ok()
}

/// Of its wake-ups, how many were late by more than a step.
fn late_wake_ups(cyclictest: Option<Child>) -> Option<(u64, u64)> {
    let output = cyclictest?.wait_with_output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout);
    let lines = text.lines().filter_map(|line| {
        let (micros, count) = line.split_once(' ')?;
        Some((micros.parse::<u64>().ok()?, count.trim().parse::<u64>().ok()?))
    });
    let (mut late, mut all) = (0, 0);
    for (micros, count) in lines {
        all += count;
        late += if micros > STEP { count } else { 0 };
    }
    (all > 0).then_some((late, all))
}
