//! A file that takes nothing, or not so fast, changes nothing in a run.

use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use mrroc::cell::RunReport;
use mrroc::recording::{CutOff, Replay};

use crate::recording::cell::{Change, arms};

fn bare() -> RunReport {
    arms(Change::Nothing).run().expect("keeps the limits")
}

fn recorded_to(file: &Path) -> RunReport {
    arms(Change::Nothing)
        .record(mrroc::recording::to(file))
        .run()
        .expect("a run does not depend on its recording")
}

#[test]
fn fault_34_a_full_disk_changes_nothing_in_a_run() {
    assert_eq!(recorded_to(Path::new("/dev/full")), bare());
}

fn pipe(name: &str) -> PathBuf {
    let pipe = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_file(&pipe);
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("mkfifo is there").success());
    pipe
}

#[test]
fn fault_34_a_pipe_that_nobody_reads_changes_nothing_in_a_run() {
    assert_eq!(recorded_to(&pipe("nobody.fifo")), bare());
}

#[test]
fn a_pipe_that_is_read_slowly_gets_everything_under_the_virtual_clock() {
    let (pipe, copy) = (pipe("slow.fifo"), Path::new(env!("CARGO_TARGET_TMPDIR")).join("slow.mcap"));
    let (from, to) = (pipe.clone(), copy.clone());
    let reader = std::thread::spawn(move || {
        let (mut from, mut to) =
            (fs::File::open(from).expect("a pipe"), fs::File::create(to).expect("a file"));
        let mut piece = vec![0; 16 * 1024];
        loop {
            let read = from.read(&mut piece).expect("readable");
            if read == 0 {
                break;
            }
            to.write_all(&piece[..read]).expect("written");
            std::thread::sleep(Duration::from_micros(500));
        }
    });
    recorded_to(&pipe);
    reader.join().expect("read to the end");
    let compared = arms(Change::Nothing).replay(copy, CutOff::Refused).expect("whole");
    assert!(compared.is_identical(), "{compared:?}");
}
