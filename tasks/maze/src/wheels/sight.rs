//! What the base's sensor tells the coordinator: a wall in its way is to it what a touch is to an arm.

use mrroc::robot::RobotImage;
use mrroc_wheels::DiffDrive;
use mrroc_wheels::sensing::{Lookout, Sight};
use nalgebra::Vector2;

use crate::feeling::{Feeling, Seen, Stretch, Touch};

impl Feeling<DiffDrive> for Lookout {
    fn touch(sight: &Sight) -> Touch {
        // Where the body's middle would be if it touched: a radius from the wall, which is the one that it would meet more squarely.
        let (sine, cosine) = sight.pose.heading.sin_cos();
        let into = if cosine.abs() > sine.abs() {
            Vector2::new(cosine.signum(), 0.0)
        } else {
            Vector2::new(0.0, sine.signum())
        };
        let at = Vector2::new(sight.x, sight.y) - into * DiffDrive::BODY;
        // It never touches.
        Touch { touching: false, touches: sight.blocked, x: at.x, y: at.y, since: 0.0 }
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
