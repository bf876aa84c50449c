//! `grf fmt`: the canonical layout.

use super::super::failure::Failure;
use super::super::report::Report;
use super::super::session::Session;
use super::args::FmtArgs;
use azulejo::models::read_bytes;
use azulejo::output::Output;
use azulejo_formats::grf::formatted;
use std::io::Write;
use std::path::Path;

/// Runs `grf fmt`; the second result is the end of the command after its report.
pub fn run(args: &FmtArgs, session: &Session) -> Result<(Report, Result<(), Failure>), Failure> {
    let is_stdin = |path: &Path| path == Path::new("-");
    let uses_stdout = !args.check && args.files.iter().any(|p| is_stdin(p));
    session.claim_stdout(uses_stdout)?;
    let mut changed = Vec::new();
    // All are read before any is written, so that a mistake in one changes none.
    for path in &args.files {
        let bytes = read_bytes(path)?;
        let name = path.to_string_lossy();
        let laid_out = formatted(&bytes, &name).map_err(Failure::failed)?;
        if laid_out != bytes || is_stdin(path) {
            changed.push((path, laid_out, bytes));
        }
    }
    if args.check {
        changed.retain(|(_, new, old)| new != old);
    } else {
        for (path, new, _) in &changed {
            let output = Output::check(path)?;
            output.write(session.progress(), |out: &mut dyn Write| out.write_all(new))?;
        }
        changed.retain(|(path, ..)| !is_stdin(path));
    }
    let names: Vec<String> = changed
        .iter()
        .map(|(path, ..)| path.display().to_string())
        .collect();
    let mut report = Report::default();
    report.value("changed", names.clone());
    let verb = if args.check { "differs" } else { "changed" };
    if !session.quiet() && !uses_stdout {
        names.iter().for_each(|name| report.line(verb, name));
    }
    let is_found = args.check && !names.is_empty();
    Ok((
        report,
        if is_found {
            Err(Failure::Found)
        } else {
            Ok(())
        },
    ))
}
