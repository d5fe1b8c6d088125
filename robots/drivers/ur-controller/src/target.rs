//! Where the joints are driven to, and how fast: `servoj` and `stopj`.
//!
//! In: in each step the goal of `servoj`, or how hard to brake. Out: the position of the joints at the end of the step.

use mrroc_robots::Six;
use mrroc_ur::{JOINTS, UrModel};

/// Length of a step \[s\].
pub(crate) const T: f64 = 0.002;

/// How many times its acceleration limit a joint can do to make up for set-points that are off (assumed).
const QUICK: f64 = 3.0;

/// Positions \[rad\], speeds and accelerations.
#[derive(Debug, Default)]
pub(crate) struct Target {
    pub position: Six,
    pub speed: Six,
    pub acceleration: Six,
    /// The last goal of `servoj`, while it goes on.
    pub goal: Option<Six>,
}

impl Target {
    /// `servoj`: the joints are at `goal` at the end of the step, if their speeds, of which they may use a fraction, and accelerations
    /// let them. What they are off by, they make up so that they come to rest beside it: `v = v_goal + sqrt(a e)` for an error e.
    /// `false`: a joint is farther from it than it comes within `lookahead` \[s\].
    #[must_use]
    pub fn servo(&mut self, goal: &Six, model: UrModel, fraction: f64, lookahead: f64) -> bool {
        let limits = model.velocities();
        let most = model.accelerations() * QUICK;
        let before = self.goal.replace(*goal).unwrap_or(goal - self.speed * T);
        for i in 0..JOINTS {
            let distance = goal[i] - self.position[i];
            if distance.abs() > limits[i] * lookahead {
                return false;
            }
            let limit = limits[i] * fraction;
            let of_goal = ((goal[i] - before[i]) / T).clamp(-limits[i], limits[i]);
            let off = distance - of_goal * T;
            let made_up = (off.abs() / T).min((most[i] * off.abs()).sqrt()).copysign(off);
            let change = (of_goal + made_up - self.speed[i]).clamp(-most[i] * T, most[i] * T);
            self.speed[i] = (self.speed[i] + change).clamp(-limit, limit);
        }
        self.position += self.speed * T;
        true
    }

    /// `stopj`: the fastest joint is braked so hard [rad/s²], and the others with it.
    pub fn brake(&mut self, deceleration: f64) {
        self.goal = None;
        let fastest = self.speed.amax();
        let share = if fastest > deceleration * T { 1.0 - deceleration * T / fastest } else { 0.0 };
        self.speed *= share;
        self.position += self.speed * T;
    }

    /// The joints are held where they are.
    pub fn rest(&mut self, position: Six) {
        (self.position, self.speed) = (position, Six::zeros());
    }
}
