//! Ultrasound in air, as it is believed to be: beams, pulses, what surfaces send back, and what a threshold detector makes of it.
//!
//! ```text
//! p(t) = k / 2 pi   sum over rays   D(theta)^2 e^(-2 j k r) g(t - 2 r / c) 10^(-1.3 2 r / 20) d Omega          Kirchhoff, rigid surfaces
//! ```
//!
//! The sum runs over the directions of a transducer that sends and hears; r is where a ray meets a surface first. An element dA
//! of a surface sends back cos(theta) dA / r^2 = d Omega: spreading and slope are in the solid angle, and what is hidden sends nothing.
//! That a sheet echoes as its mirror image does, that an edge gives half of it, and that slanted faces are silent, comes of itself.
//!
//! Not in it: sound that meets two surfaces before it comes back, and what is soft.

mod air;
mod array;
mod piston;
mod transducer;
mod waveform;

pub use air::Air;
pub use array::Array;
pub use piston::Piston;
pub use transducer::{Surface, Transducer, Window};
pub use waveform::{Echo, Waveform};
