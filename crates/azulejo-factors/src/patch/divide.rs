//! How finely to divide: pieces per edge, then cells per region.

use super::PatchSize;
use super::cells::Cells;
use super::contacts::Contacts;
use super::edge_points::EdgePoints;
use super::irregular::{Irregular, expected_patches, flatten, flatten_contacts};
use super::lines::{Lines, is_worth};
use super::locate::is_flat;
use super::outline::{Form, Outline, Region};
use azulejo_scene::{Primitive, Shape, SurfaceGrid};
use rayon::prelude::*;

/// Most patches of any division (about 150 bytes each); a smaller size is raised until it fits.
/// Faces are never joined, so a scene with more faces has more patches.
pub(super) const MAX_PATCHES: usize = 1 << 24;
/// An edge may be divided this much finer than its length requires, to match its neighbours.
const HARMONY: f64 = 1.25;
/// Rounds of matching; each propagates a count by one face.
const HARMONY_ROUNDS: usize = 8;
/// Chord error of an exact shape's cells, as a share of the patch size.
const CHORD_ERROR: f64 = 0.02;

/// Limit of the patches that contacts add, per requested square: hundreds of parts that intersect
/// each other would add ever more.
const MOST_CUTS: usize = 3;

/// A patch size and the division that it leads to.
pub(super) struct Division {
    /// Pieces of each edge.
    pub edge_points: EdgePoints,
    /// Cells of each region.
    pub cells: Vec<Cells>,
}

impl Division {
    pub fn new(outline: &Outline, contacts: &Contacts, size: PatchSize) -> Division {
        let plan = DivisionPlan {
            outline,
            contacts,
            curved: f64::INFINITY,
        };
        match size {
            PatchSize::Edge(edge) => {
                let edge = if edge > 0.0 { edge } else { f64::INFINITY };
                Division::at(plan, plan.fitting(edge, MAX_PATCHES as f64))
            }
            PatchSize::Count(count) => {
                let target = PatchTarget::new(plan, count.clamp(1, MAX_PATCHES));
                Division::near_count(plan, target)
            }
            PatchSize::FlatWhole(count) => {
                let curved = square_edge(outline, count);
                let plan = DivisionPlan { curved, ..plan };
                Division::at(plan, f64::INFINITY)
            }
            PatchSize::Squares(count) => {
                let edge = square_edge(outline, count);
                let most = plan.estimate(f64::INFINITY) as usize;
                let most = most.saturating_add(count.saturating_mul(MOST_CUTS));
                let division = Division::at(plan, plan.fitting(edge, MAX_PATCHES as f64));
                if division.patches() > most {
                    Division::near_count(plan, PatchTarget::new(plan, most.clamp(1, MAX_PATCHES)))
                } else {
                    division
                }
            }
        }
    }

    /// The division whose count is nearest: the estimate is corrected by the actual result.
    fn near_count(plan: DivisionPlan, target: PatchTarget) -> Division {
        let mut requested = target.added;
        let mut best: Option<(f64, Division)> = None;
        for _ in 0..5 {
            let division = Division::at(plan, plan.fitting(0.0, target.expected + requested));
            let added = division.patches().saturating_sub(target.whole);
            let ratio = added as f64 / target.added;
            // Equal faces are divided all at once or not at all; then rather not.
            let is_far_beyond =
                target.whole > 0 && division.patches() as f64 > 1.1 * target.total();
            let error = if is_far_beyond {
                f64::INFINITY
            } else {
                (ratio.max(1e-300)).ln().abs()
            };
            if best.as_ref().is_none_or(|b| error < b.0) {
                best = Some((error, division));
            }
            if error < 0.03 || !ratio.is_finite() {
                break;
            }
            requested = (requested / ratio.clamp(0.25, 4.0)).clamp(1.0, MAX_PATCHES as f64);
        }
        best.map_or_else(|| Division::at(plan, f64::INFINITY), |b| b.1)
    }

    fn at(plan: DivisionPlan, size: f64) -> Division {
        let outline = plan.outline;
        let lines: Vec<Option<Box<Lines>>> = (0..outline.regions.len())
            .into_par_iter()
            .map(|r| plan.lines(r, size))
            .collect();
        let mut edge_points = EdgePoints::even(edge_pieces(outline, size));
        edge_points.cut_at_ends(outline, plan.contacts, &lines, size);
        let cells = |(region, lines): (&Region, &Option<Box<Lines>>)| {
            let size = plan.region_size(region, size);
            cells(outline, region, &edge_points, lines.as_deref(), size)
        };
        let regions = outline.regions.par_iter().zip(&lines);
        let cells = regions.map(cells).collect();
        Division { edge_points, cells }
    }

    fn patches(&self) -> usize {
        self.cells.iter().map(Cells::len).sum()
    }
}

/// How many patches a division aims at.
#[derive(Clone, Copy)]
struct PatchTarget {
    /// Patches that are left out of the comparison: if they are most of all, no share of the total
    /// would notice whether the large surfaces have any.
    whole: usize,
    /// The estimate of the same number.
    expected: f64,
    /// All other patches; at least 1.
    added: f64,
}

impl PatchTarget {
    fn total(self) -> f64 {
        self.whole as f64 + self.added
    }

    /// `count` patches, of which undivided faces use at most half: what they need beyond that comes
    /// on top.
    fn new(plan: DivisionPlan, count: usize) -> PatchTarget {
        let expected = plan.estimate(f64::INFINITY);
        let half = 0.5 * count as f64;
        if expected <= half {
            return PatchTarget {
                whole: 0,
                expected: 0.0,
                added: count as f64,
            };
        }
        let most = MAX_PATCHES as f64 - expected;
        PatchTarget {
            whole: Division::at(plan, f64::INFINITY).patches(),
            expected,
            added: half.min(most).max(1.0),
        }
    }
}

/// The scene before a size is chosen.
#[derive(Clone, Copy)]
struct DivisionPlan<'a> {
    outline: &'a Outline<'a>,
    contacts: &'a Contacts,
    /// Largest size of curved cells, whatever that of flat ones.
    curved: f64,
}

impl DivisionPlan<'_> {
    /// The size of the cells of a region where it is `size` in general.
    fn region_size(self, region: &Region, size: f64) -> f64 {
        let shape = &self.outline.scene.objects[region.object as usize].shape;
        match shape {
            Shape::Primitive(primitive) if !is_flat(primitive.kind) => size.min(self.curved),
            _ => size,
        }
    }

    /// The smallest edge size from `least` up that is expected to make at most `count` patches.
    fn fitting(self, least: f64, count: f64) -> f64 {
        let fits = |size: f64| self.estimate(size) <= count;
        if least > 0.0 && fits(least) {
            return least;
        }
        let diagonal = self.outline.scene.bounds().diagonal();
        let mut high = diagonal.max(f64::MIN_POSITIVE);
        if !high.is_finite() || !fits(high) {
            return f64::INFINITY;
        }
        let mut low = high;
        // Counts grow at least like 1/size, so 2^-64 of the scene is far beyond every limit.
        for _ in 0..64 {
            low *= 0.5;
            if !fits(low) {
                break;
            }
            high = low;
        }
        for _ in 0..20 {
            let middle = (low * high).sqrt();
            if fits(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        high.max(least)
    }

    fn estimate(self, size: f64) -> f64 {
        let outline = self.outline;
        let pieces = edge_pieces(outline, size);
        let one = |(r, region): (usize, &Region)| {
            let (length, diameter) = self.contacts.extent(r);
            let has_lines = length > 0.0 && is_worth(diameter, size);
            match pattern(outline, region, &pieces, size) {
                Some(cells) if !has_lines => cells_count(&cells),
                _ => {
                    let edges = outline.slots_of(region).iter().map(|s| s.edge as usize);
                    let sides = edges.map(|edge| (outline.edges[edge].length(), pieces[edge]));
                    let mut sides: Vec<(f64, u32)> = sides.collect();
                    if has_lines {
                        // Either side of a line acts like a border.
                        sides.push((2.0 * length, (2.0 * length / size).ceil() as u32));
                    }
                    expected_patches(region.area, &sides, size)
                }
            }
        };
        outline.regions.iter().enumerate().map(one).sum()
    }

    /// The lines through a region that are worth a division at this size.
    fn lines(self, r: usize, size: f64) -> Option<Box<Lines>> {
        let contacts = self.contacts.of(r);
        if !self.contacts.run_through(r) {
            return None;
        }
        let region = &self.outline.regions[r];
        let (corners, scale) = flatten(self.outline, region);
        let segments = flatten_contacts(self.outline, region, contacts);
        Lines::new(&corners, &segments, size * scale).map(Box::new)
    }
}

/// In floating point, because an impossible size would overflow integers.
fn cells_count(cells: &Cells) -> f64 {
    match *cells {
        Cells::Quad { nu, nv } | Cells::Part { nu, nv } => f64::from(nu) * f64::from(nv),
        Cells::Triangle { k } => f64::from(k) * f64::from(k),
        Cells::None | Cells::Irregular(_) => 0.0,
    }
}

/// Pieces of each edge: as many as its length requires, or up to a quarter more where that lets a
/// region keep a regular pattern. Edges that are short enough stay whole.
fn edge_pieces(outline: &Outline, size: f64) -> Vec<u32> {
    let limits: Vec<(u32, u32)> = outline
        .edges
        .iter()
        .map(|e| {
            let n = e.length() / size;
            let pieces = |n: f64| (n.ceil() as u32).max(1);
            let least = pieces(n);
            (least, if least < 2 { 1 } else { pieces(HARMONY * n) })
        })
        .collect();
    let mut pieces: Vec<u32> = limits.iter().map(|limit| limit.0).collect();
    for _ in 0..HARMONY_ROUNDS {
        let mut changed = false;
        for region in &outline.regions {
            let slots = outline.slots_of(region);
            let edge = |k: usize| slots[k].edge as usize;
            match region.form {
                Form::Triangle => {
                    changed |= match_edges(&mut pieces, &limits, &[edge(0), edge(1), edge(2)]);
                }
                Form::Quad => {
                    changed |= match_edges(&mut pieces, &limits, &[edge(0), edge(2)]);
                    changed |= match_edges(&mut pieces, &limits, &[edge(1), edge(3)]);
                }
                Form::Empty | Form::Polygon | Form::Part => {}
            }
        }
        if !changed {
            break;
        }
    }
    pieces
}

/// Raises all edges of a set to its largest count, if all of them allow it.
fn match_edges(pieces: &mut [u32], limits: &[(u32, u32)], set: &[usize]) -> bool {
    let most = set.iter().map(|&e| pieces[e]).max().unwrap_or(1);
    let equal = set.iter().all(|&e| pieces[e] == most);
    let may = set
        .iter()
        .all(|&e| pieces[e] == most || most <= limits[e].1);
    if !equal && may {
        set.iter().for_each(|&e| pieces[e] = most);
    }
    !equal && may
}

/// The regular pattern of a region, if its sides allow one.
fn pattern(outline: &Outline, region: &Region, pieces: &[u32], size: f64) -> Option<Cells> {
    let slots = outline.slots_of(region);
    let side = |k: usize| pieces[slots[k].edge as usize];
    match region.form {
        Form::Empty => Some(Cells::None),
        Form::Triangle if side(0) == side(1) && side(1) == side(2) => {
            Some(Cells::Triangle { k: side(0) })
        }
        Form::Quad if side(0) == side(2) && side(1) == side(3) => Some(Cells::Quad {
            nu: side(0),
            nv: side(1),
        }),
        Form::Part => {
            let SurfaceGrid { nu, nv } = part_grid(outline, region, size);
            Some(Cells::Part { nu, nv })
        }
        Form::Triangle | Form::Quad | Form::Polygon => None,
    }
}

fn cells(
    outline: &Outline,
    region: &Region,
    edge_points: &EdgePoints,
    lines: Option<&Lines>,
    size: f64,
) -> Cells {
    let slots = outline.slots_of(region);
    let is_even = lines.is_none() && !slots.iter().any(|s| edge_points.is_cut(s.edge));
    let regular = is_even.then(|| pattern(outline, region, &edge_points.pieces, size));
    regular.flatten().unwrap_or_else(|| {
        let irregular = Irregular::new(outline, region, edge_points, lines, size);
        Cells::Irregular(Box::new(irregular))
    })
}

/// The edge of squares of which `count` have the area of all surfaces; infinite where there is none.
fn square_edge(outline: &Outline, count: usize) -> f64 {
    let edge = (area(outline) / count.max(1) as f64).sqrt();
    if edge > 0.0 { edge } else { f64::INFINITY }
}

/// The area of all surfaces. Regions of exact shapes have no polygon, and no area of their own.
fn area(outline: &Outline) -> f64 {
    let polygons: f64 = outline.regions.iter().map(|r| r.area).sum();
    let exact = outline.scene.objects.iter().map(|o| match &o.shape {
        Shape::Primitive(primitive) => primitive.area(),
        Shape::Mesh(_) | Shape::Instance(_) | Shape::Exact(_) => 0.0,
    });
    polygons + exact.sum::<f64>()
}

/// The grids of an exact shape at a patch size.
pub(super) fn grids(primitive: &Primitive, size: f64) -> Vec<SurfaceGrid> {
    primitive.grids(CHORD_ERROR * size, size)
}

fn part_grid(outline: &Outline, region: &Region, size: f64) -> SurfaceGrid {
    match &outline.scene.objects[region.object as usize].shape {
        Shape::Primitive(p) => grids(p, size)[region.face as usize],
        Shape::Mesh(_) | Shape::Instance(_) | Shape::Exact(_) => SurfaceGrid { nu: 1, nv: 1 },
    }
}
