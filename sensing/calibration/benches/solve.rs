//! What a fit takes, beside SciPy on the same problem: `tests/benches/peers/calibration/run`.

// The tests use more of it.
#[allow(dead_code)]
#[path = "../tests/support/case.rs"]
mod case;

use std::hint::black_box;
use std::time::Instant;

use case::{Case, Stated};
use mrroc_calibration::Settings;

fn main() {
    // Without a problem there is nothing to compare: `cargo bench` alone uses one of the tests.
    let file = std::env::var("MRROC_CALIBRATION_PROBLEM").ok();
    let value: serde_json::Value = match &file {
        Some(file) => serde_json::from_str(&std::fs::read_to_string(file).expect("a problem")).expect("JSON"),
        None => {
            let all: serde_json::Value =
                serde_json::from_str(include_str!("../tests/reference/fits.json")).expect("JSON");
            all["theodolites"].clone()
        }
    };
    let Stated { problem, .. } = Case::new(value).stated();
    let mut best = f64::INFINITY;
    let mut last = None;
    for _ in 0..20 {
        let began = Instant::now();
        last = Some(black_box(
            problem.fit(&Settings { tolerance: 1e-8, ..Settings::default() }).expect("a fit"),
        ));
        best = best.min(began.elapsed().as_secs_f64());
    }
    if let Some(fit) = last {
        println!("mrroc {:.2} ms iterations {}", best * 1e3, fit.iterations());
    }
}
