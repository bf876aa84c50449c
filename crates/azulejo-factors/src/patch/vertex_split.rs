//! Display vertices on both sides of a contact.
//!
//! Around a vertex, patches belong together if they are connected by edges that are not contacts.
//! Each such group has a display vertex of its own, so the end of a line in the middle of a face
//! stays one vertex.

use super::DisplayVertex;
use super::cells::NO_CORNER;
use std::collections::{BTreeMap, HashSet};

/// A display vertex that was split off.
#[derive(Clone, Copy, Debug)]
pub(super) struct SplitVertex {
    pub from: u32,
    pub into: u32,
    /// Share of the angle around the vertex.
    pub share: f64,
}

/// Splits the vertices along `contacts`, pairs of vertices in ascending order, between the patches
/// with these `corners`. New vertices are appended.
pub(super) fn split_along_contacts(
    contacts: &HashSet<[u32; 2]>,
    corners: &mut [[u32; 4]],
    vertices: &mut Vec<DisplayVertex>,
) -> Vec<SplitVertex> {
    let mut around: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for &v in contacts.iter().flatten() {
        around.entry(v).or_default();
    }
    for (i, ring) in corners.iter().enumerate() {
        for v in ring {
            if let Some(patches) = around.get_mut(v) {
                patches.push(i);
            }
        }
    }
    let (mut parted, mut changes) = (Vec::new(), Vec::new());
    for (&v, patches) in &around {
        let rings = patches
            .iter()
            .map(|&i| Corner::new(&corners[i], v, vertices));
        let rings: Vec<Corner> = rings.collect();
        let groups = groups(&rings, v, contacts);
        let angle = |g: usize| -> f64 {
            let members = rings.iter().zip(&groups).filter(|r| *r.1 == g);
            members.map(|r| r.0.angle).sum()
        };
        let whole: f64 = rings.iter().map(|r| r.angle).sum();
        // A group is named by its first patch, and the first group keeps the vertex.
        for g in (0..groups.len()).filter(|&g| groups[g] == g) {
            let into = if g == 0 { v } else { vertices.len() as u32 };
            if g > 0 {
                vertices.push(vertices[v as usize]);
                let members = patches.iter().zip(&groups).filter(|p| *p.1 == g);
                changes.extend(members.map(|p| (*p.0, v, into)));
            }
            let share = angle(g) / whole;
            parted.push(SplitVertex {
                from: v,
                into,
                share,
            });
        }
    }
    for (patch, from, into) in changes {
        let corner = corners[patch].iter_mut().find(|v| **v == from);
        corner.into_iter().for_each(|v| *v = into);
    }
    parted
}

/// A patch's corner: the vertices before and after it, and its angle.
struct Corner {
    beside: [u32; 2],
    angle: f64,
}

impl Corner {
    fn new(ring: &[u32; 4], v: u32, vertices: &[DisplayVertex]) -> Corner {
        let n = if ring[3] == NO_CORNER { 3 } else { 4 };
        let k = ring.iter().position(|&w| w == v).unwrap_or(0);
        let beside = [ring[(k + n - 1) % n], ring[(k + 1) % n]];
        let at = |v: u32| vertices[v as usize].position;
        let [a, b] = beside.map(|w| at(w) - at(v));
        Corner {
            beside,
            angle: a.angle_between(b),
        }
    }
}

/// For each corner around `v` the first one of its group.
fn groups(corners: &[Corner], v: u32, contacts: &HashSet<[u32; 2]>) -> Vec<usize> {
    let mut group: Vec<usize> = (0..corners.len()).collect();
    let mut across: BTreeMap<u32, usize> = BTreeMap::new();
    for (i, corner) in corners.iter().enumerate() {
        for w in corner.beside {
            if contacts.contains(&[v.min(w), v.max(w)]) {
                continue;
            }
            let other = *across.entry(w).or_insert(i);
            let (a, b) = (group[i].min(group[other]), group[i].max(group[other]));
            // A vertex has few patches around it, so renaming all is quick.
            group.iter_mut().filter(|g| **g == b).for_each(|g| *g = a);
        }
    }
    group
}
