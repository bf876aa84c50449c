//! Free-form statements: from `cstype` to `end`.
//!
//! Attributes (`cstype`, `deg`, `bmat`, `step`, `stech`) hold until they change. An element
//! (`surf`, `curv2`, `curv`) is followed by its body (`parm`, `trim`, `hole`...) and `end`, at which
//! it is converted to polygons or kept for the loops of later surfaces.

mod basis;
mod curve;
mod region;
mod surface;
mod tessellate;
#[cfg(test)]
mod tests;

use super::read::ObjReader;
use crate::reading::options::Budget;
use crate::reading::text::{shortened, text};
use crate::{Position, ReadError};
use azulejo_scene::{MaterialId, Mesh};
use basis::{Basis, BasisKind, MOST_DEGREE};
use curve::Curve;
use glam::{DVec2, DVec3};
use region::Loops;
use std::rc::Rc;
use surface::{FreeFormSurface, Lines, Net, Refused, Technique};

/// The state of free-form statements.
#[derive(Debug, Default)]
pub(super) struct FreeForm {
    rational: bool,
    family: Family,
    degree: [usize; 2],
    step: [usize; 2],
    matrix: [Rc<[f64]>; 2],
    technique: Technique,
    /// `vp`, with missing coordinates set to 0 and 1.
    points: Vec<DVec3>,
    /// `curv2` in file order; `None` for unusable ones.
    curves: Vec<Option<Curve>>,
    element: Option<Element>,
    /// Whether any surface has used the weights of its vertices.
    pub weights_used: bool,
}

/// Polygons of the surfaces of one part of the file, with material indices of the file.
#[derive(Debug)]
pub(super) struct Tessellated {
    /// Number of parts begun so far.
    pub part: usize,
    pub mesh: Mesh,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Family {
    #[default]
    None,
    Matrix,
    Bezier,
    BSpline,
    Cardinal,
    Taylor,
}

/// A curve or surface before its `end`.
#[derive(Debug)]
struct Element {
    position: Position,
    what: ElementKind,
    parm: [Vec<f64>; 2],
    /// Loops of `trim` and `hole`.
    loops: Vec<Vec<Piece>>,
    /// Whether there was a `trim`; holes alone are cut out of the whole surface.
    trimmed: bool,
}

#[derive(Debug)]
enum ElementKind {
    Surface {
        range: [f64; 4],
        net: Net,
        material: MaterialId,
    },
    Trimming(Vec<DVec3>),
    /// An element without a surface, or an unusable one: its body is skipped.
    Nothing,
}

/// A part of a trimming curve.
#[derive(Clone, Copy, Debug)]
struct Piece {
    from: f64,
    to: f64,
    /// Index into [`FreeForm::curves`].
    curve: usize,
}

impl Element {
    fn new(position: Position, what: ElementKind) -> Element {
        Element {
            position,
            what,
            parm: Default::default(),
            loops: Vec::new(),
            trimmed: false,
        }
    }
}

impl FreeForm {
    /// The basis functions of an axis over these parameters.
    fn basis(&self, axis: usize, parm: Vec<f64>) -> Result<Basis, String> {
        let degree = self.degree[axis];
        let kind = match self.family {
            Family::None => return Err("no cstype before it".to_owned()),
            Family::Bezier => BasisKind::Bezier,
            Family::BSpline => BasisKind::BSpline,
            Family::Cardinal => BasisKind::cardinal(),
            Family::Taylor => BasisKind::taylor(degree.min(MOST_DEGREE)),
            Family::Matrix => BasisKind::Matrix {
                rows: Rc::clone(&self.matrix[axis]),
                step: self.step[axis],
            },
        };
        Basis::new(kind, degree, parm)
    }

    /// The region of a surface that its loops leave; empty if it is not trimmed.
    fn region(
        &self,
        element: &Element,
        lines: &Lines,
        budget: &mut Budget,
    ) -> Result<Loops, Refused> {
        let mut region = Loops::new();
        for pieces in &element.loops {
            let mut points: Vec<DVec2> = Vec::new();
            for piece in pieces {
                let curve = self.curves.get(piece.curve).and_then(Option::as_ref);
                let curve = curve.ok_or("a loop with a trimming curve that does not exist")?;
                points.extend(curve.flatten(piece.from, piece.to, lines, budget)?);
            }
            points.dedup();
            if !points.iter().all(|p| p.is_finite()) {
                return Err("a trimming curve with points that are not finite".into());
            }
            if points.len() >= 3 {
                region.push(points);
            }
        }
        if !region.is_empty() && !element.trimmed {
            let [a, b] = [&lines.u, &lines.v].map(|l| (l[0], l[l.len() - 1]));
            let corners = [(a.0, b.0), (a.1, b.0), (a.1, b.1), (a.0, b.1)];
            region.push(corners.map(DVec2::from).to_vec());
        }
        Ok(region)
    }
}

impl ObjReader<'_> {
    /// Handles a statement; returns `false` if it is not one of free-form geometry.
    #[cold]
    pub(super) fn free_form(&mut self, keyword: &[u8]) -> Result<bool, ReadError> {
        match keyword {
            b"vp" => self.parameter_vertex(),
            b"cstype" => self.family(),
            b"deg" => self.degree(),
            b"bmat" => self.matrix(),
            b"step" => self.step(),
            b"stech" => self.technique(),
            b"surf" => self.surface()?,
            b"curv2" => self.trimming_curve()?,
            b"curv" => {
                self.warn("free-form curves (curv) have no surface: skipped");
                self.begin(ElementKind::Nothing)?;
            }
            b"parm" => self.parameters(),
            b"trim" | b"hole" => self.trimming_loop(keyword == b"trim"),
            b"end" => self.end()?,
            b"bzp" | b"bsp" | b"cdp" => self.old_patch(keyword)?,
            b"cdc" => self.warn("free-form curves (cdc) have no surface: skipped"),
            b"con" => self.warn("con: surfaces are not joined, their edges may not meet exactly"),
            b"scrv" | b"sp" | b"ctech" | b"res" => {
                let word = text(keyword);
                self.warn(format!(
                    "\"{word}\" does not change a surface, only how it is divided: skipped"
                ));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// The numbers of a statement; a warning if one is malformed or not finite.
    fn values(&mut self, keyword: &str) -> Option<Vec<f64>> {
        let mut values = Vec::new();
        while !self.cursor.at_end() {
            let Some(value) = self.value() else {
                self.warn(format!(
                    "\"{keyword}\" with a malformed or infinite number: skipped"
                ));
                return None;
            };
            values.push(value);
        }
        Some(values)
    }

    /// The next number, if it is valid and finite.
    fn value(&mut self) -> Option<f64> {
        self.cursor.skip_blanks();
        let [value] = self.cursor.plain_numbers()?;
        value.is_finite().then_some(value)
    }

    /// 0 or 1 for the word `u` or `v`.
    fn axis(&mut self, keyword: &str) -> Option<usize> {
        match self.cursor.word() {
            Some(b"u") => Some(0),
            Some(b"v") => Some(1),
            _ => {
                self.warn(format!("\"{keyword}\" for neither u nor v: skipped"));
                None
            }
        }
    }

    /// `vp u [v [w]]`.
    fn parameter_vertex(&mut self) {
        let values = self.values("vp").unwrap_or_default();
        let at = |k: usize, missing| values.get(k).copied().unwrap_or(missing);
        let point = DVec3::new(at(0, 0.0), at(1, 0.0), at(2, 1.0));
        // An unusable vertex keeps its index, because points are referenced by number.
        self.free_form.points.push(point);
    }

    /// `cstype [rat] type`.
    fn family(&mut self) {
        let mut word = self.cursor.word().unwrap_or_default();
        self.free_form.rational = word == b"rat";
        if word == b"rat" {
            word = self.cursor.word().unwrap_or_default();
        }
        self.free_form.family = match word {
            b"bmatrix" => Family::Matrix,
            b"bezier" => Family::Bezier,
            b"bspline" => Family::BSpline,
            b"cardinal" => Family::Cardinal,
            b"taylor" => Family::Taylor,
            _ => {
                let word = shortened(&text(word));
                self.warn(format!("unknown cstype \"{word}\""));
                Family::None
            }
        };
    }

    fn degree(&mut self) {
        if let Some(values) = self.values("deg") {
            self.free_form.degree = whole_pair(&values);
        }
    }

    fn step(&mut self) {
        if let Some(values) = self.values("step") {
            self.free_form.step = whole_pair(&values);
        }
    }

    fn matrix(&mut self) {
        if let Some(axis) = self.axis("bmat")
            && let Some(values) = self.values("bmat")
        {
            self.free_form.matrix[axis] = values.into();
        }
    }

    /// `stech cparma u v`, `stech cparmb uv`, `stech cspace length` or
    /// `stech curv distance degrees`.
    fn technique(&mut self) {
        let word = self.cursor.word().unwrap_or_default();
        let values = self.values("stech").unwrap_or_default();
        self.free_form.technique = match (word, values.as_slice()) {
            (b"cparma", &[u, v]) => Technique::Parametric(u, v),
            (b"cparmb", &[uv]) => Technique::Parametric(uv, uv),
            (b"cspace", &[length]) if length > 0.0 => Technique::Spatial(length),
            (b"curv", &[distance, angle]) if distance > 0.0 && angle > 0.0 => {
                Technique::Curvature(distance, angle.to_radians())
            }
            _ => {
                self.warn("malformed \"stech\": skipped");
                Technique::default()
            }
        };
    }

    /// Begins an element; one that has not ended ends now.
    fn begin(&mut self, what: ElementKind) -> Result<(), ReadError> {
        let position = self.cursor.position();
        if self.free_form.element.is_some() {
            self.warn("curve or surface without end before the next one: ended there");
            self.end()?;
        }
        self.free_form.element = Some(Element::new(position, what));
        Ok(())
    }

    /// `surf u0 u1 v0 v1 corner...`.
    fn surface(&mut self) -> Result<(), ReadError> {
        let mut range = [0.0; 4];
        for value in &mut range {
            let Some(given) = self.value() else {
                self.warn("\"surf\" without four numbers for its range: skipped");
                return self.begin(ElementKind::Nothing);
            };
            *value = given;
        }
        let what = ElementKind::Surface {
            range,
            net: self.net()?,
            material: self.material,
        };
        self.begin(what)
    }

    /// Control points to the end of the statement.
    fn net(&mut self) -> Result<Net, ReadError> {
        let (mut net, mut textured, mut weighted) = (Net::default(), true, false);
        while !self.cursor.at_end() {
            let start = self.cursor.offset();
            let [vertex, uv, normal] = self.corner()?;
            let Some(&point) = self.raw.positions.get(vertex as usize) else {
                return Err(self.out_of_range(i64::from(vertex) + 1, start));
            };
            if normal != super::lists::NONE {
                self.warn("normals of control points: not used, those of the surface are computed");
            }
            net.points.push(point);
            let weight = self.raw.weights.get(vertex as usize).copied();
            net.weights.push(weight.unwrap_or(1.0));
            weighted |= weight.is_some_and(|w| w != 1.0);
            let uv = self.raw.uvs.get(uv as usize).copied();
            textured &= uv.is_some();
            net.uvs.push(uv.unwrap_or_default());
        }
        if !textured {
            net.uvs = Vec::new();
        }
        if !self.free_form.rational {
            net.weights = Vec::new();
        }
        self.free_form.weights_used |= weighted && self.free_form.rational;
        Ok(net)
    }

    /// `curv2 vp...`.
    fn trimming_curve(&mut self) -> Result<(), ReadError> {
        let values = self.values("curv2").unwrap_or_default();
        let known = &self.free_form.points;
        let point = |&given: &f64| {
            let index = from_one(given, known.len())?;
            let p = known[index];
            let weight = if self.free_form.rational { p.z } else { 1.0 };
            Some(DVec3::new(p.x, p.y, weight))
        };
        // If one is missing, `end` will report that the others do not suffice.
        let points = values.iter().filter_map(point).collect();
        self.begin(ElementKind::Trimming(points))
    }

    /// `parm u ...` and `parm v ...`.
    fn parameters(&mut self) {
        let axis = self.axis("parm");
        let values = self.values("parm");
        if let (Some(axis), Some(values)) = (axis, values) {
            self.in_element("parm", |element| element.parm[axis] = values);
        }
    }

    /// `trim` and `hole`: triples of two parameters and a curve.
    fn trimming_loop(&mut self, outer: bool) {
        let Some(values) = self.values("trim or hole") else {
            return;
        };
        let count = self.free_form.curves.len();
        let piece = |triple: &[f64]| Piece {
            from: triple[0],
            to: triple[1],
            curve: from_one(triple[2], count).unwrap_or(usize::MAX),
        };
        let pieces = values.chunks_exact(3).map(piece).collect();
        self.in_element("trim or hole", |element| {
            element.loops.push(pieces);
            element.trimmed |= outer;
        });
    }

    fn in_element(&mut self, keyword: &str, change: impl FnOnce(&mut Element)) {
        match &mut self.free_form.element {
            Some(element) => change(element),
            None => self.warn(format!("\"{keyword}\" outside a curve or surface: skipped")),
        }
    }

    /// Patches of version 2.11: sixteen control points, rows from the top.
    fn old_patch(&mut self, keyword: &[u8]) -> Result<(), ReadError> {
        let kept = std::mem::take(&mut self.free_form.rational);
        let mut net = self.net()?;
        self.free_form.rational = kept;
        if net.points.len() != 16 {
            self.warn("patch without exactly 16 control points: skipped");
            return Ok(());
        }
        net.points = net.points.chunks(4).rev().flatten().copied().collect();
        net.uvs = net.uvs.chunks(4).rev().flatten().copied().collect();
        let (family, parm): (Family, Vec<f64>) = match keyword {
            b"bsp" => (Family::BSpline, (-3..=4).map(f64::from).collect()),
            b"cdp" => (Family::Cardinal, vec![0.0, 1.0]),
            _ => (Family::Bezier, vec![0.0, 1.0]),
        };
        self.begin(ElementKind::Surface {
            range: [0.0, 1.0, 0.0, 1.0],
            net,
            material: self.material,
        })?;
        self.in_element("patch", |element| element.parm = [parm.clone(), parm]);
        let (given, degree) = (self.free_form.family, self.free_form.degree);
        (self.free_form.family, self.free_form.degree) = (family, [3, 3]);
        let ended = self.end();
        (self.free_form.family, self.free_form.degree) = (given, degree);
        ended
    }

    /// Finishes the current element.
    pub(super) fn end(&mut self) -> Result<(), ReadError> {
        let Some(mut element) = self.free_form.element.take() else {
            self.warn("\"end\" without a curve or surface: skipped");
            return Ok(());
        };
        let position = element.position;
        let made = match std::mem::replace(&mut element.what, ElementKind::Nothing) {
            ElementKind::Nothing => Ok(()),
            ElementKind::Trimming(points) => {
                let (curve, made) = match self.trimming(&mut element, points) {
                    Ok(curve) => (Some(curve), Ok(())),
                    Err(why) => (None, Err(why.into())),
                };
                self.free_form.curves.push(curve);
                made
            }
            ElementKind::Surface {
                range,
                net,
                material,
            } => self.polygons(&mut element, range, net, material),
        };
        match made {
            Ok(()) => Ok(()),
            Err(Refused::Budget(exhausted)) => Err(exhausted.error(self.file)),
            Err(Refused::Reason(why)) => {
                let message = format!("free-form curve or surface with {why}: skipped");
                self.warnings.add(self.file, message, || position);
                Ok(())
            }
        }
    }

    fn trimming(&self, element: &mut Element, points: Vec<DVec3>) -> Result<Curve, String> {
        let basis = self
            .free_form
            .basis(0, std::mem::take(&mut element.parm[0]))?;
        positive(points.iter().map(|p| p.z))?;
        Curve::new(basis, points)
    }

    fn polygons(
        &mut self,
        element: &mut Element,
        range: [f64; 4],
        net: Net,
        material: MaterialId,
    ) -> Result<(), Refused> {
        let [u, v] = std::mem::take(&mut element.parm);
        let free_form = &self.free_form;
        let (u, v) = (free_form.basis(0, u)?, free_form.basis(1, v)?);
        positive(net.weights.iter().copied())?;
        let surface = FreeFormSurface::new(u, v, net)?;
        let range = surface.within(range);
        let range = range.ok_or("a range outside its parameters")?;
        let patch = tessellate::tessellate(
            &surface,
            range,
            free_form.technique,
            |lines, budget| free_form.region(element, lines, budget),
            &mut self.budget,
        )?;
        if patch.is_empty() {
            return Err("loops that cut all of it away".into());
        }
        let part = self.raw.parts.len();
        let surfaces = &mut self.raw.surfaces;
        if surfaces.last().is_none_or(|last| last.part != part) {
            let mesh = Mesh::default();
            surfaces.push(Tessellated { part, mesh });
        }
        if let Some(last) = surfaces.last_mut() {
            patch.add_to(&mut last.mesh, material);
        }
        Ok(())
    }

    /// Ends an element that the file left open.
    pub(super) fn end_of_file(&mut self) -> Result<(), ReadError> {
        if self.free_form.element.is_some() {
            self.warn("curve or surface without end at the end of the file: ended there");
            self.end()?;
        }
        Ok(())
    }
}

/// Integers for u and v; missing or negative ones become 0, large ones are clamped.
fn whole_pair(values: &[f64]) -> [usize; 2] {
    [0, 1].map(|axis| values.get(axis).map_or(0, |v| v.clamp(0.0, 1e6) as usize))
}

/// Converts an index that counts from 1, or backwards from −1, to one from 0.
fn from_one(given: f64, count: usize) -> Option<usize> {
    let index = if given > 0.0 {
        given - 1.0
    } else {
        given + count as f64
    };
    (0.0..count as f64)
        .contains(&index)
        .then_some(index as usize)
}

fn positive(mut weights: impl Iterator<Item = f64>) -> Result<(), String> {
    if weights.all(|w| w > 0.0) {
        Ok(())
    } else {
        Err("weights that are not positive".to_owned())
    }
}
