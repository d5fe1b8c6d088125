//! Postures for a calibration that is still to be measured: drawn within the joints' limits, in sight and clear, and of these the ones that tell most.
//!
//! In: a [`Plan`], the header of the table to come. Out: [`Postures`], the table with joint positions, and how sure the arm will be anywhere in its
//! workspace, beside as many postures at random.

use core::fmt;

use mrroc::random::Noise as Random;

use crate::chain::Detail;
use crate::choice::{Aim, Choice, choose, evaluate};
use crate::data::{Plan, Scales, Stated};
use crate::problem::{InstrumentId, TargetId};
use crate::trials::settings;

/// So many postures are chosen from for each that is wanted, but no more than [`POOL`].
const PER_POSTURE: usize = 12;
const POOL: usize = 400;
/// So often is drawn for each posture of the pool before it is given up.
const TRIES: usize = 100;
/// Postures at which the arm is to be known.
const AIMS: usize = 60;
/// Links nearer to each other than this are not clear \[m\].
const CLEAR: f64 = 0.01;

/// What postures must keep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wanted {
    /// How many.
    pub count: usize,
    /// Of what is drawn at random.
    pub seed: u64,
    /// How much of the arm is to be calibrated; by default what the header says, or its geometry.
    pub detail: Option<Detail>,
    /// Joints that go up and down, the flange and its points stay above this height in the base \[m\].
    pub floor: Option<f64>,
    /// In which direction a point's face looks in its own frame, and how far that may be turned from the line of sight \[rad\].
    pub facing: Option<(nalgebra::Unit<nalgebra::Vector3<f64>>, f64)>,
    /// How near and how far a point may be from the instrument \[m\].
    pub range: Option<[f64; 2]>,
}

/// Postures, in the order in which they tell most.
#[derive(Clone, Debug)]
pub struct Postures {
    /// The table to fill in.
    pub table: String,
    /// What the chosen ones tell.
    pub chosen: Told,
    /// What as many at random tell.
    pub random: Told,
    /// Unknowns that the chosen ones say nothing of, by name.
    pub unseen: Vec<String>,
    /// How many postures there were to choose from.
    pub among: usize,
    /// Why collisions are not looked at, if they are not.
    pub no_clearance: Option<String>,
}

/// What postures tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// How many there are.
    pub count: usize,
    /// Of so many unknowns.
    pub unknowns: usize,
    /// This many are seen.
    pub rank: usize,
    /// The smallest singular value of what is measured and believed, with columns of norm 1.
    pub smallest: f64,
    /// The root mean square of how far points will be from where they are foretold, in the workspace \[m\].
    pub error: f64,
}

/// Why there are none.
#[derive(Debug, thiserror::Error)]
pub enum NoPostures {
    /// None, or more than can be chosen from.
    #[error("{0} postures are wanted, of 3 to 200\n help: write --count 30; 20 to 40 are usual")]
    Count(usize),
    /// Sight is limited, and it is not known from where.
    #[error(
        "nobody says where `{0}` stands, from which points must be in sight\n help: write [instruments.{0}] with position = [..] and unit, and rotation_vector, or leave out --facing and --range"
    )]
    Place(String),
    /// Nothing is in sight.
    #[error(
        "`{name}` sees no point in any of {tried} postures that are clear\n help: see its position, and in which direction points face; or widen --facing or --range"
    )]
    Blind {
        /// The instrument.
        name: String,
        /// How many were looked at.
        tried: usize,
    },
    /// Too few are left.
    #[error(
        "{found} postures of {tried} drawn within the limits are clear and in sight, and {wanted} are wanted: {low} are below the floor, {meet} have links that meet, {hidden} are out of sight\n help: widen what leaves out most: limits, --floor, --facing or --range"
    )]
    Few {
        /// How many are left.
        found: usize,
        /// Of these.
        tried: usize,
        /// How many are wanted.
        wanted: usize,
        /// How many are too low.
        low: usize,
        /// How many meet themselves.
        meet: usize,
        /// How many no instrument sees.
        hidden: usize,
    },
    /// The table, or its problem.
    #[error("{0}")]
    Other(String),
}

/// A posture, and the places of its sights.
type Seen = (Vec<f64>, Vec<usize>);

impl Postures {
    /// Chooses.
    ///
    /// # Errors
    /// [`NoPostures`].
    pub fn choose(mut plan: Plan, wanted: &Wanted) -> Result<Postures, NoPostures> {
        let count = wanted.count;
        if !(3..=200).contains(&count) {
            return Err(NoPostures::Count(count));
        }
        let (pool, aims, no_clearance) = drawn(&plan, wanted)?;
        let Stated { problem, arm, points, instruments, .. } = stated(&mut plan, &pool, wanted)?;
        let mut next = 0;
        let candidates: Vec<Vec<usize>> = pool
            .iter()
            .map(|(_, seen)| {
                next += seen.len();
                (next - seen.len()..next).collect()
            })
            .collect();
        let mut aimed = problem.clone();
        let targets = moving(&plan, &points, &instruments, |id| aimed.target_at(id));
        let place = |q: &Vec<f64>| {
            targets.iter().map(|target| Aim::Place(arm, q.clone(), *target)).collect::<Vec<_>>()
        };
        let aims: Vec<Aim> = aims.iter().flat_map(place).collect();
        let best = choose(&aimed, &candidates, &aims, count);
        let at_random = evaluate(&aimed, &candidates, &aims, &(0..count).collect::<Vec<_>>());
        let (chosen, unseen) = told(&mut plan, &pool, wanted, &best)?;
        let (random, _) = told(&mut plan, &pool, wanted, &at_random)?;
        let rows = best.candidates.iter().map(|i| (&*pool[*i].0, &*pool[*i].1));
        let table = plan.table(rows).map_err(NoPostures::Other)?;
        Ok(Postures { table, chosen, random, unseen, among: pool.len(), no_clearance })
    }
}

/// What is to be known anywhere: the points on the flange, and instruments there.
fn moving(
    plan: &Plan,
    points: &[TargetId],
    instruments: &[InstrumentId],
    mut target_at: impl FnMut(InstrumentId) -> TargetId,
) -> Vec<TargetId> {
    let mut targets: Vec<TargetId> = Vec::new();
    let (mut seen_points, mut seen_instruments) = (Vec::new(), Vec::new());
    for sight in plan.sights() {
        let (moves, looks) = plan.on_flange(sight);
        if moves && !seen_points.contains(&sight.point) {
            seen_points.push(sight.point);
            targets.push(points[sight.point]);
        }
        if looks && !seen_instruments.contains(&sight.instrument) {
            seen_instruments.push(sight.instrument);
            targets.push(target_at(instruments[sight.instrument]));
        }
    }
    targets
}

fn stated(plan: &mut Plan, postures: &[Seen], wanted: &Wanted) -> Result<Stated, NoPostures> {
    plan.expect(postures.iter().map(|(q, seen)| (&**q, &**seen)));
    let detail = wanted.detail.or(plan.data.detail()).unwrap_or(Detail::Geometry);
    let stated = plan.data.problem(detail, &plan.data.tolerances(), Scales::Declared);
    stated.map_err(|why| NoPostures::Other(why.to_string()))
}

/// What some of the pool tell, and what they do not, as a fit to what is expected of them says.
fn told(
    plan: &mut Plan,
    pool: &[Seen],
    wanted: &Wanted,
    of: &Choice,
) -> Result<(Told, Vec<String>), NoPostures> {
    let own: Vec<Seen> = of.candidates.iter().map(|i| pool[*i].clone()).collect();
    let fit = stated(plan, &own, wanted)?.problem.fit(&settings());
    let fit = fit.map_err(|why| NoPostures::Other(why.to_string()))?;
    let information = fit.information();
    let told = Told {
        count: own.len(),
        unknowns: information.parameters(),
        rank: information.rank,
        smallest: of.smallest,
        error: of.left.last().copied().unwrap_or(f64::INFINITY),
    };
    Ok((told, fit.unseen().iter().map(ToString::to_string).collect()))
}

/// Postures to choose from, others at which the arm is to be known, and why collisions are not looked at.
#[allow(clippy::type_complexity)]
fn drawn(plan: &Plan, wanted: &Wanted) -> Result<(Vec<Seen>, Vec<Vec<f64>>, Option<String>), NoPostures> {
    let names: Vec<&str> = plan.data.instruments().collect();
    let is_limited = wanted.facing.is_some() || wanted.range.is_some();
    let unplaced = (0..names.len()).find(|i| is_limited && !plan.is_placed(*i));
    if let Some(unplaced) = unplaced {
        return Err(NoPostures::Place(names[unplaced].to_owned()));
    }
    let arm = plan.data.arm();
    let (mut clearance, no_clearance) = match arm.own_clearance() {
        Ok(clearance) => (Some(clearance), None),
        Err(why) => (None, Some(why)),
    };
    let limits: Vec<[f64; 2]> = arm.limits.iter().map(|limits| limits.unwrap_or_default()).collect();
    let lifted = lifted(plan, &limits);
    let size = POOL.min(PER_POSTURE * wanted.count).max(wanted.count);
    let mut random = Random::seeded(wanted.seed);
    let (mut pool, mut aims) = (Vec::new(), Vec::new());
    let mut sees = vec![false; names.len()];
    let [mut low, mut meet, mut hidden, mut tried] = [0; 4];
    while tried < TRIES * size && (pool.len() < size || aims.len() < AIMS) {
        tried += 1;
        let q: Vec<f64> = limits.iter().map(|[low, high]| random.between(*low, *high)).collect();
        if !is_above(plan, &q, &lifted, wanted.floor) {
            low += 1;
            continue;
        }
        let nearest = clearance.as_mut().map(|clearance| {
            // A posture that cannot be evaluated is not clear.
            clearance.nearest_at(&[&q]).map_or(0.0, |nearest| nearest.distance)
        });
        if nearest.is_some_and(|nearest| nearest < CLEAR) {
            meet += 1;
            continue;
        }
        // The first ones are aims, so that these are no candidates.
        if aims.len() < AIMS {
            aims.push(q);
            continue;
        }
        let seen: Vec<usize> =
            (0..plan.sights().len()).filter(|i| is_in_sight(plan, *i, &q, wanted)).collect();
        seen.iter().for_each(|i| sees[plan.sights()[*i].instrument] = true);
        if seen.is_empty() {
            hidden += 1;
        } else {
            pool.push((q, seen));
        }
    }
    if let Some(blind) = sees.iter().position(|sees| !sees).filter(|_| tried > low + meet) {
        return Err(NoPostures::Blind { name: names[blind].to_owned(), tried: tried - low - meet });
    }
    if pool.len() < wanted.count {
        let (found, wanted) = (pool.len(), wanted.count);
        return Err(NoPostures::Few { found, tried, wanted, low, meet, hidden });
    }
    Ok((pool, aims, no_clearance))
}

/// The heights of the joints, the flange, and the points on it.
fn heights(plan: &Plan, q: &[f64]) -> Vec<f64> {
    let frames = plan.frames(q);
    let flange = frames.last().copied().unwrap_or_default();
    let on_flange = plan.sights().iter().filter(|sight| plan.on_flange(sight).0);
    let points = on_flange.map(|sight| plan.both(sight, &flange).0);
    frames.into_iter().chain(points).map(|frame| frame.translation.z).collect()
}

/// Which of the heights change: a shoulder that only turns about the vertical stands where it stands.
fn lifted(plan: &Plan, limits: &[[f64; 2]]) -> Vec<bool> {
    let mut random = Random::seeded(1);
    let mut any =
        || heights(plan, &limits.iter().map(|[low, high]| random.between(*low, *high)).collect::<Vec<_>>());
    let first = any();
    let others = [any(), any(), any(), any()];
    (0..first.len()).map(|i| others.iter().any(|other| (other[i] - first[i]).abs() > 1e-6)).collect()
}

/// Whether all that goes up and down is above the floor.
fn is_above(plan: &Plan, q: &[f64], lifted: &[bool], floor: Option<f64>) -> bool {
    let Some(floor) = floor else { return true };
    heights(plan, q).into_iter().zip(lifted).all(|(height, lifted)| !lifted || height >= floor)
}

fn is_in_sight(plan: &Plan, sight: usize, q: &[f64], wanted: &Wanted) -> bool {
    let Some(flange) = plan.frames(q).pop() else { return false };
    let (point, own) = plan.both(&plan.sights()[sight], &flange);
    let sight = own.translation.vector - point.translation.vector;
    let is_near = wanted.range.is_none_or(|[near, far]| (near..=far).contains(&sight.norm()));
    let faces = wanted.facing.is_none_or(|(face, most)| (point.rotation * face).angle(&sight) <= most);
    is_near && faces
}

impl fmt::Display for Postures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} postures of {} that are within the limits, in sight and clear",
            self.chosen.count, self.among
        )?;
        match &self.no_clearance {
            None => writeln!(
                f,
                "links of the arm stay {:.0} mm apart; what stands around it is not looked at",
                1e3 * CLEAR
            )?,
            Some(why) => {
                writeln!(f, "collisions are not looked at: {why}; go to each posture slowly the first time")?
            }
        }
        writeln!(
            f,
            "                  rank    smallest singular value   predicted error, rms over the workspace"
        )?;
        for (name, told) in [("chosen", &self.chosen), ("at random", &self.random)] {
            let Told { unknowns, rank, smallest, error, .. } = told;
            writeln!(f, "{name:12} {rank:4} of {unknowns:<4}   {smallest:20.1e}   {:20.4} mm", 1e3 * error)?;
        }
        if !self.unseen.is_empty() {
            writeln!(f, "what cannot be told apart (the first of each stays as it was designed):")?;
            for unseen in &self.unseen {
                writeln!(f, "  {unseen}")?;
            }
        }
        Ok(())
    }
}
