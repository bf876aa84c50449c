//! The Cornell box with light that is a function of the place, as a page and as what a ray sees.

use azulejo_bake::web_page::{PageLightmap, PageMaterial, PageMesh, PageModel};
use azulejo_scene::math::Ray;
use azulejo_scene::synthetic::{CornellVariant, cornell_box};
use azulejo_scene::{Mesh, Scene, Shape, Up};
use glam::{DVec2, DVec3};

/// Irradiance and its standard error at a place with a normal.
pub type Light = fn(&Room, DVec3, DVec3) -> ([f32; 3], [f32; 3]);

/// Texels between a chart and the border of its cell.
const PADDING: f64 = 2.0;

/// Triangles, each with a cell of the lightmap.
pub struct Room {
    pub scene: Scene,
    pub faces: Vec<Face>,
}

/// A triangle with its corners counterclockwise.
pub struct Face {
    pub object: usize,
    pub corners: Vec<DVec3>,
    pub material: usize,
    pub normal: DVec3,
}

impl Room {
    pub fn cornell() -> Room {
        let scene = cornell_box(CornellVariant::Diffuse);
        let mut faces = Vec::new();
        for (object, of) in scene.objects.iter().enumerate() {
            let Shape::Mesh(mesh) = &of.shape else {
                panic!("the box is of meshes")
            };
            faces.extend((0..mesh.faces.len()).flat_map(|k| triangles(object, mesh, k)));
        }
        Room { scene, faces }
    }

    /// A page with a lightmap of `size` × `size` texels of this light.
    pub fn page(&self, size: u32, light: Light) -> PageModel {
        let cells = (self.faces.len() as f64).sqrt().ceil() as u32;
        let cell = size / cells;
        let mut map = PageLightmap {
            width: size,
            height: size,
            irradiance: vec![[0.0; 3]; (size * size) as usize],
            standard_error: vec![[0.0; 3]; (size * size) as usize],
        };
        let mut meshes = Vec::new();
        for (k, face) in self.faces.iter().enumerate() {
            let corner = [k as u32 % cells * cell, k as u32 / cells * cell];
            let chart = Chart::new(face, corner, cell);
            for texel in 0..cell * cell {
                let place = [corner[0] + texel % cell, corner[1] + texel / cell];
                let middle = DVec2::new(f64::from(place[0]), f64::from(place[1])) + 0.5;
                let (value, error) = light(self, chart.world(middle), face.normal);
                let index = (place[1] * size + place[0]) as usize;
                map.irradiance[index] = value;
                map.standard_error[index] = error;
            }
            meshes.push(self.mesh(face, &chart, size));
        }
        PageModel {
            title: "Cornell box".into(),
            meshes,
            materials: self.materials(),
            lightmaps: vec![map],
            cameras: self.scene.cameras.clone(),
            up: Up::Y,
            photometric: false,
            note: "Light by formula.".into(),
        }
    }

    fn mesh(&self, face: &Face, chart: &Chart, size: u32) -> PageMesh {
        let texels = face.corners.iter().map(|p| chart.texel(*p));
        PageMesh {
            name: self.scene.objects[face.object].name.clone(),
            positions: face.corners.iter().map(|p| p.as_vec3().into()).collect(),
            normals: vec![face.normal.as_vec3().into(); face.corners.len()],
            lightmap_uvs: texels
                .map(|t| (t / f64::from(size)).as_vec2().into())
                .collect(),
            indices: (1..face.corners.len() as u32 - 1)
                .flat_map(|k| [0, k, k + 1])
                .collect(),
            material: face.material as u32,
            ..PageMesh::default()
        }
    }

    fn materials(&self) -> Vec<PageMaterial> {
        let of = |m: &azulejo_scene::Material| PageMaterial {
            emission: m.emission.to_array().map(|x| x as f32),
            double_sided: false,
            ..PageMaterial::matt(m.name.clone(), m.diffuse.to_array().map(|x| x as f32))
        };
        self.scene.materials.iter().map(of).collect()
    }

    /// The nearest face whose front a ray meets, and its distance in lengths of the direction.
    pub fn hit(&self, ray: &Ray) -> Option<(&Face, f64)> {
        let hits = self.faces.iter().filter_map(|face| {
            let towards = -ray.direction.dot(face.normal);
            let distance = (ray.origin - face.corners[0]).dot(face.normal) / towards;
            let is_met = towards > 0.0 && distance > 1e-9 && face.holds(ray.at(distance));
            is_met.then_some((face, distance))
        });
        hits.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Radiance along a ray, or `None` if it leaves.
    pub fn radiance(&self, ray: &Ray, light: Light) -> Option<[f64; 3]> {
        let (face, distance) = self.hit(ray)?;
        let (e, _) = light(self, ray.at(distance), face.normal);
        let material = &self.scene.materials[face.material];
        let (reflectance, emission) = (material.diffuse.to_array(), material.emission.to_array());
        let channel =
            |c: usize| reflectance[c] * f64::from(e[c]) / std::f64::consts::PI + emission[c];
        Some([channel(0), channel(1), channel(2)])
    }
}

impl Face {
    /// Whether a place of its plane is inside.
    pub fn holds(&self, place: DVec3) -> bool {
        let count = self.corners.len();
        (0..count).all(|k| {
            let (a, b) = (self.corners[k], self.corners[(k + 1) % count]);
            (b - a).cross(place - a).dot(self.normal) >= 0.0
        })
    }

    /// Distance to the nearest edge of a place inside.
    pub fn margin(&self, place: DVec3) -> f64 {
        let count = self.corners.len();
        let distance = |k: usize| {
            let (a, b) = (self.corners[k], self.corners[(k + 1) % count]);
            (b - a).normalize().cross(place - a).length()
        };
        (0..count).map(distance).fold(f64::INFINITY, f64::min)
    }
}

/// The triangles of a face, whose corners need not lie in one plane: those of the left wall do not.
fn triangles(object: usize, mesh: &Mesh, k: usize) -> Vec<Face> {
    let corners = mesh.face_positions(k);
    let triangle = |j: usize| {
        let corners = vec![corners[0], corners[j], corners[j + 1]];
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        Face {
            object,
            corners,
            material: mesh.face_materials[k] as usize,
            normal: normal.normalize(),
        }
    };
    (1..corners.len() - 1).map(triangle).collect()
}

/// A face laid out flat in a cell of the lightmap.
struct Chart {
    /// The place in the world of the cell's padded corner, and the steps of one texel.
    origin: DVec3,
    across: DVec3,
    down: DVec3,
    corner: DVec2,
}

impl Chart {
    fn new(face: &Face, corner: [u32; 2], cell: u32) -> Chart {
        let first = face.corners[0];
        let across = (face.corners[1] - first).normalize();
        let down = face.normal.cross(across);
        let flat = |p: &DVec3| DVec2::new((*p - first).dot(across), (*p - first).dot(down));
        let low = face.corners.iter().map(flat).reduce(DVec2::min).unwrap();
        let high = face.corners.iter().map(flat).reduce(DVec2::max).unwrap();
        let texel = (high - low).max_element() / (f64::from(cell) - 2.0 * PADDING);
        Chart {
            origin: first + low.x * across + low.y * down,
            across: across * texel,
            down: down * texel,
            corner: DVec2::new(f64::from(corner[0]), f64::from(corner[1])) + PADDING,
        }
    }

    fn world(&self, texel: DVec2) -> DVec3 {
        let steps = texel - self.corner;
        self.origin + steps.x * self.across + steps.y * self.down
    }

    fn texel(&self, place: DVec3) -> DVec2 {
        let from = place - self.origin;
        let steps = DVec2::new(
            from.dot(self.across) / self.across.length_squared(),
            from.dot(self.down) / self.down.length_squared(),
        );
        self.corner + steps
    }
}

/// Light of a small lamp below the ceiling, warm, and a little light from everywhere, bluish. Smooth but
/// where faces turn away from the lamp.
pub fn lamp_light(_: &Room, place: DVec3, normal: DVec3) -> ([f32; 3], [f32; 3]) {
    let to_lamp = DVec3::new(278.0, 480.0, 279.5) - place;
    let cosine = to_lamp.normalize().dot(normal).max(0.0);
    let direct = 1.2e6 * cosine / to_lamp.length_squared().max(1e3);
    let height = place.y / 548.8;
    let value = [
        direct + 0.4 + 0.3 * height,
        0.7 * direct + 0.45,
        0.35 * direct + 0.6 - 0.2 * height,
    ];
    let error = value.map(|x| (x * (0.01 + 0.03 * height)) as f32);
    (value.map(|x| x as f32), error)
}
