//! A base on a floor that follows paths by what it knows of its place.

use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc_wheels::generators::BaseLimits;
use mrroc_wheels::sensing::{DeadReckoning, Gyro, Located, Standing, Turned};
use mrroc_wheels::simulation::{Floor, Ground};
use mrroc_wheels::{DiffDrive, FollowPath, Path, Planar, Rolling, Two, Whereabouts};

/// Half a metre a second, with what tyres hold in bends.
pub const LIMITS: BaseLimits = BaseLimits { speed: 0.5, lateral: 2.5, turning: 8.0, off: 0.06 };

/// From a demand to where the base is seen to have gone, in steps.
pub const DELAY: f64 = 2.0;

/// It stands, and knows the bias of its gyro.
#[condition(ecp)]
fn stands(v: &Reading<(Whereabouts,)>) -> bool {
    v.0.reading().is_some_and(|read| read.stands)
}

/// Where the base thinks that it is, and where it is.
pub type Trace = Rc<RefCell<Vec<(Planar, Planar)>>>;

/// A sensor that also keeps where the base truly was whenever it was asked.
pub struct Traced<V> {
    pub inner: V,
    pub floor: Floor,
    pub trace: Trace,
}

impl<V: VirtualSensor<Kind = Whereabouts>> VirtualSensor for Traced<V> {
    type Kind = Whereabouts;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Standing, Fault> {
        let standing = self.inner.aggregate(order)?;
        self.trace.borrow_mut().push((standing.pose, self.floor.motion().pose));
        Ok(standing)
    }

    fn is_simulated(&self) -> bool {
        true
    }
}

/// Where a base stands by its wheels alone.
pub struct ByWheels {
    pub reckoning: DeadReckoning,
    pub before: Two,
}

impl VirtualSensor for ByWheels {
    type Kind = Whereabouts;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Standing, Fault> {
        let state = order.robot.expect("the base");
        let wheels = Two::new(state.joints[0], state.joints[1]);
        let (_, angle) = DiffDrive::rolled(&(wheels - core::mem::replace(&mut self.before, wheels)));
        let reckoned = self.reckoning.step(&wheels, &Turned { angle, time: 0.002 });
        Ok(Standing { pose: reckoned.pose, stands: reckoned.stands })
    }
}

/// Runs the paths one after the other.
pub fn run(
    floor: &Floor,
    sensor: impl VirtualSensor<Kind = Whereabouts>,
    paths: Vec<Path>,
) -> Result<(), CellError> {
    let drives = Rolling::new(DiffDrive::new(), floor.clone());
    let robot = RobotSetup::new("base", DiffDrive::new(), drives).program(move |ecp| {
        let mut whereabouts = ecp.sensor::<Whereabouts>("whereabouts")?;
        for path in &paths {
            ecp.wait_until((&mut whereabouts,), stands {})?;
            let follow =
                FollowPath::<Whereabouts>::along(path.clone(), LIMITS, |read| Some(read.pose), DELAY, 2);
            ecp.move_robot((&mut whereabouts,), follow)?;
        }
        ecp.wait_until((&mut whereabouts,), stands {}).map(drop)
    });
    let sensor = SensorSetup::new("whereabouts", sensor).of("base");
    Cell::new(Duration::from_millis(2)).robot(robot).sensor(sensor).run().map(drop)
}

/// Where a base truly was that followed a path on this ground by its wheels and its gyro, with what is known of the distance.
pub fn followed(path: Path, ground: Ground, scale: f64, seed: u64) -> Vec<Planar> {
    let floor = Floor::new(ground, Planar::default());
    let trace = Trace::default();
    let reckoning = DeadReckoning::from(Planar::default()).with_scale(scale);
    let inner = Located::by(Gyro::new(floor.clone(), seed), reckoning);
    run(&floor, Traced { inner, floor: floor.clone(), trace: Rc::clone(&trace) }, vec![path])
        .expect("no fault");
    let all = trace.take();
    all.into_iter().map(|(_, truly)| truly).collect()
}
