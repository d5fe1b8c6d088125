//! A recording in the eyes of another language's MCAP library: PyPI's, which needs a network to be installed once.

use std::cell::RefCell;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::rc::Rc;

use mrroc::{Operator, Recording};

use crate::cell::{Change, arms, operate};

#[test]
#[ignore = "installs PyPI's mcap: just test-recording-peer"]
fn another_librarys_values_are_those_that_a_guard_saw() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let (file, values) = (folder.join("peer.mcap"), folder.join("peer.csv"));
    let (seen, step) = (Rc::new(RefCell::new(String::new())), Rc::new(std::cell::Cell::new(0)));
    let (to, now, begins) = (Rc::clone(&seen), Rc::clone(&step), Rc::clone(&step));
    let ran = arms(Change::Nothing)
        .on_step(move |step, operator: &Operator| {
            begins.set(step);
            operate(step, operator);
        })
        .guard(1, move |views| {
            let mut text = to.borrow_mut();
            for view in views {
                for joint in 0..6 {
                    let (demanded, measured) = (view.demanded.joints[joint], view.measured.joints[joint]);
                    writeln!(text, "{},{},{joint},{demanded:?},{measured:?}", now.get(), view.name)
                        .expect("a text");
                }
            }
            Ok(())
        })
        .record(Recording::to(&file))
        .run()
        .expect("keeps the limits");
    fs::write(&values, &*seen.borrow()).expect("a file");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../benches/peers/recording");
    let read = Command::new(script).args([&file, &values]).output().expect("bash is there");
    let said = [read.stdout, read.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    println!("{said}");
    assert!(read.status.success(), "{said}");
    // The guard saw both robots in nearly every step of the run.
    let steps = seen.borrow().lines().count() as u64 / 12;
    assert!(steps > ran.steps * 9 / 10, "{steps} of {}", ran.steps);
}
