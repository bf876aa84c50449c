//! The charts of a lightmap: which surfaces receive light, where each of them is on pages, and which side is shown.

use super::indirect::{IndirectLight, SampleLight};
use super::sides::{differing_share, lit_backs, power_beside_patches, turned};
use super::{BakeError, BakeOptions, BakedLight, BakedSides, Coordinates};
use azulejo_bake::layout::NO_CHART;
use azulejo_bake::{Atlas, Layout, LayoutError, Receiver, Samples};
use azulejo_factors::ProxyScene;
use azulejo_radiosity::{SolveError, SolvedLight};
use azulejo_scene::Scene;
use azulejo_trace::run::digest;
use azulejo_trace::{Cancelled, Progress, Run, Tracer};

/// Memory of a texel, and what one that covers a surface takes beside that, bytes: measured.
const BYTES_PER_TEXEL: f64 = 100.0;
const BYTES_PER_COVERED: f64 = 400.0;

/// The same beside that where light is gathered at every texel: in a process that computes a part of it, and in one
/// that puts all of it together.
const BYTES_PER_GATHERED: [f64; 2] = [400.0, 700.0];

/// What it takes beside that, for each texel and each that covers a surface, to ask where light comes from.
const BYTES_OF_DIRECTIONS: [f64; 2] = [140.0, 300.0];

/// Mean square error at edges of shadows, relative to that of even texels, with which it is worth that charts of even
/// light have fewer.
const WORTH_REPACKING: f64 = 0.9;

/// Surfaces with their places on pages, and the light between patches, by which sides and sizes of charts are chosen.
pub struct Charts<'a> {
    scene: &'a Scene,
    pub solved: SolvedLight<'a>,
    pub atlas: Atlas,
    /// The object of each receiver; where both sides receive, the backs come after all `fronts`.
    pub objects: Vec<u32>,
    fronts: usize,
    /// Whether charts with edges of shadows have more texels than others.
    pub follows_light: bool,
}

impl<'a> Charts<'a> {
    pub fn new(
        proxy: &'a ProxyScene<'a>,
        objects: &[u32],
        options: &BakeOptions,
        run: Run<'a>,
    ) -> Result<Charts<'a>, BakeError> {
        let (mut receivers, mut objects) = receivers_of(&proxy.scene, objects, &options.densities);
        let fronts = receivers.len();
        // Which backs get light is known from the solution alone; otherwise charts come first, as they may not fit.
        let mut solved = None;
        if options.sides == BakedSides::Both {
            let light = solved_light(proxy, options, run)?;
            for (receiver, object) in lit_backs(&receivers, &objects, &proxy.scene, &light) {
                receivers.push(receiver);
                objects.push(object);
            }
            solved = Some(light);
        }
        let atlas = arranged(receivers, options, &proxy.tracer, run)?;
        let mut charts = Charts {
            scene: &proxy.scene,
            solved: match solved {
                Some(solved) => solved,
                None => solved_light(proxy, options, run)?,
            },
            atlas,
            objects,
            fronts,
            follows_light: false,
        };
        charts.atlas.turned = charts.turned(options.sides)?;
        if options.follows_light && options.coordinates == Coordinates::New {
            charts.follow_light(&proxy.tracer, options, run)?;
        }
        Ok(charts)
    }

    /// Whether each chart shows the back of its surface.
    fn turned(&self, sides: BakedSides) -> Result<Vec<bool>, Cancelled> {
        let atlas = &self.atlas;
        Ok(match sides {
            BakedSides::Front => Vec::new(),
            BakedSides::Brighter => turned(atlas, &self.objects, self.scene, &self.solved)?,
            BakedSides::Both => {
                let mut is_turned = vec![false; atlas.layout.charts as usize];
                let backs = atlas.layout.receivers[self.fronts..].iter();
                for &chart in backs.flat_map(|r| &r.charts).filter(|c| **c != NO_CHART) {
                    is_turned[chart as usize] = true;
                }
                is_turned
            }
        })
    }

    /// Changes to a layout in which charts with edges of shadows have more texels than others, if errors are less with
    /// it.
    fn follow_light(
        &mut self,
        tracer: &Tracer,
        options: &BakeOptions,
        run: Run,
    ) -> Result<(), BakeError> {
        let (error, seed) = (options.error(), options.seed());
        let (atlas, gatherer) = (&self.atlas, self.solved.gatherer());
        let importance = azulejo_bake::chart_importance(atlas, gatherer, error, seed, run)?;
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
        if error_in(&followed) < WORTH_REPACKING * error_in(even) {
            self.atlas.layout = followed;
            self.atlas.turned = self.turned(options.sides)?;
            self.follows_light = true;
        }
        Ok(())
    }

    /// The points of all texels.
    pub fn samples(&self, run: Run) -> Result<Samples, Cancelled> {
        agreed_samples(&self.atlas, self.solved.gatherer().surfaces().tracer, run)
    }

    /// Where indirect light comes from, to an error relative to the mean.
    pub fn indirect<'l>(
        &'l self,
        options: &BakeOptions,
        error: f64,
        run: Run<'l>,
    ) -> IndirectLight<'l> {
        IndirectLight {
            solved: &self.solved,
            bounces: options.pass.bounces,
            error,
            is_directional: options.is_directional && options.light != BakedLight::Indirect,
            run,
        }
    }

    /// The light of all samples, of which direct and indirect light stay apart.
    pub fn light(
        &self,
        samples: &Samples,
        options: &BakeOptions,
        run: Run,
    ) -> Result<SampleLight, SolveError> {
        let indirect = self.indirect(options, options.error(), run);
        let (atlas, seed) = (&self.atlas, options.seed());
        match options.fixed_rays(run.progress) {
            Some(rays) => indirect.with_rays(atlas, samples, rays, seed),
            None => indirect.to_error(atlas, &self.objects, samples, options.light, seed),
        }
    }

    /// Share of the area that is seen from both sides, of which one has the lightmap and the other has light that
    /// differs by more than a tenth.
    pub fn differing_sides(&self, sides: BakedSides) -> f64 {
        match sides {
            BakedSides::Both => 0.0,
            BakedSides::Front | BakedSides::Brighter => differing_share(
                &self.atlas.receivers,
                &self.objects,
                self.scene,
                &self.solved,
            ),
        }
    }

    /// How much more light texels have than the patches at the same places, relative to that.
    pub fn beside_patches(&self, samples: &Samples, light: &SampleLight) -> f64 {
        let (atlas, objects) = (&self.atlas, &self.objects);
        let [patches, texels] = power_beside_patches(
            atlas,
            objects,
            self.scene,
            &self.solved,
            (samples, &light.all),
        );
        if patches > 0.0 {
            texels / patches - 1.0
        } else {
            0.0
        }
    }
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
pub fn agreed_samples(atlas: &Atlas, tracer: &Tracer, run: Run) -> Result<Samples, Cancelled> {
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
pub fn receivers_of(
    scene: &Scene,
    objects: &[u32],
    densities: &[f64],
) -> (Vec<Receiver>, Vec<u32>) {
    let receiver = |(place, &o): (usize, &u32)| {
        let mut receiver = Receiver::of_object(&scene.objects[o as usize])?;
        receiver.density = densities.get(place).copied().unwrap_or(1.0);
        Some((receiver, o))
    };
    objects.iter().enumerate().filter_map(receiver).unzip()
}

/// The receivers with their charts, if there is room for the texels.
pub fn arranged(
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
    let mut needed = memory_of(&layout, [BYTES_PER_TEXEL, bytes_per_covered]);
    if options.is_directional {
        needed += memory_of(&layout, BYTES_OF_DIRECTIONS);
    }
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

/// Memory that the texels of a layout, and those of them that cover surfaces, take together, bytes.
fn memory_of(layout: &Layout, [bytes_per_texel, bytes_per_covered]: [f64; 2]) -> u64 {
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
    (texels * bytes_per_texel + covered * bytes_per_covered) as u64
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
