use super::*;
use azulejo_trace::sampling::uniform;

const SIZE: u32 = 48;

/// An image by a function of column and row.
fn image(of: impl Fn(u32, u32) -> [f32; 3]) -> Image {
    let pixels = (0..SIZE * SIZE).map(|k| of(k % SIZE, k / SIZE)).collect();
    Image::opaque(SIZE, SIZE, pixels)
}

/// A texture of stripes, which the albedo holds, on two walls with an edge between them, under light
/// that grows from left to right.
fn albedo(x: u32, _: u32) -> f32 {
    if x % 6 < 3 { 0.8 } else { 0.2 }
}

fn light(x: u32, y: u32) -> f32 {
    let wall = if y < SIZE / 2 { 1.0 } else { 0.4 };
    wall * (1.0 + x as f32 / SIZE as f32)
}

fn truth() -> Image {
    image(|x, y| [albedo(x, y) * light(x, y); 3])
}

fn layers() -> PictureLayers {
    let nothing = || image(|_, _| [0.0; 3]);
    let count = (SIZE * SIZE) as usize;
    let upper = |y: u32| y < SIZE / 2;
    PictureLayers {
        albedo: image(|x, y| [albedo(x, y); 3]),
        albedo_error: nothing(),
        normal: image(|_, y| {
            if upper(y) {
                [0.0, 0.0, 1.0]
            } else {
                [0.0, 1.0, 0.0]
            }
        }),
        normal_error: nothing(),
        depth: vec![3.0; count],
        object: vec![1; count],
        material: vec![1; count],
        glyph: vec![0; count],
    }
}

/// The truth with noise of a relative standard deviation.
fn noisy(deviation: f32) -> MeasuredImage {
    let truth = truth();
    let half = |h: u32| {
        image(|x, y| {
            let pixel = y * SIZE + x;
            // The sum of twelve uniform numbers has variance 1.
            let normal = (0..12).map(|k| uniform(&[pixel, h, k])).sum::<f32>() - 6.0;
            truth.pixels[pixel as usize].map(|v| v * (1.0 + deviation * 2f32.sqrt() * normal))
        })
    };
    let halves = [half(0), half(1)];
    let of = |f: &dyn Fn(usize, usize) -> f32| {
        image(|x, y| [0, 1, 2].map(|c| f((y * SIZE + x) as usize, c)))
    };
    let mean = of(&|k, c| 0.5 * (halves[0].pixels[k][c] + halves[1].pixels[k][c]));
    MeasuredImage {
        error: of(&|k, c| truth.pixels[k][c] * deviation),
        direct: mean.clone(),
        indirect: of(&|_, _| 0.0),
        image: mean,
        halves,
        removed: 0.0,
    }
}

#[test]
fn an_image_without_noise_is_unchanged() {
    let measured = noisy(0.0);
    let filtered = denoise(&measured, &layers(), &Progress::new()).unwrap();
    assert_eq!(filtered.image, measured.image);
    assert_eq!(
        [filtered.change, filtered.bias, filtered.error_after],
        [0.0; 3]
    );
}

#[test]
fn noise_goes_and_textures_and_edges_stay() {
    let measured = noisy(0.2);
    let filtered = denoise(&measured, &layers(), &Progress::new()).unwrap();
    let error = |image: &Image| crate::relative_rmse(image, &truth());
    let (before, after) = (error(&measured.image), error(&filtered.image));
    assert!(after < 0.25 * before, "{before}, then {after}");
    // Both estimates hold to a fifth of the noise that there was.
    let estimates = [filtered.error_before - before, filtered.error_after - after];
    for estimate in estimates {
        assert!(estimate.abs() < 0.2 * before, "{estimate}");
    }
    let mean = |image: &Image, is_in: &dyn Fn(u32, u32) -> bool| {
        let inside = |k: &u32| is_in(k % SIZE, k / SIZE);
        let values = (0..SIZE * SIZE).filter(inside);
        let values: Vec<f32> = values.map(|k| image.pixels[k as usize][0]).collect();
        values.iter().sum::<f32>() / values.len() as f32
    };
    // Rows beside the edge, and light and dark stripes.
    let rows = [SIZE / 2 - 1, SIZE / 2].map(|row| move |_: u32, y: u32| y == row);
    for is_in in &rows {
        let ratio = mean(&filtered.image, is_in) / mean(&truth(), is_in);
        assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
    }
    let dark = |x: u32, _: u32| x % 6 == 3;
    let ratio = mean(&filtered.image, &dark) / mean(&truth(), &dark);
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
}

#[test]
fn threads_do_not_matter() {
    let measured = noisy(0.3);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.install(|| denoise(&measured, &layers(), &Progress::new()).unwrap())
    };
    assert_eq!(run(1), run(4));
}
