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

/// Hits of other objects by rays from both sides of an object, [`RAYS`] from each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct FacingCounts {
    /// From its fronts, on fronts and on backs.
    front: [u32; 2],
    /// From its backs, on fronts and on backs.
    back: [u32; 2],
}

/// What is probably turned inside out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum InsideOut {
    /// Nothing.
    Nothing,
    /// These objects, by their numbers: their backs see the fronts of others, and their fronts hardly do.
    Objects(Vec<u32>),
    /// The whole scene: backs see backs, and fronts see nothing.
    Everything,
}

impl FacingCounts {
    /// Whether the object would see more of the others' fronts if it were turned.
    fn is_turned(&self) -> bool {
        self.back[0] >= FEW && self.back[0] > CLEARLY * self.front[0]
    }
}

/// Finds what is probably turned inside out, by 512 rays from each object.
///
/// An object counts as turned if its backs see at least four times as much of other objects' fronts as its
/// fronts do; the scene does if its fronts see nothing while its backs see backs. A single body in empty space
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
    let counts: Vec<(FacingCounts, [u32; 2])> = counts.collect::<Result<_, _>>()?;
    let turned = counts.iter().enumerate();
    let turned = turned.filter(|(_, (others, _))| others.is_turned());
    let turned: Vec<u32> = turned.map(|(k, _)| k as u32).collect();
    let sum = |hits: fn(&(FacingCounts, [u32; 2])) -> u32| counts.iter().map(hits).sum::<u32>();
    let fronts = sum(|(others, own)| others.front.iter().sum::<u32>() + own[0]);
    let backs = sum(|(others, own)| others.back[1] + own[1]);
    Ok(if !turned.is_empty() {
        InsideOut::Objects(turned)
    } else if fronts == 0 && backs >= FEW {
        InsideOut::Everything
    } else {
        InsideOut::Nothing
    })
}

/// Hits of others, and of the object itself from front and back.
fn count(patches: &Patches, tracer: &Tracer, object: u32) -> (FacingCounts, [u32; 2]) {
    let (mut others, mut own) = (FacingCounts::default(), [0; 2]);
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
        for (side, normal) in [at.normal, -at.normal].into_iter().enumerate() {
            let direction = cosine_about(&Frame::from_normal(normal), random(2), random(3));
            let from = tracer.leaving(at.position, normal);
            let Some(hit) = tracer.hit(&Ray::new(from, direction)) else {
                continue;
            };
            if hit.object == object {
                own[side] += 1;
            } else {
                let counts = [&mut others.front, &mut others.back];
                counts[side][usize::from(!hit.entering)] += 1;
            }
        }
    }
    (others, own)
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
