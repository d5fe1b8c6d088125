//! How sure what was found is: what is left of the measurements, correlations, and what the measurements see at all.

use mrroc_calibration::Fit;
use mrroc_pictures::svg::palette::{GREY, HIGHLIGHT, INK, RULE, WHITE, joint};
use mrroc_pictures::svg::{Area, Axes, Look, Page, Range, TextStyle};
use nalgebra::Vector2;

use super::{MARGIN, WIDTH, heading};

/// Width of a bar of the histogram, in standard deviations.
const BIN: f64 = 0.25;
/// The histogram's ends.
const END: f64 = 5.0;

/// What is left of all measurements in units of their standard deviations, beside the normal distribution.
#[must_use]
pub fn residuals(fit: &Fit) -> String {
    let all = fit.unit_residuals();
    let count = all.len() as f64;
    let bins = (2.0 * END / BIN) as usize;
    let mut share = vec![0.0; bins];
    for residual in all {
        let bin = ((residual + END) / BIN).clamp(0.0, bins as f64 - 1.0) as usize;
        share[bin] += 1.0 / (count * BIN);
    }
    let rms = (all.iter().map(|r| r * r).sum::<f64>() / count).sqrt();
    Page::new("What is left of the measurements", WIDTH, 480.0).draw(|svg| {
        let below = format!(
            "{} numbers in units of their standard deviations, {rms:.2} rms; line: the normal distribution",
            all.len()
        );
        heading(svg, "What is left of the measurements", &below);
        let frame = Area { x: MARGIN, y: 90.0, width: WIDTH - 2.0 * MARGIN, height: 340.0 };
        let axes = Axes::new(frame, Range { low: -END, high: END }, Range { low: 0.0, high: 0.45 });
        axes.draw_grid(svg);
        axes.draw_labels_below(svg);
        for (bin, share) in share.iter().enumerate() {
            let low = -END + bin as f64 * BIN;
            let (corner, foot) = (axes.at(low, *share), axes.at(low + BIN, 0.0));
            let bar = Area {
                x: corner.x + 1.0,
                y: corner.y,
                width: foot.x - corner.x - 2.0,
                height: foot.y - corner.y,
            };
            svg.rectangle(bar, 0.0, Look::filled(joint(0)).fill_opacity(0.5));
        }
        let across: Vec<f64> = (0..=200).map(|i| -END + f64::from(i) * END / 100.0).collect();
        let density = |x: &f64| (-0.5 * x * x).exp() / core::f64::consts::TAU.sqrt();
        let up: Vec<f64> = across.iter().map(density).collect();
        svg.polyline(&axes.curve(&across, &up), Look::line(HIGHLIGHT, 1.6).no_fill());
    })
}

/// The correlation of each two parameters: blue where they rise together, red where one falls.
#[must_use]
pub fn correlations(fit: &Fit) -> String {
    const LABELS: f64 = 190.0;
    let names: Vec<String> = fit.found().map(|found| found.parameter.name).collect();
    let covariance = fit.covariance();
    let n = names.len();
    let cell = ((WIDTH - 2.0 * MARGIN - LABELS) / n as f64).min(11.0);
    let height = 90.0 + cell * n as f64 + MARGIN;
    let corner = Vector2::new(MARGIN + LABELS, 90.0);
    Page::new("Correlations", WIDTH, height).draw(|svg| {
        heading(svg, "Correlations of what was found", "blue: errors of both rise together; red: of one rise where those of the other fall; darker: closer to 1");
        for i in 0..n {
            let row = corner + Vector2::new(-5.0, (i as f64 + 0.8) * cell);
            svg.text(row, TextStyle::new((0.85 * cell).min(9.0), INK).end(), &names[i]);
            for j in 0..n {
                let spread = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
                let correlation = if spread > 0.0 { covariance[(i, j)] / spread } else { 0.0 };
                if correlation.abs() < 0.05 {
                    continue;
                }
                let tone = if correlation > 0.0 { joint(0) } else { HIGHLIGHT };
                let at = corner + Vector2::new(j as f64, i as f64) * cell;
                let area = Area { x: at.x, y: at.y, width: cell, height: cell };
                svg.rectangle(area, 0.0, Look::filled(WHITE.towards(tone, correlation.abs().min(1.0))));
            }
        }
        let side = n as f64 * cell;
        let frame = Area { x: corner.x, y: corner.y, width: side, height: side };
        svg.rectangle(frame, 0.0, Look::line(RULE, 1.0).no_fill());
    })
}

/// How well each parameter is seen: its standard deviation beside what was believed of it.
#[must_use]
pub fn observability(fit: &Fit) -> String {
    const LABELS: f64 = 210.0;
    const ROW: f64 = 15.0;
    let found: Vec<_> = fit.found().filter(|found| found.parameter.tolerance.is_some()).collect();
    let unseen = fit.unseen();
    let height = 130.0 + ROW * (found.len() + unseen.len()) as f64 + MARGIN;
    let rank = fit.information();
    Page::new("What is seen", WIDTH, height).draw(|svg| {
        let below = format!(
            "rank {} of {} parameters; bars: the standard deviation as a part of what was believed before, 1 at the right: nothing was learnt",
            rank.rank,
            rank.parameters()
        );
        heading(svg, "What is seen of the arms", &below);
        let frame = Area { x: MARGIN + LABELS, y: 80.0, width: WIDTH - 3.0 * MARGIN - LABELS, height: ROW * found.len() as f64 };
        let axes = Axes::new(frame, Range { low: -4.0, high: 0.0 }, Range { low: 0.0, high: 1.0 });
        for power in -4..=0 {
            let x = axes.at(f64::from(power), 0.0).x;
            svg.line(Vector2::new(x, frame.y), Vector2::new(x, frame.bottom()), Look::line(RULE, 0.8));
            let label = format!("{:.4}", 10_f64.powi(power)).trim_end_matches('0').trim_end_matches('.').to_owned();
            svg.text(Vector2::new(x, frame.bottom() + 16.0), TextStyle::new(11.0, GREY).middle(), &label);
        }
        for (i, one) in found.iter().enumerate() {
            let y = frame.y + i as f64 * ROW;
            svg.text(Vector2::new(frame.x - 6.0, y + 11.0), TextStyle::new(11.0, INK).end(), &one.parameter.name);
            let part = one.sigma / one.parameter.tolerance.unwrap_or(1.0);
            let end = axes.at(part.max(1e-4).log10().min(0.0), 0.0).x;
            let bar = Area { x: frame.x, y: y + 3.0, width: (end - frame.x).max(1.0), height: ROW - 6.0 };
            let colour = if part > 0.5 { HIGHLIGHT } else { joint(0) };
            svg.rectangle(bar, 0.0, Look::filled(colour).fill_opacity(0.6));
            let (unit, factor) = one.parameter.unit.shown();
            let label = format!("{:.4} {unit}", one.sigma * factor);
            svg.text(Vector2::new(end + 6.0, y + 11.0), TextStyle::new(10.0, GREY), &label);
        }
        for (i, one) in unseen.iter().enumerate() {
            let at = Vector2::new(MARGIN, frame.bottom() + 46.0 + i as f64 * ROW);
            svg.text(at, TextStyle::new(11.0, INK), &format!("cannot be told apart: {one}"));
        }
    })
}
