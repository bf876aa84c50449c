//! Edits of the light from outside: suns, skies, pictures of the surroundings, a studio.

use super::{EditError, Edited, missing, refuse};
use crate::document::daylight::is_same_place;
use crate::document::{ItemId, SceneDocument, SceneLight, SkySettings};
use azulejo::scene::sky::PerezWeather;
use azulejo::scene::{
    Backplate, BackplateFit, Environment, EnvironmentSource, Light, LightKind, Projection, Rgb,
    Scene, SceneBackground, Texture, TextureId,
};
use azulejo::surroundings::{extract_sun, studio};
use azulejo::trace::Tracer;
use std::sync::Arc;

impl SceneDocument {
    /// Applies an edit of the lights; the ground below each sky keeps its reflectance under the
    /// suns that result.
    pub(super) fn with_grounds(&mut self, edit: impl FnOnce(&mut Self) -> Edited) -> Edited {
        let before = self.beam_on_ground();
        let edited = edit(self)?;
        self.relight_grounds(before);
        Ok(edited)
    }

    /// Adds a light under its name or, if that is taken, with a number. A sky or a picture replaces
    /// the background, which would hide it.
    pub(super) fn push_light(&mut self, name: &str, kind: LightKind) -> Edited {
        let light = Light {
            name: self.unique_name(name),
            kind,
        };
        self.check_light(&light)?;
        if let LightKind::Environment(_) = light.kind {
            self.background = None;
        }
        let id = self.new_id();
        self.lights.push(SceneLight {
            id,
            source_file: None,
            hidden: false,
            light,
        });
        Ok(vec![id])
    }

    pub(super) fn set_light(&mut self, id: ItemId, light: &Light) -> Edited {
        self.check_light(light)?;
        let Some(lamp) = self.lights.iter_mut().find(|l| l.id == id) else {
            return missing("light");
        };
        let old = std::mem::replace(&mut lamp.light, light.clone());
        if let (
            LightKind::Directional {
                direction: from, ..
            },
            LightKind::Directional { direction: to, .. },
        ) = (&old.kind, &light.kind)
            && from != to
        {
            self.move_skies(-*from, -*to);
        }
        Ok(vec![id])
    }

    pub(super) fn check_light(&self, light: &Light) -> Result<(), EditError> {
        let alone = Scene {
            lights: vec![light.clone()],
            textures: self.blank_textures(),
            ..Scene::default()
        };
        alone.validate().or_else(|e| refuse(e.problem))
    }

    /// As many textures as the document has, without their pictures, for validation.
    pub(super) fn blank_textures(&self) -> Vec<Texture> {
        vec![Texture::default(); self.textures.len()]
    }

    pub(super) fn add_environment(
        &mut self,
        texture: &Arc<Texture>,
        projection: Projection,
    ) -> Edited {
        let id = self.push_texture(texture);
        let environment = Environment::picture(id, projection, self.units.up);
        self.push_light("environment", LightKind::Environment(environment))
    }

    pub(super) fn set_environment_picture(
        &mut self,
        id: ItemId,
        texture: &Arc<Texture>,
        projection: Projection,
    ) -> Edited {
        let mut environment = self.environment(id)?;
        environment.source = EnvironmentSource::Picture {
            texture: self.push_texture(texture),
            projection,
        };
        self.set_kind(id, LightKind::Environment(environment))
    }

    pub(super) fn set_backplate(
        &mut self,
        texture: &Arc<Texture>,
        fit: BackplateFit,
        radiance: f64,
    ) -> Edited {
        let texture = self.push_texture(texture);
        let plate = Backplate {
            texture,
            fit,
            radiance,
        };
        self.set_surroundings(Some(SceneBackground::Backplate(plate)), self.fog)
    }

    /// Takes the sun out of the picture of an environment, as a light of its own.
    pub(super) fn extract_sun(&mut self, id: ItemId) -> Edited {
        let mut environment = self.environment(id)?;
        let EnvironmentSource::Picture {
            texture,
            projection,
        } = environment.source
        else {
            return refuse("a sky holds no picture of the sun");
        };
        let Some(old) = self.textures.get(texture as usize) else {
            return missing("picture");
        };
        let mut texture = Texture::clone(old);
        let Some(image) = &mut texture.image else {
            return refuse("the picture is not loaded");
        };
        let sun = extract_sun(image, projection).or_else(refuse)?;
        environment.source = EnvironmentSource::Picture {
            texture: self.push_texture(&Arc::new(texture)),
            projection,
        };
        self.set_kind(id, LightKind::Environment(environment))?;
        let toward = environment.world_from_environment * sun.toward;
        self.push_light(
            "sun",
            LightKind::Directional {
                direction: -toward.normalize(),
                irradiance: sun.irradiance * environment.scale,
                half_angle: sun.half_angle,
            },
        )
    }

    /// Makes a light the sky of weather, and gives the sun at its place the irradiance that the
    /// weather has.
    pub(super) fn set_weather(&mut self, id: ItemId, weather: &PerezWeather) -> Edited {
        let mut environment = self.environment(id)?;
        let EnvironmentSource::Sky(old) = environment.source else {
            return refuse("weather makes a sky, and this light is a picture");
        };
        let numbers = [weather.dni, weather.dhi, weather.dew_point];
        if !numbers.iter().all(|x| x.is_finite()) || weather.dni < 0.0 || weather.dhi < 0.0 {
            return refuse("irradiances of weather are finite and not negative");
        }
        let reflectance = self.sky_settings(&environment, &old).reflectance;
        let (sky, direct) = self.daylight_units().perez_sky(weather, old.toward_sun);
        let settings = SkySettings {
            reflectance,
            ..self.sky_settings(&environment, &sky)
        };
        environment.source = EnvironmentSource::Sky(self.sky_of(&environment, &settings));
        let edited = self.set_kind(id, LightKind::Environment(environment))?;
        let toward = environment.world_from_environment * old.toward_sun;
        for lamp in &mut self.lights {
            if let LightKind::Directional {
                direction,
                irradiance,
                ..
            } = &mut lamp.light.kind
                && is_same_place(-*direction, toward)
            {
                *irradiance = Rgb::grey(direct);
            }
        }
        Ok(edited)
    }

    /// Surrounds a model in which nothing shines with a floor and three lamps, or hangs a lamp in a
    /// room.
    pub(super) fn add_studio(&mut self) -> Edited {
        if self.has_light() {
            return refuse("the scene has light of its own, a studio is for one without");
        }
        let scene = self.scene();
        let Some(mut around) = studio(&scene, &Tracer::new(&scene)) else {
            return refuse("there is no model to put into a studio");
        };
        if !self.cameras.is_empty() {
            around.cameras.clear();
        }
        Ok(self.append(around, None))
    }

    fn environment(&self, id: ItemId) -> Result<Environment, EditError> {
        match self.light(id).map(|lamp| &lamp.light.kind) {
            Some(LightKind::Environment(environment)) => Ok(*environment),
            Some(_) => refuse("the light is neither a sky nor a picture"),
            None => missing("light"),
        }
    }

    fn set_kind(&mut self, id: ItemId, kind: LightKind) -> Edited {
        let name = self.name(id).unwrap_or_default().to_owned();
        self.set_light(id, &Light { name, kind })
    }

    fn push_texture(&mut self, texture: &Arc<Texture>) -> TextureId {
        self.textures.push(Arc::clone(texture));
        (self.textures.len() - 1) as TextureId
    }
}
