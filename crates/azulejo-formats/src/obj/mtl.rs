//! Material libraries.

use super::cursor::StatementCursor;
use super::placement::PicturePlacement;
use crate::reading::text::{decoded, shortened, text};
use crate::reading::warnings::Warnings;
use crate::surface::gloss::{Gloss, SMOOTHEST};
use crate::surface::phong::Highlight;
use crate::surface::textures::Textures;
use crate::{Files, Loaded, ReadError};
use azulejo_scene::{
    Dielectric, FinishMaps, Material, MaterialId, NumberPicture, Opacity, PictureChannel, Relief,
    ReliefKind, Rgb, Scene, TextureId, WrapMode,
};
use glam::DVec2;
use std::collections::HashMap;

/// Reflectance of faces without a material.
const DEFAULT_REFLECTANCE: Rgb = Rgb::grey(0.5);

/// Index of refraction of glass without `Ni`.
const DEFAULT_IOR: f64 = 1.5;

/// By how much shares that were scaled to a sum of 1 may exceed it.
const ROUNDING: f64 = 1e-12;

/// Reads a material library by itself: a scene with materials and textures, without objects.
///
/// # Errors
/// A malformed number, bytes that are not text.
pub fn read(bytes: &[u8], name: &str, files: &dyn Files) -> Result<Loaded, ReadError> {
    let (mut library, mut warnings) = (Library::default(), Warnings::default());
    library.add(bytes, name, files, &mut warnings)?;
    Ok(Loaded {
        scene: Scene {
            materials: library.materials,
            textures: library.textures.into_list(),
            ..Scene::default()
        },
        warnings: warnings.finish(name),
    })
}

/// The materials of one or more library files.
#[derive(Debug, Default)]
pub(super) struct Library {
    pub materials: Vec<Material>,
    pub textures: Textures,
    by_name: HashMap<String, MaterialId>,
    gloss: Gloss,
    /// Placements of the textures that deviate from the model's texture coordinates, by material.
    placements: HashMap<MaterialId, PicturePlacement>,
}

impl Library {
    /// The material of that name, or a new grey one, with a warning.
    pub fn find_or_default(
        &mut self,
        name: &str,
        file: &str,
        warnings: &mut Warnings,
    ) -> MaterialId {
        if let Some(&known) = self.by_name.get(name) {
            return known;
        }
        let message = "material that no library defines: taken as grey with reflectance 0.5";
        warnings.add_whole(file, format!("{message}, for \"{}\"", shortened(name)));
        self.insert(Material::diffuse(name, DEFAULT_REFLECTANCE))
    }

    /// The grey material of faces without `usemtl`.
    pub fn default_material(&mut self) -> MaterialId {
        let id = self.materials.len() as MaterialId;
        self.materials
            .push(Material::diffuse("default", DEFAULT_REFLECTANCE));
        id
    }

    /// The texture placement of a material; `None` if it follows the model's texture coordinates.
    pub fn placement(&self, material: MaterialId) -> Option<PicturePlacement> {
        self.placements.get(&material).copied()
    }

    fn insert(&mut self, material: Material) -> MaterialId {
        let id = self.materials.len() as MaterialId;
        self.by_name.insert(material.name.clone(), id);
        self.materials.push(material);
        id
    }

    /// Adds the materials of a file.
    ///
    /// # Errors
    /// As [`read`].
    pub fn add(
        &mut self,
        bytes: &[u8],
        file: &str,
        files: &dyn Files,
        warnings: &mut Warnings,
    ) -> Result<(), ReadError> {
        let bytes = &*decoded(bytes);
        let mut parser = MtlParser {
            cursor: StatementCursor::new(bytes, file)?,
            file,
            files,
            warnings,
            library: self,
        };
        let mut current: Option<Definition> = None;
        while let Some(keyword) = parser.cursor.keyword() {
            if keyword == b"newmtl" {
                let next = Definition::new(parser.cursor.name());
                if let Some(done) = current.replace(next) {
                    parser.define(done);
                }
            } else if let Some(definition) = &mut current {
                parser.statement(keyword, definition)?;
            } else {
                parser.warn("statement before the first newmtl: skipped");
            }
            parser.cursor.finish_statement();
        }
        if let Some(done) = current {
            parser.define(done);
        }
        Ok(())
    }
}

/// The content of a `newmtl` block; `None` for missing statements.
#[derive(Debug, Default)]
struct Definition {
    name: String,
    kd: Option<Rgb>,
    ks: Option<Rgb>,
    ke: Option<Rgb>,
    tf: Option<Rgb>,
    ns: Option<f64>,
    ni: Option<f64>,
    /// 1 minus the last `Tr`.
    tr: Option<f64>,
    d: Option<f64>,
    map_d: Option<TextureId>,
    illum: Option<f64>,
    roughness: Option<f64>,
    metallic: Option<f64>,
    map_kd: Option<TextureId>,
    map_ke: Option<TextureId>,
    map_pm: Option<NumberPicture>,
    map_pr: Option<NumberPicture>,
    relief: Option<Relief>,
    placement: PicturePlacement,
}

/// The options of a picture, which precede its file name.
struct PictureOptions {
    placement: PicturePlacement,
    wrap: WrapMode,
    /// `-bm`.
    bump: f64,
    /// `-imfchan`.
    channel: Option<PictureChannel>,
}

impl Definition {
    /// Whether a picture has determined the placement.
    fn has_picture(&self) -> bool {
        let pictures = [self.map_kd, self.map_d, self.map_ke];
        let numbers = self.map_pm.is_some() || self.map_pr.is_some();
        pictures.iter().any(Option::is_some) || numbers || self.relief.is_some()
    }

    fn new(name: String) -> Definition {
        Definition {
            name,
            ..Definition::default()
        }
    }
}

struct MtlParser<'a> {
    cursor: StatementCursor<'a>,
    file: &'a str,
    files: &'a dyn Files,
    warnings: &'a mut Warnings,
    library: &'a mut Library,
}

impl MtlParser<'_> {
    #[cold]
    fn warn(&mut self, message: impl Into<String>) {
        let cursor = &self.cursor;
        self.warnings
            .add(self.file, message.into(), || cursor.position());
    }

    fn statement(&mut self, keyword: &[u8], m: &mut Definition) -> Result<(), ReadError> {
        match keyword {
            b"Kd" => m.kd = self.color()?.or(m.kd),
            b"Ks" => m.ks = self.color()?.or(m.ks),
            b"Ke" => m.ke = self.color()?.or(m.ke),
            b"Tf" => m.tf = self.color()?.or(m.tf),
            b"Ns" => m.ns = Some(self.number()?),
            b"Ni" => m.ni = Some(self.number()?),
            b"illum" => m.illum = Some(self.number()?),
            b"d" => m.d = Some(self.opacity()?),
            b"Tr" => m.tr = Some(1.0 - self.number()?),
            b"Pr" => m.roughness = Some(self.number()?),
            b"Pm" => m.metallic = Some(self.number()?),
            b"Ps" | b"Pc" | b"Pcr" | b"aniso" | b"anisor" => self.unless_zero(keyword),
            b"map_Kd" => {
                let options = self.options(keyword);
                if let Some(picture) = self.texture(options.wrap) {
                    (m.map_kd, m.placement) = (Some(picture), options.placement);
                }
            }
            b"map_d" => m.map_d = self.further(keyword, m).or(m.map_d),
            b"map_Ke" => m.map_ke = self.further(keyword, m).or(m.map_ke),
            b"map_Pm" => m.map_pm = self.numbers(keyword, m).or(m.map_pm),
            b"map_Pr" => m.map_pr = self.numbers(keyword, m).or(m.map_pr),
            b"norm" | b"map_Bump" | b"map_bump" | b"bump" => {
                m.relief = self.relief(keyword, m).or(m.relief);
            }
            // Ambient reflectance stands for indirect light, which azulejo computes; `sharpness`
            // applies to environment maps, which it does not use.
            b"Ka" | b"map_Ka" | b"sharpness" => {}
            _ => self.unused(keyword),
        }
        Ok(())
    }

    /// A required finite number.
    fn number(&mut self) -> Result<f64, ReadError> {
        self.cursor.skip_blanks();
        let start = self.cursor.offset();
        match self.cursor.number()? {
            Some(n) if n.value.is_finite() => Ok(n.value),
            _ => Err(self.cursor.error_at(start, "a finite number")),
        }
    }

    /// A statement that has no effect if it is zero, as Blender writes it for most materials.
    fn unless_zero(&mut self, keyword: &[u8]) {
        self.cursor.skip_blanks();
        if self.cursor.plain_numbers() != Some([0.0]) {
            self.unused(keyword);
        }
    }

    fn unused(&mut self, keyword: &[u8]) {
        let word = shortened(&text(keyword));
        self.warn(format!("\"{word}\" is not used: skipped"));
    }

    /// `d value` or `d -halo value`.
    fn opacity(&mut self) -> Result<f64, ReadError> {
        let mut ahead = self.cursor.clone();
        if ahead.word() == Some(b"-halo") {
            self.cursor = ahead;
            self.warn("\"-halo\" is not used: skipped");
        }
        self.number()
    }

    /// One number for grey or three, or `xyz` or `spectral`, which are skipped with a warning.
    fn color(&mut self) -> Result<Option<Rgb>, ReadError> {
        let mut ahead = self.cursor.clone();
        if let Some(b"xyz" | b"spectral") = ahead.word() {
            self.warn("colour as CIE xyz or spectrum: skipped");
            return Ok(None);
        }
        let r = self.number()?;
        if self.cursor.at_end() {
            return Ok(Some(Rgb::grey(r)));
        }
        Ok(Some(Rgb::new(r, self.number()?, self.number()?)))
    }

    /// A picture beside that of the colour, in whose place it is drawn if there is one.
    fn further(&mut self, keyword: &[u8], m: &mut Definition) -> Option<TextureId> {
        let options = self.options(keyword);
        self.placed(keyword, &options, m)
    }

    /// The picture after options; warns if it is placed otherwise than others of the material.
    fn placed(
        &mut self,
        keyword: &[u8],
        options: &PictureOptions,
        m: &mut Definition,
    ) -> Option<TextureId> {
        let picture = self.texture(options.wrap)?;
        if !m.has_picture() {
            m.placement = options.placement;
        } else if m.placement != options.placement {
            let word = text(keyword);
            self.warn(format!(
                "{word} placed otherwise than map_Kd: placed as map_Kd"
            ));
        }
        Some(picture)
    }

    /// A picture of numbers: the channel by `-imfchan`, else the first, as pictures of numbers are grey.
    fn numbers(&mut self, keyword: &[u8], m: &mut Definition) -> Option<NumberPicture> {
        let options = self.options(keyword);
        let texture = self.placed(keyword, &options, m)?;
        let channel = options.channel.unwrap_or(PictureChannel::Red);
        Some(NumberPicture { texture, channel })
            .filter(|_| self.library.textures.is_loaded(texture))
    }

    /// A relief: `norm` names normals, the others heights; but Blender writes normals as `map_Bump`,
    /// which the bluish picture tells.
    fn relief(&mut self, keyword: &[u8], m: &mut Definition) -> Option<Relief> {
        let options = self.options(keyword);
        let texture = self.placed(keyword, &options, m)?;
        let mean = self.library.textures.numbers(texture)?.mean();
        let is_bluish = mean.z > 0.7 && (mean.x - 0.5).abs() < 0.15 && (mean.y - 0.5).abs() < 0.15;
        let factor = options.bump;
        let kind = if keyword == b"norm" || is_bluish {
            ReliefKind::Normals { scale: factor }
        } else {
            ReliefKind::Heights { slope: factor }
        };
        Some(Relief { texture, kind })
    }

    /// The texture named by a statement, after its options.
    fn texture(&mut self, wrap: WrapMode) -> Option<TextureId> {
        let name = self.cursor.name();
        if name.is_empty() {
            self.warn("map without a file: skipped");
            return None;
        }
        let (id, problem) = self.library.textures.index(self.file, &name, self.files);
        if let Some(problem) = problem {
            self.warn(problem);
        }
        Some(self.library.textures.wrapped(id, [wrap; 2]))
    }

    /// Options before the file name: `-s 1 1 1`, `-clamp on`... Those that would change the
    /// texture beyond its placement are skipped with a warning.
    fn options(&mut self, keyword: &[u8]) -> PictureOptions {
        // Some options apply only to pictures of relief or of single numbers.
        let is_relief = matches!(keyword, b"norm" | b"map_Bump" | b"map_bump" | b"bump");
        let is_number = matches!(keyword, b"map_Pr" | b"map_Pm");
        let mut options = PictureOptions {
            placement: PicturePlacement::default(),
            wrap: WrapMode::Repeat,
            bump: 1.0,
            channel: None,
        };
        loop {
            // Look ahead: the first word that names none of the options begins the name of the file.
            let mut ahead = self.cursor.clone();
            let Some(option) = ahead.word() else {
                return options;
            };
            // An option is plain if it has its full effect, or a value that changes nothing.
            let plain = match option {
                b"-s" | b"-o" | b"-t" => {
                    let mut given = vector(&mut ahead).into_iter();
                    let missing = f64::from(u8::from(option == b"-s"));
                    let [u, v] = [(); 2].map(|()| given.next().unwrap_or(missing));
                    let given = DVec2::new(u, v);
                    match option {
                        b"-s" => options.placement.scale = given,
                        b"-o" => options.placement.offset = given,
                        _ => {}
                    }
                    option != b"-t" || given == DVec2::ZERO
                }
                b"-mm" => [ahead.word(), ahead.word()] == [Some(&b"0"[..]), Some(&b"1"[..])],
                b"-clamp" => {
                    if ahead.word() == Some(b"on") {
                        options.wrap = WrapMode::Clamp;
                    }
                    true
                }
                b"-cc" => ahead.word() == Some(b"off"),
                b"-blendu" | b"-blendv" => ahead.word() == Some(b"on"),
                b"-bm" if is_relief => {
                    let factor = vector(&mut ahead).first().copied();
                    options.bump = factor.filter(|f| f.is_finite()).unwrap_or(1.0);
                    true
                }
                b"-imfchan" if is_number => {
                    options.channel = match ahead.word() {
                        Some(b"r") => Some(PictureChannel::Red),
                        Some(b"g") => Some(PictureChannel::Green),
                        Some(b"b") => Some(PictureChannel::Blue),
                        _ => None,
                    };
                    options.channel.is_some()
                }
                b"-texres" | b"-bm" | b"-boost" | b"-imfchan" | b"-type" | b"-colorspace" => {
                    ahead.word();
                    false
                }
                _ => return options,
            };
            let option = text(option).into_owned();
            self.cursor = ahead;
            if !plain {
                self.warn(format!("texture option \"{option}\" is not used: skipped"));
            }
        }
    }

    /// Converts a finished block to a material.
    fn define(&mut self, m: Definition) {
        let mut material = Material::default();
        (material.emission, material.emission_picture) = self.emission(&m);
        match self.surface(&m) {
            MtlSurface::Diffuse => self.diffuse(&m, &mut material),
            MtlSurface::Mirror => self.mirror(&m, &mut material),
            MtlSurface::Rough => self.rough(&m, &mut material),
            MtlSurface::Glass(ior) => self.glass(&m, ior, &mut material),
        }
        if material.dielectric.is_none() {
            material.opacity = self.see_through(&m);
        }
        material.textures.extend(m.map_kd);
        material.relief = m.relief;
        material.name = m.name;
        let id = match self.library.by_name.get(&material.name) {
            Some(&earlier) => {
                let what = "is defined again: the later definition is used";
                self.warn_about(&material.name, what);
                self.library.materials[earlier as usize] = material;
                earlier
            }
            None => self.library.insert(material),
        };
        if m.placement == PicturePlacement::default() {
            self.library.placements.remove(&id);
        } else {
            self.library.placements.insert(id, m.placement);
        }
    }

    /// `Ke`, white without it, times `map_Ke`: a picture that is missing or black emits nothing.
    fn emission(&mut self, m: &Definition) -> (Rgb, Option<TextureId>) {
        let Some(picture) = m.map_ke else {
            return (self.at_least_black(m.ke.unwrap_or_default(), m), None);
        };
        let emission = self.at_least_black(m.ke.unwrap_or(Rgb::WHITE), m);
        let image = self.library.textures.image(picture);
        let shines = image.is_some_and(|i| i.pixels.iter().any(|p| *p != [0.0; 3]));
        if shines && !emission.is_black() {
            (emission, Some(picture))
        } else {
            (Rgb::BLACK, None)
        }
    }

    /// A warning about a block that has ended.
    fn warn_about(&mut self, name: &str, what: &str) {
        let message = format!("material \"{}\" {what}", shortened(name));
        self.warnings.add_whole(self.file, message);
    }

    /// The surface type by `illum`, or by `Pm` and `Pr` of programs that do not write
    /// `illum`.
    fn surface(&mut self, m: &Definition) -> MtlSurface {
        let model = m.illum.unwrap_or(2.0);
        let ior = m.ni.filter(|ni| *ni > 1.0);
        let is_pictured = m.map_pm.is_some() || m.map_pr.is_some();
        let is_metal = m.metallic.is_some_and(|share| share > 0.0);
        let is_rough = is_metal || m.roughness.is_some() || is_pictured;
        match model as i64 {
            0..=5 if is_rough && (model != 4.0 || ior.is_none()) => MtlSurface::Rough,
            0..=2 => MtlSurface::Diffuse,
            3 | 5 => MtlSurface::Mirror,
            4 if ior.is_none() => {
                self.warnings.add_whole(
                    self.file,
                    "material with illum 4 and Ni of 1 or none, as Maya writes for every surface: taken as opaque",
                );
                MtlSurface::Diffuse
            }
            4 | 6 | 7 => {
                if ior.is_none() {
                    self.warn_about(&m.name, "is glass without an Ni above 1: taken as 1.5");
                }
                MtlSurface::Glass(ior.unwrap_or(DEFAULT_IOR))
            }
            _ => {
                self.warn_about(&m.name, "has an unknown illum: taken as diffuse");
                MtlSurface::Diffuse
            }
        }
    }

    /// `Pm` and `Pr` are glTF's metalness and roughness, with base colour `Kd`.
    fn rough(&mut self, m: &Definition, material: &mut Material) {
        let base = self.reflectance(m.kd.unwrap_or(missing_kd(m)), m);
        let share = |given: Option<f64>, missing: f64| given.unwrap_or(missing).clamp(0.0, 1.0);
        // A picture of a number multiplies 1 if the number is missing.
        let metallic = share(m.metallic, f64::from(u8::from(m.map_pm.is_some())));
        let roughness = share(m.roughness, 1.0);
        if m.roughness.is_none() && m.map_pr.is_none() {
            let message = "metal (Pm) without roughness (Pr): taken as fully rough";
            self.warnings.add_whole(self.file, message);
        }
        let mean = |picture: Option<NumberPicture>| {
            let numbers = picture.and_then(|p| self.library.textures.numbers(p.texture));
            let mean = numbers.zip(picture).map(|(n, p)| p.channel.of(n.mean()));
            mean.unwrap_or(1.0)
        };
        let means = [metallic * mean(m.map_pm), roughness * mean(m.map_pr)];
        let is_pictured = m.map_pm.is_some() || m.map_pr.is_some();
        let is_colored_metal = m.map_kd.is_some() && metallic > 0.0;
        let least = if is_pictured { SMOOTHEST } else { 0.0 };
        let gloss = &mut self.library.gloss;
        let made = gloss.metallic_roughness(material, base, means[0], means[1].max(least));
        let maps = FinishMaps {
            base,
            metallic,
            roughness,
            metallic_picture: m.map_pm,
            roughness_picture: m.map_pr,
        };
        let is_varied = (is_pictured || is_colored_metal) && material.brdf.is_some();
        material.finish = is_varied.then_some(maps);
        if is_colored_metal && !is_varied {
            let message = "texture (map_Kd) of a metal: mirror reflection uses only Kd";
            self.warnings.add_whole(self.file, message);
        }
        self.warn_if(made);
    }

    fn diffuse(&mut self, m: &Definition, material: &mut Material) {
        material.diffuse = self.reflectance(m.kd.unwrap_or(missing_kd(m)), m);
        if m.illum.unwrap_or(2.0) >= 2.0 {
            // A sum above 1 means a sharp and bright highlight.
            let ks = m.ks.unwrap_or_default();
            let highlight = Highlight::half(m.ns.unwrap_or(1.0), ks);
            let made = self.library.gloss.highlight(material, highlight);
            self.warn_if(made);
        }
    }

    /// The opacity of a surface other than glass: `d` or, without it, 1 − `Tr`, times `map_d`.
    fn see_through(&mut self, m: &Definition) -> Option<Opacity> {
        let given = match (m.d, m.tr) {
            // Several exporters write `Tr 1` for what is opaque, and nobody a surface that is not there.
            (None, Some(tr)) if tr <= 0.0 => {
                self.warn_about(
                    &m.name,
                    "has Tr 1 without d, which would be invisible: opaque",
                );
                1.0
            }
            (d, tr) => d.or(tr).unwrap_or(1.0),
        };
        let opacity = Opacity {
            picture: m.map_d.map(|id| self.library.textures.opacity(id)),
            ..Opacity::constant(given.clamp(0.0, 1.0))
        };
        (!opacity.is_opaque()).then_some(opacity)
    }

    fn warn_if(&mut self, made: Result<(), &'static str>) {
        if let Err(message) = made {
            self.warnings.add_whole(self.file, message);
        }
    }

    fn mirror(&mut self, m: &Definition, material: &mut Material) {
        let diffuse = self.reflectance(m.kd.unwrap_or_default(), m);
        let mirror = self.reflectance(m.ks.unwrap_or_default(), m);
        let most = (diffuse + mirror).max_channel();
        let exceeds = most > 1.0 + ROUNDING;
        let scale = if exceeds { 1.0 / most } else { 1.0 };
        if exceeds {
            self.warn_about(
                &m.name,
                "reflects more light than it receives (Kd + Ks > 1): both scaled down",
            );
        }
        (material.diffuse, material.mirror) = (diffuse * scale, mirror * scale);
    }

    fn glass(&mut self, m: &Definition, ior: f64, material: &mut Material) {
        let is_own = |kd: Rgb| !kd.is_black() && Some(kd) != m.tf;
        if m.kd.is_some_and(is_own) {
            let message = "Kd of a glass material: not used, the Fresnel equations determine reflectance and transmittance";
            self.warnings.add_whole(self.file, message);
        }
        material.mirror = Rgb::WHITE;
        material.dielectric = Some(Dielectric {
            ior,
            transmittance: self.reflectance(m.tf.unwrap_or(Rgb::WHITE), m),
            thin: false,
        });
    }

    /// A share of light, clamped to 0..=1.
    fn reflectance(&mut self, given: Rgb, m: &Definition) -> Rgb {
        let clamped = given.map(|c| c.clamp(0.0, 1.0));
        if clamped != given {
            self.warn_about(
                &m.name,
                "has a reflectance or transmittance outside 0..1: clamped",
            );
        }
        clamped
    }

    fn at_least_black(&mut self, given: Rgb, m: &Definition) -> Rgb {
        let clamped = given.map(|c| c.max(0.0));
        if clamped != given {
            self.warn_about(&m.name, "has negative emission: clamped to 0");
        }
        clamped
    }
}

/// The surface types that `illum` and `Pm` select.
enum MtlSurface {
    Diffuse,
    Mirror,
    /// Metallic-roughness by `Pm` and `Pr`.
    Rough,
    /// With its index of refraction, above 1.
    Glass(f64),
}

/// One to three numbers, as many as there are.
fn vector(cursor: &mut StatementCursor) -> Vec<f64> {
    let mut given = Vec::new();
    while given.len() < 3 {
        let mut next = cursor.clone();
        next.skip_blanks();
        match next.plain_numbers() {
            Some([value]) if value.is_finite() => given.push(value),
            _ => break,
        }
        *cursor = next;
    }
    given
}

/// Reflectance of a diffuse surface without `Kd`: none if it is a lamp, 1 if it has a texture,
/// otherwise the default grey.
fn missing_kd(m: &Definition) -> Rgb {
    if m.map_kd.is_some() {
        Rgb::WHITE
    } else if m.ke.is_some_and(|ke| !ke.is_black()) {
        Rgb::BLACK
    } else {
        DEFAULT_REFLECTANCE
    }
}
