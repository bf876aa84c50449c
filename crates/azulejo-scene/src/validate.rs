//! Validation of scenes.

mod exact;
mod rtrace;

use crate::{
    Attribute, BackIrradiance, Backplate, Environment, EnvironmentSource, FinishMaps, LightKind,
    Material, MaterialId, Mesh, MeshInstance, Object, Opacity, OpacityMode, Primitive,
    PrimitiveKind, ReliefKind, Rgb, Scene, SceneBackground, Shape, TextureId,
};
use glam::{DVec2, DVec3};
use std::fmt;

/// The first violation found in a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Invalid {
    /// Which part, as a path: `objects[3] "floor": faces[7]`.
    pub place: String,
    /// What was found and what was expected.
    pub problem: String,
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.problem)
    }
}

impl std::error::Error for Invalid {}

type Check = Result<(), Invalid>;

fn ensure(holds: bool, place: impl FnOnce() -> String, problem: impl FnOnce() -> String) -> Check {
    if holds {
        Ok(())
    } else {
        Err(Invalid {
            place: place(),
            problem: problem(),
        })
    }
}

fn ensure_material(material: MaterialId, count: usize, place: impl FnOnce() -> String) -> Check {
    ensure((material as usize) < count, place, || {
        format!("material {material} of {count}")
    })
}

/// The error of a check with its path one level deeper.
fn inside(level: impl FnOnce() -> String, check: Check) -> Check {
    check.map_err(|e| Invalid {
        place: format!("{}: {}", level(), e.place),
        ..e
    })
}

/// Whether a colour is one of light, or a factor of it.
fn is_light(c: Rgb) -> bool {
    c.to_array().iter().all(|x| *x >= 0.0 && x.is_finite())
}

impl Scene {
    /// Checks all invariants on which the passes rely:
    ///
    /// 1. Every index is in range: corners into positions, attributes into their values, faces
    ///    and primitives into materials, materials into textures.
    /// 2. Every face has three or more corners and one material; per-vertex lists are empty or
    ///    as long as the positions, per-face lists as long as the faces.
    /// 3. Every number is finite. Reflectances and opacities are in 0..=1, cutoffs >= 0; `diffuse + mirror`, with the
    ///    albedo of glossy lobes, is at most 1; emission, irradiance and intensities are not
    ///    negative.
    /// 4. Normals have length 1 (to 1e-3) or are absent; so have the directions of lights.
    /// 5. Primitives' maps are invertible, cone tops in 0..=1, `ior > 0`, units > 0.
    ///    Prisms' figures are finite and their maps invertible; both operands of a set operation
    ///    are closed and not empty; meshes in them have one material and two faces at every edge;
    ///    operations nest at most 256 deep. A proxy mesh has only materials of its solids.
    /// 6. A camera's eye, target and up span a plane; its field of view is in 0..π.
    /// 7. Background and fog are not negative; fog has a visibility > 0.
    /// 8. RTRACE's parameters, if any, refer to existing surfaces and define a view.
    ///
    /// Degenerate faces (no area) are allowed: they neither send nor receive light.
    ///
    /// # Errors
    /// The first violation.
    pub fn validate(&self) -> Result<(), Invalid> {
        let units = self.units.metres();
        ensure(
            units > 0.0 && units.is_finite(),
            || "units".into(),
            || format!("metres_per_unit is {units}, expected > 0"),
        )?;
        self.validate_materials()?;
        let mut exact = exact::Checker::new(self.materials.len());
        for (i, mesh) in self.shared_meshes().into_iter().enumerate() {
            let check = validate_mesh(mesh, self.materials.len());
            inside(|| format!("shared mesh {i}"), check)?;
        }
        for (i, object) in self.objects.iter().enumerate() {
            let place = || format!("objects[{i}] \"{}\"", object.name);
            inside(place, self.validate_object(object, &mut exact))?;
        }
        self.validate_lights()?;
        self.validate_cameras()?;
        self.validate_surroundings()?;
        match &self.rtrace {
            Some(numbers) => rtrace::validate(numbers, self),
            None => Ok(()),
        }
    }

    fn validate_surroundings(&self) -> Check {
        let place = || String::from("background");
        match self.background {
            Some(SceneBackground::Environment(sky)) => self.validate_environment(&sky, place)?,
            Some(SceneBackground::Backplate(plate)) => self.validate_backplate(&plate, place)?,
            Some(SceneBackground::Color(sky)) => ensure(is_light(sky), place, || {
                format!("radiance is {sky:?}, expected finite numbers >= 0")
            })?,
            None => {}
        }
        let Some(fog) = self.fog else { return Ok(()) };
        let far = fog.visibility;
        ensure(
            is_light(fog.color) && far > 0.0 && far.is_finite(),
            || "fog".into(),
            || {
                format!(
                    "colour is {:?} and visibility {far}, expected >= 0 and > 0",
                    fog.color
                )
            },
        )
    }

    fn validate_materials(&self) -> Check {
        for (i, material) in self.materials.iter().enumerate() {
            let place = || format!("materials[{i}] \"{}\"", material.name);
            validate_energy(material, place)?;
            validate_looks(material, place)?;
            let count = self.textures.len();
            for t in material.pictures() {
                ensure((t as usize) < count, place, || {
                    format!("texture {t} of {count}")
                })?;
            }
        }
        Ok(())
    }

    fn validate_object(&self, object: &Object, exact: &mut exact::Checker) -> Check {
        let materials = self.materials.len();
        match &object.shape {
            Shape::Mesh(mesh) => validate_mesh(mesh, materials),
            Shape::Instance(instance) => validate_instance(instance),
            Shape::Primitive(p) => validate_primitive(p, materials),
            Shape::Exact(shape) => exact.validate(shape),
        }
    }

    fn validate_lights(&self) -> Check {
        for (i, light) in self.lights.iter().enumerate() {
            let place = || format!("lights[{i}] \"{}\"", light.name);
            let unit = |d: DVec3| (d.length() - 1.0).abs() < 1e-3;
            let (finite, colour, direction) = match light.kind {
                LightKind::Point {
                    position,
                    intensity,
                } => (position.is_finite(), is_light(intensity), true),
                LightKind::Spot {
                    position,
                    direction,
                    intensity,
                    inner,
                    outer,
                } => {
                    let angles =
                        0.0 <= inner && inner <= outer && outer <= std::f64::consts::PI + 1e-12;
                    ensure(angles, place, || {
                        format!(
                            "spot angles are {inner} and {outer}, expected 0 <= inner <= outer <= π"
                        )
                    })?;
                    (position.is_finite(), is_light(intensity), unit(direction))
                }
                LightKind::Luminaire {
                    position,
                    world_from_web,
                    scale,
                    ..
                } => {
                    let product = world_from_web.transpose() * world_from_web;
                    let is_frame = product.abs_diff_eq(glam::DMat3::IDENTITY, 1e-3);
                    (position.is_finite(), is_light(scale), is_frame)
                }
                LightKind::Directional {
                    direction,
                    irradiance,
                    half_angle,
                } => {
                    let is_angle = (0.0..std::f64::consts::FRAC_PI_2).contains(&half_angle);
                    ensure(is_angle, place, || {
                        format!("the half angle is {half_angle}, expected 0..π/2")
                    })?;
                    (true, is_light(irradiance), unit(direction))
                }
                LightKind::Ambient { radiance } => (true, is_light(radiance), true),
                LightKind::Environment(environment) => {
                    self.validate_environment(&environment, place)?;
                    (true, true, true)
                }
            };
            ensure(finite, place, || "the position is not finite".into())?;
            ensure(colour, place, || {
                "the colour is negative or not finite".into()
            })?;
            ensure(direction, place, || {
                "the direction is not a unit vector, or the axes are not orthogonal ones".into()
            })?;
        }
        Ok(())
    }

    fn validate_environment(&self, sky: &Environment, place: impl Fn() -> String) -> Check {
        ensure(is_light(sky.scale), &place, || {
            "the scale is negative or not finite".into()
        })?;
        ensure(
            (sky.world_from_environment.length() - 1.0).abs() < 1e-3,
            &place,
            || "the rotation is not a unit quaternion".into(),
        )?;
        if let EnvironmentSource::Sky(sky) = sky.source {
            let numbers = [sky.scale, sky.ground];
            let is_sun = (sky.toward_sun.length() - 1.0).abs() < 1e-3;
            ensure(
                is_sun && numbers.iter().all(|n| *n >= 0.0 && n.is_finite()),
                &place,
                || {
                    "the sky's sun is not a unit vector, or a radiance is negative or not finite"
                        .into()
                },
            )?;
        }
        let count = self.textures.len();
        let is_there = |t: TextureId| (t as usize) < count;
        ensure(sky.texture().is_none_or(is_there), &place, || {
            format!("its texture is not one of the scene's {count}")
        })
    }

    fn validate_backplate(&self, plate: &Backplate, place: impl Fn() -> String) -> Check {
        let white = plate.radiance;
        ensure(white >= 0.0 && white.is_finite(), &place, || {
            format!("the radiance of its white is {white}, expected a finite number >= 0")
        })?;
        let count = self.textures.len();
        ensure((plate.texture as usize) < count, &place, || {
            format!("its texture is not one of the scene's {count}")
        })
    }

    fn validate_cameras(&self) -> Check {
        for (i, c) in self.cameras.iter().enumerate() {
            let place = || format!("cameras[{i}] \"{}\"", c.name);
            let (right, up, forward) = c.axes();
            let spans =
                c.eye.is_finite() && right.is_finite() && up.is_finite() && forward.is_finite();
            ensure(spans, place, || {
                "eye, target and up do not span a plane".into()
            })?;
            let fov = c.vertical_fov;
            ensure(fov > 0.0 && fov < std::f64::consts::PI, place, || {
                format!("field of view is {fov} rad, expected 0..π")
            })?;
            ensure(c.size.is_none_or(|(w, h)| w > 0 && h > 0), place, || {
                "the image has no pixels".into()
            })?;
        }
        Ok(())
    }
}

/// Checks what a material reflects, transmits and emits.
fn validate_energy(m: &Material, place: impl Fn() -> String) -> Check {
    for k in 0..3 {
        let (d, s, e) = (m.diffuse[k], m.mirror[k], m.emission[k]);
        ensure(
            (0.0..=1.0).contains(&d) && (0.0..=1.0).contains(&s),
            &place,
            || format!("reflectances are diffuse {d} and mirror {s}, expected 0..=1"),
        )?;
        let glossy = m.mean_glossy()[k];
        let margin = Material::energy_margin(glossy);
        ensure(d + s + glossy <= 1.0 + margin, &place, || match glossy {
            0.0 => format!("diffuse {d} + mirror {s} exceed 1, which creates energy"),
            _ => {
                format!("diffuse {d} + mirror {s} + glossy {glossy} exceed 1, which creates energy")
            }
        })?;
        ensure(e >= 0.0 && e.is_finite(), &place, || {
            format!("emission is {e}, expected a finite number >= 0")
        })?;
    }
    let Some(g) = m.dielectric else { return Ok(()) };
    ensure(g.ior > 0.0 && g.ior.is_finite(), &place, || {
        format!("index of refraction is {}, expected > 0", g.ior)
    })?;
    let t = g.transmittance;
    ensure((0..3).all(|k| (0.0..=1.0).contains(&t[k])), &place, || {
        format!("transmittance is {t:?}, expected 0..=1")
    })
}

/// Checks the opacity, finish, relief and lightmap of a material.
fn validate_looks(m: &Material, place: impl Fn() -> String) -> Check {
    let opacity = m.opacity.as_ref();
    ensure(opacity.is_none_or(is_possible), &place, || {
        format!("opacity is {opacity:?}, expected 0..=1 and a cutoff >= 0")
    })?;
    let finish = m.finish.as_ref();
    ensure(finish.is_none_or(is_finish), &place, || {
        format!("finish is {finish:?}, expected 0..=1")
    })?;
    let relief = m.relief.map(|r| r.kind);
    ensure(relief.is_none_or(is_finite_relief), &place, || {
        format!("relief is {relief:?}, expected a finite number")
    })?;
    let scale = m.lightmap.map_or(0.0, |l| l.scale);
    ensure(scale >= 0.0 && scale.is_finite(), &place, || {
        format!("scale of the lightmap is {scale}, expected a finite number >= 0")
    })
}

/// Whether colour, metalness and roughness are shares.
fn is_finish(finish: &FinishMaps) -> bool {
    let [r, g, b] = finish.base.to_array();
    let shares = [r, g, b, finish.metallic, finish.roughness];
    shares.iter().all(|x| (0.0..=1.0).contains(x))
}

fn is_finite_relief(kind: ReliefKind) -> bool {
    match kind {
        ReliefKind::Normals { scale } => scale.is_finite(),
        ReliefKind::Heights { slope } => slope.is_finite(),
    }
}

/// Whether an opacity is one.
fn is_possible(opacity: &Opacity) -> bool {
    let cut = match opacity.mode {
        OpacityMode::Mask { cutoff } => cutoff,
        OpacityMode::Blend => 0.0,
    };
    (0.0..=1.0).contains(&opacity.constant) && cut >= 0.0 && cut.is_finite()
}

fn validate_mesh(mesh: &Mesh, materials: usize) -> Check {
    let (vertices, faces) = (mesh.positions.len(), mesh.faces.len());
    let whole = || "mesh".to_string();
    let starts = &mesh.faces.starts;
    ensure(
        starts.first() == Some(&0)
            && starts.last().copied().map(|e| e as usize) == Some(mesh.faces.corners.len()),
        whole,
        || "face starts do not span the corners".into(),
    )?;
    for (f, w) in starts.windows(2).enumerate() {
        ensure(
            w[1] >= w[0].saturating_add(3),
            || format!("faces[{f}]"),
            || "fewer than 3 corners".into(),
        )?;
    }
    let bad_corner = mesh.faces.corners.iter().find(|&&v| v as usize >= vertices);
    ensure(bad_corner.is_none(), whole, || {
        format!(
            "a corner is vertex {} of {vertices}",
            bad_corner.unwrap_or(&0)
        )
    })?;
    ensure(mesh.face_materials.len() == faces, whole, || {
        format!("{} materials for {faces} faces", mesh.face_materials.len())
    })?;
    let bad_material = mesh
        .face_materials
        .iter()
        .find(|&&m| m as usize >= materials);
    ensure(bad_material.is_none(), whole, || {
        format!("material {} of {materials}", bad_material.unwrap_or(&0))
    })?;
    ensure(
        mesh.smoothing.is_empty() || mesh.smoothing.len() == faces,
        whole,
        || "smoothing groups for some faces only".into(),
    )?;
    validate_vertices(mesh)
}

/// Checks what belongs to the vertices and corners of a mesh.
fn validate_vertices(mesh: &Mesh) -> Check {
    let (vertices, whole) = (mesh.positions.len(), || "mesh".to_string());
    for (name, list) in [
        ("color", &mesh.colors),
        ("irradiance", &mesh.irradiance),
        ("irradiance error", &mesh.irradiance_error),
    ] {
        ensure(list.is_empty() || list.len() == vertices, whole, || {
            format!("{} {name}s for {vertices} vertices", list.len())
        })?;
        let bad = list.iter().position(|&c| !is_light(c));
        ensure(
            bad.is_none(),
            || format!("vertices[{}]", bad.unwrap_or(0)),
            || format!("{name} is negative or not finite"),
        )?;
    }
    validate_back(mesh.back.as_deref(), mesh.irradiance.len())?;
    let bad = mesh.positions.iter().position(|p| !p.is_finite());
    ensure(
        bad.is_none(),
        || format!("vertices[{}]", bad.unwrap_or(0)),
        || "the position is not finite".into(),
    )?;
    validate_attribute(mesh, "normal", mesh.normals.as_ref(), |n| {
        (n.length() - 1.0).abs() < 1e-3
    })?;
    let is_finite = |uv: &DVec2| uv.is_finite();
    validate_attribute(mesh, "texture coordinate", mesh.uvs.as_ref(), is_finite)?;
    let lightmap = mesh.lightmap_uvs.as_ref();
    validate_attribute(mesh, "lightmap coordinate", lightmap, is_finite)
}

/// The place and the light of an instance; its mesh is validated once for all.
fn validate_instance(instance: &MeshInstance) -> Check {
    let place = || "instance".to_string();
    let size = instance.world_from_mesh.matrix3.determinant();
    ensure(
        instance.world_from_mesh.is_finite() && size > 0.0 && size.is_finite(),
        place,
        || "its map is not invertible, or mirrors".into(),
    )?;
    let mesh = &instance.mesh;
    let is_dark = mesh.irradiance.is_empty() && mesh.irradiance_error.is_empty();
    ensure(is_dark && mesh.back.is_none(), place, || {
        "its mesh has irradiance, which belongs to one place".into()
    })?;
    ensure(instance.is_finite(), place, || "its map overflows".into())?;
    let Some(light) = &instance.light else {
        return Ok(());
    };
    let count = mesh.positions.len();
    let fits = light.irradiance.len() == count && [0, count].contains(&light.error.len());
    ensure(fits, place, || {
        let lengths = (light.irradiance.len(), light.error.len());
        format!("irradiance and errors of {lengths:?} for {count} vertices")
    })?;
    let mut values = light.irradiance.iter().chain(&light.error);
    ensure(values.all(|&c| is_light(c)), place, || {
        "irradiance is negative or not finite".into()
    })?;
    validate_back(light.back.as_deref(), count)
}

/// The back's irradiance stands beside that of the front, of as many vertices.
fn validate_back(back: Option<&BackIrradiance>, count: usize) -> Check {
    let Some(back) = back else {
        return Ok(());
    };
    let place = || "mesh".to_string();
    let fits = back.irradiance.len() == count && [0, count].contains(&back.error.len());
    ensure(fits, place, || {
        let lengths = (back.irradiance.len(), back.error.len());
        format!("irradiance and errors of {lengths:?} backs for {count} fronts")
    })?;
    let mut values = back.irradiance.iter().flatten().chain(&back.error);
    ensure(values.all(|&c| is_light(c)), place, || {
        "irradiance of a back is negative or not finite".into()
    })
}

fn validate_attribute<T: Copy>(
    mesh: &Mesh,
    name: &str,
    attribute: Option<&Attribute<T>>,
    good: impl Fn(&T) -> bool,
) -> Check {
    let Some(attribute) = attribute else {
        return Ok(());
    };
    let whole = || "mesh".to_string();
    let count = attribute.values.len();
    match &attribute.corners {
        None => ensure(count == mesh.positions.len(), whole, || {
            format!("{count} {name}s for {} vertices", mesh.positions.len())
        })?,
        Some(index) => {
            ensure(index.len() == mesh.faces.corners.len(), whole, || {
                format!("{name}s for some corners only")
            })?;
            ensure(index.iter().all(|&k| (k as usize) < count), whole, || {
                format!("a corner's {name} is out of range")
            })?;
        }
    }
    let bad = attribute.values.iter().position(|v| !good(v));
    ensure(bad.is_none(), whole, || {
        format!(
            "{name} {} is not usable: not finite, or not of unit length",
            bad.unwrap_or(0)
        )
    })
}

fn validate_primitive(p: &Primitive, materials: usize) -> Check {
    let place = || "primitive".to_string();
    ensure_material(p.material, materials, place)?;
    let m = p.world_from_object.matrix3;
    let size = match p.kind {
        PrimitiveKind::Square => m.x_axis.cross(m.y_axis).length(),
        _ => m.determinant(),
    };
    ensure(
        p.world_from_object.is_finite() && size != 0.0 && size.is_finite(),
        place,
        || "its map is not invertible".into(),
    )?;
    if let PrimitiveKind::Cone { top } | PrimitiveKind::Tube { top } = p.kind {
        ensure((0.0..=1.0).contains(&top), place, || {
            format!("the cone's top radius is {top}, expected 0..=1")
        })?;
    }
    let Some(light) = &p.light else { return Ok(()) };
    let cells = light.grids.iter().all(|g| g.nu > 0 && g.nv > 0);
    let count: usize = light.grids.iter().map(crate::SurfaceGrid::vertices).sum();
    ensure(
        cells && light.grids.len() == p.kind.parts() && count == light.irradiance.len(),
        place,
        || "its light does not fit its grids".into(),
    )?;
    ensure([0, count].contains(&light.error.len()), place, || {
        "its light's error does not fit".into()
    })?;
    let mut values = light.irradiance.iter().chain(&light.error);
    ensure(values.all(|c| c.is_finite()), place, || {
        "its light is not finite".into()
    })
}

#[cfg(test)]
mod tests {
    use crate::*;
    use glam::DVec3;

    fn triangle() -> Scene {
        let mut scene = Scene::default();
        let white = scene.add_material(Material::diffuse("white", Rgb::grey(0.5)));
        let mut mesh = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2], white);
        scene.objects.push(Object::new("t", Shape::Mesh(mesh)));
        scene
    }

    fn mesh(scene: &mut Scene) -> &mut Mesh {
        match &mut scene.objects[0].shape {
            Shape::Mesh(mesh) => mesh,
            _ => unreachable!("the test scene is a mesh"),
        }
    }

    fn check(spoil: impl Fn(&mut Scene), expected: &str) {
        let mut scene = triangle();
        assert_eq!(scene.validate(), Ok(()));
        spoil(&mut scene);
        let message = scene.validate().unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }

    #[test]
    fn broken_promises_are_named() {
        check(|s| mesh(s).faces.corners[1] = 9, "vertex 9 of 3");
        check(
            |s| mesh(s).faces.starts = vec![0, 2, 3],
            "faces[0]: fewer than 3",
        );
        check(
            |s| mesh(s).positions[2].y = f64::NAN,
            "vertices[2]: the position",
        );
        check(|s| mesh(s).face_materials[0] = 4, "material 4 of 1");
        check(
            |s| mesh(s).irradiance = vec![Rgb::WHITE],
            "1 irradiances for 3",
        );
        check(
            |s| mesh(s).normals = Some(Attribute::per_vertex(vec![DVec3::ONE; 3])),
            "normal 0",
        );
        check(|s| s.materials[0].mirror = Rgb::grey(0.6), "exceed 1");
        check(
            |s| s.materials[0].opacity = Some(Opacity::constant(1.5)),
            "opacity is",
        );
        check(
            |s| {
                s.materials[0].opacity = Some(Opacity {
                    mode: OpacityMode::Mask { cutoff: f64::NAN },
                    ..Opacity::constant(1.0)
                });
            },
            "opacity is",
        );
        check(
            |s| {
                s.materials[0].opacity = Some(Opacity {
                    picture: Some(OpacityPicture {
                        texture: 3,
                        channel: OpacityChannel::Alpha,
                    }),
                    ..Opacity::constant(1.0)
                });
            },
            "texture 3 of 0",
        );
        check(|s| s.units.metres_per_unit = Some(0.0), "metres_per_unit");
        check(
            |s| s.background = Some(Rgb::grey(-1.0).into()),
            "background",
        );
        check(
            |s| {
                s.fog = Some(Fog {
                    color: Rgb::WHITE,
                    visibility: 0.0,
                    exponential: true,
                });
            },
            "fog",
        );
        let spot = LightKind::Directional {
            direction: DVec3::ONE,
            irradiance: Rgb::WHITE,
            half_angle: 0.0,
        };
        check(
            |s| {
                s.lights.push(Light {
                    name: "l".into(),
                    kind: spot.clone(),
                })
            },
            "unit vector",
        );
    }
}
