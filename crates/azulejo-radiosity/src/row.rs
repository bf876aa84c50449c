//! Rows of extended form factors: what one side of a patch sees.

use azulejo_scene::Rgb;
use azulejo_trace::REPLICATES;
use azulejo_trace::follow::Via;

/// One side of a patch: twice the patch for the front, one more for the back.
pub type Side = u32;

/// The side of `patch` that is seen from its front, or from its back.
pub fn side(patch: u32, front: bool) -> Side {
    2 * patch + u32::from(!front)
}

/// Number of ways that entries tell apart.
pub const ORDERS: usize = 3;

/// How light came: 0 straight, 1 by one mirror, 2 by more of them or through glass.
pub type Order = u8;

/// The order of what came this way.
pub fn order(via: Via) -> Order {
    match via {
        Via::Direct => 0,
        Via::Mirror(_) => 1,
        Via::Many => 2,
    }
}

/// An extended form factor to one side, of light that came one way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Where the light arrives.
    pub side: Side,
    /// How it came.
    pub order: Order,
    /// Form factor, per channel.
    pub weight: [f32; 3],
}

/// Entries of one replicate of a row, sorted by side and order, each pair once.
pub type Entries = Vec<Entry>;

/// What an estimator found of one side of a patch.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// Per replicate, the extended form factor to each side that was reached.
    pub entries: [Entries; REPLICATES],
    /// Per replicate, irradiance from emission and surroundings that was met on the way and that
    /// [`direct light`](crate::direct) does not count, W/m².
    pub stray: [Rgb; REPLICATES],
    /// The part of `stray` that came from the surroundings.
    pub foreign: Rgb,
    /// Share of the weight that surfaces absorbed.
    pub absorbed: Rgb,
    /// Share that left the scene, upwards and downwards.
    pub escaped: [Rgb; 2],
    /// Share that was cut off because it was too weak, or reflected too often.
    pub cut: Rgb,
    /// Rays traced, or pixels drawn, from the patch, without those that mirrors added.
    pub rays: u32,
}

impl Row {
    /// Share that left the scene, either way.
    pub fn all_escaped(&self) -> Rgb {
        self.escaped[0] + self.escaped[1]
    }
}

/// Which sides of patches a row keeps as columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Columns {
    /// All that is reached, mirrors too: whole rows, whose shares add up.
    All,
    /// Only sides that reflect diffusely: what a solver needs.
    Diffuse,
}

/// Sorts what was found and adds up what belongs together, in `f64`, in the order found.
pub(crate) fn merged(mut found: Entries) -> Entries {
    // A stable sort keeps the order of the finds, so sums depend on nothing else.
    found.sort_by_key(|e| (e.side, e.order));
    let same = |a: &Entry, b: &Entry| (a.side, a.order) == (b.side, b.order);
    let sum = |group: &[Entry]| {
        let channel = |k: usize| group.iter().map(|e| f64::from(e.weight[k])).sum::<f64>() as f32;
        Entry {
            weight: [channel(0), channel(1), channel(2)],
            ..group[0]
        }
    };
    found.chunk_by(same).map(sum).collect()
}
