//! The messages of the Franka Control Interface, version 10, as bytes.
//!
//! In: the robot's state, a datagram of every millisecond, and its answers to requests, over TCP. Out: the answer to a state,
//! and requests. All numbers are little-endian, and nothing is padded. Laid out as in libfranka's
//! `research_interface/robot/rbk_types.h` and `service_types.h`.

use core::array;

use mrroc::robot::Load;
use nalgebra::{Matrix3, Vector3};

use crate::wrench::External;

/// How many joints the arm has.
pub const JOINTS: usize = 7;

/// The version of the interface.
pub const VERSION: u16 = 10;

/// The port at which a robot takes requests.
pub const PORT: u16 = 1337;

/// Bytes of a state, and of the answer to one.
pub const STATE: usize = 1377;
pub const COMMAND: usize = 371;

/// Errors that a state has flags for.
const ERRORS: usize = 41;

/// Where things are in a state. Before and between them are poses, the load, torques and contacts.
mod at {
    pub const F_T_EE: usize = 8 + 4 * 32;
    pub const EE_T_K: usize = F_T_EE + 64;
    pub const M_EE: usize = 8 + 4 * 96;
    pub const I_EE: usize = M_EE + 4;
    pub const F_X_CEE: usize = I_EE + 36;
    pub const K_F_EXT: usize = 8 + 4 * 221;
    pub const Q: usize = 8 + 4 * 147;
    pub const Q_D: usize = Q + 28;
    pub const DQ: usize = Q_D + 28;
    pub const DQ_D: usize = DQ + 28;
    pub const DDQ_D: usize = DQ_D + 28;
    pub const MOTION: usize = 8 + 4 * 320;
    pub const ERRORS: usize = MOTION + 2;
    pub const REASONS: usize = ERRORS + super::ERRORS;
    pub const MODE: usize = REASONS + super::ERRORS;
    pub const SUCCESS: usize = MODE + 1;
}

/// What the robot is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Not known to this version: the brakes may be closed.
    Other,
    /// It stands, and moves when it is told to.
    Idle,
    /// A motion runs.
    Move,
    /// A person guides it by hand.
    Guiding,
    /// It has stopped by itself.
    Reflex,
    /// The external activation device or the user stop is pressed.
    UserStopped,
    /// It recovers from what stopped it.
    Recovering,
}

impl Mode {
    fn read(byte: u8) -> Mode {
        match byte {
            1 => Mode::Idle,
            2 => Mode::Move,
            3 => Mode::Guiding,
            4 => Mode::Reflex,
            5 => Mode::UserStopped,
            6 => Mode::Recovering,
            _ => Mode::Other,
        }
    }
}

/// What the robot says in a period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Its count of periods of a millisecond.
    pub count: u64,
    /// Measured positions of the joints \[rad\].
    pub q: [f64; JOINTS],
    /// Their measured velocities [rad/s].
    pub dq: [f64; JOINTS],
    /// The positions that its regulators follow \[rad\], with 24 bits. The next position that it is told must go on from here.
    pub q_d: [f64; JOINTS],
    /// The velocities that they follow [rad/s].
    pub dq_d: [f64; JOINTS],
    /// The accelerations that they follow [rad/s²].
    pub ddq_d: [f64; JOINTS],
    /// Whether a motion by joint positions runs.
    pub follows_positions: bool,
    /// What it is doing.
    pub mode: Mode,
    /// The first error that holds now.
    pub error: Option<&'static str>,
    /// The first error that caused its last reflex.
    pub reason: Option<&'static str>,
    /// Which part of the last 100 answers came in time, 0 to 1; 0 without a motion.
    pub success: f64,
    /// The end effector that Desk has: what the robot carries besides its load; it may have numbers that are none.
    pub end_effector: Load,
    /// What it estimates of the wrench that acts on it; it may have numbers that are none.
    pub external: External,
}

impl State {
    /// What a datagram says; `None` if it is no state, or has numbers that are none, but for those of the wrench and
    /// of the end effector.
    #[must_use]
    pub fn read(bytes: &[u8]) -> Option<State> {
        let bytes: &[u8; STATE] = bytes.try_into().ok()?;
        let number = |at: usize| {
            let [a, b, c, d] = [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
            f64::from(f32::from_le_bytes([a, b, c, d]))
        };
        let float = |at: usize| Some(number(at)).filter(|number| number.is_finite());
        let joints = |at: usize| {
            let mut joints = [0.0; JOINTS];
            for (i, joint) in joints.iter_mut().enumerate() {
                *joint = float(at + 4 * i)?;
            }
            Some(joints)
        };
        let first = |at: usize| {
            let flags = &bytes[at..at + ERRORS];
            flags.iter().position(|&flag| flag != 0).map(|error| ERROR_NAMES[error])
        };
        Some(State {
            count: u64::from_le_bytes(bytes[..8].try_into().ok()?),
            q: joints(at::Q)?,
            dq: joints(at::DQ)?,
            q_d: joints(at::Q_D)?,
            dq_d: joints(at::DQ_D)?,
            ddq_d: joints(at::DDQ_D)?,
            follows_positions: bytes[at::MOTION] == 1,
            mode: Mode::read(bytes[at::MODE]),
            error: first(at::ERRORS),
            reason: first(at::REASONS),
            success: float(at::SUCCESS)?,
            end_effector: Load {
                mass: number(at::M_EE),
                centre: Vector3::from_fn(|i, _| number(at::F_X_CEE + 4 * i)),
                inertia: Matrix3::from_fn(|i, j| number(at::I_EE + 4 * (i + 3 * j))),
            },
            external: External {
                F_T_EE: array::from_fn(|i| number(at::F_T_EE + 4 * i)),
                EE_T_K: array::from_fn(|i| number(at::EE_T_K + 4 * i)),
                K_F_ext_hat_K: array::from_fn(|i| number(at::K_F_EXT + 4 * i)),
            },
        })
    }
}

/// The answer to the state of this count: the positions for the end of its period \[rad\], and whether they are the motion's
/// last.
#[must_use]
pub fn command(count: u64, q: &[f64; JOINTS], is_last: bool) -> [u8; COMMAND] {
    let mut bytes = [0; COMMAND];
    bytes[..8].copy_from_slice(&count.to_le_bytes());
    for (place, q) in bytes[8..64].chunks_exact_mut(8).zip(q) {
        place.copy_from_slice(&q.to_le_bytes());
    }
    // Velocities, a pose, a twist and an elbow lie between.
    bytes[313] = u8::from(is_last);
    bytes
}

/// How hard each joint is held [N m/rad], 0 to 14250: the robot's `setJointImpedance`.
pub type Stiffness = [f64; JOINTS];

/// When the robot takes something for a contact, which it only says, and for a collision, which is a reflex. The same while it
/// accelerates: its `setCollisionBehavior`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collision {
    /// External torques at the joints that are a contact [N m], > 0.
    pub contact_torques: [f64; JOINTS],
    /// Those that are a collision [N m], at least as large.
    pub collision_torques: [f64; JOINTS],
    /// Forces and torques at the flange that are a contact [N, N m], > 0.
    pub contact_forces: [f64; 6],
    /// Those that are a collision [N, N m], at least as large.
    pub collision_forces: [f64; 6],
}

/// What the robot is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request {
    /// To send its states to this port.
    Connect { port: u16 },
    /// To move by joint positions, with its own joint impedance.
    Move,
    /// To take something for a collision from these thresholds on.
    Collision(Collision),
    /// To hold its joints so hard.
    Stiffness(Stiffness),
    /// To reckon with this on its flange, besides its end effector.
    Load(Load),
    /// To recover from what stopped it.
    Recover,
}

/// The longest request.
pub const LONGEST_REQUEST: usize = HEADER + 416;

/// Bytes before what a request or its answer says.
const HEADER: usize = 12;

impl Request {
    const fn number(self) -> u32 {
        match self {
            Request::Connect { .. } => 0,
            Request::Move => 1,
            Request::Collision(_) => 3,
            Request::Stiffness(_) => 4,
            Request::Load(_) => 9,
            Request::Recover => 10,
        }
    }

    /// Writes it with this number of its own, and says how many bytes it has.
    pub fn write(self, id: u32, bytes: &mut [u8; LONGEST_REQUEST]) -> usize {
        bytes.fill(0);
        let mut len = HEADER;
        let mut put = |what: &[u8]| {
            bytes[len..len + what.len()].copy_from_slice(what);
            len += what.len();
        };
        match self {
            Request::Connect { port } => {
                put(&VERSION.to_le_bytes());
                put(&port.to_le_bytes());
            }
            Request::Move => {
                // Joint impedance, joint positions.
                put(&0_u32.to_le_bytes());
                put(&0_u32.to_le_bytes());
                // How far it may be from the path, and from the goal: m, rad, rad. These are libfranka's.
                for deviation in [10.0_f64, 3.12, core::f64::consts::TAU].repeat(2) {
                    put(&deviation.to_le_bytes());
                }
                // Not its own generator of motions between positions, which has a velocity for each joint.
                put(&[0; 57]);
            }
            Request::Collision(Collision {
                contact_torques,
                collision_torques,
                contact_forces,
                collision_forces,
            }) => {
                // While it accelerates, and while it does not.
                for torque in [contact_torques, collision_torques].repeat(2).iter().flatten() {
                    put(&torque.to_le_bytes());
                }
                for force in [contact_forces, collision_forces].repeat(2).iter().flatten() {
                    put(&force.to_le_bytes());
                }
            }
            Request::Stiffness(stiffness) => stiffness.iter().for_each(|one| put(&one.to_le_bytes())),
            Request::Load(Load { mass, centre, inertia }) => {
                // nalgebra's matrices are column-major, as the robot's.
                let words = [mass].into_iter().chain(centre.iter().copied()).chain(inertia.iter().copied());
                words.for_each(|word| put(&word.to_le_bytes()));
            }
            Request::Recover => {}
        }
        for (place, number) in [self.number(), id, len as u32].into_iter().enumerate() {
            bytes[4 * place..4 * place + 4].copy_from_slice(&number.to_le_bytes());
        }
        len
    }
}

/// An answer of the robot to a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// The request's number.
    pub id: u32,
    /// What it says: 0 is success; the others depend on what was asked for.
    pub status: u8,
    /// Its version, where it answers a connection; 0 where it says none.
    pub version: u16,
}

/// The most bytes that an answer to one of these requests may have.
pub const LONGEST_ANSWER: usize = 64;

impl Answer {
    /// The answer that `bytes` begin with, and how many of them it has. `None` while it is not there as a whole.
    ///
    /// # Errors
    /// It is longer than any answer, or too short for one.
    #[allow(clippy::result_unit_err)]
    pub fn read(bytes: &[u8]) -> Result<Option<(Answer, usize)>, ()> {
        let number = |at: usize| {
            let bytes = bytes.get(at..at + 4)?.try_into().ok()?;
            Some(u32::from_le_bytes(bytes))
        };
        let (Some(id), Some(size)) = (number(4), number(8)) else { return Ok(None) };
        let size = size as usize;
        if !(HEADER + 1..=LONGEST_ANSWER).contains(&size) {
            return Err(());
        }
        let Some(says) = bytes.get(HEADER..size) else { return Ok(None) };
        let version = says.get(1..3).map_or(0, |version| u16::from_le_bytes([version[0], version[1]]));
        Ok(Some((Answer { id, status: says[0], version }, size)))
    }
}

/// Franka's names of the errors, in the order of their flags.
const ERROR_NAMES: [&str; ERRORS] = [
    "joint_position_limits_violation",
    "cartesian_position_limits_violation",
    "self_collision_avoidance_violation",
    "joint_velocity_violation",
    "cartesian_velocity_violation",
    "force_control_safety_violation",
    "joint_reflex",
    "cartesian_reflex",
    "max_goal_pose_deviation_violation",
    "max_path_pose_deviation_violation",
    "cartesian_velocity_profile_safety_violation",
    "joint_position_motion_generator_start_pose_invalid",
    "joint_motion_generator_position_limits_violation",
    "joint_motion_generator_velocity_limits_violation",
    "joint_motion_generator_velocity_discontinuity",
    "joint_motion_generator_acceleration_discontinuity",
    "cartesian_position_motion_generator_start_pose_invalid",
    "cartesian_motion_generator_elbow_limit_violation",
    "cartesian_motion_generator_velocity_limits_violation",
    "cartesian_motion_generator_velocity_discontinuity",
    "cartesian_motion_generator_acceleration_discontinuity",
    "cartesian_motion_generator_elbow_sign_inconsistent",
    "cartesian_motion_generator_start_elbow_invalid",
    "force_controller_desired_force_tolerance_violation",
    "start_elbow_sign_inconsistent",
    "communication_constraints_violation",
    "power_limit_violation",
    "cartesian_motion_generator_joint_position_limits_violation",
    "cartesian_motion_generator_joint_velocity_limits_violation",
    "cartesian_motion_generator_joint_velocity_discontinuity",
    "cartesian_motion_generator_joint_acceleration_discontinuity",
    "cartesian_position_motion_generator_invalid_frame_flag",
    "controller_torque_discontinuity",
    "joint_p2p_insufficient_torque_for_planning",
    "tau_J_range_violation",
    "instability_detected",
    "joint_move_in_wrong_direction",
    "cartesian_spline_motion_generator_violation",
    "joint_via_motion_generator_planning_joint_limit_violation",
    "base_acceleration_initialization_timeout",
    "base_acceleration_invalid_reading",
];

/// Answers were missing for too long.
pub const COMMUNICATION: &str = ERROR_NAMES[25];

/// States of a robot, for tests.
#[cfg(test)]
pub mod testing {
    use super::*;

    /// The bytes of a state.
    pub fn bytes(state: &State, motion: u8) -> [u8; STATE] {
        let mut bytes = [0; STATE];
        bytes[..8].copy_from_slice(&state.count.to_le_bytes());
        let places = [at::Q, at::DQ, at::Q_D, at::DQ_D, at::DDQ_D];
        for (at, joints) in places.into_iter().zip([state.q, state.dq, state.q_d, state.dq_d, state.ddq_d]) {
            for (place, joint) in bytes[at..at + 28].chunks_exact_mut(4).zip(joints) {
                place.copy_from_slice(&(joint as f32).to_le_bytes());
            }
        }
        let external = &state.external;
        let mut put = |at: usize, numbers: &[f64]| {
            for (place, number) in bytes[at..].chunks_exact_mut(4).zip(numbers) {
                place.copy_from_slice(&(*number as f32).to_le_bytes());
            }
        };
        put(at::F_T_EE, &external.F_T_EE);
        put(at::EE_T_K, &external.EE_T_K);
        put(at::K_F_EXT, &external.K_F_ext_hat_K);
        put(at::M_EE, &[state.end_effector.mass]);
        put(at::I_EE, state.end_effector.inertia.as_slice());
        put(at::F_X_CEE, state.end_effector.centre.as_slice());
        bytes[at::MOTION] = motion;
        let flag = |error: Option<&str>| ERROR_NAMES.iter().position(|name| Some(*name) == error);
        if let Some(error) = flag(state.error) {
            bytes[at::ERRORS + error] = 1;
        }
        if let Some(error) = flag(state.reason) {
            bytes[at::REASONS + error] = 1;
        }
        bytes[at::MODE] = match state.mode {
            Mode::Other => 0,
            Mode::Idle => 1,
            Mode::Move => 2,
            Mode::Guiding => 3,
            Mode::Reflex => 4,
            Mode::UserStopped => 5,
            Mode::Recovering => 6,
        };
        bytes[at::SUCCESS..].copy_from_slice(&(state.success as f32).to_le_bytes());
        bytes
    }

    /// A pose that is none.
    const IDENTITY: [f64; 16] =
        [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

    /// A robot that stands at `q` \[rad\], and feels nothing.
    pub fn standing(count: u64, q: [f64; JOINTS], mode: Mode) -> State {
        State {
            count,
            q,
            dq: [0.0; JOINTS],
            q_d: q,
            dq_d: [0.0; JOINTS],
            ddq_d: [0.0; JOINTS],
            follows_positions: mode == Mode::Move,
            mode,
            error: None,
            reason: None,
            success: 0.0,
            end_effector: Load::NONE,
            external: External { F_T_EE: IDENTITY, EE_T_K: IDENTITY, K_F_ext_hat_K: [0.0; 6] },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::testing::{bytes, standing};
    use super::*;

    #[test]
    fn a_state_is_read_from_its_1377_bytes_and_from_no_others() {
        let mut state = standing(4711, [0.5, -0.25, 0.125, -1.5, 1.0, 1.75, -2.0], Mode::Reflex);
        state.dq = [0.5; JOINTS];
        state.q_d = [0.25; JOINTS];
        state.error = Some("joint_reflex");
        state.reason = Some(COMMUNICATION);
        state.success = 0.5;
        let good = bytes(&state, 0);
        assert_eq!(State::read(&good), Some(state));
        assert_eq!(State::read(&good[1..]), None);
        assert_eq!(State::read(&[good.as_slice(), &[0]].concat()), None);
        for at in [at::Q, at::Q_D + 24, at::DDQ_D, at::SUCCESS] {
            let mut bad = good;
            bad[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
            assert_eq!(State::read(&bad), None, "at {at}");
        }
        assert_eq!((at::SUCCESS + 4, at::MOTION), (STATE, 1288));
    }

    /// Numbers that are their places among the floats after the count: `rbk_types.h` has six poses of 16, two loads of 13, two
    /// elbows of 2, 8 by 7 of the joints, 7 + 6 + 7 + 6 of contacts and collisions, 7 external torques, then the wrench in
    /// the axes of the base, then in those of K.
    #[test]
    fn the_wrench_and_its_frames_are_read_from_their_places_whatever_they_are() {
        let mut datagram = [0; STATE];
        for (place, bytes) in datagram[8..].chunks_exact_mut(4).take(320).enumerate() {
            bytes.copy_from_slice(&(place as f32).to_le_bytes());
        }
        let State { external, end_effector, .. } = State::read(&datagram).expect("a state");
        // A load is its mass, its inertia by columns and its centre.
        assert_eq!(end_effector.mass, 96.0);
        assert_eq!(end_effector.inertia.as_slice(), array::from_fn::<_, 9, _>(|i| (97 + i) as f64));
        assert_eq!(end_effector.centre.as_slice(), [106.0, 107.0, 108.0]);
        let from = |place: usize| move |i: usize| (place + i) as f64;
        assert_eq!(external.F_T_EE, array::from_fn(from(2 * 16)));
        assert_eq!(external.EE_T_K, array::from_fn(from(3 * 16)));
        let before = 6 * 16 + 2 * 13 + 2 * 2 + 8 * 7 + (7 + 6 + 7 + 6) + 7 + 6;
        assert_eq!(external.K_F_ext_hat_K, array::from_fn(from(before)));
        // A robot that estimates no wrench still says where it is.
        datagram[at::K_F_EXT..at::K_F_EXT + 4].copy_from_slice(&f32::NAN.to_le_bytes());
        assert_eq!(State::read(&datagram).expect("a state").external.wrench(), None);
    }

    #[test]
    fn requests_have_the_sizes_of_the_interface() {
        let mut bytes = [0; LONGEST_REQUEST];
        assert_eq!(Request::Connect { port: 0x1234 }.write(7, &mut bytes), 16);
        assert_eq!(bytes[..16], [0, 0, 0, 0, 7, 0, 0, 0, 16, 0, 0, 0, 10, 0, 0x34, 0x12]);
        assert_eq!(Request::Move.write(8, &mut bytes), 125);
        assert_eq!(bytes[20..28], 10.0_f64.to_le_bytes());
        assert_eq!(Request::Recover.write(9, &mut bytes), 12);
        assert_eq!(bytes[..4], [10, 0, 0, 0]);
    }

    #[test]
    fn an_answer_may_come_in_pieces_and_a_size_that_none_has_is_refused() {
        let whole = [0, 0, 0, 0, 7, 0, 0, 0, 15, 0, 0, 0, 1, 9, 0];
        for len in 0..whole.len() {
            assert_eq!(Answer::read(&whole[..len]), Ok(None), "{len} bytes");
        }
        let answer = Answer { id: 7, status: 1, version: 9 };
        assert_eq!(Answer::read(&whole), Ok(Some((answer, 15))));
        for size in [0, 12, 65, u32::MAX] {
            let mut bad = whole;
            bad[8..12].copy_from_slice(&size.to_le_bytes());
            assert_eq!(Answer::read(&bad), Err(()), "{size}");
        }
    }

    #[test]
    fn a_command_names_its_state_and_has_its_positions_first() {
        let bytes = command(3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], true);
        assert_eq!(bytes[..8], 3_u64.to_le_bytes());
        assert_eq!(bytes[56..64], 7.0_f64.to_le_bytes());
        assert_eq!((bytes[313], bytes[370]), (1, 0));
        assert!(bytes[64..313].iter().all(|&byte| byte == 0));
    }
}
