//! A robot finds its way out of a maze by touch.

fn main() {
    for seed in 0..5 {
        let outcome = maze::run::Ready::new(&mrroc_map::Layout::random(16, seed), seed).expect("cell").run();
        println!("{seed} {:?} ratio {:.2} touches {} travel {:.2} mm pace {:.0}", outcome.report.as_ref().map(|r| r.time), outcome.ratio(), outcome.contacts.len(), outcome.travel * 1e3, outcome.pace());
    }
}
