//! Photometric files as lights: `ies`.

use super::ies::{BINS, Luminaire, LuminousOpening, parse};
use super::reader::{EntityError, MgfReader, MgfSource, skip};
use super::solids;
use super::transform::MgfTransform;
use crate::reading::files::beside;
use crate::reading::text::quoted;
use azulejo_scene::{LightKind, Material, Primitive, Rgb};
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;
use std::rc::Rc;

/// A side with a smaller share of the flux than this is dark.
const DARK: f64 = 1e-3;

/// A distribution with half of its flux within this many degrees is a beam, which a Lambertian
/// opening (half of the flux within 45°) cannot represent.
const BEAM: f64 = 30.0;

/// Sides of round openings.
const SIDES: u32 = 32;

/// Least distance between the two sides of an opening that emits both ways, metres.
const LEAST_HEIGHT: f64 = 2e-3;

impl MgfReader<'_> {
    /// Adds a luminaire for each instance of a transform.
    pub(super) fn place_luminaires(
        &mut self,
        source: &mut MgfSource,
        name: &str,
        multiplier: f64,
        transform: &MgfTransform,
    ) -> Result<(), EntityError> {
        let luminaire = self.luminaire_of(name)?;
        if let Some(body) = &luminaire.body {
            let body = beside(name, body);
            match self.text_of(&body) {
                Ok(bytes) => {
                    let outside = self.emission;
                    self.emission *= luminaire.factor * multiplier;
                    self.open.push(name.to_owned());
                    let read = self.instances_of(&body, &bytes, transform);
                    self.open.pop();
                    self.emission = outside;
                    return read;
                }
                Err(EntityError::Skipped(message)) => self.warn(source, message),
                Err(stop) => return Err(stop),
            }
        }
        let group = name.rsplit('/').next().unwrap_or(name);
        self.for_instances(group, transform, |reader| {
            reader.shine(&luminaire, multiplier)
        })?;
        skip("luminaire (ies): its distribution is approximated by area lights and spotlights")
    }

    fn luminaire_of(&mut self, name: &str) -> Result<Rc<Luminaire>, EntityError> {
        let shown = quoted(name.as_bytes());
        if self.open.iter().any(|open| open == name) {
            return skip(format!(
                "the geometry of {shown} includes it again: skipped"
            ));
        }
        if let Some(known) = self.luminaires.get(name) {
            let known = known.clone();
            return known.map_or_else(|| skip(format!("{shown} skipped, as before")), Ok);
        }
        let bytes = self.text_of(name)?;
        let parsed = parse(&bytes).map(Rc::new);
        self.luminaires.insert(name.to_owned(), parsed.clone().ok());
        parsed.or_else(|wrong| {
            skip(format!(
                "{shown} is not a valid photometric file: found {wrong}"
            ))
        })
    }

    /// Adds the downward and the upward light, each on its side of the opening.
    fn shine(&mut self, luminaire: &Luminaire, multiplier: f64) -> Result<(), EntityError> {
        let total: f64 = luminaire.flux.iter().sum();
        let both = [false, true].map(|up| LuminaireSide::new(luminaire, up, multiplier));
        let is_lit = |side: &LuminaireSide| side.lumens > DARK * total * multiplier;
        let shines_both_ways = both.iter().all(is_lit);
        let is_round_about = luminaire.opening == LuminousOpening::Point
            && both
                .iter()
                .all(|side| side.lumens > 0.25 * total * multiplier);
        if is_round_about {
            return self.bulb(total * multiplier);
        }
        for side in both.iter().filter(|side| is_lit(side)) {
            let is_beam = side.angle_of(0.5) < BEAM;
            match luminaire.opening {
                LuminousOpening::Point => self.spot(side)?,
                _ if is_beam => self.spot(side)?,
                opening => self.lamp(side, opening, shines_both_ways)?,
            }
        }
        Ok(())
    }

    /// Intensities scale with the square of lengths, like the flux of surfaces.
    fn candelas(&self, local: f64) -> Rgb {
        Rgb::grey(local * self.placement.scale * self.placement.scale)
    }

    fn bulb(&mut self, lumens: f64) -> Result<(), EntityError> {
        let position = self.placement.map.translation;
        let intensity = self.candelas(lumens / (4.0 * PI));
        self.light(
            position,
            LightKind::Point {
                position,
                intensity,
            },
        )
    }

    fn spot(&mut self, side: &LuminaireSide) -> Result<(), EntityError> {
        let map = self.placement.map;
        let position = map.translation;
        let Some(direction) = (map.matrix3 * side.aim()).try_normalize() else {
            return skip("luminaire without a direction: skipped");
        };
        let [inner, outer] = [side.angle_of(0.25), side.angle_of(0.99)].map(f64::to_radians);
        // Smoothstep of the cosine between the two: half of the flux in that ring.
        let solid_angle = 2.0 * PI * (1.0 - 0.5 * (inner.cos() + outer.cos()));
        let intensity = self.candelas(side.lumens / solid_angle);
        let kind = LightKind::Spot {
            position,
            direction,
            intensity,
            inner,
            outer,
        };
        self.light(position, kind)
    }

    fn light(&mut self, position: DVec3, kind: LightKind) -> Result<(), EntityError> {
        let (LightKind::Point { intensity, .. } | LightKind::Spot { intensity, .. }) = kind else {
            return Ok(());
        };
        if !(position.is_finite() && intensity.is_finite()) {
            return skip("luminaire whose size overflows: skipped");
        }
        self.builder.light(kind);
        Ok(())
    }

    /// A Lambertian opening.
    fn lamp(
        &mut self,
        side: &LuminaireSide,
        opening: LuminousOpening,
        both: bool,
    ) -> Result<(), EntityError> {
        let (LuminousOpening::Rectangle { height, .. } | LuminousOpening::Disc { height, .. }) =
            opening
        else {
            return Ok(());
        };
        let height = if both {
            height.max(LEAST_HEIGHT)
        } else {
            height
        };
        let normal = side.aim();
        let centre = 0.5 * height * normal;
        let map = self.placement.map;
        match opening {
            LuminousOpening::Rectangle { length, width, .. } => {
                let material = self.lamp_material(side.lumens / (length * width))?;
                let (along, across) = (length * DVec3::X, width * normal.cross(DVec3::X));
                let corner = centre - 0.5 * (along + across);
                self.rectangle([corner, along, across], &map, material)
            }
            LuminousOpening::Disc { diameter, .. } => {
                let mut mesh = solids::ring(centre, normal, 0.0, 0.5 * diameter, SIDES);
                let material = self.lamp_material(side.lumens / mesh.area())?;
                if !mesh
                    .positions
                    .iter()
                    .all(|p| map.transform_point3(*p).is_finite())
                {
                    return skip("luminaire whose size overflows: skipped");
                }
                mesh.transform(&map);
                self.builder.solid(mesh, material, None);
                Ok(())
            }
            LuminousOpening::Point => Ok(()),
        }
    }

    fn rectangle(
        &mut self,
        [corner, along, across]: [DVec3; 3],
        map: &DAffine3,
        material: u32,
    ) -> Result<(), EntityError> {
        let corner = map.transform_point3(corner);
        let [along, across] = [along, across].map(|edge| map.transform_vector3(edge));
        // The front follows the edges, so reversing them preserves it under a reflection.
        let [first, second] = if self.placement.mirrors() {
            [across, along]
        } else {
            [along, across]
        };
        let size = first.cross(second).length();
        if !(corner.is_finite() && size.is_finite() && size > 0.0) {
            return skip("luminaire without size, or whose size overflows: skipped");
        }
        self.builder
            .primitive(Primitive::parallelogram(corner, first, second, material));
        Ok(())
    }

    /// A white emitter with the given emittance, lm/m².
    fn lamp_material(&mut self, emittance: f64) -> Result<u32, EntityError> {
        let radiance = emittance / PI;
        if !radiance.is_finite() {
            return skip("luminaire whose brightness overflows: skipped");
        }
        let name = self.builder.path().to_owned();
        Ok(self
            .builder
            .material(Material::emitter(name, Rgb::grey(radiance))))
    }
}

/// The downward or upward flux.
struct LuminaireSide {
    up: bool,
    lumens: f64,
    /// Its share within each degree from its own axis.
    shares: Vec<f64>,
}

impl LuminaireSide {
    fn new(luminaire: &Luminaire, up: bool, multiplier: f64) -> LuminaireSide {
        let half = BINS / 2;
        let from_axis = |k: usize| if up { BINS - 1 - k } else { k };
        let flux: Vec<f64> = (0..half).map(|k| luminaire.flux[from_axis(k)]).collect();
        let sum: f64 = flux.iter().sum();
        LuminaireSide {
            up,
            lumens: sum * multiplier,
            shares: flux
                .iter()
                .map(|f| f / sum.max(f64::MIN_POSITIVE))
                .collect(),
        }
    }

    /// The direction of its axis.
    fn aim(&self) -> DVec3 {
        if self.up { DVec3::Z } else { -DVec3::Z }
    }

    /// The angle from the axis, degrees, that contains a share of the flux.
    fn angle_of(&self, share: f64) -> f64 {
        let mut left = share;
        for (degree, here) in (0..).zip(&self.shares) {
            if *here >= left && *here > 0.0 {
                return f64::from(degree) + left / here;
            }
            left -= here;
        }
        self.shares.len() as f64
    }
}
