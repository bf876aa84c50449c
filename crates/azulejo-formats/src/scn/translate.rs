//! Translates commands in their order to SFF records.

use super::ScnResult;
use super::attributes::is_attribute;
use super::scope::ScnScopes;
use super::values::TokenStream;
use crate::reading::options::Budget;
use crate::sff::document::*;
use azulejo_scene::Operation;
use azulejo_scene::Rgb;
use std::collections::HashMap;

/// Maximum depth of groups and set operations.
const DEEPEST: usize = 256;

/// A translation in progress.
pub(super) struct ScnTranslator<'t> {
    pub stream: TokenStream<'t>,
    pub document: SffDocument,
    pub scopes: ScnScopes,
    pub budget: &'t mut Budget,
    surfaces: HashMap<Vec<u64>, u32>,
    /// Open blocks, the outermost first.
    open: Vec<OpenedBlock>,
    /// The view commands found so far.
    given: Vec<&'static str>,
}

/// An open block.
struct OpenedBlock {
    kind: OpenedBlockKind,
    place: SffPosition,
}

#[derive(Clone, Copy, PartialEq)]
enum OpenedBlockKind {
    Group,
    Left,
    Right,
    List,
}

/// Translates a whole scene.
pub(super) fn translate(stream: TokenStream, budget: &mut Budget) -> ScnResult<SffDocument> {
    let mut translator = ScnTranslator {
        stream,
        document: SffDocument {
            background: Rgb::new(0.2, 0.5, 0.7),
            ambient: Rgb::grey(0.1),
            ..SffDocument::default()
        },
        scopes: ScnScopes::new(),
        budget,
        surfaces: HashMap::new(),
        open: Vec::new(),
        given: Vec::new(),
    };
    translator.document.view.place = translator.stream.place();
    while translator.stream.left() > 0 {
        translator.command()?;
    }
    if let Some(open) = translator.open.last() {
        let found = "a beginning without its end";
        return Err(translator.stream.error(open.place, found, "both"));
    }
    Ok(translator.document)
}

impl ScnTranslator<'_> {
    fn command(&mut self) -> ScnResult<()> {
        let place = self.stream.place();
        if let Some(texture) = self.named_texture()? {
            self.scopes.texture(Some(texture));
            return Ok(());
        }
        let expected = "an SCN command";
        let Some(word) = self.stream.peek_word() else {
            return Err(self.stream.unexpected(expected));
        };
        if is_attribute(word) {
            return self.attribute();
        }
        if self.view(word, place)? {
            return Ok(());
        }
        if !super::objects::is_object(word) && !COMMANDS.contains(&word) {
            return Err(self.stream.unexpected(expected));
        }
        self.stream.word();
        match word {
            "light" => {
                let light = self.light()?;
                self.document.lights.push(light);
            }
            "group" | "begin" => {
                self.open(OpenedBlockKind::Group, place)?;
                self.scopes.enter(false);
            }
            "ungroup" | "end" => self.close(&[OpenedBlockKind::Group], place)?,
            "csg" => self.csg(place)?,
            "list" => self.list(place)?,
            name => self.object(name, place)?,
        }
        Ok(())
    }

    /// Reads a command about the view, each of which may be given once.
    fn view(&mut self, word: &str, place: SffPosition) -> ScnResult<bool> {
        let name = match word {
            "eye" | "from" => "eye",
            "look" | "at" | "to" => "look",
            "up" => "up",
            "angle" | "fov" => "angle",
            "background" | "back" => "background",
            "ambient" => "ambient",
            _ => return Ok(false),
        };
        self.stream.word();
        if self.given.contains(&name) {
            let message = format!("{name} is given more than once: the last one is used");
            self.stream.warn(place, message);
        }
        self.given.push(name);
        let (stream, view) = (&mut self.stream, &mut self.document.view);
        match name {
            "eye" => view.eye = stream.point()?,
            "look" => view.target = stream.point()?,
            "up" => view.up = stream.vector()?,
            "angle" => {
                let mut angle = || stream.within(0.5, 89.5, "angle of view");
                let horizontal = angle()?;
                let vertical = if stream.real_follows() {
                    stream.within(0.5, 89.5, "angle of view")?
                } else {
                    horizontal
                };
                view.angles = [horizontal, vertical];
            }
            "background" => self.document.background = stream.color()?,
            _ => self.document.ambient = stream.color()?,
        }
        Ok(true)
    }

    /// Reads an attribute of the objects that follow.
    fn attribute(&mut self) -> ScnResult<()> {
        match self.stream.word().unwrap_or_default() {
            "surface" => {
                let surface = self.surface()?;
                self.scopes.set_surface(surface);
            }
            "transform" => {
                let transform = self.transform()?;
                self.scopes.transform(transform);
            }
            "texture" => {
                let texture = self.texture()?;
                self.scopes.texture(texture);
            }
            // refraction or ior
            _ => {
                let what = "index of refraction";
                let refraction = self.stream.within(1.0, 300.0, what)?;
                self.scopes.set_refraction(refraction);
            }
        }
        Ok(())
    }

    /// Reads the attributes of one object, which end with `data`, and opens a scope in any case.
    pub fn local_attributes(&mut self) -> ScnResult<()> {
        self.scopes.enter(false);
        let mut any = false;
        while self.stream.peek_word().is_some_and(is_attribute) {
            any = true;
            match self.named_texture()? {
                Some(texture) => self.scopes.texture(Some(texture)),
                None => self.attribute()?,
            }
        }
        if self.stream.take(&["data"]) || !any {
            return Ok(());
        }
        Err(self
            .stream
            .unexpected("data, which ends the attributes of an object"))
    }

    fn open(&mut self, kind: OpenedBlockKind, place: SffPosition) -> ScnResult<()> {
        if self.scopes.depth() >= DEEPEST || self.open.len() >= DEEPEST {
            let found = format!("groups and operations nested more than {DEEPEST} deep");
            return Err(self.stream.error(place, found, "fewer levels"));
        }
        self.open.push(OpenedBlock { kind, place });
        Ok(())
    }

    fn close(&mut self, kinds: &[OpenedBlockKind], place: SffPosition) -> ScnResult<()> {
        match self.open.last() {
            Some(open) if kinds.contains(&open.kind) => {
                self.open.pop();
                self.scopes.leave();
                Ok(())
            }
            _ => {
                let found = "an end without its beginning";
                Err(self
                    .stream
                    .error(place, found, "the block that began last to end first"))
            }
        }
    }

    fn csg(&mut self, place: SffPosition) -> ScnResult<()> {
        let word = self.stream.word().unwrap_or_default();
        let operation = match word {
            "union" => Operation::Union,
            "subtraction" | "difference" => Operation::Difference,
            "intersection" => Operation::Intersection,
            "next" => {
                self.push(RecordKind::CsgNext, place)?;
                return match self.open.last_mut() {
                    Some(open) if open.kind == OpenedBlockKind::Left => {
                        open.kind = OpenedBlockKind::Right;
                        Ok(())
                    }
                    _ => {
                        let found =
                            "csg next that does not follow the left side of a set operation";
                        Err(self
                            .stream
                            .error(place, found, "csg union begin and solids before it"))
                    }
                };
            }
            "end" => {
                self.close(&[OpenedBlockKind::Right], place)?;
                // Two scopes are left: the inside, and that of its attributes.
                self.scopes.leave();
                return self.push(RecordKind::CsgEnd, place);
            }
            other => {
                let expected = "union, subtraction, difference, intersection, next or end";
                return Err(self.stream.error(place, format!("csg {other}"), expected));
            }
        };
        self.open(OpenedBlockKind::Left, place)?;
        let appearance = self.begin()?;
        self.push(
            RecordKind::CsgBegin {
                appearance,
                operation,
            },
            place,
        )?;
        self.push_attributes(place)?;
        self.scopes.enter(true);
        Ok(())
    }

    fn list(&mut self, place: SffPosition) -> ScnResult<()> {
        if self.stream.take(&["end"]) {
            self.close(&[OpenedBlockKind::List], place)?;
            self.scopes.leave();
            return self.push(RecordKind::ListEnd, place);
        }
        self.open(OpenedBlockKind::List, place)?;
        let appearance = self.begin()?;
        self.push(RecordKind::ListBegin { appearance }, place)?;
        self.push_attributes(place)?;
        self.scopes.enter(true);
        Ok(())
    }

    /// Reads attributes up to `begin`, and returns those that override the members' own.
    fn begin(&mut self) -> ScnResult<RecordAppearance> {
        self.local_attributes()?;
        if !self.stream.take(&["begin"]) {
            return Err(self.stream.unexpected("begin"));
        }
        let scope = self.scopes.innermost();
        Ok(RecordAppearance {
            surface: if scope.sets_surface { scope.surface } else { 0 },
            refraction: if scope.sets_refraction {
                scope.refraction
            } else {
                0.0
            },
        })
    }

    /// Whether the current position is inside a set operation, but not inside a list in it.
    pub fn is_in_operation(&self) -> bool {
        let kinds = self.open.iter().rev().map(|o| o.kind);
        let mut kinds = kinds.filter(|k| *k != OpenedBlockKind::Group);
        matches!(
            kinds.next(),
            Some(OpenedBlockKind::Left | OpenedBlockKind::Right)
        )
    }

    /// Adds a record.
    pub fn push(&mut self, kind: RecordKind, place: SffPosition) -> ScnResult<()> {
        self.spend(1, place)?;
        self.document.objects.push(SffRecord { place, kind });
        Ok(())
    }

    pub fn spend(&mut self, elements: usize, place: SffPosition) -> ScnResult<()> {
        let name = self.stream.sources.name(place.file);
        (self.budget.spend(elements as u64)).map_err(|e| e.error(name))
    }

    /// Adds the transforms and textures of the latest object.
    pub fn push_attributes(&mut self, place: SffPosition) -> ScnResult<()> {
        self.spend(3 * self.scopes.record_count(), place)?;
        let records = self.scopes.records(place);
        self.document.objects.extend(records);
        Ok(())
    }

    /// The current appearance.
    pub fn appearance(&mut self) -> ScnResult<RecordAppearance> {
        if self.scopes.innermost().surface == 0 {
            let surface = self.default_surface()?;
            self.scopes.set_default(surface);
        }
        let scope = self.scopes.innermost();
        Ok(RecordAppearance {
            surface: scope.surface,
            refraction: scope.refraction,
        })
    }

    /// The number of a surface; equal surfaces share one.
    pub fn number_of(&mut self, surface: SurfaceRecord) -> ScnResult<u32> {
        let key = bits(&surface);
        if let Some(&known) = self.surfaces.get(&key) {
            return Ok(known);
        }
        self.document.surfaces.push(surface);
        let number = self.document.surfaces.len() as u32;
        self.surfaces.insert(key, number);
        Ok(number)
    }
}

const COMMANDS: [&str; 7] = ["light", "group", "begin", "ungroup", "end", "csg", "list"];

/// The bits of all numbers of a surface.
fn bits(surface: &SurfaceRecord) -> Vec<u64> {
    use azulejo_scene::rtrace::RtraceSource::*;
    let flags = [surface.is_emitter, surface.is_unshadowed].map(|f| f64::from(u8::from(f)));
    let mut numbers = vec![flags[0], flags[1]];
    let mut colors = vec![surface.color];
    match surface.source {
        Phong {
            diffuse,
            specular,
            phong,
            metal,
            transparency,
        } => {
            numbers.extend([1.0, phong, metal]);
            colors.extend([diffuse, specular, transparency]);
        }
        Strauss {
            smooth,
            metal,
            transparency,
        } => {
            numbers.push(2.0);
            colors.extend([smooth, metal, transparency]);
        }
    }
    let values = numbers
        .into_iter()
        .chain(colors.into_iter().flat_map(|c| c.to_array()));
    values.map(f64::to_bits).collect()
}
