//! The status line for the surface point under the mouse.

use super::PanelContext;
use super::cache::CachedMesh;
use super::legend::number;
use super::pane::ViewPane;
use crate::app::light_unit::ShownUnit;
use crate::document::ShadingPoint;
use crate::gpu::PickHit;
use crate::ui::inspector::named;
use azulejo::scene::Rgb;
use azulejo::scene::math::Ray;

/// Object, position, material and light at the point where a ray hits the model.
pub fn text(cx: &PanelContext, pane: &ViewPane, ray: &Ray) -> Option<String> {
    let hit = pane.hit(ray)?;
    let entry = &pane.cache.entries()[hit.object];
    let document = &cx.app.document;
    let name = document.name(entry.id).unwrap_or_default();
    let p = hit.position;
    let surface = format!(
        "{name} #{} · {} {} · ({}, {}, {})",
        entry.id.0,
        cx.tr("face"),
        entry.model_face(cx.app, ray).unwrap_or(hit.face),
        number(p.x),
        number(p.y),
        number(p.z)
    );
    let weights = hit.barycentric.to_array();
    let mesh = entry.mesh();
    let paint = ShadingPoint::at(mesh, hit.face, hit.vertices, weights, hit.is_front);
    let Some(paint) = paint else {
        return Some(surface);
    };
    let material = named(document, paint.material);
    // What is measured comes first: the end of a long line is cut off in a narrow window.
    let light = light(cx, entry, &hit, &paint, ray).unwrap_or_default();
    Some(format!("{light}{surface} · {material} #{}", paint.material))
}

/// Irradiance with its standard error, and the diffuse radiance.
fn light(
    cx: &PanelContext,
    entry: &CachedMesh,
    hit: &PickHit,
    paint: &ShadingPoint,
    ray: &Ray,
) -> Option<String> {
    let of_lightmap = entry.light_of_lightmap(cx.app, hit.vertices, hit.barycentric);
    if !hit.is_front && of_lightmap.is_none() {
        // Irradiance of vertices is known on front sides only.
        return None;
    }
    let shown = entry.light(hit.vertices, hit.barycentric);
    let shown = of_lightmap.map(|light| (light, None)).or(shown);
    let (irradiance, error) = shown.or_else(|| entry.light_beneath(cx.app, ray))?;
    let app = cx.app;
    let unit = ShownUnit::of(app);
    let error = error.map_or_else(|| "?".to_owned(), |e| number(unit.rgb(e).luminance()));
    let radiance = unit.rgb(app.document.radiance(paint, irradiance)?);
    Some(format!(
        "E = {} ± {error} {}{} · {} L = {} {} · ",
        number(unit.rgb(irradiance).luminance()),
        unit.irradiance(),
        channels(unit.rgb(irradiance)),
        cx.tr("diffuse"),
        number(radiance.luminance()),
        unit.radiance()
    ))
}

/// The channels of a coloured light in parentheses; nothing if they agree.
fn channels(c: Rgb) -> String {
    if is_grey(c) {
        return String::new();
    }
    format!(" (R {}, G {}, B {})", number(c.r), number(c.g), number(c.b))
}

fn is_grey(c: Rgb) -> bool {
    let (low, high) = (c.r.min(c.g).min(c.b), c.max_channel());
    high - low <= 5e-3 * high.abs()
}

/// One number if the channels agree, otherwise three.
pub fn value(c: Rgb) -> String {
    if is_grey(c) {
        number(c.luminance())
    } else {
        format!("({}, {}, {})", number(c.r), number(c.g), number(c.b))
    }
}
