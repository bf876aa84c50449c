//! The element `vertex`.

use super::header::{PlyElement, PropertyType, ScalarType};
use super::rows::{RowError, RowSource};
use super::{PlyReader, rows};
use crate::{Position, ReadError};
use azulejo_scene::Rgb;
use glam::{DVec2, DVec3};

/// The attributes of the vertices; lists of absent ones are empty.
#[derive(Debug, Default)]
pub(super) struct PlyVertices {
    /// May contain non-finite values.
    pub positions: Vec<DVec3>,
    /// As in the file.
    pub normals: Vec<DVec3>,
    pub uvs: Vec<DVec2>,
    /// Divided by the value that represents 1 in their type.
    pub colors: Vec<Rgb>,
    pub irradiance: Vec<Rgb>,
    pub irradiance_error: Vec<Rgb>,
    /// The index of azulejo's object for each vertex.
    pub objects: Vec<u32>,
}

/// Property names by meaning. The index of a name is the index of its value.
const MEANINGS: [&[&str]; 21] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["s", "u", "texture_u", "texture_s"],
    &["t", "v", "texture_v", "texture_t"],
    &["red", "r"],
    &["green", "g"],
    &["blue", "b"],
    &["diffuse_red"],
    &["diffuse_green"],
    &["diffuse_blue"],
    &["irradiance_red"],
    &["irradiance_green"],
    &["irradiance_blue"],
    &["irradiance_error_red"],
    &["irradiance_error_green"],
    &["irradiance_error_blue"],
    &["object"],
];

const NORMAL: usize = 3;
const UV: usize = 6;
const COLOR: usize = 8;
/// Colours as numbers, which bytes for other programs stand beside.
const EXACT_COLOR: usize = 11;
const IRRADIANCE: usize = 14;
const ERROR: usize = 17;
const OBJECT: usize = 20;

/// The index for values that are not used.
const UNUSED: usize = MEANINGS.len();

/// The use of each property of a row, and the resulting values.
#[derive(Default)]
struct VertexPlan {
    steps: Vec<PropertyTarget>,
    has: [bool; UNUSED],
    /// The values that represent 1 in colours.
    one: [f64; 6],
    normals: bool,
    uvs: bool,
    /// The first of the three colours that are used.
    colors: Option<usize>,
    irradiance: bool,
    errors: bool,
}

enum PropertyTarget {
    Value(ScalarType, usize),
    List(usize),
}

type RowValues = [f64; UNUSED + 1];

impl VertexPlan {
    fn new(
        reader: &mut PlyReader<'_>,
        element: &PlyElement,
        objects_are_named: bool,
    ) -> VertexPlan {
        let mut plan = VertexPlan::default();
        for (number, property) in element.properties.iter().enumerate() {
            let PropertyType::Scalar(kind) = property.kind else {
                plan.steps.push(PropertyTarget::List(number));
                reader.unused(element, &property.name);
                continue;
            };
            let means = |names: &&[&str]| names.contains(&property.name.as_str());
            let known = MEANINGS.iter().position(means);
            let meaning = known.filter(|&m| !plan.has[m] && (m != OBJECT || objects_are_named));
            match meaning {
                Some(meaning) => plan.has[meaning] = true,
                None => reader.unused(element, &property.name),
            }
            let slot = meaning.unwrap_or(UNUSED);
            plan.steps.push(PropertyTarget::Value(kind, slot));
            if (COLOR..IRRADIANCE).contains(&slot) {
                plan.one[slot - COLOR] = kind.one();
            }
        }
        plan.normals = plan.has_all(NORMAL, 3);
        plan.uvs = plan.has_all(UV, 2);
        plan.colors = [EXACT_COLOR, COLOR]
            .into_iter()
            .find(|&first| plan.has_all(first, 3));
        plan.irradiance = plan.has_all(IRRADIANCE, 3);
        plan.errors = plan.has_all(ERROR, 3);
        plan
    }

    /// Whether all properties of a group are present.
    fn has_all(&self, first: usize, count: usize) -> bool {
        self.has[first..first + count].iter().all(|h| *h)
    }

    /// Stores the numbers of a row by their meanings.
    #[inline]
    fn row<S: RowSource>(
        &self,
        source: &mut S,
        element: &PlyElement,
        values: &mut RowValues,
    ) -> Result<(), RowError> {
        for step in &self.steps {
            match *step {
                PropertyTarget::Value(kind, slot) => values[slot] = source.number(kind)?,
                PropertyTarget::List(number) => element.properties[number].skip(source)?,
            }
        }
        Ok(())
    }
}

impl PlyReader<'_> {
    /// Reads the vertices and returns how many are missing.
    pub fn read_vertices<S: RowSource>(
        &mut self,
        element: &PlyElement,
        objects_are_named: bool,
        source: &mut S,
    ) -> Result<(PlyVertices, u64), ReadError> {
        let plan = VertexPlan::new(self, element, objects_are_named);
        let mut vertices = PlyVertices::default();
        if !plan.has_all(0, 3) {
            let found = "vertices without x, y or z";
            return Err(ReadError {
                position: Position::Line(element.line, 1),
                ..ReadError::whole(self.file, found, "these three properties")
            });
        }
        let room = element.room(source.left());
        vertices.positions.reserve_exact(room);
        let mut values = [0.0; UNUSED + 1];
        let missing = rows(element, source, |source| {
            plan.row(source, element, &mut values)?;
            vertices.push(&plan, &values);
            Ok(())
        })?;
        Ok((vertices, missing))
    }
}

impl PlyVertices {
    #[inline]
    fn push(&mut self, plan: &VertexPlan, values: &RowValues) {
        let vector = |first: usize| DVec3::new(values[first], values[first + 1], values[first + 2]);
        let color = |first: usize| Rgb::from(vector(first).to_array());
        self.positions.push(vector(0));
        if plan.normals {
            self.normals.push(vector(NORMAL));
        }
        if plan.uvs {
            self.uvs.push(DVec2::new(values[UV], values[UV + 1]));
        }
        if let Some(first) = plan.colors {
            let share = |i: usize| values[first + i] / plan.one[first - COLOR + i];
            self.colors.push(Rgb::new(share(0), share(1), share(2)));
        }
        if plan.irradiance {
            self.irradiance.push(color(IRRADIANCE));
        }
        if plan.errors {
            self.irradiance_error.push(color(ERROR));
        }
        if plan.has[OBJECT] {
            self.objects.push(values[OBJECT] as u32);
        }
    }
}
