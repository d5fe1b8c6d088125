//! The visible shapes of an arm read from a URDF: the STL files that its `<visual>` elements name.
//!
//! In: the URDF, the chain, and the folder of the file. Out: files in that folder with their places on the links, for panels. Nothing
//! that moves depends on them.

use std::path::{Component, Path, PathBuf};

use mrroc::prelude::*;
use mrroc::robot::LinkMesh;
use nalgebra::Translation3;

use super::chain::turn_of_z;
use super::document::{Element, Tree, origin, parsed};
use super::error::UrdfError;
use super::places::{Place, axis, places};
use super::serial::Serial;

impl<const N: usize> Serial<N> {
    /// The same with the visible shapes of its links, as the `<visual>` elements say of the URDF `text` that it was read from, with
    /// the same `base` and `tip`.
    ///
    /// A mesh is an STL file in `folder` or below it: `meshes/arm.stl`, or `package://NAME/meshes/arm.stl` with the package's name left
    /// out. If one of the chain's shapes is anything else, or its file is not there, the arm is given none, and is drawn by its
    /// capsules or bars.
    #[must_use]
    pub fn with_meshes(mut self, text: &str, base: &str, tip: &str, folder: &Path) -> Self {
        self.meshes = read(text, base, tip, folder).ok().flatten().unwrap_or_default();
        self
    }
}

/// The meshes of a chain; `None` where one of its shapes is none.
fn read(text: &str, base: &str, tip: &str, folder: &Path) -> Result<Option<Vec<LinkMesh>>, UrdfError> {
    let document = parsed(text)?;
    let tree = Tree::of(&document)?;
    let (mut fixed, mut frame, mut meshes) = (Pose::identity(), 0, Vec::new());
    let mut whole = collect(&tree, base, (&fixed, frame), folder, &mut meshes)?;
    for Place { joint, X_PJ, moves } in places(&tree, base, tip)? {
        fixed *= X_PJ;
        if moves.is_some() {
            // The frame of a joint that moves has its z along the axis.
            fixed = Pose::from_parts(Translation3::identity(), turn_of_z(axis(&joint)?).inverse());
            frame += 1;
        }
        whole &= collect(&tree, joint.child, (&fixed, frame), folder, &mut meshes)?;
    }
    Ok(whole.then_some(meshes))
}

/// Adds the meshes of a link that stands at `X_JL` in a frame of the robot; whether all of its shapes are such.
#[allow(non_snake_case)]
fn collect(
    tree: &Tree<'_, '_>,
    link: &str,
    (X_JL, frame): (&Pose, usize),
    folder: &Path,
    meshes: &mut Vec<LinkMesh>,
) -> Result<bool, UrdfError> {
    let Some(element) = tree.link(link) else { return Ok(true) };
    for visual in element.all("visual") {
        let pose = X_JL * origin(&visual, tree.has_quaternions)?;
        let Some(mesh) = mesh(&visual)? else { return Ok(false) };
        let Some(file) = mesh.text("filename")?.and_then(|name| file(folder, name, &["stl"])) else {
            return Ok(false);
        };
        let scale = mesh.numbers::<3>("scale")?.unwrap_or([1.0; 3]);
        meshes.push(LinkMesh { file, frame, pose, scale });
    }
    Ok(true)
}

fn mesh<'a, 'i>(visual: &Element<'a, 'i>) -> Result<Option<Element<'a, 'i>>, UrdfError> {
    match visual.child("geometry")? {
        Some(geometry) => geometry.child("mesh"),
        None => Ok(None),
    }
}

/// The file that a mesh names, in a folder or below it, if there is one and its name has one of these ends. Of `package://NAME/rest` the
/// package's name is left out.
pub(super) fn file(folder: &Path, name: &str, extensions: &[&str]) -> Option<PathBuf> {
    let name = match name.strip_prefix("package://") {
        Some(of_package) => of_package.split_once('/')?.1,
        None => name,
    };
    // The folder of a file that is named without one.
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let path = Path::new(name);
    let is_below = path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    let is_known =
        path.extension().is_some_and(|end| extensions.iter().any(|known| end.eq_ignore_ascii_case(known)));
    // A link of the file system may lead elsewhere.
    let found = folder.join(path).canonicalize().ok().filter(|_| is_below && is_known)?;
    found.starts_with(folder.canonicalize().ok()?).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3};

    /// An arm of one joint about y, whose two links have a mesh each.
    fn arm(of_upper: &str) -> String {
        format!(
            r#"<robot name="r">
<link name="base"><visual><geometry><mesh filename="package://r/base.stl"/></geometry></visual></link>
<link name="upper"><visual><origin xyz="0 0 0.2" rpy="0 0 0.5"/><geometry>{of_upper}</geometry></visual></link>
<joint name="turn" type="revolute"><origin xyz="0.1 0 0.3" rpy="0.4 0 0"/><parent link="base"/><child link="upper"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="2" effort="1"/></joint></robot>"#
        )
    }

    /// A folder with the meshes of both.
    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("mrroc-meshes-{name}-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("parts")).expect("a folder");
        for name in ["base.stl", "parts/Upper.STL"] {
            std::fs::write(folder.join(name), "solid").expect("a file");
        }
        folder
    }

    fn robot(text: &str, folder: &Path) -> Serial<1> {
        let built = Serial::<1>::from_urdf(text, "base", "upper").expect("a URDF");
        let robot = built.with_acceleration([5.0].into()).expect("an acceleration");
        robot.with_meshes(text, "base", "upper", folder)
    }

    #[test]
    fn meshes_stand_where_the_urdf_puts_them_and_move_with_their_links() {
        let folder = folder("placed");
        let text = arm(r#"<mesh filename="./parts/Upper.STL" scale="0.001 0.001 0.001"/>"#);
        let with = robot(&text, &folder);
        assert_eq!(Robot::meshes(&with).len(), 2);
        assert_eq!(Robot::meshes(&with)[1].scale, [0.001; 3]);
        let q = [0.7].into();
        let mut frames = Vec::new();
        with.frames(&q, &mut |frame| frames.push(*frame));
        // By hand, as the URDF says: origin of the joint, turn about y, origin of the shape.
        let turned = |axis: Vector3<f64>| Pose::rotation(axis);
        let expected = Pose::translation(0.1, 0.0, 0.3)
            * turned(Vector3::x() * 0.4)
            * turned(Vector3::y() * 0.7)
            * Pose::translation(0.0, 0.0, 0.2)
            * turned(Vector3::z() * 0.5);
        let mesh = &Robot::meshes(&with)[1];
        let at = frames[mesh.frame] * mesh.pose;
        for point in [Point3::origin(), Point3::new(1.0, 2.0, 3.0)] {
            assert!((at * point - expected * point).norm() < 1e-12, "{at} is not {expected}");
        }
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn fault_242_what_is_outside_of_the_folder_of_a_urdf_is_no_mesh() {
        let folder = folder("outside");
        // Beside the folder there is one, which is not its own.
        let beside = folder.with_extension("stl");
        std::fs::copy(folder.join("base.stl"), &beside).expect("a file");
        let name = beside.file_name().and_then(|name| name.to_str()).expect("a name");
        let [above, absolute] = [format!("../{name}"), beside.display().to_string()]
            .map(|name| format!(r#"<mesh filename="{name}"/>"#));
        // What is elsewhere, is not there or is no STL leaves the arm as it was.
        std::fs::write(folder.join("upper.dae"), "").expect("a file");
        for other in [
            above.as_str(),
            absolute.as_str(),
            r#"<mesh filename="missing.stl"/>"#,
            r#"<mesh filename="upper.dae"/>"#,
            r#"<mesh filename="file:///base.stl"/>"#,
            r#"<box size="1 1 1"/>"#,
        ] {
            assert!(Robot::meshes(&robot(&arm(other), &folder)).is_empty(), "{other}");
        }
        std::os::unix::fs::symlink(&beside, folder.join("link.stl")).expect("a link");
        assert!(
            Robot::meshes(&robot(&arm(r#"<mesh filename="link.stl"/>"#), &folder)).is_empty(),
            "a link that leads elsewhere"
        );
        std::fs::remove_file(&beside).expect("removed");
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
