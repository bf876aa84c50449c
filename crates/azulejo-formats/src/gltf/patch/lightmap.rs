//! Puts a lightmap into a file.

use super::super::origin::ObjectOrigin;
use super::additions::Additions;
use super::assign::assignments;
use super::error::PatchError;
use super::lights;
use super::mark;
use super::materials::{MaterialUses, Replaced, Textures};
use super::notes::Notes;
use super::primitives;
use super::source::Source;
use super::types::{Convention, InstanceMode, LightmapEdit, LightsMode, PatchedFile};
use super::work::Work;
use serde_json::json;

const MOZ_LIGHTMAP: &str = "MOZ_lightmap";
const MX_LIGHTMAP: &str = "MX_lightmap";

/// Puts a lightmap into a file that has none of azulejo's.
pub fn edited(
    source: &Source,
    origins: &[ObjectOrigin],
    edit: &LightmapEdit,
    mut notes: Notes,
) -> Result<PatchedFile, PatchError> {
    check_edit(source, edit)?;
    let work = Work {
        source,
        edit,
        assignments: assignments(source, origins, edit, &mut notes)?,
        meshes: primitives::of_meshes(&source.json),
    };
    let set = work.set(&mut notes)?;
    let mut additions = Additions::new(source, edit.output.stem, "lightmap");
    let split = work.split(set, &mut additions, &mut notes)?;
    let mut textures = Textures::new(edit);
    let uses = work.uses(&split);
    let replaced = match edit.convention {
        Convention::Mx | Convention::Plain => Replaced::default(),
        _ => uses.light(edit, set, &mut textures, &mut additions, &mut notes),
    };
    let shows_radiance = matches!(edit.convention, Convention::Emissive | Convention::Unlit);
    if shows_radiance && replaced.is_empty() {
        let fault =
            "surfaces of metal, glass and light alone: none could show its lightmap in this way";
        return Err(source.refused(fault));
    }
    work.meshes(&split, &replaced, &mut additions, &mut notes);
    if edit.convention == Convention::Mx {
        work.nodes(set, &mut textures, &mut additions);
    }
    drop_others(&work, &uses, &mut additions, &mut notes);
    let mode = match edit.convention {
        Convention::Plain | Convention::Occlusion => LightsMode::Keep,
        _ => edit.lights,
    };
    let mut facts = json!({ "convention": name_of(edit.convention), "texCoord": set });
    if edit.pages.iter().any(|page| !page.directions.is_empty()) {
        facts["directions"] = true.into();
    }
    if let Some(content) = edit.content {
        facts["content"] = content.into();
    }
    let mut facts = facts.into();
    let are_dark = lights::change(&mut additions.json, mode, &mut facts);
    let has_others = replaced.has_others() || edit.objects.iter().any(Option::is_none);
    let patched = mark::finished(additions, facts, notes)?;
    Ok(PatchedFile {
        leaves_dark: are_dark && has_others,
        ..patched
    })
}

/// Removes lightmaps of other programs that programs would show beside the new one; those that are in its place are
/// replaced with it.
fn drop_others(work: &Work, uses: &MaterialUses, additions: &mut Additions, notes: &mut Notes) {
    let mut remove = |list: &str, entry: usize, name: &str| {
        let steps = ["extensions", name];
        let known = work.source.json.entries(list).get(entry);
        if known.is_some_and(|entry| entry.find(&steps).is_some()) {
            let place = additions.json.key(list).at(entry);
            place.key("extensions").remove(name);
            let kind = list.trim_end_matches('s');
            notes.add(&format!(
                "{kind} with a lightmap of another program: loses it"
            ));
        }
    };
    match work.edit.convention {
        Convention::Plain | Convention::Occlusion => {}
        Convention::Mx => {
            let own = uses.receiving().filter(|(_, is_shared)| !is_shared);
            own.for_each(|(material, _)| remove("materials", material, MOZ_LIGHTMAP));
        }
        Convention::Moz | Convention::Emissive | Convention::Unlit => {
            let nodes = work.assignments.iter().map(|a| a.node);
            nodes.for_each(|node| remove("nodes", node, MX_LIGHTMAP));
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
        return Err(source.refused("a lightmap whose intensity is not a number, or negative"));
    }
    if edit.instances == InstanceMode::Node && edit.convention != Convention::Mx {
        return Err(source.refused("offsets at nodes, which only MX_lightmap has"));
    }
    Ok(())
}
