//! Radiance that arrives from infinitely far away, by direction: pictures of the surroundings, and
//! skies.

use crate::sky::{Sky, SkyDistribution};
use crate::{Image, Rgb, TextureId, Up};
use glam::{DMat3, DQuat, DVec3};
use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// The radiance of the surroundings by direction.
///
/// Its own frame has z up, y north and x east, whatever the axes of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// What is around.
    pub source: EnvironmentSource,
    /// Turns directions of its frame into those of the world; unit length.
    pub world_from_environment: DQuat,
    /// Factor of the radiance of the source, ≥ 0 per channel.
    pub scale: Rgb,
}

/// Where an environment's radiance comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EnvironmentSource {
    /// A picture whose pixels are radiance, W/(sr·m²); black while it is not loaded.
    Picture {
        /// The picture, one of the scene's textures.
        texture: TextureId,
        /// How directions map to its pixels.
        projection: Projection,
    },
    /// A sky, and the ground below it.
    Sky(Sky),
}

/// How directions map to the pixels of a picture of the surroundings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projection {
    /// Azimuth across and zenith angle down, twice as wide as high. The middle column looks along
    /// +x, what is right of it is to the right: as three.js and Blender have it.
    #[default]
    Equirectangular,
    /// Debevec's angular map: a square whose inscribed circle shows all directions, with +x in the
    /// middle and the distance from it proportional to the angle
    /// (Debevec, *Rendering synthetic objects into real scenes*, SIGGRAPH 1998).
    AngularMap,
}

impl Projection {
    /// Where a unit direction of the environment's frame is found, in 0..=1 from the left and from
    /// the top.
    pub fn place(self, direction: DVec3) -> (f64, f64) {
        let zenith_angle = direction.z.clamp(-1.0, 1.0).acos();
        match self {
            Projection::Equirectangular => {
                let to_the_right = (-direction.y).atan2(direction.x);
                (0.5 + to_the_right / TAU, zenith_angle * FRAC_1_PI)
            }
            Projection::AngularMap => {
                let (right, up) = (-direction.y, direction.z);
                let across = right.hypot(up);
                let distance = across.atan2(direction.x) * FRAC_1_PI;
                let share = if across > 0.0 { distance / across } else { 0.0 };
                (0.5 + 0.5 * right * share, 0.5 - 0.5 * up * share)
            }
        }
    }
}

impl Projection {
    /// The unit direction of the environment's frame that is found at a place, in 0..=1 from the
    /// left and from the top. Outside of its circle an angular map shows nothing, and what is
    /// nearest is returned.
    pub fn direction(self, u: f64, v: f64) -> DVec3 {
        match self {
            Projection::Equirectangular => {
                let (azimuth, zenith_angle) = (TAU * (u - 0.5), PI * v);
                let across = zenith_angle.sin();
                DVec3::new(
                    across * azimuth.cos(),
                    -across * azimuth.sin(),
                    zenith_angle.cos(),
                )
            }
            Projection::AngularMap => {
                let (right, up) = (2.0 * u - 1.0, 1.0 - 2.0 * v);
                let distance = right.hypot(up);
                let angle = PI * distance.min(1.0);
                let share = if distance > 0.0 {
                    angle.sin() / distance
                } else {
                    0.0
                };
                DVec3::new(angle.cos(), -right * share, up * share)
            }
        }
    }
}

impl Environment {
    /// A picture of the surroundings, upright in a world with this up axis: its middle column looks
    /// along +x.
    pub fn picture(texture: TextureId, projection: Projection, up: Up) -> Environment {
        Environment {
            source: EnvironmentSource::Picture {
                texture,
                projection,
            },
            world_from_environment: upright(up, 0.0),
            scale: Rgb::WHITE,
        }
    }

    /// A sky in a world with this up axis; north is turned clockwise, seen from above, by `north`
    /// radians from +y where z is up, and from −z where y is up.
    pub fn sky(sky: Sky, up: Up, north: f64) -> Environment {
        Environment {
            source: EnvironmentSource::Sky(sky),
            world_from_environment: upright(up, north),
            scale: Rgb::WHITE,
        }
    }

    /// The texture that it shows, if it is a picture.
    pub fn texture(&self) -> Option<TextureId> {
        match self.source {
            EnvironmentSource::Picture { texture, .. } => Some(texture),
            EnvironmentSource::Sky(_) => None,
        }
    }

    /// The same, with its texture numbered anew.
    #[must_use]
    pub fn with_texture(mut self, number: impl Fn(TextureId) -> TextureId) -> Environment {
        if let EnvironmentSource::Picture { texture, .. } = &mut self.source {
            *texture = number(*texture);
        }
        self
    }

    /// Turns the environment by the rotation in a linear map: its scales are dropped, as what is
    /// infinitely far away has no size, and so is a reflection. A singular map leaves it as it is.
    pub fn turn(&mut self, map: &DMat3) {
        let Some(x) = map.x_axis.try_normalize() else {
            return;
        };
        if let Some(z) = x.cross(map.y_axis).try_normalize() {
            let rotation = DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z));
            self.world_from_environment = (rotation * self.world_from_environment).normalize();
        }
    }

    /// Where its north lies in a world with this up axis, radians in 0..2π, clockwise as seen from
    /// above: what [`Environment::sky`] was given, or the same of a tilted one.
    pub fn north(&self, up: Up) -> f64 {
        let north = upright(up, 0.0).conjugate() * (self.world_from_environment * DVec3::Y);
        north.x.atan2(north.y).rem_euclid(TAU)
    }

    /// The same, turned about the vertical of a world with this up axis until its north lies there;
    /// `north` as for [`Environment::sky`]. A tilt stays.
    #[must_use]
    pub fn with_north(mut self, up: Up, north: f64) -> Environment {
        let turn = DQuat::from_axis_angle(up.axis(), self.north(up) - north);
        self.world_from_environment = (turn * self.world_from_environment).normalize();
        self
    }

    /// The radiance that arrives from every direction alike (W/(sr·m²)), and the environment without it: of an even sky
    /// the less bright of sky and ground. Light from everywhere needs no choice of directions.
    pub fn split_even(&self) -> (Rgb, Environment) {
        let EnvironmentSource::Sky(sky) = self.source else {
            return (Rgb::BLACK, *self);
        };
        if sky.distribution != SkyDistribution::Uniform {
            return (Rgb::BLACK, *self);
        }
        let even = sky.scale.min(sky.ground);
        let uneven = Sky {
            scale: sky.scale - even,
            ground: sky.ground - even,
            ..sky
        };
        let uneven = Environment {
            source: EnvironmentSource::Sky(uneven),
            ..*self
        };
        (self.scale * even, uneven)
    }

    /// A direction of the world in the frame of the environment.
    pub fn to_local(&self, direction: DVec3) -> DVec3 {
        self.world_from_environment.conjugate() * direction
    }

    /// Radiance that arrives from the unit direction of the world, W/(sr·m²). `image` is the
    /// picture; pixels are constant.
    pub fn radiance(&self, direction: DVec3, image: Option<&Image>) -> Rgb {
        self.look_up(direction, image, |image, u, v| {
            let column = (u * f64::from(image.width)) as u32;
            let row = (v * f64::from(image.height)) as u32;
            image.pixel(column.min(image.width - 1), row.min(image.height - 1))
        })
    }

    /// As [`radiance`](Environment::radiance), between pixels interpolated: what a camera sees.
    pub fn seen(&self, direction: DVec3, image: Option<&Image>) -> Rgb {
        self.look_up(direction, image, interpolated)
    }

    fn look_up(
        &self,
        direction: DVec3,
        image: Option<&Image>,
        pixel: impl Fn(&Image, f64, f64) -> [f32; 3],
    ) -> Rgb {
        let local = self.to_local(direction);
        let radiance = match self.source {
            EnvironmentSource::Picture { projection, .. } => {
                let image = image.filter(|i| i.width > 0 && i.height > 0);
                image.map_or(Rgb::BLACK, |image| {
                    let (u, v) = projection.place(local);
                    Rgb::from(pixel(image, u, v).map(f64::from))
                })
            }
            EnvironmentSource::Sky(sky) => Rgb::grey(sky.radiance(local)),
        };
        radiance * self.scale
    }
}

/// Bilinear, around the picture from side to side, not over its upper and lower edges.
fn interpolated(image: &Image, u: f64, v: f64) -> [f32; 3] {
    let (width, height) = (i64::from(image.width), i64::from(image.height));
    let (x, y) = (u * width as f64 - 0.5, v * height as f64 - 0.5);
    let (fx, fy) = ((x - x.floor()) as f32, (y - y.floor()) as f32);
    let at = |dx: i64, dy: i64| {
        let column = (x.floor() as i64 + dx).rem_euclid(width);
        let row = (y.floor() as i64 + dy).clamp(0, height - 1);
        image.pixel(column as u32, row as u32)
    };
    let corners = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
    let weights = [
        (1.0 - fx) * (1.0 - fy),
        fx * (1.0 - fy),
        (1.0 - fx) * fy,
        fx * fy,
    ];
    std::array::from_fn(|k| corners.iter().zip(weights).map(|(c, w)| w * c[k]).sum())
}

/// Turns the frame of an environment upright in a world with this up axis: east is +x; north is +y
/// where z is up and −z where y is up, turned clockwise, seen from above, by `north` radians.
pub fn upright(up: Up, north: f64) -> DQuat {
    let turned = DQuat::from_rotation_z(-north);
    match up {
        Up::Z => turned,
        Up::Y => {
            let columns = DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y);
            DQuat::from_mat3(&columns) * turned
        }
    }
}

/// Solid angle, sr, of the band of the sphere between two zenith angles over an azimuth of `width`
/// radians.
pub fn solid_angle_of_band(from: f64, to: f64, width: f64) -> f64 {
    debug_assert!((0.0..=PI).contains(&from) && from <= to, "{from}..{to}");
    width * (from.cos() - to.cos())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: u32, height: u32) -> Image {
        let pixel = |k: u32| [k as f32, (k % width) as f32, (k / width) as f32];
        Image {
            width,
            height,
            pixels: (0..width * height).map(pixel).collect(),
            alpha: None,
        }
    }

    #[test]
    fn the_middle_looks_along_x_and_right_is_right() {
        for (up, right, above) in [(Up::Z, DVec3::NEG_Y, DVec3::Z), (Up::Y, DVec3::Z, DVec3::Y)] {
            for projection in [Projection::Equirectangular, Projection::AngularMap] {
                let environment = Environment::picture(0, projection, up);
                let place = |d: DVec3| projection.place(environment.to_local(d.normalize()));
                let (u, v) = place(DVec3::X);
                assert!((u - 0.5).abs() < 1e-12 && (v - 0.5).abs() < 1e-12);
                assert!(place(DVec3::X + 0.1 * right).0 > 0.51);
                assert!(place(DVec3::X + 0.1 * above).1 < 0.49);
            }
        }
    }

    #[test]
    fn directions_and_places_are_inverse() {
        for projection in [Projection::Equirectangular, Projection::AngularMap] {
            for (u, v) in [(0.5, 0.5), (0.3, 0.6), (0.7, 0.2), (0.45, 0.9)] {
                let direction = projection.direction(u, v);
                assert!((direction.length() - 1.0).abs() < 1e-12);
                let (again, below) = projection.place(direction);
                assert!(
                    (again - u).abs() < 1e-9 && (below - v).abs() < 1e-9,
                    "{u} {v}"
                );
            }
        }
    }

    #[test]
    fn pixels_are_constant_and_found_where_they_are() {
        let image = picture(8, 4);
        let environment = Environment::picture(0, Projection::Equirectangular, Up::Z);
        for row in 0..4 {
            for column in 0..8 {
                for (dx, dy) in [(0.01, 0.02), (0.5, 0.5), (0.99, 0.98)] {
                    let azimuth = TAU * ((f64::from(column) + dx) / 8.0 - 0.5);
                    let zenith = PI * (f64::from(row) + dy) / 4.0;
                    let d = DVec3::new(
                        zenith.sin() * azimuth.cos(),
                        -zenith.sin() * azimuth.sin(),
                        zenith.cos(),
                    );
                    let radiance = environment.radiance(d, Some(&image));
                    assert_eq!(radiance.r, f64::from(8 * row + column));
                }
            }
        }
    }

    #[test]
    fn interpolation_meets_the_centres_of_pixels() {
        let image = picture(8, 4);
        let [_, x, y] = interpolated(&image, 2.5 / 8.0, 1.5 / 4.0);
        assert_eq!((x, y), (2.0, 1.0));
        let [_, x, _] = interpolated(&image, 3.0 / 8.0, 1.5 / 4.0);
        assert_eq!(x, 2.5);
    }

    #[test]
    fn axes_turn_it_along() {
        let mut environment = Environment::picture(0, Projection::default(), Up::Z);
        environment.turn(&(3.0 * DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y)));
        let upright = Environment::picture(0, Projection::default(), Up::Y);
        let (a, b) = (
            environment.world_from_environment,
            upright.world_from_environment,
        );
        assert!(a.dot(b).abs() > 1.0 - 1e-12);
        environment.turn(&DMat3::ZERO);
        assert_eq!(environment.world_from_environment, a);
    }

    #[test]
    fn an_environment_is_turned_to_a_north() {
        for up in [Up::Y, Up::Z] {
            let sky = Environment::sky(Sky::uniform(1.0), up, 0.4);
            assert!((sky.north(up) - 0.4).abs() < 1e-12);
            let turned = sky.with_north(up, 5.0);
            let expected = Environment::sky(Sky::uniform(1.0), up, 5.0);
            let off = turned
                .world_from_environment
                .dot(expected.world_from_environment);
            assert!(off.abs() > 1.0 - 1e-12, "{up:?}");
        }
    }

    #[test]
    fn an_even_sky_is_split_into_what_comes_from_everywhere_and_the_rest() {
        for (sky, ground, even) in [(1.0, 1.0, 1.0), (2.0, 0.5, 0.5), (0.5, 2.0, 0.5)] {
            let mut whole = Environment::sky(
                Sky {
                    ground,
                    ..Sky::uniform(sky)
                },
                Up::Z,
                0.0,
            );
            whole.scale = Rgb::new(1.0, 2.0, 3.0);
            let (everywhere, rest) = whole.split_even();
            assert_eq!(everywhere, whole.scale * even);
            for direction in [DVec3::Z, -DVec3::Z, DVec3::new(0.6, 0.0, 0.8)] {
                let sum = everywhere + rest.radiance(direction, None);
                assert_eq!(sum, whole.radiance(direction, None));
            }
        }
        let picture = Environment::picture(0, Projection::Equirectangular, Up::Z);
        assert_eq!(picture.split_even(), (Rgb::BLACK, picture));
    }

    #[test]
    fn north_turns_clockwise() {
        let east = upright(Up::Z, std::f64::consts::FRAC_PI_2) * DVec3::Y;
        assert!(east.distance(DVec3::X) < 1e-12);
        let north = upright(Up::Y, 0.0) * DVec3::Y;
        assert!(north.distance(DVec3::NEG_Z) < 1e-12);
    }
}
