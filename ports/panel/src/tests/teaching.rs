//! What pages ask of taught poses.

use mrroc_core::operator::Request;
use mrroc_core::operator::button::Button;
use mrroc_core::robot::Robot;
use serde_json::{Value, json};

use super::pages::{Fixture, fixture};
use super::*;
use crate::poses::Poses;
use crate::teaching::WorkOutcome;

#[test]
fn fault_240_while_the_file_of_the_poses_does_not_answer_a_stop_and_holds_are_taken() {
    let mut fixture = fixture();
    let page = fixture.known();
    fixture.say(page, &json!({"n": 1, "do": "take"}));
    assert_eq!(fixture.request(), Some(Request::Take));
    for n in 2..30 {
        fixture.say(page, &json!({"n": n, "do": "path", "robot": "arm", "name": "pick"}));
    }
    // Sixteen wait for the files; those that are too many are refused.
    assert_eq!(fixture.work.len(), 16);
    let refused = fixture.answer(page, 18);
    assert!(refused["text"].as_str().is_some_and(|why| why.contains("do not answer")), "{refused}");
    fixture.say(page, &json!({"n": 40, "do": "hold", "begins": true, "epoch": 0, "step": 1000}));
    assert!(matches!(fixture.request(), Some(Request::Press(Button::Hold(_)))));
    fixture.say(page, &json!({"n": 41, "do": "stop"}));
    assert_eq!(fixture.request(), Some(Request::Press(Button::Stop)));
    // They answer: the first one that waited is told, and another one may ask.
    let (to, ..) = fixture.work.pop_front().expect("it waits");
    fixture.pages.worked(to, Ok(WorkOutcome::ToolPath(vec![[1.0, 2.0, 3.0]])), None);
    fixture.settle();
    let path = fixture.answer(page, 2);
    assert_eq!(
        path,
        json!({"kind": "answer", "n": 2, "outcome": "done", "text": "", "path": [[1.0, 2.0, 3.0]]})
    );
    for n in 50..52 {
        fixture.say(page, &json!({"n": n, "do": "path", "robot": "arm", "name": "pick"}));
    }
    assert_eq!(fixture.work.len(), 16);
}

#[test]
fn a_page_teaches_a_robot_that_stands_and_is_shown_the_path_to_what_it_taught() {
    let folder = std::env::temp_dir().join(format!("mrroc-panel-poses-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let (home, there) =
        (Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0), Six::new(0.4, -1.5, 0.1, -0.1, 4.6, 0.3));
    let mut fixture = fixture();
    fixture.poses = Some(Poses::of(&folder.join("cell.toml")));
    let show = |fixture: &mut Fixture, joints: Six, moves: bool| {
        let robots = [robot_at(joints)].into();
        let shown = shown(&fixture.looks);
        fixture.pages.show(CellSnapshot { robots, moves, ..shown });
    };
    let page = fixture.known();
    fixture.say(page, &json!({"n": 1, "do": "take"}));
    assert_eq!(fixture.answer(page, 1)["outcome"], "done");
    let ask = |fixture: &mut Fixture, n: u64, message: &Value| {
        let mut message = message.clone();
        message["n"] = json!(n);
        (message["epoch"], message["step"]) = (json!(0), json!(1000));
        fixture.say(page, &message);
        fixture.answer(page, n)
    };
    let teach = json!({"do": "teach", "robot": "arm", "name": "pick"});
    show(&mut fixture, there, true);
    assert!(
        ask(&mut fixture, 2, &teach)["text"]
            .as_str()
            .is_some_and(|why| why.contains("let them come to rest"))
    );
    show(&mut fixture, there, false);
    assert_eq!(ask(&mut fixture, 3, &teach)["outcome"], "done");
    show(&mut fixture, home, false);
    // Straight in joint space: as the generator goes.
    let path = ask(&mut fixture, 4, &json!({"do": "path", "robot": "arm", "name": "pick"}));
    let places = path["path"].as_array().expect("places");
    for (i, place) in places.iter().enumerate() {
        let share = i as f64 / (places.len() - 1) as f64;
        let tool = Irp6::nominal().forward(&(home + (there - home) * share)).translation.vector;
        let off = (0..3).map(|k| (place[k].as_f64().expect("a number") - tool[k]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{i}: {place} {tool}");
    }
    assert_eq!(
        ask(&mut fixture, 5, &json!({"do": "rename", "robot": "arm", "name": "pick", "to": "place"}))["outcome"],
        "done"
    );
    assert_eq!(
        ask(&mut fixture, 6, &json!({"do": "path", "robot": "arm", "name": "pick"}))["outcome"],
        "refused"
    );
    let taught = mrroc_generators::teach::Taught::read(&folder.join("poses/arm.txt")).expect("in order");
    assert_eq!(taught.select(&["place"]).expect("there").poses[0].coordinates(), there.as_slice());
    assert_eq!(
        ask(&mut fixture, 7, &json!({"do": "forget", "robot": "arm", "name": "place"}))["outcome"],
        "done"
    );
    std::fs::remove_dir_all(&folder).expect("removed");
}
