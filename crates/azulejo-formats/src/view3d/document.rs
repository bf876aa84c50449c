//! The content of a file, record by record.

use glam::DVec3;

/// A file for View3D, record by record.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View3dDocument {
    /// The last title.
    pub title: String,
    /// The parameters on the control lines.
    pub controls: View3dControls,
    /// The vertices of an F 3 file; vertex n is the n-th.
    pub vertices: Vec<DVec3>,
    /// All surfaces; surface n is the n-th.
    pub surfaces: Vec<View3dSurface>,
}

/// Control parameters, with View3D's defaults for those that are not given.
#[derive(Clone, Debug, PartialEq)]
pub struct View3dControls {
    /// Convergence limit of the integration.
    pub eps: f64,
    /// The single row to compute, from 1; 0 for all.
    pub row: u32,
    /// The single column, from 1, if a row is given; 0 for all.
    pub column: u32,
    /// Whether the surfaces are an enclosure, so that rows are normalized to sum to 1.
    pub encl: bool,
    /// Whether to compute grey interchange factors instead of view factors.
    pub emit: bool,
    /// The output format of the matrix.
    pub out: MatrixLayout,
    /// Parameters of View3D's own method given in the file, by name, with their values.
    pub others: Vec<(&'static str, i16)>,
}

impl Default for View3dControls {
    fn default() -> View3dControls {
        View3dControls {
            eps: 1e-4,
            row: 0,
            column: 0,
            encl: false,
            emit: false,
            out: MatrixLayout::Text,
            others: Vec::new(),
        }
    }
}

/// View3D's matrix formats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MatrixLayout {
    /// `out=0`: decimal numbers.
    #[default]
    Text,
    /// `out=1`: 32-bit numbers.
    Binary,
}

/// The role of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceKind {
    /// S: radiates from its front.
    Radiating,
    /// M: covers a part of its base, and faces it.
    Mask,
    /// N: removes a part of its base.
    Null,
    /// O: only blocks.
    Obstruction,
}

/// A surface, a polygon of three or four corners.
#[derive(Clone, Debug, PartialEq)]
pub struct View3dSurface {
    /// Its role.
    pub kind: SurfaceKind,
    /// Its polygon.
    pub outline: SurfaceOutline,
    /// The surface that contains it, from 1; 0 for none.
    pub base: u32,
    /// The surface that it is combined with, from 1; 0 for none.
    pub combined: u32,
    /// Emissivity, 0.001..=0.999.
    pub emissivity: f64,
    /// One word; may be empty.
    pub name: String,
    /// The first line of its record, from 1.
    pub line: u32,
}

/// The polygon of a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceOutline {
    /// F 3: three or four vertices, from 1, counter-clockwise from the front.
    Vertices(Vec<u32>),
    /// F 3a: a flat shape in space.
    Placed {
        /// The shape.
        shape: PlanarShape,
        /// The position of its origin.
        origin: DVec3,
        /// The azimuth of its normal, degrees clockwise from +y.
        azimuth: f64,
        /// The angle of its normal from +z, degrees.
        tilt: f64,
    },
}

/// A shape in its own plane.
#[derive(Clone, Debug, PartialEq)]
pub enum PlanarShape {
    /// R: width and height from the lower left corner, as seen from the front.
    Rectangle([f64; 2]),
    /// T or Q: three or four corners (u, v).
    Polygon(Vec<[f64; 2]>),
}

impl View3dDocument {
    /// The corners of a surface, counter-clockwise as seen from its front.
    ///
    /// # Panics
    /// If the surface refers to vertices that the document does not have.
    pub fn corners(&self, surface: &View3dSurface) -> Vec<DVec3> {
        match &surface.outline {
            SurfaceOutline::Vertices(numbers) => {
                let vertex = |&n: &u32| self.vertices[n as usize - 1];
                numbers.iter().map(vertex).collect()
            }
            SurfaceOutline::Placed {
                shape,
                origin,
                azimuth,
                tilt,
            } => shape.placed(*origin, *azimuth, *tilt),
        }
    }
}

impl PlanarShape {
    fn placed(&self, origin: DVec3, azimuth: f64, tilt: f64) -> Vec<DVec3> {
        let ((sa, ca), (st, ct)) = (sin_cos(azimuth), sin_cos(tilt));
        let (u, v) = (DVec3::new(-ca, sa, 0.0), DVec3::new(-sa * ct, -ca * ct, st));
        let place = |[x, y]: [f64; 2]| origin + x * u + y * v;
        match self {
            &PlanarShape::Rectangle([w, h]) => {
                [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]].map(place).to_vec()
            }
            PlanarShape::Polygon(corners) => corners.iter().map(|&c| place(c)).collect(),
        }
    }
}

/// Sine and cosine of an angle in degrees, exact for multiples of 90 degrees.
fn sin_cos(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        other => other.to_radians().sin_cos(),
    }
}
