//! Charts for surfaces that have none that a lightmap could use, packed on pages.

use crate::Receiver;
use crate::layout::{Layout, NO_CHART, ReceiverLayout};
use crate::thin;
use crate::unwrap_mesh::UnwrapMesh;
use azulejo_trace::time::Instant;
use azulejo_trace::{Cancelled, Progress, Tracer};
use std::collections::BTreeSet;
use std::fmt;
use std::sync::atomic::{AtomicUsize, Ordering};
use uvunwrap::{Atlas, Density, MeshInput, Options, OutputMesh, Packing, Stage};

/// Largest width and height of a page, texels: what graphics cards take.
pub const MOST_SIZE: u32 = 16_384;

/// Share of a page that charts of usual scenes fill, when pages are counted in advance.
const USUAL_COVERAGE: f64 = 0.5;

/// Texels of charts that are only looked at.
const FEW_TEXELS: f64 = 65_536.0;

/// Fewest charts that are packed in rows: by shape, thousands of them take tens of seconds.
const MOST_SHAPED: usize = 40_000;

/// Part of the time until a deadline after which charts are packed in rows, if they are not packed by shape.
const PACKING_SHARE: f64 = 0.1;

/// How finely and where charts are laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnwrapOptions {
    /// How many texels there are.
    pub resolution: Resolution,
    /// Width and height of a page, texels; the largest with [`Resolution::PerUnit`].
    pub size: u32,
    /// Number of pages to divide the receivers among; more are used where one resolution asks for
    /// more texels than fit.
    pub pages: u32,
    /// Empty texels around each chart: charts are twice as far apart.
    pub padding: u32,
    /// Whether charts keep to blocks of 4 × 4 texels, for compressed formats.
    pub blocks: bool,
    /// Charts end at edges with a larger angle between the normals, degrees.
    pub crease: f64,
}

impl Default for UnwrapOptions {
    fn default() -> UnwrapOptions {
        UnwrapOptions {
            resolution: Resolution::Fill,
            size: 1024,
            pages: 1,
            padding: 2,
            blocks: false,
            crease: 30.0,
        }
    }
}

/// How many texels a lightmap has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resolution {
    /// As many as fit the pages.
    Fill,
    /// So many per scene unit of length, on as many pages as that takes.
    PerUnit(f64),
    /// About so many that cover surfaces, on as many pages as that takes.
    Texels(f64),
}

impl Resolution {
    /// Width and height of a page where none is given, texels: of one that is filled, or of the largest one.
    pub fn page_size(self) -> u32 {
        match self {
            Resolution::Fill => 1024,
            Resolution::PerUnit(_) | Resolution::Texels(_) => 8192,
        }
    }

    /// Texels per scene unit; `None` for as many as fit.
    fn density(self, receivers: &[Receiver]) -> Option<f64> {
        let area: f64 = receivers.iter().map(|r| r.area() * r.density.powi(2)).sum();
        match self {
            Resolution::Fill => None,
            Resolution::PerUnit(density) => Some(density),
            Resolution::Texels(texels) => Some((texels / area.max(f64::MIN_POSITIVE)).sqrt()),
        }
    }
}

/// Why there is no layout.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum LayoutError {
    /// There is no triangle with an area.
    NoSurface,
    /// The size of pages is not within 1 + 2 × padding and [`MOST_SIZE`].
    PageSize {
        /// The size.
        size: u32,
        /// The smallest that could hold a chart.
        least: u32,
    },
    /// There are more charts than the pages have room for, each with its padding.
    TooManyCharts {
        /// Size of a page, texels.
        size: u32,
        /// A size that would do; there may be no pages so large.
        enough: u32,
    },
    /// At the requested texels per unit the charts of one object need a larger page.
    PageTooLarge {
        /// Largest size of a page, texels.
        size: u32,
        /// What the object needs.
        needed: u32,
    },
    /// At the requested texels per unit a lightmap is larger than all memory.
    TooDense {
        /// The texels that it would have.
        texels: f64,
    },
    /// The unwrapper failed for a reason of its own.
    Unwrapper(String),
    /// The caller cancelled.
    Cancelled,
}

impl fmt::Display for LayoutError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LayoutError::NoSurface => {
                f.write_str("there is no triangle with an area that could receive a lightmap")
            }
            LayoutError::PageSize { size, least } => {
                write!(f, "pages of {size} texels: expected {least} to {MOST_SIZE}")
            }
            LayoutError::TooManyCharts { size, enough } => {
                write!(
                    f,
                    "there are more charts than a page of {size} × {size} texels has room for, with their \
                     padding: ask for "
                )?;
                if *enough <= MOST_SIZE {
                    write!(f, "a size of {enough} texels, ")?;
                }
                f.write_str("more pages, or less padding")
            }
            LayoutError::PageTooLarge { size, needed } => write!(
                f,
                "at this resolution the charts of one object need a page of {needed} texels, and the largest \
                 has {size}: ask for fewer texels, a larger --size, or divide the object"
            ),
            LayoutError::TooDense { texels } => write!(
                f,
                "a lightmap of {texels:.3e} texels is too large: ask for fewer texels per metre"
            ),
            LayoutError::Unwrapper(what) => write!(f, "no charts could be made: {what}"),
            LayoutError::Cancelled => f.write_str("cancelled"),
        }
    }
}

impl std::error::Error for LayoutError {}

impl From<Cancelled> for LayoutError {
    fn from(_: Cancelled) -> LayoutError {
        LayoutError::Cancelled
    }
}

/// Most texels of a lightmap.
const MOST_TEXELS: f64 = (1u64 << 30) as f64;

/// Cuts the receivers into charts and packs these on pages. Charts end at creases, and at edges of
/// triangles on which `tracer` finds something standing.
///
/// # Errors
/// [`LayoutError`].
pub fn unwrap(
    receivers: &[Receiver],
    tracer: &Tracer,
    options: &UnwrapOptions,
    progress: &Progress,
) -> Result<Layout, LayoutError> {
    let meshes = receivers
        .iter()
        .map(|r| UnwrapMesh::new(r, options.crease, tracer))
        .collect();
    laid_out_on_pages(receivers, meshes, options, progress)
}

/// Packs charts that receivers have already, such as several meshes that fill a page each: their shapes stay, but
/// for turns and the size. `coordinates` has the `uvs` of each receiver. Charts that fold or overlap are
/// made anew.
///
/// # Errors
/// [`LayoutError`].
pub fn repack(
    receivers: &[Receiver],
    coordinates: &[ReceiverLayout],
    tracer: &Tracer,
    options: &UnwrapOptions,
    progress: &Progress,
) -> Result<Layout, LayoutError> {
    let meshes = receivers
        .iter()
        .zip(coordinates)
        .map(|(r, c)| UnwrapMesh::new(r, options.crease, tracer).with_uvs(&c.uvs))
        .collect();
    laid_out_on_pages(receivers, meshes, options, progress)
}

/// Packs the charts of a layout anew, each with its own texels per length relative to others, `densities`.
///
/// # Errors
/// [`LayoutError`].
pub fn repack_charts(
    receivers: &[Receiver],
    layout: &Layout,
    densities: &[f64],
    tracer: &Tracer,
    options: &UnwrapOptions,
    progress: &Progress,
) -> Result<Layout, LayoutError> {
    let count: usize = receivers.iter().map(|r| r.triangles.len()).sum();
    progress.begin("charts", count as u64);
    // Charts of nearly the same density are packed as one mesh.
    let class_of = |chart: u32| (DENSITY_CLASSES * densities[chart as usize].log2()).round() as i32;
    // The shapes of charts stay: meshes have the coordinates of the given layout.
    let meshes: Vec<UnwrapMesh> = receivers
        .iter()
        .enumerate()
        .map(|(r, receiver)| {
            let corners = |t: usize| layout.texels(r, t).map(|c| c.as_vec2().to_array());
            let uvs: Vec<_> = (0..receiver.triangles.len()).map(corners).collect();
            UnwrapMesh::new(receiver, options.crease, tracer).with_uvs(&uvs)
        })
        .collect();
    let none = |mesh: &UnwrapMesh| ReceiverLayout {
        uvs: vec![[[0.0; 2]; 3]; mesh.parts.len()],
        charts: vec![NO_CHART; mesh.parts.len()],
        pages: vec![0; mesh.parts.len()],
        cuts: mesh.seams.clone(),
    };
    let mut packed_layout = Layout {
        receivers: meshes.iter().map(none).collect(),
        ..Layout::default()
    };
    // Pack each page anew, as members with one class of one receiver each.
    for page in 0..layout.pages.len() as u32 {
        let is_on_page = |r: &usize| {
            let of_receiver = &layout.receivers[*r];
            let mut charts = of_receiver.pages.iter().zip(&of_receiver.charts);
            charts.any(|(p, chart)| *p == page && *chart != NO_CHART)
        };
        let mut members = Vec::new();
        for receiver in (0..receivers.len()).filter(is_on_page) {
            let charts = &layout.receivers[receiver].charts;
            let charted = charts.iter().filter(|chart| **chart != NO_CHART);
            for class in charted
                .map(|&chart| class_of(chart))
                .collect::<BTreeSet<i32>>()
            {
                let is_other = |&chart: &u32| chart == NO_CHART || class_of(chart) != class;
                members.push(Member {
                    receiver,
                    omitted: Some(charts.iter().map(is_other).collect()),
                    density: receivers[receiver].density
                        * (f64::from(class) / DENSITY_CLASSES).exp2(),
                });
            }
        }
        if members.is_empty() {
            continue;
        }
        let inputs: Vec<MeshInput> = members.iter().map(|member| member.input(&meshes)).collect();
        let density = options.resolution.density(receivers);
        let atlas = packed(&inputs, density, options, progress)?;
        packed_layout.add_page(&members, &meshes, &atlas, options);
    }
    Ok(packed_layout)
}

/// Classes of density per doubling: charts of a class are packed as one mesh.
const DENSITY_CLASSES: f64 = 2.0;

/// A mesh, or some of its charts, on a page.
struct Member {
    receiver: usize,
    /// The triangles that belong to other members; `None` if none do.
    omitted: Option<Vec<bool>>,
    density: f64,
}

impl Member {
    fn input<'m>(&'m self, meshes: &'m [UnwrapMesh]) -> MeshInput<'m> {
        let whole = meshes[self.receiver].input(self.density);
        match &self.omitted {
            Some(omitted) => MeshInput {
                ignored_faces: Some(omitted),
                ..whole
            },
            None => whole,
        }
    }
}

/// Cuts meshes into charts and packs these.
fn laid_out_on_pages(
    receivers: &[Receiver],
    mut meshes: Vec<UnwrapMesh>,
    options: &UnwrapOptions,
    progress: &Progress,
) -> Result<Layout, LayoutError> {
    let least = 1 + 2 * options.padding;
    if !(least..=MOST_SIZE).contains(&options.size) {
        let size = options.size;
        return Err(LayoutError::PageSize { size, least });
    }
    if meshes.iter().all(|m| m.ignored.iter().all(|&i| i)) {
        return Err(LayoutError::NoSurface);
    }
    let count: usize = receivers.iter().map(|r| r.triangles.len()).sum();
    progress.begin("charts", count as u64);
    for (mesh, receiver) in meshes.iter_mut().zip(receivers) {
        divide_folds(mesh, receiver, progress)?;
    }
    let density = options.resolution.density(receivers);
    let mut pages = page_count(receivers, density, options)?;
    loop {
        match on_pages(receivers, &meshes, pages, options, progress) {
            // Charts fill less of a page than usual.
            Err(LayoutError::PageTooLarge { .. }) if pages < receivers.len() => pages *= 2,
            result => return result,
        }
    }
}

/// Packs the charts of meshes on this many pages.
fn on_pages(
    receivers: &[Receiver],
    meshes: &[UnwrapMesh],
    pages: usize,
    options: &UnwrapOptions,
    progress: &Progress,
) -> Result<Layout, LayoutError> {
    let density = options.resolution.density(receivers);
    let mut layout = Layout {
        receivers: vec![ReceiverLayout::default(); receivers.len()],
        ..Layout::default()
    };
    for members in page_members(receivers, pages) {
        let member = |receiver: usize| Member {
            receiver,
            omitted: None,
            density: receivers[receiver].density,
        };
        let members: Vec<Member> = members.into_iter().map(member).collect();
        let inputs: Vec<MeshInput> = members.iter().map(|member| member.input(meshes)).collect();
        let atlas = packed(&inputs, density, options, progress)?;
        layout.add_page(&members, meshes, &atlas, options);
    }
    Ok(layout)
}

/// Divides the charts of a mesh that would fold over an edge at which they should end: makes charts once, to see
/// which.
fn divide_folds(
    mesh: &mut UnwrapMesh,
    receiver: &Receiver,
    progress: &Progress,
) -> Result<(), LayoutError> {
    let density = (FEW_TEXELS / receiver.area()).sqrt() as f32;
    if !density.is_normal() || !mesh.may_fold() {
        return Ok(());
    }
    let options = Options {
        density: Density::Fixed {
            texels_per_unit: density,
            page_size: None,
        },
        padding: 0,
        packing: Packing::Fast,
        ..Options::default()
    };
    let report = |_: uvunwrap::Progress| progress.advance(0).is_ok();
    match uvunwrap::generate_with_progress(&[mesh.input(1.0)], &options, report) {
        Ok(atlas) => {
            let layout = laid_out(&atlas.meshes[0], mesh.parts.len(), 0, 0, [1.0; 2]);
            mesh.divide(&layout.charts);
            Ok(())
        }
        Err(uvunwrap::Error::Cancelled) => Err(LayoutError::Cancelled),
        // What is wrong will be said when charts are made for good.
        Err(_) => Ok(()),
    }
}

/// Pages that the resolution asks for.
fn page_count(
    receivers: &[Receiver],
    density: Option<f64>,
    options: &UnwrapOptions,
) -> Result<usize, LayoutError> {
    let Some(density) = density else {
        return Ok(options.pages.max(1) as usize);
    };
    let texels: f64 = receivers
        .iter()
        .map(|r| r.area() * (density * r.density).powi(2))
        .sum();
    if texels.is_nan() || texels > MOST_TEXELS {
        return Err(LayoutError::TooDense { texels });
    }
    let room = USUAL_COVERAGE * f64::from(options.size).powi(2);
    Ok((texels / room).ceil().max(options.pages.into()) as usize)
}

/// Divides the receivers among pages by area, the largest first to where there is most room left.
fn page_members(receivers: &[Receiver], pages: usize) -> Vec<Vec<usize>> {
    let weight = |r: &Receiver| r.area() * r.density.powi(2);
    let weights: Vec<f64> = receivers.iter().map(weight).collect();
    let mut order: Vec<usize> = (0..receivers.len()).collect();
    order.sort_by(|&a, &b| weights[b].total_cmp(&weights[a]).then(a.cmp(&b)));
    let mut members = vec![Vec::new(); pages.clamp(1, receivers.len().max(1))];
    let mut filled = vec![0.0; members.len()];
    for r in order {
        let emptiest = (0..filled.len()).min_by(|&a, &b| f64::total_cmp(&filled[a], &filled[b]));
        let page = emptiest.unwrap_or(0);
        filled[page] += weights[r];
        members[page].push(r);
    }
    members.iter_mut().for_each(|m| m.sort_unstable());
    members.retain(|m| !m.is_empty());
    members
}

/// One page of charts.
fn packed(
    inputs: &[MeshInput],
    density: Option<f64>,
    options: &UnwrapOptions,
    progress: &Progress,
) -> Result<Atlas, LayoutError> {
    let triangles: usize = inputs.iter().map(|m| m.indices.len() / 3).sum();
    let density = match density {
        None => Density::Auto {
            page_size: options.size,
        },
        Some(density) => Density::Fixed {
            texels_per_unit: density as f32,
            page_size: None,
        },
    };
    let packing = if triangles > MOST_SHAPED {
        Packing::Fast
    } else {
        Packing::Shape
    };
    let settings = Options {
        density,
        padding: options.padding,
        block_align: options.blocks,
        packing,
        ..Options::default()
    };
    // Packing by shape must leave the most of the time to light.
    let most = progress.time_left().map(|left| left.mul_f64(PACKING_SHARE));
    let started = Instant::now();
    let is_late = || most.is_some_and(|most| started.elapsed() > most);
    let flattened = AtomicUsize::new(0);
    let report = |settings: &Options, p: uvunwrap::Progress| match p.stage {
        Stage::Parameterizing => {
            let before = flattened.swap(p.done, Ordering::Relaxed);
            progress
                .advance(p.done.saturating_sub(before) as u64)
                .is_ok()
        }
        _ => progress.advance(0).is_ok() && !(settings.packing == Packing::Shape && is_late()),
    };
    let unwrap = |settings: &Options| {
        uvunwrap::generate_with_progress(inputs, settings, |p| report(settings, p))
    };
    let mut atlas = unwrap(&settings);
    if matches!(atlas, Err(uvunwrap::Error::Cancelled)) && is_late() {
        progress.advance(0)?;
        atlas = unwrap(&Options {
            packing: Packing::Fast,
            ..settings
        });
    }
    let atlas = atlas.map_err(|error| match error {
        uvunwrap::Error::Cancelled => LayoutError::Cancelled,
        uvunwrap::Error::ChartTooLarge { .. } => LayoutError::TooManyCharts {
            size: options.size,
            enough: 2 * options.size,
        },
        uvunwrap::Error::AtlasTooLarge { texels } => LayoutError::TooDense {
            texels: texels as f64,
        },
        other => LayoutError::Unwrapper(other.to_string()),
    })?;
    let needed = atlas.width.max(atlas.height);
    if needed > options.size {
        let size = options.size;
        return Err(LayoutError::PageTooLarge { size, needed });
    }
    if atlas.page_count > 1 {
        // Padding alone fills a page: the unwrapper goes on with pages of a low density.
        return Err(LayoutError::TooManyCharts {
            size: options.size,
            enough: enough(atlas.chart_count, options),
        });
    }
    Ok(atlas)
}

/// The next power of two that has room for so many charts of a texel each, larger than the size that has not.
fn enough(charts: u32, options: &UnwrapOptions) -> u32 {
    let cell = 1 + 2 * options.padding;
    let cell = if options.blocks {
        cell.next_multiple_of(4)
    } else {
        cell
    };
    let per_side = f64::from(charts).sqrt().ceil() as u32;
    let least = per_side.saturating_mul(cell).max(options.size + 1);
    least.min(1 << 31).next_power_of_two()
}

impl Layout {
    /// Adds a page with the charts of some receivers, or some of their charts.
    fn add_page(
        &mut self,
        members: &[Member],
        meshes: &[UnwrapMesh],
        atlas: &Atlas,
        options: &UnwrapOptions,
    ) {
        let page = self.pages.len() as u32;
        // The unwrapper crops a page to the rows in use.
        let size = match options.resolution {
            Resolution::Fill => [options.size; 2],
            _ => [atlas.width, atlas.height],
        };
        let scale = [
            f64::from(atlas.width) / f64::from(size[0]),
            f64::from(atlas.height) / f64::from(size[1]),
        ];
        self.pages.push(size);
        let first_chart = self.charts;
        for (member, mesh) in members.iter().zip(&atlas.meshes) {
            let r = member.receiver;
            let count = meshes[r].parts.len();
            let layout = laid_out(mesh, count, page, self.charts, scale);
            let of_receiver = &mut self.receivers[r];
            if of_receiver.charts.is_empty() {
                *of_receiver = layout;
                of_receiver.cuts.clone_from(&meshes[r].seams);
                continue;
            }
            // The unwrapper gives those that it ignores some place of another.
            let is_omitted = |t: usize| member.omitted.as_ref().is_some_and(|o| o[t]);
            for t in (0..count).filter(|&t| !is_omitted(t)) {
                of_receiver.uvs[t] = layout.uvs[t];
                of_receiver.charts[t] = layout.charts[t];
                of_receiver.pages[t] = page;
            }
        }
        self.charts += atlas.chart_count;
        let members: BTreeSet<usize> = members.iter().map(|member| member.receiver).collect();
        thin::widen(self, &members, page, first_chart);
    }
}

fn laid_out(
    mesh: &OutputMesh,
    triangles: usize,
    page: u32,
    first_chart: u32,
    scale: [f64; 2],
) -> ReceiverLayout {
    let mut layout = ReceiverLayout {
        pages: vec![page; triangles],
        ..ReceiverLayout::default()
    };
    for corners in mesh.indices.chunks_exact(3) {
        let vertices = [0, 1, 2].map(|k| mesh.vertices[corners[k] as usize]);
        let uv = |k: usize| {
            let [u, v] = vertices[k].uv;
            [
                (f64::from(u) * scale[0]) as f32,
                (f64::from(v) * scale[1]) as f32,
            ]
        };
        layout.uvs.push([0, 1, 2].map(uv));
        let charts = vertices.map(|v| v.chart);
        let is_charted = charts[0].is_some() && charts.iter().all(|c| *c == charts[0]);
        layout.charts.push(match charts[0] {
            Some(chart) if is_charted => first_chart + chart,
            _ => NO_CHART,
        });
    }
    layout
}
