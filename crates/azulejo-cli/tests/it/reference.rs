//! The path tracer on the command line.

use crate::support::{Folder, project};

#[test]
fn references_are_written_with_their_errors() {
    let folder = Folder::with_room();
    let scene = std::fs::read(project().join("examples/cornell.grf")).unwrap();
    folder.write("box.grf", scene);
    let command = "render box.grf --reference --spp 64 --size 12x9 -o room.exr --error-image e.hdr";
    let report = folder.json(command);
    let error = report["error"].as_f64();
    assert!(error.is_some_and(|e| e > 0.0 && e < 1.0), "{report}");
    assert!(!folder.read("e.hdr").is_empty() && !folder.read("room.exr").is_empty());
    folder.fails(
        "render room.obj -o x.png --error-image e.exr",
        2,
        "--reference",
    );
    let png = "render room.obj --reference -o x.png --error-image e.png";
    folder.fails(png, 2, "expected .exr or .hdr");
    folder.fails(
        "render room.obj --reference --gather 8 -o x.png",
        2,
        "--gather",
    );
}

#[test]
fn clamped_images_state_their_bias() {
    let folder = Folder::new();
    let scene = std::fs::read(project().join("examples/cornell-glossy.grf")).unwrap();
    folder.write("box.grf", scene);
    let command = "render box.grf --reference --spp 16 --size 16x16 -o x.exr";
    let share = |line: &str| folder.json(line)["clamped"].as_f64();
    assert_eq!(share(command), None);
    let some = share(&format!("{command} --clamp 1")).unwrap();
    let none = share(&format!("{command} --clamp 1000")).unwrap();
    assert!(some > 0.0 && some < 0.5 && none == 0.0, "{some} {none}");
    folder.fails(&format!("{command} --clamp 0"), 2, "above 0");
}
