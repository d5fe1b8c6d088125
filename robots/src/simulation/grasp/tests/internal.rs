//! How grippers share a load, and what is left over.

use mrroc::pose::Wrench;
use mrroc::random::Noise;
use nalgebra::Vector3;

use crate::simulation::grasp::Sharing;

fn random(noise: &mut Noise) -> Vector3<f64> {
    Vector3::from_fn(|_, _| noise.normal())
}

/// The sum of the wrenches about the origin.
fn total(grasps: &[(Vector3<f64>, Wrench)]) -> Wrench {
    grasps.iter().fold(Wrench::default(), |sum, (at, wrench)| {
        sum + Wrench::new(wrench.force, wrench.torque + at.cross(&wrench.force))
    })
}

#[test]
fn internal_wrenches_of_any_number_of_grasps_add_up_to_nothing() {
    let mut noise = Noise::seeded(5);
    for count in 1..=6 {
        for _ in 0..50 {
            let grasps: Vec<_> = (0..count)
                .map(|_| (random(&mut noise), Wrench::new(random(&mut noise) * 30.0, random(&mut noise))))
                .collect();
            let sharing = Sharing::of(grasps.iter().copied());
            let internal: Vec<_> = grasps.iter().map(|grasp| (grasp.0, sharing.internal(grasp))).collect();
            let shares: Vec<_> = grasps.iter().map(|(at, _)| (*at, sharing.share(at))).collect();
            let (sum, whole, carried) = (total(&internal), total(&grasps), total(&shares));
            assert!(sum.force.amax() < 1e-12 && sum.torque.amax() < 1e-11, "{count}: {sum:?}");
            assert!((carried - whole).force.amax() < 1e-12 && (carried - whole).torque.amax() < 1e-11);
            // The decomposition is a projection: what is internal has no share, a share nothing internal.
            let again = Sharing::of(internal.iter().copied());
            assert!(again.share(&grasps[0].0).force.amax() < 1e-11);
            if count == 1 {
                assert!(internal[0].1.force.amax() < 1e-13);
            }
        }
    }
}

#[test]
fn two_hands_that_press_on_each_other_do_nothing_but_squeeze() {
    let pressing = |x: f64, f: f64| {
        (Vector3::new(x, 0.1, 0.2), Wrench::new(Vector3::new(f, 0.0, 0.0), Vector3::new(0.3 * f, 0.0, 0.0)))
    };
    let grasps = [pressing(-0.3, 40.0), pressing(0.3, -40.0)];
    let sharing = Sharing::of(grasps.iter().copied());
    for grasp in &grasps {
        let internal = sharing.internal(grasp);
        assert!((internal - grasp.1).force.amax() < 1e-13 && (internal - grasp.1).torque.amax() < 1e-13);
    }
}
