//! Entities anywhere in space, as ezdxf places them; splines through fit points, as scipy computes them.

use super::*;

fn rows(text: &str) -> Vec<serde_json::Value> {
    text.lines().map(|row| serde_json::from_str(row).unwrap()).collect()
}

/// ezdxf makes arcs of cubic curves, up to 16 in a turn where it can: 3e-4 of a length at worst.
#[test]
fn extrusions_inserts_and_texts_lie_where_ezdxf_has_them() {
    let rows = rows(include_str!("reference/entities.jsonl"));
    assert!(rows.len() > 80);
    for row in rows {
        let text = |key: &str| row[key].as_str().unwrap();
        let import = import(text("blocks"), text("entities"));
        let bounds = import.drawing.bounds().unwrap();
        let expected: Vec<f64> = row["box"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        let size = (expected[2] - expected[0]).max(expected[3] - expected[1]);
        let found = [bounds.min.x, bounds.min.y, bounds.max.x, bounds.max.y];
        for (found, expected) in found.iter().zip(&expected) {
            assert!(
                (found - expected).abs() < 3e-4 * size,
                "{}: {bounds:?} for {:?}",
                text("name"),
                row["box"]
            );
        }
        if let Some(length) = row["length"].as_f64() {
            let found = import.drawing.length();
            assert!((found - length).abs() < 3e-4 * length, "{}: {found} for {length}", text("name"));
        }
    }
}

#[test]
fn a_tilted_circle_is_engraved_as_the_ellipse_that_is_seen() {
    let import = read_str("a.dxf", include_str!("files/d06_extrusion_tilt.dxf"), Limits::default()).unwrap();
    let circle = import.drawing.strokes.iter().find(|s| s.closure() == Closure::Closed).unwrap();
    // By hand: the plane's axes are (-1, 0, 0) and (0, -0.8, 0.6).
    let bounds = circle.bounds();
    assert!((bounds.min - Vec2::new(-15.0, -12.0)).norm() < 1e-9, "{bounds:?}");
    assert!((bounds.max - Vec2::new(-5.0, -4.0)).norm() < 1e-9, "{bounds:?}");
    assert!(
        import.warnings.iter().any(|w| w.contains("1 entity not parallel to the plate")),
        "{:?}",
        import.warnings
    );
}

#[test]
fn what_stands_upright_on_the_plate_is_left_out_and_told() {
    let upright = "0 CIRCLE 10 0 20 0 40 5 210 0 220 1 230 0 0 LINE 10 1 20 1 30 0 11 1 21 1 31 7";
    let import = import("", &format!("{upright} 0 LINE 10 0 20 0 11 3 21 4"));
    assert!(near(import.drawing.length(), 5.0));
    let told = import.warnings.join("\n");
    assert!(
        told.contains("1 CIRCLE left out: upright") && told.contains("1 LINE left out: upright"),
        "{told}"
    );
    assert!(refusal(&file("", upright, 4)).contains("upright"));
}

#[test]
fn splines_through_fit_points_begin_and_end_as_they_say() {
    for row in rows(include_str!("reference/fit_splines.jsonl")) {
        let name = row["name"].as_str().unwrap();
        let drawing = import("", row["entities"].as_str().unwrap()).drawing;
        let expected = row["length"].as_f64().unwrap();
        assert!((drawing.length() - expected).abs() < 2e-6 * expected, "{name}: {}", drawing.length());
        let middle = Vec2::new(row["middle"][0].as_f64().unwrap(), row["middle"][1].as_f64().unwrap());
        let polyline = drawing.strokes[0].flattened(1e-6);
        let nearest = polyline.windows(2).map(|w| {
            let along = w[1] - w[0];
            let t = ((middle - w[0]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            (w[0] + along * t - middle).norm()
        });
        assert!(nearest.fold(f64::MAX, f64::min) < 1e-5, "{name}");
    }
    let import = read_str("a.dxf", include_str!("files/d08d_fit_tangents.dxf"), Limits::default()).unwrap();
    let tangent = import.drawing.strokes[0].tip_tangent(0, 0.0);
    assert!((tangent.x - 1.0).abs() < 1e-9, "{tangent}");
}
