//! The head of the data: everything small, as JSON.

use super::light::{ERROR_STEPS, LIGHT_STEPS, LightCodes, OCTAVES};
use super::{PageMaterial, PageMesh, PageModel, PageOpacity};
use azulejo_scene::{Camera, WrapMode};
use serde_json::{Value, json};

/// The JSON text, safe inside of a script element.
pub(super) fn json(model: &PageModel, light: &[LightCodes]) -> String {
    let pictures = model.materials.iter().filter_map(|m| m.picture.as_ref());
    let maps = model.lightmaps.iter().zip(light).map(|(map, codes)| {
        json!({
            "width": map.width,
            "height": map.height,
            "peak": codes.peak,
            "errorPeak": codes.error_peak,
        })
    });
    let head = json!({
        "title": title(model),
        "note": model.note,
        "photometric": model.photometric,
        "up": model.up.axis().to_array(),
        "lightSteps": LIGHT_STEPS,
        "errorSteps": ERROR_STEPS,
        "octaves": OCTAVES,
        "meshes": model.meshes.iter().map(mesh).collect::<Vec<_>>(),
        "materials": materials(&model.materials),
        "pictures": pictures.map(|p| json!({
            "type": p.media_type,
            "wrap": p.wrap.map(wrap),
        })).collect::<Vec<_>>(),
        "lightmaps": maps.collect::<Vec<_>>(),
        "cameras": model.cameras.iter().map(camera).collect::<Vec<_>>(),
    });
    // No "</script>" and no "<!--" can appear without it.
    head.to_string().replace('<', "\\u003c")
}

/// The title of the page.
pub(super) fn title(model: &PageModel) -> &str {
    match model.title.trim() {
        "" => "azulejo",
        title => title,
    }
}

fn mesh(mesh: &PageMesh) -> Value {
    json!({
        "name": mesh.name,
        "vertices": mesh.positions.len(),
        "indices": mesh.indices.len(),
        "uvs": !mesh.uvs.is_empty(),
        "lit": !mesh.lightmap_uvs.is_empty(),
        "colors": !mesh.colors.is_empty(),
        "material": mesh.material,
        "lightmap": mesh.lightmap,
    })
}

fn materials(materials: &[PageMaterial]) -> Vec<Value> {
    let mut pictures = 0;
    let mut number = |material: &PageMaterial| {
        let number = material.picture.as_ref().map(|_| pictures);
        pictures += u32::from(number.is_some());
        number
    };
    materials
        .iter()
        .map(|m| {
            let (mode, opacity) = match m.opacity {
                PageOpacity::Opaque => ("opaque", 1.0),
                PageOpacity::Mask { cutoff } => ("mask", cutoff),
                PageOpacity::Blend { opacity } => ("blend", opacity),
            };
            json!({
                "name": m.name,
                "baseColor": m.base_color,
                "emission": m.emission,
                "picture": number(m),
                "mode": mode,
                "opacity": opacity,
                "doubleSided": m.double_sided,
                "unlit": m.unlit,
            })
        })
        .collect()
}

fn wrap(mode: WrapMode) -> &'static str {
    match mode {
        WrapMode::Repeat => "repeat",
        WrapMode::Clamp => "clamp",
        WrapMode::Mirror => "mirror",
    }
}

fn camera(camera: &Camera) -> Value {
    json!({
        "name": camera.name,
        "eye": camera.eye.to_array(),
        "target": camera.target.to_array(),
        "up": camera.up.to_array(),
        "verticalFov": camera.vertical_fov.to_degrees(),
        "size": camera.size.map(|(width, height)| [width, height]),
    })
}
