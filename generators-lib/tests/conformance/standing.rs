//! Generators that let a robot stand still.

use super::kit::{alone, behind, bytes};
use mrroc::prelude::*;
use mrroc::robot::{Channel, Output};
use mrroc_generators::conformance::Given;
use mrroc_generators::generator_conformance;
use mrroc_generators::generators::{AwaitOperator, Delay, Settle, Sleep, Tell};
use mrroc_robots::{Irp6, Six};

generator_conformance! {
    sleep: Sleep<Irp6>,
    class: "ECP f*0(c)",
    make: Sleep::lasting(0.5),
    given: alone,
    odd: |x| vec![Sleep::lasting(x)],
    allocated: bytes,
}

generator_conformance! {
    tell: Tell<Irp6>,
    class: "ECP f*0(c)",
    make: Tell::output(flow(), 0.5),
    given: alone,
    odd: |x| vec![Tell::output(flow(), x)],
    allocated: bytes,
}

/// An analog output.
fn flow() -> Output<f64> {
    Output::of(Channel::Analog(0)).expect("an analog one")
}

generator_conformance! {
    settle: Settle<Irp6>,
    class: "ECP f*2(c, e)",
    make: Settle::within(Six::repeat(1e-3), 0.5, 1.0),
    given: |step| Given { order: Order::new(()), e: State::new(behind(0.9_f64.powi(step as i32))), v: Reading::new(()) },
    odd: |x| vec![
        Settle::within(Six::repeat(x), 0.5, 1.0), Settle::within(Six::repeat(1e-3), x, 1.0),
        Settle::within(Six::repeat(1e-3), 0.5, x), Settle::within(Six::repeat(x), x, x),
    ],
    allocated: bytes,
}

generator_conformance! {
    delay: Delay<Irp6>,
    class: "ECP f*0(c)",
    make: Delay::lasting(0.5),
    given: alone,
    odd: |x| vec![Delay::lasting(x)],
    allocated: bytes,
}

generator_conformance! {
    await_operator: AwaitOperator<Irp6, fn() -> bool>,
    class: "ECP f*0(c)",
    make: AwaitOperator::until(|| false),
    given: alone,
    odd: |_| vec![AwaitOperator::until(|| true)],
    allocated: bytes,
}
