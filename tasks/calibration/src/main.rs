//! Two simulated arms are calibrated by two simulated theodolites: `cargo run --release -p calibration -- --help`.
//!
//! It prints what was found, and writes a file for each arm into a folder, for `calibration` of its robot in cell.toml, and pictures.

use std::error::Error;
use std::process::ExitCode;
use std::time::Duration;

use calibration::estimate::{Accuracy, Bases, Estimate, estimate};
use calibration::mp::run_telling;
use calibration::options::{Options, parse};
use calibration::pictures;
use calibration::scene::{NAMES, Scene, posture};
use calibration::theodolite::SECOND;
use calibration::visits::{Visit, chosen};
use mrroc::console::{complain, say};
use mrroc::random::Random;
use mrroc_calibration::Irp6Arm;
use mrroc_calibration::file::{Account, text, today};
use mrroc_calibration::trials::Errors;
use mrroc_robots::{ArmCalibration, Irp6, Irp6Calibration, Six};

/// Accuracy of a sight in one face \[rad\].
const SIGHT: f64 = 2.0 * SECOND;
/// What friction winds up between a motor and its joint \[rad\] (assumed).
const WINDUP: f64 = 1e-5;
/// Of how many postures those are chosen that are visited.
const CANDIDATES: usize = 800;
/// After so many postures it is said how far it is.
const TELLING: usize = 10;
/// How long a motorised instrument takes to turn to a ball and to sight it (assumed; a person takes 8 to 20 s).
const POINTING: Duration = Duration::from_secs(1);

fn main() -> ExitCode {
    let options = match parse(std::env::args_os().skip(1)) {
        Ok(options) => options,
        Err(answer) if answer.use_stderr() => {
            complain(answer.to_string().trim_end());
            return ExitCode::from(2);
        }
        Err(answer) => return say(&answer.to_string()),
    };
    match calibrate(&options) {
        Ok(_) if options.quiet => ExitCode::SUCCESS,
        Ok(text) => say(&text),
        Err(error) => {
            complain(&format!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}

fn calibrate(options: &Options) -> Result<String, Box<dyn Error>> {
    let Options { seed, visits: count, out: folder, quiet } = options;
    let (count, quiet) = (*count as usize, *quiet);
    let tell = move |what: &str| {
        if !quiet {
            complain(what);
        }
    };
    // Found out now, and not when all is computed.
    std::fs::create_dir_all(folder).map_err(|why| {
        format!("the folder {} cannot be made: {why}\n help: write another one: --out DIR", folder.display())
    })?;
    let scene = Scene::new(SIGHT, WINDUP, u64::from(*seed));
    tell(&format!("choosing {count} of {CANDIDATES} postures"));
    let visits = chosen(count, CANDIDATES, 5);
    let made = move |made: usize| {
        if made % TELLING == 1 {
            tell(&format!("measuring posture {made} of {count}"));
        }
    };
    let (sights, time, shared) = run_telling(scene, &visits, POINTING, made)?;
    tell("computing arms and bases");
    let estimate = estimate(&sights)?;
    let scene = &mut *shared.scene.borrow_mut();
    let mut told = format!(
        "{} postures, {} sights of two sets in both faces, {:.0} min on the cell's clock\n\
         errors of the balls at 200 postures that were not used [mm]:\n  arm      rms      max      foretold rms   by itself\n",
        visits.len(),
        sights.sights.len(),
        time.as_secs_f64() / 60.0
    );
    let mut random = Random::seeded(77);
    for (arm, name) in NAMES.into_iter().enumerate() {
        let unseen: Vec<Six> = (0..200).map(|_| posture(arm, &mut random)).collect();
        let Accuracy { rms, max, foretold, own } = estimate.accuracy(scene, arm, &unseen);
        told += &format!(
            "  {:6} {:8.4} {:8.4} {:8.4} {:8.4}\n",
            name,
            1e3 * rms,
            1e3 * max,
            1e3 * foretold,
            1e3 * own
        );
        let model = Irp6Arm::new(Irp6::nominal());
        let found = model.with(estimate.fit.arm(estimate.arms[arm]));
        let calibration = ArmCalibration::Irp6(Irp6Calibration::of(&found));
        let residuals =
            estimate.fit.residuals().map(|(_, _, raw)| raw.iter().map(|r| r * r).sum::<f64>().sqrt());
        let account = Account {
            robot: name.to_owned(),
            data: None,
            made: today(),
            within: Errors::of(residuals),
            foretold: Errors::of(
                estimate
                    .fit
                    .cross_validated(10)?
                    .iter()
                    .map(|(_, raw)| raw.iter().map(|r| r * r).sum::<f64>().sqrt()),
            ),
            frames: vec![(
                "base".to_owned(),
                estimate.fit.frame(estimate.problem.base_of(estimate.arms[arm])),
            )],
        };
        let path = folder.join(format!("{}.calibration.toml", name));
        std::fs::write(&path, text(&calibration, &estimate.fit, estimate.arms[arm], &account))?;
    }
    let Bases { length, angle, length_sigma, angle_sigma, .. } = estimate.bases(scene);
    told += &format!(
        "right base in the left one: off by {:.4} mm and {:.4} mrad; foretold {:.4} mm and {:.4} mrad\n",
        1e3 * length,
        1e3 * angle,
        1e3 * length_sigma,
        1e3 * angle_sigma
    );
    for unseen in estimate.fit.unseen() {
        told += &format!("cannot be told apart: {unseen}\n");
    }
    tell("drawing");
    let drawn = draw(&estimate, scene, &visits);
    for (name, picture) in &drawn {
        std::fs::write(folder.join(name), picture)?;
    }
    let names: Vec<&str> = drawn.iter().map(|(name, _)| *name).collect();
    Ok(format!(
        "{told}see {}: left.calibration.toml, right.calibration.toml, {}\n",
        folder.display(),
        names.join(", ")
    ))
}

/// The pictures, by the names of their files.
fn draw(estimate: &Estimate, scene: &mut Scene, visits: &[Visit]) -> Vec<(&'static str, String)> {
    let mut random = Random::seeded(78);
    let postures = core::array::from_fn(|arm| (0..100).map(|_| posture(arm, &mut random)).collect());
    let mut drawn: Vec<(&str, String)> =
        visits.iter().take(1).map(|visit| ("cell.svg", pictures::cell(scene, visit))).collect();
    drawn.push(("errors.svg", pictures::errors(estimate, scene, &postures)));
    drawn.push(("residuals.svg", pictures::residuals(&estimate.fit)));
    drawn.push(("correlations.svg", pictures::correlations(&estimate.fit)));
    drawn.push(("observability.svg", pictures::observability(&estimate.fit)));
    drawn
}
