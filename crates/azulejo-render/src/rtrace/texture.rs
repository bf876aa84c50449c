//! Textures that change colours and reflectances.

use super::map::{color_at, image_at};
use super::noise::{Octaves, bands, noise, wave};
use super::relief;
use azulejo_scene::Rgb;
use azulejo_scene::rtrace::{ColorMap, RtraceSurface, RtraceTexture, RtraceTextureKind};
use glam::{DMat4, DVec3};

/// Turbulence that moves a point before it is looked up.
const TURBULENCE: Octaves = Octaves::halves(4);

/// A surface point to which textures are applied.
#[derive(Clone, Copy, Debug)]
pub(super) struct TexturedSurface {
    pub surface: RtraceSurface,
    /// In the world.
    pub position: DVec3,
    /// Unit, toward the ray.
    pub normal: DVec3,
}

impl TexturedSurface {
    /// Applies textures one after the other; each passes its transformed point to the next.
    pub fn apply(&mut self, textures: &[RtraceTexture], surfaces: &[RtraceSurface]) {
        let mut point = self.position;
        for texture in textures {
            point = transformed(&texture.texture_from_point, point);
            if !point.is_finite() {
                return;
            }
            self.apply_one(&texture.kind, &mut point, surfaces);
        }
    }

    fn apply_one(
        &mut self,
        kind: &RtraceTextureKind,
        point: &mut DVec3,
        surfaces: &[RtraceSurface],
    ) {
        use RtraceTextureKind::*;
        match kind {
            Null => {}
            Checker { surface } => {
                if is_odd(*point) {
                    self.surface = surfaces[*surface as usize];
                }
            }
            Blotch { k, surface } => self.blend(surfaces[*surface as usize].color, *k, *point),
            Marble { map } => self.scale_by(map, marble(*point)),
            Fbm {
                offset,
                k,
                omega,
                lambda,
                threshold,
                octaves,
                map,
            } => {
                let sum = Octaves::brownian(*omega, *lambda, *octaves).sum(*point);
                self.scale_by(map, offset + k * (sum - threshold).max(0.0));
            }
            Wood { color } => self.scale(wood(*color, *point)),
            Bozo { turbulence, map } => {
                bend(point, *turbulence);
                self.bozo(map, noise(*point));
            }
            Spotted { map } => self.scale_by(map, noise(*point)),
            Agate { map } => self.agate(map, *point),
            Granite { map } => self.scale_by(map, granite(*point)),
            Gradient {
                turbulence,
                direction,
                map,
            } => {
                bend(point, *turbulence);
                self.scale_by(map, gradient(*direction, *point));
            }
            ImageMap {
                turbulence,
                tiles,
                axes,
                image,
            } => {
                bend(point, *turbulence);
                let [u, v] = axes.map(|a| point[usize::from(a)]);
                let is_on = |x: f64| *tiles || (0.0..=1.0).contains(&x);
                if is_on(u) && is_on(v) {
                    self.surface.color = image_at(image, u, v);
                }
            }
            Gloss { k } => self.gloss(k * noise(*point)),
            Bump { .. }
            | FbmBump { .. }
            | Round { .. }
            | Ripples { .. }
            | Waves { .. }
            | Dents { .. }
            | Wrinkles { .. }
            | Bump3 { .. } => relief::apply(self, kind, point),
        }
    }

    /// Multiplies the colour by 2 `by`: ½ leaves a channel unchanged.
    fn scale(&mut self, by: Rgb) {
        let color = self.surface.color * by;
        self.surface.color = color.map(|c| (2.0 * c).clamp(0.0, 1.0));
    }

    fn scale_by(&mut self, map: &Option<ColorMap>, t: f64) {
        self.scale(match map {
            Some(map) => color_at(map, t),
            None => Rgb::grey(t),
        });
    }

    /// Another colour shines through where noise is above `k`.
    fn blend(&mut self, other: Rgb, k: f64, point: DVec3) {
        let t = noise(point);
        if t > k {
            let share = (t - k) / (1.0 - k);
            let color = (1.0 - share) * self.surface.color + share * other;
            self.surface.color = color.map(|c| c.clamp(0.0, 1.0));
        }
    }

    fn bozo(&mut self, map: &Option<ColorMap>, t: f64) {
        if map.is_some() {
            return self.scale_by(map, t);
        }
        self.scale(match t {
            t if t < 0.4 => Rgb::WHITE,
            t if t < 0.6 => Rgb::new(0.5, 1.0, 0.5),
            t if t < 0.8 => Rgb::new(0.5, 0.5, 1.0),
            _ => Rgb::new(1.0, 0.5, 0.5),
        });
    }

    fn agate(&mut self, map: &Option<ColorMap>, point: DVec3) {
        let phase = 1.3 * Octaves::halves(4).sum(point) + 1.1 * point.z;
        let t = (0.5 * (wave(phase) + 1.0)).powf(0.77);
        if map.is_some() {
            return self.scale_by(map, t);
        }
        let hue = 1.0 - t;
        self.scale(match t {
            t if t < 0.5 => Rgb::new(1.0 - t / 10.0, 1.0 - t / 5.0, hue),
            t if t < 0.6 => Rgb::new(0.9, 0.7, hue),
            _ => Rgb::new(0.6 + hue, 0.3 + hue, hue),
        });
    }

    /// Moves a share of Kd to Ks.
    fn gloss(&mut self, share: f64) {
        let s = &mut self.surface;
        s.specular += share * s.diffuse;
        s.diffuse *= 1.0 - share;
        s.phong = 1.0 + 1000.0 * share;
    }
}

/// A point under a map with a perspective row; points at infinity keep their direction.
fn transformed(map: &DMat4, point: DVec3) -> DVec3 {
    let p = *map * point.extend(1.0);
    if p.w.abs() < 1e-12 {
        return p.truncate();
    }
    p.truncate() / p.w
}

fn bend(point: &mut DVec3, turbulence: f64) {
    if turbulence > 1e-12 {
        *point += turbulence * TURBULENCE.vector_sum(*point);
    }
}

/// Whether a point is in an odd one of the unit cells: those at 0 are as wide as all others.
fn is_odd(point: DVec3) -> bool {
    let cell = |x: f64| if x > 0.0 { x as i64 } else { (1.0 - x) as i64 };
    let sum = point.to_array().into_iter().fold(0, |n, x| n ^ cell(x));
    sum & 1 == 1
}

fn marble(p: DVec3) -> f64 {
    bands(8.0 * Octaves::halves(6).sum(p) + 7.0 * p.z)
}

fn granite(p: DVec3) -> f64 {
    let octaves = (1..=6).map(|k| {
        let f = f64::from(1 << k);
        noise(4.0 * f * p) / f
    });
    octaves.sum()
}

fn gradient(direction: DVec3, p: DVec3) -> f64 {
    let fraction = |x: f64| x - x.floor();
    let along = (direction * p).to_array().map(fraction);
    fraction(along.iter().sum())
}

/// Brown and green layers across, a fine grain along z.
fn wood(color: Rgb, p: DVec3) -> Rgb {
    let chaos = Octaves::halves(7).sum(p);
    let layer = (8.0 * chaos + 7.0 * p.x + 3.0 * p.y).sin().sin().abs();
    let grain = (40.0 * chaos + 50.0 * p.z).sin().abs();
    let curve = (0.5 * (layer + 1.0)).powf(0.6);
    let (brown, green) = (curve * (0.7 * grain + 0.3), curve * (0.2 * grain + 0.8));
    let depth = layer.powf(0.3);
    let mixed = |share: f64| share * (color.r + color.b) * brown + color.g * green;
    let g = brown.max(green) * (0.15 * grain + 0.85);
    depth * Rgb::new(mixed(0.5), g, mixed(0.25))
}

#[cfg(test)]
mod tests {
    use super::*;
    use RtraceTextureKind::*;
    use azulejo_scene::Image;
    use std::sync::Arc;

    const GREY: Rgb = Rgb::grey(0.4);

    fn surface(color: Rgb) -> RtraceSurface {
        RtraceSurface {
            color,
            diffuse: Rgb::grey(0.8),
            specular: Rgb::grey(0.1),
            phong: 5.0,
            ..RtraceSurface::default()
        }
    }

    fn texture(kind: RtraceTextureKind) -> RtraceTexture {
        RtraceTexture {
            texture_from_point: DMat4::IDENTITY,
            matrix: DMat4::ZERO,
            file: String::new(),
            kind,
        }
    }

    fn textured(textures: &[RtraceTexture], position: DVec3) -> TexturedSurface {
        let mut textured = TexturedSurface {
            surface: surface(GREY),
            position,
            normal: DVec3::Y,
        };
        textured.apply(textures, &[surface(Rgb::WHITE)]);
        textured
    }

    /// One of each, with typical parameters.
    fn all() -> Vec<RtraceTextureKind> {
        let map: ColorMap = Arc::new([Rgb::grey(0.5); 256]);
        vec![
            Null,
            Checker { surface: 0 },
            Blotch { k: 0.4, surface: 0 },
            Bump { k: 0.5 },
            Marble { map: None },
            Fbm {
                offset: 0.0,
                k: 1.0,
                omega: 0.5,
                lambda: 2.0,
                threshold: 0.4,
                octaves: 6.0,
                map: None,
            },
            FbmBump {
                offset: 0.0,
                k: 0.6,
                omega: 0.5,
                lambda: 2.0,
                octaves: 6.0,
            },
            Wood {
                color: Rgb::new(0.5, 0.5, 0.35),
            },
            Round { k: 0.3 },
            Bozo {
                turbulence: 0.5,
                map: None,
            },
            Ripples {
                frequency: 1.0,
                phase: 0.0,
                k: 0.5,
            },
            Waves {
                frequency: 1.0,
                phase: 0.2,
                k: 0.5,
            },
            Spotted { map: Some(map) },
            Dents { k: 1.0 },
            Agate { map: None },
            Wrinkles { k: 0.3 },
            Granite { map: None },
            Gradient {
                turbulence: 0.0,
                direction: DVec3::new(1.0, 0.5, 0.0),
                map: None,
            },
            ImageMap {
                turbulence: 0.0,
                tiles: true,
                axes: [0, 2],
                image: Arc::new(Image {
                    width: 2,
                    height: 2,
                    pixels: vec![[0.2; 3], [0.4; 3], [0.6; 3], [0.8; 3]],
                    alpha: None,
                }),
            },
            Gloss { k: 0.1 },
            Bump3 { k: 0.1, size: 0.01 },
        ]
    }

    /// Points all over.
    fn points() -> impl Iterator<Item = DVec3> {
        (0..400).map(|i| f64::from(i) * DVec3::new(0.313, -0.171, 0.527) - DVec3::splat(9.3))
    }

    #[test]
    fn all_of_them_stay_in_range_and_say_the_same_again() {
        for kind in all() {
            let textures = [texture(kind)];
            for p in points() {
                let a = textured(&textures, p);
                let b = textured(&textures, p);
                assert!(
                    a.surface == b.surface && a.normal == b.normal,
                    "{textures:?}"
                );
                let color = a.surface.color.to_array();
                assert!(
                    color.iter().all(|c| (0.0..=1.0).contains(c)),
                    "{textures:?} {color:?}"
                );
                assert!((a.normal.length() - 1.0).abs() < 1e-9, "{textures:?}");
                assert!((a.position - p).length() <= 0.3, "{textures:?}");
            }
        }
    }

    #[test]
    fn colours_or_normals_change_as_the_kind_says() {
        for (number, kind) in all().into_iter().enumerate() {
            let textures = [texture(kind)];
            let any =
                |f: &dyn Fn(&TexturedSurface) -> bool| points().any(|p| f(&textured(&textures, p)));
            let bends = matches!(number, 3 | 6 | 8 | 10 | 11 | 13 | 15 | 20);
            // A map of middle grey leaves spots as they are.
            let colors = matches!(number, 1 | 2 | 4 | 5 | 7 | 9 | 14 | 16 | 17 | 18);
            assert_eq!(any(&|p| p.normal != DVec3::Y), bends, "{number}");
            assert_eq!(any(&|p| p.surface.color != GREY), colors, "{number}");
            assert_eq!(any(&|p| p.surface.phong != 5.0), number == 19, "{number}");
        }
    }

    #[test]
    fn means_over_space_are_those_of_the_formulas() {
        let check = |kind: RtraceTextureKind, expected: f64, tolerance: f64| {
            let textures = [texture(kind)];
            let n = 4000;
            let mean: f64 = (0..n)
                .map(|i| {
                    let p = f64::from(i) * DVec3::new(0.7313, -0.9171, 1.327);
                    textured(&textures, p).surface.color.r
                })
                .sum::<f64>()
                / f64::from(n);
            assert!((mean - expected).abs() < tolerance, "{textures:?}: {mean}");
        };
        let map = None;
        check(Checker { surface: 0 }, 0.7, 0.02);
        // 0.4 × 2 × ½ where noise has mean ½.
        check(Spotted { map: map.clone() }, 0.4, 0.02);
        // Σ 2^−k ½, to the sixth.
        check(Granite { map: map.clone() }, 0.8 * 0.5 * 63.0 / 64.0, 0.02);
        // The mean of ((sin + 1)/2)^0.77 over all phases is 0.5517.
        check(Marble { map: map.clone() }, 0.8 * 0.5517, 0.03);
        let gradient = Gradient {
            turbulence: 0.0,
            direction: DVec3::new(1.0, 0.0, 0.0),
            map,
        };
        check(gradient, 0.4, 0.02);
    }

    #[test]
    fn cells_alternate_also_across_zero() {
        let check = |x: f64, expected: bool| {
            assert_eq!(is_odd(DVec3::new(x, 0.5, 0.5)), expected, "{x}");
        };
        check(0.5, false);
        check(1.5, true);
        check(-0.5, true);
        check(-1.5, false);
        check(1e300, is_odd(DVec3::new(1e300, 0.5, 0.5)));
    }

    #[test]
    fn the_point_goes_from_texture_to_texture() {
        let mut moved = texture(Null);
        moved.texture_from_point = DMat4::from_translation(DVec3::X);
        let checker = || texture(Checker { surface: 0 });
        let color =
            |textures: &[RtraceTexture]| textured(textures, DVec3::splat(0.5)).surface.color;
        assert_eq!(color(&[checker()]), GREY);
        assert_eq!(color(&[moved.clone(), checker()]), Rgb::WHITE);
        assert_eq!(color(&[moved.clone(), moved, checker()]), GREY);
    }

    #[test]
    fn a_perspective_row_divides() {
        let mut map = DMat4::IDENTITY;
        map.w_axis.w = 4.0;
        assert_eq!(transformed(&map, DVec3::splat(2.0)), DVec3::splat(0.5));
        assert_eq!(transformed(&DMat4::ZERO, DVec3::ONE), DVec3::ZERO);
    }

    #[test]
    fn gloss_moves_light_from_diffuse_to_mirror() {
        let glossy = textured(&[texture(Gloss { k: 0.1 })], DVec3::new(0.3, 0.7, 0.1)).surface;
        let before = surface(GREY);
        assert!(glossy.specular.r > before.specular.r && glossy.phong > 1.0);
        let sum = |s: RtraceSurface| s.diffuse.r + s.specular.r;
        assert!((sum(glossy) - sum(before)).abs() < 1e-12);
    }

    #[test]
    fn an_image_that_does_not_tile_stays_in_its_square() {
        let image = |tiles| {
            texture(ImageMap {
                turbulence: 0.0,
                tiles,
                axes: [0, 1],
                image: Arc::new(Image::new(2, 2)),
            })
        };
        let color = |tiles, x| {
            textured(&[image(tiles)], DVec3::new(x, 0.5, 0.5))
                .surface
                .color
        };
        assert_eq!(color(false, 0.5), Rgb::BLACK);
        assert_eq!(color(false, 1.5), GREY);
        assert_eq!(color(true, 1.5), Rgb::BLACK);
    }

    #[test]
    fn numbers_out_of_all_bounds_leave_finite_colours() {
        let wild = [
            Fbm {
                offset: 1.0,
                k: 1e5,
                omega: 1.0,
                lambda: 0.0,
                threshold: 0.0,
                octaves: 1e5,
                map: None,
            },
            FbmBump {
                offset: 1.0,
                k: 1e5,
                omega: 1.0,
                lambda: 0.0,
                octaves: 1e5,
            },
            Blotch { k: 1.0, surface: 0 },
            Gloss { k: 1e5 },
            Bump3 { k: 1e5, size: 0.0 },
            Bozo {
                turbulence: 1e308,
                map: None,
            },
        ];
        for kind in wild {
            let textures = [texture(kind), texture(Checker { surface: 0 })];
            for p in points() {
                let patterned = textured(&textures, 1e300 * p);
                assert!(patterned.surface.color.is_finite() && patterned.normal.is_finite());
            }
        }
    }
}
