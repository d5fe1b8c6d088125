//! The engraving, the transfer and a belt in the background on both links: the same demands to the bit on the memory link and as processes of the
//! operating system under the virtual clock, and the same pictures and measurements of them.

use mrroc_tests::fixture::{SEEN, TASKS};

use crate::launch::Place;

/// Two arms, two hands, a sensor of forces in each wrist.
#[test]
fn the_transfer_demands_the_same_on_both_links_to_the_bit() {
    compare(40, &["transfer"], &["rnt", "polycrank", "rnt-hand", "polycrank-hand"]);
}

/// A belt that runs in the background of an arm's Moves.
#[test]
fn a_belt_in_the_background_is_demanded_the_same_on_both_links_to_the_bit() {
    compare(46, &["belt"], &["arm", "belt"]);
}

/// A sensor that the MP and an ECP read: its picture does not tell who was heard first.
#[test]
fn a_sensor_of_two_readers_is_drawn_the_same_on_both_links_to_the_byte() {
    compare(49, &["readers"], &["arm"]);
}

/// One letter.
#[test]
fn the_engraving_demands_the_same_on_both_links_to_the_bit() {
    compare(41, &["engraving", "I"], &["irp6"]);
}

mod whole {
    #[test]
    #[ignore = "takes minutes: `just test-both-links`"]
    fn the_engraving_demands_the_same_on_both_links_to_the_bit() {
        super::compare(42, &["engraving", "nameplate"], &["irp6"]);
    }
}

/// Runs a task on both links and compares every demand of every servo period.
fn compare(test: u32, task: &[&str], robots: &[&str]) {
    let place = Place::of(test, TASKS, include_str!("cell.toml"));
    let run = |link: &str| {
        let mut launch = place.start(link, &[task, &[link]].concat());
        assert!(launch.end().success(), "{task:?} on {link}: {}", launch.said());
        launch
    };
    let (memory, processes) = (run("memory"), run("processes"));
    for robot in robots {
        let (here, apart) = (memory.record(robot), processes.record(robot));
        // Longer than the shortest motion of both tasks takes.
        assert!(here.len() > 1000, "{task:?}: {robot} has {} periods", here.len());
        let same = here.iter().zip(&apart).take_while(|(a, b)| a == b).count();
        assert!(
            here.len() == apart.len() && same == here.len(),
            "{task:?}: {robot}: {} and {} periods, the first {same} of them the same: {:?}, {:?}",
            here.len(),
            apart.len(),
            here.get(same),
            apart.get(same)
        );
        println!("{}: {robot}: {same} demands are the same to the bit", task.join(" "));
    }
    let [here, apart] = [&memory, &processes].map(|launch| launch.text(SEEN));
    assert!(
        !here.is_empty() && here == apart,
        "{task:?}: what observers see differs: {here:.2000}\n{apart:.2000}"
    );
    processes.assert_nothing_left(&[]);
}
