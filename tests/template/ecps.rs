//! The sets whose motions are an ECP's, and the robot of the user's own.

#[path = "../../template/src/arm.rs"]
pub mod arm;
#[path = "../../template/sets/both_two/ecp.rs"]
pub mod both_two_ecp;
#[path = "../../template/sets/both_two/mp.rs"]
pub mod both_two_mp;
#[path = "../../template/sets/ecp_one/ecp.rs"]
pub mod ecp_one;
#[path = "../../template/sets/ecp_two/ecp.rs"]
pub mod ecp_two;
#[path = "../../template/src/generators/mod.rs"]
pub mod generators;
#[path = "../../template/src/orders.rs"]
pub mod orders;
#[path = "../../template/sets/own/arm.rs"]
pub mod own_arm;
#[path = "../../template/src/touch.rs"]
pub mod touch;
#[path = "../../template/sets/urdf/arm.rs"]
pub mod urdf_arm;
