//! Common to the processor and cards: the local coordinates of hemicubes, and the viewpoint with
//! its images behind mirrors.

use super::{Mirror, NO_MIRROR, View, World};
use azulejo_scene::Rgb;
use azulejo_scene::math::reflect;
use glam::DVec3;

/// A reflected world begins this far behind its mirror, so that nothing in the mirror's own plane is
/// seen in it; relative to half the world's size. It is the step of
/// [`Tracer::leaving`](crate::Tracer::leaving).
const LEAVING: f64 = 16.0 * f32::EPSILON as f64;

/// The precision in which a backend compares distances.
///
/// It decides how far behind a mirror the reflected world begins. Rounding in single precision grows
/// with the distance of the mirrored viewpoint: seen from 10, 30, 100 and 1000 half world sizes, a
/// constant step lets 0.2, 25, 52 and 70 % of the points in a mirror's plane through, one that grows
/// with the distance at most 1e-5 of them. Double precision needs no growth, and is better without:
/// a growing step loses light at the edges of mirrors, and in a bowl of perfect mirrors two thirds of
/// it after a thousand reflections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DepthPrecision {
    /// `f32`, as on graphics cards.
    Single,
    /// `f64`, as on the processor.
    Double,
}

impl DepthPrecision {
    /// How far behind its mirror a reflected world begins that is seen from `eye`, in local
    /// coordinates.
    fn step(self, eye: DVec3) -> f64 {
        match self {
            DepthPrecision::Single => LEAVING * eye.abs().max_element().max(1.0),
            DepthPrecision::Double => LEAVING,
        }
    }
}

/// The map of world coordinates into −1..=1 about the world's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitCube {
    /// The world's centre, scene units.
    pub centre: DVec3,
    /// Half the world's largest extent, scene units.
    pub reach: f64,
}

impl UnitCube {
    /// The map for a world with these points. A single point, or none, is not scaled.
    pub fn around(points: impl Iterator<Item = DVec3>) -> UnitCube {
        let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = points.fold(nothing, |(low, high), p| (low.min(p), high.max(p)));
        let reach = 0.5 * (high - low).max_element();
        if reach > 0.0 && reach.is_finite() {
            let centre = 0.5 * (low + high);
            return UnitCube { centre, reach };
        }
        let centre = if low.is_finite() { low } else { DVec3::ZERO };
        UnitCube { centre, reach: 1.0 }
    }

    /// A point of the world in local coordinates.
    pub fn point(&self, p: DVec3) -> DVec3 {
        (p - self.centre) / self.reach
    }

    /// A point in local coordinates back in the world.
    pub fn world_point(&self, p: DVec3) -> DVec3 {
        p * self.reach + self.centre
    }
}

/// The points p with `normal` · p = `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal.
    pub normal: DVec3,
    /// Distance from the origin along the normal.
    pub offset: f64,
}

/// A mirror with its plane in local coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalMirror {
    /// Its plane.
    pub plane: Plane,
    /// Reflectance ρ_s, 0..=1 per channel.
    pub reflectance: Rgb,
}

impl LocalMirror {
    /// A mirror of the world in local coordinates.
    pub fn new(mirror: &Mirror, local: &UnitCube) -> LocalMirror {
        LocalMirror {
            plane: Plane {
                normal: mirror.normal,
                offset: mirror.normal.dot(local.point(mirror.point)),
            },
            reflectance: mirror.reflectance,
        }
    }
}

/// The reflection of light at a patch, as far as item buffers can follow it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PatchOptics {
    /// It is not followed: the patch is diffuse.
    Diffuse,
    /// It is reflected: the patch is a part of this mirror.
    Mirror(u32),
    /// It continues in a way that item buffers cannot draw.
    Bent,
}

impl World {
    /// The reflection of light at a patch.
    pub fn optics(&self, patch: u32) -> PatchOptics {
        if self.is_bent.get(patch as usize) == Some(&true) {
            return PatchOptics::Bent;
        }
        match self.mirror_of.get(patch as usize) {
            Some(&m) if m != NO_MIRROR && (m as usize) < self.mirrors.len() => {
                PatchOptics::Mirror(m)
            }
            _ => PatchOptics::Diffuse,
        }
    }
}

/// A hemicube in local coordinates, direct or through mirrors.
#[derive(Clone, Debug, PartialEq)]
pub struct HemicubeView {
    /// The viewpoint, or its image behind the mirrors.
    pub eye: DVec3,
    /// x, y, and z along the normal.
    pub axes: [DVec3; 3],
    /// Whether the axes are left-handed, as they are after an odd number of mirrors.
    pub is_turned: bool,
    /// Product of the reflectances on the way.
    pub tint: Rgb,
    /// The last mirror on the way, or [`NO_MIRROR`].
    pub mirror: u32,
    /// The plane at which the last mirror's world begins: points below its offset are not part of
    /// it.
    pub begin: Option<Plane>,
    /// The precision of the backend that draws it.
    pub precision: DepthPrecision,
}

impl HemicubeView {
    /// A hemicube without mirrors.
    pub fn new(view: &View, local: &UnitCube, precision: DepthPrecision) -> HemicubeView {
        HemicubeView {
            eye: local.point(view.eye),
            axes: view.axes(),
            is_turned: false,
            tint: Rgb::WHITE,
            mirror: NO_MIRROR,
            begin: None,
            precision,
        }
    }

    /// Its reflection in a mirror, on the side of the viewpoint. `number` is the mirror's index in
    /// [`World::mirrors`].
    pub fn behind(&self, number: u32, mirror: &LocalMirror) -> HemicubeView {
        let Plane { normal, offset } = mirror.plane;
        let height = normal.dot(self.eye) - offset;
        let side = if height < 0.0 { -1.0 } else { 1.0 };
        let eye = self.eye - 2.0 * height * normal;
        let step = self.precision.step(eye);
        HemicubeView {
            eye,
            axes: self.axes.map(|a| reflect(a, normal)),
            is_turned: !self.is_turned,
            tint: self.tint * mirror.reflectance,
            mirror: number,
            begin: Some(Plane {
                normal: side * normal,
                offset: side * offset + step,
            }),
            precision: self.precision,
        }
    }

    /// Axes of a face: the points (u, v) of its image lie in the direction u x + v y + w. Face 0
    /// is the top, 1 to 4 are those towards +x, −x, +y, −y.
    pub fn face_axes(&self, face: usize) -> [DVec3; 3] {
        let [x, y, z] = self.axes;
        match face {
            0 => [x, y, z],
            1 => [y, z, x],
            2 => [-y, z, -x],
            3 => [-x, z, y],
            _ => [x, z, -y],
        }
    }

    /// The nearness of the plane at which the reflected world begins, in a face with these axes:
    /// the coefficients of u, v and 1 in 1/w, with w the distance along the face's last axis.
    /// `None` without mirrors.
    pub fn begin_nearness(&self, axes: &[DVec3; 3]) -> Option<[f64; 3]> {
        let plane = self.begin.as_ref()?;
        // n · (eye + w d) = offset, so 1/w = n · d / away.
        let away = plane.offset - plane.normal.dot(self.eye);
        let inverse = 1.0 / away;
        (away > 0.0).then(|| axes.map(|a| plane.normal.dot(a) * inverse))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::uniform;

    /// A number of −1..=1.
    fn number(k: u32, dimension: u32) -> f64 {
        2.0 * f64::from(uniform(&[k, dimension])) - 1.0
    }

    fn vector(k: u32, dimension: u32) -> DVec3 {
        DVec3::from([0, 1, 2].map(|axis| number(k, dimension + axis)))
    }

    /// The fraction of points of a mirror's plane that count as behind it as a card computes it,
    /// all in single precision: 1/w of the plane, taken as that of a facet in the mirror, and of
    /// the plane at which the reflected world begins. Seen from `distance`, in world halves, with
    /// `step` between the two planes.
    fn leak(distance: f64, step: impl Fn(DVec3) -> f64) -> f64 {
        let (mut seen, mut leaked) = (0, 0);
        for k in 0..3000 {
            let normal = vector(k, 0).normalize();
            let point = 0.5 * vector(k, 3);
            let in_plane = |d: DVec3| point + 0.5 * (d - d.dot(normal) * normal);
            let (middle, target) = (in_plane(vector(k, 6)), in_plane(vector(k, 9)));
            let away = vector(k, 12).normalize();
            let away = if away.dot(normal) < 0.0 { away } else { -away };
            let eye = target + distance * away;
            // A face whose image contains the target.
            let frame = azulejo_scene::math::Frame::from_normal(-away);
            let axes = [frame.x, frame.y, frame.z + 0.4 * frame.x + 0.3 * frame.y];
            let w = axes[2].normalize();
            let u = axes[0] - axes[0].dot(w) * w;
            let axes = [u.normalize(), w.cross(u.normalize()), w];
            let view = HemicubeView {
                eye,
                axes,
                is_turned: false,
                tint: Rgb::WHITE,
                mirror: 0,
                begin: Some(Plane {
                    normal,
                    offset: normal.dot(point) + step(eye),
                }),
                precision: DepthPrecision::Single,
            };
            let Some(begin) = view.begin_nearness(&axes) else {
                continue;
            };
            // As draw.wgsl does.
            let high = eye.as_vec3();
            let low = (eye - high.as_dvec3()).as_vec3();
            let n = normal.as_vec3();
            let offset = n.as_dvec3().dot(middle) as f32;
            let away = (offset - n.dot(high)) - n.dot(low);
            let d = target - eye;
            let image = [0, 1].map(|a| (d.dot(axes[a]) / d.dot(axes[2])) as f32);
            let image = glam::Vec3::new(image[0], image[1], 1.0);
            let near = glam::Vec3::from(axes.map(|a| n.dot(a.as_vec3()) / away)).dot(image);
            let begin = glam::Vec3::from(begin.map(|b| b as f32)).dot(image);
            seen += 1;
            leaked += u32::from(near <= begin);
        }
        f64::from(leaked) / f64::from(seen)
    }

    #[test]
    fn the_plane_of_a_mirror_is_not_seen_in_it_from_any_distance() {
        for exponent in -3..=3 {
            let distance = 10f64.powi(exponent);
            let leak = leak(distance, |eye| DepthPrecision::Single.step(eye));
            assert!(leak < 1e-3, "{leak} from {distance}");
        }
        // The constant step of double precision would not do.
        let constant = leak(100.0, |eye| DepthPrecision::Double.step(eye));
        assert!(constant > 0.3, "{constant}");
    }
}
