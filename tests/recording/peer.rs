//! Reads a recording by the MCAP library of another language: PyPI's, whose installation needs a network once.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::rc::Rc;

use mrroc::observe::Observation;

use crate::recording::cell::{Change, STEP, arms};

#[test]
#[ignore = "installs PyPI's mcap: just test-recording-peer"]
fn another_librarys_values_are_those_that_the_drives_got_and_measured() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let (file, values) = (folder.join("peer.mcap"), folder.join("peer.csv"));
    let seen = Rc::new(RefCell::new(String::new()));
    let to = Rc::clone(&seen);
    let mut before = BTreeMap::new();
    let ran = arms(Change::Nothing)
        .watch(move |now: &Observation<'_>| {
            // A servo period of a step's length begins in the middle of its step, and its end is told.
            let step = (now.time / STEP.as_secs_f64() - 1.5).round();
            let measured = before.insert(now.robot.to_owned(), now.measured.to_vec());
            for (joint, (demanded, measured)) in
                now.demanded.iter().zip(measured.iter().flatten()).enumerate()
            {
                writeln!(to.borrow_mut(), "{step},{},{joint},{demanded:?},{measured:?}", now.robot)
                    .expect("a text");
            }
        })
        .record(mrroc::recording::to(&file))
        .run()
        .expect("keeps the limits");
    fs::write(&values, &*seen.borrow()).expect("a file");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/peers/recording");
    let read = Command::new(script).args([&file, &values]).output().expect("bash is there");
    let said = [read.stdout, read.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    println!("{said}");
    assert!(read.status.success(), "{said}");
    // Six joints of two robots in nearly every step of the run.
    let steps = seen.borrow().lines().count() as u64 / 12;
    assert!(steps > ran.steps * 9 / 10, "{steps} of {}", ran.steps);
}
