//! The robots of this crate in one cell under the runtime: poses demanded, joints followed.

use std::time::Duration;

use mrroc::prelude::*;
use mrroc_robots::{Irp6Track, Polycrank, Rnt, Seven, Simulated, Six};
use nalgebra::{Translation3, Vector3};

const DURATION: f64 = 2.0;

/// Carries three flanges along one path, as one body would ask for.
struct Carry {
    from: Option<[Pose; 3]>,
    t: f64,
}

impl Carry {
    /// 8 cm there and back, each robot in its own world; the speed begins and ends with zero.
    fn at(&self, t: f64) -> [Pose; 3] {
        let part = 0.5 * (1.0 - (std::f64::consts::TAU * t / DURATION).cos());
        let displacement = Translation3::from(Vector3::new(0.03, -0.05, 0.02) * part);
        self.from.map_or([Pose::identity(); 3], |from| from.map(|pose| displacement * pose))
    }
}

#[generator(mp, first = grasp)]
fn carry(c: &mut Carry, t: Tick) -> Step<(Rnt, Polycrank, Irp6Track)> {
    if c.t >= DURATION {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(DURATION);
    let [rnt, polycrank, irp6] = c.at(c.t);
    Step::Next((Demand::pose(rnt), Demand::pose(polycrank), Demand::pose(irp6)))
}

fn grasp(
    c: &mut Carry,
    e: &State<(Rnt, Polycrank, Irp6Track)>,
    t: Tick,
) -> Step<(Rnt, Polycrank, Irp6Track)> {
    c.from = Some([
        Rnt::new().forward(&e.0.demanded().joints),
        Polycrank::new().forward(&e.1.demanded().joints),
        Irp6Track::nominal().forward(&e.2.demanded().joints),
    ]);
    carry(c, t)
}

#[test]
fn rnt_polycrank_and_the_arm_on_the_track_carry_along_one_path() {
    let rnt = Six::new(0.1, 0.5, 0.55, 0.2, 1.3, 0.3);
    let polycrank = Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2]);
    let irp6 = Seven::from([0.5, 0.1, -1.55, 0.1, -0.1, 4.6, 0.2]);
    let report = Cell::new(Duration::from_millis(2))
        .robot(RobotSetup::new("rnt", Rnt::new(), Simulated::new(Rnt::new(), &rnt)))
        .robot(RobotSetup::new("polycrank", Polycrank::new(), Simulated::new(Polycrank::new(), &polycrank)))
        .robot(RobotSetup::new("irp6", Irp6Track::nominal(), Simulated::new(Irp6Track::nominal(), &irp6)))
        .program(move |mp| {
            let mut one = mp.robot::<Rnt>("rnt")?;
            let mut two = mp.robot::<Polycrank>("polycrank")?;
            let mut three = mp.robot::<Irp6Track>("irp6")?;
            mp.move_robots((&mut one, &mut two, &mut three), (), Carry { from: None, t: 0.0 })?;
            assert!((one.measured().joints - rnt).amax() < 1e-3);
            assert!((three.measured().joints - irp6).amax() < 1e-3);
            // The redundancy may end elsewhere; the flange may not.
            let robot = Polycrank::new();
            let (back, began) = (robot.forward(&two.measured().joints), robot.forward(&polycrank));
            assert!((back.translation.vector - began.translation.vector).amax() < 1e-3);
            Ok(())
        })
        .run()
        .expect("no limit is broken");
    assert!((report.time.as_secs_f64() - DURATION).abs() < 0.05);
}
