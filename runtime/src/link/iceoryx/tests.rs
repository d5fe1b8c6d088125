//! Two ends of the link in one process.

use std::path::PathBuf;

use super::{Clock, Fabric, Seal};
use crate::fault::ProcessId;
use crate::link::Link;
use crate::message::{Kind, Message};

const SEAL: Seal = Seal { session: 17, epoch: 1 };

/// Files of this test alone: the folder of its nodes, and its segments of shared memory.
struct Files(PathBuf, String);

impl Files {
    fn new() -> Files {
        let number = std::process::id();
        let folder = std::env::temp_dir().join(format!("mrt{number}"));
        std::fs::create_dir_all(&folder).expect("a folder");
        Files(folder, format!("mrt{number}_"))
    }
}

impl Drop for Files {
    fn drop(&mut self) {
        for entry in std::fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
            if entry.file_name().to_str().is_some_and(|name| name.starts_with(&self.1)) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn fault_17_a_reader_that_does_not_read_blocks_no_writer_and_sees_the_newest_afterwards() {
    let files = Files::new();
    let ids = [ProcessId::MP, ProcessId::PLANT];
    let mut ends = ids.map(|me| {
        let mut fabric = Fabric::new(me, Clock::Virtual);
        for id in ids {
            fabric.place(id);
        }
        let (board, port) = (fabric.board(0, 1), fabric.port(0, 1));
        fabric.create(&files.0, &files.1, SEAL).expect("made");
        (fabric, board, port)
    });
    ends.iter_mut().for_each(|(fabric, ..)| fabric.connect(SEAL).expect("connected"));
    let [(_, writes, (client, _)), (_, reads, (_, server))] = &ends;
    let numbered = |step| {
        let mut message = Message::empty();
        (message.header.kind, message.header.step) = (Kind::Reply, step);
        message
    };
    let mut seen = Message::empty();
    assert!(!reads.read(&mut seen) && !server.receive(&mut seen));
    // Far more than any queue has places: each returns, though nobody reads.
    for step in 1..=100_000 {
        writes.write(&numbered(step));
        client.send(&numbered(step));
    }
    assert!(reads.read(&mut seen) && seen.header.step == 100_000, "{}", seen.header.step);
    assert!(server.receive(&mut seen) && seen.header.step == 100_000, "{}", seen.header.step);
    // A request is taken once.
    assert!(!server.receive(&mut seen));
}
