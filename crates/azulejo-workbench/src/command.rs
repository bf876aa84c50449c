//! Commands: everything the user can do.

use crate::bake::{BakeSettings, LightmapFile};
use crate::document::{
    Edit, Example, ItemId, NewLightKind, NewShapeKind, SurfacePick, TaskPlaneSettings,
};
use crate::first_pass::LightSettings;
use crate::lab::Lesson;
use crate::preferences::Preferences;
use crate::view::ModelView;
use azulejo::scene::MaterialId;
use std::path::PathBuf;

/// One user action. Menus, keyboard shortcuts, the mouse, scripts and tests all issue commands.
#[allow(
    clippy::large_enum_variant,
    reason = "there is one at a time, so its size does not matter"
)]
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Creates an empty document.
    New,
    /// Loads files into a new document.
    Open(Vec<PathBuf>),
    /// Opens an example, which has no file.
    OpenExample(Example),
    /// Shows a lesson of the lab, or hides the lab.
    ShowLab(Option<Lesson>),
    /// Opens the scene of the lesson that is shown.
    OpenLesson,
    /// Loads files into the current document.
    Add(Vec<PathBuf>),
    /// Saves the document to its own file.
    Save,
    /// Saves it even if another program has changed the file.
    SaveAnyway,
    /// Solves the light on the vertices of the model and saves it, in place of a finer mesh.
    KeepFaces,
    /// The user has seen that the saved mesh is finer than the model.
    DismissFinerMesh,
    /// Saves it to another file, which becomes its own.
    SaveAs(PathBuf),
    /// Writes a copy in the format of the extension.
    Export(PathBuf),
    /// Writes the rendered image.
    SaveRender(PathBuf),
    /// Opens a file dialog.
    RequestFile(FileRequest),
    /// The file dialog was closed.
    DialogClosed,
    /// Quits, after asking about unsaved changes.
    Quit,
    /// Executes the pending command although changes are lost.
    Discard,
    /// Cancels the pending command and closes its question.
    CancelPending,
    /// Opens a recovery copy.
    Recover(PathBuf),
    /// Deletes a recovery copy.
    DeleteRecovery(PathBuf),

    /// Edits the document. Edits with the same gesture number are one undo step.
    Edit(Edit, Option<u64>),
    /// Adds a shape with a size and position that suit the model.
    AddShape(NewShapeKind),
    /// Adds a light above the model.
    AddLight(NewLightKind),
    /// Applies a recipe to everything.
    ApplyRecipe(PathBuf),
    /// Loads a picture of the surroundings: for an environment, or as a new one.
    LoadEnvironment(PathBuf, Option<ItemId>),
    /// Adds solid text.
    AddText {
        /// The text, of one line or several.
        text: String,
        /// Font size in world units per em.
        size: f64,
        /// Extrusion depth in ems.
        depth: f64,
        /// A font file of any supported format; `None` for the built-in typeface.
        font: Option<PathBuf>,
    },
    /// Adds an exact prism on the ground.
    AddPrism {
        /// The outline to extrude.
        base: PrismBase,
        /// The larger side of the base in world units.
        size: f64,
        /// Height in world units.
        height: f64,
    },
    /// Undoes the last edit.
    Undo,
    /// Redoes the edit last undone.
    Redo,

    /// Changes the selection.
    Select(Selection),
    /// Selects all objects, lights and cameras.
    SelectAll,

    /// Changes the camera or the display settings of the viewport.
    SetView(Box<ModelView>),
    /// Loads an image as the background of the scene.
    LoadBackplate(PathBuf),

    /// Changes the solver settings.
    SetLight(LightSettings),
    /// Starts the solver.
    Solve,
    /// Pauses the solver.
    Pause,
    /// Resumes the solver.
    Resume,
    /// Stops the solver; what it has computed so far stays.
    StopSolving,
    /// Removes the solved light from the model.
    ClearLight,
    /// Computes the form factors of the patch at a picked point.
    FormFactorsFrom(SurfacePick),
    /// Compares the engines on the patch whose form factors are shown.
    CompareEngines,
    /// Pins a probe at a picked point.
    AddProbe(SurfacePick),
    /// Removes the probe of this number.
    RemoveProbe(u64),
    /// Computes the irradiance at the probes themselves instead of interpolating it between
    /// vertices.
    MeasureProbes,
    /// Writes the table of probes as CSV.
    SaveProbes(PathBuf),
    /// Changes where the task plane lies.
    SetTaskPlane(TaskPlaneSettings),
    /// Adds a task plane that suits the model, and measures it.
    AddTaskPlane,
    /// Measures the task plane, which is added if there is none.
    MeasureTaskPlane,
    /// Removes the task plane and what was measured on it.
    RemoveTaskPlane,
    /// Writes the points of the task plane as CSV.
    SaveTaskPlane(PathBuf),

    /// Renders the current view progressively.
    Render {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Final number of paths per pixel; `None` for the number in the preferences.
        paths: Option<u32>,
    },
    /// Stops rendering; the image stays as it is.
    StopRender,
    /// Continues to render an image that was stopped.
    ResumeRender,
    /// Closes the rendered image: the viewport shows the model again.
    CloseRender,
    /// Asks for the file of an image that is not finished.
    SaveUnfinishedRender,

    /// Changes the settings of the next lightmap.
    SetBake(BakeSettings),
    /// Starts baking a lightmap.
    Bake,
    /// Shows the lightmap in the viewport, or the light of vertices.
    ShowLightmap(bool),
    /// Writes a part of the lightmap to a file.
    SaveLightmap(LightmapFile, PathBuf),

    /// Cancels the job of this number.
    Cancel(u64),
    /// Changes the preferences.
    SetPreferences(Box<Preferences>),
    /// Clears the message list.
    ClearMessages,
    /// The user has seen the last error.
    DismissFailure,
}

/// What a prism is extruded from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PrismBase {
    /// A regular polygon with this number of sides.
    Regular(u32),
    /// The filled contours of an SVG, DXF or PDF drawing.
    Drawing(PathBuf),
}

/// What commands apply to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Objects, lights and cameras.
    pub ids: Vec<ItemId>,
    /// Faces of one mesh.
    pub faces: Option<(ItemId, Vec<u32>)>,
    /// The material being edited.
    pub material: Option<MaterialId>,
}

impl Selection {
    /// Selects one object, light or camera.
    pub fn one(id: ItemId) -> Selection {
        Selection {
            ids: vec![id],
            ..Selection::default()
        }
    }

    /// Whether no object, light, camera or face is selected; a material may be.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty() && self.faces.is_none()
    }
}

/// The purpose of a file dialog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileRequest {
    /// Models to open.
    Open,
    /// Models to add.
    Add,
    /// The file to save to.
    SaveAs,
    /// The file to export to.
    Export,
    /// The file for the rendered image.
    SaveRender,
    /// The file for a part of the lightmap.
    SaveLightmap(LightmapFile),
    /// The file for the table of probes.
    SaveProbes,
    /// The file for the points of the task plane.
    SaveTaskPlane,
    /// An image for the background.
    Backplate,
    /// A recipe to apply.
    Recipe,
    /// A picture of the surroundings, for an environment or as a new one.
    Environment(Option<ItemId>),
    /// A font for solid text.
    Font,
    /// A drawing for the base of a prism.
    Outline,
    /// A reflection model for the selected material.
    LoadBrdf,
    /// The file for the selected material's reflection model.
    SaveBrdf,
}
