//! Bounds, the table, and what is in the file.

use super::*;
use crate::chosen::By;

fn chosen(value: f64) -> Chosen {
    Chosen { least: value, greatest: value, by: By::Default, limited: 0 }
}

fn summary() -> Summary {
    let deviation = PathDeviation {
        max_mm: Bounded { value: 0.004, limit: 0.01 },
        rms_mm: Bounded { value: 0.001, limit: 0.01 },
        worst_at_mm: [1.0, 2.0],
        points: 100,
        excepted: 0,
    };
    Summary {
        source: "a.svg".to_owned(),
        strokes: 3,
        cut_length_mm: 100.0,
        travel_length_mm: 20.0,
        drawing_size_mm: [50.0, 30.0],
        depth_mm: chosen(0.3),
        feed_mm_per_s: Chosen { by: By::File, ..chosen(8.0) },
        travel_height_mm: chosen(2.0),
        samples: 60,
        steps: 5000,
        step_s: 0.002,
        simulated_s: 10.0,
        wall_s: 0.01,
        demanded: deviation,
        executed: deviation,
        joints: vec![JointPeaks { joint: "2".to_owned(), velocity_share: 0.4, acceleration_share: 0.6 }],
        plate_height: Some(PlateHeight { found_mm: 12.001, true_mm: 12.0, limit_mm: 0.01 }),
        broken: Vec::new(),
        passed: false,
    }
}

#[test]
fn a_run_within_its_bounds_passes() {
    let checked = summary().checked();
    assert!(checked.passed && checked.broken.is_empty());
    assert!(checked.table().contains("1000 x real time"));
    assert!(!checked.table().contains("FAIL"));
}

#[test]
fn each_broken_bound_is_named() {
    let mut run = summary();
    run.executed.max_mm.value = 0.02;
    run.joints[0].velocity_share = 1.2;
    run.plate_height = Some(PlateHeight { found_mm: 13.0, true_mm: 12.0, limit_mm: 0.01 });
    let checked = run.checked();
    assert!(!checked.passed);
    assert_eq!(checked.broken.len(), 3, "{:?}", checked.broken);
    assert!(checked.table().contains("joint 2: velocity at 120 % of its limit"));
}

#[test]
fn a_deviation_that_is_no_number_fails() {
    let mut run = summary();
    run.demanded.max_mm.value = f64::NAN;
    assert!(!run.checked().passed);
}

#[test]
fn what_the_file_chose_is_in_the_summary_and_defaults_are_in_the_table_alone() {
    let checked = summary().checked();
    assert!(checked.table().contains("depth              0.3 mm, by default"), "{}", checked.table());
    assert!(checked.table().contains("feed               8 mm/s, from the file"));
    let json = serde_json::to_value(&checked).unwrap();
    assert_eq!(json["feed_mm_per_s"]["by"], "file");
    assert!(json.get("depth_mm").is_none() && json.get("travel_height_mm").is_none());
}
