//! A picture in the plant that takes nothing of what the processes show it disturbs none of them.

use mrroc_tests::fixture::TAKES_NOTHING;

use crate::launch::Place;
use crate::runs::{REAL, ROBOTS, VIRTUAL, is_late};

const WARNING: &str = "warning: the picture does not get all that the processes have shown";

#[test]
fn a_picture_that_stands_still_changes_no_demand() {
    let place = Place::new(47);
    let mut usual = place.start("usual", VIRTUAL);
    assert!(usual.end().success(), "{}", usual.said());
    let mut still = place.start_with(&[(TAKES_NOTHING, "")], "still", VIRTUAL);
    assert!(still.end().success(), "{}", still.said());
    assert!(still.said().contains(WARNING), "{}", still.said());
    for robot in ROBOTS {
        let record = usual.record(robot);
        assert!(record.len() > 1750, "{}", record.len());
        assert_eq!(record, still.record(robot), "{robot}");
    }
    still.assert_nothing_left(&[]);
}

#[test]
fn a_picture_that_stands_still_stops_no_cell_in_real_time() {
    let place = Place::new(48);
    let mut launch = place.start_with(&[(TAKES_NOTHING, "")], "still", REAL);
    let status = launch.end().code();
    let said = launch.said();
    // A machine without a real-time scheduler may be late, with a picture or without.
    assert!(status == Some(0) && said.contains(WARNING) || status == Some(1) && is_late(&said), "{said}");
    launch.assert_nothing_left(&[]);
}
