//! Affine transforms of scenes, and conversion to another scene's units.

use crate::math::normal_matrix;
use crate::{
    Camera, Light, LightKind, Mesh, MeshInstance, Object, Primitive, PrimitiveKind, Scene,
    SceneBackground, Shape, SharedMesh, SurfaceLight, Units, Up,
};
use glam::{DAffine3, DMat3, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

impl Scene {
    /// The scene transformed by an affine map: objects, lights, cameras and fog.
    ///
    /// `world_from_scene` must be finite and invertible. A map that mirrors also
    /// reverses the corners of faces, so that fronts stay fronts. Intensities of lights grow with the
    /// square of the mean scale and irradiance stays, so that the scene looks the same at any
    /// size. RTRACE's parameters are dropped.
    pub fn transformed(mut self, world_from_scene: &DAffine3) -> Scene {
        let map = world_from_scene;
        let mut shared = HashMap::new();
        for object in &mut self.objects {
            match &mut object.shape {
                Shape::Instance(instance) => instance.transform(map, &mut shared),
                Shape::Mesh(mesh) => mesh.transform(map),
                Shape::Primitive(p) => p.transform(map),
                Shape::Exact(exact) => exact.transform(map),
            }
        }
        let scale = map.matrix3.determinant().abs().cbrt();
        self.lights.iter_mut().for_each(|l| l.transform(map, scale));
        self.cameras.iter_mut().for_each(|c| c.transform(map));
        if let Some(fog) = &mut self.fog {
            fog.visibility *= scale;
        }
        if let Some(SceneBackground::Environment(environment)) = &mut self.background {
            environment.turn(&map.matrix3);
        }
        // Its lights and textures are meaningless at another scale.
        self.rtrace = None;
        self
    }

    /// The scene in other units: rotated if its up axis differs, scaled if both define the length
    /// of a unit. If only one does, lengths stay as they are.
    pub fn adapted(self, units: Units) -> Scene {
        let scale = match (self.units.metres_per_unit, units.metres_per_unit) {
            (Some(from), Some(to)) => from / to,
            _ => 1.0,
        };
        let turn = turn(self.units.up, units.up);
        let mut adapted = if scale == 1.0 && turn == DMat3::IDENTITY {
            self
        } else {
            self.transformed(&DAffine3::from_mat3(turn * scale))
        };
        adapted.units = Units {
            metres_per_unit: units.metres_per_unit.or(adapted.units.metres_per_unit),
            ..units
        };
        adapted
    }
}

/// The quarter turn about x that brings one up axis to the other, without rounding.
fn turn(from: Up, to: Up) -> DMat3 {
    match (from, to) {
        (Up::Z, Up::Y) => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
        (Up::Y, Up::Z) => DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
        _ => DMat3::IDENTITY,
    }
}

impl Primitive {
    /// Transforms the primitive and its irradiance by an affine map. A map that mirrors exchanges
    /// the edges of a parallelogram, whose front follows them, so that the front stays the front.
    pub fn transform(&mut self, map: &DAffine3) {
        self.world_from_object = *map * self.world_from_object;
        if self.kind == PrimitiveKind::Square && map.matrix3.determinant() < 0.0 {
            let axes = &mut self.world_from_object.matrix3;
            (axes.x_axis, axes.y_axis) = (axes.y_axis, axes.x_axis);
            if let Some(light) = &mut self.light {
                light.transpose();
            }
        }
    }
}

impl SurfaceLight {
    /// Exchanges `u` and `v` of its first grid, the only one of a parallelogram.
    fn transpose(&mut self) {
        let Some(grid) = self.grids.first_mut() else {
            return;
        };
        let (columns, rows) = (grid.nu as usize + 1, grid.nv as usize + 1);
        (grid.nu, grid.nv) = (grid.nv, grid.nu);
        for values in [&mut self.irradiance, &mut self.error] {
            if values.len() == columns * rows {
                let turned = (0..columns).flat_map(|u| (0..rows).map(move |v| v * columns + u));
                *values = turned.map(|k| values[k]).collect();
            }
        }
    }
}

impl MeshInstance {
    /// Transforms the instance; where the map mirrors, it gets the mirrored mesh of those in `shared`. A
    /// map that is not invertible leaves it where it is.
    fn transform(&mut self, map: &DAffine3, shared: &mut HashMap<*const Mesh, SharedMesh>) {
        // The entries keep their meshes alive, so that no other gets the address of one.
        let shared = shared
            .entry(Arc::as_ptr(&self.mesh))
            .or_insert_with(|| SharedMesh::of(self.mesh.clone()));
        if let Some(mut placed) = shared.placed(*map * self.world_from_mesh) {
            placed.light = self.light.take();
            *self = placed;
        }
    }
}

impl Object {
    /// Turns a mesh inside out: fronts become backs, and normals point the other way. An instance gets a
    /// mesh of its own. Returns whether the object has a mesh.
    pub fn turn_inside_out(&mut self) -> bool {
        let turned = |mesh: &mut Mesh| {
            mesh.flip();
            let normals = mesh.normals.iter_mut().flat_map(|n| &mut n.values);
            normals.for_each(|n| *n = -*n);
        };
        match &mut self.shape {
            Shape::Mesh(mesh) => turned(mesh),
            Shape::Instance(instance) => {
                let mut mesh = Mesh::clone(&instance.mesh);
                turned(&mut mesh);
                instance.mesh = Arc::new(mesh);
            }
            Shape::Primitive(_) | Shape::Exact(_) => return false,
        }
        true
    }
}

impl Mesh {
    /// Transforms the mesh by an affine map; a map that mirrors reverses the corners of faces.
    pub fn transform(&mut self, map: &DAffine3) {
        let rounding = self.coordinate_rounding();
        for p in &mut self.positions {
            *p = map.transform_point3(*p);
        }
        self.note_map(rounding, map);
        if let Some(normals) = &mut self.normals {
            let matrix = normal_matrix(map.matrix3);
            for n in &mut normals.values {
                // A singular map may leave no direction; the old one is then kept.
                *n = (matrix * *n).try_normalize().unwrap_or(*n);
            }
        }
        if map.matrix3.determinant() < 0.0 {
            self.flip();
        }
    }

    /// Reverses every face: its front becomes its back. Normals stay.
    pub fn flip(&mut self) {
        (0..self.faces.len()).for_each(|face| self.reverse_face(face));
    }
}

impl Light {
    /// Puts it where a map puts it; its intensity stays. Says whether it is anywhere: a direction that the map takes away
    /// stays, too.
    pub fn move_by(&mut self, map: &DAffine3) -> bool {
        let turn = |direction: &mut DVec3| {
            let turned = (map.matrix3 * *direction).try_normalize();
            *direction = turned.unwrap_or(*direction);
            turned.is_some()
        };
        let moved = |position: &mut DVec3| {
            *position = map.transform_point3(*position);
            position.is_finite()
        };
        match &mut self.kind {
            LightKind::Point { position, .. } => moved(position),
            LightKind::Spot {
                position,
                direction,
                ..
            } => moved(position) & turn(direction),
            LightKind::Luminaire {
                position,
                world_from_web,
                ..
            } => {
                let turned = frame_of(&(map.matrix3 * *world_from_web));
                *world_from_web = turned.unwrap_or(*world_from_web);
                moved(position) & turned.is_some()
            }
            LightKind::Directional { direction, .. } => turn(direction),
            LightKind::Ambient { .. } => true,
            LightKind::Environment(environment) => {
                environment.turn(&map.matrix3);
                true
            }
        }
    }

    fn transform(&mut self, map: &DAffine3, scale: f64) {
        self.move_by(map);
        match &mut self.kind {
            LightKind::Point { intensity, .. } | LightKind::Spot { intensity, .. } => {
                *intensity *= scale * scale;
            }
            LightKind::Luminaire { scale: power, .. } => *power *= scale * scale,
            LightKind::Directional { .. }
            | LightKind::Ambient { .. }
            | LightKind::Environment(_) => {}
        }
    }
}

/// The orthonormal axes nearest to those of a map, of the same handedness; `None` if they span no space.
fn frame_of(map: &DMat3) -> Option<DMat3> {
    let x = map.x_axis.try_normalize()?;
    let z = x.cross(map.y_axis).try_normalize()?;
    let side = map.determinant().signum();
    Some(DMat3::from_cols(x, z.cross(x), side * z))
}

impl Camera {
    fn transform(&mut self, map: &DAffine3) {
        self.eye = map.transform_point3(self.eye);
        self.target = map.transform_point3(self.target);
        self.up = map.transform_vector3(self.up);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Attribute;
    use crate::{Material, Object, Rgb};

    /// A triangle in the ground plane that faces up, a lamp above it and a camera.
    fn scene(up: Up, metres_per_unit: Option<f64>) -> Scene {
        let (a, b, height) = match up {
            Up::Y => (DVec3::Z, DVec3::X, DVec3::Y),
            Up::Z => (DVec3::X, DVec3::Y, DVec3::Z),
        };
        let mut scene = Scene::default();
        let white = scene.add_material(Material::diffuse("white", Rgb::WHITE));
        let mut mesh = Mesh {
            positions: vec![DVec3::ZERO, a, b],
            normals: Some(Attribute::per_vertex(vec![height; 3])),
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2], white);
        scene.objects.push(Object::new("floor", Shape::Mesh(mesh)));
        scene.lights.push(Light {
            name: "lamp".into(),
            kind: LightKind::Point {
                position: 3.0 * height,
                intensity: Rgb::grey(9.0),
            },
        });
        scene.units = Units {
            metres_per_unit,
            up,
            photometric: false,
        };
        scene
    }

    fn floor(scene: &Scene) -> &Mesh {
        match &scene.objects[0].shape {
            Shape::Mesh(mesh) => mesh,
            _ => unreachable!("the floor is a mesh"),
        }
    }

    #[test]
    fn up_and_length_follow_the_units() {
        let millimetres = Units {
            metres_per_unit: Some(1e-3),
            ..Units::default()
        };
        let adapted = scene(Up::Z, Some(0.1)).adapted(millimetres);
        adapted.validate().unwrap();
        assert_eq!(adapted.units, millimetres);
        let mesh = floor(&adapted);
        assert!((mesh.face_area_vector(0).normalize() - DVec3::Y).length() < 1e-15);
        assert!((mesh.area() - 5000.0).abs() < 1e-9);
        assert_eq!(mesh.normals.as_ref().unwrap().values[0], DVec3::Y);
        let LightKind::Point {
            position,
            intensity,
        } = adapted.lights[0].kind
        else {
            unreachable!("a point light")
        };
        assert!((position - DVec3::new(0.0, 300.0, 0.0)).length() < 1e-9);
        // 100 times as far and 10,000 times as strong: the floor is lit as before.
        assert!((intensity.r - 90_000.0).abs() < 1e-6);
    }

    #[test]
    fn nothing_is_scaled_on_a_guess() {
        let adapted = scene(Up::Y, None).adapted(Units {
            metres_per_unit: Some(1e-3),
            ..Units::default()
        });
        assert_eq!(floor(&adapted).positions[1], DVec3::Z);
        let adapted = scene(Up::Y, Some(0.1)).adapted(Units::default());
        assert_eq!(adapted.units.metres_per_unit, Some(0.1));
    }

    #[test]
    fn there_and_back_is_the_same_to_the_last_bit() {
        let before = scene(Up::Z, None);
        let there = before.clone().adapted(Units::default());
        assert_eq!(there.adapted(before.units), before);
    }

    #[test]
    fn a_mirrored_sheet_keeps_its_front_and_its_light() {
        let mut sheet = Primitive::parallelogram(DVec3::ZERO, 2.0 * DVec3::X, DVec3::Y, 0);
        sheet.light = Some(Box::new(SurfaceLight {
            grids: vec![crate::SurfaceGrid { nu: 2, nv: 1 }],
            irradiance: (0..6).map(|k| Rgb::grey(f64::from(k))).collect(),
            error: Vec::new(),
        }));
        let before = sheet.clone();
        sheet.transform(&DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)));
        assert_eq!(sheet.point(0, 0.5, 0.5).normal, DVec3::Z);
        let light = |p: &Primitive, u, v| p.light.as_ref().unwrap().at(0, u, v);
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.25, 0.75), (0.5, 1.0)] {
            let (p, q) = (before.point(0, u, v), sheet.point(0, v, u));
            assert_eq!(q.position, p.position * DVec3::new(-1.0, 1.0, 1.0));
            assert!((light(&sheet, v, u).r - light(&before, u, v).r).abs() < 1e-12);
        }
    }

    #[test]
    fn a_mirrored_front_stays_a_front() {
        let mirror = DAffine3::from_scale(DVec3::new(-2.0, 1.0, 1.0));
        let mirrored = scene(Up::Y, None).transformed(&mirror);
        mirrored.validate().unwrap();
        let mesh = floor(&mirrored);
        assert_eq!(mesh.face_area_vector(0), DVec3::Y);
        assert_eq!(mesh.normals.as_ref().unwrap().values[0], DVec3::Y);
    }
}
