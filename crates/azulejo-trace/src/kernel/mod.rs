//! The kernel: finds the first triangle or other shape that a ray hits, or whether it hits any.
//!
//! It is independent of scenes and the world: it takes triangles and boxes in coordinates of
//! −1..=1, and returns item numbers ([`KernelHit`]). Other shapes in its leaves are intersected
//! through [`OtherShapes`]. Its parts:
//!
//! - [`binary_tree`] orders boxes ([`Reference`]) into a tree. Meshes that are solids and item
//!   buffers traverse that tree themselves.
//! - [`Bvh::collapse`] widens it to nodes of eight boxes above packets of four triangles.
//! - [`InstructionSet::closest`] and [`InstructionSet::any`] trace batches of rays through it, in
//!   AVX2 where the machine has it and in plain Rust elsewhere, with the same hits to the bit.
//! - [`Kernel`] and [`ExternalKernel`] let another library trace the triangles, which is Embree so
//!   far.
//! - [`vectorized`] runs other code with the same choice of instructions.
//!
//! | what | where | source |
//! |---|---|---|
//! | building by the surface area heuristic, in bins | `build` | Wald, *On fast Construction of SAH-based Bounding Volume Hierarchies*, 2007 |
//! | nodes of eight boxes | `bvh` | Dammertz, Hanika and Keller, *Shallow Bounding Volume Hierarchies for Fast SIMD Ray Tracing of Incoherent Rays*, EGSR 2008 |
//! | their choice from a binary tree | `bvh` | Ylitie, Karras and Laine, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, HPG 2017 |
//! | boxes no ray slips past | `traversal`, `prepared_ray` | Ize, *Robust BVH Ray Traversal*, JCGT 2(2), 2013 |
//! | triangles without gaps | `portable`, `simd`, `triangle` | Woop, Benthin and Wald, *Watertight Ray/Triangle Intersection*, JCGT 2(1), 2013 |
//! | Embree | `embree` | Wald et al., *Embree: A Kernel Framework for Efficient CPU Ray Tracing*, SIGGRAPH 2014 |

mod build;
mod bvh;
pub mod embree;
mod external;
mod portable;
mod prepared_ray;
mod ray;
mod simd;
#[cfg(test)]
mod tests;
mod traversal;
mod triangle;

pub(crate) use build::{BinaryNode, DEEPEST, Reference, binary_tree};
pub(crate) use bvh::{Bvh, KernelTriangle};
pub(crate) use external::ExternalKernel;
pub use external::Kernel;
pub(crate) use ray::SolidPart;
pub use ray::{KernelHit, KernelRay};
pub(crate) use simd::{InstructionSet, Vectorized, vectorized};
pub(crate) use traversal::{KernelScene, OtherShapes};
