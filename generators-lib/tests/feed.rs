//! The feed planner keeps its limits at and between samples, and its path at any feed rate.

use crate::usage::reference::*;
use mrroc_generators::bspline::*;
use mrroc_generators::feed::*;

const MILLI: f64 = 1e-3;

fn limits() -> FeedLimits {
    FeedLimits {
        feed: 0.1,
        tangential: 1.5,
        normal: 2.0,
        step: 1e-3,
        chord_error: f64::INFINITY,
        jerk: f64::INFINITY,
    }
}

/// The reference sets in metres; those of the engraver are in millimetres.
fn paths() -> Vec<(String, Vec<Point>)> {
    let scaled = |(name, points): (String, Vec<Point>)| (name, points.iter().map(|p| p * MILLI).collect());
    let mut all: Vec<_> = datasets().into_iter().map(scaled).collect();
    all.push(("line".into(), vec![Point::zeros(), Point::x() * 0.5]));
    all
}

fn smooth(points: &[Point]) -> SpanStream<impl Iterator<Item = Point>> {
    let set = SplineSettings { corner: std::f64::consts::PI, ..SplineSettings::default() };
    SpanStream::new(set, points.to_vec()).unwrap()
}

fn follow<I>(limits: FeedLimits, spans: I, mut dt: impl FnMut(usize) -> f64) -> Vec<PathPoint>
where
    I: Iterator<Item = Result<PathSpan, SplineError>>,
{
    let mut path: FedPath<I> = FedPath::new(limits, spans).unwrap();
    let mut out = Vec::new();
    while let Some(point) = path.advance(dt(out.len())) {
        out.push(point);
        assert!(out.len() < 5_000_000, "the path does not end");
    }
    assert_eq!((path.error(), path.advance(1.0)), (None, None));
    out
}

#[test]
fn a_path_ends_at_rest_exactly_at_its_last_point() {
    for (name, points) in paths() {
        let all = follow(limits(), smooth(&points), |_| 1e-3);
        let last = all.last().unwrap();
        assert_eq!((last.position, last.speed), (*points.last().unwrap(), 0.0), "{name}");
        assert!(all[..all.len() - 1].iter().all(|p| p.length < last.length));
        let length: f64 = smooth(&points)
            .map(|span| span.unwrap().span)
            .map(|span| length_between(&span, 0.0, span.knot_span()))
            .sum();
        assert!((last.length - length).abs() < 1e-12 * (1.0 + length));
    }
}

/// Second differences over `h` are means of the acceleration over 2 h: fine ones see it between samples of 1 ms.
#[test]
fn speed_and_acceleration_stay_within_their_limits_between_samples_too() {
    let limits = limits();
    let most = limits.tangential.hypot(limits.normal);
    for (name, points) in paths() {
        for h in [1e-3, 1e-4] {
            let mut all: Vec<_> = follow(limits, smooth(&points), |_| h).iter().map(|p| p.position).collect();
            // At rest before and after.
            all.insert(0, points[0]);
            all.insert(0, points[0]);
            let last = all[all.len() - 1];
            all.push(last);
            for w in all.windows(3) {
                let speed = (w[1] - w[0]).norm() / h;
                let acceleration = (w[2] - w[1] * 2.0 + w[0]).norm() / (h * h);
                assert!(speed <= limits.feed * (1.0 + 1e-9), "{name}: speed {speed}");
                // 1e-15 m of rounding is 1e-7 m/s^2 at h = 1e-4.
                assert!(acceleration <= most * (1.0 + 1e-5), "{name}: {acceleration} > {most} at h = {h}");
            }
        }
    }
}

#[test]
fn normal_acceleration_and_chord_error_hold_at_every_sample() {
    let limits = FeedLimits { chord_error: 1e-6, feed: 1.0, step: 4e-3, ..limits() };
    for (name, points) in paths() {
        for p in follow(limits, smooth(&points), |_| 4e-3) {
            let slowest = 0.5 * limits.normal * limits.step;
            assert!(
                p.speed <= slowest || p.speed * p.speed * p.curvature <= limits.normal * (1.0 + 1e-9),
                "{name}"
            );
            let radius = 1.0 / p.curvature;
            let half_chord = 0.5 * p.speed * limits.step;
            let sagitta = radius - (radius * radius - half_chord * half_chord).max(0.0).sqrt();
            assert!(
                p.speed <= slowest || !sagitta.is_finite() || sagitta <= 1e-6 * 1.001,
                "{name}: {sagitta}"
            );
        }
    }
}

/// On a circle the cap is a closed form: v = sqrt(A_n R), (2 / Ts) sqrt(2 R d - d^2), (J R^2)^(1/3).
#[test]
fn the_circle_is_travelled_at_nearly_the_greatest_possible_speed() {
    let radius = 0.01_f64;
    let circle: Vec<_> = (0..=720)
        .map(|k| f64::from(k) * std::f64::consts::PI / 60.0)
        .map(|a| Point::new(a.cos(), a.sin(), 0.0) * radius)
        .collect();
    let free = FeedLimits { feed: 10.0, ..limits() };
    let cases = [
        (free, (2.0 * radius).sqrt()),
        (FeedLimits { chord_error: 1e-7, ..free }, 2e3 * (2.0 * radius * 1e-7_f64 - 1e-14).sqrt()),
        (FeedLimits { jerk: 5.0, ..free }, (5.0 * radius * radius).cbrt()),
    ];
    for (limits, expected) in cases {
        let all = follow(limits, smooth(&circle), |_| 1e-3);
        let middle = all[all.len() / 2].speed;
        assert!(middle <= expected * 1.001 && middle >= 0.95 * expected, "{middle} of {expected}");
    }
}

/// A figure of eight whose bends limit the speed: it goes down and up with the curvature's radius, not from cell to cell.
#[test]
fn the_speed_follows_the_curvature_without_chatter() {
    let limits = FeedLimits { feed: 0.1, tangential: 0.4, normal: 0.4, step: 4e-3, ..limits() };
    for points in [48, 96, 300] {
        let eight: Vec<_> = (0..=points)
            .map(|i| f64::from(i) * std::f64::consts::TAU / f64::from(points))
            .map(|a| Point::new(1.0 - a.cos(), (2.0 * a).sin() / 2.0, 0.0) * 0.05)
            .collect();
        let all = follow(limits, smooth(&eight), |_| 1e-3);
        let rates: Vec<_> = all.windows(2).map(|w| (w[1].speed - w[0].speed) / 1e-3).collect();
        // Turns between speeding up and slowing down at more than a quarter of what is allowed.
        let (mut turns, mut sign) = (0, 0.0);
        for rate in rates.iter().filter(|rate| rate.abs() > 0.25 * limits.tangential) {
            turns += u32::from(*rate * sign < 0.0);
            sign = *rate;
        }
        // Four bends, each entered and left, between a start and an end.
        assert!(turns <= 9, "{points} points: {turns} turns");
        // At the sharpest bend the speed is what the curvature allows, but for the bound's distance from it.
        let sharpest = all.iter().max_by(|a, b| a.curvature.total_cmp(&b.curvature)).unwrap();
        let most = (limits.normal / sharpest.curvature).sqrt();
        assert!(sharpest.speed > 0.95 * most && sharpest.speed <= most, "{} of {most}", sharpest.speed);
    }
}

/// Line of 0.5 m at 0.1 m/s and 1.5 m/s^2: T = D/V + V/A.
#[test]
fn a_line_takes_the_time_of_the_closed_form() {
    let steps = follow(limits(), smooth(&[Point::zeros(), Point::x() * 0.5]), |_| 1e-3).len();
    assert!((steps as f64 * 1e-3 - (5.0 + 0.1 / 1.5)).abs() <= 1e-3 + 1e-9);
}

/// Deviation of every point from a densely sampled run: its chords are 0.1 um or less off the curve.
#[test]
fn any_feed_rate_keeps_the_same_path() {
    let ramp = |k: usize| 1e-3 * (0.5 + 0.5 * (k as f64 * 0.01).cos());
    let rates: [&dyn Fn(usize) -> f64; 3] = [&|_| 0.3e-3, &ramp, &|k| if k % 7 < 3 { 0.0 } else { 1e-3 }];
    for (name, points) in paths() {
        let spans: Vec<_> = smooth(&points).map(|span| span.unwrap().span).collect();
        let lengths: Vec<_> = spans.iter().map(|s| length_between(s, 0.0, s.knot_span())).collect();
        for rate in rates {
            for p in follow(limits(), smooth(&points), rate) {
                // The point at this length, found from the spans alone.
                let mut s = p.length;
                let mut i = 0;
                while i + 1 < spans.len() && s > lengths[i] {
                    s -= lengths[i];
                    i += 1;
                }
                let u = parameter_at(&spans[i], 0.0, spans[i].knot_span(), s);
                let off = (spans[i].position(u) - p.position).norm();
                assert!(off < 1e-10, "{name}: {off} m off the path at {} m", p.length);
            }
        }
    }
}

#[test]
fn the_same_path_time_gives_the_same_point_at_any_feed_rate() {
    for (name, points) in paths() {
        let full = follow(limits(), smooth(&points), |_| 1e-3);
        let slow = follow(limits(), smooth(&points), |_| 0.25e-3);
        for (k, p) in full.iter().take(full.len() - 2).enumerate() {
            let q = slow[4 * k + 3];
            assert!((p.position - q.position).norm() < 1e-10, "{name} step {k}");
        }
    }
}

#[test]
fn corners_are_met_at_rest_and_exactly() {
    let square = [(0.0, 0.0), (0.03, 0.0), (0.03, 0.02), (0.0, 0.02)].map(|(x, y)| Point::new(x, y, 0.0));
    let stream = || SpanStream::new(SplineSettings::default(), square).unwrap();
    let all = follow(limits(), stream(), |_| 1e-4);
    for corner in &square[1..3] {
        let nearest =
            all.iter().min_by(|a, b| (a.position - corner).norm().total_cmp(&(b.position - corner).norm()));
        // v^2 = 2 A s
        let p = nearest.unwrap();
        assert!(p.speed <= 1.5e-4 + 1e-9 && (p.position - corner).norm() < 1e-8);
    }
    assert!(all.iter().all(|p| p.position.x <= 0.03 + 1e-15 && p.position.y <= 0.02 + 1e-15));
}

#[test]
fn a_starved_planner_rests_at_the_last_known_point_and_goes_on() {
    let points: Vec<_> = (0..60).map(|k| Point::new(f64::from(k) * 1e-3, 0.0, 0.0)).collect();
    let mut planner: FeedPlanner<32> = FeedPlanner::new(limits()).unwrap();
    assert_eq!(planner.advance(1e-3), None);
    let mut positions = vec![0.0];
    for span in smooth(&points).map(Result::unwrap) {
        planner.push(span).unwrap();
        for _ in 0..200 {
            positions.push(planner.advance(1e-3).unwrap().position.x);
        }
        assert_eq!(planner.advance(1e-3).unwrap().position, span.span.end());
        assert_eq!(planner.advance(1e-3).unwrap().speed, 0.0);
        assert!(!planner.is_done());
    }
    for w in positions.windows(3) {
        assert!((w[2] - 2.0 * w[1] + w[0]).abs() <= 1.5e-6 * (1.0 + 1e-6));
    }
    planner.finish();
    assert!(planner.advance(1e-3).is_some());
    assert_eq!((planner.advance(1e-3), planner.is_done()), (None, true));
}

#[test]
fn kinks_of_the_literal_method_are_passed_slowly_enough() {
    let circle = &datasets()["circle24(R=10)"];
    let points: Vec<_> = circle.iter().map(|p| p * MILLI).collect();
    let method = Method::Literal(EndCondition::Natural);
    let set = SplineSettings { method, corner: 3.0, ..SplineSettings::default() };
    let limits = limits();
    let all = follow(limits, SpanStream::new(set, points).unwrap(), |_| 1e-3);
    for w in all.windows(3) {
        let a = (w[2].position - w[1].position * 2.0 + w[0].position).norm() / 1e-6;
        // The jump adds to what the curve needs on either side of it.
        assert!(a <= limits.tangential.hypot(2.0 * limits.normal), "{a}");
    }
}

/// There and back again without a corner: the curve stands still at the turn and reverses there.
#[test]
fn a_reversal_without_a_corner_is_passed_slowly_enough() {
    let points = [0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0].map(|x| Point::new(x * MILLI, 0.0, 0.0));
    let limits = limits();
    let all = follow(limits, smooth(&points), |_| 1e-3);
    assert!(
        all.iter().all(|p| p.position.iter().all(|x| x.is_finite()) && p.position.x <= 3.0 * MILLI + 1e-15)
    );
    for w in all.windows(3) {
        let a = (w[2].position - w[1].position * 2.0 + w[0].position).norm() / 1e-6;
        assert!(a <= (limits.tangential + limits.normal) * (1.0 + 1e-6), "{a}");
    }
}

#[test]
fn bad_limits_gaps_and_faulty_points_are_refused() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(FeedPlanner::<64>::new(FeedLimits { feed: bad, ..limits() }).is_err());
    }
    let mut planner: FeedPlanner = FeedPlanner::new(limits()).unwrap();
    let line = |a: f64, b: f64| {
        let (p, q) = (Point::x() * a, Point::x() * b);
        PathSpan { span: Span::cubic(p, q, q - p, q - p, 1.0), end: SpanEnd::Continued }
    };
    planner.push(line(0.0, 1.0)).unwrap();
    assert!(matches!(planner.push(line(1.1, 2.0)), Err(FeedError::Gap(_))));
    // A point that is not finite: the path ends at rest at the last good span, and says why.
    let points = (0..30).map(|k| Point::new(if k == 20 { f64::NAN } else { f64::from(k) * 1e-3 }, 0.0, 0.0));
    let spans = SpanStream::new(SplineSettings::default(), points).unwrap();
    let mut path: FedPath<_> = FedPath::new(limits(), spans).unwrap();
    let mut last = None;
    while let Some(point) = path.advance(1e-3) {
        last = Some(point);
    }
    assert_eq!(last.unwrap().speed, 0.0);
    assert!(matches!(path.error(), Some(FeedError::Spline(SplineError::Point { .. }))));
}
