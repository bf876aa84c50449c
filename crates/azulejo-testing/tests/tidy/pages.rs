//! Pages that name or quote code.

use crate::{root, sources};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_alphanumeric() && c != '_')
}

/// The words in the sources of all crates, and in the paths of these.
fn identifiers() -> BTreeSet<String> {
    let mut known = BTreeSet::new();
    for (path, text) in sources(&root().join("crates")) {
        known.extend(words(&text).map(str::to_owned));
        known.extend(words(&path.to_string_lossy()).map(str::to_owned));
    }
    known
}

#[test]
fn names_in_the_architecture_exist() {
    let known = identifiers();
    let page = fs::read_to_string(root().join("ARCHITECTURE.md")).expect("the architecture");
    let mut checked = 0;
    for code in page.split('`').skip(1).step_by(2) {
        for name in words(code).filter(|w| w.len() > 2 && w.starts_with(char::is_alphabetic)) {
            assert!(known.contains(name), "no code is named `{name}`: {code}");
            checked += 1;
        }
    }
    assert!(checked > 100, "the page has hardly any code");
}

#[test]
fn identifiers_of_the_glossary_exist() {
    let known = identifiers();
    let page = fs::read_to_string(root().join("docs/glossary.md")).expect("a glossary");
    let mut checked = 0;
    for row in page.lines().filter(|line| line.starts_with("| ")) {
        let last = row.trim_end_matches(" |").rsplit("| ").next();
        for name in last.unwrap_or("").split('`').skip(1).step_by(2) {
            assert!(known.contains(name), "no code is named `{name}`: {row}");
            checked += 1;
        }
    }
    assert!(checked > 50, "the glossary's last column is not found");
}

/// A block of code that begins with a comment naming a file is a quotation of that file: its lines
/// stand there in this order, an ellipsis for what is left out.
#[test]
fn pages_quote_code_as_it_is() {
    let folder = root().join("docs/how-to-add");
    let mut quotations = 0;
    for entry in fs::read_dir(folder).expect("the pages") {
        let path = entry.expect("a page").path();
        let page = fs::read_to_string(&path).expect("a page of text");
        for block in page.split("```rust").skip(1) {
            let mut lines = block.lines().skip(1).take_while(|line| *line != "```");
            let Some(file) = lines.next().and_then(|l| l.strip_prefix("// crates/")) else {
                continue;
            };
            let source = fs::read_to_string(root().join("crates").join(file));
            let source = source.unwrap_or_else(|e| panic!("{}: {file}: {e}", path.display()));
            let mut source = source.lines().map(str::trim);
            for line in lines
                .map(str::trim)
                .filter(|l| !l.is_empty() && *l != "// …")
            {
                let stands = source.any(|other| other == line);
                assert!(stands, "{}: {file} has no line {line:?}", path.display());
            }
            quotations += 1;
        }
    }
    assert!(quotations > 1, "no quotation was found");
}

/// Pages for readers, in the root and under `docs`.
fn all_pages() -> Vec<(PathBuf, String)> {
    [root(), root().join("docs")]
        .map(|folder| pages(&folder))
        .concat()
}

/// The pages of a folder; of `docs`, also those below.
fn pages(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("a readable entry").path();
        if path.is_dir() && folder.ends_with("docs") {
            files.extend(pages(&path));
        } else if path.extension().is_some_and(|e| e == "md") {
            let text = fs::read_to_string(&path).expect("a page of text");
            files.push((path, text));
        }
    }
    files
}

#[test]
fn benchmarks_that_pages_name_exist() {
    let mut checked = 0;
    for (page, text) in all_pages() {
        for command in text.split("cargo bench ").skip(1) {
            let mut words = command.split(|c: char| c.is_whitespace() || c == '`');
            let (Some("-p"), Some(package)) = (words.next(), words.next()) else {
                panic!("{}: cargo bench without -p PACKAGE", page.display());
            };
            let manifest = root().join("crates").join(package).join("Cargo.toml");
            let manifest = fs::read_to_string(&manifest).expect("the manifest of a benchmark");
            // Without --bench, all of the package's run.
            let name = match words.next() {
                Some("--bench") => words.next().unwrap_or(""),
                _ => continue,
            };
            let entry = format!("[[bench]]\nname = \"{name}\"");
            let place = page.display();
            assert!(
                manifest.contains(&entry),
                "{place}: {package} has no benchmark `{name}`"
            );
            checked += 1;
        }
    }
    assert!(checked > 5, "the commands are not found");
}

/// The files that a page links to.
fn links(page: &str) -> impl Iterator<Item = &str> {
    let ends = page.split("](").skip(1);
    ends.filter_map(|link| link.split([')', '#']).next())
        .filter(|target| !target.is_empty() && !target.contains("://"))
}

#[test]
fn links_of_pages_lead_somewhere() {
    for (page, text) in all_pages() {
        for target in links(&text) {
            let file = page.parent().expect("a folder").join(target);
            assert!(file.exists(), "{}: no {target}", page.display());
        }
    }
}

/// What `release/archive.sh` copies from the root: files, and folders as a whole.
fn packed() -> BTreeSet<PathBuf> {
    let script = fs::read_to_string(root().join("release/archive.sh")).expect("the script");
    let copies = script.lines().filter(|line| line.starts_with("cp "));
    copies
        .flat_map(str::split_whitespace)
        .filter(|word| {
            word.ends_with(".md") || ["docs", "examples", "web", "blender", "bevy"].contains(word)
        })
        .map(PathBuf::from)
        .collect()
}

#[test]
fn pages_of_a_release_link_to_what_is_in_it() {
    let packed = packed();
    let is_packed = |path: &Path| path.ancestors().any(|part| packed.contains(part));
    for (page, text) in all_pages() {
        let page = page.strip_prefix(root()).expect("a page below the root");
        if !is_packed(page) {
            continue;
        }
        let folder = page.parent().expect("a folder");
        for target in links(&text) {
            let file = resolved(&folder.join(target));
            assert!(is_packed(&file), "{}: {target} is missing", page.display());
        }
    }
}

/// A path without `..`, as written: no link of the file system is followed.
fn resolved(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            std::path::Component::ParentDir => drop(plain.pop()),
            part => plain.push(part),
        }
    }
    plain
}

/// Parts of the names of files that pages show how to add.
const TO_BE_ADDED: [&str; 2] = ["mesh_grid", "plain.rs"];

#[test]
fn paths_of_pages_exist() {
    let crates = names(&root().join("crates"));
    let mut checked = 0;
    for (page, text) in all_pages() {
        if page.ends_with("CHANGELOG.md") {
            continue;
        }
        let folder = page.parent().expect("a folder");
        for path in spans(&text).filter(|span| is_path(span, &crates)) {
            let is_to_be_added = TO_BE_ADDED.iter().any(|part| path.contains(part));
            let exists = is_to_be_added || stands(path, folder, &crates);
            assert!(exists, "{}: no {path}", page.display());
            checked += 1;
        }
    }
    assert!(checked > 50, "only {checked} paths are found");
}

/// What stands between backticks in the sentences and tables of a page.
fn spans(page: &str) -> impl Iterator<Item = &str> {
    let prose = page.split("```").step_by(2);
    prose.flat_map(|text| text.split('`').skip(1).step_by(2))
}

/// Whether a piece of code is a path of the repository, from its root or from a crate.
fn is_path(code: &str, crates: &BTreeSet<String>) -> bool {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_./-".contains(c);
    let Some((first, _)) = code.split_once('/').filter(|_| code.chars().all(is_plain)) else {
        return false;
    };
    let is_known = first == "src" || crates.contains(first) || root().join(first).exists();
    code.ends_with(".rs") || !first.is_empty() && !first.starts_with('.') && is_known
}

/// Whether a path leads somewhere from the root, from the folder of a page, or from a crate.
fn stands(path: &str, folder: &Path, crates: &BTreeSet<String>) -> bool {
    let places = ["", "src", "tests"].map(|part| {
        let mut homes = crates
            .iter()
            .map(|name| root().join("crates").join(name).join(part));
        homes.any(|home| home.join(path).exists())
    });
    let outer = [root(), root().join("crates"), folder.to_owned()];
    places.contains(&true) || outer.iter().any(|home| home.join(path).exists())
}

/// The names of what is in a folder.
fn names(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).expect("a readable folder");
    let name = |entry: std::io::Result<fs::DirEntry>| {
        entry
            .expect("a readable entry")
            .file_name()
            .to_string_lossy()
            .into_owned()
    };
    entries.map(name).collect()
}
