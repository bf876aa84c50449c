//! Which side's irradiance a surface stores.
//!
//! Sides are chosen for whole surfaces, so that no wall is a patchwork of the light on its two
//! sides. A surface is made of the patches that meet at edges; where more than two meet at an
//! edge, those that continue each other do.

use crate::system::RadiositySolution;
use azulejo_factors::Patches;
use azulejo_factors::row::side;
use azulejo_scene::{Material, Object, Rgb, Scene, Shape, Sidedness};
use azulejo_trace::{Gathered, REPLICATES};
use glam::DVec3;
use std::collections::HashMap;

/// Which side's irradiance the surfaces of meshes store. Exact shapes store that of their outside.
///
/// Lamps and glass, whose sides differ, keep their fronts under every rule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StoredSides {
    /// By what the file says of each surface ([`Sidedness`]). The front where backs are culled; both
    /// sides where both are visible. Where the file says nothing, one side: the front, or the back
    /// if only that is lit, as in a room whose walls face outwards. But if more than a fiftieth of
    /// the edges of an object's faces contradict each other, their order says nothing, and both
    /// sides of its surfaces are stored.
    ///
    /// Closed surfaces of which only one side is lit store that one; a mesh that is
    /// [kept](crate::FirstPass::keep_mesh) stores one side of every surface, which is the
    /// [brighter](StoredSides::Brighter) one where the order of corners says nothing.
    #[default]
    BySurface,
    /// The front of every face.
    Front,
    /// The brighter side of every surface: the back, if it is brighter by a quarter and by three
    /// standard errors.
    Brighter,
    /// Both sides of every surface, unless it is closed and only one side is lit.
    Split,
    /// For files whose faces stay as they are: as [`BySurface`](StoredSides::BySurface), but instead
    /// of turning a surface to its back both of its sides are stored, on kept meshes too.
    Unturned,
}

/// How much brighter a clearly brighter side is.
const CLEARLY: f64 = 1.25;

/// Share of edges at which an object's faces may contradict each other before their order counts
/// for nothing: a few flipped faces are accidents.
const CONTRADICTIONS: f64 = 0.02;

/// Share of the back's light below which a front is unlit.
const UNLIT: f64 = 1e-4;

/// Standard errors that are not an accident.
const SIGNIFICANT: f64 = 3.0;

/// Cosine of 1°: faces that turn by less continue each other.
const COPLANAR: f64 = 0.999_85;

/// At an edge of many faces this many are compared.
const FACES_COMPARED: usize = 8;

/// What a patch stores.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SideChoice {
    /// Whether its back becomes its front.
    pub is_turned: bool,
    /// Whether its other side is stored, too.
    pub both: bool,
}

/// The choice of every patch; `scene` is the scene as given, exact shapes included.
pub(crate) fn choose(
    scene: &Scene,
    patches: &Patches,
    found: &RadiositySolution,
    rule: StoredSides,
    keep_mesh: bool,
) -> Vec<SideChoice> {
    let turns = rule != StoredSides::Unturned;
    let (rule, keep_mesh) = match rule {
        StoredSides::Unturned => (StoredSides::BySurface, false),
        _ => (rule, keep_mesh),
    };
    let mut choices = vec![SideChoice::default(); patches.len()];
    if rule == StoredSides::Front {
        return choices;
    }
    for surface in SurfaceJoiner::new(scene, patches).into_list() {
        let light = LightOnSides::new(&surface, patches, found);
        let is_hollow = surface.is_closed && (light.is_back_unlit() || light.is_front_unlit());
        let is_double = match (rule, surface.sidedness) {
            (StoredSides::Split, _) => true,
            (StoredSides::BySurface, Sidedness::Two) => !keep_mesh,
            (StoredSides::BySurface, Sidedness::Unsaid) => surface.is_doubtful && !keep_mesh,
            _ => false,
        };
        let both = is_double && !is_hollow;
        let turn = match (rule, surface.sidedness) {
            // The corners of a face say which of its sides is which.
            _ if both => None,
            (StoredSides::BySurface, Sidedness::One) => None,
            (StoredSides::Brighter, _) => Some(light.is_back_clearly_brighter()),
            _ if surface.is_doubtful => Some(light.is_back_clearly_brighter()),
            _ => Some(light.is_front_unlit()),
        };
        for &(patch, is_reversed) in &surface.patches {
            let is_turned = turn.is_some_and(|turn| turn != is_reversed);
            // Others share the faces of an instance.
            let object = patches.face(patch as usize).object as usize;
            let turns = turns && !matches!(scene.objects[object].shape, Shape::Instance(_));
            choices[patch as usize] = SideChoice {
                is_turned: is_turned && turns,
                both: both || is_turned && !turns,
            };
        }
    }
    choices
}

/// Patches that are one sheet.
struct JoinedSurface {
    /// The patches in ascending order, each with whether it faces the other way than most of the
    /// surface's area.
    patches: Vec<(u32, bool)>,
    /// Whether a patch continues at every edge.
    is_closed: bool,
    /// Whether the order of its corners says nothing.
    is_doubtful: bool,
    sidedness: Sidedness,
}

/// The surfaces of a scene's meshes while they are joined.
struct SurfaceJoiner<'a> {
    scene: &'a Scene,
    patches: &'a Patches,
    /// The surface of each patch, as a tree of patches.
    parents: Vec<u32>,
    /// Whether each patch faces the other way than its parent.
    is_opposite: Vec<bool>,
    /// Patches with an edge at which nothing continues them.
    is_open: Vec<bool>,
    /// For each object, at how many edges its faces meet, and at how many they contradict.
    edges: Vec<[u32; 2]>,
}

/// An edge of a patch: its ends in ascending order, and whether the patch runs that way.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct PatchEdge {
    ends: [u32; 2],
    object: u32,
    patch: u32,
    is_forward: bool,
}

impl<'a> SurfaceJoiner<'a> {
    fn new(scene: &'a Scene, patches: &'a Patches) -> SurfaceJoiner<'a> {
        let count = patches.len();
        let mut surfaces = SurfaceJoiner {
            scene,
            patches,
            parents: (0..count as u32).collect(),
            is_opposite: vec![false; count],
            is_open: vec![false; count],
            edges: vec![[0; 2]; scene.objects.len()],
        };
        let edges = surfaces.patch_edges();
        for run in edges.chunk_by(|a, b| a.ends == b.ends) {
            surfaces.join_run(run);
        }
        surfaces
    }

    /// The edges of all patches that have surfaces, sorted.
    fn patch_edges(&self) -> Vec<PatchEdge> {
        let mut places: HashMap<[u64; 3], u32> = HashMap::new();
        let mut place = |p: DVec3| {
            let next = places.len() as u32;
            *places.entry(p.to_array().map(f64::to_bits)).or_insert(next)
        };
        let vertices = self.patches.vertices();
        let places: Vec<u32> = vertices.iter().map(|v| place(v.position)).collect();
        let mut edges = Vec::new();
        for patch in (0..self.patches.len()).filter(|&p| self.has_surface(p)) {
            let corners = self.patches.corner_vertices(patch);
            let next = corners.iter().cycle().skip(1);
            for (&a, &b) in corners.iter().zip(next) {
                let (a, b) = (places[a as usize], places[b as usize]);
                edges.push(PatchEdge {
                    ends: [a.min(b), a.max(b)],
                    object: self.patches.face(patch).object,
                    patch: patch as u32,
                    is_forward: a < b,
                });
            }
        }
        edges.sort_unstable();
        edges
    }

    /// Whether a patch may be turned: it is of a mesh, and its sides are alike.
    fn has_surface(&self, patch: usize) -> bool {
        let object = self.patches.face(patch).object as usize;
        let material = self.material(patch as u32);
        is_mesh(&self.scene.objects[object])
            && !material.is_emitter()
            && material.dielectric.is_none()
    }

    fn material(&self, patch: u32) -> &Material {
        &self.scene.materials[self.patches.material(patch as usize) as usize]
    }

    /// Joins the patches at one edge: first those that continue each other, then what is left of
    /// each object if it is two, and what is left of all if it is two.
    fn join_run(&mut self, run: &[PatchEdge]) {
        let mut left: Vec<PatchEdge> = run.to_vec();
        if run.len() > 2 {
            self.join_coplanar(&mut left);
            let mut rest = Vec::new();
            for of_object in left.chunk_by(|a, b| a.object == b.object) {
                match of_object {
                    &[a, b] if self.sidedness(a) == self.sidedness(b) => self.join(a, b),
                    _ => rest.extend_from_slice(of_object),
                }
            }
            left = rest;
        }
        match left[..] {
            [a, b] if self.sidedness(a) == self.sidedness(b) => self.join(a, b),
            _ => left
                .iter()
                .for_each(|e| self.is_open[e.patch as usize] = true),
        }
    }

    fn sidedness(&self, edge: PatchEdge) -> Sidedness {
        self.material(edge.patch).sidedness
    }

    /// Joins the pairs of one object that lie in one plane on both sides of the edge and face the
    /// same way, and removes them.
    fn join_coplanar(&mut self, left: &mut Vec<PatchEdge>) {
        let mut i = 0;
        while i < left.len() {
            let a = left[i];
            let continues = |b: &PatchEdge| {
                let normal = |e: &PatchEdge| self.patches.normal(e.patch as usize);
                a.object == b.object
                    && a.is_forward != b.is_forward
                    && normal(&a).dot(normal(b)) > COPLANAR
                    && self.sidedness(a) == self.sidedness(*b)
            };
            let near = &left[i + 1..left.len().min(i + FACES_COMPARED)];
            match near.iter().position(continues) {
                Some(k) => {
                    let b = left.remove(i + 1 + k);
                    left.remove(i);
                    self.join(a, b);
                }
                None => i += 1,
            }
        }
    }

    /// Makes two patches one surface. At a common edge, patches that face the same way run in
    /// opposite directions.
    fn join(&mut self, a: PatchEdge, b: PatchEdge) {
        let contradicts = a.is_forward == b.is_forward;
        let face = |e: PatchEdge| self.patches.face(e.patch as usize);
        if face(a) != face(b) {
            for object in [a.object, b.object] {
                let [all, against] = &mut self.edges[object as usize];
                *all += 1;
                *against += u32::from(contradicts);
            }
        }
        let ((root, turn), (other, other_turn)) = (self.find(a.patch), self.find(b.patch));
        if root != other {
            let (first, last) = (root.min(other), root.max(other));
            self.parents[last as usize] = first;
            self.is_opposite[last as usize] = turn ^ other_turn ^ contradicts;
        }
    }

    /// The root of a patch's tree, and whether the patch faces the other way than it.
    fn find(&mut self, patch: u32) -> (u32, bool) {
        let (mut root, mut opposite) = (patch, false);
        while self.parents[root as usize] != root {
            opposite ^= self.is_opposite[root as usize];
            root = self.parents[root as usize];
        }
        // The path becomes short, so that long strips are not followed again and again.
        let (mut next, mut turn) = (patch, opposite);
        while next != root {
            let (parent, was) = (self.parents[next as usize], self.is_opposite[next as usize]);
            self.parents[next as usize] = root;
            self.is_opposite[next as usize] = turn;
            (next, turn) = (parent, turn ^ was);
        }
        (root, opposite)
    }

    fn into_list(mut self) -> Vec<JoinedSurface> {
        let mut of_root: HashMap<u32, usize> = HashMap::new();
        let mut list: Vec<JoinedSurface> = Vec::new();
        for patch in 0..self.patches.len() {
            if !self.has_surface(patch) {
                continue;
            }
            let (root, opposite) = self.find(patch as u32);
            let index = *of_root.entry(root).or_insert_with(|| {
                list.push(JoinedSurface {
                    patches: Vec::new(),
                    is_closed: true,
                    is_doubtful: false,
                    sidedness: self.material(patch as u32).sidedness,
                });
                list.len() - 1
            });
            let surface = &mut list[index];
            surface.patches.push((patch as u32, opposite));
            surface.is_closed &= !self.is_open[patch];
            surface.is_doubtful |= self.is_doubtful(self.patches.face(patch).object);
        }
        for surface in &mut list {
            surface.face_as_most(self.patches);
        }
        list
    }

    fn is_doubtful(&self, object: u32) -> bool {
        let [all, against] = self.edges[object as usize].map(f64::from);
        against > CONTRADICTIONS * all
    }
}

pub(crate) fn is_mesh(object: &Object) -> bool {
    object.shape.mesh().is_some()
}

impl JoinedSurface {
    /// Turns the surface over if most of its area faces the other way than its first patch.
    fn face_as_most(&mut self, patches: &Patches) {
        let area = |&(p, is_reversed): &(u32, bool)| {
            let area = patches.area(p as usize);
            if is_reversed { -area } else { area }
        };
        if self.patches.iter().map(area).sum::<f64>() < 0.0 {
            self.patches.iter_mut().for_each(|(_, r)| *r = !*r);
        }
    }
}

/// Mean irradiance on the sides of a surface, grey, with its replicates, W/m².
struct LightOnSides {
    front: [f64; REPLICATES],
    back: [f64; REPLICATES],
}

impl LightOnSides {
    fn new(
        surface: &JoinedSurface,
        patches: &Patches,
        solution: &RadiositySolution,
    ) -> LightOnSides {
        let mut light = LightOnSides {
            front: [0.0; REPLICATES],
            back: [0.0; REPLICATES],
        };
        let total: f64 = (surface.patches.iter())
            .map(|&(p, _)| patches.area(p as usize))
            .sum();
        for &(patch, is_reversed) in &surface.patches {
            let share = patches.area(patch as usize) / total;
            for front in [true, false] {
                let replicates = irradiance(solution, side(patch, front) as usize);
                let sums = if front != is_reversed {
                    &mut light.front
                } else {
                    &mut light.back
                };
                sums.iter_mut()
                    .zip(replicates)
                    .for_each(|(s, e)| *s += share * e);
            }
        }
        light
    }

    /// Whether the back is brighter, and that is not an accident.
    fn is_back_significant(&self) -> bool {
        let difference = Gathered {
            replicates: std::array::from_fn(|r| Rgb::grey(self.back[r] - self.front[r])),
        };
        difference.mean().mean() > SIGNIFICANT * difference.standard_error().mean()
    }

    fn is_back_clearly_brighter(&self) -> bool {
        let [front, back] = self.means();
        back > CLEARLY * front && self.is_back_significant()
    }

    /// Whether the back alone has light.
    fn is_front_unlit(&self) -> bool {
        let [front, back] = self.means();
        back > 0.0 && front <= UNLIT * back && self.is_back_significant()
    }

    /// Whether no light reaches the back.
    fn is_back_unlit(&self) -> bool {
        let [front, back] = self.means();
        back <= UNLIT * front
    }

    fn means(&self) -> [f64; 2] {
        [self.front, self.back].map(|e| e.iter().sum::<f64>() / REPLICATES as f64)
    }
}

/// Irradiance of one side, per replicate: only the mean is stored, which varies as the reflected
/// light does.
fn irradiance(solution: &RadiositySolution, side: usize) -> [f64; REPLICATES] {
    let count = solution.solutions.len();
    let mean: Rgb = solution.solutions.iter().map(|x| x[side]).sum::<Rgb>() / count as f64;
    std::array::from_fn(|r| {
        let reflected = solution.solutions[r % count][side];
        let channel = |k: usize| {
            let e = solution.incident[side][k];
            if mean[k] > 0.0 {
                e * reflected[k] / mean[k]
            } else {
                e
            }
        };
        (0..3).map(channel).sum::<f64>() / 3.0
    })
}
