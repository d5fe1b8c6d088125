//! The set whose motions are the MP's, of two robots.

#[path = "../../template/src/arm.rs"]
pub mod arm;
#[path = "../../template/src/touch.rs"]
pub mod touch;
#[path = "../../template/sets/mp_two/generators"]
pub mod generators {
    mod my_motion;
    mod point_to_point;
    pub use my_motion::MyMotion;
    pub use point_to_point::PointToPoint;
}
#[path = "../../template/sets/mp_two/mp.rs"]
pub mod mp;
