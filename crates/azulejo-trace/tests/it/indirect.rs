//! Indirect light alone, against that beside direct light.

use azulejo_scene::Rgb;
use azulejo_scene::synthetic::{CornellVariant, cornell_box};
use azulejo_trace::{
    DiffuseHit, DiffuseLight, DirectionTables, GatherOptions, GatherPoint, Gathered, Gatherer,
    OutgoingRadiosity, Surfaces, Termination, Tracer,
};
use glam::DVec3;

/// A radiosity that is the same everywhere, if it is known.
struct Even {
    radiosity: Option<f32>,
}

impl DiffuseLight for Even {
    fn outgoing(&self, _: &DiffuseHit, _: usize) -> OutgoingRadiosity {
        OutgoingRadiosity {
            radiosity: [self.radiosity.unwrap_or(0.0); 3],
            footprint: 0.0,
        }
    }

    fn reflectance(&self, _: &DiffuseHit) -> Rgb {
        Rgb::grey(0.5)
    }

    fn is_unknown(&self) -> bool {
        self.radiosity.is_none()
    }
}

/// Indirect light of points on the floor, gathered beside direct light and alone.
fn both(light: &Even, termination: Termination, rays: u32) -> [Vec<Gathered>; 2] {
    let scene = cornell_box(CornellVariant::Diffuse);
    let tracer = Tracer::new(&scene);
    let gatherer = Gatherer::new(Surfaces::new(&scene, &tracer));
    let point = |key: u32| GatherPoint {
        position: DVec3::new(40.0 + 60.0 * f64::from(key), 0.1, 40.0),
        normal: DVec3::Y,
        key,
    };
    let points: Vec<GatherPoint> = (0..8).map(point).collect();
    let options = GatherOptions {
        rays,
        spent: 0,
        seed: 3,
        termination,
    };
    let directions = DirectionTables::new(&options);
    let split = gatherer.gather_with(&points, &options, &directions, light);
    let alone = gatherer.gather_indirect(&points, &options, &directions, light);
    [split.iter().map(|s| s.indirect).collect(), alone]
}

#[test]
fn it_is_the_same_beside_direct_light_and_alone() {
    for (radiosity, termination) in [
        (Some(2.0), Termination::Radiosity),
        (None, Termination::Roulette),
        (None, Termination::Bounces(3)),
    ] {
        let [beside, alone] = both(&Even { radiosity }, termination, 64);
        assert_eq!(beside, alone, "{termination:?}");
        assert!(alone.iter().all(|g| g.mean().mean() > 0.0));
    }
}

#[test]
fn roulette_by_what_is_read_ends_other_paths_for_the_same_light() {
    // About as much as there is.
    let light = Even {
        radiosity: Some(0.1),
    };
    let [beside, alone] = both(&light, Termination::Roulette, 1 << 14);
    for (a, b) in beside.iter().zip(&alone) {
        let off = (a.mean() - b.mean()).mean().abs();
        // Both take the same directions, so that they differ by less than their errors.
        let error = a.standard_error().mean().hypot(b.standard_error().mean());
        assert!(off <= 3.0 * error, "{a:?} {b:?}");
        assert!(error < 0.05 * a.mean().mean(), "{error} {a:?}");
    }
}
