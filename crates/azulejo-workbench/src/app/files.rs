//! Loading files into the document.

use super::failures::describe;
use super::recipes::ImportedRecipes;
use super::saving::{OnDisk, PendingQuestion};
use super::{AcceptedLoss, App, JobResult, Severity};
use crate::command::{Command, Selection};
use crate::document::{Edit, ItemId, SceneDocument, SourceFile};
use crate::jobs::{Job, JobKind};
use crate::view::Backdrop;
use crate::words::Language;
use azulejo::formats::Warning;
use azulejo::models;
use azulejo::scene::{BackplateFit, Projection, SceneBackground, Texture, Units};
use azulejo::surroundings::SurroundingPicture;
use azulejo::trace::Progress;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// A model that a job has read.
pub struct LoadedModel {
    path: PathBuf,
    on_disk: OnDisk,
    document: SceneDocument,
    warnings: Vec<Warning>,
    notes: Vec<String>,
    /// What was wrong with its recipes.
    recipe_warnings: Vec<String>,
}

/// Files that are being loaded.
pub(super) struct Loading {
    /// Whether the first of them replaces the document.
    replaces: bool,
    /// Whether they are opened, not added: then all of them are framed.
    opens: bool,
    /// Whether it is a recovery copy.
    recovered: bool,
    /// The state when loading began, whose loss the user has accepted.
    pub(super) accepted: AcceptedLoss,
    /// The command that started loading.
    command: Command,
    /// Files to add when these are loaded.
    then: Vec<PathBuf>,
}

impl App {
    /// Loads files in the background. Files to add wait for those already being loaded.
    pub(super) fn load(&mut self, paths: Vec<PathBuf>, replaces: bool) {
        if paths.is_empty() {
            return;
        }
        let paths: Vec<PathBuf> = paths.into_iter().map(absolute).collect();
        match &mut self.loading {
            Some(loading) if !replaces => loading.then.extend(paths),
            _ => self.begin_loading(paths, replaces, false),
        }
    }

    /// Cancels the files being loaded because another one is opened, and reports it.
    fn abandon_loading(&mut self) {
        let job = self.jobs.of(JobKind::Load).map(|job| job.title.clone());
        let waiting = self.loading.take().map(|l| l.then).unwrap_or_default();
        let waiting = waiting.iter().map(|p| p.display().to_string());
        let files: Vec<String> = job.into_iter().chain(waiting).collect();
        if !files.is_empty() {
            let abandoned = self.tr("cancelled: another file was opened");
            self.report(
                Severity::Warning,
                format!("{}: {abandoned}", files.join(", ")),
            );
        }
        self.jobs.cancel_kind(JobKind::Load);
    }

    pub(super) fn begin_loading(&mut self, paths: Vec<PathBuf>, replaces: bool, recovered: bool) {
        self.abandon_loading();
        let command = if recovered {
            Command::Recover(paths[0].clone())
        } else {
            Command::Open(paths.clone())
        };
        // Files that were waiting for the same recovery copy, about which the user has been asked
        // meanwhile.
        let waiting = self.after_recovery.take();
        let then = waiting.filter(|(copy, _)| recovered && *copy == paths[0]);
        self.loading = Some(Loading {
            replaces,
            opens: replaces,
            recovered,
            accepted: self.accept_loss(),
            command,
            then: then.map_or_else(Vec::new, |(_, then)| then),
        });
        let keeps = !replaces && !self.document.is_empty();
        let units = keeps.then_some(self.document.units);
        let source_files = self.document.source_files.iter().map(|b| b.name.clone());
        let taken: Vec<String> = if keeps {
            source_files.collect()
        } else {
            Vec::new()
        };
        let copies = self.recovery.recoverable().iter();
        let copy = copies.filter(|_| recovered).find(|f| f.copy == paths[0]);
        let original = copy.and_then(|f| f.original.as_deref());
        let home = original.and_then(Path::parent).map(Path::to_owned);
        let title = match &paths[..] {
            [one] => one.display().to_string(),
            several => format!("{} {}", several.len(), self.tr("files")),
        };
        let language = self.preferences.language;
        self.jobs
            .start(JobKind::Load, title, move |progress, outbox| {
                let mut reader = ModelReader { units, taken, home };
                for path in paths {
                    match reader.read(&path, progress) {
                        Ok(model) => outbox.send(JobResult::Model(Box::new(model))),
                        Err(models::ReadFailure::Cancelled) => return Ok(()),
                        Err(failure) => {
                            let why = describe(language, &path, &failure);
                            outbox.send(JobResult::NoModel(why));
                        }
                    }
                }
                Ok(())
            });
    }

    pub(super) fn take_model(&mut self, job: &Job, model: LoadedModel) {
        let LoadedModel {
            path,
            on_disk,
            document,
            warnings,
            mut notes,
            recipe_warnings,
        } = model;
        let Some(loading) = &self.loading else {
            return;
        };
        let (replaces, recovered) = (loading.replaces, loading.recovered);
        // Several files that are opened together are one scene.
        let opens = loading.opens;
        if replaces && self.loses_unaccepted(loading.accepted) {
            // The user has not agreed to lose the changes made while the file was being read.
            self.jobs.cancel(job.id);
            return self.ask_again();
        }
        if document.is_empty() && !recovered {
            // A text that some format accepts is not a model: it does not replace one.
            warnings
                .iter()
                .for_each(|w| self.report(Severity::Warning, w.to_string()));
            let why = self.tr("this file contains nothing that can be shown");
            self.report(Severity::Error, format!("{}: {why}", path.display()));
            return;
        }
        if let Some(loading) = &mut self.loading {
            loading.replaces = false;
        }
        for file in &document.source_files {
            let noted = file.recipes.clone();
            self.noted_recipes.insert(file.path.clone(), noted);
        }
        let before = self.document.objects.len();
        let summary = summary(
            &document,
            &path,
            job.started.elapsed(),
            self.preferences.language,
        );
        if replaces {
            let file = (!recovered).then_some(on_disk);
            self.replace(document, file);
            if recovered {
                self.adopt_recovered(&path);
            }
        } else {
            let was_empty = self.document.objects.is_empty();
            let (document, changes) = self.in_current_units(document, &path);
            notes.extend(changes);
            self.edit(&Edit::Append(Box::new(document)), None);
            if was_empty {
                self.take_light_of_file();
                self.show_lightmap_of_file();
            }
            if was_empty || opens {
                self.frame_all();
            } else {
                let added = self.document.objects.get(before..).unwrap_or_default();
                let ids: Vec<ItemId> = added.iter().map(|item| item.id).collect();
                self.reveal(&ids);
                self.select(Selection {
                    ids,
                    ..Selection::default()
                });
            }
        }
        if !recovered {
            self.thumbnail_wanted = replaces.then(|| path.clone());
            self.preferences.note_recent(&path);
            self.store_preferences();
        }
        let start = if replaces { 0 } else { before };
        let items = self.document.objects.get(start..).unwrap_or_default();
        let ids: Vec<_> = items.iter().map(|i| i.id).collect();
        self.report_warnings(&warnings, &ids);
        for warning in recipe_warnings {
            self.report(Severity::Warning, warning);
        }
        notes
            .into_iter()
            .for_each(|n| self.report(Severity::Note, n));
        self.report(Severity::Note, summary);
    }

    /// Converts a document that was read in the units valid when reading began to the current
    /// units; also returns messages on what changed.
    fn in_current_units(
        &self,
        document: SceneDocument,
        path: &Path,
    ) -> (SceneDocument, Vec<String>) {
        if self.document.is_empty() {
            return (document, Vec::new());
        }
        let units = self.document.units;
        let changes = models::changes(document.units, units);
        let unit_change_text = changes.iter().map(|c| unit_change_text(path, c)).collect();
        (document.adapted(units), unit_change_text)
    }

    /// Asks whether the changes made while loading may be lost too; the command waits for the
    /// answer.
    fn ask_again(&mut self) {
        let Some(loading) = self.loading.take() else {
            return;
        };
        let (mut command, mut then) = (loading.command, loading.then);
        match &mut command {
            Command::Open(paths) => paths.append(&mut then),
            Command::Recover(copy) => self.after_recovery = Some((copy.clone(), then)),
            _ => {}
        }
        self.question = Some(PendingQuestion::Unsaved(Box::new(command)));
    }

    /// Ends loading, successfully or not, and starts on the files that are waiting.
    pub(super) fn end_loading(&mut self) {
        let then = self.loading.take().map(|loading| loading.then);
        self.load(then.unwrap_or_default(), false);
    }

    pub(super) fn load_backplate(&mut self, path: PathBuf) {
        self.asking = None;
        let path = absolute(path);
        let title = path.display().to_string();
        self.jobs
            .start(JobKind::Backplate, title, move |_, outbox| {
                let bytes = models::read_bytes(&path).map_err(|e| e.to_string())?;
                let image = azulejo::formats::read_picture(&bytes).map_err(|e| e.to_string())?;
                outbox.send(JobResult::Backplate(Arc::new(Texture {
                    path: path.to_string_lossy().into_owned(),
                    image: Some(image),
                    ..Texture::default()
                })));
                Ok(())
            });
    }

    /// Puts an image behind the scene, as bright as it is at the exposure of the view, and placed as
    /// the one before it.
    pub(super) fn take_backplate(&mut self, texture: Arc<Texture>) {
        let fit = match self.document.background {
            Some(SceneBackground::Backplate(before)) => before.fit,
            _ => BackplateFit::default(),
        };
        let radiance = 1.0 / self.exposure(&self.view);
        self.edit(&Edit::SetBackplate(texture, fit, radiance), None);
        self.view.backdrop = Backdrop::Scene;
    }
}

/// A picture of the surroundings that a job has read.
pub struct LoadedEnvironment {
    texture: Arc<Texture>,
    projection: Projection,
    /// The environment that gets it; a new one if there is none.
    into: Option<ItemId>,
    warnings: Vec<String>,
}

impl App {
    pub(super) fn load_environment(&mut self, path: PathBuf, into: Option<ItemId>) {
        self.asking = None;
        let path = absolute(path);
        let title = path.display().to_string();
        self.jobs
            .start(JobKind::Environment, title, move |_, outbox| {
                let read = SurroundingPicture::read(&path);
                let (picture, warnings) = read.map_err(|e| e.to_string())?;
                outbox.send(JobResult::Environment(LoadedEnvironment {
                    texture: Arc::new(picture.texture),
                    projection: picture.projection,
                    into,
                    warnings,
                }));
                Ok(())
            });
    }

    pub(super) fn take_environment(&mut self, loaded: LoadedEnvironment) {
        let (texture, projection) = (loaded.texture, loaded.projection);
        let edit = match loaded.into {
            Some(id) => Edit::SetEnvironmentPicture(id, texture, projection),
            None => Edit::AddEnvironment(texture, projection),
        };
        self.edit(&edit, None);
        for warning in loaded.warnings {
            self.report(Severity::Warning, warning);
        }
    }
}

/// The absolute path, with this extension if it has none.
pub(super) fn with_default_extension(path: PathBuf, extension: &str) -> PathBuf {
    match path.extension() {
        Some(_) => absolute(path),
        None => absolute(path).with_extension(extension),
    }
}

/// The absolute path, since the next session may start in another folder. `-` is not a file.
pub(super) fn absolute(path: PathBuf) -> PathBuf {
    if path == Path::new("-") {
        return path;
    }
    std::path::absolute(&path).unwrap_or(path)
}

/// Summary of a loaded file for the message list.
fn summary(document: &SceneDocument, path: &Path, time: Duration, language: Language) -> String {
    format!(
        "{}: {} {}, {} {}, {} {}, {} {}, {:.1} s",
        path.display(),
        document.objects.len(),
        language.tr("objects"),
        document.face_count(),
        language.tr("faces"),
        document.materials.len(),
        language.tr("materials"),
        document.lights.len(),
        language.tr("lights"),
        time.as_secs_f64()
    )
}

/// Describes how a file in other units was converted.
fn unit_change_text(path: &Path, change: &models::Change) -> String {
    format!("{}: {change}", path.display())
}

/// Reads several files into one set of units.
struct ModelReader {
    /// Units of the document that the files join; `None` takes those of the first file.
    units: Option<Units>,
    /// Names of source files that are taken.
    taken: Vec<String>,
    /// Folder in which a recovery copy finds the textures of its original.
    home: Option<PathBuf>,
}

impl ModelReader {
    fn read(
        &mut self,
        path: &Path,
        progress: &Progress,
    ) -> Result<LoadedModel, models::ReadFailure> {
        // Taken before reading, so that later changes by other programs are detected.
        let on_disk = OnDisk::now(path);
        let reading = models::Reading {
            home: self.home.clone(),
            ..models::Reading::default()
        };
        let model = models::read(path, &reading, progress)?;
        let mut scene = model.scene;
        // Before anything is renamed or converted: as if the model were opened alone.
        let imported = ImportedRecipes::apply(path, &mut scene);
        let target_units = *self.units.get_or_insert(scene.units);
        let changes = models::changes(scene.units, target_units);
        scene = scene.adapted(target_units);
        let name = models::branch_name(path, |n| self.taken.iter().any(|t| t == n));
        if !self.taken.is_empty() {
            models::name_branch(&mut scene, &name);
        }
        self.taken.push(name.clone());
        let source_file = SourceFile {
            name,
            path: path.to_owned(),
            format: Some(model.format),
            recipes: imported.recipes,
        };
        let changes = changes.iter().map(|c| unit_change_text(path, c));
        Ok(LoadedModel {
            notes: changes.chain(imported.notes).collect(),
            recipe_warnings: imported.warnings,
            path: path.to_owned(),
            on_disk,
            document: SceneDocument::of_scene(scene, Some(source_file)),
            warnings: model.warnings,
        })
    }
}
