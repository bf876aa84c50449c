//! The backend that renders item buffers; the processor takes over when a device fails.

use crate::engine::HemicubeBackend;
use azulejo_trace::item_buffer::{
    Device, DrawError, ItemBuffers, Processor, ProcessorBuffers, Seen, Settings, View, World,
};
use std::sync::{Mutex, PoisonError, RwLock, RwLockReadGuard};

/// A scene loaded into a backend.
pub(super) struct BackendBuffers {
    settings: Settings,
    active: RwLock<ActiveBackend>,
    notes: Mutex<Vec<String>>,
}

enum ActiveBackend {
    /// A device, and the scene for the processor in case it has to take over.
    Device {
        name: String,
        buffers: Box<dyn ItemBuffers>,
        world: World,
    },
    Processor(ProcessorBuffers),
}

impl BackendBuffers {
    /// Loads the scene into the device, or into the processor if that fails.
    pub fn new(world: World, settings: Settings, by: &HemicubeBackend) -> BackendBuffers {
        let mut notes = Vec::new();
        let active = match by {
            HemicubeBackend::Processor => ActiveBackend::processor(&world, &settings),
            HemicubeBackend::Device(device) => match device.load(&world, &settings) {
                Ok(buffers) => ActiveBackend::Device {
                    name: device.name(),
                    buffers,
                    world,
                },
                Err(error) => {
                    notes.push(format!("the processor renders instead: {error}"));
                    ActiveBackend::processor(&world, &settings)
                }
            },
        };
        BackendBuffers {
            settings,
            active: RwLock::new(active),
            notes: Mutex::new(notes),
        }
    }

    fn active(&self) -> RwLockReadGuard<'_, ActiveBackend> {
        self.active.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// The name of the backend in use.
    pub fn device(&self) -> String {
        match &*self.active() {
            ActiveBackend::Device { name, .. } => name.clone(),
            ActiveBackend::Processor(_) => Processor.name(),
        }
    }

    /// Deviations from what was requested so far.
    pub fn notes(&self) -> Vec<String> {
        let notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
        notes.clone()
    }

    /// How many views a call should contain.
    pub fn batch(&self) -> usize {
        match &*self.active() {
            ActiveBackend::Device { buffers, .. } => buffers.batch().max(1),
            ActiveBackend::Processor(buffers) => buffers.batch(),
        }
    }

    /// One answer per view. The processor takes over for good from a device that fails.
    pub fn draw(&self, views: &[View]) -> Vec<Seen> {
        let error = match &*self.active() {
            ActiveBackend::Processor(buffers) => return buffers.see(views),
            ActiveBackend::Device { buffers, .. } => match buffers.draw(views) {
                Ok(seen) if seen.len() == views.len() => return seen,
                Ok(seen) => {
                    let (drawn, requested) = (seen.len(), views.len());
                    DrawError::Lost(format!("it drew {drawn} of {requested} hemicubes"))
                }
                Err(error) => error,
            },
        };
        self.replace(&error);
        match &*self.active() {
            ActiveBackend::Processor(buffers) => buffers.see(views),
            // A device is never put back.
            ActiveBackend::Device { .. } => Vec::new(),
        }
    }

    /// Replaces the device by the processor, unless another thread already did.
    fn replace(&self, error: &DrawError) {
        let mut active = self.active.write().unwrap_or_else(PoisonError::into_inner);
        if let ActiveBackend::Device { name, world, .. } = &*active {
            let note = format!("the processor took over from {name}: {error}");
            let mut notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
            notes.push(note);
            *active = ActiveBackend::processor(world, &self.settings);
        }
    }
}

impl ActiveBackend {
    fn processor(world: &World, settings: &Settings) -> ActiveBackend {
        ActiveBackend::Processor(ProcessorBuffers::new(world, settings))
    }
}
