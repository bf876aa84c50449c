//! The terms of the direct light of a point: each source with what it would give if nothing stood
//! between.

use super::direct::Direct;
use super::light_clusters::LightClusters;
use super::polygon::{is_hidden, is_through};
use super::{GatherPoint, REPLICATES};
use crate::lambert::{ArrayPolygon, clip, clip_to_window, point_to_polygon};
use crate::lights::{SunDisc, side_toward, unoccluded, unoccluded_image};
use azulejo_scene::Rgb;
use azulejo_scene::math::reflect;
use glam::DVec3;
use std::f64::consts::PI;

/// A source of direct light at one point.
pub(super) struct Term {
    /// Index of the point.
    pub point: u32,
    /// Irradiance if nothing stood between; an estimate for curved emitters.
    pub full: Rgb,
    /// Radiance of the lamp as it arrives; black for lights without area.
    pub radiance: Rgb,
    pub target: Target,
    is_rough: bool,
}

/// What samples found of a term.
#[derive(Clone, Default)]
pub(super) struct TermTests {
    /// Sums of weights, and of the parts of them that arrive, per replicate.
    pub weights: [f64; REPLICATES],
    pub visible: [Rgb; REPLICATES],
    /// Samples per replicate, those without weight included.
    pub samples: u32,
}

/// What of a source a point sees if nothing stands between.
pub(super) enum Target {
    /// A flat emitter, by its number, or what of it is above the horizon.
    Flat(u32),
    /// The part of a flat emitter's image that a window shows.
    Image {
        window: u32,
        seen: Box<ArrayPolygon>,
    },
    /// A curved emitter, by its number: no formula exists for what it gives.
    Curved(u32),
    /// A light without area, at which a shadow ray ends here.
    Delta(DVec3),
    /// A light without area in a window, whose image is here.
    DeltaImage { window: u32, image: DVec3 },
    /// A sun, by its number.
    Sun(u32),
    /// A sun in a window.
    SunImage { window: u32, sun: u32 },
}

/// A flat emitter, or its image in a window, by their numbers.
#[derive(Clone, Copy)]
pub(super) struct FlatSource {
    pub lamp: usize,
    pub window: Option<usize>,
}

impl Term {
    fn new(point: u32, full: Rgb, radiance: Rgb, target: Target) -> Term {
        Term {
            point,
            full,
            radiance,
            is_rough: matches!(target, Target::Curved(_)),
            target,
        }
    }

    /// A term chosen of so many that the sum of all is not known.
    pub fn of_many(full: Rgb, radiance: Rgb, target: Target) -> Term {
        Term {
            is_rough: true,
            ..Term::new(0, full, radiance, target)
        }
    }

    /// Whether `full` is an estimate, or one of a sum that is not known.
    pub fn is_rough(&self) -> bool {
        self.is_rough
    }

    /// Whether its light comes from infinitely far away, from a disc.
    pub fn is_sun(&self) -> bool {
        matches!(self.target, Target::Sun(_) | Target::SunImage { .. })
    }

    /// Whether it is a light without area, which one ray decides.
    pub fn is_delta(&self) -> bool {
        matches!(self.target, Target::Delta(_) | Target::DeltaImage { .. })
    }

    /// Irradiance from one sample of the given weight.
    pub fn unbiased(&self, weight: f64) -> Rgb {
        if self.is_delta() {
            self.full
        } else {
            self.radiance * weight
        }
    }

    /// The visible share as replicate `r` of its tests sees it.
    ///
    /// Formulas know the sum of all weights, so what the other half of the replicates found to
    /// be the visible share serves as a control variate: unbiased, because it is independent of
    /// this half, and exact where all or nothing is visible.
    pub fn visible_share(&self, tests: &TermTests, r: usize) -> Rgb {
        let TermTests {
            weights,
            visible,
            samples,
        } = tests;
        if self.is_delta() {
            return if weights[0] > 0.0 {
                visible[0] / weights[0]
            } else {
                Rgb::BLACK
            };
        }
        let share = ratio_of_others(visible, weights, r);
        let sum = f64::from(*samples) * self.full.max_channel() / self.radiance.max_channel();
        share + (visible[r] - share * weights[r]) / sum
    }
}

/// Σ parts / Σ wholes over the half of the replicates that `r` is not in; 1 without wholes.
pub(super) fn ratio_of_others(
    parts: &[Rgb; REPLICATES],
    wholes: &[f64; REPLICATES],
    r: usize,
) -> Rgb {
    let others = (0..REPLICATES).filter(|s| s / 2 != r / 2);
    let part: Rgb = others.clone().map(|s| parts[s]).sum();
    let whole: f64 = others.map(|s| wholes[s]).sum();
    if whole > 0.0 {
        part / whole
    } else {
        Rgb::WHITE
    }
}

/// The term of a sun whose centre is seen in the unit direction `toward`; `None` if it is below the
/// horizon. At the horizon what of it is above is left to samples.
fn sun_term(
    index: u32,
    point: &GatherPoint,
    sun: &SunDisc,
    toward: DVec3,
    share: Rgb,
    target: Target,
) -> Option<Term> {
    let cos = toward.dot(point.normal);
    // The sine of its height is the cosine to the normal.
    let is_whole = cos >= sun.sine();
    let full = sun.irradiance * share * if is_whole { cos } else { sun.sine() };
    // A window may show a part of an image, and no formula says which.
    let is_image = matches!(target, Target::SunImage { .. });
    (cos > -sun.sine() && full.max_channel() > 0.0).then(|| Term {
        is_rough: is_image || !is_whole,
        ..Term::new(index, full, sun.irradiance * share, target)
    })
}

impl Direct<'_> {
    /// Appends the terms of all sources that could light `point`, but for those in `groups`.
    pub(super) fn terms_of(
        &self,
        index: u32,
        point: &GatherPoint,
        groups: Option<&LightClusters>,
        terms: &mut Vec<Term>,
    ) {
        let flat = if groups.is_some_and(LightClusters::has_flat) {
            &[]
        } else {
            self.sources.flat(self.lights)
        };
        let mut push = |full: Rgb, radiance: Rgb, target: Target| {
            if full.max_channel() > 0.0 {
                terms.push(Term::new(index, full, radiance, target));
            }
        };
        let (p, n) = (point.position, point.normal);
        for (lamp, light) in flat.iter().enumerate() {
            let f = light.form_factor(p, n);
            let radiance = light.emission.radiance;
            push(radiance * (PI * f), radiance, Target::Flat(lamp as u32));
        }
        for (k, light) in self.sources.curved(self.lights).iter().enumerate() {
            let d = light.centre - p;
            let reach = d.dot(n) + light.radius2.sqrt() * 3f64.sqrt();
            if reach > 0.0 {
                // Only a guide to where rays are worth spending.
                let rough = PI * (light.radius2 / d.length_squared()).min(1.0);
                let radiance = light.emission.radiance;
                push(radiance * rough, radiance, Target::Curved(k as u32));
            }
        }
        for light in &self.lights.delta {
            if groups.is_some_and(|groups| groups.has(light)) {
                continue;
            }
            if let Some((target, full)) = unoccluded(light, p, n, self.surfaces) {
                push(full, Rgb::BLACK, Target::Delta(target));
            }
        }
        for window in 0..self.sources.windows.len() {
            self.images_in(window, point, &mut push);
        }
    }

    /// Appends the terms of all suns that could light `point`, and of their images.
    pub(super) fn sun_terms_of(&self, index: u32, point: &GatherPoint, terms: &mut Vec<Term>) {
        for (k, sun) in self.lights.outside.suns.iter().enumerate() {
            let k = k as u32;
            terms.extend(sun_term(
                index,
                point,
                sun,
                sun.toward(),
                Rgb::WHITE,
                Target::Sun(k),
            ));
            for (number, window) in self.sources.windows.iter().enumerate() {
                let target = Target::SunImage {
                    window: number as u32,
                    sun: k,
                };
                let toward = reflect(sun.toward(), window.normal);
                terms.extend(sun_term(
                    index,
                    point,
                    sun,
                    toward,
                    window.reflectance,
                    target,
                ));
            }
        }
    }

    /// The images of lamps and lights that a window shows.
    fn images_in(
        &self,
        window: usize,
        point: &GatherPoint,
        push: &mut impl FnMut(Rgb, Rgb, Target),
    ) {
        let (p, n) = (point.position, point.normal);
        let number = window as u32;
        for lamp in 0..self.sources.flat(self.lights).len() {
            let Some(seen) = self.visible_image(lamp, window, point) else {
                continue;
            };
            let f = point_to_polygon(p, n, &seen);
            if f > 0.0 {
                let window = Some(window);
                let radiance = self.radiance(FlatSource { lamp, window });
                let seen = Box::new(seen);
                let target = Target::Image {
                    window: number,
                    seen,
                };
                push(radiance * (PI * f), radiance, target);
            }
        }
        let window = &self.sources.windows[window];
        for light in &self.lights.delta {
            let plane = (window.polygon[0], window.normal);
            let lit = unoccluded_image(light, (p, n), plane, self.surfaces);
            let lit = lit.filter(|(image, _)| is_through(p, *image, &window.polygon));
            if let Some((image, full)) = lit {
                let target = Target::DeltaImage {
                    window: number,
                    image,
                };
                push(full * window.reflectance, Rgb::BLACK, target);
            }
        }
    }

    /// Radiance of a flat emitter as it arrives.
    pub(super) fn radiance(&self, source: FlatSource) -> Rgb {
        let radiance = self.lights.flat()[source.lamp].emission.radiance;
        match source.window {
            None => radiance,
            Some(w) => radiance * self.sources.windows[w].reflectance,
        }
    }

    /// Form factor from a point to a source, if nothing stood between.
    pub(super) fn form_factor(&self, source: FlatSource, point: &GatherPoint) -> f64 {
        let (p, n) = (point.position, point.normal);
        let FlatSource { lamp, window } = source;
        match window {
            None => self.lights.flat()[lamp].form_factor(p, n),
            Some(w) => {
                let seen = self.visible_image(lamp, w, point);
                seen.map_or(0.0, |seen| point_to_polygon(p, n, &seen))
            }
        }
    }

    /// What a point sees of a source; `None` if it is nothing.
    pub(super) fn target(&self, source: FlatSource, point: &GatherPoint) -> Option<Target> {
        let FlatSource { lamp, window } = source;
        let Some(w) = window else {
            return Some(Target::Flat(lamp as u32));
        };
        Some(Target::Image {
            window: w as u32,
            seen: Box::new(self.visible_image(lamp, w, point)?),
        })
    }

    /// What of a lamp's image the window shows to a point; `None` if it is nothing.
    fn visible_image(
        &self,
        lamp: usize,
        window: usize,
        point: &GatherPoint,
    ) -> Option<ArrayPolygon> {
        let emits_back = self.lights.flat()[lamp].emission.emits_back;
        let window = &self.sources.windows[window];
        let p = point.position;
        let image = side_toward(&window.images[lamp], emits_back, p);
        if is_hidden(point, &image, &window.polygon) {
            return None;
        }
        // On the mirror itself the side that the point faces counts, not that to which rounding has moved it.
        let from = self.surfaces.tracer.leaving(p, point.normal);
        let side = (from - window.polygon[0]).dot(window.normal);
        // Only what of the lamp is on the point's side of the mirror has an image there, and
        // that image lies on the other side.
        let away = -side.signum() * window.normal;
        let beyond = clip(&image, window.polygon[0], away);
        let seen = clip_to_window(&beyond, p, &window.polygon);
        (seen.len() >= 3).then_some(seen)
    }
}
