//! Edges of prisms that are cut off or rounded.

use std::f64::consts::FRAC_PI_2;

/// How a prism narrows towards one or both of its planes.
///
/// Where s is the distance of a point inside the figure from the figure's border, a bevelled prism is
/// the set of points with s ≥ δ, where the setback δ grows from 0 at the depth of the bevel to its inset at
/// the plane. So its sections are the inner parallel curves of the outline: mitred where the outline is convex,
/// round about reflex corners. Where the figure is narrower than twice the inset, no plane is left,
/// and the bevels from both sides meet in a ridge, on the medial axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bevel {
    /// Its shape in section.
    pub profile: BevelProfile,
    /// How far it reaches into the planes, in the units of the figure, > 0.
    pub inset: f64,
    /// How far it reaches along the extrusion, whose whole length is 1: > 0, and at most 1, or 1/2 at both ends.
    pub depth: f64,
    /// Which planes it surrounds.
    pub ends: BevelEnds,
}

/// The section of a bevel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BevelProfile {
    /// A straight line.
    Chamfer,
    /// A quarter of an ellipse, tangent to the side and to the plane: a quarter circle where inset
    /// and depth are equally long in the world.
    Round,
}

/// How far up one of a prism's bevels heights are: a linear function, 0 where the bevel begins and 1 on
/// the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BevelClimb {
    /// The height at which the bevel begins.
    pub from: f64,
    /// The derivative of the rise by the height; negative about the figure's own plane.
    pub slope: f64,
}

/// Where a prism has a bevel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BevelEnds {
    /// About the figure's own plane, z = 0.
    Front,
    /// About both planes.
    Both,
}

impl Bevel {
    /// Whether its numbers are in their ranges.
    pub fn is_valid(&self) -> bool {
        let most = match self.ends {
            BevelEnds::Front => 1.0,
            BevelEnds::Both => 0.5,
        };
        let fits = self.depth > 0.0 && self.depth <= most;
        fits && self.inset > 0.0 && self.inset.is_finite() && self.inset.recip().is_finite()
    }

    /// The heights of the sides between the bevels: the lower and the upper end.
    pub fn sides(&self) -> [f64; 2] {
        match self.ends {
            BevelEnds::Front => [self.depth, 1.0],
            BevelEnds::Both => [self.depth, 1.0 - self.depth],
        }
    }

    /// The bevel at a height, 0..=1; `None` between the bevels.
    pub fn climb(&self, z: f64) -> Option<BevelClimb> {
        let [low, high] = self.sides();
        let climb = |from: f64, slope: f64| Some(BevelClimb { from, slope });
        match z {
            _ if z < low => climb(low, -1.0 / self.depth),
            _ if z > high => climb(high, 1.0 / self.depth),
            _ => None,
        }
    }

    /// The setback of the surface from the figure's border at a height, figure units.
    pub fn setback(&self, z: f64) -> f64 {
        let rise = self.climb(z).map_or(0.0, |climb| climb.at(z));
        self.inset * self.profile.across(rise.clamp(0.0, 1.0))
    }
}

impl BevelClimb {
    /// The rise at a height.
    pub fn at(&self, z: f64) -> f64 {
        (z - self.from) * self.slope
    }

    /// The height of a rise.
    pub fn height(&self, rise: f64) -> f64 {
        self.from + rise / self.slope
    }
}

impl BevelProfile {
    /// The setback of the surface as a share of the inset, at a `rise` in 0..=1.
    pub fn across(self, rise: f64) -> f64 {
        match self {
            BevelProfile::Chamfer => rise,
            // 1 − √(1 − x²) without cancellation.
            BevelProfile::Round => rise * rise / (1.0 + (1.0 - rise * rise).max(0.0).sqrt()),
        }
    }

    /// The rise at which the setback is this share of the inset, 0..=1: the inverse of
    /// [`across`](BevelProfile::across).
    pub fn rise(self, across: f64) -> f64 {
        match self {
            BevelProfile::Chamfer => across,
            BevelProfile::Round => (across * (2.0 - across)).max(0.0).sqrt(),
        }
    }

    /// The derivative of [`across`](BevelProfile::across). That of a round profile is infinite at 1.
    pub fn slope(self, rise: f64) -> f64 {
        match self {
            BevelProfile::Chamfer => 1.0,
            BevelProfile::Round => rise / (1.0 - rise * rise).max(0.0).sqrt(),
        }
    }

    /// The setback, as a share of the inset, and the rise at a share of the way along the profile, from the side to the
    /// plane, with their derivatives.
    pub fn point(self, share: f64) -> [(f64, f64); 2] {
        match self {
            BevelProfile::Chamfer => [(share, 1.0); 2],
            BevelProfile::Round => {
                let (sin, cos) = (FRAC_PI_2 * share).sin_cos();
                [(1.0 - cos, FRAC_PI_2 * sin), (sin, FRAC_PI_2 * cos)]
            }
        }
    }

    /// The share of the way along the profile at a rise in 0..=1: the inverse of [`point`](BevelProfile::point).
    pub fn share(self, rise: f64) -> f64 {
        match self {
            BevelProfile::Chamfer => rise,
            BevelProfile::Round => rise.asin() / FRAC_PI_2,
        }
    }

    /// A smooth function that is 0 on the profile and positive inside, and its derivatives by the setback, as a share
    /// of the inset, and by the rise.
    pub fn equation(self, across: f64, rise: f64) -> [f64; 3] {
        match self {
            BevelProfile::Chamfer => [across - rise, 1.0, -1.0],
            BevelProfile::Round => {
                let value = across * (2.0 - across) - rise * rise;
                [value, 2.0 * (1.0 - across), -2.0 * rise]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_and_their_inverses_agree() {
        for profile in [BevelProfile::Chamfer, BevelProfile::Round] {
            for k in 0..=100 {
                let rise = f64::from(k) / 100.0;
                let across = profile.across(rise);
                assert!(
                    (profile.rise(across) - rise).abs() < 1e-12,
                    "{profile:?} {rise}"
                );
                let [(set, _), (up, _)] = profile.point(profile.share(rise));
                assert!(
                    (set - across).abs() < 1e-9 && (up - rise).abs() < 1e-9,
                    "{profile:?} {rise}"
                );
                let step = 1e-6;
                let slope =
                    (profile.across(rise + step) - profile.across(rise - step)) / (2.0 * step);
                if k < 95 {
                    assert!(
                        (slope - profile.slope(rise)).abs() < 1e-4,
                        "{profile:?} {rise}"
                    );
                }
                // Its gradient is perpendicular to the profile.
                let [value, by_across, by_rise] = profile.equation(across, rise);
                let off = (by_across * profile.slope(rise) + by_rise) / by_across.hypot(by_rise);
                assert!(value.abs() < 1e-12, "{profile:?} {rise} {value}");
                assert!(k == 100 || off.abs() < 1e-9, "{profile:?} {rise} {off}");
            }
        }
    }

    #[test]
    fn ends_are_where_they_should_be() {
        let bevel = Bevel {
            profile: BevelProfile::Round,
            inset: 2.0,
            depth: 0.25,
            ends: BevelEnds::Both,
        };
        assert!(bevel.is_valid());
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        close(bevel.setback(0.0), 2.0);
        close(bevel.setback(1.0), 2.0);
        close(bevel.setback(0.5), 0.0);
        close(bevel.setback(0.125), 2.0 * (1.0 - 0.75f64.sqrt()));
        let slopes = [0.1, 0.5, 0.9].map(|z| bevel.climb(z).map(|climb| climb.slope));
        assert_eq!(slopes, [Some(-4.0), None, Some(4.0)]);
        let front = Bevel {
            ends: BevelEnds::Front,
            ..bevel
        };
        close(front.setback(1.0), 0.0);
        for wrong in [
            Bevel {
                depth: 0.51,
                ..bevel
            },
            Bevel {
                depth: 0.0,
                ..bevel
            },
            Bevel {
                inset: f64::INFINITY,
                ..bevel
            },
            Bevel {
                inset: -1.0,
                ..front
            },
            Bevel {
                depth: f64::NAN,
                ..front
            },
        ] {
            assert!(!wrong.is_valid(), "{wrong:?}");
        }
    }
}
