//! One vertex's journey: from a file to irradiance to a pixel.
//!
//! `cargo run --release --example journey` reads a small room from text, solves its light,
//! writes it as GRF with the irradiance on its vertices, and draws it.

use azulejo::formats::{Memory, grf, obj, picture::png};
use azulejo::radiosity::{self, FirstPass};
use azulejo::render::{self, SecondPass, Tone, auto_exposure, tone_map};
use azulejo::scene::Camera;
use azulejo::trace::{Progress, Tracer};
use glam::DVec3;
use std::error::Error;
use std::fs::{self, File};

fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::temp_dir().join("azulejo-journey");
    fs::create_dir_all(&out)?;
    let mut grf_file = File::create(out.join("room.grf"))?;
    let mut png_file = File::create(out.join("room.png"))?;
    let folder = Memory::new().with("room.mtl", MATERIALS);
    let progress = Progress::new();
    let (first_pass, second_pass) = (FirstPass::default(), SecondPass::default());

    let mut loaded = obj::read(ROOM.as_bytes(), "room.obj", &folder)?; // "v 1 0 0" → positions[1]
    let light = radiosity::solve(
        &loaded.scene,
        &Tracer::new(&loaded.scene),
        &first_pass,
        &progress,
    )?; // rows, solve, gather to vertices
    loaded.scene.set_irradiance(light.irradiance); // the vertex now has its value
    grf::write(&loaded.scene, &mut grf_file)?; // irad (…) (1, 0, 0)
    let camera = Camera::framing(loaded.scene.bounds(), 1.0, DVec3::Y);
    let image = render::render(
        &loaded.scene,
        &Tracer::new(&loaded.scene),
        &camera,
        &second_pass,
        &progress,
    )?;
    png::write(
        image.width,
        image.height,
        &tone_map(&image, auto_exposure(&image), Tone::default()),
        &mut png_file,
    )?; // L = ρE/π, interpolated

    Ok(())
}

/// A floor, a wall, and a lamp above.
const ROOM: &str = "\
mtllib room.mtl
v 0 0 0
v 1 0 0
v 1 0 1
v 0 0 1
v 0 1 0
v 1 1 0
v 0.4 1 0.4
v 0.6 1 0.4
v 0.6 1 0.6
v 0.4 1 0.6
usemtl tile
f 1 4 3 2
f 1 2 6 5
usemtl lamp
f 7 8 9 10
";

const MATERIALS: &str = "\
newmtl tile
Kd 0.3 0.5 0.8
newmtl lamp
Ke 20 18 15
";
