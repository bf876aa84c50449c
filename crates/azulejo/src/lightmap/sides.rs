//! Which sides of surfaces have a lightmap.

use azulejo_bake::layout::NO_CHART;
use azulejo_bake::{Atlas, Receiver, Samples};
use azulejo_radiosity::SolvedLight;
use azulejo_radiosity::sites::SiteLight;
use azulejo_scene::{Rgb, Scene, Sidedness};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, GatherPoint};
use glam::DVec3;

/// Light of a side relative to that of the other up to which it is what patches leak.
const DARK: f64 = 0.01;

/// How much brighter a back must be to be taken: what the order of corners says counts where both sides are lit,
/// as the floor of a building whose underside sees the ground.
const CLEARLY: f64 = 2.0;

/// Difference of the light of two sides, relative to the brighter, above which it is reported.
const DIFFERING: f64 = 0.1;

/// The receivers whose backs somebody may see, with their objects: those outside of solids, and those that get
/// light, in rooms whose fronts are outside.
pub fn lit_backs(
    receivers: &[Receiver],
    objects: &[u32],
    scene: &Scene,
    solved: &SolvedLight,
) -> Vec<(Receiver, u32)> {
    let inside = azulejo_bake::backs_inside(scene);
    let mut backs = Vec::new();
    for (receiver, &object) in receivers.iter().zip(objects) {
        let is_dark = |place: [u32; 3]| {
            let [front, back] = solved.sides_at(place, [1.0 / 3.0; 2]);
            back.mean() <= DARK * front.mean()
        };
        let materials = scene.objects[object as usize].shape.mesh();
        let materials = materials.map_or(&[][..], |mesh| &mesh.face_materials);
        let is_omitted = |[face, triangle]: [u32; 2]| {
            let material = &scene.materials[materials[face as usize] as usize];
            let is_inside = inside[object as usize][face as usize];
            // Glass has no sides that could be told apart, a face of its own would shine as a lamp does, and some
            // files say that backs are not seen.
            material.dielectric.is_some()
                || material.is_emitter()
                || material.sidedness == Sidedness::One
                || (is_inside && is_dark([object, face, triangle]))
        };
        let faces = face_triangles(scene, object).into_iter();
        let omitted: Vec<bool> = faces.map(is_omitted).collect();
        let back = Receiver {
            omitted,
            ..receiver.clone()
        };
        if back.visible_triangles().contains(&true) {
            backs.push((back, object));
        }
    }
    backs
}

/// Share of the area of receivers that is seen from both sides, whose light differs by more than
/// [`DIFFERING`]: a lightmap of one side is wrong on the other. A side without light does not count: nobody is there,
/// as outside of a room of single sheets.
pub fn differing_share(
    receivers: &[Receiver],
    objects: &[u32],
    scene: &Scene,
    solved: &SolvedLight,
) -> f64 {
    let inside = azulejo_bake::backs_inside(scene);
    let (mut differing, mut all) = (0.0, 0.0);
    for (receiver, &object) in receivers.iter().zip(objects) {
        let materials = scene.objects[object as usize].shape.mesh();
        let materials = materials.map_or(&[][..], |mesh| &mesh.face_materials);
        let faces = face_triangles(scene, object);
        for (t, [face, triangle]) in faces.into_iter().enumerate() {
            let area = receiver.area_vector(t).length();
            all += area;
            let material = &scene.materials[materials[face as usize] as usize];
            let is_inside = inside[object as usize][face as usize];
            if is_inside || material.dielectric.is_some() || material.sidedness == Sidedness::One {
                continue;
            }
            let sides = solved.sides_at([object, face, triangle], [1.0 / 3.0; 2]);
            let [front, back] = sides.map(Rgb::mean);
            let brighter = front.max(back);
            let has_both = front.min(back) > DARK * brighter;
            if has_both && (front - back).abs() > DIFFERING * brighter {
                differing += area;
            }
        }
    }
    differing / f64::max(all, f64::MIN_POSITIVE)
}

/// Light of the patches under some of the samples, and of these samples themselves, W: what both say of the same
/// places should be the same.
pub fn power_beside_patches(
    atlas: &Atlas,
    objects: &[u32],
    scene: &Scene,
    solved: &SolvedLight,
    (samples, light): (&Samples, &[SiteLight]),
) -> [f64; 2] {
    let faces: Vec<Vec<[u32; 2]>> = objects.iter().map(|&o| face_triangles(scene, o)).collect();
    let (mut patches, mut texels) = (0.0, 0.0);
    for (sample, light) in samples.samples.iter().zip(light).step_by(EVERY) {
        let receiver = sample.of.receiver as usize;
        let [face, triangle] = faces[receiver][sample.of.triangle as usize];
        let sides = solved.sides_at([objects[receiver], face, triangle], sample.uv);
        let chart = atlas.layout.receivers[receiver].charts[sample.of.triangle as usize];
        let of_patch = sides[usize::from(atlas.is_turned(chart))].mean();
        // The solution has no sides that other surfaces do not see.
        if of_patch <= 0.0 {
            continue;
        }
        let area = f64::from(sample.area * sample.free);
        patches += area * of_patch;
        texels += area * f64::from(light.irradiance.iter().sum::<f32>()) / 3.0;
    }
    [patches, texels]
}

/// Of this many samples one is compared with patches.
const EVERY: usize = 8;

/// Of each chart whether its back gets more light. Lamps keep their fronts, from which they shine.
///
/// # Errors
/// The caller cancelled.
pub fn turned(
    atlas: &Atlas,
    objects: &[u32],
    scene: &Scene,
    solved: &SolvedLight,
) -> Result<Vec<bool>, Cancelled> {
    let mut excess = vec![0.0; atlas.layout.charts as usize];
    let (mut unseen, mut of_charts) = (Vec::new(), Vec::new());
    for (r, receiver) in atlas.receivers.iter().enumerate() {
        let mesh = scene.objects[objects[r] as usize].shape.mesh();
        let shines = |face: u32| {
            let material = mesh.map(|mesh| mesh.face_materials[face as usize]);
            material.is_some_and(|m| scene.materials[m as usize].is_emitter())
        };
        let faces = face_triangles(scene, objects[r]);
        for (t, [face, triangle]) in faces.into_iter().enumerate() {
            let chart = atlas.layout.receivers[r].charts[t];
            if chart == NO_CHART || shines(face) {
                continue;
            }
            let [front, back] = solved.sides_at([objects[r], face, triangle], [1.0 / 3.0; 2]);
            let vector = receiver.area_vector(t);
            let area = vector.length();
            excess[chart as usize] += area * (back - front * CLEARLY).mean();
            // The solution has no sides that other surfaces do not see, nor any that there was no time for: lights may
            // shine on them all the same.
            for (side, weight, light) in [(1.0, -CLEARLY, front), (-1.0, 1.0, back)] {
                if light.is_black() {
                    unseen.push(GatherPoint {
                        position: receiver.corners(t).iter().sum::<DVec3>() / 3.0,
                        normal: side * vector.normalize_or(DVec3::Z),
                        key: hash(&[r as u32, t as u32]),
                    });
                    of_charts.push((chart, weight * area));
                }
            }
        }
    }
    let direct = solved.direct_at(&unseen)?;
    for ((chart, weight), light) in of_charts.into_iter().zip(direct) {
        excess[chart as usize] += weight * light.mean();
    }
    Ok(excess.into_iter().map(|e| e > 0.0).collect())
}

/// For each triangle of a receiver its face, and its number in the face.
fn face_triangles(scene: &Scene, object: u32) -> Vec<[u32; 2]> {
    let mesh = scene.objects[object as usize].shape.mesh();
    let faces = mesh.map_or(0, |mesh| mesh.faces.len());
    let of_face = |face: usize| {
        let count = mesh.map_or(0, |mesh| mesh.faces.get(face).len() - 2);
        (0..count as u32).map(move |triangle| [face as u32, triangle])
    };
    (0..faces).flat_map(of_face).collect()
}
