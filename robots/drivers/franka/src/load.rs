//! What a robot is told that it carries: what the cell says, less the end effector of Desk, which the robot adds by itself.
//!
//! In: all that the flange carries, and the end effector that the robot's states tell. Out: the load for `SetLoad`. libfranka composes
//! the two again in `m_total`, `F_x_Ctotal` and `I_total`.

use mrroc::robot::{DriveFault, Load};
use nalgebra::{Matrix3, Vector3};

/// A mass that is none \[kg\]: the robot's states have seven digits.
const NOTHING: f64 = 1e-3;

/// The share of an inertia that is lost among those digits.
const LOST: f64 = 1e-5;

pub(crate) const LESS: DriveFault = DriveFault::Other(
    "the flange carries less by the cell than the end effector that Desk has: `[tools.NAME]` is all that is on the flange, a hand with it",
);

pub(crate) const NO_BODY: DriveFault = DriveFault::Other(
    "no body has the inertia that the cell's load leaves beside the end effector of Desk: write that of all on the flange, or none",
);

const UNREAD: DriveFault = DriveFault::Other("the robot tells an end effector with a number that is none");

/// What is on the flange besides the end effector of Desk, where all of it is `whole`. One without an inertia is that of a small body,
/// and so is what remains.
///
/// By the definition of the centre of mass, `m c = m_ee c_ee + m_l c_l`, and by Steiner's theorem, about `c`:
/// `I = I_ee + S(m_ee, c_ee - c) + I_l + S(m_l, c_l - c)` with `S(m, d) = m (d·d 1 - d dᵀ)`.
///
/// # Errors
/// `whole` is less than the end effector, or no body has the inertia that remains.
pub(crate) fn besides(effector: &Load, whole: &Load) -> Result<Load, DriveFault> {
    let numbers = [effector.mass].into_iter().chain(effector.centre.iter().copied());
    if !numbers.chain(effector.inertia.iter().copied()).all(f64::is_finite) {
        return Err(UNREAD);
    }
    if effector.mass == 0.0 {
        return Ok(*whole);
    }
    let mass = whole.mass - effector.mass;
    if mass < -NOTHING {
        return Err(LESS);
    }
    if mass <= NOTHING {
        return Ok(Load::NONE);
    }
    let centre = (whole.centre * whole.mass - effector.centre * effector.mass) / mass;
    if whole.inertia == Matrix3::zeros() {
        return Ok(Load::point(mass, centre));
    }
    let of_effector = (effector.inertia + effector.inertia.transpose()) / 2.0;
    let inertia = whole.inertia
        - of_effector
        - steiner(effector.mass, effector.centre - whole.centre)
        - steiner(mass, centre - whole.centre);
    let lost = LOST * whole.inertia.amax();
    if inertia.amax() <= lost {
        return Ok(Load::point(mass, centre));
    }
    let load = Load { mass, centre, inertia };
    // What is lost among the digits may be what a thin body has.
    let rounded = Load { inertia: inertia + Matrix3::identity() * lost, ..load };
    [load, rounded].into_iter().find(|load| load.fault().is_none()).ok_or(NO_BODY)
}

/// The inertia of a small body at `d` from the point about which it is counted [kg m²].
fn steiner(mass: f64, d: Vector3<f64>) -> Matrix3<f64> {
    (Matrix3::identity() * d.dot(&d) - d * d.transpose()) * mass
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cuboid: mass \[kg\], centre and edges \[m\].
    fn cuboid(mass: f64, centre: [f64; 3], [a, b, c]: [f64; 3]) -> Load {
        let moments = Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b) * (mass / 12.0);
        Load { mass, centre: centre.into(), inertia: Matrix3::from_diagonal(&moments) }
    }

    fn rounded(load: &Load) -> Load {
        let round = |x: f64| f64::from(x as f32);
        Load { mass: round(load.mass), centre: load.centre.map(round), inertia: load.inertia.map(round) }
    }

    fn apart(a: &Load, b: &Load) -> [f64; 3] {
        [(a.mass - b.mass).abs(), (a.centre - b.centre).amax(), (a.inertia - b.inertia).amax()]
    }

    /// The hand of Franka by its URDF's mass, and a cuboid beside it. They have cuboids' moments: of two halves of one cuboid the
    /// whole is the cuboid.
    #[test]
    fn of_a_body_that_is_made_of_two_the_other_one_remains() {
        let edges = [0.04, 0.2, 0.1];
        let whole = cuboid(1.46, [0.01, 0.0, 0.1], edges);
        let halves = [-0.05, 0.05].map(|y| cuboid(0.73, [0.01, y, 0.1], [0.04, 0.1, 0.1]));
        let remains = besides(&rounded(&halves[0]), &whole).expect("a body");
        let apart = apart(&remains, &halves[1]);
        assert!(apart[0] < 1e-7 && apart[1] < 1e-7 && apart[2] < 1e-8, "{apart:?}");
    }

    #[test]
    fn a_robot_without_an_end_effector_is_told_all_and_one_that_carries_nothing_else_is_told_nothing() {
        let pen = cuboid(0.3, [0.0, 0.0, 0.06], [0.01, 0.01, 0.12]);
        assert_eq!(besides(&Load::NONE, &pen), Ok(pen));
        let hand = cuboid(0.73, [-0.01, 0.0, 0.03], [0.04, 0.2, 0.1]);
        assert_eq!(besides(&rounded(&hand), &hand), Ok(Load::NONE));
        // A small body at the end of it: 0.5 kg that turns like nothing.
        let (mass, centre) = (1.23, (hand.centre * 0.73 + Vector3::new(0.0, 0.1, 0.2) * 0.5) / 1.23);
        let of_hand = hand.inertia + steiner(0.73, hand.centre - centre);
        let inertia = of_hand + steiner(0.5, Vector3::new(0.0, 0.1, 0.2) - centre);
        let part = besides(&rounded(&hand), &Load { mass, centre, inertia }).expect("a body");
        assert_eq!(part.inertia, Matrix3::zeros());
        assert!((part.mass - 0.5).abs() < 1e-7 && (part.centre - Vector3::new(0.0, 0.1, 0.2)).amax() < 1e-6);
        // Where the cell says no inertia, what remains has none either.
        let point = besides(&rounded(&hand), &Load::point(mass, centre)).expect("a body");
        assert_eq!((point.centre, point.inertia), (part.centre, Matrix3::zeros()));
    }

    #[test]
    fn fault_117_less_than_the_end_effector_and_what_no_body_leaves_is_refused() {
        let hand = cuboid(0.73, [-0.01, 0.0, 0.03], [0.04, 0.2, 0.1]);
        assert_eq!(besides(&hand, &cuboid(0.3, [0.0, 0.0, 0.06], [0.01, 0.01, 0.12])), Err(LESS));
        // The inertia of the part alone, where that of all on the flange is asked for.
        assert_eq!(besides(&hand, &cuboid(1.0, [0.0, 0.0, 0.1], [0.01, 0.01, 0.12])), Err(NO_BODY));
        let nan = Load { centre: Vector3::new(f64::NAN, 0.0, 0.0), ..hand };
        assert_eq!(besides(&nan, &hand), Err(UNREAD));
    }
}
