//! A world on a card, ready to be drawn.

use crate::atlas::Atlas;
use crate::mesh::Mesh;
use crate::shared::{Reduction, Shared};
use crate::tally::{Tally, exact_weights, whole_weights};
use crate::target::{AtlasTarget, DrawInto, Mapping, TargetOptions, sum_bytes};
use crate::view_traversal::{Pixels, ViewContext, ViewTraversal, WindowRequest};
use azulejo_trace::item_buffer::{
    Beyond, DepthPrecision, DrawError, Hemicube, HemicubeView, ItemBuffers, Seen, Settings, View,
    World,
};
use std::sync::{Arc, Mutex, PoisonError};

/// Largest number of pixels of an atlas. Hardware needs 20 bytes for each, twice, because the next
/// atlas is drawn while the last is read. Software drivers are faster with an atlas that fits into
/// the caches.
const MOST_PIXELS: u64 = 1 << 24;
const MOST_PIXELS_SOFTWARE: u64 = 1 << 20;
/// Largest number of views in an atlas: more do not increase utilization.
const MOST_TILES: u32 = 256;
/// Largest size of the sums of an atlas, in bytes.
const MOST_SUMS: u64 = 128 << 20;
/// Facets in a cluster. Hardware draws a facet in less time than the processor needs to cull it.
const CLUSTER: u32 = 1024;
const CLUSTER_SOFTWARE: u32 = 64;

/// A world on a card.
pub struct Buffers {
    shared: Arc<Shared>,
    mesh: Mesh,
    /// Delta form factors of the pixels of a hemicube.
    weights: Vec<f64>,
    beyond: Beyond,
    atlas: Atlas,
    /// The integer on the card that stands for a form factor of 1.
    scale: f64,
    /// One is drawn while the other is read.
    targets: Mutex<[AtlasTarget; 2]>,
}

/// Views that the card is drawing.
struct PendingViews {
    traversals: Vec<ViewTraversal>,
    submission: wgpu::SubmissionIndex,
    readback: Readback,
}

/// The data that will be read back.
enum Readback {
    Pixels(Vec<Mapping>),
    Sums(Mapping),
}

impl Buffers {
    pub fn new(
        shared: Arc<Shared>,
        world: &World,
        settings: &Settings,
        reduction: Option<Reduction>,
    ) -> Result<Buffers, DrawError> {
        shared.check()?;
        // Software drivers profit from smaller clusters of facets: drawing costs them more than culling.
        let cluster = if shared.is_software {
            CLUSTER_SOFTWARE
        } else {
            CLUSTER
        };
        let mesh = Mesh::new(&shared, world, cluster)?;
        let cube = Hemicube::new(settings.resolution);
        let (has_mirrors, has_bent) = (mesh.has_mirrors(), mesh.has_bent());
        let is_windowed = matches!(settings.mirrors, Beyond::Windows { depth: 1.., .. });
        // Limits on pixels, on tiles and, if the card adds, on the size of its sums determine the atlas.
        let most = if shared.is_software {
            MOST_PIXELS_SOFTWARE
        } else {
            MOST_PIXELS
        };
        let mut atlas = Atlas::new(cube.resolution(), most, &shared.limits)?.with_tiles(MOST_TILES);
        let reduction = choose(&shared, &cube, mesh.patches, reduction);
        if reduction == Reduction::Compute {
            let tiles = most_sums(&shared) / sum_bytes(mesh.patches);
            atlas = atlas.with_tiles(tiles.min(u64::from(u32::MAX)) as u32);
        }
        // The card adds integers: `scale` is what a form factor of 1 becomes.
        let weights = exact_weights(&cube);
        let (whole, scale) = whole_weights(&weights);
        // Nearness is stored where rays continue from pixels: at bent patches and listed mirrors.
        let mut options = TargetOptions {
            atlas,
            nearness: has_bent || (has_mirrors && settings.mirrors == Beyond::List),
            windows: has_mirrors && is_windowed,
            reduction,
            weights: &whole,
            patches: mesh.patches,
        };
        // If memory is short, the targets have fewer tiles than requested.
        let targets = targets(&shared, &mut options)?;
        let atlas = options.atlas;
        shared.check()?;
        Ok(Buffers {
            shared,
            mesh,
            weights,
            beyond: settings.mirrors,
            atlas,
            scale,
            targets: Mutex::new(targets),
        })
    }

    fn context(&self) -> ViewContext<'_> {
        ViewContext {
            mesh: &self.mesh,
            weights: &self.weights,
            atlas: &self.atlas,
            beyond: self.beyond,
        }
    }

    /// Submits views to the card.
    fn begin(&self, target: &mut AtlasTarget, views: &[View]) -> PendingViews {
        let context = self.context();
        let traversal = |(tile, view)| {
            ViewTraversal::new(
                tile,
                HemicubeView::new(view, &self.mesh.local, DepthPrecision::Single),
                self.beyond,
            )
        };
        let mut traversals: Vec<ViewTraversal> = (0..).zip(views).map(traversal).collect();
        let drawings = side_by_side(
            &mut traversals,
            || (),
            |(), traversal| traversal.straight(&context),
        );
        let drawings: Vec<_> = drawings.into_iter().flatten().collect();
        target.draw(&self.shared, &self.mesh, &drawings, DrawInto::Faces);
        let ups: Vec<[f32; 4]> = traversals.iter().map(|g| g.up(&context)).collect();
        let (submission, readback) = match target.add_up(&self.shared, &ups) {
            Some((submission, sums)) => (submission, Readback::Sums(sums)),
            None => {
                let tiles: Vec<u32> = traversals.iter().map(|g| g.tile).collect();
                let (submission, pixels) = target.read_back(&self.shared, &tiles);
                (submission, Readback::Pixels(pixels))
            }
        };
        PendingViews {
            traversals,
            submission,
            readback,
        }
    }

    /// Reads the pixels, and draws reflected worlds level by level until there are no more windows.
    fn finish(
        &self,
        target: &mut AtlasTarget,
        drawn: PendingViews,
    ) -> Result<Vec<Seen>, DrawError> {
        let PendingViews {
            mut traversals,
            submission,
            readback,
        } = drawn;
        self.shared.wait(submission)?;
        let context = self.context();
        match readback {
            Readback::Pixels(pixels) => self.read(
                pixels,
                &mut traversals.iter_mut(),
                |tally, traversal, pixels| {
                    traversal.read_all(&context, pixels, Some(tally));
                },
            )?,
            Readback::Sums(sums) => self.read_sums(target, sums, &mut traversals)?,
        }
        while traversals.iter().any(ViewTraversal::has_windows) {
            self.next_level(target, &mut traversals)?;
        }
        Ok(side_by_side(
            &mut traversals,
            || (),
            |(), traversal| traversal.take(),
        ))
    }

    /// Reads the card's sums, and the pixels of those tiles in which some pixels continue into
    /// mirrors or rays.
    fn read_sums(
        &self,
        target: &AtlasTarget,
        sums: Mapping,
        traversals: &mut [ViewTraversal],
    ) -> Result<(), DrawError> {
        let context = self.context();
        let continues = sums.read(&self.shared, |words| {
            let slots = 2 * (2 * self.mesh.patches as usize + 2);
            let mut pairs: Vec<_> = traversals
                .iter_mut()
                .zip(words.chunks_exact(slots))
                .collect();
            side_by_side(
                &mut pairs,
                || (),
                |(), (traversal, sums)| traversal.add_sums(&context, sums, self.scale),
            )
        })?;
        let on = traversals
            .iter_mut()
            .zip(continues)
            .filter_map(|(traversal, on)| on.then_some(traversal));
        let mut on: Vec<&mut ViewTraversal> = on.collect();
        let tiles: Vec<u32> = on.iter().map(|g| g.tile).collect();
        if tiles.is_empty() {
            return Ok(());
        }
        let (submission, pixels) = target.read_back(&self.shared, &tiles);
        self.shared.wait(submission)?;
        self.read(
            pixels,
            &mut on.iter_mut().map(|g| &mut **g),
            |_, traversal, pixels| {
                traversal.read_all(&context, pixels, None);
            },
        )
    }

    /// Draws and reads the views behind one more mirror.
    fn next_level(
        &self,
        target: &mut AtlasTarget,
        traversals: &mut [ViewTraversal],
    ) -> Result<(), DrawError> {
        let context = self.context();
        let mut open: Vec<&mut ViewTraversal> =
            traversals.iter_mut().filter(|g| g.has_windows()).collect();
        let requests = side_by_side(
            &mut open,
            || (),
            |(), traversal| traversal.request(&context),
        );
        let tiles: Vec<u32> = open.iter().map(|g| g.tile).collect();
        let mut drawings = Vec::new();
        for (request, &tile) in requests.into_iter().zip(&tiles) {
            let WindowRequest {
                drawings: more,
                first_row,
                numbers,
            } = request;
            target.set_windows(&self.shared, tile, first_row, &numbers);
            drawings.extend(more);
        }
        target.draw(&self.shared, &self.mesh, &drawings, DrawInto::Windows);
        let (submission, pixels) = target.read_back(&self.shared, &tiles);
        self.shared.wait(submission)?;
        self.read(
            pixels,
            &mut open.iter_mut().map(|g| &mut **g),
            |tally, traversal, pixels| {
                traversal.read_windows(&context, pixels, tally);
            },
        )
    }

    /// Passes each traversal the pixels of its tile, which were read back in the same order.
    fn read(
        &self,
        mappings: Vec<Mapping>,
        traversals: &mut dyn Iterator<Item = &mut ViewTraversal>,
        work: impl Fn(&mut Tally, &mut ViewTraversal, Pixels) + Sync,
    ) -> Result<(), DrawError> {
        let words = (self.atlas.tile_bytes() / 4) as usize;
        let stride = (self.atlas.row_bytes() / 4) as usize;
        let mut traversals: Vec<(usize, &mut ViewTraversal)> = traversals.enumerate().collect();
        let tally = || Tally::new(self.mesh.patches);
        let mut read_all = |sides: &[u32], nearness: Option<&[u32]>| {
            let tile = |k: usize| k * words..(k + 1) * words;
            side_by_side(&mut traversals, tally, |tally, (k, traversal)| {
                let pixels = Pixels {
                    sides: &sides[tile(*k)],
                    nearness: nearness.map(|n| &n[tile(*k)]),
                    stride,
                };
                work(tally, traversal, pixels);
            });
        };
        let mut mappings = mappings.into_iter();
        let (sides, nearness) = (mappings.next(), mappings.next());
        match (sides, nearness) {
            (Some(sides), None) => sides.read(&self.shared, |sides| read_all(sides, None)),
            (Some(sides), Some(nearness)) => sides.read(&self.shared, |sides| {
                nearness.read(&self.shared, |nearness| read_all(sides, Some(nearness)))
            })?,
            _ => Ok(()),
        }
    }
}

impl ItemBuffers for Buffers {
    fn batch(&self) -> usize {
        // One atlas to draw, one to read, and the same again as a margin.
        4 * self.atlas.tiles as usize
    }

    fn draw(&self, views: &[View]) -> Result<Vec<Seen>, DrawError> {
        let _gate = self.shared.gate();
        self.shared.check()?;
        let mut targets = self.targets.lock().unwrap_or_else(PoisonError::into_inner);
        let [one, other] = &mut *targets;
        let (mut now, mut last) = (one, other);
        let mut results = Vec::with_capacity(views.len());
        let mut drawing: Option<PendingViews> = None;
        for part in views.chunks(self.atlas.tiles as usize) {
            let next = self.begin(now, part);
            if let Some(drawn) = drawing.replace(next) {
                results.extend(self.finish(last, drawn)?);
            }
            std::mem::swap(&mut now, &mut last);
        }
        if let Some(drawn) = drawing {
            results.extend(self.finish(last, drawn)?);
        }
        self.shared.check()?;
        Ok(results)
    }
}

/// The default place of the summation: the card, if it is hardware and its sums are smaller to read
/// back than the pixels.
fn choose(
    shared: &Shared,
    cube: &Hemicube,
    patches: u32,
    requested: Option<Reduction>,
) -> Reduction {
    let is_possible = shared.can_compute && sum_bytes(patches) <= most_sums(shared);
    let is_less = sum_bytes(patches) < 4 * u64::from(cube.pixels());
    let prefers_card = match requested {
        Some(reduction) => reduction == Reduction::Compute,
        None => !shared.is_software && is_less,
    };
    if is_possible && prefers_card {
        Reduction::Compute
    } else {
        Reduction::ReadBack
    }
}

/// Largest size of the sums of an atlas, in bytes.
fn most_sums(shared: &Shared) -> u64 {
    let limits = &shared.limits;
    let binding = limits.max_storage_buffer_binding_size;
    MOST_SUMS.min(limits.max_buffer_size).min(binding)
}

/// Two targets, with fewer tiles than requested if the card's memory is short.
fn targets(shared: &Shared, wanted: &mut TargetOptions) -> Result<[AtlasTarget; 2], DrawError> {
    loop {
        let pair = [
            AtlasTarget::new(shared, wanted),
            AtlasTarget::new(shared, wanted),
        ];
        if let [Some(one), Some(other)] = pair {
            return Ok([one, other]);
        }
        shared.check()?;
        if wanted.atlas.tiles == 1 {
            let n = wanted.atlas.resolution;
            return Err(DrawError::TooLarge(format!(
                "a hemicube of {n} pixels ({} bytes, several times) does not fit into the memory \
                 that the world leaves free; use fewer pixels",
                wanted.atlas.tile_bytes()
            )));
        }
        wanted.atlas = wanted.atlas.with_tiles(wanted.atlas.tiles / 2);
    }
}

/// Processes each item, on as many threads as rayon has. Not on rayon's own threads: one of those,
/// waiting here, might start another drawing and wait for the card that it holds itself.
fn side_by_side<T: Send, S, R: Send>(
    items: &mut [T],
    start: impl Fn() -> S + Sync,
    work: impl Fn(&mut S, &mut T) -> R + Sync,
) -> Vec<R> {
    let each = items.len().div_ceil(rayon::current_num_threads()).max(1);
    let run = |part: &mut [T]| -> Vec<R> {
        let mut state = start();
        part.iter_mut().map(|item| work(&mut state, item)).collect()
    };
    if items.len() <= each {
        return run(items);
    }
    std::thread::scope(|scope| {
        let threads: Vec<_> = items
            .chunks_mut(each)
            .map(|part| scope.spawn(|| run(part)))
            .collect();
        let results = threads.into_iter().flat_map(|t| match t.join() {
            Ok(results) => results,
            Err(panic) => std::panic::resume_unwind(panic),
        });
        results.collect()
    })
}
