//! How many rays each node gets.
//!
//! Of all ways to bring the mean square of noise to what is permitted, the cheapest has each node's rays grow
//! with the root of its area times its variance (Neyman, *On the two different aspects of the representative
//! method*, 1934, for strata; here with another rate for rays that read light). Light that is even needs few.

use super::light::PairRays;
use rayon::prelude::*;

/// Cost of a path beside that of a ray that reads light.
const PATH_COST: f64 = 5.0;

/// The variance of read light falls with rays n about as n^−1.2, between random, 1, and 2-D strata, 3/2.
pub(crate) const READ_RATE: f64 = 1.2;

/// The variance of paths falls as their number grows.
const TRACED_RATE: f64 = 1.0;

/// Most rays of a node that read light, and of those that are paths.
const MOST_RAYS: PairRays = PairRays {
    read: 1 << 14,
    traced: 1 << 12,
};

/// Largest growth of rays at once: variances of few rays are not known well.
const GROWTH: f64 = 8.0;

/// Steps of the search for the price of variance, by factors of the root of 2 at last.
const STEPS: u32 = 40;

/// From this part of a doubling on, rays are doubled.
const ROUNDING: f64 = 0.4;

/// Noise of a node, as a part of that of all.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct NodeNoise {
    /// Area times the variance of what is read.
    pub read: f64,
    /// Area times the variance of its correction by paths.
    pub traced: f64,
}

/// Rays with which the sum of the noise of all nodes falls to `permitted`, or as many as can be added at once:
/// never fewer than there are.
pub(crate) fn allocated(
    current: &[PairRays],
    noise: &[NodeNoise],
    permitted: f64,
) -> Vec<PairRays> {
    let left = |price: f64| -> f64 {
        let of_node = |(&rays, noise): (&PairRays, &NodeNoise)| {
            let [read, traced] = growths(rays, noise, price);
            noise.read * read.powf(-READ_RATE) + noise.traced * traced.powf(-TRACED_RATE)
        };
        // The sum is in the order of nodes, whatever the number of threads.
        let all: Vec<f64> = current.par_iter().zip(noise).map(of_node).collect();
        all.iter().sum()
    };
    // Variance per ray: the lower, the more rays.
    let (mut low, mut high) = (-200.0_f64, 200.0_f64);
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        if left(middle.exp2()) <= permitted {
            low = middle;
        } else {
            high = middle;
        }
    }
    let price = low.exp2();
    let grown = |rays: u32, growth: f64, most: u32| {
        let steps = (growth.log2() - ROUNDING).ceil().max(0.0) as u32;
        (rays << steps).min(most.max(rays))
    };
    let of_node = |(&rays, noise): (&PairRays, &NodeNoise)| {
        let [read, traced] = growths(rays, noise, price);
        let traced = grown(rays.traced, traced, MOST_RAYS.traced);
        PairRays {
            // Paths are some of the rays that read light.
            read: grown(rays.read, read, MOST_RAYS.read).max(traced),
            traced,
        }
    };
    current.iter().zip(noise).map(of_node).collect()
}

/// Factors by which both kinds of rays grow where a ray is worth this much variance.
fn growths(rays: PairRays, noise: &NodeNoise, price: f64) -> [f64; 2] {
    // d/dx (v x^−r) = −price · cost, in multiples x of the present rays.
    let of = |variance: f64, rate: f64, cost: f64| {
        let growth =
            (rate * variance / (price * cost).max(f64::MIN_POSITIVE)).powf(1.0 / (1.0 + rate));
        growth.clamp(1.0, GROWTH)
    };
    [
        of(noise.read, READ_RATE, f64::from(rays.read)),
        of(
            noise.traced,
            TRACED_RATE,
            PATH_COST * f64::from(rays.traced),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const FEW: PairRays = PairRays {
        read: 64,
        traced: 16,
    };

    #[test]
    fn rays_go_where_noise_is() {
        let noise = |read| NodeNoise { read, traced: 0.0 };
        let noises: Vec<NodeNoise> = [1.0, 0.01, 0.0].map(noise).to_vec();
        let of_nodes = allocated(&[FEW; 3], &noises, 0.3);
        assert!(of_nodes[0].read >= 2 * FEW.read, "{of_nodes:?}");
        assert_eq!(of_nodes[1..], [FEW; 2]);
        assert!(of_nodes.iter().all(|rays| rays.traced == FEW.traced));
    }

    #[test]
    fn what_is_permitted_is_about_reached_at_least_cost() {
        let noises: Vec<NodeNoise> = (0..1000)
            .map(|k| NodeNoise {
                read: f64::from(k % 17) / 17.0,
                traced: f64::from(k % 5) / 5.0,
            })
            .collect();
        let all: f64 = noises.iter().map(|n| n.read + n.traced).sum();
        let current = vec![FEW; noises.len()];
        let of_nodes = allocated(&current, &noises, 0.4 * all);
        let left = |rays: &[PairRays]| -> f64 {
            let of = |(noise, rays): (&NodeNoise, &PairRays)| {
                noise.read * (f64::from(rays.read) / 64.0).powf(-READ_RATE)
                    + noise.traced * 16.0 / f64::from(rays.traced)
            };
            noises.iter().zip(rays).map(of).sum()
        };
        let cost = |rays: &[PairRays]| -> f64 {
            let of = |r: &PairRays| f64::from(r.read) + PATH_COST * f64::from(r.traced);
            rays.iter().map(of).sum()
        };
        let share = left(&of_nodes) / all;
        assert!((0.3..0.5).contains(&share), "{share}");
        // More than if all nodes got the same.
        let alike = vec![
            PairRays {
                read: 128,
                traced: 64
            };
            noises.len()
        ];
        assert!(left(&alike) > 0.3 * all && cost(&of_nodes) < cost(&alike));
        // What is quiet enough stays.
        assert_eq!(allocated(&current, &noises, 1.01 * all), current);
    }

    #[test]
    fn rays_have_limits() {
        let noise = NodeNoise {
            read: 1e9,
            traced: f64::INFINITY,
        };
        let mut rays = vec![FEW];
        for _ in 0..6 {
            rays = allocated(&rays, &[noise], 1e-9);
        }
        assert_eq!(rays, [MOST_RAYS]);
        let silent = NodeNoise::default();
        assert_eq!(allocated(&[FEW], &[silent], 0.0), [FEW]);
    }
}
