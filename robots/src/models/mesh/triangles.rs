//! A mesh of triangles: vertices and indices in, checked once, so that all that works on it can rely on them.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::error::MeshError;

/// The farthest that a vertex may be from the origin \[m\]: what is farther is in other units, or broken.
pub(super) const FARTHEST: f64 = 1e4;

/// What a file holds: vertices, and triangles by their indices.
pub(super) type Read = (Vec<Vector3<f64>>, Vec<[u32; 3]>);

/// Triangles in space, of a body or of a sheet. All coordinates are finite, all indices are in range, and no triangle is without
/// area. Which side of a triangle is outside says nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMesh {
    vertices: Vec<Vector3<f64>>,
    triangles: Vec<[u32; 3]>,
    /// Triangles of three corners without area: they are nowhere, but hold the edges of others together.
    flat: Vec<[u32; 3]>,
    dropped: usize,
}

impl TriangleMesh {
    /// A mesh of these vertices \[m\] and triangles, each of three indices of vertices. Vertices at one place become one; triangles
    /// without area are dropped and [counted](Self::dropped).
    ///
    /// # Errors
    /// [`MeshError`]: a coordinate that is not finite or beyond 10 km, an index out of range, no triangle with an area.
    pub fn new(vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Result<Self, MeshError> {
        let is_far = |vertex: &Vector3<f64>| vertex.iter().any(|x| !(x.is_finite() && x.abs() <= FARTHEST));
        if let Some(vertex) = vertices.iter().position(is_far) {
            return Err(MeshError::Coordinate { vertex, limit: FARTHEST });
        }
        let mut places: BTreeMap<[u64; 3], u32> = BTreeMap::new();
        let mut kept: Vec<Vector3<f64>> = Vec::new();
        let (mut whole, mut flat) = (Vec::with_capacity(triangles.len()), Vec::new());
        for (triangle, corners) in triangles.iter().enumerate() {
            let mut indices = [0; 3];
            for (index, corner) in indices.iter_mut().zip(corners) {
                let vertex = vertices.get(*corner as usize).ok_or(MeshError::Index {
                    triangle,
                    index: u64::from(*corner),
                    count: vertices.len(),
                })?;
                // Adding 0 makes one of the two zeros.
                let key = [0, 1, 2].map(|axis| (vertex[axis] + 0.0).to_bits());
                *index = *places.entry(key).or_insert_with(|| {
                    kept.push(*vertex);
                    kept.len() as u32 - 1
                });
            }
            let [a, b, c] = indices.map(|index| kept[index as usize]);
            let area = (b - a).cross(&(c - a)).norm();
            let longest = (b - a).norm_squared().max((c - a).norm_squared()).max((c - b).norm_squared());
            if area > longest * FLAT {
                whole.push(indices);
            } else if indices[0] != indices[1] && indices[1] != indices[2] && indices[2] != indices[0] {
                flat.push(indices);
            }
        }
        let dropped = triangles.len() - whole.len();
        if whole.is_empty() {
            return Err(MeshError::Empty { dropped });
        }
        Ok(Self { vertices: kept, triangles: whole, flat, dropped })
    }

    /// The corners \[m\].
    #[must_use]
    pub fn vertices(&self) -> &[Vector3<f64>] {
        &self.vertices
    }

    /// The triangles, each by the indices of its corners.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// How many triangles had no area and were dropped.
    #[must_use]
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// The corners of a triangle \[m\].
    pub(super) fn corners(&self, triangle: &[u32; 3]) -> [Vector3<f64>; 3] {
        triangle.map(|index| self.vertices[index as usize])
    }

    /// Least and largest coordinates \[m\].
    #[must_use]
    pub fn bounds(&self) -> [Vector3<f64>; 2] {
        let of = |pick: fn(&Vector3<f64>, &Vector3<f64>) -> Vector3<f64>| {
            self.vertices.iter().skip(1).fold(self.vertices[0], |bound, vertex| pick(&bound, vertex))
        };
        [of(Vector3::inf), of(Vector3::sup)]
    }

    /// The same with all coordinates multiplied by these factors, each finite and not 0 (below 0 it is mirrored).
    ///
    /// # Errors
    /// [`MeshError::Scale`], and those of [`TriangleMesh::new`].
    pub fn scaled(&self, scale: [f64; 3]) -> Result<Self, MeshError> {
        if scale.iter().any(|factor| !(factor.is_finite() && *factor != 0.0)) {
            return Err(MeshError::Scale { scale });
        }
        let factor = Vector3::from(scale);
        let vertices: Vec<_> = self.vertices.iter().map(|vertex| vertex.component_mul(&factor)).collect();
        self.again(&vertices, self.triangles.clone())
    }

    /// Edges that an odd number of triangles have: where the mesh is open. They form closed loops.
    pub(super) fn open_edges(&self) -> Vec<[u32; 2]> {
        odd(self.triangles.iter().chain(&self.flat))
    }

    /// Whether every edge has an even number of triangles, so that the mesh parts space into inside and outside.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.open_edges().is_empty()
    }

    /// The same with its openings closed: each loop of open edges is joined to its centre by triangles. A tube becomes a
    /// rod, a bowl is filled to its rim. Also how many openings there were.
    ///
    /// # Errors
    /// [`MeshError`], as of [`TriangleMesh::new`].
    pub fn with_openings_closed(&self) -> Result<(Self, usize), MeshError> {
        let loops = loops(self.open_edges());
        let (mut vertices, mut triangles) = (self.vertices.clone(), self.triangles.clone());
        for edges in &loops {
            let centre = vertices.len() as u32;
            let ends = edges.iter().flatten().map(|index| self.vertices[*index as usize]);
            vertices.push(ends.sum::<Vector3<f64>>() / (2 * edges.len()) as f64);
            triangles.extend(edges.iter().map(|[a, b]| [*a, *b, centre]));
        }
        Ok((self.again(&vertices, triangles)?, loops.len()))
    }

    /// A mesh made of this one, which keeps what was dropped in mind.
    fn again(&self, vertices: &[Vector3<f64>], triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        let before = self.dropped - self.flat.len();
        let all: Vec<_> = triangles.into_iter().chain(self.flat.iter().copied()).collect();
        let made = Self::new(vertices, &all)?;
        Ok(Self { dropped: made.dropped + before, ..made })
    }

    /// The triangles in parts that share no vertex, and whether each is closed.
    pub(super) fn parts(&self) -> Vec<(Vec<[u32; 3]>, bool)> {
        let mut groups = Groups::of(self.vertices.len());
        for [a, b, c] in self.triangles.iter().chain(&self.flat) {
            groups.join(*a, *b);
            groups.join(*b, *c);
        }
        let mut parts: BTreeMap<u32, [Vec<[u32; 3]>; 2]> = BTreeMap::new();
        for (kind, triangles) in [&self.triangles, &self.flat].into_iter().enumerate() {
            for triangle in triangles {
                parts.entry(groups.root(triangle[0])).or_default()[kind].push(*triangle);
            }
        }
        let parts = parts.into_values().filter(|[whole, _]| !whole.is_empty());
        parts
            .map(|[whole, flat]| {
                let is_closed = odd(whole.iter().chain(&flat)).is_empty();
                (whole, is_closed)
            })
            .collect()
    }
}

/// The edges that an odd number of these triangles have.
fn odd<'t>(triangles: impl Iterator<Item = &'t [u32; 3]>) -> Vec<[u32; 2]> {
    let mut all: Vec<[u32; 2]> = triangles.flat_map(edges).collect();
    all.sort_unstable();
    all.chunk_by(|a, b| a == b).filter(|same| same.len() % 2 == 1).map(|same| same[0]).collect()
}

/// Twice the area of a triangle by the square of its longest edge, below which it has none.
const FLAT: f64 = 1e-12;

/// The edges of a triangle, each with its lower index first.
fn edges(triangle: &[u32; 3]) -> [[u32; 2]; 3] {
    let [a, b, c] = *triangle;
    [[a, b], [b, c], [c, a]].map(|[from, to]| [from.min(to), from.max(to)])
}

/// Edges in groups that hang together.
fn loops(edges: Vec<[u32; 2]>) -> Vec<Vec<[u32; 2]>> {
    let count = edges.iter().flatten().max().map_or(0, |most| *most as usize + 1);
    let mut groups = Groups::of(count);
    for [a, b] in &edges {
        groups.join(*a, *b);
    }
    let mut loops: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
    for edge in edges {
        loops.entry(groups.root(edge[0])).or_default().push(edge);
    }
    loops.into_values().collect()
}

/// Which indices hang together.
struct Groups(Vec<u32>);

impl Groups {
    fn of(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    fn root(&mut self, mut at: u32) -> u32 {
        while self.0[at as usize] != at {
            let above = self.0[self.0[at as usize] as usize];
            self.0[at as usize] = above;
            at = above;
        }
        at
    }

    fn join(&mut self, a: u32, b: u32) {
        let [a, b] = [self.root(a), self.root(b)];
        self.0[a.max(b) as usize] = a.min(b);
    }
}
