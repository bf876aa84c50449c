//! Stores as folders.

use azulejo_formats::zarr::{ZarrSink, ZarrStore};
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::PathBuf;

/// A folder that is read.
#[derive(Clone, Debug)]
pub struct StoreFolder(pub PathBuf);

impl ZarrStore for StoreFolder {
    fn names(&self) -> io::Result<Vec<String>> {
        let mut names = Vec::new();
        for entry in fs::read_dir(&self.0)? {
            let entry = entry?;
            if entry.path().join("zarr.json").is_file()
                && let Ok(name) = entry.file_name().into_string()
            {
                names.push(name);
            }
        }
        names.sort();
        Ok(names)
    }

    fn get(&self, key: &str, most: u64) -> io::Result<Option<Vec<u8>>> {
        let file = match File::open(self.0.join(key)) {
            Ok(file) => file,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(e),
        };
        let mut content = Vec::new();
        file.take(most.saturating_add(1))
            .read_to_end(&mut content)?;
        if content.len() as u64 > most {
            let message =
                format!("the file has more than {most} bytes, which its array has no room for");
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
        }
        Ok(Some(content))
    }
}

/// A folder that is written to; it must be there.
#[derive(Debug)]
pub struct StoreFolderSink(pub PathBuf);

impl ZarrSink for StoreFolderSink {
    fn put(&mut self, key: &str, content: &[u8]) -> io::Result<()> {
        let path = self.0.join(key);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        let mut file = File::create(path)?;
        file.write_all(content)?;
        // Who finds the whole store in its place must find all of it, after a power cut too.
        file.sync_data()
    }
}
