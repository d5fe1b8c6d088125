//! What is shown to whom, and who is disconnected, when, and with which words.

use mrroc_core::operator::Request;
use serde_json::json;

use super::pages::{fixture, fixture_by};
use super::*;
use crate::events::PageEvent;
use crate::rules::PAGES;

#[test]
fn fault_200_without_the_token_nothing_is_shown_and_nothing_is_done() {
    let mut fixture = fixture();
    for first in [
        json!({"token": "0".repeat(32)}),
        json!({"token": ""}),
        json!({"n": 1, "do": "stop"}),
        json!({"n": 1, "do": "take"}),
    ] {
        let page = fixture.connect().expect("a place");
        fixture.say(page, &first);
        fixture.say(page, &json!({"n": 2, "do": "stop"}));
        assert_eq!(fixture.next(page), None, "{first}");
        // It is told why at once.
        assert_eq!(fixture.closed[&page], (fixture.now, Some("this is not the token")));
    }
    for first in
        [PageEvent::Binary, PageEvent::Control, PageEvent::Closed, PageEvent::Failed("reset".to_owned())]
    {
        let page = fixture.connect().expect("a place");
        fixture.hear(page, first);
        fixture.say(page, &json!({"n": 2, "do": "stop"}));
        assert_eq!(fixture.closed[&page], (fixture.now, None));
        assert_eq!(fixture.next(page), None);
    }
    assert!(fixture.asked.is_empty() && fixture.said.is_empty());
    let page = fixture.known();
    assert_eq!(fixture.next(page).expect("the cell")["kind"], "layout");
}

#[test]
fn fault_200_a_page_that_does_not_show_the_token_is_disconnected_after_five_seconds() {
    let mut fixture = fixture();
    let (began, page, other) =
        (fixture.now, fixture.connect().expect("a place"), fixture.connect().expect("a place"));
    fixture.pass(MS(4999));
    let token = json!({"token": fixture.token});
    fixture.say(other, &token);
    fixture.pass(MS(10_000));
    assert_eq!(fixture.closed[&page], (began + MS(5000), None));
    assert_eq!(fixture.next(page), None);
    assert!(!fixture.closed.contains_key(&other), "this one has shown it in time");
    // One whose connection is being made is not counted yet.
    let key = fixture.pages.connect().expect("a place");
    fixture.pass(MS(10_000));
    fixture.pages.begin(key, fixture.now);
    assert!(fixture.pages.poll(key, fixture.now + MS(4999)).is_some());
    assert!(fixture.pages.poll(key, fixture.now + MS(5000)).is_none());
}

#[test]
fn fault_200_who_does_not_take_the_refusal_of_the_token_is_gone_after_five_seconds() {
    let mut fixture = fixture();
    let page = fixture.connect().expect("a place");
    fixture.stuck.push(page);
    fixture.pass(MS(4000));
    let at = fixture.now;
    fixture.say(page, &json!({"token": "no"}));
    fixture.pass(MS(10_000));
    assert_eq!(fixture.closed[&page].0, at + MS(5000));
}

#[test]
fn fault_203_malformed_messages_and_floods_disconnect_who_sends_them_and_reach_no_console_server() {
    let mut fixture = fixture();
    let good = fixture.known();
    let page = fixture.known();
    for _ in 0..8 {
        fixture.hear(page, PageEvent::Text("{]"));
        assert!(fixture.answer(page, 0)["text"].as_str().is_some_and(|why| why.contains("JSON")));
    }
    fixture.hear(page, PageEvent::Text("{]"));
    assert_eq!(fixture.closed[&page].1, Some("the panel has closed the connection"));
    let page = fixture.known();
    fixture.hear(page, PageEvent::Binary);
    assert!(fixture.closed.contains_key(&page));
    // A burst of sixty, whether they are messages or pings; then as many as there are sixtieths of a second.
    let (page, pings) = (fixture.known(), fixture.known());
    for _ in 0..60 {
        fixture.say(page, &json!({"do": "beat"}));
        fixture.hear(pings, PageEvent::Control);
    }
    fixture.pass(MS(51));
    for _ in 0..3 {
        fixture.say(page, &json!({"do": "beat"}));
        fixture.hear(pings, PageEvent::Control);
        assert!(!fixture.closed.contains_key(&page) && !fixture.closed.contains_key(&pings));
    }
    fixture.say(page, &json!({"n": 1, "do": "take"}));
    fixture.hear(pings, PageEvent::Control);
    assert!(fixture.closed.contains_key(&page) && fixture.closed.contains_key(&pings));
    let gone: Vec<_> = fixture.said.iter().filter(|said| said.contains("gone")).map(String::as_str).collect();
    assert_eq!(
        gone,
        [
            "page 2 is gone: it said what is no message",
            "page 3 is gone: it sent what is no text",
            "page 4 is gone: it said too much",
            "page 5 is gone: it sent what is no text",
        ]
    );
    fixture.say(good, &json!({"n": 4, "do": "suspend", "epoch": 0, "step": 1000}));
    assert_eq!(fixture.answer(good, 4)["outcome"], "refused");
    assert!(fixture.asked.is_empty());
}

#[test]
fn fault_203_of_a_crowd_of_pages_as_many_find_a_place_as_there_are() {
    let mut fixture = fixture();
    let good = fixture.known();
    // Of those that show nothing the oldest makes room, and never a page that has shown the token.
    let crowd: Vec<_> = (0..60).map(|_| fixture.connect()).collect();
    assert_eq!(crowd.iter().flatten().count(), 60);
    let known: Vec<_> = (2..PAGES).map(|_| fixture.known()).collect();
    let news = fixture.known();
    assert_eq!((known.len(), fixture.connect()), (PAGES - 2, None), "all places are those of pages");
    fixture.say(good, &json!({"n": 4, "do": "suspend", "epoch": 0, "step": 1000}));
    assert_eq!(fixture.answer(good, 4)["outcome"], "refused");
    fixture.say(news, &json!({"n": 4, "do": "suspend", "epoch": 0, "step": 1000}));
    assert_eq!(fixture.answer(news, 4)["outcome"], "refused");
}

#[test]
fn fault_203_a_page_that_does_not_read_is_disconnected_after_five_seconds_and_operates_nothing() {
    let mut fixture = fixture();
    let good = fixture.known();
    let page = fixture.known();
    fixture.say(page, &json!({"n": 1, "do": "take"}));
    assert_eq!(fixture.answer(page, 1)["outcome"], "done");
    fixture.asked.clear();
    // From now on it takes nothing, though it goes on to say that it is there.
    fixture.stuck.push(page);
    let newest = shown(&fixture.looks);
    fixture.pages.show(newest.clone());
    fixture.settle();
    let at = fixture.now;
    for _ in 0..50 {
        fixture.say(page, &json!({"do": "beat"}));
        fixture.pages.show(newest.clone());
        fixture.pass(MS(100));
    }
    fixture.pass(MS(2000));
    // The console server is told at the end of the fifth second; the connection is closed a second later, whatever it takes.
    assert_eq!(fixture.asked, [(at + MS(5000), Request::Release)]);
    assert_eq!(fixture.closed[&page].0, at + MS(6000));
    assert!(fixture.said.iter().any(|said| said == "page 2 is gone: it does not read"));
    // The other one was shown every picture.
    assert_eq!(fixture.kinds(good).iter().filter(|kind| *kind == "state").count(), 52);
}

#[test]
fn fault_203_a_page_that_does_not_read_its_answers_is_disconnected_when_they_are_too_many() {
    let mut fixture = fixture();
    let page = fixture.known();
    fixture.stuck.push(page);
    fixture.pages.show(shown(&fixture.looks));
    fixture.settle();
    for n in 0..64 {
        fixture.pass(MS(20));
        fixture.say(page, &json!({"n": n, "do": "suspend", "epoch": 0, "step": 1000}));
    }
    let at = fixture.now;
    fixture.say(page, &json!({"n": 64, "do": "suspend", "epoch": 0, "step": 1000}));
    assert!(fixture.said.iter().any(|said| said == "page 1 is gone: it does not read"));
    // It reads again: it is told what waits for it, and that it is disconnected.
    fixture.stuck.clear();
    fixture.pages.sent(page);
    fixture.settle();
    assert_eq!(fixture.answer(page, 63)["outcome"], "refused");
    assert_eq!(fixture.closed[&page], (at, Some("the panel has closed the connection")));
}

#[test]
fn a_page_that_is_disconnected_is_told_what_it_has_asked_for_within_a_second() {
    let mut fixture = fixture_by(|_| None);
    let (page, other) = (fixture.known(), fixture.known());
    for key in [page, other] {
        fixture.say(key, &json!({"n": 7, "do": "stop"}));
        fixture.hear(key, PageEvent::Binary);
    }
    let at = fixture.now;
    fixture.pass(MS(900));
    let (to, kind) = fixture.waiting.pop_front().expect("it waits");
    fixture.pages.answered(to, &kind, None);
    fixture.pass(MS(1000));
    assert_eq!(fixture.answer(page, 7)["text"], "the panel is ending");
    assert_eq!(fixture.closed[&page], (at + MS(900), Some("the panel has closed the connection")));
    assert_eq!(fixture.closed[&other], (at + MS(1000), None));
}
