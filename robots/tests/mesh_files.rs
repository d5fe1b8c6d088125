//! Files of meshes: the same body in all formats, and what is refused.

use mrroc_robots::mesh::{MeshError, TriangleMesh};
use nalgebra::Vector3;

/// A tetrahedron, whose numbers are exact in `f32`.
const CORNERS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.25, 0.0], [0.0, 0.0, 0.125]];
const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

fn expected() -> TriangleMesh {
    TriangleMesh::new(&CORNERS.map(Vector3::from), &FACES).unwrap()
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = b"solid though it is binary".to_vec();
    bytes.resize(80, 0);
    bytes.extend(4_u32.to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        for corner in face {
            bytes.extend(CORNERS[corner as usize].iter().flat_map(|x| (*x as f32).to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn ascii_stl() -> String {
    let vertex = |corner: &u32| {
        let [x, y, z] = CORNERS[*corner as usize];
        format!("vertex {x} {y} {z}\n")
    };
    let facet = |face: &[u32; 3]| {
        let corners: String = face.iter().map(vertex).collect();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    format!("solid a body\n{}endsolid a body\n", FACES.iter().map(facet).collect::<String>())
}

fn obj() -> String {
    let vertices = CORNERS.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    // With normals, and one face by negative indices.
    let faces = "f 1//1 3//1 2//1\nf 1 2 4\nf -3/1/2 -2/1/2 -1/1/2\nf 1 4 3\n";
    format!("# a comment\n{vertices}vn 0 0 1\n{faces}")
}

/// In millimetres, turned by a node and put back by the matrix within it.
fn dae() -> String {
    let positions = CORNERS.map(|[x, y, z]| format!("{} {} {} ", x * 1e3, y * 1e3, z * 1e3)).concat();
    let indices = FACES.as_flattened().iter().map(|i| format!("0 {i} ")).collect::<String>();
    format!(
        r##"<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="millimeter" meter="0.001"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="12">{positions}</float_array>
<technique_common><accessor source="#a" count="4" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="4"><input semantic="NORMAL" source="#n" offset="0"/><input semantic="VERTEX" source="#v" offset="1"/>
<vcount>3 3 3 3</vcount><p>{indices}</p></polylist></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><translate>100 0 0</translate><rotate>0 0 1 90</rotate>
<node><matrix>0 1 0 0 -1 0 0 100 0 0 1 0 0 0 0 1</matrix><instance_geometry url="#g"/></node></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"##
    )
}

#[test]
fn all_formats_give_the_same_mesh() {
    for (kind, bytes) in [
        ("stl", binary_stl()),
        ("stl", ascii_stl().into_bytes()),
        ("obj", obj().into_bytes()),
        ("dae", dae().into_bytes()),
    ] {
        let mesh = TriangleMesh::from_bytes(kind, &bytes).unwrap();
        assert!(mesh.is_closed(), "{kind}");
        let corners = |mesh: &TriangleMesh| -> Vec<[Vector3<f64>; 3]> {
            mesh.triangles().iter().map(|t| t.map(|index| mesh.vertices()[index as usize])).collect()
        };
        for (found, expected) in corners(&mesh).iter().flatten().zip(corners(&expected()).iter().flatten()) {
            assert!((found - expected).amax() < 1e-12, "{kind}: {found} is not {expected}");
        }
    }
}

#[test]
fn a_file_that_is_cut_off_is_refused_wherever_that_is() {
    for length in 0..binary_stl().len() {
        let refused = TriangleMesh::from_bytes("stl", &binary_stl()[..length]);
        assert!(refused.is_err(), "binary STL of {length} bytes");
    }
    let whole = ascii_stl();
    for length in 0..whole.find("endsolid").unwrap() {
        let refused = TriangleMesh::from_bytes("stl", &whole.as_bytes()[..length]);
        assert!(refused.is_err(), "ASCII STL of {length} bytes");
    }
    let whole = dae();
    for length in 0..whole.len() {
        assert!(
            TriangleMesh::from_bytes("dae", &whole.as_bytes()[..length]).is_err(),
            "COLLADA of {length} bytes"
        );
    }
}

#[test]
fn counts_that_no_file_holds_are_refused_before_memory_is_taken() {
    let mut bytes = binary_stl();
    bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    bytes[0] = b'x';
    let refused = TriangleMesh::from_bytes("stl", &bytes).unwrap_err();
    assert!(matches!(refused, MeshError::Length { count: u32::MAX, bytes: 284, .. }), "{refused}");
    let refused = |from: &str, to: &str| {
        assert!(dae().contains(from));
        TriangleMesh::from_bytes("dae", dae().replace(from, to).as_bytes()).unwrap_err().to_string()
    };
    let many = refused("count=\"4\" stride", "count=\"4000000000000000000\" stride");
    assert!(many.contains("line 4") && many.contains("4000000000000000000"), "{many}");
    assert!(refused("<vcount>3 3 3 3", "<vcount>3 3 3 18446744073709551615").contains("24 indices"));
    assert!(refused("offset=\"1\"", "offset=\"99999999999\"").contains("offset"));
}

#[test]
fn numbers_and_indices_that_are_wrong_are_named() {
    let mut bytes = binary_stl();
    bytes[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
    let refused = TriangleMesh::from_bytes("stl", &bytes).unwrap_err();
    assert!(matches!(refused, MeshError::Coordinate { vertex: 0, .. }), "{refused}");
    for (from, to, line) in [
        ("v 0.5 0 0", "v 0.5 x 0", 3),
        ("v 0.5 0 0", "v 0.5 0", 3),
        ("f 1 4 3", "f 1 5 3", 10),
        ("f 1 4 3", "f 0 4 3", 10),
        ("f 1 4 3", "f -5 4 3", 10),
        ("f 1 4 3", "f 1 4", 10),
    ] {
        let refused = TriangleMesh::from_bytes("obj", obj().replace(from, to).as_bytes()).unwrap_err();
        assert!(matches!(refused, MeshError::Text { line: found, .. } if found == line), "{to}: {refused}");
    }
    for far in ["v inf 0 0", "v 1e9 0 0"] {
        let refused =
            TriangleMesh::from_bytes("obj", obj().replace("v 0.5 0 0", far).as_bytes()).unwrap_err();
        assert!(matches!(refused, MeshError::Coordinate { vertex: 1, .. }), "{refused}");
    }
    let refused = TriangleMesh::from_bytes("dae", dae().replace("0 3 0 2 </p>", "0 3 0 4 </p>").as_bytes());
    assert!(refused.unwrap_err().to_string().contains("vertex 4, and there are 4"));
    let refused = TriangleMesh::from_bytes("dae", dae().replace("url=\"#g\"", "url=\"#h\"").as_bytes());
    assert!(refused.unwrap_err().to_string().contains("line 10"));
    let refused = TriangleMesh::new(&CORNERS.map(Vector3::from), &[[0, 1, 9]]).unwrap_err();
    assert!(matches!(refused, MeshError::Index { triangle: 0, index: 9, count: 4 }), "{refused}");
}

#[test]
fn geometries_cannot_be_shown_more_often_than_the_file_is_long() {
    let shown = r##"<instance_geometry url="#g"/>"##;
    let text = dae().replace(shown, &shown.repeat(1000));
    assert!(TriangleMesh::from_bytes("dae", text.as_bytes()).is_ok());
    // One of a thousand triangles, a thousand times.
    let many = "0 0 0 1 0 2 ".repeat(1000);
    let sides = "3 ".repeat(1000);
    let text = text
        .replace("<vcount>3 3 3 3", &format!("<vcount>{sides}3 3 3 3"))
        .replace("<p>", &format!("<p>{many}"));
    let refused = TriangleMesh::from_bytes("dae", text.as_bytes()).unwrap_err();
    assert!(refused.to_string().contains("too often"), "{refused}");
}

#[test]
fn triangles_without_an_area_are_dropped_and_counted() {
    let flat = [FACES.as_slice(), &[[0, 0, 1], [1, 1, 1]]].concat();
    let mesh = TriangleMesh::new(&CORNERS.map(Vector3::from), &flat).unwrap();
    assert_eq!((mesh.triangles().len(), mesh.dropped()), (4, 2));
    // An edge with a corner in its middle on one side: the triangle between the two sides has no area, and closes the mesh.
    let corners = [CORNERS.as_slice(), &[[0.25, 0.0, 0.0]]].concat();
    let corners: Vec<Vector3<f64>> = corners.into_iter().map(Vector3::from).collect();
    let seam = [[0, 2, 1], [0, 4, 3], [4, 1, 3], [1, 2, 3], [0, 3, 2], [0, 1, 4]];
    let mesh = TriangleMesh::new(&corners, &seam).unwrap();
    assert_eq!((mesh.triangles().len(), mesh.dropped(), mesh.is_closed()), (5, 1, true));
    let scaled = mesh.scaled([2.0; 3]).unwrap();
    assert_eq!((scaled.triangles().len(), scaled.dropped(), scaled.is_closed()), (5, 1, true));
    let refused = TriangleMesh::new(&CORNERS.map(Vector3::from), &[[0, 0, 1]]).unwrap_err();
    assert!(matches!(refused, MeshError::Empty { dropped: 1 }), "{refused}");
    assert!(matches!(
        TriangleMesh::from_bytes("stl", b"solid\nendsolid\n"),
        Err(MeshError::Empty { dropped: 0 })
    ));
    assert!(matches!(TriangleMesh::from_bytes("obj", b""), Err(MeshError::Empty { dropped: 0 })));
}

#[test]
fn errors_name_the_file() {
    let folder = std::env::temp_dir().join(format!("mrroc-mesh-files-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        TriangleMesh::from_file(&path)
    };
    assert_eq!(write("Arm.STL", &binary_stl()).unwrap(), expected());
    for (name, bytes) in
        [("cut.stl", &binary_stl()[..200]), ("arm.step", b"ISO-10303"), ("bad.obj", b"v 1 2\n")]
    {
        let refused = write(name, bytes).unwrap_err().to_string();
        assert!(refused.contains(name), "{refused}");
    }
    let missing = TriangleMesh::from_file(folder.join("missing.stl")).unwrap_err().to_string();
    assert!(missing.contains("missing.stl"), "{missing}");
    std::fs::remove_dir_all(&folder).unwrap();
}
