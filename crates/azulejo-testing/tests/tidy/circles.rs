//! Inside of a crate: the modules that `lib.rs` declares use each other in one direction only, so
//! that each can be read with what is below it alone.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// For each module the modules that it uses.
type Uses = BTreeMap<String, BTreeSet<String>>;

#[test]
fn modules_of_a_crate_form_no_circle() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut seen = 0;
    for folder in fs::read_dir(&crates).expect("readable") {
        let folder = folder.expect("readable");
        let source = folder.path().join("src");
        if !source.join("lib.rs").exists() {
            continue;
        }
        let name = folder.file_name().to_string_lossy().into_owned();
        let uses = uses(&source);
        seen += uses.len();
        let circle = circle(&uses);
        assert_eq!(
            circle, None,
            "{name}: its modules use each other in a circle"
        );
    }
    assert!(seen > 200, "modules are not found: {seen}");
}

fn uses(source: &Path) -> Uses {
    let root = shipped(&fs::read_to_string(source.join("lib.rs")).expect("lib.rs is there"));
    let mut uses = Uses::new();
    for line in root.lines() {
        let declared = line.strip_prefix("pub ").unwrap_or(line);
        if let Some(module) = declared
            .strip_prefix("mod ")
            .and_then(|m| m.strip_suffix(';'))
        {
            uses.insert(module.to_owned(), BTreeSet::new());
        }
    }
    // What lib.rs exports again is used by its short name too.
    let mut exports = BTreeMap::new();
    for export in root.split("pub use ").skip(1) {
        let export = export.split(';').next().unwrap_or("");
        if let Some((module, names)) = export.split_once("::") {
            let names = first_names(names);
            exports.extend(names.into_iter().map(|name| (name, module.to_owned())));
        }
    }
    let modules: Vec<String> = uses.keys().cloned().collect();
    for module in &modules {
        let mut names = BTreeSet::new();
        let files = [format!("{module}.rs"), format!("{module}/mod.rs")].map(|f| source.join(f));
        for file in &files {
            let text = shipped(&fs::read_to_string(file).unwrap_or_default());
            names.extend(text.split("super::").skip(1).flat_map(first_names));
        }
        add_names(&files[0], &mut names);
        add_names(&source.join(module), &mut names);
        let used = names.into_iter().map(|name| match exports.get(&name) {
            Some(of) => of.clone(),
            None => name,
        });
        let used = used.filter(|used| used != module && modules.contains(used));
        uses.insert(module.clone(), used.collect());
    }
    uses
}

/// Adds the first names of all paths from the crate's root in a file or in a folder of files.
fn add_names(path: &Path, names: &mut BTreeSet<String>) {
    if let Ok(folder) = fs::read_dir(path) {
        for entry in folder {
            add_names(&entry.expect("readable").path(), names);
        }
    }
    let name = path.file_name().and_then(|n| n.to_str()).unwrap_or("");
    if !name.ends_with(".rs") || name.ends_with("tests.rs") {
        return;
    }
    let Ok(text) = fs::read_to_string(path) else {
        return;
    };
    for path in shipped(&text).split("crate::").skip(1) {
        names.extend(first_names(path));
    }
}

/// A file without comments, and without the tests at its end.
pub fn shipped(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or("");
    let lines = text
        .lines()
        .map(|line| line.split("//").next().unwrap_or(""));
    let lines: Vec<&str> = lines.collect();
    lines.join("\n").replace("#[cfg(test)]\nmod ", "")
}

/// The first name of a path, or those of a group of paths in braces.
fn first_names(path: &str) -> Vec<String> {
    let name = |path: &str| -> String {
        let is_part = |c: &char| c.is_alphanumeric() || *c == '_';
        path.trim_start().chars().take_while(is_part).collect()
    };
    let Some(group) = path.strip_prefix('{') else {
        return vec![name(path)];
    };
    let mut depth = 0;
    let mut names = vec![name(group)];
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => names.push(name(&group[at + 1..])),
            _ => {}
        }
    }
    names
}

/// Modules each of which uses the next, and the last one the first; `None` if there are none.
fn circle(uses: &Uses) -> Option<Vec<&str>> {
    // What uses nothing but modules that are already taken away is in no circle.
    let mut left: BTreeSet<&str> = uses.keys().map(String::as_str).collect();
    loop {
        let is_free = |m: &&str| uses[*m].iter().all(|used| !left.contains(used.as_str()));
        let free: Vec<&str> = left.iter().copied().filter(is_free).collect();
        if free.is_empty() {
            break;
        }
        left.retain(|m| !free.contains(m));
    }
    let mut way = vec![*left.first()?];
    loop {
        let next = uses[way[way.len() - 1]].iter();
        let next = next.map(String::as_str).find(|used| left.contains(used))?;
        if let Some(first) = way.iter().position(|m| *m == next) {
            return Some(way.split_off(first));
        }
        way.push(next);
    }
}

#[test]
fn circles_and_paths_are_seen() {
    let set = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect();
    let mut uses = Uses::from([
        ("a".to_owned(), set(&["b"])),
        ("b".to_owned(), set(&["c", "d"])),
        ("c".to_owned(), set(&[])),
        ("d".to_owned(), set(&["c"])),
    ]);
    assert_eq!(circle(&uses), None);
    uses.insert("d".to_owned(), set(&["b"]));
    assert_eq!(circle(&uses), Some(vec!["b", "d"]));
    assert_eq!(
        first_names("{a::{b, c}, D,\n    e_f::g};"),
        ["a", "D", "e_f"]
    );
    assert_eq!(first_names("sampling::hash;"), ["sampling"]);
    let text = "use crate::a; // crate::b\n#[cfg(test)]\nmod tests {\n    use crate::c;\n}";
    assert_eq!(shipped(text), "use crate::a; ");
}
