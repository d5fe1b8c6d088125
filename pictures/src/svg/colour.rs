//! A colour.

use std::fmt;

/// A colour of the sRGB space. Written as `#rrggbb`, or `#rgb` where that says the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour {
    /// Red, green, blue.
    channels: [u8; 3],
}

impl Colour {
    /// The colour that is written `0xrrggbb`; what is above these three bytes is ignored.
    #[must_use]
    pub const fn hex(rgb: u32) -> Colour {
        let [_, red, green, blue] = rgb.to_be_bytes();
        Colour { channels: [red, green, blue] }
    }

    /// On the straight line from this colour to another one, `share` 0 to 1.
    #[must_use]
    pub fn towards(self, other: Colour, share: f64) -> Colour {
        let share = share.clamp(0.0, 1.0);
        let mixed = |i: usize| {
            let from = f64::from(self.channels[i]);
            let to = f64::from(other.channels[i]);
            (from + (to - from) * share).round() as u8
        };
        Colour { channels: std::array::from_fn(mixed) }
    }
}

impl fmt::Display for Colour {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [red, green, blue] = self.channels;
        if self.channels.iter().all(|channel| channel >> 4 == channel & 15) {
            return write!(f, "#{:x}{:x}{:x}", red & 15, green & 15, blue & 15);
        }
        write!(f, "#{red:02x}{green:02x}{blue:02x}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_colour_is_written_as_it_was_given_and_short_where_it_can_be() {
        let texts = [0x0072b2, 0xffffff, 0x112233, 0x112234].map(|rgb| Colour::hex(rgb).to_string());
        assert_eq!(texts, ["#0072b2", "#fff", "#123", "#112234"]);
    }

    #[test]
    fn between_two_colours_every_channel_is_between() {
        let (black, orange) = (Colour::hex(0), Colour::hex(0xff8000));
        assert_eq!(black.towards(orange, 0.5), Colour::hex(0x804000));
        assert_eq!([black.towards(orange, -1.0), black.towards(orange, 2.0)], [black, orange]);
    }
}
