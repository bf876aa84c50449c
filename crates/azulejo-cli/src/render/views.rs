//! The pictures of one `render`: one, or one for each of several cameras.

use super::args::RenderArgs;
use crate::camera;
use crate::failure::Failure;
use azulejo::output::Output;
use azulejo_scene::{Camera, Scene};
use std::path::{Path, PathBuf};

/// A picture to render.
pub struct PictureView {
    /// Its camera.
    pub camera: Camera,
    /// Its file.
    pub path: PathBuf,
    /// Where it goes.
    pub output: Output,
}

/// The requested pictures, and their size. Several are written beside each other, with a
/// number or the camera's name before the extension.
pub fn choose(args: &RenderArgs, scene: &Scene) -> Result<(Vec<PictureView>, (u32, u32)), Failure> {
    let up = args.input.reading.up;
    let (requested_size, first) = (args.picture.size, camera::first_look);
    // Cameras by name are of the scene or in files; standard output has room for one picture only.
    let named: Vec<Camera> = match args.cameras.as_deref() {
        None => Vec::new(),
        Some(_) if args.output == Path::new("-") => {
            return Err(Failure::misuse(
                "--cameras: standard output takes one picture",
            ));
        }
        Some("all") if scene.cameras.is_empty() => {
            return Err(Failure::failed("--cameras all: the scene has no cameras"));
        }
        Some("all") => scene.cameras.clone(),
        Some(names) => names
            .split(',')
            .map(|name| camera::by_name_or_file(name.trim(), scene))
            .collect::<Result<_, _>>()?,
    };
    // All pictures have one size: the requested one, or that of the first camera.
    if !named.is_empty() {
        let size = requested_size.or(named[0].size).unwrap_or(camera::SIZE);
        camera::check_size(size)?;
        let views = named.into_iter().enumerate().map(|(k, camera)| {
            let label = label(&camera.name, k);
            view(camera, beside(&args.output, &label))
        });
        return Ok((distinct(views.collect::<Result<_, _>>()?)?, size));
    }
    // Without names there is one camera, of the only picture or of the first of a turntable.
    let (camera, size) = camera::choose(&args.view, requested_size, scene, up, first)?;
    let Some(count) = args.turntable else {
        return Ok((vec![view(camera, args.output.clone())?], size));
    };
    if args.output == Path::new("-") {
        return Err(Failure::misuse(
            "--turntable: standard output takes one picture",
        ));
    }
    // Numbers have leading zeros, so that files sort in the order of the turn.
    let digits = count.to_string().len().max(3);
    let turned = camera::turntable(&camera, count, scene.units.up.axis());
    let views = turned.into_iter().enumerate().map(|(k, camera)| {
        let label = format!("{:0digits$}", k + 1);
        view(camera, beside(&args.output, &label))
    });
    Ok((views.collect::<Result<_, _>>()?, size))
}

fn view(camera: Camera, path: PathBuf) -> Result<PictureView, Failure> {
    Ok(PictureView {
        output: Output::check(&path)?,
        camera,
        path,
    })
}

/// `name.ext` with a label: `name-label.ext`.
fn beside(path: &Path, label: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{label}.{extension}"))
}

/// A camera's name as a part of a file name; its number if it has none.
fn label(name: &str, number: usize) -> String {
    let plain = |c: char| {
        if c.is_alphanumeric() || "._-".contains(c) {
            c
        } else {
            '_'
        }
    };
    match name {
        "" => (number + 1).to_string(),
        name => name.chars().take(60).map(plain).collect(),
    }
}

/// Numbers files of the same name.
fn distinct(mut views: Vec<PictureView>) -> Result<Vec<PictureView>, Failure> {
    for k in 1..views.len() {
        if views[..k].iter().any(|before| before.path == views[k].path) {
            views[k].path = beside(&views[k].path, &(k + 1).to_string());
            views[k].output = Output::check(&views[k].path)?;
        }
    }
    Ok(views)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_several_pictures() {
        let path = beside(Path::new("out/room.png"), "003");
        assert_eq!(path, Path::new("out/room-003.png"));
        assert_eq!(label("", 4), "5");
        assert_eq!(label("kitchen/left view", 0), "kitchen_left_view");
    }
}
