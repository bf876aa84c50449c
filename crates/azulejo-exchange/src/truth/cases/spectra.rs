//! Shares of black emission, surfaces in two bands, and the sun.

use super::super::enclosures::{GreyEnclosure, duct, heat, nested, nodes, parts_of_sphere};
use super::super::expected::{SIGMA, crater_shadow, plates, sunlit_plate};
use super::super::known_factors;
use super::super::planck::{bisect, planck_between, planck_fraction};
use super::*;
use crate::thermal::bands::{SpectralRange, band_fraction};
use crate::thermal::network::{HeatProblem, heat_balance};
use azulejo_trace::Progress;

/// The sun at the distance of the Earth, W/m².
const SUN: f64 = 1361.0;

/// The cases of this module.
pub fn cases() -> Vec<ExchangeCase> {
    [
        fractions(),
        windows(),
        plates_in_bands(),
        triangle_in_bands(),
        sunlit_plates(),
        craters(),
    ]
    .concat()
}

const QUADRATURE: &str = "Planck's law, c2 = 14387.76877 µm K, by quadrature over ln(lambda T)";

fn fractions() -> Vec<ExchangeCase> {
    let rows = [
        ("band_1000", 1000.0),
        ("band_2897", 2_897.771_955),
        ("band_5000", 5000.0),
        ("band_20000", 20_000.0),
        ("band_60000", 60_000.0),
    ];
    let case = |(id, product): (&'static str, f64)| {
        let description = format!("black body: share of emission below λT = {product} µm·K");
        let truth = planck_fraction(product);
        let answer = move || Ok(band_fraction(product / 300.0, 300.0));
        case(
            id,
            description,
            QUADRATURE,
            ExchangeQuantity::BandFraction,
            truth,
            answer,
        )
    };
    rows.into_iter().map(case).collect()
}

/// Bands of instruments.
fn windows() -> Vec<ExchangeCase> {
    let case = |id, low: f64, high: f64, t: f64| {
        let description = format!("black body of {t} K: share of emission from {low} to {high} µm");
        let truth = planck_between(low * t, high * t);
        let answer = move || Ok(SpectralRange::Between(low, high).share(t));
        case(
            id,
            description,
            QUADRATURE,
            ExchangeQuantity::BandFraction,
            truth,
            answer,
        )
    };
    vec![
        case("band_8_14_at_300K", 8.0, 14.0, 300.0),
        case("band_visible_at_5772K", 0.38, 0.78, 5772.0),
    ]
}

/// Emissivities of both plates below and above 4 µm.
const BELOW: [f64; 2] = [0.9, 0.2];
const ABOVE: [f64; 2] = [0.1, 0.8];
const EDGE: f64 = 4.0;

/// Black emission below and above the edge, W/m².
fn emission(temperature: f64) -> [f64; 2] {
    let below = planck_fraction(EDGE * temperature);
    [below, 1.0 - below].map(|share| share * SIGMA * temperature.powi(4))
}

/// Temperatures and fluxes in two bands by the solver.
fn in_two_bands(
    enclosure: &GreyEnclosure,
    [below, above]: [&[f64]; 2],
    conditions: &[RowCondition],
) -> Result<crate::thermal::network::HeatBalance, ExchangeError> {
    let bands = [
        enclosure.band(SpectralRange::Between(0.0, EDGE), Some(below)),
        enclosure.band(SpectralRange::Between(EDGE, f64::INFINITY), Some(above)),
    ];
    heat(&bands, conditions, &[])
}

fn plates_in_bands() -> Vec<ExchangeCase> {
    let flux = |t1: f64, t2: f64| {
        let ([a1, b1], [a2, b2]) = (emission(t1), emission(t2));
        plates(BELOW[0], BELOW[1]) * (a1 - a2) + plates(ABOVE[0], ABOVE[1]) * (b1 - b2)
    };
    let text = "infinite parallel plates, e 0.9 and 0.2 below 4 µm, 0.1 and 0.8 above";
    let ask = |given: [RowCondition; 2]| {
        let plates = nested([1.0; 2], &GreyPaint::matt(&[0.5; 2]));
        in_two_bands(&plates, [&BELOW, &ABOVE], &given)
    };
    // The hotter the second plate, the less it takes up.
    let second = bisect(10.0, 1500.0, |t| 20_000.0 - flux(1500.0, t));
    vec![
        case(
            "band2_plates_q",
            format!("{text}, 1500 and 300 K: q of 1"),
            "sum over bands of GR s (f(T1) T1^4 - f(T2) T2^4)",
            ExchangeQuantity::Flux,
            flux(1500.0, 300.0),
            move || Ok(ask([at(1500.0), at(300.0)])?.fluxes[0]),
        ),
        case(
            "band2_plates_T2",
            format!("{text}, 1 at 1500 K, 2 takes up 20 kW/m²: T of 2"),
            "the same, by bisection",
            ExchangeQuantity::Temperature,
            second,
            move || Ok(ask([at(1500.0), giving(-20_000.0)])?.temperatures[1]),
        ),
    ]
}

/// An adiabatic side whose emissivity changes with the wavelength: between those of its neighbours.
fn triangle_in_bands() -> Vec<ExchangeCase> {
    let (below, above) = ([0.9, 0.6, 0.8], [0.3, 0.7, 0.1]);
    let books =
        [below, above].map(|e| known_factors::triangle([3.0, 4.0, 5.0], &GreyPaint::matt(&e)));
    let given = [1200.0, 400.0];
    let heat_of_third = |t: f64| {
        let mut heat = 0.0;
        for (j, other) in given.into_iter().enumerate() {
            let (own, other) = (emission(t), emission(other));
            for (band, book) in books.iter().enumerate() {
                heat += book.conductance(2, j) * (own[band] - other[band]);
            }
        }
        heat
    };
    let truth = bisect(400.0, 1200.0, heat_of_third);
    let answer = move || {
        let corners = [[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]];
        let triangle = duct(&corners, &GreyPaint::matt(&[0.5; 3]));
        let conditions = [at(given[0]), at(given[1]), giving(0.0)];
        Ok(in_two_bands(&triangle, [&below, &above], &conditions)?.temperatures[2])
    };
    vec![case(
        "band2_tri_T3",
        "long duct, a triangle of sides 3, 4, 5, e 0.9, 0.6, 0.8 below 4 µm, 0.3, 0.7, 0.1 above, 1200 and \
         400 K, 3 adiabatic: T of 3",
        "sum over bands of GR s (f(T3) T3^4 - f(Tj) Tj^4) = 0, Gebhart 1961 for GR, by bisection",
        ExchangeQuantity::Temperature,
        truth,
        answer,
    )]
}

/// A plate of emissivity e that absorbs the share a of the sun's light.
fn sunlit_plates() -> Vec<ExchangeCase> {
    let case = |id, a: f64, e: f64, sky: f64| {
        let answer = move || {
            let plate = GreyEnclosure::new(&[1.0], &GreyPaint::matt(&[e]), |_, _| 0.0);
            let problem = HeatProblem {
                bands: &[plate.grey(), plate.band(SpectralRange::Solar, Some(&[a]))],
                conditions: &[giving(0.0)],
                surroundings: [sky, 0.0],
                solar: &[SUN],
            };
            let balance = heat_balance(&problem, &nodes(1), &Progress::new())?;
            Ok(balance.temperatures[0])
        };
        let text = format!(
            "plate under the sun of 1361 W/m², absorptance {a}, e {e}, back adiabatic, sky of {sky} K: T"
        );
        let source = "a S + e s Tsky^4 = e s T^4";
        let truth = sunlit_plate(a, e, SUN, sky);
        case(
            id,
            text,
            source,
            ExchangeQuantity::Temperature,
            truth,
            answer,
        )
    };
    vec![
        case("solar_plate_T", 0.2, 0.8, 0.0),
        case("solar_absorber_T", 0.95, 0.05, 0.0),
        case("solar_roof_T", 0.3, 0.9, 255.0),
    ]
}

/// Shadow in craters, parts of spheres.
fn craters() -> Vec<ExchangeCase> {
    let case = |id, share: f64, albedo: f64, e: f64, degrees: f64| {
        let sun = SUN * degrees.to_radians().sin();
        let text = format!(
            "crater, {share} of a sphere, albedo {albedo}, e {e}, the sun's 1361 W/m² {degrees}° above the \
             rim, half of it lit: T in shadow"
        );
        case(
            id,
            text,
            "Ingersoll, Svitek and Murray 1992",
            ExchangeQuantity::Temperature,
            crater_shadow(share, albedo, e, sun),
            move || in_shadow(share, albedo, e, sun),
        )
    };
    vec![
        case("ingersoll_T", 0.2, 0.12, 0.95, 10.0),
        case("ingersoll_deep_T", 0.5, 0.3, 0.9, 30.0),
        case("ingersoll_flat_T", 0.05, 0.08, 0.98, 2.0),
    ]
}

/// Two halves, one lit, `share` of a sphere of area 1; `sun` is that of the plane of the rim.
fn in_shadow(share: f64, albedo: f64, emissivity: f64, sun: f64) -> Result<f64, ExchangeError> {
    let halves = [0.5 * share; 2];
    let crater = parts_of_sphere(&halves, &GreyPaint::matt(&[emissivity; 2]));
    let solar = [1.0 - albedo; 2];
    let bands = [
        crater.grey(),
        crater.band(SpectralRange::Solar, Some(&solar)),
    ];
    // The rim's disk, share (1 − share) of the sphere, catches the light; all of it falls on one half.
    let lit = sun * (1.0 - share) / 0.5;
    let balance = heat(&bands, &[giving(0.0); 2], &[lit, 0.0])?;
    Ok(balance.temperatures[1])
}
