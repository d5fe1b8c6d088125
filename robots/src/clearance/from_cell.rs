//! Obstacles of a cell file.
//!
//! In: tables `[obstacles.NAME]`, and the files that they name. Out: an [`Obstacle`] of each, under its name.

use mrroc::cell::CellError;
use mrroc_launch::cell_file::{CellFile, ObstacleEntry, ObstacleShape};
use nalgebra::{Point3, Vector3};

use super::builder::ClearanceBuilder;
use super::error::ClearanceError;
use super::from_mesh::covered;
use super::obstacle::{Bodies, Cloud, HeightField, Obstacle, ObstacleError};
use crate::models::Capsule;

impl ClearanceBuilder {
    /// Adds all obstacles of a cell file, each under its name there.
    ///
    /// # Errors
    /// [`ClearanceError::File`]: a file with points, heights or a mesh cannot be read or makes no obstacle. Others as of
    /// [`obstacle`](Self::obstacle).
    pub fn obstacles(self, file: &CellFile) -> Result<Self, ClearanceError> {
        file.obstacles()
            .iter()
            .try_fold(self, |builder, entry| builder.obstacle(entry.name(), Obstacle::of(entry)?))
    }
}

impl Obstacle {
    /// The obstacle that a cell file describes, in the world. It reads the file with its points, heights or mesh, if it has one.
    ///
    /// # Errors
    /// That file cannot be read, or what it has makes no obstacle.
    #[allow(non_snake_case)]
    pub fn of(entry: &ObstacleEntry) -> Result<Self, CellError> {
        let X_WO = entry.place();
        let refuse =
            |error: ObstacleError| entry.refuse(&error.to_string(), "correct the file or these numbers");
        Ok(match entry.shape() {
            ObstacleShape::Box { size } => Obstacle::Box { X_WO, half: Vector3::from(*size) * 0.5 },
            ObstacleShape::Cylinder { radius, length } => {
                Obstacle::Cylinder { X_WO, radius: *radius, half_length: 0.5 * length }
            }
            ObstacleShape::Sphere { radius } => Obstacle::ball(X_WO.translation.vector, *radius),
            ObstacleShape::Capsule { radius, length } => {
                let half = Vector3::z() * (0.5 * length);
                Obstacle::Capsule(Capsule::new(-half, half, *radius).moved(&X_WO))
            }
            ObstacleShape::HalfSpace { height } => {
                let normal = X_WO.rotation * Vector3::z();
                Obstacle::HalfSpace { normal, height: normal.dot(&X_WO.translation.vector) + height }
            }
            ObstacleShape::Cloud { radius, cell, .. } => {
                let points: Vec<_> =
                    entry.points()?.iter().map(|point| (X_WO * Point3::from(*point)).coords).collect();
                let cloud = match cell {
                    Some(cell) => Cloud::thinned(&points, *radius, *cell),
                    None => Cloud::new(&points, *radius),
                };
                Obstacle::Cloud(cloud.map_err(refuse)?.into())
            }
            ObstacleShape::HeightField { cell, .. } => {
                // Of no columns it is refused.
                let (columns, heights) =
                    entry.heights()?.map_or((0, Vec::new()), |found| (found.columns, found.heights));
                Obstacle::HeightField(HeightField::new(X_WO, *cell, columns, heights).map_err(refuse)?.into())
            }
            ObstacleShape::Mesh(mesh) => {
                let capsules: Vec<_> = covered(entry, mesh)?.iter().map(|one| one.moved(&X_WO)).collect();
                Obstacle::Bodies(Bodies::new(&capsules).map_err(refuse)?.into())
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Clearance, Stopping};
    use super::*;
    use core::time::Duration;
    use mrroc::pose::Pose;

    fn obstacles(text: &str) -> Vec<Obstacle> {
        let text = format!("step_ms = 2\n[robots.arm]\nkind = \"irp6\"\n{text}");
        let file = CellFile::parse("cell.toml", &text).unwrap();
        file.obstacles().iter().map(|entry| Obstacle::of(entry).unwrap()).collect()
    }

    #[test]
    fn what_a_cell_file_describes_is_as_far_away_as_geometry_says() {
        // A quarter of a turn about y (of z, y, z the second angle) takes z to x.
        let at = "at = { xyz = [1.0, 0.0, 0.0], zyz = [0.0, 1.5707963267948966, 0.0] }";
        let shapes = [
            ("half_space = { height = 0.5 }", 1.5),
            ("capsule = { radius = 0.1, length = 0.8 }", 2.5),
            ("cylinder = { radius = 0.1, length = 0.8 }", 2.6),
            ("sphere = { radius = 0.1 }", 2.9),
            ("box = { size = [0.2, 0.4, 0.6] }", 2.7),
        ];
        for (shape, expected) in shapes {
            let found = obstacles(&format!("[obstacles.body]\n{shape}\n{at}\n"));
            assert!(found[0].is_valid());
            // From 3 m in front of its origin along x.
            let distance = found[0].distance(&Vector3::new(4.0, 0.0, 0.0), f64::INFINITY);
            let expected = if shape.starts_with("half") { 4.0 - expected } else { expected };
            assert!((distance - expected).abs() < 1e-12, "{shape}: {distance}");
        }
    }

    #[test]
    fn clouds_and_height_fields_of_files_stand_where_the_cell_file_says() {
        let folder = std::env::temp_dir().join(format!("mrroc-from-cell-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("scan.xyz"), "0 0 0\n0 0 1\n0 0 1.001\n").unwrap();
        std::fs::write(folder.join("ground.txt"), "0.5\n").unwrap();
        let text = "step_ms = 2\n[robots.arm]\nkind = \"irp6\"\n\
                    [obstacles.scan]\ncloud = { file = \"scan.xyz\", radius = 0.1, cell = 0.5 }\n\
                    at = { xyz = [1.0, 0.0, 0.0] }\n\
                    [obstacles.ground]\nheight_field = { file = \"ground.txt\", cell = 0.5 }\n\
                    at = { xyz = [1.0, 0.0, 0.0] }\n";
        std::fs::write(folder.join("cell.toml"), text).unwrap();
        let file = CellFile::read(folder.join("cell.toml")).unwrap();
        let found: Vec<_> = file.obstacles().iter().map(|entry| Obstacle::of(entry).unwrap()).collect();
        let Obstacle::Cloud(cloud) = &found[0] else { panic!("a cloud") };
        assert_eq!(cloud.len(), 2);
        assert!((cloud.radius() - 0.1005).abs() < 1e-6, "two points 1 mm apart are one in their middle");
        assert!((found[0].distance(&Vector3::zeros(), 9.0) - (1.0 - cloud.radius())).abs() < 1e-12);
        let Obstacle::HeightField(field) = &found[1] else { panic!("a height field") };
        assert_eq!(*field.place(), Pose::translation(1.0, 0.0, 0.0));
        assert!((found[1].distance(&Vector3::new(1.2, 0.2, 0.9), 9.0) - 0.4).abs() < 1e-12);
        let names = Clearance::with_margin(0.0).obstacles(&file).and_then(|builder| {
            // Both names are known now.
            builder
                .margin_between("scan", "ground", 0.1)
                .build(Stopping::of_guard(Duration::from_millis(2), 1))
        });
        assert!(names.is_ok());
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
