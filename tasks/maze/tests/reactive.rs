//! The reactive controller without a map: out of mazes, and within the bound of Bug2 where that applies.
//!
//! The shipped mazes and a few worlds; `just maze-whole` takes all worlds, and thirty mazes by chance.

use maze::mazes::Seeded;
use maze::mp::MazeSettings;
use maze::options::Means;
use maze::places::Sizes;
use maze::plant::stylus::TRAVEL;
use maze::reactive::run::Ready;
use maze::summary::Summary;
use mrroc_map::{Knowledge, Layout, Place, Region, Wall, Walls};

use crate::usage::with_shipped;

/// The shipped mazes, and beside them so many by chance.
fn shipped_mazes_are_left(count: u64) {
    let mazes = with_shipped(count);
    let summary = Summary::sweep(Means::Reactive, &mazes);
    println!("{summary}");
    for (row, Seeded { name, .. }) in summary.0.iter().zip(&mazes).take(2) {
        assert!(row.fault.is_none() && row.travel < TRAVEL && row.ratio > 0.999, "{name}: {summary}");
    }
    assert!(!summary.0[0].by_hand, "the left-hand rule goes round the islands");
}

#[test]
fn the_shipped_mazes_are_left_without_a_map_also_where_the_left_hand_goes_round() {
    shipped_mazes_are_left(0);
}

/// A world of `reference/bug2.csv`: boxes \[m\], and the bound of Bug2 for a ball among them \[m\].
struct World {
    boxes: Vec<Wall>,
    bound: f64,
}

fn worlds() -> Vec<World> {
    let lines = include_str!("reference/bug2.csv").lines().skip(1);
    let number = |text: &str| text.parse::<f64>().expect("a number");
    let world = |line: &str| {
        let (bound, boxes) = line.split_once(',').expect("two columns");
        let boxes = boxes.split(';').map(|one| {
            let sides: Vec<f64> = one.split(' ').map(number).collect();
            Wall { lower: Place::new(sides[0], sides[1]), upper: Place::new(sides[2], sides[3]) }
        });
        World { boxes: boxes.collect(), bound: number(bound) }
    };
    lines.map(world).collect()
}

/// The frame of the worlds \[m\], and where the ball is to go from and to.
const SIDE: f64 = 0.4;
const ENDS: [[f64; 2]; 2] = [[0.03, 0.05], [0.37, 0.33]];

/// So many of the worlds.
fn distances_are_within_the_bound_of_bug2(count: usize) {
    let sizes = Sizes::CLASSIC;
    let (h, side) = (0.5 * sizes.thickness, SIDE);
    let frame = [
        [-h, -h, side + h, h],
        [-h, side - h, side + h, side + h],
        [-h, -h, h, side + h],
        [side - h, -h, side + h, side + h],
    ]
    .map(|[a, b, c, d]| Wall { lower: Place::new(a, b), upper: Place::new(c, d) });
    let near = Place::new(5e-3, 5e-3);
    let [start, goal] = ENDS.map(Place::from);
    let (mut shares, mut within) = (vec![], 0);
    for (seed, world) in worlds().into_iter().enumerate().take(count) {
        let told = MazeSettings {
            start,
            goal: Region { lower: goal - near, upper: goal + near },
            most: 1000,
            known: Knowledge {
                size: [SIDE; 2],
                radius: sizes.radius,
                thickness: sizes.thickness,
                passage: sizes.passage,
                wall: sizes.pitch,
            },
            sizes,
        };
        let walls = Walls::of_boxes(frame.into_iter().chain(world.boxes).collect(), sizes.pitch, [SIDE; 2]);
        let outcome = Ready::among(walls, told, seed as u64).expect("a cell").run();
        assert!(outcome.report.is_ok(), "world {seed}: {:?}", outcome.report);
        assert!(
            outcome.travel < TRAVEL && outcome.distance >= 0.999 * (outcome.shortest - 5e-3),
            "world {seed}"
        );
        shares.push(outcome.distance / world.bound);
        within += usize::from(outcome.distance <= world.bound);
        // The bound is of a point that keeps to a wall. The ball goes along it in curves from touch to touch, and back after each: arcs of a
        // quarter of a circle, which are 1.11 times their chord, and 2 times 0.8 mm for a chord of 10 mm.
        assert!(
            outcome.distance <= 1.3 * world.bound,
            "world {seed}: {} m of {} m",
            outcome.distance,
            world.bound
        );
    }
    shares.sort_by(f64::total_cmp);
    println!(
        "{} worlds, {within} within the bound of Bug2; distance through the bound: median {:.2}, worst {:.2}",
        shares.len(),
        shares[shares.len() / 2],
        shares[shares.len() - 1]
    );
}

#[test]
fn among_obstacles_its_distance_is_within_1_3_times_the_bound_of_bug2() {
    distances_are_within_the_bound_of_bug2(4);
}

mod whole {
    #[test]
    #[ignore = "takes minutes: `just maze-whole`"]
    fn the_shipped_mazes_are_left_without_a_map_also_where_the_left_hand_goes_round() {
        super::shipped_mazes_are_left(30);
    }

    #[test]
    #[ignore = "takes minutes: `just maze-whole`"]
    fn among_obstacles_its_distance_is_within_1_3_times_the_bound_of_bug2() {
        super::distances_are_within_the_bound_of_bug2(usize::MAX);
    }
}

#[test]
fn fault_235_a_reactive_arm_that_comes_round_without_a_path_ends_with_a_fault_that_says_so() {
    let closed: Layout = "o---o---o---o\n|           |\no   o---o   o\n|   | G |   |\no   o---o   o\n| S         |\no---o---o---o".parse().expect("a maze");
    let outcome = Ready::new(&closed, 1).expect("a cell").run();
    let fault = outcome.report.expect_err("no path").to_string();
    assert!(fault.contains("no path leads to the exit"), "{fault}");
    // Once round the room in the middle: some 0.2 m, in curves.
    assert!(outcome.travel < TRAVEL && outcome.distance < 0.6, "{} m", outcome.distance);
}
