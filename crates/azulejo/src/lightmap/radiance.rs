//! The radiance that lit surfaces show, in the texels of a lightmap: for viewers that know no lightmaps.

use super::Baked;
use azulejo_bake::{SurfaceColor, TriangleId, texel_colors};
use azulejo_render::DiffuseReflectance;
use azulejo_scene::{PlacedMesh, Rgb, Scene};
use azulejo_trace::{Cancelled, MeshTriangles, Progress};
use glam::DVec2;
use std::f32::consts::PI;

/// Share of the area that may be brighter than what an automatic exposure shows.
const BRIGHTEST: f64 = 1e-3;

/// The radiance of the diffusely reflected light, ρE/π, of each texel of each page, W/(sr·m²) (cd/m² in
/// photometric scenes): ρ is the mean over what the texel covers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TexelRadiance {
    /// The texels of each page, as those of [`Lightmap`](azulejo_bake::Lightmap).
    pub pages: Vec<Vec<[f32; 3]>>,
    /// What each of them covers, square scene units.
    areas: Vec<Vec<f32>>,
}

impl TexelRadiance {
    /// The radiance of what was baked of a scene. `padding` is that of its charts.
    ///
    /// # Errors
    /// The caller cancelled.
    pub fn new(
        baked: &Baked,
        scene: &Scene,
        padding: u32,
        progress: &Progress,
    ) -> Result<TexelRadiance, Cancelled> {
        let colors = ColorOfObjects::new(baked, scene);
        let mut pages = texel_colors(&baked.atlas, &colors, padding, progress)?;
        for (colors, page) in pages.iter_mut().zip(&baked.lightmap.pages) {
            for (color, light) in colors.iter_mut().zip(&page.irradiance) {
                *color = [0, 1, 2].map(|k| color[k] * light[k] / PI);
            }
        }
        let areas = baked.lightmap.pages.iter().map(|p| p.areas.clone());
        Ok(TexelRadiance {
            pages,
            areas: areas.collect(),
        })
    }

    /// The factor with which all but the brightest thousandth of the area is at most 1; 1 without light.
    pub fn exposure(&self) -> f64 {
        let mut texels: Vec<(f32, f32)> = self.texels().collect();
        texels.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut left = BRIGHTEST * self.area();
        for (bright, area) in texels {
            left -= f64::from(area);
            if left < 0.0 {
                return if bright > 0.0 {
                    1.0 / f64::from(bright)
                } else {
                    1.0
                };
            }
        }
        1.0
    }

    /// Multiplies all texels, and cuts what is above 1. Returns the share of the area where a channel was.
    pub fn expose(&mut self, exposure: f64) -> f64 {
        for texel in self.pages.iter_mut().flatten() {
            *texel = texel.map(|v| (f64::from(v) * exposure) as f32);
        }
        let above = self.texels().filter(|(bright, _)| *bright > 1.0);
        let above: f64 = above.map(|(_, area)| f64::from(area)).sum();
        for value in self.pages.iter_mut().flatten().flatten() {
            *value = value.min(1.0);
        }
        above / f64::max(self.area(), f64::MIN_POSITIVE)
    }

    /// The brightest channel of each texel, and the area that it covers.
    fn texels(&self) -> impl Iterator<Item = (f32, f32)> + '_ {
        let values = self.pages.iter().flatten();
        let bright = values.map(|texel| texel.iter().copied().fold(0.0, f32::max));
        bright.zip(self.areas.iter().flatten().copied())
    }

    fn area(&self) -> f64 {
        self.areas.iter().flatten().map(|&a| f64::from(a)).sum()
    }
}

/// The diffuse reflectance of the objects that receive.
struct ColorOfObjects<'a> {
    reflectance: DiffuseReflectance<'a>,
    objects: Vec<Option<ReceivingMesh<'a>>>,
}

/// The mesh of an object with its triangles.
struct ReceivingMesh<'a> {
    placed: PlacedMesh<'a>,
    triangles: MeshTriangles,
    /// The face of each triangle.
    faces: Vec<u32>,
}

impl<'a> ColorOfObjects<'a> {
    fn new(baked: &Baked, scene: &'a Scene) -> ColorOfObjects<'a> {
        let mesh_of = |&object: &u32| {
            let placed = scene.objects[object as usize].shape.placed_mesh()?;
            let faces = 0..placed.mesh.faces.len();
            let of_face =
                |face| std::iter::repeat_n(face as u32, placed.mesh.faces.get(face).len() - 2);
            Some(ReceivingMesh {
                triangles: MeshTriangles::new(placed.mesh),
                faces: faces.flat_map(of_face).collect(),
                placed,
            })
        };
        ColorOfObjects {
            reflectance: DiffuseReflectance::new(scene),
            objects: baked.objects.iter().map(mesh_of).collect(),
        }
    }

    /// The mesh of a triangle that has a place in the lightmap.
    fn mesh(&self, of: TriangleId) -> Option<&ReceivingMesh<'a>> {
        self.objects.get(of.receiver as usize)?.as_ref()
    }
}

impl SurfaceColor for ColorOfObjects<'_> {
    fn at(&self, of: TriangleId, weights: [f64; 3]) -> Rgb {
        let Some(receiving) = self.mesh(of) else {
            return Rgb::BLACK;
        };
        let mesh = receiving.placed.mesh;
        let corners = receiving.triangles.corners(of.triangle as usize);
        let vertex = |c: u32| mesh.faces.corners[c as usize];
        let color = if mesh.colors.is_empty() {
            Rgb::WHITE
        } else {
            let parts = corners.iter().zip(weights);
            parts
                .map(|(&c, w)| mesh.colors[vertex(c) as usize] * w)
                .sum()
        };
        let uv = mesh.uvs.as_ref().map(|uvs| {
            let parts = corners.iter().zip(weights);
            parts
                .map(|(&c, w)| w * uvs.at(c as usize, vertex(c)))
                .sum::<DVec2>()
        });
        let face = receiving.faces[of.triangle as usize] as usize;
        self.reflectance.at(mesh.face_materials[face], color, uv)
    }

    fn varies(&self, of: TriangleId) -> bool {
        let Some(receiving) = self.mesh(of) else {
            return false;
        };
        let mesh = receiving.placed.mesh;
        let material = mesh.face_materials[receiving.faces[of.triangle as usize] as usize];
        let is_textured = mesh.uvs.is_some() && self.reflectance.is_textured(material);
        is_textured || !mesh.colors.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texels(values: &[(f32, f32)]) -> TexelRadiance {
        TexelRadiance {
            pages: vec![values.iter().map(|v| [v.0, 0.5 * v.0, 0.0]).collect()],
            areas: vec![values.iter().map(|v| v.1).collect()],
        }
    }

    #[test]
    fn the_brightest_thousandth_is_cut() {
        let mut dark = vec![(2.0, 1.0); 2000];
        dark.extend([(100.0, 1.0), (50.0, 0.9), (1e9, 0.0)]);
        let mut all = texels(&dark);
        assert_eq!(all.exposure(), 0.5);
        let cut = all.expose(0.5);
        assert!((cut - 1.9 / 2001.9).abs() < 1e-9, "{cut}");
        assert_eq!(all.pages[0][0], [1.0, 0.5, 0.0]);
        assert_eq!(all.pages[0][2000], [1.0, 1.0, 0.0]);
        assert_eq!(texels(&[(0.0, 1.0)]).exposure(), 1.0);
        assert_eq!(texels(&[]).exposure(), 1.0);
        assert_eq!(texels(&[]).expose(2.0), 0.0);
    }
}
