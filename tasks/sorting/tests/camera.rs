//! With the camera: recognition, places, grasps. A share of what `just sorting-camera` tries.

use std::cell::Cell;
use std::rc::Rc;

use mrroc::observe::Observation;
use mrroc_sensors::aggregation::Vision;
use sorting::camera::gap::Things;
use sorting::camera::kinds::{KINDS, classes};
use sorting::camera::layout::camera;
use sorting::camera::misses::Missed;
use sorting::camera::picture::{read, write};
use sorting::camera::run::network;
use sorting::camera::settings::{Overhead, Settings};
use sorting::camera::studio::{Trial, examine};
use sorting::camera::summary::{Confusion, Line, Table, examination};
use sorting::monitor::Fate;
use sorting::places::{CLOSED, HIGH};
use sorting::summary::quantile;

/// So many parts and strangers that no training has seen.
fn parts_are_recognised(count: usize) {
    let classifier = Box::new(network().expect("a network"));
    let trials = examine(count, 2_000_000, 6, classifier, |_, _| ()).expect("light");
    println!("{}", examination(&trials));
    let counts = Confusion::of(&trials);
    let [right, misnamed, rejected] = counts.counts();
    assert_eq!(misnamed, 0, "misnamed");
    assert!(f64::from(right) >= 0.998 * f64::from(right + rejected), "{right} right, {rejected} rejected");
    // Not one stranger has a name.
    let row = counts.0[KINDS];
    assert!(row[KINDS] > 0 && row[..KINDS].iter().all(|count| *count == 0), "{row:?}");
    let of = |value: fn(&Trial) -> f64| {
        quantile(&trials.iter().filter(|trial| trial.taken.is_some()).map(value).collect::<Vec<_>>(), 0.95)
    };
    let (off, turned) = (of(|trial| trial.off), of(|trial| trial.turned).to_degrees());
    assert!(off <= 5e-4 && turned <= 0.5, "{off} m, {turned} deg");
}

#[test]
fn parts_that_no_training_has_seen_are_recognised_and_strangers_rejected() {
    parts_are_recognised(48);
}

#[test]
fn images_in_files_are_evaluated_as_those_in_memory() {
    let folder = std::env::temp_dir().join(format!("mrroc-sorting-images-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let (mut images, mut wanted) = (Vec::new(), Vec::new());
    examine(4, 77, 0, Box::new(network().expect("a network")), |image, found| {
        images.push(image.to_vec());
        wanted.push(found.to_vec());
    })
    .expect("light");
    let plane = camera();
    let size = plane.camera.size;
    let mut vision = Vision::new(plane, classes(), Box::new(network().expect("a network")));
    for (number, (image, wanted)) in images.iter().zip(&wanted).enumerate() {
        let file = folder.join(format!("{number}.png"));
        write(&file, image, size).expect("written");
        let image = read(&file, size).expect("read");
        if number == 0 {
            vision.teach(&image).expect("light");
        } else {
            assert_eq!(&vision.look(&image).expect("light"), wanted);
            assert!(!wanted.is_empty());
        }
        let wrong = read(&file, [640, 480]).expect_err("another size").to_string();
        assert!(wrong.contains("768 x 576") && wrong.contains("640 x 480"), "{wrong}");
    }
    std::fs::remove_dir_all(&folder).expect("removed");
}

/// So many parts at each speed \[m/s\].
fn parts_go_to_their_bins(parts: usize, speeds: &[f64]) {
    for &speed in speeds {
        let settings = Settings::of(speed, parts, Settings::CYCLE / 0.6, 4);
        let outcome = settings.run().expect("a cell");
        let line = Line::of(&settings, &outcome);
        println!("{}", Table(vec![line.clone()]));
        assert!(outcome.report.is_ok(), "{:?}", outcome.report);
        assert_eq!(
            (outcome.count(Fate::Sorted), line.wrong, line.crashes),
            (parts, 0, 0),
            "{:?}",
            line.missed
        );
        let [place, angle, off] =
            [&line.places, &line.angles, &line.off].map(|values| quantile(values, 0.95));
        assert!(place <= 5e-4 && angle.to_degrees() <= 0.5, "place {place} m, angle {angle} rad");
        assert!(off <= 1e-3, "{off} m off the middle");
    }
}

#[test]
fn parts_seen_by_the_camera_go_to_the_bins_of_their_kinds() {
    parts_go_to_their_bins(5, &[0.1]);
}

mod whole {
    #[test]
    #[ignore = "takes minutes: `just sorting-whole`"]
    fn parts_that_no_training_has_seen_are_recognised_and_strangers_rejected() {
        super::parts_are_recognised(2400);
    }

    #[test]
    #[ignore = "takes minutes: `just sorting-whole`"]
    fn parts_seen_by_the_camera_go_to_the_bins_of_their_kinds() {
        super::parts_go_to_their_bins(500, &[0.05, 0.1, 0.15]);
    }
}

#[test]
fn the_same_seed_gives_the_same_run_with_the_camera_to_the_bit() {
    let settings = Settings::of(0.12, 1, 10.0, 9);
    let [one, two] = [(), ()].map(|()| settings.run().expect("a cell"));
    assert!(!one.grips.is_empty() && (one.grips, one.looks) == (two.grips, two.looks));
}

/// The second of two parts, a step, is lifted at the far end of the window, and the straight line to its bin leads too near to the column.
#[test]
fn a_part_is_carried_past_the_column_where_the_arm_cannot_go_straight_to_the_bin() {
    let settings = Settings::of(0.1, 2, 1.0, 491);
    let outcome = settings.run().expect("a cell");
    assert!(outcome.report.is_ok(), "{:?}", outcome.report);
    assert_eq!((outcome.count(Fate::Sorted), outcome.crashes), (2, 0), "{:?}", outcome.fates);
}

/// Arms that may go on for ten seconds before they brake can go nowhere within their limits.
#[test]
fn fault_341_a_part_that_the_arm_cannot_bring_to_its_bin_is_put_back_and_missed_with_its_reason() {
    for arms in [1, 2] {
        let settings = Settings { noticing: Some(10.0), ..Settings::of(0.1, 3, 13.3, 5) }.by(arms);
        let outcome = settings.run().expect("a cell");
        assert!(outcome.report.is_ok(), "{:?}", outcome.report);
        let why: Vec<_> = outcome.misses(arms).into_iter().map(|miss| miss.why).collect();
        assert_eq!((why, outcome.crashes), (vec![Missed::NoPath; 3], 0), "{arms} arms");
        // Each was in the hand once: then it is on the belt, and not in the hand any more.
        assert_eq!((outcome.grips.len(), outcome.stranded.len()), (3, 3), "{:?}", outcome.grips);
    }
}

/// The belt stops when a part has just been gripped, and another one lies below it or upstream of that place: no gap comes.
#[test]
fn fault_341_a_part_for_which_no_gap_comes_on_a_belt_that_stands_stops_the_cell_and_stays_in_the_hand() {
    for arms in [1, 2] {
        let settings =
            Settings { noticing: Some(10.0), regular: 0.0, ..Settings::of(0.1, 8, 3.0, 5) }.by(arms);
        let first = settings.run().expect("a cell").grips[0];
        let stop = vec![(first.time + 0.5, 0.0)].leak();
        let ready = Settings { profile: stop, ..settings }.ready().expect("a cell");
        let world = ready.plant.world.clone();
        let outcome = ready.run();
        let fault = outcome.report.as_ref().expect_err("no gap").to_string();
        assert!(fault.contains("no gap of the belt came"), "{arms} arms: {fault}");
        // 120 s after it was lifted, which takes two seconds at most; then all stop within another one.
        let waited = world.time() - first.time;
        assert!((120.0..123.0).contains(&waited), "{arms} arms: {waited} s");
        let part = world.body_of(first.part).expect("it is in no sink").pose.translation;
        assert!(part.z > 0.5 * HIGH, "{arms} arms: {part}");
        assert_eq!((outcome.count(Fate::Wrong), outcome.crashes), (0, 0), "{arms} arms");
    }
}

/// In runs where parts follow each other closely and none can be brought to its bin: how many were put back, and how near another part was
/// then, along the belt \[m\].
fn put_back_where_parts_are_close(settings: &Settings) -> (usize, f64) {
    let mut ready = settings.ready().expect("a cell");
    let nearest = Rc::new(Cell::new((0, f64::INFINITY)));
    let (seen, world) = (nearest.clone(), ready.plant.world.clone());
    let mut held = [None; 2];
    let observer = move |observation: &Observation<'_>| {
        let Some(arm) = ["hand", "hand-2"].iter().position(|hand| *hand == observation.robot) else { return };
        let Some(hand) = world.hand(arm) else { return };
        let is_closed = observation.demanded[0] < CLOSED + 2e-4;
        let now = hand.gripped().map(|touch| touch.body).filter(|_| is_closed);
        let before = core::mem::replace(&mut held[arm], now);
        let along = |part: usize| world.body_of(part).map(|body| body.pose.translation.y);
        if let (Some(part), None) = (before, now)
            && let Some(at) = along(part)
        {
            let others = (0..world.bodies()).filter(|other| *other != part).filter_map(along);
            let (count, least) = seen.get();
            seen.set((count + 1, others.map(|other| (other - at).abs()).fold(least, f64::min)));
        }
    };
    ready.cell = ready.cell.watch(observer);
    let outcome = ready.run();
    assert!(outcome.report.is_ok(), "{:?}", outcome.report);
    assert_eq!((outcome.count(Fate::Wrong), outcome.crashes), (0, 0), "{settings:?}");
    nearest.get()
}

/// At 0.1 m/s parts are 0.2 m apart and more here: the arm's own place is filled by the next one while it lifts a part.
#[test]
fn fault_341_a_part_is_put_back_into_a_gap_of_the_belt_and_not_onto_one_that_follows() {
    for (arms, overhead) in [(1, Overhead::Camera), (2, Overhead::Camera), (1, Overhead::Matrix)] {
        for seed in [5, 6] {
            let settings = Settings { noticing: Some(10.0), regular: 0.0, ..Settings::of(0.1, 8, 3.0, seed) };
            let (count, nearest) = put_back_where_parts_are_close(&settings.below(overhead).by(arms));
            println!("{arms} arms, {overhead:?}, seed {seed}: {count} put back, {nearest:.3} m from others");
            // Bodies: their middles are up to 10 mm off their frames on either side.
            assert!(
                count > 0 && nearest > Things::APART - 0.02,
                "{arms} arms, {overhead:?}, seed {seed}: {nearest} m"
            );
        }
    }
}
