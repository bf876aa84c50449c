//! Validation of exact shapes.

use super::{Check, Invalid, ensure, ensure_material, inside, validate_mesh, validate_primitive};
use crate::{BicubicPatch, Curve, Exact, Figure, MaterialId, Mesh, PrimitiveKind, Prism, Solid};
use std::collections::HashSet;
use std::sync::Arc;

/// Largest nesting depth of set operations: their traversal recurses.
const DEEPEST: usize = 256;

/// Checks the exact shapes of one scene.
pub(super) struct Checker {
    materials: usize,
    /// Figures already validated: a page of text shares a few.
    good: HashSet<*const Figure>,
}

impl Checker {
    /// A checker for a scene with that many materials.
    pub fn new(materials: usize) -> Checker {
        Checker {
            materials,
            good: HashSet::new(),
        }
    }

    /// Checks one shape and its proxy mesh.
    pub fn validate(&mut self, exact: &Exact) -> Check {
        self.validate_all(&exact.solids, 0)?;
        match &exact.proxy {
            Some(proxy) => inside(|| "proxy".into(), self.validate_proxy(proxy, exact)),
            None => Ok(()),
        }
    }

    fn validate_proxy(&self, proxy: &Mesh, exact: &Exact) -> Check {
        validate_mesh(proxy, self.materials)?;
        let solids: HashSet<MaterialId> = exact.leaves().iter().map(|l| l.material()).collect();
        let strange = proxy.face_materials.iter().find(|m| !solids.contains(m));
        match strange {
            None => Ok(()),
            Some(m) => Err(Invalid {
                place: "mesh".into(),
                problem: format!("material {m} belongs to none of the solids"),
            }),
        }
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

    /// Checks one operand of a set operation.
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
        ensure_material(prism.material, self.materials, place)?;
        let map = prism.world_from_figure;
        let size = map.matrix3.determinant();
        ensure(
            map.is_finite() && size != 0.0 && size.is_finite() && map.inverse().is_finite(),
            place,
            || "its map is not invertible".into(),
        )?;
        let is_good = prism.bevel.as_ref().is_none_or(|b| b.is_valid());
        ensure(is_good, place, || {
            "its bevel is not within 0 to 1 of its depth, 1/2 at both ends, or has no finite inset"
                .into()
        })?;
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
    ensure_material(patch.material, materials, place)?;
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
    /// The open part of a solid, in words; `None` if it has an inside, as set operations require. A
    /// shell counts as closed: its pieces close it together.
    pub fn open_part(&self) -> Option<&'static str> {
        match self {
            Solid::Primitive(p) => match p.kind {
                PrimitiveKind::Square => Some("a parallelogram"),
                PrimitiveKind::Tube { .. } => Some("a tube"),
                _ => None,
            },
            Solid::Patch(_) => Some("a patch"),
            Solid::Mesh(m) if !m.is_closed() => {
                Some("a mesh with an edge that does not have two faces")
            }
            Solid::Mesh(_) | Solid::Prism(_) | Solid::Shell(_) | Solid::Csg(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        Contour, Csg, Curve, Exact, Figure, Material, Mesh, Object, Operation, Primitive,
        PrimitiveKind, Prism, Rgb, Scene, Shape, Solid,
    };
    use glam::{DAffine3, DVec2, DVec3};
    use std::sync::Arc;

    fn prism() -> Prism {
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y];
        Prism {
            figure: Arc::new(Figure::polygon(corners)),
            world_from_figure: DAffine3::IDENTITY,
            material: 0,
            bevel: None,
        }
    }

    fn primitive(kind: PrimitiveKind) -> Solid {
        Solid::Primitive(Primitive::new(kind, DAffine3::IDENTITY, 0))
    }

    fn triangle(material: u32) -> Mesh {
        let mut mesh = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2], material);
        mesh
    }

    fn csg(left: Vec<Solid>, right: Vec<Solid>) -> Solid {
        Solid::Csg(Box::new(Csg {
            operation: Operation::Union,
            left,
            right,
        }))
    }

    fn validate(exact: Exact) -> Result<(), String> {
        let mut scene = Scene::default();
        for name in ["a", "b"] {
            scene.add_material(Material::diffuse(name, Rgb::grey(0.5)));
        }
        scene.objects.push(Object::new("o", Shape::Exact(exact)));
        scene.validate().map_err(|invalid| invalid.to_string())
    }

    /// The invariant that one solid violates.
    fn check(solid: Solid, expected: &str) {
        let place = "objects[0] \"o\": solids[0]";
        let message = validate(Exact::new(vec![solid])).unwrap_err();
        assert_eq!(message, format!("{place}: {expected}"));
    }

    #[test]
    fn good_shapes_are_good() {
        let open = vec![
            primitive(PrimitiveKind::Tube { top: 1.0 }),
            Solid::Mesh(Box::new(triangle(1))),
        ];
        let sides = [Solid::Prism(prism()), Solid::Shell(open)];
        let [left, right] = sides.map(|s| vec![s]);
        let mut exact = Exact::new(vec![csg(left, right)]);
        exact.proxy = Some(Box::new(triangle(1)));
        assert_eq!(validate(exact), Ok(()));
        assert_eq!(validate(Exact::default()), Ok(()));
    }

    #[test]
    fn prisms() {
        let material = Prism {
            material: 2,
            ..prism()
        };
        check(Solid::Prism(material), "prism: material 2 of 2");
        let flat = Prism {
            world_from_figure: DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0)),
            ..prism()
        };
        check(Solid::Prism(flat), "prism: its map is not invertible");
        let start = DVec2::new(f64::NAN, 0.0);
        let contour = Contour {
            curves: vec![Curve::Line { start }],
        };
        let figure = Figure {
            contours: vec![contour],
            ..Figure::default()
        };
        let endless = Prism {
            figure: Arc::new(figure),
            ..prism()
        };
        check(Solid::Prism(endless), "prism: its figure is not finite");
    }

    #[test]
    fn a_figure_that_is_shared_is_refused_too() {
        let start = DVec2::new(f64::INFINITY, 0.0);
        let mut shared = prism();
        shared.figure = Arc::new(Figure::polygon([start]));
        let solids = vec![Solid::Prism(prism()), Solid::Prism(shared.clone())];
        let message = validate(Exact::new(solids)).unwrap_err();
        assert!(
            message.contains("solids[1]: prism: its figure"),
            "{message}"
        );
    }

    #[test]
    fn set_operations() {
        let ball = || vec![primitive(PrimitiveKind::Sphere)];
        check(
            csg(Vec::new(), ball()),
            "left: nothing on this side of a set operation",
        );
        let open = |solid: Solid, what: &str| {
            let expected = format!("right[0]: set operation: {what} is open: it has no inside");
            check(csg(ball(), vec![solid]), &expected);
        };
        open(primitive(PrimitiveKind::Square), "a parallelogram");
        open(primitive(PrimitiveKind::Tube { top: 0.5 }), "a tube");
        open(
            Solid::Mesh(Box::new(triangle(0))),
            "a mesh with an edge that does not have two faces",
        );
        let nested = |depth: usize| {
            let shell = |inner, _| Solid::Shell(vec![inner]);
            (0..depth).fold(primitive(PrimitiveKind::Sphere), shell)
        };
        assert_eq!(validate(Exact::new(vec![nested(256)])), Ok(()));
        let message = validate(Exact::new(vec![nested(257)])).unwrap_err();
        assert!(
            message.ends_with("solid: nested more than 256 deep"),
            "{message}"
        );
    }

    #[test]
    fn meshes_and_proxies() {
        let mut two = triangle(0);
        two.push_face(&[0, 2, 1], 1);
        check(
            Solid::Mesh(Box::new(two)),
            "mesh: several materials in a mesh that is a solid",
        );
        let with_proxy = |proxy: Mesh| {
            let mut exact = Exact::new(vec![Solid::Prism(prism())]);
            exact.proxy = Some(Box::new(proxy));
            validate(exact).unwrap_err()
        };
        assert_eq!(
            with_proxy(triangle(1)),
            "objects[0] \"o\": proxy: mesh: material 1 belongs to none of the solids"
        );
        let mut dark = triangle(0);
        dark.irradiance = vec![Rgb::WHITE];
        let message = with_proxy(dark);
        assert!(
            message.starts_with("objects[0] \"o\": proxy: mesh: "),
            "{message}"
        );
    }
}
