//! What a page cannot show.

use super::{PageLightmap, PageMaterial, PageMesh, PageModel, PageOpacity};
use azulejo_scene::Camera;
use std::io;

/// Media types that browsers decode.
const MEDIA_TYPES: [&str; 6] = [
    "image/png",
    "image/jpeg",
    "image/webp",
    "image/gif",
    "image/bmp",
    "image/avif",
];

/// Most texels per row or column: no graphics card takes more.
const MOST_TEXELS: u32 = 16_384;

/// Checks everything that the viewer relies on.
pub(super) fn validate(model: &PageModel) -> io::Result<()> {
    let vertices: usize = model.meshes.iter().map(|m| m.positions.len()).sum();
    let corners: usize = model.meshes.iter().map(|m| m.indices.len()).sum();
    if u32::try_from(vertices.max(corners)).is_err() {
        return Err(invalid(format!(
            "the meshes have {vertices} vertices and {corners} corners, of which a page holds 4294967295"
        )));
    }
    let checks = [
        named(&model.meshes, "mesh", |m| (&m.name, mesh(m, model))),
        named(&model.materials, "material", |m| (&m.name, material(m))),
        named(&model.lightmaps, "lightmap", |m| ("", lightmap(m))),
        named(&model.cameras, "camera", |c| (&c.name, camera(c))),
    ];
    checks
        .into_iter()
        .find_map(Result::err)
        .map_or(Ok(()), |problem| Err(invalid(problem)))
}

fn invalid(message: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, message)
}

type Check = Result<(), String>;

/// The first problem of a list, with its place before it.
fn named<'a, T>(list: &'a [T], what: &str, check: impl Fn(&'a T) -> (&'a str, Check)) -> Check {
    for (k, item) in list.iter().enumerate() {
        let (name, checked) = check(item);
        checked.map_err(|problem| format!("{what} {k} `{name}`: {problem}"))?;
    }
    Ok(())
}

fn mesh(mesh: &PageMesh, model: &PageModel) -> Check {
    let count = mesh.positions.len();
    for (what, len) in [
        ("normals", mesh.normals.len()),
        ("texture coordinates", mesh.uvs.len()),
        ("places in the lightmap", mesh.lightmap_uvs.len()),
        ("colours", mesh.colors.len()),
    ] {
        if len != 0 && len != count {
            return Err(format!("{len} {what} for {count} vertices"));
        }
    }
    finite("position", &mesh.positions)?;
    finite("normal", &mesh.normals)?;
    finite("texture coordinate", &mesh.uvs)?;
    finite("place in the lightmap", &mesh.lightmap_uvs)?;
    finite("colour", &mesh.colors)?;
    if !mesh.indices.len().is_multiple_of(3) {
        let corners = mesh.indices.len();
        return Err(format!("{corners} indices, which are not triangles"));
    }
    if let Some(index) = mesh.indices.iter().find(|i| **i as usize >= count) {
        return Err(format!("index {index} among {count} vertices"));
    }
    if mesh.material as usize >= model.materials.len() {
        let (material, count) = (mesh.material, model.materials.len());
        return Err(format!("material {material} of {count}"));
    }
    if !mesh.lightmap_uvs.is_empty() && mesh.lightmap as usize >= model.lightmaps.len() {
        let (lightmap, count) = (mesh.lightmap, model.lightmaps.len());
        return Err(format!("lightmap {lightmap} of {count}"));
    }
    Ok(())
}

fn material(material: &PageMaterial) -> Check {
    for (what, color) in [
        ("base colour", material.base_color),
        ("emission", material.emission),
    ] {
        let is_light = |x: f32| x.is_finite() && x >= 0.0;
        if !color.into_iter().all(is_light) {
            return Err(format!("{what} {color:?}, expected finite numbers ≥ 0"));
        }
    }
    let opacity = match material.opacity {
        PageOpacity::Opaque => 1.0,
        PageOpacity::Mask { cutoff: x } | PageOpacity::Blend { opacity: x } => x,
    };
    if !(0.0..=1.0).contains(&opacity) {
        return Err(format!("opacity {opacity}, expected 0 to 1"));
    }
    if let Some(picture) = &material.picture
        && !MEDIA_TYPES.contains(&picture.media_type.as_str())
    {
        let (media_type, known) = (&picture.media_type, MEDIA_TYPES.join(", "));
        return Err(format!(
            "a picture of type `{media_type}`, expected one of {known}"
        ));
    }
    Ok(())
}

fn lightmap(map: &PageLightmap) -> Check {
    let sides = 1..=MOST_TEXELS;
    if !sides.contains(&map.width) || !sides.contains(&map.height) {
        let (width, height) = (map.width, map.height);
        return Err(format!(
            "{width} × {height} texels, expected 1 to {MOST_TEXELS} a side"
        ));
    }
    let count = map.width as usize * map.height as usize;
    let values = map.irradiance.len();
    if values != count {
        return Err(format!("{values} values of irradiance for {count} texels"));
    }
    let errors = map.standard_error.len();
    if errors != 0 && errors != count {
        return Err(format!("{errors} standard errors for {count} texels"));
    }
    Ok(())
}

fn camera(camera: &Camera) -> Check {
    let vectors = [camera.eye, camera.target, camera.up];
    let (forward, fov) = (camera.target - camera.eye, camera.vertical_fov);
    let is_view = vectors.iter().all(|v| v.is_finite())
        && forward.cross(camera.up).length_squared() > 0.0
        && fov > 0.0
        && fov < std::f64::consts::PI;
    if is_view {
        Ok(())
    } else {
        Err(format!("{camera:?} sees nothing"))
    }
}

/// Whether all numbers of a list are finite; the first that is not is named.
fn finite<const N: usize>(what: &str, list: &[[f32; N]]) -> Check {
    let bad = |value: &[f32; N]| !value.iter().all(|x| x.is_finite());
    match list.iter().position(bad) {
        None => Ok(()),
        Some(k) => Err(format!(
            "{what} {k} is {:?}, expected finite numbers",
            list[k]
        )),
    }
}
