//! Two ends of the link in one process.

use std::path::PathBuf;
use std::rc::Rc;

use super::{Clock, Fabric, Seal};
use mrroc_core::fault::ProcessId;
use mrroc_core::link::message::{Kind, Message};
use mrroc_core::link::{Board, Client, Link, Server};

const SEAL: Seal = Seal { session: 17, epoch: 1 };

/// Files of this test alone: the folder of its nodes, and its segments of shared memory.
struct Files(PathBuf, String);

impl Files {
    fn new(test: &str) -> Files {
        let number = format!("{}{test}", std::process::id());
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

/// The ends of a board and of a port, from the MP's to the plant's.
type Ends = (Fabric, Rc<dyn Board>, (Box<dyn Client>, Box<dyn Server>));

fn connected(files: &Files) -> [Ends; 2] {
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
    ends
}

fn numbered(step: u64) -> Message {
    let mut message = Message::empty();
    (message.header.kind, message.header.step) = (Kind::Reply, step);
    message
}

#[test]
fn what_is_sent_again_is_taken_once_and_answered_once() {
    let files = Files::new("again");
    let ends = connected(&files);
    let [(_, _, (client, _)), (_, _, (_, server))] = &ends;
    let mut seen = Message::empty();
    for step in 1..4 {
        client.send(&numbered(step));
        client.send_again();
        assert!(server.receive(&mut seen) && seen.header.step == step);
        client.send_again();
        assert!(!server.receive(&mut seen) && !client.receive(&mut seen));
        server.reply(&numbered(10 * step));
        client.send_again();
        assert!(!server.receive(&mut seen));
        assert!(client.receive(&mut seen) && seen.header.step == 10 * step);
        client.send_again();
        assert!(!server.receive(&mut seen) && !client.receive(&mut seen));
    }
}

#[test]
fn fault_17_a_reader_that_does_not_read_blocks_no_writer_and_sees_the_newest_afterwards() {
    let files = Files::new("17");
    let ends = connected(&files);
    let [(_, writes, (client, _)), (_, reads, (_, server))] = &ends;
    let mut seen = Message::empty();
    assert!(!reads.read(&mut seen) && !server.receive(&mut seen));
    // Far more messages than any queue holds: each call returns, although nobody reads.
    for step in 1..=100_000 {
        writes.write(&numbered(step));
        client.send(&numbered(step));
    }
    assert!(reads.read(&mut seen) && seen.header.step == 100_000, "{}", seen.header.step);
    assert!(server.receive(&mut seen) && seen.header.step == 100_000, "{}", seen.header.step);
    // A request is taken once.
    assert!(!server.receive(&mut seen));
}
