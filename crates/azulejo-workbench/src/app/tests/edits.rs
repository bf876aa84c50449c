//! Any sequence of edits can be undone.

use super::*;
use crate::document::{NewLight, NewLightKind, NewShape, NewShapeKind, PrismOutline, TextLayout};
use azulejo::scene::math::Aabb;
use azulejo::scene::{
    Camera, Fog, Light, LightKind, Material, Mesh, Primitive, PrimitiveKind, Rgb, SceneBackground,
    Shape, Units, Up,
};
use glam::{DAffine3, DMat3, DVec3};
use proptest::prelude::*;
use proptest::sample::select;

/// Numbers, mostly reasonable ones.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        12 => -10.0..10.0,
        2 => select(vec![0.0, 1.0, -1.0]),
        1 => select(vec![f64::NAN, f64::INFINITY, f64::MAX, f64::MIN_POSITIVE, 1e200, 1e-200]),
    ]
}

fn vector() -> impl Strategy<Value = DVec3> {
    [number(), number(), number()].prop_map(DVec3::from)
}

fn color() -> impl Strategy<Value = Rgb> {
    prop_oneof![
        6 => [0.0..1.0, 0.0..1.0, 0.0..1.0f64].prop_map(|[r, g, b]| Rgb::new(r, g, b)),
        1 => vector().prop_map(|v| Rgb::new(v.x, v.y, v.z)),
    ]
}

fn map() -> impl Strategy<Value = DAffine3> {
    prop_oneof![
        4 => (vector(), 0.1..3.0f64, vector()).prop_map(|(by, factor, turn)| {
            let turn = glam::DQuat::from_scaled_axis(turn.clamp(DVec3::splat(-3.0), DVec3::splat(3.0)));
            DAffine3::from_scale_rotation_translation(DVec3::splat(factor), turn, by)
        }),
        2 => (vector(), vector(), vector(), vector()).prop_map(|(x, y, z, t)| DAffine3 {
            matrix3: DMat3::from_cols(x, y, z),
            translation: t,
        }),
    ]
}

/// Ids that exist, and some that do not: those of the sample end at 6.
fn id() -> impl Strategy<Value = ItemId> {
    (1..12u64).prop_map(ItemId)
}

fn ids() -> impl Strategy<Value = Vec<ItemId>> {
    prop::collection::vec(id(), 0..4)
}

fn name() -> impl Strategy<Value = String> {
    prop_oneof![9 => "[a-c /0-9é]{0,6}", 1 => "[a\n\t]{1,3}"]
}

fn material() -> impl Strategy<Value = Material> {
    (name(), color(), color(), 0..3u32, any::<bool>()).prop_map(
        |(name, kd, le, texture, shines)| Material {
            emission: if shines { le } else { Rgb::BLACK },
            textures: (0..texture).collect(),
            ..Material::diffuse(name, kd)
        },
    )
}

fn shape() -> impl Strategy<Value = Shape> {
    let corner = || prop::collection::vec(vector(), 3..6);
    let mesh = (corner(), 0..5u32, 0..7u32).prop_map(|(positions, material, last)| {
        let mut mesh = Mesh {
            positions,
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, last], material);
        Shape::Mesh(mesh)
    });
    let kinds = select(vec![
        PrimitiveKind::Sphere,
        PrimitiveKind::Cuboid,
        PrimitiveKind::Square,
        PrimitiveKind::Cone { top: 0.5 },
    ]);
    let primitive = (kinds, map(), 0..5u32)
        .prop_map(|(kind, map, material)| Shape::Primitive(Primitive::new(kind, map, material)));
    prop_oneof![mesh, primitive]
}

fn new_shape() -> impl Strategy<Value = NewShape> {
    let kinds = select(vec![
        NewShapeKind::Cuboid,
        NewShapeKind::Sphere,
        NewShapeKind::Cylinder,
        NewShapeKind::Cone,
        NewShapeKind::Square,
        NewShapeKind::AreaLight,
        NewShapeKind::Prism(PrismOutline::regular(5, 0.5).unwrap()),
        NewShapeKind::Text(TextLayout::set("i", 0.2, None).unwrap()),
    ]);
    let material = prop::option::of(0..5u32);
    (kinds, vector(), number(), material).prop_map(|(kind, at, size, material)| NewShape {
        kind,
        at,
        size,
        material,
    })
}

fn new_light() -> impl Strategy<Value = NewLight> {
    let kinds = select(vec![
        NewLightKind::Point,
        NewLightKind::Spot,
        NewLightKind::Sun,
        NewLightKind::Sky,
        NewLightKind::Ambient,
    ]);
    (kinds, vector(), vector()).prop_map(|(kind, at, toward)| NewLight { kind, at, toward })
}

fn light() -> impl Strategy<Value = Light> {
    let unit = || vector().prop_map(|v| v.normalize());
    let point = (vector(), color()).prop_map(|(position, intensity)| LightKind::Point {
        position,
        intensity,
    });
    let spot = (vector(), unit(), color(), number(), number()).prop_map(
        |(position, direction, intensity, inner, outer)| LightKind::Spot {
            position,
            direction,
            intensity,
            inner,
            outer,
        },
    );
    let sun = (unit(), color()).prop_map(|(direction, irradiance)| LightKind::Directional {
        direction,
        irradiance,
        half_angle: 0.0,
    });
    let sky = color().prop_map(|radiance| LightKind::Ambient { radiance });
    (name(), prop_oneof![point, spot, sun, sky]).prop_map(|(name, kind)| Light { name, kind })
}

fn camera() -> impl Strategy<Value = Camera> {
    (name(), vector(), vector(), vector(), number()).prop_map(|(name, eye, target, up, fov)| {
        Camera {
            name,
            eye,
            target,
            up,
            vertical_fov: fov,
            size: None,
        }
    })
}

fn units() -> impl Strategy<Value = Units> {
    (prop::option::of(number()), any::<bool>(), any::<bool>()).prop_map(
        |(metres, z, photometric)| Units {
            metres_per_unit: metres,
            up: if z { Up::Z } else { Up::Y },
            photometric,
        },
    )
}

fn any_edit() -> impl Strategy<Value = Edit> {
    let fog = (color(), number(), any::<bool>()).prop_map(|(color, visibility, exponential)| Fog {
        color,
        visibility,
        exponential,
    });
    let faces = prop::collection::vec(0..3u32, 0..3);
    prop_oneof![
        (id(), name()).prop_map(|(id, name)| Edit::Rename(id, name)),
        (ids(), any::<bool>()).prop_map(|(ids, hidden)| Edit::Hide(ids, hidden)),
        ids().prop_map(Edit::Delete),
        ids().prop_map(Edit::Duplicate),
        (ids(), map()).prop_map(|(ids, map)| Edit::Transform(ids, map)),
        (id(), map()).prop_map(|(id, map)| Edit::SetPlacement(id, map)),
        new_shape().prop_map(Edit::AddShape),
        (id(), shape()).prop_map(|(id, shape)| Edit::SetShape(id, Arc::new(shape))),
        new_light().prop_map(Edit::AddLight),
        (id(), light()).prop_map(|(id, light)| Edit::SetLight(id, light)),
        camera().prop_map(Edit::AddCamera),
        (id(), camera()).prop_map(|(id, camera)| Edit::SetCamera(id, camera)),
        material().prop_map(Edit::AddMaterial),
        (0..6u32, material()).prop_map(|(id, material)| Edit::SetMaterial(id, material)),
        (0..6u32).prop_map(Edit::DeleteMaterial),
        Just(Edit::DeleteUnusedMaterials),
        (ids(), 0..6u32).prop_map(|(ids, material)| Edit::Assign(ids, material)),
        (id(), faces, 0..6u32).prop_map(|(id, faces, m)| Edit::AssignFaces(id, faces, m)),
        prop::option::of(color().prop_map(SceneBackground::Color)).prop_map(Edit::SetBackground),
        prop::option::of(fog).prop_map(Edit::SetFog),
        units().prop_map(Edit::SetUnits),
        Just(Edit::Append(Box::new(sample()))),
    ]
}

/// Other actions between edits.
#[allow(
    clippy::large_enum_variant,
    reason = "there is one at a time, so its size does not matter"
)]
#[derive(Clone, Debug)]
enum TestAction {
    Edit(Edit, Option<u64>),
    Undo,
    Redo,
    Select(Selection),
}

fn act() -> impl Strategy<Value = TestAction> {
    let faces = prop::option::of((id(), prop::collection::vec(0..4u32, 0..3)));
    let selection =
        (ids(), faces, prop::option::of(0..6u32)).prop_map(|(ids, faces, material)| Selection {
            ids,
            faces,
            material,
        });
    prop_oneof![
        8 => (any_edit(), prop::option::of(0..2u64)).prop_map(|(e, gesture)| TestAction::Edit(e, gesture)),
        2 => Just(TestAction::Undo),
        1 => Just(TestAction::Redo),
        1 => selection.prop_map(TestAction::Select),
    ]
}

/// Invariants that hold at any time.
fn check_app(app: &App) {
    let scene = app.document.scene();
    let valid = scene.validate();
    assert!(valid.is_ok(), "{valid:?}");
    let selection = &app.selection;
    assert!(
        selection.ids.iter().all(|&id| app.document.has(id)),
        "{selection:?}"
    );
    let materials = app.document.materials.len() as u32;
    assert!(
        selection.material.is_none_or(|m| m < materials),
        "{selection:?}"
    );
    if let Some((id, faces)) = &selection.faces {
        let item = app.document.object(*id).expect("faces of something");
        let Shape::Mesh(mesh) = &*item.shape else {
            panic!("faces of what has none: {selection:?}")
        };
        assert!(
            faces.iter().all(|&f| (f as usize) < mesh.faces.len()),
            "{selection:?}"
        );
    }
    let bounds = app.document.bounds(None);
    assert!(
        bounds == Aabb::EMPTY || bounds.min.is_finite() && bounds.max.is_finite(),
        "{bounds:?}"
    );
}

fn perform(app: &mut App, act: TestAction) {
    match act {
        TestAction::Undo => app.execute(Command::Undo),
        TestAction::Redo => app.execute(Command::Redo),
        TestAction::Select(selection) => app.execute(Command::Select(selection)),
        TestAction::Edit(edit, gesture) => {
            let (before, revision) = (app.document.clone(), app.revision());
            app.messages.clear();
            let is_idle = !edit.changes(&before);
            app.execute(Command::Edit(edit, gesture));
            let refused = !app.messages.is_empty();
            assert_eq!(refused || is_idle, app.revision() == revision);
            assert!(
                app.revision() != revision || app.document == before,
                "refused, and changed"
            );
        }
    }
}

fn undo_all(app: &mut App) -> usize {
    let mut steps = 0;
    while app.undo_labels().0.is_some() {
        app.execute(Command::Undo);
        check_app(app);
        steps += 1;
    }
    steps
}

proptest! {
    #[test]
    fn any_sequence_undone_gives_the_first_document_back(
        acts in prop::collection::vec(act(), 1..24)
    ) {
        let mut app = filled();
        let first = app.document.clone();
        let scene = first.scene();
        for act in acts {
            perform(&mut app, act);
            check_app(&app);
        }
        let mut last = app.document.clone();
        while app.undo_labels().1.is_some() {
            app.execute(Command::Redo);
            last = app.document.clone();
        }
        let steps = undo_all(&mut app);
        prop_assert!(app.document == first);
        prop_assert!(app.document.scene() == scene);
        prop_assert!(!app.is_changed());
        for _ in 0..steps {
            app.execute(Command::Redo);
        }
        prop_assert!(app.document == last);
        prop_assert_eq!(app.undo_labels().1, None);
    }
}

#[test]
fn a_gesture_is_one_step_however_many_edits_it_has() {
    let mut app = filled();
    let first = app.document.clone();
    for k in 0..10 {
        let shift = DAffine3::from_translation(DVec3::X * f64::from(k));
        let drag = Edit::Transform(vec![ItemId(3)], shift);
        app.execute(Command::Edit(drag, Some(4)));
    }
    edit(&mut app, Edit::Rename(ItemId(3), "marble".into()));
    assert_eq!(app.undo_labels().0, Some("rename"));
    app.execute(Command::Undo);
    assert_eq!(app.undo_labels().0, Some("move"));
    app.execute(Command::Undo);
    assert_eq!(app.document, first);
    assert_eq!(app.undo_labels(), (None, Some("move")));
}

#[test]
fn what_is_made_is_selected_and_undo_selects_what_was() {
    let mut app = filled();
    app.execute(Command::Select(Selection::one(ItemId(3))));
    assert_eq!(app.selection.material, Some(1));
    edit(&mut app, Edit::Duplicate(vec![ItemId(3)]));
    let copy = app.selection.ids[0];
    assert_eq!(app.document.name(copy), Some("ball 2"));
    app.execute(Command::Undo);
    assert_eq!(app.selection.ids, [ItemId(3)]);
    app.execute(Command::SelectAll);
    assert_eq!(app.selection.ids, (1..=6).map(ItemId).collect::<Vec<_>>());
}

/// A floor of more than ten thousand vertices.
fn large() -> App {
    let mut app = filled();
    let Shape::Mesh(mesh) = &*app.document.objects[0].shape else {
        panic!("the floor is a mesh")
    };
    let mut mesh = mesh.clone();
    mesh.positions.resize(10_000, DVec3::ZERO);
    edit(
        &mut app,
        Edit::SetShape(ItemId(1), Arc::new(Shape::Mesh(mesh))),
    );
    app
}

fn count_undo(app: &mut App) -> usize {
    let mut steps = 0;
    while app.undo_labels().0.is_some() {
        app.execute(Command::Undo);
        steps += 1;
    }
    steps
}

#[test]
fn undo_holds_twice_a_large_document_and_forgets_the_rest() {
    let mut app = large();
    app.undo_bytes = 1_000;
    for k in 0..60 {
        edit(&mut app, Edit::AssignFaces(ItemId(1), vec![0], k % 2));
        // Each of them copies the floor.
        assert!(app.history.bytes() <= 5 * app.document.bytes());
    }
    assert!(app.history.bytes() > 240_000, "{}", app.history.bytes());
    assert_eq!(count_undo(&mut app), 4);

    // With enough memory all steps are kept.
    let mut app = large();
    for k in 0..60 {
        edit(&mut app, Edit::AssignFaces(ItemId(1), vec![0], k % 2));
    }
    assert!((60 * 240_000..61 * 260_000).contains(&app.history.bytes()));
    assert_eq!(count_undo(&mut app), 61);
}

#[test]
fn a_step_holds_the_objects_that_it_changes() {
    let mut app = filled();
    for _ in 0..9 {
        let ids = app.document.objects.iter().map(|i| i.id).collect();
        edit(&mut app, Edit::Duplicate(ids));
    }
    let count = app.document.objects.len() as u64;
    assert_eq!(count, 2_048);
    app.execute(Command::Select(Selection::one(ItemId(3))));
    let before = app.history.bytes();
    for k in 0..100 {
        let by = DVec3::X * f64::from(k);
        let drag = DAffine3::from_translation(by);
        edit(&mut app, Edit::Transform(vec![ItemId(3)], drag));
    }
    let step = (app.history.bytes() - before) / 100;
    // A pointer for each object, and one object.
    assert!(step < 8 * count + 1_000, "{step} bytes");
}

#[test]
fn what_changes_nothing_is_no_step() {
    let mut app = filled();
    edit(
        &mut app,
        Edit::Hide(vec![ItemId(1), ItemId(5), ItemId(6)], false),
    );
    edit(&mut app, Edit::Hide(vec![ItemId(99)], true));
    edit(&mut app, Edit::Rename(ItemId(3), "ball ".into()));
    assert_eq!(app.undo_labels().0, None);
    assert!(!app.is_changed());
    check_no_error(&app);
    edit(
        &mut app,
        Edit::Hide(vec![ItemId(1), ItemId(5), ItemId(6)], true),
    );
    assert_eq!(app.document.hidden(), [1, 5, 6].map(ItemId));
    assert!(app.document.has_light() && app.document.scene().lights.len() == 1);
    app.execute(Command::Undo);
    assert!(app.document.hidden().is_empty());
}

#[test]
fn faces_of_another_shape_are_not_selected_any_more() {
    let mut app = filled();
    app.execute(Command::Select(Selection {
        faces: Some((ItemId(1), vec![0, 1])),
        ..Selection::one(ItemId(1))
    }));
    assert!(app.selection.faces.is_some());
    let ball = Primitive::sphere(DVec3::ZERO, 1.0, 0);
    edit(
        &mut app,
        Edit::SetShape(ItemId(1), Arc::new(Shape::Primitive(ball))),
    );
    assert_eq!(app.selection.faces, None);
}

#[test]
fn letters_are_added_and_nonsense_is_told() {
    let mut app = filled();
    let text = |text: &str, size: f64, font: Option<PathBuf>| Command::AddText {
        text: text.into(),
        size,
        depth: 0.2,
        font,
    };
    app.execute(text("Olé", 1.0, None));
    check_no_error(&app);
    assert_eq!(app.document.objects.last().unwrap().name, "Olé");
    check_app(&app);
    app.execute(text("a", -1.0, None));
    app.execute(text("a", 1.0, Some("/nowhere/font.ttf".into())));
    app.execute(text("a", 1.0, Some(example("cornell.grf"))));
    assert_eq!(errors(&app).len(), 3, "{:?}", app.messages);
    assert_eq!(app.document.objects.len(), 5);
}

#[test]
fn a_view_without_direction_is_not_taken() {
    let mut app = filled();
    let good = app.view.clone();
    let mut bad = good.clone();
    bad.camera.eye = bad.camera.target;
    app.execute(Command::SetView(Box::new(bad)));
    assert_eq!(app.view, good);
}

/// The sample with two more materials: one used by a sphere, one unused.
fn with_materials() -> App {
    let mut app = filled();
    for name in ["spare", "used"] {
        edit(
            &mut app,
            Edit::AddMaterial(Material::diffuse(name, Rgb::WHITE)),
        );
    }
    let used = (app.document.materials.len() - 1) as u32;
    edit(&mut app, Edit::Assign(vec![ItemId(3)], used));
    app
}

fn number_of(app: &App, name: &str) -> u32 {
    let mut materials = app.document.materials.iter();
    materials.position(|m| m.name == name).unwrap() as u32
}

fn material_of(app: &App, id: ItemId) -> &str {
    let material = app.document.object(id).unwrap().materials()[0];
    &app.document.materials[material as usize].name
}

#[test]
fn a_material_goes_and_those_behind_it_move_up() {
    let mut app = with_materials();
    let (spare, used) = (number_of(&app, "spare"), number_of(&app, "used"));
    app.execute(Command::Select(Selection {
        material: Some(used),
        ..Selection::default()
    }));
    let before = app.document.clone();
    edit(&mut app, Edit::DeleteMaterial(spare));
    check_no_error(&app);
    check_app(&app);
    assert_eq!(app.document.materials.len(), before.materials.len() - 1);
    assert_eq!(material_of(&app, ItemId(3)), "used");
    assert_eq!(app.selection.material, Some(used - 1), "still the same one");
    app.execute(Command::Undo);
    assert_eq!(app.document, before);
    assert_eq!(app.selection.material, Some(used));
    app.execute(Command::Redo);
    assert_eq!(app.selection.material, Some(used - 1));
}

#[test]
fn a_material_that_is_used_stays_and_it_is_said_by_whom() {
    let mut app = with_materials();
    let used = number_of(&app, "used");
    let before = app.document.clone();
    edit(&mut app, Edit::DeleteMaterial(used));
    assert_eq!(app.document, before);
    assert_eq!(errors(&app), ["the material \"used\" is used by \"ball\""]);
    edit(&mut app, Edit::DeleteMaterial(99));
    assert_eq!(errors(&app).len(), 2);
}

#[test]
fn copies_of_a_shape_share_it_after_materials_went() {
    let mut app = with_materials();
    edit(&mut app, Edit::Duplicate(vec![ItemId(3)]));
    let copy = app.selection.ids[0];
    edit(&mut app, Edit::DeleteUnusedMaterials);
    check_no_error(&app);
    check_app(&app);
    let used = app.document.used_materials();
    assert_eq!(used.len(), app.document.materials.len());
    let shape = |id| &app.document.object(id).unwrap().shape;
    assert!(Arc::ptr_eq(shape(ItemId(3)), shape(copy)));
    assert_eq!(material_of(&app, copy), "used");
    edit(&mut app, Edit::DeleteUnusedMaterials);
    assert_eq!(errors(&app), ["every material is used"]);
}

#[test]
fn undo_names_what_it_is_about() {
    let mut app = App::quiet();
    run(&mut app, Command::Open(vec![example("shapes.grf")]));
    settle(&mut app);
    let find = |app: &App, name: &str| {
        let mut objects = app.document.objects.iter();
        objects.find(|o| o.name.ends_with(name)).unwrap().id
    };
    let undone = |app: &App| app.undo_texts().0.unwrap();
    let (column, cone) = (find(&app, "column"), find(&app, "cone"));
    let shift = DAffine3::from_translation(DVec3::X);
    edit(&mut app, Edit::Transform(vec![column], shift));
    assert_eq!(undone(&app), "move “column”");
    edit(&mut app, Edit::Rename(column, "pillar".into()));
    assert_eq!(undone(&app), "rename “column”");
    edit(&mut app, Edit::Transform(vec![column, cone], shift));
    assert_eq!(undone(&app), "move");
    edit(&mut app, Edit::Delete(vec![cone]));
    assert_eq!(undone(&app), "delete “cone”");
    run(&mut app, Command::AddLight(NewLightKind::Sun));
    assert_eq!(undone(&app), "add a light “sun”");
    let mut wall = Material::clone(&app.document.materials[1]);
    wall.diffuse = Rgb::grey(0.1);
    edit(&mut app, Edit::SetMaterial(1, wall));
    assert_eq!(undone(&app), "change a material “wall”");
    app.preferences.language = crate::words::Language::Spanish;
    assert_eq!(undone(&app), "modificar un material «wall»");
    run(&mut app, Command::Undo);
    let (undo, redo) = app.undo_texts();
    assert_eq!(undo.unwrap(), "añadir una luz «sun»");
    assert_eq!(redo.unwrap(), "modificar un material «wall»");
}
