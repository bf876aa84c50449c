//! `ext light begin kind = environment ...` and `ext background begin picture = ...`: radiance by
//! direction, or by the place in the image.

use super::document::{BlockKind, SourcePosition};
use super::entries::{GrfEntries, Taken};
use super::parser::{GrfParser, ParseResult};
use super::placement::BlockPlace;
use super::resolve::{GrfResolver, ResolveResult};
use super::write::{GrfOutput, Number, Quoted, point, rgb};
use azulejo_scene::sky::{CieSky, PerezSky, Sky, SkyDistribution};
use azulejo_scene::{
    Backplate, BackplateFit, Environment, EnvironmentSource, Light, LightKind, Material,
    Projection, Rgb, Scene, SceneBackground, TextureId,
};
use glam::{DMat3, DQuat, DVec3};
use std::collections::HashSet;
use std::io::{self, Write};

/// An environment of a GRF file, whose picture has a path instead of a number.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EnvironmentBlock {
    /// The name of a light; `None` for the background, which gives none.
    pub light: Option<String>,
    /// The file of its picture.
    pub picture: Option<String>,
    /// The environment; the number of its picture means nothing.
    pub environment: Environment,
}

impl EnvironmentBlock {
    /// The block of an environment, with the file of its picture.
    pub fn new(
        light: Option<&str>,
        environment: Environment,
        picture: impl Fn(u32) -> String,
    ) -> Box<EnvironmentBlock> {
        Box::new(EnvironmentBlock {
            light: light.map(str::to_owned),
            picture: environment.texture().map(picture),
            environment,
        })
    }
}

/// A backplate of a GRF file, whose picture has a path instead of a number.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BackplateBlock {
    /// The file of its picture.
    pub picture: String,
    /// The backplate; the number of its picture means nothing.
    pub plate: Backplate,
}

impl<'a> GrfParser<'a, '_, '_> {
    /// The rest of a background that is not a single colour.
    pub(super) fn background(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<BlockKind> {
        let Some(fit) = self.take_choice(entries, "fit", &FITS)? else {
            return self.environment(entries, None);
        };
        let picture = self.take_text(entries, "picture")?;
        let radiance = self.take_number(entries, "radiance")?;
        Ok(BlockKind::Backplate(Box::new(BackplateBlock {
            picture: self.required(entries, "picture", picture)?,
            plate: Backplate {
                texture: 0,
                fit,
                radiance: self.not_negative_number(radiance.unwrap_or((1.0, entries.offset)))?,
            },
        })))
    }

    /// The rest of an environment; `light` is the name of the light that it is.
    pub(super) fn environment(
        &mut self,
        entries: &mut GrfEntries<'a>,
        light: Option<String>,
    ) -> ParseResult<BlockKind> {
        let picture = self.take_text(entries, "picture")?;
        let source = match self.sky(entries)? {
            Some(sky) => EnvironmentSource::Sky(sky),
            None => EnvironmentSource::Picture {
                texture: 0,
                projection: (self.take_choice(entries, "projection", &PROJECTIONS)?)
                    .unwrap_or_default(),
            },
        };
        let scale = self.take_rgb(entries, "scale")?.unwrap_or(Rgb::WHITE);
        let environment = Environment {
            source,
            world_from_environment: self.directions(entries)?,
            scale,
        };
        let picture = match source {
            EnvironmentSource::Sky(_) => None,
            EnvironmentSource::Picture { .. } => Some(self.required(entries, "picture", picture)?),
        };
        Ok(BlockKind::Environment(Box::new(EnvironmentBlock {
            light,
            picture,
            environment,
        })))
    }

    /// `sky = uniform`, `cie` or `perez`, with what it depends on; `None` for a picture.
    fn sky(&mut self, entries: &mut GrfEntries<'a>) -> Taken<Sky> {
        let Some((name, offset)) = self.take_word(entries, "sky")? else {
            return Ok(None);
        };
        let distribution = match name {
            "uniform" => SkyDistribution::Uniform,
            "cie" => {
                let kind = self.take_number(entries, "type")?;
                let (kind, at) = self.required(entries, "type", kind)?;
                match CieSky::new(kind as u8) {
                    Ok(sky) if f64::from(kind as u8) == kind => SkyDistribution::Cie(sky),
                    _ => return Err(self.fail(at, format!("`{kind}`"), "a type of 1 to 16")),
                }
            }
            "perez" => {
                let mut coefficients = [0.0; 5];
                for (value, key) in coefficients.iter_mut().zip(COEFFICIENTS) {
                    let coefficient = self.take_number(entries, key)?;
                    *value = self.required(entries, key, coefficient)?.0;
                }
                SkyDistribution::Perez(PerezSky { coefficients })
            }
            _ => {
                return Err(self.fail(offset, format!("`{name}`"), "`uniform`, `cie` or `perez`"));
            }
        };
        let sun = self.take_point(entries, "sun")?.unwrap_or(DVec3::Z);
        let Some(toward_sun) = super::unit(sun) else {
            return Err(self.fail(offset, "a sun without direction", "a non-zero vector"));
        };
        let [scale, ground] = ["radiance", "ground"].map(|key| self.take_number(entries, key));
        let (scale, ground) = (scale?, ground?);
        let scale = self.required(entries, "radiance", scale)?;
        Ok(Some(Sky {
            distribution,
            toward_sun,
            scale: self.not_negative_number(scale)?,
            ground: self.not_negative_number(ground.unwrap_or((0.0, offset)))?,
        }))
    }

    fn not_negative_number(&mut self, (value, offset): (f64, usize)) -> ParseResult<f64> {
        if value >= 0.0 && value.is_finite() {
            return Ok(value);
        }
        Err(self.fail(offset, format!("`{value}`"), "a number of at least 0"))
    }

    /// The rotation by `up` and `north`, by default z and y.
    fn directions(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<DQuat> {
        let offset = entries.offset;
        let up = self.take_point(entries, "up")?.unwrap_or(DVec3::Z);
        let north = self.take_point(entries, "north")?.unwrap_or(DVec3::Y);
        let axes = || {
            let (up, east) = (up.try_normalize()?, north.cross(up).try_normalize()?);
            Some(DMat3::from_cols(east, up.cross(east), up))
        };
        match axes() {
            Some(axes) => Ok(DQuat::from_mat3(&axes).normalize()),
            None => Err(self.fail(
                offset,
                "an environment whose up and north are parallel or 0",
                "two directions at right angles",
            )),
        }
    }
}

impl GrfResolver<'_> {
    /// Adds an environment to the scene.
    pub fn environment(
        &mut self,
        block: &EnvironmentBlock,
        place: BlockPlace,
    ) -> ResolveResult<()> {
        let mut environment = block.environment;
        if let Some(map) = place.outer {
            environment.turn(&map.matrix3);
        }
        if let Some(path) = &block.picture {
            let texture = self.texture_in_place(path, place.source);
            environment = environment.with_texture(|_| texture);
        }
        match &block.light {
            None => self.scene.background = Some(SceneBackground::Environment(environment)),
            Some(name) => self.scene.lights.push(Light {
                name: name.clone(),
                kind: LightKind::Environment(environment),
            }),
        }
        Ok(())
    }
}

impl GrfResolver<'_> {
    /// Puts a picture behind the scene.
    pub(super) fn backplate(&mut self, block: &BackplateBlock, place: SourcePosition) {
        let texture = self.texture_in_place(&block.picture, place);
        let plate = Backplate {
            texture,
            ..block.plate
        };
        self.scene.background = Some(SceneBackground::Backplate(plate));
    }
}

/// The textures that environments and the background alone show: materials need no names for them.
pub(super) fn pictures_of(scene: &Scene) -> HashSet<TextureId> {
    let mut around: HashSet<TextureId> = scene.surrounding_pictures().collect();
    for texture in scene.materials.iter().flat_map(Material::pictures) {
        around.remove(&texture);
    }
    around
}

/// The names of the coefficients of a Perez sky.
const COEFFICIENTS: [&str; 5] = ["a", "b", "c", "d", "e"];

const PROJECTIONS: [(&str, Projection); 2] = [
    ("equirectangular", Projection::Equirectangular),
    ("angular_map", Projection::AngularMap),
];

const FITS: [(&str, BackplateFit); 3] = [
    ("scaled", BackplateFit::Scaled),
    ("centered", BackplateFit::Centered),
    ("tiled", BackplateFit::Tiled),
];

/// Writes a backplate.
pub(super) fn write_backplate(out: &mut GrfOutput<'_>, block: &BackplateBlock) -> io::Result<()> {
    let Backplate { fit, radiance, .. } = block.plate;
    let named = FITS.iter().find(|(_, known)| *known == fit);
    writeln!(
        out,
        "ext background begin picture = {} fit = {} radiance = {} end ext",
        Quoted(&block.picture),
        named.map_or("", |(name, _)| *name),
        Number(radiance)
    )
}

/// Writes an environment.
pub(super) fn write(out: &mut GrfOutput<'_>, block: &EnvironmentBlock) -> io::Result<()> {
    // Light and background differ in how the block begins, not in its entries.
    match &block.light {
        None => write!(out, "ext background begin")?,
        Some(name) => write!(
            out,
            "ext light begin name = {} kind = environment",
            Quoted(name)
        )?,
    }
    let Environment {
        source,
        world_from_environment: turn,
        scale,
    } = block.environment;
    // Write where the radiance comes from: a picture, or a model of the sky.
    match source {
        EnvironmentSource::Picture { projection, .. } => {
            let path = block.picture.as_deref().unwrap_or_default();
            let named = PROJECTIONS.iter().find(|(_, known)| *known == projection);
            let name = named.map_or("", |(name, _)| *name);
            write!(out, " picture = {} projection = {name}", Quoted(path))?;
        }
        EnvironmentSource::Sky(sky) => {
            match sky.distribution {
                SkyDistribution::Uniform => write!(out, " sky = uniform")?,
                SkyDistribution::Cie(sky) => write!(out, " sky = cie type = {}", sky.number())?,
                SkyDistribution::Perez(PerezSky { coefficients }) => {
                    write!(out, " sky = perez")?;
                    for (key, value) in COEFFICIENTS.iter().zip(coefficients) {
                        write!(out, " {key} = {}", Number(value))?;
                    }
                }
            }
            write!(
                out,
                " sun = {} radiance = {} ground = {}",
                point(sky.toward_sun),
                Number(sky.scale),
                Number(sky.ground)
            )?;
        }
    }
    // Two axes in the world stand for the rotation.
    let (up, north) = (turn * DVec3::Z, turn * DVec3::Y);
    writeln!(
        out,
        " up = {} north = {} scale = {} end ext",
        point(up),
        point(north),
        rgb(scale)
    )
}
