//! What is written is what was given, decoded as the viewer decodes it.

use super::light::{ERROR_STEPS, LIGHT_STEPS, LightCodes, OCTAVES, code, predicted};
use super::{PageLightmap, PageMaterial, PageMesh, PageModel, PageOpacity, PagePicture, write};
use std::io::{ErrorKind, Read};

fn triangle() -> PageModel {
    let mut model = PageModel::default();
    model.materials.push(PageMaterial::matt("grey", [0.5; 3]));
    model.meshes.push(PageMesh {
        name: "triangle".into(),
        positions: vec![[1e6, -0.0, 0.1], [1.0, -3e-20, 0.0], [0.0, 1.0, f32::MAX]],
        normals: vec![[0.0, 0.0, 1.0]; 3],
        lightmap_uvs: vec![[0.0, 0.0], [1.0, 0.25], [0.3, 1.0]],
        indices: vec![2, 0, 1],
        ..PageMesh::default()
    });
    model.lightmaps.push(PageLightmap {
        width: 2,
        height: 1,
        irradiance: vec![[1.0, 2.0, 3.0], [0.0, 1e-3, 5e4]],
        standard_error: Vec::new(),
    });
    model
}

fn page(model: &PageModel) -> String {
    let mut bytes = Vec::new();
    write(model, &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

/// The bytes of a piece of a page.
fn piece(page: &str, id: &str) -> Vec<u8> {
    let text = page.split(&format!("id=\"{id}\">")).nth(1).unwrap();
    let text = text.split("</script>").next().unwrap();
    let six = |c: u8| {
        let letters = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        letters.iter().position(|l| *l == c).unwrap() as u32
    };
    let mut bytes = Vec::new();
    for four in text.trim_end_matches('=').as_bytes().chunks(4) {
        let bits = four.iter().fold(0, |bits, c| bits << 6 | six(*c)) << (6 * (4 - four.len()));
        bytes.extend(&bits.to_be_bytes()[1..four.len()]);
    }
    bytes
}

fn inflated(page: &str, id: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let piece = piece(page, id);
    flate2::read::DeflateDecoder::new(piece.as_slice())
        .read_to_end(&mut bytes)
        .unwrap();
    bytes
}

/// Undoes `planes::push_differences` for `count` numbers at the start of `bytes`, which it shortens.
fn words(bytes: &mut &[u8], count: usize) -> Vec<u32> {
    let (list, rest) = bytes.split_at(4 * count);
    *bytes = rest;
    let mut last = 0u32;
    let word = |k: usize| {
        let z = u32::from_le_bytes([0, 1, 2, 3].map(|plane| list[plane * count + k]));
        last = last.wrapping_add(z >> 1 ^ 0u32.wrapping_sub(z & 1));
        last
    };
    (0..count).map(word).collect()
}

#[test]
fn geometry_comes_back_bit_for_bit() {
    let model = triangle();
    let bytes = inflated(&page(&model), "geometry");
    let mesh = &model.meshes[0];
    let mut rest = bytes.as_slice();
    for axis in 0..3 {
        let expected: Vec<f32> = mesh.positions.iter().map(|p| p[axis]).collect();
        let coordinates: Vec<f32> = words(&mut rest, 3)
            .into_iter()
            .map(f32::from_bits)
            .collect();
        assert_eq!(coordinates, expected);
    }
    assert_eq!(rest[..9], [0, 0, 0, 0, 0, 0, 127, 0, 0], "normals");
    rest = &rest[9..];
    for axis in 0..2 {
        for (word, uv) in words(&mut rest, 3).into_iter().zip(&mesh.lightmap_uvs) {
            assert!((f32::from_bits(word) - uv[axis]).abs() <= 0.5 / 1_048_576.0);
        }
    }
    assert_eq!(words(&mut rest, 3), mesh.indices);
    assert!(rest.is_empty());
}

/// Numbers of one list of a lightmap, as the viewer makes them whole.
fn whole(bytes: &[u8], width: usize) -> Vec<u16> {
    let count = bytes.len() / 2;
    let mut numbers = vec![0u16; count];
    for k in 0..count {
        let z = u16::from_le_bytes([bytes[k], bytes[count + k]]);
        let residual = z >> 1 ^ 0u16.wrapping_sub(z & 1);
        numbers[k] = predicted(&numbers, width, k).wrapping_add(residual);
    }
    numbers
}

fn value(code: u16, peak: f32, steps: u16) -> f64 {
    let octaves = f64::from(code) / f64::from(steps) - f64::from(OCTAVES);
    if code == 0 {
        0.0
    } else {
        f64::from(peak) * octaves.exp2()
    }
}

#[test]
fn light_comes_back_within_half_a_step() {
    let mut state = 7;
    let mut random = || azulejo_scene::random::split_mix64(&mut state);
    let (width, height) = (37, 23);
    // Six decades, and no light in places.
    let mut texel = || {
        let level = 10f64.powf(6.0 * random() - 3.0);
        let channel = |x: f64| if x < 0.05 { 0.0 } else { (level * x) as f32 };
        [random(), random(), random()].map(channel)
    };
    let map = PageLightmap {
        width,
        height,
        irradiance: (0..width * height).map(|_| texel()).collect(),
        standard_error: (0..width * height).map(|_| texel()).collect(),
    };
    let mut model = triangle();
    model.lightmaps = vec![map.clone()];
    let codes = LightCodes::new(&map);
    let bytes = inflated(&page(&model), "light-0");
    let lists: Vec<Vec<u16>> = bytes
        .chunks(2 * map.irradiance.len())
        .map(|list| whole(list, width as usize))
        .collect();
    let check = |decoded: f64, expected: f64, tolerance: f64| {
        assert!(
            (decoded - expected).abs() <= tolerance * expected,
            "{decoded} of {expected}"
        );
    };
    for (k, expected) in map.irradiance.iter().enumerate() {
        let green = lists[0][k];
        let channels = [
            lists[1][k].wrapping_add(green),
            green,
            lists[2][k].wrapping_add(green),
        ];
        for c in 0..3 {
            check(
                value(channels[c], codes.peak, LIGHT_STEPS),
                expected[c].into(),
                0.0028,
            );
        }
        let error = azulejo_scene::Rgb::from(map.standard_error[k].map(f64::from)).luminance();
        let decoded = value(lists[3][k], codes.error_peak.unwrap(), ERROR_STEPS);
        check(decoded, error, 0.045);
    }
}

#[test]
fn what_is_no_light_is_dark() {
    for value in [0.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e-38] {
        assert_eq!(code(value, 1.0, LIGHT_STEPS), 0, "{value}");
    }
    assert_eq!(code(5.0, 5.0, LIGHT_STEPS), LIGHT_STEPS * OCTAVES);
    let mut model = triangle();
    model.lightmaps[0].irradiance = vec![[f32::NAN; 3], [-1.0; 3]];
    assert!(page(&model).contains("\"peak\":1.0"));
}

#[test]
fn pictures_are_kept_as_they_are() {
    let mut model = triangle();
    let bytes: Vec<u8> = (0..=255).collect();
    model.materials[0].picture = Some(PagePicture {
        bytes: bytes.clone(),
        media_type: "image/png".into(),
        ..PagePicture::default()
    });
    assert_eq!(piece(&page(&model), "picture-0"), bytes);
}

#[test]
fn what_cannot_be_shown_is_refused() {
    let check = |change: fn(&mut PageModel), expected: &str| {
        let mut model = triangle();
        change(&mut model);
        let error = write(&model, &mut Vec::new()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidInput);
        assert_eq!(error.to_string(), expected);
    };
    check(
        |m| m.meshes[0].positions[1][2] = f32::NAN,
        "mesh 0 `triangle`: position 1 is [1.0, -3e-20, NaN], expected finite numbers",
    );
    check(
        |m| m.meshes[0].lightmap_uvs[0] = [f32::INFINITY, 0.0],
        "mesh 0 `triangle`: place in the lightmap 0 is [inf, 0.0], expected finite numbers",
    );
    check(
        |m| m.meshes[0].uvs.push([0.0; 2]),
        "mesh 0 `triangle`: 1 texture coordinates for 3 vertices",
    );
    check(
        |m| m.meshes[0].indices[0] = 3,
        "mesh 0 `triangle`: index 3 among 3 vertices",
    );
    check(
        |m| m.meshes[0].indices.push(0),
        "mesh 0 `triangle`: 4 indices, which are not triangles",
    );
    check(
        |m| m.meshes[0].material = 1,
        "mesh 0 `triangle`: material 1 of 1",
    );
    check(
        |m| m.lightmaps.clear(),
        "mesh 0 `triangle`: lightmap 0 of 0",
    );
    check(
        |m| m.lightmaps[0].width = 0,
        "lightmap 0 ``: 0 × 1 texels, expected 1 to 16384 a side",
    );
    check(
        |m| m.lightmaps[0].height = 2,
        "lightmap 0 ``: 2 values of irradiance for 4 texels",
    );
    check(
        |m| m.lightmaps[0].standard_error.push([0.0; 3]),
        "lightmap 0 ``: 1 standard errors for 2 texels",
    );
    check(
        |m| m.materials[0].emission[0] = f32::NAN,
        "material 0 `grey`: emission [NaN, 0.0, 0.0], expected finite numbers ≥ 0",
    );
    check(
        |m| m.materials[0].opacity = PageOpacity::Blend { opacity: 1.5 },
        "material 0 `grey`: opacity 1.5, expected 0 to 1",
    );
    check(
        |m| {
            m.materials[0].picture = Some(PagePicture {
                media_type: "text/html".into(),
                ..PagePicture::default()
            });
        },
        "material 0 `grey`: a picture of type `text/html`, expected one of image/png, image/jpeg, \
         image/webp, image/gif, image/bmp, image/avif",
    );
}
