//! Lightmaps of scenes: charts, light of the solved first pass in their texels, and padding.
//!
//! [`bake`] is the third pass beside the picture: `azulejo-bake` knows texels, `azulejo-radiosity` knows
//! light, and here the two meet. A [`BakeSource`] is the scene with the glTF file that gets its lightmap.

mod facing;
mod source;

pub use source::{BakeSource, SourceError, SourceFile};

mod radiance;

pub use radiance::TexelRadiance;

use azulejo_bake::{
    Atlas, BetweenTexels, IndirectGoal, Layout, Lightmap, LightmapPage, LookRequest, NodePair,
    PairRequest, Receiver, ReceiverLayout, SampleDirect, Samples, SeamErrors, ShownSamples,
    TexelField, TexelLight, TexelStatistics, UnwrapOptions,
};
use azulejo_bake::{LayoutError, layout::NO_CHART};
use azulejo_factors::{PatchSize, Patches, ProxyScene, RefinedShape};
use azulejo_radiosity::{
    FirstPass, IrradianceField, PairRange, PathPair, Report, SolveError, SolvedLight,
};
use azulejo_scene::{Rgb, Scene, Shape};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, DiffuseHit, GatherPoint, Gatherer, Progress, Tracer};
use std::fmt;

/// Share of the permitted error that is left to noise and patches beside interpolation.
const NOISE_SHARE: f64 = 0.85;

/// Rays per point of the first look at the light.
const FIRST_RAYS: u32 = 128;

/// Looks after the first, each corrected by paths: what patches leak into the dark, and miss where it is
/// bright, is hardly left in the light that the last gather reads.
const LOOKS: u32 = 2;

/// Chord error of tessellated primitives, relative to their size.
const CHORD_ERROR: f64 = 1e-3;

/// Longest edge of faces that are cut, as a part of the scene: contacts of a twentieth of that count.
const CUTS: f64 = 8.0;

/// Memory of a texel, and what one that covers a surface takes beside that, bytes: measured.
const BYTES_PER_TEXEL: f64 = 100.0;
const BYTES_PER_COVERED: f64 = 400.0;

/// Part of what texels are too coarse for that indirect light may be off by, whatever is asked: together
/// both are hardly more.
const BESIDE_RESOLUTION: f64 = 0.2;

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
    /// Of each chart the side that gets more light.
    Brighter,
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
    /// The first pass, with the error to reach.
    pub pass: FirstPass,
    /// Which light.
    pub light: BakedLight,
    /// Which sides.
    pub sides: BakedSides,
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
    /// The object of each receiver.
    pub objects: Vec<u32>,
    /// The texels.
    pub lightmap: Lightmap,
    /// How they were computed.
    pub texels: TexelStatistics,
    /// The light between patches.
    pub report: Report,
    /// Differences along seams.
    pub seams: SeamErrors,
    /// Root mean square of what interpolation between texels misses of direct light, W/m²: part of the standard
    /// errors. 0 where only indirect light is baked.
    pub between_texels: f64,
}

/// Bakes the lightmap of a scene of meshes: the objects that are listed receive. Where options have something for
/// each of them, all of them are meshes.
///
/// # Errors
/// [`BakeError`].
pub fn bake(
    scene: &Scene,
    tracer: &Tracer,
    objects: &[u32],
    options: &BakeOptions,
    progress: &Progress,
) -> Result<Baked, BakeError> {
    let proxy = ProxyScene::new(scene, tracer, options.pass.size);
    let receiver = |(place, &o): (usize, &u32)| {
        let mut receiver = Receiver::of_object(&proxy.scene.objects[o as usize])?;
        receiver.density = options.densities.get(place).copied().unwrap_or(1.0);
        Some((receiver, o))
    };
    let (receivers, objects): (Vec<Receiver>, Vec<u32>) =
        objects.iter().enumerate().filter_map(receiver).unzip();
    let layout = laid_out(&receivers, options, &proxy.tracer, progress)?;
    let mut atlas = Atlas {
        receivers,
        layout,
        turned: Vec::new(),
    };
    let needed = memory_of(&atlas.layout);
    if needed > options.pass.memory {
        return Err(BakeError::Memory {
            needed,
            permitted: options.pass.memory,
        });
    }
    let solved = SolvedLight::new(&proxy, &options.pass, progress)?;
    if options.sides == BakedSides::Brighter {
        atlas.turned = turned(&atlas, &objects, &proxy.scene, &solved);
    }
    let gatherer = solved.gatherer();
    let surfaces = gatherer.surfaces();
    let samples = Samples::new(&atlas, surfaces.tracer, progress)?;
    let error = options.pass.error.unwrap_or(DEFAULT_ERROR);
    let seed = hash(&[
        options.pass.seed as u32,
        (options.pass.seed >> 32) as u32,
        3,
    ]);
    let direct = azulejo_bake::direct(&samples, &atlas, gatherer, error, seed, progress)?;
    let light = IndirectLight {
        solved: &solved,
        options,
        error,
        progress,
    };
    let (mut light, texels) = match options.light {
        BakedLight::Direct => (
            direct.light(),
            TexelStatistics {
                samples: samples.samples.len(),
                ..TexelStatistics::default()
            },
        ),
        _ => {
            let coarse =
                too_coarse_for(&atlas, &samples, &direct, (gatherer, error, seed), progress)?;
            let goal = IndirectGoal {
                relative: error,
                least: BESIDE_RESOLUTION * coarse,
            };
            light.of_texels(&atlas, &objects, (&samples, &direct), goal)?
        }
    };
    if options.light == BakedLight::Indirect {
        direct.take_from(&mut light);
    }
    let shown = ShownSamples::new(&samples, &light, surfaces);
    let mut lightmap = shown.lightmap(&samples, &light);
    for page in &mut lightmap.pages {
        azulejo_bake::pad_charts(page, options.charts.padding);
    }
    let seams = azulejo_bake::stitch(&mut lightmap, &atlas);
    let between = if options.light == BakedLight::Indirect {
        0.0
    } else {
        direct.take_from(&mut light);
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
        between.add_to(&mut lightmap, options.charts.padding, progress)?
    };
    for page in &mut lightmap.pages {
        azulejo_bake::fill(page);
    }
    Ok(Baked {
        atlas,
        objects,
        lightmap,
        texels,
        report: solved.report(),
        seams,
        between_texels: between,
    })
}

/// Root mean square of the direct light that texels are too coarse for, W/m², about.
fn too_coarse_for(
    atlas: &Atlas,
    samples: &Samples,
    direct: &SampleDirect,
    (gatherer, error, seed): (&Gatherer, f64, u32),
    progress: &Progress,
) -> Result<f64, Cancelled> {
    let light = direct.light();
    let shown = ShownSamples::new(samples, &light, gatherer.surfaces());
    let none = vec![TexelLight::default(); light.len()];
    let between = BetweenTexels {
        atlas,
        samples,
        shown: &shown,
        direct,
        rest: &none,
        gatherer,
        error,
        seed,
    };
    let mut lightmap = shown.lightmap(samples, &light);
    for page in &mut lightmap.pages {
        azulejo_bake::pad_charts(page, 1);
    }
    between.estimate(&lightmap, progress)
}

/// Memory that the texels of a layout take while they are baked, bytes, about.
fn memory_of(layout: &Layout) -> u64 {
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
    (texels * BYTES_PER_TEXEL + covered * BYTES_PER_COVERED) as u64
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
    let mut meshes = azulejo_factors::faceted(scene, PatchSize::Edge(0.0)).into_owned();
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

/// Where the indirect light of texels comes from.
struct IndirectLight<'a> {
    solved: &'a SolvedLight<'a>,
    options: &'a BakeOptions,
    error: f64,
    progress: &'a Progress,
}

impl IndirectLight<'_> {
    /// The light of all samples: a first look at that of patches, others at the look before, and the last, to
    /// the requested error.
    fn of_texels(
        &self,
        atlas: &Atlas,
        objects: &[u32],
        (samples, direct): (&Samples, &SampleDirect),
        goal: IndirectGoal,
    ) -> Result<(Vec<TexelLight>, TexelStatistics), BakeError> {
        let surfaces = self.solved.gatherer().surfaces();
        let mut look = |request: &LookRequest| {
            let range = PairRange {
                read: 0..FIRST_RAYS,
                traced: 0..0,
            };
            let found = self.pairs(request.points, None, &range, 0)?;
            Ok::<_, SolveError>(found.iter().map(|pair| pair.read).collect())
        };
        let (mut light, nodes) =
            azulejo_bake::first_look(samples, direct, goal, self.progress, &mut look)?;
        if self.options.pass.bounces.is_some() {
            let mut gather = |request: &PairRequest| self.limited(request);
            let found = azulejo_bake::with_indirect(
                samples,
                direct,
                nodes,
                goal,
                true,
                self.progress,
                &mut gather,
            )?;
            return Ok(found);
        }
        for number in 1..=LOOKS {
            if self.progress.out_of_time() {
                break;
            }
            let field = TexelField::new(atlas, samples, &light, objects, surfaces);
            drop(std::mem::take(&mut light));
            let mut gather = |request: &PairRequest| self.paired(request, &field, number);
            light = azulejo_bake::look_again(samples, direct, &nodes, &mut gather)?;
        }
        let field = TexelField::new(atlas, samples, &light, objects, surfaces);
        drop(light);
        let mut gather = |request: &PairRequest| self.paired(request, &field, LOOKS + 1);
        Ok(azulejo_bake::with_indirect(
            samples,
            direct,
            nodes,
            goal,
            false,
            self.progress,
            &mut gather,
        )?)
    }

    fn paired(
        &self,
        request: &PairRequest,
        field: &TexelField,
        look: u32,
    ) -> Result<Vec<NodePair>, SolveError> {
        let range = PairRange {
            read: request.read.clone(),
            traced: request.traced.clone(),
        };
        self.pairs(request.points, Some(&FieldOfTexels(field)), &range, look)
    }

    fn pairs(
        &self,
        points: &[GatherPoint],
        field: Option<&dyn IrradianceField>,
        range: &PairRange,
        look: u32,
    ) -> Result<Vec<NodePair>, SolveError> {
        let found = self
            .solved
            .path_pairs(points, field, range, look, self.progress)?;
        let pair = |pair: PathPair| NodePair {
            read: pair.read,
            few: pair.few,
            traced: pair.traced,
        };
        Ok(found.into_iter().map(pair).collect())
    }

    /// Where bounces are limited, all is path traced.
    fn limited(&self, request: &PairRequest) -> Result<Vec<NodePair>, SolveError> {
        let error = NOISE_SHARE * self.error;
        let found = self.solved.indirect(
            request.points,
            request.areas,
            error,
            LOOKS + 1,
            self.progress,
        )?;
        let node = |read| NodePair {
            read,
            ..NodePair::default()
        };
        Ok(found.into_iter().map(node).collect())
    }
}

/// Light of texels beside that of patches.
struct FieldOfTexels<'a>(&'a TexelField<'a>);

impl IrradianceField for FieldOfTexels<'_> {
    fn irradiance(&self, at: &DiffuseHit) -> Option<([f32; 3], f32)> {
        self.0.irradiance(at)
    }
}

/// For each triangle of a receiver its face, and its number in the face.
fn face_triangles(scene: &Scene, object: u32) -> Vec<[u32; 2]> {
    let mesh = scene.objects[object as usize].shape.mesh();
    let faces = mesh.map_or(0, |mesh| mesh.faces.len());
    let of_face = |face: usize| {
        let count = mesh.map_or(0, |mesh| mesh.faces.get(face).len() - 2);
        (0..count as u32).map(move |triangle| [face as u32, triangle])
    };
    (0..faces).flat_map(of_face).collect()
}

/// Of each chart whether its back gets more light.
fn turned(atlas: &Atlas, objects: &[u32], scene: &Scene, solved: &SolvedLight) -> Vec<bool> {
    let mut excess = vec![0.0; atlas.layout.charts as usize];
    for (r, receiver) in atlas.receivers.iter().enumerate() {
        let faces = face_triangles(scene, objects[r]);
        for (t, [face, triangle]) in faces.into_iter().enumerate() {
            let chart = atlas.layout.receivers[r].charts[t];
            if chart != NO_CHART {
                let place = [objects[r], face, triangle];
                let [front, back] = solved.sides_at(place, [1.0 / 3.0; 2]);
                let area = receiver.area_vector(t).length();
                excess[chart as usize] += area * (back - front).mean();
            }
        }
    }
    excess.into_iter().map(|e| e > 0.0).collect()
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
