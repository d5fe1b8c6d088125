//! A change of velocity by an acceleration that is a trapezoid over time.

/// From one velocity to another: an acceleration that is a rectangle `ramp` long, averaged over `soft` <= `ramp`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Blend {
    /// Duration of the rectangle \[s\].
    pub ramp: f64,
    /// Duration of the average \[s\]; 0 for a jump of the acceleration.
    pub soft: f64,
}

impl Blend {
    /// The shortest whose velocity changes by `dv` within `acceleration` and `jerk` for each of `changes`
    /// `(dv, acceleration, jerk)`.
    pub(super) fn of(changes: impl Iterator<Item = (f64, f64, f64)> + Clone) -> Self {
        let most = |f: fn((f64, f64, f64)) -> f64| changes.clone().map(f).fold(0.0, f64::max);
        let ramp = most(|(dv, a, _)| dv / a);
        let area = most(|(dv, _, j)| dv / j);
        if area >= ramp * ramp {
            let both = area.sqrt();
            return Blend { ramp: both, soft: both };
        }
        Blend { ramp, soft: area / ramp }
    }

    /// Duration \[s\].
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.ramp + self.soft
    }

    /// By how far it passes the corner, per unit of the velocity's change \[s\].
    #[must_use]
    pub fn deviation(&self) -> f64 {
        if self.ramp > 0.0 { self.ramp / 8.0 + self.soft * self.soft / (24.0 * self.ramp) } else { 0.0 }
    }

    /// The distance per unit of the new velocity \[s\], the share, of the velocity and of the acceleration at `x` \[s\] from the middle: the
    /// integral of the smoothed step, the step, its derivative.
    #[must_use]
    pub fn at(&self, x: f64) -> (f64, f64, f64) {
        let Blend { ramp, soft } = *self;
        let half = 0.5 * (ramp + soft);
        let flat = 0.5 * (ramp - soft);
        if x > 0.0 {
            let (advance, share, rise) = self.at(-x);
            return (x + advance, 1.0 - share, rise);
        }
        if x <= -half || ramp == 0.0 {
            return (0.0, 0.0, 0.0);
        }
        if x < -flat {
            let y = x + half;
            let rise = y / (ramp * soft);
            return (rise * y * y / 6.0, 0.5 * rise * y, rise);
        }
        let z = x + flat;
        ((soft * soft / 6.0 + 0.5 * z * (soft + z)) / ramp, (0.5 * soft + z) / ramp, 1.0 / ramp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blend_is_the_integral_of_its_trapezoid() {
        for blend in
            [Blend { ramp: 2.0, soft: 0.5 }, Blend { ramp: 1.0, soft: 1.0 }, Blend { ramp: 1.0, soft: 0.0 }]
        {
            let h = 1e-4;
            for i in -200..=200 {
                let x = f64::from(i) * 0.01 + 0.0031;
                let before = blend.at(x - h);
                let here = blend.at(x);
                let after = blend.at(x + h);
                assert!(((after.0 - before.0) / (2.0 * h) - here.1).abs() < 1e-6, "{x}");
                assert!(((after.1 - before.1) / (2.0 * h) - here.2).abs() < 1e-3, "{x}");
            }
            assert!((blend.at(0.0).0 - blend.deviation()).abs() < 1e-15);
            assert_eq!(blend.at(5.0), (5.0, 1.0, 0.0));
        }
    }
}
