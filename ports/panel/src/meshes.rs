//! The visible shapes of links, as a page draws them.
//!
//! In: STL files, binary or text, that the robots of the cell name. Out: triangles as JSON, in hundredths of a millimetre. A file that
//! cannot be read leaves its robot to its capsules, and that is told at the terminal.

use std::fs::File;
use std::io::Read;

use mrroc_core::console::complain;
use mrroc_core::observe::layout::RobotLayout;
use mrroc_core::robot::LinkMesh;
use serde_json::{Value, json};

use crate::values::numbers;

/// The largest file that is read \[bytes\].
const LARGEST: u64 = 8 << 20;

/// The most triangles of a cell: a browser without a graphics card draws them twenty times a second.
const MOST: usize = 60_000;

/// Hundredths of a millimetre in a metre.
const UNITS: f64 = 1e5;

/// The triangles of the links of a cell's robots.
#[derive(Default)]
pub struct Meshes {
    /// Of each robot in the order of the layout: what a page is told of its meshes.
    of_robots: Vec<Value>,
    /// A message of each mesh.
    messages: Vec<String>,
}

impl Meshes {
    /// Reads the files of these robots.
    pub fn of(robots: &[RobotLayout]) -> Meshes {
        let (mut meshes, mut left) = (Meshes::default(), MOST);
        for robot in robots {
            let read = read_all(robot.figure.meshes(), &mut left).unwrap_or_else(|why| {
                complain(&format!("panel: {} is drawn by capsules: {why}", robot.name));
                Vec::new()
            });
            let mut placed = Vec::new();
            for (mesh, corners) in robot.figure.meshes().iter().zip(read) {
                let place = meshes.messages.len();
                placed.push(json!({"mesh": place, "frame": mesh.frame, "pose": numbers(&mesh.pose)}));
                let message = json!({"kind": "mesh", "mesh": place, "corners": corners});
                meshes.messages.push(message.to_string());
            }
            meshes.of_robots.push(placed.into());
        }
        meshes
    }

    /// What a page is told of the meshes of the robot at a place.
    pub fn of_robot(&self, place: usize) -> Value {
        self.of_robots.get(place).cloned().unwrap_or_else(|| json!([]))
    }

    /// The messages that a page is sent after the layout.
    pub fn messages(&self) -> &[String] {
        &self.messages
    }
}

/// The corners of each mesh, three numbers for each of three corners of each triangle.
fn read_all(meshes: &[LinkMesh], left: &mut usize) -> Result<Vec<Vec<i64>>, String> {
    let read = |mesh: &LinkMesh| {
        let told = |why: &dyn core::fmt::Display| format!("{}: {why}", mesh.file.display());
        let mut bytes = Vec::new();
        let opened = File::open(&mesh.file).and_then(|file| file.take(LARGEST + 1).read_to_end(&mut bytes));
        opened.map_err(|error| told(&error))?;
        if bytes.len() as u64 > LARGEST {
            return Err(told(&"it has more than 8 MiB: write a coarser one"));
        }
        let corners = stl(&bytes).ok_or_else(|| told(&"it is no STL"))?;
        let rest = left.checked_sub(corners.len() / 3);
        *left = rest
            .ok_or_else(|| told(&format!("the cell has more than {MOST} triangles: write coarser ones")))?;
        let scaled =
            |corner: &[f64; 3]| [0, 1, 2].map(|i| (UNITS * mesh.scale[i] * corner[i]).round() as i64);
        Ok(corners.iter().flat_map(scaled).collect())
    };
    meshes.iter().map(read).collect()
}

/// The corners of the triangles of an STL.
fn stl(bytes: &[u8]) -> Option<Vec<[f64; 3]>> {
    let corners = binary(bytes).or_else(|| text(core::str::from_utf8(bytes).ok()?))?;
    let are_finite = corners.iter().flatten().all(|x| x.is_finite());
    (are_finite && corners.len().is_multiple_of(3)).then_some(corners)
}

/// Of a binary one: a header of 80 bytes, the number of triangles, and for each a normal, three corners, two bytes more.
fn binary(bytes: &[u8]) -> Option<Vec<[f64; 3]>> {
    const TRIANGLE: usize = 50;
    let count = u32::from_le_bytes(bytes.get(80..84)?.try_into().ok()?) as usize;
    let triangles = &bytes[84..];
    if triangles.len() != count.checked_mul(TRIANGLE)? {
        return None;
    }
    let corner = |bytes: &[u8]| {
        let (numbers, _) = bytes.as_chunks::<4>();
        core::array::from_fn(|i| numbers.get(i).map_or(f64::NAN, |x| f64::from(f32::from_le_bytes(*x))))
    };
    let of = |triangle: &[u8]| [12, 24, 36].map(|from| corner(&triangle[from..from + 12]));
    Some(triangles.chunks_exact(TRIANGLE).flat_map(of).collect())
}

/// Of one in text: the lines `vertex X Y Z`.
fn text(text: &str) -> Option<Vec<[f64; 3]>> {
    if !text.trim_start().starts_with("solid") {
        return None;
    }
    let corner = |line: &str| {
        let mut numbers = line.trim().strip_prefix("vertex")?.split_ascii_whitespace();
        let mut next = || numbers.next().and_then(|x| x.parse().ok()).unwrap_or(f64::NAN);
        Some([next(), next(), next()])
    };
    Some(text.lines().filter_map(corner).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle in each form.
    const CORNERS: [[f64; 3]; 3] = [[0.0, 0.0, 0.5], [1.0, 0.0, 0.25], [0.0, -2.0, 0.0]];

    fn in_binary() -> Vec<u8> {
        let mut bytes = vec![b's'; 80];
        bytes.extend(1_u32.to_le_bytes());
        bytes.extend([0; 12]);
        CORNERS.iter().flatten().for_each(|x| bytes.extend((*x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
        bytes
    }

    const IN_TEXT: &str = "solid part\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 5e-1\n   vertex 1 0 0.25\n\
        vertex 0 -2 0\n  endloop\n endfacet\nendsolid part\n";

    #[test]
    fn a_triangle_is_read_from_both_forms_of_an_stl() {
        assert_eq!(stl(&in_binary()), Some(CORNERS.to_vec()));
        assert_eq!(stl(IN_TEXT.as_bytes()), Some(CORNERS.to_vec()));
        for none in [&b""[..], b"ply", &in_binary()[..133], &[0; 84][..80]] {
            assert_eq!(stl(none), None);
        }
        assert_eq!(stl(IN_TEXT.replace("1 0 0.25", "1 nan 0.25").as_bytes()), None);
        assert_eq!(stl(IN_TEXT.replace("vertex 0 -2 0", "").as_bytes()), None);
    }

    #[test]
    fn fault_242_a_file_that_is_no_mesh_is_told_by_its_name_and_too_many_triangles_are_refused() {
        let file = std::env::temp_dir().join(format!("mrroc-mesh-{}.stl", std::process::id()));
        let mesh = |scale| LinkMesh {
            file: file.clone(),
            frame: 1,
            pose: mrroc_core::pose::Pose::identity(),
            scale,
        };
        let read = |left: &mut usize| read_all(&[mesh([0.001; 3])], left);
        assert!(read(&mut 9).expect_err("no file").contains("mrroc-mesh-"));
        std::fs::write(&file, "ply").expect("written");
        assert!(read(&mut 9).expect_err("no STL").contains("is no STL"));
        std::fs::write(&file, in_binary()).expect("written");
        let mut left = 1;
        // Millimetres: half of one is fifty hundredths.
        assert_eq!(read(&mut left), Ok(vec![vec![0, 0, 50, 100, 0, 25, 0, -200, 0]]));
        assert!(read(&mut left).expect_err("too many").contains("triangles"));
        std::fs::remove_file(&file).expect("removed");
    }
}
