//! The set that engraves.

#[path = "../../template/src/arm.rs"]
pub mod arm;
#[path = "../../template/sets/engraving/ecp.rs"]
pub mod ecp;
#[path = "../../template/sets/engraving/generators/mod.rs"]
pub mod generators;
#[path = "../../template/sets/engraving/mp.rs"]
pub mod mp;
#[path = "../../template/sets/engraving/orders.rs"]
pub mod orders;
#[path = "../../template/src/touch.rs"]
pub mod touch;
