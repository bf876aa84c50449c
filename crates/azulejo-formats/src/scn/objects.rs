//! Translates objects to records.

use super::ScnResult;
use super::solids::{self, ScnTorus};
use super::translate::ScnTranslator;
use crate::sff::document::*;
use glam::DVec3;

/// The object names.
const OBJECTS: [&str; 18] = [
    "sphere",
    "box",
    "cube",
    "cone",
    "cylinder",
    "disc",
    "ring",
    "wedge",
    "tetra",
    "prism",
    "pyramid",
    "patch",
    "polygon",
    "triangle",
    "quadrangle",
    "torus",
    "text3d",
    "disk",
];

/// Whether a word is the name of an object.
pub(super) fn is_object(word: &str) -> bool {
    OBJECTS.contains(&word)
}

/// The words between an object's name and its data.
#[derive(Default)]
struct ObjectModifiers {
    open: bool,
    truncated: bool,
    file: bool,
    normal: bool,
    general: bool,
}

/// The translation of an object.
struct TranslatedObject {
    pieces: Vec<SffGeometry>,
    /// Whether the pieces together close a volume.
    compound: bool,
    /// Whether the surfaces are given per corner.
    general: bool,
}

impl From<SffGeometry> for TranslatedObject {
    fn from(geometry: SffGeometry) -> TranslatedObject {
        TranslatedObject {
            pieces: vec![geometry],
            compound: false,
            general: false,
        }
    }
}

impl TranslatedObject {
    fn compound(pieces: Vec<SffGeometry>, open: bool) -> TranslatedObject {
        TranslatedObject {
            pieces,
            compound: !open,
            general: false,
        }
    }
}

impl ScnTranslator<'_> {
    /// Reads an object after its name.
    pub fn object(&mut self, name: &str, place: SffPosition) -> ScnResult<()> {
        let mut modifiers = ObjectModifiers::default();
        self.modifiers(&mut modifiers);
        self.local_attributes()?;
        self.modifiers(&mut modifiers);
        let mut appearance = self.appearance()?;
        let made = self.shape(name, &modifiers, place)?;
        if made.general {
            appearance.surface = 0;
        }
        let is_list = made.compound && self.is_in_operation();
        if is_list {
            let appearance = RecordAppearance::default();
            self.push(RecordKind::ListBegin { appearance }, place)?;
            self.push_attributes(place)?;
        }
        for geometry in made.pieces {
            self.push(
                RecordKind::Object {
                    appearance,
                    geometry,
                },
                place,
            )?;
            if !is_list {
                self.push_attributes(place)?;
            }
        }
        if is_list {
            self.push(RecordKind::ListEnd, place)?;
        }
        self.scopes.leave();
        Ok(())
    }

    fn modifiers(&mut self, modifiers: &mut ObjectModifiers) {
        loop {
            let which = match self.stream.peek_word() {
                Some("open") => &mut modifiers.open,
                Some("truncated" | "trunc") => &mut modifiers.truncated,
                Some("file") => &mut modifiers.file,
                Some("normal") => &mut modifiers.normal,
                Some("general") => &mut modifiers.general,
                _ => return,
            };
            *which = true;
            self.stream.word();
        }
    }

    fn shape(
        &mut self,
        name: &str,
        modifiers: &ObjectModifiers,
        place: SffPosition,
    ) -> ScnResult<TranslatedObject> {
        let open = modifiers.open;
        let stream = &mut self.stream;
        Ok(match name {
            "sphere" => SffGeometry::Sphere {
                centre: stream.point()?,
                radius: stream.positive("a radius")?,
            }
            .into(),
            "box" | "cube" => {
                let centre = stream.point()?;
                let x = stream.positive("half size")?;
                let half = if name == "box" && stream.real_follows() {
                    DVec3::new(
                        x,
                        stream.positive("half size")?,
                        stream.positive("half size")?,
                    )
                } else {
                    DVec3::splat(x)
                };
                SffGeometry::Cuboid { centre, half }.into()
            }
            "cone" | "cylinder" => self.turned(name, modifiers, place)?,
            "disc" | "disk" => {
                let (centre, normal) = (stream.point()?, stream.vector()?.normalize());
                solids::disc(centre, normal, stream.positive("a radius")?).into()
            }
            "ring" => {
                let (centre, normal) = (stream.point()?, stream.vector()?.normalize());
                let outer = stream.positive("a radius")?;
                let inner = stream.positive("a radius")?;
                solids::ring(centre, normal, outer, inner).into()
            }
            "wedge" => {
                let base = [stream.point()?, stream.point()?, stream.point()?];
                let depth = stream.positive("a depth")?;
                let normal = self.normal(&base, place)?;
                TranslatedObject::compound(vec![solids::prism(&base, normal, depth, false)], false)
            }
            "tetra" => {
                let p = [
                    stream.point()?,
                    stream.point()?,
                    stream.point()?,
                    stream.point()?,
                ];
                TranslatedObject::compound(vec![solids::tetrahedron(p)], false)
            }
            "prism" => {
                let height = stream.positive("a height")?;
                let base = self.points(place)?;
                let normal = self.normal(&base, place)?;
                TranslatedObject::compound(vec![solids::prism(&base, normal, height, open)], open)
            }
            "pyramid" => {
                let height = stream.positive("a height")?;
                let top = if modifiers.truncated {
                    Some(stream.positive("relative size of the top")?)
                } else {
                    None
                };
                let base = self.points(place)?;
                let normal = self.normal(&base, place)?;
                let pyramid = solids::pyramid(&base, normal, height, top, open);
                TranslatedObject::compound(vec![pyramid], open)
            }
            "torus" => self.torus(open, place)?,
            "text3d" => SffGeometry::Text(RecordData::File(stream.file_name()?)).into(),
            _ if modifiers.file => self.file(name, modifiers)?,
            "patch" => {
                let mut points = [DVec3::ZERO; 12];
                for point in &mut points {
                    *point = stream.point()?;
                }
                solids::patch(points).into()
            }
            "polygon" => {
                let points = self.points(place)?;
                one_polygon(points).into()
            }
            "quadrangle" => {
                let p = [
                    stream.point()?,
                    stream.point()?,
                    stream.point()?,
                    stream.point()?,
                ];
                one_polygon(p.to_vec()).into()
            }
            _ if modifiers.normal || modifiers.general => self.triangle(modifiers.general)?,
            _ => {
                let p = [stream.point()?, stream.point()?, stream.point()?];
                one_polygon(p.to_vec()).into()
            }
        })
    }

    fn turned(
        &mut self,
        name: &str,
        modifiers: &ObjectModifiers,
        place: SffPosition,
    ) -> ScnResult<TranslatedObject> {
        let stream = &mut self.stream;
        let apex = stream.point()?;
        let pieces = if modifiers.truncated {
            let apex_radius = stream.positive("a radius")?;
            let base = stream.point()?;
            let base_radius = stream.positive("a radius")?;
            ((apex, apex_radius), (base, base_radius))
        } else {
            let base = stream.point()?;
            let radius = stream.positive("a radius")?;
            let apex_radius = if name == "cone" { 0.0 } else { radius };
            ((apex, apex_radius), (base, radius))
        };
        if pieces.0.0 == pieces.1.0 {
            let found = format!("a {name} without height");
            return Err(stream.error(place, found, "two different ends"));
        }
        let made = solids::cone(pieces.0, pieces.1, modifiers.open);
        Ok(TranslatedObject::compound(made, modifiers.open))
    }

    fn torus(&mut self, open: bool, place: SffPosition) -> ScnResult<TranslatedObject> {
        let stream = &mut self.stream;
        let radius = stream.positive("a radius")?;
        let tube = stream.positive("a radius")?;
        let (mut from, mut to, mut pieces) = (0.0, 360.0, [16, 8]);
        if stream.real_follows() {
            (from, to) = (stream.real()?, stream.real()?);
            if stream.real_follows() {
                let mut count = || stream.within(3.0, 4096.0, "number of pieces of a torus");
                pieces = [count()?.round() as u32, count()?.round() as u32];
            }
        }
        if from == to || (to - from).abs() > 1e6 {
            let found = format!("a torus from {from} to {to} degrees");
            return Err(stream.error(place, found, "two different angles"));
        }
        // A triangle has three corners with normals.
        self.spend(6 * (pieces[0] + 1) as usize * pieces[1] as usize, place)?;
        let torus = ScnTorus {
            radius,
            tube,
            from,
            to,
            pieces,
            open,
        };
        let full = (to - from).abs() >= 360.0;
        Ok(TranslatedObject::compound(
            vec![torus.triangles()],
            open && !full,
        ))
    }

    /// Reads a triangle with normals, and with surfaces if it is `general`.
    fn triangle(&mut self, general: bool) -> ScnResult<TranslatedObject> {
        let mut corners = [(DVec3::ZERO, DVec3::ZERO); 3];
        for corner in &mut corners {
            *corner = (self.stream.point()?, self.stream.vector()?.normalize());
        }
        let mut surfaces = Vec::new();
        if general {
            let mut three = [0; 3];
            for surface in &mut three {
                if !self.stream.take(&["surface"]) {
                    return Err(self.stream.unexpected("surface, one for each corner"));
                }
                *surface = self.surface()?;
            }
            surfaces.push(three);
        }
        let data = TriangleData {
            corners: vec![corners],
            surfaces,
        };
        Ok(TranslatedObject {
            general,
            ..SffGeometry::Triangles(solids::here(data)).into()
        })
    }

    /// Reads patches, polygons or triangles from another file, translated and scaled.
    fn file(&mut self, name: &str, modifiers: &ObjectModifiers) -> ScnResult<TranslatedObject> {
        let stream = &mut self.stream;
        let (mut origin, mut scale) = (DVec3::ZERO, DVec3::ONE);
        if stream.point_follows() {
            origin = stream.point()?;
            if stream.real_follows() {
                let x = stream.real()?;
                scale = if stream.real_follows() {
                    DVec3::new(x, stream.real()?, stream.real()?)
                } else {
                    DVec3::splat(x)
                };
            }
        }
        let file = stream.file_name()?;
        fn placed<T>(origin: DVec3, scale: DVec3, file: String) -> Box<PlacedData<T>> {
            Box::new(PlacedData {
                origin,
                scale,
                data: RecordData::File(file),
            })
        }
        let geometry = match name {
            "patch" => SffGeometry::Patches(placed(origin, scale, file)),
            "triangle" => SffGeometry::Triangles(placed(origin, scale, file)),
            _ => SffGeometry::Polygons(placed(origin, scale, file)),
        };
        Ok(TranslatedObject {
            general: name == "triangle" && modifiers.general,
            ..geometry.into()
        })
    }

    /// Reads a count and as many points.
    fn points(&mut self, place: SffPosition) -> ScnResult<Vec<DVec3>> {
        let count = self.stream.real()?.round();
        // Every point takes at least one token.
        if !(3.0..=self.stream.left() as f64).contains(&count) {
            let found = format!("{count} points");
            return Err(self
                .stream
                .error(place, found, "3 or more, all listed after the count"));
        }
        (0..count as usize).map(|_| self.stream.point()).collect()
    }

    fn normal(&self, base: &[DVec3], place: SffPosition) -> ScnResult<DVec3> {
        solids::normal(base).ok_or_else(|| {
            let found = "a base without area";
            self.stream
                .error(place, found, "corners of a planar polygon with an area")
        })
    }
}

fn one_polygon(points: Vec<DVec3>) -> SffGeometry {
    let face = (0..points.len() as u32).collect();
    solids::polygons(points, &[face])
}
