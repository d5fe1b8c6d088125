//! Undisturbed runs.

use legs::plant::Drawn;
use legs::run::Ready;
use legs::walk::Gait;

#[test]
fn probe() {
    let gait = Gait { footsteps: 8, ..Gait::default() };
    let drawn = match std::env::var("SEED") { Ok(seed) => Drawn::by(seed.parse().unwrap(), 2.4), Err(_) => Drawn::level(0.7) };
    let gait = if std::env::var("SEED").is_ok() { Gait::default() } else { gait };
    println!("{:?}", drawn);
    let outcome = Ready::new(&drawn, &gait, 0).expect("a cell").run();
    println!("{:?} {:?}", outcome.report, outcome.wall);
    let seen = &outcome.seen;
    println!("margin {} lean {} force {} fallen {} slip {}", seen.margin, seen.lean, seen.force, seen.fallen, seen.slip());
    for step in &seen.steps { println!("{step:?}"); }
    for s in seen.film.iter().step_by(10) { println!("{:.2} {:.4?} m {:.4} lean {:.4} F {:.0?}", s.time, s.X_WT.translation.vector.as_slice(), s.margin(), s.lean(), s.forces.map(|f| f.z)); }
}

#[test]
fn many() {
    let Ok(n) = std::env::var("SEEDS") else { return };
    for seed in 0..n.parse().unwrap() {
        let o = Ready::new(&Drawn::by(seed, 2.4), &Gait::default(), seed).expect("a cell").run();
        let s = &o.seen;
        if let Some(w) = s.steps.iter().max_by(|a, b| a.slip.total_cmp(&b.slip)) {
            println!("{w:?}");
            let mut before = None;
            for f in s.film.iter().filter(|f| f.time <= w.lifted + 0.03 && f.time > w.lifted - 4.0) {
                let v = f.slid[w.leg];
                if let Some(b) = before { if v - b > 2e-5 { println!("  {:.3} +{:.0} um  F {:.1?} all {:.0?}", f.time, 1e6 * (v - b), f.forces[w.leg].as_slice(), f.forces.map(|f| f.norm())); } }
                before = Some(v);
            }
        }
        let err = o.report.as_ref().err().map(|e| e.to_string());
        println!("{seed} steps {} margin {:.4} slip {:.5} moved {:.5} lean {:.4} force {:.0} fallen {} {:?} {err:?}", s.steps.len(), s.margin, s.slip(), s.steps.iter().map(|s| s.moved).fold(0.0, f64::max), s.lean, s.force, s.fallen, o.wall);
    }
}
