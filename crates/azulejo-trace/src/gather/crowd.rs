//! Direct light of many lamps, averaged over a surface.
//!
//! At a few places formulas say what every lamp, and every image of one in a mirror, would give if
//! nothing stood between. What does stand between is found by shadow rays from places all over
//! the surface to lamps chosen in proportion to that: one ray a place, in five dimensions. As at
//! single points the share that is visible serves as a control variate, so that a surface that
//! sees all or nothing of the lamps has no error but that of the few places.

use super::direct::{Direct, Picked, aim, is_hidden};
use super::{DirectLight, GatherPoint, REPLICATES};
use crate::lambert::{ArrayPolygon, clip, clip_to_window, point_to_polygon};
use crate::sampling::{hash, seeds, sobol};
use azulejo_scene::Rgb;
use std::f64::consts::PI;

/// A lamp, or the image of one in a window.
#[derive(Clone, Copy)]
struct Source {
    lamp: usize,
    window: Option<usize>,
}

/// Places on a surface: as many for each replicate, one replicate after the other.
pub struct Places<'p> {
    /// Where formulas are evaluated.
    pub formulas: &'p [GatherPoint],
    /// Where shadow rays begin.
    pub rays: &'p [GatherPoint],
    /// How many shadow rays of each replicate's sequence came before these.
    pub before: u32,
}

impl Direct<'_> {
    /// Mean direct light over a surface, one estimate per replicate.
    pub(super) fn over(&mut self, places: &Places, seed: u32) -> DirectLight {
        let sources = self.sources();
        let (known, chances) = self.known(&sources, places.formulas);
        let mut light = DirectLight::default();
        let Some(&whole) = chances.last().filter(|&&whole| whole > 0.0) else {
            return light;
        };
        self.forget();
        let mut values = Vec::with_capacity(places.rays.len());
        let each = places.rays.len() / REPLICATES;
        for (place, point) in places.rays.iter().enumerate() {
            let (r, k) = (place / each, places.before + (place % each) as u32);
            let [s1, s2, s3, ..] = seeds(&[hash(&[seed, r as u32]), 0xc0]);
            let [c, u1, u2] = [(2, s1), (3, s2), (4, s3)].map(|(d, s)| f64::from(sobol(k, d, s)));
            let chosen = chances.partition_point(|&sum| sum <= c * whole);
            let chosen = chosen.min(sources.len() - 1);
            let before = chosen.checked_sub(1).map_or(0.0, |k| chances[k]);
            let probability = (chances[chosen] - before) / whole;
            let tag = values.len() as u32;
            if let Some(weight) = self.aim_at(&sources[chosen], point, tag, r as u32, (u1, u2)) {
                let radiance = self.radiance(&sources[chosen]);
                values.push(radiance * (weight / (probability * each as f64)));
            }
        }
        let mut sums = Picked::default();
        self.ask(|test, is_free| {
            sums.add(
                test.replicate as usize,
                (values[test.term as usize], false),
                is_free,
            )
        });
        light.lamps.replicates = std::array::from_fn(|r| sums.irradiance(r, known[r]));
        light
    }

    fn sources(&self) -> Vec<Source> {
        let windows = 0..self.emitters.windows.len();
        let windows = std::iter::once(None).chain(windows.map(Some));
        let lamps = 0..self.emitters.lamps.len();
        windows
            .flat_map(|window| lamps.clone().map(move |lamp| Source { lamp, window }))
            .collect()
    }

    fn radiance(&self, source: &Source) -> Rgb {
        let radiance = self.emitters.lamps[source.lamp].radiance;
        match source.window {
            None => radiance,
            Some(w) => radiance * self.emitters.windows[w].reflectance,
        }
    }

    /// Irradiance per replicate if nothing stood between, and for each source the sum of the
    /// chances up to it.
    fn known(&self, sources: &[Source], places: &[GatherPoint]) -> ([Rgb; REPLICATES], Vec<f64>) {
        let each = places.len() / REPLICATES;
        let (mut known, mut chances) =
            ([Rgb::BLACK; REPLICATES], Vec::with_capacity(sources.len()));
        let mut sum = 0.0;
        for source in sources {
            let radiance = self.radiance(source);
            for (place, point) in places.iter().enumerate() {
                let full = radiance * (PI * self.form_factor(source, point) / each as f64);
                known[place / each] += full;
                sum += full.max_channel();
            }
            chances.push(sum);
        }
        (known, chances)
    }

    /// Form factor from a point to a source, if nothing stood between.
    fn form_factor(&self, source: &Source, point: &GatherPoint) -> f64 {
        let (p, n) = (point.position, point.normal);
        match source.window {
            None => point_to_polygon(p, n, &self.emitters.lamps[source.lamp].polygon),
            Some(w) => {
                let window = &self.emitters.windows[w];
                match is_hidden(point, &window.images[source.lamp], &window.polygon) {
                    true => 0.0,
                    false => point_to_polygon(p, n, &self.seen(source.lamp, w, point)),
                }
            }
        }
    }

    /// What of a lamp's image the window shows.
    fn seen(&self, lamp: usize, window: usize, point: &GatherPoint) -> ArrayPolygon {
        let window = &self.emitters.windows[window];
        let side = (point.position - window.polygon[0]).dot(window.normal);
        // Only what of the lamp is on the point's side of the mirror has an image there, and that
        // image lies on the other side.
        let away = -side.signum() * window.normal;
        let beyond = clip(&window.images[lamp], window.polygon[0], away);
        clip_to_window(&beyond, point.position, &window.polygon)
    }

    /// Plans a shadow test toward a point of a source; its weight, kernel over density.
    fn aim_at(
        &mut self,
        source: &Source,
        point: &GatherPoint,
        tag: u32,
        replicate: u32,
        u: (f64, f64),
    ) -> Option<f64> {
        let from = self.surfaces.tracer.leaving(point.position, point.normal);
        let emitters = self.emitters;
        let first = self.planned();
        let weight = match source.window {
            None => {
                let polygon = &emitters.lamps[source.lamp].polygon;
                let (y, weight) = aim(point, polygon, u)?;
                self.push_segment(from, self.in_front(y, polygon));
                weight
            }
            Some(w) => {
                let window = &emitters.windows[w];
                if is_hidden(point, &window.images[source.lamp], &window.polygon) {
                    return None;
                }
                let seen = self.seen(source.lamp, w, point);
                if seen.len() < 3 {
                    return None;
                }
                let (y, weight) = aim(point, &seen, u)?;
                self.push_reflected(from, self.in_front(y, &seen), w as u32);
                weight
            }
        };
        self.keep(first, tag, replicate, weight)
    }
}
