//! Planar outlines to extrude.

use super::EditError;
use azulejo::fonts::Fonts;
use azulejo::formats::{ReadOptions, Warning, read_drawing};
use azulejo::scene::{Exact, Figure, MaterialId, Prism, Shape, Solid};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use std::f64::consts::TAU;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Number of sides of a regular prism; with more it looks like a cylinder.
pub const SIDES: RangeInclusive<u32> = 3..=64;

/// An outline and the height of its extrusion.
#[derive(Clone, Debug, PartialEq)]
pub struct PrismOutline {
    name: String,
    figures: Vec<Arc<Figure>>,
    /// Centre of the bounding box of all contours, and its larger side, in their own units.
    middle: DVec2,
    span: f64,
    height: f64,
}

impl PrismOutline {
    /// A regular polygon with one side facing the viewer. `height` is relative to the larger side.
    ///
    /// # Errors
    ///
    /// The number of sides is outside [`SIDES`], or the height is not positive.
    pub fn regular(sides: u32, height: f64) -> Result<PrismOutline, EditError> {
        if !SIDES.contains(&sides) {
            let (least, most) = (SIDES.start(), SIDES.end());
            let message = format!("a prism of {sides} sides, expected {least} to {most}");
            return Err(EditError(message));
        }
        let step = TAU / f64::from(sides);
        let corner = |k: u32| DVec2::from_angle((f64::from(k) + 0.5) * step - 0.25 * TAU);
        let figure = Figure::polygon((0..sides).map(corner));
        PrismOutline::of("prism".into(), vec![figure], height)
    }

    /// The filled contours of an SVG, DXF or PDF drawing, and warnings. `name` is the file name used in
    /// messages.
    ///
    /// # Errors
    ///
    /// The drawing cannot be read or has no filled contours, or the height is not positive.
    pub fn drawing(
        bytes: &[u8],
        name: &str,
        height: f64,
    ) -> Result<(PrismOutline, Vec<Warning>), EditError> {
        let drawing = read_drawing(bytes, name, &Fonts::default(), &ReadOptions::default());
        let drawing = drawing.map_err(|e| EditError(e.to_string()))?;
        let figures = drawing.shapes.into_iter().map(|shape| shape.figure);
        let stem = std::path::Path::new(name).file_stem().unwrap_or_default();
        let stem = stem.to_string_lossy().into_owned();
        let outline = PrismOutline::of(stem, figures.collect(), height)?;
        Ok((outline, drawing.warnings))
    }

    fn of(name: String, figures: Vec<Figure>, height: f64) -> Result<PrismOutline, EditError> {
        if !(height > 0.0 && height.is_finite()) {
            let message = format!("a prism {height} high, expected more than 0");
            return Err(EditError(message));
        }
        let corners = figures.iter().map(Figure::bounds);
        let corners = corners.map(|around| (around.min, around.max));
        let around = corners.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let (min, max) = around.unwrap_or((DVec2::ZERO, DVec2::ZERO));
        let span = (max - min).max_element();
        if !(span > 0.0 && span.is_finite()) {
            return Err(EditError(format!("{name}: no closed outlines to extrude")));
        }
        Ok(PrismOutline {
            name,
            figures: figures.into_iter().map(Arc::new).collect(),
            middle: 0.5 * (min + max),
            span,
            height,
        })
    }

    /// Base of the name of the new object.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Exact prisms whose larger side is `size`, on the ground at `at`; `standing` maps z to the
    /// world's up axis.
    pub(super) fn prisms(
        &self,
        size: f64,
        at: DVec3,
        standing: DMat3,
        material: MaterialId,
    ) -> Shape {
        let scale = size / self.span;
        let grown = DMat3::from_diagonal(DVec3::new(scale, scale, size * self.height));
        let world_from_figure = DAffine3 {
            matrix3: standing * grown,
            translation: at - standing * (scale * self.middle.extend(0.0)),
        };
        let prism = |figure: &Arc<Figure>| {
            Solid::Prism(Prism {
                figure: Arc::clone(figure),
                world_from_figure,
                material,
                bevel: None,
            })
        };
        Shape::Exact(Exact::new(self.figures.iter().map(prism).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::{Edit, NewShape, NewShapeKind, SceneDocument};

    const DRAWING: &[u8] = br#"<svg xmlns="http://www.w3.org/2000/svg" width="4" height="2">
        <rect x="0" y="0" width="1" height="2"/><circle cx="3" cy="1" r="1"/></svg>"#;

    /// Bounding box of the prism made from an outline with the centre of its base at (1, 2, 3).
    fn added(outline: PrismOutline, size: f64) -> (DVec3, DVec3) {
        let mut document = SceneDocument::default();
        let new = NewShape {
            kind: NewShapeKind::Prism(outline),
            at: DVec3::new(1.0, 2.0, 3.0),
            size,
            material: None,
        };
        Edit::AddShape(new).apply(&mut document).unwrap();
        document.scene().validate().unwrap();
        let bounds = document.bounds(None);
        (bounds.min, bounds.max)
    }

    fn check(found: (DVec3, DVec3), min: [f64; 3], max: [f64; 3]) {
        let (a, b) = (DVec3::from(min), DVec3::from(max));
        assert!((found.0 - a).length() < 1e-9, "{found:?}, expected {a}");
        assert!((found.1 - b).length() < 1e-9, "{found:?}, expected {b}");
    }

    #[test]
    fn a_prism_stands_on_the_ground_and_is_as_large_as_was_said() {
        let cube = PrismOutline::regular(4, 0.5).unwrap();
        check(added(cube, 2.0), [0.0, 2.0, 2.0], [2.0, 3.0, 4.0]);
        // A hexagon is wider across its corners than across its sides.
        let low = 3f64.sqrt() / 2.0;
        let nut = PrismOutline::regular(6, 1.0).unwrap();
        check(
            added(nut, 2.0),
            [0.0, 2.0, 3.0 - low],
            [2.0, 4.0, 3.0 + low],
        );
    }

    #[test]
    fn the_figures_of_a_drawing_keep_their_places() {
        let (outline, warnings) = PrismOutline::drawing(DRAWING, "/tmp/logo.svg", 0.25).unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!(outline.name(), "logo");
        assert_eq!(outline.figures.len(), 2);
        check(added(outline, 8.0), [-3.0, 2.0, 1.0], [5.0, 4.0, 5.0]);
    }

    #[test]
    fn what_makes_no_prism_is_refused() {
        for sides in [0, 2, 65] {
            let message = PrismOutline::regular(sides, 1.0).unwrap_err().to_string();
            assert!(message.contains("expected 3 to 64"), "{message}");
        }
        for height in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(PrismOutline::regular(5, height).is_err(), "{height}");
        }
        let none = br#"<svg xmlns="http://www.w3.org/2000/svg" width="4" height="2"/>"#;
        for bytes in [&none[..], b"no drawing"] {
            let message = PrismOutline::drawing(bytes, "x.svg", 1.0).unwrap_err();
            assert!(message.to_string().contains('x'), "{message}");
        }
    }
}
