//! The set that takes a part from a belt.

#[path = "../../template/sets/pick/belt.rs"]
pub mod belt;
#[path = "../../template/sets/pick/ecp.rs"]
pub mod ecp;
#[path = "../../template/sets/pick/generators/mod.rs"]
pub mod generators;
#[path = "../../template/sets/pick/mp.rs"]
pub mod mp;
#[path = "../../template/sets/pick/orders.rs"]
pub mod orders;
