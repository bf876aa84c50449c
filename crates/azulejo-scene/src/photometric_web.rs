//! The intensity of a luminaire in many directions, as photometric files give it.

use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::OnceLock;

/// How two angles say a direction (IES LM-63, CIE 121). A luminaire aims at −z of its own frame, with +y up and +x to the
/// right for one who stands behind it and looks along the aim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WebType {
    /// The horizontal angle is an azimuth about y, from the aim to the right, the vertical one an elevation toward y.
    A,
    /// The vertical angle turns about x, from the aim toward y, and the horizontal one is the angle from there toward x.
    B,
    /// The vertical angle is that from the aim, the horizontal one that about it: from +x toward +y.
    C,
}

/// Intensities on a grid of two angles, bilinear between them and 0 beyond.
///
/// Where the grid has a part of the horizontal angles the others mirror it: of type C a quarter, a half (0 to 180, 90 to
/// 270 or 180 to 360 degrees) or one plane for all, of types A and B one half.
#[derive(Clone, Debug)]
pub struct PhotometricWeb {
    kind: WebType,
    /// Vertical and horizontal angles, as they were given.
    degrees: [Vec<f64>; 2],
    /// Radians, ascending.
    vertical: Vec<f64>,
    /// Radians, ascending.
    horizontal: Vec<f64>,
    /// All vertical angles for the first horizontal one, then for the next.
    values: Vec<f64>,
    most: f64,
    sphere_integral: f64,
    /// Made when it is first asked for: some thousand evaluations, which those who read the file alone do not need.
    cells: OnceLock<WebCells>,
}

/// The light of a web by cells of the sphere.
#[derive(Clone, Debug)]
struct WebCells {
    mean_direction: DVec3,
    /// See [`PhotometricWeb::sample`].
    cumulative: Vec<f64>,
}

impl PartialEq for PhotometricWeb {
    fn eq(&self, other: &PhotometricWeb) -> bool {
        // All else follows from these.
        self.kind == other.kind && self.degrees == other.degrees && self.values == other.values
    }
}

/// Cells of the sphere from which directions are drawn: rows from the aim, columns about it.
const ROWS: usize = 180;
const COLUMNS: usize = 72;

/// Share of the largest intensity that every cell has at least, as a grid may have light between the places that are
/// looked at.
const LEAST: f64 = 1e-4;

impl PhotometricWeb {
    /// A web of angles in degrees and intensities of any unit: all vertical angles for the first horizontal one, then for
    /// the next.
    ///
    /// # Errors
    /// In words: angles that do not rise or are out of range, another number of intensities, and intensities that are
    /// negative or not finite.
    pub fn new(
        kind: WebType,
        [vertical, horizontal]: [&[f64]; 2],
        values: Vec<f64>,
    ) -> Result<PhotometricWeb, String> {
        let low = if kind == WebType::C { 0.0 } else { -180.0 };
        // The plane that was added after a turn is read back, too.
        let ranges = [
            ("vertical", vertical, low, 180.0),
            ("horizontal", horizontal, low, 720.0),
        ];
        for (name, angles, low, high) in ranges {
            let is_inside = angles.iter().all(|a| (low..=high).contains(a));
            if angles.is_empty() || !is_inside || !angles.is_sorted() {
                return Err(format!(
                    "{name} angles that decrease or are not within {low} to {high}"
                ));
            }
        }
        if values.len() != vertical.len() * horizontal.len() {
            let counts = [values.len(), vertical.len(), horizontal.len()];
            let [values, rows, columns] = counts;
            return Err(format!(
                "{values} intensities for {rows} × {columns} angles"
            ));
        }
        if let Some(wrong) = values.iter().find(|v| !(**v >= 0.0 && v.is_finite())) {
            return Err(format!("an intensity of {wrong}"));
        }
        let radians = |angles: &[f64]| angles.iter().map(|a| a.to_radians()).collect::<Vec<_>>();
        let mut web = PhotometricWeb {
            kind,
            degrees: [vertical.to_vec(), horizontal.to_vec()],
            vertical: radians(vertical),
            horizontal: radians(horizontal),
            most: values.iter().copied().fold(0.0, f64::max),
            values,
            sphere_integral: 0.0,
            cells: OnceLock::new(),
        };
        if kind == WebType::C {
            web.go_round();
        }
        web.sphere_integral = web.integral();
        if !web.sphere_integral.is_finite() {
            return Err("intensities that overflow".to_owned());
        }
        Ok(web)
    }

    /// Repeats the first plane after a turn, where planes go nearly all around and none is there.
    fn go_round(&mut self) {
        let (first, last) = self.sector();
        if last - first > PI + 1e-6 && last < first + TAU - 1e-6 && !self.is_half_about_y() {
            self.horizontal.push(first + TAU);
            let first = self.degrees[1][0];
            self.degrees[1].push(first + 360.0);
            self.values.extend_from_within(..self.vertical.len());
        }
    }

    /// First and last horizontal angle.
    fn sector(&self) -> (f64, f64) {
        (
            self.horizontal[0],
            self.horizontal[self.horizontal.len() - 1],
        )
    }

    /// Whether planes from 90 to 270 degrees are given, which the others mirror.
    fn is_half_about_y(&self) -> bool {
        let (first, last) = self.sector();
        (first - FRAC_PI_2).abs() < 1e-6 && (last - 1.5 * PI).abs() < 1e-6
    }

    /// How its angles say directions.
    pub fn kind(&self) -> WebType {
        self.kind
    }

    /// Vertical and horizontal angles, degrees.
    pub fn angles(&self) -> [&[f64]; 2] {
        let [vertical, horizontal] = &self.degrees;
        [vertical, horizontal]
    }

    /// The intensities, all vertical angles for the first horizontal one, then for the next.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The largest intensity.
    pub fn most(&self) -> f64 {
        self.most
    }

    /// The integral of the intensity over the sphere, exactly that of the interpolated grid: of candelas, the luminous flux
    /// in lumens.
    pub fn sphere_integral(&self) -> f64 {
        self.sphere_integral
    }

    /// Intensity in a unit direction of the luminaire's frame. Along the axis of type C, where planes may differ, it is the
    /// mean of all.
    pub fn toward(&self, w: DVec3) -> f64 {
        if self.kind == WebType::C && w.x.hypot(w.y) < 1e-12 {
            let v = if w.z < 0.0 { 0.0 } else { PI };
            let of_planes: Vec<f64> = self.horizontal.iter().map(|&h| self.at(v, h)).collect();
            return self.mean_of_planes(&of_planes);
        }
        let (v, h) = match self.kind {
            WebType::A => (w.y.clamp(-1.0, 1.0).asin(), w.x.atan2(-w.z)),
            WebType::B => (w.y.atan2(-w.z), w.x.clamp(-1.0, 1.0).asin()),
            WebType::C => (
                // Exact near the aim, where the cosine of the angle is not.
                w.x.hypot(w.y).atan2(-w.z),
                w.y.atan2(w.x).rem_euclid(TAU),
            ),
        };
        self.at(v, h)
    }

    /// Intensity at two angles, radians.
    fn at(&self, v: f64, h: f64) -> f64 {
        let (v, h) = match self.kind {
            WebType::C => (v, self.folded(h)),
            WebType::A | WebType::B => {
                let half = |list: &[f64], x: f64| if list[0] >= 0.0 { x.abs() } else { x };
                (half(&self.vertical, v), half(&self.horizontal, h))
            }
        };
        let places = (place(&self.vertical, v), place(&self.horizontal, h));
        let (Some((i, f)), Some((j, g))) = places else {
            return 0.0;
        };
        let n = self.vertical.len();
        let row = |j: usize| {
            let next = self.values[j * n + (i + 1).min(n - 1)];
            (1.0 - f) * self.values[j * n + i] + f * next
        };
        (1.0 - g) * row(j) + g * row((j + 1).min(self.horizontal.len() - 1))
    }

    /// An angle about the aim, 0..2π, as one of those that the planes are given for.
    fn folded(&self, h: f64) -> f64 {
        let (first, last) = self.sector();
        if self.is_half_about_y() {
            return match h {
                h if h < FRAC_PI_2 => PI - h,
                h if h > 1.5 * PI => 3.0 * PI - h,
                h => h,
            };
        }
        let half = if h > PI { TAU - h } else { h };
        if first > PI - 1e-6 {
            return (TAU - half).clamp(first, last);
        }
        let quarter = if half > FRAC_PI_2 { PI - half } else { half };
        match last - first {
            span if span > PI + 1e-6 => {
                // Planes may begin anywhere.
                if h < first { h + TAU } else { h }
            }
            _ if last > FRAC_PI_2 + 1e-6 => half.clamp(first, last),
            _ => quarter.clamp(first, last),
        }
    }

    /// The closed form of the integral of the bilinear intensity over the sphere.
    fn integral(&self) -> f64 {
        let n = self.vertical.len();
        let column = |j: usize| &self.values[j * n..][..n];
        let columns = 0..self.horizontal.len();
        let mirrored = |list: &[f64]| if list[0] >= 0.0 { 2.0 } else { 1.0 };
        match self.kind {
            WebType::C => {
                let of_planes: Vec<f64> = columns
                    .map(|j| weighted(&self.vertical, column(j), Weight::Sine))
                    .collect();
                TAU * self.mean_of_planes(&of_planes)
            }
            WebType::A | WebType::B => {
                let copies = mirrored(&self.vertical) * mirrored(&self.horizontal);
                let [inner, outer] = match self.kind {
                    WebType::A => [Weight::Cosine, Weight::One],
                    _ => [Weight::One, Weight::Cosine],
                };
                let of_columns: Vec<f64> = columns
                    .map(|j| weighted(&self.vertical, column(j), inner))
                    .collect();
                copies * weighted(&self.horizontal, &of_columns, outer)
            }
        }
    }

    /// The mean over all horizontal angles of what the planes have, which by symmetry is that over the given ones.
    fn mean_of_planes(&self, of_planes: &[f64]) -> f64 {
        let (first, last) = self.sector();
        match last - first {
            0.0 => of_planes[0],
            span => weighted(&self.horizontal, of_planes, Weight::One) / span,
        }
    }

    /// Intensities in places of the cells, row by row: their middles for 0.5, their first corners for 0.
    fn over_cells(&self, within: f64, [rows, columns]: [usize; 2]) -> Vec<f64> {
        let places = (0..rows).flat_map(|row| (0..columns).map(move |column| [row, column]));
        let at = |[row, column]: [usize; 2]| {
            self.toward(direction(row as f64 + within, column as f64 + within))
        };
        places.map(at).collect()
    }

    fn cells(&self) -> &WebCells {
        self.cells.get_or_init(|| {
            let middles = self.over_cells(0.5, [ROWS, COLUMNS]);
            WebCells {
                cumulative: self.cumulative(&middles),
                mean_direction: self.mean_of_directions(&middles),
            }
        })
    }

    /// Cumulative weights of the cells: about the integral of the intensity over each.
    fn cumulative(&self, middles: &[f64]) -> Vec<f64> {
        let corners = self.over_cells(0.0, [ROWS + 1, COLUMNS + 1]);
        let mut sum = 0.0;
        let cumulative = middles.iter().enumerate().map(|(cell, middle)| {
            let (row, column) = (cell / COLUMNS, cell % COLUMNS);
            let at = |u: usize, v: usize| corners[(row + u) * (COLUMNS + 1) + column + v];
            let corners = at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1);
            let mean = (2.0 * middle + corners / 2.0) / 4.0;
            sum += (mean + LEAST * self.most) * cell_size(row);
            sum
        });
        cumulative.collect()
    }

    /// A unit direction for two numbers in 0..1, about in proportion to the intensity, with its probability density, 1/sr;
    /// `None` if there is no light.
    pub fn sample(&self, [u, v]: [f64; 2]) -> Option<(DVec3, f64)> {
        let cumulative = &self.cells().cumulative;
        let total = *cumulative.last()?;
        if total <= 0.0 {
            return None;
        }
        let target = u * total;
        let cell = cumulative.partition_point(|&c| c <= target);
        let cell = cell.min(cumulative.len() - 1);
        let before = if cell > 0 { cumulative[cell - 1] } else { 0.0 };
        let weight = cumulative[cell] - before;
        let (row, column) = (cell / COLUMNS, cell % COLUMNS);
        // The rest of the first number is even within the cell.
        let within = ((target - before) / weight).clamp(0.0, 1.0);
        let [top, bottom] = [row, row + 1].map(|r| (PI * r as f64 / ROWS as f64).cos());
        let cos = top + v * (bottom - top);
        let from_aim = cos.clamp(-1.0, 1.0).acos() / PI * ROWS as f64;
        let w = direction(from_aim, column as f64 + within);
        Some((w, weight / (total * cell_size(row))))
    }

    /// The mean direction of the light, of the luminaire's frame: the nearer to a unit vector, the narrower the beam; 0
    /// without light.
    pub fn mean_direction(&self) -> DVec3 {
        self.cells().mean_direction
    }

    fn mean_of_directions(&self, middles: &[f64]) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for (cell, middle) in middles.iter().enumerate() {
            let (row, column) = (cell / COLUMNS, cell % COLUMNS);
            let w = direction(row as f64 + 0.5, column as f64 + 0.5);
            sum += middle * cell_size(row) * w;
        }
        match self.sphere_integral {
            0.0 => DVec3::ZERO,
            integral => sum / integral,
        }
    }
}

/// The direction at a place of the cells.
fn direction(row: f64, column: f64) -> DVec3 {
    let (sin, cos) = (PI * row / ROWS as f64).sin_cos();
    let (y, x) = (TAU * column / COLUMNS as f64).sin_cos();
    DVec3::new(sin * x, sin * y, -cos)
}

/// Solid angle of a cell of a row, sr.
fn cell_size(row: usize) -> f64 {
    let [top, bottom] = [row, row + 1].map(|r| (PI * r as f64 / ROWS as f64).cos());
    (top - bottom) * TAU / COLUMNS as f64
}

#[derive(Clone, Copy)]
enum Weight {
    One,
    Sine,
    Cosine,
}

/// The integral of what is linear between values at angles, times the weight.
fn weighted(angles: &[f64], values: &[f64], weight: Weight) -> f64 {
    let pieces = angles.windows(2).zip(values.windows(2));
    let piece = |(angles, values): (&[f64], &[f64])| {
        let ([a, b], [x, y]) = ([angles[0], angles[1]], [values[0], values[1]]);
        if b <= a {
            return 0.0;
        }
        // By parts.
        let slope = (y - x) / (b - a);
        match weight {
            Weight::One => (b - a) * (x + y) / 2.0,
            Weight::Sine => x * a.cos() - y * b.cos() + slope * (b.sin() - a.sin()),
            Weight::Cosine => y * b.sin() - x * a.sin() + slope * (b.cos() - a.cos()),
        }
    };
    pieces.map(piece).sum()
}

/// The position of a value in a non-decreasing list: the index before it and the fraction of the way to the next; `None`
/// outside. A list of one value holds everywhere.
fn place(list: &[f64], value: f64) -> Option<(usize, f64)> {
    let (first, last) = (*list.first()?, *list.last()?);
    if list.len() == 1 {
        return Some((0, 0.0));
    }
    // Degrees in radians are rounded, and so are the angles of directions.
    let value = match value {
        x if x < first && first - x < 1e-9 => first,
        x if x > last && x - last < 1e-9 => last,
        x => x,
    };
    if !(first..=last).contains(&value) {
        return None;
    }
    let behind = list.partition_point(|&x| x <= value);
    let behind = behind.clamp(1, list.len() - 1);
    let width = list[behind] - list[behind - 1];
    let share = if width > 0.0 {
        (value - list[behind - 1]) / width
    } else {
        0.0
    };
    Some((behind - 1, share))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn web(kind: WebType, vertical: &[f64], horizontal: &[f64], values: &[f64]) -> PhotometricWeb {
        PhotometricWeb::new(kind, [vertical, horizontal], values.to_vec()).unwrap()
    }

    #[test]
    fn light_the_same_everywhere() {
        for horizontal in [
            &[0.0][..],
            &[0.0, 90.0],
            &[0.0, 180.0],
            &[90.0, 270.0],
            &[0.0, 120.0, 240.0],
            &[0.0, 90.0, 180.0, 270.0, 360.0],
        ] {
            let even = web(
                WebType::C,
                &[0.0, 180.0],
                horizontal,
                &vec![2.0; 2 * horizontal.len()],
            );
            let error = even.sphere_integral() - 8.0 * PI;
            assert!(error.abs() < 1e-12, "{horizontal:?}: {error}");
            assert!(even.mean_direction().length() < 1e-12);
            for w in [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::new(-0.6, 0.0, 0.8)] {
                assert!((even.toward(w) - 2.0).abs() < 1e-12, "{horizontal:?} {w}");
            }
        }
        for kind in [WebType::A, WebType::B] {
            let (wide, narrow) = ([-180.0, 180.0], [-90.0, 90.0]);
            let [vertical, horizontal] = match kind {
                WebType::A => [narrow, wide],
                _ => [wide, narrow],
            };
            let even = web(kind, &vertical, &horizontal, &[1.0; 4]);
            assert!(
                (even.sphere_integral() - 4.0 * PI).abs() < 1e-12,
                "{kind:?}"
            );
        }
    }

    /// A cosine, by one-degree steps: the exact integral of the interpolated one is a bit less than π.
    #[test]
    fn integrals_are_those_of_the_interpolated_grid() {
        let angles: Vec<f64> = (0..=90).map(f64::from).collect();
        let values: Vec<f64> = angles.iter().map(|a| a.to_radians().cos()).collect();
        let lambert = web(WebType::C, &angles, &[0.0], &values);
        let error = lambert.sphere_integral() / PI - 1.0;
        assert!((-4e-5..0.0).contains(&error), "{error}");
        // ∫ cos² θ dω / ∫ cos θ dω over the half sphere.
        let mean = lambert.mean_direction();
        assert!((mean - 2.0 / 3.0 * DVec3::NEG_Z).length() < 1e-3, "{mean}");
    }

    #[test]
    fn sectors_mirror_each_other() {
        // Intensities by their horizontal angle, along directions in the plane across the aim.
        let planar = |horizontal: &[f64], values: &[f64], degrees: f64| {
            let doubled: Vec<f64> = values.iter().flat_map(|v| [*v, *v]).collect();
            let web = web(WebType::C, &[0.0, 180.0], horizontal, &doubled);
            let (y, x) = degrees.to_radians().sin_cos();
            web.toward(DVec3::new(x, y, 0.0))
        };
        let check = |horizontal: &[f64], values: &[f64], degrees: f64, expected: f64| {
            let found = planar(horizontal, values, degrees);
            assert!(
                (found - expected).abs() < 1e-9,
                "{horizontal:?} {degrees}: {found}"
            );
        };
        let quarter = (&[0.0, 90.0][..], &[1.0, 3.0][..]);
        for degrees in [45.0, 135.0, 225.0, 315.0] {
            check(quarter.0, quarter.1, degrees, 2.0);
        }
        let half = (&[0.0, 90.0, 180.0][..], &[1.0, 2.0, 5.0][..]);
        check(half.0, half.1, 270.0, 2.0);
        check(half.0, half.1, 225.0, 3.5);
        let other_half = (&[90.0, 180.0, 270.0][..], &[1.0, 2.0, 5.0][..]);
        check(other_half.0, other_half.1, 0.0, 2.0);
        check(other_half.0, other_half.1, 315.0, 3.5);
        check(other_half.0, other_half.1, 45.0, 1.5);
        let all_but_the_last = (&[0.0, 120.0, 240.0][..], &[1.0, 2.0, 5.0][..]);
        check(all_but_the_last.0, all_but_the_last.1, 300.0, 3.0);
        // Along the axis no plane is meant.
        let axis = web(
            WebType::C,
            &[0.0, 90.0],
            &[0.0, 90.0, 180.0],
            &[4.0, 0.0, 2.0, 0.0, 0.0, 0.0],
        );
        assert_eq!(axis.toward(DVec3::NEG_Z), 2.0);
    }

    #[test]
    fn floodlights_have_their_own_angles() {
        // Brighter to the right and up of the aim.
        let horizontal = [-90.0, 0.0, 90.0];
        let vertical = [-90.0, 0.0, 90.0];
        let values = [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 0.0, 4.0, 0.0];
        for kind in [WebType::A, WebType::B] {
            let flood = web(kind, &vertical, &horizontal, &values);
            for (w, expected) in [(DVec3::NEG_Z, 1.0), (DVec3::Y, 2.0), (DVec3::X, 4.0)] {
                let pole =
                    (kind == WebType::A && w == DVec3::Y) || (kind == WebType::B && w == DVec3::X);
                let found = flood.toward(w);
                assert!(
                    pole || (found - expected).abs() < 1e-9,
                    "{kind:?} {w}: {found}"
                );
            }
            assert_eq!(flood.toward(DVec3::Z), 0.0);
        }
        // Half of the angles: the other half mirrors it.
        let half = web(WebType::B, &[0.0, 10.0], &[0.0, 10.0], &[100.0; 4]);
        let side = 20f64.to_radians();
        let expected = 100.0 * side * 2.0 * 10f64.to_radians().sin();
        assert!((half.sphere_integral() / expected - 1.0).abs() < 1e-12);
        let w = |x: f64, y: f64| DVec3::new(x, y, -1.0).normalize();
        assert_eq!(
            [half.toward(w(-0.1, -0.1)), half.toward(w(-0.3, 0.0))],
            [100.0, 0.0]
        );
    }

    #[test]
    fn what_is_wrong_is_said() {
        let check = |angles: [&[f64]; 2], values: &[f64], expected: &str| {
            let error = PhotometricWeb::new(WebType::C, angles, values.to_vec()).unwrap_err();
            assert!(error.contains(expected), "{error}");
        };
        check([&[], &[0.0]], &[], "vertical angles");
        check([&[90.0, 0.0], &[0.0]], &[1.0, 1.0], "vertical angles");
        check([&[0.0, 90.0], &[-1.0]], &[1.0, 1.0], "horizontal angles");
        check([&[0.0, f64::NAN], &[0.0]], &[1.0, 1.0], "vertical angles");
        check([&[0.0, 90.0], &[0.0]], &[1.0], "1 intensities for 2 × 1");
        check([&[0.0, 90.0], &[0.0]], &[1.0, -2.0], "intensity of -2");
        check([&[0.0, 90.0], &[0.0]], &[f64::MAX, f64::MAX], "overflow");
    }

    fn any_web() -> impl Strategy<Value = PhotometricWeb> {
        let kinds = prop_oneof![Just(WebType::A), Just(WebType::B), Just(WebType::C)];
        let values = proptest::collection::vec(0.0..10.0f64, 12);
        (kinds, 0..4usize, values).prop_map(|(kind, sector, values)| {
            let vertical = match kind {
                WebType::C => [0.0, 20.0, 50.0, 170.0],
                _ => [-60.0, 0.0, 20.0, 80.0],
            };
            let horizontal = match (kind, sector) {
                (WebType::C, 0) => [0.0, 20.0, 90.0],
                (WebType::C, 1) => [0.0, 70.0, 180.0],
                (WebType::C, 2) => [90.0, 100.0, 270.0],
                (WebType::C, _) => [0.0, 180.0, 360.0],
                (_, 0 | 1) => [0.0, 20.0, 70.0],
                _ => [-50.0, 20.0, 70.0],
            };
            web(kind, &vertical, &horizontal, &values)
        })
    }

    proptest! {
        /// The closed form is what sampling finds, and densities are those of the samples.
        #[test]
        fn samples_have_the_integral(web in any_web()) {
            // The first number chooses the cell, of which there are thousands.
            let count = 1 << 15;
            let mut sum = 0.0;
            for k in 0..count {
                let u = (f64::from(k) + 0.5) / f64::from(count);
                let v = (f64::from(k) * 0.618_033_988_75).fract();
                let (w, density) = web.sample([u, v]).unwrap();
                prop_assert!((w.length() - 1.0).abs() < 1e-9);
                sum += web.toward(w) / density;
            }
            let found = sum / f64::from(count);
            prop_assert!((found / web.sphere_integral() - 1.0).abs() < 0.01, "{found} {}", web.sphere_integral());
        }
    }
}
