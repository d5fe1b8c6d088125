//! The path of a foot through the air: up, over, down, and down slowly until it touches.
//!
//! In: from where to where, and how high, over the ground. Out: where the foot is, over the ground: its velocity along the ground is zero
//! where it leaves it and where it comes down, whatever the trunk does meanwhile.

use nalgebra::Vector3;

use super::gait::soft;

/// How fast a foot comes down at last [m/s].
pub const DOWN: f64 = 0.12;
/// It comes down at that speed from so far over where the ground should be \[m\].
pub const OVER: f64 = 0.01;
/// How long a foot takes to stop once it has touched, that comes down at [`DOWN`] \[s\].
const STOP: f64 = 0.016;
/// How hard one is stopped at most that touches earlier, while it is still faster [m/s^2].
const HARDEST: f64 = 8.5;
/// Shares of the swing: when it moves ahead from and to, when it is highest, when it comes down slowly.
const AHEAD: [f64; 2] = [0.16, 0.9];
const HIGHEST: f64 = 0.48;
const SLOW: f64 = 0.88;
/// In this share of the swing it is lifted by no more than this \[m\]: the others take over its load gently.
const UNLOADS: f64 = 0.15;
const BARELY: f64 = 1.5e-3;

/// A swing.
#[derive(Clone, Debug, PartialEq)]
pub struct Swing {
    from: Vector3<f64>,
    to: Vector3<f64>,
    top: f64,
    lasts: f64,
    touched: Option<Touched>,
}

/// A touch.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Touched {
    /// When \[s\], and where \[m\].
    when: f64,
    at: Vector3<f64>,
    /// How fast it came [m/s], and how long it takes to stop \[s\].
    velocity: Vector3<f64>,
    stop: f64,
}

impl Swing {
    /// From one place to another \[m\], at least as high as `top` in between, in `lasts` \[s\].
    #[must_use]
    pub const fn new(from: Vector3<f64>, to: Vector3<f64>, top: f64, lasts: f64) -> Self {
        Self { from, to, top, lasts, touched: None }
    }

    /// Where it is to come down \[m\].
    #[must_use]
    pub const fn to(&self) -> &Vector3<f64> {
        &self.to
    }

    /// Whether it may touch at a time: it is on its way down.
    #[must_use]
    pub fn may_touch(&self, t: f64) -> bool {
        t > 0.6 * self.lasts
    }

    /// Whether it has touched.
    #[must_use]
    pub const fn has_touched(&self) -> bool {
        self.touched.is_some()
    }

    /// It has touched the ground, at the time `t` \[s\].
    pub fn touch(&mut self, t: f64) {
        const H: f64 = 1e-4;
        let velocity = (self.free(t + H) - self.free(t - H)) / (2.0 * H);
        let stop = STOP.max(velocity.norm() / HARDEST);
        self.touched = Some(Touched { when: t, at: self.free(t), velocity, stop });
    }

    /// Where the foot is at the time `t` \[s\] from its lift.
    #[must_use]
    pub fn at(&self, t: f64) -> Vector3<f64> {
        match self.touched {
            None => self.free(t),
            Some(Touched { when, at, velocity, stop }) => {
                let since = (t - when).clamp(0.0, stop);
                at + velocity * (since - 0.5 * since * since / stop)
            }
        }
    }

    /// As if there were no ground.
    fn free(&self, t: f64) -> Vector3<f64> {
        let u = t / self.lasts;
        let over = self.from + (self.to - self.from) * soft((u - AHEAD[0]) / (AHEAD[1] - AHEAD[0]));
        let low = self.to.z + OVER;
        let z = if u <= HIGHEST {
            self.from.z
                + BARELY * soft(u / UNLOADS)
                + (self.top - self.from.z - BARELY) * soft((u - UNLOADS) / (HIGHEST - UNLOADS))
        } else if u <= SLOW {
            let time = (SLOW - HIGHEST) * self.lasts;
            let s = (u - HIGHEST) / (SLOW - HIGHEST);
            // A fifth-degree polynomial from rest to the speed at which it comes down: s³ (7 s - 3 s² - 4) is its slope's part.
            self.top + (low - self.top) * soft(s) - DOWN * time * s * s * s * (7.0 * s - 3.0 * s * s - 4.0)
        } else {
            low - DOWN * (u - SLOW) * self.lasts
        };
        Vector3::new(over.x, over.y, z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swing() -> Swing {
        Swing::new(Vector3::new(0.0, 0.2, 0.0), Vector3::new(0.3, 0.2, 0.02), 0.06, 0.56)
    }

    #[test]
    fn it_has_no_corner_and_stands_over_the_ground_where_it_leaves_and_comes_down() {
        let swing = swing();
        let h = 1e-5;
        let velocity = |t: f64| (swing.at(t + h) - swing.at(t - h)) / (2.0 * h);
        for share in [UNLOADS, HIGHEST, SLOW, 0.16, 0.9] {
            let t = share * 0.56;
            assert!((velocity(t + 2.0 * h) - velocity(t - 2.0 * h)).norm() < 2e-2, "{share}");
        }
        assert!((swing.at(HIGHEST * 0.56).z - 0.06).abs() < 1e-12);
        assert!((velocity(0.95 * 0.56) - Vector3::new(0.0, 0.0, -DOWN)).norm() < 1e-6);
        assert!((swing.at(0.95 * 0.56).xy() - swing.to().xy()).norm() < 1e-12);
        assert_eq!(swing.at(0.0), Vector3::new(0.0, 0.2, 0.0));
    }

    #[test]
    fn a_foot_that_touches_early_is_stopped_no_harder_and_no_sooner_than_it_can() {
        let h = 1e-5;
        for share in [0.62, 0.7, 0.8, 0.9] {
            let mut swing = swing();
            let t = share * 0.56;
            let velocity = (swing.at(t + h) - swing.at(t - h)) / (2.0 * h);
            swing.touch(t);
            let stop = f64::max(STOP, velocity.norm() / HARDEST);
            let acceleration =
                |t: f64| (swing.at(t + h) - 2.0 * swing.at(t) + swing.at(t - h)).norm() / (h * h);
            assert!(acceleration(t + 0.5 * stop) < 1.001 * HARDEST, "{share}");
            // The distance of a body that is stopped evenly.
            assert!((swing.at(t + 1.0) - swing.at(t) - 0.5 * stop * velocity).norm() < 1e-6, "{share}");
        }
    }

    #[test]
    fn once_it_has_touched_it_stops_within_two_millimetres_and_stays() {
        let mut swing = swing();
        let t = 0.95 * 0.56;
        let at = swing.at(t);
        swing.touch(t);
        assert!((swing.at(t) - at).norm() < 1e-12);
        let rest = swing.at(t + 1.0);
        assert_eq!(swing.at(t + STOP), rest);
        assert!((at.z - rest.z - 0.5 * DOWN * STOP).abs() < 1e-6 && (at - rest).norm() < 2e-3);
    }
}
