//! Light from outside in the panel: suns, skies and pictures of the surroundings.

use crate::window::*;
use azulejo::scene::sky::{Sky, SkyDistribution};
use azulejo::scene::{EnvironmentSource, LightKind};
use azulejo_workbench::app::App;
use azulejo_workbench::command::{Command, FileRequest};
use azulejo_workbench::document::{NewLightKind, NewShapeKind};
use egui::accesskit::Role;
use egui::{Key, Modifiers};

fn with_light(kind: NewLightKind) -> TestWindow {
    let mut app = App::quiet();
    app.execute(Command::AddShape(NewShapeKind::Cuboid));
    app.execute(Command::AddLight(kind));
    window(app)
}

fn kind(window: &TestWindow) -> LightKind {
    window.state().app.document.lights[0].light.kind.clone()
}

fn sky(window: &TestWindow) -> Sky {
    match kind(window) {
        LightKind::Environment(environment) => match environment.source {
            EnvironmentSource::Sky(sky) => sky,
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_sun_has_its_place_by_the_compass_and_its_size() {
    let mut window = with_light(NewLightKind::Sun);
    set(&mut window, "Azimuth", 90.0);
    set(&mut window, "Elevation", 30.0);
    set(&mut window, "Irradiance", 800.0);
    set(&mut window, "Angular size", 2.0);
    let LightKind::Directional {
        direction,
        irradiance,
        half_angle,
    } = kind(&window)
    else {
        panic!("a sun is a directional light")
    };
    // It stands in the east, at +x, half as high as far.
    assert!((direction.x + 0.75f64.sqrt()).abs() < 1e-9 && (direction.y + 0.5).abs() < 1e-9);
    assert!((irradiance.max_channel() - 800.0).abs() < 1e-3);
    assert!((half_angle.to_degrees() - 1.0).abs() < 1e-9);
    click(&mut window, "Use clear-sky irradiance");
    let (_, clear) = window.state().app.document.first_sun().unwrap();
    assert!((400.0..600.0).contains(&clear), "{clear}");
    press(&mut window, Modifiers::COMMAND, Key::Z);
    let (_, again) = window.state().app.document.first_sun().unwrap();
    assert!((again - 800.0).abs() < 1e-3);
    check_no_error(&window);
}

#[test]
fn a_sky_has_a_type_a_sun_and_a_brightness() {
    let mut window = with_light(NewLightKind::Sky);
    find(&window, Role::ComboBox, "Type of sky").click();
    window.run();
    click_last(&mut window, "CIE 1: overcast");
    let SkyDistribution::Cie(kind) = sky(&window).distribution else {
        panic!("a CIE sky")
    };
    assert_eq!(kind.number(), 1);
    set(&mut window, "Horizontal irradiance", 120.0);
    set(&mut window, "Ground reflectance", 0.5);
    let overcast = sky(&window);
    assert!((overcast.diffuse_horizontal() - 120.0).abs() < 1e-6);
    assert!((overcast.ground - 0.5 * 120.0 / std::f64::consts::PI).abs() < 1e-6);
    set(&mut window, "Elevation of the sun", 90.0);
    assert!(sky(&window).toward_sun.z > 1.0 - 1e-12);
    click(&mut window, "Use typical irradiance");
    // At the zenith the types of overcast skies have 8.7 kcd/m².
    let zenith = sky(&window).radiance(glam::DVec3::Z);
    assert!((zenith * 179.0 - 8_723.0).abs() < 1.0, "{zenith}");
    check_no_error(&window);
}

#[test]
fn a_sky_is_made_of_weather_and_put_around_the_sun() {
    let mut window = with_light(NewLightKind::Sky);
    set(&mut window, "Direct normal irradiance", 500.0);
    set(&mut window, "Diffuse horizontal irradiance", 180.0);
    click(&mut window, "Create sky from weather");
    assert!(matches!(
        sky(&window).distribution,
        SkyDistribution::Perez(_)
    ));
    assert!(says(&window, "From weather (Perez)"));
    set(&mut window, "Azimuth of the sun", 10.0);
    let app = &mut window.state_mut().app;
    let sky_id = app.document.lights[0].id;
    app.execute(Command::AddLight(NewLightKind::Sun));
    app.execute(Command::Select(azulejo_workbench::command::Selection::one(
        sky_id,
    )));
    window.run();
    set(&mut window, "Azimuth of the sun", 200.0);
    click(&mut window, "Align with sun");
    let place = sky(&window).toward_sun;
    let azimuth = place.x.atan2(place.y).to_degrees();
    assert!((azimuth - 10.0).abs() < 1e-6, "{azimuth}");
    check_no_error(&window);
}

#[test]
fn looking_at_a_sky_changes_nothing() {
    let mut window = with_light(NewLightKind::Sky);
    let before = sky(&window);
    for label in [
        "Azimuth of the sun",
        "Elevation of the sun",
        "Horizontal irradiance",
        "Ground reflectance",
        "Dew point",
    ] {
        find(&window, Role::SpinButton, label).focus();
        window.run();
        press(&mut window, Modifiers::NONE, Key::Enter);
    }
    assert_eq!(sky(&window), before);
}

#[test]
fn the_menu_asks_for_a_picture_and_offers_a_studio() {
    let mut app = App::quiet();
    app.execute(Command::AddShape(NewShapeKind::Cuboid));
    let mut window = window(app);
    click(&mut window, "Add");
    click(&mut window, "Studio");
    let document = &window.state().app.document;
    assert!(document.has_light() && document.objects.len() == 5);
    click(&mut window, "Add");
    click(&mut window, "Environment map…");
    let asking = window.state().app.asking;
    assert_eq!(asking, Some(FileRequest::Environment(None)));
}
