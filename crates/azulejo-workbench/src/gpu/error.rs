//! Errors of the graphics device, and advice on what to do.

use std::fmt;

/// Why nothing can be drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GpuError {
    /// There is neither a GPU nor a software driver.
    Missing {
        /// The adapters found; none of them is suitable.
        found: Vec<String>,
    },
    /// The driver failed to open the adapter.
    Refused {
        /// Name of the adapter.
        name: String,
        /// The driver's error message.
        reason: String,
    },
    /// The GPU was unplugged or reset, or it hung. A new device must be opened.
    Lost {
        /// The driver's error message.
        reason: String,
    },
    /// The GPU is out of memory.
    OutOfMemory,
    /// The requested image exceeds the limits of the GPU.
    TooLarge {
        /// Requested size, pixels.
        asked: [u32; 2],
        /// Maximum length of a side, pixels.
        most: u32,
    },
    /// The driver rejected a call.
    Rejected {
        /// The driver's error message.
        reason: String,
    },
}

/// Advice for systems without a driver.
const INSTALL: &str = "Install a graphics driver: the card's own, or Mesa's, which also draws on \
                       machines without a card (Debian and Ubuntu: apt install \
                       mesa-vulkan-drivers libvulkan1 libegl1 libgl1-mesa-dri)";

impl fmt::Display for GpuError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            GpuError::Missing { found } if found.is_empty() => {
                write!(
                    f,
                    "no graphics card or driver for Vulkan or OpenGL. {INSTALL}"
                )
            }
            GpuError::Missing { found } => {
                let adapters = found.join(", ");
                write!(
                    f,
                    "no suitable graphics adapter, only {adapters}. {INSTALL}"
                )
            }
            GpuError::Refused { name, reason } => {
                write!(
                    f,
                    "the driver of {name} cannot open it: {reason}. Close programs that use \
                     it, or set WGPU_BACKEND to gl or vulkan"
                )
            }
            GpuError::Lost { reason } => {
                write!(
                    f,
                    "the graphics device is lost: {reason}. Your work is not; save it and restart"
                )
            }
            GpuError::OutOfMemory => write!(
                f,
                "the graphics card is out of memory: hide objects, show them without lines or \
                 patches, or make the window smaller"
            ),
            GpuError::TooLarge { asked, most } => write!(
                f,
                "an image of {} x {} pixels is too large: this card supports up to {most} per side",
                asked[0], asked[1]
            ),
            GpuError::Rejected { reason } => {
                write!(f, "the graphics driver rejected a call: {reason}")
            }
        }
    }
}

impl std::error::Error for GpuError {}

impl From<wgpu::Error> for GpuError {
    fn from(error: wgpu::Error) -> GpuError {
        match error {
            wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory,
            other => GpuError::Rejected {
                reason: other.to_string(),
            },
        }
    }
}
