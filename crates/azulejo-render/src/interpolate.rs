//! Values interpolated between vertices: irradiance, normals, colours and textures at a hit.

use azulejo_scene::math::area_vector;
use azulejo_scene::{
    Attribute, BackIrradiance, Image, IrradiancePicture, Material, Mesh, Object, PlacedMesh,
    Primitive, Rgb, Scene, Shape, Sidedness, TriangleTree,
};
use azulejo_trace::{Item, KernelHit, KernelRay, Tracer};
use glam::{DAffine3, DVec2, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Interpolates the values of vertices at the hits of a tracer.
pub(crate) struct Interpolator<'a> {
    scene: &'a Scene,
    tracer: &'a Tracer,
    /// By prototype: what all instances of a mesh share is stored once.
    items: Vec<ItemFace>,
    /// For each object the normals of its mesh, if it has smoothing groups instead.
    group_normals: Vec<Option<Arc<Attribute<DVec3>>>>,
    /// For each object its proxy mesh, if it is an exact shape with irradiance.
    proxies: Vec<Option<IrradianceProxy<'a>>>,
}

/// The mesh on which an exact shape carries its irradiance.
struct IrradianceProxy<'a> {
    mesh: &'a Mesh,
    tree: TriangleTree,
    /// One per triangle of the tree.
    items: Vec<ItemFace>,
}

/// The face that an item belongs to.
#[derive(Clone, Copy, Debug)]
struct ItemFace {
    /// Index of the object; of the first instance of a shared mesh.
    object: u32,
    /// Position of the face's first corner in the mesh; for a primitive, the part.
    start: u32,
    /// Corners of the triangle, counted within the face.
    corners: [u32; 3],
    /// The remaining corner of a quadrilateral that is convex along its normal, in the affine
    /// coordinates in which the triangle is (0, 0), (1, 0), (0, 1); NaN for all other faces.
    fourth: [f32; 2],
    /// Size of the face or of the primitive's cell, scene units, and without irradiance infinite; of a
    /// shared mesh in its coordinates.
    footprint: f32,
}

/// Where the irradiance at a hit is read, and the size of the patch there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IrradianceLookup<'a> {
    source: IrradianceSource<'a>,
    footprint: f32,
}

#[derive(Clone, Copy, Debug)]
enum IrradianceSource<'a> {
    /// Between the corners of a face.
    Mesh(PlacedMesh<'a>, Weights),
    /// In a lightmap.
    Lightmap(LightmapTexel<'a>),
    /// At `(u, v)` of a part of a primitive.
    Primitive(&'a Primitive, usize, f64, f64),
    /// On an exact shape: on the nearest face of its proxy mesh, if it has one.
    Exact(Option<(&'a Mesh, Weights)>),
}

/// A place in a lightmap.
#[derive(Clone, Copy, Debug)]
struct LightmapTexel<'a> {
    lightmap: IrradiancePicture,
    image: &'a Image,
    uv: DVec2,
    /// Whether the back shows it, too.
    both_sides: bool,
}

/// A mean of up to four corners of one face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weights {
    /// Positions in [`azulejo_scene::Faces::corners`]; unused ones repeat the first.
    corners: [usize; 4],
    /// Their weights, which add up to 1.
    weights: [f64; 4],
}

impl<'a> Interpolator<'a> {
    /// Prepares every item of `tracer`, which must have been made from `scene`.
    pub fn new(scene: &'a Scene, tracer: &'a Tracer) -> Interpolator<'a> {
        // Items of one face follow each other, so each face is divided once.
        let mut last = (u32::MAX, u32::MAX);
        let mut triangles = Vec::new();
        let items = tracer.prototype_items().into_iter().map(|i| {
            let item = tracer.item(i);
            if last != (item.object, item.face) {
                last = (item.object, item.face);
                triangles.clear();
                if let Some(mesh) = scene.objects[item.object as usize].shape.mesh() {
                    mesh.triangulate_into(item.face as usize, &mut triangles);
                }
            }
            let corners = triangles.get(item.triangle as usize).copied();
            ItemFace::new(scene, &item, corners.unwrap_or([0, 1, 2]))
        });
        Interpolator {
            items: items.collect(),
            proxies: scene
                .objects
                .iter()
                .map(|o| IrradianceProxy::of(&o.shape))
                .collect(),
            group_normals: group_normals(scene),
            scene,
            tracer,
        }
    }

    /// Where the irradiance at the hit of a ray is read.
    pub fn lookup(&self, ray: &KernelRay, hit: &KernelHit) -> IrradianceLookup<'a> {
        let (item, shape) = self.at(hit);
        let [u, v] = hit.uv().map(f64::from);
        if let Some(placed) = shape.placed_mesh() {
            let weights = Weights::on_face(item, u, v);
            if let Some(texel) = self.texel(hit, &placed, &weights) {
                return IrradianceLookup {
                    // Read from any distance: the lamps whose light it has may be gone.
                    footprint: 0.0,
                    source: IrradianceSource::Lightmap(texel),
                };
            }
            return IrradianceLookup {
                footprint: footprint(&placed, item),
                source: IrradianceSource::Mesh(placed, weights),
            };
        }
        match shape {
            Shape::Primitive(p) => IrradianceLookup {
                source: IrradianceSource::Primitive(p, item.start as usize, u, v),
                footprint: item.footprint,
            },
            _ => self.on_proxy(item.object, ray, hit),
        }
    }

    /// Whether the surface at a hit has a lightmap, and no irradiance on vertices.
    pub fn is_baked(&self, hit: &KernelHit) -> bool {
        let (_, shape) = self.at(hit);
        let placed = shape.placed_mesh();
        placed.is_some_and(|placed| self.lightmap(hit, &placed).is_some())
    }

    /// The lightmap at a hit of a mesh without irradiance on vertices, and whether backs show it.
    fn lightmap(
        &self,
        hit: &KernelHit,
        placed: &PlacedMesh<'a>,
    ) -> Option<(IrradiancePicture, &'a Image, bool)> {
        if !placed.irradiance.is_empty() || placed.mesh.lightmap_uvs.is_none() {
            return None;
        }
        let face = self.tracer.item(hit.item).face as usize;
        let material = placed.mesh.face_materials[face];
        let (lightmap, image) = self.scene.lightmap(material)?;
        let sidedness = self.scene.materials[material as usize].sidedness;
        Some((lightmap, image, sidedness != Sidedness::One))
    }

    /// The place in the lightmap at a hit.
    fn texel(
        &self,
        hit: &KernelHit,
        placed: &PlacedMesh<'a>,
        weights: &Weights,
    ) -> Option<LightmapTexel<'a>> {
        let (lightmap, image, both_sides) = self.lightmap(hit, placed)?;
        let uvs = placed.mesh.lightmap_uvs.as_ref()?;
        Some(LightmapTexel {
            lightmap,
            image,
            uv: weights.of_attribute(placed.mesh, uvs),
            both_sides,
        })
    }

    /// The face that was hit, and the shape of its object.
    fn at(&self, hit: &KernelHit) -> (&ItemFace, &'a Shape) {
        let item = &self.items[self.tracer.prototype(hit.item) as usize];
        let object = if self.tracer.is_instanced(hit.item) {
            self.tracer.item(hit.item).object
        } else {
            item.object
        };
        (item, &self.scene.objects[object as usize].shape)
    }

    fn on_proxy(&self, object: u32, ray: &KernelRay, hit: &KernelHit) -> IrradianceLookup<'a> {
        let near = self.proxies[object as usize].as_ref().and_then(|proxy| {
            let at = self.tracer.resolve(&self.tracer.world_ray(ray), hit);
            let on = proxy.tree.nearest(at.position, at.normal)?;
            let item = &proxy.items[on.index as usize];
            Some((
                proxy.mesh,
                Weights::on_face(item, on.u, on.v),
                item.footprint,
            ))
        });
        IrradianceLookup {
            source: IrradianceSource::Exact(near.map(|(mesh, weights, _)| (mesh, weights))),
            footprint: near.map_or(f32::INFINITY, |near| near.2),
        }
    }

    /// Unit shading normal at a hit, interpolated; `None` where the object has no vertex normals:
    /// exact shapes are smooth without.
    pub fn shading_normal(&self, hit: &KernelHit) -> Option<DVec3> {
        let (item, shape) = self.at(hit);
        let placed = shape.placed_mesh()?;
        let mesh = placed.mesh;
        let normals = match &mesh.normals {
            Some(normals) => normals,
            None => self.group_normals[item.object as usize].as_deref()?,
        };
        let [u, v] = hit.uv().map(f64::from);
        let weights = Weights::on_face(item, u, v);
        let pairs = weights.corners.iter().zip(weights.weights);
        let sum: DVec3 = pairs
            .map(|(&c, w)| w * normals.at(c, mesh.faces.corners[c]))
            .sum();
        Some(placed.to_world(sum.try_normalize()?))
    }

    /// Diffuse reflectance at a hit: the material's, times vertex colours, times textures.
    ///
    /// Textures that could not be loaded, and those on objects without texture coordinates,
    /// change nothing.
    pub fn reflectance(&self, hit: &KernelHit, material: &Material) -> Rgb {
        material.diffuse * self.pattern(hit, material)
    }

    /// The factor by which vertex colours and textures change a material's colour at a hit.
    pub fn pattern(&self, hit: &KernelHit, material: &Material) -> Rgb {
        let (item, shape) = self.at(hit);
        let is_painted = |mesh: &&Mesh| !(mesh.colors.is_empty() && material.textures.is_empty());
        let Some(mesh) = shape.mesh().filter(is_painted) else {
            return Rgb::WHITE;
        };
        let [u, v] = hit.uv().map(f64::from);
        let weights = Weights::on_face(item, u, v);
        let color = if mesh.colors.is_empty() {
            Rgb::WHITE
        } else {
            weights.of_vertices(mesh, |v| mesh.colors[v])
        };
        let uv = (!material.textures.is_empty()).then(|| weights.uv(mesh));
        let texture = |id| self.scene.textures.get(id as usize);
        material.pattern(color, uv.flatten(), texture)
    }
}

/// For each object the normals by its smoothing groups; instances of one mesh share them.
fn group_normals(scene: &Scene) -> Vec<Option<Arc<Attribute<DVec3>>>> {
    let mut known: HashMap<*const Mesh, Option<Arc<Attribute<DVec3>>>> = HashMap::new();
    let of_object = |object: &Object| {
        let mesh = object.shape.mesh().filter(|m| m.normals.is_none())?;
        let of_mesh = || mesh.group_normals().map(Arc::new);
        let entry = known.entry(std::ptr::from_ref(mesh));
        entry.or_insert_with(of_mesh).clone()
    };
    scene.objects.iter().map(of_object).collect()
}

impl<'a> IrradianceProxy<'a> {
    /// `None` for shapes without a proxy mesh that carries irradiance.
    fn of(shape: &'a Shape) -> Option<IrradianceProxy<'a>> {
        let Shape::Exact(exact) = shape else {
            return None;
        };
        let mesh = exact
            .proxy
            .as_deref()
            .filter(|m| !m.irradiance.is_empty())?;
        let tree = TriangleTree::new(mesh);
        let item = |k: u32| {
            let triangle = tree.triangle(k);
            ItemFace::of_mesh(mesh, triangle.face as usize, triangle.corners)
        };
        Some(IrradianceProxy {
            mesh,
            items: (0..tree.len() as u32).map(item).collect(),
            tree,
        })
    }
}

impl ItemFace {
    fn new(scene: &Scene, item: &Item, corners: [u32; 3]) -> ItemFace {
        let object = item.object;
        let shape = &scene.objects[object as usize].shape;
        if let Some(mesh) = shape.mesh() {
            return ItemFace {
                object,
                ..ItemFace::of_mesh(mesh, item.face as usize, corners)
            };
        }
        match shape {
            Shape::Primitive(p) => {
                let size = || cell_area(p, item.face as usize).sqrt();
                ItemFace {
                    object,
                    start: item.face,
                    corners,
                    fourth: [f32::NAN; 2],
                    footprint: p.light.as_ref().map_or(f32::INFINITY, |_| size() as f32),
                }
            }
            _ => ItemFace {
                object,
                start: item.face,
                corners,
                fourth: [f32::NAN; 2],
                footprint: f32::INFINITY,
            },
        }
    }

    /// A triangle of a face; of object 0.
    fn of_mesh(mesh: &Mesh, face: usize, corners: [u32; 3]) -> ItemFace {
        let positions = mesh.face_positions(face);
        let fourth = fourth_corner(&positions, corners);
        let size = area_vector(&positions).length().sqrt() as f32;
        ItemFace {
            object: 0,
            start: mesh.faces.starts[face],
            corners,
            fourth: fourth.map_or([f32::NAN; 2], |c| c.as_vec2().to_array()),
            footprint: size,
        }
    }
}

/// Size of a face of a mesh in the world; infinite without irradiance. Maps that stretch are taken as
/// their mean scale.
fn footprint(placed: &PlacedMesh, item: &ItemFace) -> f32 {
    if placed.irradiance.is_empty() {
        return f32::INFINITY;
    }
    let scale = |map: &DAffine3| map.matrix3.determinant().cbrt() as f32;
    item.footprint * placed.world_from_mesh().map_or(1.0, scale)
}

/// The corner of a quadrilateral that a triangle of it lacks, in the triangle's affine
/// coordinates, seen along the quadrilateral's normal. `None` unless the face is a quadrilateral
/// and convex from there; corners of 180° are allowed.
fn fourth_corner(positions: &[DVec3], triangle: [u32; 3]) -> Option<DVec2> {
    let quad: &[DVec3; 4] = positions.try_into().ok()?;
    let normal = area_vector(quad);
    let [p, q, r] = triangle.map(|k| quad[k as usize]);
    let missing = 6 - triangle.iter().sum::<u32>();
    let cross = |a: DVec3, b: DVec3| a.cross(b).dot(normal);
    let whole = cross(q - p, r - p);
    let rest = quad[missing as usize] - p;
    let fourth = DVec2::new(cross(rest, r - p), cross(q - p, rest)) / whole;
    let is_convex = (0..4).all(|k| {
        let [a, b, c] = [0, 1, 2].map(|turn| quad[(k + turn) % 4]);
        // A corner of 180° may be a rounding error beyond it.
        cross(b - a, c - b) >= -1e-9 * normal.length_squared()
    });
    (is_convex && fourth.is_finite()).then_some(fourth)
}

/// Area of a typical cell of the grid on a part of a primitive.
fn cell_area(p: &Primitive, part: usize) -> f64 {
    let grid = p.light.as_ref().and_then(|light| light.grids.get(part));
    let cells = grid.map_or(1, |grid| grid.cells().max(1));
    p.point(part, 0.5, 0.5).area_density / cells as f64
}

impl IrradianceLookup<'_> {
    /// Irradiance of the first pass on a side, W/m²; `None` where none is stored for it.
    pub fn irradiance(&self, front: bool) -> Option<Rgb> {
        match (&self.source, front) {
            (IrradianceSource::Mesh(placed, weights), true) => {
                let values = placed.irradiance;
                (!values.is_empty()).then(|| weights.of_vertices(placed.mesh, |v| values[v]))
            }
            (IrradianceSource::Exact(Some((mesh, weights))), true) => {
                let values = &mesh.irradiance;
                (!values.is_empty()).then(|| weights.of_vertices(mesh, |v| values[v]))
            }
            (IrradianceSource::Mesh(placed, weights), false) => {
                weights.of_backs(placed.mesh, placed.back?)
            }
            (IrradianceSource::Lightmap(texel), front) => {
                let shown = front || texel.both_sides;
                shown.then(|| texel.lightmap.at(texel.image, texel.uv))
            }
            (IrradianceSource::Primitive(p, part, u, v), true) => {
                p.light.as_ref().map(|light| light.at(*part, *u, *v))
            }
            // Exact shapes carry the light of their outside.
            (IrradianceSource::Primitive(..) | IrradianceSource::Exact(_), _) => None,
        }
    }

    /// Whether the irradiance of the corners differs by more than `share` of the largest, beyond their standard errors, so
    /// that the light between them is not known: it may change at a line, and it may not change at all where
    /// a corner alone is lit through a gap.
    pub fn is_uneven(&self, front: bool, share: f64) -> bool {
        match (&self.source, front) {
            (IrradianceSource::Mesh(placed, weights), true) => weights.is_uneven(
                placed.mesh,
                &|v| placed.irradiance.get(v).copied(),
                placed.irradiance_error,
                share,
            ),
            (IrradianceSource::Exact(Some((mesh, weights))), true) => weights.is_uneven(
                mesh,
                &|v| mesh.irradiance.get(v).copied(),
                &mesh.irradiance_error,
                share,
            ),
            (IrradianceSource::Mesh(placed, weights), false) => placed.back.is_some_and(|back| {
                let value = |v: usize| back.irradiance.get(v).copied().flatten();
                weights.is_uneven(placed.mesh, &value, &back.error, share)
            }),
            (IrradianceSource::Primitive(p, part, u, v), true) => {
                let light = p.light.as_ref();
                light.is_some_and(|light| {
                    let values = light.around(*part, *u, *v).map(|k| {
                        let error = light.error.get(k).copied().unwrap_or_default();
                        (light.irradiance[k].mean(), error.mean())
                    });
                    differ(values, share)
                })
            }
            // Texels are as fine as whoever baked them wanted.
            (IrradianceSource::Lightmap(_), _) => false,
            (IrradianceSource::Primitive(..) | IrradianceSource::Exact(_), _) => false,
        }
    }

    /// Whether it is read in a lightmap.
    pub fn is_baked(&self) -> bool {
        matches!(self.source, IrradianceSource::Lightmap(_))
    }

    /// Size of the patch, scene units: from nearer than this its interpolated irradiance is too
    /// coarse. Infinite where there is no irradiance.
    pub fn footprint(&self) -> f32 {
        self.footprint
    }
}

impl Weights {
    /// Weights where the barycentric coordinates in the item's triangle are `u`, `v`.
    ///
    /// Triangles are barycentric. Convex quadrilaterals are bilinear, so that no diagonal shows;
    /// bent ones are projected along their normal. Other faces are interpolated in their
    /// triangles. All agree along shared edges, where each is linear between the edge's two ends.
    fn on_face(item: &ItemFace, u: f64, v: f64) -> Weights {
        let start = item.start as usize;
        if item.fourth[0].is_nan() {
            return Weights::in_triangle(start, item.corners, u, v);
        }
        // The triangle's corners are 0, 1, 2 and 3 but one: the missing one makes the sum 6.
        let mut quad = [item.fourth.map(f64::from).into(); 4];
        for (&corner, point) in item.corners.iter().zip([DVec2::ZERO, DVec2::X, DVec2::Y]) {
            quad[corner as usize] = point;
        }
        let (s, t) = bilinear(quad, DVec2::new(u, v));
        Weights::in_quadrilateral(start, s, t)
    }

    fn in_triangle(start: usize, [a, b, c]: [u32; 3], u: f64, v: f64) -> Weights {
        Weights {
            corners: [a, b, c, a].map(|k| start + k as usize),
            weights: [1.0 - u - v, u, v, 0.0],
        }
    }

    fn in_quadrilateral(start: usize, s: f64, t: f64) -> Weights {
        Weights {
            corners: [start, start + 1, start + 2, start + 3],
            weights: [(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t],
        }
    }

    /// Whether the values of the corners differ beyond their errors; see [`differ`].
    fn is_uneven(
        &self,
        mesh: &Mesh,
        value: &impl Fn(usize) -> Option<Rgb>,
        errors: &[Rgb],
        share: f64,
    ) -> bool {
        let corners = self.corners.iter();
        let known = corners.filter_map(|&c| {
            let vertex = mesh.faces.corners[c] as usize;
            let error = errors.get(vertex).copied().unwrap_or_default();
            Some((value(vertex)?.mean(), error.mean()))
        });
        differ(known, share)
    }

    /// The mean of the irradiance on the backs of vertices, if all of them have any.
    fn of_backs(&self, mesh: &Mesh, back: &BackIrradiance) -> Option<Rgb> {
        let at = |c: usize| back.irradiance[mesh.faces.corners[c] as usize];
        // Corners that do not count repeat the first.
        let is_known = self.corners.iter().all(|&c| at(c).is_some());
        is_known.then(|| {
            let known = |v: usize| back.irradiance[v].unwrap_or(Rgb::BLACK);
            self.of_vertices(mesh, known)
        })
    }

    /// The mean of per-vertex values.
    fn of_vertices(&self, mesh: &Mesh, values: impl Fn(usize) -> Rgb) -> Rgb {
        let value = |k: usize| values(mesh.faces.corners[self.corners[k]] as usize);
        let w = self.weights;
        (value(0) * w[0] + value(1) * w[1]) + (value(2) * w[2] + value(3) * w[3])
    }

    fn uv(&self, mesh: &Mesh) -> Option<DVec2> {
        Some(self.of_attribute(mesh, mesh.uvs.as_ref()?))
    }

    /// The mean of texture coordinates.
    fn of_attribute(&self, mesh: &Mesh, uvs: &Attribute<DVec2>) -> DVec2 {
        let pairs = self.corners.iter().zip(self.weights);
        pairs
            .map(|(&c, w)| w * uvs.at(c, mesh.faces.corners[c]))
            .sum()
    }
}

/// Whether the largest of some values exceeds the least by more than a share of itself and three of their standard
/// errors.
fn differ(values: impl IntoIterator<Item = (f64, f64)>, share: f64) -> bool {
    let start = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
    let (least, most, error) = values.into_iter().fold(start, |(a, b, e), (value, error)| {
        (a.min(value), b.max(value), e.max(error))
    });
    most - least > share * most + 3.0 * error
}

/// Bilinear coordinates `(s, t)`, in 0..=1, of the point
/// `lerp(lerp(a, b, s), lerp(d, c, s), t)` of a convex counter-clockwise quadrilateral.
///
/// Points outside are clamped. At a corner of 180° or beyond, where the map folds up, the result
/// is finite but need not be the point's.
fn bilinear([a, b, c, d]: [DVec2; 4], point: DVec2) -> (f64, f64) {
    // With h = point − a = s e + t f + s t g; eliminating s leaves k2 t² + k1 t + k0 = 0, which
    // rises through the one root between 0 and 1.
    let (e, f, g, h) = (b - a, d - a, a - b + c - d, point - a);
    let (k2, k1, k0) = (g.perp_dot(f), e.perp_dot(f) + h.perp_dot(g), h.perp_dot(e));
    let root = (k1 * k1 - 4.0 * k2 * k0).max(0.0).sqrt();
    let t = if k1 >= 0.0 {
        -2.0 * k0 / (k1 + root)
    } else {
        (root - k1) / (2.0 * k2)
    };
    let across = e + t * g;
    let s = (h - t * f).dot(across) / across.length_squared();
    // A fold divides zero by zero; any corner will do there.
    let within = |x: f64| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) };
    (within(s), within(t))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bilinear coordinates come back from the point that they make, whichever triangle of the
    /// quadrilateral was hit.
    fn check(quad: [[f64; 2]; 4]) {
        // A tilted plane, and a mirrored one.
        for (x, y) in [
            (DVec3::new(0.6, 0.8, 0.0), DVec3::Z),
            (DVec3::new(1.0, 0.5, 0.0), -DVec3::Y),
        ] {
            let corners = quad.map(|[a, b]| DVec3::splat(9.0) + a * x + b * y);
            for triangle in [[0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3]] {
                check_triangle(&corners, triangle);
            }
        }
    }

    fn check_triangle(corners: &[DVec3; 4], triangle: [u32; 3]) {
        let fourth = fourth_corner(corners, triangle).expect("convex");
        let item = ItemFace {
            object: 0,
            start: 10,
            corners: triangle,
            fourth: fourth.as_vec2().to_array(),
            footprint: 0.0,
        };
        let [p, q, r] = triangle.map(|k| corners[k as usize]);
        let normal = (q - p).cross(r - p);
        for (s, t) in [(0.0, 0.0), (0.3, 0.8), (0.5, 0.5), (1.0, 0.2), (0.7, 1.0)] {
            let bottom = corners[0].lerp(corners[1], s);
            let at = bottom.lerp(corners[3].lerp(corners[2], s), t) - p;
            let u = at.cross(r - p).dot(normal) / normal.length_squared();
            let v = (q - p).cross(at).dot(normal) / normal.length_squared();
            let weights = Weights::on_face(&item, u, v);
            let expected = Weights::in_quadrilateral(10, s, t);
            assert_eq!(weights.corners, expected.corners);
            for (a, b) in weights.weights.iter().zip(expected.weights) {
                assert!((a - b).abs() < 1e-5, "{corners:?} ({s}, {t}): {weights:?}");
            }
        }
    }

    #[test]
    fn bilinear_inverts_convex_quadrilaterals() {
        check([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        check([[0.0, 0.0], [3.0, 0.5], [4.0, 2.0], [1.0, 1.5]]);
        check([[0.0, 0.0], [5.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        check([[0.0, 0.0], [1.0, 0.0], [7.0, 6.0], [-1.0, 2.0]]);
        check([[-3.0, 0.0], [0.0, -0.2], [0.5, 0.0], [0.1, 3.0]]);
    }

    #[test]
    fn other_faces_go_by_their_triangles() {
        let refused = |polygon: &[[f64; 2]]| {
            let corners: Vec<DVec3> = polygon
                .iter()
                .map(|&[x, y]| DVec3::new(x, y, 0.0))
                .collect();
            assert_eq!(fourth_corner(&corners, [0, 1, 2]), None, "{polygon:?}");
        };
        refused(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        refused(&[[0.0, 0.0], [2.0, -2.0], [0.5, 0.0], [2.0, 2.0]]);
        refused(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]);
        refused(&[[0.1, 0.1]; 4]);
        refused(&[[0.0, 0.0], [1.0, 0.0], [1.5, 1.0], [1.0, 2.0], [0.0, 2.0]]);
    }

    #[test]
    fn corners_of_180_degrees_and_folds_stay_finite() {
        let bent = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0]].map(DVec2::from);
        for (x, y) in [(0.1, 0.1), (1.0, 0.0), (1.9, 0.0), (0.5, 0.3), (-1.0, 5.0)] {
            let (s, t) = bilinear(bent, DVec2::new(x, y));
            assert!(
                (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t),
                "{x} {y}: {s} {t}"
            );
        }
        let (s, t) = bilinear([DVec2::ZERO; 4], DVec2::ZERO);
        assert!((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t));
    }
}
