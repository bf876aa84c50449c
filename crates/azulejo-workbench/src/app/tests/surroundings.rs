//! Light from outside, by commands.

use super::*;
use crate::document::{NewLightKind, NewShapeKind};
use azulejo::formats::picture::hdr;
use azulejo::scene::sky::{PerezWeather, SkyDistribution, SunPosition};
use azulejo::scene::{Environment, EnvironmentSource, Light, LightKind, Projection, Rgb};
use azulejo::surroundings::GROUND_REFLECTANCE;
use glam::DVec3;
use std::f64::consts::PI;

/// An app with a box, a sun and a sky; the ids of the sun and of the sky.
fn daylight() -> (App, [ItemId; 2]) {
    let mut app = App::quiet();
    app.execute(Command::AddShape(NewShapeKind::Cuboid));
    app.execute(Command::AddLight(NewLightKind::Sun));
    app.execute(Command::AddLight(NewLightKind::Sky));
    check_no_error(&app);
    let ids = [0, 1].map(|k| app.document.lights[k].id);
    (app, ids)
}

fn environment(app: &App, id: ItemId) -> Environment {
    match app.document.light(id).map(|l| l.light.kind.clone()) {
        Some(LightKind::Environment(environment)) => environment,
        other => panic!("{other:?} is not an environment"),
    }
}

fn sky(app: &App, id: ItemId) -> azulejo::scene::sky::Sky {
    match environment(app, id).source {
        EnvironmentSource::Sky(sky) => sky,
        other => panic!("{other:?} is not a sky"),
    }
}

fn reflectance(app: &App, id: ItemId) -> f64 {
    let environment = environment(app, id);
    let settings = app.document.sky_settings(&environment, &sky(app, id));
    settings.reflectance
}

/// Moves the sun and sets its irradiance.
fn set_sun(app: &mut App, id: ItemId, [azimuth, elevation]: [f64; 2], irradiance: f64) {
    let mut light = app.document.light(id).unwrap().light.clone();
    let toward = app.document.toward(SunPosition {
        azimuth: azimuth.to_radians(),
        altitude: elevation.to_radians(),
    });
    if let LightKind::Directional {
        direction,
        irradiance: e,
        ..
    } = &mut light.kind
    {
        (*direction, *e) = (-toward, Rgb::grey(irradiance));
    }
    edit(app, Edit::SetLight(id, light));
}

#[test]
fn a_sky_is_made_around_the_sun_and_goes_with_it() {
    let (mut app, [sun, sky_id]) = daylight();
    let toward = app.document.first_sun().unwrap().0;
    let local = |app: &App, toward| environment(app, sky_id).to_local(toward);
    assert!(sky(&app, sky_id).toward_sun.distance(local(&app, toward)) < 1e-9);
    let before = sky(&app, sky_id).diffuse_horizontal();
    set_sun(&mut app, sun, [90.0, 20.0], 700.0);
    // East is +x in every scene.
    let east = sky(&app, sky_id).toward_sun;
    assert!(east.x > 0.9 && (east.z - 20f64.to_radians().sin()).abs() < 1e-9);
    let after = sky(&app, sky_id).diffuse_horizontal();
    assert!((after / before - 1.0).abs() < 1e-9, "as bright as before");
    app.execute(Command::Undo);
    assert!(sky(&app, sky_id).toward_sun.distance(local(&app, toward)) < 1e-9);
    check_no_error(&app);
}

#[test]
fn a_sky_replaces_the_background_that_would_hide_it() {
    let mut app = filled();
    let before = app.document.background;
    assert!(before.is_some());
    app.execute(Command::AddLight(NewLightKind::Sun));
    assert_eq!(app.document.background, before);
    app.execute(Command::AddLight(NewLightKind::Sky));
    assert_eq!(app.document.background, None);
    app.execute(Command::Undo);
    assert_eq!(app.document.background, before);
}

#[test]
fn a_sky_that_stands_elsewhere_stays_where_it_is() {
    let (mut app, [sun, sky_id]) = daylight();
    let apart = sky(&app, sky_id).with_sun(DVec3::new(0.0, 0.6, 0.8));
    let kind = LightKind::Environment(Environment {
        source: EnvironmentSource::Sky(apart),
        ..environment(&app, sky_id)
    });
    let name = "sky".into();
    edit(&mut app, Edit::SetLight(sky_id, Light { name, kind }));
    set_sun(&mut app, sun, [90.0, 20.0], 700.0);
    assert_eq!(sky(&app, sky_id).toward_sun, apart.toward_sun);
}

#[test]
fn the_ground_keeps_its_reflectance_whatever_becomes_of_the_sun() {
    let (mut app, [sun, sky_id]) = daylight();
    let check = |app: &App| {
        let ground = reflectance(app, sky_id);
        assert!((ground - GROUND_REFLECTANCE).abs() < 1e-9, "{ground}");
    };
    check(&app);
    set_sun(&mut app, sun, [120.0, 60.0], 900.0);
    check(&app);
    edit(&mut app, Edit::Delete(vec![sun]));
    check(&app);
    let diffuse = sky(&app, sky_id).diffuse_horizontal();
    let ground = sky(&app, sky_id).ground;
    assert!((ground - GROUND_REFLECTANCE * diffuse / PI).abs() < 1e-9);
    check_no_error(&app);
}

#[test]
fn a_sky_that_is_switched_off_keeps_its_brightness() {
    let (app, [_, id]) = daylight();
    let dark = Environment {
        scale: Rgb::BLACK,
        ..environment(&app, id)
    };
    let old = sky(&app, id);
    let settings = app.document.sky_settings(&dark, &old);
    let new = app.document.sky_of(&dark, &settings);
    assert!((new.diffuse_horizontal() / old.diffuse_horizontal() - 1.0).abs() < 1e-9);
    assert!((new.ground / old.ground - 1.0).abs() < 1e-9);
}

#[test]
fn weather_makes_a_sky_and_its_sun() {
    let (mut app, [sun, sky_id]) = daylight();
    let (toward, clear) = app.document.first_sun().unwrap();
    let weather = PerezWeather {
        dni: 300.0,
        dhi: 200.0,
        sun_altitude: app.document.compass(toward).altitude,
        day_of_year: 100,
        dew_point: 11.0,
    };
    edit(&mut app, Edit::SetWeather(sky_id, weather));
    check_no_error(&app);
    let made = sky(&app, sky_id);
    assert!(matches!(made.distribution, SkyDistribution::Perez(_)));
    let watts = weather.diffuse_illuminance() / 179.0;
    assert!((made.diffuse_horizontal() / watts - 1.0).abs() < 1e-6);
    let dimmed = app.document.first_sun().unwrap().1;
    assert!(dimmed < 0.7 * clear, "{dimmed} of {clear}");
    assert!((reflectance(&app, sky_id) - GROUND_REFLECTANCE).abs() < 1e-9);
    app.execute(Command::Undo);
    assert_eq!(app.document.first_sun().unwrap().1, clear, "one step");

    edit(&mut app, Edit::SetWeather(sun, weather));
    check_error(&app, "neither a sky nor a picture");
    let dark = PerezWeather {
        dni: -1.0,
        ..weather
    };
    let before = app.revision();
    edit(&mut app, Edit::SetWeather(sky_id, dark));
    assert_eq!(app.revision(), before);
}

/// An equirectangular picture of a grey sky with a sun of four pixels.
fn write_picture(path: &Path) {
    let (width, height) = (512, 256);
    let pixel = |k: u32| {
        let (x, y) = (k % width, k / width);
        if (300..302).contains(&x) && (60..62).contains(&y) {
            [40_000.0; 3]
        } else {
            [0.5; 3]
        }
    };
    let image = Image::opaque(width, height, (0..width * height).map(pixel).collect());
    let mut bytes = Vec::new();
    hdr::write(&image, &mut bytes).unwrap();
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn a_picture_is_loaded_dimmed_changed_and_saved() {
    let folder = TestFolder::new("environment");
    let (first, second) = (folder.path("a.hdr"), folder.path("b.hdr"));
    write_picture(&first);
    write_picture(&second);
    let mut app = App::quiet();
    app.execute(Command::AddShape(NewShapeKind::Cuboid));
    run(&mut app, Command::LoadEnvironment(first, None));
    check_no_error(&app);
    let id = app.selection.ids[0];
    assert_eq!(environment(&app, id).texture(), Some(0));
    // Numbers of a picture can be changed like those of any light.
    let up = app.document.units.up;
    let turned = Environment {
        scale: Rgb::grey(2.0),
        ..environment(&app, id).with_north(up, 1.0)
    };
    let kind = LightKind::Environment(turned);
    let name = "outside".into();
    edit(&mut app, Edit::SetLight(id, Light { name, kind }));
    run(&mut app, Command::LoadEnvironment(second, Some(id)));
    check_no_error(&app);
    let now = environment(&app, id);
    assert_eq!((now.texture(), now.scale), (Some(1), Rgb::grey(2.0)));
    assert!((now.north(up) - 1.0).abs() < 1e-9, "its turn stays");
    let saved = folder.path("lit.grf");
    run(&mut app, Command::SaveAs(saved.clone()));
    run(&mut app, Command::Open(vec![saved]));
    check_no_error(&app);
    let id = app.document.lights[0].id;
    assert_eq!(environment(&app, id).scale, Rgb::grey(2.0));
}

#[test]
fn the_sun_of_a_picture_becomes_a_light_in_one_step() {
    let folder = TestFolder::new("extracted");
    let path = folder.path("sun.hdr");
    write_picture(&path);
    let mut app = App::quiet();
    app.execute(Command::AddShape(NewShapeKind::Cuboid));
    run(&mut app, Command::LoadEnvironment(path, None));
    let id = app.selection.ids[0];
    edit(&mut app, Edit::ExtractSun(id));
    check_no_error(&app);
    let (toward, irradiance) = app.document.first_sun().unwrap();
    let expected = Projection::Equirectangular.direction(301.0 / 512.0, 61.0 / 256.0);
    let direction = environment(&app, id).to_local(toward);
    assert!(direction.angle_between(expected) < 0.01, "{direction}");
    assert!(irradiance > 1.0);
    // Once more there is none.
    edit(&mut app, Edit::ExtractSun(id));
    check_error(&app, "times the median");
    app.execute(Command::Undo);
    assert_eq!(app.document.first_sun(), None);
    assert_eq!(environment(&app, id).texture(), Some(0));
}

#[test]
fn what_is_no_picture_of_the_surroundings_is_refused() {
    let mut app = App::quiet();
    let before = app.revision();
    run(
        &mut app,
        Command::LoadEnvironment(example("cornell.grf"), None),
    );
    check_error(&app, "holds no radiance");
    assert_eq!(app.revision(), before);
}

#[test]
fn a_studio_is_for_a_model_in_which_nothing_shines() {
    let mut app = App::quiet();
    edit(&mut app, Edit::AddStudio);
    check_error(&app, "no model");
    app.execute(Command::AddShape(NewShapeKind::Sphere));
    edit(&mut app, Edit::AddStudio);
    assert!(app.document.has_light());
    assert_eq!(app.document.objects.len(), 5, "a floor and three lamps");
    assert_eq!(app.document.cameras.len(), 1);
    app.document.scene().validate().unwrap();
    app.execute(Command::Undo);
    assert_eq!(app.document.objects.len(), 1);
    app.execute(Command::AddLight(NewLightKind::Point));
    edit(&mut app, Edit::AddStudio);
    assert!(errors(&app)[1].contains("light of its own"));
}
