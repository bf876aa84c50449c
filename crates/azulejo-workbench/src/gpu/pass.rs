//! The order in which a frame is drawn.

use super::frame::{DrawnMesh, ViewportFrame};
use super::geometry::{FacetAttribute, GpuMesh, PieceBuffers, VertexStreams};
use super::overlay::WORDS;
use super::pipelines::{DrawStage, PipelineKey, RenderPipelines, VertexAttributes};
use super::renderer::DefaultAttributes;
use super::textures::TextureCache;
use super::uniforms::{self, UniformBlocks};
use crate::projection::Projection;
use crate::view::Shading;
use glam::{DAffine3, DVec3};
use std::collections::HashMap;

/// What a shading mode draws for each mesh.
#[derive(Clone, Copy, Debug, Default)]
pub struct DrawPlan {
    pub streams: VertexStreams,
    /// The fragment shader entry point for faces.
    shade: Option<&'static str>,
    /// Whether faces only occlude edges.
    hides: bool,
    points: bool,
}

impl DrawPlan {
    pub fn of(shading: Shading) -> DrawPlan {
        let base = VertexStreams {
            colors: true,
            ..VertexStreams::default()
        };
        let smooth = VertexStreams {
            normals: true,
            ..base
        };
        let surface = |shade, streams| DrawPlan {
            streams,
            shade: Some(shade),
            ..DrawPlan::default()
        };
        let edges = VertexStreams {
            edges: true,
            ..VertexStreams::default()
        };
        let facets = |facets, edges| VertexStreams {
            facets,
            edges,
            ..VertexStreams::default()
        };
        match shading {
            Shading::Points => DrawPlan {
                points: true,
                ..DrawPlan::default()
            },
            Shading::Lines => DrawPlan {
                streams: edges,
                ..DrawPlan::default()
            },
            Shading::HiddenLines => DrawPlan {
                streams: edges,
                hides: true,
                ..DrawPlan::default()
            },
            Shading::Flat => surface("flat_shade", base),
            Shading::Gouraud => surface("gouraud", smooth),
            Shading::Textured => surface(
                "textured",
                VertexStreams {
                    uvs: true,
                    ..smooth
                },
            ),
            Shading::Irradiance => {
                let streams = VertexStreams {
                    uvs: true,
                    light: true,
                    ..smooth
                };
                surface("irradiance", streams)
            }
            Shading::FalseColor | Shading::Error => {
                let streams = VertexStreams {
                    light: true,
                    ..VertexStreams::default()
                };
                surface("false_color", streams)
            }
            Shading::Patches => surface("patches", facets(FacetAttribute::Light, true)),
            Shading::FormFactors => surface("face_number", facets(FacetAttribute::Values, false)),
            Shading::Normals => surface(
                "directions",
                VertexStreams {
                    colors: false,
                    ..smooth
                },
            ),
        }
    }
}

impl DrawPlan {
    /// The plan that draws values in place of colours.
    pub fn packed(self) -> DrawPlan {
        DrawPlan {
            shade: self.shade.map(|_| "packed"),
            ..self
        }
    }
}

/// An object that may be visible.
pub struct VisibleObject {
    /// Its index among the frame's objects.
    pub index: usize,
    pub view_from: DAffine3,
    /// Upper bound on how much its placement stretches lengths.
    pub stretch: f64,
}

/// Everything that a render pass reads.
pub struct PassEncoder<'a> {
    pub frame: &'a ViewportFrame<'a>,
    pub view: Projection,
    pub plan: DrawPlan,
    pub device: &'a wgpu::Device,
    pub pipelines: &'a mut RenderPipelines,
    pub texture_cache: &'a TextureCache,
    pub geometries: &'a HashMap<u64, GpuMesh>,
    pub objects: &'a UniformBlocks,
    pub materials: &'a UniformBlocks,
    pub constants: &'a DefaultAttributes,
    pub frame_group: &'a wgpu::BindGroup,
    /// The texture key of each material.
    pub textures: &'a [Option<Vec<u64>>],
    pub visible: &'a [VisibleObject],
    pub ink: &'a wgpu::Buffer,
    /// Number of overlay vertices that surfaces can occlude.
    pub hidden_ink: u32,
    pub samples: u32,
}

/// An object with its draw stages and the offset of its uniforms.
#[derive(Clone, Copy)]
struct ObjectDraw<'a> {
    drawn: &'a DrawnMesh<'a>,
    geometry: &'a GpuMesh,
    visible: &'a VisibleObject,
    number: u32,
    culled: Option<wgpu::Face>,
    /// The side that the backs of its faces are on, in GPU terms: of mirrored objects, the front.
    back: wgpu::Face,
}

impl ObjectDraw<'_> {
    /// What is culled from its glass, layer by layer: first the fronts, then the backs.
    fn glass_layers(&self) -> impl Iterator<Item = Option<wgpu::Face>> + use<> {
        let front = match self.back {
            wgpu::Face::Back => wgpu::Face::Front,
            wgpu::Face::Front => wgpu::Face::Back,
        };
        let backs = self.culled.is_none().then_some(Some(front));
        backs.into_iter().chain([Some(self.back)])
    }
}

/// The middle of a piece of an object, in view space.
fn centre(one: &ObjectDraw, piece: &PieceBuffers) -> DVec3 {
    let place = piece.centre.as_dvec3();
    one.visible.view_from.transform_point3(place)
}

impl PassEncoder<'_> {
    /// Creates the missing pipelines.
    pub fn prepare(&mut self) {
        let mut ways = vec![
            self.pipeline_key(DrawStage::Background, None),
            self.pipeline_key(DrawStage::OverlayStyle { on_top: false }, None),
            self.pipeline_key(DrawStage::OverlayStyle { on_top: true }, None),
        ];
        for one in self.object_draws() {
            ways.extend(
                self.stages(&one)
                    .map(|stage| self.pipeline_key(stage, one.culled)),
            );
            let glass = self.face_stage(one.geometry.attributes(), true);
            if let Some(stage) = glass {
                let layers = one.glass_layers();
                ways.extend(layers.map(|culled| self.pipeline_key(stage, culled)));
            }
        }
        for way in ways {
            self.pipelines.prepare(self.device, way);
        }
    }

    pub fn encode(&self, mut pass: wgpu::RenderPass) {
        pass.set_bind_group(0, self.frame_group, &[]);
        self.set(&mut pass, DrawStage::Background, None);
        pass.draw(0..3, 0..1);
        for one in self.object_draws() {
            self.faces(&mut pass, &one, false, &self.pieces(&one));
        }
        // Each glass is seen through those before it, so that the farthest is drawn first, and of each
        // the faces that are turned away: those of a ball lie behind the others.
        for (one, piece) in self.glasses() {
            for culled in one.glass_layers() {
                let layer = ObjectDraw { culled, ..one };
                self.faces(&mut pass, &layer, true, &[piece]);
            }
        }
        for one in self.object_draws() {
            self.lines_and_points(&mut pass, &one);
        }
        let corners = (self.ink.size() / (4 * WORDS as u64)) as u32;
        let parts = [
            (false, 0..self.hidden_ink),
            (true, self.hidden_ink..corners),
        ];
        for (on_top, range) in parts {
            if !range.is_empty() {
                self.set(&mut pass, DrawStage::OverlayStyle { on_top }, None);
                pass.set_vertex_buffer(0, self.ink.slice(..));
                pass.draw(range, 0..1);
            }
        }
    }

    fn object_draws(&self) -> impl Iterator<Item = ObjectDraw<'_>> {
        (0..).zip(self.visible).filter_map(|(number, visible)| {
            let drawn = &self.frame.objects[visible.index];
            let is_mirrored = visible.view_from.matrix3.determinant() < 0.0;
            let culled = if is_mirrored {
                wgpu::Face::Front
            } else {
                wgpu::Face::Back
            };
            Some(ObjectDraw {
                drawn,
                geometry: self.geometries.get(&drawn.key)?,
                visible,
                number,
                culled: self.frame.hides_backs.then_some(culled),
                back: culled,
            })
        })
    }

    fn pipeline_key(&self, stage: DrawStage, culled: Option<wgpu::Face>) -> PipelineKey {
        let is_faces = !matches!(
            stage,
            DrawStage::Background
                | DrawStage::OverlayStyle { .. }
                | DrawStage::Edges { .. }
                | DrawStage::Points
        );
        PipelineKey {
            stage,
            samples: self.samples,
            culled: culled.filter(|_| is_faces),
        }
    }

    /// All draw stages of an object.
    fn stages(&self, one: &ObjectDraw) -> impl Iterator<Item = DrawStage> + use<> {
        let has = one.geometry.attributes();
        let faces = [false, true].map(|glass| self.face_stage(has, glass));
        let plan = self.plan;
        let edges = plan.streams.edges.then(|| self.edge_stage());
        let hides = plan.hides.then_some(DrawStage::Hiding);
        let points = plan.points.then_some(DrawStage::Points);
        let others = [edges, hides, points];
        faces.into_iter().chain(others).flatten()
    }

    fn face_stage(&self, has: VertexAttributes, is_glass: bool) -> Option<DrawStage> {
        let shade = self.plan.shade?;
        Some(match self.plan.streams.facets {
            FacetAttribute::None => DrawStage::Surface {
                shade,
                has,
                is_glass,
            },
            FacetAttribute::Light | FacetAttribute::Values => DrawStage::Facets { shade, is_glass },
        })
    }

    fn edge_stage(&self) -> DrawStage {
        DrawStage::Edges {
            is_faint: self.plan.shade.is_some(),
        }
    }

    fn set(&self, pass: &mut wgpu::RenderPass, stage: DrawStage, culled: Option<wgpu::Face>) {
        if let Some(pipeline) = self.pipelines.get(self.pipeline_key(stage, culled)) {
            pass.set_pipeline(pipeline);
        }
    }

    /// The pieces of an object that may be visible.
    fn pieces<'b>(&self, one: &ObjectDraw<'b>) -> Vec<&'b PieceBuffers> {
        let pieces = one.geometry.pieces.iter().filter(|piece| {
            let radius = f64::from(piece.radius) * one.visible.stretch;
            self.view.sees(centre(one, piece), radius)
        });
        pieces.collect()
    }

    /// The pieces with glass, from the farthest to the nearest.
    fn glasses(&self) -> Vec<(ObjectDraw<'_>, &PieceBuffers)> {
        let mut glasses: Vec<(f64, ObjectDraw<'_>, &PieceBuffers)> = Vec::new();
        for one in self.object_draws() {
            for piece in self.pieces(&one) {
                if piece.ranges.iter().any(|r| self.is_glass(r.0)) {
                    glasses.push((centre(&one, piece).length(), one, piece));
                }
            }
        }
        glasses.sort_by(|a, b| b.0.total_cmp(&a.0));
        glasses
            .into_iter()
            .map(|(_, one, piece)| (one, piece))
            .collect()
    }

    fn set_object(&self, pass: &mut wgpu::RenderPass, one: &ObjectDraw) {
        pass.set_bind_group(1, &self.objects.group, &[self.objects.offset(one.number)]);
    }

    fn faces(
        &self,
        pass: &mut wgpu::RenderPass,
        one: &ObjectDraw,
        glass: bool,
        pieces: &[&PieceBuffers],
    ) {
        if self.plan.hides && !glass {
            self.hiding(pass, one);
        }
        let Some(stage) = self.face_stage(one.geometry.attributes(), glass) else {
            return;
        };
        let is_wanted = |material: u32| self.is_glass(material) == glass;
        let has_wanted = |p: &PieceBuffers| p.ranges.iter().any(|r| is_wanted(r.0));
        for piece in pieces.iter().filter(|p| has_wanted(p)) {
            self.set(pass, stage, one.culled);
            self.set_object(pass, one);
            let is_indexed = self.set_corners(pass, piece);
            for (material, range) in piece.ranges.iter().filter(|r| is_wanted(r.0)) {
                self.set_material(pass, *material);
                if is_indexed {
                    pass.draw_indexed(range.clone(), 0, 0..1)
                } else {
                    pass.draw(range.clone(), 0..1)
                }
            }
        }
    }

    fn is_glass(&self, material: u32) -> bool {
        let material = self.frame.materials.get(material as usize);
        let shows_matter = matches!(
            self.frame.shading,
            Shading::Flat | Shading::Gouraud | Shading::Textured | Shading::Irradiance
        );
        shows_matter && material.is_some_and(|m| uniforms::is_glass(m))
    }

    /// Binds the vertex buffers; returns whether the triangles are indexed.
    fn set_corners(&self, pass: &mut wgpu::RenderPass, piece: &PieceBuffers) -> bool {
        let (zeros, ones) = (&self.constants.zeros, &self.constants.ones);
        if let (Some(facets), Some(values)) = (&piece.facets, &piece.facet_values)
            && self.plan.streams.facets != FacetAttribute::None
        {
            let buffers = [facets, zeros, values, ones, zeros, zeros];
            for (slot, buffer) in (0..).zip(buffers) {
                pass.set_vertex_buffer(slot, buffer.slice(..));
            }
            return false;
        }
        let buffers = [
            &piece.positions,
            piece.normals.as_ref().unwrap_or(zeros),
            piece.light.as_ref().unwrap_or(zeros),
            piece.colors.as_ref().unwrap_or(ones),
            piece.uvs.as_ref().unwrap_or(zeros),
            piece.lightmap.as_ref().unwrap_or(zeros),
        ];
        for (slot, buffer) in (0..).zip(buffers) {
            pass.set_vertex_buffer(slot, buffer.slice(..));
        }
        pass.set_index_buffer(piece.triangles.slice(..), wgpu::IndexFormat::Uint32);
        true
    }

    fn set_material(&self, pass: &mut wgpu::RenderPass, material: u32) {
        // The last block is for missing materials.
        let number = material.min(self.frame.materials.len() as u32);
        let offset = self.materials.offset(number);
        pass.set_bind_group(2, &self.materials.group, &[offset]);
        let key = self.textures.get(number as usize).and_then(Option::as_ref);
        pass.set_bind_group(3, self.texture_cache.group(key), &[]);
    }

    fn hiding(&self, pass: &mut wgpu::RenderPass, one: &ObjectDraw) {
        self.set(pass, DrawStage::Hiding, one.culled);
        self.set_object(pass, one);
        for piece in self.pieces(one) {
            pass.set_vertex_buffer(0, piece.positions.slice(..));
            pass.set_index_buffer(piece.triangles.slice(..), wgpu::IndexFormat::Uint32);
            if let Some((_, last)) = piece.ranges.last() {
                pass.draw_indexed(0..last.end, 0, 0..1);
            }
        }
    }

    fn lines_and_points(&self, pass: &mut wgpu::RenderPass, one: &ObjectDraw) {
        for piece in self.pieces(one) {
            if self.plan.points {
                self.set(pass, DrawStage::Points, None);
                self.set_object(pass, one);
                pass.set_vertex_buffer(0, piece.positions.slice(..));
                pass.draw(0..4, 0..piece.vertex_count);
            }
            if let (true, Some(edges)) = (self.plan.streams.edges, &piece.edges) {
                self.set(pass, self.edge_stage(), None);
                self.set_object(pass, one);
                pass.set_vertex_buffer(0, piece.positions.slice(..));
                pass.set_index_buffer(edges.slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(0..piece.edge_ends, 0, 0..1);
            }
        }
    }

    /// Whether anything is selected whose surfaces are drawn; edges and points change their colour.
    pub fn has_marks(&self) -> bool {
        let is_marked =
            |one: ObjectDraw| one.drawn.is_selected || !one.drawn.selected_faces.is_empty();
        let is_drawn = self.plan.shade.is_some() && !self.frame.is_values;
        is_drawn && self.object_draws().any(is_marked)
    }

    /// Draws the mask of the selection, with the pipeline that the pass has.
    pub fn encode_marks(&self, mut pass: wgpu::RenderPass) {
        pass.set_bind_group(0, self.frame_group, &[]);
        for one in self.object_draws() {
            if one.drawn.is_selected {
                self.set_object(&mut pass, &one);
                for piece in self.pieces(&one) {
                    pass.set_vertex_buffer(0, piece.positions.slice(..));
                    pass.set_index_buffer(piece.triangles.slice(..), wgpu::IndexFormat::Uint32);
                    if let Some((_, last)) = piece.ranges.last() {
                        pass.draw_indexed(0..last.end, 0, 0..1);
                    }
                }
            }
            if let (Some(chosen), false) =
                (&one.geometry.selection, one.drawn.selected_faces.is_empty())
            {
                self.set_object(&mut pass, &one);
                pass.set_vertex_buffer(0, chosen.positions.slice(..));
                pass.draw(0..chosen.vertex_count, 0..1);
            }
        }
    }
}
