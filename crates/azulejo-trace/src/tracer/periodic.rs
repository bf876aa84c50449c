//! Scenes that repeat themselves without end: a ray that leaves the cell goes on in the next one.

use super::Tracer;
use crate::frame::{double, single};
use crate::kernel::{KernelHit, KernelRay};
use azulejo_scene::math::Ray;
use glam::DVec3;
use std::fmt;

/// Cells after which a ray that met nothing counts as one that leaves the scene. Of the light of a
/// wall of height h, about h / (20,000 period) goes farther.
const MOST_CELLS: u32 = 1 << 14;

/// How far the parts of a ray in two neighbouring cells overlap across the plane where they meet, relative to
/// the scene's size: a few times the rounding of `f32`, so that no ray slips through.
const OVERLAP: f64 = 1e-6;

/// The same along the ray, at most.
const LONGEST_OVERLAP: f64 = 4.0;

/// A scene may be larger than its period by this share of it: the rounding of files.
const SLACK: f64 = 1e-5;

/// The cell of a scene that repeats itself, in the kernel's coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PeriodicCell {
    centre: DVec3,
    /// Edge lengths; infinite along axes without repetition.
    period: DVec3,
    /// Half the size of the scene.
    half: DVec3,
    /// The same in world units, zero along axes without repetition.
    world: DVec3,
}

/// A period that a scene cannot have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PeriodError {
    /// Not a positive number, or zero for none.
    NotALength {
        /// The axis: 0, 1 or 2.
        axis: usize,
        /// What was given.
        period: f64,
    },
    /// The scene is larger than the period: its copies would overlap.
    TooShort {
        /// The axis: 0, 1 or 2.
        axis: usize,
        /// What was given.
        period: f64,
        /// The extent of the scene.
        size: f64,
    },
}

impl fmt::Display for PeriodError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let name = |axis: usize| ["x", "y", "z"][axis.min(2)];
        match *self {
            PeriodError::NotALength { axis, period } => {
                let axis = name(axis);
                write!(
                    f,
                    "the period along {axis} is {period}; expected a length above 0"
                )
            }
            PeriodError::TooShort { axis, period, size } => {
                let axis = name(axis);
                write!(
                    f,
                    "the period along {axis} is {period}, but the model is {size} long there: its \
                     copies would overlap"
                )
            }
        }
    }
}

impl std::error::Error for PeriodError {}

impl Tracer {
    /// The tracer of the scene repeated without end: copies of it stand side by side along the axes
    /// whose `period`, in world units, is not zero. What a ray hits in a copy is reported as an item
    /// of the scene itself; only [`KernelHit::t`] counts from where the ray began. A ray that meets
    /// nothing in 16,384 cells leaves the scene.
    ///
    /// # Errors
    /// A period that is negative, not finite, or shorter than the scene.
    pub fn repeated(mut self, period: DVec3) -> Result<Tracer, PeriodError> {
        let size = self.bounds.size();
        for axis in 0..3 {
            let (period, size) = (period[axis], size[axis]);
            if !(period.is_finite() && period >= 0.0) {
                return Err(PeriodError::NotALength { axis, period });
            }
            if period > 0.0 && size > period * (1.0 + SLACK) {
                return Err(PeriodError::TooShort { axis, period, size });
            }
        }
        self.set_period(period);
        Ok(self)
    }

    /// The same with the period of `other`, the tracer of a scene of the same extent.
    pub fn repeated_as(mut self, other: &Tracer) -> Tracer {
        self.set_period(other.period());
        self
    }

    fn set_period(&mut self, period: DVec3) {
        let is_repeated = period.cmpgt(DVec3::ZERO);
        let endless = DVec3::splat(f64::INFINITY);
        self.cell = (is_repeated.any() && !self.bounds.is_empty()).then(|| PeriodicCell {
            centre: self.frame.point(self.bounds.centre()),
            period: DVec3::select(is_repeated, self.frame.vector(period), endless),
            half: 0.5 * self.frame.vector(self.bounds.size()),
            world: period,
        });
    }

    /// The period along each axis, in world units; zero where the scene does not repeat itself.
    pub fn period(&self) -> DVec3 {
        self.cell.map_or(DVec3::ZERO, |cell| cell.world)
    }

    /// Whether the scene repeats itself along any axis.
    pub fn is_repeated(&self) -> bool {
        self.cell.is_some()
    }

    /// The first hit of each ray in any cell.
    pub(super) fn closest_in_cells(
        &self,
        cell: &PeriodicCell,
        rays: &[KernelRay],
        hits: &mut [KernelHit],
    ) {
        cell.walk(
            rays,
            |parts, part_hits| self.own_closest(parts, part_hits),
            |ray, hit| hits[ray] = hit,
        );
    }

    /// Whether each ray hits anything in any cell.
    pub(super) fn any_in_cells(
        &self,
        cell: &PeriodicCell,
        rays: &[KernelRay],
        blocked: &mut [bool],
    ) {
        blocked.fill(false);
        cell.walk(
            rays,
            |parts, part_hits| self.own_closest(parts, part_hits),
            |ray, _| blocked[ray] = true,
        );
    }

    /// A ray moved by whole periods, so that its point at `t` lies in the scene itself.
    pub(super) fn in_own_cell(&self, ray: &Ray, t: f64) -> Ray {
        let Some(cell) = &self.cell else {
            return *ray;
        };
        let at = self.frame.point(ray.at(t));
        let cells = ((at - cell.centre) / cell.period).round();
        Ray {
            origin: ray.origin - cells * cell.world,
            ..*ray
        }
    }
}

/// A ray on its way through the cells.
#[derive(Clone, Copy)]
struct CellWalk {
    ray: usize,
    origin: DVec3,
    direction: DVec3,
    /// The cell where it is; whole numbers, in which `f64` is exact.
    cell: DVec3,
    /// Where it entered that cell.
    t: f64,
    /// How far its part in this cell reaches back into the one before.
    overlap: f64,
    t_max: f64,
}

/// CellPart of a ray in one cell: it begins at `from` of the whole one.
#[derive(Clone, Copy)]
struct CellPart {
    walk: CellWalk,
    from: f64,
    /// Where the cell ends, and the axis along which the next one lies.
    end: (f64, usize),
}

impl PeriodicCell {
    /// Follows rays from cell to cell, all at the same time; `closest` traces what lies in one cell,
    /// `on_hit` gets the first hit of each ray that has one.
    fn walk(
        &self,
        rays: &[KernelRay],
        mut closest: impl FnMut(&[KernelRay], &mut [KernelHit]),
        mut on_hit: impl FnMut(usize, KernelHit),
    ) {
        let mut walks: Vec<CellWalk> = (0..rays.len())
            .filter_map(|k| self.start(k, &rays[k]))
            .collect();
        let (mut parts, mut pieces, mut hits) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..MOST_CELLS {
            parts.clear();
            pieces.clear();
            for walk in &walks {
                if let Some((part, piece)) = self.part(walk, &rays[walk.ray]) {
                    parts.push(part);
                    pieces.push(piece);
                }
            }
            if parts.is_empty() {
                return;
            }
            hits.clear();
            hits.resize(pieces.len(), KernelHit::NOTHING);
            closest(&pieces, &mut hits);
            walks.clear();
            for ((part, piece), mut hit) in parts.iter().zip(&mut pieces).zip(hits.iter().copied())
            {
                let least = rays[part.walk.ray].t_min;
                while hit.is_hit() {
                    let t = (part.from + f64::from(hit.t)) as f32;
                    if t >= least {
                        let mut ray_hit = hit;
                        ray_hit.t = t;
                        on_hit(part.walk.ray, ray_hit);
                        break;
                    }
                    // The overlap of cells begins before the ray does.
                    *piece = piece.behind(&hit);
                    let mut next = [KernelHit::NOTHING];
                    closest(&[*piece], &mut next);
                    hit = next[0];
                }
                if !hit.is_hit() {
                    walks.extend(self.next(part));
                }
            }
        }
    }

    /// A ray in its first cell; `None` if it hits nothing whatever there is.
    fn start(&self, ray: usize, given: &KernelRay) -> Option<CellWalk> {
        let (origin, direction) = (double(given.origin), double(given.direction));
        let t = f64::from(given.t_min).max(0.0);
        let length = direction.length();
        let at = origin + t * direction;
        let is_valid = length > 1e-25 && length.is_finite() && at.is_finite();
        let cell = ((at - self.centre) / self.period).round();
        (is_valid && cell.abs().max_element() < 1e9).then(|| CellWalk {
            ray,
            origin,
            direction,
            cell,
            t,
            overlap: 0.0,
            t_max: f64::from(given.t_max),
        })
    }

    /// What of a ray lies in its cell; `None` if nothing of the scene can lie ahead of it.
    fn part(&self, walk: &CellWalk, given: &KernelRay) -> Option<(CellPart, KernelRay)> {
        if walk.t - walk.overlap >= walk.t_max || self.is_past(walk) {
            return None;
        }
        let end = self.end(walk);
        let to = (end.0 + self.overlap(walk, end.1)).min(walk.t_max);
        let shift = self.shift(walk.cell);
        let is_first = walk.t <= f64::from(given.t_min).max(0.0);
        let (from, t_min) = if is_first {
            (0.0, given.t_min)
        } else {
            (walk.t - walk.overlap, 0.0)
        };
        let piece = KernelRay {
            origin: single(walk.origin + from * walk.direction - shift),
            t_min,
            t_max: (to - from) as f32,
            ..*given
        };
        let part = CellPart {
            walk: *walk,
            from,
            end,
        };
        Some((part, piece))
    }

    /// Where a ray leaves its cell, and along which axis.
    fn end(&self, walk: &CellWalk) -> (f64, usize) {
        let wall =
            self.centre + self.shift(walk.cell) + 0.5 * self.period * walk.direction.signum();
        let exits = (wall - walk.origin) / walk.direction;
        let exit = |axis: usize| {
            let is_crossed = self.period[axis].is_finite() && walk.direction[axis] != 0.0;
            if is_crossed {
                exits[axis].max(walk.t)
            } else {
                f64::INFINITY
            }
        };
        let nearest = |a: (f64, usize), axis: usize| {
            if exit(axis) < a.0 {
                (exit(axis), axis)
            } else {
                a
            }
        };
        (0..3).fold((f64::INFINITY, 0), nearest)
    }

    /// The same ray in the next cell; `None` where there is none.
    fn next(&self, part: &CellPart) -> Option<CellWalk> {
        let (t, axis) = part.end;
        let mut walk = part.walk;
        if !t.is_finite() {
            return None;
        }
        walk.cell[axis] += walk.direction[axis].signum();
        walk.t = t;
        walk.overlap = self.overlap(&walk, axis);
        Some(walk)
    }

    /// Whether a ray has passed the whole scene along an axis without repetition.
    fn is_past(&self, walk: &CellWalk) -> bool {
        let at = walk.origin + (walk.t - walk.overlap).max(0.0) * walk.direction;
        (0..3).any(|axis| {
            let (ahead, way) = (at[axis] - self.centre[axis], walk.direction[axis]);
            let half = self.half[axis] + OVERLAP * self.size();
            let is_beyond = (ahead > half && way >= 0.0) || (ahead < -half && way <= 0.0);
            self.period[axis].is_infinite() && is_beyond
        })
    }

    /// Half the largest extent of the scene, at least 1.
    fn size(&self) -> f64 {
        self.half.max_element().max(1.0)
    }

    /// How far parts of a ray overlap beside a plane across an axis, in units of `t`.
    fn overlap(&self, walk: &CellWalk, axis: usize) -> f64 {
        let across = OVERLAP / walk.direction[axis].abs();
        self.size() * across.min(LONGEST_OVERLAP / walk.direction.length())
    }

    /// The place of a cell relative to the scene itself.
    fn shift(&self, cells: DVec3) -> DVec3 {
        DVec3::select(
            self.period.is_finite_mask(),
            cells * self.period,
            DVec3::ZERO,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{Material, Object, Primitive, PrimitiveKind, Rgb, Scene, Shape};
    use glam::DAffine3;

    /// A block on the middle of a square of ground of four units, as one scene and as rows of copies.
    fn block(copies: i32) -> Scene {
        let mut scene = Scene::default();
        let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
        for (i, j) in (-copies..=copies).flat_map(|i| (-copies..=copies).map(move |j| (i, j))) {
            let at = 4.0 * DVec3::new(f64::from(i), f64::from(j), 0.0);
            let ground = Primitive::parallelogram(
                at - DVec3::new(2.0, 2.0, 0.0),
                4.0 * DVec3::X,
                4.0 * DVec3::Y,
                grey,
            );
            let map = DAffine3::from_translation(at - DVec3::new(0.5, 0.5, 0.0));
            let cube = Primitive::new(PrimitiveKind::Cuboid, map, grey);
            for shape in [ground, cube] {
                scene.objects.push(Object::new("", Shape::Primitive(shape)));
            }
        }
        scene
    }

    /// Rays from all over the cell, flat and steep ones.
    fn rays() -> impl Iterator<Item = Ray> {
        (0..4_000u32).map(|k| {
            let at = |dimension| f64::from(crate::sampling::uniform(&[k, dimension]));
            let origin = DVec3::new(4.0 * at(0) - 2.0, 4.0 * at(1) - 2.0, 1.5 * at(2) + 1e-3);
            let (turn, rise) = (6.3 * at(3), at(4) - 0.6);
            Ray::new(origin, DVec3::new(turn.cos(), turn.sin(), rise).normalize())
        })
    }

    #[test]
    fn a_cell_stands_for_all_its_copies() {
        let period = DVec3::new(4.0, 4.0, 0.0);
        let cell = Tracer::new(&block(0)).repeated(period).unwrap();
        let copies = Tracer::new(&block(12));
        let (mut met, mut far) = (0, 0);
        for ray in rays() {
            let (one, all) = (cell.hit(&ray), copies.hit(&ray));
            // Copies end after 48 units.
            if all.is_none_or(|hit| hit.position.truncate().abs().max_element() > 48.0) {
                continue;
            }
            let (one, all) = (one.unwrap(), all.unwrap());
            assert!(
                (one.t - all.t).abs() < 1e-5 * (1.0 + all.t),
                "{one:?} {all:?}"
            );
            assert!((one.normal - all.normal).length() < 1e-9, "{one:?} {all:?}");
            let away = (all.position - one.position) / 4.0;
            assert!((away - away.round()).length() < 1e-5, "{one:?} {all:?}");
            assert!(
                one.position.truncate().abs().max_element() < 2.0 + 1e-5,
                "{one:?}"
            );
            assert!(cell.occluded(&ray));
            let short = Ray {
                t_max: 0.999 * all.t,
                ..ray
            };
            assert!(!cell.occluded(&short), "{short:?}");
            met += 1;
            far += usize::from(away.length() > 1.5);
        }
        assert!(met > 2_000 && far > 200, "{met} {far}");
    }

    #[test]
    fn what_leaves_upwards_or_runs_along_a_street_ends() {
        let cell = Tracer::new(&block(0))
            .repeated(DVec3::new(4.0, 4.0, 0.0))
            .unwrap();
        let along = Ray::new(DVec3::new(1.5, 0.0, 0.5), DVec3::Y);
        assert_eq!(cell.hit(&along), None);
        let up = Ray::new(DVec3::new(1.5, 0.0, 0.5), DVec3::new(0.6, 0.0, 0.8));
        assert!(!cell.occluded(&up));
    }

    /// Rays from the ground beside a wall where cells meet, steep ones too, hit its front.
    #[test]
    fn walls_between_cells_are_tight() {
        let mut scene = Scene::default();
        let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
        for (at, a, b) in [
            (DVec3::ZERO, 3.0 * DVec3::X, 3.0 * DVec3::Y),
            (3.0 * DVec3::X, 3.0 * DVec3::Y, 1.5 * DVec3::Z),
        ] {
            let face = Primitive::parallelogram(at, a, b, grey);
            scene.objects.push(Object::new("", Shape::Primitive(face)));
        }
        let cell = Tracer::new(&scene);
        let cell = cell.repeated(DVec3::new(3.0, 3.0, 0.0)).unwrap();
        for k in 0..100_000u32 {
            let at = |dimension| f64::from(crate::sampling::uniform(&[k, dimension]));
            let slope = 0.1 * at(0).powi(4) + 1e-6;
            let away = 1.4 * at(1) * slope;
            let origin = DVec3::new(away, 3.0 * at(2), 1e-5);
            let ray = Ray::new(origin, DVec3::new(-slope, slope * at(3), 1.0).normalize());
            let hit = cell.hit(&ray);
            assert!(hit.is_some_and(|hit| hit.entering), "{ray:?} {hit:?}");
        }
    }

    #[test]
    fn wrong_periods_are_refused() {
        let refused = |period: DVec3| {
            Tracer::new(&block(0))
                .repeated(period)
                .unwrap_err()
                .to_string()
        };
        let short = refused(DVec3::new(3.9, 4.0, 0.0));
        assert_eq!(
            short,
            "the period along x is 3.9, but the model is 4 long there: its copies would overlap"
        );
        let negative = refused(DVec3::new(0.0, -4.0, 0.0));
        assert_eq!(
            negative,
            "the period along y is -4; expected a length above 0"
        );
        assert!(refused(DVec3::new(4.0, 4.0, f64::NAN)).contains("along z is NaN"));
    }
}
