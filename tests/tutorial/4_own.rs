//! Chapter 4 of the tutorial: a copied generator in the place of the template's own, as it is and changed.

#[path = "4_own/ecp.rs"]
mod ecp;

use super::support::{ONE, extent, file, watched};
use crate::arm;

#[test]
fn the_changed_copy_bends_by_two_centimetres() {
    let cell = ecp::programs(file(ONE).cell(&arm::kinds()).expect("known"));
    let (cell, paths) = watched(cell);
    cell.run().expect("within the limits");
    let (low, high) = extent(&paths, "arm", 2);
    assert!(low > -1e-3 && (high - 0.1).abs() < 1e-3, "{low} {high}");
    // 0.08 s (1 - s) is 0.02 m at s = 1/2.
    let aside = [0, 1].map(|axis| extent(&paths, "arm", axis));
    let widest = aside.iter().map(|(low, high)| high.max(-low)).fold(0.0, f64::max);
    assert!((widest - 0.02).abs() < 1e-3, "{aside:?}");
}
