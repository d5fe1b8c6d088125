//! The colours of all pictures: told apart by the colour-blind, dark enough for thin lines on white.

use super::colour::Colour;

/// Grounds that are drawn on.
pub const WHITE: Colour = Colour::hex(0xffffff);
/// The page that white panels lie on.
pub const PAGE: Colour = Colour::hex(0xf3f5f7);
/// The ground of a drawing in a panel.
pub const PALE: Colour = Colour::hex(0xfafbfc);
/// The floor that robots stand on.
pub const FLOOR: Colour = Colour::hex(0xf6f8f9);

/// Text and axes.
pub const INK: Colour = Colour::hex(0x1c2733);
/// Text of less weight.
pub const GREY: Colour = Colour::hex(0x5d6b79);
/// Grid lines, and borders of panels.
pub const GRID: Colour = Colour::hex(0xe2e6ea);
/// Lines a little stronger than the grid.
pub const RULE: Colour = Colour::hex(0xb4bdc6);

/// A region that something may be in.
pub const REGION: Colour = Colour::hex(0xdbe9f6);
/// A body that robots handle.
pub const BLOCK: Colour = Colour::hex(0x9a6a1f);
/// The one line that is looked at.
pub const HIGHLIGHT: Colour = Colour::hex(0xc8102e);
/// The axes x, y and z of a frame.
pub const FRAME: [Colour; 3] = [Colour::hex(0xdd0000), Colour::hex(0x009900), Colour::hex(0x0000dd)];

/// Of joints, in their order: Okabe and Ito (2008), its yellow darkened, and a brown for the eighth.
const JOINTS: [Colour; 8] = [
    Colour::hex(0x0072b2),
    Colour::hex(0xd55e00),
    Colour::hex(0x009e73),
    Colour::hex(0xcc5f9f),
    Colour::hex(0xb38600),
    Colour::hex(0x3fa4dc),
    Colour::hex(0x3b3b3b),
    Colour::hex(0x8c564b),
];

/// Of robots, in their order: dark, so that they are not taken for joints.
const ROBOTS: [Colour; 8] = [
    Colour::hex(0x264b73),
    Colour::hex(0x8a4b12),
    Colour::hex(0x2f6b4f),
    Colour::hex(0x6b3a78),
    Colour::hex(0x4a5560),
    Colour::hex(0x8b2f3c),
    Colour::hex(0x3d6f86),
    Colour::hex(0x6d6420),
];

/// From slow to fast: dark blue to orange, its lightness grows evenly (after matplotlib's plasma).
const SPEEDS: [Colour; 6] = [
    Colour::hex(0x0d0887),
    Colour::hex(0x5c01a6),
    Colour::hex(0x9c179e),
    Colour::hex(0xcc4778),
    Colour::hex(0xed7953),
    Colour::hex(0xfbaa34),
];

/// Of joint `index`, from 0, or of the lines of a plot in their order; after eight they come again.
#[must_use]
pub fn joint(index: usize) -> Colour {
    JOINTS[index % JOINTS.len()]
}

/// Of robot `index`, from 0; after eight they come again.
#[must_use]
pub fn robot(index: usize) -> Colour {
    ROBOTS[index % ROBOTS.len()]
}

/// Of a speed as a share of the fastest, 0 to 1.
#[must_use]
pub fn speed(share: f64) -> Colour {
    let place = share.clamp(0.0, 1.0) * (SPEEDS.len() - 1) as f64;
    let index = (place.floor() as usize).min(SPEEDS.len() - 2);
    SPEEDS[index].towards(SPEEDS[index + 1], place - index as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_begin_dark_end_bright_and_no_number_is_a_colour_too() {
        assert_eq!([speed(0.0), speed(1.0)], [SPEEDS[0], SPEEDS[5]]);
        assert_eq!(speed(0.2), SPEEDS[1]);
        assert_eq!(speed(0.1), SPEEDS[0].towards(SPEEDS[1], 0.5));
        assert_eq!(speed(2.0), SPEEDS[5]);
        let _ = speed(f64::NAN);
    }
}
