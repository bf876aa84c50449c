//! A device at work, and the processor in its place when it fails.

use crate::engine::DrawnBy;
use azulejo_trace::item_buffer::{
    Device, DrawError, ItemBuffers, Processor, ProcessorBuffers, Seen, Settings, View, World,
};
use std::sync::{Mutex, PoisonError, RwLock};

/// A world on whatever draws it.
pub(super) struct Drawn {
    settings: Settings,
    drawer: RwLock<Drawer>,
    notes: Mutex<Vec<String>>,
}

enum Drawer {
    /// A device, and the world for the processor, should it have to take over.
    Device {
        name: String,
        buffers: Box<dyn ItemBuffers>,
        world: World,
    },
    Processor(ProcessorBuffers),
}

impl Drawn {
    /// Brings the world to the device, or to the processor if that fails.
    pub fn new(world: World, settings: Settings, by: &DrawnBy) -> Drawn {
        let mut notes = Vec::new();
        let drawer = match by {
            DrawnBy::Processor => Drawer::processor(&world, &settings),
            DrawnBy::Device(device) => match device.load(&world, &settings) {
                Ok(buffers) => Drawer::Device {
                    name: device.name(),
                    buffers,
                    world,
                },
                Err(error) => {
                    notes.push(format!("the processor draws instead: {error}"));
                    Drawer::processor(&world, &settings)
                }
            },
        };
        Drawn {
            settings,
            drawer: RwLock::new(drawer),
            notes: Mutex::new(notes),
        }
    }

    /// Who draws now.
    pub fn device(&self) -> String {
        match &*self.drawer.read().unwrap_or_else(PoisonError::into_inner) {
            Drawer::Device { name, .. } => name.clone(),
            Drawer::Processor(_) => Processor.name(),
        }
    }

    /// What went otherwise than asked so far.
    pub fn notes(&self) -> Vec<String> {
        let notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
        notes.clone()
    }

    /// How many views a call should bring.
    pub fn batch(&self) -> usize {
        let drawer = self.drawer.read().unwrap_or_else(PoisonError::into_inner);
        match &*drawer {
            Drawer::Device { buffers, .. } => buffers.batch().max(1),
            Drawer::Processor(buffers) => buffers.batch(),
        }
    }

    /// One answer per view. The processor takes over for good from a device that fails.
    pub fn draw(&self, views: &[View]) -> Vec<Seen> {
        let error = match &*self.drawer.read().unwrap_or_else(PoisonError::into_inner) {
            Drawer::Processor(buffers) => return buffers.see(views),
            Drawer::Device { buffers, .. } => match buffers.draw(views) {
                Ok(seen) if seen.len() == views.len() => return seen,
                Ok(seen) => {
                    let (found, asked) = (seen.len(), views.len());
                    DrawError::Lost(format!("it drew {found} of {asked} hemicubes"))
                }
                Err(error) => error,
            },
        };
        self.replace(&error);
        match &*self.drawer.read().unwrap_or_else(PoisonError::into_inner) {
            Drawer::Processor(buffers) => buffers.see(views),
            // Nobody puts a device back.
            Drawer::Device { .. } => Vec::new(),
        }
    }

    /// Puts the processor in the device's place, unless another thread already did.
    fn replace(&self, error: &DrawError) {
        let mut drawer = self.drawer.write().unwrap_or_else(PoisonError::into_inner);
        if let Drawer::Device { name, world, .. } = &*drawer {
            let note = format!("the processor took over from {name}: {error}");
            let mut notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
            notes.push(note);
            *drawer = Drawer::processor(world, &self.settings);
        }
    }
}

impl Drawer {
    fn processor(world: &World, settings: &Settings) -> Drawer {
        Drawer::Processor(ProcessorBuffers::new(world, settings))
    }
}
