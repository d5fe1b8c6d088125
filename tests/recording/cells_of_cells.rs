//! Recordings of cells of cells: one file has what all cells show.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use mrroc::cell::LowerCell;
use mrroc::prelude::*;
use mrroc::recording::{CutOff, Replay};
use mrroc_tests::{Gantry, MS, gantry};
use serde_json::json;

use crate::recording::contents::{Message, read};
use crate::runtime::lower_cells::{Job, lower};

/// One job for both cells.
struct Both(Job);

#[generator(mp)]
fn both(c: &mut Both) -> Always<(LowerCell, LowerCell), Job> {
    Always((c.0, c.0))
}

/// Two cells of two gantries each, under one that has a gantry of its own, which shares its name with theirs.
fn plant() -> Cell {
    let plant =
        Cell::new(4 * MS).robot(gantry("g0").0).cell("press", lower::<2>().0).cell("paint", lower::<2>().0);
    plant.program(|mp| {
        let (mut press, mut paint) = (mp.robot::<LowerCell>("press")?, mp.robot::<LowerCell>("paint")?);
        let own = mp.robot::<Gantry>("g0")?;
        mp.move_robots((&mut press, &mut paint), (), Both(Job::Go { end: 0.2, seconds: 0.5 }))?;
        drop(own);
        Ok(())
    })
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

#[test]
fn the_recording_of_a_plant_has_all_cells_on_one_clock_and_each_robot_by_its_name_in_the_plant() {
    let file = file("plant.mcap");
    plant().record(mrroc::recording::to(&file)).run().expect("keeps the limits");
    let (_, messages) = read(&file);
    let topics: BTreeSet<_> = messages.iter().map(|message| message.topic.as_str()).collect();
    let of = |topic: &str| -> Vec<&Message> {
        let found: Vec<_> = messages.iter().filter(|message| message.topic == topic).collect();
        assert!(!found.is_empty(), "nothing about {topic}: {topics:?}");
        found
    };
    // The order of the upper MP, to each cell, in its own steps of 4 ms.
    for cell in ["press", "paint"] {
        let orders = of(&format!("/robots/{cell}/orders/Job"));
        assert!(
            orders.iter().all(|order| {
                order.time % 4_000_000 < 1_000_000
                    && order.body["order"]["Go"] == json!({"end": 0.2, "seconds": 0.5})
            }),
            "{:?}",
            orders.first()
        );
        // What its own MP orders, and begins.
        of(&format!("/robots/{cell}.g1/orders"));
        let motions = of(&format!("/cells/{cell}/instructions"));
        assert_eq!(motions[0].body["process"], json!(format!("mp {cell}")));
        // Each cell counts its own steps, of 1 ms, on the clock of all.
        for step in of(&format!("/cells/{cell}/steps")) {
            assert_eq!(step.body["step"], json!(step.time / 1_000_000));
        }
        for robot in ["g0", "g1"] {
            let last = of(&format!("/robots/{cell}.{robot}")).pop().expect("some");
            // It was told to go to 0.2 m, and may stop a round-off beside it.
            let x = last.body["measured"]["joints"][0].as_f64().expect("a number");
            assert!((x - 0.2).abs() < 1e-9, "{cell}.{robot}: {x}");
        }
    }
    for step in of("/steps") {
        assert_eq!(step.body["step"], json!(step.time / 4_000_000));
    }
    // The plant's own gantry, which has a name that those of the cells have in theirs, has not moved.
    assert!(of("/robots/g0").iter().all(|image| image.body["measured"]["joints"][0] == json!(0.0)));
    let about = about(&file);
    assert_eq!(
        about,
        json!([{"name": "press", "step_ns": 1_000_000}, {"name": "paint", "step_ns": 1_000_000}])
    );
}

/// The lower cells that the metadata tell of.
fn about(file: &Path) -> serde_json::Value {
    let bytes = std::fs::read(file).expect("a recording");
    let summary = mcap::Summary::read(&bytes).expect("an MCAP file").expect("a summary");
    let about =
        summary.metadata_indexes.iter().find(|index| index.name == "mrroc").expect("what is recorded");
    let about = mcap::read::metadata(&bytes, about).expect("metadata");
    serde_json::from_str(&about.metadata["cells"]).expect("JSON")
}

#[test]
fn a_recording_of_a_plant_has_what_it_is_asked_for_and_is_the_same_run() {
    let (all, some) = (file("all.mcap"), file("some.mcap"));
    let report = plant().run().expect("keeps the limits");
    assert_eq!(plant().record(mrroc::recording::to(&all)).run(), Ok(report));
    let asked = mrroc::recording::to(&some).robots(["press.g1"]);
    assert_eq!(plant().record(asked).run(), Ok(report));
    let (_, messages) = read(&some);
    let robots: BTreeSet<_> = messages
        .iter()
        .filter_map(|message| message.topic.strip_prefix("/robots/")?.split('/').next())
        .collect();
    assert_eq!(robots, BTreeSet::from(["press.g1"]));
    let unknown = plant().record(mrroc::recording::to(&some).robots(["press.g7"])).run();
    let told = unknown.expect_err("no such robot").to_string();
    assert!(told.contains("asks for robot `press.g7`") && told.contains("press.g1"), "{told}");
}

#[test]
fn fault_177_what_cannot_be_recorded_or_replayed_of_cells_of_cells_is_refused_before_anything_moves() {
    let own = lower::<2>().0.record(mrroc::recording::to(file("own.mcap")));
    let plant_of = Cell::new(4 * MS).cell("press", own).program(|_| Ok(()));
    let told = plant_of.run().expect_err("its own recording").to_string();
    assert!(told.contains("cell `press`: it asks for a recording of its own"), "{told}");
    assert!(!file("own.mcap").exists());
    let recorded = file("refused.mcap");
    plant().record(mrroc::recording::to(&recorded)).run().expect("keeps the limits");
    let told = plant().replay(&recorded, CutOff::Refused).expect_err("a cell of cells").to_string();
    assert!(told.contains("a cell of cells cannot be replayed"), "{told}");
}
