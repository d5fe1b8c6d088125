//! Why poses do not fit: each usual mistake is undone in turn, and the ones are told without which they fit.
//!
//! In: poses as they are written. Out: sentences, the likeliest first. A mistake counts as found if what is left without it is below the limits ([`known`](crate::known)) and
//! below a third of what is left with it.

use core::f64::consts::PI;
use std::collections::BTreeSet;

use mrroc::pose::Pose;
use nalgebra::Vector3;

use crate::columns::Written;
use crate::data::rotation::{Spelling, Turning};
use crate::known::{WRONG, WRONG_TURN};
use crate::quick::{Left, QuickEye, quick_tip};

/// A mistake explains what it makes smaller by this factor.
const EXPLAINS: f64 = 3.0;

/// Of several mistakes those are told that leave at most so many times what the best one leaves.
const AS_LIKELY: f64 = 2.0;

/// What is left is not told apart below this share of the limits.
const EXACT: f64 = 1e-3;

/// How many draws of poses are tried to find some that fit each other, and how many poses each draw has.
const DRAWS: u32 = 400;
const DRAWN: usize = 4;

/// At least this share of the poses must fit each other for the others to be told as wrong.
const MOST: f64 = 0.6;

/// A pose that is off by less than this share of the limits is not told as wrong.
const ASIDE: f64 = 0.5;

/// Poses of a flange, with those of a board if a camera saw one.
#[derive(Clone, Debug)]
pub struct Asked {
    /// Where the flange was.
    pub flange: Written,
    /// Where the board was in the camera.
    pub board: Option<Written>,
    /// Whether the board's poses were written by a user, and not computed from photos.
    pub is_board_written: bool,
    /// Whether the camera stands beside the arm.
    pub is_beside: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    Flange,
    Board,
}

/// A mistake that may have been made.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mistake {
    /// The orientation is written otherwise.
    Turns(Side, Spelling),
    /// Its angles are in another unit: what they are to be multiplied by.
    Angles(Side, f64),
    Inverse(Side),
    /// The board of a row belongs to the flange so many rows further.
    Late(usize, bool),
    /// Lengths of the board are wrong by a factor.
    Scale,
}

/// By pose what is left, and how the board seems turned.
type AllLeft = Vec<(Left, Vector3<f64>)>;

/// Poses of the flange and of the board, and their lines.
type Undone = (Vec<Pose>, Option<Vec<Pose>>, Vec<usize>);

/// What a mistake leaves if it is undone.
struct Tried {
    mistakes: Vec<Mistake>,
    score: f64,
    scale: f64,
    /// Poses that do not fit even then: the line, and by what.
    wrong: Vec<(usize, Left, Vector3<f64>)>,
}

/// The likeliest causes, as sentences; none if nothing explains it.
#[must_use]
pub fn causes(asked: &Asked) -> Vec<String> {
    let Some(as_written) = asked.tried(&[], false) else { return Vec::new() };
    let enough = (as_written.score / EXPLAINS).min(1.0);
    let singles = asked.singles();
    let all = |found: Vec<Tried>| told(asked, found, enough);
    let tried = |is_robust: bool| {
        let each = singles.iter().filter_map(|one| asked.tried(&[*one], is_robust));
        all(each.collect())
    };
    let first = tried(false);
    if !first.is_empty() {
        return first;
    }
    let alone = all(asked.tried(&[], true).into_iter().collect());
    if !alone.is_empty() {
        return alone;
    }
    let pairs = singles.iter().enumerate().flat_map(|(i, a)| singles[..i].iter().map(move |b| [*b, *a]));
    let pairs = pairs.filter(|[a, b]| a.may_be_with(*b)).filter_map(|both| asked.tried(&both, false));
    let both = all(pairs.collect());
    if !both.is_empty() {
        return both;
    }
    tried(true)
}

fn told(asked: &Asked, mut found: Vec<Tried>, enough: f64) -> Vec<String> {
    found.retain(|one| one.score <= enough);
    found.sort_by(|a, b| a.score.max(EXACT).total_cmp(&b.score.max(EXACT)));
    let Some(best) = found.first().map(|one| one.score.max(EXACT)) else { return Vec::new() };
    let likely = found.iter().filter(|one| one.score <= AS_LIKELY * best);
    let mut sentences: Vec<String> = Vec::new();
    for one in likely {
        let sentence = asked.sentence(one);
        if !sentences.contains(&sentence) {
            sentences.push(sentence);
        }
    }
    sentences.truncate(3);
    sentences
}

impl Mistake {
    fn may_be_with(self, other: Self) -> bool {
        use Mistake::{Angles, Inverse, Late, Scale, Turns};
        match (self, other) {
            (Turns(a, _) | Angles(a, _), Turns(b, _) | Angles(b, _)) | (Inverse(a), Inverse(b)) => a != b,
            (Late(..), Late(..)) | (Scale, Scale) => false,
            _ => true,
        }
    }
}

impl Asked {
    /// All mistakes that these poses may have, with the usual ones first.
    fn singles(&self) -> Vec<Mistake> {
        let mut singles = Vec::new();
        let board = self.board.as_ref().filter(|_| self.is_board_written);
        for (side, written) in [(Side::Flange, Some(&self.flange)), (Side::Board, board)] {
            let Some(written) = written else { continue };
            singles.extend(spellings(written.spelling).into_iter().map(|other| Mistake::Turns(side, other)));
            if written.spelling.is_angles() {
                singles.extend([PI / 180.0, 180.0 / PI].map(|factor| Mistake::Angles(side, factor)));
            }
            singles.push(Mistake::Inverse(side));
        }
        if self.board.is_some() {
            singles.push(Mistake::Scale);
            singles.extend([1, 2].iter().flat_map(|rows| [true, false].map(|up| Mistake::Late(*rows, up))));
        }
        singles
    }

    /// The poses without these mistakes, with the rows that are left; `None` where they are none.
    fn without(&self, mistakes: &[Mistake]) -> Option<Undone> {
        let (mut flange, mut board) = (self.flange.clone(), self.board.clone());
        let (mut is_inverse, mut rows) = ([self.is_beside, false], (0, 0));
        for mistake in mistakes {
            let of = |side: Side| side as usize;
            match *mistake {
                Mistake::Turns(side, spelling) => match side {
                    Side::Flange => flange.spelling = spelling,
                    Side::Board => board.as_mut()?.spelling = spelling,
                },
                Mistake::Angles(side, factor) => {
                    let written = if side == Side::Flange { &mut flange } else { board.as_mut()? };
                    written.turns.iter_mut().flatten().for_each(|angle| *angle *= factor);
                }
                Mistake::Inverse(side) => is_inverse[of(side)] = !is_inverse[of(side)],
                Mistake::Late(by, true) => rows.1 = by,
                Mistake::Late(by, false) => rows.0 = by,
                Mistake::Scale => {}
            }
        }
        let read = |written: &Written, is_inverse: bool| -> Option<Vec<Pose>> {
            let poses = written.poses().ok()?;
            Some(poses.into_iter().map(|pose| if is_inverse { pose.inverse() } else { pose }).collect())
        };
        let mut flanges = read(&flange, is_inverse[0])?;
        let mut boards = board.as_ref().map(|board| read(board, is_inverse[1]).ok_or(())).transpose().ok()?;
        let mut lines = self.flange.lines.clone();
        if let Some(boards) = &mut boards {
            flanges.drain(..rows.0.min(flanges.len()));
            lines.drain(..rows.0.min(lines.len()));
            boards.drain(..rows.1.min(boards.len()));
            let count = flanges.len().min(boards.len());
            flanges.truncate(count);
            boards.truncate(count);
            lines.truncate(count);
        }
        Some((flanges, boards, lines))
    }

    /// What is left without some mistakes; `is_robust` where single poses may be wrong beside.
    fn tried(&self, mistakes: &[Mistake], is_robust: bool) -> Option<Tried> {
        let (flanges, boards, lines) = self.without(mistakes)?;
        let n = flanges.len();
        if n < if boards.is_some() { 3 } else { DRAWN } {
            return None;
        }
        let is_scale_free = mistakes.contains(&Mistake::Scale);
        let pairs: Option<Vec<(Pose, Pose)>> =
            boards.map(|boards| flanges.iter().copied().zip(boards).collect());
        // By pose what is left, with what is found from some of them.
        let left = |of: &[usize]| -> Option<(AllLeft, f64)> {
            match &pairs {
                Some(pairs) => {
                    let some: Vec<(Pose, Pose)> = of.iter().map(|i| pairs[*i]).collect();
                    let eye = QuickEye::of(&some, is_scale_free)?;
                    Some((pairs.iter().map(|pair| eye.left(pair)).collect(), eye.scale))
                }
                None => {
                    let left = quick_tip(&flanges, of)?;
                    Some((left.into_iter().map(|left| ([left, 0.0], Vector3::zeros())).collect(), 1.0))
                }
            }
        };
        let every: Vec<usize> = (0..n).collect();
        if !is_robust {
            let (left, scale) = left(&every)?;
            let score = score(&left, &every);
            return Some(Tried { mistakes: mistakes.to_vec(), score, scale, wrong: Vec::new() });
        }
        if n <= DRAWN {
            return None;
        }
        let most = (MOST * n as f64).ceil() as usize;
        let by_size = |left: &[(Left, Vector3<f64>)]| {
            let mut order = every.clone();
            order.sort_by(|a, b| size(&left[*a].0).total_cmp(&size(&left[*b].0)));
            order
        };
        // Of all draws the one that foretells most of the poses best (Rousseeuw 1984).
        let mut best: Option<(f64, Vec<usize>)> = None;
        let mut random = 1_u64;
        for _ in 0..DRAWS {
            let mut drawn = BTreeSet::new();
            while drawn.len() < DRAWN {
                random =
                    random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                drawn.insert((random >> 33) as usize % n);
            }
            let drawn: Vec<usize> = drawn.into_iter().collect();
            let Some((left, _)) = left(&drawn) else { continue };
            let mut order = by_size(&left);
            order.truncate(most.max(DRAWN));
            let largest = order.last().map_or(f64::INFINITY, |last| size(&left[*last].0));
            if best.as_ref().is_none_or(|(least, _)| largest < *least) {
                best = Some((largest, order));
            }
        }
        let (_, mut kept) = best?;
        for _ in 0..3 {
            let (left, _) = left(&kept)?;
            let limit = (4.0 * score(&left, &kept)).max(ASIDE);
            let fit: Vec<usize> = every.iter().copied().filter(|i| size(&left[*i].0) < limit).collect();
            if fit.len() < kept.len() {
                break;
            }
            kept = fit;
        }
        if kept.len() == n {
            return None;
        }
        let (left, scale) = left(&kept)?;
        let wrong = every.iter().filter(|i| !kept.contains(i)).map(|i| (lines[*i], left[*i].0, left[*i].1));
        let score = score(&left, &kept);
        Some(Tried { mistakes: mistakes.to_vec(), score, scale, wrong: wrong.collect() })
    }

    fn sentence(&self, tried: &Tried) -> String {
        let mut parts: Vec<String> =
            tried.mistakes.iter().map(|mistake| self.named(*mistake, tried.scale)).collect();
        parts.extend(tried.wrong.iter().take(5).map(|(line, [length, angle], turn)| {
            let mut text = format!(
                "line {line} does not fit the others: it is off by {:.1} mm{}",
                1e3 * length,
                if self.board.is_some() {
                    format!(" and {:.1} degrees", angle.to_degrees())
                } else {
                    String::new()
                }
            );
            let axis = turn.try_normalize(0.0).map(|axis| (axis.iamax(), axis.amax()));
            if let Some((axis, along)) = axis.filter(|_| *angle > 2.6)
                && along > 0.9
            {
                let axis = ["x", "y", "z"][axis];
                text += &format!(
                    " (the board seems turned by half a turn about its {axis} axis: were its corners counted from the other end?)"
                );
            }
            text + "; measure it again, or leave it out"
        }));
        if tried.wrong.len() > 5 {
            parts.push(format!("and so do {} other lines", tried.wrong.len() - 5));
        }
        parts.join("; and ")
    }

    fn named(&self, mistake: Mistake, scale: f64) -> String {
        let of = |side: Side| match side {
            Side::Flange => "the flange",
            Side::Board => "the board",
        };
        match mistake {
            Mistake::Turns(side, spelling) => {
                let now = if side == Side::Flange {
                    self.flange.spelling
                } else {
                    self.board.as_ref().map_or(Spelling::Vector, |board| board.spelling)
                };
                respelled(of(side), now, spelling)
            }
            Mistake::Angles(side, factor) => {
                let (is, not) = if factor < 1.0 { ("degrees", "radians") } else { ("radians", "degrees") };
                format!(
                    "the angles of {} are {is}, and the columns' names say {not}: rename the columns",
                    of(side)
                )
            }
            Mistake::Inverse(Side::Flange) if self.board.is_some() => {
                let (other, where_it_is) = if self.is_beside {
                    ("hand-eye", "the camera is on the flange")
                } else {
                    ("eye-to-hand", "the camera stands beside the arm")
                };
                format!(
                    "{where_it_is} (then it is `calibrate {other}`), or the flange's poses are inverse: those of the base in the flange, in place of the flange in the base"
                )
            }
            Mistake::Inverse(Side::Flange) => {
                "the poses are inverse: those of the base in the flange, in place of the flange in the base"
                    .to_owned()
            }
            Mistake::Inverse(Side::Board) => {
                "the board's poses are inverse: those of the camera in the board, in place of the board in the camera"
                    .to_owned()
            }
            Mistake::Late(by, up) => {
                let side = if up { "below" } else { "above" };
                let rows = if by == 1 { "one row".to_owned() } else { format!("{by} rows") };
                format!("each board is written {rows} {side} the pose of the flange that it belongs to")
            }
            Mistake::Scale => scaled(scale),
        }
    }
}

/// What a factor of the board's lengths means.
fn scaled(scale: f64) -> String {
    let near = |unit: f64| (scale / unit - 1.0).abs() < 0.05;
    if near(1e-3) || near(1e3) {
        let (a, b) = if near(1e-3) { ("mm", "m") } else { ("m", "mm") };
        return format!(
            "lengths of the board are in {a}, and its columns' names say {b} (or those of the flange the other way round): rename the columns"
        );
    }
    let percent = 100.0 * (scale.recip() - 1.0);
    let (percent, sense) = (percent.abs(), if percent > 0.0 { "long" } else { "short" });
    format!(
        "lengths of the board are {percent:.2} % too {sense}: the squares that it was measured with are {scale:.4} times as large as was said; measure them with a calliper"
    )
}

/// What a factor of the board's lengths means that explains these poses, if it is there without doubt: more than `share` of the length, and five standard deviations.
/// Poses that a usual fit leaves may fit, and the camera be beside where it is for all that.
#[must_use]
pub fn another_scale(asked: &Asked, share: f64) -> Option<String> {
    let as_written = asked.left_of(false)?;
    let (least, scale, count) = asked.left_of(true).map(|(sum, scale, n)| (sum, scale, n as f64))?;
    let freedom = (3.0 * count - 7.0).max(1.0);
    // The sum of squares that the factor takes away, in units of their variance.
    let squares = freedom * (as_written.0 / least.max(f64::MIN_POSITIVE) - 1.0);
    ((scale - 1.0).abs() > share && squares > 25.0).then(|| scaled(scale))
}

impl Asked {
    /// The sum of the squares of what is left of positions \[m^2\], the factor of the board's lengths, and how many poses there are.
    fn left_of(&self, is_scale_free: bool) -> Option<(f64, f64, usize)> {
        let (flanges, boards, _) = self.without(&[])?;
        let pairs: Vec<(Pose, Pose)> = flanges.into_iter().zip(boards?).collect();
        let eye = QuickEye::of(&pairs, is_scale_free)?;
        Some((pairs.iter().map(|pair| eye.left(pair).0[0].powi(2)).sum(), eye.scale, pairs.len()))
    }
}

/// What is left of a pose, 1 at the limits.
fn size([length, angle]: &Left) -> f64 {
    (length / WRONG).max(angle / WRONG_TURN)
}

/// The same of several poses, as root mean squares.
fn score(left: &[(Left, Vector3<f64>)], of: &[usize]) -> f64 {
    let rms = |part: usize| {
        (of.iter().map(|i| left[*i].0[part].powi(2)).sum::<f64>() / of.len().max(1) as f64).sqrt()
    };
    let score = size(&[rms(0), rms(1)]);
    if score.is_finite() { score } else { f64::INFINITY }
}

/// Other conventions in which the same numbers may write orientations.
fn spellings(own: Spelling) -> Vec<Spelling> {
    let others = match own {
        Spelling::Wxyz => vec![Spelling::Xyzw],
        Spelling::Xyzw => vec![Spelling::Wxyz],
        Spelling::Matrix => Vec::new(),
        Spelling::Vector | Spelling::Euler(..) => {
            let usual = ["zyx moving", "xyz moving", "zyz moving", "xyz fixed", "zyx fixed", "zyz fixed"];
            let usual = usual.iter().filter_map(|name| Spelling::parse(&format!("euler {name}")));
            let mut all: Vec<Spelling> = [Spelling::Vector].into_iter().chain(usual).collect();
            for turning in [Turning::Moving, Turning::Fixed] {
                for axes in (0..27).map(|i| [i / 9, i / 3 % 3, i % 3]) {
                    let one = Spelling::Euler(axes, turning);
                    if axes[0] != axes[1] && axes[1] != axes[2] && !all.contains(&one) {
                        all.push(one);
                    }
                }
            }
            all
        }
    };
    others.into_iter().filter(|other| *other != own).collect()
}

/// How orientations are truly written, and what to do.
fn respelled(of: &str, now: Spelling, truly: Spelling) -> String {
    let letters = |axes: [usize; 3]| axes.map(|axis| ["x", "y", "z"][axis]).concat();
    match (now, truly) {
        (_, Spelling::Vector) => {
            format!("the three angles of {of} are a rotation vector: name their columns rx, ry, rz")
        }
        (_, Spelling::Euler(axes, turning)) => {
            let (about, order, columns) = match turning {
                Turning::Moving => ("axes as turned before", letters(axes), "a, b, c"),
                Turning::Fixed => {
                    let [a, b, c] = axes;
                    ("fixed axes", letters([c, b, a]), "c, b, a (in this order)")
                }
            };
            let what = format!(
                "the orientation of {of} is three turns in the order {} about {about}",
                letters(axes)
            );
            if ["zyx", "xyz", "zyz"].contains(&&*order) {
                format!("{what}: name its columns {columns}, and write --angles {order}")
            } else {
                format!("{what}, which this command does not read: write a quaternion or a rotation vector")
            }
        }
        (Spelling::Wxyz, _) => {
            format!(
                "the quaternions of {of} have the scalar w last: name their columns qx, qy, qz, qw in this order"
            )
        }
        _ => format!(
            "the quaternions of {of} have the scalar w first: name their columns qw, qx, qy, qz in this order"
        ),
    }
}
