//! Covers of meshes: all of the surface is in a capsule, and no capsule stands out farther than it may.

use core::f64::consts::TAU;

use mrroc::random::Random;
use mrroc_robots::clearance::Capsule;
use mrroc_robots::mesh::{Cover, MOST_CAPSULES, MeshError, TriangleMesh, cover};
use nalgebra::Vector3;

type Corners = [Vector3<f64>; 3];

/// Triangles over a grid of points: `point(i, j)` for columns and rows, each way round where that closes.
fn sheet(
    columns: u32,
    rows: u32,
    point: impl Fn(u32, u32) -> Vector3<f64>,
) -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
    let points = (0..columns * rows).map(|k| point(k / rows, k % rows)).collect();
    let cells = (0..columns - 1).flat_map(|i| (0..rows - 1).map(move |j| i * rows + j));
    (points, cells.flat_map(|at| [[at, at + rows, at + 1], [at + 1, at + rows, at + rows + 1]]).collect())
}

fn made((points, triangles): (Vec<Vector3<f64>>, Vec<[u32; 3]>)) -> TriangleMesh {
    TriangleMesh::new(&points, &triangles).unwrap()
}

/// A box around the origin, its triangles facing outwards.
fn cuboid(edges: [f64; 3]) -> TriangleMesh {
    let points: Vec<_> = (0..8_u32)
        .map(|k| {
            Vector3::from_fn(
                |axis, _| if k >> axis & 1 == 1 { 0.5 * edges[axis] } else { -0.5 * edges[axis] },
            )
        })
        .collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[u32; 3]> =
        faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    TriangleMesh::new(&points, &triangles).unwrap()
}

/// A body that turning a line round the z axis gives: radii and heights along it, the first and the last on the axis.
fn turned(profile: &[[f64; 2]], around: u32) -> TriangleMesh {
    made(sheet(around + 1, profile.len() as u32, |i, j| {
        let angle = f64::from(i % around) / f64::from(around) * TAU;
        let [radius, height] = profile[j as usize];
        Vector3::new(radius * angle.cos(), radius * angle.sin(), height)
    }))
}

fn cylinder(radius: f64, length: f64) -> TriangleMesh {
    turned(&[[0.0, 0.0], [radius, 0.0], [radius, length], [0.0, length]], 32)
}

fn torus(large: f64, small: f64) -> TriangleMesh {
    let ring: Vec<[f64; 2]> = (0..=16)
        .map(|k| f64::from(k % 16) / 16.0 * TAU)
        .map(|angle| [large + small * angle.cos(), small * angle.sin()])
        .collect();
    turned(&ring, 24)
}

fn corners(mesh: &TriangleMesh) -> Vec<Corners> {
    mesh.triangles().iter().map(|t| t.map(|index| mesh.vertices()[index as usize])).collect()
}

/// How far a point is from a segment.
fn from_segment(point: &Vector3<f64>, a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    let along = b - a;
    let square = along.norm_squared();
    let part = if square > 0.0 { ((point - a).dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 };
    (point - a - along * part).norm()
}

/// How far a point is from a triangle: from its plane where it stands above it, else from the nearest edge.
fn from_triangle(point: &Vector3<f64>, [a, b, c]: &Corners) -> f64 {
    let normal = (b - a).cross(&(c - a)).normalize();
    let is_above =
        [(a, b), (b, c), (c, a)].iter().all(|(p, q)| (*q - *p).cross(&(point - *p)).dot(&normal) >= 0.0);
    if is_above {
        return (point - a).dot(&normal).abs();
    }
    from_segment(point, a, b).min(from_segment(point, b, c)).min(from_segment(point, c, a))
}

/// How often the surface winds around a point, by the solid angles of its triangles (Van Oosterom and Strackee, 1983).
fn winding(point: &Vector3<f64>, triangles: &[Corners]) -> f64 {
    let angle = |triangle: &Corners| {
        let [a, b, c] = triangle.map(|corner| corner - point);
        let below = a.norm() * b.norm() * c.norm()
            + a.dot(&b) * c.norm()
            + b.dot(&c) * a.norm()
            + c.dot(&a) * b.norm();
        2.0 * a.dot(&b.cross(&c)).atan2(below)
    };
    triangles.iter().map(angle).sum::<f64>() / (2.0 * TAU)
}

fn direction(random: &mut Random) -> Vector3<f64> {
    loop {
        let drawn = Vector3::from_fn(|_, _| random.within(1.0));
        if (0.01..1.0).contains(&drawn.norm()) {
            return drawn.normalize();
        }
    }
}

/// A random point on a capsule.
fn on(capsule: &Capsule, random: &mut Random) -> Vector3<f64> {
    let [a, b] = capsule.ends;
    let (away, along) = (direction(random), b - a);
    if random.unit() < 0.5 || along.norm() == 0.0 {
        return if away.dot(&along) < 0.0 { a } else { b } + away * capsule.radius;
    }
    let across = (away - along * (away.dot(&along) / along.norm_squared())).normalize();
    a + along * random.unit() + across * capsule.radius
}

/// Checks a cover by random points, against distances and windings that are found by looking at every triangle. `facing` is the
/// same body with its triangles facing outwards, where it has an inside.
fn is_a_cover(name: &str, mesh: &TriangleMesh, facing: Option<&TriangleMesh>, excess: f64) -> Cover {
    let cover = cover(mesh, excess).unwrap();
    assert!(cover.excess <= excess);
    let mut random = Random::seeded(38);
    let triangles = corners(mesh);
    for triangle in &triangles {
        for _ in 0..2000 / triangles.len() + 5 {
            let [mut u, mut v] = [random.unit(), random.unit()];
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let point = triangle[0] * (1.0 - u - v) + triangle[1] * u + triangle[2] * v;
            let is_held = |capsule: &Capsule| {
                from_segment(&point, &capsule.ends[0], &capsule.ends[1]) <= capsule.radius + 1e-12
            };
            assert!(cover.capsules.iter().any(is_held), "{name}: {point} is in no capsule");
        }
    }
    let facing = facing.map(corners);
    let mut farthest = 0.0_f64;
    for capsule in &cover.capsules {
        for _ in 0..4000 / cover.capsules.len() + 20 {
            let point = on(capsule, &mut random);
            let apart = triangles.iter().map(|t| from_triangle(&point, t)).fold(f64::INFINITY, f64::min);
            if apart > excess {
                let is_inside = facing.as_ref().is_some_and(|facing| winding(&point, facing).abs() > 0.5);
                assert!(is_inside, "{name}: {point} is {apart} m outside");
            } else if facing.as_ref().is_none_or(|facing| winding(&point, facing).abs() < 0.5) {
                farthest = farthest.max(apart);
            }
        }
    }
    println!("{name}: {} capsules, {:.2} mm outside at most", cover.capsules.len(), farthest * 1e3);
    cover
}

#[test]
fn bodies_are_covered_within_the_excess() {
    let stepped = [[0.0, 0.0], [0.05, 0.0], [0.05, 0.06], [0.02, 0.06], [0.02, 0.3], [0.0, 0.3]];
    for (name, mesh, excess) in [
        ("a cube", cuboid([0.1; 3]), 5e-3),
        ("a long box", cuboid([0.08, 0.06, 0.4]), 5e-3),
        ("a plate", cuboid([0.1, 0.08, 0.002]), 5e-3),
        ("a cylinder", cylinder(0.05, 0.2), 5e-3),
        ("a coarser cover of it", cylinder(0.05, 0.2), 2e-2),
        ("a shaft with a step", turned(&stepped, 24), 5e-3),
        ("a ring", torus(0.08, 0.02), 5e-3),
    ] {
        is_a_cover(name, &mesh, Some(&mesh), excess);
    }
}

#[test]
fn sheets_are_covered_within_the_excess() {
    let flat = made(sheet(3, 3, |i, j| Vector3::new(f64::from(i) * 0.04, f64::from(j) * 0.03, 0.1)));
    let cover = is_a_cover("a flat sheet", &flat, None, 5e-3);
    // Seven or eight strips of 10 mm less the edge of a patch, and none thicker than the excess.
    assert!(cover.capsules.len() < 30, "{}", cover.capsules.len());
    assert!(cover.capsules.iter().all(|capsule| capsule.radius <= 5e-3));
    let bent = made(sheet(13, 2, |i, j| {
        let angle = f64::from(i) / 24.0 * TAU;
        Vector3::new(0.04 * angle.cos(), 0.04 * angle.sin(), f64::from(j) * 0.05)
    }));
    is_a_cover("half a tube", &bent, None, 5e-3);
}

#[test]
fn which_way_triangles_face_does_not_matter() {
    let facing = cylinder(0.05, 0.1);
    let mixed: Vec<[u32; 3]> = facing
        .triangles()
        .iter()
        .enumerate()
        .map(|(i, [a, b, c])| if i % 3 == 0 { [*a, *c, *b] } else { [*a, *b, *c] })
        .collect();
    let mixed = TriangleMesh::new(facing.vertices(), &mixed).unwrap();
    assert!(mixed.is_closed());
    let cover = is_a_cover("a cylinder that faces nowhere", &mixed, Some(&facing), 5e-3);
    assert!(cover.capsules.len() < 60, "{}", cover.capsules.len());
}

#[test]
fn parts_that_overlap_are_one_body() {
    let (a, b) = (cuboid([0.1, 0.06, 0.06]), cuboid([0.06, 0.06, 0.2]));
    let shift = a.vertices().len() as u32;
    let points: Vec<_> = a.vertices().iter().chain(b.vertices()).copied().collect();
    let of_b = b.triangles().iter().map(|t| t.map(|index| index + shift));
    let triangles: Vec<_> = a.triangles().iter().copied().chain(of_b).collect();
    // Some of their corners are at one place, so they are moved apart.
    let points: Vec<_> =
        points.iter().enumerate().map(|(i, p)| p + Vector3::x() * if i < 8 { 0.01 } else { 0.0 }).collect();
    let both = TriangleMesh::new(&points, &triangles).unwrap();
    is_a_cover("a cross", &both, Some(&both), 5e-3);
}

#[test]
fn a_tube_whose_openings_are_closed_is_a_rod() {
    let tube = turned(&[[0.03, 0.0], [0.03, 0.2]], 24);
    assert!(!tube.is_closed());
    let (rod, openings) = tube.with_openings_closed().unwrap();
    assert_eq!(openings, 2);
    assert!(rod.is_closed());
    let with_ends = turned(&[[0.0, 0.0], [0.03, 0.0], [0.03, 0.2], [0.0, 0.2]], 24);
    let covered = is_a_cover("a tube with its ends closed", &rod, Some(&with_ends), 5e-3);
    assert!(covered.capsules.len() < cover(&tube, 5e-3).unwrap().capsules.len());
}

#[test]
fn a_scaled_mesh_has_a_scaled_cover() {
    let in_millimetres = cuboid([100.0, 60.0, 60.0]);
    // Two edges of the scale mirror the box; its triangles face outwards still.
    let mesh = in_millimetres.scaled([-0.001, -0.001, 0.002]).unwrap();
    assert_eq!(mesh.bounds()[1], Vector3::new(0.05, 0.03, 0.06));
    is_a_cover("a scaled box", &mesh, Some(&mesh), 5e-3);
    for scale in [[0.0, 1.0, 1.0], [f64::NAN, 1.0, 1.0], [1.0, f64::INFINITY, 1.0]] {
        assert!(matches!(mesh.scaled(scale), Err(MeshError::Scale { .. })));
    }
}

#[test]
fn the_same_mesh_has_the_same_cover() {
    let mesh = torus(0.08, 0.03);
    assert_eq!(cover(&mesh, 5e-3).unwrap(), cover(&mesh, 5e-3).unwrap());
}

#[test]
fn a_cover_that_would_be_too_large_or_has_no_excess_is_refused() {
    let mesh = cuboid([0.1; 3]);
    for excess in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(cover(&mesh, excess), Err(MeshError::Excess { .. })));
    }
    let large = mesh.scaled([100.0; 3]).unwrap();
    assert!(matches!(cover(&large, 5e-3), Err(MeshError::TooFine { .. })));
    // Small boxes so far apart that no capsule holds two.
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    let part = cuboid([0.01; 3]);
    for at in 0..MOST_CAPSULES as u32 + 1 {
        let place = Vector3::new(f64::from(at % 25), f64::from(at / 25), 0.0) * 0.1;
        let shift = points.len() as u32;
        points.extend(part.vertices().iter().map(|point| point + place));
        triangles.extend(part.triangles().iter().map(|t| t.map(|index| index + shift)));
    }
    let mesh = TriangleMesh::new(&points, &triangles).unwrap();
    let refused = cover(&mesh, 5e-3).unwrap_err();
    assert!(matches!(refused, MeshError::TooMany { open_edges: 0, .. }), "{refused}");
}
