//! What goes wrong with a gripper, or between it and this machine, and when that is told.

use super::*;

#[test]
fn fault_103_an_activation_that_takes_more_than_20_s_is_ended_and_told() {
    let all = Fixture::new(Gripper { takes: u32::MAX, ..Gripper::inactive() });
    let mut activation = Some(all.activation());
    let told = all.network.until(|| match search(activation.take()?) {
        Ok(Search::Searching(on)) => {
            activation = Some(on);
            None
        }
        Ok(Search::Found(_)) => panic!("it does not end"),
        Err(why) => Some(why),
    });
    assert_eq!(told.to_string(), "failure of its controller: its activation was not over after 20 s");
    // More than 20 s after the request at 0.
    assert_eq!(all.look(|gripper| gripper.written_at), ms(20_005));
    assert_eq!(all.look(|gripper| gripper.written.clone()), [[0; 3], [0x0100, 0, 0], [0; 3]]);
}

#[test]
fn fault_103_a_fault_of_the_gripper_is_told_by_its_name_and_stays_until_it_is_gone() {
    let all = Fixture::new(Gripper::ACTIVE);
    let mut drives = all.opened();
    all.look(|gripper| gripper.fault = 0x08);
    // With the next exchange.
    let told = all.fault_at(&mut drives, opening(40), ms(5));
    assert_eq!(told.to_string(), "protective stop: fault 8: it is too hot, let it cool down");
    assert_eq!(all.recovered(&mut drives), Err(told));
    assert_eq!(drives.switch_on(), Err(told));
    all.look(|gripper| gripper.fault = 0);
    assert_eq!(all.recovered(&mut drives), Ok(()));
    drives.switch_on().expect("it has cooled down");
    all.go(&mut drives, opening(100), opening(100));
}

/// Somebody took its activation away, or its power.
#[test]
fn fault_103_a_gripper_that_is_activated_no_more_stops_and_no_reset_moves_its_fingers() {
    let all = Fixture::new(Gripper::ACTIVE);
    let mut drives = all.opened();
    all.look(|gripper| gripper.write([0; 3]));
    assert_eq!(all.fault_at(&mut drives, opening(40), ms(5)), INACTIVE.into());
    let before = all.look(|gripper| gripper.written.len());
    assert_eq!(all.recovered(&mut drives), Err(INACTIVE.into()));
    assert_eq!(all.look(|gripper| gripper.written.len()), before);
}

#[test]
fn fault_102_a_gripper_that_says_nothing_is_lost_and_only_a_reset_calls_it_again() {
    let all = Fixture::new(Gripper { object: 120, ..Gripper::ACTIVE });
    let mut drives = all.opened();
    all.go(&mut drives, opening(200), opening(120));
    all.look(|gripper| gripper.is_silent = true);
    all.network.advance(ms(5));
    // 500 ms after the question that it has not answered.
    let lost = all.look(|gripper| gripper.asked_at) + ms(500);
    let told = all.fault_at(&mut drives, opening(200), lost);
    assert_eq!(told.to_string(), "communication lost: no answer came in time");
    assert!(drives.tick(&opening(200)).is_err() && drives.measured().is_err());
    all.look(|gripper| gripper.is_silent = false);
    all.network.advance(ms(5000));
    assert!(drives.switch_on().is_err(), "it does not connect by itself");
    assert_eq!(all.look(|gripper| gripper.connections), 1);
    let before = all.look(|gripper| gripper.written.len());
    assert_eq!(all.recovered(&mut drives), Ok(()));
    drives.switch_on().expect("it answers");
    assert_eq!(all.look(|gripper| gripper.connections), 2);
    // Demands begin where it presses to: it keeps its grip.
    assert_eq!(drives.held(), Some(opening(200)));
    drives.tick(&opening(200)).expect("it goes on");
    all.network.advance(ms(1000));
    assert!(all.look(|gripper| gripper.held && gripper.written.len() == before));
}

#[test]
fn fault_102_a_connection_that_is_closed_or_loses_a_byte_is_lost() {
    let all = Fixture::new(Gripper::ACTIVE);
    let mut drives = all.opened();
    all.network.advance(ms(2));
    all.network.close();
    // The next question shows it.
    let told = all.fault_at(&mut drives, opening(40), ms(5));
    assert_eq!(told.to_string(), "communication lost: the connection was closed");
    // An answer that a byte is missing of never ends.
    assert_eq!(all.recovered(&mut drives), Ok(()));
    all.network.change(|faults| faults.lost = Some(11));
    all.network.advance(ms(5));
    let lost = all.look(|gripper| gripper.asked_at) + ms(500);
    let told = all.fault_at(&mut drives, opening(40), lost);
    assert_eq!(told.to_string(), "communication lost: no answer came in time");
}

#[test]
fn fault_102_a_gripper_that_is_not_there_is_told_as_such() {
    let network = VirtualNetwork::empty();
    let mut drives: Drives = Box::new(Robotiq::over(network.network(), settings()));
    let told = drives.open().expect_err("nobody listens");
    assert_eq!(told.to_string(), "communication lost: nothing accepts a connection at its address");
    let Ok(Recovery::GoesOn) = drives.recover() else { panic!("a reset tries it once more") };
    assert_eq!(drives.recover(), Err(told));
}

#[test]
fn fault_102_what_is_no_answer_ends_the_exchange_with_its_reason() {
    // Transaction 1 is the first question, of unit 9.
    let cases: [(&[u8], &str); 5] = [
        (&[0, 7, 0, 0, 0, 9, 9, 4, 6, 0xf9, 0, 0, 0, 0, 0], "another transaction's number"),
        (&[0, 1, 0, 0, 0xff, 0xff, 9, 4, 6], "a length that cannot be"),
        (&[0, 1, 0, 0, 0, 9, 4, 4, 6, 0xf9, 0, 0, 0, 0, 0], "of another unit"),
        (b"HTTP/1.1 400 Bad Request\r\n\r\n", "of another protocol"),
        (&[0, 1, 0, 0, 0, 3, 9, 0x84, 2], "exception 2: the device has no such bits or registers"),
    ];
    for (instead, reason) in cases {
        let all = Fixture::new(Gripper { instead: Some(instead.to_vec()), ..Gripper::ACTIVE });
        let told = all.drives().open().expect_err("it is no answer").to_string();
        assert!(told.contains(reason), "{told}");
        assert!(all.network.now() <= ms(1), "it is told at once");
    }
    // A whole message that never ends.
    let all = Fixture::new(Gripper { instead: Some(vec![0, 1, 0, 0]), ..Gripper::ACTIVE });
    let told = all.drives().open().expect_err("it is cut").to_string();
    assert!(told.contains("no answer came in time"), "{told}");
    assert_eq!(all.network.now(), ms(500));
}

#[test]
fn fault_102_a_gateway_that_is_busy_is_asked_again() {
    // After exception 11 the answer that was given up may still come, for as long as an answer may take.
    for (exception, again) in [(6, ms(5)), (0x0b, ms(500))] {
        let busy = vec![0, 1, 0, 0, 0, 3, 9, 0x84, exception];
        let all = Fixture::new(Gripper { instead: Some(busy), ..Gripper::ACTIVE });
        all.drives().open().expect("the second time it answers");
        assert_eq!(all.network.now(), again, "exception {exception}");
    }
}

#[test]
fn fault_102_a_gateway_that_stays_busy_is_lost_after_a_second() {
    let all = Fixture::new(Gripper { exception: Some(6), ..Gripper::ACTIVE });
    let told = all.drives().open().expect_err("it stays busy");
    assert_eq!(told.to_string(), "communication lost: exception 6: the device is busy");
    assert_eq!(all.network.now(), ms(1000));
    // The same of one that was heard before: more than a second after that.
    let all = Fixture::new(Gripper::ACTIVE);
    let mut drives = all.opened();
    all.look(|gripper| gripper.exception = Some(6));
    let beyond = ms(1000) + Duration::from_nanos(1);
    let told = all.fault_at(&mut drives, opening(40), beyond);
    assert_eq!(told.to_string(), "communication lost: no reading came in time", "the drives see it first");
    all.network.advance(ms(5));
    let told = drives.tick(&opening(40)).expect_err("the exchange has seen it, too");
    assert_eq!(told.to_string(), "communication lost: exception 6: the device is busy");
}

#[test]
fn fault_102_a_position_that_does_not_arrive_is_told() {
    let all = Fixture::new(Gripper::ACTIVE);
    let mut drives = all.opened();
    all.go(&mut drives, opening(100), opening(100));
    // Somebody else writes to it all the time.
    let reads = all.look(|gripper| {
        gripper.others = Some(7);
        gripper.reads
    });
    // The 101st exchange, every 5 ms.
    let now = all.network.now();
    let told = all.fault_at(&mut drives, opening(100), now + ms(101 * 5));
    assert_eq!(cause(told), StopCause::PendantInControl);
    assert_eq!(all.look(|gripper| gripper.reads) - reads, 101);
}

#[test]
fn fault_102_fingers_that_somebody_else_moves_are_not_taken_over() {
    let all = Fixture::new(Gripper { is_restless: true, ..Gripper::ACTIVE });
    let told = all.drives().open().expect_err("they do not stand");
    assert_eq!(told.to_string(), "operated from its pendant: somebody else moves its fingers");
    assert_eq!(all.network.now(), ms(6005), "more than 6 s, and a reading");
    assert!(all.look(|gripper| gripper.written.is_empty()));
}

#[test]
fn fault_102_a_gripper_that_was_told_nothing_for_long_forgets_that_within_a_second_or_is_lost() {
    let all = Fixture::new(Gripper { fault: 9, ..Gripper::ACTIVE });
    let told = all.drives().open().expect_err("it does not forget it");
    assert_eq!(told.to_string(), "communication lost: fault 9: it was told nothing for a second");
    assert_eq!(all.network.now(), ms(1005), "more than a second, and a reading");
}

#[test]
fn fault_102_whichever_byte_is_lost_the_fingers_are_told_nothing_but_what_was_demanded() {
    let mut lost = 0;
    // The status is read with 15 bytes twice before the drives are open; then 12 and 15 come in each exchange.
    for byte in 0..100 {
        let all = Fixture::new(Gripper::ACTIVE);
        all.network.change(|faults| faults.lost = Some(byte));
        let mut drives = all.drives();
        let told = drives.open().err().or_else(|| {
            all.network.until(|| {
                let ticked = drives.tick(&opening(100));
                (ticked.is_err() || all.network.now() > ms(700)).then(|| ticked.err())
            })
        });
        lost += u32::from(told.is_some_and(|told| cause(told) == StopCause::CommunicationLost));
        let written = all.look(|gripper| gripper.written.clone());
        assert!(written.iter().all(|request| *request == [0x0900, 100, 0xff40]), "{byte}: {written:x?}");
    }
    assert_eq!(lost, 100, "each of them");
}

#[test]
fn answers_may_be_cut_anywhere() {
    let run = |piece: usize| {
        let all = Fixture::new(Gripper { object: 120, ..Gripper::ACTIVE });
        all.network
            .change(|faults| *faults = Faults { piece, gap: Duration::from_micros(10), ..Faults::NONE });
        let mut drives = all.opened();
        all.go(&mut drives, opening(200), opening(120));
        all.look(|gripper| (gripper.reads, gripper.written.clone()))
    };
    for piece in 1..20 {
        assert_eq!(run(piece), run(usize::MAX), "{piece} bytes");
    }
}
