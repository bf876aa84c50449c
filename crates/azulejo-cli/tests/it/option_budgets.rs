//! How many options each command may have. One more has to be worth more than what it costs everybody who reads the
//! help: look for one that it replaces first, and say in the commit why the budget grows.

use azulejo_cli::parsers::command_line;
use clap::{Arg, Command};

/// Each command with its most options, without those of every command.
const BUDGETS: [(&str, usize); 25] = [
    ("info", 30),
    ("convert", 32),
    ("solve", 49),
    ("bake", 76),
    ("render", 76),
    ("probe", 53),
    ("form-factors", 62),
    ("merge", 4),
    ("exchange", 51),
    ("experiment", 4),
    ("validate", 6),
    ("text", 24),
    ("font convert", 3),
    ("font sheet", 3),
    ("extrude", 16),
    ("brdf list", 0),
    ("brdf eval", 2),
    ("brdf plot", 5),
    ("brdf check", 1),
    ("brdf fit", 4),
    ("grf fmt", 1),
    ("grf lint", 2),
    ("grf diff", 13),
    ("view", 5),
    ("completions", 0),
];

#[test]
fn commands_have_no_more_options_than_their_budgets() {
    let mut definition = command_line();
    definition.build();
    let mut counts = Vec::new();
    count(&definition, "", &mut counts);
    for (name, options) in &counts {
        let budget = BUDGETS.iter().find(|(command, _)| command == name);
        let most = budget.map_or(0, |(_, most)| *most);
        assert!(
            *options <= most,
            "`{name}` has {options} options, and its budget is {most}"
        );
        assert!(
            *options == most,
            "`{name}` has only {options} options: lower its budget of {most}"
        );
    }
    for (name, _) in BUDGETS {
        let is_there = counts.iter().any(|(command, _)| command == name);
        assert!(is_there, "there is no command `{name}`");
    }
}

/// Adds the number of options of each command that has no subcommands, by its name.
fn count(command: &Command, name: &str, counts: &mut Vec<(String, usize)>) {
    for inner in command.get_subcommands().filter(|c| c.get_name() != "help") {
        let name = format!("{name} {}", inner.get_name());
        if inner.has_subcommands() {
            count(inner, &name, counts);
            continue;
        }
        let options = inner.get_arguments().filter(|arg| is_counted(arg)).count();
        counts.push((name.trim_start().to_owned(), options));
    }
}

/// Whether an argument is an option that the help of its command shows beside those of every command.
fn is_counted(arg: &Arg) -> bool {
    let is_its_own = |long: &str| !["help", "version"].contains(&long);
    arg.get_long().is_some_and(is_its_own) && !arg.is_hide_set() && !arg.is_global_set()
}
