//! Distances from a set of triangles, and rays through it, by a tree of boxes.

use nalgebra::Vector3;

use super::triangles::TriangleMesh;

/// Most triangles of a leaf.
const LEAF: usize = 4;

type Corners = [Vector3<f64>; 3];

/// A box, and what lies in it: triangles `first .. first + count`, or, where that is 0, two boxes, the next one and `first`.
#[derive(Clone, Debug)]
struct Node {
    least: Vector3<f64>,
    most: Vector3<f64>,
    first: u32,
    count: u32,
}

/// Triangles in a tree of boxes.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    nodes: Vec<Node>,
    triangles: Vec<Corners>,
}

impl Surface {
    /// These triangles of a mesh, of which there is at least one.
    pub(super) fn of(mesh: &TriangleMesh, triangles: &[[u32; 3]]) -> Self {
        let mut triangles: Vec<Corners> = triangles.iter().map(|t| mesh.corners(t)).collect();
        let mut nodes = Vec::with_capacity(triangles.len());
        // Boxes that still have to be made: a range of triangles, and the box whose second one it is.
        let mut open = vec![(0, triangles.len(), None)];
        while let Some((from, to, second_of)) = open.pop() {
            let at = nodes.len();
            if let Some(parent) = second_of {
                let parent: &mut Node = &mut nodes[parent];
                parent.first = at as u32;
            }
            let part = &mut triangles[from..to];
            let corners = || part.iter().flatten();
            let least = corners().fold(Vector3::repeat(f64::INFINITY), |least, corner| least.inf(corner));
            let most = corners().fold(Vector3::repeat(f64::NEG_INFINITY), |most, corner| most.sup(corner));
            let count = to - from;
            if count <= LEAF {
                nodes.push(Node { least, most, first: from as u32, count: count as u32 });
                continue;
            }
            let axis = (most - least).imax();
            let centre = |triangle: &Corners| triangle.iter().map(|corner| corner[axis]).sum::<f64>();
            part.sort_by(|a, b| centre(a).total_cmp(&centre(b)));
            nodes.push(Node { least, most, first: 0, count: 0 });
            let middle = from + count / 2;
            open.push((middle, to, Some(at)));
            open.push((from, middle, None));
        }
        Self { nodes, triangles }
    }

    /// The least and the largest coordinates \[m\].
    pub(super) fn bounds(&self) -> (Vector3<f64>, Vector3<f64>) {
        (self.nodes[0].least, self.nodes[0].most)
    }

    /// The nearest point to `point`, if one is nearer than `within` \[m\].
    pub(super) fn nearest(&self, point: &Vector3<f64>, within: f64) -> Option<Vector3<f64>> {
        let mut best = within * within;
        let mut found = None;
        let mut open = [(0_u32, 0.0_f64); 64];
        let mut count = 1;
        open[0] = (0, outside(&self.nodes[0], point));
        while count > 0 {
            count -= 1;
            let (at, apart) = open[count];
            if apart >= best {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.count > 0 {
                let from = node.first as usize;
                for triangle in &self.triangles[from..from + node.count as usize] {
                    let on = nearest_on(triangle, point);
                    let apart = (on - point).norm_squared();
                    if apart < best {
                        best = apart;
                        found = Some(on);
                    }
                }
                continue;
            }
            let mut both = [at + 1, node.first].map(|at| (at, outside(&self.nodes[at as usize], point)));
            // The nearer one is looked at first, so it is pushed last.
            if both[0].1 < both[1].1 {
                both.swap(0, 1);
            }
            // Halves make the tree at most 32 deep: two boxes open for each level have place.
            for one in both {
                if one.1 < best && count < open.len() {
                    open[count] = one;
                    count += 1;
                }
            }
        }
        found
    }

    /// Whether a ray crosses an odd number of triangles.
    pub(super) fn is_odd(&self, from: &Vector3<f64>, direction: &Vector3<f64>) -> bool {
        let inverse = direction.map(|x| 1.0 / x);
        let mut open = vec![0_u32];
        let mut odd = false;
        while let Some(at) = open.pop() {
            let node = &self.nodes[at as usize];
            let a = (node.least - from).component_mul(&inverse);
            let b = (node.most - from).component_mul(&inverse);
            if a.sup(&b).min() < a.inf(&b).max().max(0.0) {
                continue;
            }
            if node.count > 0 {
                let first = node.first as usize;
                let crossed = self.triangles[first..first + node.count as usize].iter();
                odd ^= crossed.filter(|triangle| crosses(triangle, from, direction)).count() % 2 == 1;
            } else {
                open.extend([node.first, at + 1]);
            }
        }
        odd
    }
}

/// The square of the distance of a point from a box \[m²\].
fn outside(node: &Node, point: &Vector3<f64>) -> f64 {
    (node.least - point).sup(&(point - node.most)).map(|x| x.max(0.0)).norm_squared()
}

/// The point of a triangle that is nearest to a point (Ericson, Real-Time Collision Detection, 5.1.5).
pub(super) fn nearest_on([a, b, c]: &Corners, point: &Vector3<f64>) -> Vector3<f64> {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return *a;
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return *b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return *c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let sum = va + vb + vc;
    a + ab * (vb / sum) + ac * (vc / sum)
}

/// Whether a ray crosses a triangle (Möller and Trumbore, 1997).
fn crosses([a, b, c]: &Corners, from: &Vector3<f64>, direction: &Vector3<f64>) -> bool {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(&ac);
    let determinant = ab.dot(&p);
    if determinant == 0.0 {
        return false;
    }
    let s = from - a;
    let u = s.dot(&p) / determinant;
    let q = s.cross(&ab);
    let v = direction.dot(&q) / determinant;
    let t = ac.dot(&q) / determinant;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0
}
