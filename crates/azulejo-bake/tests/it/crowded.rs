//! Charts that are too many, too thin, or denser than others.

use azulejo_bake::check::{CheckOptions, check};
use azulejo_bake::{Coverage, LayoutError, Receiver, TriangleId, UnwrapOptions, unwrap};
use azulejo_scene::Scene;
use azulejo_trace::{Progress, Tracer};
use glam::DVec3;
use std::collections::HashSet;

/// Squares of one size, or of many.
fn squares(count: u32, side: impl Fn(u32) -> f64) -> Vec<Receiver> {
    (0..count)
        .map(|k| {
            let at = DVec3::new(f64::from(k % 100) * 10.0, f64::from(k / 100) * 10.0, 0.0);
            let corner = |x: f64, y: f64| at + side(k) * DVec3::new(x, y, 0.0);
            Receiver {
                name: format!("square {k}"),
                positions: vec![
                    corner(0.0, 0.0),
                    corner(1.0, 0.0),
                    corner(1.0, 1.0),
                    corner(0.0, 1.0),
                ],
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                parts: vec![0; 2],
                density: 1.0,
                ..Receiver::default()
            }
        })
        .collect()
}

#[test]
fn a_size_that_would_do_is_named() {
    let tracer = Tracer::new(&Scene::default());
    let sized = |receivers: &[Receiver], size: u32, options: &UnwrapOptions| {
        let options = UnwrapOptions { size, ..*options };
        let progress = Progress::new();
        let layout = unwrap(receivers, &tracer, &options, &progress);
        // No size is found by trying: charts are made once, whether they fit or not.
        assert_eq!(progress.done(), progress.total(), "{size}");
        layout
    };
    // 2601 cells of 5 texels are all that 256² has.
    for (count, size, padding, blocks) in [
        (2700, 256, 2, false),
        (10_404, 256, 2, false),
        (3000, 128, 1, false),
        (2000, 128, 2, true),
    ] {
        let options = UnwrapOptions {
            padding,
            blocks,
            ..UnwrapOptions::default()
        };
        for side in [|_: u32| 1.0, |k: u32| 0.1 + f64::from(k % 50)] {
            let receivers = squares(count, side);
            let failed = sized(&receivers, size, &options);
            let Err(LayoutError::TooManyCharts { enough, .. }) = failed else {
                panic!("{count} on {size}: {:?}", failed.map(|l| l.charts));
            };
            let said = LayoutError::TooManyCharts { size, enough }.to_string();
            assert!(
                said.contains(&format!("a size of {enough} texels")),
                "{said}"
            );
            let found = sized(&receivers, enough, &options);
            let found = found.unwrap_or_else(|e| panic!("{count} on {enough}: {e}"));
            assert_eq!(found.charts, count);
        }
    }
    let none = LayoutError::TooManyCharts {
        size: 16_384,
        enough: 32_768,
    };
    assert!(
        none.to_string()
            .ends_with("ask for more pages, or less padding")
    );
}

/// Strips that are far thinner than texels: each covers whole texels, and nothing is nearer than before.
#[test]
fn slivers_cover_texels() {
    let tracer = Tracer::new(&Scene::default());
    let mut receivers = squares(300, |_| 1.0);
    for (k, receiver) in receivers.iter_mut().enumerate() {
        let origin = receiver.positions[0];
        let thin = 10f64.powf(-2.0 - 6.0 * (k as f64) / 300.0);
        for corner in &mut receiver.positions {
            let offset = *corner - origin;
            *corner = origin + DVec3::new(8.0 * offset.x, thin * offset.y, offset.x);
        }
        if k % 2 == 0 {
            receiver.triangles.truncate(1);
            receiver.parts.truncate(1);
        }
    }
    // One that is large, so that texels are.
    receivers.extend(squares(1, |_| 60.0));
    for padding in [1, 2] {
        let options = UnwrapOptions {
            size: 512,
            padding,
            ..UnwrapOptions::default()
        };
        let layout = unwrap(&receivers, &tracer, &options, &Progress::new()).unwrap();
        let wanted = CheckOptions {
            gap: 2.0 * f64::from(padding),
            crease: options.crease,
        };
        let found = check(&receivers, &layout, &wanted);
        assert_eq!(found.thin.count, 0, "{found:?}");
        // The unwrapper takes what is a million times longer than wide for a line.
        assert!(found.collapsed_share < 1e-6, "{found:?}");
        assert_eq!(found.near.count, 0, "{found:?}");
        assert_eq!(found.overlaps.count, 0, "{found:?}");
        assert_eq!(found.outside.count, 0, "{found:?}");
        let coverage = Coverage::new(&receivers, &layout, 0, &Progress::new()).unwrap();
        assert_eq!(coverage.shared, 0);
        let covered: HashSet<TriangleId> = (0..coverage.texels.len())
            .flat_map(|t| coverage.pieces(t).iter().map(|p| p.of))
            .collect();
        assert_eq!(covered.len(), found.triangles - found.collapsed.count);
        assert!(covered.len() > 200);
    }
}

/// Objects are as dense as is asked for.
#[test]
fn densities_are_kept() {
    let tracer = Tracer::new(&Scene::default());
    let mut receivers = squares(3, |_| 1.0);
    receivers[1].density = 2.0;
    receivers[2].density = 0.5;
    let layout = unwrap(
        &receivers,
        &tracer,
        &UnwrapOptions::default(),
        &Progress::new(),
    );
    let layout = layout.unwrap();
    let density = |r: usize| {
        let texels: f64 = (0..2)
            .map(|t| {
                let [a, b, c] = layout.texels(r, t);
                0.5 * (b - a).perp_dot(c - a).abs()
            })
            .sum();
        texels.sqrt()
    };
    for (r, wanted) in [(1, 2.0), (2, 0.5)] {
        let ratio = density(r) / density(0);
        assert!((ratio / wanted - 1.0).abs() < 0.01, "{r}: {ratio}");
    }
}
