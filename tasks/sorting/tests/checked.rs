//! What becomes of the one part of a cell with a fault.

use sorting::camera::run::Ready;
use sorting::camera::settings::Settings;
use sorting::monitor::Fate;

/// When the undisturbed run gets hold of its part \[s\].
pub fn first_hold(settings: &Settings) -> f64 {
    let outcome = settings.run().expect("a cell");
    assert_eq!(outcome.count(Fate::Sorted), 1, "{outcome:?}");
    outcome.grips[0].time
}

/// Runs, and checks that there was no wrong grasp, none farther off the middle than this \[m\]; what became of the part, and the fault.
pub fn checked(ready: Ready, case: &str, most: f64) -> (Fate, Option<String>) {
    let outcome = ready.run();
    let fault = outcome.report.as_ref().err().map(ToString::to_string);
    assert_eq!((outcome.count(Fate::Wrong), outcome.crashes), (0, 0), "{case}: {outcome:?}");
    for grip in &outcome.grips {
        assert!(grip.off.abs() < most, "{case}: grasped {} m off the middle", grip.off);
    }
    (outcome.fates[0], fault)
}
