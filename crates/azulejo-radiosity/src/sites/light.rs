//! Light with its error.

use azulejo_scene::Rgb;
use azulejo_trace::Gathered;
use azulejo_trace::run::{Record, RecordReader};

/// Irradiance with its standard error, W/m² (lx in photometric scenes): in single precision, because there is one
/// for each of millions of texels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SiteLight {
    /// The value.
    pub irradiance: [f32; 3],
    /// Its standard error.
    pub standard_error: [f32; 3],
}

impl SiteLight {
    /// The value in double precision.
    pub fn rgb(&self) -> Rgb {
        Rgb::from(self.irradiance.map(f64::from))
    }
}

impl Record for SiteLight {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.irradiance.write(bytes);
        self.standard_error.write(bytes);
    }

    fn read(bytes: &mut RecordReader) -> Option<SiteLight> {
        Some(SiteLight {
            irradiance: Record::read(bytes)?,
            standard_error: Record::read(bytes)?,
        })
    }
}

/// Direct light of each site.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SiteDirect {
    /// Irradiance, W/m².
    pub irradiance: Vec<[f32; 3]>,
    /// Its variance.
    pub variance: Vec<[f32; 3]>,
}

impl SiteDirect {
    /// No light at this many sites.
    pub fn none(count: usize) -> SiteDirect {
        SiteDirect {
            irradiance: vec![[0.0; 3]; count],
            variance: vec![[0.0; 3]; count],
        }
    }

    /// Sets the light of a site.
    pub fn set(&mut self, site: usize, found: &Gathered) {
        self.irradiance[site] = found.mean().map(|e| e.max(0.0)).to_f32();
        self.variance[site] = found.variance().to_f32();
    }

    /// This light alone, of each site.
    pub fn light(&self) -> Vec<SiteLight> {
        let all = self.irradiance.iter().zip(&self.variance);
        all.map(|(e, variance)| SiteLight {
            irradiance: *e,
            standard_error: variance.map(f32::sqrt),
        })
        .collect()
    }

    /// This light and indirect light of each site, given as its mean and standard error, W/m².
    pub fn plus(&self, indirect: impl Iterator<Item = (Rgb, Rgb)>) -> Vec<SiteLight> {
        let all = indirect.enumerate();
        all.map(|(site, (value, error))| {
            let variance = Rgb::from(self.variance[site].map(f64::from)) + error * error;
            SiteLight {
                irradiance: (self.mean(site) + value).map(|e| e.max(0.0)).to_f32(),
                standard_error: variance.map(f64::sqrt).to_f32(),
            }
        })
        .collect()
    }

    /// Takes this light, and its error, out of the light of all sites.
    pub fn take_from(&self, light: &mut [SiteLight]) {
        let direct = self.irradiance.iter().zip(&self.variance);
        for (all, (direct, variance)) in light.iter_mut().zip(direct) {
            for k in 0..3 {
                all.irradiance[k] = (all.irradiance[k] - direct[k]).max(0.0);
                let rest = all.standard_error[k].powi(2) - variance[k];
                all.standard_error[k] = rest.max(0.0).sqrt();
            }
        }
    }

    /// Irradiance of a site.
    pub fn mean(&self, site: usize) -> Rgb {
        Rgb::from(self.irradiance[site].map(f64::from))
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

/// Numbers of rays of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PairRays {
    /// Those that read light.
    pub read: u32,
    /// Those of them that are also path traced.
    pub traced: u32,
}
