//! `validate`: compares this program with closed forms, balances and its own error bars, and writes
//! a report.
//!
//! | module | what it checks |
//! |---|---|
//! | `closed_forms` | form factors with known values, by every engine |
//! | `exchanges` | exchange factors, temperatures and fluxes with known values |
//! | `balances` | closure, reciprocity and energy of whole scenes, and their stated errors |
//! | `error_bars` | how often the truth lies within them |
//! | `repeatability` | the same bits for any number of threads |
//! | `peers` | the closed forms by other programs that are installed |
//! | `engines`, `record` | what is checked, and what came out |
//! | `report` | page, plots and tables |

pub mod args;
mod balances;
mod closed_forms;
mod engines;
mod error_bars;
mod exchanges;
mod peers;
mod record;
mod repeatability;
mod report;

use super::failure::Failure;
use super::machine_info::MachineInfo;
use super::report::{Report, count};
use super::session::Session;
use crate::clock::Clock;
use args::ValidateArgs;
use azulejo_trace::Progress;
use engines::CheckedEngines;
use peers::PeerResults;
use record::{CheckOutcome, CheckRecord, ValidationPart};

/// How much is computed.
struct ValidationEffort {
    /// Rays of all rows of a scene together.
    rays: usize,
    /// Pixels along the side of a hemicube.
    resolution: u32,
    /// Seeds of the error bars.
    seeds: u64,
    /// Efforts at which the error is drawn, each four times the one before.
    convergence: u32,
    /// One in this many cases is among those whose error is drawn.
    convergence_step: usize,
}

const FULL: ValidationEffort = ValidationEffort {
    rays: 1 << 19,
    resolution: 64,
    seeds: 200,
    convergence: 5,
    convergence_step: 1,
};

const USUAL: ValidationEffort = ValidationEffort {
    rays: 1 << 16,
    resolution: 32,
    seeds: 40,
    convergence: 3,
    convergence_step: 4,
};

/// What all parts need.
struct Validator<'a> {
    engines: &'a CheckedEngines,
    effort: ValidationEffort,
    seed: u64,
    only: Option<&'a str>,
    progress: &'a Progress,
    say: &'a dyn Fn(&str),
}

/// Error of an engine against its samples.
struct ErrorCurve {
    engine: &'static str,
    /// Samples of a row, and the root mean square of relative errors.
    points: Vec<[f64; 2]>,
}

/// Share of answers within a number of standard errors.
struct CoverageCurve {
    name: String,
    /// Standard errors, and the share.
    points: Vec<[f64; 2]>,
}

/// All that came out.
#[derive(Default)]
struct ValidationResults {
    records: Vec<CheckRecord>,
    convergence: Vec<ErrorCurve>,
    coverage: Vec<CoverageCurve>,
    /// What other programs answered, if they were asked.
    peers: Option<PeerResults>,
    /// Wall-clock time, s.
    seconds: f64,
}

impl Validator<'_> {
    /// Whether a check is among those asked for.
    fn wants(&self, part: ValidationPart, subject: &str) -> bool {
        let has = |name: &str| part.to_string().contains(name) || subject.contains(name);
        self.only.is_none_or(has)
    }

    /// A line on what comes next.
    fn tell(&self, words: &str) {
        (self.say)(words);
    }

    fn run(&self) -> Result<ValidationResults, Failure> {
        let clock = Clock::start();
        let mut records = closed_forms::check(self)?;
        let convergence = closed_forms::convergence(self)?;
        records.extend(exchanges::check(self)?);
        records.extend(balances::check(self)?);
        let (bars, coverage) = error_bars::check(self)?;
        records.extend(bars);
        records.extend(repeatability::check(self)?);
        Ok(ValidationResults {
            records,
            convergence,
            coverage,
            peers: None,
            seconds: clock.wall(),
        })
    }
}

impl ValidationResults {
    /// Number of the checks of a part with an outcome.
    fn number(&self, part: ValidationPart, outcome: CheckOutcome) -> usize {
        let is_such = |r: &&CheckRecord| r.part == part && r.outcome == outcome;
        self.records.iter().filter(is_such).count()
    }

    /// Number of all checks with an outcome.
    fn total(&self, outcome: CheckOutcome) -> usize {
        let number = |part| self.number(part, outcome);
        ValidationPart::ALL.into_iter().map(number).sum()
    }
}

/// Runs `validate`: the summary, and whether every check passed.
pub fn run(
    args: &ValidateArgs,
    session: &mut Session,
) -> Result<(Report, Result<(), Failure>), Failure> {
    let effort = if args.full { FULL } else { USUAL };
    let engines = CheckedEngines::new(&args.engine, effort.resolution)?;
    // Before the work, not after it.
    let folder = &args.output;
    std::fs::create_dir_all(folder).map_err(|e| Failure::file("create", folder, &e))?;
    let results = session.with_progress(|progress| {
        let validator = Validator {
            engines: &engines,
            effort,
            seed: args.seed,
            only: args.only.as_deref(),
            progress,
            say: &|words| session.tell(words),
        };
        let mut results = validator.run()?;
        if args.peers {
            results.peers = Some(peers::ask(&validator, folder)?);
        }
        Ok::<_, Failure>(results)
    })?;
    if results.records.is_empty() {
        let name = args.only.as_deref().unwrap_or_default();
        return Err(Failure::misuse(format_args!(
            "no check has \"{name}\" in its name: parts are {}",
            ValidationPart::ALL.map(|p| p.to_string()).join(", ")
        )));
    }
    let machine = MachineInfo::detect();
    report::write(args, &results, &engines, &machine, session.progress())?;
    let is_good = results.total(CheckOutcome::Failed) == 0;
    let end = if is_good { Ok(()) } else { Err(Failure::Found) };
    Ok((summary(args, &results, session), end))
}

fn summary(args: &ValidateArgs, results: &ValidationResults, session: &mut Session) -> Report {
    let mut report = Report::default();
    // Parts without checks, as those that --only leaves out, have no line.
    for part in ValidationPart::ALL {
        let number = |outcome| results.number(part, outcome);
        let (passed, outlying, failed) = (
            number(CheckOutcome::Passed),
            number(CheckOutcome::Outlying),
            number(CheckOutcome::Failed),
        );
        if passed + outlying + failed == 0 {
            continue;
        }
        let mut words = format!("{} passed", count(passed));
        if outlying > 0 {
            words += &format!(", {outlying} outlying");
        }
        if failed > 0 {
            words += &format!(", {failed} FAILED");
        }
        report.line(&part.to_string(), words);
    }
    for (name, why) in results.peers.iter().flat_map(|peers| &peers.missing) {
        session.note(&format!("--peers: {name} was not asked: {why}"));
    }
    for peer in results.peers.iter().flat_map(|peers| &peers.answered) {
        report.line(&peer.program, peer.summary());
    }
    // Name the first failed checks, so that the page need not be opened for them.
    let failed = results
        .records
        .iter()
        .filter(|r| r.outcome == CheckOutcome::Failed);
    for record in failed.take(LISTED) {
        session.note(&format!(
            "{}: {} by {}: {} is {}, expected {} ± {:.1e}",
            record.part,
            record.subject,
            record.engine,
            record.description,
            record.found,
            record.expected,
            record.bound,
        ));
    }
    // Totals are for the JSON, since the lines have the numbers of each part.
    report.value("checks", results.records.len());
    report.value("passed", results.total(CheckOutcome::Passed));
    report.value("outlying", results.total(CheckOutcome::Outlying));
    report.value("failed", results.total(CheckOutcome::Failed));
    let path = args.output.join(report::PAGE).display().to_string();
    report.fact("output", path.clone(), "report", path);
    report
}

/// Failed checks that the summary names.
const LISTED: usize = 20;
