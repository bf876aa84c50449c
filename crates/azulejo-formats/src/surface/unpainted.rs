//! White surfaces whose pictures are missing.
//!
//! A picture multiplies the diffuse reflectance of its material, which is therefore often white. Without the
//! picture such a surface would reflect all light: interreflection would hardly end, and pictures would
//! be overexposed.

use super::gloss::Gloss;
use super::model::gltf_mr;
use crate::Warning;
use crate::reading::text::shortened;
use crate::reading::warnings::Warnings;
use azulejo_scene::{Material, Rgb, Scene};

/// Surfaces are white if they reflect more than this share in every channel.
const WHITE: f64 = 0.8;

/// What they reflect without their picture, about as much as the mean of most pictures.
const MIDDLE: f64 = 0.5;

/// Gives white materials a middle reflectance if all pictures of their diffuse reflectance are missing, and
/// returns a warning for each such picture. Vertex colours show in place of a picture: materials that have
/// them stay white.
pub(crate) fn darken_unpainted(scene: &mut Scene, file: &str) -> Vec<Warning> {
    let has_colors = materials_with_colors(scene);
    let is_missing = |id: &u32| {
        let texture = scene.textures.get(*id as usize);
        texture.is_none_or(|t| t.image.is_none())
    };
    let (mut gloss, mut warnings) = (Gloss::default(), Warnings::default());
    let mut is_named = vec![false; scene.textures.len()];
    for (material, has_colors) in scene.materials.iter_mut().zip(has_colors) {
        let pictures = &material.textures;
        let is_unpainted = !pictures.is_empty() && pictures.iter().all(is_missing);
        if !is_unpainted || has_colors || !darken(material, &mut gloss) {
            continue;
        }
        for &id in &material.textures {
            if let Some(texture) = scene.textures.get(id as usize)
                && !std::mem::replace(&mut is_named[id as usize], true)
            {
                let name = shortened(&texture.path);
                let message = format!(
                    "picture \"{name}\" is missing: white materials with it reflect 50% instead"
                );
                warnings.add_whole(file, message);
            }
        }
    }
    warnings.finish(file)
}

/// Whether each material is on a mesh with vertex colours.
fn materials_with_colors(scene: &Scene) -> Vec<bool> {
    let mut has_colors = vec![false; scene.materials.len()];
    let meshes = scene.objects.iter().filter_map(|o| o.shape.mesh());
    for mesh in meshes.filter(|m| !m.colors.is_empty()) {
        for &material in &mesh.face_materials {
            has_colors[material as usize] = true;
        }
    }
    has_colors
}

/// Gives a material a middle reflectance if it is white; `false` if it is not.
fn darken(material: &mut Material, gloss: &mut Gloss) -> bool {
    let is_white = |c: Rgb| c.r.min(c.g).min(c.b) > WHITE;
    let middle = Rgb::grey(MIDDLE);
    if material.dielectric.is_some() {
        return false;
    }
    match gltf_mr(material) {
        Some((base, metallic, roughness)) if is_white(base) => {
            // There are no more models than before.
            let made = gloss.metallic_roughness(material, middle, metallic, roughness);
            if made.is_err() {
                material.brdf = None;
            }
            true
        }
        None if is_white(material.diffuse) => {
            material.diffuse = middle;
            true
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{Image, Mesh, Object, Shape, Texture};
    use glam::DVec3;

    fn scene(materials: Vec<Material>) -> Scene {
        let texture = |path: &str, image: Option<Image>| Texture {
            path: path.into(),
            image,
            ..Texture::default()
        };
        Scene {
            materials,
            textures: vec![
                texture("lost.jpg", None),
                texture("here.png", Some(Image::new(1, 1))),
            ],
            ..Scene::default()
        }
    }

    fn with(reflectance: f64, textures: &[u32]) -> Material {
        Material {
            textures: textures.to_vec(),
            ..Material::diffuse("m", Rgb::grey(reflectance))
        }
    }

    #[test]
    fn white_without_its_picture_is_grey() {
        let mut scene = scene(vec![
            with(1.0, &[0]),
            with(0.85, &[0]),
            with(0.7, &[0]),
            with(1.0, &[1]),
            with(1.0, &[0, 1]),
            with(1.0, &[]),
        ]);
        let warnings = darken_unpainted(&mut scene, "a.obj");
        let reflectances: Vec<f64> = scene.materials.iter().map(|m| m.diffuse.g).collect();
        assert_eq!(reflectances, [0.5, 0.5, 0.7, 1.0, 1.0, 1.0]);
        assert_eq!(warnings.len(), 1);
        assert!(warnings[0].message.contains("lost.jpg"));
        assert!(darken_unpainted(&mut scene, "a.obj").is_empty());
    }

    #[test]
    fn base_colours_of_models_change_with_them() {
        let mut glossy = with(1.0, &[0]);
        let mut gloss = Gloss::default();
        gloss
            .metallic_roughness(&mut glossy, Rgb::WHITE, 0.0, 0.5)
            .unwrap();
        let mut scene = scene(vec![glossy]);
        darken_unpainted(&mut scene, "a.glb");
        let material = &scene.materials[0];
        assert_eq!(gltf_mr(material), Some((Rgb::grey(0.5), 0.0, 0.5)));
        assert!(material.diffuse.max_channel() <= 0.5);
        scene.validate().unwrap();
    }

    #[test]
    fn colours_of_vertices_show_in_place_of_the_picture() {
        let mut scene = scene(vec![with(1.0, &[0])]);
        let mut mesh = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            colors: vec![Rgb::grey(0.3); 3],
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2], 0);
        scene.objects.push(Object::new("", Shape::Mesh(mesh)));
        assert!(darken_unpainted(&mut scene, "a.ply").is_empty());
        assert_eq!(scene.materials[0].diffuse, Rgb::WHITE);
    }
}
