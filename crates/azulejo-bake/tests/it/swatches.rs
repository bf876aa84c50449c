//! Squares in a row, one for each thing that a material can be, under even light.

use azulejo_bake::web_page::{
    PageLightmap, PageMaterial, PageMesh, PageModel, PageOpacity, PagePicture,
};
use azulejo_scene::{Camera, Up};
use flate2::Crc;
use flate2::write::ZlibEncoder;
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use std::f32::consts::PI;
use std::io::Write;

/// Pixels per square and columns of squares.
const SIDE: u32 = 64;
const COLUMNS: u32 = 7;

/// Irradiance per π, so that what is shown is this times the colour.
const LIGHT: [f32; 3] = [2.0, 1.0, 0.5];

/// Where squares are looked at, from their lower left corners: the middles of their quarters.
const LOW: f64 = 0.25;
const HIGH: f64 = 0.75;

/// A row of squares from x = 0 on, in the plane through the origin that faces the camera.
struct Row {
    up: Up,
    model: PageModel,
    points: Vec<Value>,
}

/// The squares, and what is seen of them.
pub fn swatches(up: Up) -> (PageModel, Value) {
    let mut row = Row::new(up);
    let half = PageMaterial::matt("half", [0.5; 3]);
    let painted = |opacity| PageMaterial {
        picture: Some(PagePicture {
            bytes: four_colors(),
            media_type: "image/png".into(),
            ..PagePicture::default()
        }),
        opacity,
        ..half.clone()
    };
    let corners = [
        (LOW, HIGH, [0.5, 0.0, 0.0]),
        (HIGH, HIGH, [0.0, 0.5, 0.0]),
        (LOW, LOW, [0.0, 0.0, 0.5]),
    ];
    for (column, opacity) in [
        (0, PageOpacity::Opaque),
        (1, PageOpacity::Mask { cutoff: 0.5 }),
    ] {
        row.square(column, 0.0, painted(opacity), |_| {});
        for (x, y, color) in corners {
            row.expect(column, (x, y), Some(lit(color)));
        }
    }
    row.expect(0, (HIGH, LOW), Some(lit([0.5; 3])));
    row.expect(1, (HIGH, LOW), None);

    let glass = PageOpacity::Blend { opacity: 0.25 };
    let red = PageMaterial::matt("red", [0.8, 0.0, 0.0]);
    row.square(
        2,
        0.1,
        PageMaterial {
            opacity: glass,
            ..red
        },
        |_| {},
    );
    row.square(2, 0.0, half.clone(), |_| {});
    row.expect(
        2,
        (LOW, LOW),
        Some(lit([0.25 * 0.8 + 0.75 * 0.5, 0.375, 0.375])),
    );

    let unlit = PageMaterial {
        unlit: true,
        ..half.clone()
    };
    row.square(3, 0.0, unlit, |_| {});
    row.expect(3, (LOW, LOW), Some([0.5; 3]));

    let one_sided = PageMaterial {
        double_sided: false,
        ..half.clone()
    };
    row.square(4, 0.0, one_sided, |mesh| mesh.indices.reverse());
    row.expect(4, (LOW, LOW), None);

    row.square(5, 0.0, half.clone(), |mesh| {
        mesh.colors = vec![[1.0, 0.5, 0.25]; 4]
    });
    row.expect(5, (LOW, LOW), Some(lit([0.5, 0.25, 0.125])));

    let lamp = PageMaterial {
        emission: [3.0, 2.0, 1.0],
        ..half
    };
    row.square(6, 0.0, lamp, |mesh| mesh.lightmap_uvs.clear());
    row.expect(6, (LOW, LOW), Some([3.0, 2.0, 1.0]));
    let (width, height) = (COLUMNS * SIDE, SIDE);
    (
        row.model,
        json!({ "camera": 0, "width": width, "height": height, "points": row.points }),
    )
}

fn lit(color: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|c| color[c] * LIGHT[c])
}

impl Row {
    fn new(up: Up) -> Row {
        let model = PageModel {
            title: "Swatches".into(),
            lightmaps: vec![PageLightmap {
                width: 4,
                height: 4,
                irradiance: vec![LIGHT.map(|x| x * PI); 16],
                standard_error: Vec::new(),
            }],
            up,
            ..PageModel::default()
        };
        let mut row = Row {
            up,
            model,
            points: Vec::new(),
        };
        let distance = 10.0;
        let middle = f64::from(COLUMNS) / 2.0;
        row.model.cameras.push(Camera {
            name: "front".into(),
            eye: row.world(middle, 0.5, distance),
            target: row.world(middle, 0.5, 0.0),
            up: up.axis(),
            vertical_fov: 2.0 * (0.5 / distance).atan(),
            size: Some((COLUMNS * SIDE, SIDE)),
        });
        row
    }

    /// A place to the right, above, and nearer to the camera than the origin.
    fn world(&self, x: f64, y: f64, nearer: f64) -> DVec3 {
        match self.up {
            Up::Y => DVec3::new(x, y, nearer),
            Up::Z => DVec3::new(x, -nearer, y),
        }
    }

    fn square(
        &mut self,
        column: u32,
        nearer: f64,
        material: PageMaterial,
        change: impl FnOnce(&mut PageMesh),
    ) {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let place =
            |[x, y]: [f64; 2]| -> Vec3 { self.world(f64::from(column) + x, y, nearer).as_vec3() };
        let flat = corners.map(|c| c.map(|x| x as f32)).to_vec();
        let mut mesh = PageMesh {
            name: material.name.clone(),
            positions: corners.map(|c| place(c).into()).to_vec(),
            uvs: flat.clone(),
            lightmap_uvs: flat,
            indices: vec![0, 1, 2, 0, 2, 3],
            material: self.model.materials.len() as u32,
            ..PageMesh::default()
        };
        change(&mut mesh);
        self.model.materials.push(material);
        self.model.meshes.push(mesh);
    }

    /// Radiance at a place of a column's square, from its lower left corner; `None`: nothing is there.
    fn expect(&mut self, column: u32, place: (f64, f64), radiance: Option<[f32; 3]>) {
        let side = f64::from(SIDE);
        let x = (f64::from(column) + place.0) * side;
        let y = (1.0 - place.1) * side;
        self.points
            .push(json!({ "x": x.floor() + 0.5, "y": y.floor() + 0.5, "radiance": radiance }));
    }
}

/// A PNG of 16 × 16 pixels in four squares: red and green above blue and transparent white.
fn four_colors() -> Vec<u8> {
    let mut rows = ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    for y in 0..16 {
        rows.write_all(&[0]).unwrap();
        for x in 0..16 {
            let pixel: [u8; 4] = match (x < 8, y < 8) {
                (true, true) => [255, 0, 0, 255],
                (false, true) => [0, 255, 0, 255],
                (true, false) => [0, 0, 255, 255],
                (false, false) => [255, 255, 255, 0],
            };
            rows.write_all(&pixel).unwrap();
        }
    }
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    let header = [0, 0, 0, 16, 0, 0, 0, 16, 8, 6, 0, 0, 0];
    for (name, data) in [
        (b"IHDR", header.to_vec()),
        (b"IDAT", rows.finish().unwrap()),
        (b"IEND", Vec::new()),
    ] {
        let mut crc = Crc::new();
        crc.update(name);
        crc.update(&data);
        file.extend((data.len() as u32).to_be_bytes());
        file.extend(name);
        file.extend(data);
        file.extend(crc.sum().to_be_bytes());
    }
    file
}
