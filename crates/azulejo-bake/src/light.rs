//! Light with its error.

use azulejo_scene::Rgb;
use azulejo_trace::Gathered;
use azulejo_trace::run::{Record, RecordReader};

/// Irradiance with its standard error, W/m² (lx in photometric scenes): in single precision, because there is one
/// for each of millions of texels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexelLight {
    /// The value.
    pub irradiance: [f32; 3],
    /// Its standard error.
    pub standard_error: [f32; 3],
}

impl TexelLight {
    /// The value in double precision.
    pub(crate) fn rgb(&self) -> Rgb {
        Rgb::from(self.irradiance.map(f64::from))
    }
}

impl Record for TexelLight {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.irradiance.write(bytes);
        self.standard_error.write(bytes);
    }

    fn read(bytes: &mut RecordReader) -> Option<TexelLight> {
        Some(TexelLight {
            irradiance: Record::read(bytes)?,
            standard_error: Record::read(bytes)?,
        })
    }
}

/// Indirect light of a node, W/m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct NodeLight {
    /// Irradiance.
    pub irradiance: Gathered,
    /// Standard deviation of its own noise.
    pub noise: Rgb,
    /// Standard deviation of the noise of its correction, which it shares with the nodes around.
    pub shared_noise: Rgb,
    /// Root mean square of what the correction misses, because it is a mean over many nodes.
    pub bias: f64,
}

impl Record for NodeLight {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.irradiance.write(bytes);
        self.noise.write(bytes);
        self.shared_noise.write(bytes);
        self.bias.write(bytes);
    }

    fn read(bytes: &mut RecordReader) -> Option<NodeLight> {
        Some(NodeLight {
            irradiance: Record::read(bytes)?,
            noise: Record::read(bytes)?,
            shared_noise: Record::read(bytes)?,
            bias: Record::read(bytes)?,
        })
    }
}

impl From<Gathered> for NodeLight {
    fn from(irradiance: Gathered) -> NodeLight {
        NodeLight {
            irradiance,
            noise: irradiance.variance().map(f64::sqrt),
            ..NodeLight::default()
        }
    }
}

/// Indirect light of a node, found in two ways, W/m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NodePair {
    /// From rays that read light where they end.
    pub read: Gathered,
    /// The same from the first few of them.
    pub few: Gathered,
    /// Path traced, from the same directions as `few`.
    pub traced: Gathered,
}

/// Numbers of rays of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PairRays {
    /// Those that read light.
    pub read: u32,
    /// Those of them that are also path traced.
    pub traced: u32,
}
