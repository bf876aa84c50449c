//! `bake --verify`: whether a lightmap is that of the model, the lights and the options of today.

use super::args::BakeArgs;
use super::source;
use super::work::BakeWork;
use crate::failure::Failure;
use crate::report::Report;
use crate::session::Session;
use azulejo::models::read_bytes;
use azulejo_formats::gltf::patch;

/// Compares what the lightmap of the first file says that it was computed from with what it would be computed from
/// now.
pub fn run(
    args: &BakeArgs,
    session: &mut Session,
) -> Result<(Report, Result<(), Failure>), Failure> {
    let (baked, models) = args
        .input
        .scenes
        .split_first()
        .ok_or_else(|| Failure::misuse("--verify needs the file with the lightmap"))?;
    let name = baked.to_string_lossy();
    let content = patch::content(&read_bytes(baked)?, &name).map_err(Failure::failed)?;
    let content = content.ok_or_else(|| {
        Failure::failed(format_args!(
            "{name}: no lightmap that says what it was baked from: bake it with this version of azulejo"
        ))
    })?;
    // Without other models those in the file itself count, and nothing is known of the options.
    let mut now = args.clone();
    if !models.is_empty() {
        now.input.scenes = models.to_vec();
    }
    let prepared = now.first_pass.engine.prepare()?;
    let source = source::read(&now, session)?;
    let (work, _) = BakeWork::new(&now, &source, &prepared, session)?;
    let today = work.content();
    let (scene, settings) = content.split_once('-').unwrap_or((&content, ""));
    let has_same_scene = scene == today.scene;
    let has_same_settings = models.is_empty() || settings == today.settings;
    let verdict = match (has_same_scene, has_same_settings) {
        (true, true) => "up to date",
        (true, false) => "stale: it was baked with other options",
        (false, _) => "stale: geometry, materials or lights have changed since it was baked",
    };
    let is_current = has_same_scene && has_same_settings;
    let mut report = Report::default();
    report.fact("up_to_date", is_current, "lightmap", verdict.to_owned());
    let end = if is_current {
        Ok(())
    } else {
        Err(Failure::Found)
    };
    Ok((report, end))
}
