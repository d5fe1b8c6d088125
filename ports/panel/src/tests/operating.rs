//! Who may operate the cell, and until when.

use mrroc_core::operator::button::Button;
use mrroc_core::operator::{Answer, Request};
use serde_json::{Value, json};

use super::pages::{Fixture, fixture, fixture_by};
use super::*;
use crate::events::{Key, PageEvent};

fn jog(number: u64, begins: bool) -> Value {
    let order = "world x 20% by 0.001";
    json!({"n": number, "do": "jog", "begins": begins, "robot": "arm", "order": order, "epoch": 0, "step": 1000})
}

/// A page that has control.
fn in_control(fixture: &mut Fixture) -> Key {
    let page = fixture.known();
    fixture.say(page, &json!({"n": 1, "do": "take"}));
    assert_eq!(fixture.request(), Some(Request::Take));
    assert_eq!(fixture.answer(page, 1)["outcome"], "done");
    page
}

/// The number of the hold that the page begins.
fn holds(fixture: &mut Fixture, page: Key) -> u64 {
    fixture.say(page, &json!({"n": 2, "do": "hold", "begins": true, "epoch": 0, "step": 1000}));
    match fixture.request() {
        Some(Request::Press(Button::Hold(renewal))) => renewal.hold(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn fault_205_a_stop_is_taken_from_every_page_whatever_it_said_before_and_whoever_has_authority() {
    let mut fixture = fixture();
    in_control(&mut fixture);
    let two = fixture.known();
    fixture.say(two, &json!({"n": 1, "do": "suspend", "epoch": 0, "step": 1000}));
    let refused = fixture.answer(two, 1);
    assert!(refused["text"].as_str().is_some_and(|why| why.contains("has control")), "{refused}");
    // All that a page may say is said; the stop has no step and no epoch.
    for _ in 0..59 {
        fixture.say(two, &json!({"do": "beat"}));
    }
    for n in 2..40 {
        fixture.say(two, &json!({"n": n, "do": "stop"}));
        assert_eq!(fixture.request(), Some(Request::Press(Button::Stop)));
        assert_eq!(fixture.answer(two, n)["outcome"], "done");
    }
    assert!(fixture.closed.is_empty());
    // Anything else is too much.
    fixture.say(two, &json!({"do": "beat"}));
    assert!(fixture.closed.contains_key(&two));
}

#[test]
fn fault_205_a_stop_that_comes_while_the_last_one_of_its_page_is_under_way_is_part_of_it() {
    let mut fixture = fixture_by(|request| match request {
        Request::Press(Button::Stop) => None,
        request => Some(Answer::Done(format!("{request}"))),
    });
    let (one, two) = (fixture.known(), fixture.known());
    for n in 1..100 {
        fixture.say(one, &json!({"n": n, "do": "stop"}));
    }
    fixture.say(two, &json!({"n": 1, "do": "stop"}));
    // One for each page.
    assert_eq!(
        (fixture.request(), fixture.request()),
        (Some(Request::Press(Button::Stop)), Some(Request::Press(Button::Stop)))
    );
    assert_eq!(fixture.request(), None);
    let (to, request) = fixture.waiting.pop_front().expect("one waits");
    fixture.pages.answered(to, &request, Some(Answer::Done("stopped".to_owned())));
    fixture.settle();
    assert_eq!(fixture.answer(one, 1)["text"], "stopped");
    fixture.say(one, &json!({"n": 100, "do": "stop"}));
    assert_eq!(fixture.request(), Some(Request::Press(Button::Stop)));
}

#[test]
fn fault_206_a_page_that_falls_silent_while_it_holds_lets_go_and_loses_authority() {
    let mut fixture = fixture();
    let page = in_control(&mut fixture);
    let held = holds(&mut fixture, page);
    let began = fixture.now;
    // What it does is no sign of life, and renews nothing.
    fixture.pass(MS(280));
    fixture.say(page, &json!({"n": 3, "do": "resume", "epoch": 0, "step": 1000}));
    assert_eq!(fixture.request(), Some(Request::Press(Button::Resume)));
    fixture.pass(MS(1000));
    // What it holds is let go 290 ms after its last renewal, and authority lapses 300 ms after its last sign of life: not a millisecond later.
    let asked: Vec<_> = fixture.asked.drain(..).map(|(at, request)| (at - began, request)).collect();
    assert_eq!(asked, [(MS(290), Request::Press(Button::LetGo(held))), (MS(300), Request::Release)]);
    fixture.say(page, &json!({"n": 4, "do": "resume", "epoch": 0, "step": 1000}));
    assert_eq!(fixture.answer(page, 4)["outcome"], "refused");
    assert_eq!(fixture.request(), None);
}

#[test]
fn fault_206_what_has_lapsed_is_told_to_the_console_server_also_where_the_page_speaks_before_anybody_has_looked()
 {
    let mut fixture = fixture();
    let page = in_control(&mut fixture);
    let held = holds(&mut fixture, page);
    fixture.now += MS(310);
    // By a late word of its own page, or a word of any other.
    fixture.say(page, &json!({"do": "beat"}));
    assert_eq!(fixture.request(), Some(Request::Press(Button::LetGo(held))));
    assert_eq!(fixture.request(), Some(Request::Release));
    assert_eq!(fixture.request(), None);
    let held = {
        fixture.say(page, &json!({"n": 5, "do": "take"}));
        fixture.request().expect("taken");
        holds(&mut fixture, page)
    };
    let other = fixture.known();
    fixture.now += MS(310);
    fixture.say(other, &json!({"n": 1, "do": "take"}));
    assert_eq!(fixture.request(), Some(Request::Press(Button::LetGo(held))));
    assert_eq!((fixture.request(), fixture.request()), (Some(Request::Release), Some(Request::Take)));
}

#[test]
fn fault_206_a_page_that_is_gone_holds_nothing_from_then_on_and_its_console_server_is_told_at_once() {
    for heard in [PageEvent::Closed, PageEvent::Failed("reset".to_owned()), PageEvent::Binary] {
        let mut fixture = fixture();
        let page = in_control(&mut fixture);
        let held = holds(&mut fixture, page);
        fixture.hear(page, heard);
        assert_eq!(fixture.request(), Some(Request::Press(Button::LetGo(held))));
        assert_eq!((fixture.request(), fixture.request()), (Some(Request::Release), None));
    }
    // As if it had said so.
    let mut fixture = fixture();
    let page = in_control(&mut fixture);
    let held = holds(&mut fixture, page);
    fixture.say(page, &json!({"n": 3, "do": "release"}));
    assert_eq!(fixture.request(), Some(Request::Press(Button::LetGo(held))));
    assert_eq!((fixture.request(), fixture.request()), (Some(Request::Release), None));
    assert_eq!(fixture.answer(page, 3)["text"], "nobody has control");
}

#[test]
fn fault_232_a_page_that_jogs_and_falls_silent_lets_go_and_loses_authority() {
    let mut fixture = fixture();
    let other = fixture.known();
    // Only the page with control jogs.
    fixture.say(other, &jog(2, true));
    assert_eq!(fixture.answer(other, 2)["outcome"], "refused");
    let page = in_control(&mut fixture);
    // What renews nothing begins nothing.
    fixture.say(page, &jog(2, false));
    let why = fixture.answer(page, 2);
    assert!(why["text"].as_str().is_some_and(|why| why.contains("the hold is over")), "{why}");
    let renewal = |request: Option<Request>| match request {
        Some(Request::Press(Button::Jog(renewal, robot, order))) => {
            assert_eq!((robot.as_str(), order.to_string().as_str()), ("arm", "world x 20% by 0.001"));
            (renewal.hold(), renewal.count())
        }
        other => panic!("{other:?}"),
    };
    fixture.say(page, &jog(3, true));
    let (held, _) = renewal(fixture.request());
    // As long as it says that it is there, and holds, this goes on.
    for count in 1..50 {
        fixture.pass(MS(289));
        fixture.say(page, &json!({"do": "beat"}));
        fixture.say(page, &jog(0, false));
        assert_eq!(renewal(fixture.request()), (held, count));
    }
    let last = fixture.now;
    fixture.pass(MS(1000));
    let asked: Vec<_> = fixture.asked.drain(..).map(|(at, request)| (at - last, request)).collect();
    assert_eq!(asked, [(MS(290), Request::Press(Button::LetGo(held))), (MS(300), Request::Release)]);
    fixture.say(page, &jog(4, false));
    assert_eq!(fixture.answer(page, 4)["outcome"], "refused");
}

#[test]
fn fault_232_a_renewal_that_comes_too_late_begins_nothing() {
    for (late, is_renewed) in [(289, true), (290, false)] {
        let mut fixture = fixture();
        let page = in_control(&mut fixture);
        fixture.say(page, &jog(2, true));
        fixture.asked.clear();
        fixture.pass(MS(100));
        fixture.say(page, &json!({"do": "beat"}));
        fixture.pass(MS(late - 100));
        fixture.say(page, &jog(3, false));
        let is_jogged =
            fixture.asked.iter().any(|(_, request)| matches!(request, Request::Press(Button::Jog(..))));
        assert_eq!(is_jogged, is_renewed);
        assert_eq!(fixture.asked.len(), 1, "it is renewed, or let go");
    }
}

#[test]
fn a_page_is_told_why_the_robot_stands_that_it_holds() {
    let mut fixture = fixture_by(|request| match request {
        Request::Press(Button::Jog(renewal, ..)) if renewal.count() == 2 => {
            Some(Answer::Refused("another robot moves".to_owned()))
        }
        request => Some(Answer::Done(format!("{request}"))),
    });
    let (page, other) = (in_control(&mut fixture), fixture.known());
    for count in 0..3 {
        let order = "world x 20%";
        fixture.say(page, &json!({"do": "jog", "begins": count == 0, "robot": "arm", "order": order, "epoch": 0, "step": 1000}));
    }
    let why = fixture.answer(page, 0);
    assert_eq!((&why["outcome"], &why["text"]), (&json!("refused"), &json!("another robot moves")));
    // Another robot, in the same hold.
    fixture.say(page, &json!({"do": "hold", "epoch": 0, "step": 1000}));
    let why = fixture.answer(page, 0);
    assert!(why["text"].as_str().is_some_and(|why| why.contains("what it began with")), "{why}");
    // Renewals are told to no other page.
    let notes = fixture.kinds(other).iter().filter(|kind| *kind == "note").count();
    assert_eq!(notes, 1, "the beginning of the jog");
}

#[test]
fn a_page_that_another_console_keeps_from_the_cell_has_no_control() {
    let mut fixture = fixture_by(|request| match request {
        Request::Take => Some(Answer::Refused("console 7 has control".to_owned())),
        request => Some(Answer::Done(format!("{request}"))),
    });
    let page = fixture.known();
    fixture.say(page, &json!({"n": 1, "do": "take"}));
    assert_eq!(fixture.answer(page, 1)["text"], "console 7 has control");
    fixture.say(page, &json!({"n": 2, "do": "resume", "epoch": 0, "step": 1000}));
    assert_eq!(fixture.answer(page, 2)["text"], "this page does not have control: take it first");
    // The console server is not told of what it has refused.
    assert_eq!((fixture.request(), fixture.request()), (Some(Request::Take), None));
}

#[test]
fn fault_204_a_button_is_refused_where_the_cell_is_not_seen_yet_or_was_seen_too_long_ago() {
    let mut fixture = fixture();
    let page = in_control(&mut fixture);
    let press = |fixture: &mut Fixture, step: u64| {
        fixture.say(page, &json!({"do": "beat"}));
        fixture.say(page, &json!({"n": 3, "do": "resume", "epoch": 0, "step": step}));
        fixture.answer(page, 3)["text"].as_str().expect("a text").to_owned()
    };
    // A second of steps of 2 ms.
    assert!(press(&mut fixture, 499).contains("501 steps ago"));
    assert_eq!(press(&mut fixture, 500), "resume");
    fixture.pages.show(CellSnapshot::default());
    assert_eq!(press(&mut fixture, 1000), "the cell has not been seen yet");
}
