//! The same bits for any number of threads, and digests to compare machines by.

use super::Validator;
use super::balances::WholeScene;
use super::engines::CheckedEngine;
use super::record::{CheckRecord, ValidationPart};
use crate::clock::Clock;
use crate::content_key::{ContentHasher, shown};
use crate::failure::Failure;
use crate::pass;
use azulejo_factors::{FormFactors, form_factors};

const PART: ValidationPart = ValidationPart::Repeatability;

/// Numbers of threads that are compared.
const THREADS: [usize; 4] = [1, 2, 3, 8];

/// Rays of all rows together.
const RAYS: usize = 1 << 18;

/// Checks each scene by each engine.
pub fn check(validator: &Validator) -> Result<Vec<CheckRecord>, Failure> {
    let mut records = Vec::new();
    for scene in WholeScene::small() {
        if !validator.wants(PART, scene.name) {
            continue;
        }
        for engine in &validator.engines.engines {
            records.push(compared(validator, engine, &scene)?);
        }
    }
    Ok(records)
}

fn compared(
    validator: &Validator,
    engine: &CheckedEngine,
    scene: &WholeScene,
) -> Result<CheckRecord, Failure> {
    let clock = Clock::start();
    // Not the seed of the user: digests are there to be compared with published ones.
    let options = engine.options(&scene.scene, scene.size, RAYS, 0);
    let mut digests = Vec::new();
    for threads in THREADS {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool =
            pool.map_err(|e| Failure::failed(format_args!("cannot start the threads: {e}")))?;
        let tracer = engine.prepared.tracer(&scene.scene)?;
        let factors =
            pool.install(|| form_factors(&scene.scene, &tracer, &options, validator.progress));
        digests.push(digest(&factors.map_err(pass::failure)?));
    }
    let first = digests[0].clone();
    digests.sort_unstable();
    digests.dedup();
    let values = [digests.len() as f64, 1.0, 0.0];
    let words = format!("different matrices with {THREADS:?} threads");
    Ok(CheckRecord {
        note: first,
        seconds: clock.wall(),
        ..CheckRecord::new(PART, scene.name, values).of(engine.name, words)
    })
}

/// BLAKE3 of all entries with their errors, and of what reaches no column.
fn digest(factors: &FormFactors) -> String {
    let mut hasher = ContentHasher::new();
    for i in 0..factors.len() {
        for entry in factors.exchange.upper(i) {
            let column = entry.column as usize;
            hasher
                .add(&column)
                .add(&entry.value)
                .add(&f64::from(entry.error));
        }
        hasher.add(&factors.rest[i].sum());
    }
    shown(&hasher.key())
}
