//! Where the base stands, and what it sees, as readings of virtual sensors.
//!
//! In: wheel angles (`e_j` of the order), what a rate gyro and infrared sensors give (`r`). Out: aggregated readings, `v`.

mod dead_reckoning;
mod gyro;
pub mod infrared;
mod lookout;
mod planar;
mod wall_memory;
mod whereabouts;

pub use dead_reckoning::{DeadReckoning, Reckoned};
pub use gyro::{Gyro, GyroFault, Turned};
pub use infrared::Infrared;
pub use lookout::{LookingOut, Lookout, Sight, Watch};
pub use planar::Planar;
pub use wall_memory::{Face, TOLD, WallMemory};
pub use whereabouts::{Located, Standing, Whereabouts};
