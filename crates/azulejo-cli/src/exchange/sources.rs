//! Where the form factors of `exchange` come from: archives, or models whose factors are computed first.

use super::args::ExchangeArgs;
use super::in_file;
use crate::failure::Failure;
use crate::form_factors::stored::{is_archive, read_archive, refuse_computation};
use crate::form_factors::{self, FactorRequest};
use crate::report::{Report, percent};
use crate::runner::Runner;
use crate::session::Session;
use azulejo_exchange::Enclosure;
use azulejo_exchange::thermal::tables::MaterialTable;

/// Share of a row's light that may be lost without a word.
const LOST: f64 = 1e-3;

/// The matrices, each with what it is called in messages.
pub fn enclosures(
    args: &ExchangeArgs,
    materials: &MaterialTable,
    session: &mut Session,
    report: &mut Report,
) -> Result<Vec<(String, Enclosure)>, Failure> {
    let scenes = &args.input.scenes;
    let archives = scenes.iter().filter(|path| is_archive(path)).count();
    let mut enclosures = Vec::new();
    if archives == 0 {
        enclosures = computed(args, materials, session, report)?;
    } else if archives == scenes.len() {
        refuse_computation((&args.input, args.clock), &args.computation)?;
        if args.computation.closure.is_some() {
            return Err(Failure::misuse(
                "--closure: the factors of an .npz are computed; form-factors F.npz --closure closes them",
            ));
        }
        for path in scenes {
            let name = path.display().to_string();
            enclosures.push((name, read_archive(path, args.computation.memory, session)?));
        }
    } else {
        return Err(Failure::misuse(
            "models and factors (.npz) together: expected one or the other",
        ));
    }
    for (name, enclosure) in &mut enclosures {
        give_back_lost(args, name, enclosure, session);
    }
    Ok(enclosures)
}

/// The factors of models, once for each set of mirrors.
fn computed(
    args: &ExchangeArgs,
    materials: &MaterialTable,
    session: &mut Session,
    report: &mut Report,
) -> Result<Vec<(String, Enclosure)>, Failure> {
    let scene = form_factors::read_models(&args.input, args.clock, session)?;
    let mut enclosures = Vec::new();
    for band in materials.mirror_sets() {
        let mut scene = scene.clone();
        let painted = materials.paint(&mut scene, band);
        painted.map_err(|e| in_file(&args.materials, e))?;
        let request = FactorRequest {
            computation: &args.computation,
            sky: None,
            separate: false,
            // Rows have radiosities of their own unless they are lumped.
            groups: args.by.groups().filter(|_| args.lump),
            room: None,
        };
        let mut other = Report::default();
        let report = if enclosures.is_empty() {
            &mut *report
        } else {
            &mut other
        };
        let alone = (Runner::alone(), None);
        let computed = form_factors::enclosure(&scene, request, alone, session, report)?;
        enclosures.extend(computed.map(|computed| ("the scene".to_owned(), computed.value)));
    }
    Ok(enclosures)
}

/// Gives what rows lose to the sky, if that is asked for, or says how much it is.
fn give_back_lost(
    args: &ExchangeArgs,
    name: &str,
    enclosure: &mut Enclosure,
    session: &mut Session,
) {
    let rest = &mut enclosure.factors.rest;
    let lost = |r: &azulejo_factors::form_factors::RowRemainder| r.hidden + r.cut;
    let most = rest.iter().map(lost).fold(0.0, f64::max);
    if args.lost_to_sky {
        for row in rest {
            row.sky += lost(row);
            row.sky_error = row.sky_error.hypot(row.hidden_error);
            (row.hidden, row.hidden_error, row.cut) = (0.0, 0.0, 0.0);
        }
    } else if most > LOST {
        session.note(&format!(
            "{name}: up to {} of a row's light ends on backs or is cut off between mirrors, where nothing absorbs it; \
             --lost-to-sky gives it to the sky, --two-sided when factors are computed makes rows of backs",
            percent(most)
        ));
    }
}
