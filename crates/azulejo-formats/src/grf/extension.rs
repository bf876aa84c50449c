//! `ext name begin key = value ... end ext`: what GRF itself cannot express.
//!
//! docs/formats/grf.md lists every extension with its keys.

use super::appearance::MOST_TEXTURES;
use super::document::{
    BlockKind, BoxedError, FinishNote, GrfBlock, GrfName, MaterialNote, NameKind, ObjectNotes,
    OpacityNote, PrimitiveBlock,
};
use super::entries::{EntryValue, GrfEntries, GrfEntry, Taken};
use super::parser::{GrfParser, ParseResult};
use super::solids::is_solid;
use azulejo_scene::{
    BackIrradiance, Camera, Fog, Light, LightKind, OpacityChannel, OpacityMode, PictureChannel,
    PrimitiveKind, ReliefKind, Rgb, Sidedness, SurfaceGrid, SurfaceLight, Units, Up, WrapMode,
};
use glam::DAffine3;

/// Maximum number of cells along one direction of a solved primitive, small enough for its square
/// to be a count.
const MOST_CELLS: f64 = 65_536.0;

/// The result of reading an extension.
pub(super) enum Extension {
    /// A block of its own.
    Block(Box<BlockKind>),
    /// `ext object`, which applies to the object that follows.
    Names(Box<ObjectNotes>),
    /// It was applied to the preceding object.
    Noted,
}

impl<'a> GrfParser<'a, '_, '_> {
    /// Reads an extension; `before` is the preceding block.
    pub fn extension(&mut self, before: Option<&mut GrfBlock>) -> ParseResult<Extension> {
        let offset = self.lexer.skip_blank();
        self.expect_word("ext")?;
        let Some(name) = self.lexer.word() else {
            return Err(self.unexpected("the name of an extension"));
        };
        self.expect_word("begin")?;
        let lower = name.to_ascii_lowercase();
        if !KNOWN.split(' ').any(|known| known == lower) && !is_solid(&lower) {
            let text = self.unknown_text(offset)?;
            let name = name.to_owned();
            return Ok(Extension::Block(Box::new(BlockKind::Unknown {
                name,
                text,
            })));
        }
        if let Some(block) = self.nesting(&lower, offset)? {
            return Ok(Extension::Block(Box::new(block)));
        }
        if lower == "skin" {
            self.skin(offset, before)?;
            return Ok(Extension::Noted);
        }
        let mut entries = self.entries(&lower, offset)?;
        let known = self.known(&lower, &mut entries, before)?;
        self.warn_of_rest(&entries);
        Ok(known)
    }

    /// Reads the extensions that contain more than keys and values.
    fn nesting(&mut self, name: &str, offset: usize) -> ParseResult<Option<BlockKind>> {
        match name {
            "figure" => self.figure(offset).map(Some),
            "define" => self.solid_definition(offset).map(Some),
            _ if is_solid(name) => self.exact(name, offset).map(Some),
            _ => Ok(None),
        }
    }

    /// The text of an unknown extension, up to `end ext`.
    fn unknown_text(&mut self, offset: usize) -> ParseResult<String> {
        let start = self.lexer.skip_blank();
        loop {
            let here = self.lexer.skip_blank();
            let mut ahead = self.lexer;
            if ahead.eat_word("end") && ahead.eat_word("ext") {
                self.lexer = ahead;
                let text = self.lexer.text()[start..here].trim_end().to_owned();
                self.record_opaque(start, start + text.len());
                return Ok(text);
            }
            if !self.lexer.skip_any() {
                let line = self.place(offset).line;
                return Err(self.unexpected(format!(
                    "`end ext` for the block that begins in line {line}"
                )));
            }
        }
    }

    fn known(
        &mut self,
        name: &str,
        entries: &mut GrfEntries<'a>,
        before: Option<&mut GrfBlock>,
    ) -> ParseResult<Extension> {
        let block = match name {
            "units" => BlockKind::Units(self.units(entries)?),
            "camera" => BlockKind::Camera(self.camera(entries)?),
            "background" => match self.take_rgb(entries, "color")? {
                Some(color) => BlockKind::Background(color),
                None => self.background(entries)?,
            },
            "fog" => BlockKind::Fog(self.fog(entries)?),
            "light" => self.light(entries)?,
            "material" => BlockKind::Material(Box::new(self.material_note(entries)?)),
            "texture" => {
                let of = self.needed_name(entries, "of", NameKind::Texture)?;
                let path = self.take_text(entries, "path")?;
                BlockKind::Texture {
                    of,
                    path: self.required(entries, "path", path)?,
                    wrap: self.take_wrap(entries)?,
                }
            }
            "primitive" => BlockKind::Primitive(Box::new(self.primitive(entries)?)),
            "mesh_instance" => BlockKind::MeshInstance(Box::new(self.mesh_instance(entries)?)),
            "object" => {
                return Ok(Extension::Names(Box::new(ObjectNotes {
                    name: self.take_text(entries, "name")?.unwrap_or_default(),
                    material: self.take_name(entries, "material", NameKind::Brdf)?,
                    ..ObjectNotes::default()
                })));
            }
            _ => {
                self.note_object(name, entries, before)?;
                return Ok(Extension::Noted);
            }
        };
        Ok(Extension::Block(Box::new(block)))
    }

    fn units(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<Units> {
        let mut units = Units::default();
        if let Some((metres, offset)) = self.take_number(entries, "metres_per_unit")? {
            if metres <= 0.0 {
                return Err(self.fail(
                    offset,
                    format!("{metres} metres per unit"),
                    "a positive length",
                ));
            }
            units.metres_per_unit = Some(metres);
        }
        units.photometric = self.take_flag(entries, "photometric")?;
        let up = self.take_choice(entries, "up", &[("y", Up::Y), ("z", Up::Z)])?;
        units.up = up.unwrap_or(units.up);
        Ok(units)
    }

    fn fog(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<Fog> {
        let color = self.needed_rgb(entries, "color")?;
        let visibility = self.take_number(entries, "visibility")?;
        let visibility = match visibility {
            Some((far, offset)) if far <= 0.0 => {
                return Err(self.fail(offset, format!("a visibility of {far}"), "above 0"));
            }
            other => other.map(|(far, _)| far),
        };
        Ok(Fog {
            color,
            visibility: self.required(entries, "visibility", visibility)?,
            exponential: self.take_flag(entries, "exponential")?,
        })
    }

    /// `key = true` or `key = false`, which is the default.
    fn take_flag(&mut self, entries: &mut GrfEntries<'a>, key: &str) -> ParseResult<bool> {
        let flag = self.take_choice(entries, key, &[("true", true), ("false", false)])?;
        Ok(flag.unwrap_or(false))
    }

    fn camera(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<Camera> {
        let eye = self.take_point(entries, "eye")?;
        let target = self.take_point(entries, "target")?;
        let up = self.take_point(entries, "up")?;
        let fov = self.take_angle(entries, "fov")?;
        let camera = Camera {
            name: self.take_text(entries, "name")?.unwrap_or_default(),
            eye: self.required(entries, "eye", eye)?,
            target: self.required(entries, "target", target)?,
            up: self.required(entries, "up", up)?,
            vertical_fov: self.required(entries, "fov", fov)?,
            size: self.take_size(entries)?,
        };
        if super::is_camera(&camera) {
            return Ok(camera);
        }
        Err(self.fail(
            entries.offset,
            "a camera with a degenerate view",
            "eye, target and up that span a plane, and a field of view between 0 and 180 degrees",
        ))
    }

    fn take_size(&mut self, entries: &mut GrfEntries<'a>) -> Taken<(u32, u32)> {
        let Some(entry) = entries.take("size") else {
            return Ok(None);
        };
        let pixels = |n: f64| (n >= 1.0 && n <= f64::from(u32::MAX)).then_some(n as u32);
        if let EntryValue::Numbers(numbers) = &entry.value
            && let [width, height] = numbers[..]
            && let (Some(width), Some(height)) = (pixels(width), pixels(height))
        {
            return Ok(Some((width, height)));
        }
        Err(self.wrong(&entry, "two numbers of pixels, at least 1"))
    }

    fn light(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<BlockKind> {
        let name = self.take_text(entries, "name")?.unwrap_or_default();
        let (kind, offset) = self.needed_word(entries, "kind")?;
        let kind = match kind {
            "point" => LightKind::Point {
                position: self.needed_point(entries, "position")?,
                intensity: self.needed_rgb(entries, "intensity")?,
            },
            "spot" => self.spot(entries)?,
            "luminaire" => self.luminaire(entries)?,
            "directional" => LightKind::Directional {
                direction: self.needed_direction(entries)?,
                irradiance: self.needed_rgb(entries, "irradiance")?,
                half_angle: self.half_angle(entries)?,
            },
            "environment" => return self.environment(entries, Some(name)),
            "ambient" => LightKind::Ambient {
                radiance: self.needed_rgb(entries, "radiance")?,
            },
            _ => {
                return Err(self.fail(
                    offset,
                    format!("`{kind}`"),
                    "`point`, `spot`, `luminaire`, `directional`, `ambient` or `environment`",
                ));
            }
        };
        Ok(BlockKind::Light(Light { name, kind }))
    }

    fn half_angle(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<f64> {
        let half_angle = self.take_angle(entries, "half_angle")?.unwrap_or(0.0);
        if (0.0..std::f64::consts::FRAC_PI_2).contains(&half_angle) {
            return Ok(half_angle);
        }
        Err(self.fail(
            entries.offset,
            "a light of an impossible size",
            "a half_angle of 0 to 90 degrees",
        ))
    }

    fn spot(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<LightKind> {
        let inner = self.take_angle(entries, "inner")?;
        let outer = self.take_angle(entries, "outer")?;
        let inner = self.required(entries, "inner", inner)?;
        let outer = self.required(entries, "outer", outer)?;
        if !(0.0 <= inner && inner <= outer && outer <= std::f64::consts::PI + 1e-12) {
            return Err(self.fail(
                entries.offset,
                "a spot light with invalid angles",
                "0 <= inner <= outer <= 180 degrees",
            ));
        }
        Ok(LightKind::Spot {
            position: self.needed_point(entries, "position")?,
            direction: self.needed_direction(entries)?,
            intensity: self.needed_rgb(entries, "intensity")?,
            inner,
            outer,
        })
    }

    /// The brdf that a note completes, which does not use it.
    fn annotated_name(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<GrfName> {
        let count = |parser: &Self| parser.shared.layout.as_ref().map_or(0, |l| l.uses.len());
        let before = count(self);
        let of = self.needed_name(entries, "of", NameKind::Brdf)?;
        if count(self) > before
            && let Some(layout) = &mut self.shared.layout
        {
            layout.uses.remove(&(NameKind::Brdf, of.clone()));
        }
        Ok(of)
    }

    fn material_note(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<MaterialNote> {
        let of = self.annotated_name(entries)?;
        let name = self.take_text(entries, "name")?;
        let diffuse = self.take_reflectance(entries, "diffuse")?;
        let mirror = self.take_reflectance(entries, "mirror")?;
        let emission = self.take_rgb(entries, "emission")?;
        let transmittance = self.take_reflectance(entries, "transmittance")?;
        let ior = self.take_number(entries, "ior")?;
        if let Some((ior, offset)) = ior
            && ior <= 0.0
        {
            return Err(self.fail(
                offset,
                format!("an index of refraction of {ior}"),
                "a positive number",
            ));
        }
        Ok(MaterialNote {
            of,
            name,
            diffuse,
            mirror,
            emission,
            emission_texture: self.take_name(entries, "emission_texture", NameKind::Texture)?,
            emits_back: self.take_flag(entries, "emits_back")?,
            ior: ior.map(|(ior, _)| ior),
            transmittance,
            thin: self.take_flag(entries, "thin")?,
            sidedness: self.take_sides(entries)?,
            textures: self.take_textures(entries)?,
            brdf_file: self.take_brdf_file(entries)?,
            opacity: self.take_opacity(entries)?,
            finish: self.take_finish(entries)?,
            relief: self.take_relief(entries)?,
        })
    }

    /// `wrap` with the ways of u and v; they repeat without it.
    fn take_wrap(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<[WrapMode; 2]> {
        let Some(entry) = entries.take("wrap") else {
            return Ok([WrapMode::Repeat; 2]);
        };
        let mode = |word: &str| match word {
            "repeat" => Some(WrapMode::Repeat),
            "clamp" => Some(WrapMode::Clamp),
            "mirror" => Some(WrapMode::Mirror),
            _ => None,
        };
        if let EntryValue::Words(words) = &entry.value
            && let [u, v] = words[..]
            && let (Some(u), Some(v)) = (mode(u), mode(v))
        {
            return Ok([u, v]);
        }
        Err(self.wrong(&entry, "two of the words `repeat`, `clamp` and `mirror`"))
    }

    /// `opacity`, `opacity_texture`, `opacity_channel` and `cutoff`, of which any may be missing.
    fn take_opacity(&mut self, entries: &mut GrfEntries<'a>) -> Taken<OpacityNote> {
        let constant = self.take_number(entries, "opacity")?;
        if let Some((value, offset)) = constant
            && !(0.0..=1.0).contains(&value)
        {
            return Err(self.fail(offset, format!("an opacity of {value}"), "0 to 1"));
        }
        let texture = self.take_name(entries, "opacity_texture", NameKind::Texture)?;
        let channel = self.take_choice(entries, "opacity_channel", &OPACITY_CHANNELS)?;
        let channel = channel.unwrap_or(OpacityChannel::Alpha);
        let cutoff = self.take_number(entries, "cutoff")?;
        if let Some((value, offset)) = cutoff
            && value < 0.0
        {
            return Err(self.fail(offset, format!("a cutoff of {value}"), "at least 0"));
        }
        if constant.is_none() && texture.is_none() && cutoff.is_none() {
            return Ok(None);
        }
        Ok(Some(OpacityNote {
            constant: constant.map_or(1.0, |(value, _)| value),
            picture: texture.map(|name| (name, channel)),
            mode: match cutoff {
                Some((cutoff, _)) => OpacityMode::Mask { cutoff },
                None => OpacityMode::Blend,
            },
        }))
    }

    /// `base`, `metallic`, `roughness`, and the pictures of the last two; `None` without `base`.
    fn take_finish(&mut self, entries: &mut GrfEntries<'a>) -> Taken<FinishNote> {
        let base = self.take_reflectance(entries, "base")?;
        let metallic = self.take_share(entries, "metallic")?;
        let roughness = self.take_share(entries, "roughness")?;
        let metallic_picture =
            self.take_numbers(entries, ["metallic_texture", "metallic_channel"])?;
        let roughness_picture =
            self.take_numbers(entries, ["roughness_texture", "roughness_channel"])?;
        Ok(base.map(|base| FinishNote {
            base,
            metallic,
            roughness,
            metallic_picture,
            roughness_picture,
        }))
    }

    /// A number in 0..=1; 1 if it is missing.
    fn take_share(&mut self, entries: &mut GrfEntries<'a>, key: &'static str) -> ParseResult<f64> {
        match self.take_number(entries, key)? {
            Some((value, offset)) if !(0.0..=1.0).contains(&value) => {
                Err(self.fail(offset, format!("{value}"), "0 to 1"))
            }
            share => Ok(share.map_or(1.0, |(value, _)| value)),
        }
    }

    /// A texture and its channel, which is `red` if it is missing.
    fn take_numbers(
        &mut self,
        entries: &mut GrfEntries<'a>,
        [texture, channel]: [&'static str; 2],
    ) -> ParseResult<Option<(GrfName, PictureChannel)>> {
        let name = self.take_name(entries, texture, NameKind::Texture)?;
        let channel = self.take_choice(entries, channel, &PICTURE_CHANNELS)?;
        Ok(name.map(|name| (name, channel.unwrap_or(PictureChannel::Red))))
    }

    /// `normal_texture` with `normal_scale`, or `bump_texture` with `bump_slope`.
    fn take_relief(&mut self, entries: &mut GrfEntries<'a>) -> Taken<(GrfName, ReliefKind)> {
        let normals = self.take_name(entries, "normal_texture", NameKind::Texture)?;
        let scale = self.take_number(entries, "normal_scale")?;
        let heights = self.take_name(entries, "bump_texture", NameKind::Texture)?;
        let slope = self.take_number(entries, "bump_slope")?;
        let [scale, slope] = [scale, slope].map(|given| given.map_or(1.0, |(value, _)| value));
        let normals = normals.map(|name| (name, ReliefKind::Normals { scale }));
        Ok(normals.or(heights.map(|name| (name, ReliefKind::Heights { slope }))))
    }

    fn take_sides(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<Sidedness> {
        let sides = [("one", Sidedness::One), ("two", Sidedness::Two)];
        Ok((self.take_choice(entries, "sides", &sides)?).unwrap_or(Sidedness::Unsaid))
    }

    fn take_textures(&mut self, entries: &mut GrfEntries<'a>) -> Taken<Vec<GrfName>> {
        let Some(entry) = entries.take("textures") else {
            return Ok(None);
        };
        let EntryValue::Words(words) = &entry.value else {
            return Err(self.wrong(&entry, "names of textures, or `none`"));
        };
        if words.len() > MOST_TEXTURES {
            return Err(self.wrong(
                &entry,
                &format!("at most {MOST_TEXTURES} names of textures"),
            ));
        }
        if words[..] == ["none"] {
            return Ok(Some(Vec::new()));
        }
        let mut names = Vec::new();
        for word in words {
            let name = self.shared.intern(word);
            self.note_use(entry.offset, NameKind::Texture, &name);
            names.push(name);
        }
        Ok(Some(names))
    }

    fn primitive(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<PrimitiveBlock> {
        let (kind, map) = self.unit_primitive(entries)?;
        Ok(PrimitiveBlock {
            kind,
            map,
            notes: ObjectNotes {
                material: self.take_name(entries, "material", NameKind::Brdf)?,
                ..ObjectNotes::default()
            },
        })
    }

    /// The kind of a primitive and its map.
    pub fn unit_primitive(
        &mut self,
        entries: &mut GrfEntries<'a>,
    ) -> ParseResult<(PrimitiveKind, DAffine3)> {
        let (word, offset) = self.needed_word(entries, "kind")?;
        let kind = match word {
            "sphere" => PrimitiveKind::Sphere,
            "cylinder" => PrimitiveKind::Cylinder,
            "box" => PrimitiveKind::Cuboid,
            "parallelogram" => PrimitiveKind::Square,
            "cone" => PrimitiveKind::Cone {
                top: self.top(entries, 0.0)?,
            },
            "tube" => PrimitiveKind::Tube {
                top: self.top(entries, 1.0)?,
            },
            _ => {
                return Err(self.fail(
                    offset,
                    format!("`{word}`"),
                    "`sphere`, `cylinder`, `cone`, `tube`, `box` or `parallelogram`",
                ));
            }
        };
        Ok((kind, self.map(entries, kind)?))
    }

    fn top(&mut self, entries: &mut GrfEntries<'a>, default: f64) -> ParseResult<f64> {
        let top = self.take_number(entries, "top")?;
        let (top, offset) = top.unwrap_or((default, entries.offset));
        if (0.0..=1.0).contains(&top) {
            return Ok(top);
        }
        Err(self.fail(
            offset,
            format!("a cone or tube with the top radius {top}"),
            "a radius from 0 to 1; the base has radius 1",
        ))
    }

    pub fn map(
        &mut self,
        entries: &mut GrfEntries<'a>,
        kind: PrimitiveKind,
    ) -> ParseResult<DAffine3> {
        let entry = self.needed(entries, "map")?;
        let is_placing = |map: &DAffine3| super::is_invertible(kind, map);
        match entry.value.map().filter(is_placing) {
            Some(map) => Ok(map),
            None => Err(self.not_a_map(&entry)),
        }
    }

    #[cold]
    pub fn not_a_map(&mut self, entry: &GrfEntry<'_>) -> BoxedError {
        self.wrong(
            entry,
            "12 numbers, the images of the x, y and z axes and of the origin, that form an invertible map",
        )
    }

    /// Reads `smoothing`, `shared`, `shared_mesh`, `irad_error`, `irad_back` or `surface_light`, which apply to the preceding object.
    fn note_object(
        &mut self,
        name: &str,
        entries: &mut GrfEntries<'a>,
        before: Option<&mut GrfBlock>,
    ) -> ParseResult<()> {
        match (name, before.map(|block| &mut block.kind)) {
            ("smoothing", Some(BlockKind::Mesh(mesh))) => {
                let faces = mesh.faces.len();
                mesh.notes.smoothing = self.counts(entries, "groups", (faces, "face"))?;
            }
            ("shared", Some(BlockKind::Mesh(mesh))) => {
                let vertices = mesh.vertices.positions.len();
                mesh.notes.shared = self.shared(entries, vertices)?;
            }
            ("shared_mesh", Some(BlockKind::Mesh(mesh))) => {
                mesh.notes.shared_mesh = Some(self.shared_mesh(entries)?);
            }
            ("irad_error", Some(BlockKind::Mesh(mesh))) => {
                let vertices = mesh.vertices.positions.len();
                mesh.notes.irradiance_error = self.rgb_list(entries, "values", vertices)?;
            }
            ("irad_back", Some(BlockKind::Mesh(mesh))) if !mesh.vertices.irradiance.is_empty() => {
                let vertices = mesh.vertices.positions.len();
                mesh.notes.back = Some(Box::new(self.back_irradiance(entries, vertices)?));
            }
            ("irad_back", Some(BlockKind::Mesh(_))) => {
                let expected = "`irad` at the vertices of the mesh before it";
                return Err(self.fail(entries.offset, "`ext irad_back`", expected));
            }
            ("surface_light", Some(BlockKind::AreaLight(light))) => {
                light.notes.light = Some(Box::new(
                    self.surface_light(entries, PrimitiveKind::Square)?,
                ));
            }
            ("surface_light", Some(BlockKind::Primitive(primitive))) => {
                primitive.notes.light =
                    Some(Box::new(self.surface_light(entries, primitive.kind)?));
            }
            _ => {
                return Err(self.fail(
                    entries.offset,
                    format!("`ext {name}`"),
                    "its object immediately before it",
                ));
            }
        }
        Ok(())
    }

    /// The originals of the last of `count` vertices.
    fn shared(&mut self, entries: &mut GrfEntries<'a>, count: usize) -> ParseResult<Vec<u32>> {
        let entry = self.needed(entries, "vertices")?;
        if let EntryValue::Numbers(numbers) = &entry.value
            && numbers.len() <= count
        {
            let originals = (count - numbers.len()) as f64;
            let is_original = |n: &f64| (*n >= 0.0 && *n < originals).then_some(*n as u32);
            if let Some(list) = numbers.iter().map(is_original).collect() {
                return Ok(list);
            }
        }
        Err(self.wrong(
            &entry,
            "an original vertex for each copy at the end of the mesh",
        ))
    }

    /// `values` and `errors` at the backs of `vertices`, by default of all.
    fn back_irradiance(
        &mut self,
        entries: &mut GrfEntries<'a>,
        count: usize,
    ) -> ParseResult<BackIrradiance> {
        let vertices: Vec<usize> = match entries.take("vertices") {
            None => (0..count).collect(),
            Some(entry) => {
                let vertex = |n: &f64| (*n >= 0.0 && *n < count as f64).then_some(*n as usize);
                let list = match &entry.value {
                    EntryValue::Numbers(numbers) => numbers.iter().map(vertex).collect(),
                    _ => None,
                };
                match list {
                    Some(list) => list,
                    None => return Err(self.wrong(&entry, &format!("vertices below {count}"))),
                }
            }
        };
        let mut back = BackIrradiance {
            irradiance: vec![None; count],
            error: Vec::new(),
        };
        let values = self.rgb_list(entries, "values", vertices.len())?;
        for (&v, value) in vertices.iter().zip(values) {
            back.irradiance[v] = Some(value);
        }
        if entries.has("errors") {
            back.error = vec![Rgb::BLACK; count];
            let errors = self.rgb_list(entries, "errors", vertices.len())?;
            for (&v, error) in vertices.iter().zip(errors) {
                back.error[v] = error;
            }
        }
        Ok(back)
    }

    /// `count` integers, one for each of a number of parts.
    pub fn counts(
        &mut self,
        entries: &mut GrfEntries<'a>,
        key: &str,
        (count, part): (usize, &str),
    ) -> ParseResult<Vec<u32>> {
        let entry = match entries.take(key) {
            None if count == 0 => return Ok(Vec::new()),
            entry => self.required(entries, key, entry)?,
        };
        let group = |n: &f64| (*n >= 0.0 && *n <= f64::from(u32::MAX)).then_some(*n as u32);
        if let EntryValue::Numbers(numbers) = &entry.value
            && numbers.len() == count
            && let Some(groups) = numbers.iter().map(group).collect()
        {
            return Ok(groups);
        }
        Err(self.wrong(&entry, &format!("{count} integers, one per {part}")))
    }

    fn surface_light(
        &mut self,
        entries: &mut GrfEntries<'a>,
        kind: PrimitiveKind,
    ) -> ParseResult<SurfaceLight> {
        let grids = self.grids(entries, kind.parts())?;
        let count = grids.iter().map(SurfaceGrid::vertices).sum();
        let error = if entries.list.iter().any(|e| e.key == "error") {
            self.rgb_list(entries, "error", count)?
        } else {
            Vec::new()
        };
        Ok(SurfaceLight {
            irradiance: self.rgb_list(entries, "irradiance", count)?,
            grids,
            error,
        })
    }

    fn grids(
        &mut self,
        entries: &mut GrfEntries<'a>,
        parts: usize,
    ) -> ParseResult<Vec<SurfaceGrid>> {
        let entry = self.needed(entries, "grids")?;
        let is_count = |n: &f64| (1.0..=MOST_CELLS).contains(n);
        if let EntryValue::Numbers(numbers) = &entry.value
            && numbers.len() == 2 * parts
            && numbers.iter().all(is_count)
        {
            let grid = |pair: &[f64]| SurfaceGrid {
                nu: pair[0] as u32,
                nv: pair[1] as u32,
            };
            return Ok(numbers.chunks(2).map(grid).collect());
        }
        Err(self.wrong(
            &entry,
            &format!("{} cell counts, two for each part", 2 * parts),
        ))
    }

    /// `count` triples.
    pub fn rgb_list(
        &mut self,
        entries: &mut GrfEntries<'a>,
        key: &str,
        count: usize,
    ) -> ParseResult<Vec<Rgb>> {
        let entry = match entries.take(key) {
            // The key of an empty list has no value.
            None if count == 0 => return Ok(Vec::new()),
            entry => self.required(entries, key, entry)?,
        };
        match &entry.value {
            EntryValue::Vectors(list) if list.len() == count => Ok(list
                .iter()
                .map(|&v| self.not_negative(entry.offset, Rgb::from(v)))
                .collect()),
            _ => Err(self.wrong(&entry, &format!("{count} triples (r, g, b)"))),
        }
    }
}

/// The parts of a picture that an opacity may be, by their words.
const OPACITY_CHANNELS: [(&str, OpacityChannel); 2] = [
    ("alpha", OpacityChannel::Alpha),
    ("luminance", OpacityChannel::Luminance),
];

/// The channels of a picture, by their words.
const PICTURE_CHANNELS: [(&str, PictureChannel); 3] = [
    ("red", PictureChannel::Red),
    ("green", PictureChannel::Green),
    ("blue", PictureChannel::Blue),
];

/// The names of known extensions.
const KNOWN: &str = "mesh_instance shared_mesh units camera background fog light material texture primitive \
     object smoothing shared irad_error irad_back surface_light figure define skin";
