//! The tutorial: the programs that its chapters make of the template's files do what the chapters say and show.

mod book;
#[path = "5_driver.rs"]
mod driver;
#[path = "1_line.rs"]
mod line;
#[path = "4_own.rs"]
mod own;
mod page;
#[path = "3_pair.rs"]
mod pair;
#[path = "../../template/sets/mp_one/generators/point_to_point.rs"]
mod point_to_point;
#[path = "6_real_robot.rs"]
mod real_robot;
#[path = "2_sensor.rs"]
mod sensor;
mod sensor_page;
pub mod support;
mod tcp_servo;
