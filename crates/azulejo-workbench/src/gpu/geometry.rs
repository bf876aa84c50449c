//! Meshes in GPU memory.
//!
//! Only the vertex streams that the shading mode needs are uploaded, when they are first needed.

use super::GpuError;
use super::frame::{DrawnMesh, FaceValues};
use super::mesh_pieces::{MeshPiece, for_each_piece};
use super::pipelines::VertexAttributes;
use azulejo::scene::math::Aabb;
use azulejo::scene::{MaterialId, Mesh, Rgb};
use bytemuck::Pod;
use glam::{DVec3, Vec3};
use std::ops::Range;

/// Limit on data in flight to the GPU before waiting for it, in bytes.
const MAX_IN_FLIGHT: u64 = 64 << 20;
/// Limit on the number of highlighted triangles.
const MAX_SELECTED: usize = 1 << 22;
/// The value stored for the largest irradiance: far below the largest half float, 65504.
const BRIGHTEST: f64 = 16384.0;

/// The vertex streams that a shading mode needs beside positions, and its other geometry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct VertexStreams {
    pub normals: bool,
    /// Irradiance of vertices, and places in the lightmap.
    pub light: bool,
    pub lightmap: bool,
    pub colors: bool,
    pub uvs: bool,
    pub edges: bool,
    /// Triangles that share no vertices, so that each face has a value of its own.
    pub facets: FacetAttribute,
}

/// The source of per-face values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FacetAttribute {
    #[default]
    None,
    /// The mean irradiance of the corners.
    Light,
    /// The values in the frame.
    Values,
}

/// A mesh in GPU memory.
#[derive(Debug)]
pub struct GpuMesh {
    /// The origin that positions are relative to.
    pub origin: DVec3,
    /// Radius of a bounding sphere around the origin.
    pub radius: f64,
    pub pieces: Vec<PieceBuffers>,
    /// Irradiance that the stored value 1 stands for; 0 for a mesh without irradiance.
    pub light_scale: f64,
    /// Value that the stored facet value 1 stands for.
    pub facet_scale: f64,
    pub selection: Option<SelectionBuffers>,
    /// The frame in which it was last drawn.
    pub used: u64,
    light_key: Option<u64>,
    facet_key: Option<(FacetAttribute, u64)>,
}

/// The buffers of a piece of a mesh.
#[derive(Debug)]
pub struct PieceBuffers {
    pub centre: Vec3,
    pub radius: f32,
    pub ranges: Vec<(MaterialId, Range<u32>)>,
    pub vertex_count: u32,
    pub edge_ends: u32,
    pub positions: wgpu::Buffer,
    pub triangles: wgpu::Buffer,
    pub normals: Option<wgpu::Buffer>,
    pub light: Option<wgpu::Buffer>,
    pub lightmap: Option<wgpu::Buffer>,
    pub colors: Option<wgpu::Buffer>,
    pub uvs: Option<wgpu::Buffer>,
    pub edges: Option<wgpu::Buffer>,
    pub facets: Option<wgpu::Buffer>,
    pub facet_values: Option<wgpu::Buffer>,
}

/// The buffers of the selected faces.
#[derive(Debug)]
pub struct SelectionBuffers {
    pub positions: wgpu::Buffer,
    pub vertex_count: u32,
    faces: Vec<u32>,
}

/// Uploads data to the GPU.
pub struct GpuUploader<'a> {
    pub device: &'a wgpu::Device,
    pub queue: &'a wgpu::Queue,
    /// Bytes uploaded in total.
    pub bytes: u64,
    under_way: u64,
}

impl<'a> GpuUploader<'a> {
    pub fn new(device: &'a wgpu::Device, queue: &'a wgpu::Queue) -> GpuUploader<'a> {
        GpuUploader {
            device,
            queue,
            bytes: 0,
            under_way: 0,
        }
    }

    fn load<T: Pod>(&mut self, usage: wgpu::BufferUsages, data: &[T]) -> wgpu::Buffer {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("geometry"),
            size: (bytes.len() as u64).max(4),
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, bytes);
        self.bytes += bytes.len() as u64;
        self.under_way += bytes.len() as u64;
        if self.under_way > MAX_IN_FLIGHT {
            self.queue.submit([]);
            // A lost device is detected elsewhere.
            let _ = self.device.poll(wgpu::PollType::wait_indefinitely());
            self.under_way = 0;
        }
        buffer
    }

    fn vertices<T: Pod>(&mut self, data: impl Iterator<Item = T>) -> wgpu::Buffer {
        self.load(wgpu::BufferUsages::VERTEX, &data.collect::<Vec<T>>())
    }
}

impl GpuMesh {
    /// Prepares a mesh without uploading anything.
    pub fn new(mesh: &Mesh) -> GpuMesh {
        let bounds = mesh.bounds();
        GpuMesh {
            origin: bounds.centre(),
            radius: 0.5 * bounds.diagonal(),
            pieces: Vec::new(),
            light_scale: 0.0,
            facet_scale: 0.0,
            selection: None,
            used: 0,
            light_key: None,
            facet_key: None,
        }
    }

    /// Uploads the streams in `wanted` that are missing or out of date.
    pub fn upload(
        &mut self,
        drawn: &DrawnMesh,
        wanted: VertexStreams,
        loader: &mut GpuUploader,
    ) -> Result<(), GpuError> {
        let mesh = drawn.mesh;
        let source = FacetSource::new(drawn, wanted.facets);
        // Drop irradiance of an earlier revision; the scale keeps its maximum within half floats.
        if self.light_key != Some(drawn.light_key) {
            self.pieces.iter_mut().for_each(|p| p.light = None);
            self.light_key = Some(drawn.light_key);
            self.light_scale = brightest(mesh) / BRIGHTEST;
        }
        // Drop values of faces likewise, also if they came from another source.
        let facet_key = source.key(drawn).map(|key| (wanted.facets, key));
        if facet_key.is_some() && self.facet_key != facet_key {
            self.pieces.iter_mut().for_each(|p| p.facet_values = None);
            self.facet_key = facet_key;
            self.facet_scale = source.brightest() / BRIGHTEST;
        }
        // Request only what the mesh has for each vertex: other attributes are constant.
        let streams = VertexStreams {
            normals: wanted.normals && mesh.normals.is_some(),
            light: wanted.light && is_solved(mesh),
            lightmap: wanted.light && places_of(drawn).is_some(),
            colors: wanted.colors && mesh.colors.len() == mesh.positions.len(),
            uvs: wanted.uvs && mesh.uvs.is_some(),
            ..wanted
        };
        // Of a mesh without pieces `all` is true, although nothing was uploaded.
        let is_there = self.pieces.iter().all(|p| p.has(streams));
        if is_there && (mesh.faces.is_empty() || !self.pieces.is_empty()) {
            return Ok(());
        }
        // Pieces come in a reproducible order, and so meet the buffers that they have filled before.
        let mut number = 0;
        for_each_piece(mesh, streams.edges, |piece| {
            if number == self.pieces.len() {
                let buffers = PieceBuffers::new(mesh, self.origin, piece, loader);
                self.pieces.push(buffers);
            }
            let scales = [self.light_scale, self.facet_scale];
            let origin = self.origin;
            let buffers = &mut self.pieces[number];
            buffers.complete(mesh, piece, streams, loader, scales[0]);
            if let Some(places) = places_of(drawn).filter(|_| streams.lightmap) {
                buffers.complete_lightmap(places, piece, loader);
            }
            if streams.facets != FacetAttribute::None {
                buffers.complete_facets(mesh, piece, origin, &source, scales[1], loader);
            }
            number += 1;
            Ok(())
        })
    }

    /// The attributes that have a value for each vertex.
    pub fn attributes(&self) -> VertexAttributes {
        self.pieces
            .first()
            .map_or(VertexAttributes::default(), |p| VertexAttributes {
                normals: p.normals.is_some(),
                light: p.light.is_some(),
                lightmap: p.lightmap.is_some(),
                colors: p.colors.is_some(),
                uvs: p.uvs.is_some(),
            })
    }

    /// Frees the triangles that share no vertices, the largest data of any mode.
    pub fn drop_facets(&mut self) {
        for piece in &mut self.pieces {
            (piece.facets, piece.facet_values) = (None, None);
        }
        self.facet_key = None;
    }

    /// Uploads the selected faces if they have changed.
    pub fn select(&mut self, drawn: &DrawnMesh, loader: &mut GpuUploader) {
        let faces = drawn.selected_faces;
        if faces.is_empty() {
            self.selection = None;
        } else if self.selection.as_ref().is_none_or(|s| s.faces != faces) {
            self.selection = Some(SelectionBuffers::new(
                drawn.mesh,
                self.origin,
                faces,
                loader,
            ));
        }
    }
}

impl SelectionBuffers {
    fn new(
        mesh: &Mesh,
        origin: DVec3,
        faces: &[u32],
        loader: &mut GpuUploader,
    ) -> SelectionBuffers {
        let mut corners: Vec<[f32; 3]> = Vec::new();
        let mut triangles = Vec::new();
        let known = faces.iter().map(|&f| f as usize);
        for face in known.filter(|&f| f < mesh.faces.len()) {
            triangles.clear();
            mesh.triangulate_into(face, &mut triangles);
            let vertices = mesh.faces.get(face);
            let indices = triangles.iter().flatten();
            corners.extend(indices.map(|&k| relative(mesh, vertices[k as usize], origin)));
            if corners.len() > 3 * MAX_SELECTED {
                break;
            }
        }
        SelectionBuffers {
            vertex_count: corners.len() as u32,
            positions: loader.load(wgpu::BufferUsages::VERTEX, &corners),
            faces: faces.to_vec(),
        }
    }
}

impl PieceBuffers {
    fn new(
        mesh: &Mesh,
        origin: DVec3,
        piece: &MeshPiece,
        loader: &mut GpuUploader,
    ) -> PieceBuffers {
        let at = |v: &[u32; 2]| relative(mesh, v[0], origin);
        let bounds = piece.vertices.iter().map(|v| mesh.positions[v[0] as usize]);
        let bounds = Aabb::around(bounds);
        PieceBuffers {
            centre: (bounds.centre() - origin).as_vec3(),
            radius: (0.5 * bounds.diagonal()) as f32,
            ranges: piece.ranges.clone(),
            vertex_count: piece.vertices.len() as u32,
            edge_ends: 0,
            positions: loader.vertices(piece.vertices.iter().map(at)),
            triangles: loader.load(wgpu::BufferUsages::INDEX, &piece.triangles),
            normals: None,
            light: None,
            lightmap: None,
            colors: None,
            uvs: None,
            edges: None,
            facets: None,
            facet_values: None,
        }
    }

    fn has(&self, wanted: VertexStreams) -> bool {
        let facets = self.facets.is_some() && self.facet_values.is_some();
        (!wanted.normals || self.normals.is_some())
            && (!wanted.light || self.light.is_some())
            && (!wanted.lightmap || self.lightmap.is_some())
            && (!wanted.colors || self.colors.is_some())
            && (!wanted.uvs || self.uvs.is_some())
            && (!wanted.edges || self.edges.is_some())
            && (wanted.facets == FacetAttribute::None || facets)
    }

    fn complete(
        &mut self,
        mesh: &Mesh,
        piece: &MeshPiece,
        wanted: VertexStreams,
        loader: &mut GpuUploader,
        light_scale: f64,
    ) {
        let vertices = piece.vertices.iter();
        if let (true, None, Some(normals)) = (wanted.normals, &self.normals, &mesh.normals) {
            let packed = |v: &[u32; 2]| octahedral(normals.at(v[1] as usize, v[0]));
            self.normals = Some(loader.vertices(vertices.clone().map(packed)));
        }
        if let (true, None, Some(uvs)) = (wanted.uvs, &self.uvs, &mesh.uvs) {
            let uv = |v: &[u32; 2]| uvs.at(v[1] as usize, v[0]).as_vec2().to_array();
            self.uvs = Some(loader.vertices(vertices.clone().map(uv)));
        }
        if wanted.light && self.light.is_none() {
            let packed = |v: &[u32; 2]| halves(mesh.irradiance[v[0] as usize], light_scale);
            self.light = Some(loader.vertices(vertices.clone().map(packed)));
        }
        if wanted.colors && self.colors.is_none() {
            let packed = |v: &[u32; 2]| bytes(mesh.colors[v[0] as usize]);
            self.colors = Some(loader.vertices(vertices.map(packed)));
        }
        if wanted.edges && self.edges.is_none() {
            self.edge_ends = piece.edges.len() as u32;
            self.edges = Some(loader.load(wgpu::BufferUsages::INDEX, &piece.edges));
        }
    }

    fn complete_lightmap(
        &mut self,
        places: &[[f32; 3]],
        piece: &MeshPiece,
        loader: &mut GpuUploader,
    ) {
        if self.lightmap.is_none() {
            // The shader takes 0 for none, which meshes without places have.
            let place = |v: &[u32; 2]| {
                let [u, v, page] = places[v[0] as usize];
                [u, v, page + 1.0]
            };
            self.lightmap = Some(loader.vertices(piece.vertices.iter().map(place)));
        }
    }

    fn complete_facets(
        &mut self,
        mesh: &Mesh,
        piece: &MeshPiece,
        origin: DVec3,
        source: &FacetSource,
        scale: f64,
        loader: &mut GpuUploader,
    ) {
        if self.facets.is_none() {
            let corner = |&t: &u32| relative(mesh, piece.vertices[t as usize][0], origin);
            self.facets = Some(loader.vertices(piece.triangles.iter().map(corner)));
        }
        if self.facet_values.is_none() {
            let packed = |&face: &u32| [source.packed(face, scale); 3];
            self.facet_values = Some(loader.vertices(piece.faces.iter().map(packed)));
        }
    }
}

/// Where facet values come from.
enum FacetSource<'a> {
    None,
    Light(&'a Mesh),
    Values(FaceValues<'a>),
}

impl<'a> FacetSource<'a> {
    fn new(drawn: &DrawnMesh<'a>, facets: FacetAttribute) -> FacetSource<'a> {
        match (facets, drawn.face_values) {
            (FacetAttribute::Light, _) if is_solved(drawn.mesh) => FacetSource::Light(drawn.mesh),
            (FacetAttribute::Values, Some(values)) => FacetSource::Values(values),
            _ => FacetSource::None,
        }
    }

    fn key(&self, drawn: &DrawnMesh) -> Option<u64> {
        match self {
            // Without values, those of another mode must not remain.
            FacetSource::None => Some(u64::MAX),
            FacetSource::Light(_) => Some(drawn.light_key),
            FacetSource::Values(values) => Some(values.key),
        }
    }

    fn brightest(&self) -> f64 {
        match self {
            FacetSource::None => 0.0,
            FacetSource::Light(mesh) => brightest(mesh),
            FacetSource::Values(values) => {
                let finite = values.values.iter().filter(|v| v.is_finite());
                positive(f64::from(finite.fold(0f32, |most, &v| most.max(v))))
            }
        }
    }

    /// The value of a face, and whether it is known.
    fn packed(&self, face: u32, scale: f64) -> [u16; 4] {
        let unknown = [0; 4];
        match self {
            FacetSource::None => unknown,
            FacetSource::Light(mesh) => {
                let corners = mesh.faces.get(face as usize);
                let values = corners.iter().map(|&v| mesh.irradiance[v as usize]);
                halves(values.sum::<Rgb>() / corners.len() as f64, scale)
            }
            FacetSource::Values(values) => match values.values.get(face as usize) {
                Some(v) if v.is_finite() => halves(Rgb::grey(f64::from(*v)), scale),
                _ => unknown,
            },
        }
    }
}

/// Whether every vertex has irradiance.
pub fn is_solved(mesh: &Mesh) -> bool {
    !mesh.irradiance.is_empty() && mesh.irradiance.len() == mesh.positions.len()
}

/// The places in the lightmap, if every vertex has one.
fn places_of<'a>(drawn: &DrawnMesh<'a>) -> Option<&'a [[f32; 3]]> {
    let is_complete = |places: &&[[f32; 3]]| places.len() == drawn.mesh.positions.len();
    drawn.lightmap.filter(is_complete)
}

fn brightest(mesh: &Mesh) -> f64 {
    if !is_solved(mesh) {
        return 0.0;
    }
    let channels = mesh.irradiance.iter().map(|e| e.max_channel());
    let most = channels.filter(|e| e.is_finite()).fold(0.0, f64::max);
    positive(most)
}

/// A solution may be completely dark; use 1 as its unit.
fn positive(most: f64) -> f64 {
    if most > 0.0 { most } else { 1.0 }
}

fn relative(mesh: &Mesh, vertex: u32, origin: DVec3) -> [f32; 3] {
    (mesh.positions[vertex as usize] - origin)
        .as_vec3()
        .to_array()
}

/// Irradiance in units of `scale` as half floats; the fourth component marks it as known.
fn halves(light: Rgb, scale: f64) -> [u16; 4] {
    let part = |x: f64| half(if scale > 0.0 { (x / scale) as f32 } else { 0.0 });
    [part(light.r), part(light.g), part(light.b), half(1.0)]
}

/// The nearest half float in 0..=65504; 0 for negative values and NaN.
pub fn half(x: f32) -> u16 {
    let x = if x > 0.0 { x.min(65504.0) } else { 0.0 };
    // 2^-112 changes the exponent's bias from 127 to 15 and maps small values to subnormals.
    let bits = (x * f32::from_bits(0x0780_0000)).to_bits();
    ((bits + 0xfff + (bits >> 13 & 1)) >> 13) as u16
}

fn bytes(color: Rgb) -> [u8; 4] {
    let byte = |x: f64| (255.0 * x.clamp(0.0, 1.0)).round() as u8;
    [byte(color.r), byte(color.g), byte(color.b), 255]
}

/// A unit vector in octahedral encoding: Meyer et al., *On Floating-Point Normal Vectors*, EGSR
/// 2010. Accurate to 4e-5 rad.
fn octahedral(n: DVec3) -> [i16; 2] {
    let p = n / (n.x.abs() + n.y.abs() + n.z.abs()).max(f64::MIN_POSITIVE);
    let fold = |x: f64, y: f64| (1.0 - y.abs()) * 1f64.copysign(x);
    let (x, y) = if p.z < 0.0 {
        (fold(p.x, p.y), fold(p.y, p.x))
    } else {
        (p.x, p.y)
    };
    [x, y].map(|k| (32767.0 * k).round() as i16)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The value of a half float >= 0.
    fn value(half: u16) -> f64 {
        let (exponent, fraction) = (i32::from(half >> 10), f64::from(half & 0x3ff));
        match exponent {
            0 => fraction * 2f64.powi(-24),
            _ => (1024.0 + fraction) * 2f64.powi(exponent - 25),
        }
    }

    #[test]
    fn half_floats_are_the_nearest() {
        for x in [0.0, 6e-8, 1e-5, 0.1, 1.0, 2049.0, 16384.0, 65504.0] {
            let step = (x * 2f64.powi(-11)).max(2f64.powi(-25));
            assert!((value(half(x as f32)) - x).abs() <= 1.01 * step, "{x}");
        }
        assert_eq!(half(1e9), half(65504.0));
        assert_eq!((half(-1.0), half(f32::NAN)), (0, 0));
    }

    #[test]
    fn normals_survive_their_packing() {
        for k in 0..200 {
            let (z, a) = (f64::from(k) / 99.5 - 1.0, f64::from(k) * 2.4);
            let r = (1.0 - z * z).max(0.0).sqrt();
            let n = DVec3::new(r * a.cos(), r * a.sin(), z);
            let [x, y] = octahedral(n).map(|k| f64::from(k) / 32767.0);
            let mut back = DVec3::new(x, y, 1.0 - x.abs() - y.abs());
            if back.z < 0.0 {
                let fold = |x: f64, y: f64| (1.0 - y.abs()) * 1f64.copysign(x);
                (back.x, back.y) = (fold(x, y), fold(y, x));
            }
            assert!(back.normalize().dot(n) > 1.0 - 1e-8, "{n} {back}");
        }
    }
}
