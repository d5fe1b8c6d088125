use std::panic::{AssertUnwindSafe, catch_unwind};

use super::*;
use crate::model::name::Name;

type Log = Rc<RefCell<Vec<&'static str>>>;

fn process(name: &str) -> ProcessId {
    ProcessId::new(Role::Ecp, Name::new(name).expect("a name"))
}

/// Asks, and waits for the reply; whether it came.
fn ask(client: &dyn Client, host: &Host<'_>) -> bool {
    client.send(&Message::empty());
    let mut reply = Message::empty();
    while !client.receive(&mut reply) {
        if host.waiter.wait_for_reply(client, None).is_err() {
            return false;
        }
    }
    true
}

/// Waits for a request; whether it came.
fn is_asked(server: &dyn Server, host: &Host<'_>) -> bool {
    let mut request = Message::empty();
    while !server.receive(&mut request) {
        if host.waiter.wait(None).is_err() {
            return false;
        }
    }
    true
}

/// Runs a master that asks two controllers at once and waits for the second one first. Each controller asks a driver of its
/// own, which does `drive`. Who ran, one after another, in a cell whose processes were made in this order.
fn run(names: [&'static str; 5], drive: fn()) -> (Log, std::thread::Result<Result<Nanos, Stuck>>) {
    let log = Log::default();
    let mut scheduler = Scheduler::new();
    let places = names.map(|name| (name, scheduler.place(process(name))));
    let place = |wanted: &str| places.iter().find(|(name, _)| *name == wanted).expect("made").1;
    let mut clients = Vec::new();
    for (controller, driver) in [("c1", "d1"), ("c2", "d2")] {
        let (client, asked) = scheduler.port(place("m"), place(controller));
        clients.push(client);
        let (drives, server) = scheduler.port(place(controller), place(driver));
        let shown = Rc::clone(&log);
        let control = move |host: Host<'_>| {
            if is_asked(&*asked, &host) {
                shown.borrow_mut().push(controller);
                let outcome = if ask(&*drives, &host) { controller } else { "closed" };
                shown.borrow_mut().push(outcome);
                asked.reply(&Message::empty());
            }
        };
        scheduler.body(place(controller), Box::new(control)).expect("a stack");
        let shown = Rc::clone(&log);
        let serve = move |host: Host<'_>| {
            if is_asked(&*server, &host) {
                shown.borrow_mut().push(driver);
                drive();
                server.reply(&Message::empty());
            }
        };
        scheduler.body(place(driver), Box::new(serve)).expect("a stack");
    }
    let (shown, close) = (Rc::clone(&log), scheduler.closer());
    let master = move |host: Host<'_>| {
        clients[0].send(&Message::empty());
        if ask(&*clients[1], &host) {
            shown.borrow_mut().push("m");
        }
        close();
    };
    scheduler.body(place("m"), Box::new(master)).expect("a stack");
    let outcome = catch_unwind(AssertUnwindSafe(|| scheduler.run()));
    (log, outcome)
}

#[test]
fn of_the_processes_that_can_run_the_one_of_the_lowest_place_does_whoever_waits_for_a_reply() {
    let (log, outcome) = run(["m", "c1", "d1", "c2", "d2"], || {});
    assert!(matches!(outcome, Ok(Ok(0))), "{outcome:?}");
    assert_eq!(*log.borrow(), ["c1", "d1", "c1", "c2", "d2", "c2", "m"]);
    // The second controller runs while the first one waits, and goes on after it.
    let (log, outcome) = run(["m", "c1", "c2", "d1", "d2"], || {});
    assert!(matches!(outcome, Ok(Ok(0))), "{outcome:?}");
    assert_eq!(*log.borrow(), ["c1", "c2", "d1", "c1", "d2", "c2", "m"]);
    let (log, _) = run(["d2", "d1", "c2", "c1", "m"], || {});
    assert_eq!(*log.borrow(), ["c2", "d2", "c2", "c1", "d1", "c1", "m"]);
}

#[test]
fn a_panic_that_a_process_does_not_catch_is_not_that_of_the_process_that_waits_for_it() {
    let (log, outcome) = run(["m", "c1", "d1", "c2", "d2"], || panic!("a bug of a driver"));
    let panic = outcome.expect_err("the panic ends the run");
    assert_eq!(panic.downcast_ref::<&str>(), Some(&"a bug of a driver"));
    // The controller is told that the cell closes.
    assert!(log.borrow().starts_with(&["c1", "d1", "closed"]), "{log:?}");
}

/// How a run ended, or panicked.
type Outcome = std::thread::Result<Result<Nanos, Stuck>>;

/// A server that serves, and a master that asks it twice at time 0 and then waits until 12: what the server did, with the
/// time, and the outcome. The server wants to wake every 5.
fn run_served(turns_until_panic: usize) -> (Vec<(Nanos, bool)>, Outcome) {
    let log = Rc::new(RefCell::new(Vec::new()));
    let mut scheduler = Scheduler::new();
    let (m, s) = (scheduler.place(process("m")), scheduler.place(process("s")));
    let (client, server) = scheduler.port(m, s);
    let shown = Rc::clone(&log);
    let serve = move |host: Host<'_>| {
        let mut request = Message::empty();
        host.waiter.serve(5, &mut || {
            assert!(shown.borrow().len() < turns_until_panic, "a bug of a driver");
            let now = host.waiter.now();
            let asked = server.receive(&mut request);
            shown.borrow_mut().push((now, asked));
            if asked {
                server.reply(&request);
            }
            // Nobody can wait in a turn, on whichever stack.
            assert!(host.waiter.wait(Some(now + 1)).is_err());
            (now / 5 + 1) * 5
        });
        assert!(host.waiter.wait(None).is_err(), "the cell is closing");
    };
    scheduler.body(s, Box::new(serve)).expect("a stack");
    let close = scheduler.closer();
    let master = move |host: Host<'_>| {
        // The server is there once it has run.
        while host.waiter.now() < 1 && host.waiter.wait(Some(1)).is_ok() {}
        if ask(&*client, &host) && ask(&*client, &host) {
            while host.waiter.now() < 12 && host.waiter.wait(Some(12)).is_ok() {}
        }
        close();
    };
    scheduler.body(m, Box::new(master)).expect("a stack");
    let outcome = catch_unwind(AssertUnwindSafe(|| scheduler.run()));
    (log.take(), outcome)
}

#[test]
fn a_process_that_serves_works_when_it_is_asked_and_at_the_times_that_it_has_named() {
    let (log, outcome) = run_served(10);
    assert!(matches!(outcome, Ok(Ok(12))), "{outcome:?}");
    assert_eq!(log, [(1, true), (1, true), (5, false), (10, false)]);
}

#[test]
fn a_panic_in_a_turn_is_that_of_the_process_whose_turn_it_is() {
    for turns in [0, 1, 2, 3] {
        let (log, outcome) = run_served(turns);
        let panic = outcome.expect_err("the panic ends the run");
        assert_eq!(panic.downcast_ref::<&str>(), Some(&"a bug of a driver"));
        assert_eq!(log.len(), turns);
    }
}

/// Runs a process that serves and sends a request in its first turn, to itself or to another process that serves and asks it back: how
/// many turns it had, and how many of them at once at most.
fn run_entered_again(by_another: bool) -> (u32, u32) {
    let turns = Rc::new(Cell::new((0, 0, 0)));
    let mut scheduler = Scheduler::new();
    let [m, a, b] = ["m", "a", "b"].map(|name| scheduler.place(process(name)));
    let (asks, _first) = scheduler.port(m, a);
    let (sends, hears) = scheduler.port(a, if by_another { b } else { a });
    let (answers, _second) = scheduler.port(b, a);
    let shown = Rc::clone(&turns);
    let serve = move |host: Host<'_>| {
        host.waiter.serve(NEVER, &mut || {
            let (count, at_once, most) = shown.get();
            shown.set((count + 1, at_once + 1, most.max(at_once + 1)));
            if count == 0 {
                sends.send(&Message::empty());
            }
            let (count, at_once, most) = shown.get();
            shown.set((count, at_once - 1, most));
            NEVER
        });
    };
    scheduler.body(a, Box::new(serve)).expect("a stack");
    let serve = move |host: Host<'_>| {
        let mut request = Message::empty();
        host.waiter.serve(NEVER, &mut || {
            if by_another && hears.receive(&mut request) {
                answers.send(&Message::empty());
            }
            NEVER
        });
    };
    scheduler.body(b, Box::new(serve)).expect("a stack");
    let close = scheduler.closer();
    let master = move |host: Host<'_>| {
        while host.waiter.now() < 1 && host.waiter.wait(Some(1)).is_ok() {}
        asks.send(&Message::empty());
        while host.waiter.now() < 2 && host.waiter.wait(Some(2)).is_ok() {}
        close();
    };
    scheduler.body(m, Box::new(master)).expect("a stack");
    assert_eq!(scheduler.run(), Ok(2));
    let (count, at_once, most) = turns.get();
    assert_eq!(at_once, 0);
    (count, most)
}

#[test]
fn a_request_of_a_turn_to_its_own_process_waits_for_the_next_turn() {
    // That which is asked by the master, and one more.
    assert_eq!(run_entered_again(false), (2, 1));
}

#[test]
fn a_request_that_comes_back_to_a_turn_under_way_waits_for_the_next_turn() {
    assert_eq!(run_entered_again(true), (2, 1));
}

#[test]
fn a_turn_that_serves_is_told_at_once_that_it_cannot() {
    let log = Log::default();
    let mut scheduler = Scheduler::new();
    let [m, a] = ["m", "a"].map(|name| scheduler.place(process(name)));
    let (asks, _server) = scheduler.port(m, a);
    let shown = Rc::clone(&log);
    let serve = move |host: Host<'_>| {
        host.waiter.serve(NEVER, &mut || {
            shown.borrow_mut().push("turn");
            host.waiter.serve(NEVER, &mut || {
                shown.borrow_mut().push("a turn in a turn");
                NEVER
            });
            shown.borrow_mut().push("over");
            NEVER
        });
    };
    scheduler.body(a, Box::new(serve)).expect("a stack");
    let close = scheduler.closer();
    let master = move |host: Host<'_>| {
        while host.waiter.now() < 1 && host.waiter.wait(Some(1)).is_ok() {}
        asks.send(&Message::empty());
        close();
    };
    scheduler.body(m, Box::new(master)).expect("a stack");
    assert_eq!(scheduler.run(), Ok(1));
    assert_eq!(*log.borrow(), ["turn", "over"]);
}
