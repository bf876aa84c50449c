//! Regions of the plane bounded by closed loops, cut along the lines of a grid.

use super::surface::Refused;
use crate::reading::options::Budget;
use earcut::Earcut;
use glam::DVec2;

/// Closed polygons. A point is inside if an odd number of them surrounds it, whatever their orientation.
pub(super) type Loops = Vec<Vec<DVec2>>;

/// Cuts a region into the cells of a grid, and every piece into counter-clockwise convex
/// polygons. Neighbouring pieces have the same points on their common line.
pub(super) fn cells(
    loops: Loops,
    us: &[f64],
    vs: &[f64],
    budget: &mut Budget,
) -> Result<Vec<Vec<DVec2>>, Refused> {
    let mut polygons = Vec::new();
    for column in slices(loops, 0, us, budget)? {
        for cell in slices(column, 1, vs, budget)? {
            polygons.extend(triangles(cell, budget)?);
        }
    }
    Ok(polygons)
}

/// The parts of a region between neighbouring lines; what lies outside the first and the last
/// is dropped.
fn slices(
    loops: Loops,
    axis: usize,
    lines: &[f64],
    budget: &mut Budget,
) -> Result<Vec<Loops>, Refused> {
    let (Some(&first), Some(&last)) = (lines.first(), lines.last()) else {
        return Ok(Vec::new());
    };
    let inside = split(split(loops, axis, first).1, axis, last).0;
    let mut slices = Vec::new();
    // Halving keeps work and depth logarithmic in the number of lines.
    let mut waiting = vec![(inside, lines)];
    while let Some((part, lines)) = waiting.pop() {
        let points: usize = part.iter().map(Vec::len).sum();
        budget.spend(points as u64 + 1)?;
        if part.is_empty() {
            continue;
        }
        if lines.len() <= 2 {
            slices.push(part);
            continue;
        }
        let middle = lines.len() / 2;
        let (low, high) = split(part, axis, lines[middle]);
        waiting.push((high, &lines[middle..]));
        waiting.push((low, &lines[..=middle]));
    }
    Ok(slices)
}

/// A piece of a loop on one side of a line, from the crossing where it enters to the one where it
/// leaves.
struct Chain {
    ends: [usize; 2],
    points: Vec<DVec2>,
}

/// Splits loops at coordinate `at` of an axis into what lies below it, and what lies on it or above.
///
/// Along the line, inside and outside alternate at the crossings: between the first and the
/// second, the third and the fourth... the cut closes the loops. This also holds for loops that
/// touch or cross each other.
fn split(loops: Loops, axis: usize, at: f64) -> (Loops, Loops) {
    let mut whole = [Loops::new(), Loops::new()];
    let mut chains = [Vec::new(), Vec::new()];
    let mut crossings: Vec<DVec2> = Vec::new();
    for points in loops {
        let side = |p: DVec2| usize::from(p[axis] >= at);
        let next = |i: usize| points[(i + 1) % points.len()];
        let crosses = |i: &usize| side(points[*i]) != side(next(*i));
        // A loop that does not cross the line lies on one side of it as a whole.
        let Some(start) = (0..points.len()).find(crosses) else {
            whole[side(points[0])].push(points);
            continue;
        };
        // Follow the loop from its first crossing; each crossing ends a chain and begins one on the other side.
        let first = crossings.len();
        let mut open: Option<(usize, Chain)> = None;
        for k in 0..points.len() {
            let i = (start + k) % points.len();
            if let Some((_, chain)) = &mut open {
                chain.points.push(points[i]);
            }
            if crosses(&i) {
                let (id, point) = (crossings.len(), crossing(points[i], next(i), axis, at));
                crossings.push(point);
                if let Some((side, mut chain)) = open.take() {
                    chain.points.push(point);
                    chain.ends[1] = id;
                    chains[side].push(chain);
                }
                let chain = Chain {
                    ends: [id, id],
                    points: vec![point],
                };
                open = Some((side(next(i)), chain));
            }
        }
        // The last chain runs through the start of the loop to the first crossing.
        if let Some((side, mut chain)) = open {
            chain.points.push(points[start]);
            chain.points.push(crossings[first]);
            chain.ends[1] = first;
            chains[side].push(chain);
        }
    }
    // Close the chains of each side along the line.
    let partners = partners(&crossings, 1 - axis);
    let [low, high] = chains.map(|chains| joined(chains, &partners));
    let [mut below, mut above] = whole;
    below.extend(low);
    above.extend(high);
    (below, above)
}

/// The intersection of the edge from `p` to `q` with the line.
fn crossing(p: DVec2, q: DVec2, axis: usize, at: f64) -> DVec2 {
    let share = (at - p[axis]) / (q[axis] - p[axis]);
    let mut point = p + share * (q - p);
    point[axis] = at;
    point
}

/// For each crossing, the one that the cut connects it with.
fn partners(crossings: &[DVec2], axis: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..crossings.len()).collect();
    order.sort_by(|&a, &b| crossings[a][axis].total_cmp(&crossings[b][axis]));
    let mut partners = vec![0; order.len()];
    for pair in order.chunks_exact(2) {
        (partners[pair[0]], partners[pair[1]]) = (pair[1], pair[0]);
    }
    partners
}

/// The chains of one side, joined along the cut to closed loops.
fn joined(chains: Vec<Chain>, partners: &[usize]) -> Loops {
    let mut at_crossing = vec![(0, 0); partners.len()];
    for (k, chain) in chains.iter().enumerate() {
        for end in 0..2 {
            at_crossing[chain.ends[end]] = (k, end);
        }
    }
    let mut used = vec![false; chains.len()];
    let mut loops = Loops::new();
    for start in 0..chains.len() {
        let (mut k, mut entered) = (start, 0);
        let mut points: Vec<DVec2> = Vec::new();
        while !std::mem::replace(&mut used[k], true) {
            let chain = &chains[k];
            match entered {
                0 => points.extend(&chain.points),
                _ => points.extend(chain.points.iter().rev()),
            }
            (k, entered) = at_crossing[partners[chain.ends[1 - entered]]];
        }
        points.dedup();
        if points.first() == points.last() {
            points.pop();
        }
        if points.len() >= 3 && has_extent(&points) {
            loops.push(points);
        }
    }
    loops
}

/// Whether points lie neither all on one line of the grid nor all on one line across it.
fn has_extent(points: &[DVec2]) -> bool {
    let first = points[0];
    points.iter().any(|p| p.x != first.x) && points.iter().any(|p| p.y != first.y)
}

/// Twice the signed area.
fn area(points: &[DVec2]) -> f64 {
    let origin = points[0];
    let pairs = points.windows(2).skip(1);
    pairs.map(|w| (w[0] - origin).perp_dot(w[1] - origin)).sum()
}

/// The convex polygons of a cell: the cell itself if it is whole, otherwise triangles.
fn triangles(loops: Loops, budget: &mut Budget) -> Result<Vec<Vec<DVec2>>, Refused> {
    if !loops.iter().flatten().all(|p| p.is_finite()) {
        return Err("a trimming curve with points that are not finite".into());
    }
    if let [only] = loops.as_slice()
        && let Some(convex) = convex(only)
    {
        return Ok(vec![convex]);
    }
    let points: u64 = loops.iter().map(|l| l.len() as u64).sum();
    // Assigning holes to outlines and cutting ears may test every pair.
    budget.spend(points * loops.len() as u64 + points * points / 16)?;
    let mut polygons = Vec::new();
    for rings in with_holes(loops) {
        let starts: Vec<u32> = rings[..rings.len() - 1]
            .iter()
            .scan(0, |end, ring| {
                *end += ring.len() as u32;
                Some(*end)
            })
            .collect();
        let points = rings.concat();
        let mut corners: Vec<u32> = Vec::new();
        let flat = points.iter().map(|p| p.to_array());
        Earcut::new().earcut(flat, &starts, &mut corners);
        for triangle in corners.chunks_exact(3) {
            let mut triangle: Vec<DVec2> = triangle.iter().map(|&k| points[k as usize]).collect();
            if area(&triangle) < 0.0 {
                triangle.swap(1, 2);
            }
            polygons.push(triangle);
        }
    }
    Ok(polygons)
}

/// A convex triangle or quadrilateral, counter-clockwise.
fn convex(points: &[DVec2]) -> Option<Vec<DVec2>> {
    let mut points = points.to_vec();
    let n = points.len();
    if area(&points) < 0.0 {
        points.reverse();
    }
    let at = |i: usize| points[i % n];
    let turns_left = |i: usize| (at(i + 1) - at(i)).perp_dot(at(i + 2) - at(i + 1)) > 0.0;
    (n <= 4 && (0..n).all(turns_left)).then_some(points)
}

/// Every outline, followed by its holes.
fn with_holes(mut loops: Loops) -> Vec<Loops> {
    // A loop is smaller than the loop that surrounds it.
    loops.sort_by(|a, b| area(b).abs().total_cmp(&area(a).abs()));
    let mut outlines: Vec<Loops> = Vec::new();
    // The number of the outline that each loop is; `None` for holes.
    let mut outline_indices: Vec<Option<usize>> = Vec::new();
    for (k, points) in loops.iter().enumerate() {
        let around: Vec<usize> = (0..k).filter(|&j| surrounds(&loops[j], points)).collect();
        let outline = match around.last() {
            Some(&nearest) if around.len() % 2 == 1 => outline_indices[nearest],
            _ => None,
        };
        match outline {
            Some(outline) => {
                outlines[outline].push(points.clone());
                outline_indices.push(None);
            }
            None => {
                outline_indices.push(Some(outlines.len()));
                outlines.push(vec![points.clone()]);
            }
        }
    }
    outlines
}

/// Whether one loop lies in another, by the midpoint of its first edge.
fn surrounds(outer: &[DVec2], inner: &[DVec2]) -> bool {
    let p = inner[0].midpoint(inner[1]);
    let mut previous = outer[outer.len() - 1];
    let mut inside = false;
    for &q in outer {
        if (previous.y > p.y) != (q.y > p.y)
            && p.x < previous.x + (p.y - previous.y) / (q.y - previous.y) * (q.x - previous.x)
        {
            inside = !inside;
        }
        previous = q;
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ReadOptions;
    use proptest::prelude::*;

    fn rectangle(a: (f64, f64), b: (f64, f64)) -> Vec<DVec2> {
        [(a.0, a.1), (b.0, a.1), (b.0, b.1), (a.0, b.1)]
            .map(DVec2::from)
            .to_vec()
    }

    fn polygons(loops: Loops, lines: &[f64]) -> Vec<Vec<DVec2>> {
        let mut budget = Budget::new(&ReadOptions::default());
        let polygons = cells(loops, lines, lines, &mut budget).unwrap();
        assert!(polygons.iter().all(|p| area(p) >= 0.0));
        polygons
    }

    fn check(loops: Loops, expected: f64) {
        for pieces in [1, 2, 3, 7] {
            let lines: Vec<f64> = (0..=pieces)
                .map(|k| f64::from(k) / f64::from(pieces))
                .collect();
            let polygons = polygons(loops.clone(), &lines);
            let sum: f64 = polygons.iter().map(|p| area(p) / 2.0).sum();
            assert!(
                (sum - expected).abs() < 1e-12,
                "{sum} of {expected}, {pieces}"
            );
            for polygon in &polygons {
                // Every piece stays in one cell.
                let cell =
                    |p: DVec2, toward: DVec2| (p.lerp(toward, 0.01) * f64::from(pieces)).floor();
                let middle = polygon.iter().sum::<DVec2>() / polygon.len() as f64;
                assert!(
                    polygon
                        .iter()
                        .all(|&p| cell(p, middle) == cell(middle, middle))
                );
            }
        }
    }

    #[test]
    fn whole_cells_stay_whole() {
        let all = polygons(
            vec![rectangle((0.0, 0.0), (1.0, 1.0))],
            &[0.0, 0.25, 0.5, 1.0],
        );
        assert_eq!(all.len(), 9);
        assert!(all.iter().all(|p| p.len() == 4));
    }

    #[test]
    fn areas() {
        let unit = rectangle((0.0, 0.0), (1.0, 1.0));
        let hole = rectangle((0.25, 0.4), (0.75, 0.6));
        let island = rectangle((0.3, 0.45), (0.4, 0.55));
        check(vec![unit.clone()], 1.0);
        check(vec![rectangle((-3.0, -2.0), (2.0, 3.0))], 1.0);
        check(vec![unit.clone(), hole.clone()], 0.9);
        check(vec![hole.clone(), unit.clone(), island], 0.91);
        let mut backwards = hole.clone();
        backwards.reverse();
        check(vec![unit.clone(), backwards], 0.9);
        check(vec![hole], 0.1);
        // Half a cell, with an edge along a line of the grid.
        check(vec![rectangle((0.0, 0.0), (0.5, 1.0))], 0.5);
        let triangle = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(DVec2::from);
        check(vec![triangle.to_vec()], 0.5);
        check(vec![unit, triangle.to_vec()], 0.5);
        check(vec![rectangle((2.0, 2.0), (3.0, 3.0))], 0.0);
        let bow = [(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)].map(DVec2::from);
        let polygons = polygons(vec![bow.to_vec()], &[0.0, 0.5, 1.0]);
        let sum: f64 = polygons.iter().map(|p| area(p) / 2.0).sum();
        assert!((sum - 0.5).abs() < 1e-12, "{sum}");
    }

    proptest! {
        /// Cutting keeps the area, and neighbours share all points of their common edges.
        #[test]
        fn stars(radii in prop::collection::vec(0.05..0.45f64, 3..40)) {
            let n = radii.len() as f64;
            let point = |(k, r): (usize, &f64)| {
                0.5 + *r * DVec2::from_angle(k as f64 / n * std::f64::consts::TAU)
            };
            let star: Vec<DVec2> = radii.iter().enumerate().map(point).collect();
            let expected = area(&star) / 2.0;
            let polygons = polygons(vec![star], &[0.0, 0.3, 0.5, 0.6, 1.0]);
            let sum: f64 = polygons.iter().map(|p| area(p) / 2.0).sum();
            prop_assert!((sum - expected).abs() < 1e-9, "{} of {}", sum, expected);
        }
    }
}
