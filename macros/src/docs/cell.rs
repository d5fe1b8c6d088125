// The robots and the sensor of the examples, which do not show them.

use mrroc::{prelude::*, robot::*};

macro_rules! robots {
    ($($name:ident)*) => {$(
        #[derive(Clone)]
        pub struct $name;
        impl Robot for $name {
            const KIND: &'static str = stringify!($name);
            type Joints = nalgebra::SVector<f64, 6>;
            fn limits(&self) -> &Limits<Self::Joints> { unimplemented!() }
            fn forward(&self, _: &Self::Joints) -> Pose { unimplemented!() }
            fn inverse(&self, _: &Pose, _: &Self::Joints) -> Result<Self::Joints, NoInverse> { unimplemented!() }
        }
    )*};
}
robots! { Rnt Polycrank }

pub struct WristForce;
impl Sensor for WristForce {
    const KIND: &'static str = "wrist force";
    type Reading = Force;
    type Configuration = ();
}

#[derive(Clone, Copy, Payload)]
pub struct Force {
    pub along_z: f64,
}
