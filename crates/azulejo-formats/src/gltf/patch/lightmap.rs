//! Puts a lightmap into a file.

use super::super::origin::ObjectOrigin;
use super::additions::Additions;
use super::assign::assignments;
use super::error::PatchError;
use super::glb::Parts;
use super::lights;
use super::materials::{MaterialUses, Replaced, Textures};
use super::notes::Notes;
use super::scan::{Span, find};
use super::source::{Source, parsed};
use super::types::{Convention, GltfFile, InstanceMode, LightmapEdit, LightsMode, PatchedFile};
use super::undo;
use super::work::Work;
use serde_json::{Map, json};

const MOZ_LIGHTMAP: &str = "MOZ_lightmap";
const MX_LIGHTMAP: &str = "MX_lightmap";

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
    let shows_radiance = matches!(edit.convention, Convention::Emissive | Convention::Unlit);
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
    if shows_radiance && replaced.is_empty() {
        let fault =
            "surfaces of metal, glass and light alone: none could show its lightmap in this way";
        return Err(source.refused(fault));
    }
    work.meshes(&split, &replaced, set, &mut additions, &mut notes);
    if edit.convention == Convention::Mx {
        work.nodes(set, &mut textures, &mut additions)?;
    }
    drop_others(&work, &uses, &mut additions, &mut notes);
    let mode = match edit.convention {
        Convention::Plain | Convention::Occlusion => LightsMode::Keep,
        _ => edit.lights,
    };
    let mut facts = Map::new();
    facts.insert("convention".into(), json!(name_of(edit.convention)));
    facts.insert("texCoord".into(), json!(set));
    let mut are_dark = mode == LightsMode::Remove;
    for (member, baked) in lights::change(&source, mode, &mut additions) {
        if !baked.is_empty() {
            are_dark = true;
            facts.insert(member.into(), json!(baked));
        }
    }
    let has_others = replaced.has_others() || edit.objects.iter().any(Option::is_none);
    let patched = undo::sealed(&source, additions, facts, notes)?;
    Ok(PatchedFile {
        leaves_dark: are_dark && has_others,
        ..patched
    })
}

/// Removes lightmaps of other programs that programs would show beside the new one; those that are in its place are
/// replaced with it.
fn drop_others(work: &Work, uses: &MaterialUses, additions: &mut Additions, notes: &mut Notes) {
    let (source, text) = (work.source, work.source.text());
    let remove = |list: &str, entry: usize, name: &str, additions: &mut Additions| {
        let entries = source.list(list);
        let has_one = |span: &Span| find(text, span, &["extensions", name]).is_some();
        let found = entries.get(entry).is_some_and(has_one);
        if found {
            let change = additions.edit.key(list).index(entry);
            change.key("extensions").key(name).remove();
        }
        found
    };
    match work.edit.convention {
        Convention::Plain | Convention::Occlusion => {}
        Convention::Mx => {
            for (material, is_shared) in uses.receiving() {
                if is_shared {
                    continue;
                }
                if remove("materials", material, MOZ_LIGHTMAP, additions) {
                    notes.add("material with a lightmap of another program: loses it");
                }
            }
        }
        Convention::Moz | Convention::Emissive | Convention::Unlit => {
            for assignment in &work.assignments {
                if remove("nodes", assignment.node, MX_LIGHTMAP, additions) {
                    notes.add("node with a lightmap of another program: loses it");
                }
            }
        }
    }
}

fn name_of(convention: Convention) -> &'static str {
    match convention {
        Convention::Moz => "moz",
        Convention::Mx => "mx",
        Convention::Emissive => "emissive",
        Convention::Unlit => "unlit",
        Convention::Occlusion => "occlusion",
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
