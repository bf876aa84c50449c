//! The map between the world and the kernel's own coordinates.

use azulejo_scene::math::Aabb;
use glam::{DAffine3, DMat3, DVec3};

/// Boxes among which the most crowded place is searched.
const SAMPLES: usize = 4096;

/// The scene has to be this many times as large as its crowded place for that to have coordinates of its own.
const FAR: f64 = 32.0;

/// Most faces that are intersected in `f64`, because they are large and near at once.
const MOST_LARGE: usize = 256;

/// Boxes within this many sizes of the crowded place belong to it.
const BESIDE: f64 = 4.0;

/// World to kernel coordinates: `(p − centre) · scale`. Most of the scene lies in −1..=1; all of it, unless a
/// few things lie far away from everything else: a stray point at the origin of a city in national coordinates
/// would else cost all of the digits of `f32` that tell its walls apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalFrame {
    centre: DVec3,
    /// A power of two, so that scaling rounds nothing.
    scale: f64,
    /// World units around the centre that coordinates of up to 1 stand for, about.
    reach: f64,
}

impl LocalFrame {
    pub(crate) fn around(bounds: &Aabb) -> LocalFrame {
        LocalFrame::about(bounds.centre(), 0.5 * bounds.size().max_element())
    }

    fn about(centre: DVec3, reach: f64) -> LocalFrame {
        // A single point, or a size that no power of two scales to 1, is not scaled.
        let scale = (-reach.log2().ceil()).exp2();
        LocalFrame {
            centre,
            scale: if scale.is_normal() { scale } else { 1.0 },
            reach,
        }
    }

    /// The frame of a scene with these `boxes`, all of them within `bounds`: about the crowded place, if that is
    /// small beside the scene, and few things are [large](LocalFrame::is_large) as seen from there.
    pub(crate) fn of<B: Iterator<Item = Aabb>>(bounds: &Aabb, boxes: impl Fn() -> B) -> LocalFrame {
        let whole = LocalFrame::around(bounds);
        let Some(crowd) = crowded(&boxes) else {
            return whole;
        };
        let half = 0.5 * crowd.size().max_element();
        let about = LocalFrame::about(crowd.centre(), half);
        let is_apart = half > 0.0 && FAR * half < whole.reach;
        if is_apart && boxes().filter(|b| about.is_large(b)).count() <= MOST_LARGE {
            about
        } else {
            whole
        }
    }

    /// Whether something reaches from near the centre, or from far away to twice as far. Rounding of its corners
    /// would move it by more than what is near is rounded.
    pub(crate) fn is_large(&self, of: &Aabb) -> bool {
        let centre = self.centre;
        let farthest = (of.min - centre).abs().max((of.max - centre).abs());
        let nearest = (of.min - centre).max(centre - of.max).max(DVec3::ZERO);
        farthest.max_element() > 2.0 * nearest.max_element().max(self.reach)
    }

    /// World units around the centre in which coordinates are rounded as 1 is.
    pub(crate) fn reach(&self) -> f64 {
        self.reach
    }

    pub(crate) fn point(&self, p: DVec3) -> DVec3 {
        (p - self.centre) * self.scale
    }

    pub(crate) fn vector(&self, v: DVec3) -> DVec3 {
        v * self.scale
    }

    pub(crate) fn world_point(&self, p: DVec3) -> DVec3 {
        p / self.scale + self.centre
    }

    pub(crate) fn world_vector(&self, v: DVec3) -> DVec3 {
        v / self.scale
    }

    /// Largest coordinate of a point relative to the centre, in world units.
    pub(crate) fn distance(&self, p: DVec3) -> f64 {
        (p - self.centre).abs().max_element()
    }

    pub(crate) fn world_from_local(&self) -> DAffine3 {
        DAffine3 {
            matrix3: DMat3::from_diagonal(DVec3::splat(1.0 / self.scale)),
            translation: self.centre,
        }
    }

    pub(crate) fn local_from_world(&self) -> DAffine3 {
        DAffine3 {
            matrix3: DMat3::from_diagonal(DVec3::splat(self.scale)),
            translation: -self.centre * self.scale,
        }
    }
}

pub(crate) fn single(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

pub(crate) fn double(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// The box around the boxes about the place where half of them are; `None` if there is no such place.
fn crowded<B: Iterator<Item = Aabb>>(boxes: &impl Fn() -> B) -> Option<Aabb> {
    let every = boxes().count().div_ceil(SAMPLES).max(1);
    let sample: Vec<Aabb> = boxes().step_by(every).collect();
    let half = sample.len().div_ceil(2);
    let centres = Aabb::around(sample.iter().map(Aabb::centre));
    let mut axes = [0, 1, 2];
    axes.sort_by(|&a, &b| centres.size()[b].total_cmp(&centres.size()[a]));
    // Along each axis the shortest interval with the centres of half of them, the longest axis first: what that
    // leaves out does not count along the others.
    let (mut crowd, mut left) = (centres, sample.clone());
    for axis in axes {
        left.sort_by(|a, b| a.centre()[axis].total_cmp(&b.centre()[axis]));
        let length = |w: &[Aabb]| w[w.len() - 1].centre()[axis] - w[0].centre()[axis];
        let shortest = left
            .windows(half.max(1))
            .min_by(|v, w| length(v).total_cmp(&length(w)))?;
        let (low, high) = (
            shortest[0].centre()[axis],
            shortest[half - 1].centre()[axis],
        );
        (crowd.min[axis], crowd.max[axis]) = (low, high);
        left.retain(|b| (low..=high).contains(&b.centre()[axis]));
    }
    // With all that lies beside it, and beside that.
    let mut count = 0;
    loop {
        let margin = BESIDE * crowd.size().max_element();
        let (low, high) = (crowd.min - margin, crowd.max + margin);
        let is_beside = |b: &&Aabb| b.centre().cmpge(low).all() && b.centre().cmple(high).all();
        let beside: Vec<&Aabb> = sample.iter().filter(is_beside).collect();
        if beside.len() <= count {
            return (count >= half).then_some(crowd);
        }
        count = beside.len();
        crowd = beside.into_iter().fold(crowd, |all, b| all.union(*b));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cubes(at: &[(f64, f64)]) -> Vec<Aabb> {
        let cube = |&(x, size): &(f64, f64)| Aabb {
            min: DVec3::new(x, 0.0, 0.0),
            max: DVec3::new(x + size, size, size),
        };
        at.iter().map(cube).collect()
    }

    fn reach(at: &[(f64, f64)]) -> f64 {
        let boxes = cubes(at);
        let bounds = boxes.iter().copied().fold(Aabb::EMPTY, Aabb::union);
        LocalFrame::of(&bounds, || boxes.iter().copied()).reach()
    }

    #[test]
    fn what_is_far_away_takes_no_digits() {
        let town = [(5e5, 10.0), (5e5 + 20.0, 10.0), (5e5 + 40.0, 10.0)];
        assert_eq!(reach(&town), 25.0);
        assert_eq!(reach(&[town[0], town[1], town[2], (0.0, 1.0)]), 25.0);
        // As many far as near.
        let twins = [town[0], town[1], (0.0, 1.0), (1.0, 1.0)];
        assert!(reach(&twins) < 20.0, "{}", reach(&twins));
    }

    #[test]
    fn a_plain_takes_no_digits() {
        let rooms = [(0.0, 1.0), (1.0, 1.0), (2.0, 1.0)];
        let on_a_plain = [rooms[0], rooms[1], rooms[2], (-1e4, 2e4)];
        assert_eq!(reach(&on_a_plain), 1.5);
        assert_eq!(reach(&rooms), 1.5);
        let frame = LocalFrame::around(&cubes(&[(0.0, 3.0)])[0]);
        let is_large = |of: (f64, f64)| frame.is_large(&cubes(&[of])[0]);
        assert!(is_large((-1e4, 2e4)) && is_large((10.0, 1e4)));
        assert!(!is_large((0.0, 3.0)) && !is_large((1e4, 10.0)));
    }
}
