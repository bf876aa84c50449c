//! The element types of gmsh, which are numbers.

use crate::surface::boundary::CellKind;

/// What an element is, whatever its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MshShape {
    /// A point or a line, which has no area.
    Line,
    /// A polygon with this number of corners.
    Polygon(usize),
    /// A volume.
    Cell(CellKind),
}

impl MshShape {
    /// Number of corners, which are the first nodes of an element.
    pub fn corner_count(self) -> usize {
        match self {
            MshShape::Line => 0,
            MshShape::Polygon(corners) => corners,
            MshShape::Cell(kind) => kind.corner_count(),
        }
    }
}

/// The shape and the number of nodes of a type; `None` if it is unknown or of no fixed number.
pub(super) fn element_type(number: i64) -> Option<(MshShape, usize)> {
    let shapes = [
        (MshShape::Line, LINES),
        (MshShape::Polygon(3), TRIANGLES),
        (MshShape::Polygon(4), QUADRILATERALS),
        (MshShape::Cell(CellKind::Tetrahedron), TETRAHEDRA),
        (MshShape::Cell(CellKind::Hexahedron), HEXAHEDRA),
        (MshShape::Cell(CellKind::Prism), PRISMS),
        (MshShape::Cell(CellKind::Pyramid), PYRAMIDS),
    ];
    let nodes = |types: &[(i64, usize)]| types.iter().find(|t| t.0 == number).map(|t| t.1);
    let mut shapes = shapes.into_iter();
    shapes.find_map(|(shape, types)| Some((shape, nodes(types)?)))
}

/// Types and their numbers of nodes, by shape and then by order.
type TypeTable = &'static [(i64, usize)];

const LINES: TypeTable = &[
    (15, 1),
    (1, 2),
    (8, 3),
    (26, 4),
    (27, 5),
    (28, 6),
    (62, 7),
    (63, 8),
    (64, 9),
    (65, 10),
    (66, 11),
];

const TRIANGLES: TypeTable = &[
    (2, 3),
    (9, 6),
    (20, 9),
    (21, 10),
    (22, 12),
    (23, 15),
    (24, 15),
    (25, 21),
    (42, 28),
    (43, 36),
    (44, 45),
    (45, 55),
    (46, 66),
    (52, 18),
    (53, 21),
    (54, 24),
    (55, 27),
    (56, 30),
];

const QUADRILATERALS: TypeTable = &[
    (3, 4),
    (10, 9),
    (16, 8),
    (36, 16),
    (37, 25),
    (38, 36),
    (39, 12),
    (40, 16),
    (41, 20),
    (47, 49),
    (48, 64),
    (49, 81),
    (50, 100),
    (51, 121),
    (57, 24),
    (58, 28),
    (59, 32),
    (60, 36),
    (61, 40),
];

const TETRAHEDRA: TypeTable = &[
    (4, 4),
    (11, 10),
    (29, 20),
    (30, 35),
    (31, 56),
    (32, 22),
    (33, 28),
    (71, 84),
    (72, 120),
    (73, 165),
    (74, 220),
    (75, 286),
    (79, 34),
    (80, 40),
    (81, 46),
    (82, 52),
    (83, 58),
    (137, 16),
];

const HEXAHEDRA: TypeTable = &[
    (5, 8),
    (12, 27),
    (17, 20),
    (92, 64),
    (93, 125),
    (94, 216),
    (95, 343),
    (96, 512),
    (97, 729),
    (98, 1000),
    (99, 32),
    (100, 44),
    (101, 56),
    (102, 68),
    (103, 80),
    (104, 92),
    (105, 104),
];

const PRISMS: TypeTable = &[(6, 6), (13, 18), (18, 15), (90, 40), (91, 75)];

const PYRAMIDS: TypeTable = &[
    (7, 5),
    (14, 14),
    (19, 13),
    (118, 30),
    (119, 55),
    (120, 91),
    (121, 140),
    (122, 204),
    (123, 285),
    (124, 385),
    (125, 21),
    (126, 29),
    (127, 37),
    (128, 45),
    (129, 53),
    (130, 61),
    (131, 69),
];
