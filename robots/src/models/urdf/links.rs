//! A chain as what its motors drive: its links, a tree of bodies whose weight loads them.

use mrroc::pose::Pose;
use mrroc::robot::Measured;
use nalgebra::{SMatrix, SVector, Vector3};

use super::chain::Segment;
use super::drives::{ROTOR, efforts};
use super::serial::Serial;
use crate::dynamics::{self, Tree};
use crate::models::drives::{Driven, MotorData, MotorLimits, Shafts};

impl<const N: usize> Driven<N> for Serial<N> {
    fn motor_data(&self) -> &[MotorData; N] {
        &self.drives.motors
    }

    fn motor_limits(&self) -> &MotorLimits<N> {
        &self.drives.limits
    }

    /// The links between base and tip, mimic joints too.
    fn tree(&self) -> Option<Tree<N>> {
        // The first segment has the base in it.
        let base =
            self.segments.first().map_or_else(Pose::identity, |first| first.X_before * self.X_BJ.inverse());
        let segments = self.segments.iter().zip(&self.drives.bodies).enumerate();
        let segments = segments.map(|(i, (segment, body))| dynamics::Segment {
            name: self.name_of(i, segment),
            parent: i.checked_sub(1),
            X_PJ: if i == 0 { self.X_BJ } else { segment.X_before },
            kind: segment.kind,
            axis: Vector3::z(),
            coordinate: segment.leader,
            multiplier: segment.multiplier,
            offset: segment.offset,
            body: body.load(),
        });
        Tree::new(base, segments.collect(), self.X_tip).ok()
    }

    fn positions(&self, angles: &SVector<f64, N>) -> SVector<f64, N> {
        angles.component_div(&self.drives.gears)
    }

    fn ratios(&self, _angles: &SVector<f64, N>) -> SMatrix<f64, N, N> {
        SMatrix::from_diagonal(&self.drives.gears.map(f64::recip))
    }

    /// The rotor that every motor was given beside its load.
    fn rotors(&self) -> SVector<f64, N> {
        SVector::repeat(ROTOR)
    }

    fn motors(&self, q: &SVector<f64, N>) -> SVector<f64, N> {
        q.component_mul(&self.drives.gears)
    }

    fn shafts(&self, angles: &SVector<f64, N>, speeds: &SVector<f64, N>) -> Shafts<N> {
        let gears = &self.drives.gears;
        let position = angles.component_div(gears);
        let loads = efforts(&self.segments, &self.drives.bodies, &position).component_div(gears);
        Shafts { joints: Measured { position, velocity: speeds.component_div(gears) }, loads }
    }
}

impl<const N: usize> Serial<N> {
    /// The name of its coordinate, for the first segment that moves as that does; else one made of it.
    fn name_of(&self, i: usize, segment: &Segment) -> String {
        let name = self.movers.get(segment.leader).map_or("joint", |mover| mover.name.as_str());
        let leads =
            |one: &Segment| one.leader == segment.leader && one.multiplier == 1.0 && one.offset == 0.0;
        let is_taken = self.segments.iter().take(i).any(leads);
        if leads(segment) && !is_taken { name.to_owned() } else { format!("{name}_follower_{}", i + 1) }
    }
}
