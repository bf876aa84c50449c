//! Executes statements.

use super::build::MgfBuilder;
use super::color::Chroma;
use super::context::{ContextError, ContextTable};
use super::lines::{MgfLines, StatementMark, number};
use super::material::{MaterialComponent, MgfMaterial};
use super::sharing::{ContentFrames, FrameId, RepeatedOrigin, WORLD};
use super::transform::MgfTransform;
use crate::photometry::PhotometricFile;
use crate::reading::files::beside;
use crate::reading::options::{Budget, Exhausted};
use crate::reading::text::{decoded, quoted, text};
use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, ReadOptions};
use azulejo_scene::Sidedness;
use glam::{DAffine3, DVec3};
use std::collections::HashMap;
use std::rc::Rc;

/// Includes nested more deeply than this are considered an error.
const DEEPEST: usize = 64;

/// What repeating a statement takes from the budget, for an instance or an included file: as much
/// as several vertices, so that a small file cannot keep the reader busy for long.
const REPEATED: u64 = 4;

/// What a statement takes in addition if it evaluates a spectrum.
const SPECTRUM: u64 = 256;

/// What a warning about a repeated statement takes.
const COMPLAINT: u64 = 64;

/// Why a statement was not executed.
#[derive(Debug)]
pub(super) enum EntityError {
    /// It was skipped or repaired, with this warning.
    Skipped(String),
    /// The model unfolds to more than is allowed: reading stops.
    Exhausted(Exhausted),
}

impl From<Exhausted> for EntityError {
    fn from(e: Exhausted) -> EntityError {
        EntityError::Exhausted(e)
    }
}

/// Skips or repairs a statement with a warning.
pub(super) fn skip<T>(message: impl Into<String>) -> Result<T, EntityError> {
    Err(EntityError::Skipped(message.into()))
}

/// A vertex as defined in the file.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MgfVertex {
    pub position: DVec3,
    /// Unit length.
    pub normal: Option<DVec3>,
    /// Changes whenever any vertex changes; unique among vertices.
    pub revision: u64,
}

/// The current transform.
#[derive(Clone, Copy, Debug)]
pub(super) struct TransformState {
    /// To the world.
    pub map: DAffine3,
    /// The coordinates in which meshes are built.
    pub frame: FrameId,
    /// To the frame.
    pub frame_from_content: DAffine3,
    /// Mean scale of `map`.
    pub scale: f64,
    /// Unique among transforms.
    pub serial: u64,
}

impl TransformState {
    /// No transform.
    const IDENTITY: TransformState = TransformState {
        map: DAffine3::IDENTITY,
        frame: WORLD,
        frame_from_content: DAffine3::IDENTITY,
        scale: 1.0,
        serial: 0,
    };

    /// A transform inside this one.
    fn then(&self, step: DAffine3, serial: u64) -> TransformState {
        let map = self.map * step;
        TransformState {
            map,
            frame: self.frame,
            frame_from_content: self.frame_from_content * step,
            scale: map.matrix3.determinant().abs().cbrt(),
            serial,
        }
    }
}

/// A file being read.
pub(super) struct MgfSource<'a> {
    /// Its name relative to the model's folder, against which its own includes are resolved.
    name: &'a str,
    /// Its name in messages.
    label: &'a str,
    lines: MgfLines<'a>,
    /// The position of the current statement.
    statement: StatementMark,
    /// The open blocks of this file.
    blocks: Vec<OpenBlock>,
}

impl<'a> MgfSource<'a> {
    fn new(name: &'a str, label: &'a str, bytes: &'a [u8]) -> MgfSource<'a> {
        let lines = MgfLines::new(bytes);
        MgfSource {
            name,
            label,
            statement: lines.mark(),
            lines,
            blocks: Vec::new(),
        }
    }
}

/// A block that must end in the file that begins it.
enum OpenBlock {
    /// `o name`.
    Object,
    /// `xf ...`.
    Transform(Box<ArrayInstances>),
}

/// A transform whose content is read once for each of its instances.
struct ArrayInstances {
    transform: MgfTransform,
    next: u64,
    /// The position of the content.
    start: StatementMark,
    outer: TransformState,
}

/// Reads files into a scene.
pub(super) struct MgfReader<'r> {
    files: &'r dyn Files,
    pub(super) warnings: Warnings,
    pub(super) budget: Budget,
    pub(super) builder: MgfBuilder,
    colors: ContextTable<Chroma>,
    pub(super) surfaces: ContextTable<MgfMaterial>,
    pub(super) vertices: ContextTable<MgfVertex>,
    pub(super) placement: TransformState,
    pub(super) frames: ContentFrames,
    /// Counts transforms and changes of vertices.
    serial: u64,
    /// Files being read, outermost first.
    pub(super) open: Vec<String>,
    /// Cached files; `None` for those that cannot be read.
    texts: HashMap<String, Option<Rc<[u8]>>>,
    /// Remaining budget of bytes in other files.
    bytes_left: u64,
    pub(super) luminaires: HashMap<String, Option<Rc<PhotometricFile>>>,
    /// The number of array instances and included files around the current statement.
    pub(super) repeated: usize,
    /// Factor of emittance: the product of an IES file's factors, in the geometry that it names.
    pub(super) emission: f64,
}

impl<'r> MgfReader<'r> {
    pub fn new(files: &'r dyn Files, options: &ReadOptions) -> MgfReader<'r> {
        MgfReader {
            files,
            warnings: Warnings::default(),
            budget: Budget::new(options),
            builder: MgfBuilder::new(options.keeps),
            colors: ContextTable::new(),
            surfaces: ContextTable::new(),
            vertices: ContextTable::new(),
            placement: TransformState::IDENTITY,
            frames: ContentFrames::new(),
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
        // Other names are relative to the model's folder, wherever it is.
        let name = label.rsplit(['/', '\\']).next().unwrap_or(label);
        self.open.push(name.to_owned());
        self.source(MgfSource::new(name, label, bytes))
    }

    /// The scene and the warnings.
    pub fn finish(mut self, label: &str) -> Loaded {
        if self.builder.is_empty() {
            self.warnings
                .add_whole(label, "the file contains no geometry");
            self.keep_materials();
        }
        Loaded {
            scene: self.builder.finish(),
            warnings: self.warnings.finish(label),
        }
    }

    /// The materials of a file without geometry: a library.
    fn keep_materials(&mut self) {
        for (name, surface) in self.surfaces.named() {
            let (material, _) = surface.material(&text(name), false, &mut self.builder.gloss);
            self.builder.material(material);
        }
    }

    fn source(&mut self, mut source: MgfSource) -> Result<(), Exhausted> {
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

    /// Executes a statement, or returns why it was not executed.
    fn attempt(&mut self, source: &mut MgfSource, words: &[&[u8]]) -> Result<(), Exhausted> {
        match self.statement(source, words[0], &words[1..]) {
            Ok(()) => Ok(()),
            Err(EntityError::Exhausted(e)) => Err(e),
            Err(EntityError::Skipped(message)) => {
                if self.repeated > 0 {
                    self.budget.spend(COMPLAINT)?;
                }
                self.warn(source, message);
                Ok(())
            }
        }
    }

    /// The origin of a mesh in a frame; `None` in the world, where nothing is repeated.
    pub(super) fn origin(&self, source: &MgfSource, frame: FrameId) -> Option<RepeatedOrigin> {
        (frame != WORLD).then(|| RepeatedOrigin {
            statement: source.lines.address(source.statement),
            world_from_frame: self.frames.world_from(frame),
        })
    }

    #[cold]
    pub(super) fn warn(&mut self, source: &MgfSource, message: String) {
        let position = || source.lines.position(source.statement);
        self.warnings.add(source.label, message, position);
    }

    fn statement(
        &mut self,
        source: &mut MgfSource,
        keyword: &[u8],
        words: &[&[u8]],
    ) -> Result<(), EntityError> {
        match keyword {
            b"v" => self.choose_vertex(words),
            b"p" => self.vertex(|v, p| v.position = p, words),
            b"n" => self.vertex(|v, n| v.normal = n.try_normalize(), words),
            b"c" => context_warning(self.colors.choose(words, || Chroma::WHITE), "colour: white"),
            b"cxy" | b"cspec" | b"cct" | b"cmix" => self.color(keyword, words),
            b"m" => context_warning(
                self.surfaces.choose(words, MgfMaterial::undefined),
                "material: grey with reflectance 0.5",
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

    fn choose_vertex(&mut self, words: &[&[u8]]) -> Result<(), EntityError> {
        let chosen = self.vertices.choose(words, MgfVertex::default);
        if words.len() > 1 {
            // A copy is a separate vertex.
            self.serial += 1;
            self.vertices.current().1.revision = self.serial;
        }
        context_warning(chosen, "vertex: at the origin")
    }

    fn vertex(
        &mut self,
        set: fn(&mut MgfVertex, DVec3),
        words: &[&[u8]],
    ) -> Result<(), EntityError> {
        let value = DVec3::from_array(numbers(words)?);
        self.serial += 1;
        let (_, vertex) = self.vertices.current();
        set(vertex, value);
        vertex.revision = self.serial;
        Ok(())
    }

    fn color(&mut self, keyword: &[u8], words: &[&[u8]]) -> Result<(), EntityError> {
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
            return skip(format!("{} without visible colour: skipped", text(keyword)));
        };
        *self.colors.current().1 = color;
        Ok(())
    }

    /// The pairs of weight and colour of `cmix`.
    fn mixture(&self, words: &[&[u8]]) -> Result<Vec<(f64, Chroma)>, EntityError> {
        let (pairs, rest) = words.as_chunks::<2>();
        if !rest.is_empty() {
            return skip("cmix without pairs of weight and colour: skipped");
        }
        let part = |[weight, name]: &[&[u8]; 2]| match (number(weight), self.colors.get(name)) {
            (Some(weight), Some(&color)) => Ok((weight, color)),
            (None, _) => skip(format!("{} is not a weight: cmix skipped", quoted(weight))),
            _ => skip(format!("undefined colour {}: cmix skipped", quoted(name))),
        };
        pairs.iter().map(part).collect()
    }

    fn material(&mut self, keyword: &[u8], words: &[&[u8]]) -> Result<(), EntityError> {
        let (_, surface) = self.surfaces.current();
        surface.made = [None; 2];
        match keyword {
            b"sides" => match numbers(words)? {
                [1.0] => surface.sidedness = Sidedness::One,
                [2.0] => surface.sidedness = Sidedness::Two,
                _ => return skip("sides must be 1 or 2: skipped"),
            },
            b"ir" => {
                let [real, _] = numbers(words)?;
                surface.ior = (real > 0.0 && real != 1.0).then_some(real);
            }
            b"ed" => {
                let [amount] = numbers(words)?;
                surface.ed = MaterialComponent {
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

    /// Sets one of the shares of the incident light: rd, td, rs or ts.
    fn share(&mut self, keyword: &[u8], words: &[&[u8]]) -> Result<(), EntityError> {
        let [amount, roughness] = match keyword {
            b"rd" | b"td" => [numbers::<1>(words)?[0], 0.0],
            _ => numbers(words)?,
        };
        let part = MaterialComponent {
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
        if amount == part.amount {
            Ok(())
        } else {
            skip(format!("{} outside 0..1: clamped", text(keyword)))
        }
    }

    fn object(&mut self, source: &mut MgfSource, words: &[&[u8]]) -> Result<(), EntityError> {
        match words {
            [] => {
                let is_object = |b: &OpenBlock| matches!(b, OpenBlock::Object);
                self.end(source, is_object, "\"o\" without a matching begin: skipped")
            }
            [name, ..] => {
                self.builder.open(&text(name), self.placement.frame);
                source.blocks.push(OpenBlock::Object);
                Ok(())
            }
        }
    }

    /// Ends the innermost block of a type, and the blocks still open inside it.
    fn end(
        &mut self,
        source: &mut MgfSource,
        is_meant: fn(&OpenBlock) -> bool,
        nothing: &str,
    ) -> Result<(), EntityError> {
        let Some(at) = source.blocks.iter().rposition(is_meant) else {
            return skip(nothing);
        };
        let inner = source.blocks.len() - 1 - at;
        for block in source.blocks.drain(at..).rev().collect::<Vec<_>>() {
            self.close(block);
        }
        match inner {
            0 => Ok(()),
            _ => skip("\"o\" and \"xf\" overlap: the inner ones end with the outer"),
        }
    }

    fn close(&mut self, block: OpenBlock) {
        match block {
            OpenBlock::Object => self.builder.close(),
            OpenBlock::Transform(instances) => {
                self.placement = instances.outer;
                if instances.transform.is_array() {
                    self.builder.close();
                    self.repeated -= usize::from(instances.next > 1);
                }
            }
        }
    }

    fn transform(&mut self, source: &mut MgfSource, words: &[&[u8]]) -> Result<(), EntityError> {
        if words.is_empty() {
            return self.next_instance(source);
        }
        let (transform, wrong) = MgfTransform::parse(words);
        let outer = self.placement;
        self.enter(&transform, 0, outer, transform.is_array());
        source
            .blocks
            .push(OpenBlock::Transform(Box::new(ArrayInstances {
                transform,
                next: 1,
                start: source.lines.mark(),
                outer,
            })));
        option_warning(wrong)
    }

    /// Makes an instance the current transform, with a frame of its own if its content may be repeated.
    fn enter(
        &mut self,
        transform: &MgfTransform,
        instance: u64,
        outer: TransformState,
        is_repeated: bool,
    ) {
        self.serial += 1;
        let mut inner = outer.then(transform.map(instance), self.serial);
        if is_repeated
            && let Some(frame) = self
                .frames
                .enter(outer.frame, inner.frame_from_content, inner.map)
        {
            inner.frame = frame;
            inner.frame_from_content = DAffine3::IDENTITY;
        }
        self.placement = inner;
        if transform.is_array() {
            self.builder.open(&transform.name(instance), inner.frame);
        }
    }

    /// At the end of a transform, returns to its beginning for the next instance, or continues.
    fn next_instance(&mut self, source: &mut MgfSource) -> Result<(), EntityError> {
        if let Some(OpenBlock::Transform(instances)) = source.blocks.last_mut()
            && instances.next < instances.transform.instances()
        {
            self.builder.close();
            if instances.next == 1 {
                self.repeated += 1;
                // An array of a billion is refused before the first million of it is read.
                let rest = instances.transform.instances() - 1;
                self.budget.check(rest.saturating_mul(REPEATED))?;
            }
            let (next, outer) = (instances.next, instances.outer);
            instances.next += 1;
            source.lines.return_to(instances.start);
            let transform = instances.transform.clone();
            self.budget.spend(REPEATED)?;
            self.enter(&transform, next, outer, true);
            return Ok(());
        }
        let is_transform = |b: &OpenBlock| matches!(b, OpenBlock::Transform(_));
        self.end(
            source,
            is_transform,
            "\"xf\" without a matching begin: skipped",
        )
    }

    fn include(&mut self, source: &mut MgfSource, words: &[&[u8]]) -> Result<(), EntityError> {
        let [path, options @ ..] = words else {
            return skip("\"i\" without a file: skipped");
        };
        let name = beside(source.name, &text(path));
        let bytes = self.text_of(&name)?;
        let (transform, wrong) = MgfTransform::parse(options);
        self.instances_of(&name, &bytes, &transform)?;
        option_warning(wrong)
    }

    /// Reads a file once for each instance of a transform.
    pub(super) fn instances_of(
        &mut self,
        name: &str,
        bytes: &[u8],
        transform: &MgfTransform,
    ) -> Result<(), EntityError> {
        let outer = self.placement;
        self.repeated += 1;
        self.open.push(name.to_owned());
        for instance in 0..transform.instances() {
            self.budget.spend(REPEATED)?;
            self.enter(transform, instance, outer, true);
            self.source(MgfSource::new(name, name, bytes))?;
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
    pub(super) fn text_of(&mut self, name: &str) -> Result<Rc<[u8]>, EntityError> {
        let shown = quoted(name.as_bytes());
        if self.open.iter().any(|open| open == name) {
            return skip(format!("file {shown} includes itself: skipped"));
        }
        if self.open.len() > DEEPEST {
            return skip(format!("files included more than {DEEPEST} deep: skipped"));
        }
        if !self.texts.contains_key(name) {
            let read = self.files.read(name);
            let text = match &read {
                Ok(bytes) => Some(Rc::from(&*decoded(bytes))),
                Err(_) => None,
            };
            self.texts.insert(name.to_owned(), text);
            match read {
                Ok(bytes) => self.count_bytes(name, bytes.len() as u64)?,
                Err(e) => return skip(format!("file {shown} skipped: {e}")),
            }
        }
        match self.texts.get(name) {
            Some(Some(bytes)) => Ok(Rc::clone(bytes)),
            _ => skip(format!("file {shown} skipped, as before")),
        }
    }

    fn count_bytes(&mut self, name: &str, bytes: u64) -> Result<(), EntityError> {
        match self.bytes_left.checked_sub(bytes) {
            Some(left) => {
                self.bytes_left = left;
                Ok(())
            }
            None => {
                self.texts.insert(name.to_owned(), None);
                let shown = quoted(name.as_bytes());
                skip(format!(
                    "file {shown} skipped: the included files exceed the size limit"
                ))
            }
        }
    }

    fn luminaire(&mut self, source: &mut MgfSource, words: &[&[u8]]) -> Result<(), EntityError> {
        let [path, rest @ ..] = words else {
            return skip("\"ies\" without a file: skipped");
        };
        let (multiplier, options) = match rest {
            [b"-m", value, options @ ..] => match number(value).filter(|m| *m >= 0.0) {
                Some(multiplier) => (multiplier, options),
                None => return skip("\"ies\" with a multiplier that is not a number: skipped"),
            },
            options => (1.0, options),
        };
        let (transform, wrong) = MgfTransform::parse(options);
        let name = beside(source.name, &text(path));
        self.place_luminaires(source, &name, multiplier, &transform)?;
        option_warning(wrong)
    }

    /// Runs `place` once for each instance of a transform, in its own group named `name`.
    pub(super) fn for_instances(
        &mut self,
        name: &str,
        transform: &MgfTransform,
        mut place: impl FnMut(&mut Self) -> Result<(), EntityError>,
    ) -> Result<(), EntityError> {
        let outer = self.placement;
        let mut outcome = Ok(());
        self.builder.open(name, outer.frame);
        for instance in 0..transform.instances() {
            self.budget.spend(REPEATED)?;
            self.enter(transform, instance, outer, false);
            match place(self) {
                Err(EntityError::Exhausted(e)) => return Err(e.into()),
                Err(skipped) => outcome = Err(skipped),
                Ok(()) => {}
            }
            if transform.is_array() {
                self.builder.close();
            }
        }
        self.builder.close();
        self.placement = outer;
        outcome
    }
}

/// Turns an error in the selection of a context into a warning; `stand_in` names the type and the
/// default.
fn context_warning(chosen: Result<(), ContextError>, stand_in: &str) -> Result<(), EntityError> {
    match chosen {
        Ok(()) => Ok(()),
        Err(ContextError::Form) => {
            skip("neither \"id\" nor \"id =\" nor \"id = template\": skipped")
        }
        Err(ContextError::Undefined(name)) => {
            let (kind, value) = stand_in.split_once(':').unwrap_or((stand_in, ""));
            skip(format!(
                "undefined {kind} {}: taken as{value}",
                quoted(name)
            ))
        }
    }
}

/// Turns an error in the options of a transform into a warning.
fn option_warning(wrong: Option<&str>) -> Result<(), EntityError> {
    match wrong {
        None => Ok(()),
        Some(wrong) => skip(format!("{wrong}: it and the following options are skipped")),
    }
}

/// Exactly `N` numbers.
fn numbers<const N: usize>(words: &[&[u8]]) -> Result<[f64; N], EntityError> {
    let mut values = [0.0; N];
    if words.len() != N {
        return skip(format!("{} arguments, expected {N}: skipped", words.len()));
    }
    for (value, word) in values.iter_mut().zip(words) {
        match number(word) {
            Some(parsed) => *value = parsed,
            None => return skip(format!("{} is not a number: skipped", quoted(word))),
        }
    }
    Ok(values)
}
