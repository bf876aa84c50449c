//! Irradiance at hits, from the texels that they lie on.

use crate::atlas::Atlas;
use crate::layout::{NO_CHART, signed_area};
use crate::samples::Samples;
use azulejo_radiosity::IrradianceField;
use azulejo_radiosity::sites::SiteLight;
use azulejo_trace::{DiffuseHit, Surfaces};

/// Irradiance by texel.
pub struct TexelField<'a> {
    atlas: &'a Atlas,
    surfaces: &'a Surfaces<'a>,
    /// By object: its receivers, one for each side that has texels, and the first triangle of each face.
    of_object: Vec<(Vec<u32>, Vec<u32>)>,
    /// By page and texel.
    pages: Vec<Vec<[f32; 3]>>,
    /// By receiver and triangle, the width of its texels, scene units.
    widths: Vec<Vec<f32>>,
}

impl<'a> TexelField<'a> {
    /// From the light of samples. `objects` are those of the receivers in the scene.
    pub fn new(
        atlas: &'a Atlas,
        samples: &Samples,
        light: &[SiteLight],
        objects: &[u32],
        surfaces: &'a Surfaces<'a>,
    ) -> TexelField<'a> {
        let mut of_object = vec![(Vec::new(), Vec::new()); surfaces.scene.objects.len()];
        // List the receivers of each object, and once for all of them the first triangles of its faces.
        for (receiver, &object) in objects.iter().enumerate() {
            let (receivers, starts) = &mut of_object[object as usize];
            receivers.push(receiver as u32);
            if receivers.len() > 1 {
                continue;
            }
            let mesh = surfaces.scene.objects[object as usize].shape.mesh();
            *starts = mesh.map_or(Vec::new(), |mesh| {
                let first = |face| azulejo_trace::MeshTriangles::first_of(mesh, face) as u32;
                (0..mesh.faces.len()).map(first).collect()
            });
        }
        // Spread the light over the pages: the first sample of a texel counts, and texels without any are NaN.
        let mut pages: Vec<Vec<[f32; 3]>> = samples
            .pages
            .iter()
            .map(|p| vec![[f32::NAN; 3]; p.size[0] as usize * p.size[1] as usize])
            .collect();
        for (s, light) in samples.samples.iter().zip(light) {
            let page = s.page as usize;
            let index = samples.pages[page].texels[s.texel as usize].index as usize;
            if pages[page][index][0].is_nan() {
                pages[page][index] = light.irradiance;
            }
        }
        // Texels are as wide as the root of their area on each triangle.
        let width = |r: usize, t: usize| {
            let in_texels = signed_area(atlas.layout.texels(r, t)).abs();
            let area = atlas.receivers[r].area_vector(t).length();
            (area / in_texels.max(f64::MIN_POSITIVE)).sqrt() as f32
        };
        let widths = (0..atlas.receivers.len()).map(|r| {
            (0..atlas.receivers[r].triangles.len())
                .map(|t| width(r, t))
                .collect()
        });
        TexelField {
            atlas,
            surfaces,
            of_object,
            pages,
            widths: widths.collect(),
        }
    }
}

impl IrradianceField for TexelField<'_> {
    /// That of the texel, with its width; `None` where no texel receives on that side.
    fn irradiance(&self, at: &DiffuseHit) -> Option<([f32; 3], f32)> {
        let item = self.surfaces.item(at.hit.item);
        let (receivers, starts) = self.of_object.get(item.object as usize)?;
        let triangle = (*starts.get(item.face as usize)? + item.triangle) as usize;
        let is_seen = |&&receiver: &&u32| {
            let chart = self.atlas.layout.receivers[receiver as usize].charts[triangle];
            chart != NO_CHART && self.atlas.is_turned(chart) != at.front
        };
        let receiver = receivers.iter().find(is_seen)?;
        let layout = &self.atlas.layout.receivers[*receiver as usize];
        let [u, v] = at.hit.uv();
        let page = layout.pages[triangle];
        let size = self.atlas.layout.pages[page as usize];
        let corners = layout.uvs[triangle];
        let texel = |k: usize| {
            let x = corners[0][k] * (1.0 - u - v) + corners[1][k] * u + corners[2][k] * v;
            ((x * size[k] as f32).max(0.0) as u32).min(size[k] - 1)
        };
        let index = texel(1) as usize * size[0] as usize + texel(0) as usize;
        let irradiance = self.pages[page as usize][index];
        (!irradiance[0].is_nan()).then(|| (irradiance, self.widths[*receiver as usize][triangle]))
    }
}
