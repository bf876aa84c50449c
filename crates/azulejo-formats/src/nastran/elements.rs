//! Elements: what their cards hold, and the sides of them that radiate.

use super::card::BulkCard;
use crate::surface::boundary::CellKind;
use crate::surface::finite::FiniteShape;

/// The shape of the element of a card, if it has surfaces.
pub(super) fn shape_of(card: &BulkCard) -> Option<FiniteShape> {
    match &*card.name {
        b"CTRIA3" | b"CTRIAR" | b"CTRIA6" => Some(FiniteShape::Triangle),
        b"CQUAD4" | b"CQUADR" | b"CQUAD8" | b"CQUAD" => Some(FiniteShape::Quadrilateral),
        b"CTETRA" => Some(FiniteShape::Cell(CellKind::Tetrahedron)),
        b"CPYRAM" | b"CPYRA" => Some(FiniteShape::Cell(CellKind::Pyramid)),
        b"CPENTA" => Some(FiniteShape::Cell(CellKind::Prism)),
        b"CHEXA" => Some(FiniteShape::Cell(CellKind::Hexahedron)),
        _ => None,
    }
}

/// The corners of a side by its number on `CHBDYE`, counter-clockwise from outside; `None` for edges.
pub(super) fn side(shape: FiniteShape, side: u32) -> Option<&'static [usize]> {
    // Sides 2 to 5 of shells are edges, side 6 is the back.
    const TRIANGLE: [&[usize]; 6] = [&[0, 1, 2], &[], &[], &[], &[], &[2, 1, 0]];
    const QUADRILATERAL: [&[usize]; 6] = [&[0, 1, 2, 3], &[], &[], &[], &[], &[3, 2, 1, 0]];
    const TETRAHEDRON: [&[usize]; 4] = [&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]];
    const PRISM: [&[usize]; 5] = [
        &[2, 1, 0],
        &[0, 1, 4, 3],
        &[1, 2, 5, 4],
        &[2, 0, 3, 5],
        &[3, 4, 5],
    ];
    const HEXAHEDRON: [&[usize]; 6] = [
        &[3, 2, 1, 0],
        &[0, 1, 5, 4],
        &[1, 2, 6, 5],
        &[2, 3, 7, 6],
        &[3, 0, 4, 7],
        &[4, 5, 6, 7],
    ];
    let sides: &[&[usize]] = match shape {
        FiniteShape::Triangle => &TRIANGLE,
        FiniteShape::Quadrilateral => &QUADRILATERAL,
        FiniteShape::Cell(CellKind::Tetrahedron) => &TETRAHEDRON,
        FiniteShape::Cell(CellKind::Prism) => &PRISM,
        FiniteShape::Cell(CellKind::Hexahedron) => &HEXAHEDRON,
        // The manuals number no sides of pyramids.
        FiniteShape::Cell(CellKind::Pyramid) => &[],
    };
    let side = sides.get((side as usize).checked_sub(1)?).copied();
    side.filter(|corners| !corners.is_empty())
}

/// Whether a card of this name is an element that has no surface, or one that is not read.
pub(super) fn is_other_element(name: &[u8]) -> bool {
    const OTHERS: [&[u8]; 38] = [
        b"CAXIF2", b"CAXIF3", b"CAXIF4", b"CBAR", b"CBEAM", b"CBEAM3", b"CBEND", b"CBUSH",
        b"CBUSH1D", b"CDAMP1", b"CDAMP2", b"CDAMP3", b"CDAMP4", b"CELAS1", b"CELAS2", b"CELAS3",
        b"CELAS4", b"CFAST", b"CGAP", b"CHBDY", b"CONM1", b"CONM2", b"CONROD", b"CQUADX",
        b"CQUADX4", b"CQUADX8", b"CROD", b"CSEAM", b"CSHEAR", b"CTRAX3", b"CTRAX6", b"CTRIAX",
        b"CTRIAX6", b"CTUBE", b"CVISC", b"CWELD", b"CIHEX1", b"CIHEX2",
    ];
    OTHERS.contains(&name)
}

/// An element with a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct BulkElement {
    pub id: u32,
    pub shape: FiniteShape,
    /// 0 if the card does not say.
    pub property: u32,
    /// Numbers of its grid points.
    pub corners: [u32; 8],
    /// File and line.
    pub place: (u32, u32),
}

impl BulkElement {
    /// The numbers of the corners.
    pub fn corners(&self) -> &[u32] {
        &self.corners[..self.shape.corner_count()]
    }
}
