//! What a cell file says of what stands in the cell: tables `[obstacles.NAME]`.
//!
//! In: a shape and its place, read by the reader. Out: plain numbers, for those who keep robots away from it and for those
//! who draw it; points and heights come from files that are read when they are asked for.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use mrroc_core::cell::CellError;
use mrroc_core::nalgebra::Vector3;
use mrroc_core::observe::solid::Solid;
use mrroc_core::pose::Pose;

use super::error::{At, Source};
use super::heights::{self, Heights};
use super::points;
use crate::files;

/// The most points that are drawn of a cloud or a height field.
const DRAWN: usize = 2000;

/// An obstacle of a cell file.
#[derive(Clone, Debug)]
pub struct ObstacleEntry {
    pub(super) source: Rc<Source>,
    pub(super) name: String,
    pub(super) place: Pose,
    pub(super) shape: At<ObstacleShape>,
}

/// The shape of an obstacle about its frame O. Lengths are finite and > 0.
#[derive(Clone, Debug, PartialEq)]
pub enum ObstacleShape {
    /// `box`: a box about the origin.
    Box {
        /// Edges along x, y, z \[m\].
        size: [f64; 3],
    },
    /// `cylinder`: one with plane ends, the middle of its axis in the origin.
    Cylinder {
        /// Radius \[m\].
        radius: f64,
        /// Length along z \[m\].
        length: f64,
    },
    /// `sphere`: a ball about the origin.
    Sphere {
        /// Radius \[m\].
        radius: f64,
    },
    /// `capsule`: a cylinder with a half ball on each end, the middle of its axis in the origin.
    Capsule {
        /// Radius \[m\].
        radius: f64,
        /// Length of the cylinder along z, without the half balls \[m\].
        length: f64,
    },
    /// `half_space`: all that lies below a plane.
    HalfSpace {
        /// Where the plane is along z \[m\], any finite number.
        height: f64,
    },
    /// `cloud`: balls about the points of a file.
    Cloud {
        /// The file as it stands there.
        file: String,
        /// Radius of each ball \[m\].
        radius: f64,
        /// The edge of the cells of a grid, of each of which one point is kept \[m\]; all are kept if it is not said.
        cell: Option<f64>,
    },
    /// `height_field`: columns of the heights of a file.
    HeightField {
        /// The file as it stands there.
        file: String,
        /// The edge of a column \[m\].
        cell: f64,
    },
    /// `mesh`: the capsules that cover a closed mesh of triangles.
    Mesh(ObstacleMesh),
}

/// A mesh of triangles that an obstacle is.
#[derive(Clone, Debug, PartialEq)]
pub struct ObstacleMesh {
    /// The file as it stands there.
    pub file: String,
    /// How far the capsules may stand out of the mesh \[m\].
    pub excess: f64,
    /// Metres in a unit of the file \[1\].
    pub scale: f64,
}

impl ObstacleMesh {
    /// How far the capsules may stand out, if the cell file does not say it \[m\].
    pub const EXCESS: f64 = 5e-3;
}

impl ObstacleEntry {
    /// The obstacle's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The obstacle's frame in the world, `X_WO`: `at`, in the `frame` of the cell if it names one.
    #[must_use]
    pub const fn place(&self) -> Pose {
        self.place
    }

    /// The frame of its [`solid`](Self::solid) in the world: that of the obstacle, of a half space in its surface.
    #[must_use]
    pub fn place_of_solid(&self) -> Pose {
        match &self.shape.value {
            ObstacleShape::HalfSpace { height } => self.place * Pose::translation(0.0, 0.0, *height),
            ObstacleShape::Box { .. }
            | ObstacleShape::Cylinder { .. }
            | ObstacleShape::Sphere { .. }
            | ObstacleShape::Capsule { .. }
            | ObstacleShape::Cloud { .. }
            | ObstacleShape::HeightField { .. }
            | ObstacleShape::Mesh(_) => self.place,
        }
    }

    /// Its shape.
    #[must_use]
    pub const fn shape(&self) -> &ObstacleShape {
        &self.shape.value
    }

    /// The points of a `cloud` \[m\], in O; none of other shapes.
    ///
    /// # Errors
    /// The file cannot be read, or the first of its lines that is no point.
    pub fn points(&self) -> Result<Vec<Vector3<f64>>, CellError> {
        match &self.shape.value {
            ObstacleShape::Cloud { file, .. } => self.read(file, points::parse),
            ObstacleShape::Box { .. }
            | ObstacleShape::Cylinder { .. }
            | ObstacleShape::Sphere { .. }
            | ObstacleShape::Capsule { .. }
            | ObstacleShape::HalfSpace { .. }
            | ObstacleShape::HeightField { .. }
            | ObstacleShape::Mesh(_) => Ok(Vec::new()),
        }
    }

    /// The heights of a `height_field` \[m\], in O; `None` of other shapes.
    ///
    /// # Errors
    /// The file cannot be read, or the first of its lines that is no row of heights.
    pub fn heights(&self) -> Result<Option<Heights>, CellError> {
        match &self.shape.value {
            ObstacleShape::HeightField { file, .. } => self.read(file, heights::parse).map(Some),
            ObstacleShape::Box { .. }
            | ObstacleShape::Cylinder { .. }
            | ObstacleShape::Sphere { .. }
            | ObstacleShape::Capsule { .. }
            | ObstacleShape::HalfSpace { .. }
            | ObstacleShape::Cloud { .. }
            | ObstacleShape::Mesh(_) => Ok(None),
        }
    }

    /// An error at the shape of this obstacle: what is wrong with it, and what to write.
    #[must_use]
    pub fn refuse(&self, what: &str, help: &str) -> CellError {
        let what = format!("obstacle `{}`: {what}", self.name);
        self.source.complain(&self.shape.span, what, help.to_owned()).into()
    }

    /// The path of a file that the shape names: it is told from the folder of the cell file.
    #[must_use]
    pub fn beside(&self, file: &str) -> PathBuf {
        Path::new(&self.source.file).parent().unwrap_or(Path::new("")).join(file)
    }

    /// Reads a file beside the cell file.
    fn read<T>(
        &self,
        file: &str,
        parse: impl FnOnce(&Path, &str) -> Result<T, String>,
    ) -> Result<T, CellError> {
        let path = self.beside(file);
        let text = files::open(&path).and_then(std::io::read_to_string);
        let text = text.map_err(|error| {
            let what = format!("{} cannot be read: {error}", path.display());
            self.refuse(&what, "name a text file in the folder of the cell file")
        })?;
        parse(&path, &text).map_err(|why| {
            self.refuse(&format!("{}: {why}", path.display()), "correct that line, or name another file")
        })
    }

    /// What is drawn of it: at most 2000 points of a file, and of a mesh what `draw` makes of it.
    ///
    /// # Errors
    /// As of [`points`](Self::points) and [`heights`](Self::heights), and those of `draw`.
    pub fn solid(
        &self,
        draw: impl FnOnce(&Self, &ObstacleMesh) -> Result<Solid, CellError>,
    ) -> Result<Solid, CellError> {
        Ok(match &self.shape.value {
            ObstacleShape::Box { size } => Solid::Box { edges: *size },
            ObstacleShape::Cylinder { radius, length } => {
                Solid::Cylinder { radius: *radius, length: *length }
            }
            ObstacleShape::Sphere { radius } => Solid::Ball { radius: *radius },
            ObstacleShape::Capsule { radius, length } => Solid::Capsule { radius: *radius, length: *length },
            ObstacleShape::HalfSpace { .. } => Solid::HalfSpace,
            ObstacleShape::Cloud { radius, .. } => {
                let points = some_of(self.points()?);
                Solid::Points { points: points.into(), radius: *radius }
            }
            ObstacleShape::HeightField { cell, .. } => {
                let found = self.heights()?;
                let tops = found.map_or_else(Vec::new, |Heights { columns, heights }| {
                    let top = |(index, height): (usize, &f64)| {
                        let middle = |index: usize| (index as f64 + 0.5) * cell;
                        Vector3::new(middle(index % columns), middle(index / columns), *height)
                    };
                    heights.iter().enumerate().map(top).collect()
                });
                Solid::Points { points: some_of(tops).into(), radius: 0.5 * cell }
            }
            ObstacleShape::Mesh(mesh) => draw(self, mesh)?,
        })
    }
}

/// At most [`DRAWN`] of the points, evenly taken.
fn some_of(points: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
    let every = points.len().div_ceil(DRAWN).max(1);
    points.into_iter().step_by(every).collect()
}

#[cfg(test)]
mod tests {
    use super::super::CellFile;
    use super::*;
    use core::f64::consts::FRAC_PI_2;

    const ARM: &str = "step_ms = 2\n[robots.arm]\nkind = \"irp6\"\n";

    fn parsed(text: &str) -> CellFile {
        CellFile::parse("cell.toml", &format!("{ARM}{text}")).expect("nothing is wrong")
    }

    fn refused(text: &str) -> String {
        CellFile::parse("cell.toml", &format!("{ARM}{text}")).expect_err("something is wrong").to_string()
    }

    fn solid(entry: &ObstacleEntry) -> Result<Solid, CellError> {
        entry.solid(|_, _| panic!("it is no mesh"))
    }

    #[test]
    fn an_obstacle_stands_in_the_frame_that_it_names() {
        let file = parsed(
            "[obstacles.post]\ncylinder = { radius = 0.05, length = 1 }\nat = { xyz = [1.0, 0.0, 0.5] }\nframe = \"table\"\n\
             [obstacles.ball]\nsphere = { radius = 0.1 }\n\
             [frames.table]\nxyz = [0.0, 2.0, 0.0]\nzyz = [1.5707963267948966, 0.0, 0.0]\n",
        );
        let [post, ball] = file.obstacles() else { panic!("two obstacles") };
        assert_eq!((post.name(), ball.name()), ("post", "ball"));
        assert_eq!(post.shape(), &ObstacleShape::Cylinder { radius: 0.05, length: 1.0 });
        // A quarter of a turn about z takes x of the table to y of the world.
        let place = post.place();
        assert!((place.translation.vector - Vector3::new(0.0, 3.0, 0.5)).norm() < 1e-12, "{place}");
        assert!((place.rotation.angle() - FRAC_PI_2).abs() < 1e-12);
        assert_eq!(ball.place(), Pose::identity());
        assert_eq!(solid(ball), Ok(Solid::Ball { radius: 0.1 }));
    }

    #[test]
    fn everything_that_is_wrong_with_obstacles_is_told_at_once_with_its_place() {
        let told = refused(
            "[obstacles.arm]\nbox = { size = [1, 1, 1] }\n\
             [obstacles.none]\nat = { xyz = [1.0, 0.0, 0.5] }\n\
             [obstacles.two]\nsphere = { radius = 0.1 }\nbox = { size = [1, 1, 1] }\n\
             [obstacles.flat]\nbox = { size = [1, 1, 0] }\nframe = \"table\"\n\
             [obstacles.long]\ncapsule = { radius = -0.1, lenght = 1 }\n\
             [obstacles.scan]\ncloud = { radius = 0.1 }\n",
        );
        for expected in [
            "cell.toml:4:12: `arm` is a robot already",
            "cell.toml:6:12: obstacle `none` has no shape",
            "obstacle `two` has both",
            "cell.toml:12:23: 0 m",
            "write an edge above 0 [m]",
            "cell.toml:13:9: no frame `table`",
            "cell.toml:15:22: -0.1 m",
            "write a radius above 0 [m]",
            "unknown key `lenght`",
            "did you mean `length`?",
            "a shape without `length`",
            "cell.toml:17:9: a shape without `file`",
        ] {
            assert!(told.contains(expected), "no `{expected}` in:\n{told}");
        }
    }

    #[test]
    fn a_mesh_is_named_by_its_file_and_has_an_excess_and_a_unit() {
        let file = parsed(
            "[obstacles.jig]\nmesh = { file = \"jig.stl\" }\n\
             [obstacles.cast]\nmesh = { file = \"parts/cast.obj\", excess = 0.01, scale = 1e-3 }\n",
        );
        let [jig, cast] = file.obstacles() else { panic!("two obstacles") };
        let of = |file: &str, excess, scale| {
            ObstacleShape::Mesh(ObstacleMesh { file: file.to_owned(), excess, scale })
        };
        assert_eq!(jig.shape(), &of("jig.stl", 5e-3, 1.0));
        assert_eq!(cast.shape(), &of("parts/cast.obj", 0.01, 1e-3));
        let told = refused(
            "[obstacles.none]\nmesh = { scale = 0 }\n[obstacles.far]\nmesh = { file = \"a.stl\", excess = -1 }\n",
        );
        for expected in [
            "cell.toml:5:8: a shape without `file`",
            "cell.toml:5:18: 0 is no scale",
            "write a scale above 0, such as 0.001 for a file in millimetres",
            "cell.toml:7:35: -1 m",
        ] {
            assert!(told.contains(expected), "no `{expected}` in:\n{told}");
        }
    }

    #[test]
    fn a_mesh_is_drawn_by_the_kinds_of_robots_that_can_read_it_and_refused_by_others() {
        use super::super::Kinds;
        let file = CellFile::parse(
            "cells/cell.toml",
            "step_ms = 2\n[robots.arm]\nkind = \"arm\"\n[obstacles.jig]\nmesh = { file = \"jig.stl\" }\n",
        )
        .expect("nothing is wrong");
        // Each cell is refused, because there is no kind of robots either.
        let told_by = |kinds: &Kinds| file.cell(kinds).err().map_or(String::new(), |error| error.to_string());
        let told = told_by(&Kinds::new());
        assert!(told.contains("cells/cell.toml:5:8: obstacle `jig`: the kinds of robots"), "{told}");
        let kinds = Kinds::new().meshes(|entry, mesh| {
            assert_eq!(entry.beside(&mesh.file), Path::new("cells/jig.stl"));
            Ok(Solid::Ball { radius: 0.25 })
        });
        assert!(!told_by(&kinds).contains("jig"));
    }

    #[test]
    fn the_points_and_heights_of_files_are_read_beside_the_cell_file() {
        let folder = std::env::temp_dir().join(format!("mrroc-obstacles-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let rows = (0..5000).map(|k| format!("{k} 0 0\n")).collect::<String>();
        std::fs::write(folder.join("scan.xyz"), rows).expect("a file");
        std::fs::write(folder.join("ground.txt"), "0 1\n2 3\n").expect("a file");
        std::fs::write(folder.join("bad.xyz"), "1 2 3\n1 nan 3\n").expect("a file");
        std::fs::write(
            folder.join("cell.toml"),
            format!(
                "{ARM}[obstacles.scan]\ncloud = {{ file = \"scan.xyz\", radius = 0.01 }}\n\
                 [obstacles.ground]\nheight_field = {{ file = \"ground.txt\", cell = 0.5 }}\n\
                 [obstacles.bad]\ncloud = {{ file = \"bad.xyz\", radius = 0.01 }}\n\
                 [obstacles.none]\ncloud = {{ file = \"none.xyz\", radius = 0.01 }}\n"
            ),
        )
        .expect("a file");
        let file = CellFile::read(folder.join("cell.toml")).expect("nothing is wrong with the file itself");
        let [scan, ground, bad, none] = file.obstacles() else { panic!("four obstacles") };
        assert_eq!(scan.points().expect("points").len(), 5000);
        // Every third is drawn: 2000 are the most.
        let Ok(Solid::Points { points, radius }) = solid(scan) else { panic!("points") };
        assert_eq!((points.len(), radius, points[1]), (1667, 0.01, Vector3::new(3.0, 0.0, 0.0)));
        let heights = ground.heights().expect("heights").expect("a height field");
        assert_eq!(heights, Heights { columns: 2, heights: vec![0.0, 1.0, 2.0, 3.0] });
        let Ok(Solid::Points { points, radius }) = solid(ground) else { panic!("points") };
        assert_eq!(
            (points[1], points[2], radius),
            (Vector3::new(0.75, 0.25, 1.0), Vector3::new(0.25, 0.75, 2.0), 0.25)
        );
        let bad = bad.points().expect_err("no number").to_string();
        assert!(bad.contains("cell.toml:9:9: obstacle `bad`: ") && bad.contains("line 2: `nan`"), "{bad}");
        let none = none.points().expect_err("no file").to_string();
        assert!(none.contains("none.xyz cannot be read: "), "{none}");
        std::fs::remove_dir_all(&folder).expect("it is there");
    }
}
