//! Types of elements, and their faces.

use crate::surface::boundary::CellKind;
use crate::surface::finite::FiniteShape;

/// A type of elements with surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ElementType {
    pub shape: FiniteShape,
    /// Nodes of an element, those between the corners included.
    pub nodes: usize,
    /// What its surfaces are.
    pub domain: ElementDomain,
}

/// What the surfaces of an element are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ElementDomain {
    /// Its sides or faces.
    Space,
    /// The sheet that it is in its plane; its numbered faces are edges.
    Plane,
    /// What its edges, which are its numbered faces, sweep around the axis y: a section of a body of revolution.
    Meridian,
}

impl ElementType {
    /// By the name of the type in capitals: shells, membranes, rigid faces and plane elements, and solids.
    pub fn named(name: &str) -> Option<ElementType> {
        // Solids with other properties have other letters before and behind: DC3D8, C3D20R, C3D10MH.
        let solid = name.find("C3D").map(|at| &name[at + 3..]);
        let solid = solid.or_else(|| name.strip_prefix("F3D"));
        let continuum = (name.strip_prefix("SC")).or_else(|| name.strip_prefix("CSS"));
        if let Some(rest) = solid.or(continuum) {
            let nodes = leading_number(rest)?;
            let kind = match nodes {
                4 | 10 => CellKind::Tetrahedron,
                5 | 13 => CellKind::Pyramid,
                6 | 15 => CellKind::Prism,
                8 | 20 => CellKind::Hexahedron,
                _ => return None,
            };
            // C3D15V has more nodes than its name says.
            let is_plain = !rest.ends_with('V');
            return is_plain.then_some(ElementType {
                shape: FiniteShape::Cell(kind),
                nodes,
                domain: ElementDomain::Space,
            });
        }
        if name.starts_with("STRI65") {
            return ElementType::sheet(6, ElementDomain::Space);
        }
        // Plane elements are sheets in their plane; gmsh and meshio write those in space, too.
        const PLANES: [&str; 6] = ["CPS", "CPEG", "CPE", "CAX", "DC2D", "DCAX"];
        const SHELLS: [&str; 6] = ["STRI", "SFM3D", "M3D", "R3D", "DS", "S"];
        let behind = |prefixes: &[&str]| prefixes.iter().find_map(|p| name.strip_prefix(p));
        let (rest, domain) = match behind(&PLANES) {
            Some(rest) => (rest, ElementDomain::Plane),
            None => (behind(&SHELLS)?, ElementDomain::Space),
        };
        ElementType::sheet(leading_number(rest)?, domain)
    }

    fn sheet(nodes: usize, domain: ElementDomain) -> Option<ElementType> {
        let shape = match nodes {
            3 | 6 => FiniteShape::Triangle,
            4 | 8 | 9 => FiniteShape::Quadrilateral,
            _ => return None,
        };
        Some(ElementType {
            shape,
            nodes,
            domain,
        })
    }

    /// The solid that a section of a body of revolution sweeps in a sector, from its corners at one end to those at the
    /// other.
    pub fn swept(self) -> Option<FiniteShape> {
        if self.domain != ElementDomain::Meridian {
            return None;
        }
        match self.shape {
            FiniteShape::Triangle => Some(FiniteShape::Cell(CellKind::Prism)),
            FiniteShape::Quadrilateral => Some(FiniteShape::Cell(CellKind::Hexahedron)),
            FiniteShape::Cell(_) => None,
        }
    }

    /// Whether it has an inside.
    pub fn is_solid(self) -> bool {
        matches!(self.swept().unwrap_or(self.shape), FiniteShape::Cell(_))
    }

    /// The corners of a numbered face of a solid, or of what a section sweeps, counter-clockwise from outside.
    pub fn solid_face(self, number: u8) -> Option<&'static [usize]> {
        match (self.swept(), self.shape) {
            // Before what its edges sweep come the two ends.
            (Some(FiniteShape::Cell(kind)), _) => solid_face(kind, number + 2),
            (None, FiniteShape::Cell(kind)) => solid_face(kind, number),
            _ => None,
        }
    }
}

/// The number that a text begins with.
fn leading_number(text: &str) -> Option<usize> {
    let end = text.find(|c: char| !c.is_ascii_digit());
    text[..end.unwrap_or(text.len())].parse().ok()
}

/// A face of an element, as surfaces name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum ElementFace {
    /// All that no other element shares, or the front of a shell.
    Free,
    /// Of a solid, from 1.
    Number(u8),
    /// The front of a shell.
    Front,
    /// The back of a shell.
    Back,
}

impl ElementFace {
    /// By its name.
    pub fn named(name: &[u8]) -> Option<ElementFace> {
        match name.to_ascii_uppercase().as_slice() {
            b"" => Some(ElementFace::Free),
            b"SPOS" | b"POS" => Some(ElementFace::Front),
            b"SNEG" | b"NEG" => Some(ElementFace::Back),
            [b'S', digit @ b'1'..=b'6'] => Some(ElementFace::Number(digit - b'0')),
            _ => None,
        }
    }

    /// The face of an element of this type; CalculiX numbers the sides of shells, too, the back first.
    pub fn of(self, kind: ElementType) -> Option<ElementFace> {
        match (kind.is_solid(), self) {
            (_, ElementFace::Number(_)) if kind.domain == ElementDomain::Plane => None,
            (true, ElementFace::Number(_) | ElementFace::Free) => Some(self),
            (true, _) => None,
            (_, ElementFace::Number(1) | ElementFace::Back) => Some(ElementFace::Back),
            (_, ElementFace::Number(2) | ElementFace::Free | ElementFace::Front) => {
                Some(ElementFace::Front)
            }
            (_, ElementFace::Number(_)) => None,
        }
    }
}

/// The corners of a face of a solid by its number, counter-clockwise from outside. The manuals list them from
/// inside.
fn solid_face(kind: CellKind, number: u8) -> Option<&'static [usize]> {
    let faces: &[&[usize]] = match kind {
        CellKind::Tetrahedron => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
        CellKind::Pyramid => &[
            &[0, 3, 2, 1],
            &[0, 1, 4],
            &[1, 2, 4],
            &[2, 3, 4],
            &[3, 0, 4],
        ],
        CellKind::Prism => &[
            &[0, 2, 1],
            &[3, 4, 5],
            &[0, 1, 4, 3],
            &[1, 2, 5, 4],
            &[2, 0, 3, 5],
        ],
        CellKind::Hexahedron => &[
            &[0, 3, 2, 1],
            &[4, 5, 6, 7],
            &[0, 1, 5, 4],
            &[1, 2, 6, 5],
            &[2, 3, 7, 6],
            &[3, 0, 4, 7],
        ],
    };
    faces.get(usize::from(number).checked_sub(1)?).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_by_their_names() {
        use CellKind::*;
        let check = |name: &str, shape: FiniteShape, nodes: usize| {
            let element = ElementType::named(name).unwrap();
            assert_eq!((element.shape, element.nodes), (shape, nodes), "{name}");
            let is_plane = ["CP", "CA", "DC2", "DCA"]
                .iter()
                .any(|p| name.starts_with(p));
            assert_eq!(element.domain == ElementDomain::Plane, is_plane, "{name}");
        };
        for name in [
            "S3", "S3R", "S3RS", "STRI3", "DS3", "R3D3", "M3D3", "SFM3D3",
        ] {
            check(name, FiniteShape::Triangle, 3);
        }
        for name in [
            "S4", "S4R", "S4R5", "S4RSW", "DS4", "R3D4", "M3D4R", "SFM3D4R",
        ] {
            check(name, FiniteShape::Quadrilateral, 4);
        }
        for name in ["CPS4", "CPE4R", "CPEG4", "CAX4P", "DC2D4", "DCAX4"] {
            check(name, FiniteShape::Quadrilateral, 4);
        }
        check("STRI65", FiniteShape::Triangle, 6);
        check("S6", FiniteShape::Triangle, 6);
        check("S8R5", FiniteShape::Quadrilateral, 8);
        check("S9R5", FiniteShape::Quadrilateral, 9);
        check("C3D10MH", FiniteShape::Cell(Tetrahedron), 10);
        check("DC3D4", FiniteShape::Cell(Tetrahedron), 4);
        check("C3D15", FiniteShape::Cell(Prism), 15);
        check("DCC3D8D", FiniteShape::Cell(Hexahedron), 8);
        check("F3D6", FiniteShape::Cell(Prism), 6);
        check("SC8R", FiniteShape::Cell(Hexahedron), 8);
        check("C3D5", FiniteShape::Cell(Pyramid), 5);
        for name in [
            "B31", "T3D2", "SAX1", "SPRINGA", "CPE5", "MASS", "C3D27", "C3D15V", "S", "RB3D2",
        ] {
            assert_eq!(ElementType::named(name), None, "{name}");
        }
    }
}
