//! Objects that are turned inside out, judged by what their sides see of the others.
//!
//! Form factors count light between fronts only: an object whose fronts look away from the others takes
//! no part in the exchange, and nothing in the matrix says why.

use crate::patch::{PatchSize, Patches};
use azulejo_scene::Scene;
use azulejo_scene::math::{Frame, Ray};
use azulejo_trace::sampling::{cosine_about, hash, uniform};
use azulejo_trace::{Cancelled, Progress, Tracer};
use rayon::prelude::*;

/// Rays from each side of an object.
const RAYS: u32 = 256;

/// A side that sees this many times as much as the other is the one that was meant.
const CLEARLY: u32 = 4;

/// Fewer hits than this prove nothing.
const FEW: u32 = 16;

/// What rays from one side of an object meet, of [`RAYS`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct SideCounts {
    /// Fronts and backs of other objects.
    others: [u32; 2],
    /// Fronts and backs of the object itself.
    own: [u32; 2],
    /// Nothing: sky or ground.
    free: u32,
}

/// What rays from front and back of an object meet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct FacingCounts {
    front: SideCounts,
    back: SideCounts,
}

/// What is probably turned inside out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum InsideOut {
    /// Nothing.
    Nothing,
    /// These objects, by their numbers: their backs see fronts of others or the sky, and their fronts hardly do.
    Objects(Vec<u32>),
    /// The whole scene: backs see backs, and fronts see nothing.
    Everything,
}

impl FacingCounts {
    /// Whether the object would see more if it were turned: its fronts see neither the sky nor fronts of others,
    /// which its backs do. Where fronts see backs, as of a roof that faces into its house, the sky behind counts, too.
    fn is_turned(&self) -> bool {
        let seen = self.front.others[0] + self.front.free;
        let is_hidden = self.front.others[1] + self.front.own[1] >= RAYS / 2;
        let behind = self.back.others[0] + if is_hidden { self.back.free } else { 0 };
        let least = if is_hidden { RAYS / 2 } else { FEW };
        behind >= least && behind > CLEARLY * seen
    }
}

/// Finds what is probably turned inside out, by 512 rays from each object.
///
/// An object counts as turned if its backs see at least four times as much of other objects' fronts as its
/// fronts do of these and of the sky; the scene does if its fronts see nothing while its backs see backs. A single body in empty space
/// cannot be told from an empty room: both are `Everything`.
///
/// # Errors
/// [`Cancelled`].
pub fn inside_out(
    scene: &Scene,
    tracer: &Tracer,
    progress: &Progress,
) -> Result<InsideOut, Cancelled> {
    let patches = Patches::new(scene, PatchSize::Edge(0.0));
    let objects = 0..scene.objects.len() as u32;
    progress.begin("orientation", u64::from(objects.end));
    let counts = objects.into_par_iter().map(|object| {
        progress.advance(1)?;
        Ok(count(&patches, tracer, object))
    });
    let counts: Vec<FacingCounts> = counts.collect::<Result<_, _>>()?;
    let turned = (0..).zip(&counts).filter(|(_, counts)| counts.is_turned());
    let turned: Vec<u32> = turned.map(|(k, _)| k).collect();
    let sum = |hits: fn(&FacingCounts) -> u32| counts.iter().map(hits).sum::<u32>();
    let fronts = sum(|c| c.front.others.iter().chain(&c.front.own).sum());
    let backs = sum(|c| c.back.others[1] + c.back.own.iter().sum::<u32>());
    Ok(if !turned.is_empty() {
        InsideOut::Objects(turned)
    } else if fronts == 0 && backs >= FEW {
        InsideOut::Everything
    } else {
        InsideOut::Nothing
    })
}

fn count(patches: &Patches, tracer: &Tracer, object: u32) -> FacingCounts {
    let mut sides = [SideCounts::default(); 2];
    let rows = patches.patches_of(object);
    let area: f64 = rows.clone().map(|p| patches.area(p)).sum();
    let (mut patch, mut reached) = (rows.start, 0.0);
    for ray in 0..RAYS {
        // Patches by their areas, at even steps.
        let target = area * (f64::from(ray) + 0.5) / f64::from(RAYS);
        while patch + 1 < rows.end && reached + patches.area(patch) < target {
            reached += patches.area(patch);
            patch += 1;
        }
        if rows.is_empty() {
            break;
        }
        let random = |k: u32| f64::from(uniform(&[hash(&[object, ray]), k]));
        let at = patches.sample(patch, random(0), random(1));
        for (side, normal) in sides.iter_mut().zip([at.normal, -at.normal]) {
            let direction = cosine_about(&Frame::from_normal(normal), random(2), random(3));
            let from = tracer.leaving(at.position, normal);
            let Some(hit) = tracer.hit(&Ray::new(from, direction)) else {
                side.free += 1;
                continue;
            };
            let is_own = hit.object == object;
            let counts = if is_own {
                &mut side.own
            } else {
                &mut side.others
            };
            counts[usize::from(!hit.entering)] += 1;
        }
    }
    let [front, back] = sides;
    FacingCounts { front, back }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::synthetic::{cube_room, room_with_table, street_with_detail};
    use glam::{DAffine3, DVec3};

    fn orientation(scene: &Scene) -> InsideOut {
        inside_out(scene, &Tracer::new(scene), &Progress::new()).unwrap()
    }

    #[test]
    fn what_is_right_stays() {
        for scene in [cube_room(), room_with_table(500), street_with_detail(0.02)] {
            assert_eq!(orientation(&scene), InsideOut::Nothing);
        }
    }

    #[test]
    fn turned_objects_are_found() {
        // The fronts of the inner cube are inside, too.
        let mut scene = cube_room();
        let smaller = DAffine3::from_translation(DVec3::splat(0.4));
        let smaller = smaller * DAffine3::from_scale(DVec3::splat(0.2));
        scene.merge(cube_room().transformed(&smaller));
        assert_eq!(orientation(&scene), InsideOut::Objects(vec![1]));
        scene.objects[1].turn_inside_out();
        assert_eq!(orientation(&scene), InsideOut::Nothing);
        let mut scene = cube_room();
        scene.objects[0].turn_inside_out();
        assert_eq!(orientation(&scene), InsideOut::Everything);
        assert_eq!(orientation(&Scene::default()), InsideOut::Nothing);
    }

    #[test]
    fn cancelling_is_an_answer() {
        let (scene, progress) = (cube_room(), Progress::new());
        progress.cancel();
        assert!(inside_out(&scene, &Tracer::new(&scene), &progress).is_err());
    }
}
