//! Obstacles of a cell file that are meshes.
//!
//! In: an entry with `mesh`, and the file that it names. Out: the capsules that cover it, in the frame O of the obstacle, to keep
//! robots away from it and to draw it.

use mrroc::cell::CellError;
use mrroc::observe::solid::Solid;
use mrroc::pose::Pose;
use mrroc_launch::cell_file::{ObstacleEntry, ObstacleMesh};
use mrroc_launch::files;
use nalgebra::{UnitQuaternion, Vector3};

use crate::models::Capsule;
use crate::models::mesh::{MeshError, TriangleMesh, cover};

/// The capsules that cover the mesh of an entry, in O.
pub(super) fn covered(entry: &ObstacleEntry, mesh: &ObstacleMesh) -> Result<Vec<Capsule>, CellError> {
    let ObstacleMesh { file, excess, scale } = mesh;
    let path = entry.beside(file);
    let refuse = |what: &str, help| entry.refuse(&format!("{}: {what}", path.display()), help);
    // So that it is known as a file that is read; `from_file` opens it again and limits its size.
    files::open(&path).map_err(|error| {
        refuse(
            &format!("it cannot be read: {error}"),
            "name a .stl, .obj or .dae file, as seen from the folder of the cell file",
        )
    })?;
    let wrong = |error: MeshError| entry.refuse(&error.to_string(), "correct the file or these numbers");
    let mesh = TriangleMesh::from_file(&path).map_err(wrong)?;
    let mesh = mesh.scaled([*scale; 3]).map_err(|error| wrong(error.of_file(&path)))?;
    if !mesh.is_closed() {
        return Err(refuse(
            "the mesh is open: it has edges with an odd number of triangles",
            "close it in the program that made it, so that its inside is known",
        ));
    }
    cover(&mesh, *excess).map(|cover| cover.capsules).map_err(|error| wrong(error.of_file(&path)))
}

/// What is drawn of an obstacle that is a mesh, in O: the capsules that cover it. Robots are kept away from the same ones. It is for
/// [`Kinds::meshes`](mrroc_launch::cell_file::Kinds::meshes).
///
/// # Errors
/// The file cannot be read, or its mesh is open or cannot be covered.
pub fn drawn_mesh(entry: &ObstacleEntry, mesh: &ObstacleMesh) -> Result<Solid, CellError> {
    Ok(Solid::Several(covered(entry, mesh)?.iter().map(part).collect()))
}

/// A capsule as a solid with its frame in O.
fn part(capsule: &Capsule) -> (Pose, Solid) {
    let [a, b] = capsule.ends;
    let (middle, along, radius) = ((a + b) * 0.5, b - a, capsule.radius);
    let length = along.norm();
    let place = Pose::translation(middle.x, middle.y, middle.z);
    if length == 0.0 {
        return (place, Solid::Ball { radius });
    }
    // Of opposite directions there are many rotations; this is one.
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &along)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f64::consts::PI));
    (place * turn, Solid::Capsule { radius, length })
}

#[cfg(test)]
mod tests {
    use super::super::obstacle::Obstacle;
    use super::*;
    use core::f64::consts::FRAC_PI_2;
    use mrroc_launch::cell_file::CellFile;
    use nalgebra::Point3;
    use std::path::Path;

    /// A cube with edges of 100 about the origin, as OBJ; without its last triangle it is open.
    fn cube(triangles: usize) -> String {
        let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -50 } else { 50 });
        let vertices = (0..8).map(corner).map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect::<String>();
        let faces = [[1, 2, 4, 3], [5, 6, 8, 7], [1, 2, 6, 5], [3, 4, 8, 7], [1, 3, 7, 5], [2, 4, 8, 6]];
        let halves = faces.iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let faces = halves.take(triangles).map(|[a, b, c]| format!("f {a} {b} {c}\n")).collect::<String>();
        vertices + &faces
    }

    fn file_in(folder: &Path) -> CellFile {
        std::fs::create_dir_all(folder.join("parts")).unwrap();
        for (name, text) in [
            ("parts/cube.obj", cube(12)),
            ("open.obj", cube(11)),
            ("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n".to_owned()),
        ] {
            std::fs::write(folder.join(name), text).unwrap();
        }
        let text = "step_ms = 2\n[robots.arm]\nkind = \"irp6\"\n\
                    [obstacles.cube]\nmesh = { file = \"parts/cube.obj\", excess = 0.01, scale = 0.001 }\n\
                    at = { xyz = [1.0, 0.0, 0.0], zyz = [0.0, 1.5707963267948966, 0.0] }\n\
                    [obstacles.open]\nmesh = { file = \"open.obj\", scale = 0.001 }\n\
                    [obstacles.flat]\nmesh = { file = \"flat.obj\" }\n\
                    [obstacles.none]\nmesh = { file = \"none.stl\" }\n\
                    [obstacles.metres]\nmesh = { file = \"parts/cube.obj\" }\n";
        std::fs::write(folder.join("cell.toml"), text).unwrap();
        CellFile::read(folder.join("cell.toml")).unwrap()
    }

    #[test]
    fn a_mesh_of_a_cell_file_is_held_by_its_obstacle_and_a_wrong_one_is_refused_with_its_file() {
        let folder = std::env::temp_dir().join(format!("mrroc-from-mesh-{}", std::process::id()));
        let file = file_in(&folder);
        let [cube, open, flat, none, metres] = file.obstacles() else { panic!("five obstacles") };
        let obstacle = Obstacle::of(cube).unwrap();
        // 0.5 m above the top of the cube, and beside an edge by 3 and 4 parts: at most the excess is missing.
        for (point, expected) in [(Vector3::new(1.0, 0.0, 0.55), 0.5), (Vector3::new(1.08, 0.09, 0.0), 0.05)]
        {
            let distance = obstacle.distance(&point, f64::INFINITY);
            assert!((expected - 0.01 - 1e-9..=expected + 1e-9).contains(&distance), "{point}: {distance}");
        }
        // What is drawn holds the corners, and no more than the excess: its lowest and highest points along x in O are z in W.
        let drawn = |entry: &ObstacleEntry| entry.solid(drawn_mesh);
        let Ok(Solid::Several(parts)) = drawn(cube) else { panic!("parts") };
        let Obstacle::Bodies(bodies) = &obstacle else { panic!("bodies") };
        assert_eq!(parts.len(), bodies.capsules().len());
        let held = |corner: Vector3<f64>| {
            parts.iter().any(|(place, solid)| {
                let p = place.inverse_transform_point(&Point3::from(corner)).coords;
                match solid {
                    Solid::Capsule { radius, length } => {
                        let beyond = (p.z.abs() - 0.5 * length).max(0.0);
                        p.x.hypot(p.y).hypot(beyond) <= radius + 1e-9
                    }
                    Solid::Ball { radius } => p.norm() <= radius + 1e-9,
                    Solid::Box { .. }
                    | Solid::Cylinder { .. }
                    | Solid::HalfSpace
                    | Solid::Points { .. }
                    | Solid::Several(_) => false,
                }
            })
        };
        for i in 0..8 {
            let corner = Vector3::from_fn(|axis, _| if i >> axis & 1 == 0 { -0.05 } else { 0.05 });
            assert!(held(corner), "{corner}");
        }
        assert!(!held(Vector3::new(0.0, 0.0, 0.0601)) && !held(Vector3::new(0.0601, 0.0, 0.0)));
        let told = [open, flat, none, metres].map(|entry| Obstacle::of(entry).unwrap_err().to_string());
        for (told, expected) in told.iter().zip([
            ["cell.toml:8:8: obstacle `open`: ", "open.obj: the mesh is open"],
            ["cell.toml:10:8: obstacle `flat`: ", "flat.obj: it has no triangle with an area (1 without)"],
            ["cell.toml:12:8: obstacle `none`: ", "none.stl: it cannot be read: "],
            ["cell.toml:14:8: obstacle `metres`: ", "check its unit and scale"],
        ]) {
            assert!(expected.iter().all(|part| told.contains(part)), "{told}");
        }
        assert_eq!(drawn(open).unwrap_err(), Obstacle::of(open).unwrap_err());
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_capsule_is_drawn_between_its_ends_whatever_its_direction() {
        for along in [Vector3::z(), -Vector3::z(), Vector3::x(), Vector3::new(0.1, -0.2, 0.3)] {
            let from = Vector3::new(1.0, 2.0, 3.0);
            let (place, solid) = part(&Capsule::new(from, from + along, 0.1));
            let length = along.norm();
            assert_eq!(solid, Solid::Capsule { radius: 0.1, length: (from + along - from).norm() });
            let ends = [-0.5, 0.5].map(|side| (place * Point3::new(0.0, 0.0, side * length)).coords);
            assert!((ends[0] - from).norm() < 1e-12 && (ends[1] - from - along).norm() < 1e-12);
        }
        let turned = part(&Capsule::new(Vector3::zeros(), Vector3::x(), 0.1)).0;
        assert!((turned.rotation.angle() - FRAC_PI_2).abs() < 1e-12);
    }
}
