//! A picture in the plant that takes nothing of what the processes show it disturbs none of them.

use mrroc_tests::fixture::TAKES_NOTHING;

use crate::launch::Place;
use crate::runs::{ROBOTS, VIRTUAL};

pub const WARNING: &str = "warning: the picture does not get all that the processes have shown";

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
