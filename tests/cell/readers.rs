//! An arm, and a sensor of its column that the MP reads alone at first, then the arm's ECP, then both in the same steps.

use std::time::Duration;

use mrroc::prelude::*;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};

/// The cell.
pub fn cell() -> Cell {
    let rest = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
    let arm = RobotSetup::new("arm", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &rest));
    let cell =
        Cell::new(Duration::from_millis(2)).robot(arm).sensor(SensorSetup::new("column", Looks).of("arm"));
    cell.ecp("arm", serve).program(|mp| {
        let (mut arm, mut column) = (mp.robot::<Irp6>("arm")?, mp.sensor::<Column>("column")?);
        mp.wait_until((&mut arm,), (&mut column,), Pause(100))?;
        mp.move_robots((&mut arm,), (), ask {})?;
        mp.move_robots((&mut arm,), (&mut column,), Look {}).map(drop)
    })
}

struct Column;

impl Sensor for Column {
    const KIND: &'static str = "column";
    type Reading = Seen;
    type Configuration = ();
}

/// Where the column is \[rad\], and whether that is to the left.
#[derive(Clone, Copy, Payload)]
struct Seen {
    column: f64,
    is_left: bool,
}

struct Looks;

impl VirtualSensor for Looks {
    type Kind = Column;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Seen, Fault> {
        let column = order.robot.map_or(0.0, |robot| robot.joints[0]);
        Ok(Seen { column, is_left: column > 0.1 })
    }
}

#[derive(Clone, Copy, Payload)]
enum Go {
    There,
}

struct Pause(u32);

#[condition(mp)]
fn pause(c: &mut Pause, _v: &Reading<(Column,)>) -> bool {
    c.0 = c.0.saturating_sub(1);
    c.0 == 0
}

#[generator(mp)]
fn ask() -> Always<(Irp6,), Go> {
    Always((Go::There,))
}

struct Look {}

#[generator(mp)]
fn look(_c: &mut Look, _v: &Reading<(Column,)>) -> Always<(Irp6,), Go> {
    Always((Go::There,))
}

fn serve(ecp: &mut Ecp<Irp6>) -> Result<(), Fault> {
    let mut column = ecp.sensor::<Column>("column")?;
    for by in [0.2, -0.2] {
        let turn = Turn { from: Six::zeros(), by, t: 0.0 };
        ecp.serve(|ecp, _: Go| ecp.move_robot((&mut column,), turn).map(drop))?;
    }
    Ok(())
}

/// The column by an angle \[rad\] in a second, from rest to rest.
#[derive(Clone, Copy)]
struct Turn {
    from: Six,
    by: f64,
    t: f64,
}

#[generator(ecp, first = begin)]
fn turn(c: &mut Turn, _v: &Reading<(Column,)>, t: Tick) -> Step<Irp6> {
    if c.t >= 1.0 {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(1.0);
    Step::Next(Demand::joints(c.from + Six::x() * (c.by * c.t * c.t * (3.0 - 2.0 * c.t))))
}

fn begin(c: &mut Turn, e: &State<Irp6>, v: &Reading<(Column,)>, t: Tick) -> Step<Irp6> {
    c.from = e.demanded().joints;
    turn(c, v, t)
}
