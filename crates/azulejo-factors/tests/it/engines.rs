//! One set of tests for all engines: the cases with known answers, and properties of every engine.

use crate::cases::{Answer, Case, CaseKind, Question, cases};
use crate::posed_cases::Pose;
use azulejo_factors::form_factors::Closure;
use azulejo_factors::{Engine, FormFactorOptions, Hemicube, Patches};
use azulejo_trace::{Progress, Tracer};
use std::fmt::Write;

/// Values of the reference table by id, with half a unit of their last digit.
fn table() -> Option<Vec<(String, f64, f64)>> {
    let path = azulejo_testing::data()?.join("reference/view_factors.tsv");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let row = |line: &str| {
        let fields: Vec<&str> = line.split('\t').collect();
        let value: f64 = fields[3].parse().expect("a value");
        let digits: i32 = fields[4].parse().expect("a number of digits");
        let last = value.log10().floor() as i32 + 1 - digits;
        (fields[0].to_string(), value, 0.5 * 10f64.powi(last))
    };
    Some(text.lines().skip(1).map(row).collect())
}

#[test]
fn truths_agree_with_the_reference_table() {
    let Some(table) = table() else { return };
    let cases = cases();
    assert_eq!((table.len(), cases.len()), (68, 68));
    let mut wrong = String::new();
    for (id, value, half) in table {
        let Some(case) = cases.iter().find(|c| c.id == id) else {
            panic!("no case {id}")
        };
        // Elements are small squares here: that difference is due to the scene, not to the formula.
        let off = (case.truth.value - value).abs();
        if off > 1.01 * half + 1e-13 {
            let _ = writeln!(
                wrong,
                "{id}: {} is not {value}: {off:.1e}, more than {half:.1e}",
                case.truth.value
            );
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// A number of rays, an eighth of it where tests are not thorough.
fn rays_of(thorough: usize) -> usize {
    if azulejo_testing::is_thorough() {
        thorough
    } else {
        thorough / 8
    }
}

fn options(engine: Engine, case: &Case) -> FormFactorOptions {
    let patches = Patches::new(&case.scene, case.size).len();
    let closure = match (&engine, case.kind) {
        // Where mirrors make endless chains, closure takes care of what is left to rays.
        (Engine::Analytic, CaseKind::Mirrors) => Closure::Always,
        _ => Closure::default(),
    };
    FormFactorOptions {
        closure,
        analytic: engine == Engine::Analytic,
        engine,
        rays: (rays_of(1 << 17) / patches).clamp(rays_of(1 << 11), rays_of(1 << 16)) as u32,
        ..FormFactorOptions::default()
    }
}

/// A case with an engine's answer and the name of the engine that ran.
struct Answered {
    case: Case,
    answer: Answer,
    engine: String,
}

fn ask(case: Case, options: &FormFactorOptions) -> Answered {
    let result = case.ask(&Tracer::new(&case.scene), options, &Progress::new());
    let (answer, factors) = result.unwrap_or_else(|e| panic!("{}: {e}", case.id));
    let (id, truth, engine) = (&case.id, case.truth.value, factors.engine_used.name);
    let (value, off, error) = (answer.value, answer.off(&case), answer.error);
    eprintln!("{engine:9} {id:16} {value:.10} truth {truth:.10} off {off:.1e} ± {error:.1e}");
    assert!(value.is_finite() && error.is_finite(), "{id}: {answer:?}");
    Answered {
        case,
        answer,
        engine,
    }
}

/// Cases of perfect mirrors that show each other without end, in poses in which images that coincide differ by rounding:
/// by the analytic engine, each takes as long as many others together.
const ENDLESS: [(&str, Pose); 10] = [
    ("wedge_inf_90", Pose::Rounded),
    ("corridor_1", Pose::Rounded),
    ("prism_mir_12", Pose::Turned),
    ("wedge45_mir_11", Pose::Turned),
    ("prism_mir_B", Pose::Turned),
    ("prism_mir_12", Pose::Rounded),
    ("wedge45_mir_11", Pose::Rounded),
    ("furnace_spec", Pose::Turned),
    ("furnace_spec", Pose::Rounded),
    ("plates", Pose::Rounded),
];

/// The answers of one engine to all cases in all poses.
fn answers(engine: Engine) -> Vec<Answered> {
    let answered = |case: Case| {
        let options = options(engine.clone(), &case);
        ask(case, &options)
    };
    let is_endless = |case: &Case, pose: Pose| {
        engine == Engine::Analytic && ENDLESS.contains(&(&*case.id, pose))
    };
    let is_left_out = |case: &Case, pose| !azulejo_testing::is_thorough() && is_endless(case, pose);
    let posed = |case: Case| {
        let pose = |pose| case.posed(pose).filter(|_| !is_left_out(&case, pose));
        Pose::ALL.map(pose)
    };
    let cases = cases().into_iter().flat_map(posed).flatten();
    cases.map(answered).collect()
}

/// At least 99 of 100 answers lie within four of their standard errors.
fn check_honesty(answers: &[Answered]) {
    let is_far = |a: &&Answered| a.answer.standard_errors(&a.case) > 4.0;
    let far: Vec<&Answered> = answers.iter().filter(is_far).collect();
    let word = |a: &&Answered| {
        let (id, truth) = (&a.case.id, a.case.truth.value);
        format!("{} {id}: {:?}, truth {truth}", a.engine, a.answer)
    };
    let words: Vec<String> = far.iter().map(word).collect();
    assert!(far.len() * 100 <= answers.len(), "far off: {words:#?}");
}

#[test]
fn rays() {
    check_honesty(&answers(Engine::Rays));
}

/// Formulas for near pairs never make rays worse.
#[test]
fn rays_with_formulas() {
    let with = |analytic: bool, case: &Case| {
        let options = FormFactorOptions {
            analytic,
            ..options(Engine::Rays, case)
        };
        ask(case.clone(), &options)
    };
    let pairs = cases().into_iter().filter(|c| {
        let is_flat = matches!(
            c.kind,
            CaseKind::Polygons | CaseKind::Shadow | CaseKind::Mirrors
        );
        is_flat && matches!(c.question, Question::Factor { .. })
    });
    let mut answers = Vec::new();
    for case in pairs {
        let (rays, formulas) = (with(false, &case), with(true, &case));
        // Four replicates estimate their spread to within a third.
        let most = 1.5 * rays.answer.error;
        assert!(formulas.answer.error <= most, "{}", case.id);
        answers.push(formulas);
    }
    check_honesty(&answers);
}

/// Hemicubes of this many pixels along a side, from this many points, on the processor. Fewer pixels would not do: what
/// they distort of close pairs is not noise.
fn pixels(resolution: u32, points: u32) -> Hemicube {
    Hemicube {
        resolution,
        points,
        ..Hemicube::default()
    }
}

/// Points of a row: at least one for each replicate.
fn points() -> u32 {
    if azulejo_testing::is_thorough() {
        16
    } else {
        4
    }
}

/// Relative difference in size between bodies as facets and the exact ones.
const FACETS: f64 = 0.015;

/// Engines that render: as accurate as the others, except for the facets of curved bodies.
fn check_drawn(engine: Engine, name: &str) {
    let mut answered = answers(engine);
    assert!(
        answered.iter().all(|a| a.engine == name),
        "{name} is what runs"
    );
    for a in &mut answered {
        if a.case.kind == CaseKind::Curved {
            a.case.truth.error += FACETS * a.case.truth.value;
        }
    }
    check_honesty(&answered);
}

#[test]
fn hemicubes() {
    check_drawn(Engine::Hemicube(pixels(32, points())), "hemicube");
}

#[test]
fn hybrid() {
    check_drawn(Engine::Hybrid(pixels(32, points())), "hybrid");
}

/// Four times the pixels along a side and sixteen times the points at least halve the error: there
/// is not an error floor, as there is for one point per patch.
#[test]
fn hemicubes_get_better() {
    let off = |resolution, points| {
        let engine = Engine::Hemicube(pixels(resolution, points));
        let flat = cases().into_iter().filter(|c| c.kind == CaseKind::Polygons);
        let squares = flat.map(|case| {
            let options = options(engine.clone(), &case);
            let answered = ask(case, &options);
            (answered.answer.off(&answered.case) / answered.case.truth.value).powi(2)
        });
        let squares: Vec<f64> = squares.collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    let (rough, fine) = (off(16, 4), off(64, 64));
    assert!(fine < 0.5 * rough, "{rough} {fine}");
}

/// The tolerance of formulas, relative to the truth.
fn formula_tolerance(kind: CaseKind) -> Option<f64> {
    match kind {
        CaseKind::Polygons => Some(1e-10),
        CaseKind::Shadow => Some(1e-6),
        CaseKind::Mirrors => Some(1e-8),
        CaseKind::Curved | CaseKind::Glass => None,
    }
}

#[test]
fn analytic() {
    let answers = answers(Engine::Analytic);
    assert!(answers.iter().all(|a| a.engine == "analytic"));
    // Mirrors at angles that divide a turn join their images; once rounded, some are left to rays.
    let is_by_rays = |a: &Answered| a.case.kind == CaseKind::Mirrors && a.answer.error > 1e-5;
    assert!(answers.iter().filter(|a| is_by_rays(a)).count() <= 8);
    for answered in answers.iter().filter(|a| !is_by_rays(a)) {
        let Answered { case, answer, .. } = answered;
        if let Some(tolerance) = formula_tolerance(case.kind) {
            let most = tolerance * case.truth.value + case.truth.error;
            assert!(
                answer.off(case) <= most,
                "{}: {answer:?}, {:?}",
                case.id,
                case.truth
            );
        }
    }
    check_honesty(&answers);
}
