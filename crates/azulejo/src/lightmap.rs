//! Lightmaps of scenes: charts, light of the solved first pass in their texels, and padding.
//!
//! [`bake`] is the third pass beside the picture: `azulejo-bake` knows texels, `azulejo-radiosity` knows
//! light, and here the two meet. A [`BakeSource`] is the scene with the glTF file that gets its lightmap.

mod brightness;
mod facing;
mod indirect;
mod occlusion;
mod radiance;
mod sides;
mod source;

pub use brightness::{BytePicture, BytePictures};
pub use occlusion::bake_occlusion;
pub use radiance::TexelRadiance;
pub use source::{BakeSource, SourceError, SourceFile};

use azulejo_bake::{
    Atlas, BetweenTexels, Layout, LayoutError, Lightmap, LightmapPage, Receiver, ReceiverLayout,
    Samples, SeamErrors, ShownSamples, TexelField, TexelStatistics, UnwrapOptions,
    layout::NO_CHART,
};
use azulejo_factors::{PatchSize, Patches, ProxyScene, RefinedShape};
use azulejo_radiosity::{FirstPass, Report, SolveError, SolvedLight};
use azulejo_scene::{Exact, Rgb, Scene, Shape};
use azulejo_trace::run::digest;
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, GatherPoint, Progress, Run, Tracer};
use indirect::{IndirectLight, SampleLight};
use sides::{differing_share, lit_backs, power_beside_patches, turned};
use std::fmt;

/// Chord error of tessellated primitives, relative to their size.
const CHORD_ERROR: f64 = 1e-3;

/// Longest edge of faces that are cut, as a part of the scene: contacts of a twentieth of that count.
const CUTS: f64 = 8.0;

/// Memory of a texel, and what one that covers a surface takes beside that, bytes: measured.
const BYTES_PER_TEXEL: f64 = 100.0;
const BYTES_PER_COVERED: f64 = 400.0;

/// The same beside that where light is gathered at every texel: in a process that computes a part of it, and in one
/// that puts all of it together.
const BYTES_PER_GATHERED: [f64; 2] = [400.0, 700.0];

/// Mean square error at edges of shadows, relative to that of even texels, with which it is worth that charts of even
/// light have fewer.
const WORTH_REPACKING: f64 = 0.9;

/// Error where none is requested.
const DEFAULT_ERROR: f64 = 0.03;

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
    /// with so many rays at every texel, and not interpolated; otherwise rays are those of patches.
    pub pass: FirstPass,
    /// Which light.
    pub light: BakedLight,
    /// Which sides.
    pub sides: BakedSides,
}

impl BakeOptions {
    /// Rays of every texel, where their number is given and no error.
    fn fixed_rays(&self, progress: &Progress) -> Option<u32> {
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
    /// How they were computed.
    pub texels: TexelStatistics,
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
    let progress = run.progress;
    let proxy = ProxyScene::new(scene, tracer, options.pass.size);
    let (mut receivers, mut objects) = receivers_of(&proxy.scene, objects, &options.densities);
    let fronts = receivers.len();
    // Which backs get light is known from the solution alone; otherwise charts come first, as they may not fit.
    let mut solved = None;
    if options.sides == BakedSides::Both {
        let light = solved_light(&proxy, options, run)?;
        for (receiver, object) in lit_backs(&receivers, &objects, &proxy.scene, &light) {
            receivers.push(receiver);
            objects.push(object);
        }
        solved = Some(light);
    }
    let mut atlas = arranged(receivers, options, &proxy.tracer, run)?;
    let solved = match solved {
        Some(solved) => solved,
        None => solved_light(&proxy, options, run)?,
    };
    let turn =
        |atlas: &Atlas| turned_charts(atlas, fronts, &objects, &proxy.scene, &solved, options);
    atlas.turned = turn(&atlas)?;
    let differing_sides = match options.sides {
        BakedSides::Both => 0.0,
        _ => differing_share(&atlas.receivers, &objects, &proxy.scene, &solved),
    };
    let gatherer = solved.gatherer();
    let surfaces = gatherer.surfaces();
    let error = options.pass.error.unwrap_or(DEFAULT_ERROR);
    let seed = hash(&[
        options.pass.seed as u32,
        (options.pass.seed >> 32) as u32,
        3,
    ]);
    let mut follows_light = false;
    if options.follows_light
        && options.coordinates == Coordinates::New
        && let Some(layout) = following_layout(&atlas, &solved, &proxy.tracer, options, seed, run)?
    {
        atlas.layout = layout;
        atlas.turned = turn(&atlas)?;
        follows_light = true;
    }
    // The light of all texels, of which direct and indirect light stay apart.
    let samples = agreed_samples(&atlas, surfaces.tracer, run)?;
    let indirect_to = |error: f64| IndirectLight {
        solved: &solved,
        bounces: options.pass.bounces,
        error,
        run,
    };
    let light = match options.fixed_rays(progress) {
        Some(rays) => indirect_to(error).with_rays(&atlas, &samples, rays, seed)?,
        None => indirect_to(error).to_error(&atlas, &objects, &samples, options.light, seed)?,
    };
    let SampleLight {
        direct,
        all: mut light,
        texels,
        error,
    } = light;
    let indirect = indirect_to(error);
    let power = power_beside_patches(&atlas, &objects, &proxy.scene, &solved, (&samples, &light));
    let beside_patches = match options.light {
        BakedLight::Total if power[0] > 0.0 => power[1] / power[0] - 1.0,
        _ => 0.0,
    };
    let field = (options.light != BakedLight::Direct)
        .then(|| TexelField::new(&atlas, &samples, &light, &objects, surfaces));
    if options.light == BakedLight::Indirect {
        direct.take_from(&mut light);
    }
    // Pages of what viewers read, with borders of charts and seams.
    let shown = ShownSamples::new(&samples, &light, surfaces);
    let mut lightmap = shown.lightmap(&samples, &light);
    for page in &mut lightmap.pages {
        azulejo_bake::pad_charts(page, options.charts.padding);
    }
    let seams = azulejo_bake::stitch(&mut lightmap, &atlas);
    if options.light != BakedLight::Indirect {
        direct.take_from(&mut light);
    }
    // What interpolation between texels misses, as part of their errors.
    let between = BetweenTexels {
        atlas: &atlas,
        samples: &samples,
        shown: &shown,
        direct: &direct,
        rest: &light,
        gatherer,
        error,
        seed,
    };
    let rest = between.rest_of(options.charts.padding);
    let mut between_texels = 0.0_f64;
    if options.light != BakedLight::Indirect {
        between_texels = between.add_direct(&mut lightmap, &rest, run)?;
    }
    if let Some(field) = &field {
        let mut gather = |points: &[GatherPoint]| indirect.at(points, field);
        let missed = between.add_indirect(&mut lightmap, &rest, &mut gather)?;
        between_texels = between_texels.hypot(missed);
    }
    for page in &mut lightmap.pages {
        azulejo_bake::fill(page);
    }
    Ok(Baked {
        atlas,
        objects,
        lightmap,
        texels,
        report: Some(solved.report()),
        seams,
        differing_sides,
        beside_patches,
        between_texels,
        follows_light,
    })
}

/// Whether each chart of an atlas shows the back of its surface.
fn turned_charts(
    atlas: &Atlas,
    fronts: usize,
    objects: &[u32],
    scene: &Scene,
    solved: &SolvedLight<'_>,
    options: &BakeOptions,
) -> Result<Vec<bool>, Cancelled> {
    Ok(match options.sides {
        BakedSides::Front => Vec::new(),
        BakedSides::Brighter => turned(atlas, objects, scene, solved)?,
        BakedSides::Both => {
            let mut is_turned = vec![false; atlas.layout.charts as usize];
            let backs = atlas.layout.receivers[fronts..].iter();
            for &chart in backs.flat_map(|r| &r.charts).filter(|c| **c != NO_CHART) {
                is_turned[chart as usize] = true;
            }
            is_turned
        }
    })
}

/// The layout in which charts with edges of shadows have more texels than others, if errors are less with it.
fn following_layout(
    atlas: &Atlas,
    solved: &SolvedLight<'_>,
    tracer: &Tracer,
    options: &BakeOptions,
    seed: u32,
    run: Run,
) -> Result<Option<Layout>, BakeError> {
    let error = options.pass.error.unwrap_or(DEFAULT_ERROR);
    let importance = azulejo_bake::chart_importance(atlas, solved.gatherer(), error, seed, run)?;
    let (receivers, even) = (&atlas.receivers, &atlas.layout);
    let followed = azulejo_bake::repack_charts(
        receivers,
        even,
        &importance.densities,
        tracer,
        &options.charts,
        run.progress,
    )?;
    // Charts of many sizes fill less of a page.
    let error_in = |layout: &Layout| importance.shadow_error(layout, even, receivers);
    let is_better = error_in(&followed) < WORTH_REPACKING * error_in(even);
    Ok(is_better.then_some(followed))
}

/// The light between patches, on which processes that share the work agree.
fn solved_light<'a>(
    proxy: &'a ProxyScene<'a>,
    options: &BakeOptions,
    run: Run<'a>,
) -> Result<SolvedLight<'a>, SolveError> {
    let solved = SolvedLight::new(proxy, &options.pass, run)?;
    solved.agree()?;
    Ok(solved)
}

/// The points of all texels. Processes that share the work divide it by the numbers of points, so all of them must
/// have the same.
fn agreed_samples(atlas: &Atlas, tracer: &Tracer, run: Run) -> Result<Samples, Cancelled> {
    let samples = Samples::new(atlas, tracer, run)?;
    if run.is_shared() {
        let places = samples.samples.iter().map(|s| (s.position, s.normal));
        let numbers = places.flat_map(|(p, n)| [p.x, p.y, p.z, n.x, n.y, n.z]);
        run.blocks
            .rely_on(run.blocks.loop_stage(), digest(numbers))?;
    }
    Ok(samples)
}

/// The objects that receive, and their numbers.
fn receivers_of(scene: &Scene, objects: &[u32], densities: &[f64]) -> (Vec<Receiver>, Vec<u32>) {
    let receiver = |(place, &o): (usize, &u32)| {
        let mut receiver = Receiver::of_object(&scene.objects[o as usize])?;
        receiver.density = densities.get(place).copied().unwrap_or(1.0);
        Some((receiver, o))
    };
    objects.iter().enumerate().filter_map(receiver).unzip()
}

/// The receivers with their charts, if there is room for the texels.
fn arranged(
    receivers: Vec<Receiver>,
    options: &BakeOptions,
    tracer: &Tracer,
    run: Run,
) -> Result<Atlas, BakeError> {
    let layout = laid_out(&receivers, options, tracer, run.progress)?;
    let bytes_per_covered = match options.fixed_rays(run.progress) {
        Some(_) => BYTES_PER_COVERED + BYTES_PER_GATHERED[usize::from(run.role().assembles)],
        None => BYTES_PER_COVERED,
    };
    let needed = memory_of(&layout, bytes_per_covered);
    if needed > options.pass.memory {
        return Err(BakeError::Memory {
            needed,
            permitted: options.pass.memory,
        });
    }
    Ok(Atlas {
        receivers,
        layout,
        turned: Vec::new(),
    })
}

/// Memory that the texels of a layout take while they are baked, bytes, about.
fn memory_of(layout: &Layout, bytes_per_covered: f64) -> u64 {
    let (mut texels, mut covered) = (0.0, 0.0);
    for [width, height] in &layout.pages {
        texels += f64::from(*width) * f64::from(*height);
    }
    for receiver in &layout.receivers {
        for (uvs, &page) in receiver.uvs.iter().zip(&receiver.pages) {
            let [width, height] = layout.pages[page as usize].map(f64::from);
            let [a, b, c] = uvs.map(|uv| uv.map(f64::from));
            let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            covered += 0.5 * area.abs() * width * height;
        }
    }
    (texels * BYTES_PER_TEXEL + covered * bytes_per_covered) as u64
}

/// The layout of the receivers, made or kept.
fn laid_out(
    receivers: &[Receiver],
    options: &BakeOptions,
    tracer: &Tracer,
    progress: &Progress,
) -> Result<Layout, LayoutError> {
    let charts = &options.charts;
    match &options.coordinates {
        Coordinates::New => azulejo_bake::unwrap(receivers, tracer, charts, progress),
        Coordinates::Kept { of_objects, pages } => Ok(azulejo_bake::kept_layout(
            receivers,
            of_objects.clone(),
            pages.clone(),
            charts.crease,
            Some(tracer),
        )),
        Coordinates::Repacked(of_objects) => {
            azulejo_bake::repack(receivers, of_objects, tracer, charts, progress)
        }
    }
}

/// A scene of meshes alone, for models that are written anew; if wished, cut along the lines on which one
/// thing stands on another, so that charts can end there. Instances share their mesh, which stays whole.
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
