//! Files that come into the page, and files that leave it.

use super::text;
use azulejo::formats::{disk, recognize};
use js_sys::futures::spawn_local;
use js_sys::{Array, Uint8Array};
use std::cell::RefCell;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};
use wasm_bindgen::closure::Closure;
use wasm_bindgen::{JsCast, JsValue};
use web_sys::{Blob, File, FileList, HtmlAnchorElement, HtmlInputElement, Url};

/// The largest file, and the largest sum of files that are opened together, bytes: a page may have 4 GiB of
/// memory, and a model takes several times its file.
pub const MAX_FILES: u64 = 400 << 20;

/// Files that have come into the page.
#[derive(Debug, Default)]
pub struct Arrived {
    /// Their paths: of several, the models, or if none is one, all.
    pub paths: Vec<PathBuf>,
    /// What is to be said of them.
    pub errors: Vec<String>,
}

thread_local! {
    static DROPPED: RefCell<Vec<Arrived>> = RefCell::default();
}

/// Files that were dropped, since the last call.
pub fn take_dropped() -> Vec<Arrived> {
    DROPPED.take()
}

/// Reads files that were dropped; `done` is called when [`take_dropped`] has them.
pub fn read_dropped(files: Vec<File>, done: impl FnOnce() + 'static) {
    spawn_local(async move {
        let arrived = read_files(files, true).await;
        DROPPED.with_borrow_mut(|all| all.push(arrived));
        done();
    });
}

/// Puts a file into the page as if it had been dropped.
pub fn put_dropped(name: &str, bytes: Vec<u8>) {
    let mut arrived = Arrived::default();
    let mut room = MAX_FILES;
    keep(name, bytes, &mut arrived, &mut room);
    choose_models(&mut arrived);
    DROPPED.with_borrow_mut(|all| all.push(arrived));
}

/// Asks for files by the browser's dialog; `done` gets them, or none if it was cancelled.
pub fn pick(
    many: bool,
    types: &str,
    models: bool,
    done: impl FnOnce(Arrived) + 'static,
) -> Result<(), String> {
    let failed = |e: JsValue| text(&e);
    let document = web_sys::window()
        .and_then(|w| w.document())
        .ok_or("no page")?;
    let input = document.create_element("input").map_err(failed)?;
    let input: HtmlInputElement = input.dyn_into().map_err(|_| "no field for files")?;
    input.set_type("file");
    input.set_multiple(many);
    input.set_accept(types);
    let done = std::rc::Rc::new(RefCell::new(Some(done)));
    let (chosen, field) = (done.clone(), input.clone());
    let on_change = Closure::once_into_js(move || {
        let files = listed(field.files());
        spawn_local(async move {
            let mut arrived = read_files(files, models).await;
            let errors = std::mem::take(&mut arrived.errors);
            let paths = Vec::new();
            DROPPED.with_borrow_mut(|all| all.push(Arrived { paths, errors }));
            if let Some(done) = chosen.take() {
                done(arrived);
            }
        });
    });
    let on_cancel = Closure::once_into_js(move || {
        if let Some(done) = done.take() {
            done(Arrived::default());
        }
    });
    input.set_onchange(Some(on_change.unchecked_ref()));
    let listening = input.add_event_listener_with_callback("cancel", on_cancel.unchecked_ref());
    listening.map_err(failed)?;
    input.click();
    Ok(())
}

fn listed(files: Option<FileList>) -> Vec<File> {
    let files = files.into_iter();
    files
        .flat_map(|all| (0..all.length()).filter_map(move |k| all.get(k)))
        .collect()
}

async fn read_files(files: Vec<File>, models: bool) -> Arrived {
    let mut arrived = Arrived::default();
    let mut room = MAX_FILES;
    for file in files {
        let name = file.name();
        if file.size() > room as f64 {
            arrived.errors.push(too_large(&name, file.size()));
            continue;
        }
        match file.array_buffer().await {
            Ok(buffer) => keep(
                &name,
                Uint8Array::new(&buffer).to_vec(),
                &mut arrived,
                &mut room,
            ),
            Err(e) => arrived.errors.push(format!("{name}: {}", text(&e))),
        }
    }
    if models {
        choose_models(&mut arrived);
    }
    arrived
}

fn too_large(name: &str, bytes: f64) -> String {
    format!(
        "{name}: {:.0} MB; a page opens at most {} MB at once, the program that is installed more",
        bytes / 1e6,
        MAX_FILES / 1_000_000
    )
}

/// Keeps a file, or the files of an archive.
fn keep(name: &str, bytes: Vec<u8>, arrived: &mut Arrived, room: &mut u64) {
    if name.to_lowercase().ends_with(".zip") {
        return unpack(name, bytes, arrived, room);
    }
    match room.checked_sub(bytes.len() as u64) {
        Some(rest) => *room = rest,
        None => return arrived.errors.push(too_large(name, bytes.len() as f64)),
    }
    let path = Path::new("/").join(name);
    let _ = disk::write(&path, bytes);
    arrived.paths.push(path);
}

/// Keeps the files of an archive in a folder of its name.
fn unpack(name: &str, bytes: Vec<u8>, arrived: &mut Arrived, room: &mut u64) {
    let folder = &name[..name.len() - ".zip".len()];
    let mut archive = match zip::ZipArchive::new(Cursor::new(bytes)) {
        Ok(archive) => archive,
        Err(e) => return arrived.errors.push(format!("{name}: {e}")),
    };
    for k in 0..archive.len() {
        let entry = match archive.by_index(k) {
            Ok(entry) => entry,
            Err(e) => {
                arrived.errors.push(format!("{name}: {e}"));
                continue;
            }
        };
        // Names that lead out of the archive are left out.
        let Some(inner) = entry.enclosed_name().filter(|_| entry.is_file()) else {
            continue;
        };
        let inner = Path::new(folder).join(inner);
        let mut bytes = Vec::new();
        let read = entry.take(*room + 1).read_to_end(&mut bytes);
        match read {
            Ok(_) if bytes.len() as u64 > *room => {
                return arrived.errors.push(too_large(name, bytes.len() as f64));
            }
            Ok(_) => {
                *room -= bytes.len() as u64;
                let path = Path::new("/").join(inner);
                let _ = disk::write(&path, bytes);
                arrived.paths.push(path);
            }
            Err(e) => arrived
                .errors
                .push(format!("{name}: {}: {e}", inner.display())),
        }
    }
}

/// Of several files leaves the models, if there are any: the others are what models name.
fn choose_models(arrived: &mut Arrived) {
    let is_model = |path: &&PathBuf| {
        let bytes = disk::read(path).unwrap_or_default();
        recognize(&bytes, &path.to_string_lossy()).is_ok()
    };
    let models: Vec<PathBuf> = arrived.paths.iter().filter(is_model).cloned().collect();
    if !models.is_empty() {
        arrived.paths = models;
    }
}

/// Offers the files that were saved as downloads; several as one archive.
pub fn download_saved() {
    let paths = disk::take_written();
    let (kept, paths): (Vec<PathBuf>, Vec<PathBuf>) =
        paths.into_iter().partition(|p| p.starts_with(RECOVERY));
    for path in kept
        .iter()
        .filter(|p| p.extension().is_some_and(|e| e == "grf"))
    {
        if let Ok(bytes) = disk::read(path) {
            keep_copy(&bytes);
        }
    }
    match &paths[..] {
        [] => {}
        [path] => offer(path, disk::read(path).unwrap_or_default()),
        several => {
            let first = several
                .last()
                .map(|p| p.with_extension("zip"))
                .unwrap_or_default();
            if let Some(bytes) = packed(several) {
                offer(&first, bytes);
            }
        }
    }
}

/// The folder of recovery copies.
pub const RECOVERY: &str = "/recovery";

/// Hands a copy of the scene to the page, which survives the program.
fn keep_copy(bytes: &[u8]) {
    let global = js_sys::global();
    let keep = js_sys::Reflect::get(&global, &"azulejoKeep".into());
    if let Ok(keep) = keep.and_then(|k| k.dyn_into::<js_sys::Function>()) {
        let _ = keep.call1(&global, &Uint8Array::from(bytes));
    }
}

fn packed(paths: &[PathBuf]) -> Option<Vec<u8>> {
    let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for path in paths {
        let name = path.file_name()?.to_string_lossy();
        writer
            .start_file(name, zip::write::SimpleFileOptions::default())
            .ok()?;
        std::io::Write::write_all(&mut writer, &disk::read(path).ok()?).ok()?;
    }
    Some(writer.finish().ok()?.into_inner())
}

fn offer(path: &Path, bytes: Vec<u8>) {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let offer = || -> Result<(), JsValue> {
        let blob = Blob::new_with_u8_array_sequence(&Array::of1(&Uint8Array::from(&bytes[..])))?;
        let url = Url::create_object_url_with_blob(&blob)?;
        let document = web_sys::window()
            .and_then(|w| w.document())
            .ok_or("no page")?;
        let link: HtmlAnchorElement = document
            .create_element("a")?
            .dyn_into()
            .map_err(JsValue::from)?;
        link.set_href(&url);
        link.set_download(&name);
        link.click();
        // The browser has begun to read it when the click returns.
        Url::revoke_object_url(&url)
    };
    let _ = offer();
}
