//! What a page is sent, and in which order.

use mrroc_core::observe::step_observer::StepRecord;
use serde_json::json;

use super::pages::{fixture, of_history};
use super::*;
use crate::events::PageEvent;
use crate::run_history::RunHistory;

#[test]
fn a_page_is_told_what_stays_as_it_is_then_who_has_control_and_then_what_changes() {
    let mut fixture = fixture();
    fixture.pages.teach(json!({"kind": "poses", "robots": {}}).to_string().into());
    let one = fixture.known();
    let layout = fixture.next(one).expect("the layout");
    assert_eq!(
        (&layout["kind"], &layout["page"], &layout["lasts"]),
        (&json!("layout"), &json!(1), &json!(null))
    );
    assert_eq!(fixture.next(one), Some(json!({"kind": "authority", "page": null, "yours": false})));
    assert_eq!(fixture.kinds(one), ["poses", "state"]);
    // Nothing is said twice.
    fixture.pass(MS(10_000));
    assert_eq!(fixture.next(one), None);
    let two = fixture.known();
    assert_eq!(fixture.kinds(two), ["layout", "authority", "poses", "state"]);
    assert_eq!(fixture.next(one), Some(json!({"kind": "note", "text": "page 2 looks on"})));
    // Who has control, an answer, and then what all pages are told.
    fixture.say(two, &json!({"n": 9, "do": "take"}));
    assert_eq!(fixture.next(two), Some(json!({"kind": "authority", "page": 2, "yours": true})));
    assert_eq!(fixture.next(two), Some(json!({"kind": "answer", "n": 9, "outcome": "done", "text": "take"})));
    let note = json!({"kind": "note", "text": "page 2: take control: done: take"});
    assert_eq!(fixture.next(two), Some(note.clone()));
    assert_eq!(fixture.next(one), Some(json!({"kind": "authority", "page": 2, "yours": false})));
    assert_eq!(fixture.next(one), Some(note));
    // As soon as it has lapsed, they are told.
    fixture.pass(MS(300));
    for page in [one, two] {
        assert_eq!(fixture.next(page), Some(json!({"kind": "authority", "page": null, "yours": false})));
        let lost = json!({"kind": "note", "text": "page 2 was silent for too long, and has lost control"});
        assert_eq!(fixture.next(page), Some(lost));
    }
}

#[test]
fn a_page_is_shown_the_newest_picture_and_told_why_there_are_no_more() {
    let mut fixture = fixture();
    let page = fixture.known();
    assert_eq!(fixture.kinds(page), ["layout", "authority", "state"]);
    // Two pictures before it looks: it is shown the second one.
    for step in [1001, 1002] {
        let text = json!({"kind": "state", "step": step}).to_string();
        fixture.pages.show(CellSnapshot { text: Some(text.into()), ..CellSnapshot::default() });
    }
    assert!(fixture.pages.has_news());
    fixture.settle();
    assert_eq!(fixture.next(page), Some(json!({"kind": "state", "step": 1002})));
    fixture
        .pages
        .show(CellSnapshot { over: Some("the cell has ended".to_owned()), ..CellSnapshot::default() });
    fixture.settle();
    assert_eq!(fixture.next(page), Some(json!({"kind": "over", "text": "the cell has ended"})));
    assert_eq!(fixture.next(page), None);
}

#[test]
fn of_the_notes_that_a_page_does_not_take_the_oldest_are_dropped() {
    let mut fixture = fixture();
    let page = fixture.known();
    fixture.stuck.push(page);
    fixture.pages.show(shown(&fixture.looks));
    fixture.settle();
    fixture.kinds(page);
    for _ in 0..20 {
        // Each comes and goes.
        let other = fixture.known();
        fixture.hear(other, PageEvent::Closed);
    }
    fixture.stuck.clear();
    fixture.pages.sent(page);
    fixture.settle();
    let notes: Vec<_> = std::iter::from_fn(|| fixture.next(page)).map(|note| note["text"].clone()).collect();
    assert_eq!(notes.len(), 32);
    assert_eq!((&notes[0], &notes[31]), (&json!("page 6 looks on"), &json!("page 21 is gone")));
}

#[test]
fn what_a_run_showed_that_is_over_is_answered_and_nothing_of_it_is_operated() {
    let mut history = RunHistory::of(&{
        use mrroc::prelude::*;
        use mrroc_robots::SimulatedIrp6;
        let start = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
        let arm = RobotSetup::new("arm", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &start));
        Cell::new(Duration::from_millis(2)).robot(arm).layout()
    });
    let six = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0];
    for step in 0..100 {
        let (time, tool) = (20_000_000 * step, mrroc_core::pose::Pose::identity());
        history.robot(time, "arm", [&six, &six], [tool, tool]);
        history.step(time, &StepRecord { step, dt: 0.02, duration: 0.02, ..StepRecord::default() });
    }
    let lasts = history.lasts();
    let mut fixture = of_history(Some(Box::new(history)));
    let page = fixture.known();
    assert_eq!(fixture.next(page).expect("the layout")["lasts"], json!(lasts));
    assert_eq!(fixture.kinds(page), ["authority"]);
    fixture.say(page, &json!({"n": 1, "do": "frame", "at": 1.0, "minute": true}));
    let state = fixture.next(page).expect("a moment");
    assert_eq!(state["kind"], "state");
    assert!((state["time"].as_f64().expect("a time") - 1.0).abs() < 0.021);
    assert!(state["minute"].as_array().is_some_and(|minute| minute.len() > 10));
    fixture.say(page, &json!({"do": "beat"}));
    for (n, asked, why) in [(2, "take", "there is nothing to operate"), (3, "stop", "the run is over")] {
        fixture.say(page, &json!({"n": n, "do": asked}));
        let answer = fixture.answer(page, n);
        assert!(answer["text"].as_str().is_some_and(|text| text.contains(why)), "{answer}");
        assert_eq!(answer["outcome"], "refused");
    }
    assert!(fixture.asked.is_empty() && fixture.closed.is_empty());
}
