//! All that a person can ask for.

use crate::document::{Edit, ItemId, NewLightKind, NewShapeKind};
use crate::first_pass::LightSettings;
use crate::preferences::Preferences;
use crate::view::ModelView;
use azulejo::scene::MaterialId;
use std::path::PathBuf;

/// One wish. Menus, keys, the mouse, scripts and tests all speak in these.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// An empty document.
    New,
    /// Reads files into a new document.
    Open(Vec<PathBuf>),
    /// Reads files into this document.
    Add(Vec<PathBuf>),
    /// Writes the document where it came from.
    Save,
    /// Writes it, whatever happened to the file meanwhile.
    SaveAnyway,
    /// Writes it elsewhere and stays there.
    SaveAs(PathBuf),
    /// Writes a copy, in the format of its extension.
    Export(PathBuf),
    /// Writes the picture that is being refined.
    SaveRender(PathBuf),
    /// Asks for a file by a dialog.
    RequestFile(FileRequest),
    /// The dialog was answered.
    DialogClosed,
    /// Leaves, after asking about unsaved changes.
    Quit,
    /// What was asked for goes on although changes are lost.
    Discard,
    /// What was asked for does not go on; an open question is closed.
    CancelPending,
    /// Opens what was written before a crash.
    Recover(PathBuf),
    /// Deletes what was written before a crash.
    DeleteRecovery(PathBuf),

    /// Changes the document. Edits of one gesture are one step of undo.
    Edit(Edit, Option<u64>),
    /// Adds a shape where it suits the model, in a size that does.
    AddShape(NewShapeKind),
    /// Adds a light above what there is.
    AddLight(NewLightKind),
    /// Adds solid letters: text, size, depth in ems, a font file or azulejo's own.
    AddText {
        /// What to write.
        text: String,
        /// World units of an em.
        size: f64,
        /// Ems.
        depth: f64,
        /// A font file of any kind.
        font: Option<PathBuf>,
    },
    /// Adds an exact prism that stands on the ground.
    AddPrism {
        /// What is extruded.
        base: PrismBase,
        /// The larger side of the base, world units.
        size: f64,
        /// World units.
        height: f64,
    },
    /// Takes the last edit back.
    Undo,
    /// Makes it again.
    Redo,

    /// What further commands are about.
    Select(Selection),
    /// Everything there is.
    SelectAll,

    /// How the model is looked at.
    SetView(Box<ModelView>),
    /// Puts a picture from a file behind the model.
    LoadBackdrop(PathBuf),

    /// How light is solved.
    SetLight(LightSettings),
    /// Solves the light.
    Solve,
    /// The solver rests.
    Pause,
    /// The solver goes on.
    Resume,
    /// The solver ends; what it found stays.
    StopSolving,
    /// Takes the light off the model.
    ClearLight,
    /// Finds what the patch at a place sees.
    FormFactorsFrom(SurfacePick),
    /// Watches the light of a place.
    AddProbe(SurfacePick),
    /// Watches it no more: the probe of this number.
    RemoveProbe(u64),
    /// Finds the irradiance at the probes themselves, not between the vertices around them.
    MeasureProbes,

    /// Draws a picture from here, at this size, and refines it.
    Render {
        /// Pixels.
        width: u32,
        /// Pixels.
        height: u32,
        /// Paths per pixel to go on to; `None` for as many as the preferences say.
        paths: Option<u32>,
    },
    /// No picture any more.
    StopRender,

    /// Cancels a job.
    Cancel(u64),
    /// Choices that outlive the session.
    SetPreferences(Box<Preferences>),
    /// Takes messages off the list.
    ClearMessages,
}

/// What a prism stands on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PrismBase {
    /// A regular polygon of so many sides.
    Regular(u32),
    /// The filled figures of an SVG or DXF drawing.
    Drawing(PathBuf),
}

/// A place on a surface, and its side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePick {
    /// The object.
    pub item: ItemId,
    /// World position.
    pub position: glam::DVec3,
    /// Unit normal of the side.
    pub normal: glam::DVec3,
}

/// What further commands are about.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Objects, lights, cameras.
    pub ids: Vec<ItemId>,
    /// Faces of one mesh.
    pub faces: Option<(ItemId, Vec<u32>)>,
    /// A material, to be edited.
    pub material: Option<MaterialId>,
}

impl Selection {
    /// One object, light or camera.
    pub fn one(id: ItemId) -> Selection {
        Selection {
            ids: vec![id],
            ..Selection::default()
        }
    }

    /// Whether nothing is selected but perhaps a material.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty() && self.faces.is_none()
    }
}

/// What a file is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileRequest {
    /// Models to open.
    Open,
    /// Models to add.
    Add,
    /// Where to save.
    SaveAs,
    /// Where to export.
    Export,
    /// Where the picture goes.
    SaveRender,
    /// A picture for the background.
    Backdrop,
    /// A typeface.
    Font,
    /// A drawing to extrude.
    Outline,
    /// A reflection model to load into the selected material.
    LoadBrdf,
    /// Where the selected material's reflection model goes.
    SaveBrdf,
}
