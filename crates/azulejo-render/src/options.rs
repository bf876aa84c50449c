//! How the second pass works.

/// How the second pass works.
#[derive(Clone, Debug, PartialEq)]
pub struct SecondPass {
    /// Image size in pixels, width then height. An image without pixels is allowed and empty.
    pub size: (u32, u32),
    /// Camera paths per pixel; 0 counts as 1.
    pub samples_per_pixel: u32,
    /// Where irradiance is gathered instead of interpolated between vertices.
    pub gather: FinalGather,
    /// By which share of the largest the irradiance of a face's corners may differ, beyond their errors, before
    /// [`FinalGather::Uneven`] gathers between them; > 0. A small model in a large scene has few patches, between
    /// which more may happen than in those of a room.
    pub evenness: f64,
    /// Keys all random numbers. The same seed gives the same bits, whatever the threads.
    pub seed: u64,
    /// A safety cap on mirrors and boundaries along one path, for closed rooms of perfect
    /// mirrors, from which light never leaves. What a path still carries then is lost; paths end
    /// long before it by Russian roulette, which loses nothing on average.
    pub max_depth: u32,
    /// The most radiance, W/(sr·m²), that paths behind the first surface that scatters may add to one
    /// sample: above it is scaled down, which removes bright dots, and light. `None` removes
    /// nothing.
    pub clamp: Option<f64>,
    /// Contrast up to which a pixel is even, and four paths suffice for it, unless these are random: the difference
    /// from the pixels beside it, and twice the standard deviation of its paths, relative to the brighter. `None`
    /// gives all paths to all pixels.
    pub contrast: Option<f64>,
}

/// Where paths gather irradiance, by rays over the hemisphere and the direct light of all lamps and
/// lights, at the diffuse surfaces that the camera sees straight or by mirrors and glass, instead of
/// interpolating it between vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FinalGather {
    /// Nowhere but on sides of which the scene carries no irradiance.
    #[default]
    Unknown,
    /// Also where the irradiance of the corners of a face differs so much that the light between
    /// them is not known: at the edges of shadows, and where a face passes from the light into the
    /// dark. So many rays at each hit.
    Uneven(u32),
    /// Everywhere, with this many rays at each hit. This hides the patches and sharpens contact shadows.
    /// It also renders a scene without irradiance, slowly: light is then followed over its first
    /// bounces only.
    Everywhere(u32),
}

impl FinalGather {
    /// Rays of a gather.
    pub(crate) fn rays(self) -> u32 {
        /// On a side of which the scene carries no irradiance.
        const BACK_RAYS: u32 = 32;
        match self {
            FinalGather::Unknown => BACK_RAYS,
            FinalGather::Uneven(rays) | FinalGather::Everywhere(rays) => rays.max(1),
        }
    }
}

impl Default for SecondPass {
    /// 512 × 512 pixels, 16 samples each, no final gather, seed 0, at most 1000 interfaces, no clamp,
    /// all samples in all pixels.
    fn default() -> SecondPass {
        SecondPass {
            size: (512, 512),
            samples_per_pixel: 16,
            gather: FinalGather::Unknown,
            evenness: 0.5,
            seed: 0,
            max_depth: 1000,
            clamp: None,
            contrast: None,
        }
    }
}

impl SecondPass {
    /// Paths that are followed together: enough to keep the kernel busy, few enough for the
    /// cache and for cancelling within a moment.
    pub(crate) fn batch(&self) -> u32 {
        const RAYS: u32 = 4096;
        const GATHER_RAYS: u32 = 1 << 18;
        let gathers = match self.gather {
            FinalGather::Everywhere(rays) => rays.max(1),
            FinalGather::Unknown | FinalGather::Uneven(_) => 1,
        };
        (GATHER_RAYS / gathers).clamp(1, RAYS)
    }
}
