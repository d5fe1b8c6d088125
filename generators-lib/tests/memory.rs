//! Memory does not grow with the path, and nothing allocates while it is followed.

use mrroc_counting_allocator::bytes;
use mrroc_generators::bspline::{SpanStream, SplineSettings};
use mrroc_generators::feed::{FedPath, FeedLimits};
use nalgebra::Vector3;

use super::registry::{Row, rows};

/// Bytes that the work allocates.
fn allocated(work: impl FnOnce()) -> usize {
    let before = bytes();
    work();
    bytes() - before
}

fn wave(points: u32) -> impl Iterator<Item = Vector3<f64>> {
    (0..points).map(|i| {
        let x = f64::from(i) * 1e-3;
        Vector3::new(x, 0.01 * (x * 30.0).sin(), 0.0)
    })
}

/// The count covers points, windows and spans.
#[test]
fn a_spline_of_any_length_allocates_nothing() {
    for points in [10_000, if cfg!(debug_assertions) { 1_000_000 } else { 10_000_000 }] {
        let mut spans = 0;
        let bytes = allocated(|| {
            spans = SpanStream::new(SplineSettings::default(), wave(points)).unwrap().flatten().count();
        });
        assert_eq!((bytes, spans), (0, points as usize - 1));
    }
}

#[test]
fn following_a_path_allocates_nothing() {
    let limits = FeedLimits {
        feed: 0.2,
        tangential: 1.0,
        normal: 1.0,
        step: 1e-3,
        chord_error: 1e-5,
        jerk: f64::INFINITY,
    };
    let mut steps = 0;
    let bytes = allocated(|| {
        let spans = SpanStream::new(SplineSettings::default(), wave(2000)).unwrap();
        let mut path: FedPath<_> = FedPath::new(limits, spans).unwrap();
        while path.advance(1e-3).is_some() {
            steps += 1;
        }
    });
    assert_eq!(bytes, 0);
    assert!(steps > 10_000, "{steps}");
}

/// The conformance counts what next steps allocate.
#[test]
fn first_steps_allocate_only_where_the_registry_says_so() {
    let allocates = |row: &Row| (row.first_step)() > 0;
    let wrong: Vec<_> =
        rows().into_iter().filter(|row| allocates(row) != row.allocates).map(|row| row.name).collect();
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// The counter does count.
#[test]
fn an_allocation_is_seen() {
    assert!(allocated(|| drop(std::hint::black_box(vec![0_u8; 100]))) >= 100);
}
