//! The sky, and the plain between it and the street.

use crate::MaterialId;
use crate::synthetic::sheets::{Sheets, raised};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// A vault of rings of `around` trapezoids between parallels of a sphere, and a flat field at the
/// top, a star of lozenges around the zenith.
///
/// Lozenge k has `sides[k]` × `sides[k + 1]` cells.
pub(super) struct Dome {
    sides: Vec<usize>,
    rings: usize,
}

const RADIUS: f64 = 100.0;

impl Dome {
    /// In full detail 23 rings of 90 and a field of 337 cells: 2,407 in all.
    pub(super) fn new(detail: f64) -> Dome {
        let of = |n: usize| ((n as f64 * detail).round() as usize).max(1);
        Dome {
            sides: [8, 8, 7, 7, 8, 7].map(of).to_vec(),
            rings: of(23).max(2),
        }
    }

    fn side(&self, k: usize) -> usize {
        self.sides[k % self.sides.len()]
    }

    fn around(&self) -> usize {
        2 * self.sides.iter().sum::<usize>()
    }

    fn top_cells(&self) -> usize {
        (0..self.sides.len())
            .map(|k| self.side(k) * self.side(k + 1))
            .sum()
    }

    /// Sine of the altitude at which the flat field begins, so that its cells are as large as
    /// those of the rings: (1 − s²) / field = 2 s / rings.
    fn top_sine(&self) -> f64 {
        let half = self.top_cells() as f64 / (self.rings * self.around()) as f64;
        (half * half + 1.0).sqrt() - half
    }

    /// The direction of a step around the dome; full turns give bit-identical directions.
    fn direction(&self, step: f64) -> DVec2 {
        let n = self.around() as f64;
        DVec2::from_angle(TAU * step.rem_euclid(n) / n)
    }

    /// Adds the sky, fronts inside.
    pub(super) fn add_sky(&self, sheets: &mut Sheets, sky: MaterialId, sun: MaterialId) {
        let sine = self.top_sine();
        let parallel = |k: usize| -> Vec<DVec3> {
            let s = sine * k as f64 / self.rings as f64;
            let radius = RADIUS * (1.0 - s * s).sqrt();
            let around = 0..=self.around();
            around
                .map(|i| (radius * self.direction(i as f64)).extend(RADIUS * s))
                .collect()
        };
        let rows: Vec<_> = (0..=self.rings).rev().map(parallel).collect();
        // Ten patches in the south-west at about half the height of the rings: 2 rows of 5.
        let (row, column) = (self.rings / 3, self.around() * 5 / 9);
        let is_sun =
            |i: usize, j: usize| (row..row + 2).contains(&j) && (column..column + 5).contains(&i);
        sheets.sheet(&rows, |i, j| Some(if is_sun(i, j) { sun } else { sky }));
        self.add_top(sheets, sky);
    }

    /// Adds the flat field inside the highest parallel.
    fn add_top(&self, sheets: &mut Sheets, sky: MaterialId) {
        let mut first = 0;
        for k in 0..self.sides.len() {
            let size = [self.side(k), self.side(k + 1)];
            let row = |j| {
                (0..=size[0])
                    .map(|i| self.in_lozenge([i, j], size, first))
                    .collect()
            };
            // Counter-clockwise rows would have their front above; from the last row to the first
            // it is below.
            let rows: Vec<Vec<DVec3>> = (0..=size[1]).rev().map(row).collect();
            sheets.sheet(&rows, |_, _| Some(sky));
            first += size[0] + size[1];
        }
    }

    /// The point (i, j) of a lozenge of a × b cells whose two outer sides are the steps from
    /// `first` around the field; (0, 0) is the zenith.
    ///
    /// Shirley and Chiu's map of a square to a disk (1997), which keeps areas: the larger of i/a
    /// and j/b selects the circle, and the other number the position on it.
    fn in_lozenge(&self, [i, j]: [usize; 2], [a, b]: [usize; 2], first: usize) -> DVec3 {
        let ratio = |p: usize, q: usize| p as f64 / q.max(1) as f64;
        let (circle, step) = if i * b >= j * a {
            (ratio(i, a), ratio(j * a, i))
        } else {
            (ratio(j, b), (a + b) as f64 - ratio(i * b, j))
        };
        let sine = self.top_sine();
        let radius = RADIUS * (1.0 - sine * sine).sqrt();
        (radius * circle * self.direction(first as f64 + step)).extend(RADIUS * sine)
    }

    /// Adds the plain between a border, counter-clockwise from the right, and the horizon.
    pub(super) fn add_plain(&self, sheets: &mut Sheets, border: &[DVec2], material: MaterialId) {
        let horizon = self.around();
        let mut rows = vec![border.to_vec()];
        while rows[rows.len() - 1].len() > horizon {
            let inner = &rows[rows.len() - 1];
            rows.push(thinned(inner, horizon));
        }
        let last = rows.len() - 1;
        for (k, row) in rows.iter_mut().enumerate().skip(1) {
            let t = k as f64 / last as f64;
            row.iter_mut()
                .for_each(|p| *p = p.lerp(RADIUS * p.normalize(), t));
        }
        rows[last] = (0..horizon)
            .map(|k| RADIUS * self.direction(k as f64))
            .collect();
        let pairs = rows.windows(2);
        pairs.for_each(|pair| add_ring(sheets, &pair[0], &pair[1], material));
    }
}

/// About a third of the points, spread evenly, but at least `least`; the number left out is even.
fn thinned(ring: &[DVec2], least: usize) -> Vec<DVec2> {
    let third = ring.len().div_ceil(3);
    let n = (third + (ring.len() - third) % 2).max(least);
    let mut at = 0;
    let starts = steps_inside(ring.len(), n).map(|inside| {
        at += inside;
        ring[at - inside]
    });
    starts.collect()
}

/// The number of steps of the inner ring, 1 or 3, within each of `outer` steps of the outer ring.
fn steps_inside(inner: usize, outer: usize) -> impl Iterator<Item = usize> {
    let threes = (inner - outer) / 2;
    (0..outer).map(move |k| 1 + 2 * ((k + 1) * threes / outer - k * threes / outer))
}

/// Adds quadrilaterals between two rings on the ground, fronts up: one where an inner step
/// corresponds to one outer step, four where it corresponds to three.
fn add_ring(sheets: &mut Sheets, inner: &[DVec2], outer: &[DVec2], material: MaterialId) {
    let (inner, outer) = (raised(inner, 0.0), raised(outer, 0.0));
    let near = |k: usize| inner[k % inner.len()];
    let mut start = 0;
    for (k, inside) in steps_inside(inner.len(), outer.len()).enumerate() {
        let (a, b) = (outer[k], outer[(k + 1) % outer.len()]);
        let p = [0, 1, 2, 3].map(|i: usize| near(start + i));
        start += inside;
        if inside == 1 {
            sheets.face(&[p[0], a, b, p[1]], material);
            continue;
        }
        let [q, r] = [(p[1], 1.0), (p[2], 2.0)].map(|(p, i)| (p + a + (b - a) * (i / 3.0)) / 2.0);
        sheets.face(&[p[0], a, q, p[1]], material);
        sheets.face(&[p[1], q, r, p[2]], material);
        sheets.face(&[p[2], r, b, p[3]], material);
        sheets.face(&[a, b, r, q], material);
    }
}
