//! The enclosures with known answers: what their files say is what catalogues and textbooks say.

use crate::cases::{ExchangeCase, ExchangeQuestion, GivenRow, KnownEnclosure, exchange_cases};
use crate::expected::*;
use crate::known_factors;
use crate::net_radiation::{GreyPaint, KnownBalance, NetRadiation};
use crate::planck::{bisect, planck_between, planck_fraction};
use azulejo_exchange::RowCondition;
use azulejo_testing::closed_forms::wedge;
use std::f64::consts::{FRAC_PI_3, PI};

/// Wavelength where the bands of enclosures that are not grey meet, µm.
const EDGE: f64 = 4.0;

fn paint(enclosure: &KnownEnclosure) -> GreyPaint {
    let rows = enclosure.areas.len();
    let grey = enclosure.bands.first().map(|band| &band.emissivity);
    GreyPaint {
        emissivity: grey.unwrap_or(&enclosure.emissivity).clone(),
        mirror: (0..rows).map(|row| enclosure.mirror_of(row)).collect(),
    }
}

/// The same enclosure with factors of catalogues; `None` for those of gaps, without rows, and of 24 squares.
fn book(case: &ExchangeCase) -> Option<NetRadiation> {
    let (id, enclosure) = (&*case.problem.id, &*case.enclosure);
    let (paint, areas) = (paint(enclosure), &enclosure.areas[..]);
    if areas.is_empty() || id.starts_with("cube24") {
        return None;
    }
    let given = |upper: &[&[f64]]| NetRadiation::reciprocal(areas, &paint, |i, j| upper[i][j]);
    let reordered = |matt: NetRadiation, rows: [usize; 4]| {
        NetRadiation::new(areas, &paint, |i, j| matt.factor(rows[i], rows[j]))
    };
    let matt = |rows: usize| GreyPaint::matt(&vec![1.0; rows]);
    let is_in = |prefixes: &[&str]| prefixes.iter().any(|prefix| id.starts_with(prefix));
    Some(match id {
        "dome_halves_rerad_GR" => given(&[&[0.0, 0.0, 1.0], &[0.0, 0.0, 1.0], &[0.0, 0.0, 0.5]]),
        "duct_rerad_GR" => {
            let duct = known_factors::rectangular_duct(2.0, 1.0, &matt(4));
            reordered(duct, [0, 2, 1, 3])
        }
        "slot_flat_eps" | "slot_deep_eps" => {
            let slot = known_factors::slot(1.0, areas[0], &matt(3));
            reordered(slot, [1, 0, 2, 0])
        }
        "cone_rerad_GR" => known_factors::frustum(1.0, 2.0, 1.5, &paint),
        "cone_narrow_rerad_GR" => known_factors::frustum(1.0, 0.3, 3.0, &paint),
        _ if is_in(&["cyl3_"]) => known_factors::frustum(1.0, 1.0, 2.0, &paint),
        _ if is_in(&["cyl_mirror_"]) => known_factors::mirrored_cylinder(1.0, 2.0, &paint),
        _ if is_in(&["cyl_cavity_"]) => {
            known_factors::cylindrical_cavity(1.0, areas[1] / (2.0 * PI), &paint)
        }
        _ if is_in(&["sphere3_", "sphere_hole", "ingersoll"]) => {
            NetRadiation::new(areas, &paint, |_, j| areas[j])
        }
        _ if is_in(&["plates", "band2_plates", "sph_", "cyl_", "dome_"]) => {
            known_factors::nested([areas[0], areas[1]], &paint)
        }
        _ if is_in(&["tri_"]) => known_factors::triangle([1.0; 3], &paint),
        _ if is_in(&["tri345", "band2_tri"]) => known_factors::triangle([3.0, 4.0, 5.0], &paint),
        _ if is_in(&["duct_square"]) => known_factors::rectangular_duct(1.0, 1.0, &paint),
        _ if is_in(&["duct_flat"]) => known_factors::rectangular_duct(3.0, 0.5, &paint),
        _ if is_in(&["duct_m3"]) => known_factors::mirrored_duct(&paint),
        _ if is_in(&["wedge", "groove"]) => known_factors::strips(angle(id), &paint),
        _ if is_in(&["cube3_"]) => known_factors::cube_of_three(&paint),
        _ if is_in(&["cube_"]) => known_factors::mirrored_cube(&paint),
        _ if is_in(&["room_", "furnace_"]) => known_factors::room([4.0, 3.0, 2.5], &paint),
        _ if is_in(&["squares60"]) => given(&[&[0.0, wedge(FRAC_PI_3)], &[0.0, 0.0]]),
        _ if is_in(&["solar_"]) => given(&[&[0.0]]),
        _ => panic!("{id} has factors of no catalogue"),
    })
}

/// Between the strips of a wedge or groove, in radians.
fn angle(id: &str) -> f64 {
    let degrees = match id.split('_').nth(1) {
        Some(word) if id.starts_with("groove") => word.parse().expect("degrees"),
        _ if id.starts_with("wedge40") => 40.0,
        _ => 60.0,
    };
    f64::to_radians(degrees)
}

#[test]
fn factors_are_those_of_catalogues() {
    for case in exchange_cases() {
        let Some(book) = book(&case) else { continue };
        let (id, enclosure) = (&case.problem.id, &case.enclosure);
        let rows = enclosure.areas.len();
        for (i, j) in (0..rows).flat_map(|i| (0..rows).map(move |j| (i, j))) {
            let (factor, expected) = (enclosure.factor(i, j), book.factor(i, j));
            let is_near = (factor - expected).abs() < 1e-11 * (1.0 + expected);
            assert!(is_near, "{id}: {factor} from {i} to {j}, not {expected}");
        }
    }
}

/// Temperatures and fluxes of a grey enclosure.
fn balance(case: &ExchangeCase, book: &NetRadiation) -> KnownBalance {
    let given: Vec<RowCondition> = case.problem.given.iter().map(|&row| row.into()).collect();
    book.balance(&given)
}

/// What the textbook's equations say of a grey enclosure.
fn by_equations(case: &ExchangeCase, book: &NetRadiation) -> Option<f64> {
    if !case.enclosure.bands.is_empty() {
        return None;
    }
    let enclosure = &case.enclosure;
    let rows = enclosure.areas.len();
    Some(match &case.problem.question {
        ExchangeQuestion::Factor([i, j]) => book.factor(*i, *j),
        ExchangeQuestion::ToSpace(i) => book.to_space(*i),
        ExchangeQuestion::Gebhart([i, j]) => book.gebhart(*i, *j),
        ExchangeQuestion::ScriptF([i, j]) => book.script_f(*i, *j),
        ExchangeQuestion::Conductance([i, j]) => book.conductance(*i, *j),
        ExchangeQuestion::AllConductances(i) => (0..rows).map(|j| book.conductance(*i, j)).sum(),
        ExchangeQuestion::Opening(area) => {
            (0..rows).map(|i| book.conductance(i, rows)).sum::<f64>() / area
        }
        ExchangeQuestion::Reradiating(area) => {
            let mut given = vec![RowCondition::Flux(0.0); rows];
            given[0] = RowCondition::Temperature(400.0);
            given[1] = RowCondition::Temperature(300.0);
            area * book.balance(&given).fluxes[0] / (SIGMA * fourth_powers(400.0, 300.0))
        }
        ExchangeQuestion::Flux(rows) => balance(case, book).fluxes[rows[0]],
        ExchangeQuestion::Temperature(i) => balance(case, book).temperatures[*i],
        ExchangeQuestion::Irradiation(i) => {
            let balance = balance(case, book);
            let emission = SIGMA * balance.temperatures[*i].powi(4);
            emission - balance.fluxes[*i] / enclosure.emissivity[*i]
        }
        _ => return None,
    })
}

/// What closed formulas say.
fn by_formula(case: &ExchangeCase) -> Option<f64> {
    let (id, enclosure) = (&*case.problem.id, &*case.enclosure);
    let (areas, e) = (&enclosure.areas[..], &enclosure.emissivity[..]);
    let is_nested = ["sph_", "cyl_", "dome_GR"]
        .iter()
        .any(|p| id.starts_with(p));
    Some(match &case.problem.question {
        ExchangeQuestion::Conductance(_) | ExchangeQuestion::ScriptF(_)
            if id.starts_with("plates") =>
        {
            plates(e[0], e[1])
        }
        ExchangeQuestion::Conductance(_) if is_nested => gap_conductance(enclosure),
        ExchangeQuestion::Gebhart([_, j]) if id.starts_with("sphere3") => {
            part_of_sphere(areas, e, *j)
        }
        ExchangeQuestion::Opening(_) if id.starts_with("sphere_hole") => {
            hole_of_sphere(e[0], 1.0 - areas[0])
        }
        ExchangeQuestion::Opening(_) if id.starts_with("groove") => {
            groove(e[0], (0.5 * angle(id)).sin())
        }
        // Each half of the disk sees the dome alone.
        ExchangeQuestion::Reradiating(area) if id.starts_with("dome_halves") => {
            in_series(&[e[0] * area, e[1] * area])
        }
        ExchangeQuestion::Reradiating(_) => {
            let black = reradiating(areas[0], areas[1], enclosure.factor(0, 1));
            let surfaces = [0, 1].map(|row| surface_conductance(e[row], areas[row]));
            in_series(&[surfaces[0], black, surfaces[1]])
        }
        ExchangeQuestion::ConductanceOfGaps(_) => gaps_conductance(enclosure),
        ExchangeQuestion::FluxThroughGaps([t1, t2]) => {
            SIGMA * fourth_powers(*t1, *t2) * gaps_conductance(enclosure)
        }
        ExchangeQuestion::TemperatureBeforeGaps { flux, last } => {
            (last.powi(4) + flux / (SIGMA * gaps_conductance(enclosure))).powf(0.25)
        }
        ExchangeQuestion::Emitted { range, temperature } if range[0] > 0.0 => {
            planck_between(range[0] * temperature, range[1] * temperature)
        }
        ExchangeQuestion::Emitted { range, temperature } => planck_fraction(range[1] * temperature),
        _ => return two_band_value(case),
    })
}

fn gap_conductance(gap: &KnownEnclosure) -> f64 {
    let pair = |values: &[f64]| [values[0], values[1]];
    concentric(pair(&gap.areas), pair(&gap.emissivity), gap.mirror_of(1))
}

fn gaps_conductance(enclosure: &KnownEnclosure) -> f64 {
    in_series(
        &enclosure
            .gaps
            .iter()
            .map(gap_conductance)
            .collect::<Vec<f64>>(),
    )
}

/// T₁⁴ − T₂⁴ in K⁴.
fn fourth_powers(t1: f64, t2: f64) -> f64 {
    t1.powi(4) - t2.powi(4)
}

/// Temperatures and fluxes in two bands: heat and the sun, or below and above the edge.
fn two_band_value(case: &ExchangeCase) -> Option<f64> {
    let (asked, enclosure) = (&case.problem, &*case.enclosure);
    let [first, second] = &enclosure.bands[..] else {
        return None;
    };
    let [first, second] = [first, second].map(|band| &band.emissivity[..]);
    Some(match &*asked.id {
        id if id.starts_with("solar") => sunlit_plate(second[0], first[0], asked.sun[0], asked.sky),
        id if id.starts_with("ingersoll") => {
            let share: f64 = enclosure.areas.iter().sum();
            // The rim's disk catches the light; all of it falls on one half.
            let on_plane = asked.sun[0] * 0.5 / (1.0 - share);
            crater_shadow(share, 1.0 - second[0], first[0], on_plane)
        }
        "band2_plates_q" => between_plates([first, second], 1500.0, 300.0),
        // The hotter the second plate, the less it takes up.
        "band2_plates_T2" => bisect(10.0, 1500.0, |t| {
            20_000.0 - between_plates([first, second], 1500.0, t)
        }),
        "band2_tri_T3" => adiabatic_side([first, second], [1200.0, 400.0]),
        _ => return None,
    })
}

/// Black emission below and above the edge, W/m².
fn emission(temperature: f64) -> [f64; 2] {
    let below = planck_fraction(EDGE * temperature);
    [below, 1.0 - below].map(|share| share * SIGMA * temperature.powi(4))
}

/// Flux between parallel plates with these emissivities below and above the edge.
fn between_plates(bands: [&[f64]; 2], t1: f64, t2: f64) -> f64 {
    let (hot, cold) = (emission(t1), emission(t2));
    let flux = |band: usize| plates(bands[band][0], bands[band][1]) * (hot[band] - cold[band]);
    flux(0) + flux(1)
}

/// Temperature of the third side of a triangle that gives off nothing, between those of the others.
fn adiabatic_side(bands: [&[f64]; 2], given: [f64; 2]) -> f64 {
    let books = bands.map(|e| known_factors::triangle([3.0, 4.0, 5.0], &GreyPaint::matt(e)));
    bisect(given[1], given[0], |t| {
        let own = emission(t);
        let mut heat = 0.0;
        for (j, other) in given.into_iter().map(emission).enumerate() {
            for (band, book) in books.iter().enumerate() {
                heat += book.conductance(2, j) * (own[band] - other[band]);
            }
        }
        heat
    })
}

#[test]
fn truths_are_what_textbooks_say() {
    for case in exchange_cases() {
        let asked = &case.problem;
        if asked.id.starts_with("cube24") {
            continue;
        }
        let equations = book(&case).and_then(|book| by_equations(&case, &book));
        let both = [equations, by_formula(&case)];
        let values: Vec<f64> = both.into_iter().flatten().collect();
        assert!(!values.is_empty(), "nothing says {}", asked.id);
        for value in values {
            let is_near = (value - asked.truth).abs() <= 1e-11 * asked.truth.abs();
            assert!(is_near, "{}: {value}, not {}", asked.id, asked.truth);
        }
    }
}

/// A cube of 24 squares, which symmetry makes four: those of the floor, of the ceiling, and the lower and the upper
/// ones of the walls.
#[test]
fn squares_that_are_alike_are_one() {
    let cases = exchange_cases();
    let ids = ["floor", "ceiling", "wall_low", "wall_high"].map(|id| format!("cube24_q_{id}"));
    let cases = ids.map(|id| cases.iter().find(|case| case.problem.id == id).unwrap());
    let groups = cases.map(|case| match &case.problem.question {
        ExchangeQuestion::Flux(rows) => &rows[..],
        question => panic!("{question:?}"),
    });
    let book = known_factors::cube_of_24(&GreyPaint::matt(&[0.8; 4]));
    let enclosure = &cases[0].enclosure;
    for (g, h) in (0..4).flat_map(|g| (0..4).map(move |h| (g, h))) {
        for &i in groups[g] {
            let sum: f64 = groups[h].iter().map(|&j| enclosure.factor(i, j)).sum();
            assert!((sum - book.factor(g, h)).abs() < 1e-11, "{i} to {h}: {sum}");
        }
    }
    let given = groups.map(|rows| RowCondition::from(cases[0].problem.given[rows[0]]));
    let fluxes = book.balance(&given).fluxes;
    for (case, flux) in cases.into_iter().zip(fluxes) {
        let off = (case.problem.truth - flux).abs();
        assert!(off < 1e-11 * flux.abs(), "{}: {flux}", case.problem.id);
        assert!(
            case.problem
                .given
                .iter()
                .all(|row| matches!(row, GivenRow::Temperature(_)))
        );
    }
}
