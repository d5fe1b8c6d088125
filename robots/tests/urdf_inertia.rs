//! Inertias that no body has are refused by the link's name and line; those that files have by rounding are not.
//!
//! Of the principal moments A <= B <= C of any mass, A >= 0 and C <= A + B (Goldstein, Classical Mechanics, problem 5.1).

use mrroc_robots::{Serial, UrdfError};

/// An arm whose link `arm` has this `<inertia>`, with a link fixed to it that has the other one, if any.
fn with(moments: [f64; 6], fixed: Option<(f64, [f64; 6])>) -> Result<(), UrdfError> {
    let inertial = |mass: f64, [xx, xy, xz, yy, yz, zz]: [f64; 6]| {
        format!(
            "<inertial><mass value=\"{mass}\"/>\n<inertia ixx=\"{xx}\" ixy=\"{xy}\" ixz=\"{xz}\" iyy=\"{yy}\" iyz=\"{yz}\" izz=\"{zz}\"/></inertial>"
        )
    };
    let flange = fixed.map_or(String::new(), |(mass, moments)| inertial(mass, moments));
    let text = format!(
        "<robot name=\"r\"><link name=\"base\"/>\n<link name=\"arm\">{}</link><link name=\"flange\">{flange}</link>\n\
         <joint name=\"turn\" type=\"revolute\"><parent link=\"base\"/><child link=\"arm\"/><axis xyz=\"0 0 1\"/>\n\
         <limit lower=\"-1\" upper=\"2\" velocity=\"3\"/></joint>\n\
         <joint name=\"mount\" type=\"fixed\"><parent link=\"arm\"/><child link=\"flange\"/></joint></robot>",
        inertial(2.0, moments)
    );
    Serial::<1>::from_urdf(&text, "base", "flange").map(drop)
}

fn alone(moments: [f64; 6]) -> Result<(), UrdfError> {
    with(moments, None)
}

fn diagonal([xx, yy, zz]: [f64; 3]) -> [f64; 6] {
    [xx, 0.0, 0.0, yy, 0.0, zz]
}

/// Six equal numbers, which many files have where nobody has computed any.
fn placeholder(number: f64) -> [f64; 6] {
    [number; 6]
}

#[test]
fn a_negative_principal_moment_is_refused() {
    // In the plane of x and y: 0.02 +- 0.03.
    let refused = alone([0.02, 0.03, 0.0, 0.02, 0.0, 0.05]).expect_err("it cannot be");
    assert_eq!(
        refused.to_string(),
        "line 3: link \"arm\": its <inertia> cannot be: principal moments -1.000e-2, 5.000e-2, 5.000e-2 kg m^2, of which none may \
         be negative: correct the moments and the signs of the products"
    );
}

#[test]
fn a_moment_beyond_the_sum_of_the_others_is_refused() {
    // Of romeo.urdf of example-robot-data, link RShoulderYawLink.
    let refused = alone(diagonal([0.00656531, 0.000661782, 0.000679363])).expect_err("it cannot be");
    assert_eq!(
        refused.to_string(),
        "line 3: link \"arm\": its <inertia> cannot be: principal moments 6.618e-4, 6.794e-4, 6.565e-3 kg m^2, of which the largest is \
         at most the sum of the others in any body (5 % more are taken for rounding): correct it, or write the moments of a \
         sphere, 0.4 m r^2 each"
    );
    // A moment of 1 and nothing else; hands of allegro_left_hand.urdf.
    assert!(alone(diagonal([0.0, 0.0, 1.0])).is_err());
    assert!(alone(diagonal([1.2961e-5, 7.1057e-5, 9.9822e-5])).is_err());
}

#[test]
fn moments_of_bodies_are_taken() {
    // A point, a ball, a thin rod, a thin plate: C = A + B.
    for moments in [[0.0; 3], [0.1; 3], [0.0, 0.2, 0.2], [0.1, 0.2, 0.3]] {
        alone(diagonal(moments)).expect("a body");
    }
    // A rod of 1 kg and 1 m along u = (0.6, 0.8, 0), (E - u u^T)/12, written with three digits: its least moment is -1e-5.
    alone([0.0533, -0.0400, 0.0, 0.0300, 0.0, 0.0833]).expect("a rod, rounded");
}

#[test]
fn what_arms_in_use_have_by_rounding_is_taken() {
    // Of tiago.urdf and tiago_dual.urdf of example-robot-data, links of the arm: 2.2 and 3.2 % beyond.
    alone(diagonal([0.001910314, 0.008459804, 0.010593882])).expect("Tiago's");
    alone(diagonal([0.001556792, 0.005976269, 0.007773939])).expect("Tiago's");
}

#[test]
fn a_placeholder_counts_by_what_it_is_fixed_to() {
    let heavy = diagonal([0.1, 0.1, 0.05]);
    with(heavy, Some((1e-6, placeholder(1e-6)))).expect("nothing beside 2 kg");
    // Six equal numbers are moments 0, 0 and three times as much.
    let told = with(heavy, Some((0.1, placeholder(1.0)))).expect_err("larger than the arm").to_string();
    assert!(
        told.starts_with("line 4: link \"flange\": its <inertia> cannot be") && told.contains("3.000e0 kg"),
        "{told}"
    );
    assert!(alone(placeholder(1e-3)).is_err());
    // Also where it has no mass: the shortest way to write that is no <inertial>.
    with(heavy, Some((0.0, placeholder(1e-6)))).expect("nothing beside 2 kg");
}

/// The moments of both together are infinite, of which an iteration for principal moments would not end.
#[test]
fn moments_that_overflow_end_the_reading() {
    let most = 1.5e308;
    let _ = with(diagonal([0.0, 0.0, most]), Some((1.0, diagonal([most; 3]))));
}
