//! Irradiance by brute force: a path tracer as one writes it in an afternoon. Shares no code with azulejo
//! except the scene's data: its own triangles, bounding volumes and random numbers, in one thread.
//!
//! At each point of a path one point of the lamps is sampled by area, and each sun by a shadow ray; a path
//! that leaves the scene sees the sky. Directions are cosine-distributed; after three bounces paths end by
//! Russian roulette.

use azulejo_scene::{LightKind, Material, Rgb, Scene, Shape};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Bounces of a path that are certain.
const BOUNCES: u32 = 3;

/// Triangles of a leaf that is not divided.
const LEAF: usize = 3;

/// Intervals between which a box may be divided, along each axis.
const BINS: usize = 16;

/// Boxes that wait on the way through the tree, at most.
const DEPTH: usize = 128;

/// Distance of rays from the surface that they leave, over the scene's size.
const OFFSET: f64 = 1e-6;

/// A scene of diffuse triangles, lit by lamps, suns and a uniform sky.
pub struct PathTracer {
    triangles: Vec<Triangle>,
    nodes: Vec<Node>,
    /// Triangles that emit, each with the area of all up to it.
    lamps: Vec<(usize, f64)>,
    suns: Vec<Sun>,
    /// Radiance, W/(sr·m²).
    sky: Rgb,
    offset: f64,
}

/// A point of a surface, and the side from which it is lit.
#[derive(Clone, Copy)]
pub struct Point {
    /// Where it is.
    pub position: DVec3,
    /// Unit vector.
    pub normal: DVec3,
}

/// Mean of the paths at a point.
pub struct Estimate {
    /// Irradiance, W/m².
    pub value: Rgb,
    /// Square of its standard error.
    pub variance: Rgb,
}

struct Sun {
    toward: DVec3,
    irradiance: Rgb,
}

struct Triangle {
    corner: DVec3,
    edges: [DVec3; 2],
    normal: DVec3,
    diffuse: Rgb,
    emission: Rgb,
    emits_back: bool,
}

impl PathTracer {
    /// The triangles of a scene, with the lights of another file.
    ///
    /// # Panics
    /// If there is more than diffuse meshes, lamps, sharp suns and a uniform sky.
    pub fn new(scene: &Scene, lights: &Scene) -> PathTracer {
        let mut triangles = triangles(scene);
        let mut nodes = Vec::new();
        divide(&mut triangles, 0, &mut nodes);
        let mut area = 0.0;
        let lit = (0..triangles.len()).filter(|&i| !triangles[i].emission.is_black());
        let lamp = |i: usize| {
            area += triangles[i].area();
            (i, area)
        };
        let lamps = lit.map(lamp).collect();
        let size = nodes[0].bounds.high - nodes[0].bounds.low;
        let (mut suns, mut sky) = (Vec::new(), Rgb::BLACK);
        for light in &lights.lights {
            match light.kind {
                LightKind::Ambient { radiance } => sky += radiance,
                LightKind::Directional {
                    direction,
                    irradiance,
                    half_angle: 0.0,
                } => suns.push(Sun {
                    toward: -direction,
                    irradiance,
                }),
                _ => panic!("brute force knows sharp suns and uniform skies only"),
            }
        }
        PathTracer {
            triangles,
            nodes,
            lamps,
            suns,
            sky,
            offset: OFFSET * size.length(),
        }
    }

    /// Points spread evenly over the fronts of what is not a lamp, in proportion to area.
    pub fn points(&self, count: usize, seed: u64) -> Vec<Point> {
        let mut area = 0.0;
        let dark = self.triangles.iter().filter(|t| t.emission.is_black());
        let areas: Vec<(&Triangle, f64)> = dark
            .map(|triangle| {
                area += triangle.area();
                (triangle, area)
            })
            .collect();
        let mut random = Random::new(seed, 0);
        let point = |i: usize| {
            let place = (i as f64 + random.next()) / count as f64 * area;
            let chosen = areas.partition_point(|a| a.1 <= place).min(areas.len() - 1);
            Point {
                position: areas[chosen].0.sample(&mut random),
                normal: areas[chosen].0.normal,
            }
        };
        (0..count).map(point).collect()
    }

    /// Irradiance at a point by this many paths; the random numbers depend on `seed` and `key`.
    pub fn irradiance(&self, point: &Point, paths: u32, seed: u64, key: u64) -> Estimate {
        let mut random = Random::new(seed, key);
        let (mut sum, mut squares) = (Rgb::BLACK, Rgb::BLACK);
        for _ in 0..paths {
            let value = self.path(*point, &mut random);
            sum += value;
            squares += value * value;
        }
        let count = f64::from(paths);
        let value = sum / count;
        Estimate {
            value,
            variance: (squares / count - value * value) / (count - 1.0),
        }
    }

    /// Irradiance of one path.
    fn path(&self, mut point: Point, random: &mut Random) -> Rgb {
        let (mut sum, mut weight) = (Rgb::BLACK, Rgb::WHITE);
        for bounce in 1.. {
            sum += weight * (self.lamplight(&point, random) + self.sunlight(&point));
            let direction = random.cosine(point.normal);
            let origin = point.position + self.offset * point.normal;
            let Some((index, distance)) = self.hit::<false>(origin, direction, f64::INFINITY)
            else {
                return sum + weight * self.sky * PI;
            };
            let triangle = &self.triangles[index];
            weight *= triangle.diffuse;
            let survival = match bounce {
                ..=BOUNCES => 1.0,
                _ => weight.max_channel().min(1.0),
            };
            if weight.is_black() || random.next() >= survival {
                break;
            }
            weight = weight / survival;
            point = Point {
                position: origin + distance * direction,
                normal: -triangle.normal.dot(direction).signum() * triangle.normal,
            };
        }
        sum
    }

    /// Irradiance from one point of the lamps.
    fn lamplight(&self, point: &Point, random: &mut Random) -> Rgb {
        let Some(&(_, area)) = self.lamps.last() else {
            return Rgb::BLACK;
        };
        let place = random.next() * area;
        let chosen = self.lamps.partition_point(|l| l.1 <= place);
        let lamp = &self.triangles[self.lamps[chosen.min(self.lamps.len() - 1)].0];
        let origin = point.position + self.offset * point.normal;
        let way = lamp.sample(random) - origin;
        let (here, there) = (way.dot(point.normal), -way.dot(lamp.normal));
        let there = if lamp.emits_back { there.abs() } else { there };
        if here <= 0.0 || there <= 0.0 || self.hit::<true>(origin, way, 1.0 - OFFSET).is_some() {
            return Rgb::BLACK;
        }
        lamp.emission * (here * there * area / way.length_squared().powi(2))
    }

    /// Irradiance from the suns.
    fn sunlight(&self, point: &Point) -> Rgb {
        let mut sum = Rgb::BLACK;
        let origin = point.position + self.offset * point.normal;
        for sun in &self.suns {
            let cosine = point.normal.dot(sun.toward);
            if cosine > 0.0
                && self
                    .hit::<true>(origin, sun.toward, f64::INFINITY)
                    .is_none()
            {
                sum += sun.irradiance * cosine;
            }
        }
        sum
    }

    /// The nearest triangle before `far`, or any, and how many times the direction it is away.
    fn hit<const ANY: bool>(
        &self,
        origin: DVec3,
        direction: DVec3,
        mut far: f64,
    ) -> Option<(usize, f64)> {
        let inverse = direction.recip();
        let mut nearest = None;
        let mut waiting = [0; DEPTH];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let index = waiting[count];
            let node = &self.nodes[index];
            if !node.bounds.is_met(origin, inverse, far) {
                continue;
            }
            if node.count == 0 {
                let children = [node.start, index + 1];
                let is_forward = direction[node.axis] >= 0.0;
                waiting[count] = children[usize::from(!is_forward)];
                waiting[count + 1] = children[usize::from(is_forward)];
                count += 2;
                continue;
            }
            for i in node.start..node.start + node.count {
                let distance = self.triangles[i].distance(origin, direction);
                let Some(distance) = distance.filter(|&d| d < far) else {
                    continue;
                };
                (far, nearest) = (distance, Some((i, distance)));
                if ANY {
                    return nearest;
                }
            }
        }
        nearest
    }
}

/// The triangles of a scene.
fn triangles(scene: &Scene) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for object in &scene.objects {
        let Shape::Mesh(mesh) = &object.shape else {
            panic!("brute force knows meshes only")
        };
        for face in 0..mesh.faces.len() {
            let material = &scene.materials[mesh.face_materials[face] as usize];
            assert!(is_diffuse(material), "{} is not diffuse", material.name);
            let corners = mesh.face_positions(face);
            for ijk in mesh.triangulate(face) {
                let [a, b, c] = ijk.map(|k| corners[k as usize]);
                triangles.extend(Triangle::new([a, b, c], material));
            }
        }
    }
    triangles
}

fn is_diffuse(material: &Material) -> bool {
    material.mirror.is_black()
        && material.dielectric.is_none()
        && material.opacity.is_none()
        && material.brdf.is_none()
        && material.textures.is_empty()
        && material.emission_picture.is_none()
}

impl Triangle {
    /// `None` without area.
    fn new([a, b, c]: [DVec3; 3], material: &Material) -> Option<Triangle> {
        Some(Triangle {
            corner: a,
            edges: [b - a, c - a],
            normal: (b - a).cross(c - a).try_normalize()?,
            diffuse: material.diffuse,
            emission: material.emission,
            emits_back: material.emits_back,
        })
    }

    fn area(&self) -> f64 {
        0.5 * self.edges[0].cross(self.edges[1]).length()
    }

    /// A random point, evenly by area.
    fn sample(&self, random: &mut Random) -> DVec3 {
        let (u, v) = (random.next().sqrt(), random.next());
        self.corner + u * (1.0 - v) * self.edges[0] + u * v * self.edges[1]
    }

    /// Where a ray meets it. Möller and Trumbore, *Fast, minimum storage ray–triangle intersection*, 1997.
    fn distance(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let p = direction.cross(self.edges[1]);
        let inverse = 1.0 / p.dot(self.edges[0]);
        let s = origin - self.corner;
        let u = s.dot(p) * inverse;
        if !(0.0..=1.0).contains(&u) {
            return None;
        }
        let q = s.cross(self.edges[0]);
        let v = direction.dot(q) * inverse;
        let distance = self.edges[1].dot(q) * inverse;
        (v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some(distance)
    }

    fn bounds(&self) -> Bounds {
        let [b, c] = self.edges.map(|edge| self.corner + edge);
        Bounds {
            low: self.corner.min(b).min(c),
            high: self.corner.max(b).max(c),
        }
    }
}

#[derive(Clone, Copy)]
struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    const EMPTY: Bounds = Bounds {
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
    };

    fn union(self, other: Bounds) -> Bounds {
        Bounds {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    fn centre(&self) -> DVec3 {
        0.5 * (self.low + self.high)
    }

    /// Half the area of the surface.
    fn area(&self) -> f64 {
        let size = (self.high - self.low).max(DVec3::ZERO);
        size.x * size.y + size.y * size.z + size.z * size.x
    }

    fn is_met(&self, origin: DVec3, inverse: DVec3, far: f64) -> bool {
        let (a, b) = (
            (self.low - origin) * inverse,
            (self.high - origin) * inverse,
        );
        a.min(b).max_element().max(0.0) <= a.max(b).min_element().min(far)
    }
}

/// A box of the tree: a leaf, or one with two children, the first of which follows it.
struct Node {
    bounds: Bounds,
    /// The first triangle, or the second child.
    start: usize,
    /// Triangles of a leaf; 0 with children.
    count: usize,
    /// Along which the children lie.
    axis: usize,
}

/// Adds the tree of triangles, which it reorders; `start` is the number of the first.
fn divide(triangles: &mut [Triangle], start: usize, nodes: &mut Vec<Node>) {
    let index = nodes.len();
    let bounds = triangles.iter().map(Triangle::bounds);
    nodes.push(Node {
        bounds: bounds.fold(Bounds::EMPTY, Bounds::union),
        start,
        count: triangles.len(),
        axis: 0,
    });
    if triangles.len() <= LEAF {
        return;
    }
    let Some(plane) = Plane::best(triangles) else {
        return;
    };
    triangles.sort_unstable_by_key(|t| plane.is_beyond(t));
    let half = triangles.partition_point(|t| !plane.is_beyond(t));
    let (near, beyond) = triangles.split_at_mut(half);
    divide(near, start, nodes);
    nodes[index].start = nodes.len();
    nodes[index].count = 0;
    nodes[index].axis = plane.axis;
    divide(beyond, start + half, nodes);
}

/// Divides triangles by their centres.
struct Plane {
    axis: usize,
    /// The first centre and the number of intervals per length.
    low: f64,
    scale: f64,
    /// The first interval beyond.
    interval: usize,
}

impl Plane {
    /// The plane with the smallest expected cost: boxes count by their area. `None` if all centres are the
    /// same.
    ///
    /// Wald, *On fast construction of SAH-based bounding volume hierarchies*, 2007.
    fn best(triangles: &[Triangle]) -> Option<Plane> {
        let centres = triangles.iter().map(|t| t.bounds().centre());
        let centres = centres.map(|c| Bounds { low: c, high: c });
        let range = centres.fold(Bounds::EMPTY, Bounds::union);
        let planes = (0..3).filter(|&axis| range.high[axis] > range.low[axis]);
        let planes = planes.map(|axis| Plane {
            axis,
            low: range.low[axis],
            scale: BINS as f64 / (range.high[axis] - range.low[axis]),
            interval: 0,
        });
        let best = planes.map(|plane| plane.placed(triangles));
        best.min_by(|a, b| a.1.total_cmp(&b.1)).map(|best| best.0)
    }

    fn interval(&self, triangle: &Triangle) -> usize {
        let along = triangle.bounds().centre()[self.axis] - self.low;
        ((along * self.scale) as usize).min(BINS - 1)
    }

    fn is_beyond(&self, triangle: &Triangle) -> bool {
        self.interval(triangle) >= self.interval
    }

    /// The best along this axis, and its cost.
    fn placed(mut self, triangles: &[Triangle]) -> (Plane, f64) {
        let mut bins = [(Bounds::EMPTY, 0); BINS];
        for triangle in triangles {
            let (bounds, count) = &mut bins[self.interval(triangle)];
            *bounds = bounds.union(triangle.bounds());
            *count += 1;
        }
        let cost = |bins: &[(Bounds, usize)]| {
            let bounds = bins.iter().fold(Bounds::EMPTY, |b, bin| b.union(bin.0));
            bounds.area() * bins.iter().map(|bin| bin.1).sum::<usize>() as f64
        };
        let costs = (1..BINS).map(|k| (k, cost(&bins[..k]) + cost(&bins[k..])));
        let best = costs.min_by(|a, b| a.1.total_cmp(&b.1));
        let (interval, cost) = best.expect("several intervals");
        self.interval = interval;
        (self, cost)
    }
}

/// xorshift64*: Vigna, *An experimental exploration of Marsaglia's xorshift generators*, 2016.
struct Random(u64);

impl Random {
    /// Starts from the finalizer of SplitMix64, so that keys next to each other give unrelated sequences.
    fn new(seed: u64, key: u64) -> Random {
        let mut state = (key << 8 | seed).wrapping_add(1);
        state = state.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        state = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state = (state ^ state >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        Random((state ^ state >> 31) | 1)
    }

    /// The next number in 0..1.
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A cosine-distributed direction: the normal plus a point of the unit sphere.
    fn cosine(&mut self, normal: DVec3) -> DVec3 {
        let z = 1.0 - 2.0 * self.next();
        let (sin, cos) = (TAU * self.next()).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        (normal + DVec3::new(r * cos, r * sin, z)).normalize_or(normal)
    }
}
