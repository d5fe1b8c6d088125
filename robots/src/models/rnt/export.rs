//! RNT as a URDF: its open tree, with the loops that a URDF cannot say in a comment.

use mrroc::robot::{Robot, Tool};

use super::linkage::{CRANK, FOOT2, FOOT3, Foot, ROCKER, ROD, TAIL};
use super::masses::{OPEN, Posture};
use super::{A1, D1, Rnt};
use crate::models::urdf::export::{Coordinate, coordinates, notes, written};
use crate::models::vectors::Six;

/// Steps of the grid of the actuators' lengths on which ranges are looked for.
const STEPS: u32 = 40;

impl Rnt {
    pub(super) fn exported(&self, name: &str, tool: &Tool) -> Option<String> {
        let tree = self.open_tree()?;
        let own = coordinates(self);
        let limits = self.limits();
        let passive = Coordinate {
            lower: f64::INFINITY,
            upper: f64::NEG_INFINITY,
            velocity: 0.0,
            effort: 0.0,
            damping: 0.0,
            friction: 0.0,
        };
        let mut open = [passive; OPEN];
        for i in [0, 3, 4, 5] {
            open[i] = own[i];
        }
        let part = |i: usize, k: u32| {
            limits.lower[i] + (limits.upper[i] - limits.lower[i]) * f64::from(k) / f64::from(STEPS)
        };
        for (a, b) in (0..=STEPS).flat_map(|a| (0..=STEPS).map(move |b| (a, b))) {
            let q = Six::new(0.0, part(1, a), part(2, b), 0.0, 0.0, 0.0);
            let closes = self.check_coupled(&q, &q, 1.0).is_ok();
            let Some((posture, _)) = Posture::at(&q).filter(|_| closes) else { continue };
            for i in [1, 2, 6, 7] {
                let speed =
                    posture.rates.row(i).iter().zip(limits.velocity.iter()).map(|(g, v)| (g * v).abs()).sum();
                open[i].lower = open[i].lower.min(posture.s[i]);
                open[i].upper = open[i].upper.max(posture.s[i]);
                open[i].velocity = open[i].velocity.max(speed);
            }
        }
        let foot = |Foot { distance, cosine, sine }: Foot| {
            format!("({} 0 {})", A1 + distance * cosine, D1 + distance * sine)
        };
        let mut told = vec![
            "Closed loops, cut here; all in the plane x-z of the link `column_link` [m]:".to_owned(),
            format!("  ({ROD} 0 0) of `rod_link` is joined to ({} 0 0) of `forearm_link`;", -TAIL),
            format!("  actuator 2, of length q2, joins {} of `column_link` to ({CRANK} 0 0) of `upper_arm_link`;", foot(FOOT2)),
            format!("  actuator 3, of length q3, joins {} of `column_link` to ({ROCKER} 0 0) of `rocker_link`.", foot(FOOT3)),
            "  The robot's joints are q1 (`column`), q2, q3, q4 (`wrist_4`), q5 (`wrist_5`), q6 (`flange_6`). `upper_arm`, `forearm`, `rocker`".to_owned(),
            "  and `rod` have no motor: q2 and q3 determine them, within the ranges written, which they do not take independently.".to_owned(),
            format!("  q2 is {} to {} m, q3 {} to {} m, each at most {} m/s.", limits.lower[1], limits.upper[1], limits.lower[2], limits.upper[2], limits.velocity[1]),
            format!("  The sine of the angle at which rods and actuators drive their links stays above {}.", Self::TRANSMISSION),
        ];
        told.extend(notes(self));
        Some(written(name, &tree, &open, tool, &told))
    }
}
