//! What programs need to be told, and users of them.

use super::FactorFileError;
use crate::enclosure::Enclosure;
use azulejo_factors::form_factors::RowRemainder;
use std::borrow::Cow;
use std::collections::HashSet;

/// Share of a row's light from which a program without a sky gives wrong results.
const OPEN: f64 = 1e-6;

/// Share of a row's light on sides without a row from which it matters.
const HIDDEN: f64 = 1e-3;

/// Names of rows as the model has them: of groups; of objects where each is one row; else of rows.
pub(super) fn row_names(enclosure: &Enclosure) -> Vec<Cow<'_, str>> {
    let (factors, rows) = (&enclosure.factors, &enclosure.rows);
    let names = rows.names.iter().map(|n| Cow::from(n.as_str()));
    let objects: Vec<&str> = factors.faces.iter().map(|&f| rows.object(f)).collect();
    let different: HashSet<&&str> = objects.iter().collect();
    if rows.are_groups || different.len() < objects.len() {
        names.collect()
    } else {
        objects.into_iter().map(Cow::from).collect()
    }
}

/// Notes about the light that rows lose, of which a program knows nothing.
pub(super) fn about_losses(enclosure: &Enclosure, program: &str) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some((rows, worst)) = losing(enclosure, OPEN, RowRemainder::escaped) {
        notes.push(format!(
            "{rows} lose light to sky or ground, {worst}: {program} knows neither, so that an opening \
             must be a surface of the model"
        ));
    }
    notes.extend(about_hidden(enclosure));
    notes
}

/// A note about light that ends where there is no row, if it matters.
pub(super) fn about_hidden(enclosure: &Enclosure) -> Option<String> {
    let share = |r: &RowRemainder| r.hidden + r.cut + r.lost;
    let (rows, worst) = losing(enclosure, HIDDEN, share)?;
    Some(format!(
        "{rows} lose light to back sides or between mirrors, {worst}: the model leaks, or its faces \
         point the wrong way"
    ))
}

/// How many rows lose more than a share in a certain way, and the worst of them, in words.
pub(super) fn losing(
    enclosure: &Enclosure,
    limit: f64,
    share: impl Fn(&RowRemainder) -> f64,
) -> Option<(String, String)> {
    let shares: Vec<f64> = enclosure.factors.rest.iter().map(share).collect();
    let losing = shares.iter().filter(|&&s| s > limit).count();
    let (worst, most) = (shares.iter().enumerate()).max_by(|a, b| a.1.total_cmp(b.1))?;
    let rows = format!("{losing} of {} rows", enclosure.len());
    let name = &enclosure.rows.names[worst];
    let words = format!("at most {} ({name})", percent(*most));
    (losing > 0).then_some((rows, words))
}

fn percent(share: f64) -> String {
    format!("{}%", super::text::general(100.0 * share, 3))
}

/// Refuses rows that are not the faces of a model, each once and in order.
pub(super) fn check_faces(
    enclosure: &Enclosure,
    program: &'static str,
    model: &str,
) -> Result<(), FactorFileError> {
    let (factors, rows) = (&enclosure.factors, &enclosure.rows);
    let places: Vec<_> = (factors.faces.iter()).map(|f| (f.object, f.face)).collect();
    // Groups may have several faces.
    let is_each_once = places.windows(2).all(|pair| pair[0] < pair[1])
        && rows.grouped_faces.len().max(places.len()) == places.len();
    // The face that should come after another, or first.
    let expected = |row: usize| match row.checked_sub(1).map(|k| places[k]) {
        Some((object, face)) if object == places[row].0 => face + 1,
        _ => 0,
    };
    let missing = (0..places.len()).find(|&row| places[row].1 > expected(row));
    let message = if factors.is_back.contains(&true) {
        "found back sides among the rows, expected one row for each face".to_owned()
    } else if !is_each_once {
        format!(
            "found {} rows, several of a face, of several faces or in another order, expected one for each face: \
             --patch-size 0 or --by face makes them",
            enclosure.len()
        )
    } else if let Some(row) = missing {
        format!(
            "face {} of \"{}\" has no row, as it has no area, and {program} counts it: remove it from the {model}",
            expected(row),
            rows.object(factors.faces[row])
        )
    } else {
        return Ok(());
    };
    Err(FactorFileError::Rows { program, message })
}
