//! Points, such as vertices, as sites of a gather.
//!
//! Nodes behind a wall or around a corner say nothing of a point: between both the way is free. How far others may be
//! is measured: a node that is left out tells how well those around it do.

use crate::records::RecordCells;
use crate::sites::{SiteCells, plane_weights, smooth};
use azulejo_scene::math::Frame;
use azulejo_trace::interaction::shadow_ray;
use azulejo_trace::run::batches::in_batches;
use azulejo_trace::{Cancelled, GatherPoint, KernelRay, Run, Tracer};
use glam::dvec2;
use rstar::RTree;
use rstar::primitives::GeomWithData;

/// Points for each of the first cells, and fewest of these.
const POINTS_PER_CELL: usize = 32;
const LEAST_CELLS: usize = 1000;

/// Fewer nodes do not determine a plane well.
const FEWEST: usize = 4;

/// Nodes that are looked at for each that is wanted, the nearest first.
const CANDIDATES: usize = 2;

/// Least cosine of the angle between the normals of a point and its nodes.
const MOST_BENT: f64 = 0.85;

/// How far the way between a point and a node is lifted off the surface, as a share of its length.
const LIFT: f64 = 0.02;

/// Cells that are worked on together.
const BATCH: usize = 64;

/// No node.
const NONE: u32 = u32::MAX;

/// Points in the cells of octrees, whose records are their nodes.
#[derive(Clone)]
pub(crate) struct PointCells<'a> {
    tracer: &'a Tracer,
    points: &'a [GatherPoint],
    /// Empty if all count alike.
    areas: &'a [f64],
    cells: RecordCells,
    records: Vec<u32>,
    /// The point of each node, and the node of each point.
    nodes: Vec<u32>,
    node_of: Vec<u32>,
}

impl<'a> PointCells<'a> {
    /// As many cells as do for a first look. `areas` is what the points stand for, or empty.
    pub fn new(
        tracer: &'a Tracer,
        points: &'a [GatherPoint],
        areas: &'a [f64],
        seed: u32,
    ) -> PointCells<'a> {
        let count = (points.len() / POINTS_PER_CELL).max(LEAST_CELLS);
        let mut cells = PointCells {
            tracer,
            points,
            areas,
            cells: RecordCells::new(points, seed, count),
            records: Vec::new(),
            nodes: Vec::new(),
            node_of: vec![NONE; points.len()],
        };
        cells.number_nodes();
        cells
    }

    /// Gives numbers to new nodes.
    fn number_nodes(&mut self) {
        self.records = self.cells.records().collect();
        for &point in &self.records {
            let node = &mut self.node_of[point as usize];
            if *node == NONE {
                *node = self.nodes.len() as u32;
                self.nodes.push(point);
            }
        }
    }

    /// Whether a point faces as another does, about.
    fn faces(&self, a: u32, b: u32) -> bool {
        let [a, b] = [a, b].map(|point| self.points[point as usize].normal);
        a.dot(b) >= MOST_BENT
    }

    /// Which nodes, given by their points, face as a point does and can be reached from it.
    fn reached(&self, from: u32, nodes: &[u32]) -> Vec<bool> {
        let point = &self.points[from as usize];
        let mut is_reached = Vec::with_capacity(nodes.len());
        let mut rays = Vec::with_capacity(nodes.len());
        for &node in nodes {
            let other = &self.points[node as usize];
            let is_apart = other.position != point.position;
            let faces = self.faces(from, node);
            is_reached.push(faces);
            if faces && is_apart {
                rays.push(self.way(point, other));
            }
        }
        let mut blocked = Vec::new();
        self.tracer.any(&rays, &mut blocked);
        let mut blocked = blocked.into_iter();
        for (is_reached, &node) in is_reached.iter_mut().zip(nodes) {
            let other = &self.points[node as usize];
            if *is_reached && other.position != point.position {
                *is_reached = blocked.next() == Some(false);
            }
        }
        is_reached
    }

    /// The way from a point to another, lifted over what bends between them.
    fn way(&self, point: &GatherPoint, other: &GatherPoint) -> KernelRay {
        let distance = point.position.distance(other.position);
        let angle = (point.normal - other.normal).length();
        let lift = distance * (LIFT + 0.25 * angle);
        let end = |p: &GatherPoint| self.tracer.leaving(p.position, p.normal) + lift * p.normal;
        shadow_ray(self.tracer, end(point), end(other))
    }
}

impl SiteCells for PointCells<'_> {
    /// Number of the point.
    type Place = u32;

    fn site_count(&self) -> usize {
        self.points.len()
    }

    fn point(&self, site: u32) -> GatherPoint {
        self.points[site as usize]
    }

    fn area(&self, site: u32) -> f64 {
        self.areas.get(site as usize).copied().unwrap_or(1.0)
    }

    fn place(&self, site: u32) -> u32 {
        site
    }

    fn distance(&self, a: u32, b: u32) -> f64 {
        let [a, b] = [a, b].map(|site| self.points[site as usize].position);
        a.distance(b)
    }

    fn weights(&self, at: u32, nodes: &[u32], found: &mut Vec<f64>) -> bool {
        if nodes.len() < FEWEST {
            return false;
        }
        let is_reached = self.reached(at, nodes);
        if is_reached.iter().filter(|reached| **reached).count() < FEWEST {
            return false;
        }
        let point = &self.points[at as usize];
        let frame = Frame::from_normal(point.normal);
        let way = |(&node, _): (&u32, &bool)| {
            let way = self.points[node as usize].position - point.position;
            dvec2(way.dot(frame.x), way.dot(frame.y))
        };
        let used = nodes
            .iter()
            .zip(&is_reached)
            .filter(|(_, reached)| **reached);
        plane_weights(used.map(way), smooth, found);
        let mut weights = std::mem::take(found).into_iter();
        let of_node = |reached: &bool| if *reached { weights.next() } else { None };
        found.extend(
            is_reached
                .iter()
                .map(of_node)
                .map(Option::unwrap_or_default),
        );
        true
    }

    fn len(&self) -> usize {
        self.cells.count()
    }

    fn sites(&self, cell: usize) -> &[u32] {
        self.cells.points_of(cell)
    }

    fn node(&self, cell: usize) -> u32 {
        self.node_of[self.records[cell] as usize]
    }

    fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    fn divide(&mut self, is_divided: &[bool]) {
        self.cells.divide(is_divided);
        self.number_nodes();
    }

    fn isolate(&mut self, sites: &[u32]) {
        let mut is_lonely = vec![false; self.points.len()];
        sites
            .iter()
            .for_each(|&site| is_lonely[site as usize] = true);
        self.cells.isolate(&is_lonely);
        self.number_nodes();
    }

    fn nodes_around(&self, count: usize, run: Run) -> Result<Vec<Vec<u32>>, Cancelled> {
        let place = |(node, &site): (u32, &u32)| {
            let position = self.points[site as usize].position;
            GeomWithData::new(position.to_array(), node)
        };
        let tree = RTree::bulk_load((0..).zip(&self.nodes).map(place).collect());
        let of_record = |&record: &u32| -> Vec<u32> {
            let point = &self.points[record as usize];
            let own = self.node_of[record as usize];
            // Others than its own, by distance and number.
            let mut near: Vec<(f64, u32)> = tree
                .nearest_neighbor_iter_with_distance_2(&point.position.to_array())
                .filter(|(node, _)| node.data != own)
                .take(CANDIDATES * count)
                .map(|(node, square)| (square, node.data))
                .collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let sites: Vec<u32> = near.iter().map(|n| self.nodes[n.1 as usize]).collect();
            let reached = self.reached(record, &sites).into_iter();
            let others = near.iter().zip(reached).filter(|(_, reached)| *reached);
            std::iter::once(own)
                .chain(others.map(|(n, _)| n.1).take(count))
                .collect()
        };
        in_batches(&self.records, BATCH, run, |batch| {
            Ok(batch.iter().map(of_record).collect())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{Material, Object, Primitive, Rgb, Scene, Shape};
    use azulejo_trace::Progress;
    use glam::{DVec3, dvec3};

    /// A grid of points on a floor, 20 to a side.
    fn floor() -> Vec<GatherPoint> {
        let point = |k: u32| GatherPoint {
            position: dvec3(f64::from(k % 20), 0.0, f64::from(k / 20)),
            normal: DVec3::Y,
            key: k,
        };
        (0..400).map(point).collect()
    }

    /// A sheet across the floor between x = 9 and 10.
    fn wall() -> Scene {
        let mut scene = Scene::default();
        let material = scene.add_material(Material::diffuse("wall", Rgb::grey(0.5)));
        let corner = dvec3(9.5, -1.0, -1.0);
        let sheet = Primitive::parallelogram(corner, 21.0 * DVec3::Z, 9.0 * DVec3::Y, material);
        let object = Object::new("wall", Shape::Primitive(sheet));
        scene.objects.push(object);
        scene
    }

    #[test]
    fn planes_are_reproduced() {
        let (tracer, points) = (Tracer::new(&Scene::default()), floor());
        let cells = PointCells::new(&tracer, &points, &[], 0);
        let value = |i: u32| {
            let p = points[i as usize].position;
            3.0 + 0.5 * p.x - 0.25 * p.z
        };
        let nodes = [84, 87, 103, 124, 127, 163];
        let mut found = Vec::new();
        for at in [105, 106, 125, 145] {
            assert!(cells.weights(at, &nodes, &mut found));
            let sum: f64 = found.iter().sum();
            let given: f64 = nodes.iter().zip(&found).map(|(&n, w)| w * value(n)).sum();
            // The ridge moves gradients toward zero by a thousandth.
            assert!((sum - 1.0).abs() < 1e-9, "{sum}");
            assert!((given - value(at)).abs() < 5e-3, "{given} at {at}");
        }
    }

    #[test]
    fn nodes_beyond_a_wall_say_nothing() {
        let (tracer, points) = (Tracer::new(&wall()), floor());
        let cells = PointCells::new(&tracer, &points, &[], 0);
        let progress = Progress::new();
        let around = cells.nodes_around(48, Run::alone(&progress)).unwrap();
        let is_left = |point: u32| points[point as usize].position.x < 9.5;
        for (cell, nodes) in around.iter().enumerate() {
            let own = cells.nodes()[cells.node(cell) as usize];
            assert_eq!(nodes[0], cells.node(cell));
            let mut sites = nodes.iter().map(|&n| cells.nodes()[n as usize]);
            assert!(sites.all(|site| is_left(site) == is_left(own)));
        }
        // Four nodes on this side, and two beyond.
        let mut found = Vec::new();
        assert!(cells.weights(28, &[26, 27, 48, 68, 30, 31], &mut found));
        assert!(
            found[..4].iter().all(|w| *w != 0.0) && found[4..] == [0.0; 2],
            "{found:?}"
        );
        assert!(!cells.weights(28, &[26, 27, 48, 30, 31, 32], &mut found));
    }
}
