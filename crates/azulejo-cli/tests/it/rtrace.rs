//! `--look rtrace` on the command line.

use crate::support::Folder;
use azulejo::formats::picture::png;
use azulejo::render::srgb_from_linear;

/// A ball before a background.
const BALL: &str = "\
view
0 0 8
0 0 0
0 1 0
10 10
colors
0.2 0.4 0.6
0.1 0.1 0.1
lights
1 5 5 5 1 1 1

surfaces
1 0.9 0.5 0.1 0.9 0.9 0.9 0 0 0 0 0 0 0 0

objects
1 1 1 0 0 0 1

";

#[test]
fn the_command_draws_old_scenes() {
    let folder = Folder::new();
    folder.write("ball.sff", BALL);
    folder.ok("render ball.sff --look rtrace -o a.png");
    let picture = png::read(&folder.read("a.png")).unwrap();
    assert_eq!((picture.width, picture.height), (256, 256));
    let byte = |v: f32| (255.0 * srgb_from_linear(v.into())).round();
    // The background as it is in the file, times 256.
    assert_eq!(picture.pixel(0, 0).map(byte), [51.0, 102.0, 154.0]);
    assert!(picture.pixel(140, 110)[0] > picture.pixel(140, 110)[2]);

    folder.ok("render ball.sff --look rtrace -o b.png --threads 1");
    assert_eq!(folder.read("a.png"), folder.read("b.png"));
    folder.ok("render ball.sff --look rtrace -o c.exr --size 20x30 --look-levels 2");
    folder.ok("render ball.sff --look rtrace -o d.png --from 3,0,8 --at 0,0,1 --fov 30");
    assert_ne!(folder.read("a.png"), folder.read("d.png"));
    folder.ok("render ball.sff --look rtrace -o e.png --look-eye left=2 --size 40x40");
    folder.ok("render ball.sff --look rtrace -o f.png --look-eye right=2 --size 40x40");
    assert_ne!(folder.read("e.png"), folder.read("f.png"));
    folder.ok("render ball.sff --look rtrace -o g.png --look-aperture 0.1 --look-focus 6");
}

#[test]
fn looks_and_their_options_go_together() {
    let folder = Folder::with_room();
    folder.write("ball.sff", BALL);
    let missing = "needs the surfaces and lights of a single SFF or SCN scene";
    folder.fails("render room.obj --look rtrace -o a.png", 1, missing);
    folder.fails(
        "render room.obj ball.sff --look rtrace -o a.png",
        1,
        missing,
    );
    folder.fails(
        "render ball.sff --look-model 0 -o a.png",
        2,
        "requires --look rtrace",
    );
    let line = "render ball.sff --look rtrace --exposure 1 -o a.png";
    folder.fails(line, 2, "--exposure does not apply");
    let line = "render ball.sff --look rtrace --turntable 3 -o a.png";
    folder.fails(line, 2, "--turntable does not apply");
    // Each view would replace the errors of the one before.
    let line = "render room.obj --reference --error-image e.exr --turntable 3 -o a.png";
    folder.fails(line, 2, "cannot be used with");
    folder.fails(
        "render ball.sff --look rtrace --look-levels 4 -o a.png",
        2,
        "0..=3",
    );
    folder.fails(
        "render ball.sff --look rtrace --at 0,0,8 -o a.png",
        2,
        "no direction",
    );
    assert!(!folder.names().contains(&"a.png".to_owned()));
}
