//! Two machines in one process: the MP on one, an ECP on the other, and a network of this test between their stand-ins.

use std::path::PathBuf;
use std::rc::Rc;

use super::*;
use mrroc_core::fault::Name;
use mrroc_core::link::message::{Kind, Message};
use mrroc_core::link::{Board, Client, Clock, Link, Server};

const BETWEEN: Seal = Seal { session: 99, epoch: 3 };

/// Files of one machine of a test.
struct Files(PathBuf, String);

impl Files {
    fn new(test: &str) -> Files {
        let number = format!("{}{test}", std::process::id());
        let folder = std::env::temp_dir().join(format!("mrs{number}"));
        std::fs::create_dir_all(&folder).expect("a folder");
        Files(folder, format!("mrs{number}_"))
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

/// A machine: the end of a port from the MP to the ECP and of a board back, and what is carried.
struct Machine {
    _fabric: Fabric,
    port: (Box<dyn Client>, Box<dyn Server>),
    board: Rc<dyn Board>,
    incoming: Incoming,
    outgoing: Vec<Outgoing>,
    _files: Files,
}

fn machine(test: &str, me: usize) -> Machine {
    let files = Files::new(&format!("{test}{me}"));
    let ecp = ProcessId::new(Role::Ecp, Name::new("arm").expect("a name"));
    let ids = [ProcessId::MP, ecp];
    let here = Seal { session: 10 + me as u64, epoch: 3 };
    let mut fabric = Fabric::new(ids[me], Clock::Real);
    for id in ids {
        fabric.place(id);
    }
    let (port, board) = (fabric.port(0, 1), fabric.board(1, 0));
    let places = Where { me, places: vec![Some(0), Some(1)] };
    let seals = Seals { here, between: BETWEEN };
    let stand_in = StandIn::make(&fabric, (&files.0, &files.1), seals, &places).expect("made");
    fabric.create(&files.0, &files.1, here).expect("made");
    fabric.connect(here).expect("connected");
    let (incoming, outgoing) = stand_in.open().expect("opened");
    Machine { _fabric: fabric, port, board, incoming, outgoing, _files: files }
}

fn numbered(step: u64) -> Message {
    let mut message = Message::empty();
    (message.header.kind, message.header.step) = (Kind::Reply, step);
    message
}

/// All that a machine has to send.
fn sent(machine: &mut Machine) -> Vec<(u16, Envelope)> {
    std::iter::from_fn(|| machine.outgoing[0].next()).collect()
}

#[test]
fn an_order_and_its_answer_cross_as_if_both_were_on_one_machine() {
    let (mut left, mut right) = (machine("cross", 0), machine("cross", 1));
    let mut seen = Message::empty();
    for step in 1..4 {
        left.port.0.send(&numbered(step));
        let orders = sent(&mut left);
        assert_eq!(orders.len(), 1);
        assert!(right.incoming.came(0, orders[0].0, &orders[0].1));
        assert!(right.port.1.receive(&mut seen) && seen.header.step == step);
        right.port.1.reply(&numbered(10 * step));
        right.board.write(&numbered(100 * step));
        let answers = sent(&mut right);
        assert_eq!(answers.len(), 2, "the answer, and the board");
        for (slot, envelope) in &answers {
            assert!(left.incoming.came(1, *slot, envelope));
        }
        assert!(left.port.0.receive(&mut seen) && seen.header.step == 10 * step);
        assert!(left.board.read(&mut seen) && seen.header.step == 100 * step);
        // Nothing is sent twice that was written once.
        assert!(sent(&mut left).is_empty() && sent(&mut right).is_empty());
    }
}

#[test]
fn what_was_lost_between_machines_is_asked_for_and_answered_again() {
    let (mut left, mut right) = (machine("lost", 0), machine("lost", 1));
    let mut seen = Message::empty();
    left.port.0.send(&numbered(1));
    drop(sent(&mut left));
    left.port.0.send_again();
    let again = sent(&mut left);
    assert!(right.incoming.came(0, again[0].0, &again[0].1));
    assert!(right.port.1.receive(&mut seen));
    right.port.1.reply(&numbered(10));
    drop(sent(&mut right));
    // The answer is lost, too: it is given again, with the same number.
    left.port.0.send_again();
    let again = sent(&mut left);
    assert!(right.incoming.came(0, again[0].0, &again[0].1));
    assert!(!right.port.1.receive(&mut seen));
    let answer = sent(&mut right);
    assert!(left.incoming.came(1, answer[0].0, &answer[0].1));
    assert!(left.port.0.receive(&mut seen) && seen.header.step == 10);
}

#[test]
fn fault_143_what_a_node_says_for_a_process_of_another_node_is_not_taken() {
    let (mut left, right) = (machine("143", 0), machine("143", 1));
    left.port.0.send(&numbered(1));
    let orders = sent(&mut left);
    let (slot, order) = &orders[0];
    // Its own words, said by another node; and a slot that only goes out.
    assert!(!right.incoming.came(1, *slot, order) && !right.incoming.came(2, *slot, order));
    assert!(!left.incoming.came(1, *slot, order));
    assert!(!right.port.1.receive(&mut Message::empty()));
    assert!(right.incoming.came(0, *slot, order));
}

#[test]
fn fault_145_what_is_of_another_run_or_older_than_what_stands_there_is_not_taken() {
    let (mut left, right) = (machine("145", 0), machine("145", 1));
    let mut orders = Vec::new();
    for step in 1..3 {
        left.port.0.send(&numbered(step));
        orders.extend(sent(&mut left));
    }
    let [(slot, first), (_, second)] = orders.as_slice() else { panic!("two orders") };
    for seal in [Seal { session: 98, ..BETWEEN }, Seal { epoch: 2, ..BETWEEN }] {
        let other = second.moved(BETWEEN, seal).expect("whole");
        assert!(!right.incoming.came(0, *slot, &other));
    }
    assert!(!right.incoming.came(0, *slot, &second.damaged(12, 1)));
    assert!(right.incoming.came(0, *slot, second));
    assert!(!right.incoming.came(0, *slot, first), "it was overtaken");
    let mut seen = Message::empty();
    assert!(right.port.1.receive(&mut seen) && seen.header.step == 2);
}
