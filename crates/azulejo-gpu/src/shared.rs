//! An opened card, shared by all worlds in its memory.

use crate::pipelines::Pipelines;
use azulejo_trace::item_buffer::DrawError;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// The place where the form factors of pixels are summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reduction {
    /// Pixels are read back and summed by the processor: best for software drivers, and if there
    /// are fewer pixels than patches.
    ReadBack,
    /// The card sums in integers, so that the result does not depend on the order of additions.
    Compute,
}

/// The opened card, shared by all worlds in its memory.
pub struct Shared {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub limits: wgpu::Limits,
    pub is_software: bool,
    pub can_compute: bool,
    pub pipelines: Pipelines,
    pub info: wgpu::AdapterInfo,
    /// The reason of the card's loss, once it is lost.
    pub lost: Arc<Mutex<Option<String>>>,
    /// Held by the thread that uses the card: wgpu's OpenGL panics if a thread waits too long for
    /// another's context.
    pub gate: Mutex<()>,
}

/// A card that has not responded for this long counts as lost.
const PATIENCE: Duration = Duration::from_secs(120);

impl Shared {
    /// Waits until no other thread uses the card.
    pub fn gate(&self) -> MutexGuard<'_, ()> {
        self.gate.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns an error if the card has been lost.
    pub fn check(&self) -> Result<(), DrawError> {
        let lost = self.lost.lock().unwrap_or_else(PoisonError::into_inner);
        lost.as_ref()
            .map_or(Ok(()), |why| Err(DrawError::Lost(why.clone())))
    }

    /// Waits until a submission is complete and its callbacks have run.
    pub fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<(), DrawError> {
        let poll = wgpu::PollType::Wait {
            submission_index: Some(submission),
            timeout: Some(PATIENCE),
        };
        let polled = self.device.poll(poll);
        self.check()?;
        match polled {
            Ok(_) => Ok(()),
            Err(wgpu::PollError::Timeout) => {
                let seconds = PATIENCE.as_secs();
                let why = format!("{} did not respond for {seconds} s", self.info.name);
                Err(self.lose(why))
            }
            Err(other) => Err(self.lose(other.to_string())),
        }
    }

    /// Records the loss of the card and its reason.
    pub fn lose(&self, why: String) -> DrawError {
        note(&self.lost, why.clone());
        DrawError::Lost(why)
    }

    /// Allocates in the card's memory; `None` if there is not enough.
    pub fn allocate<T>(&self, make: impl FnOnce(&wgpu::Device) -> T) -> Option<T> {
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let made = make(&self.device);
        match pollster::block_on(scope.pop()) {
            None => Some(made),
            Some(_) => None,
        }
    }
}

/// Keeps the first reason, because later ones are its consequences.
fn note(lost: &Mutex<Option<String>>, why: String) {
    let mut lost = lost.lock().unwrap_or_else(PoisonError::into_inner);
    lost.get_or_insert(why);
}

/// Records the loss of the device, and unexpected errors; without listeners wgpu would panic.
pub fn listen(device: &wgpu::Device) -> Arc<Mutex<Option<String>>> {
    let lost = Arc::new(Mutex::new(None));
    let slot = lost.clone();
    device.set_device_lost_callback(move |reason, message| {
        note(&slot, format!("{message} ({reason:?})"));
    });
    let slot = lost.clone();
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
        note(&slot, error.to_string());
    }));
    lost
}
