//! What is computed for a lightmap, alone or by several processes.

use super::args::{BakeArgs, DoubleSidedArg, TexelArgs};
use super::coordinates;
use crate::content_key::{ContentHasher, shown};
use crate::engine::PreparedEngine;
use crate::failure::Failure;
use crate::pass;
use crate::report::Report;
use crate::runner::{Completed, DividedWork, Runner, Sharing, WorkKey};
use crate::session::Session;
use azulejo::bake::{ReceiverLayout, Resolution, UnwrapOptions};
use azulejo::lightmap::{
    BakeError, BakeOptions, BakeSource, Baked, BakedSides, Coordinates, bake, bake_occlusion,
};
use azulejo::surroundings::STUDIO_FLOOR;
use azulejo_factors::Engine;
use azulejo_formats::gltf::patch::LightmapUvs;
use azulejo_radiosity::FirstPass;
use azulejo_scene::Scene;
use azulejo_trace::{Blocks, Tracer};
use std::fmt;
use std::path::Path;

/// Distance up to which things occlude, as a share of the size of the model.
const OCCLUSION_DISTANCE: f64 = 0.1;

/// Texels per length of the floor of a studio, relative to those of the model: it is far larger.
const STUDIO_DENSITY: f64 = 0.25;

/// What a lightmap is computed from, as keys.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BakeContent {
    /// Of geometry, materials and lights.
    pub scene: String,
    /// Of the options.
    pub settings: String,
}

impl fmt::Display for BakeContent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}", self.scene, self.settings)
    }
}

/// A lightmap to be computed.
pub struct BakeWork<'a> {
    args: &'a BakeArgs,
    source: &'a BakeSource,
    tracer: Tracer,
    options: BakeOptions,
    /// How near things count as occluding, scene units; `None` for light.
    occlusion: Option<f64>,
}

impl<'a> BakeWork<'a> {
    /// What arguments ask for, and where the texture coordinates are written.
    ///
    /// # Errors
    /// Nothing can receive it; coordinates that should be kept cannot be; the engine cannot have the scene.
    pub fn new(
        args: &'a BakeArgs,
        source: &'a BakeSource,
        prepared: &PreparedEngine,
        session: &mut Session,
    ) -> Result<(BakeWork<'a>, LightmapUvs), Failure> {
        if source.receivers.is_empty() {
            return Err(Failure::failed(
                "there is no surface that could receive a lightmap: what is animated, skinned or morphed does not, nor \
                 do points and lines",
            ));
        }
        let tracer = prepared.tracer(&source.scene)?;
        let charts = charts(&args.texels, &source.scene);
        let chosen = coordinates::choose(args, source, &charts, session)?;
        let light = args.texels.light.baked();
        let options = BakeOptions {
            charts,
            coordinates: chosen.coordinates,
            densities: densities(&args.texels, source, session),
            follows_light: args.texels.follows_light(),
            pass: pass::options(&args.first_pass, prepared, session),
            light: light.unwrap_or_default(),
            denoises: args.texels.denoise,
            is_directional: args.files.directional.is_some(),
            sides: sides(args, source),
        };
        let occlusion = match light {
            Some(_) => None,
            None => Some(occlusion_distance(&args.texels, &source.scene)),
        };
        let work = BakeWork {
            args,
            source,
            tracer,
            options,
            occlusion,
        };
        Ok((work, chosen.uvs))
    }

    /// Computes it, or what this process has to of it.
    ///
    /// # Errors
    /// Those of the bake and of [`Runner::compute`].
    pub fn compute(
        &self,
        runner: Runner,
        output: Option<&Path>,
        session: &mut Session,
        report: &mut Report,
    ) -> Result<Option<Completed<Baked>>, Failure> {
        let plan = DividedWork {
            key: &|| self.key(),
            sharing: Sharing::All,
            output,
        };
        runner.compute(&plan, session, report, |blocks, session| {
            match self.baked(blocks, session) {
                Ok(baked) => Ok(Some(baked)),
                Err(BakeError::Solve(error)) => pass::unless_elsewhere(Err(error)),
                Err(other) => Err(Failure::failed(other)),
            }
        })
    }

    /// What the lightmap is computed from, whatever machine does it: without the kernel and the version of the program,
    /// which change no more than the noise.
    pub fn content(&self) -> BakeContent {
        let plain = FirstPass {
            engine: Engine::Auto,
            memory: 0,
            ..self.options.pass.clone()
        };
        let mut settings = ContentHasher::new();
        settings.add(&format!("{plain:?}"));
        self.add_settings(&mut settings);
        BakeContent {
            scene: shown(&ContentHasher::new().add(&self.source.scene).key()),
            settings: shown(&settings.key()),
        }
    }

    /// How it was computed.
    pub fn into_options(self) -> BakeOptions {
        self.options
    }

    fn baked(&self, blocks: &dyn Blocks, session: &Session) -> Result<Baked, BakeError> {
        let BakeSource {
            scene, receivers, ..
        } = self.source;
        let (tracer, options) = (&self.tracer, &self.options);
        pass::with_forecast(&self.args.first_pass, (blocks, session), |run| {
            match self.occlusion {
                None => bake(scene, tracer, receivers, options, run),
                Some(distance) => bake_occlusion(scene, tracer, receivers, options, distance, run),
            }
        })
    }

    /// What its blocks depend on.
    fn key(&self) -> WorkKey {
        let light = pass::work_key(&self.source.scene, &self.tracer, &self.options.pass, &[]);
        let mut settings = ContentHasher::new();
        settings.add(&light.settings);
        self.add_settings(&mut settings);
        WorkKey {
            settings: settings.key(),
            ..light
        }
    }

    /// Adds all options but those of the first pass.
    fn add_settings(&self, settings: &mut ContentHasher) {
        let options = &self.options;
        // Coordinates are many numbers, and those of the first pass are in the other key.
        let plain = BakeOptions {
            pass: FirstPass::default(),
            coordinates: Coordinates::New,
            ..options.clone()
        };
        settings
            .add("lightmap")
            .add(&format!("{plain:?}"))
            .add(&self.source.receivers)
            .add(&self.occlusion);
        match &options.coordinates {
            Coordinates::New => settings.add("new"),
            Coordinates::Kept { of_objects, pages } => {
                add_layouts(of_objects, settings.add("kept").add(pages))
            }
            Coordinates::Repacked(of_objects) => add_layouts(of_objects, settings.add("repacked")),
        };
    }
}

/// Adds what is known of coordinates that a file has.
fn add_layouts<'h>(
    of_objects: &[ReceiverLayout],
    settings: &'h mut ContentHasher,
) -> &'h mut ContentHasher {
    settings.add(&of_objects.len());
    for layout in of_objects {
        let ReceiverLayout {
            uvs,
            charts,
            pages,
            cuts,
        } = layout;
        settings.add(uvs).add(charts).add(pages).add(cuts);
    }
    settings
}

/// How near things count as occluding, scene units.
fn occlusion_distance(args: &TexelArgs, scene: &Scene) -> f64 {
    let usual = || OCCLUSION_DISTANCE * scene.bounds().diagonal();
    args.ao_distance
        .map_or_else(usual, |metres| metres / scene.units.metres())
}

fn charts(args: &TexelArgs, scene: &Scene) -> UnwrapOptions {
    let resolution = match (args.texels_per_metre, args.count) {
        (Some(density), _) => Resolution::PerUnit(density * scene.units.metres()),
        (None, Some(texels)) => Resolution::Texels(texels),
        (None, None) => Resolution::Fill,
    };
    UnwrapOptions {
        resolution,
        size: args.size.unwrap_or(resolution.page_size()),
        pages: args.pages,
        padding: args.padding.max(1 << args.mips),
        blocks: args.blocks,
        crease: args.crease,
    }
}

/// How dense the texels of each receiver are, relative to others; empty if all are alike.
fn densities(args: &TexelArgs, source: &BakeSource, session: &mut Session) -> Vec<f64> {
    let studio = |r: &u32| match source.scene.objects[*r as usize].name.as_str() {
        STUDIO_FLOOR => STUDIO_DENSITY,
        _ => 1.0,
    };
    if args.object_densities().next().is_none() {
        let factors: Vec<f64> = source.receivers.iter().map(studio).collect();
        return if factors.iter().all(|f| *f == 1.0) {
            Vec::new()
        } else {
            factors
        };
    }
    let name = |&r: &u32| source.scene.objects[r as usize].name.as_str();
    for given in args.object_densities() {
        if !source
            .receivers
            .iter()
            .any(|r| given.names.is_match(name(r)))
        {
            session.note(&format!(
                "--density {}: no object has such a name",
                given.text
            ));
        }
    }
    let factor = |r: &u32| {
        let mut fits = args.object_densities().rev();
        fits.find(|given| given.names.is_match(name(r)))
            .map_or_else(|| studio(r), |given| given.factor)
    };
    source.receivers.iter().map(factor).collect()
}

/// The side that receives: glTF says which side is the front, other formats often do not.
fn sides(args: &BakeArgs, source: &BakeSource) -> BakedSides {
    let usual = if source.is_given {
        BakedSides::Front
    } else {
        BakedSides::Brighter
    };
    args.texels
        .double_sided
        .map_or(usual, DoubleSidedArg::baked)
}
