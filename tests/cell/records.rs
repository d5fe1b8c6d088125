//! Records of what robots were demanded, each written by the process that demands it.
//!
//! In: servo periods. Out: a file per robot, which tests compare: the bits of a demand are what must be the same.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::path::PathBuf;

use mrroc::observe::Observation;

/// Writes every servo period of every robot to a file of its own: the time, then the bits of each demanded joint.
pub fn record(folder: PathBuf) -> impl FnMut(&Observation<'_>) {
    let files = RefCell::new(BTreeMap::new());
    move |seen| {
        let mut files = files.borrow_mut();
        let file = files.entry(seen.robot.to_owned()).or_insert_with(|| {
            File::create(folder.join(seen.robot)).expect("the folder of the records can be written")
        });
        let bits: String = seen.demanded.iter().map(|q| format!(" {:016x}", q.to_bits())).collect();
        // One write a line: what is there when the process is killed is whole.
        file.write_all(format!("{:.6}{bits}\n", seen.time).as_bytes()).expect("written");
    }
}
