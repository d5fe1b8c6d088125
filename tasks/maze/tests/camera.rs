//! Known layout: one image, and the way.
use maze::camera::run::Ready;
use mrroc_map::Layout;

fn islands() -> Layout {
    include_str!("../mazes/islands.txt").parse().expect("a maze")
}

#[test]
fn trial() {
    for (name, maze) in [("islands", islands()), ("seed 0", Layout::random(16, 0)), ("seed 1", Layout::random(16,1))] {
    for seed in 0..3 {
        let b = std::time::Instant::now();
        let outcome = Ready::new(&maze, seed).expect("a cell").run();
        println!("{name} {seed} ready+run {:?} wall {:?} report {:?} ratio {:.4} clearance {:.3} mm travel {:.4} image {:?} plan {:?} boxes {:?} of {}", b.elapsed(), outcome.wall, outcome.report, outcome.ratio(), 1e3*outcome.clearance, 1e3*outcome.travel, outcome.taken.took, outcome.planned.took, outcome.taken.bars.as_ref().map(|b| b.boxes.len()), outcome.walls.boxes().len());
        if let Some(b) = &outcome.taken.bars {
            let mut worst=[0.0_f64;4]; let mut sum=[0.0_f64;4];
            for w in outcome.walls.boxes() {
                let near = b.boxes.iter().min_by(|p,q| ((p[0]-w.lower).norm()+(p[1]-w.upper).norm()).total_cmp(&((q[0]-w.lower).norm()+(q[1]-w.upper).norm()))).unwrap();
                let e=[near[0].x-w.lower.x,near[0].y-w.lower.y,near[1].x-w.upper.x,near[1].y-w.upper.y];
                for k in 0..4 { sum[k]+=e[k]*e[k]; if e[k].abs()>worst[k].abs() {worst[k]=e[k];} if e[k].abs()>1e-4 && seed==0 && name=="seed 0" {println!("  {:?} {:?} err um {:?}", w.lower*1e3,w.upper*1e3,e.map(|x|(x*1e6).round()));} }
            }
            let n=outcome.walls.boxes().len() as f64;
            println!("   worst um {:?} rms {:?}", worst.map(|x|(x*1e6).round()), sum.map(|s|((s/n).sqrt()*1e6).round()));
        }
    }
    }
}
