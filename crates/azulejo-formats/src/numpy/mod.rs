//! Arrays of NumPy: [`npy`], one array in a file, and [`npz`], several in an archive.

pub mod npy;
pub mod npz;

use std::io::{self, Write};

/// Whether arrays are compressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ArrayCompression {
    /// As they are: larger, and written several times as fast.
    None,
    /// Deflated at the fastest level, because higher ones gain little on numbers.
    #[default]
    Fast,
}

/// Level of [`ArrayCompression::Fast`], 1 to 9.
pub(crate) const LEVEL: u32 = 1;

/// Where several named arrays are written, one after the other.
pub trait ArraySink {
    /// Adds an array: `write`, which is called once, writes it as the content of an `.npy` file by the
    /// functions of [`npy`].
    ///
    /// # Errors
    /// Those of writing.
    fn add_array(
        &mut self,
        name: &str,
        write: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<()>;
}
