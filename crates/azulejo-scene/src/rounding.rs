//! Numbers with fewer digits, for shorter files.

use crate::{BackIrradiance, Mesh, Rgb, Scene, Shape};
use glam::{DVec2, DVec3};

/// A number with `digits` significant decimal digits, at least 1; its shortest spelling has no more.
/// What is not finite stays.
pub fn rounded_number(x: f64, digits: usize) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return x;
    }
    let text = format!("{x:.*e}", digits.max(1) - 1);
    text.parse().unwrap_or(x)
}

impl Scene {
    /// Rounds positions, normals, texture coordinates, colours and light of all meshes, and light on
    /// primitives. Materials, lights, cameras and maps, of which there are few, stay exact.
    pub fn round_meshes(&mut self, digits: usize) {
        let point = |p: &mut DVec3| *p = p.map(|x| rounded_number(x, digits));
        let pair = |p: &mut DVec2| *p = p.map(|x| rounded_number(x, digits));
        self.each_mesh(|mesh| {
            mesh.positions.iter_mut().for_each(point);
            let normals = mesh.normals.iter_mut().flat_map(|a| &mut a.values);
            normals.for_each(point);
            let uvs = [&mut mesh.uvs, &mut mesh.lightmap_uvs]
                .into_iter()
                .flatten();
            uvs.flat_map(|a| &mut a.values).for_each(pair);
            round_all(&mut mesh.colors, digits);
        });
        self.round_light(digits);
    }

    /// Rounds the irradiance on all surfaces and its standard errors.
    pub fn round_light(&mut self, digits: usize) {
        self.each_mesh(|mesh| {
            round_all(&mut mesh.irradiance, digits);
            round_all(&mut mesh.irradiance_error, digits);
            round_back(&mut mesh.back, digits);
        });
        for object in &mut self.objects {
            match &mut object.shape {
                Shape::Primitive(primitive) => {
                    if let Some(light) = &mut primitive.light {
                        round_all(&mut light.irradiance, digits);
                        round_all(&mut light.error, digits);
                    }
                }
                Shape::Instance(instance) => {
                    if let Some(light) = instance.light.as_deref_mut() {
                        round_all(&mut light.irradiance, digits);
                        round_all(&mut light.error, digits);
                        round_back(&mut light.back, digits);
                    }
                }
                Shape::Mesh(_) | Shape::Exact(_) => {}
            }
        }
    }

    /// The meshes of objects, shared ones once, and the proxies of exact shapes.
    fn each_mesh(&mut self, mut change: impl FnMut(&mut Mesh)) {
        for object in &mut self.objects {
            match &mut object.shape {
                Shape::Mesh(mesh) => change(mesh),
                Shape::Exact(exact) => {
                    exact.proxy.as_deref_mut().into_iter().for_each(&mut change);
                }
                Shape::Primitive(_) | Shape::Instance(_) => {}
            }
        }
        self.change_shared_meshes(change);
    }
}

fn round_all<'c>(colors: impl IntoIterator<Item = &'c mut Rgb>, digits: usize) {
    for color in colors {
        *color = color.map(|x| rounded_number(x, digits));
    }
}

fn round_back(back: &mut Option<Box<BackIrradiance>>, digits: usize) {
    if let Some(back) = back {
        round_all(back.irradiance.iter_mut().flatten(), digits);
        round_all(&mut back.error, digits);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::cube_room;

    #[test]
    fn numbers_have_as_many_digits_as_wanted() {
        let check = |x: f64, digits: usize, expected: &str| {
            assert_eq!(rounded_number(x, digits).to_string(), expected);
        };
        check(1.0 / 3.0, 4, "0.3333");
        check(-123_456.789, 3, "-123000");
        check(0.1, 17, "0.1");
        check(0.0, 1, "0");
        check(f64::INFINITY, 2, "inf");
        check(9.9999, 2, "10");
        assert_eq!(rounded_number(1.234_56e-300, 3), 1.23e-300);
    }

    #[test]
    fn a_rounded_scene_is_valid() {
        let mut scene = cube_room();
        for object in &mut scene.objects {
            if let Shape::Mesh(mesh) = &mut object.shape {
                mesh.irradiance = vec![Rgb::grey(1.0 / 3.0); mesh.positions.len()];
                mesh.back = Some(Box::new(BackIrradiance {
                    irradiance: vec![Some(Rgb::grey(2.0 / 3.0)); mesh.positions.len()],
                    error: Vec::new(),
                }));
            }
        }
        scene.round_meshes(4);
        scene.validate().unwrap();
        let Shape::Mesh(mesh) = &scene.objects[0].shape else {
            panic!("a mesh")
        };
        assert_eq!(mesh.irradiance[0], Rgb::grey(0.3333));
        let back = mesh.back.as_ref().unwrap();
        assert_eq!(back.irradiance[0], Some(Rgb::grey(0.6667)));
    }
}
