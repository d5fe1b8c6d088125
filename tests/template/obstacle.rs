//! The set in which an arm goes around an obstacle.

#[path = "../../template/sets/urdf/arm.rs"]
pub mod arm;
#[path = "../../template/sets/obstacle/mp.rs"]
pub mod mp;
#[path = "../../template/sets/obstacle/world.rs"]
pub mod world;
