//! Pictures of what the matrix heard: reliefs with the parts that were found in them, and echoes over time.

use mrroc_pictures::svg::palette::{GREY, HIGHLIGHT, INK, REGION, WHITE, joint};
use mrroc_pictures::svg::{Area, Axes, Colour, Look, Page, Range, TextStyle};
use mrroc_sensors::aggregation::{HeardObject, Relief};
use mrroc_sensors::ultrasound::{Air, Waveform};
use nalgebra::{Rotation2, Vector2};

use super::layout::array;
use crate::camera::kinds::kinds;
use crate::camera::looks::Trace;
use crate::pictures::{MARGIN, heading};

const WIDTH: f64 = 1000.0;
/// Reliefs in a row, and the edge of each.
const COLUMNS: usize = 3;
const SIDE: f64 = 290.0;
/// How much of the belt is drawn to each side of a thing \[m\].
const HALF: f64 = 0.1;

/// A colour for a height: pale of the belt, dark of 40 mm.
fn shade(height: f64) -> Colour {
    WHITE.towards(joint(0), (height / 0.045).clamp(0.0, 1.0))
}

/// Reliefs from above: a dot for each ping, and the outline that was found.
#[must_use]
pub fn reliefs(all: &[(Relief, HeardObject)]) -> String {
    let kinds = kinds();
    let rows = all.len().div_ceil(COLUMNS).max(1);
    Page::new("What the matrix heard", WIDTH, 110.0 + (SIDE + 44.0) * rows as f64).draw(|svg| {
        let text = "a dot for each ping, the darker the higher, on 20 cm of belt; a cross: no echo. Outline and axes: what was found";
        heading(svg, "What the matrix heard", text);
        for (number, (relief, heard)) in all.iter().enumerate() {
            let x = MARGIN + (SIDE + 16.0) * (number % COLUMNS) as f64;
            let y = 120.0 + (SIDE + 44.0) * (number / COLUMNS) as f64;
            let frame = Area { x, y, width: SIDE, height: SIDE };
            svg.rectangle(frame, 2.0, Look::filled(WHITE).stroke(REGION));
            let ends = |values: &mut dyn Iterator<Item = f64>| {
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
            };
            let (low, high) = ends(&mut relief.samples.iter().map(|sample| sample.along));
            let middle = Vector2::new(0.5 * (low + high), 0.0);
            let at = |place: Vector2<f64>| {
                let off = (place - middle) / (2.0 * HALF) * SIDE;
                Vector2::new(x + 0.5 * SIDE + off.x, y + 0.5 * SIDE - off.y)
            };
            let inside = |place: &Vector2<f64>| (place - middle).abs().max() < HALF;
            for sample in &relief.samples {
                let place = Vector2::new(sample.along, sample.across);
                if !inside(&place) {
                    continue;
                }
                let dot = at(place);
                match sample.heard {
                    Some([z, _]) => svg.circle(dot, 4.2, Look::filled(shade(z)).stroke(REGION)),
                    None => {
                        for slope in [1.0, -1.0] {
                            let arm = Vector2::new(3.0, 3.0 * slope);
                            svg.line(dot - arm, dot + arm, Look::line(GREY, 1.0));
                        }
                    }
                }
            }
            let name = heard.class.map_or("none of the kinds", |class| kinds[class].class.name);
            let label = format!("{name}: score {:.2}, misfit {:.2}", heard.score, heard.misfit);
            svg.text(Vector2::new(x, y - 7.0), TextStyle::new(13.0, INK), &label);
            if let Some(class) = heard.class {
                let turn = Rotation2::new(heard.angle);
                let placed = |[px, py]: [f64; 2]| at(heard.place + turn * Vector2::new(px, py));
                let outline = kinds[class].outline();
                for (a, b) in outline.iter().zip(outline.iter().cycle().skip(1)) {
                    svg.line(placed(*a), placed(*b), Look::line(HIGHLIGHT, 1.6));
                }
                svg.line(placed([0.0, 0.0]), placed([0.03, 0.0]), Look::line(INK, 1.6));
                svg.line(placed([0.0, 0.0]), placed([0.0, 0.018]), Look::line(INK, 1.6));
            }
        }
    })
}

/// What one transducer heard while a part passed: pressures over the range, one line for each ping, and where the threshold found the echo.
#[must_use]
pub fn echoes(traces: &[Trace]) -> String {
    const MOST: usize = 26;
    let transducer = array().transducer(Air { celsius: 20.0 });
    let [from, to] = transducer.gate();
    Page::new("Echoes of one transducer", WIDTH, 640.0).draw(|svg| {
        let text = "one line for each ping, the newest on top; dots: the threshold is passed; crosses: the echo's middle, without the walk";
        heading(svg, "Echoes while a part passes", text);
        let frame = Area { x: MARGIN, y: 110.0, width: WIDTH - 2.0 * MARGIN, height: 470.0 };
        let shown = &traces[traces.len().saturating_sub(MOST)..];
        let axes = Axes::new(frame, Range { low: 1e3 * from, high: 1e3 * to }, Range { low: 0.0, high: MOST as f64 + 2.0 });
        axes.draw_grid(svg);
        axes.draw_labels_below(svg);
        let most = shown.iter().flat_map(|trace| &trace.heard).fold(1e-9_f64, |most, p| most.max(*p));
        for (line, trace) in shown.iter().enumerate() {
            let place = |bin: usize, p: f64| axes.at(1e3 * (from + bin as f64 * Waveform::BIN), line as f64 + 2.4 * p / most);
            for (bin, pair) in trace.heard.windows(2).enumerate() {
                svg.line(place(bin, pair[0]), place(bin + 1, pair[1]), Look::line(joint(0), 1.0));
            }
            if let Some(echo) = &trace.echo {
                let range = |time: f64| 0.5 * transducer.air().speed() * time;
                let height = line as f64 + 2.4 * transducer.threshold() / most;
                let crossed = axes.at(1e3 * range(echo.time), height);
                svg.circle(crossed, 2.4, Look::filled(HIGHLIGHT));
                let middle = axes.at(1e3 * range(transducer.middle(echo)), line as f64);
                for slope in [1.0, -1.0] {
                    let arm = Vector2::new(3.5, 3.5 * slope);
                    svg.line(middle - arm, middle + arm, Look::line(INK, 1.2));
                }
            }
        }
        svg.text(Vector2::new(frame.right(), frame.bottom() + 36.0), TextStyle::new(12.0, GREY).end(), "range [mm]; the belt is at 250");
        svg.text(Vector2::new(MARGIN - 44.0, 104.0), TextStyle::new(12.0, GREY), "ping");
    })
}
