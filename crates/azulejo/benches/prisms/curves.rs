//! What a test of a line with one curve costs, and how often it ends early.

use crate::timed;
use azulejo_scene::Figure;
use azulejo_scene::figure::{Segment, bernstein, crossings};
use glam::DVec2;
use std::sync::Arc;

/// How tests ended.
#[derive(Default)]
struct Ends {
    /// All control points on one side of the line.
    beside: usize,
    /// All behind the ray's start.
    behind: usize,
    /// The cubic was solved.
    solved: usize,
}

/// Random half-lines that begin in the rectangle around each outline against all its curves, one
/// by one, without the tree of runs that the tracer has over them.
pub fn measure(name: &str, figures: &[Arc<Figure>], quick: bool) {
    let mut random = Random(3);
    let mut ends = Ends::default();
    let rounds = if quick { 2_000 } else { 20_000 };
    let mut sum = 0.0;
    let ((), seconds) = timed(|| {
        for figure in figures {
            let curves: Vec<[DVec2; 4]> = figure.segments().filter_map(cubic).collect();
            let bounds = figure.bounds();
            for _ in 0..rounds {
                let at = DVec2::new(random.next(), random.next());
                let origin = bounds.min + at * bounds.size();
                let direction = DVec2::from_angle(std::f64::consts::TAU * random.next());
                sum += (curves.iter())
                    .map(|c| test(c, origin, direction, &mut ends))
                    .sum::<f64>();
            }
        }
    });
    let tests = (ends.beside + ends.behind + ends.solved).max(1);
    let share = |n: usize| 100.0 * n as f64 / tests as f64;
    println!(
        "{name:14} {:4} glyphs, {:6.1} M tests of cubics, {:.1} ns each; beside the line {:.1}%, behind {:.1}%, \
         solved {:.1}% (sum {sum:.0})",
        figures.len(),
        tests as f64 * 1e-6,
        seconds / tests as f64 * 1e9,
        share(ends.beside),
        share(ends.behind),
        share(ends.solved),
    );
}

fn cubic(segment: Segment) -> Option<[DVec2; 4]> {
    match segment {
        Segment::Line(_) => None,
        Segment::Cubic(points) => Some(points),
    }
}

/// The sum of the distances of all crossings.
fn test(points: &[DVec2; 4], origin: DVec2, direction: DVec2, ends: &mut Ends) -> f64 {
    let height = points.map(|p| direction.perp_dot(p - origin));
    if height.iter().all(|h| *h >= 0.0) || height.iter().all(|h| *h < 0.0) {
        ends.beside += 1;
        return 0.0;
    }
    let along = points.map(|p| direction.dot(p - origin));
    if along.iter().all(|s| *s < 0.0) {
        ends.behind += 1;
        return 0.0;
    }
    ends.solved += 1;
    let crossings = crossings(height).into_iter().flatten();
    crossings.map(|(t, _)| bernstein(along, t).max(0.0)).sum()
}

/// Random numbers in 0..1, from a seed.
pub struct Random(pub u64);

impl Random {
    /// The next number.
    pub fn next(&mut self) -> f64 {
        azulejo::scene::random::split_mix64(&mut self.0)
    }
}
