//! Lightmaps of scenes: charts, light of the solved first pass in their texels, and padding.
//!
//! [`bake`] is the third pass beside the picture: `azulejo-bake` knows texels, `azulejo-radiosity` knows
//! light, and here the two meet. A [`BakeSource`] is the scene with the glTF file that gets its lightmap.

mod brightness;
mod charts;
mod directions;
mod facing;
mod indirect;
mod occlusion;
mod pages;
mod radiance;
mod sides;
mod source;

pub use brightness::{BytePicture, BytePictures, png_page};
pub use directions::{DirectionForm, direction_bytes, direction_errors};
pub use occlusion::bake_occlusion;
pub use radiance::TexelRadiance;
pub use source::{BakeSource, SourceError, SourceFile};

use azulejo_bake::layout::NO_CHART;
use azulejo_bake::{
    Atlas, DIRECTIONAL, LayoutError, Lightmap, LightmapPage, ReceiverLayout, SeamErrors,
    UnwrapOptions,
};
use azulejo_factors::{PatchSize, Patches, ProxyScene, RefinedShape};
use azulejo_radiosity::sites::SiteStatistics;
use azulejo_radiosity::{FirstPass, Report, SolveError};
use azulejo_scene::{Exact, Rgb, Scene, Shape};
use azulejo_trace::sampling::hash;
use azulejo_trace::time::Instant;
use azulejo_trace::{Cancelled, Progress, Run, Tracer};
use charts::Charts;
use pages::Pages;
use std::fmt;

/// Chord error of tessellated primitives, relative to their size.
const CHORD_ERROR: f64 = 1e-3;

/// Longest edge of faces that are cut, as a part of the scene: contacts of a twentieth of that count.
const CUTS: f64 = 8.0;

/// Error where none is requested.
const DEFAULT_ERROR: f64 = 0.03;

/// Time from the end of the gather to that of the files, as a multiple of what the places of texels took (measured).
const FINISHING: f64 = 2.5;

/// Which light a lightmap holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BakedLight {
    /// All.
    #[default]
    Total,
    /// All but what comes straight from lamps and lights, or from them by one flat mirror.
    Indirect,
    /// That alone.
    Direct,
}

/// Which side of surfaces a lightmap has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BakedSides {
    /// Fronts.
    #[default]
    Front,
    /// Of each chart the back if it gets more than twice the light of the front.
    Brighter,
    /// Both, each with charts of its own; the backs of solids, which nobody sees, have none.
    Both,
}

/// Where the texture coordinates of a lightmap come from.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Coordinates {
    /// They are made.
    #[default]
    New,
    /// The objects have them, each those of its triangles, and they stay.
    Kept {
        /// `uvs` and `pages` of each object that receives.
        of_objects: Vec<ReceiverLayout>,
        /// Width and height of each page, texels.
        pages: Vec<[u32; 2]>,
    },
    /// The objects have charts, which are packed anew: `uvs` of each object that receives.
    Repacked(Vec<ReceiverLayout>),
}

/// How a lightmap is baked.
#[derive(Clone, Debug, PartialEq)]
pub struct BakeOptions {
    /// Charts and pages.
    pub charts: UnwrapOptions,
    /// Where the coordinates come from.
    pub coordinates: Coordinates,
    /// For each object that receives, how much denser than others its texels are, per length; empty if all are
    /// alike.
    pub densities: Vec<f64>,
    /// Whether charts with edges of shadows get more texels than others, where coordinates are made and that makes the
    /// error less.
    pub follows_light: bool,
    /// The first pass, with the error to reach. With rays and no error, and without a deadline, light is gathered
    /// with this many rays at every texel, and not interpolated; otherwise rays are those of patches.
    pub pass: FirstPass,
    /// Which light.
    pub light: BakedLight,
    /// Which sides.
    pub sides: BakedSides,
    /// Whether noise is removed from texels that are gathered each by itself: those of a number of rays without an error.
    pub denoises: bool,
    /// Whether it is asked where the light comes from, see [`Baked::harmonics`].
    pub is_directional: bool,
}

impl BakeOptions {
    /// The error to reach, relative to the mean.
    fn error(&self) -> f64 {
        self.pass.error.unwrap_or(DEFAULT_ERROR)
    }

    /// What random numbers of texels depend on.
    fn seed(&self) -> u32 {
        let seed = self.pass.seed;
        hash(&[seed as u32, (seed >> 32) as u32, 3])
    }

    /// Rays of every texel, where their number is given and no error.
    pub fn fixed_rays(&self, progress: &Progress) -> Option<u32> {
        let is_fixed = self.pass.error.is_none()
            && !progress.has_deadline()
            && self.light != BakedLight::Direct;
        self.pass.rays.filter(|_| is_fixed)
    }
}

/// Why there is no lightmap.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum BakeError {
    /// No charts.
    Layout(LayoutError),
    /// No light.
    Solve(SolveError),
    /// No room.
    Memory {
        /// What the texels would take, bytes.
        needed: u64,
        /// What is permitted, bytes.
        permitted: u64,
    },
}

impl fmt::Display for BakeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BakeError::Layout(error) => error.fmt(f),
            BakeError::Solve(error) => error.fmt(f),
            BakeError::Memory { needed, permitted } => {
                let gibibytes = |bytes: u64| bytes as f64 / f64::from(1 << 30);
                write!(
                    f,
                    "the texels would take about {:.1} GiB of memory, and {:.1} GiB are permitted: ask for \
                     fewer texels, or permit more memory",
                    gibibytes(*needed),
                    gibibytes(*permitted)
                )
            }
        }
    }
}

impl std::error::Error for BakeError {}

impl From<LayoutError> for BakeError {
    fn from(error: LayoutError) -> BakeError {
        match error {
            LayoutError::Cancelled => BakeError::Solve(SolveError::Cancelled),
            other => BakeError::Layout(other),
        }
    }
}

impl From<SolveError> for BakeError {
    fn from(error: SolveError) -> BakeError {
        BakeError::Solve(error)
    }
}

impl From<Cancelled> for BakeError {
    fn from(_: Cancelled) -> BakeError {
        BakeError::Solve(SolveError::Cancelled)
    }
}

/// A lightmap with what is known of it.
#[derive(Clone, Debug)]
pub struct Baked {
    /// Surfaces and their places.
    pub atlas: Atlas,
    /// The object of each receiver; where both sides receive, the backs come after all fronts.
    pub objects: Vec<u32>,
    /// The texels.
    pub lightmap: Lightmap,
    /// The radiance above the texels as coefficients of real spherical harmonics of bands 0 and 1, (0,0), (1,−1), (1,0),
    /// (1,1), in the axes of the scene, W/(sr·m²): one lightmap for each, with their standard errors, that hold them in
    /// place of irradiance. If they are asked for.
    pub harmonics: Option<Box<[Lightmap; DIRECTIONAL]>>,
    /// How they were computed.
    pub texels: SiteStatistics,
    /// The light between patches, if any was solved.
    pub report: Option<Report>,
    /// Differences along seams.
    pub seams: SeamErrors,
    /// Share of the area that is seen from both sides, of which one has the lightmap and the other has light that
    /// differs by more than a tenth.
    pub differing_sides: f64,
    /// How much more light texels have than the patches of the first pass at the same places, relative to that: 0 if
    /// both are right. 0 where part of the light is baked.
    pub beside_patches: f64,
    /// Root mean square of what interpolation between texels misses, W/m²: part of the standard errors.
    pub between_texels: f64,
    /// Whether charts with edges of shadows have more texels than others.
    pub follows_light: bool,
}

/// Bakes the lightmap of a scene of meshes: the objects that are listed receive. Where options have something for
/// each of them, all of them are meshes.
///
/// A `&Progress` is a run of one process. Processes that talk to each other all get the
/// lightmap, with the bits of one process. Parts that never meet need a number of rays without an error, see
/// [`BakeOptions::pass`]: a process of one that does not make the result ends with [`SolveError::Elsewhere`].
///
/// # Errors
/// [`BakeError`].
pub fn bake<'r>(
    scene: &Scene,
    tracer: &Tracer,
    objects: &[u32],
    options: &BakeOptions,
    run: impl Into<Run<'r>>,
) -> Result<Baked, BakeError> {
    let run = run.into();
    let proxy = ProxyScene::new(scene, tracer, options.pass.size);
    let charts = Charts::new(&proxy, objects, options, run)?;
    let started = Instant::now();
    let samples = charts.samples(run)?;
    let finishing = started.elapsed().mul_f64(FINISHING);
    run.progress.reserve(finishing);
    let light = charts.light(&samples, options, run)?;
    let (texels, beside_patches) = (light.texels, charts.beside_patches(&samples, &light));
    let pages = Pages::new(&charts, &samples, light, options, run)?;
    Ok(Baked {
        lightmap: pages.lightmap,
        harmonics: pages.harmonics,
        texels,
        report: Some(charts.solved.report()),
        seams: pages.seams,
        differing_sides: charts.differing_sides(options.sides),
        beside_patches: match options.light {
            BakedLight::Total => beside_patches,
            BakedLight::Indirect | BakedLight::Direct => 0.0,
        },
        between_texels: pages.between_texels,
        follows_light: charts.follows_light,
        atlas: charts.atlas,
        objects: charts.objects,
    })
}

/// A scene of meshes alone, for models that are written anew; if wished, cut along the lines on which one
/// thing stands on another, so that charts can end there. Instances share their mesh, which stays whole. Light on
/// vertices is left out.
pub fn meshes_of(scene: &Scene, cuts_contacts: bool) -> Scene {
    // The size of a letter counts, not of its whole line.
    let size = |exact: &Exact| {
        let sizes = exact.solids.iter().map(|s| s.bounds().diagonal());
        sizes.fold(0.0, f64::max)
    };
    let faceted = scene.faceted_by(|exact| CHORD_ERROR * size(exact));
    let mut meshes = faceted.into_owned();
    for object in &mut meshes.objects {
        if let Shape::Primitive(primitive) = &object.shape {
            let chord_error = CHORD_ERROR * primitive.bounds().diagonal();
            let grids = primitive.grids(chord_error, f64::INFINITY);
            object.shape = Shape::Mesh(primitive.tessellate(&grids));
        }
        forget_light(&mut object.shape);
    }
    if !cuts_contacts {
        return meshes;
    }
    let edge = meshes.bounds().diagonal() / CUTS;
    let patches = Patches::new(&meshes, PatchSize::Edge(edge));
    let mut cut = meshes.clone();
    for (number, object) in cut.objects.iter_mut().enumerate() {
        if let Shape::Mesh(_) = &object.shape
            && let RefinedShape::Mesh(mesh) = patches.refined(number as u32, &meshes)
        {
            object.shape = Shape::Mesh(mesh);
        }
    }
    cut
}

/// Removes light on vertices: files would have it beside that of the lightmap.
fn forget_light(shape: &mut Shape) {
    match shape {
        Shape::Mesh(mesh) => {
            mesh.irradiance.clear();
            mesh.irradiance_error.clear();
            mesh.back = None;
        }
        Shape::Instance(instance) => instance.light = None,
        Shape::Primitive(_) | Shape::Exact(_) => {}
    }
}

impl Baked {
    /// Irradiance as a viewer reads it at a point of a receiver's triangle, W/m².
    pub fn irradiance(&self, receiver: usize, triangle: usize, weights: [f64; 3]) -> Option<Rgb> {
        let layout = &self.atlas.layout.receivers[receiver];
        if layout.charts[triangle] == NO_CHART {
            return None;
        }
        let uvs = layout.uvs[triangle];
        let uv = [0, 1].map(|k| (0..3).map(|c| weights[c] * f64::from(uvs[c][k])).sum());
        let page: &LightmapPage = &self.lightmap.pages[layout.pages[triangle] as usize];
        Some(page.bilinear(uv))
    }
}
