//! The order in which a frame is drawn.

use super::blocks::{self, Blocks};
use super::frame::{Drawn, Frame};
use super::geometry::{Buffers, Facets, Geometry, Streams};
use super::overlay::WORDS;
use super::pictures::Pictures;
use super::pipelines::{Attributes, Pipelines, Stage, Way};
use super::projection::Projection;
use super::renderer::Constants;
use crate::view::Shading;
use glam::DAffine3;
use std::collections::HashMap;

/// What a mode of shading draws of each mesh.
#[derive(Clone, Copy, Debug, Default)]
pub struct Plan {
    pub streams: Streams,
    /// The function for the pixels of faces.
    shade: Option<&'static str>,
    /// Whether faces hide lines and nothing else.
    hides: bool,
    points: bool,
}

impl Plan {
    pub fn of(shading: Shading) -> Plan {
        let base = Streams {
            colors: true,
            ..Streams::default()
        };
        let smooth = Streams {
            normals: true,
            ..base
        };
        let surface = |shade, streams| Plan {
            streams,
            shade: Some(shade),
            ..Plan::default()
        };
        let edges = Streams {
            edges: true,
            ..Streams::default()
        };
        let facets = |facets, edges| Streams {
            facets,
            edges,
            ..Streams::default()
        };
        match shading {
            Shading::Points => Plan {
                points: true,
                ..Plan::default()
            },
            Shading::Lines => Plan {
                streams: edges,
                ..Plan::default()
            },
            Shading::HiddenLines => Plan {
                streams: edges,
                hides: true,
                ..Plan::default()
            },
            Shading::Flat => surface("flat_shade", base),
            Shading::Gouraud => surface("gouraud", smooth),
            Shading::Textured => surface(
                "textured",
                Streams {
                    uvs: true,
                    ..smooth
                },
            ),
            Shading::Irradiance => {
                let streams = Streams {
                    uvs: true,
                    light: true,
                    ..smooth
                };
                surface("irradiance", streams)
            }
            Shading::FalseColor => {
                let streams = Streams {
                    light: true,
                    ..Streams::default()
                };
                surface("false_color", streams)
            }
            Shading::Patches => surface("patches", facets(Facets::Light, true)),
            Shading::FormFactors => surface("face_number", facets(Facets::Values, false)),
            Shading::Normals => surface(
                "directions",
                Streams {
                    colors: false,
                    ..smooth
                },
            ),
        }
    }
}

/// An object that can be in the picture.
pub struct Seen {
    /// Its place among the frame's objects.
    pub index: usize,
    pub view_from: DAffine3,
    /// By how much its place makes lengths longer, at most.
    pub stretch: f64,
}

/// All that a pass reads.
pub struct Encoder<'a> {
    pub frame: &'a Frame<'a>,
    pub view: Projection,
    pub plan: Plan,
    pub device: &'a wgpu::Device,
    pub pipelines: &'a mut Pipelines,
    pub pictures: &'a Pictures,
    pub geometries: &'a HashMap<u64, Geometry>,
    pub objects: &'a Blocks,
    pub materials: &'a Blocks,
    pub constants: &'a Constants,
    pub frame_group: &'a wgpu::BindGroup,
    /// Of each material the key of its texture.
    pub textures: &'a [Option<Vec<u64>>],
    pub seen: &'a [Seen],
    pub ink: &'a wgpu::Buffer,
    /// How many corners of the ink surfaces can hide.
    pub hidden_ink: u32,
    pub samples: u32,
}

/// An object, what is drawn of it, and where its numbers are.
struct One<'a> {
    drawn: &'a Drawn<'a>,
    geometry: &'a Geometry,
    seen: &'a Seen,
    number: u32,
    culled: Option<wgpu::Face>,
}

impl Encoder<'_> {
    /// Makes the pipelines that are missing.
    pub fn prepare(&mut self) {
        let mut ways = vec![
            self.way(Stage::Background, None),
            self.way(Stage::Ink { on_top: false }, None),
            self.way(Stage::Ink { on_top: true }, None),
            self.way(Stage::Chosen, None),
        ];
        for one in self.ones() {
            ways.extend(self.stages(&one).map(|stage| self.way(stage, one.culled)));
        }
        for way in ways {
            self.pipelines.prepare(self.device, way);
        }
    }

    pub fn encode(&self, mut pass: wgpu::RenderPass) {
        pass.set_bind_group(0, self.frame_group, &[]);
        self.set(&mut pass, Stage::Background, None);
        pass.draw(0..3, 0..1);
        for glass in [false, true] {
            for one in self.ones() {
                self.faces(&mut pass, &one, glass);
            }
        }
        for one in self.ones() {
            self.lines_and_points(&mut pass, &one);
        }
        for one in self.ones() {
            self.chosen(&mut pass, &one);
        }
        let corners = (self.ink.size() / (4 * WORDS as u64)) as u32;
        let parts = [
            (false, 0..self.hidden_ink),
            (true, self.hidden_ink..corners),
        ];
        for (on_top, range) in parts {
            if !range.is_empty() {
                self.set(&mut pass, Stage::Ink { on_top }, None);
                pass.set_vertex_buffer(0, self.ink.slice(..));
                pass.draw(range, 0..1);
            }
        }
    }

    fn ones(&self) -> impl Iterator<Item = One<'_>> {
        (0..).zip(self.seen).filter_map(|(number, seen)| {
            let drawn = &self.frame.objects[seen.index];
            let is_mirrored = seen.view_from.matrix3.determinant() < 0.0;
            let culled = match is_mirrored {
                true => wgpu::Face::Front,
                false => wgpu::Face::Back,
            };
            Some(One {
                drawn,
                geometry: self.geometries.get(&drawn.key)?,
                seen,
                number,
                culled: self.frame.hides_backs.then_some(culled),
            })
        })
    }

    fn way(&self, stage: Stage, culled: Option<wgpu::Face>) -> Way {
        let is_faces = !matches!(
            stage,
            Stage::Background | Stage::Ink { .. } | Stage::Edges { .. } | Stage::Points
        );
        Way {
            stage,
            samples: self.samples,
            culled: culled.filter(|_| is_faces && stage != Stage::Chosen),
        }
    }

    /// All stages of an object.
    fn stages(&self, one: &One) -> impl Iterator<Item = Stage> + use<> {
        let has = one.geometry.attributes();
        let faces = [false, true].map(|glass| self.face_stage(has, glass));
        let plan = self.plan;
        let edges = plan.streams.edges.then(|| self.edge_stage());
        let hides = plan.hides.then_some(Stage::Hiding);
        let points = plan.points.then_some(Stage::Points);
        let others = [edges, hides, points];
        faces.into_iter().chain(others).flatten()
    }

    fn face_stage(&self, has: Attributes, is_glass: bool) -> Option<Stage> {
        let shade = self.plan.shade?;
        Some(match self.plan.streams.facets {
            Facets::None => Stage::Surface {
                shade,
                has,
                is_glass,
            },
            Facets::Light | Facets::Values => Stage::Facets { shade, is_glass },
        })
    }

    fn edge_stage(&self) -> Stage {
        Stage::Edges {
            is_faint: self.plan.shade.is_some(),
        }
    }

    fn set(&self, pass: &mut wgpu::RenderPass, stage: Stage, culled: Option<wgpu::Face>) {
        if let Some(pipeline) = self.pipelines.get(self.way(stage, culled)) {
            pass.set_pipeline(pipeline);
        }
    }

    /// The pieces of an object that can be in the picture.
    fn pieces<'b>(&self, one: &One<'b>) -> impl Iterator<Item = &'b Buffers> {
        let (view, seen) = (self.view, one.seen);
        one.geometry.pieces.iter().filter(move |piece| {
            let centre = seen.view_from.transform_point3(piece.centre.as_dvec3());
            view.sees(centre, f64::from(piece.radius) * seen.stretch)
        })
    }

    fn set_object(&self, pass: &mut wgpu::RenderPass, one: &One) {
        pass.set_bind_group(1, &self.objects.group, &[self.objects.offset(one.number)]);
    }

    fn faces(&self, pass: &mut wgpu::RenderPass, one: &One, glass: bool) {
        if self.plan.hides && !glass {
            self.hiding(pass, one);
        }
        let Some(stage) = self.face_stage(one.geometry.attributes(), glass) else {
            return;
        };
        let is_wanted = |material: u32| self.is_glass(material) == glass;
        let has_wanted = |p: &Buffers| p.ranges.iter().any(|r| is_wanted(r.0));
        for piece in self.pieces(one).filter(|p| has_wanted(p)) {
            self.set(pass, stage, one.culled);
            self.set_object(pass, one);
            let is_indexed = self.set_corners(pass, piece);
            for (material, range) in piece.ranges.iter().filter(|r| is_wanted(r.0)) {
                self.set_material(pass, *material);
                match is_indexed {
                    true => pass.draw_indexed(range.clone(), 0, 0..1),
                    false => pass.draw(range.clone(), 0..1),
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
        shows_matter && material.is_some_and(|m| blocks::is_glass(m))
    }

    /// Says whether the triangles are named by indices.
    fn set_corners(&self, pass: &mut wgpu::RenderPass, piece: &Buffers) -> bool {
        let (zeros, ones) = (&self.constants.zeros, &self.constants.ones);
        if let (Some(facets), Some(values)) = (&piece.facets, &piece.facet_values)
            && self.plan.streams.facets != Facets::None
        {
            let buffers = [facets, zeros, values, ones, zeros];
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
        ];
        for (slot, buffer) in (0..).zip(buffers) {
            pass.set_vertex_buffer(slot, buffer.slice(..));
        }
        pass.set_index_buffer(piece.triangles.slice(..), wgpu::IndexFormat::Uint32);
        true
    }

    fn set_material(&self, pass: &mut wgpu::RenderPass, material: u32) {
        // The last block is for materials that are not there.
        let number = material.min(self.frame.materials.len() as u32);
        let offset = self.materials.offset(number);
        pass.set_bind_group(2, &self.materials.group, &[offset]);
        let key = self.textures.get(number as usize).and_then(Option::as_ref);
        pass.set_bind_group(3, self.pictures.group(key), &[]);
    }

    fn hiding(&self, pass: &mut wgpu::RenderPass, one: &One) {
        self.set(pass, Stage::Hiding, one.culled);
        self.set_object(pass, one);
        for piece in self.pieces(one) {
            pass.set_vertex_buffer(0, piece.positions.slice(..));
            pass.set_index_buffer(piece.triangles.slice(..), wgpu::IndexFormat::Uint32);
            if let Some((_, last)) = piece.ranges.last() {
                pass.draw_indexed(0..last.end, 0, 0..1);
            }
        }
    }

    fn lines_and_points(&self, pass: &mut wgpu::RenderPass, one: &One) {
        for piece in self.pieces(one) {
            if self.plan.points {
                self.set(pass, Stage::Points, None);
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

    fn chosen(&self, pass: &mut wgpu::RenderPass, one: &One) {
        if let (Some(chosen), false) =
            (&one.geometry.selection, one.drawn.selected_faces.is_empty())
        {
            self.set(pass, Stage::Chosen, None);
            self.set_object(pass, one);
            pass.set_vertex_buffer(0, chosen.positions.slice(..));
            pass.draw(0..chosen.vertex_count, 0..1);
        }
    }
}
