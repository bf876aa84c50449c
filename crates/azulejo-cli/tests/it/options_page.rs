//! `docs/options.md`: all options of all commands, written from the definition of the command line and the examples of
//! the documentation. `AZULEJO_ACCEPT=1 cargo test -p azulejo-cli --test it options_page` writes it anew.

use crate::pages::{Page, pages};
use crate::support::project;
use azulejo_cli::parsers::command_line;
use clap::{Arg, Command};
use std::fmt::Write;
use std::fs;

const INTRODUCTION: &str = "\
# Options

All options of all commands: `azulejo COMMAND -h` shows the common ones, `--help` all of them, with details.
The last column is an example, with the page that has it.

This page is written from the definition of the command line, and a test compares it with that:
`AZULEJO_ACCEPT=1 cargo test -p azulejo-cli --test it options_page` writes it anew.
";

#[test]
fn the_page_has_the_options_of_the_parser() {
    let path = project().join("docs/options.md");
    let expected = page();
    if std::env::var_os("AZULEJO_ACCEPT").is_some() {
        fs::write(&path, &expected).unwrap();
    }
    let actual = fs::read_to_string(&path).unwrap_or_default();
    for (line, (actual, expected)) in actual.lines().zip(expected.lines()).enumerate() {
        assert_eq!(actual, expected, "docs/options.md:{}; {RENEW}", line + 1);
    }
    assert!(actual == expected, "docs/options.md is stale; {RENEW}");
}

const RENEW: &str = "AZULEJO_ACCEPT=1 writes it anew";

#[test]
fn each_option_has_an_example() {
    let page = page();
    let without = page.lines().filter(|line| line.ends_with("|  |"));
    let without: Vec<&str> = without.collect();
    assert!(
        without.is_empty(),
        "no page and no --help shows how to use:\n{}",
        without.join("\n")
    );
}

/// A row of a table.
#[derive(Clone, PartialEq, Eq)]
struct OptionRow {
    heading: String,
    /// As typed: the long name, and the short one.
    spellings: Vec<String>,
    /// As typed, with the short name.
    names: String,
    value: String,
    default: String,
    about: String,
    /// Whether a value follows as a word of its own.
    is_followed: bool,
}

/// A command without subcommands, with its own options and the ones of several commands.
struct CommandRows {
    /// Without `azulejo`.
    name: String,
    usage: String,
    about: String,
    /// The end of its help.
    examples: String,
    rows: Vec<OptionRow>,
}

/// Options that several commands have under one heading.
struct SharedRows {
    heading: String,
    /// Numbers of the commands.
    commands: Vec<usize>,
    rows: Vec<OptionRow>,
}

/// The page as it should be.
fn page() -> String {
    let mut definition = command_line();
    definition.build();
    let mut commands = Vec::new();
    list(&definition, "", &mut commands);
    let shared = shared_rows(&commands);
    let documentation: Vec<Page> = pages()
        .into_iter()
        .filter(|p| p.path != "docs/options.md")
        .collect();
    let mut text = INTRODUCTION.to_owned();
    text.push_str("\n| command | purpose |\n|---|---|\n");
    for command in &commands {
        let (name, about) = (&command.name, escaped(&command.about));
        let _ = writeln!(text, "| [`{name}`](#{}) | {about} |", anchor(name));
    }
    text.push_str("\n## Options of every command\n");
    let general: Vec<OptionRow> = definition.get_arguments().filter_map(row).collect();
    table(
        &general,
        &commands.iter().collect::<Vec<_>>(),
        &documentation,
        &mut text,
    );
    text.push_str("\n## Options of several commands\n");
    for group in &shared {
        let users: Vec<&CommandRows> = group.commands.iter().map(|&at| &commands[at]).collect();
        let names: Vec<String> = users.iter().map(|c| format!("`{}`", c.name)).collect();
        let _ = writeln!(text, "\n### {}\n\nFor {}.", group.heading, names.join(", "));
        table(&group.rows, &users, &documentation, &mut text);
    }
    text.push_str("\n## Options of one command\n");
    for (at, command) in commands.iter().enumerate() {
        section(at, command, &shared, &documentation, &mut text);
    }
    text
}

/// The section of a command.
fn section(
    at: usize,
    command: &CommandRows,
    shared: &[SharedRows],
    pages: &[Page],
    text: &mut String,
) {
    let _ = writeln!(text, "\n### {}\n\n`{}`", command.name, command.usage);
    let is_shared = |row: &OptionRow| shared.iter().any(|group| group.rows.contains(row));
    let own: Vec<OptionRow> = command
        .rows
        .iter()
        .filter(|row| !is_shared(row))
        .cloned()
        .collect();
    if !own.is_empty() {
        table(&own, &[command], pages, text);
    }
    let others = shared.iter().filter(|group| group.commands.contains(&at));
    let others: Vec<String> = others
        .map(|group| format!("[{}](#{})", group.heading, anchor(&group.heading)))
        .collect();
    if !others.is_empty() {
        let _ = writeln!(text, "\nAlso the options of {}.", others.join(", "));
    }
}

/// All commands that have no subcommands, in the order of `--help`.
fn list(command: &Command, name: &str, commands: &mut Vec<CommandRows>) {
    for inner in command.get_subcommands().filter(|c| c.get_name() != "help") {
        let name = format!("{name} {}", inner.get_name())
            .trim_start()
            .to_owned();
        if inner.has_subcommands() {
            list(inner, &name, commands);
            continue;
        }
        let usage = inner.clone().render_usage().to_string();
        let help = inner.get_after_long_help().or(inner.get_after_help());
        commands.push(CommandRows {
            usage: usage
                .trim_start_matches("Usage: ")
                .split_whitespace()
                .collect::<Vec<_>>()
                .join(" "),
            about: inner
                .get_about()
                .map(ToString::to_string)
                .unwrap_or_default(),
            examples: help.map(ToString::to_string).unwrap_or_default(),
            rows: inner
                .get_arguments()
                .filter(|arg| !arg.is_global_set())
                .filter_map(row)
                .collect(),
            name,
        });
    }
}

/// The row of an argument, if it is an option that users see.
fn row(arg: &Arg) -> Option<OptionRow> {
    let long = arg
        .get_long()
        .filter(|long| !arg.is_hide_set() && *long != "help" && *long != "version")?;
    let takes_value = arg.get_action().takes_values();
    let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
    let (about, noted) = without_default(&help);
    let default = match arg.get_default_values() {
        [value] if takes_value => value.to_string_lossy().into_owned(),
        _ => noted,
    };
    let short = arg.get_short().map(|short| format!("-{short}"));
    let spellings: Vec<String> = short.into_iter().chain([format!("--{long}")]).collect();
    Some(OptionRow {
        heading: arg.get_help_heading().unwrap_or("Options").to_owned(),
        names: format!("`{}`", spellings.join(", ")),
        spellings,
        value: if takes_value {
            value(arg)
        } else {
            String::new()
        },
        default,
        about: first_sentence(&about).to_owned(),
        is_followed: takes_value && !arg.is_require_equals_set(),
    })
}

/// What the value of an option is called, or the words that it may be.
fn value(arg: &Arg) -> String {
    let words = arg.get_possible_values();
    let words: Vec<&str> = words
        .iter()
        .filter(|w| !w.is_hide_set())
        .map(|w| w.get_name())
        .collect();
    let value = if (1..=8).contains(&words.len()) {
        words.join("|")
    } else {
        let names = arg.get_value_names().unwrap_or_default();
        names
            .iter()
            .map(|name| name.as_str())
            .collect::<Vec<_>>()
            .join(" ")
    };
    let value = value.replace('|', "\\|");
    if arg.is_require_equals_set() {
        format!("`[={value}]`")
    } else {
        format!("`{value}`")
    }
}

/// A help text without its remark on the default, and that.
fn without_default(help: &str) -> (String, String) {
    let parts = help
        .split_once("[default")
        .and_then(|(before, rest)| Some((before, rest.split_once(']')?)));
    match parts {
        None => (help.to_owned(), String::new()),
        Some((before, (default, after))) => {
            let default = default.trim_start_matches(':').trim();
            (format!("{}{after}", before.trim_end()), default.to_owned())
        }
    }
}

/// A text up to the full stop that another sentence follows.
fn first_sentence(text: &str) -> &str {
    let starts = |next: &str| next.starts_with(|c: char| c.is_uppercase() || c == '`' || c == '"');
    let ends = text
        .match_indices(". ")
        .find(|(at, _)| starts(&text[at + 2..]));
    text[..ends.map_or(text.len(), |(at, _)| at)].trim_end_matches('.')
}

/// Options that several commands have in the same words, by the heading of `--help`.
fn shared_rows(commands: &[CommandRows]) -> Vec<SharedRows> {
    let mut shared: Vec<SharedRows> = Vec::new();
    for row in commands.iter().flat_map(|command| &command.rows) {
        let users = commands
            .iter()
            .enumerate()
            .filter(|(_, command)| command.rows.contains(row));
        let users: Vec<usize> = users.map(|(at, _)| at).collect();
        if users.len() < 2 || shared.iter().any(|group| group.rows.contains(row)) {
            continue;
        }
        match shared
            .iter_mut()
            .find(|group| group.heading == row.heading && group.commands == users)
        {
            Some(group) => group.rows.push(row.clone()),
            None => {
                let taken = shared.iter().any(|group| group.heading == row.heading);
                assert!(
                    !taken,
                    "two sets of commands share options under {:?}",
                    row.heading
                );
                shared.push(SharedRows {
                    heading: row.heading.clone(),
                    commands: users,
                    rows: vec![row.clone()],
                });
            }
        }
    }
    shared
}

/// A table of options of some commands.
fn table(rows: &[OptionRow], commands: &[&CommandRows], pages: &[Page], text: &mut String) {
    text.push_str("\n| option | value | default | meaning | example |\n|---|---|---|---|---|\n");
    for row in rows {
        let (default, about) = (escaped(&row.default), escaped(&row.about));
        let example = example(row, commands, pages).unwrap_or_default();
        let _ = writeln!(
            text,
            "| {} | {} | {default} | {about} | {example} |",
            row.names, row.value
        );
    }
}

/// How an option is used: in a command of the page that says most of it, in its sentences, or in the help.
fn example(row: &OptionRow, commands: &[&CommandRows], pages: &[Page]) -> Option<String> {
    let calls = |line: &str| {
        commands
            .iter()
            .any(|c| line.contains(&format!("azulejo {} ", c.name)))
    };
    let in_commands = |page: &Page| {
        page.commands()
            .into_iter()
            .filter(|c| calls(c))
            .find_map(|c| usage(row, &c))
    };
    let is_about = |page: &Page| {
        commands
            .iter()
            .any(|c| page.text.contains(&format!("{}`", c.name)))
            || calls(&page.text)
    };
    let in_sentences = |page: &Page| {
        page.spans()
            .find_map(|span| usage(row, span))
            .filter(|_| is_about(page))
    };
    let best = |used: &dyn Fn(&Page) -> Option<String>| {
        let uses = pages.iter().filter_map(|page| Some((page, used(page)?)));
        let rank = |page: &Page| {
            (
                page.is_gallery(),
                usize::MAX
                    - page
                        .text
                        .matches(row.spellings.last().map_or("", String::as_str))
                        .count(),
            )
        };
        let (page, usage) = uses.min_by_key(|(page, _)| rank(page))?;
        Some(format!("[{usage}]({})", page.link_from_docs()))
    };
    let in_help = || {
        let mut lines = commands.iter().flat_map(|command| command.examples.lines());
        lines.find_map(|line| usage(row, line))
    };
    best(&in_commands)
        .or_else(|| best(&in_sentences))
        .or_else(in_help)
}

/// An option with the value that it has in a text, as code of a table.
fn usage(row: &OptionRow, text: &str) -> Option<String> {
    let marks = ['[', ']', '(', ')', '`', ',', ';', ':'];
    let mut words = text.split_whitespace();
    let is_option = |word: &&str| {
        let end = |c: char| !c.is_alphanumeric() && c != '-';
        let name = word.trim_start_matches(marks).split(end).next();
        name.is_some_and(|name| row.spellings.iter().any(|spelling| spelling == name))
    };
    let mut usage = words.find(is_option)?.trim_matches(marks).to_owned();
    let follows = |word: &&str| {
        let is_other = word.len() > 1
            && word.starts_with('-')
            && !word[1..].starts_with(|c: char| c.is_ascii_digit());
        !is_other && !word.starts_with(['|', '\\', '…'])
    };
    if let Some(first) = words.next().filter(|word| row.is_followed && follows(word)) {
        let quote = first.chars().next().filter(|c| matches!(c, '"' | '\''));
        usage = format!("{usage} {first}");
        let is_open = |usage: &str| quote.is_some_and(|quote| usage.matches(quote).count() == 1);
        while is_open(&usage) {
            let Some(word) = words.next() else { break };
            let _ = write!(usage, " {word}");
        }
    }
    let usage = usage
        .trim_end_matches([',', ';', ')', '`'])
        .replace('|', "\\|");
    Some(format!("`{usage}`"))
}

/// Text for a cell of a table: what Markdown would read as marks is escaped outside of code.
fn escaped(text: &str) -> String {
    let text = text.replace('|', "\\|");
    let parts = text.split('`').enumerate();
    let escape = |(at, part): (usize, &str)| match at % 2 {
        0 => part.replace('*', "\\*").replace('<', "\\<"),
        _ => part.to_owned(),
    };
    parts.map(escape).collect::<Vec<_>>().join("`")
}

/// What GitHub makes of a heading.
fn anchor(heading: &str) -> String {
    heading.to_lowercase().replace(' ', "-")
}
