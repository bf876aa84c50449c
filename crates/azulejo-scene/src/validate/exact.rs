//! The promises of exact shapes.

use super::{Check, Invalid, ensure, validate_mesh, validate_primitive};
use crate::{BicubicPatch, Curve, Exact, PrimitiveKind, Prism, Solid};

/// Set operations nest no deeper: what walks them recurses.
pub(super) const DEEPEST: usize = 256;

pub(super) fn validate(exact: &Exact, materials: usize) -> Check {
    validate_all(&exact.solids, materials, 0)?;
    match &exact.skin {
        Some(skin) => inside("skin", validate_mesh(skin, materials)),
        None => Ok(()),
    }
}

/// `check`, its place one level deeper.
fn inside(level: &str, check: Check) -> Check {
    check.map_err(|e| Invalid {
        place: format!("{level}: {}", e.place),
        ..e
    })
}

fn validate_all(solids: &[Solid], materials: usize, depth: usize) -> Check {
    for (i, solid) in solids.iter().enumerate() {
        let level = format!("solids[{i}]");
        inside(&level, validate_solid(solid, materials, depth))?;
    }
    Ok(())
}

fn validate_solid(solid: &Solid, materials: usize, depth: usize) -> Check {
    let nested = || {
        ensure(
            depth < DEEPEST,
            || "solid".into(),
            || format!("nested more than {DEEPEST} deep"),
        )
    };
    match solid {
        Solid::Primitive(p) => validate_primitive(p, materials),
        Solid::Prism(p) => validate_prism(p, materials),
        Solid::Patch(p) => validate_patch(p, materials),
        Solid::Mesh(m) => {
            validate_mesh(m, materials)?;
            let one = m.face_materials.windows(2).all(|w| w[0] == w[1]);
            ensure(
                one,
                || "mesh".into(),
                || "several materials in a mesh that is a solid".into(),
            )
        }
        Solid::Shell(pieces) => {
            nested()?;
            inside("shell", validate_all(pieces, materials, depth + 1))
        }
        Solid::Csg(csg) => {
            nested()?;
            for (side, solids) in [("left", &csg.left), ("right", &csg.right)] {
                ensure(
                    !solids.is_empty(),
                    || side.into(),
                    || "nothing on this side of a set operation".into(),
                )?;
                inside(side, validate_all(solids, materials, depth + 1))?;
                for (i, solid) in solids.iter().enumerate() {
                    inside(&format!("{side}[{i}]"), validate_closed(solid))?;
                }
            }
            Ok(())
        }
    }
}

fn validate_prism(prism: &Prism, materials: usize) -> Check {
    let place = || "prism".to_string();
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
    let is_finite = |c: &Curve| match c {
        Curve::Line { start } => start.is_finite(),
        Curve::Cubic {
            start,
            control1,
            control2,
        } => start.is_finite() && control1.is_finite() && control2.is_finite(),
    };
    let contours = &prism.figure.contours;
    let finite = contours.iter().all(|c| c.curves.iter().all(is_finite));
    ensure(finite, place, || "its figure is not finite".into())
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
    let (closed, what) = match solid {
        Solid::Primitive(p) => (
            !matches!(p.kind, PrimitiveKind::Square | PrimitiveKind::Tube { .. }),
            "a parallelogram or tube",
        ),
        Solid::Patch(_) => (false, "a patch"),
        Solid::Mesh(m) => (m.is_closed(), "a mesh with an edge that has not two faces"),
        Solid::Prism(_) | Solid::Shell(_) | Solid::Csg(_) => (true, ""),
    };
    ensure(
        closed,
        || "set operation".into(),
        || format!("{what} is open: it has no inside"),
    )
}
