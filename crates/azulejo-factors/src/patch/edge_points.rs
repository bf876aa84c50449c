//! The division points of edges: evenly spaced, but also at the ends of contacts.

use super::contacts::Contacts;
use super::lines::Lines;
use super::outline::{Edge, Outline, Slot};
use std::collections::HashMap;

/// Cuts closer than this share of the patch size are merged.
const SNAP: f64 = 0.02;

/// The division of every edge.
pub(super) struct EdgePoints {
    /// Pieces of each edge.
    pub pieces: Vec<u32>,
    /// For edges that are not divided evenly, the inner points as ascending shares.
    cut: HashMap<u32, Vec<f64>>,
}

impl EdgePoints {
    /// Even divisions.
    pub fn even(pieces: Vec<u32>) -> EdgePoints {
        EdgePoints {
            pieces,
            cut: HashMap::new(),
        }
    }

    /// Point `i` of an edge, as a share of it.
    pub fn share(&self, edge: u32, i: u32) -> f64 {
        let count = self.pieces[edge as usize];
        match self.cut.get(&edge) {
            Some(_) if i == 0 => 0.0,
            Some(inner) => inner.get(i as usize - 1).copied().unwrap_or(1.0),
            None => f64::from(i) / f64::from(count),
        }
    }

    /// Point `step` of a side, counted from its slot, as a share of the side's edge.
    pub fn share_on(&self, slot: &Slot, step: u32) -> f64 {
        let count = self.pieces[slot.edge as usize];
        self.share(slot.edge, if slot.forward { step } else { count - step })
    }

    /// The point of a side nearest to `share` of it; the side's count stands for its end.
    pub fn nearest(&self, slot: &Slot, share: f64) -> u32 {
        let along = if slot.forward { share } else { 1.0 - share };
        let off = |step: &u32| (self.share_on(slot, *step) - along).abs();
        let steps = 0..=self.pieces[slot.edge as usize];
        steps.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0)
    }

    /// Whether an edge is not divided evenly.
    pub fn is_cut(&self, edge: u32) -> bool {
        self.cut.contains_key(&edge)
    }

    /// Cuts the edges on which lines end, where every face at the edge has contacts: faces without
    /// contacts are divided as if there were none.
    pub fn cut_at_ends(
        &mut self,
        outline: &Outline,
        contacts: &Contacts,
        lines: &[Option<Box<Lines>>],
        size: f64,
    ) {
        // Where lines end on edges, and how many faces with contacts there are at each edge.
        let mut ends: Vec<(u32, f64)> = Vec::new();
        let mut faces: HashMap<u32, i64> = HashMap::new();
        for (r, region) in outline.regions.iter().enumerate() {
            if !contacts.run_through(r) {
                continue;
            }
            let slots = outline.slots_of(region);
            let lines = lines[r].as_deref();
            let line_ends = lines.iter().flat_map(|l| l.ends());
            for (side, share) in line_ends.filter(|e| e.1 > 0.0 && e.1 < 1.0) {
                let slot = &slots[side as usize];
                ends.push((slot.edge, if slot.forward { share } else { 1.0 - share }));
            }
            for slot in slots {
                *faces.entry(slot.edge).or_default() += 1;
            }
        }
        if ends.is_empty() {
            return;
        }
        // Edges at which a face has no contacts are left alone.
        for slot in &outline.slots {
            if let Some(left) = faces.get_mut(&slot.edge) {
                *left -= 1;
            }
        }
        ends.retain(|e| faces[&e.0] == 0);
        ends.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        for cuts in ends.chunk_by(|a, b| a.0 == b.0) {
            let edge = cuts[0].0;
            let cuts = cuts.iter().map(|e| e.1);
            let inner = inner_points(&outline.edges[edge as usize], cuts, size);
            self.pieces[edge as usize] = inner.len() as u32 + 1;
            self.cut.insert(edge, inner);
        }
    }
}

/// The inner points of an edge that is divided at ascending `cuts` and evenly in between.
fn inner_points(edge: &Edge, cuts: impl Iterator<Item = f64>, size: f64) -> Vec<f64> {
    let length = edge.length();
    let (mut inner, mut last) = (Vec::new(), 0.0);
    for cut in cuts.chain([1.0]) {
        let is_end = cut == 1.0;
        if !is_end && ((cut - last) * length < SNAP * size || (1.0 - cut) * length < SNAP * size) {
            continue;
        }
        let count = ((cut - last) * length / size).ceil().max(1.0) as u32;
        inner.extend((1..count).map(|k| last + (cut - last) * f64::from(k) / f64::from(count)));
        if !is_end {
            inner.push(cut);
        }
        last = cut;
    }
    inner
}
