//! Puts a lightmap into a file.

use super::super::origin::ObjectOrigin;
use super::additions::Additions;
use super::assign::assignments;
use super::error::PatchError;
use super::glb::Parts;
use super::lights;
use super::materials::{Replaced, Textures};
use super::notes::Notes;
use super::source::{Source, parsed};
use super::types::{Convention, GltfFile, InstanceMode, LightmapEdit, LightsMode, PatchedFile};
use super::undo;
use super::work::Work;
use serde_json::{Map, json};

/// Puts a lightmap into a file that has none of azulejo's.
pub fn edited(
    file: &GltfFile,
    origins: &[ObjectOrigin],
    edit: &LightmapEdit,
    mut notes: Notes,
) -> Result<PatchedFile, PatchError> {
    let parts = Parts::of(file.bytes, file.name)?;
    let root = parsed(&parts, file)?;
    let source = Source::new(parts, &root, file);
    check_edit(&source, edit)?;
    let assignments = assignments(&source, origins, edit, &mut notes)?;
    let work = Work::new(&source, edit, assignments);
    let set = work.set(&mut notes)?;
    let mut additions = Additions::new(
        &source,
        edit.output.stem,
        "lightmap",
        file.options.most_unpacked,
    );
    let split = work.split(set, &mut additions, &mut notes)?;
    let mut textures = Textures::new(edit);
    let uses = work.uses(&split);
    let replaced = match edit.convention {
        Convention::Mx | Convention::Plain => Replaced::default(),
        _ => uses.light(
            &source,
            edit,
            set,
            &mut textures,
            &mut additions,
            &mut notes,
        )?,
    };
    work.meshes(&split, &replaced, set, &mut additions, &mut notes);
    if edit.convention == Convention::Mx {
        work.nodes(set, &mut textures, &mut additions)?;
    }
    let mode = match edit.convention {
        Convention::Plain => LightsMode::Keep,
        _ => edit.lights,
    };
    let mut facts = Map::new();
    facts.insert("convention".into(), json!(name_of(edit.convention)));
    facts.insert("texCoord".into(), json!(set));
    let baked = lights::change(&source, mode, &mut additions);
    if !baked.is_empty() {
        facts.insert("baked".into(), json!(baked));
    }
    undo::sealed(&source, additions, facts, notes)
}

fn name_of(convention: Convention) -> &'static str {
    match convention {
        Convention::Moz => "moz",
        Convention::Mx => "mx",
        Convention::Emissive => "emissive",
        Convention::Unlit => "unlit",
        Convention::Plain => "plain",
    }
}

fn check_edit(source: &Source, edit: &LightmapEdit) -> Result<(), PatchError> {
    let is_number = |i: f64| i.is_finite() && i >= 0.0;
    if !edit.pages.iter().all(|page| is_number(page.intensity)) {
        return Err(source.refused("a lightmap whose intensity is no number, or negative"));
    }
    if edit.instances == InstanceMode::Node && edit.convention != Convention::Mx {
        return Err(source.refused("offsets at nodes, which only MX_lightmap has"));
    }
    Ok(())
}
