//! Backgrounds: gradients of the sky and the ground and six pictures on a cube around the world
//! (ISO/IEC 14772-1:1997, 6.5), which become one equirectangular picture.

use super::builder::{VrmlPlacement, VrmlSceneBuilder};
use super::tree::{VrmlNode, limited, triples};
use azulejo_scene::{Environment, Image, Projection, Rgb, SceneBackground, TextureId, Up};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Rows of a picture of gradients.
const GRADIENT_ROWS: u32 = 256;

/// Most rows of a picture of six others.
const MOST_ROWS: u32 = 1024;

/// The sides of the cube: their names, where they are, and what is right and up in their pictures.
const SIDES: [(&str, [DVec3; 3]); 6] = [
    ("front", [DVec3::NEG_Z, DVec3::X, DVec3::Y]),
    ("back", [DVec3::Z, DVec3::NEG_X, DVec3::Y]),
    ("left", [DVec3::NEG_X, DVec3::NEG_Z, DVec3::Y]),
    ("right", [DVec3::X, DVec3::Z, DVec3::Y]),
    ("top", [DVec3::Y, DVec3::X, DVec3::Z]),
    ("bottom", [DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z]),
];

/// Makes a node the background of the scene.
pub(super) fn place(builder: &mut VrmlSceneBuilder, node: &VrmlNode, frame: &VrmlPlacement) {
    let gradients = Gradients::new(node);
    let sides = SIDES.map(|(name, _)| side(builder, node, name));
    let has_sides = sides.iter().any(Option::is_some);
    if !has_sides && let Some(color) = gradients.color() {
        builder.scene.background = Some(color.into());
        return;
    }
    let picture = panorama(builder, &gradients, &sides);
    match builder.textures.add_pixels("background".into(), picture) {
        Ok(texture) => {
            let mut environment = Environment::picture(texture, Projection::Equirectangular, Up::Y);
            environment.turn(&frame.world_from_object.matrix3);
            builder.scene.background = Some(SceneBackground::Environment(environment));
        }
        Err(why) => {
            let message = format!("background not used: {why}");
            builder.warn_node(node, message);
        }
    }
}

/// The picture of a side: since X3D 3.1 a texture node, before a list of files.
fn side(builder: &mut VrmlSceneBuilder, node: &VrmlNode, name: &str) -> Option<TextureId> {
    let texture = node.nodes(&format!("{name}Texture")).first().cloned();
    if let Some(texture) = texture {
        return builder.side_texture(&texture);
    }
    let urls = node.strings(&format!("{name}Url"));
    let id = builder.texture_of_urls(node, &urls)?;
    builder.textures.image(id).map(|_| id)
}

/// The colours of the sky by the angle to the zenith, and of the ground by that to the nadir.
struct Gradients {
    sky: Vec<(f64, Rgb)>,
    ground: Vec<(f64, Rgb)>,
}

impl Gradients {
    fn new(node: &VrmlNode) -> Gradients {
        let stops = |colors: &str, angles: &str, most: f64| {
            let colors = triples(&node.numbers(colors));
            let colors = colors.into_iter().map(|c| limited(c.to_array().into()));
            let angles = node.numbers(angles);
            let mut last = 0.0;
            let angles = std::iter::once(0.0).chain(angles.iter().map(|&angle| {
                // Angles grow; those that do not have no width.
                last = if angle.is_finite() {
                    angle.clamp(last, most)
                } else {
                    last
                };
                last
            }));
            angles.zip(colors).collect::<Vec<(f64, Rgb)>>()
        };
        let mut gradients = Gradients {
            sky: stops("skyColor", "skyAngle", PI),
            ground: stops("groundColor", "groundAngle", FRAC_PI_2),
        };
        // One colour of the ground is that of all of it.
        if let [(_, color)] = gradients.ground[..] {
            gradients.ground.push((FRAC_PI_2, color));
        }
        gradients
    }

    /// The colour, if it is the same everywhere.
    fn color(&self) -> Option<Rgb> {
        let first = self.sky.first().map_or(Rgb::BLACK, |stop| stop.1);
        let mut stops = self.sky.iter().chain(&self.ground);
        stops.all(|stop| stop.1 == first).then_some(first)
    }

    /// The colour at an angle to the zenith.
    fn at(&self, zenith_angle: f64) -> Rgb {
        let nadir_angle = PI - zenith_angle;
        let has_ground = self.ground.last().is_some_and(|stop| nadir_angle <= stop.0);
        if has_ground {
            interpolated(&self.ground, nadir_angle)
        } else {
            interpolated(&self.sky, zenith_angle)
        }
    }
}

/// The colour between two stops; beyond the last its own.
fn interpolated(stops: &[(f64, Rgb)], angle: f64) -> Rgb {
    let after = stops.partition_point(|stop| stop.0 <= angle);
    match (after.checked_sub(1).map(|k| stops[k]), stops.get(after)) {
        (Some((from, a)), Some(&(to, b))) => {
            let share = (angle - from) / (to - from);
            a * (1.0 - share) + b * share
        }
        (Some((_, last)), None) => last,
        (None, Some(&(_, first))) => first,
        (None, None) => Rgb::BLACK,
    }
}

fn panorama(
    builder: &VrmlSceneBuilder,
    gradients: &Gradients,
    sides: &[Option<TextureId>; 6],
) -> Image {
    let images = sides.map(|id| id.and_then(|id| builder.textures.image(id)));
    let largest = images.iter().flatten().map(|image| image.height).max();
    let (width, height) = match largest {
        // A side covers a quarter of the way around.
        Some(largest) => {
            let rows = (2 * largest).clamp(2, MOST_ROWS);
            (2 * rows, rows)
        }
        None => (1, GRADIENT_ROWS),
    };
    let upright = Environment::picture(0, Projection::Equirectangular, Up::Y);
    let pixel = |k: u32| {
        let u = (f64::from(k % width) + 0.5) / f64::from(width);
        let v = (f64::from(k / width) + 0.5) / f64::from(height);
        let local = Projection::Equirectangular.direction(u, v);
        let seen = on_cube(&images, upright.world_from_environment * local);
        seen.unwrap_or_else(|| gradients.at(PI * v).to_f32())
    };
    Image {
        pixels: (0..width * height).map(pixel).collect(),
        width,
        height,
        ..Image::default()
    }
}

/// What the cube shows in a direction, if there is a picture.
fn on_cube(images: &[Option<&Image>; 6], direction: DVec3) -> Option<[f32; 3]> {
    let toward = |k: &usize| direction.dot(SIDES[*k].1[0]);
    let side = (0..6).max_by(|a, b| toward(a).total_cmp(&toward(b)))?;
    let image = images[side]?;
    let [forward, right, up] = SIDES[side].1;
    let depth = direction.dot(forward);
    let place = |axis: DVec3| 0.5 + 0.5 * direction.dot(axis) / depth;
    // Not over the edges, where lookups would repeat the picture.
    let within = |x: f64, size: u32| {
        let half = 0.5 / f64::from(size.max(1));
        x.clamp(half, 1.0 - half)
    };
    let (u, v) = (
        within(place(right), image.width),
        within(place(up), image.height),
    );
    Some(image.sample(u, v))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_have_a_sky_and_a_ground() {
        let [red, green, blue] = [
            Rgb::new(1.0, 0.0, 0.0),
            Rgb::new(0.0, 1.0, 0.0),
            Rgb::new(0.0, 0.0, 1.0),
        ];
        let gradients = Gradients {
            sky: vec![(0.0, red), (1.0, green)],
            ground: vec![(0.0, blue), (0.5, red)],
        };
        assert_eq!(gradients.at(0.0), red);
        assert_eq!(gradients.at(0.5), (red + green) * 0.5);
        assert_eq!(gradients.at(2.0), green);
        assert_eq!(gradients.at(PI), blue);
        assert_eq!(gradients.at(PI - 0.25), (red + blue) * 0.5);
        assert_eq!(gradients.at(PI - 0.6), green);
        assert_eq!(gradients.color(), None);
    }

    /// Each side of the cube is seen where it is, the right way round.
    #[test]
    fn sides_are_where_they_are() {
        // Left half 0, right half 1; upper half 0, lower half 1.
        let image = Image {
            width: 2,
            height: 2,
            pixels: vec![
                [0.0, 0.0, 0.5],
                [1.0, 0.0, 0.5],
                [0.0, 1.0, 0.5],
                [1.0, 1.0, 0.5],
            ],
            ..Image::default()
        };
        for (k, (_, [forward, right, up])) in SIDES.iter().enumerate() {
            let mut images = [None; 6];
            images[k] = Some(&image);
            let seen = |d: DVec3| on_cube(&images, d.normalize());
            assert_eq!(
                seen(*forward + 0.9 * *right + 0.8 * *up),
                Some([1.0, 0.0, 0.5])
            );
            assert_eq!(
                seen(*forward - 0.9 * *right - 0.8 * *up),
                Some([0.0, 1.0, 0.5])
            );
            assert_eq!(seen(-*forward), None);
        }
    }
}
