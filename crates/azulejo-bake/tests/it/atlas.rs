//! Charts and texels of real and made meshes.

use azulejo_bake::layout::NO_CHART;
use azulejo_bake::{
    Atlas, Coverage, Layout, Lightmap, LightmapPage, Receiver, Resolution, UnwrapOptions,
    pad_charts, stitch, unwrap,
};
use azulejo_scene::synthetic::{
    CornellVariant, cornell_box, displaced_sphere, room_with_table, street,
};
use azulejo_scene::{Material, Mesh, Object, Rgb, Scene, Shape};
use azulejo_trace::{Progress, Tracer};
use glam::DVec3;

fn receivers(scene: &Scene) -> Vec<Receiver> {
    scene
        .objects
        .iter()
        .filter_map(Receiver::of_object)
        .collect()
}

fn atlas(scene: &Scene, options: &UnwrapOptions) -> Atlas {
    let receivers = receivers(scene);
    let tracer = Tracer::new(scene);
    let layout = unwrap(&receivers, &tracer, options, &Progress::new()).unwrap();
    Atlas {
        receivers,
        layout,
        turned: Vec::new(),
    }
}

fn scenes() -> Vec<(&'static str, Scene)> {
    vec![
        ("Cornell box", cornell_box(CornellVariant::Diffuse)),
        ("ball", displaced_sphere(2000)),
        ("room", room_with_table(24)),
        ("street", street()),
    ]
}

/// The chart of each texel of a page; a texel of two charts fails.
fn chart_map(atlas: &Atlas, page: u32) -> (Vec<u32>, Coverage) {
    let found = Coverage::new(&atlas.receivers, &atlas.layout, page, &Progress::new()).unwrap();
    assert_eq!(found.shared, 0, "texels of two charts");
    let [width, height] = found.size;
    let mut charts = vec![NO_CHART; (width * height) as usize];
    for texel in &found.texels {
        charts[texel.index as usize] = texel.chart;
    }
    (charts, found)
}

#[test]
fn charts_are_apart_and_texels_cover_all_area() {
    let options = UnwrapOptions {
        size: 256,
        ..UnwrapOptions::default()
    };
    for (name, scene) in scenes() {
        let atlas = atlas(&scene, &options);
        let (charts, coverage) = chart_map(&atlas, 0);
        let [width, height] = coverage.size.map(|n| n as i32);
        let near = 2 * options.padding as i32;
        for texel in &coverage.texels {
            let (x, y) = (texel.index as i32 % width, texel.index as i32 / width);
            for (dx, dy) in (-near..=near).flat_map(|dx| (-near..=near).map(move |dy| (dx, dy))) {
                let (x, y) = (x + dx, y + dy);
                // Charts are twice the padding apart, and each may begin within a texel.
                if dx.abs().max(dy.abs()) < near
                    && (0..width).contains(&x)
                    && (0..height).contains(&y)
                {
                    let other = charts[(y * width + x) as usize];
                    assert!(
                        other == NO_CHART || other == texel.chart,
                        "{name}: {dx}, {dy} at {x}, {y}, {} and {other}",
                        texel.chart
                    );
                }
            }
        }
        let covered: f64 = coverage.texels.iter().map(|t| f64::from(t.area)).sum();
        let area: f64 = atlas.receivers.iter().map(Receiver::area).sum();
        assert!(
            (covered / area - 1.0).abs() < 1e-4,
            "{name}: {covered} of {area}"
        );
        let uvs = atlas
            .layout
            .receivers
            .iter()
            .flat_map(|r| &r.uvs)
            .flatten()
            .flatten();
        assert!(uvs.into_iter().all(|&c| (0.0..=1.0).contains(&c)), "{name}");
    }
}

/// No chart has two triangles that meet at more than the crease angle.
#[test]
fn charts_end_at_creases() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let atlas = atlas(&scene, &UnwrapOptions::default());
    for (receiver, layout) in atlas.receivers.iter().zip(&atlas.layout.receivers) {
        let normal = |t: usize| receiver.area_vector(t).normalize();
        for a in 0..receiver.triangles.len() {
            for b in 0..a {
                if layout.charts[a] == layout.charts[b] {
                    assert!(
                        normal(a).dot(normal(b)) > 0.99,
                        "{}: {a}, {b}",
                        receiver.name
                    );
                }
            }
        }
    }
}

/// A floor in two triangles, and a wall that stands along their common edge.
#[test]
fn charts_end_where_something_stands() {
    let mut scene = Scene::default();
    let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    let mut add = |corners: &[[f64; 3]], faces: &[[u32; 3]]| {
        let mut mesh = Mesh {
            positions: corners.iter().copied().map(DVec3::from).collect(),
            ..Mesh::default()
        };
        faces.iter().for_each(|face| mesh.push_face(face, grey));
        scene.objects.push(Object::new("sheet", Shape::Mesh(mesh)));
    };
    let floor = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    add(&floor, &[[0, 1, 2], [0, 2, 3]]);
    let without = atlas(&scene, &UnwrapOptions::default());
    assert_eq!(without.layout.charts, 1);
    let mut add = |corners: &[[f64; 3]], faces: &[[u32; 3]]| {
        let mut mesh = Mesh {
            positions: corners.iter().copied().map(DVec3::from).collect(),
            ..Mesh::default()
        };
        faces.iter().for_each(|face| mesh.push_face(face, grey));
        scene.objects.push(Object::new("wall", Shape::Mesh(mesh)));
    };
    let wall = [
        [0.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [1.0, 1.0, 1.0],
        [0.0, 0.0, 1.0],
    ];
    add(&wall, &[[0, 1, 2], [0, 2, 3]]);
    let with = atlas(&scene, &UnwrapOptions::default());
    let charts = &with.layout.receivers[0].charts;
    assert_ne!(charts[0], charts[1]);
}

#[test]
fn resolutions_are_kept() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let layout = |options: &UnwrapOptions| -> Layout { atlas(&scene, options).layout };
    let bounds = scene.bounds().diagonal();
    let density = 500.0 / bounds;
    let given = layout(&UnwrapOptions {
        resolution: Resolution::PerUnit(density),
        size: 8192,
        ..UnwrapOptions::default()
    });
    let found = given.density(&receivers(&scene));
    assert!(
        (found / density - 1.0).abs() < 0.02,
        "{found} for {density}"
    );
    let texels = layout(&UnwrapOptions {
        resolution: Resolution::Texels(50_000.0),
        size: 8192,
        ..UnwrapOptions::default()
    });
    let area: f64 = receivers(&scene).iter().map(Receiver::area).sum();
    let count = area * texels.density(&receivers(&scene)).powi(2);
    assert!((count / 50_000.0 - 1.0).abs() < 0.05, "{count}");
    let pages = layout(&UnwrapOptions {
        size: 256,
        pages: 3,
        ..UnwrapOptions::default()
    });
    assert_eq!(pages.pages.len(), 3);
    assert_eq!(pages.pages[0], [256, 256]);
}

#[test]
fn what_cannot_be_laid_out_is_said() {
    let scene = displaced_sphere(2000);
    let tracer = Tracer::new(&scene);
    let said = |receivers: &[Receiver], options: UnwrapOptions| {
        let failed = unwrap(receivers, &tracer, &options, &Progress::new());
        failed.unwrap_err().to_string()
    };
    let usual = UnwrapOptions::default();
    assert!(
        said(&[], usual).contains("no triangle"),
        "{}",
        said(&[], usual)
    );
    let small = UnwrapOptions { size: 2, ..usual };
    assert!(said(&receivers(&scene), small).contains("expected 5"));
    let dense = UnwrapOptions {
        resolution: Resolution::PerUnit(1e9),
        ..usual
    };
    assert!(said(&receivers(&scene), dense).contains("too large"));
    let cancelled = Progress::new();
    cancelled.cancel();
    let failed = unwrap(&receivers(&scene), &tracer, &usual, &cancelled);
    assert_eq!(failed.unwrap_err().to_string(), "cancelled");
}

/// A lightmap of noise on a ball of many charts: light is equal on both sides of seams, and means stay.
#[test]
fn seams_close() {
    let scene = displaced_sphere(2000);
    let options = UnwrapOptions {
        size: 256,
        crease: 80.0,
        ..UnwrapOptions::default()
    };
    let atlas = atlas(&scene, &options);
    let (charts, coverage) = chart_map(&atlas, 0);
    let mut page = LightmapPage::dark(coverage.size);
    page.charts.clone_from(&charts);
    for texel in &coverage.texels {
        let t = texel.index as usize;
        page.areas[t] = texel.area;
        let noise = azulejo_trace::sampling::uniform(&[texel.index, 9]);
        page.irradiance[t] = [1.0 + 0.1 * noise; 3];
    }
    pad_charts(&mut page, 2);
    let mut lightmap = Lightmap {
        pages: vec![page],
        buried: 0,
    };
    let before = lightmap.mean().mean();
    let errors = stitch(&mut lightmap, &atlas);
    assert!(errors.points > 500, "{errors:?}");
    assert!(errors.before > 0.02 && errors.after < 0.005, "{errors:?}");
    assert!((lightmap.mean().mean() / before - 1.0).abs() < 0.002);
}
