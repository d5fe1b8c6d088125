//! The robots: each adds what is ordered to where it was.

use mrroc::prelude::*;
use nalgebra::Translation3;

use crate::arm::Arm;
use crate::orders::Lift;

/// Gives both robots the same program.
pub fn programs(cell: Cell) -> Cell {
    cell.ecp("left", arm).ecp("right", arm)
}

fn arm(ecp: &mut Ecp<Arm>) -> Result<(), Fault> {
    ecp.serve_all(|ecp, _: Lift| ecp.move_robot((), Follow { from: Pose::identity() }).map(drop))
}

struct Follow {
    from: Pose,
}

#[generator(ecp, first = begin)]
fn follow(order: &Order<Lift>, c: &mut Follow) -> Step<Arm> {
    let up = Translation3::new(0.0, 0.0, order.value().height);
    Step::Next(Demand::pose(up * c.from))
}

fn begin(order: &Order<Lift>, c: &mut Follow, e: &State<Arm>) -> Step<Arm> {
    c.from = e.demanded().pose;
    follow(order, c)
}
