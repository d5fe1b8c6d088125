//! The library's generators and their source text: what is copied into a project to be changed there.
//!
//! Classes stand here as text, so that a project is made without compiling the library first; a test compares them with
//! those that the code has.

/// One generator of the library.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Name of its module and, with `.rs`, of its file.
    pub name: &'static str,
    /// Name of its type.
    pub type_name: &'static str,
    /// Its class in the paper's classification, which does not depend on the kinds of robot and sensor.
    pub class: &'static str,
    /// The text of its file, on the public interface alone.
    pub source: &'static str,
}

impl Entry {
    /// What it does: the first line of its file.
    #[must_use]
    pub fn summary(&self) -> &'static str {
        self.source.lines().next().unwrap_or_default().trim_start_matches("//!").trim()
    }

    /// What is copied: its text without the examples of its documentation, which use it as the library's.
    #[must_use]
    pub fn copied(&self) -> String {
        let mut copied = String::with_capacity(self.source.len());
        let mut example = false;
        for line in self.source.split_inclusive('\n') {
            let of_example = example;
            if line.trim() == "/// ```" {
                example = !example;
                if example && copied.ends_with("///\n") {
                    copied.truncate(copied.len() - "///\n".len());
                }
            }
            if !of_example && !example {
                copied.push_str(line);
            }
        }
        copied
    }

    /// Whether it moves one robot, in the program of its ECP or of the MP.
    #[must_use]
    pub fn is_of_an_ecp(&self) -> bool {
        self.class.starts_with("ECP")
    }

    /// Whether it reads sensors.
    #[must_use]
    pub fn reads_sensors(&self) -> bool {
        self.reads("v")
    }

    /// Whether it is an ECP's and reads the MP's orders, so that the MP itself cannot move a robot by it.
    #[must_use]
    pub fn reads_orders(&self) -> bool {
        self.is_of_an_ecp() && self.reads("c0")
    }

    fn reads(&self, argument: &str) -> bool {
        self.class.split(['(', ',', ')']).any(|used| used.trim() == argument)
    }
}

macro_rules! entry {
    ($name:literal, $type_name:literal, $class:literal) => {
        Entry {
            name: $name,
            type_name: $type_name,
            class: $class,
            source: include_str!(concat!("../../../generators-lib/src/generators/", $name, ".rs")),
        }
    };
}

/// All generators of the library, by name.
pub const CATALOGUE: &[Entry] = &[
    entry!("await_operator", "AwaitOperator", "ECP f*0(c)"),
    entry!("circular_move", "CircularMove", "ECP f*0(c), first step f*2(c, e)"),
    entry!("compliant_transmit", "CompliantTransmit", "ECP f*5(c0, c, v)"),
    entry!("constant_order", "ConstantOrder", "MP f**() = const"),
    entry!("curve_move", "CurveMove", "ECP f*0(c), first step f*2(c, e)"),
    entry!("delay", "Delay", "ECP f*0(c)"),
    entry!("eye_in_hand", "EyeInHand", "ECP f*3(c, e, v)"),
    entry!("follow_master", "FollowMaster", "MP f*2(c0, e)"),
    entry!("followed_frame", "FollowedFrame", "ECP f*1(c, v), first step f*3(c, e, v)"),
    entry!("force_law", "ForceLaw", "ECP f*1(c, v), first step f*3(c, e, v)"),
    entry!("guarded_approach", "GuardedApproach", "ECP f*1(c, v), first step f*3(c, e, v)"),
    entry!("guided_body", "GuidedBody", "MP f*3(c0, e, v)"),
    entry!("jog", "Jog", "ECP f*0(c), first step f*2(c, e)"),
    entry!("joint_move", "JointMove", "ECP f*0(c), first step f*2(c, e)"),
    entry!("joint_spline", "JointSpline", "ECP f*0(c), first step f*2(c, e)"),
    entry!("joint_velocity", "JointVelocity", "ECP f*0(c), first step f*2(c, e)"),
    entry!("joint_via", "JointVia", "ECP f*0(c), first step f*2(c, e)"),
    entry!("line_via", "LineVia", "ECP f*0(c), first step f*2(c, e)"),
    entry!("moving_frame", "MovingFrame", "ECP f*0(c), first step f*2(c, e)"),
    entry!("ordered_force", "OrderedForce", "ECP f*7(c0, c, e, v)"),
    entry!("pose_spline_move", "PoseSplineMove", "ECP f*0(c), first step f*2(c, e)"),
    entry!("reach_state", "ReachState", "ECP f*4(c0, c), first step f*6(c0, c, e)"),
    entry!("replay", "Replay", "ECP f*0(c), first step f*2(c, e)"),
    entry!("rigid_carry", "RigidCarry", "MP f*0(c0), first step f*2(c0, e)"),
    entry!("settle", "Settle", "ECP f*2(c, e)"),
    entry!("shared_drive", "SharedDrive", "MP f*0(c0), first step f*2(c0, e)"),
    entry!("sleep", "Sleep", "ECP f*0(c)"),
    entry!("smooth_joint_move", "SmoothJointMove", "ECP f*0(c), first step f*2(c, e)"),
    entry!("spiral_search", "SpiralSearch", "ECP f*0(c), first step f*2(c, e)"),
    entry!("spline_track", "SplineTrack", "ECP f*0(c)"),
    entry!("squeezed_carry", "SqueezedCarry", "MP f*1(c0, v), first step f*3(c0, e, v)"),
    entry!("straight_line", "StraightLine", "ECP f*0(c), first step f*2(c, e)"),
    entry!("tell", "Tell", "ECP f*0(c)"),
    entry!("tilt_search", "TiltSearch", "ECP f*0(c), first step f*2(c, e)"),
    entry!("time_optimal_curve", "TimeOptimalCurve", "ECP f*0(c), first step f*2(c, e)"),
    entry!("time_optimal_joints", "TimeOptimalJoints", "ECP f*0(c), first step f*2(c, e)"),
    entry!("tool_offset", "ToolOffset", "ECP f*0(c)"),
    entry!("transmit_displacement", "TransmitDisplacement", "ECP f*4(c0, c)"),
    entry!("watched_transmit", "WatchedTransmit", "ECP f*6(c0, c, e)"),
    entry!("yielding_transmit", "YieldingTransmit", "ECP f*4(c0, c), first step f*6(c0, c, e)"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::generator::Generator;
    use mrroc::prelude::*;
    use mrroc_generators::cooperation::StraightBody;
    use mrroc_generators::generators::*;
    use mrroc_generators::teach::Jogging;
    use mrroc_robots::Irp6;

    struct Wrist;

    impl Sensor for Wrist {
        const KIND: &'static str = "wrist";
        type Reading = mrroc::pose::Wrench;
        type Configuration = ();
    }

    #[test]
    fn the_classes_are_those_of_the_code() {
        type Points = std::vec::IntoIter<nalgebra::Vector3<f64>>;
        type Two = [Irp6; 2];
        let classes = [
            AwaitOperator::<Irp6, fn() -> bool>::CLASS,
            CircularMove::<Irp6>::CLASS,
            CompliantTransmit::<Irp6, Wrist>::CLASS,
            ConstantOrder::<Two>::CLASS,
            CurveMove::<Irp6, mrroc_generators::curve::Helix>::CLASS,
            Delay::<Irp6>::CLASS,
            EyeInHand::<Irp6, Wrist>::CLASS,
            FollowMaster::<Two, StraightBody>::CLASS,
            FollowedFrame::<Irp6, Wrist>::CLASS,
            ForceLaw::<Irp6, Wrist>::CLASS,
            GuardedApproach::<Irp6, Wrist>::CLASS,
            GuidedBody::<Two, [Wrist; 2]>::CLASS,
            Jog::<Irp6, fn() -> Jogging>::CLASS,
            JointMove::<Irp6>::CLASS,
            JointSpline::<Irp6>::CLASS,
            JointVelocity::<Irp6>::CLASS,
            JointVia::<Irp6>::CLASS,
            LineVia::<Irp6>::CLASS,
            MovingFrame::<Irp6, Pose>::CLASS,
            OrderedForce::<Irp6, Wrist>::CLASS,
            PoseSplineMove::<Irp6>::CLASS,
            ReachState::<Irp6>::CLASS,
            Replay::<Irp6>::CLASS,
            RigidCarry::<Two, StraightBody>::CLASS,
            Settle::<Irp6>::CLASS,
            SharedDrive::<Two, StraightBody>::CLASS,
            Sleep::<Irp6>::CLASS,
            SmoothJointMove::<Irp6>::CLASS,
            SpiralSearch::<Irp6>::CLASS,
            SplineTrack::<Irp6, Points>::CLASS,
            SqueezedCarry::<Two, [Wrist; 2], StraightBody>::CLASS,
            StraightLine::<Irp6>::CLASS,
            Tell::<Irp6>::CLASS,
            TiltSearch::<Irp6>::CLASS,
            TimeOptimalCurve::<Irp6, mrroc_generators::curve::Helix>::CLASS,
            TimeOptimalJoints::<Irp6>::CLASS,
            ToolOffset::<Irp6>::CLASS,
            TransmitDisplacement::<Irp6>::CLASS,
            WatchedTransmit::<Irp6>::CLASS,
            YieldingTransmit::<Irp6>::CLASS,
        ];
        assert_eq!(CATALOGUE.len(), classes.len());
        for (entry, class) in CATALOGUE.iter().zip(classes) {
            assert_eq!(entry.class, class.to_string(), "{}", entry.name);
            let sensors = class.first_uses().sensors || class.next_uses().sensors;
            let orders = class.first_uses().order || class.next_uses().order;
            let is_of_an_ecp = class.level == mrroc::generator::Level::Ecp;
            assert_eq!(
                (entry.is_of_an_ecp(), entry.reads_sensors(), entry.reads_orders()),
                (is_of_an_ecp, sensors, is_of_an_ecp && orders)
            );
        }
    }

    #[test]
    fn every_generator_of_the_library_is_in_the_catalogue() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../generators-lib/src/generators");
        let mut files: Vec<_> = std::fs::read_dir(folder)
            .expect("the folder of the generators")
            .map(|entry| entry.expect("an entry").file_name().into_string().expect("a plain name"))
            // What a person jogs by is used as it is: its bounds are of the whole system, and no template.
            .filter(|file| file != "mod.rs" && file != "panel_jog.rs")
            .collect();
        files.sort();
        assert_eq!(files, CATALOGUE.iter().map(|entry| format!("{}.rs", entry.name)).collect::<Vec<_>>());
    }

    #[test]
    fn every_entry_says_what_it_does_and_is_short() {
        for entry in CATALOGUE {
            assert!(entry.source.starts_with("//! ") && entry.summary().ends_with('.'), "{}", entry.name);
            assert!(entry.source.contains(&format!("pub struct {}", entry.type_name)), "{}", entry.name);
            let copied = entry.copied();
            let (generator, tests) = copied.split_once("#[cfg(test)]").expect("its test");
            assert!(generator.lines().count() < 100 && tests.contains("#[test]"), "{}", entry.name);
        }
    }

    /// An example names the library's type, which a copy is not, and robots that a project may not have.
    #[test]
    fn every_entry_has_an_example_which_is_not_copied() {
        for entry in CATALOGUE {
            let (generator, _) = entry.source.split_once("#[cfg(test)]").expect("its test");
            let uses = "/// use mrroc_generators::generators::";
            assert!(generator.contains(uses) && generator.contains("/// assert"), "{}", entry.name);
            let copied = entry.copied();
            assert!(!copied.contains("```") && !copied.contains("/// assert"), "{}", entry.name);
            let code = |text: &str| text.lines().filter(|line| !line.starts_with("///")).count();
            assert_eq!(code(&copied), code(entry.source), "{}", entry.name);
        }
    }
}
