//! Arrays of NumPy: [`npy`], one array in a file, and [`npz`], several in an archive.

pub mod npy;
pub mod npz;
