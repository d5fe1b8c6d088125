//! Colours: told apart by the colour-blind, dark enough for thin lines on white.

/// The page and the panels on it.
pub(crate) const PAGE: &str = "#f3f5f7";
/// The ground of a panel.
pub(crate) const PANEL: &str = "#ffffff";
/// Words and axes.
pub(crate) const INK: &str = "#1c2733";
/// Words of less weight.
pub(crate) const GREY: &str = "#5d6b79";
/// Grid lines, and borders of panels.
pub(crate) const GRID: &str = "#e2e6ea";
/// Lines a little stronger than the grid.
pub(crate) const RULE: &str = "#b4bdc6";

/// Of a body that robots handle.
pub(crate) const BLOCK: &str = "#9a6a1f";

/// Of joints, in their order: Okabe and Ito (2008), its yellow darkened, and a brown for the eighth.
const JOINTS: [&str; 8] =
    ["#0072b2", "#d55e00", "#009e73", "#cc5f9f", "#b38600", "#3fa4dc", "#3b3b3b", "#8c564b"];

/// Of robots, in their order: dark, so that they are not taken for joints.
const ROBOTS: [&str; 8] =
    ["#264b73", "#8a4b12", "#2f6b4f", "#6b3a78", "#4a5560", "#8b2f3c", "#3d6f86", "#6d6420"];

/// From slow to fast: dark blue to orange, its lightness grows evenly (after matplotlib's plasma).
const SPEED: [[u8; 3]; 6] =
    [[13, 8, 135], [92, 1, 166], [156, 23, 158], [204, 71, 120], [237, 121, 83], [251, 170, 52]];

/// How many speeds a path tells apart.
pub(crate) const LEVELS: usize = 12;

/// Of joint `index`, from 0.
pub(crate) fn joint(index: usize) -> &'static str {
    JOINTS[index % JOINTS.len()]
}

/// Of robot `index`, from 0.
pub(crate) fn robot(index: usize) -> &'static str {
    ROBOTS[index % ROBOTS.len()]
}

/// Of a speed as a share of the fastest, 0 to 1.
pub(crate) fn speed(share: f64) -> String {
    let place = share.clamp(0.0, 1.0) * (SPEED.len() - 1) as f64;
    let index = (place.floor() as usize).min(SPEED.len() - 2);
    let part = place - index as f64;
    let mixed = |i: usize| {
        let (a, b) = (f64::from(SPEED[index][i]), f64::from(SPEED[index + 1][i]));
        (a + (b - a) * part).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", mixed(0), mixed(1), mixed(2))
}

/// Of a level of speed, 0 to [`LEVELS`] - 1.
pub(crate) fn level(level: usize) -> String {
    speed(level as f64 / (LEVELS - 1) as f64)
}
