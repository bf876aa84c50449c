//! Suns and skies of a document: where they stand by the compass, and the light on the ground.
//!
//! North is +y where z is up and −z where y is up, as for `--north 0` of the command line.

use super::SceneDocument;
use azulejo::scene::environment::upright;
use azulejo::scene::sky::{Sky, SkyDistribution, SunPosition, direction_from};
use azulejo::scene::{Environment, EnvironmentSource, LightKind};
use azulejo::surroundings::{DaylightUnits, GROUND_REFLECTANCE, sun_light};
use glam::DVec3;
use std::f64::consts::PI;

/// Azimuth and elevation of a new sun, degrees: south-east by south, where it lights both the front
/// and the right side of a model.
const NEW_SUN: [f64; 2] = [150.0, 40.0];

/// The type of a new sky: clear.
const NEW_SKY: u8 = 12;

/// Two directions that are closer than this, radians, are the same place of the sun.
const SAME_PLACE: f64 = 1e-6;

/// A sky in numbers of the scene and of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkySettings {
    /// How its radiance is distributed.
    pub distribution: SkyDistribution,
    /// Unit direction of the world toward its sun.
    pub toward: DVec3,
    /// Mean irradiance of level ground by the sky alone, at least 0.
    pub irradiance: f64,
    /// Reflectance of the ground below the horizon, 0..=1, for the light of the sky and all suns.
    pub reflectance: f64,
}

impl SceneDocument {
    /// What the light of suns and skies is measured in.
    pub fn daylight_units(&self) -> DaylightUnits {
        DaylightUnits {
            photometric: self.units.photometric,
            solar: false,
        }
    }

    /// The place of a sun by the compass; `toward` is a unit direction of the world toward it.
    pub fn compass(&self, toward: DVec3) -> SunPosition {
        SunPosition::of(upright(self.units.up, 0.0).conjugate() * toward)
    }

    /// The unit direction of the world toward a place by the compass.
    pub fn toward(&self, place: SunPosition) -> DVec3 {
        upright(self.units.up, 0.0) * place.toward()
    }

    /// The direction of the world toward the first sun, and its mean irradiance of what faces it.
    /// Every directional light is a sun.
    pub fn first_sun(&self) -> Option<(DVec3, f64)> {
        self.suns().next()
    }

    fn suns(&self) -> impl Iterator<Item = (DVec3, f64)> {
        self.lights.iter().filter_map(|lamp| match lamp.light.kind {
            LightKind::Directional {
                direction,
                irradiance,
                ..
            } => Some((-direction, irradiance.mean())),
            _ => None,
        })
    }

    fn skies(&self) -> impl Iterator<Item = (&Environment, &Sky)> {
        self.lights
            .iter()
            .filter_map(|lamp| as_sky(&lamp.light.kind))
    }

    /// Mean irradiance of level ground by all suns.
    pub fn beam_on_ground(&self) -> f64 {
        let up = self.units.up.axis();
        let beams = self.suns().map(|(toward, e)| e * toward.dot(up).max(0.0));
        beams.sum()
    }

    /// What a sky is, in numbers to edit.
    pub fn sky_settings(&self, environment: &Environment, sky: &Sky) -> SkySettings {
        let scale = mean_scale(environment);
        let irradiance = scale * sky.diffuse_horizontal();
        let light = irradiance + self.beam_on_ground();
        SkySettings {
            distribution: sky.distribution,
            toward: environment.world_from_environment * sky.toward_sun,
            irradiance,
            reflectance: if light > 0.0 {
                PI * scale * sky.ground / light
            } else {
                0.0
            },
        }
    }

    /// The sky of these numbers in an environment, above ground that it lights together with all
    /// suns.
    pub fn sky_of(&self, environment: &Environment, settings: &SkySettings) -> Sky {
        // The ground's radiance is scaled with that of the sky.
        let scale = mean_scale(environment);
        let sky = Sky {
            distribution: settings.distribution,
            toward_sun: environment.to_local(settings.toward),
            scale: 1.0,
            ground: 0.0,
        };
        sky.with_diffuse_horizontal(settings.irradiance / scale)
            .with_ground(settings.reflectance, self.beam_on_ground() / scale)
    }

    /// A sun where the sky is brightest, or else in the south-east, as bright as under a clear sky.
    pub(super) fn new_sun(&self) -> LightKind {
        let of_sky = |(environment, sky): (&Environment, &Sky)| {
            let toward = environment.world_from_environment * sky.toward_sun;
            Some(self.compass(toward)).filter(|place| place.is_up() && sky.toward_sun != DVec3::Z)
        };
        let [azimuth, altitude] = NEW_SUN.map(f64::to_radians);
        let place = self.skies().find_map(of_sky);
        let place = place.unwrap_or(SunPosition { altitude, azimuth });
        let irradiance = self.daylight_units().clear_sun(place.altitude);
        sun_light(place.toward(), self.units.up, 0.0, irradiance)
    }

    /// A clear sky around the first sun that is up, above ground of the usual reflectance.
    pub(super) fn new_sky(&self) -> LightKind {
        let suns = self.suns().map(|(toward, _)| self.compass(toward));
        let [azimuth, altitude] = NEW_SUN.map(f64::to_radians);
        let place = { suns }.find(|place| place.is_up());
        let toward = place.map_or_else(|| direction_from(azimuth, altitude), SunPosition::toward);
        let clear = self.daylight_units().cie_sky(NEW_SKY, Some(toward), None);
        let sky = clear.unwrap_or_else(|_| Sky::uniform(1.0));
        let sky = sky.with_ground(GROUND_REFLECTANCE, self.beam_on_ground());
        LightKind::Environment(Environment::sky(sky, self.units.up, 0.0))
    }

    /// Carries a change of the suns on to the skies of this document: the sky around a sun that has
    /// moved from `from` to `to`, directions of the world, moves with it.
    pub(super) fn move_skies(&mut self, from: DVec3, to: DVec3) {
        for lamp in &mut self.lights {
            let LightKind::Environment(environment) = &mut lamp.light.kind else {
                continue;
            };
            let [from, to] = [from, to].map(|toward| environment.to_local(toward));
            if let EnvironmentSource::Sky(sky) = &mut environment.source
                && is_same_place(sky.toward_sun, from)
            {
                *sky = sky.with_sun(to);
            }
        }
    }

    /// Makes the ground below all skies reflect the light of the suns as it did when they gave
    /// `beam_before` on level ground.
    pub(super) fn relight_grounds(&mut self, beam_before: f64) {
        let beam = self.beam_on_ground();
        if beam == beam_before {
            return;
        }
        for lamp in &mut self.lights {
            let LightKind::Environment(environment) = &mut lamp.light.kind else {
                continue;
            };
            let scale = mean_scale(environment);
            if let EnvironmentSource::Sky(sky) = &mut environment.source {
                let diffuse = scale * sky.diffuse_horizontal();
                if diffuse + beam_before > 0.0 {
                    sky.ground *= (diffuse + beam) / (diffuse + beam_before);
                }
            }
        }
    }
}

/// Whether two unit directions are the same place of the sun.
pub(super) fn is_same_place(a: DVec3, b: DVec3) -> bool {
    a.distance(b) < SAME_PLACE
}

/// The factor of an environment's radiance. One that is switched off keeps its sky for when it is on
/// again, and counts as unscaled.
fn mean_scale(environment: &Environment) -> f64 {
    match environment.scale.mean() {
        scale if scale > 0.0 => scale,
        _ => 1.0,
    }
}

/// The sky that a light is, if it is one.
fn as_sky(kind: &LightKind) -> Option<(&Environment, &Sky)> {
    match kind {
        LightKind::Environment(environment) => match &environment.source {
            EnvironmentSource::Sky(sky) => Some((environment, sky)),
            EnvironmentSource::Picture { .. } => None,
        },
        _ => None,
    }
}
