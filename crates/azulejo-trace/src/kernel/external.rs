//! The choice of the kernel that traces triangles: our own or another.

use super::bvh::KernelTriangle;
#[cfg(feature = "embree")]
use super::embree::{Embree, EmbreeScene};
use super::ray::{KernelHit, KernelRay};
#[cfg(feature = "embree")]
use std::sync::Arc;

/// The kernel that traces the triangles of meshes. All other shapes, and trees that hold
/// instances, are traced by our own.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Kernel {
    /// Our own.
    #[default]
    Own,
    /// Embree; needs the feature `embree`.
    #[cfg(feature = "embree")]
    Embree(Embree),
}

/// Triangles in a kernel other than our own. Without features there is no such kernel.
#[derive(Clone, Debug)]
pub(crate) enum ExternalKernel {
    #[cfg(feature = "embree")]
    Embree(Arc<EmbreeScene>),
}

#[cfg_attr(
    not(feature = "embree"),
    allow(
        unused_variables,
        reason = "without features there is no value to call these on"
    )
)]
impl ExternalKernel {
    /// `None` if our own kernel is selected, or if the other one ran out of memory.
    pub(crate) fn new(kernel: &Kernel, triangles: &[KernelTriangle]) -> Option<ExternalKernel> {
        match kernel {
            Kernel::Own => None,
            #[cfg(feature = "embree")]
            Kernel::Embree(embree) => {
                let scene = EmbreeScene::of(embree, triangles).ok()?;
                Some(ExternalKernel::Embree(Arc::new(scene)))
            }
        }
    }

    pub(crate) fn kernel(&self) -> Kernel {
        match *self {
            #[cfg(feature = "embree")]
            ExternalKernel::Embree(ref scene) => Kernel::Embree(scene.embree().clone()),
        }
    }

    pub(crate) fn name(&self) -> String {
        match *self {
            #[cfg(feature = "embree")]
            ExternalKernel::Embree(ref scene) => format!("Embree {}", scene.embree().version()),
        }
    }

    pub(crate) fn closest(&self, rays: &[KernelRay], hits: &mut [KernelHit]) {
        match *self {
            #[cfg(feature = "embree")]
            ExternalKernel::Embree(ref scene) => scene.closest(rays, hits),
        }
    }

    pub(crate) fn any(&self, rays: &[KernelRay], blocked: &mut [bool]) {
        match *self {
            #[cfg(feature = "embree")]
            ExternalKernel::Embree(ref scene) => scene.any(rays, blocked),
        }
    }
}
