//! Random numbers along a path.

use azulejo_trace::sampling::{DIMENSIONS, hash, sobol, uniform};

/// The random numbers of one path: stratified over the samples of its stream.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathSampler {
    pub stream: u32,
    pub sample: u32,
    used: u32,
}

impl PathSampler {
    /// The numbers of sample `sample` of pixel or probe ray `stream`.
    pub fn new(stream: u32, sample: u32) -> PathSampler {
        PathSampler {
            stream,
            sample,
            used: 0,
        }
    }

    /// Whether any number was used, so that another sample may differ.
    pub fn is_used(&self) -> bool {
        self.used > 0
    }

    /// The next number in 0..1.
    ///
    /// The first six come from Sobol dimensions 2 to 7 (the film has 0 and 1).
    pub fn next(&mut self, seed: u32) -> f64 {
        let dimension = self.used + 2;
        self.used += 1;
        let key = [seed, self.stream, dimension];
        f64::from(if (dimension as usize) < DIMENSIONS {
            sobol(self.sample, dimension as usize, hash(&key))
        } else {
            uniform(&[hash(&key), self.sample])
        })
    }
}
