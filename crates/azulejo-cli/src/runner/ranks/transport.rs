//! What ranks need of MPI.

/// Messages between ranks. Used by one thread of each.
pub trait Transport {
    /// Number of this rank.
    fn rank(&self) -> usize;

    /// Number of all.
    fn size(&self) -> usize;

    /// Sends bytes to a rank. Those to one rank arrive in their order.
    fn send(&self, to: usize, bytes: &[u8]);

    /// The next message that has arrived, with the rank that sent it; `None` if there is none yet.
    fn receive(&self) -> Option<(usize, Vec<u8>)>;

    /// The bytes of all ranks, in their order. All ranks call it.
    fn all_gather(&self, own: &[u8]) -> Vec<Vec<u8>>;

    /// The bytes of rank 0. All ranks call it; `own` counts at rank 0.
    fn broadcast(&self, own: Vec<u8>) -> Vec<u8>;
}
