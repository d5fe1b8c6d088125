//! Writes what a walk does to its feet, for programs that simulate the same: `cargo run -p mrroc-examples --example forces -- SEED FOLDER FOOTSTEPS`.
//!
//! `ground.csv`: side (1 left, -1 right), from x, to x, height \[m\] of every tread. `walk.csv`: from the beginning, every 4 ms: time \[s\], twelve true
//! joint positions \[rad\], the trunk's place \[m\] and quaternion (w, x, y, z), the normal forces of the four feet \[N\]. `figures.csv`: name and
//! value of what a model of the machine needs.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use legs::leg::Leg;
use legs::places::HIP;
use legs::plant::foot::{RADIUS, STIFFNESS};
use legs::plant::{Drawn, trunk};
use legs::run::{LENGTH, Ready};
use legs::walk::Gait;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [seed, folder, footsteps] = arguments.as_slice() else {
        return Err("usage: forces SEED FOLDER FOOTSTEPS".into());
    };
    let (seed, folder) = (seed.parse()?, Path::new(folder));
    let gait = Gait { footsteps: footsteps.parse()?, ..Gait::default() };
    let drawn = Drawn::by(seed, LENGTH);
    let ready = Ready::new(&drawn, &gait, seed)?;
    ready.plant.world().borrow_mut().seen.keep_every(2);
    let outcome = ready.run();
    outcome.report?;
    let mut ground = String::from("side,from,to,height\n");
    for (side, lane) in [(1, &drawn.ground.left), (-1, &drawn.ground.right)] {
        for (i, height) in lane.heights.iter().enumerate() {
            let from = if i == 0 { -1.0 } else { lane.edges[i - 1] };
            let to = lane.edges.get(i).copied().unwrap_or(from + 2.0);
            writeln!(ground, "{side},{from:?},{to:?},{height:?}")?;
        }
    }
    let mut walk = String::from("time");
    for name in ["lf", "rf", "lh", "rh"] {
        write!(walk, ",{name}0,{name}1,{name}2")?;
    }
    walk += ",x,y,z,qw,qx,qy,qz,n_lf,n_rf,n_lh,n_rh\n";
    for now in &outcome.seen.film {
        write!(walk, "{:.4}", now.time)?;
        now.q.iter().flatten().try_for_each(|q| write!(walk, ",{q:.9}"))?;
        let (at, turn) = (now.X_WT.translation, now.X_WT.rotation);
        write!(walk, ",{:.9},{:.9},{:.9}", at.x, at.y, at.z)?;
        write!(walk, ",{:.9},{:.9},{:.9},{:.9}", turn.w, turn.i, turn.j, turn.k)?;
        now.forces.iter().try_for_each(|force| write!(walk, ",{:.4}", force.z))?;
        walk.push('\n');
    }
    let [hip, thigh, shank] = Leg::MASSES;
    let [sx, sy, sz] = trunk::EDGES;
    let figures = [
        ("hip_mass", hip),
        ("thigh_mass", thigh),
        ("shank_mass", shank),
        ("trunk_mass", trunk::MASS),
        ("trunk_x", sx),
        ("trunk_y", sy),
        ("trunk_z", sz),
        ("hip_x", HIP[0]),
        ("hip_y", HIP[1]),
        ("aside", Leg::ASIDE),
        ("thigh", Leg::THIGH),
        ("shank", Leg::SHANK),
        ("centre_hip", Leg::CENTRES[0]),
        ("centre_thigh", Leg::CENTRES[1]),
        ("centre_shank", Leg::CENTRES[2]),
        ("radius", RADIUS),
        ("stiffness", STIFFNESS),
        ("friction", drawn.friction),
    ];
    let mut text = String::from("name,value\n");
    for (name, value) in figures {
        writeln!(text, "{name},{value:?}")?;
    }
    fs::write(folder.join("ground.csv"), ground)?;
    fs::write(folder.join("walk.csv"), walk)?;
    fs::write(folder.join("figures.csv"), text)?;
    Ok(())
}
