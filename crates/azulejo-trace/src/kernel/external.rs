//! The choice of the kernel that traces triangles: our own or another.

use super::bvh::KernelTriangle;
use super::embree::{Embree, EmbreeScene};
use super::ray::{KernelHit, KernelRay};
use std::sync::Arc;

/// The kernel that traces the triangles of meshes. All other shapes, and trees that hold
/// instances, are traced by our own.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Kernel {
    /// Our own.
    #[default]
    Own,
    /// Embree.
    Embree(Embree),
}

/// Triangles in a kernel other than our own: Embree's.
#[derive(Clone, Debug)]
pub(crate) struct ExternalKernel(Arc<EmbreeScene>);

impl ExternalKernel {
    /// `None` if our own kernel is selected, or if the other one ran out of memory.
    pub(crate) fn new(kernel: &Kernel, triangles: &[KernelTriangle]) -> Option<ExternalKernel> {
        match kernel {
            Kernel::Own => None,
            Kernel::Embree(embree) => {
                let scene = EmbreeScene::of(embree, triangles).ok()?;
                Some(ExternalKernel(Arc::new(scene)))
            }
        }
    }

    pub(crate) fn kernel(&self) -> Kernel {
        Kernel::Embree(self.0.embree().clone())
    }

    pub(crate) fn name(&self) -> String {
        format!("Embree {}", self.0.embree().version())
    }

    pub(crate) fn closest(&self, rays: &[KernelRay], hits: &mut [KernelHit]) {
        self.0.closest(rays, hits);
    }

    pub(crate) fn any(&self, rays: &[KernelRay], blocked: &mut [bool]) {
        self.0.any(rays, blocked);
    }
}
