//! A plane figure, extruded.

use crate::figure::Rectangle;
use crate::math::Aabb;
use crate::rim::Rim;
use crate::{Bevel, Figure, MaterialId};
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// All points that lie over a figure, between its plane and a parallel one: a letter in space.
///
/// Kajiya, *New Techniques for Ray Tracing Procedurally Defined Objects* (1983), section 3, for
/// any direction of extrusion. Closed: sides, front and back.
#[derive(Clone, Debug, PartialEq)]
pub struct Prism {
    /// The outline; prisms of one outline share it.
    pub figure: Arc<Figure>,
    /// The figure lies in the plane z = 0, the prism reaches to z = 1. Invertible; a skewed map
    /// extrudes obliquely, and a map that mirrors leaves the outside the front.
    pub world_from_figure: DAffine3,
    /// Its one material.
    pub material: MaterialId,
    /// How its edges are cut off or rounded, if they are; the letters of a text share it.
    pub bevel: Option<Arc<Bevel>>,
}

impl Prism {
    /// The smallest upright box around the figure's rectangle, extruded.
    pub fn bounds(&self) -> Aabb {
        self.bounds_over(self.figure.bounds())
    }

    /// [`bounds`](Prism::bounds) for callers that already know the rectangle around the figure.
    pub fn bounds_over(&self, b: Rectangle) -> Aabb {
        if b.min.x > b.max.x {
            return Aabb::EMPTY;
        }
        let corner = |k: u32| {
            let x = if k & 1 == 0 { b.min.x } else { b.max.x };
            let y = if k & 2 == 0 { b.min.y } else { b.max.y };
            let z = f64::from(k >> 2);
            self.world_from_figure.transform_point3(DVec3::new(x, y, z))
        };
        Aabb::around((0..8).map(corner))
    }

    /// Whether a world point is inside, or on the surface to rounding.
    ///
    /// With a bevel the border of the figure is prepared again for each point.
    pub fn contains(&self, point: DVec3) -> bool {
        let p = self.world_from_figure.inverse().transform_point3(point);
        let is_over = (0.0..=1.0).contains(&p.z) && self.figure.contains(p.truncate());
        is_over && !self.is_cut_off(p)
    }

    /// Whether the bevel removes a point of figure space that is inside the prism without it.
    fn is_cut_off(&self, p: DVec3) -> bool {
        let Some(bevel) = &self.bevel else {
            return false;
        };
        let setback = bevel.setback(p.z);
        let rim = (setback > 0.0).then(|| Rim::new(&self.figure));
        let nearest = rim.and_then(|rim| rim.nearest(p.truncate(), setback));
        nearest.is_some_and(|at| at.distance < setback)
    }
}
