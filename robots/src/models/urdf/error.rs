//! Why a robot cannot be made from a URDF: every message names the element and says what to write.

use std::path::PathBuf;

use crate::models::mesh::MeshError;
use crate::models::xml::TooMuchXml;

/// A URDF that gives no robot. One variant is one cause; `line` counts from 1.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UrdfError {
    /// The file cannot be read.
    #[error("{}: {why}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        #[source]
        why: std::io::Error,
    },
    /// The text is longer than any robot's description.
    #[error("the URDF has more than {limit} bytes, which no robot needs: give the file of one robot")]
    TooLarge {
        /// Longest text that is read \[bytes\].
        limit: usize,
    },
    /// An element has more attributes than any URDF element, or sees more namespaces.
    #[error("{0}: remove what a URDF has no need of")]
    TooMuch(#[from] TooMuchXml),
    /// The text is not XML.
    #[error("line {line}, column {column}: not well-formed XML: {what}")]
    Xml {
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// What the XML reader says.
        what: String,
    },
    /// A document type declaration, whose entities could grow without bound.
    #[error("line {line}: a document type declaration: remove <!DOCTYPE ..>, URDF has none")]
    Doctype {
        /// Line, from 1.
        line: usize,
    },
    /// A xacro macro file.
    #[error("line {line}: {what} is xacro, not URDF: expand it first, `xacro robot.urdf.xacro > robot.urdf`")]
    Xacro {
        /// Line, from 1.
        line: usize,
        /// The element or the expression.
        what: String,
    },
    /// Another kind of XML.
    #[error("line {line}: the root element is <{found}>: a URDF begins with <robot>")]
    NotRobot {
        /// Line, from 1.
        line: usize,
        /// Name of the root element.
        found: String,
    },
    /// An element that must be there is not.
    #[error("line {line}: {element} has no <{child}>: write {write}")]
    MissingElement {
        /// Line, from 1.
        line: usize,
        /// The element by its name.
        element: String,
        /// What is missing inside.
        child: &'static str,
        /// An example.
        write: &'static str,
    },
    /// An element that may stand once stands twice.
    #[error("line {line}: {element} has a second <{child}>: keep one")]
    RepeatedElement {
        /// Line of the second.
        line: usize,
        /// The element by its name.
        element: String,
        /// What is repeated inside.
        child: &'static str,
    },
    /// An attribute that must be there is not.
    #[error("line {line}: {element} has no attribute {attribute}: write {write}")]
    MissingAttribute {
        /// Line, from 1.
        line: usize,
        /// The element by its name.
        element: String,
        /// The attribute.
        attribute: &'static str,
        /// An example.
        write: &'static str,
    },
    /// An attribute that URDF does not have: most likely a typing mistake, which would change the robot.
    #[error("line {line}: {element} has an attribute {attribute}, which is not read: write one of {known}")]
    UnknownAttribute {
        /// Line, from 1.
        line: usize,
        /// The element by its name.
        element: String,
        /// The attribute.
        attribute: String,
        /// What is read there.
        known: String,
    },
    /// Two attributes that say the same.
    #[error("line {line}: {element} has both rpy and quat_xyzw: keep one")]
    TwoOrientations {
        /// Line, from 1.
        line: usize,
        /// The element by its name.
        element: String,
    },
    /// `quat_xyzw` in a file that declares a version which does not have it, so that other readers ignore it.
    #[error(
        "line {line}: {element} has quat_xyzw, which is read from version 1.1: write <robot version=\"1.1\">, or rpy"
    )]
    QuaternionBeforeItsTime {
        /// Line, from 1.
        line: usize,
        /// The element by its name.
        element: String,
    },
    /// A value that is not what it should be.
    #[error("line {line}: {element}: {attribute}=\"{text}\" is not {expected}")]
    BadValue {
        /// Line, from 1.
        line: usize,
        /// The element by its name.
        element: String,
        /// The attribute.
        attribute: &'static str,
        /// What stands there.
        text: String,
        /// What should stand there: `"three finite numbers"`.
        expected: &'static str,
    },
    /// Two links, or two joints, of one name.
    #[error("line {line}: a second {kind} \"{name}\" (the first stands in line {first}): rename one")]
    DuplicateName {
        /// Line of the second.
        line: usize,
        /// Line of the first.
        first: usize,
        /// `"link"` or `"joint"`.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A joint names a link that the file does not have.
    #[error("line {line}: joint \"{joint}\": its {role} \"{link}\" is no link of this file: {help}")]
    UnknownLink {
        /// Line, from 1.
        line: usize,
        /// The joint.
        joint: String,
        /// `"parent"` or `"child"`.
        role: &'static str,
        /// The name that is no link.
        link: String,
        /// What to write.
        help: String,
    },
    /// A link is the child of two joints: a closed linkage, or a mistake.
    #[error(
        "line {line}: link \"{link}\" is the child of joint \"{first}\" and of joint \"{second}\": \
         a URDF is a tree, a link has one parent"
    )]
    TwoParents {
        /// Line of the second joint.
        line: usize,
        /// The link.
        link: String,
        /// The first joint.
        first: String,
        /// The second joint.
        second: String,
    },
    /// Following parents from the tip never ends.
    #[error("line {line}: joint \"{joint}\" closes a loop through link \"{link}\": a URDF is a tree")]
    Loop {
        /// Line of the joint that closes the loop.
        line: usize,
        /// That joint.
        joint: String,
        /// The link that was met twice.
        link: String,
    },
    /// The base or the tip that was asked for is not in the file.
    #[error("the URDF has no link \"{name}\", asked for as {role}: {help}")]
    NoSuchLink {
        /// `"base"`, `"tip"` or `"link to leave out"`.
        role: &'static str,
        /// The name asked for.
        name: String,
        /// What to write.
        help: String,
    },
    /// No link, or several, on which all others hang, and no base was asked for.
    #[error("{} links of the URDF hang on no other ({}): name the base link of the arm", roots.len(), roots.join(", "))]
    NoRoot {
        /// The links that hang on no other.
        roots: Vec<String>,
    },
    /// The tip does not hang on the base.
    #[error("link \"{tip}\" does not hang on link \"{base}\": {help}")]
    NotBelow {
        /// The base asked for.
        base: String,
        /// The tip asked for.
        tip: String,
        /// What to write.
        help: String,
    },
    /// The chain has another number of moving joints than the type.
    #[error(
        "the chain from \"{base}\" to \"{tip}\" has {count} moving joints ({names}), Serial<{asked}> was asked for: {help}"
    )]
    WrongCount {
        /// The base asked for.
        base: String,
        /// The tip asked for.
        tip: String,
        /// Moving joints in the chain, mimic joints not counted.
        count: usize,
        /// Their names.
        names: String,
        /// The type's number of joints.
        asked: usize,
        /// What to write.
        help: String,
    },
    /// More joints than a chain may have, dependent ones included.
    #[error(
        "the chain from \"{base}\" to \"{tip}\" has more than {limit} joints that move, mimic joints included"
    )]
    TooManyJoints {
        /// The base asked for.
        base: String,
        /// The tip asked for.
        tip: String,
        /// The most that are served.
        limit: usize,
    },
    /// More links hang on one another than on any robot.
    #[error(
        "more than {limit} links hang on one another down to \"{link}\", off the chain: leave them out, `Meshes::without`"
    )]
    TooDeep {
        /// The first link that is too much.
        link: String,
        /// The most that are served.
        limit: usize,
    },
    /// A joint of a type that no single coordinate describes.
    #[error(
        "line {line}: joint \"{joint}\" is of type \"{kind}\": write revolute, continuous, prismatic or fixed, \
         or choose a chain without it"
    )]
    UnsupportedJoint {
        /// Line, from 1.
        line: usize,
        /// The joint.
        joint: String,
        /// Its type.
        kind: String,
    },
    /// A collision shape that no capsules are made of.
    #[error(
        "line {line}: {element} holds no box, cylinder, capsule, sphere or mesh: write one of these, or use \
         SerialOutline::new with a radius"
    )]
    UnsupportedCollision {
        /// Line, from 1.
        line: usize,
        /// The element by its name.
        element: String,
    },
    /// A mesh of a collision shape that is not there, or whose folder is not known.
    #[error("line {line}: {element}: \"{name}\" {why}")]
    NoMesh {
        /// Line, from 1.
        line: usize,
        /// The element by its name.
        element: String,
        /// What it names.
        name: String,
        /// Why it is none, and what to do.
        why: &'static str,
    },
    /// A mesh of a collision shape that cannot be read or covered.
    #[error("line {line}: {element}: {why}")]
    BadMesh {
        /// Line, from 1.
        line: usize,
        /// The element by its name.
        element: String,
        /// Why, with the file.
        #[source]
        why: Box<MeshError>,
    },
    /// No link of the chain has a collision shape.
    #[error("no link from \"{base}\" to \"{tip}\" has a <collision>: use SerialOutline::new with a radius")]
    NoCollision {
        /// The base asked for.
        base: String,
        /// The tip asked for.
        tip: String,
    },
    /// The position limits leave nothing to move in.
    #[error(
        "line {line}: joint \"{joint}\": lower={lower} is not below upper={upper}: a fixed joint has type=\"fixed\""
    )]
    EmptyRange {
        /// Line, from 1.
        line: usize,
        /// The joint.
        joint: String,
        /// Lower limit [rad or m].
        lower: f64,
        /// Upper limit [rad or m].
        upper: f64,
    },
    /// A mimic joint follows a joint that the chain does not have.
    #[error(
        "line {line}: joint \"{joint}\" mimics \"{leader}\", which is no moving joint between base and tip: \
         choose a chain that contains both, or make it fixed"
    )]
    MimicOutside {
        /// Line, from 1.
        line: usize,
        /// The mimic joint.
        joint: String,
        /// The joint that it should follow.
        leader: String,
    },
    /// Mimic joints follow one another in a circle.
    #[error(
        "line {line}: joint \"{joint}\" mimics itself, through {through}: name a joint that moves by itself"
    )]
    MimicLoop {
        /// Line, from 1.
        line: usize,
        /// The mimic joint.
        joint: String,
        /// The joint that it names.
        through: String,
    },
    /// The limits of a mimic joint leave its leader nothing to move in.
    #[error(
        "line {line}: joint \"{joint}\" keeps its limits for no position of \"{leader}\" within the limits of that: \
         widen one of the two"
    )]
    MimicLimits {
        /// Line, from 1.
        line: usize,
        /// The mimic joint.
        joint: String,
        /// The joint that it follows.
        leader: String,
    },
    /// A joint that nothing moves, because it mimics with multiplier 0, stands outside of its limits.
    #[error(
        "line {line}: joint \"{joint}\" mimics with multiplier 0, so it stands at its offset {offset}, outside of its limits \
         {lower} to {upper}: correct the multiplier or the offset"
    )]
    MimicStands {
        /// Line, from 1.
        line: usize,
        /// The mimic joint.
        joint: String,
        /// Where it stands [rad or m].
        offset: f64,
        /// Lower limit [rad or m].
        lower: f64,
        /// Upper limit [rad or m].
        upper: f64,
    },
    /// A link has a negative moment of inertia about an axis.
    #[error(
        "line {line}: link \"{link}\": its <inertia> cannot be: principal moments {} kg m^2, of which none may be negative: \
         correct the moments and the signs of the products",
        moments(principal)
    )]
    NegativeInertia {
        /// Line of `<inertia>`, from 1.
        line: usize,
        /// The link.
        link: String,
        /// Principal moments, in ascending order [kg m²].
        principal: [f64; 3],
    },
    /// A link has a larger moment of inertia than any mass could have, whatever its shape.
    #[error(
        "line {line}: link \"{link}\": its <inertia> cannot be: principal moments {} kg m^2, of which the largest is at most \
         the sum of the others in any body ({:.0} % more are taken for rounding): correct it, or write the moments of a sphere, \
         0.4 m r^2 each", moments(principal), 100.0 * limit
    )]
    ImpossibleInertia {
        /// Line of `<inertia>`, from 1.
        line: usize,
        /// The link.
        link: String,
        /// Principal moments, in ascending order [kg m²].
        principal: [f64; 3],
        /// By how much the largest may exceed the sum of the others, as a part of that; of all links together that are fixed to this one.
        limit: f64,
    },
    /// An acceleration or a jerk that the caller gave.
    #[error("joint \"{joint}\": {what} {value} is not a finite number above 0")]
    BadCallerLimit {
        /// The joint.
        joint: String,
        /// `"acceleration"` or `"jerk"`.
        what: &'static str,
        /// What was given [rad or m, per s² or s³].
        value: f64,
    },
    /// Position limits that the caller gave.
    #[error(
        "joint \"{joint}\": positions {lower} to {upper} are no range within {lowest} to {highest}: narrow them"
    )]
    CallerRange {
        /// The joint.
        joint: String,
        /// Lower limit given [rad or m].
        lower: f64,
        /// Upper limit given [rad or m].
        upper: f64,
        /// Lowest position that the file allows [rad or m].
        lowest: f64,
        /// Highest position that the file allows [rad or m].
        highest: f64,
    },
    /// An acceleration or a jerk above the one that the file states (URDF 1.2).
    #[error("joint \"{joint}\": {what} {value} exceeds {limit}, which the URDF states: give at most that")]
    AboveFile {
        /// The joint.
        joint: String,
        /// `"acceleration"` or `"jerk"`.
        what: &'static str,
        /// What was given [rad or m, per s² or s³].
        value: f64,
        /// What the file states.
        limit: f64,
    },
    /// The arm is not the one whose solutions its own begin with.
    #[error(
        "the arm is {} mm and {angle:.3} rad off its nominal one, at most {} mm and {most_angle} rad: it is another model",
        (position * 1e3).round(), most_position * 1e3
    )]
    NotNear {
        /// The largest distance of their flanges \[m\].
        position: f64,
        /// The largest turn between them \[rad\].
        angle: f64,
        /// Largest distance allowed \[m\].
        most_position: f64,
        /// Largest turn allowed \[rad\].
        most_angle: f64,
    },
    /// The arm that another one is near has no closed form.
    #[error("the nominal arm has no closed form, with whose solutions others could begin")]
    NoClosedForm,
}

/// Principal moments as a message says them.
fn moments(principal: &[f64; 3]) -> String {
    principal.map(|moment| format!("{moment:.3e}")).join(", ")
}
