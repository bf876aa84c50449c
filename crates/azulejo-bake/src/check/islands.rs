//! Charts by their edges: triangles that meet in space and on the page.

use crate::Receiver;
use crate::layout::ReceiverLayout;
use std::collections::HashMap;

/// The charts of a receiver.
pub(super) struct Islands {
    /// In the order of the triangles that were asked for.
    pub triangles: Vec<IslandTriangle>,
    /// Number of charts.
    pub charts: u32,
    /// Triangles that meet at an edge inside of a chart.
    neighbours: Vec<[u32; 2]>,
}

/// A triangle in its chart.
#[derive(Clone, Copy, Default)]
pub(super) struct IslandTriangle {
    /// Its chart, from 0.
    pub chart: u32,
    /// Which of its edges, from corner k to k + 1, no other triangle of the chart has.
    pub is_border: [bool; 3],
}

/// A corner by the bits of its position and coordinates.
type CornerKey = ([u64; 3], [u32; 2]);

/// The charts that some of the triangles of a receiver form.
pub(super) fn of(receiver: &Receiver, layout: &ReceiverLayout, kept: &[usize]) -> Islands {
    let mut corners: HashMap<CornerKey, u32> = HashMap::new();
    let mut edges: HashMap<[u32; 2], (u32, u8)> = HashMap::new();
    let mut sets = DisjointSets::new(kept.len());
    let mut is_border = vec![[true; 3]; kept.len()];
    let mut neighbours = Vec::new();
    for (k, &t) in kept.iter().enumerate() {
        let ids = [0, 1, 2].map(|c| {
            let place = receiver.positions[receiver.triangles[t][c] as usize];
            // Negative zero is where zero is.
            let place = (place + 0.0).to_array().map(f64::to_bits);
            let uv = layout.uvs[t][c].map(|x| (x + 0.0).to_bits());
            let next = corners.len() as u32;
            *corners.entry((place, uv)).or_insert(next)
        });
        for c in 0..3 {
            let (a, b) = (ids[c], ids[(c + 1) % 3]);
            let first = *edges
                .entry([a.min(b), a.max(b)])
                .or_insert((k as u32, c as u8));
            let other = first.0 as usize;
            let is_one = layout.charts.get(t) == layout.charts.get(kept[other]);
            if other != k && is_one {
                sets.join(first.0, k as u32);
                is_border[k][c] = false;
                is_border[other][usize::from(first.1)] = false;
                neighbours.push([kept[other] as u32, t as u32]);
            }
        }
    }
    let mut numbers: HashMap<u32, u32> = HashMap::new();
    let mut triangles = Vec::with_capacity(kept.len());
    for (k, &t) in kept.iter().enumerate() {
        let key = match layout.charts.get(t) {
            Some(&given) => given,
            None => sets.root(k as u32),
        };
        let next = numbers.len() as u32;
        triangles.push(IslandTriangle {
            chart: *numbers.entry(key).or_insert(next),
            is_border: is_border[k],
        });
    }
    Islands {
        triangles,
        charts: numbers.len() as u32,
        neighbours,
    }
}

impl Islands {
    /// Angles between neighbours that are larger than this, degrees, and one of the triangles.
    pub fn creases(&self, receiver: &Receiver, crease: f64) -> Vec<(f64, u32)> {
        let normal = |t: u32| receiver.area_vector(t as usize).normalize_or_zero();
        let angle = |&[a, b]: &[u32; 2]| {
            let cosine = normal(a).dot(normal(b)).clamp(-1.0, 1.0);
            (cosine.acos().to_degrees(), b)
        };
        let angles = self.neighbours.iter().map(angle);
        // Normals in single precision have angles to about 0.02°.
        angles.filter(|(angle, _)| *angle > crease + 0.1).collect()
    }
}

/// Sets that are joined (Tarjan 1975, with halved paths).
struct DisjointSets(Vec<u32>);

impl DisjointSets {
    fn new(count: usize) -> DisjointSets {
        DisjointSets((0..count as u32).collect())
    }

    fn root(&mut self, mut of: u32) -> u32 {
        while self.0[of as usize] != of {
            let above = self.0[of as usize];
            self.0[of as usize] = self.0[above as usize];
            of = above;
        }
        of
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        // The lower number stays, so that charts are numbered in the order of triangles.
        self.0[a.max(b) as usize] = a.min(b);
    }
}
