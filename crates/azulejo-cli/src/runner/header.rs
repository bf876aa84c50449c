//! How a part describes the work that it belongs to.

use super::record_file::read_up_to;
use crate::content_key::{ContentHasher, ContentKey, shown};
use crate::failure::Failure;
use crate::parts::Shard;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::Path;

/// What a part begins with.
const MAGIC: &[u8; 16] = b"azulejo part 1\r\n";

/// What parts of all versions begin with.
const MARK: &[u8] = b"azulejo part ";

/// Magic, length of the text, its checksum.
const HEAD: usize = 16 + 4 + 4;

/// Most bytes of the text.
const MOST_TEXT: u32 = 1 << 26;

/// What blocks depend on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WorkKey {
    /// Of the scene.
    pub scene: ContentKey,
    /// Of options and kernel.
    pub settings: ContentKey,
    /// The engine, where it was to be chosen the chosen one.
    pub engine: String,
}

impl WorkKey {
    /// A key of all of it.
    pub fn whole(&self) -> ContentKey {
        let mut hasher = ContentHasher::new();
        hasher
            .add(&self.scene)
            .add(&self.settings)
            .add(&self.engine);
        hasher.key()
    }
}

/// A file that the work was computed from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct NamedFile {
    /// As the command names it.
    pub path: String,
    /// The name, relative to the folder of `path`, of a file that was read for it; nothing for itself.
    pub beside: Option<String>,
    /// Key of its content.
    pub content: String,
}

/// The header of a part.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartHeader {
    /// Version of azulejo.
    pub version: String,
    /// The command's arguments.
    pub command: Vec<String>,
    /// Key of those that are not about the shard, its output and where files are.
    pub options: String,
    /// The folder in which it ran.
    pub folder: String,
    /// Which part this is.
    pub shard: Shard,
    /// The files that it names, and those read for them.
    pub files: Vec<NamedFile>,
    /// Keys of what its blocks depend on: see [`WorkKey`].
    pub scene: String,
    pub settings: String,
    pub engine: String,
}

/// What stands at the beginning of a file.
pub enum FileStart {
    /// A header of this number of bytes.
    Header(Box<PartHeader>, u64),
    /// The beginning of one, or nothing.
    Beginning,
}

impl PartHeader {
    /// The bytes of the file's beginning.
    pub fn bytes(&self) -> Vec<u8> {
        // A structure of strings and numbers has a text.
        let text = serde_json::to_vec(self).unwrap_or_default();
        let mut bytes = MAGIC.to_vec();
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(crc32fast::hash(&text).to_le_bytes());
        bytes.extend(text);
        bytes
    }

    /// Reads the beginning of a file.
    ///
    /// # Errors
    /// It is not a part, or one of another version, or damaged.
    pub fn read(file: &mut File, path: &Path) -> Result<FileStart, Failure> {
        let failed = |e: io::Error| Failure::file("read", path, &e);
        let refused =
            |words: &str| Err(Failure::failed(format_args!("{} {words}", path.display())));
        file.rewind().map_err(failed)?;
        let mut head = [0; HEAD];
        let read = read_up_to(file, &mut head).map_err(failed)?;
        // The mark tells parts of any version from other files, even where the file ends within it.
        if !head.starts_with(&MARK[..MARK.len().min(read)]) {
            return refused(
                "is not a part: it does not begin as what a command with --shard writes; give the parts alone, \
                 and each shard a file of its own",
            );
        }
        // A file that ends within its header may be an interrupted start, which is for the caller to judge.
        if read < MAGIC.len() {
            return Ok(FileStart::Beginning);
        }
        if !head.starts_with(MAGIC) {
            return refused(
                "is a part of another version of azulejo, or damaged: compute it and merge it by the same \
                 version",
            );
        }
        if read < HEAD {
            return Ok(FileStart::Beginning);
        }
        // Length and checksum tell damage from a header of another version, which only fails to parse.
        let [length, checksum] = [16, 20].map(|at| {
            let bytes = head[at..].first_chunk().copied().unwrap_or_default();
            u32::from_le_bytes(bytes)
        });
        if length > MOST_TEXT {
            return refused("is damaged: its header has no length; compute it again");
        }
        let mut text = Vec::new();
        let text_length = u64::from(length);
        file.take(text_length)
            .read_to_end(&mut text)
            .map_err(failed)?;
        if text.len() < length as usize {
            return Ok(FileStart::Beginning);
        }
        if crc32fast::hash(&text) != checksum {
            return refused("is damaged: the checksum of its header is wrong; compute it again");
        }
        match serde_json::from_slice(&text) {
            Ok(header) => Ok(FileStart::Header(
                Box::new(header),
                HEAD as u64 + text_length,
            )),
            Err(_) => refused(
                "is a part of another version of azulejo: compute it and merge it by the same version",
            ),
        }
    }

    /// The command, as it was typed.
    pub fn line(&self) -> String {
        let word = |word: &String| {
            if word.contains(char::is_whitespace) {
                format!("'{word}'")
            } else {
                word.clone()
            }
        };
        let words: Vec<String> = self.command.iter().map(word).collect();
        format!("azulejo {}", words.join(" "))
    }

    /// Whether it says that its blocks are of this work.
    pub fn has(&self, key: &WorkKey) -> bool {
        (&self.scene, &self.settings, &self.engine)
            == (&shown(&key.scene), &shown(&key.settings), &key.engine)
    }

    /// In what the work of another part differs from that of this one, as a sentence about the other;
    /// `None` if both are parts of one work.
    pub fn difference(&self, other: &PartHeader) -> Option<String> {
        if self.version != other.version {
            return Some(format!(
                "was computed by azulejo {}, and not by {}: compute all parts by the same version",
                other.version, self.version
            ));
        }
        if self.shard.of != other.shard.of {
            return Some(format!(
                "is one of {} shards, and not of {}: compute all with the same number",
                other.shard.of, self.shard.of
            ));
        }
        if self.scene != other.scene {
            return Some(format!("is of another scene: {}", self.other_files(other)));
        }
        if self.options != other.options {
            return Some(format!(
                "was computed with other options:\n  {}\n  {}",
                self.line(),
                other.line()
            ));
        }
        if self.engine != other.engine {
            return Some(format!(
                "was computed by the engine {}, and not by {}, because the machines differ in memory: choose one \
                 by --engine",
                other.engine, self.engine
            ));
        }
        if self.settings != other.settings {
            return Some(
                "was computed on a processor with other instructions for rays, whose results differ in the last \
                 bits: compute all parts on machines of one kind"
                    .to_owned(),
            );
        }
        None
    }

    /// The files that differ.
    fn other_files(&self, other: &PartHeader) -> String {
        let key = |f: &NamedFile| (file_name(&f.path).to_owned(), f.beside.clone());
        let differs = |f: &&NamedFile| {
            let same = other.files.iter().find(|o| key(o) == key(f));
            same.is_none_or(|o| o.content != f.content)
        };
        let names: Vec<String> = self
            .files
            .iter()
            .filter(differs)
            .map(NamedFile::name)
            .collect();
        if names.is_empty() {
            "options that change it differ".to_owned()
        } else {
            format!("{} differ", names.join(", "))
        }
    }
}

impl NamedFile {
    /// Its name for people.
    pub fn name(&self) -> String {
        match &self.beside {
            Some(name) => Path::new(&self.path)
                .with_file_name(name)
                .display()
                .to_string(),
            None => self.path.clone(),
        }
    }
}

fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}
