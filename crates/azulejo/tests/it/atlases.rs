//! Atlases of the files of others: ours are clean, and theirs can be looked at.

use azulejo::bake::check::{CheckOptions, check};
use azulejo::bake::{
    LayoutError, Receiver, ReceiverLayout, UnwrapOptions, kept_layout, repack, unwrap,
};
use azulejo::formats::gltf::patch::{GltfFile, coordinates};
use azulejo::formats::gltf::{ObjectOrigin, read_with_origins};
use azulejo::formats::{Folder, ReadOptions};
use azulejo::scene::Scene;
use azulejo::trace::{Progress, Tracer};
use std::path::{Path, PathBuf};

/// Most triangles of a file, for a test that takes seconds.
const MOST_TRIANGLES: usize = 20_000;

fn files_in(folder: &Path, list: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            files_in(&path, list);
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            list.push(path);
        }
    }
}

/// Calls a function with all glTF files that can be read.
fn each(data: &Path, mut look: impl FnMut(&str, &GltfFile, &Scene, &[ObjectOrigin])) {
    let mut list = Vec::new();
    files_in(&data.join("corpus/gltf"), &mut list);
    let options = ReadOptions::default();
    for path in list {
        let bytes = std::fs::read(&path).unwrap();
        let name = path.display().to_string();
        let files = Folder::of_model(&path);
        let file = GltfFile {
            bytes: &bytes,
            name: &name,
            files: &files,
            options: &options,
        };
        if let Ok((loaded, origins)) = read_with_origins(&bytes, &name, &files, &options) {
            look(&name, &file, &loaded.scene, &origins);
        }
    }
}

fn receivers(scene: &Scene) -> Vec<Receiver> {
    let objects = scene.objects.iter();
    objects.filter_map(Receiver::of_object).collect()
}

#[test]
fn atlases_of_files_are_clean() {
    let Some(data) = azulejo_testing::data() else {
        return;
    };
    let mut clean = 0;
    each(&data, |name, _, scene, _| {
        let receivers = receivers(scene);
        let triangles: usize = receivers.iter().map(|r| r.triangles.len()).sum();
        if triangles > MOST_TRIANGLES {
            return;
        }
        let options = UnwrapOptions {
            size: 512,
            ..UnwrapOptions::default()
        };
        let layout = unwrap(&receivers, &Tracer::new(scene), &options, &Progress::new());
        let layout = match layout {
            Ok(layout) => layout,
            Err(LayoutError::NoSurface) => return,
            Err(error) => panic!("{name}: {error}"),
        };
        let wanted = CheckOptions {
            gap: 4.0,
            crease: options.crease,
        };
        let found = check(&receivers, &layout, &wanted);
        assert!(found.is_complete, "{name}");
        for finding in [found.outside, found.overlaps, found.near, found.creases] {
            assert_eq!(finding.count, 0, "{name}: {found:?}");
        }
        assert!(found.mirrored_share < 1e-6, "{name}: {found:?}");
        assert!(found.collapsed_share < 1e-6, "{name}: {found:?}");
        assert!(found.stretch <= 1.05, "{name}: {found:?}");
        clean += 1;
    });
    assert!(clean > 10, "{clean}");
}

/// Coordinates of pictures are looked at and packed, whatever they are.
#[test]
fn coordinates_of_files_are_looked_at() {
    let Some(data) = azulejo_testing::data() else {
        return;
    };
    let mut looked = 0;
    each(&data, |name, file, scene, origins| {
        let found = coordinates(file, origins, 0).unwrap();
        let objects = scene.objects.iter().zip(&found.objects);
        let (receivers, layouts): (Vec<Receiver>, Vec<ReceiverLayout>) = objects
            .filter_map(|(object, layout)| {
                let layout = layout.as_ref()?;
                let receiver = Receiver::of_object(object)?;
                assert_eq!(receiver.triangles.len(), layout.uvs.len(), "{name}");
                let of_receiver = ReceiverLayout {
                    uvs: layout.uvs.clone(),
                    pages: layout.pages.clone(),
                    ..ReceiverLayout::default()
                };
                Some((receiver, of_receiver))
            })
            .unzip();
        let triangles: usize = receivers.iter().map(|r| r.triangles.len()).sum();
        if receivers.is_empty() || triangles > MOST_TRIANGLES {
            return;
        }
        let pages = vec![[512; 2]; found.pages.len()];
        let kept = kept_layout(&receivers, layouts.clone(), pages, 30.0, None);
        let judged = check(&receivers, &kept, &CheckOptions::default());
        assert!(judged.triangles <= triangles, "{name}");
        let options = UnwrapOptions {
            size: 512,
            ..UnwrapOptions::default()
        };
        let tracer = Tracer::new(scene);
        let packed = match repack(&receivers, &layouts, &tracer, &options, &Progress::new()) {
            Ok(packed) => packed,
            Err(LayoutError::NoSurface) => return,
            Err(error) => panic!("{name}: {error}"),
        };
        let judged = check(&receivers, &packed, &CheckOptions::default());
        for finding in [judged.outside, judged.overlaps, judged.near] {
            assert_eq!(finding.count, 0, "{name}: {judged:?}");
        }
        looked += 1;
    });
    assert!(looked > 5, "{looked}");
}
