//! Follows a path on the floor, corrected by a sensor that tells where the base stands.

use mrroc::fault::FaultKind;
use mrroc::prelude::*;

use super::follower::{BaseLimits, Follower};
use crate::model::DiffDrive;
use crate::path::Path;
use crate::sensing::Planar;

/// Rolls along a [`Path`] from rest to rest, as fast as the wheels' limits and those of bends allow.
///
/// A unicycle cannot be put beside its path; it is turned towards it. The correction has a reserve of the wheels' limits for itself, so that
/// no demand breaks a limit, whatever is measured.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc::sensor::SensorImage;
/// use mrroc_generators::rehearsal::rehearse_with;
/// use mrroc_wheels::generators::BaseLimits;
/// use mrroc_wheels::sensing::Standing;
/// use mrroc_wheels::{Path, DiffDrive, FollowPath, Planar, Two, Whereabouts};
/// use nalgebra::Vector2;
///
/// let places = [Vector2::new(0.0, 0.0), Vector2::new(0.4, 0.0), Vector2::new(0.4, 0.4)];
/// let path = Path::through(&places, 0.03).map_err(|error| Fault::thrown(&error.to_string()))?;
/// let limits = BaseLimits { speed: 0.5, lateral: 2.0, turning: 8.0, off: 0.05 };
/// let follow = FollowPath::<Whereabouts>::along(path, limits, |read| Some(read.pose), 0.0, 1);
/// // A base that stands where its wheels say, after it has begun 5 mm beside its path.
/// let (mut base, mut before) = (Planar { y: 0.005, ..Planar::default() }, Two::zeros());
/// rehearse_with(follow, &DiffDrive::new(), Two::zeros(), 0.002, |image| {
///     let q = image.demanded().joints;
///     let (distance, turn) = DiffDrive::rolled(&(q - before));
///     (base, before) = (base.moved(distance, turn), q);
///     let standing = Standing { pose: base, stands: false };
///     (Order::new(()), Reading::new((SensorImage::new(standing, 0),)))
/// })?;
/// assert!((base.at() - places[2]).norm() < 1e-3, "{base:?}");
/// # Ok::<(), Fault>(())
/// ```
pub struct FollowPath<S: Sensor> {
    follower: Follower,
    see: fn(&S::Reading) -> Option<Planar>,
    over: fn(&S::Reading) -> bool,
    oldest: u32,
}

impl<S: Sensor> FollowPath<S> {
    /// Along `path`, from where `see` finds in a reading that the base stands; that is `delay` steps behind what is demanded, and may
    /// be `oldest` steps old: an older reading is a fault.
    #[must_use]
    pub fn along(
        path: Path,
        limits: BaseLimits,
        see: fn(&S::Reading) -> Option<Planar>,
        delay: f64,
        oldest: u32,
    ) -> Self {
        Self { follower: Follower::on(path, limits, delay), see, over: |_| false, oldest }
    }

    /// The same, over as soon as `over` says so of a reading: then the base brakes on its path.
    #[must_use]
    pub fn until(self, over: fn(&S::Reading) -> bool) -> Self {
        Self { over, ..self }
    }
}

#[generator(ecp)]
impl<S: Sensor> FollowPath<S> {
    fn first_step(
        &mut self,
        e: &State<DiffDrive>,
        v: &Reading<(S,)>,
        t: Tick,
    ) -> Result<Step<DiffDrive>, Fault> {
        self.follower.begin(e.demanded().joints)?;
        self.next_step(v, t)
    }

    fn next_step(&mut self, v: &Reading<(S,)>, t: Tick) -> Result<Step<DiffDrive>, Fault> {
        if v.0.reading().is_some() && v.0.age() > self.oldest {
            let fault = Fault::new(FaultKind::SensorStale);
            return Err(fault.exceeds(v.0.age().into(), self.oldest.into(), "step"));
        }
        if v.0.reading().as_ref().is_some_and(self.over) {
            return Ok(Step::Done);
        }
        let standing = v.0.reading().as_ref().and_then(self.see);
        Ok(match self.follower.advance(standing.as_ref(), t.dt)? {
            Some(wheels) => Step::Next(Demand::joints(wheels)),
            None => Step::Done,
        })
    }
}
