//! Rows as the faces of a case.

use super::{BoundaryPatch, OpenFoamCase, OpenFoamVersion};
use crate::enclosure::Enclosure;
use crate::files::FactorFileError;
use azulejo_factors::FaceId;
use std::collections::{HashMap, HashSet};

/// The group of the patches that take part, at openfoam.com.
pub(super) const GROUP: &str = "viewFactorWall";

/// The rows of a matrix in the order of a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct CaseRows {
    /// The rows, by patch and first face.
    pub(super) rows: Vec<u32>,
    /// For each patch of the case, the number of the cluster of each of its faces.
    pub(super) agglomeration: Vec<Vec<u32>>,
    /// Names of the patches that take part.
    pub(super) taking_part: Vec<String>,
    /// Names of the patches whose rows are left out, because they take no part.
    pub(super) left_out: Vec<String>,
}

fn refused(message: String) -> FactorFileError {
    FactorFileError::Rows {
        program: "OpenFOAM",
        message,
    }
}

impl CaseRows {
    /// Finds the row of each face: rows are faces, clusters of faces of one patch, or whole patches.
    pub(super) fn new(
        enclosure: &Enclosure,
        case: &OpenFoamCase,
    ) -> Result<CaseRows, FactorFileError> {
        let taking_part = taking_part(enclosure, case)?;
        let numbers = row_numbers(enclosure)?;
        let faces: usize = taking_part.iter().map(|p| p.faces).sum();
        // Rows of patches that take no part are left out; those of anything else are refused below.
        let left_out = left_out(enclosure, case, &taking_part);
        let is_left_in = |face: FaceId| {
            let patches = left_out.as_ref();
            patches.is_some_and(|p| !p.contains(&enclosure.rows.object(face)))
        };
        let rows = enclosure.factors.faces.iter();
        let rows = rows.filter(|&&f| is_left_in(f)).count();
        let faces_of_rows = row_faces(enclosure).filter(|&(f, _)| is_left_in(f)).count();
        // Rows may be whole patches, if each of these has one and there are no others.
        let by_patch = enclosure.rows.are_groups
            && is_each_once(taking_part.iter().map(|p| {
                let row = numbers.get(&(p.name.as_str(), None));
                row.copied()
            }));
        if by_patch && rows == taking_part.len() {
            let row_of = |patch: &str, _| numbers.get(&(patch, None)).copied();
            let left_out = left_out.unwrap_or_default();
            return Ok(CaseRows::by(case, &taking_part, &left_out, row_of));
        }
        // Otherwise rows must have all faces of the patches that take part, and no other faces.
        let row_of = |patch: &str, face| numbers.get(&(patch, Some(face))).copied();
        let is_known = |p: &&BoundaryPatch| {
            (0..p.faces)
                .filter(|&f| row_of(&p.name, f).is_some())
                .count()
        };
        let known: usize = taking_part.iter().map(is_known).sum();
        if known != faces || faces_of_rows != faces {
            let names: Vec<_> = taking_part
                .iter()
                .map(|p| p.name.as_str())
                .take(8)
                .collect();
            let is_grouped = !enclosure.rows.grouped_faces.is_empty();
            let what = if is_grouped { "faces in rows" } else { "rows" };
            return Err(refused(format!(
                "found {} {what}, {known} of them faces of the patches that take part ({}), expected \
                 all {faces} faces of these, and no object that is not a patch: take the case's mesh as the \
                 model, with --by face, --cluster, or --by object for whole patches",
                row_faces(enclosure).count(),
                names.join(", ")
            )));
        }
        let left_out = left_out.unwrap_or_default();
        Ok(CaseRows::by(case, &taking_part, &left_out, row_of))
    }

    /// Numbers clusters by first appearance, patch by patch.
    fn by(
        case: &OpenFoamCase,
        taking_part: &[&BoundaryPatch],
        left_out: &[&str],
        row_of: impl Fn(&str, usize) -> Option<u32>,
    ) -> CaseRows {
        let part: HashSet<&str> = taking_part.iter().map(|p| p.name.as_str()).collect();
        let (mut rows, mut agglomeration) = (Vec::new(), Vec::new());
        for patch in &case.patches {
            let is_part = part.contains(patch.name.as_str());
            let row = |f| row_of(&patch.name, f).filter(|_| is_part);
            let mut numbers = HashMap::new();
            let mut clusters = Vec::new();
            for face in 0..patch.faces {
                let Some(row) = row(face) else {
                    clusters.push(face as u32);
                    continue;
                };
                let next = numbers.len() as u32;
                clusters.push(*numbers.entry(row).or_insert_with(|| {
                    rows.push(row);
                    next
                }));
            }
            agglomeration.push(clusters);
        }
        CaseRows {
            rows,
            agglomeration,
            taking_part: taking_part.iter().map(|p| p.name.clone()).collect(),
            left_out: left_out.iter().map(|&name| name.to_owned()).collect(),
        }
    }
}

/// The faces of rows: of groups all that are known.
fn row_faces(enclosure: &Enclosure) -> impl Iterator<Item = (FaceId, u32)> {
    let groups = &enclosure.rows.grouped_faces;
    let patches = enclosure.factors.faces.iter().copied().zip(0..);
    let patches = patches.filter(|_| groups.is_empty());
    groups.iter().copied().chain(patches)
}

/// The patches that have rows and take no part; `None` if there are rows of what is not a patch.
fn left_out<'a>(
    enclosure: &'a Enclosure,
    case: &OpenFoamCase,
    taking_part: &[&BoundaryPatch],
) -> Option<Vec<&'a str>> {
    let patches: HashSet<&str> = case.patches.iter().map(|p| p.name.as_str()).collect();
    let part: HashSet<&str> = taking_part.iter().map(|p| p.name.as_str()).collect();
    let mut names = Vec::new();
    for (face, _) in row_faces(enclosure) {
        let object = enclosure.rows.object(face);
        if !patches.contains(object) {
            return None;
        }
        if !part.contains(object) && !names.contains(&object) {
            names.push(object);
        }
    }
    Some(names)
}

/// Whether all are there, and none twice.
fn is_each_once(rows: impl Iterator<Item = Option<u32>>) -> bool {
    let mut seen = HashSet::new();
    rows.into_iter()
        .all(|row| row.is_some_and(|r| seen.insert(r)))
}

/// The patches that take part: of the group `viewFactorWall` at openfoam.com. At openfoam.org a
/// condition of `qr` says so, and those that have rows are taken.
fn taking_part<'a>(
    enclosure: &Enclosure,
    case: &'a OpenFoamCase,
) -> Result<Vec<&'a BoundaryPatch>, FactorFileError> {
    let objects: HashSet<&str> = (enclosure.factors.faces.iter())
        .map(|&f| enclosure.rows.object(f))
        .collect();
    let is_part = |p: &&BoundaryPatch| match case.version {
        OpenFoamVersion::Org => p.faces > 0 && objects.contains(p.name.as_str()),
        _ => p.groups.iter().any(|g| g == GROUP),
    };
    let patches: Vec<_> = case.patches.iter().filter(is_part).collect();
    if !patches.is_empty() {
        return Ok(patches);
    }
    let names: Vec<_> = case
        .patches
        .iter()
        .map(|p| p.name.as_str())
        .take(8)
        .collect();
    Err(refused(match case.version {
        OpenFoamVersion::Org => format!(
            "found no patch that a row's object is named after, expected some of {}",
            names.join(", ")
        ),
        _ => format!(
            "found no patch with inGroups ({GROUP}) in polyMesh/boundary, expected it with those of \
             {} that exchange heat",
            names.join(", ")
        ),
    }))
}

/// Rows by patch and face, and by patch alone if rows are groups.
fn row_numbers(
    enclosure: &Enclosure,
) -> Result<HashMap<(&str, Option<usize>), u32>, FactorFileError> {
    let (factors, rows) = (&enclosure.factors, &enclosure.rows);
    if factors.is_back.contains(&true) {
        let message = "found back sides among the rows, expected the faces of patches alone";
        return Err(refused(message.to_owned()));
    }
    let mut numbers = HashMap::new();
    let mut objects = HashMap::new();
    for (face, row) in row_faces(enclosure) {
        let object = rows.object(face);
        let first = *objects.entry(row).or_insert(object);
        if first != object {
            return Err(refused(format!(
                "found faces of {first} and {object} in row {}, expected rows of one patch",
                rows.names[row as usize]
            )));
        }
        if numbers
            .insert((object, Some(face.face as usize)), row)
            .is_some()
        {
            return Err(refused(format!(
                "found several rows of face {} of {object}, expected one: --by face makes one row of \
                 the pieces of a face, and --cluster keeps them together",
                face.face
            )));
        }
        // The name of a group of faces is another.
        if rows.are_groups && rows.names[row as usize] == object {
            numbers.insert((object, None), row);
        }
    }
    Ok(numbers)
}
