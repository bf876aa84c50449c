//! What can go wrong with a graphics card, and what to do then.

use std::fmt;

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no card and no driver that does without one.
    Missing {
        /// Which adapters there are; none of them can draw this.
        found: Vec<String>,
    },
    /// The driver refuses to open the card.
    Refused {
        /// The card.
        name: String,
        /// What the driver says.
        reason: String,
    },
    /// The card was unplugged, reset or hung up. A new device must be opened.
    Lost {
        /// What the driver says.
        reason: String,
    },
    /// The card's memory does not suffice.
    OutOfMemory,
    /// A picture is larger than the card can make.
    TooLarge {
        /// What was asked for, pixels.
        asked: [u32; 2],
        /// The most that a side may have.
        most: u32,
    },
    /// The driver did not take what it was given.
    Rejected {
        /// What the driver says.
        reason: String,
    },
}

/// What to install where no driver is found.
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
                let found = found.join(", ");
                write!(
                    f,
                    "no graphics card that can draw this, only {found}. {INSTALL}"
                )
            }
            GpuError::Refused { name, reason } => {
                write!(
                    f,
                    "the driver of {name} refuses to open it: {reason}. Close programs that use \
                     it, or set WGPU_BACKEND to gl or vulkan"
                )
            }
            GpuError::Lost { reason } => {
                write!(
                    f,
                    "the graphics card is lost: {reason}. The work is not; save it and start again"
                )
            }
            GpuError::OutOfMemory => write!(
                f,
                "the graphics card's memory does not suffice: hide objects, show them without \
                 lines or patches, or make the window smaller"
            ),
            GpuError::TooLarge { asked, most } => write!(
                f,
                "a picture of {} x {} pixels is too large: this card makes up to {most} on a side",
                asked[0], asked[1]
            ),
            GpuError::Rejected { reason } => {
                write!(f, "the graphics driver rejects the picture: {reason}")
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
