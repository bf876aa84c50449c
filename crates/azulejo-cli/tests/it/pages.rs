//! Pages of the documentation, and the commands that they show.

use crate::support::project;
use std::fs;

/// A page of documentation.
pub struct Page {
    /// From the root, with slashes.
    pub path: String,
    pub text: String,
}

/// `README.md`, and all pages below `docs`, sorted by path.
pub fn pages() -> Vec<Page> {
    let mut paths = vec!["README.md".to_owned()];
    collect("docs", &mut paths);
    paths.sort();
    let page = |path: String| Page {
        text: fs::read_to_string(project().join(&path)).unwrap(),
        path,
    };
    paths.into_iter().map(page).collect()
}

fn collect(folder: &str, paths: &mut Vec<String>) {
    for entry in fs::read_dir(project().join(folder)).unwrap() {
        let entry = entry.unwrap();
        let path = format!("{folder}/{}", entry.file_name().to_string_lossy());
        if entry.file_type().unwrap().is_dir() {
            collect(&path, paths);
        } else if path.ends_with(".md") {
            paths.push(path);
        }
    }
}

impl Page {
    /// Each line of its blocks of shell commands; a line that ends in a backslash with those that continue it.
    pub fn commands(&self) -> Vec<String> {
        let mut commands = Vec::new();
        for block in self.blocks() {
            let joined = block.replace("\\\n", " ");
            commands.extend(
                joined
                    .lines()
                    .map(str::trim)
                    .filter(|l| !l.is_empty())
                    .map(str::to_owned),
            );
        }
        commands
    }

    /// Its blocks of shell commands.
    pub fn blocks(&self) -> Vec<String> {
        let mut blocks = Vec::new();
        let mut block: Option<(bool, String)> = None;
        for line in self.text.lines() {
            match (line.trim_start().strip_prefix("```"), &mut block) {
                (Some(language), None) => {
                    let is_shell = matches!(language.trim(), "sh" | "bash" | "console");
                    block = Some((is_shell, String::new()));
                }
                (Some(_), Some((is_shell, text))) => {
                    if *is_shell {
                        blocks.push(std::mem::take(text));
                    }
                    block = None;
                }
                (None, Some((_, text))) => {
                    text.push_str(line);
                    text.push('\n');
                }
                (None, None) => {}
            }
        }
        blocks
    }

    /// What stands between backticks in its sentences and tables.
    pub fn spans(&self) -> impl Iterator<Item = &str> {
        self.text.split('`').skip(1).step_by(2)
    }

    /// Whether it shows many commands of one kind.
    pub fn is_gallery(&self) -> bool {
        self.path.starts_with("docs/gallery/") || self.path == "docs/bake/models.md"
    }

    /// Its address, seen from a page in `docs`.
    pub fn link_from_docs(&self) -> String {
        match self.path.strip_prefix("docs/") {
            Some(path) => path.to_owned(),
            None => format!("../{}", self.path),
        }
    }
}
