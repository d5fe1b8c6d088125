//! What goes wrong with the hand, or between it and this machine, and when that is told.

use super::*;

#[test]
fn fault_113_a_homing_that_does_not_end_within_30_s_is_told() {
    let all = Fixture::new(Fingers { max_width: 0.0, is_stuck: true, ..Fingers::open() });
    let told = all.homed().err().expect("it does not end");
    assert!(told.to_string().contains("is something in its way?"), "{told}");
    assert_eq!(all.network.now(), all.look(|fingers| fingers.asked_at) + ms(30_002));
    assert_eq!(all.asked(), [(STOP, vec![]), (HOMING, vec![])]);
}

#[test]
fn fault_114_an_opening_that_the_hand_does_not_have_is_refused() {
    let all = Fixture::new(Fingers { max_width: 0.079, width: 0.06, ..Fingers::open() });
    let mut drives = all.opened();
    for bad in [0.0795, -0.001, f64::NAN] {
        let told = drives.tick(&One::new(bad)).expect_err("it does not open so far").to_string();
        assert!(told.starts_with("demanded opening"), "{told}");
    }
    all.go(&mut drives, 0.079, 0.079);
    assert_eq!(all.asked(), [(MOVE, vec![0.079, SPEED])]);
    // Fingers that stand a little beyond may stay there.
    let all = Fixture::new(Fingers { width: -1e-4, ..Fingers::open() });
    let mut drives = all.opened();
    let held = drives.held().expect("it is open");
    all.stay(&mut drives, held[0], ms(1000));
    assert!(all.asked().is_empty());
}

#[test]
fn fault_114_a_motion_that_the_hand_does_not_do_is_told_and_a_reset_moves_nothing() {
    // Its status, and what it means.
    for (status, text, of) in [
        (1, "move failed", StopCause::ProtectiveStop),
        (2, "did not come to the opening", StopCause::ProtectiveStop),
        (3, "somebody else", StopCause::PendantInControl),
        (9, "no Franka Hand", StopCause::CommunicationLost),
    ] {
        let all = Fixture::new(Fingers { width: 0.05, refuses: Some(status), ..Fingers::open() });
        let mut drives = all.opened();
        let told = all.fault(&mut drives, 0.07);
        assert!(told.to_string().contains(text), "{told}");
        assert_eq!(cause(told), of);
        assert_eq!(drives.switch_on(), Err(told));
        assert_eq!(all.recovered(&mut drives), Ok(()));
        drives.switch_on().expect("it is there");
        assert_eq!(drives.held(), Some(One::new(0.05)));
        all.stay(&mut drives, 0.05, ms(1000));
        assert_eq!(all.asked().len(), 1);
        all.go(&mut drives, 0.07, 0.07);
    }
    let all = Fixture::new(Fingers { refuses: Some(1), ..Fingers::open() });
    let mut drives = all.opened();
    assert_eq!(all.fault(&mut drives, 0.02).to_string(), "protective stop: grasp failed");
}

#[test]
fn fault_114_a_move_that_something_holds_back_is_stopped_and_told() {
    let all = Fixture::new(Fingers { object: Some(0.05), ..Fingers::open() });
    let mut drives = all.opened();
    drives.choose_regulators(&Regulators::uniform(1));
    all.stay(&mut drives, 0.02, ms(100));
    assert_eq!(all.asked(), [(MOVE, vec![0.02, SPEED])]);
    // More than 10 s, which is looked at every 2 ms.
    let told = all.look(|fingers| fingers.asked_at);
    let told = all.fault_at(&mut drives, 0.02, told + ms(10_002));
    assert_eq!(cause(told), StopCause::ProtectiveStop);
    assert!(told.to_string().contains("is something in its way?"), "{told}");
    all.network.advance(ms(0));
    assert_eq!(all.asked()[1..], [(STOP, vec![])]);
}

#[test]
fn fault_114_a_grasp_that_does_not_end_is_told_and_not_stopped() {
    let all = Fixture::new(Fingers { is_stuck: true, ..Fingers::open() });
    let mut drives = all.opened();
    all.stay(&mut drives, 0.02, ms(100));
    let began = all.look(|fingers| fingers.asked_at);
    let told = all.fault_at(&mut drives, 0.02, began + ms(10_002));
    assert!(told.to_string().contains("is something in its way?"), "{told}");
    all.network.advance(ms(1000));
    assert_eq!(all.asked(), [(GRASP, vec![0.02, 0.0, STROKE, SPEED, FORCE])]);
}

#[test]
fn fault_112_a_hand_that_says_nothing_is_lost_and_only_a_reset_calls_it_again() {
    let all = Fixture::new(Fingers { object: Some(0.03), ..Fingers::open() });
    let mut drives = all.opened();
    all.go(&mut drives, 0.01, 0.03);
    all.network.advance(ms(20));
    assert!(holds(&drives));
    all.look(|fingers| fingers.is_silent = true);
    // More than 1 s after its last state.
    let lost = all.look(|fingers| fingers.sent_at) + ms(1000) + Duration::from_nanos(1);
    let told = all.fault_at(&mut drives, 0.01, lost);
    assert_eq!(told.to_string(), "communication lost: no state came in time");
    assert!(drives.measured().is_err() && !holds(&drives));
    // The exchange looks at that every 2 ms, and ends.
    all.network.advance(ms(2));
    all.look(|fingers| fingers.is_silent = false);
    all.network.advance(ms(5000));
    assert!(drives.switch_on().is_err(), "it does not connect by itself");
    assert_eq!(all.look(|fingers| fingers.connections), 1);
    assert_eq!(all.recovered(&mut drives), Ok(()));
    drives.switch_on().expect("it says where it is");
    assert_eq!(all.look(|fingers| fingers.connections), 2);
    // It keeps its grip.
    assert_eq!(drives.held(), Some(One::new(0.03)));
    all.stay(&mut drives, 0.03, ms(1000));
    assert!(all.look(|fingers| fingers.is_grasped && fingers.asked.len() == 1));
}

#[test]
fn fault_112_a_connection_that_is_closed_is_told() {
    let all = Fixture::new(Fingers::open());
    let mut drives = all.opened();
    let now = all.network.now();
    all.network.close();
    let told = all.fault_at(&mut drives, 0.05, now + Duration::from_nanos(1));
    assert_eq!(told.to_string(), "communication lost: connection closed by the robot");
    assert!(all.asked().is_empty());
}

#[test]
fn fault_112_a_hand_that_is_not_there_or_of_another_version_is_told_as_such() {
    let network = VirtualNetwork::empty();
    let mut drives: Drives = Box::new(Hand::over(network.network(), settings()));
    let told = drives.open().expect_err("nobody listens");
    assert!(told.to_string().contains("is the hand mounted?"), "{told}");
    let Ok(Recovery::GoesOn) = drives.recover() else { panic!("a reset tries it once more") };
    assert_eq!(drives.recover(), Err(told));
    let all = Fixture::new(Fingers { version: 2, ..Fingers::open() });
    assert_eq!(all.drives().open(), Err(OTHER_VERSION));
}

#[test]
fn fault_112_what_answers_and_is_no_hand_is_told() {
    // One with a length that cannot be, one of another request, one of another protocol.
    let cases: [&[u8]; 3] = [
        &[0, 0, 1, 0, 0, 0, 255, 255, 255, 255],
        &[0, 0, 7, 0, 0, 0, 14, 0, 0, 0, 0, 0, 3, 0],
        b"HTTP/1.1 400 Bad Request\r\n\r\n",
    ];
    for instead in cases {
        let all = Fixture::new(Fingers { instead: Some(instead.to_vec()), ..Fingers::open() });
        let told = all.drives().open().expect_err("it is no hand");
        assert!(told.to_string().contains("no Franka Hand"), "{told}");
        assert!(all.network.now() <= ms(1), "it is told at once");
    }
    // One that says nothing.
    let all = Fixture::new(Fingers { instead: Some(Vec::new()), ..Fingers::open() });
    let told = all.drives().open().expect_err("it is no hand");
    assert!(told.to_string().contains("no Franka Hand"), "{told}");
    assert_eq!(all.network.now(), ms(1000));
}

#[test]
fn fault_112_fingers_that_somebody_else_moves_are_not_taken_over() {
    let all = Fixture::new(Fingers { is_restless: true, ..Fingers::open() });
    let told = all.drives().open().expect_err("they do not stand");
    assert_eq!(cause(told), StopCause::PendantInControl);
    // More than 6 s after the first state, which comes after 10 ms.
    assert_eq!(all.network.now(), ms(6012));
}

#[test]
fn fault_112_whichever_byte_of_an_answer_is_lost_the_hand_is_asked_for_nothing_else() {
    // The answer to the connection has 14 bytes, that to a grasp 12.
    for byte in 0..26 {
        let all = Fixture::new(Fingers { object: Some(0.07), ..Fingers::open() });
        all.network.change(|faults| faults.lost = Some(byte));
        let mut drives = all.drives();
        let told = drives.open().err().unwrap_or_else(|| all.fault(&mut drives, 0.01)).to_string();
        let is_named = told.contains("no Franka Hand") || told.contains("is something in its way?");
        assert!(is_named, "{byte}: {told}");
        let expected = [(GRASP, vec![0.01, 0.0, STROKE, SPEED, FORCE])];
        assert!(expected.starts_with(&all.asked()), "{byte}: {:?}", all.asked());
        assert!(all.network.now() < ms(11_000), "{byte}");
    }
}
