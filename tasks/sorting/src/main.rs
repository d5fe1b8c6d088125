//! placeholder
use sorting::run::Settings;
fn main() {
    let mut args = std::env::args().skip(1).map(|a| a.parse::<f64>().unwrap());
    let (speed, seeds, first, trace) = (args.next().unwrap_or(0.1), args.next().unwrap_or(1.0) as u64, args.next().unwrap_or(0.0) as u64, args.next().unwrap_or(0.0) > 0.0);
    let (mut n, mut good, mut wall, mut time) = (0, 0, 0.0, 0.0);
    for seed in first..first + seeds {
        let mut ready = Settings::one(speed, seed).ready().unwrap();
        if trace {
            let world = ready.plant.world.clone();
            let chase = ready.chase.clone();
            ready.cell = ready.cell.also_on_step(move |step, _| if step % 50 == 0 {
                let hand = world.hand(0).unwrap();
                let p = hand.pose().translation.vector;
                println!("{:.3} world {:.3} body {:?} hand {:.4} {:.4} {:.4} held {:?} part {:?} missed {:?}", step as f64*0.004, world.time(), world.body_of(0).map(|b| (b.pose.translation.vector.as_slice().to_vec(), b.velocity.y)), p.x, p.y, p.z, hand.held(), chase.part.get(), chase.missed.get());
            });
        }
        let chase = ready.chase.clone();
        let out = ready.run();
        n += 1; good += out.count(sorting::witness::Fate::Sorted); wall += out.wall.as_secs_f64(); time += out.report.as_ref().map_or(0.0, |r| r.time.as_secs_f64());
        println!("{seed} {:?} missed {:?} {:?} crashes {} pace {:.0} {:?}", out.fates, chase.missed.get(), out.grips.iter().map(|g| (g.along*1e3, g.across*1e3, g.slip*1e3)).collect::<Vec<_>>(), out.crashes, out.pace(), out.report.as_ref().map(|r| r.time).map_err(|e| e.to_string()));
    }
    println!("{good} of {n}, {:.0} times real time", time / wall);
}
