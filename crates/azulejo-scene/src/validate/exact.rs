//! The promises of exact shapes.

use super::{Check, Invalid, ensure, validate_mesh, validate_primitive};
use crate::{BicubicPatch, Curve, Exact, Figure, MaterialId, Mesh, PrimitiveKind, Prism, Solid};
use std::collections::HashSet;
use std::sync::Arc;

/// Set operations nest no deeper: what walks them recurses.
const DEEPEST: usize = 256;

/// Checks the exact shapes of one scene.
pub(super) struct Checker {
    materials: usize,
    /// Figures that were found good: a page of text shares a few.
    good: HashSet<*const Figure>,
}

/// `check`, its place one level deeper.
fn inside(level: impl FnOnce() -> String, check: Check) -> Check {
    check.map_err(|e| Invalid {
        place: format!("{}: {}", level(), e.place),
        ..e
    })
}

impl Checker {
    /// For a scene of so many materials.
    pub fn new(materials: usize) -> Checker {
        Checker {
            materials,
            good: HashSet::new(),
        }
    }

    /// Checks one shape and its skin.
    pub fn validate(&mut self, exact: &Exact) -> Check {
        self.validate_all(&exact.solids, 0)?;
        match &exact.skin {
            Some(skin) => inside(|| "skin".into(), self.validate_skin(skin, exact)),
            None => Ok(()),
        }
    }

    fn validate_skin(&self, skin: &Mesh, exact: &Exact) -> Check {
        validate_mesh(skin, self.materials)?;
        let solids: HashSet<MaterialId> = exact.leaves().iter().map(|l| l.material()).collect();
        let strange = skin.face_materials.iter().find(|m| !solids.contains(m));
        ensure(
            strange.is_none(),
            || "mesh".into(),
            || format!("material {strange:?} is that of none of the solids"),
        )
    }

    fn validate_all(&mut self, solids: &[Solid], depth: usize) -> Check {
        for (i, solid) in solids.iter().enumerate() {
            inside(|| format!("solids[{i}]"), self.validate_solid(solid, depth))?;
        }
        Ok(())
    }

    fn validate_solid(&mut self, solid: &Solid, depth: usize) -> Check {
        if let Solid::Shell(_) | Solid::Csg(_) = solid {
            ensure(
                depth < DEEPEST,
                || "solid".into(),
                || format!("nested more than {DEEPEST} deep"),
            )?;
        }
        match solid {
            Solid::Primitive(p) => validate_primitive(p, self.materials),
            Solid::Prism(p) => self.validate_prism(p),
            Solid::Patch(p) => validate_patch(p, self.materials),
            Solid::Mesh(m) => self.validate_mesh(m),
            Solid::Shell(pieces) => inside(|| "shell".into(), self.validate_all(pieces, depth + 1)),
            Solid::Csg(csg) => {
                self.validate_side("left", &csg.left, depth)?;
                self.validate_side("right", &csg.right, depth)
            }
        }
    }

    /// One side of a set operation.
    fn validate_side(&mut self, side: &str, solids: &[Solid], depth: usize) -> Check {
        ensure(
            !solids.is_empty(),
            || side.into(),
            || "nothing on this side of a set operation".into(),
        )?;
        inside(|| side.into(), self.validate_all(solids, depth + 1))?;
        for (i, solid) in solids.iter().enumerate() {
            inside(|| format!("{side}[{i}]"), validate_closed(solid))?;
        }
        Ok(())
    }

    fn validate_mesh(&self, mesh: &Mesh) -> Check {
        validate_mesh(mesh, self.materials)?;
        let is_one = mesh.face_materials.windows(2).all(|w| w[0] == w[1]);
        ensure(
            is_one,
            || "mesh".into(),
            || "several materials in a mesh that is a solid".into(),
        )
    }

    fn validate_prism(&mut self, prism: &Prism) -> Check {
        let place = || "prism".to_string();
        let materials = self.materials;
        ensure((prism.material as usize) < materials, place, || {
            format!("material {} of {materials}", prism.material)
        })?;
        let map = prism.world_from_figure;
        let size = map.matrix3.determinant();
        ensure(
            map.is_finite() && size != 0.0 && size.is_finite() && map.inverse().is_finite(),
            place,
            || "its map is not invertible".into(),
        )?;
        if !self.good.insert(Arc::as_ptr(&prism.figure)) {
            return Ok(());
        }
        let mut curves = prism.figure.contours.iter().flat_map(|c| &c.curves);
        ensure(curves.all(is_finite), place, || {
            "its figure is not finite".into()
        })
    }
}

fn is_finite(curve: &Curve) -> bool {
    match curve {
        Curve::Line { start } => start.is_finite(),
        Curve::Cubic {
            start,
            control1,
            control2,
        } => start.is_finite() && control1.is_finite() && control2.is_finite(),
    }
}

fn validate_patch(patch: &BicubicPatch, materials: usize) -> Check {
    let place = || "patch".to_string();
    ensure((patch.material as usize) < materials, place, || {
        format!("material {} of {materials}", patch.material)
    })?;
    let finite = patch.points.iter().flatten().all(|p| p.is_finite());
    ensure(finite, place, || "a control point is not finite".into())
}

/// Whether a solid has an inside.
fn validate_closed(solid: &Solid) -> Check {
    match solid.open_part() {
        None => Ok(()),
        Some(what) => Err(Invalid {
            place: "set operation".into(),
            problem: format!("{what} is open: it has no inside"),
        }),
    }
}

impl Solid {
    /// What is open in a solid, in words; `None` for one that has an inside, as set operations
    /// demand. A shell counts as closed: its pieces close it together.
    pub fn open_part(&self) -> Option<&'static str> {
        match self {
            Solid::Primitive(p) => match p.kind {
                PrimitiveKind::Square => Some("a parallelogram"),
                PrimitiveKind::Tube { .. } => Some("a tube"),
                _ => None,
            },
            Solid::Patch(_) => Some("a patch"),
            Solid::Mesh(m) if !m.is_closed() => Some("a mesh with an edge that has not two faces"),
            Solid::Mesh(_) | Solid::Prism(_) | Solid::Shell(_) | Solid::Csg(_) => None,
        }
    }
}
