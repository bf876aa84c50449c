//! The commands that README and the pages of `docs` show as shell code, and the examples of `--help`.
//!
//! All of them are parsed: their options exist and go together. Those of the pages in [`RUN`] are run as well, except the
//! ones in [`PARSED_ONLY`], in the order of the page, on small models of the names that it uses, and with less work: see
//! [`with_less_work`].

use crate::pages::{Page, pages};
use crate::support::{Folder, Run, project};
use crate::tiny_font;
use crate::year::weather_file;
use azulejo_cli::parsers::command_line;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Stdio;

/// The pages whose commands are run.
const RUN: [&str; 10] = [
    "README.md",
    "docs/bake.md",
    "docs/daylight.md",
    "docs/exchange.md",
    "docs/form-factors.md",
    "docs/glossy.md",
    "docs/look-rtrace.md",
    "docs/recipes.md",
    "docs/rendering.md",
    "docs/shards.md",
];

/// Parts of lines of these pages that are parsed only, and why.
const PARSED_ONLY: [(&str, &str); 13] = [
    (
        "gold.binary",
        "measured BRDFs are not part of the repository",
    ),
    ("case/case.foam", "needs a case of OpenFOAM"),
    (
        "--check --lightmap",
        "compares with the irradiance of another bake",
    ),
    ("xargs", "a queue of shards; two of them are run before"),
    ("parallel", "the same"),
    ("merge part-*", "their result"),
    ("merge parts/*", "the same"),
    ("downloads/", "the same"),
    ("3/64", "one shard of many"),
    ("SLURM", "a script for a queue"),
    ("model/city.obj", "a script for a cloud"),
    ("office.mgf", "a model of others"),
    ("--font Serif.ttf", "a font with the letters of the text"),
];

#[test]
fn commands_are_understood() {
    let mut count = 0;
    for page in pages() {
        for line in page.commands() {
            for words in calls(&line) {
                check(&words, &page.path);
                count += 1;
            }
        }
    }
    assert!(count > 150, "only {count} commands are found");
}

#[test]
fn examples_of_the_help_are_understood() {
    let mut count = 0;
    let mut definition = command_line();
    definition.build();
    let mut commands = vec![&definition];
    while let Some(command) = commands.pop() {
        commands.extend(command.get_subcommands());
        let help = command.get_after_long_help().or(command.get_after_help());
        let help = help
            .map(ToString::to_string)
            .unwrap_or_default()
            .replace("\\\n", " ");
        for line in help.lines().filter(|line| line.starts_with("  ")) {
            for words in calls(line) {
                check(&words, "--help");
                count += 1;
            }
        }
    }
    assert!(count > 60, "only {count} examples are found");
}

#[test]
fn commands_of_pages_run() {
    let mut count = 0;
    for page in pages()
        .iter()
        .filter(|page| RUN.contains(&page.path.as_str()))
    {
        count += run(page);
    }
    assert!(count > 40, "only {count} commands are run");
}

/// Parses a command as the program does.
fn check(words: &[String], place: &str) {
    let program = ["azulejo".to_owned()];
    let parsed = command_line().try_get_matches_from(program.iter().chain(words));
    if let Err(error) = parsed {
        panic!("{place}: azulejo {}\n{error}", words.join(" "));
    }
}

/// Runs the commands of a page in a folder of their own; returns their number.
fn run(page: &Page) -> usize {
    let folder = Folder::with_room();
    let mut count = 0;
    for line in page.commands() {
        if PARSED_ONLY.iter().any(|(part, _)| line.contains(part)) {
            continue;
        }
        for words in calls(&line) {
            let words = with_less_work(
                words
                    .iter()
                    .flat_map(|word| matching(&folder, word))
                    .collect(),
            );
            words.iter().for_each(|word| provide(&folder, word));
            make_folder_of_output(&folder, &words);
            let place = format!("{}: azulejo {}", page.path, words.join(" "));
            let run = run_with_input(&folder, &words, typed(&line));
            assert_eq!(run.code, Some(0), "{place}\n{}", run.err);
            count += 1;
        }
    }
    count
}

fn run_with_input(folder: &Folder, words: &[String], input: &str) -> Run {
    let mut command = folder.command("");
    command.args(words).stdin(Stdio::piped());
    let mut process = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    process
        .stdin
        .take()
        .unwrap()
        .write_all(input.as_bytes())
        .unwrap();
    Run::of(process.wait_with_output().unwrap())
}

/// The words behind each `azulejo` of a line of shell code, with values for its variables.
fn calls(line: &str) -> Vec<Vec<String>> {
    let mut calls = Vec::new();
    for simple in simple_commands(line) {
        let is_launched = |first: &String| {
            ["azulejo", "mpiexec", "srun", "xargs", "parallel"].contains(&first.as_str())
        };
        let at = simple.iter().position(|word| word == "azulejo");
        if let Some(at) = at.filter(|_| simple.first().is_some_and(is_launched)) {
            calls.push(simple[at + 1..].to_vec());
        }
    }
    calls
}

/// What `echo` passes on in a line of shell code.
fn typed(line: &str) -> &str {
    line.strip_prefix("echo \"")
        .and_then(|rest| rest.split('"').next())
        .unwrap_or("")
}

/// Shell code divided at `|`, `&`, `;`, `<`, `>` and comments, and each part into its words.
fn simple_commands(line: &str) -> Vec<Vec<String>> {
    let mut commands: Vec<Vec<String>> = vec![Vec::new()];
    let (mut word, mut quote) = (None::<String>, None);
    for c in line.chars() {
        match (c, quote) {
            ('"' | '\'', None) => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (c, Some(open)) if c == open => quote = None,
            (c, Some(_)) => word.get_or_insert_default().push(c),
            ('#', None) if word.is_none() => break,
            ('|' | '&' | ';' | '<' | '>' | ' ', None) => {
                if let (Some(word), Some(command)) = (word.take(), commands.last_mut()) {
                    command.push(word);
                }
                if c != ' ' {
                    commands.push(Vec::new());
                }
            }
            (c, None) => word.get_or_insert_default().push(c),
        }
    }
    if let (Some(word), Some(command)) = (word, commands.last_mut()) {
        command.push(word);
    }
    let values = [
        ("$SLURM_ARRAY_TASK_ID", "1"),
        ("$SLURM_CPUS_PER_TASK", "8"),
        ("$K", "1"),
        ("K/4", "1/4"),
        ("{}", "1"),
    ];
    let with_values = |word: String| {
        let replaced = values
            .iter()
            .fold(word, |word, (name, value)| word.replace(name, value));
        replaced.trim_end_matches('\r').to_owned()
    };
    commands
        .into_iter()
        .map(|words| words.into_iter().map(with_values).collect())
        .collect()
}

/// The files that a word with an asterisk at its end stands for.
fn matching(folder: &Folder, word: &str) -> Vec<String> {
    match word.strip_suffix('*') {
        Some(start) if !start.contains('/') => {
            let names = folder.names().into_iter();
            names.filter(|name| name.starts_with(start)).collect()
        }
        _ => vec![word.to_owned()],
    }
}

/// A command with few patches, rays, pixels and texels, in place of those that its page shows, and with a large error.
fn with_less_work(mut words: Vec<String>) -> Vec<String> {
    const LESS: [(&str, &str); 9] = [
        ("--size", "32"),
        ("--spp", "4"),
        ("--patches", "60"),
        ("--rays", "64"),
        ("--error", "60%"),
        ("--texels", "500"),
        ("--texels-per-metre", "2"),
        ("--cluster", "20"),
        ("--look-levels", "1"),
    ];
    let is_picture = words[0] == "render";
    for (option, value) in LESS {
        if let Some(at) = words.iter().position(|word| word == option) {
            let square = format!("{value}x{value}");
            words[at + 1] = if is_picture && option == "--size" {
                square
            } else {
                value.to_owned()
            };
        }
    }
    let is_matrix = words[1].ends_with(".npz");
    let has = |name: &str| words.iter().any(|word| word == name);
    let more: &[&str] = match words[0].as_str() {
        "render" if has("--reference") => &["--size", "32x32", "--spp", "4"],
        "render" => &[
            "--size",
            "32x32",
            "--spp",
            "4",
            "--patches",
            "60",
            "--error",
            "60%",
        ],
        "bake" if has("--check") || has("--strip") => &[],
        "bake" if has("--rays") => &["--patches", "60"],
        "bake" if has("--texels") || has("--texels-per-metre") => {
            &["--patches", "60", "--error", "60%"]
        }
        "bake" => &["--size", "32", "--patches", "60", "--error", "60%"],
        "probe" if has("--year") => &["--patches", "60"],
        "solve" | "probe" if !has("--rays") => &["--patches", "60", "--error", "60%"],
        "form-factors" | "exchange" if !(is_matrix || has("--patch-size") || has("--by")) => {
            &["--patches", "60"]
        }
        _ => &[],
    };
    let missing: Vec<String> = more
        .chunks(2)
        .filter(|pair| !has(pair[0]))
        .flatten()
        .map(|w| (*w).to_owned())
        .collect();
    words.extend(missing);
    words
}

/// Writes the file that a word names, if commands read such a file and nothing has written it before. Models are the
/// room, whatever their names say, where that is recognized by its content.
fn provide(folder: &Folder, word: &str) {
    let path = folder.path(word);
    if path.exists() {
        return;
    }
    let made = |line: &str| drop(folder.ok(line));
    match word {
        "scene.sff" | "demo.sff" => made(&format!("convert room.obj -o {word}")),
        "level.glb" | "lamp.glb" | "city.glb" => made(&format!("convert room.obj -o {word}")),
        "room.grf" => made("solve room.obj -o room.grf --patches 60 --error 60%"),
        "street.hdr" => {
            made("render room.obj -o street.hdr --size 64x32 --spp 1 --patches 60 --error 60%")
        }
        "anybodys.glb" => drop(fs::copy(folder.path("baked.glb"), path)),
        "Serif.ttf" | "Serif.otf" => folder.write(word, tiny_font::bytes()),
        "logo.svg" => folder.write(word, LOGO),
        "munich.epw" => folder.write(word, weather_file(|_, _| false)),
        "roof.txt" => folder.write(word, "1 3.5 1 0 1 0\n"),
        "desk.txt" => folder.write(word, "0.5 0.5 0.5\n"),
        "optics.csv" => folder.write(word, "name,eps\nlamp,0.05\n*,0.8\n"),
        "temperatures.csv" => folder.write(word, "name,T,q\nlamp,320,\n*,,0\n"),
        "studio.toml" => folder.write(word, "[[material]]\nname = \"white\"\ndiffuse = 0.5\n"),
        _ if word.starts_with("examples/") => provide_example(folder, word),
        _ if ROOMS.contains(&word) => drop(fs::copy(folder.path("room.obj"), path)),
        _ if THINGS.contains(&word) => folder.write(word, THING),
        _ => {}
    }
}

/// The models of pages that are the room here.
const ROOMS: [&str; 15] = [
    "cow.3ds",
    "house.obj",
    "room.dxf",
    "old.3ds",
    "room.wrl",
    "satellite.stl",
    "street.obj",
    "hall.grf",
    "car.obj",
    "city.stl",
    "city.obj",
    "zone.obj",
    "faces.obj",
    "teapot.obj",
    "model.3ds",
];

/// The models of pages that are a thing in the room.
const THINGS: [&str; 4] = ["chair.3ds", "sun.grf", "word.sff", "car.glb"];

const THING: &str = "v 1 1 1\nv 2 1 1\nv 2 1 2\nv 1 1 2\nf 1 4 3 2\n";

const LOGO: &str = "<svg xmlns=\"http://www.w3.org/2000/svg\"><path d=\"M0 0h4v2h-4z\"/></svg>";

/// Makes the folder of the file that a command writes.
fn make_folder_of_output(folder: &Folder, words: &[String]) {
    let output = words.iter().skip_while(|word| *word != "-o").nth(1);
    let parent = output.and_then(|output| folder.path(output).parent().map(Path::to_owned));
    if let Some(parent) = parent {
        fs::create_dir_all(parent).unwrap();
    }
}

/// Copies a file of `examples`.
fn provide_example(folder: &Folder, name: &str) {
    let path = folder.path(name);
    if let Some(parent) = path.parent() {
        fs::create_dir_all(parent).unwrap();
    }
    fs::copy(project().join(name), path).unwrap();
}
