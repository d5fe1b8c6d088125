//! The one writer of SVG: every picture of mrroc's crates, tasks and examples is written with it.
//!
//! In: shapes and text on a page, in the page's unit, x to the right and y down. Out: one SVG document that needs no
//! script, no style sheet and no network.
//!
//! - [`Page`] is the document: its size, its unit, its title. It hands out an [`Svg`], which writes shapes, groups and
//!   text. Text is escaped; numbers have the page's digits and are always numbers.
//! - [`Look`] says how a shape is drawn, [`TextStyle`] how text is; their colours are a [`Colour`], best one of
//!   [`palette`].
//! - [`Axes`] is the frame of a plot: two axes with round [`Ticks`], a grid, and curves.
//!
//! ```
//! use mrroc_pictures::svg::{Area, Axes, Look, Page, Range, TextStyle, palette};
//! use nalgebra::Vector2;
//!
//! let times: Vec<f64> = (0..=100).map(|i| f64::from(i) * 0.01).collect();
//! let force: Vec<f64> = times.iter().map(|t| 10.0 * (6.0 * t).sin()).collect();
//! let frame = Area { x: 60.0, y: 40.0, width: 380.0, height: 130.0 };
//! let axes = Axes::new(frame, Range::of(&times), Range::with_zero(&force, 0.0));
//! let document = Page::new("A force", 460.0, 210.0).draw(|svg| {
//!     svg.text(Vector2::new(60.0, 24.0), TextStyle::new(15.0, palette::INK).bold(), "Force & time [N, s]");
//!     axes.draw_grid(svg);
//!     axes.draw_labels_below(svg);
//!     svg.polyline(&axes.curve(&times, &force), Look::line(palette::joint(0), 1.5));
//! });
//! assert!(document.starts_with("<svg") && document.contains("Force &amp; time"));
//! ```

mod area;
mod axes;
mod axis;
mod colour;
mod look;
mod number;
mod page;
pub mod palette;
mod text;
pub(crate) mod thinning;
mod ticks;
mod writer;

pub use area::Area;
pub use axes::Axes;
pub use axis::{Axis, Range};
pub use colour::Colour;
pub use look::Look;
pub use page::Page;
pub use text::{TextStyle, shortened};
pub use thinning::thinned;
pub use ticks::Ticks;
pub(crate) use ticks::step;
pub use writer::Svg;
