//! One base in another, from points that both arms have touched with their tools' tips.
//!
//! In: where each arm's controller says the tip is, in the arm's own base, at the same points. Out: the rigid motion that brings them
//! together best (Kabsch 1976), what is left at each point, and how sure it is: with `s` the standard deviation of a touched coordinate,
//! found from what is left, the middle of the points is known to `s / sqrt(n)`, and a turn to `s / sqrt(sum of squared distances from its axis)`.

use core::fmt;
use std::collections::BTreeMap;

use mrroc::pose::{Pose, Rpy};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::columns::{Columns, WrongLine};
use crate::known::{BASE, BASE_TURN, TOUCHING, WRONG};
use crate::pose_text::pose_text;

/// Points nearer to a line than this part of their extent tell no turn about it.
const FLAT: f64 = 0.05;

/// Touches, as a table has them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Touches(Vec<Touch>);

/// A tip at a point.
#[derive(Clone, Debug, PartialEq)]
struct Touch {
    point: String,
    arm: String,
    /// In the arm's base \[m\].
    at: Vector3<f64>,
}

/// Where one base is in another.
#[derive(Clone, Debug, PartialEq)]
pub struct TouchedBase {
    /// Where.
    pub base: Pose,
    /// By point how far both tips are from each other there \[m\].
    pub left: Vec<(String, f64)>,
    /// Standard deviation of the place of the points' middle \[m\], and of the least sure turn \[rad\].
    pub sigma: [f64; 2],
}

/// What is wrong with touches.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WrongTouches {
    /// A line that cannot be read.
    #[error(transparent)]
    Line(#[from] WrongLine),
    /// Too few points.
    #[error(
        "`{a}` and `{b}` have touched {count} points in common, of at least 3\n help: give the same points the same names; the arms are {arms}"
    )]
    TooFew {
        /// An arm.
        a: String,
        /// The other.
        b: String,
        /// How many.
        count: usize,
        /// All arms of the table.
        arms: String,
    },
    /// Points in one line.
    #[error(
        "all points lie within {aside:.1} mm of one line, which tells no turn about it\n help: touch one beside it, best by half of the others' distance"
    )]
    InLine {
        /// How far \[mm\].
        aside: f64,
    },
    /// Points that do not fit.
    #[error(
        "the arms disagree by {left:.1} mm at `{point}`\n help: compare the points' names, the tools that the controllers know, and the units"
    )]
    Disagree {
        /// Where most.
        point: String,
        /// How much \[mm\].
        left: f64,
    },
    /// Points too near to each other, or that fit too badly.
    #[error(
        "these points do not tell the base well enough: it is known to {middle:.1} mm in their middle, of {} mm at most, and to {turn:.1} mrad, of {} mrad at most\n help: touch \
         points that are farther apart ({reach:.0} mm are the most now), best as far as both arms reach, and more of them",
        1e3 * BASE, 1e3 * BASE_TURN
    )]
    Unsure {
        /// Standard deviation of the points' middle \[mm\].
        middle: f64,
        /// Of the least sure turn \[mrad\].
        turn: f64,
        /// The largest distance of two points \[mm\].
        reach: f64,
    },
}

impl Touches {
    /// Reads a table of comma-separated columns `point`, `arm`, and `x_mm`, `y_mm`, `z_mm` (or `x_m`, `y_m`, `z_m`), with these names in its first row. Lines that begin with `#` are
    /// remarks.
    ///
    /// # Errors
    /// What is wrong with it first.
    pub fn parse(text: &str) -> Result<Self, WrongTouches> {
        let table = Columns::parse(text, "point,arm,x_mm,y_mm,z_mm")?;
        let (points, arms) = (table.texts("point")?, table.texts("arm")?);
        let places = table.three(["x", "y", "z"], &[("mm", 1e-3), ("m", 1.0)])?;
        let rows = points.into_iter().zip(arms).zip(places);
        let touch = |((point, arm), at): ((&str, &str), Vector3<f64>)| Touch {
            point: point.to_owned(),
            arm: arm.to_owned(),
            at,
        };
        Ok(Self(rows.map(touch).collect()))
    }

    /// The same table as text.
    #[must_use]
    pub fn text(touches: &[(String, String, Vector3<f64>)]) -> String {
        let mut text = String::from("point,arm,x_mm,y_mm,z_mm\n");
        for (point, arm, at) in touches {
            text += &format!("{point},{arm},{:.4},{:.4},{:.4}\n", 1e3 * at.x, 1e3 * at.y, 1e3 * at.z);
        }
        text
    }

    /// Where the base of the arm `of` is in that of the arm `within`.
    ///
    /// # Errors
    /// [`WrongTouches`].
    pub fn base(&self, of: &str, within: &str) -> Result<TouchedBase, WrongTouches> {
        // A point that was touched more than once is where it was on the mean.
        let mean = |arm: &str| {
            let mut sums: BTreeMap<&str, (Vector3<f64>, f64)> = BTreeMap::new();
            for touch in self.0.iter().filter(|touch| touch.arm == arm) {
                let sum = sums.entry(&touch.point).or_insert((Vector3::zeros(), 0.0));
                *sum = (sum.0 + touch.at, sum.1 + 1.0);
            }
            sums.into_iter().map(|(point, (sum, count))| (point, sum / count)).collect::<BTreeMap<_, _>>()
        };
        let (own, others) = (mean(of), mean(within));
        let common: Vec<(&str, Vector3<f64>, Vector3<f64>)> =
            own.iter().filter_map(|(point, at)| Some((*point, *at, *others.get(point)?))).collect();
        if common.len() < 3 {
            let mut arms: Vec<&str> = self.0.iter().map(|touch| &*touch.arm).collect();
            arms.sort_unstable();
            arms.dedup();
            let (a, b) = (of.to_owned(), within.to_owned());
            return Err(WrongTouches::TooFew { a, b, count: common.len(), arms: arms.join(", ") });
        }
        let n = common.len() as f64;
        let from = common.iter().map(|one| one.1).sum::<Vector3<f64>>() / n;
        let to = common.iter().map(|one| one.2).sum::<Vector3<f64>>() / n;
        let spread: Matrix3<f64> = common.iter().map(|one| (one.2 - to) * (one.2 - to).transpose()).sum();
        let mut extents: Vec<f64> =
            spread.symmetric_eigenvalues().iter().map(|of| of.max(0.0).sqrt()).collect();
        extents.sort_by(|a, b| b.total_cmp(a));
        if extents[1] < FLAT * extents[0] {
            return Err(WrongTouches::InLine { aside: 1e3 * extents[1] });
        }
        let moment: Matrix3<f64> = common.iter().map(|one| (one.2 - to) * (one.1 - from).transpose()).sum();
        let svd = moment.svd(true, true);
        let (u, v_t) = (svd.u.unwrap_or_else(Matrix3::identity), svd.v_t.unwrap_or_else(Matrix3::identity));
        let sign = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, (u * v_t).determinant().signum()));
        let turn = Rotation3::from_matrix_unchecked(u * sign * v_t);
        let base = Pose::from_parts((to - turn * from).into(), UnitQuaternion::from_rotation_matrix(&turn));
        let left: Vec<(String, f64)> = common
            .iter()
            .map(|(point, a, b)| {
                ((*point).to_owned(), (base * nalgebra::Point3::from(*a) - nalgebra::Point3::from(*b)).norm())
            })
            .collect();
        let worst = left.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((point, left)) = worst.filter(|(_, left)| *left > WRONG) {
            return Err(WrongTouches::Disagree { point: point.clone(), left: 1e3 * left });
        }
        let square = left.iter().map(|(_, left)| left * left).sum::<f64>() / (3.0 * n - 6.0);
        // About the axis of the greatest extent the others alone resist.
        let lever = (extents[1].powi(2) + extents[2].powi(2)).sqrt();
        let sigma = |square: f64| [(3.0 * square / n).sqrt(), square.sqrt() / lever];
        let [middle, turn] = sigma(square.max(TOUCHING * TOUCHING));
        if middle > BASE || turn > BASE_TURN {
            let apart = |a: &Vector3<f64>| common.iter().map(|b| (a - b.2).norm()).fold(0.0, f64::max);
            let reach = common.iter().map(|one| apart(&one.2)).fold(0.0, f64::max);
            let [middle, turn, reach] = [middle, turn, reach].map(|one| 1e3 * one);
            return Err(WrongTouches::Unsure { middle, turn, reach });
        }
        Ok(TouchedBase { base, left, sigma: sigma(square) })
    }
}

impl TouchedBase {
    /// The file for `base` of a robot in `cell.toml`; `of` and `within` are the arms.
    #[must_use]
    pub fn text(&self, of: &str, within: &str, made: &str) -> String {
        format!(
            "# The base of `{of}` in that of `{within}`: name this file as its `base` in cell.toml.\n# m.\n\
             model = \"base\"\nrobot = {of:?}\nmade = {made:?}\n\n[frames.base]\n{}",
            pose_text(&self.base)
        )
    }
}

impl fmt::Display for TouchedBase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (p, turn) = (self.base.translation.vector * 1e3, Rpy::of(&self.base.rotation));
        writeln!(f, "xyz [mm]  {:12.4} {:12.4} {:12.4}", p.x, p.y, p.z)?;
        writeln!(f, "rpy [rad] {:12.6} {:12.6} {:12.6}", turn.roll, turn.pitch, turn.yaw)?;
        writeln!(
            f,
            "known to {:.3} mm in the middle of the points, and to {:.3} mrad (standard deviations)",
            1e3 * self.sigma[0],
            1e3 * self.sigma[1]
        )?;
        for (point, left) in &self.left {
            writeln!(f, "  {point:12} the tips are {:.3} mm apart", 1e3 * left)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn base() -> Pose {
        Pose::new(Vector3::new(1.8, -0.3, -0.45), Vector3::new(0.02, -0.01, 3.1))
    }

    fn table(points: &[[f64; 3]], off: f64) -> String {
        let mut touches = Vec::new();
        for (i, point) in points.iter().enumerate() {
            let inside = base().inverse() * nalgebra::Point3::from(*point);
            touches.push((format!("P{i}"), "left".to_owned(), Vector3::from(*point)));
            let aside = Vector3::x() * if i == 0 { off } else { 0.0 };
            touches.push((format!("P{i}"), "right".to_owned(), inside.coords + aside));
        }
        Touches::text(&touches)
    }

    #[test]
    fn three_points_that_both_arms_touch_give_one_base_in_the_other() {
        let text = table(&[[0.9, 0.1, 0.2], [0.9, -0.3, 0.2], [0.6, 0.0, 0.25]], 0.0);
        let found = Touches::parse(&text).expect("a table").base("right", "left").expect("a base");
        let off = base().inverse() * found.base;
        // Written to a tenth of a micrometre.
        assert!(off.translation.vector.norm() < 1e-6 && off.rotation.angle() < 1e-6, "{off}");
        assert!(found.text("right", "left", "2026-11-24").contains("[frames.base]"));
    }

    #[test]
    fn touches_that_tell_no_base_are_answered_with_what_to_do() {
        let told = |text: &str| match Touches::parse(text).and_then(|touches| touches.base("right", "left")) {
            Ok(found) => panic!("{found}"),
            Err(why) => why.to_string(),
        };
        let corners = [[0.9, 0.1, 0.2], [0.9, -0.3, 0.2], [0.6, 0.0, 0.25]];
        assert!(
            told(&table(&[[0.9, 0.1, 0.2], [0.9, -0.3, 0.2], [0.9, 0.0, 0.2]], 0.0)).contains("of one line")
        );
        assert!(told(&table(&corners[..2], 0.0)).contains("2 points in common"));
        assert!(told(&table(&corners, 0.05)).contains("the arms disagree by"));
        // Points 20 mm from each other, touched to 0.1 mm: a turn of 0.1 / (20 / sqrt(2)) = 7 mrad.
        let near = [[0.9, 0.1, 0.2], [0.92, 0.1, 0.2], [0.9, 0.12, 0.2]];
        assert!(told(&table(&near, 0.0)).contains("farther apart (28 mm"), "{}", told(&table(&near, 0.0)));
        assert!(told(&table(&corners, 0.0).replace("left", "lfet")).contains("the arms are lfet, right"));
        assert!(told("point,arm,x,y,z\n").contains("line 1: no column `x_mm`"));
        assert!(told("point,arm,x_mm,y_mm,z_mm\nA,left,1,2\n").contains("line 2: 4 cells"));
        assert!(told("point,arm,x_mm,y_mm,z_mm\nA,left,1,nan,2\n").contains("`nan` is no number"));
        assert!(told("").contains("nothing in the table"));
    }
}
