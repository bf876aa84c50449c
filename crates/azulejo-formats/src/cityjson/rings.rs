//! Surfaces as loops of vertices, with their holes joined to them.

use super::document::CityFile;
use crate::ReadError;
use crate::reading::json::Json;
use crate::surface::holes::join;
use glam::DVec3;

/// The rings of a surface: vertices of the outline and then of the holes.
pub(super) struct SurfaceRings {
    /// Numbers of vertices, all rings one after the other.
    pub vertices: Vec<u32>,
    /// Number of vertices of the outline.
    outline: usize,
    /// Number of vertices of each hole.
    holes: Vec<usize>,
    /// Number of holes with fewer than three different corners.
    pub empty_holes: usize,
}

impl SurfaceRings {
    /// Reads the rings of a surface, whose vertices are numbered below `count`.
    ///
    /// # Errors
    /// A vertex that does not exist.
    pub fn read(
        surface: Json<'_>,
        count: usize,
        file: CityFile<'_>,
    ) -> Result<SurfaceRings, ReadError> {
        let mut rings = SurfaceRings {
            vertices: Vec::new(),
            outline: 0,
            holes: Vec::new(),
            empty_holes: 0,
        };
        for (number, ring) in surface.elements().enumerate() {
            let start = rings.vertices.len();
            rings.ring(ring, count, file)?;
            let length = rings.vertices.len() - start;
            match number {
                0 => rings.outline = length,
                _ if length >= 3 => rings.holes.push(length),
                _ => {
                    rings.vertices.truncate(start);
                    rings.empty_holes += 1;
                }
            }
        }
        Ok(rings)
    }

    /// Appends a ring without vertices that follow themselves, and without the first one at its end.
    fn ring(&mut self, ring: Json<'_>, count: usize, file: CityFile<'_>) -> Result<(), ReadError> {
        let start = self.vertices.len();
        for corner in ring.elements() {
            let Some(vertex) = corner.index().filter(|&v| v < count) else {
                let expected = format!("the number of one of the {count} vertices");
                return Err(file.error(corner, &expected));
            };
            if self.vertices[start..].last() != Some(&(vertex as u32)) {
                self.vertices.push(vertex as u32);
            }
        }
        let ring = &self.vertices[start..];
        if ring.len() > 1 && ring.first() == ring.last() {
            self.vertices.pop();
        }
        Ok(())
    }

    /// Whether the outline has three corners.
    pub fn is_polygon(&self) -> bool {
        self.outline >= 3
    }

    /// How much work and memory the surface takes: each hole is compared with all corners that are
    /// joined so far.
    pub fn cost(&self) -> u64 {
        let corners = self.vertices.len() as u64;
        corners + corners * self.holes.len() as u64 / 8
    }

    /// One loop of vertices, given their positions, and the number of holes outside of the outline.
    pub fn joined(&self, position: impl Fn(u32) -> DVec3) -> (Vec<u32>, usize) {
        if self.holes.is_empty() {
            return (self.vertices[..self.outline].to_vec(), 0);
        }
        let points: Vec<DVec3> = self.vertices.iter().map(|&v| position(v)).collect();
        let (order, left_out) = join(&points, self.outline, &self.holes);
        let vertices = order.iter().map(|&k| self.vertices[k]);
        (vertices.collect(), left_out)
    }
}
