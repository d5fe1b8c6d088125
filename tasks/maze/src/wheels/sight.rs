//! What the base's sensor tells the coordinator: a wall in its way is to it what a touch is to an arm.

use mrroc::robot::RobotImage;
use mrroc_wheels::DiffDrive;
use mrroc_wheels::sensing::{Lookout, Sight};
use nalgebra::Vector2;

use crate::feeling::{Feeling, Seen, Stretch, Touch};

impl Feeling<DiffDrive> for Lookout {
    fn touch(sight: &Sight) -> Touch {
        // Where the body's middle would be if it went on until it touched: what it would touch may be beside its path.
        let met = Vector2::new(sight.x, sight.y);
        let seen = sight.pose.seen(&met);
        let reach = (DiffDrive::BODY * DiffDrive::BODY - seen.y * seen.y).max(0.0).sqrt();
        let middle = sight.pose.place(&Vector2::new(seen.x - reach, 0.0));
        let at = met - (met - middle).normalize() * DiffDrive::BODY;
        // It never touches.
        Touch { touching: false, touches: sight.blocked, x: at.x, y: at.y, since: 0.0 }
    }

    fn met(sight: &Sight) -> Option<Vector2<f64>> {
        Some(Vector2::new(sight.x, sight.y))
    }

    fn place(sight: &Sight, _: &RobotImage<DiffDrive>) -> Vector2<f64> {
        sight.pose.at()
    }

    fn seen(sight: &Sight) -> Seen {
        core::array::from_fn(|i| {
            let face = sight.faces.get(i).filter(|_| i < usize::from(sight.count))?;
            Some(Stretch { ends: face.ends(), into: face.direction() })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_map::{Knowledge, Map};
    use mrroc_wheels::Planar;

    #[test]
    fn a_wall_that_lies_beside_the_path_is_told_as_the_one_that_it_is() {
        // Up and to the left, more to the left, below a level wall: what it would touch is above it.
        let pose = Planar { x: 1.979, y: 0.279, heading: 2.531 };
        let sight = Sight { pose, x: 1.947, y: 0.354, blocked: 1, ..Sight::default() };
        let touch = <Lookout as Feeling<DiffDrive>>::touch(&sight);
        let ball = Vector2::new(touch.x, touch.y);
        let met = <Lookout as Feeling<DiffDrive>>::met(&sight).expect("it knows the place");
        // It touches there: a radius away, and its middle is on its path.
        assert!(((met - ball).norm() - DiffDrive::BODY).abs() < 1e-12);
        assert!(pose.seen(&ball).y.abs() < 1e-12 && pose.seen(&ball).x > 0.0, "{ball}");
        let known = Knowledge {
            size: [2.88; 2],
            radius: DiffDrive::BODY,
            thickness: 0.012,
            passage: 0.15,
            wall: 0.18,
        };
        let contact = Map::new(known).meet(&ball, &met, &Vector2::new(-0.82, 0.57));
        assert_eq!(contact.into, Vector2::y());
    }
}
