//! DXF: faces and bounding box from ezdxf, with blocks expanded.

use super::Quantity::{Bounds, Faces, Triangles};
use super::{Exception, Expected, Rules};

const EXTRUDED: &str = "30 polylines with thickness, 15 of them with width too, are surfaces; \
                        the plain counts know only faces and meshes";

pub const RULES: Rules = Rules {
    folders: &["dxf/"],
    compared: &[
        (Faces, &["raw_faces"]),
        (Triangles, &["second_triangles"]),
        (Bounds, &["second"]),
    ],
    allowed: &[],
    exceptions: &[
        Exception {
            path: "dxf/ezdxf/POLI-ALL210_12.DXF",
            quantity: Faces,
            expected: Expected::Count(1029),
            why: EXTRUDED,
        },
        Exception {
            path: "dxf/ezdxf/POLI-ALL210_12.DXF",
            quantity: Triangles,
            expected: Expected::Count(2058),
            why: EXTRUDED,
        },
        Exception {
            path: "dxf/ezdxf/POLI-ALL210_12.DXF",
            quantity: Bounds,
            expected: Expected::Box([-6.0, -11.0, 0.0], [18.0, 13.0, 6.009_002_686_417_368]),
            why: EXTRUDED,
        },
    ],
};
