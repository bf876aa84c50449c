//! Worlds as files hold them: rounded, far from the origin, cracked, doubled. Each test says what a careful
//! user would call right, by closed forms; the table in `docs/form-factors.md` lists them.

use crate::poses::{Digits, pose, posed, room};
use azulejo_factors::form_factors::Closure;
use azulejo_factors::{
    Engine, FactorsError, FormFactorOptions, FormFactors, Hemicube, PatchSize, Patches,
    form_factors,
};
use azulejo_scene::{Material, Mesh, Object, Rgb, Scene, Shape, Up};
use azulejo_testing::closed_forms::{on_common_edge, opposed};
use azulejo_trace::{Progress, Tracer};
use glam::{DAffine3, DVec3, dvec3};

/// Rays of a row.
const RAYS: u32 = 1 << 16;

/// The room that most worlds are made of: its floor is object 0, its ceiling 1, the wall at y = 0 is 2.
const SIZE: DVec3 = dvec3(4.0, 3.0, 2.5);
const CEILING: usize = 1;
const WALL: usize = 2;

fn rays_and_hemicubes() -> [Engine; 2] {
    let hemicube = Hemicube {
        resolution: 64,
        points: 64,
        ..Hemicube::default()
    };
    [Engine::Rays, Engine::Hemicube(hemicube)]
}

fn engines() -> [Engine; 3] {
    let [rays, hemicubes] = rays_and_hemicubes();
    [Engine::Analytic, rays, hemicubes]
}

/// Rows of whole faces by an engine alone, before closure.
fn ask(scene: &Scene, engine: &Engine) -> Result<FormFactors, FactorsError> {
    form_factors(
        scene,
        &Tracer::new(scene),
        &options(engine),
        &Progress::new(),
    )
}

fn options(engine: &Engine) -> FormFactorOptions {
    FormFactorOptions {
        engine: engine.clone(),
        size: PatchSize::Edge(0.0),
        rays: RAYS,
        analytic: *engine == Engine::Analytic,
        closure: Closure::Never,
        ..FormFactorOptions::default()
    }
}

fn compute(scene: &Scene, engine: &Engine) -> FormFactors {
    ask(scene, engine).unwrap()
}

fn flaws(scene: &Scene) -> Vec<String> {
    Patches::new(scene, PatchSize::Edge(0.0)).flaws(scene, false)
}

/// An object of one face for each polygon.
fn sheets(polygons: &[Vec<DVec3>]) -> Scene {
    let mut scene = Scene::default();
    let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    for (k, polygon) in polygons.iter().enumerate() {
        let mut mesh = Mesh {
            positions: polygon.clone(),
            ..Mesh::default()
        };
        let corners: Vec<u32> = (0..polygon.len() as u32).collect();
        mesh.push_face(&corners, grey);
        scene
            .objects
            .push(Object::new(format!("sheet {k}"), Shape::Mesh(mesh)));
    }
    scene
}

/// The room with a floor of these polygons, which are the last objects in the place of the first.
fn room_with_floor(floor: &[Vec<[f64; 2]>]) -> (Scene, Vec<usize>) {
    let mut scene = room(SIZE);
    let polygon = |p: &Vec<[f64; 2]>| p.iter().map(|&[x, y]| dvec3(x, y, 0.0)).collect();
    let polygons: Vec<Vec<DVec3>> = floor.iter().map(polygon).collect();
    let mut parts = sheets(&polygons).objects.into_iter();
    scene.objects[0] = parts.next().unwrap();
    scene.objects.extend(parts);
    let others = scene.objects.len() - floor.len() + 1..scene.objects.len();
    (scene, [0].into_iter().chain(others).collect())
}

/// The floor of the room from one x to another.
fn strip(from: f64, to: f64) -> Vec<[f64; 2]> {
    vec![[from, 0.0], [to, 0.0], [to, SIZE.y], [from, SIZE.y]]
}

/// The factor between objects, and its standard error.
fn between(matrix: &FormFactors, from: &[usize], to: &[usize]) -> (f64, f64) {
    let rows = |objects: &[usize]| -> Vec<usize> {
        let is_of = |&i: &usize| objects.contains(&(matrix.faces[i].object as usize));
        (0..matrix.len()).filter(is_of).collect()
    };
    let (from, to) = (rows(from), rows(to));
    let area: f64 = from.iter().map(|&i| matrix.areas[i]).sum();
    let (mut sum, mut variance) = (0.0, 0.0);
    for &i in &from {
        for &j in &to {
            let (f, error) = matrix.get(i, j as u32);
            sum += matrix.areas[i] * f;
            variance += (matrix.areas[i] * f64::from(error)).powi(2);
        }
    }
    (sum / area, variance.sqrt() / area)
}

/// A factor is right but for `slack`, and for what is by chance: five standard errors, each of four replicates.
#[track_caller]
fn check_factor(matrix: &FormFactors, from: &[usize], to: &[usize], truth: f64, slack: f64) {
    let (f, error) = between(matrix, from, to);
    assert!(
        (f - truth).abs() <= slack + 5.0 * error,
        "{} {from:?} {to:?}: {f} ± {error:e}, truth {truth}",
        matrix.engine_used.name
    );
}

/// The floor sees ceiling and wall, and they the floor, as in the room with its floor in one piece.
#[track_caller]
fn check_floor(matrix: &FormFactors, floor: &[usize], slack: f64) {
    let DVec3 { x, y, z } = SIZE;
    check_factor(matrix, floor, &[CEILING], opposed(x, y, z), slack);
    check_factor(matrix, &[CEILING], floor, opposed(x, y, z), slack);
    check_factor(matrix, floor, &[WALL], on_common_edge(x, y, z), slack);
    check_factor(matrix, &[WALL], floor, on_common_edge(x, z, y), slack);
}

/// All entries are shares; a row of some area loses at most the share `lost(area)` of its light, and is off 1 by
/// no more than that, `slack` and chance.
#[track_caller]
fn check_rows(matrix: &FormFactors, slack: f64, lost: impl Fn(f64) -> f64) {
    let (sums, noise) = (matrix.row_sums(), matrix.noise_of_sums());
    for i in 0..matrix.len() {
        let off = (sums[i] - 1.0).abs();
        let (at_most, lost) = (slack + 5.0 * noise[i], lost(matrix.areas[i]));
        let name = &matrix.engine_used.name;
        assert!(off <= at_most + lost, "{name} row {i}: 1 - {off:e}");
        let rest = matrix.rest[i].sum();
        assert!(rest <= lost, "{name} row {i} loses {rest:e}");
        assert!(matrix.row(i).all(|(_, f, _)| (0.0..=1.0).contains(&f)));
    }
}

/// What a few rays of a row that go astray stand for.
fn few_rays(matrix: &FormFactors) -> f64 {
    match matrix.engine_used.name.as_str() {
        "analytic" => 0.0,
        _ => 4.0 / f64::from(RAYS),
    }
}

/// Rounding bends a turned square to seven decimals, so that each of its sides has a corner in front: they see
/// nothing of each other all the same.
#[test]
fn sides_of_a_bent_square_do_not_see_each_other() {
    let square = [
        dvec3(1.2812419, 2.9279564, -0.7478442),
        dvec3(0.929374, 2.2451444, -0.1075654),
        dvec3(0.7316692, 1.6307662, -0.8714058),
        dvec3(1.0835371, 2.3135781, -1.5116846),
    ];
    let scene = sheets(&[square.to_vec()]);
    for engine in engines() {
        let options = FormFactorOptions {
            two_sided: true,
            // Formulas beside all engines.
            analytic: true,
            ..options(&engine)
        };
        let tracer = Tracer::new(&scene);
        let factors = form_factors(&scene, &tracer, &options, &Progress::new()).unwrap();
        assert_eq!(factors.get(0, 1).0, 0.0, "{engine:?}");
    }
}

/// T-joints: the floor is divided where its neighbours have no vertex. It stays closed, and sees what it saw.
/// By hemicubes, up to 69% of the light of a wall had ended on its own back.
#[test]
fn t_joints_stay_closed() {
    let x = 1.357_913;
    let (scene, floor) = room_with_floor(&[strip(0.0, x), strip(x, SIZE.x)]);
    for (k, decimals) in [(0, 6), (1, 6), (0, 4), (1, 4), (2, 4)] {
        let turned = posed(&scene, &pose(k, 10.0), Digits::Decimals(decimals));
        // Lengths are some metres: the unit in the last place is about the share that rounding moves.
        let unit = 10f64.powi(-decimals);
        for engine in engines() {
            let matrix = compute(&turned, &engine);
            // With six decimals a joint gapes less than single precision tells: no ray passes. With four, some
            // do, and rays and hemicubes may take the room for open.
            let gapes = decimals == 4 && engine != Engine::Analytic;
            let leak = if gapes { few_rays(&matrix) } else { 0.0 };
            check_rows(&matrix, unit, |_| unit + leak);
            check_floor(&matrix, &floor, unit);
            assert!(gapes || matrix.is_closed, "{k} {decimals} {engine:?}");
        }
    }
}

/// A crack of 1e-5 of the room lets out its own area's light: rows lack what they see of it, at most its share
/// of their area, and all rows together its area.
#[test]
fn cracks_let_out_their_own_light() {
    let x = 1.5;
    for (width, is_closed) in [(1e-5 * SIZE.x, false), (1e-7 * SIZE.x, true)] {
        let (scene, floor) = room_with_floor(&[strip(0.0, x), strip(x + width, SIZE.x)]);
        let crack = width * SIZE.y;
        for engine in engines() {
            let matrix = compute(&scene, &engine);
            let lost = |area: f64| crack / area + few_rays(&matrix);
            check_rows(&matrix, 1e-10, lost);
            check_floor(&matrix, &floor, crack / (SIZE.y * SIZE.z));
        }
        let matrix = compute(&scene, &Engine::Analytic);
        let rows = matrix.areas.iter().zip(matrix.row_sums());
        let lacking: f64 = rows.map(|(area, sum)| area * (1.0 - sum)).sum();
        assert!((lacking / crack - 1.0).abs() < 1e-6, "{lacking} of {crack}");
        // A millionth of a row's light is what counts as a leak.
        assert_eq!(matrix.is_closed, is_closed, "{width}");
        // Turned and rounded, the crack is as wide but for the last digit.
        let digits = Digits::Decimals(6);
        let turned = compute(&posed(&scene, &pose(3, 10.0), digits), &Engine::Analytic);
        check_rows(&turned, 1e-6, |area| crack / area);
        check_floor(&turned, &floor, 1e-6 + crack / (SIZE.y * SIZE.z));
    }
}

/// A floor of four triangles, one of which is as high as `height`.
fn room_with_sliver(height: f64) -> (Scene, Vec<usize>) {
    let [a, b, c, d] = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]];
    let m = [1.7, height];
    room_with_floor(&[vec![a, b, m], vec![b, c, m], vec![c, d, m], vec![d, a, m]])
}

/// A sliver changes nothing for the others, and is a row like theirs as far as its corners are known. The
/// analytic engine had refused the room, because rays from the sliver, one of nine rows, start beside it.
#[test]
fn slivers_disturb_no_other_row() {
    for height in [1e-4, 1e-6] {
        let (straight, floor) = room_with_sliver(height);
        let matrix = compute(&straight, &Engine::Analytic);
        check_rows(&matrix, 1e-9, |_| 1e-9);
        check_floor(&matrix, &floor, 1e-12);
        assert!(matrix.is_closed);
        for decimals in [7, 6] {
            let scene = posed(&straight, &pose(2, 10.0), Digits::Decimals(decimals));
            for engine in engines() {
                let matrix = compute(&scene, &engine);
                let note = matrix.engine_used.notes.join("; ");
                check_sliver(&matrix);
                check_floor(&matrix, &floor, 2.0 * 10f64.powi(-decimals));
                let says = note.contains("1 rows are less than 100 times as wide");
                assert_eq!(says, engine != Engine::Analytic, "{note}");
            }
        }
    }
}

/// Closure makes rows of the others sum to 1: that some rays of the sliver start outside is not an opening.
#[test]
fn slivers_open_no_room() {
    let (straight, _) = room_with_sliver(1e-6);
    for scene in [
        &straight,
        &posed(&straight, &pose(2, 10.0), Digits::Decimals(7)),
    ] {
        let raw = compute(scene, &Engine::Rays);
        let strays = raw.faces.iter().zip(&raw.rest);
        let strays = strays.map(|(face, rest)| (face.object == 0, rest.escaped() > 1e-3));
        assert!(
            strays
                .into_iter()
                .all(|(is_sliver, escapes)| is_sliver == escapes)
        );
        let options = FormFactorOptions {
            closure: Closure::Closed,
            ..options(&Engine::Rays)
        };
        let matrix = form_factors(scene, &Tracer::new(scene), &options, &Progress::new()).unwrap();
        assert!(raw.is_closed && matrix.is_closed && matrix.closed.is_some());
        for (sum, rest) in matrix.row_sums().iter().zip(&matrix.rest) {
            assert_eq!(rest.escaped(), 0.0);
            assert!((sum + rest.hidden - 1.0).abs() < 1e-7, "{sum} {rest:?}");
        }
    }
}

/// All rows are closed but that of the sliver, object 0, which sees less rather than more: rounding turned it by
/// itself, and rays cannot start on it alone.
#[track_caller]
fn check_sliver(matrix: &FormFactors) {
    let (sums, noise) = (matrix.row_sums(), matrix.noise_of_sums());
    for i in 0..matrix.len() {
        let slack = 1e-6 + 5.0 * noise[i];
        let least = match matrix.faces[i].object {
            0 => 0.8,
            _ => 1.0 - slack,
        };
        assert!((least..=1.0 + slack).contains(&sums[i]), "{i}: {}", sums[i]);
        let (to_sliver, _) = between(matrix, &[matrix.faces[i].object as usize], &[0]);
        assert!(to_sliver * matrix.areas[i] <= matrix.areas[0] * (1.0 + 1e-9));
    }
}

/// A wall of two sheets back to back, as thin as nothing: those inside see one of them, neither sees the other,
/// and the one outside sees nothing.
#[test]
fn sheets_back_to_back_are_one_wall() {
    let (mut scene, _) = room_with_floor(&[strip(0.0, SIZE.x)]);
    let mut outside = scene.objects[0].clone();
    outside.turn_inside_out();
    scene.objects.push(outside);
    let twin = scene.objects.len() - 1;
    let turned = posed(&scene, &pose(1, 10.0), Digits::Decimals(6));
    for (scene, slack) in [(&scene, 1e-10), (&turned, 1e-6)] {
        assert!(flaws(scene).is_empty());
        for engine in engines() {
            let matrix = compute(scene, &engine);
            check_floor(&matrix, &[0], slack);
            assert_eq!(between(&matrix, &[twin], &[0, 1, 2, 3, 4, 5]), (0.0, 0.0));
            assert!(matrix.is_closed);
        }
    }
}

/// The outer sheet is divided along the other diagonal: which of the two a ray meets first is rounding, and light
/// that met the back of the outer one was lost.
#[test]
fn sheets_back_to_back_may_be_divided_in_other_ways() {
    let (mut scene, _) = room_with_floor(&[strip(0.0, SIZE.x)]);
    let Shape::Mesh(floor) = &scene.objects[0].shape else {
        unreachable!("rooms are meshes");
    };
    let mut outside = Mesh {
        positions: floor.positions.clone(),
        ..Mesh::default()
    };
    outside.push_face(&[1, 0, 3], 0);
    outside.push_face(&[1, 3, 2], 0);
    scene
        .objects
        .push(Object::new("outside", Shape::Mesh(outside)));
    let twin = scene.objects.len() - 1;
    let turned = posed(&scene, &pose(1, 10.0), Digits::Decimals(6));
    for (scene, slack) in [(&scene, 1e-10), (&turned, 1e-6)] {
        for engine in engines() {
            let matrix = compute(scene, &engine);
            check_floor(&matrix, &[0], slack);
            assert_eq!(between(&matrix, &[twin], &[0, 1, 2, 3, 4, 5]), (0.0, 0.0));
        }
    }
}

/// A wall that is there twice. Light can meet only one of them: those inside should see the pair as they see
/// one. They see it one and a half times by rays and hemicubes, since both sheets send out all of their light;
/// so the program names the pair, and formulas refuse it.
#[test]
fn doubled_sheets_are_named() {
    let (mut scene, _) = room_with_floor(&[strip(0.0, SIZE.x)]);
    scene.objects.push(scene.objects[0].clone());
    let twin = scene.objects.len() - 1;
    let turned = posed(&scene, &pose(1, 10.0), Digits::Decimals(6));
    for scene in [&scene, &turned] {
        let flaws = flaws(scene).join("; ");
        assert!(flaws.contains("overlap"), "{flaws}");
        let refused = ask(scene, &Engine::Analytic);
        assert!(matches!(refused, Err(FactorsError::Doubtful { .. })));
        for engine in rays_and_hemicubes() {
            let matrix = compute(scene, &engine);
            assert_eq!(between(&matrix, &[0], &[twin]).0, 0.0);
            let truth = opposed(SIZE.x, SIZE.y, SIZE.z);
            check_factor(&matrix, &[0], &[CEILING], truth, 0.0);
            check_factor(&matrix, &[CEILING], &[0, twin], 1.5 * truth, 0.0);
        }
    }
}

/// The bottom and the top of a slab, and how many faces it has.
const BOTTOM: usize = 0;
const TOP: usize = 1;
const FACES: usize = 6;

/// The faces of slabs of a size, at their lowest corners.
fn slabs(places: &[DVec3], size: DVec3) -> Vec<Vec<DVec3>> {
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let corner = |at: DVec3, k: i32| {
        at + size * dvec3(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2))
    };
    let polygons = places
        .iter()
        .flat_map(|&at| faces.map(|face| face.map(|k| corner(at, k)).to_vec()));
    polygons.collect()
}

/// Two square slabs with a gap as high as they are wide, the lower one at a place.
fn two_slabs(at: DVec3, width: f64, thickness: f64) -> Vec<Vec<DVec3>> {
    let above = at + (width + thickness) * DVec3::Z;
    slabs(&[at, above], dvec3(width, width, thickness))
}

/// The slabs whose lower one starts at object `first` see each other as two squares at the distance of their
/// side, and nothing of themselves.
#[track_caller]
fn check_slabs(matrix: &FormFactors, first: usize, slack: f64) {
    let side = |slab: usize, face: usize| [first + slab * FACES + face];
    let f = opposed(1.0, 1.0, 1.0);
    assert!((f - 0.199_825).abs() < 1e-6);
    check_factor(matrix, &side(0, TOP), &side(1, BOTTOM), f, slack);
    check_factor(matrix, &side(1, BOTTOM), &side(0, TOP), f, slack);
    for (a, b) in [
        (side(0, TOP), side(0, BOTTOM)),
        (side(1, TOP), side(1, BOTTOM)),
        (side(0, BOTTOM), side(1, BOTTOM)),
        (side(0, TOP), side(1, TOP)),
    ] {
        assert_eq!(between(matrix, &a, &b).0, 0.0);
        assert_eq!(between(matrix, &b, &a).0, 0.0);
    }
}

/// Slabs of 1 m × 1 m × 1 mm at 10 km and at 5,400 km from the origin, with four decimals: as near the origin.
#[test]
fn thin_slabs_are_as_right_far_away() {
    for at in [
        DVec3::ZERO,
        dvec3(7_000.123_4, 7_000.432_1, 12.5),
        dvec3(345_678.123_4, 5_432_109.432_1, 112.5),
    ] {
        let straight = sheets(&two_slabs(at, 1.0, 1e-3));
        let straight = posed(&straight, &DAffine3::IDENTITY, Digits::Decimals(4));
        let near = sheets(&two_slabs(DVec3::ZERO, 1.0, 1e-3));
        let turn = DAffine3::from_translation(at) * pose(2, 0.0);
        let turned = posed(&near, &turn, Digits::Decimals(4));
        for engine in engines() {
            check_slabs(&compute(&straight, &engine), 0, 1e-6);
            // A factor of squares moves by at most 4 times circumference over area, 4 per metre, times the
            // rounding, 5e-5 along each axis; it is 2e-5 here.
            check_slabs(&compute(&turned, &engine), 0, 1e-4);
        }
    }
}

/// The same slabs on a plain of 20 km, whose size was that of all rounding: rays started 2 cm off a surface.
#[test]
fn thin_slabs_on_a_plain() {
    let at = dvec3(7_000.123_4, 7_000.432_1, 12.5);
    let ground = [[-1e4, -1e4], [1e4, -1e4], [1e4, 1e4], [-1e4, 1e4]];
    let mut polygons = two_slabs(at, 1.0, 1e-3);
    polygons.push(ground.map(|[x, y]| dvec3(x, y, 0.0)).to_vec());
    let scene = posed(&sheets(&polygons), &DAffine3::IDENTITY, Digits::Decimals(4));
    let matrix = compute(&scene, &Engine::Analytic);
    check_slabs(&matrix, 0, 1e-6);
    let ground = polygons.len() - 1;
    // The ground fills the view of the lowest face but for the horizon, (12.5 / 3000)² / 2 of it at most.
    check_factor(&matrix, &[BOTTOM], &[ground], 1.0, 1e-5);
    for engine in rays_and_hemicubes() {
        let matrix = compute(&scene, &engine);
        let notes = matrix.engine_used.notes.join("; ");
        assert!(!notes.contains("times as wide"), "{notes}");
        // Five standard errors.
        check_slabs(&matrix, 0, 4e-3);
    }
}

/// The slabs at both ends of a world of 10 km. Only one end can have the digits of single precision: at the other
/// rays start 2 cm off a surface, which is said.
#[test]
fn thin_slabs_at_both_ends_of_a_world() {
    let mut polygons = two_slabs(DVec3::ZERO, 1.0, 1e-3);
    let first = polygons.len();
    polygons.extend(two_slabs(dvec3(10_000.0, 0.0, 0.0), 1.0, 1e-3));
    let scene = sheets(&polygons);
    let matrix = compute(&scene, &Engine::Analytic);
    for at in [0, first] {
        check_slabs(&matrix, at, 1e-6);
    }
    for engine in rays_and_hemicubes() {
        let matrix = compute(&scene, &engine);
        let notes = matrix.engine_used.notes.join("; ");
        let expected = "12 rows are less than 100 times as wide";
        assert!(notes.contains(expected), "{notes}");
        // dF/dgap is about −0.3 per metre.
        for at in [0, first] {
            check_slabs(&matrix, at, 0.3 * 0.04);
        }
    }
}

/// CAD in millimetres: the slabs a thousand times as large, and as far from the origin as parts of a plant.
#[test]
fn millimetres_are_as_good_as_metres() {
    for at in [DVec3::ZERO, dvec3(123_456.789, -98_765.432, 5_000.123)] {
        let scene = sheets(&two_slabs(at, 1000.0, 1.0));
        let scene = posed(&scene, &DAffine3::IDENTITY, Digits::Decimals(3));
        for engine in engines() {
            check_slabs(&compute(&scene, &engine), 0, 1e-9);
        }
    }
}

/// A street in national coordinates with centimetres or millimetres: what its surfaces see of each other and of
/// the sky is what they see at the origin, turned but for rounding.
#[test]
fn streets_in_city_coordinates() {
    let (length, width, height) = (100.0, 20.0, 15.0);
    let at = |x: f64, y: f64, z: f64| dvec3(x * length, y * width, z * height);
    let ground = vec![
        at(0., 0., 0.),
        at(1., 0., 0.),
        at(1., 1., 0.),
        at(0., 1., 0.),
    ];
    let south = vec![
        at(0., 0., 0.),
        at(0., 0., 1.),
        at(1., 0., 1.),
        at(1., 0., 0.),
    ];
    let north = vec![
        at(0., 1., 0.),
        at(1., 1., 0.),
        at(1., 1., 1.),
        at(0., 1., 1.),
    ];
    let mut street = sheets(&[ground, south, north]);
    street.units.up = Up::Z;
    let to_wall = on_common_edge(length, width, height);
    let to_ground = on_common_edge(length, height, width);
    let across = opposed(length, height, width);
    let place = DAffine3::from_translation(dvec3(345_678.12, 5_432_109.87, 112.35));
    for (turn, decimals) in [(0.0, 2), (0.6, 2), (0.6, 3)] {
        let map = place * DAffine3::from_rotation_z(turn);
        let scene = posed(&street, &map, Digits::Decimals(decimals));
        // Corners move by 0.7 units along the ground; a wall of 15 m has 0.15 m of circumference per m² of area.
        let slack = match turn {
            0.0 => 1e-9,
            _ => 0.15 * 0.7 * 10f64.powi(-decimals),
        };
        for engine in engines() {
            let matrix = compute(&scene, &engine);
            check_factor(&matrix, &[0], &[1], to_wall, slack);
            check_factor(&matrix, &[2], &[0], to_ground, slack);
            check_factor(&matrix, &[1], &[2], across, slack);
            let noise = matrix.noise_of_sums()[0];
            let sky = matrix.rest[0].sky;
            assert!(
                (sky - (1.0 - 2.0 * to_wall)).abs() <= 2.0 * slack + 5.0 * noise,
                "{sky}"
            );
            assert!(!matrix.is_closed);
        }
    }
}
