//! Where triangles lie in a lightmap: texture coordinates, charts and pages.

use crate::Receiver;
use glam::DVec2;

/// The number of the chart of a triangle that has none, because it has no area.
pub const NO_CHART: u32 = u32::MAX;

/// Charts of all receivers on the pages of one lightmap.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// Width and height of each page, texels.
    pub pages: Vec<[u32; 2]>,
    /// In the order of the receivers.
    pub receivers: Vec<ReceiverLayout>,
    /// Number of charts on all pages.
    pub charts: u32,
}

/// Where the triangles of a receiver lie.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReceiverLayout {
    /// Texture coordinates of the corners of each triangle, 0..=1, v down: (0, 0) is the outer corner
    /// of the first texel of the first row, as in glTF.
    pub uvs: Vec<[[f32; 2]; 3]>,
    /// Chart of each triangle, counted over all receivers; [`NO_CHART`] if it has none.
    pub charts: Vec<u32>,
    /// Page of each triangle.
    pub pages: Vec<u32>,
    /// Which edges of each triangle, from corner k to k + 1, charts must not cross, because light may
    /// differ on either side: creases, borders of parts, and contacts.
    pub cuts: Vec<[bool; 3]>,
}

impl ReceiverLayout {
    /// The corners of a triangle in texels of a page of this size.
    pub fn texels(&self, triangle: usize, size: [u32; 2]) -> [DVec2; 3] {
        let scale = DVec2::new(size[0].into(), size[1].into());
        self.uvs[triangle].map(|[u, v]| DVec2::new(u.into(), v.into()) * scale)
    }
}

impl Layout {
    /// The corners of a triangle of a receiver in texels of its page.
    pub fn texels(&self, receiver: usize, triangle: usize) -> [DVec2; 3] {
        let layout = &self.receivers[receiver];
        layout.texels(triangle, self.pages[layout.pages[triangle] as usize])
    }

    /// Number of texels of all pages.
    pub fn texel_count(&self) -> u64 {
        let texels = |size: &[u32; 2]| u64::from(size[0]) * u64::from(size[1]);
        self.pages.iter().map(texels).sum()
    }

    /// Texels per scene unit, the root mean square over the area of all charts.
    pub fn density(&self, receivers: &[Receiver]) -> f64 {
        let (mut texels, mut area) = (0.0, 0.0);
        for (r, receiver) in receivers.iter().enumerate() {
            for t in 0..receiver.triangles.len() {
                if self.receivers[r].charts[t] != NO_CHART {
                    texels += signed_area(self.texels(r, t)).abs();
                    area += receiver.area_vector(t).length();
                }
            }
        }
        (texels / f64::max(area, f64::MIN_POSITIVE)).sqrt()
    }
}

/// Area of a triangle in the plane, positive if its corners turn from the first axis to the second.
pub(crate) fn signed_area([a, b, c]: [DVec2; 3]) -> f64 {
    0.5 * (b - a).perp_dot(c - a)
}

/// Barycentric coordinates of a point of the plane; `None` for a triangle without area.
pub(crate) fn barycentric([a, b, c]: [DVec2; 3], p: DVec2) -> Option<[f64; 3]> {
    let whole = (b - a).perp_dot(c - a);
    if whole == 0.0 {
        return None;
    }
    let of_b = (p - a).perp_dot(c - a) / whole;
    let of_c = (b - a).perp_dot(p - a) / whole;
    let weights = [1.0 - of_b - of_c, of_b, of_c];
    weights.iter().all(|w| w.is_finite()).then_some(weights)
}
