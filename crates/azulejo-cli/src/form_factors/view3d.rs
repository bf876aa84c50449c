//! `form-factors` for View3D files: rows, enclosures, and layout.

use super::args::{ComputationArgs, FormFactorArgs};
use crate::failure::Failure;
use crate::pass;
use crate::report::{Report, number, percent};
use crate::session::Session;
use azulejo::models;
use azulejo_exchange::enclosure::unique;
use azulejo_exchange::files::view3d::View3dTable;
use azulejo_exchange::{Enclosure, Groups};
use azulejo_factors::form_factors::{InterchangeError, Scaled};
use azulejo_factors::{Closure, Engine, FaceId, FormFactorOptions, FormFactors, PatchSize};
use azulejo_formats::view3d::{
    FactorHeader, MatrixLayout, View3dControls, View3dDocument, View3dModel,
};
use azulejo_formats::{Format, ReadOptions, recognize};
use azulejo_scene::Scene;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The surfaces of a View3D file.
pub struct View3dInput {
    controls: View3dControls,
    model: View3dModel,
}

/// Most sweeps over an enclosure, and over grey factors, as in View3D.
const SWEEPS: [usize; 2] = [100, 30];

/// Up to this number of polygons are computed to rounding errors.
const FEW: usize = 32;

/// Rays from each surface at View3D's own eps of 1e-4.
const RAYS: f64 = 16_384.0;

/// Reads the input if it is a single View3D file, neither placed nor divided; otherwise `None`, and
/// its faces are treated as those of other models.
pub fn read(args: &FormFactorArgs, session: &mut Session) -> Result<Option<View3dInput>, Failure> {
    // Several files, and a file that is placed or divided, lose the rows of View3D and are models like others.
    let reading = &args.input.reading;
    let is_placed =
        reading.placements().next().is_some() || reading.up.is_some() || reading.unit.is_some();
    let [path] = &args.input.scenes[..] else {
        return Ok(None);
    };
    if is_placed || pass::patch_size(&args.computation.division).is_some() || !is_view3d(path) {
        return Ok(None);
    }
    // Refuse options for what the file itself specifies: sides, emissivities and combined rows.
    if args.computation.two_sided {
        return Err(Failure::misuse(
            "--two-sided: View3D's surfaces are one-sided",
        ));
    }
    if args.materials.is_some() {
        let message = "--materials: View3D's surfaces have their emissivities in the file, and are not mirrors";
        return Err(Failure::misuse(message));
    }
    if args.matrix.by.is_some() {
        let message = "--by: a View3D file specifies itself which surfaces are one row (cmb)";
        return Err(Failure::misuse(message));
    }
    if args.matrix.cluster.is_some() {
        let message = "--cluster: a View3D file specifies itself which surfaces are one row (cmb)";
        return Err(Failure::misuse(message));
    }
    // Collect the warnings of the file and of its polygons, which --strict counts together.
    session.progress().begin("reading", 0);
    let bytes = models::read_bytes(path)?;
    let name = path.to_string_lossy();
    let read = View3dDocument::read(&bytes, &name, &ReadOptions::default());
    let (document, mut warnings) = read.map_err(Failure::failed)?;
    let model = View3dModel::new(&document, &name).map_err(Failure::failed)?;
    warnings.extend(model.warning(&name));
    warnings.iter().for_each(|w| session.warn(w));
    session.has_read(Format::View3d);
    if reading.strict && !warnings.is_empty() {
        return Err(Failure::Failed(format!(
            "{name}: {} warnings, which --strict turns into a failure",
            warnings.len()
        )));
    }
    let room = View3dInput {
        controls: document.controls,
        model,
    };
    // Rows that control lines refer to have to exist; parameters without effect here are only noted.
    room.check()?;
    room.report_unused(session);
    Ok(Some(room))
}

/// Whether a file is one of View3D's, by content or name. Streams are not: they cannot be read twice.
fn is_view3d(path: &Path) -> bool {
    const START: u64 = 1 << 16;
    let mut start = Vec::new();
    let is_file = path.metadata().is_ok_and(|m| m.is_file());
    let mut read = || File::open(path)?.take(START).read_to_end(&mut start);
    is_file && read().is_ok() && recognize(&start, &path.to_string_lossy()) == Ok(Format::View3d)
}

impl View3dInput {
    /// The polygons.
    pub fn scene(&self) -> &Scene {
        &self.model.scene
    }

    /// Unique names of its rows.
    pub fn names(&self) -> Vec<String> {
        let named = |(k, name): (usize, &String)| match name.as_str() {
            "" => format!("row {}", k + 1),
            name => name.to_owned(),
        };
        unique(self.model.names.iter().enumerate().map(named).collect())
    }

    fn rows(&self) -> usize {
        self.model.names.len()
    }

    fn polygons(&self) -> usize {
        self.model.rows.iter().map(Vec::len).sum()
    }

    /// Refuses rows that do not exist.
    fn check(&self) -> Result<(), Failure> {
        let View3dControls { row, column, .. } = self.controls;
        let rows = self.rows();
        let missing = [("row", row), ("col", column)];
        match missing.into_iter().find(|(_, n)| *n as usize > rows) {
            Some((what, n)) => Err(Failure::Failed(format!(
                "{what}={n} on a control line: expected a number up to {rows}, the number of rows \
                 after combination"
            ))),
            None => Ok(()),
        }
    }

    /// Reports the parameters of View3D's own method, which have no effect here.
    fn report_unused(&self, session: &mut Session) {
        let list = |(name, value): &(&str, i16)| format!("{name}={value}");
        let unused: Vec<String> = self.controls.others.iter().map(list).collect();
        if !unused.is_empty() {
            session.note(&format!(
                "without effect here, because they control View3D's own integration: {}",
                unused.join(", ")
            ));
        }
    }

    /// The options: undivided surfaces, in closed form unless another engine is requested, and a
    /// number of rays for which the error is proportional to eps.
    pub fn options(
        &self,
        options: FormFactorOptions,
        given: &ComputationArgs,
    ) -> FormFactorOptions {
        // The error of a row falls as rays^-0.6.
        let needed_rays = RAYS * (1e-4 / self.controls.eps).powf(1.0 / 0.6);
        let needed_rays = needed_rays.clamp(4_096.0, f64::from(1 << 18)) as u32;
        FormFactorOptions {
            engine: match options.engine {
                Engine::Auto => Engine::Analytic,
                chosen => chosen,
            },
            size: PatchSize::Edge(0.0),
            // View3D adjusts enclosures only.
            closure: match options.closure {
                Closure::Always => Closure::Always,
                _ => Closure::Never,
            },
            rays: given.rays.unwrap_or(needed_rays),
            // Small files are computed to rounding errors, because that is fast enough.
            accuracy: given
                .tolerance
                .or((self.polygons() > FEW).then_some(self.controls.eps / 2.0)),
            ..options
        }
    }

    /// Makes View3D's rows from those of the polygons, according to the control lines: combines
    /// parts, applies masks, scales the enclosure, and includes reflections.
    pub fn finish(
        &self,
        pieces: &Enclosure,
        session: &Session,
        report: &mut Report,
    ) -> Result<Enclosure, Failure> {
        let row = |face: &FaceId| self.model.rows[face.object as usize][face.face as usize];
        let mut rows = pieces.grouped(&Groups {
            of_rows: pieces.factors.faces.iter().map(row).collect(),
            names: self.names(),
        });
        rows.factors = self.combined(rows.factors, session, report)?;
        Ok(rows)
    }

    /// Applies the control lines to the rows of groups.
    fn combined(
        &self,
        mut factors: FormFactors,
        session: &Session,
        report: &mut Report,
    ) -> Result<FormFactors, Failure> {
        for mask in &self.model.masks {
            factors.cover(mask.row as usize, mask.covers as usize, mask.area);
        }
        if self.controls.encl {
            let targets = vec![1.0; self.rows()];
            let scaled = session.with_progress(|p| factors.scale_rows(&targets, SWEEPS[0], p))?;
            describe(&scaled, "enclosure", report);
        }
        if self.controls.emit {
            let emissivities = &self.model.emissivities;
            let grey = session.with_progress(|p| factors.interchange(emissivities, p));
            factors = grey.map_err(|e| match e {
                InterchangeError::Cancelled => Failure::Cancelled,
                other => Failure::failed(other),
            })?;
            if self.controls.encl {
                let scaled =
                    session.with_progress(|p| factors.scale_rows(emissivities, SWEEPS[1], p))?;
                describe(&scaled, "grey_enclosure", report);
            }
        }
        self.report_row(&factors, report);
        Ok(factors)
    }

    /// Adds the row or entry that the file requests.
    fn report_row(&self, factors: &FormFactors, report: &mut Report) {
        let View3dControls { row, column, .. } = self.controls;
        let (Some(i), letter) = (
            (row as usize).checked_sub(1),
            if self.controls.emit { "𝓕" } else { "F" },
        ) else {
            return;
        };
        let columns = match column {
            0 => 0..factors.len() as u32,
            j => j - 1..j,
        };
        let entries: Vec<f64> = columns.map(|j| factors.get(i, j).0).collect();
        let words: Vec<String> = entries.iter().map(|f| format!("{f:.6}")).collect();
        let label = match column {
            0 => format!("{letter} of row {row}"),
            j => format!("{letter} from {row} to {j}"),
        };
        report.line(&label, words.join(" "));
        let numbers: Vec<_> = entries.into_iter().map(number).collect();
        report.value("row", numbers);
    }

    /// What its output says besides the matrix, in a layout or in that of the file.
    pub fn table(&self, layout: Option<MatrixLayout>) -> View3dTable {
        View3dTable {
            header: FactorHeader {
                layout: layout.unwrap_or(self.controls.out),
                encl: self.controls.encl,
                emit: self.controls.emit,
            },
            emissivities: self.model.emissivities.clone(),
        }
    }
}

fn describe(scaled: &Scaled, key: &str, report: &mut Report) {
    let Scaled {
        sweeps,
        error,
        moved,
    } = scaled;
    let plural = if *sweeps == 1 { "" } else { "s" };
    let words = format!(
        "scaled in {sweeps} sweep{plural}, {} of the light moved, {} in the worst row",
        percent(moved.total),
        percent(moved.most)
    );
    report.line(&key.replace('_', " "), words);
    report.value(&format!("{key}_sweeps"), *sweeps);
    report.value(&format!("{key}_error"), number(*error));
    report.value(&format!("{key}_moved"), number(moved.total));
    report.value(&format!("{key}_most"), number(moved.most));
}
