//! Statements that create surfaces.

use super::build::MgfCorner;
use super::reader::{EntityError, MgfReader, MgfSource, MgfVertex, skip};
use super::sharing::WORLD;
use super::solids;
use crate::reading::text::quoted;
use crate::surface::holes::join;
use azulejo_scene::math::normal_matrix;
use azulejo_scene::{MaterialId, Mesh, Primitive, PrimitiveKind};
use glam::{DAffine3, DMat3, DVec3};

/// What an object takes from the budget besides its vertices and corners.
const OBJECT: u64 = 16;

/// From the coordinates of statements to those of the mesh that their faces belong to.
struct FaceFrame {
    frame_from_content: DAffine3,
    /// For normals.
    normals: DMat3,
    world_from_frame: DAffine3,
}

impl FaceFrame {
    /// Whether it reverses orientation.
    fn mirrors(&self) -> bool {
        self.frame_from_content.matrix3.determinant() < 0.0
    }
}

impl MgfReader<'_> {
    /// Executes a statement that creates a surface.
    pub(super) fn surface(
        &mut self,
        source: &MgfSource,
        keyword: &[u8],
        words: &[&[u8]],
    ) -> Result<(), EntityError> {
        match keyword {
            b"f" => self.face(source, words),
            b"fh" => self.face_with_holes(source, words),
            b"sph" => self.sphere(source, words),
            b"cyl" => match words {
                [a, r, b] => self.cone(source, [a, b], [r, r]),
                _ => skip("cyl without \"vertex radius vertex\": skipped"),
            },
            b"cone" => match words {
                [a, ra, b, rb] => self.cone(source, [a, b], [ra, rb]),
                _ => skip("cone without \"vertex radius vertex radius\": skipped"),
            },
            b"ring" => self.ring(source, words),
            b"torus" => self.torus(source, words),
            _ => self.prism(source, words),
        }
    }

    fn named(&self, name: &[u8]) -> Result<MgfVertex, EntityError> {
        match self.vertices.get(name) {
            Some(&vertex) => Ok(vertex),
            None => skip(format!(
                "undefined vertex {}: its surface is skipped",
                quoted(name)
            )),
        }
    }

    /// The frame of the innermost group's mesh, which may be outside of that of the current statement:
    /// the faces of an included file belong to the group around it.
    fn face_frame(&self) -> FaceFrame {
        let (outer, here) = (self.builder.group_frame(), &self.placement);
        let frame_from_content = match outer {
            WORLD => here.map,
            _ => self.frames.outer_from(outer, here.frame) * here.frame_from_content,
        };
        FaceFrame {
            frame_from_content,
            normals: normal_matrix(frame_from_content.matrix3),
            world_from_frame: self.frames.world_from(outer),
        }
    }

    /// A vertex transformed by the current transform.
    fn corner(&self, frame: &FaceFrame, name: &[u8]) -> Result<MgfCorner, EntityError> {
        let vertex = self.named(name)?;
        let position = frame.frame_from_content.transform_point3(vertex.position);
        let in_world = frame.world_from_frame.transform_point3(position);
        if !(position.is_finite() && in_world.is_finite()) {
            return skip("surface that overflows: skipped");
        }
        // A singular map can leave a normal without direction; any direction is as good.
        let placed = |n: DVec3| (frame.normals * n).try_normalize().unwrap_or(n);
        Ok(MgfCorner {
            key: (vertex.revision, self.placement.serial),
            position,
            normal: vertex.normal.map(placed),
        })
    }

    /// The current material in the scene, for an open surface, or a closed one whose inside is
    /// never visible.
    fn current_material(&mut self, source: &MgfSource, is_closed: bool) -> MaterialId {
        let (name, surface) = self.surfaces.current();
        if let Some(made) = surface.made[usize::from(is_closed)] {
            return made;
        }
        let (material, mut losses) = surface.material(
            &crate::reading::text::text(name),
            is_closed,
            &mut self.builder.gloss,
        );
        if surface.is_one_sided() {
            losses.push("one-sided material (sides 1) is visible from behind, too");
        }
        if name.is_empty() && surface.made == [None; 2] && material == Default::default() {
            losses.push("surfaces before any material: black");
        }
        let id = self.builder.material(material);
        surface.made[usize::from(is_closed)] = Some(id);
        for loss in losses {
            self.warn(source, loss.into());
        }
        id
    }

    fn face(&mut self, source: &MgfSource, names: &[&[u8]]) -> Result<(), EntityError> {
        if names.len() < 3 {
            return skip("face with fewer than 3 corners: skipped");
        }
        let frame = self.face_frame();
        let corners = names.iter().map(|name| self.corner(&frame, name));
        let corners: Vec<MgfCorner> = corners.collect::<Result<_, _>>()?;
        self.polygon(source, &frame, corners)
    }

    fn polygon(
        &mut self,
        source: &MgfSource,
        frame: &FaceFrame,
        mut corners: Vec<MgfCorner>,
    ) -> Result<(), EntityError> {
        let object = if self.builder.begins_object() && self.repeated > 0 {
            OBJECT
        } else {
            0
        };
        self.budget.spend(object + 2 * corners.len() as u64)?;
        if frame.mirrors() {
            corners[1..].reverse();
        }
        let material = self.current_material(source, false);
        let origin = self.origin(source, self.builder.group_frame());
        self.builder.face(&corners, material, origin);
        Ok(())
    }

    /// `fh`: the outline and the holes follow each other, separated by `-`.
    fn face_with_holes(&mut self, source: &MgfSource, words: &[&[u8]]) -> Result<(), EntityError> {
        let loops: Vec<&[&[u8]]> = words.split(|word| *word == b"-").collect();
        let names = loops.iter().copied().flatten();
        let frame = self.face_frame();
        let corners = names.map(|name| self.corner(&frame, name));
        let corners: Vec<MgfCorner> = corners.collect::<Result<_, _>>()?;
        let (outline, hole_loops) = (loops[0].len(), &loops[1..]);
        if outline < 3 {
            return skip("face with fewer than 3 corners: skipped");
        }
        let holes: Vec<usize> = hole_loops.iter().map(|hole| hole.len()).collect();
        // Each hole is tested against all corners connected so far.
        self.budget
            .spend((holes.len() * corners.len()) as u64 / 8)?;
        let points: Vec<DVec3> = corners.iter().map(|c| c.position).collect();
        let (joined, left_out) = join(&points, outline, &holes);
        let joined = joined.into_iter().map(|k| corners[k]).collect();
        self.polygon(source, &frame, joined)?;
        match left_out {
            0 => Ok(()),
            _ => skip("hole outside of its face: filled"),
        }
    }

    fn sphere(&mut self, source: &MgfSource, words: &[&[u8]]) -> Result<(), EntityError> {
        let [name, radius] = words else {
            return skip("sph without \"vertex radius\": skipped");
        };
        let (centre, radius) = (self.named(name)?.position, length(radius)?);
        let inward = radius < 0.0;
        let map = DAffine3::from_scale_rotation_translation(
            DVec3::splat(radius.abs()),
            glam::DQuat::IDENTITY,
            centre,
        );
        let world_from_sphere = self.placement.map * map;
        let size = world_from_sphere.matrix3.determinant();
        if !(world_from_sphere.is_finite() && size.is_finite() && size != 0.0) {
            return skip("sph without size, or that overflows: skipped");
        }
        if inward && self.surfaces.current().1.has_different_sides() {
            return self.inward_sphere(source, map, radius.abs());
        }
        self.budget.spend(OBJECT)?;
        let material = self.current_material(source, !inward);
        let sphere = Primitive::new(PrimitiveKind::Sphere, world_from_sphere, material);
        self.builder.primitive(sphere);
        Ok(())
    }

    /// A sphere whose front is its inside, which that of an exact sphere never is.
    fn inward_sphere(
        &mut self,
        source: &MgfSource,
        content_from_sphere: DAffine3,
        radius: f64,
    ) -> Result<(), EntityError> {
        let sphere = Primitive::new(PrimitiveKind::Sphere, content_from_sphere, 0);
        let grids = sphere.grids(1e-3 * radius, f64::INFINITY);
        self.budget
            .spend(2 * grids.iter().map(|g| g.vertices() as u64).sum::<u64>())?;
        let mut mesh = sphere.tessellate(&grids);
        mesh.flip();
        let normals = mesh.normals.iter_mut().flat_map(|n| &mut n.values);
        normals.for_each(|n| *n = -*n);
        self.solid(source, mesh, true)
    }

    fn cone(
        &mut self,
        source: &MgfSource,
        ends: [&[u8]; 2],
        radii: [&[u8]; 2],
    ) -> Result<(), EntityError> {
        let [a, b] = [self.named(ends[0])?.position, self.named(ends[1])?.position];
        let [ra, rb] = [length(radii[0])?, length(radii[1])?];
        let sides = solids::sides(ra.abs().max(rb.abs()) * self.placement.scale);
        self.budget.spend(6 * u64::from(sides))?;
        match solids::cone(a, ra, b, rb, sides) {
            Some(mesh) => self.solid(source, mesh, false),
            None => skip(
                "cyl or cone without length or radius, or with radii of different signs: skipped",
            ),
        }
    }

    fn ring(&mut self, source: &MgfSource, words: &[&[u8]]) -> Result<(), EntityError> {
        let (centre, normal, [inner, outer]) = self.round(words)?;
        if !(0.0 <= inner && inner < outer) {
            return skip("ring whose radii are not 0 <= inner < outer: skipped");
        }
        let sides = solids::sides(outer * self.placement.scale);
        self.budget.spend(6 * u64::from(sides))?;
        let mesh = solids::ring(centre, normal, inner, outer, sides);
        self.solid(source, mesh, false)
    }

    fn torus(&mut self, source: &MgfSource, words: &[&[u8]]) -> Result<(), EntityError> {
        let (centre, normal, [inner, outer]) = self.round(words)?;
        if inner * outer < 0.0 || inner.abs() == outer.abs() {
            return skip("torus whose radii are equal or have different signs: skipped");
        }
        let inward = inner < 0.0 || outer < 0.0;
        let (inner_size, outer_size) = (inner.abs(), outer.abs());
        let scale = self.placement.scale;
        let around = solids::sides(inner_size.max(outer_size) * scale);
        let tube = solids::sides(0.5 * (outer_size - inner_size).abs() * scale);
        self.budget.spend(5 * u64::from(around) * u64::from(tube))?;
        let mesh = solids::torus(centre, normal, inner, outer, [around, tube]);
        self.solid(source, mesh, !inward)
    }

    /// Centre, normal and two radii.
    fn round(&self, words: &[&[u8]]) -> Result<(DVec3, DVec3, [f64; 2]), EntityError> {
        let [name, inner, outer] = words else {
            return skip("ring or torus without \"vertex radius radius\": skipped");
        };
        let vertex = self.named(name)?;
        match vertex.normal {
            Some(normal) => Ok((vertex.position, normal, [length(inner)?, length(outer)?])),
            None => skip("ring or torus around a vertex without normal: skipped"),
        }
    }

    fn prism(&mut self, source: &MgfSource, words: &[&[u8]]) -> Result<(), EntityError> {
        let [names @ .., last] = words else {
            return skip("prism without \"vertices length\": skipped");
        };
        let height = length(last)?;
        let base = names.iter().map(|name| self.named(name));
        let base: Vec<MgfVertex> = base.collect::<Result<_, _>>()?;
        let base: Vec<(DVec3, Option<DVec3>)> =
            base.iter().map(|v| (v.position, v.normal)).collect();
        self.budget.spend(8 * base.len() as u64)?;
        match solids::prism(&base, height) {
            Some(mesh) if height != 0.0 => self.solid(source, mesh, height > 0.0),
            _ => skip("prism without area or length: skipped"),
        }
    }

    /// Adds a mesh in the file's coordinates as an object of its own.
    fn solid(
        &mut self,
        source: &MgfSource,
        mut mesh: Mesh,
        is_closed: bool,
    ) -> Result<(), EntityError> {
        self.budget.spend(OBJECT)?;
        let frame = self.placement.frame;
        let world_from_frame = self.frames.world_from(frame);
        mesh.transform(&self.placement.frame_from_content);
        let placed = mesh.positions.iter();
        let placed = placed.flat_map(|&p| [p, world_from_frame.transform_point3(p)]);
        let normals = mesh.normals.iter().flat_map(|n| &n.values);
        if !placed.chain(normals.copied()).all(DVec3::is_finite) {
            return skip("surface that overflows: skipped");
        }
        let material = self.current_material(source, is_closed);
        let origin = self.origin(source, frame);
        self.builder.solid(mesh, material, origin);
        Ok(())
    }
}

/// A number as a length.
fn length(word: &[u8]) -> Result<f64, EntityError> {
    match super::lines::number(word) {
        Some(length) => Ok(length),
        None => skip(format!(
            "{} is not a length: its surface is skipped",
            quoted(word)
        )),
    }
}
