//! Writes a document as text: canonical, stable, every number in its shortest exact form.

use super::brdf::GrfReflection;
use super::document::{
    AppearanceChange, AreaLight, BlockKind, DefinitionBody, FinishNote, GrfBlock, GrfDefinition,
    GrfDocument, MaterialNote, MeshBlock, ObjectNotes, OpacityNote, PrimitiveBlock, TransformStep,
};
use azulejo_scene::brdf::{Description, Model, Value};
use azulejo_scene::{
    BackIrradiance, Camera, Light, LightKind, OpacityChannel, OpacityMode, PictureChannel,
    PrimitiveKind, ReliefKind, Rgb, Sidedness, SurfaceLight, Units, Up, WrapMode,
};

use super::{instances, luminaire, solids, surroundings};
use glam::{DAffine3, DVec2, DVec3};
use std::fmt;
use std::io::{self, BufWriter, Write};

pub(super) type GrfOutput<'w> = BufWriter<&'w mut dyn Write>;

impl GrfDocument {
    /// Writes the document, through an internal buffer. Included files are not written.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut out = BufWriter::with_capacity(1 << 16, out);
        for comment in &self.comments {
            // A comment set by a program may have several lines.
            for line in comment.split(['\n', '\r']) {
                writeln!(out, "//{}", line.trim_end())?;
            }
        }
        blocks(&mut out, &self.blocks)?;
        if self.blocks.is_empty() && self.comments.is_empty() {
            // The empty statement: a file without a byte would rather be one that was not written.
            writeln!(out, ";")?;
        }
        out.flush()
    }
}

/// A number in the shortest form that reads back to the same bits.
pub(super) struct Number(pub f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size == 0.0 || (1e-5..1e16).contains(&size) {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

/// `(x, y, z)`
pub(super) struct Vector<const N: usize>([f64; N]);

impl<const N: usize> fmt::Display for Vector<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, &number) in self.0.iter().enumerate() {
            let before = if k == 0 { "(" } else { ", " };
            write!(f, "{before}{}", Number(number))?;
        }
        f.write_str(")")
    }
}

pub(super) fn point(v: DVec3) -> Vector<3> {
    Vector(v.to_array())
}

pub(super) fn pair(v: DVec2) -> Vector<2> {
    Vector(v.to_array())
}

pub(super) fn rgb(c: Rgb) -> Vector<3> {
    Vector(c.to_array())
}

/// A text of an extension, in quotes, with escapes.
pub(super) struct Quoted<'a>(pub &'a str);

impl fmt::Display for Quoted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("\"")?;
        for c in self.0.chars() {
            match c {
                '"' | '\\' => write!(f, "\\{c}")?,
                '\n' => f.write_str("\\n")?,
                '\r' => f.write_str("\\r")?,
                '\t' => f.write_str("\\t")?,
                c if c.is_control() => write!(f, "\\u{{{:x}}}", u32::from(c))?,
                c => write!(f, "{c}")?,
            }
        }
        f.write_str("\"")
    }
}

/// A file name: in quotes, or bare if it was read bare with a quote inside.
pub(super) struct FileName<'a>(pub &'a str);

impl fmt::Display for FileName<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.contains('"') {
            f.write_str(self.0)
        } else {
            write!(f, "\"{}\"", self.0)
        }
    }
}

fn blocks(out: &mut GrfOutput<'_>, blocks: &[GrfBlock]) -> io::Result<()> {
    blocks.iter().try_for_each(|b| block(out, &b.kind))
}

fn block(out: &mut GrfOutput<'_>, kind: &BlockKind) -> io::Result<()> {
    match kind {
        BlockKind::Params(text) => enclosed(out, "params", text, "params"),
        BlockKind::Mesh(block) => mesh(out, block),
        BlockKind::AreaLight(light) => area_light(out, light),
        BlockKind::Primitive(block) => primitive(out, block),
        BlockKind::Exact(block) => solids::exact(out, block),
        BlockKind::MeshInstance(block) => instances::mesh_instance(out, block),
        BlockKind::Figure(block) => solids::figure(out, block),
        BlockKind::Define(block) => solids::define(out, block),
        BlockKind::Include { name, .. } => writeln!(out, "include {}", FileName(name)),
        BlockKind::Transform {
            steps,
            blocks: inner,
        } => {
            out.write_all(b"transform")?;
            steps.iter().try_for_each(|s| step(out, s))?;
            out.write_all(b" begin\n")?;
            blocks(out, inner)?;
            out.write_all(b"end transform\n")
        }
        BlockKind::Definitions {
            definitions,
            blocks: inner,
        } => {
            definitions.iter().try_for_each(|d| definition(out, d))?;
            let Some(inner) = inner else { return Ok(()) };
            out.write_all(b"begin\n")?;
            blocks(out, inner)?;
            out.write_all(b"end def\n")
        }
        BlockKind::Units(u) => units(out, u),
        BlockKind::Camera(c) => camera(out, c),
        BlockKind::Background(color) => {
            writeln!(out, "ext background begin color = {} end ext", rgb(*color))
        }
        BlockKind::Fog(f) => writeln!(
            out,
            "ext fog begin color = {} visibility = {} exponential = {} end ext",
            rgb(f.color),
            Number(f.visibility),
            f.exponential
        ),
        BlockKind::Light(l) => light(out, l),
        BlockKind::Environment(block) => surroundings::write(out, block),
        BlockKind::Backplate(block) => surroundings::write_backplate(out, block),
        BlockKind::Material(note) => material(out, note),
        BlockKind::Texture { of, path, wrap } => {
            write!(out, "ext texture begin of = {of} path = {}", Quoted(path))?;
            if *wrap != [WrapMode::Repeat; 2] {
                let [u, v] = wrap.map(|mode| match mode {
                    WrapMode::Repeat => "repeat",
                    WrapMode::Clamp => "clamp",
                    WrapMode::Mirror => "mirror",
                });
                write!(out, " wrap = {u} {v}")?;
            }
            out.write_all(b" end ext\n")
        }
        BlockKind::Unknown { name, text } => enclosed(out, &format!("ext {name}"), text, "ext"),
    }
}

/// Writes a block whose content is kept as text.
fn enclosed(out: &mut GrfOutput<'_>, head: &str, text: &str, end: &str) -> io::Result<()> {
    writeln!(out, "{head} begin")?;
    if !text.is_empty() {
        writeln!(out, "{text}")?;
    }
    writeln!(out, "end {end}")
}

fn step(out: &mut GrfOutput<'_>, step: &TransformStep) -> io::Result<()> {
    match *step {
        TransformStep::Scale(v) => write!(out, " scale {}", point(v)),
        TransformStep::Rotation(v) => write!(out, " rotation {}", point(v)),
        TransformStep::Translation(v) => write!(out, " translation {}", point(v)),
    }
}

fn definition(out: &mut GrfOutput<'_>, definition: &GrfDefinition) -> io::Result<()> {
    write!(out, "def {} = ", definition.name)?;
    body(out, &definition.body)
}

fn body(out: &mut GrfOutput<'_>, body: &DefinitionBody) -> io::Result<()> {
    match body {
        DefinitionBody::Texture(path) => writeln!(out, "texture {}", FileName(path)),
        DefinitionBody::Color(color) => writeln!(out, "rgb {}", rgb(*color)),
        DefinitionBody::Brdf(model) => brdf(out, model),
    }
}

pub(super) fn brdf(out: &mut GrfOutput<'_>, reflection: &GrfReflection) -> io::Result<()> {
    match &reflection.description {
        Description::File { path, .. } => write!(out, "brdf {}", FileName(path))?,
        Description::Model(whole) => {
            out.write_all(b"brdf")?;
            model(out, whole)?;
        }
        Description::Combination(parts) => {
            out.write_all(b"brdf combination")?;
            for (weight, part) in parts {
                write!(out, " weight = {}", Number(*weight))?;
                model(out, part)?;
            }
        }
    }
    out.write_all(b"\n")
}

fn model(out: &mut GrfOutput<'_>, model: &Model) -> io::Result<()> {
    write!(out, " {}", model.name)?;
    for parameter in &model.parameters {
        write!(out, " {} = ", parameter.name)?;
        match &parameter.value {
            Value::Number(number) => write!(out, "{}", Number(*number))?,
            Value::Color(color) => write!(out, "{}", rgb(*color))?,
            Value::Word(word) => out.write_all(word.as_bytes())?,
        }
    }
    Ok(())
}

fn change(out: &mut GrfOutput<'_>, change: &AppearanceChange) -> io::Result<()> {
    match change {
        AppearanceChange::Set(set) => body(out, set),
        AppearanceChange::Use(kind, name) => writeln!(out, "use {} {name}", kind.word()),
    }
}

fn mesh(out: &mut GrfOutput<'_>, mesh: &MeshBlock) -> io::Result<()> {
    object(out, &mesh.notes, None)?;
    if mesh.is_light {
        out.write_all(b"mesh light begin\n")?;
    } else {
        out.write_all(b"begin mesh\n")?;
    }
    if let Some(radiance) = mesh.radiance {
        writeln!(out, "rgb {}", rgb(radiance))?;
    }
    mesh.head.iter().try_for_each(|c| change(out, c))?;
    vertices(out, mesh)?;
    faces(out, mesh)?;
    out.write_all(b"end mesh\n")?;
    mesh_notes(out, &mesh.notes)
}

pub(super) fn vertices(out: &mut GrfOutput<'_>, mesh: &MeshBlock) -> io::Result<()> {
    let vertices = &mesh.vertices;
    let mut named = vertices.named_colors.iter().peekable();
    out.write_all(b"begin vertices\n")?;
    for (v, &position) in vertices.positions.iter().enumerate() {
        if let Some(n) = vertices.normals.get(v) {
            write!(out, "normal {} ", point(n))?;
        }
        if let Some(e) = vertices.irradiance.get(v) {
            write!(out, "irad {} ", rgb(e))?;
        }
        if let Some(t) = vertices.uvs.get(v) {
            write!(out, "uv {} ", pair(t))?;
        }
        if let Some((_, name)) = named.next_if(|(at, _)| *at as usize == v) {
            write!(out, "use color {name} ")?;
        } else if let Some(c) = vertices.colors.get(v) {
            write!(out, "rgb {} ", rgb(c))?;
        }
        writeln!(out, "{}", point(position))?;
    }
    out.write_all(b"end vertices\n")
}

pub(super) fn faces(out: &mut GrfOutput<'_>, mesh: &MeshBlock) -> io::Result<()> {
    let mut changes = mesh.changes.iter().peekable();
    out.write_all(b"begin faces\n")?;
    for (f, corners) in mesh.faces.iter().enumerate() {
        while let Some((_, c)) = changes.next_if(|(at, _)| *at as usize <= f) {
            change(out, c)?;
        }
        for (k, corner) in corners.iter().enumerate() {
            write!(out, "{}{corner}", if k == 0 { "(" } else { ", " })?;
        }
        out.write_all(b")\n")?;
    }
    out.write_all(b"end faces\n")
}

/// Writes `ext object`, if it has any attributes.
pub(super) fn object(
    out: &mut GrfOutput<'_>,
    notes: &ObjectNotes,
    material: Option<&str>,
) -> io::Result<()> {
    if notes.name.is_empty() && material.is_none() {
        return Ok(());
    }
    out.write_all(b"ext object begin")?;
    let name = (!notes.name.is_empty()).then(|| Quoted(&notes.name));
    key(out, "name", name)?;
    key(out, "material", material)?;
    out.write_all(b" end ext\n")
}

fn mesh_notes(out: &mut GrfOutput<'_>, notes: &ObjectNotes) -> io::Result<()> {
    if !notes.smoothing.is_empty() {
        out.write_all(b"ext smoothing begin groups =")?;
        notes
            .smoothing
            .iter()
            .try_for_each(|g| write!(out, " {g}"))?;
        out.write_all(b" end ext\n")?;
    }
    if !notes.shared.is_empty() {
        out.write_all(b"ext shared begin vertices =")?;
        notes.shared.iter().try_for_each(|v| write!(out, " {v}"))?;
        out.write_all(b" end ext\n")?;
    }
    if let Some((name, map)) = &notes.shared_mesh {
        instances::shared_mesh(out, name, map)?;
    }
    if !notes.irradiance_error.is_empty() {
        irradiance_error(out, &notes.irradiance_error)?;
    }
    match &notes.back {
        Some(back) => back_irradiance(out, back),
        None => Ok(()),
    }
}

pub(super) fn irradiance_error(out: &mut GrfOutput<'_>, errors: &[Rgb]) -> io::Result<()> {
    out.write_all(b"ext irad_error begin\n")?;
    rgb_list(out, "values", errors)?;
    out.write_all(b"end ext\n")
}

/// Irradiance on the backs of some vertices, or of all.
pub(super) fn back_irradiance(out: &mut GrfOutput<'_>, back: &BackIrradiance) -> io::Result<()> {
    let known = |v: &usize| back.irradiance[*v].is_some();
    let vertices: Vec<usize> = (0..back.irradiance.len()).filter(known).collect();
    let values: Vec<Rgb> = back.irradiance.iter().flatten().copied().collect();
    if values.is_empty() {
        return Ok(());
    }
    out.write_all(b"ext irad_back begin\n")?;
    if vertices.len() < back.irradiance.len() {
        out.write_all(b"vertices =")?;
        vertices.iter().try_for_each(|v| write!(out, " {v}"))?;
        out.write_all(b"\n")?;
    }
    rgb_list(out, "values", &values)?;
    if !back.error.is_empty() {
        let errors: Vec<Rgb> = vertices.iter().map(|&v| back.error[v]).collect();
        rgb_list(out, "errors", &errors)?;
    }
    out.write_all(b"end ext\n")
}

pub(super) fn rgb_list(out: &mut GrfOutput<'_>, key: &str, values: &[Rgb]) -> io::Result<()> {
    writeln!(out, "{key} =")?;
    values.iter().try_for_each(|&c| writeln!(out, "{}", rgb(c)))
}

pub(super) fn surface_light(out: &mut GrfOutput<'_>, light: &SurfaceLight) -> io::Result<()> {
    out.write_all(b"ext surface_light begin\ngrids =")?;
    for grid in &light.grids {
        write!(out, " {} {}", grid.nu, grid.nv)?;
    }
    writeln!(out)?;
    rgb_list(out, "irradiance", &light.irradiance)?;
    if !light.error.is_empty() {
        rgb_list(out, "error", &light.error)?;
    }
    out.write_all(b"end ext\n")
}

fn area_light(out: &mut GrfOutput<'_>, light: &AreaLight) -> io::Result<()> {
    object(out, &light.notes, light.notes.material.as_deref())?;
    out.write_all(b"light begin")?;
    if let Some(radiance) = light.radiance {
        write!(out, " rgb {}", rgb(radiance))?;
    }
    let [a, b] = light.edges;
    writeln!(
        out,
        " {} {} {} end light",
        point(light.corner),
        point(a),
        point(b)
    )?;
    light
        .notes
        .light
        .iter()
        .try_for_each(|l| surface_light(out, l))
}

fn primitive(out: &mut GrfOutput<'_>, primitive: &PrimitiveBlock) -> io::Result<()> {
    object(out, &primitive.notes, None)?;
    out.write_all(b"ext primitive begin")?;
    unit_primitive(out, primitive.kind, &primitive.map)?;
    key(out, "material", primitive.notes.material.as_ref())?;
    out.write_all(b" end ext\n")?;
    primitive
        .notes
        .light
        .iter()
        .try_for_each(|l| surface_light(out, l))
}

/// Writes the keys of a primitive's kind and map.
pub(super) fn unit_primitive(
    out: &mut GrfOutput<'_>,
    kind: PrimitiveKind,
    map: &DAffine3,
) -> io::Result<()> {
    let word = match kind {
        PrimitiveKind::Sphere => "sphere",
        PrimitiveKind::Cylinder => "cylinder",
        PrimitiveKind::Cone { .. } => "cone",
        PrimitiveKind::Tube { .. } => "tube",
        PrimitiveKind::Cuboid => "box",
        PrimitiveKind::Square => "parallelogram",
    };
    write!(out, " kind = {word}")?;
    if let PrimitiveKind::Cone { top } | PrimitiveKind::Tube { top } = kind {
        key(out, "top", Some(Number(top)))?;
    }
    affine_map(out, map)
}

/// `map = ` and its twelve numbers.
pub(super) fn affine_map(out: &mut GrfOutput<'_>, map: &DAffine3) -> io::Result<()> {
    out.write_all(b" map =")?;
    let numbers = map.to_cols_array();
    numbers
        .iter()
        .try_for_each(|&number| write!(out, " {}", Number(number)))
}

fn units(out: &mut GrfOutput<'_>, units: &Units) -> io::Result<()> {
    out.write_all(b"ext units begin")?;
    key(out, "metres_per_unit", units.metres_per_unit.map(Number))?;
    key(out, "up", (units.up == Up::Z).then_some("z"))?;
    writeln!(out, " photometric = {} end ext", units.photometric)
}

/// An angle in degrees, or in radians under another key if degrees would lose a bit.
struct Angle<'a>(&'a str, f64);

impl fmt::Display for Angle<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Angle(key, radians) = *self;
        let near = radians.to_degrees();
        let candidates = [
            (near * 1e9).round() / 1e9,
            near,
            near.next_up(),
            near.next_down(),
        ];
        match candidates.into_iter().find(|d| d.to_radians() == radians) {
            Some(degrees) => write!(f, "{key} = {}", Number(degrees)),
            None => write!(f, "{key}_radians = {}", Number(radians)),
        }
    }
}

fn camera(out: &mut GrfOutput<'_>, camera: &Camera) -> io::Result<()> {
    writeln!(
        out,
        "ext camera begin\nname = {}\neye = {}\ntarget = {}\nup = {}\n{}",
        Quoted(&camera.name),
        point(camera.eye),
        point(camera.target),
        point(camera.up),
        Angle("fov", camera.vertical_fov),
    )?;
    if let Some((width, height)) = camera.size {
        writeln!(out, "size = {width} {height}")?;
    }
    out.write_all(b"end ext\n")
}

fn light(out: &mut GrfOutput<'_>, light: &Light) -> io::Result<()> {
    write!(
        out,
        "ext light begin name = {} kind = ",
        Quoted(&light.name)
    )?;
    match light.kind {
        LightKind::Point {
            position,
            intensity,
        } => write!(
            out,
            "point position = {} intensity = {}",
            point(position),
            rgb(intensity)
        ),
        LightKind::Spot {
            position,
            direction,
            intensity,
            inner,
            outer,
        } => write!(
            out,
            "spot position = {} direction = {} intensity = {} {} {}",
            point(position),
            point(direction),
            rgb(intensity),
            Angle("inner", inner),
            Angle("outer", outer),
        ),
        LightKind::Luminaire {
            position,
            ref world_from_web,
            scale,
            ref web,
        } => luminaire::write(out, position, world_from_web, scale, web),
        LightKind::Directional {
            direction,
            irradiance,
            half_angle,
        } => {
            let (direction, irradiance) = (point(direction), rgb(irradiance));
            write!(
                out,
                "directional direction = {direction} irradiance = {irradiance}"
            )?;
            if half_angle > 0.0 {
                write!(out, " {}", Angle("half_angle", half_angle))?;
            }
            Ok(())
        }
        // It is a block of its own, because its picture has a path.
        LightKind::Environment(_) => Ok(()),
        LightKind::Ambient { radiance } => write!(out, "ambient radiance = {}", rgb(radiance)),
    }?;
    out.write_all(b" end ext\n")
}

fn write_finish(out: &mut GrfOutput<'_>, finish: &FinishNote) -> io::Result<()> {
    let (metallic, roughness) = (Number(finish.metallic), Number(finish.roughness));
    write!(
        out,
        " base = {} metallic = {metallic} roughness = {roughness}",
        rgb(finish.base)
    )?;
    let pictures = [
        ("metallic", &finish.metallic_picture),
        ("roughness", &finish.roughness_picture),
    ];
    for (of, picture) in pictures {
        if let Some((name, channel)) = picture {
            let channel = match channel {
                PictureChannel::Red => "red",
                PictureChannel::Green => "green",
                PictureChannel::Blue => "blue",
            };
            write!(out, " {of}_texture = {name} {of}_channel = {channel}")?;
        }
    }
    Ok(())
}

fn material(out: &mut GrfOutput<'_>, note: &MaterialNote) -> io::Result<()> {
    write!(out, "ext material begin of = {}", note.of)?;
    key(out, "name", note.name.as_deref().map(Quoted))?;
    key(out, "diffuse", note.diffuse.map(rgb))?;
    key(out, "mirror", note.mirror.map(rgb))?;
    key(out, "emission", note.emission.map(rgb))?;
    key(out, "emission_texture", note.emission_texture.as_ref())?;
    key(out, "emits_back", note.emits_back.then_some(true))?;
    key(out, "ior", note.ior.map(Number))?;
    key(out, "transmittance", note.transmittance.map(rgb))?;
    key(out, "thin", note.thin.then_some(true))?;
    let sides = match note.sidedness {
        Sidedness::Unsaid => None,
        Sidedness::One => Some("one"),
        Sidedness::Two => Some("two"),
    };
    key(out, "sides", sides)?;
    if let Some(Description::File { path, .. }) = note.brdf_file.as_ref().map(|r| &r.description) {
        key(out, "brdf_file", Some(Quoted(path)))?;
    }
    if let Some(opacity) = &note.opacity {
        write_opacity(out, opacity)?;
    }
    if let Some(finish) = &note.finish {
        write_finish(out, finish)?;
    }
    match &note.relief {
        None => {}
        Some((name, ReliefKind::Normals { scale })) => {
            key(out, "normal_texture", Some(name))?;
            key(out, "normal_scale", Some(Number(*scale)))?;
        }
        Some((name, ReliefKind::Heights { slope })) => {
            key(out, "bump_texture", Some(name))?;
            key(out, "bump_slope", Some(Number(*slope)))?;
        }
    }
    match note.textures.as_deref() {
        None => {}
        Some([]) => out.write_all(b" textures = none")?,
        Some(names) => {
            out.write_all(b" textures =")?;
            names.iter().try_for_each(|name| write!(out, " {name}"))?;
        }
    }
    out.write_all(b" end ext\n")
}

fn write_opacity(out: &mut GrfOutput<'_>, opacity: &OpacityNote) -> io::Result<()> {
    key(out, "opacity", Some(Number(opacity.constant)))?;
    if let Some((name, channel)) = &opacity.picture {
        key(out, "opacity_texture", Some(name))?;
        let is_luminance = *channel == OpacityChannel::Luminance;
        key(out, "opacity_channel", is_luminance.then_some("luminance"))?;
    }
    match opacity.mode {
        OpacityMode::Mask { cutoff } => key(out, "cutoff", Some(Number(cutoff))),
        _ => Ok(()),
    }
}

/// Writes a key of an extension that has a value.
fn key(out: &mut GrfOutput<'_>, key: &str, value: Option<impl fmt::Display>) -> io::Result<()> {
    match value {
        Some(value) => write!(out, " {key} = {value}"),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(number: f64, expected: &str) {
        assert_eq!(Number(number).to_string(), expected);
        assert_eq!(
            expected.parse::<f64>().map(f64::to_bits),
            Ok(number.to_bits())
        );
    }

    #[test]
    fn numbers_are_short_and_exact() {
        check(1.0, "1");
        check(-0.0, "-0");
        check(0.1, "0.1");
        check(1.0 / 3.0, "0.3333333333333333");
        check(1e300, "1e300");
        check(-2.5e-7, "-2.5e-7");
        check(f64::MIN_POSITIVE, "2.2250738585072014e-308");
        check(f64::MAX, "1.7976931348623157e308");
    }

    #[test]
    fn angles_are_degrees_where_degrees_are_exact() {
        assert_eq!(Angle("fov", 40f64.to_radians()).to_string(), "fov = 40");
        let radians = 1.0_f64.next_up();
        let text = Angle("fov", radians).to_string();
        let (_, number) = text.split_once(" = ").unwrap();
        let number: f64 = number.parse().unwrap();
        let read = if text.contains("radians") {
            number
        } else {
            number.to_radians()
        };
        assert_eq!(read, radians, "{text}");
    }
}
