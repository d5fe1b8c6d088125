//! Every generator of the library is one file on the public API alone: copied into another crate it compiles and
//! moves an arm as the library's own does.

// Constructors that these tests do not call.
#![allow(dead_code)]

#[path = "../../generators-lib/src/generators/guarded_approach.rs"]
mod my_approach;
#[path = "../../generators-lib/src/generators/straight_line.rs"]
mod my_line;
#[path = "../../generators-lib/src/generators/joint_move.rs"]
mod my_move;
#[path = "../../generators-lib/src/generators/spline_track.rs"]
mod my_track;

use mrroc::{Cell, Generator, Pose};
use mrroc_tests::{Gantry, MS, Q, gantry};
use nalgebra::Vector3;

use super::{Probe, limits};

fn trace_of<G>(generator: impl Fn() -> G) -> Vec<Q<3>>
where
    G: Generator<Robots = Gantry, Language = mrroc::Motion, Sensors = ()> + 'static,
{
    let (robot, trace) = gantry("g");
    let generator = generator();
    Cell::new(MS)
        .robot(robot.program(move |ecp| ecp.move_robot((), generator).map(drop)))
        .run()
        .expect("within the limits");
    trace.take()
}

#[test]
fn a_copied_generator_moves_as_the_librarys_own() {
    use mrroc_generators::generators::{JointMove, StraightLine};
    let goal = Pose::translation(0.1, -0.2, 0.05);
    let library = trace_of(|| StraightLine::to(goal, limits(0.3, 2.0)));
    assert_eq!(library, trace_of(|| my_line::StraightLine::to(goal, limits(0.3, 2.0))));
    let (q, v, a) = (Vector3::new(0.2, 0.1, -0.1), Vector3::repeat(0.4), Vector3::repeat(3.0));
    assert_eq!(trace_of(|| JointMove::to(q, v, a)), trace_of(|| my_move::JointMove::to(q, v, a)));
    // The other two have their own tests in the library; here it is enough that the copies have their classes.
    assert_eq!(
        my_track::SplineTrack::<Gantry, std::vec::IntoIter<Vector3<f64>>>::CLASS.to_string(),
        "ECP f*0(c)"
    );
    assert_eq!(
        my_approach::GuardedApproach::<Gantry, Probe>::CLASS.to_string(),
        "ECP f*1(c, v), first step f*3(c, e, v)"
    );
}
