//! What each statement does.

use super::build::Builder;
use super::color::Chroma;
use super::context::{Contexts, Trouble};
use super::ies::Luminaire;
use super::lines::{Lines, Mark, number};
use super::material::{Part, Surface};
use super::transform::Transform;
use crate::reading::files::beside;
use crate::reading::options::{Budget, Exhausted};
use crate::reading::text::{decoded, quoted, text};
use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, ReadOptions};
use azulejo_scene::math::normal_matrix;
use glam::{DAffine3, DMat3, DVec3};
use std::collections::HashMap;
use std::rc::Rc;

/// Files that include each other more deeply than this are taken for a mistake.
const DEEPEST: usize = 64;

/// What a statement costs that is read again for an instance or from an included file: as much
/// as some vertices, so that a small file cannot keep the reader busy for long.
const REPEATED: u64 = 4;

/// What a statement costs besides if it makes a colour of a spectrum.
const SPECTRUM: u64 = 256;

/// What a complaint costs about a statement that is read again.
const COMPLAINT: u64 = 64;

/// Why a statement is not carried out.
#[derive(Debug)]
pub(super) enum Stop {
    /// It is skipped, or carried out as well as it can be; this is said.
    Skipped(String),
    /// The model unfolds to more than is allowed: nothing more is read.
    Exhausted(Exhausted),
}

impl From<Exhausted> for Stop {
    fn from(e: Exhausted) -> Stop {
        Stop::Exhausted(e)
    }
}

/// A statement that is skipped or mended for a reason.
pub(super) fn skip<T>(message: impl Into<String>) -> Result<T, Stop> {
    Err(Stop::Skipped(message.into()))
}

/// A vertex as the file says it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Vertex {
    pub position: DVec3,
    /// Unit length.
    pub normal: Option<DVec3>,
    /// Grows whenever any vertex changes; two vertices never have the same.
    pub revision: u64,
}

/// The transform in force.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    pub map: DAffine3,
    /// For normals.
    pub normals: DMat3,
    /// Mean scale.
    pub scale: f64,
    /// No two have the same.
    pub serial: u64,
}

impl Placement {
    fn new(map: DAffine3, serial: u64) -> Placement {
        Placement {
            map,
            normals: normal_matrix(map.matrix3),
            scale: map.matrix3.determinant().abs().cbrt(),
            serial,
        }
    }

    /// Whether it turns things into their mirror images.
    pub fn mirrors(&self) -> bool {
        self.map.matrix3.determinant() < 0.0
    }
}

/// A file while it is read.
pub(super) struct Source<'a> {
    /// Its name for what it names itself, relative to the model's folder.
    name: &'a str,
    /// Its name in messages.
    label: &'a str,
    lines: Lines<'a>,
    /// Where the statement at hand begins.
    statement: Mark,
    /// What has been begun in this file and not ended.
    blocks: Vec<Block>,
}

impl<'a> Source<'a> {
    fn new(name: &'a str, label: &'a str, bytes: &'a [u8]) -> Source<'a> {
        let lines = Lines::new(bytes);
        Source {
            name,
            label,
            statement: lines.mark(),
            lines,
            blocks: Vec::new(),
        }
    }
}

/// What has a beginning and an end in one file.
enum Block {
    /// `o name`.
    Object,
    /// `xf ...`.
    Transform(Box<Instances>),
}

/// A transform whose content is read once for each of its instances.
struct Instances {
    transform: Transform,
    next: u64,
    /// Where the content begins.
    start: Mark,
    outer: Placement,
}

/// Reads files into a scene.
pub(super) struct Reader<'r> {
    files: &'r dyn Files,
    pub(super) warnings: Warnings,
    pub(super) budget: Budget,
    pub(super) builder: Builder,
    colors: Contexts<Chroma>,
    pub(super) surfaces: Contexts<Surface>,
    pub(super) vertices: Contexts<Vertex>,
    pub(super) placement: Placement,
    /// Counts placements and changes of vertices.
    serial: u64,
    /// Files that are being read, outermost first.
    pub(super) open: Vec<String>,
    /// Files that have been read, for the next time; `None` for those that cannot be.
    texts: HashMap<String, Option<Rc<[u8]>>>,
    /// How many bytes of other files may still be read.
    bytes_left: u64,
    pub(super) luminaires: HashMap<String, Option<Rc<Luminaire>>>,
    /// How many array instances or included files the statement at hand is in.
    repeated: usize,
    /// What emittance is multiplied with: an IES file's factors, in the body that it names.
    pub(super) emission: f64,
}

impl<'r> Reader<'r> {
    /// A reader that has read nothing yet.
    pub fn new(files: &'r dyn Files, options: &ReadOptions) -> Reader<'r> {
        Reader {
            files,
            warnings: Warnings::default(),
            budget: Budget::new(options),
            builder: Builder::new(),
            colors: Contexts::new(),
            surfaces: Contexts::new(),
            vertices: Contexts::new(),
            placement: Placement::new(DAffine3::IDENTITY, 0),
            serial: 0,
            open: Vec::new(),
            texts: HashMap::new(),
            bytes_left: options.most_unpacked,
            luminaires: HashMap::new(),
            repeated: 0,
            emission: 1.0,
        }
    }

    /// Reads the model's own file.
    ///
    /// # Errors
    /// [`Exhausted`].
    pub fn run(&mut self, bytes: &[u8], label: &str) -> Result<(), Exhausted> {
        // Other names are relative to the model's folder, whatever led to it.
        let name = label.rsplit(['/', '\\']).next().unwrap_or(label);
        self.open.push(name.to_owned());
        self.source(Source::new(name, label, bytes))
    }

    /// What has been read.
    pub fn finish(mut self, label: &str) -> Loaded {
        if self.builder.is_empty() {
            self.warnings.add_whole(label, "there is no geometry");
            self.keep_materials();
        }
        Loaded {
            scene: self.builder.finish(),
            warnings: self.warnings.finish(label),
        }
    }

    /// The materials of a file that has nothing else: a library.
    fn keep_materials(&mut self) {
        for (name, surface) in self.surfaces.named() {
            let (material, _) = surface.material(&text(name), false, &mut self.builder.gloss);
            self.builder.material(material);
        }
    }

    fn source(&mut self, mut source: Source) -> Result<(), Exhausted> {
        let mut words = Vec::new();
        while let Some(mark) = source.lines.next(&mut words) {
            source.statement = mark;
            if self.repeated > 0 {
                self.budget.spend(REPEATED + words.len() as u64)?;
            }
            self.attempt(&mut source, &words)?;
        }
        while let Some(block) = source.blocks.pop() {
            self.warn(
                &source,
                "\"o\" or \"xf\" without its end: ended with the file".into(),
            );
            self.close(block);
        }
        Ok(())
    }

    /// Carries out a statement, or says why not.
    fn attempt(&mut self, source: &mut Source, words: &[&[u8]]) -> Result<(), Exhausted> {
        match self.statement(source, words[0], &words[1..]) {
            Ok(()) => Ok(()),
            Err(Stop::Exhausted(e)) => Err(e),
            Err(Stop::Skipped(message)) => {
                if self.repeated > 0 {
                    self.budget.spend(COMPLAINT)?;
                }
                self.warn(source, message);
                Ok(())
            }
        }
    }

    #[cold]
    pub(super) fn warn(&mut self, source: &Source, message: String) {
        let position = || source.lines.position(source.statement);
        self.warnings.add(source.label, message, position);
    }

    fn statement(
        &mut self,
        source: &mut Source,
        keyword: &[u8],
        words: &[&[u8]],
    ) -> Result<(), Stop> {
        match keyword {
            b"v" => self.choose_vertex(words),
            b"p" => self.vertex(|v, p| v.position = p, words),
            b"n" => self.vertex(|v, n| v.normal = n.try_normalize(), words),
            b"c" => troubled(self.colors.choose(words, || Chroma::WHITE), "colour: white"),
            b"cxy" | b"cspec" | b"cct" | b"cmix" => self.color(keyword, words),
            b"m" => troubled(
                self.surfaces.choose(words, Surface::undefined),
                "material: grey, reflectance 0.5",
            ),
            b"sides" | b"ir" | b"rd" | b"td" | b"ed" | b"rs" | b"ts" => {
                self.material(keyword, words)
            }
            b"f" | b"fh" | b"sph" | b"cyl" | b"cone" | b"ring" | b"torus" | b"prism" => {
                self.surface(source, keyword, words)
            }
            b"o" => self.object(source, words),
            b"xf" => self.transform(source, words),
            b"i" => self.include(source, words),
            b"ies" => self.luminaire(source, words),
            _ => skip(format!("unknown entity {}: skipped", quoted(keyword))),
        }
    }

    fn choose_vertex(&mut self, words: &[&[u8]]) -> Result<(), Stop> {
        let chosen = self.vertices.choose(words, Vertex::default);
        if words.len() > 1 {
            // A copy is a vertex of its own.
            self.serial += 1;
            self.vertices.current().1.revision = self.serial;
        }
        troubled(chosen, "vertex: at the origin")
    }

    fn vertex(&mut self, set: fn(&mut Vertex, DVec3), words: &[&[u8]]) -> Result<(), Stop> {
        let value = DVec3::from_array(numbers(words)?);
        self.serial += 1;
        let (_, vertex) = self.vertices.current();
        set(vertex, value);
        vertex.revision = self.serial;
        Ok(())
    }

    fn color(&mut self, keyword: &[u8], words: &[&[u8]]) -> Result<(), Stop> {
        if self.repeated > 0 && matches!(keyword, b"cspec" | b"cct") {
            self.budget.spend(SPECTRUM)?;
        }
        let color = match keyword {
            b"cxy" => {
                let [x, y] = numbers(words)?;
                Chroma::new(x, y)
            }
            b"cct" => {
                let [kelvin] = numbers(words)?;
                Chroma::black_body(kelvin)
            }
            b"cspec" => {
                let values: Option<Vec<f64>> = words.iter().map(|w| number(w)).collect();
                match values.as_deref() {
                    Some([first, last, values @ ..]) => Chroma::spectrum(*first, *last, values),
                    _ => None,
                }
            }
            _ => Chroma::mix(self.mixture(words)?),
        };
        let Some(color) = color else {
            return skip(format!("{} of no visible colour: skipped", text(keyword)));
        };
        *self.colors.current().1 = color;
        Ok(())
    }

    /// The pairs of weight and colour of `cmix`.
    fn mixture(&self, words: &[&[u8]]) -> Result<Vec<(f64, Chroma)>, Stop> {
        let (pairs, rest) = words.as_chunks::<2>();
        if !rest.is_empty() {
            return skip("cmix without pairs of weight and colour: skipped");
        }
        let part = |[weight, name]: &[&[u8]; 2]| match (number(weight), self.colors.get(name)) {
            (Some(weight), Some(&color)) => Ok((weight, color)),
            (None, _) => skip(format!("{} is no weight: cmix is skipped", quoted(weight))),
            _ => skip(format!(
                "undefined colour {}: cmix is skipped",
                quoted(name)
            )),
        };
        pairs.iter().map(part).collect()
    }

    fn material(&mut self, keyword: &[u8], words: &[&[u8]]) -> Result<(), Stop> {
        let (_, surface) = self.surfaces.current();
        surface.made = [None; 2];
        match keyword {
            b"sides" => match numbers(words)? {
                [1.0] => surface.is_one_sided = true,
                [2.0] => surface.is_one_sided = false,
                _ => return skip("sides are 1 or 2: skipped"),
            },
            b"ir" => {
                let [real, _] = numbers(words)?;
                surface.ior = (real > 0.0 && real != 1.0).then_some(real);
            }
            b"ed" => {
                let [amount] = numbers(words)?;
                surface.ed = Part {
                    amount: (amount * self.emission).clamp(0.0, f64::MAX),
                    color: *self.colors.current().1,
                    roughness: 0.0,
                };
                if amount < 0.0 {
                    return skip("ed below 0: taken as 0");
                }
            }
            _ => return self.share(keyword, words),
        }
        Ok(())
    }

    /// Sets one of the shares of the light that arrives: rd, td, rs or ts.
    fn share(&mut self, keyword: &[u8], words: &[&[u8]]) -> Result<(), Stop> {
        let [amount, roughness] = match keyword {
            b"rd" | b"td" => [numbers::<1>(words)?[0], 0.0],
            _ => numbers(words)?,
        };
        let part = Part {
            amount: amount.clamp(0.0, 1.0),
            color: *self.colors.current().1,
            roughness: roughness.max(0.0),
        };
        let (_, surface) = self.surfaces.current();
        match keyword {
            b"rd" => surface.rd = part,
            b"td" => surface.td = part,
            b"rs" => surface.rs = part,
            _ => surface.ts = part,
        }
        match amount == part.amount {
            true => Ok(()),
            false => skip(format!("{} outside 0..1: clamped", text(keyword))),
        }
    }

    fn object(&mut self, source: &mut Source, words: &[&[u8]]) -> Result<(), Stop> {
        match words {
            [] => {
                let is_object = |b: &Block| matches!(b, Block::Object);
                self.end(source, is_object, "\"o\" that ends nothing: skipped")
            }
            [name, ..] => {
                self.builder.open(&text(name));
                source.blocks.push(Block::Object);
                Ok(())
            }
        }
    }

    /// Ends the innermost block of a kind, and what is still open inside.
    fn end(
        &mut self,
        source: &mut Source,
        is_meant: fn(&Block) -> bool,
        nothing: &str,
    ) -> Result<(), Stop> {
        let Some(at) = source.blocks.iter().rposition(is_meant) else {
            return skip(nothing);
        };
        let inner = source.blocks.len() - 1 - at;
        for block in source.blocks.drain(at..).rev().collect::<Vec<_>>() {
            self.close(block);
        }
        match inner {
            0 => Ok(()),
            _ => skip("\"o\" and \"xf\" that overlap: the inner ones end with the outer"),
        }
    }

    fn close(&mut self, block: Block) {
        match block {
            Block::Object => self.builder.close(),
            Block::Transform(instances) => {
                self.placement = instances.outer;
                if instances.transform.is_array() {
                    self.builder.close();
                    self.repeated -= usize::from(instances.next > 1);
                }
            }
        }
    }

    fn transform(&mut self, source: &mut Source, words: &[&[u8]]) -> Result<(), Stop> {
        if words.is_empty() {
            return self.next_instance(source);
        }
        let (transform, wrong) = Transform::parse(words);
        let outer = self.placement;
        self.enter(&transform, 0, outer);
        source.blocks.push(Block::Transform(Box::new(Instances {
            transform,
            next: 1,
            start: source.lines.mark(),
            outer,
        })));
        understood(wrong)
    }

    /// Puts an instance in force.
    fn enter(&mut self, transform: &Transform, instance: u64, outer: Placement) {
        self.serial += 1;
        self.placement = Placement::new(outer.map * transform.map(instance), self.serial);
        if transform.is_array() {
            self.builder.open(&transform.name(instance));
        }
    }

    /// At the end of a transform: back to its beginning for the next instance, or on.
    fn next_instance(&mut self, source: &mut Source) -> Result<(), Stop> {
        if let Some(Block::Transform(instances)) = source.blocks.last_mut()
            && instances.next < instances.transform.instances()
        {
            self.builder.close();
            self.repeated += usize::from(instances.next == 1);
            let (next, outer) = (instances.next, instances.outer);
            instances.next += 1;
            source.lines.return_to(instances.start);
            let transform = instances.transform.clone();
            self.budget.spend(REPEATED)?;
            self.enter(&transform, next, outer);
            return Ok(());
        }
        let is_transform = |b: &Block| matches!(b, Block::Transform(_));
        self.end(source, is_transform, "\"xf\" that ends nothing: skipped")
    }

    fn include(&mut self, source: &mut Source, words: &[&[u8]]) -> Result<(), Stop> {
        let [path, options @ ..] = words else {
            return skip("\"i\" without a file: skipped");
        };
        let name = beside(source.name, &text(path));
        let bytes = self.text_of(&name)?;
        let (transform, wrong) = Transform::parse(options);
        self.instances_of(&name, &bytes, &transform)?;
        understood(wrong)
    }

    /// Reads a file once for each instance of a transform.
    pub(super) fn instances_of(
        &mut self,
        name: &str,
        bytes: &[u8],
        transform: &Transform,
    ) -> Result<(), Stop> {
        let outer = self.placement;
        self.repeated += 1;
        self.open.push(name.to_owned());
        for instance in 0..transform.instances() {
            self.budget.spend(REPEATED)?;
            self.enter(transform, instance, outer);
            self.source(Source::new(name, name, bytes))?;
            if transform.is_array() {
                self.builder.close();
            }
        }
        self.open.pop();
        self.repeated -= 1;
        self.placement = outer;
        Ok(())
    }

    /// The content of a file that is not being read already.
    pub(super) fn text_of(&mut self, name: &str) -> Result<Rc<[u8]>, Stop> {
        let shown = quoted(name.as_bytes());
        if self.open.iter().any(|open| open == name) {
            return skip(format!("file {shown} includes itself: skipped"));
        }
        if self.open.len() > DEEPEST {
            return skip(format!(
                "files that include each other over {DEEPEST} deep: skipped"
            ));
        }
        if !self.texts.contains_key(name) {
            let read = self.files.read(name);
            let found = match &read {
                Ok(bytes) => Some(Rc::from(&*decoded(bytes))),
                Err(_) => None,
            };
            self.texts.insert(name.to_owned(), found);
            match read {
                Ok(bytes) => self.count_bytes(name, bytes.len() as u64)?,
                Err(e) => return skip(format!("file {shown} is left out: {e}")),
            }
        }
        match self.texts.get(name) {
            Some(Some(bytes)) => Ok(Rc::clone(bytes)),
            _ => skip(format!("file {shown} is left out, as before")),
        }
    }

    fn count_bytes(&mut self, name: &str, bytes: u64) -> Result<(), Stop> {
        match self.bytes_left.checked_sub(bytes) {
            Some(left) => {
                self.bytes_left = left;
                Ok(())
            }
            None => {
                self.texts.insert(name.to_owned(), None);
                let shown = quoted(name.as_bytes());
                skip(format!(
                    "file {shown} is left out: the included files are too large"
                ))
            }
        }
    }

    fn luminaire(&mut self, source: &mut Source, words: &[&[u8]]) -> Result<(), Stop> {
        let [path, rest @ ..] = words else {
            return skip("\"ies\" without a file: skipped");
        };
        let (multiplier, options) = match rest {
            [b"-m", value, options @ ..] => match number(value).filter(|m| *m >= 0.0) {
                Some(multiplier) => (multiplier, options),
                None => return skip("\"ies\" with a multiplier that is no number: skipped"),
            },
            options => (1.0, options),
        };
        let (transform, wrong) = Transform::parse(options);
        let name = beside(source.name, &text(path));
        self.place_luminaires(source, &name, multiplier, &transform)?;
        understood(wrong)
    }

    /// Runs `place` once for each instance of a transform, in a group of its own named `name`.
    pub(super) fn for_instances(
        &mut self,
        name: &str,
        transform: &Transform,
        mut place: impl FnMut(&mut Self) -> Result<(), Stop>,
    ) -> Result<(), Stop> {
        let outer = self.placement;
        let mut said = Ok(());
        self.builder.open(name);
        for instance in 0..transform.instances() {
            self.budget.spend(REPEATED)?;
            self.enter(transform, instance, outer);
            match place(self) {
                Err(Stop::Exhausted(e)) => return Err(e.into()),
                Err(skipped) => said = Err(skipped),
                Ok(()) => {}
            }
            if transform.is_array() {
                self.builder.close();
            }
        }
        self.builder.close();
        self.placement = outer;
        said
    }
}

/// What is wrong with the choice of a context, as a message; `stand_in` says of what and with
/// what it is replaced.
fn troubled(chosen: Result<(), Trouble>, stand_in: &str) -> Result<(), Stop> {
    match chosen {
        Ok(()) => Ok(()),
        Err(Trouble::Form) => skip("neither \"id\" nor \"id =\" nor \"id = template\": skipped"),
        Err(Trouble::Undefined(name)) => {
            let (kind, value) = stand_in.split_once(':').unwrap_or((stand_in, ""));
            skip(format!(
                "undefined {kind} {}: taken as{value}",
                quoted(name)
            ))
        }
    }
}

/// What is wrong with the options of a transform, as a message.
fn understood(wrong: Option<&str>) -> Result<(), Stop> {
    match wrong {
        None => Ok(()),
        Some(wrong) => skip(format!("{wrong}: it and the options behind it are skipped")),
    }
}

/// As many numbers as are expected, no more and no less.
fn numbers<const N: usize>(words: &[&[u8]]) -> Result<[f64; N], Stop> {
    let mut values = [0.0; N];
    if words.len() != N {
        return skip(format!("{} arguments, expected {N}: skipped", words.len()));
    }
    for (value, word) in values.iter_mut().zip(words) {
        match number(word) {
            Some(found) => *value = found,
            None => return skip(format!("{} is no number: skipped", quoted(word))),
        }
    }
    Ok(values)
}
