//! The `<collision>` elements of a URDF as capsules.
//!
//! In: links with their places, and the folder of their meshes. Out: capsules in the frames of joints.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use super::document::{Element, Tree, origin, shown};
use super::error::UrdfError;
use super::meshes::file;
use crate::models::mesh::{MESH_EXTENSIONS, MeshError, TriangleMesh, cover};
use crate::models::shape::Capsule;

/// What is done with the meshes of `<collision>`.
#[derive(Clone, Debug, PartialEq)]
pub struct Meshes {
    /// The folder that the URDF stands in: meshes are files in it or below it. `package://NAME/meshes/arm.stl` is
    /// `meshes/arm.stl` there. `None` where no folder is known: then a mesh is refused.
    pub folder: Option<PathBuf>,
    /// How far their capsules may stand out \[m\], finite and > 0.
    pub excess: f64,
    /// What a mesh with openings is.
    pub openings: Openings,
    /// Links off the chain that are left out, with all that hangs on them: what is no part of the arm, or is another robot of the cell.
    pub without: Vec<String>,
}

/// What a mesh is that is not closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Openings {
    /// A body: its openings are closed first ([`TriangleMesh::with_openings_closed`]). A tube is a rod, a bowl is filled to its rim.
    Closed,
    /// Sheets without an inside. They need many capsules.
    Kept,
}

impl Meshes {
    /// No meshes: a URDF that has some is refused.
    #[must_use]
    pub const fn refused() -> Self {
        Self { folder: None, excess: 5e-3, openings: Openings::Closed, without: Vec::new() }
    }

    /// Meshes of this folder, covered by capsules that stand out by at most 5 mm, openings closed.
    #[must_use]
    pub fn below(folder: impl AsRef<Path>) -> Self {
        Self { folder: Some(folder.as_ref().to_owned()), ..Self::refused() }
    }

    /// The same without a link off the chain and all that hangs on it.
    #[must_use]
    pub fn without(mut self, link: &str) -> Self {
        self.without.push(link.to_owned());
        self
    }
}

/// A capsule of a link.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LinkCapsule {
    pub(super) link: String,
    /// How many joints stand before it.
    pub(super) joints: usize,
    /// In the frame of the last of them, or of the base.
    pub(super) capsule: Capsule,
}

/// Collision shapes being read.
pub(super) struct Shapes<'m> {
    meshes: &'m Meshes,
    pub(super) bodies: Vec<LinkCapsule>,
    /// What meshes were covered, by their files and scales: links may share them.
    covered: BTreeMap<(PathBuf, [u64; 3]), Vec<Capsule>>,
}

impl<'m> Shapes<'m> {
    pub(super) fn of(meshes: &'m Meshes) -> Self {
        Self { meshes, bodies: Vec::new(), covered: BTreeMap::new() }
    }

    /// Whether a link off the chain is left out.
    pub(super) fn is_left_out(&self, link: &str) -> bool {
        self.meshes.without.iter().any(|without| without == link)
    }

    /// How far capsules may stand out \[m\].
    pub(super) const fn excess(&self) -> f64 {
        self.meshes.excess
    }

    /// The collision shapes of a link, in its frame.
    #[allow(non_snake_case)]
    pub(super) fn of_link(&mut self, tree: &Tree<'_, '_>, link: &str) -> Result<Vec<Capsule>, UrdfError> {
        let mut capsules = Vec::new();
        let Some(element) = tree.link(link) else { return Ok(capsules) };
        for collision in element.all("collision") {
            let X_LC = origin(&collision, tree.has_quaternions)?;
            let write = "<geometry><cylinder radius=\"..\" length=\"..\"/></geometry>";
            let geometry = collision.required("geometry", write)?;
            capsules.extend(self.capsules_of(&geometry)?.iter().map(|capsule| capsule.moved(&X_LC)));
        }
        Ok(capsules)
    }

    /// The capsules that hold a shape, in its frame.
    fn capsules_of(&mut self, geometry: &Element<'_, '_>) -> Result<Vec<Capsule>, UrdfError> {
        if let Some(capsules) = of_primitive(geometry)? {
            return Ok(capsules);
        }
        match geometry.child("mesh")? {
            Some(mesh) => self.of_mesh(&mesh),
            None => {
                let element = geometry.called.clone();
                Err(UrdfError::UnsupportedCollision { line: geometry.line(), element })
            }
        }
    }

    fn of_mesh(&mut self, mesh: &Element<'_, '_>) -> Result<Vec<Capsule>, UrdfError> {
        mesh.only(&["filename", "scale"])?;
        let name = mesh.required_text("filename", "filename=\"package://NAME/meshes/arm.stl\"")?;
        let none = |why| UrdfError::NoMesh {
            line: mesh.line(),
            element: mesh.called.clone(),
            name: shown(name),
            why,
        };
        let folder = self.meshes.folder.as_ref();
        let folder = folder.ok_or_else(|| {
            none("needs the folder of the URDF: Meshes::below, or SerialOutline::new with a radius")
        })?;
        let path = file(folder, name, &MESH_EXTENSIONS).ok_or_else(|| {
            none("is no .stl, .obj or .dae file in the folder of the URDF or below it: copy it there")
        })?;
        let scale = mesh.numbers::<3>("scale")?.unwrap_or([1.0; 3]);
        let key = (path, scale.map(f64::to_bits));
        if let Some(capsules) = self.covered.get(&key) {
            return Ok(capsules.clone());
        }
        let capsules = self.cover_of(&key.0, scale).map_err(|why| UrdfError::BadMesh {
            line: mesh.line(),
            element: mesh.called.clone(),
            why: Box::new(why),
        })?;
        self.covered.insert(key, capsules.clone());
        Ok(capsules)
    }

    fn cover_of(&self, path: &Path, scale: [f64; 3]) -> Result<Vec<Capsule>, MeshError> {
        let read = TriangleMesh::from_file(path)?;
        let covered = || {
            let mesh = read.scaled(scale)?;
            let mesh = match self.meshes.openings {
                Openings::Closed => mesh.with_openings_closed()?.0,
                Openings::Kept => mesh,
            };
            cover(&mesh, self.meshes.excess)
        };
        covered().map(|cover| cover.capsules).map_err(|why| why.of_file(path))
    }
}

/// The capsules that hold a shape with dimensions, if it is one.
fn of_primitive(geometry: &Element<'_, '_>) -> Result<Option<Vec<Capsule>>, UrdfError> {
    let above_zero = |shape: &Element<'_, '_>, attribute: &'static str| {
        let number =
            shape.number(attribute)?.ok_or_else(|| shape.missing(attribute, "a length in metres"))?;
        if number > 0.0 { Ok(number) } else { Err(shape.bad(attribute, "a finite number above 0")) }
    };
    if let Some(sphere) = geometry.child("sphere")? {
        let radius = above_zero(&sphere, "radius")?;
        return Ok(Some(vec![Capsule::new(Vector3::zeros(), Vector3::zeros(), radius)]));
    }
    for name in ["cylinder", "capsule"] {
        if let Some(bar) = geometry.child(name)? {
            let radius = above_zero(&bar, "radius")?;
            let half = 0.5 * above_zero(&bar, "length")?;
            return Ok(Some(vec![Capsule::new(Vector3::z() * -half, Vector3::z() * half, radius)]));
        }
    }
    let Some(cuboid) = geometry.child("box")? else { return Ok(None) };
    let edges = cuboid.numbers::<3>("size")?.ok_or_else(|| cuboid.missing("size", "size=\"x y z\""))?;
    if edges.iter().any(|edge| *edge <= 0.0) {
        return Err(cuboid.bad("size", "three numbers above 0"));
    }
    Ok(Some(Capsule::covering_box(Vector3::from(edges), 2)))
}
