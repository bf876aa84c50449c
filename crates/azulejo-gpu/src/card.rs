//! Graphics cards: finding and opening one, and detecting its loss.

use crate::buffers::Buffers;
use crate::pipelines::Pipelines;
use crate::shared::{Reduction, Shared, listen};
use azulejo_trace::item_buffer::{Device, DrawError, ItemBuffers, Settings, World};
use std::fmt;
use std::sync::{Arc, Mutex};

/// The graphics interface through which a card is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// The best card by either: hardware before software drivers, Vulkan before OpenGL. The
    /// environment variable `WGPU_BACKEND` (`vulkan`, `gl` or both with a comma) narrows it.
    #[default]
    Auto,
    /// Vulkan.
    Vulkan,
    /// OpenGL, through EGL.
    Gl,
}

/// A graphics card, or a software driver in its place.
#[derive(Clone)]
pub struct Card {
    shared: Arc<Shared>,
    reduction: Option<Reduction>,
}

impl Card {
    /// Finds a card and opens it. Software drivers count; see [`Card::is_software`].
    ///
    /// # Errors
    /// [`DrawError::Missing`]: no adapter, or none with the required features; lists the adapters
    /// found and what to install.
    pub fn open(backend: Backend) -> Result<Card, DrawError> {
        Card::open_within(backend, |limits| limits)
    }

    /// As [`open`](Card::open), with changed limits of the adapter, to test small ones.
    pub(crate) fn open_within(
        backend: Backend,
        narrow: impl Fn(wgpu::Limits) -> wgpu::Limits,
    ) -> Result<Card, DrawError> {
        let backends = wanted(backend, std::env::var("WGPU_BACKEND").ok())?;
        let adapter = best_adapter(backends)?;
        let limits = narrow(adapter.limits());
        let flags = adapter.get_downlevel_capabilities().flags;
        let can_compute = flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS)
            && limits.max_storage_buffers_per_shader_stage >= 3;
        let opened = match opened(&adapter, limits.clone(), can_compute) {
            // OpenGL of version 3.3 may have compute shaders as an extension, for which its language of
            // that version has no words.
            Err(_) if can_compute => opened(&adapter, limits, false),
            opened => opened,
        };
        let shared = opened?;
        Ok(Card {
            shared: Arc::new(shared),
            reduction: None,
        })
    }

    /// The same card with a fixed place of summation instead of the one that is probably faster.
    /// Results agree to 1e-6. Without compute shaders pixels are always read back.
    pub fn reducing(mut self, reduction: Reduction) -> Card {
        self.reduction = Some(reduction);
        self
    }

    /// Whether this is a software driver (Mesa's llvmpipe and lavapipe, SwiftShader): correct
    /// results, but no faster than the processor.
    pub fn is_software(&self) -> bool {
        self.shared.is_software
    }

    /// The same as if it were hardware, whose clusters of facets are larger.
    #[cfg(test)]
    pub(crate) fn taken_for_hardware(mut self) -> Card {
        let shared = Arc::get_mut(&mut self.shared).expect("nothing was loaded yet");
        shared.is_software = false;
        self
    }

    /// Destroys the device as if it were unplugged.
    #[cfg(test)]
    pub(crate) fn destroy(&self) {
        self.shared.device.destroy();
    }
}

impl Device for Card {
    fn name(&self) -> String {
        described(&self.shared.info)
    }

    fn load(&self, world: &World, settings: &Settings) -> Result<Box<dyn ItemBuffers>, DrawError> {
        let _gate = self.shared.gate();
        let buffers = Buffers::new(self.shared.clone(), world, settings, self.reduction)?;
        Ok(Box::new(buffers))
    }
}

impl fmt::Debug for Card {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Card").field(&self.name()).finish()
    }
}

/// The device of an adapter with azulejo's shaders, which it takes.
fn opened(
    adapter: &wgpu::Adapter,
    limits: wgpu::Limits,
    can_compute: bool,
) -> Result<Shared, DrawError> {
    let info = adapter.get_info();
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("azulejo"),
        required_limits: limits,
        ..wgpu::DeviceDescriptor::default()
    };
    let opened = pollster::block_on(adapter.request_device(&descriptor));
    let (device, queue) = opened.map_err(|e| {
        let name = described(&info);
        DrawError::Missing(format!("the driver of {name} refuses to open it: {e}"))
    })?;
    let lost = listen(&device);
    let pipelines = Pipelines::new(&device, can_compute);
    let shared = Shared {
        is_software: is_software(&info),
        limits: device.limits(),
        device,
        queue,
        can_compute,
        pipelines,
        info,
        lost,
        gate: Mutex::new(()),
    };
    shared.check().map_err(|e| {
        let name = described(&shared.info);
        DrawError::Missing(format!("{name} does not take azulejo's shaders: {e}"))
    })?;
    Ok(shared)
}

/// The interfaces to search, given the value of the environment variable.
fn wanted(backend: Backend, variable: Option<String>) -> Result<wgpu::Backends, DrawError> {
    let ours = wgpu::Backends::VULKAN | wgpu::Backends::GL;
    match backend {
        Backend::Vulkan => Ok(wgpu::Backends::VULKAN),
        Backend::Gl => Ok(wgpu::Backends::GL),
        Backend::Auto => {
            let Some(asked) = variable.filter(|v| !v.is_empty()) else {
                return Ok(ours);
            };
            let named = wgpu::Backends::from_comma_list(&asked) & ours;
            if named.is_empty() {
                return Err(DrawError::Missing(format!(
                    "WGPU_BACKEND is \"{asked}\", which is not a graphics interface that azulejo \
                     uses: set it to vulkan, gl or vulkan,gl, or unset it"
                )));
            }
            Ok(named)
        }
    }
}

fn adapters(backends: wgpu::Backends) -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        // Without validation: the layers are for developers, and slow.
        flags: wgpu::InstanceFlags::empty(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    pollster::block_on(instance.enumerate_adapters(backends))
}

/// The preferred adapter.
fn best_adapter(wanted: wgpu::Backends) -> Result<wgpu::Adapter, DrawError> {
    let rank = |adapter: &wgpu::Adapter| {
        let info = adapter.get_info();
        let kind = match info.device_type {
            _ if is_software(&info) => 4,
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu => 2,
            _ => 3,
        };
        (kind, info.backend != wgpu::Backend::Vulkan)
    };
    let candidates = adapters(wanted).into_iter().filter(can_draw);
    candidates
        .min_by_key(rank)
        .ok_or_else(|| DrawError::Missing(missing(wanted)))
}

/// Whether an adapter can draw patch numbers.
fn can_draw(adapter: &wgpu::Adapter) -> bool {
    let usages = |format| adapter.get_texture_format_features(format).allowed_usages;
    [
        wgpu::TextureFormat::R32Uint,
        wgpu::TextureFormat::Depth32Float,
    ]
    .into_iter()
    .all(|format| usages(format).contains(wgpu::TextureUsages::RENDER_ATTACHMENT))
}

/// The message if there is no adapter: what was searched, what was found, what to do.
fn missing(wanted: wgpu::Backends) -> String {
    let looked_for = match wanted {
        w if w == wgpu::Backends::VULKAN => "Vulkan",
        w if w == wgpu::Backends::GL => "OpenGL",
        _ => "Vulkan or OpenGL",
    };
    let adapters = adapters(wgpu::Backends::VULKAN | wgpu::Backends::GL);
    let names: Vec<String> = adapters.iter().map(|a| described(&a.get_info())).collect();
    let list = if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    };
    format!(
        "no graphics card or driver through {looked_for}; adapters found: {list}. Install a \
         driver: the card's own, or Mesa's for machines without one (Debian and Ubuntu: apt \
         install mesa-vulkan-drivers libvulkan1 libegl1 libgl1-mesa-dri); or use the \
         processor"
    )
}

/// Describes an adapter.
fn described(info: &wgpu::AdapterInfo) -> String {
    let interface = match info.backend {
        wgpu::Backend::Vulkan => "Vulkan",
        wgpu::Backend::Gl => "OpenGL",
        _ => "another interface",
    };
    let mut text = format!("{} ({interface}", info.name);
    for part in [&info.driver, &info.driver_info] {
        if !part.is_empty() && *part != info.name {
            text += ", ";
            text += part;
        }
    }
    if is_software(info) {
        text += ", software";
    }
    text + ")"
}

/// Whether an adapter is a software driver. OpenGL does not report this, so names decide there.
fn is_software(info: &wgpu::AdapterInfo) -> bool {
    let name = info.name.to_lowercase();
    let known = ["llvmpipe", "softpipe", "swiftshader", "swrast", "software"];
    info.device_type == wgpu::DeviceType::Cpu || known.iter().any(|k| name.contains(k))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_environment_narrows_what_is_looked_for() {
        let check = |backend, variable: Option<&str>, expected: wgpu::Backends| {
            let backends = wanted(backend, variable.map(str::to_owned));
            assert_eq!(backends, Ok(expected), "{backend:?} {variable:?}");
        };
        let (vulkan, gl) = (wgpu::Backends::VULKAN, wgpu::Backends::GL);
        check(Backend::Auto, None, vulkan | gl);
        check(Backend::Auto, Some(""), vulkan | gl);
        check(Backend::Auto, Some("gl"), gl);
        check(Backend::Auto, Some("metal, vulkan"), vulkan);
        check(Backend::Gl, Some("vulkan"), gl);
        let error = wanted(Backend::Auto, Some("metal".to_owned())).expect_err("not ours");
        assert!(
            error.to_string().contains("WGPU_BACKEND is \"metal\""),
            "{error}"
        );
    }

    #[test]
    fn who_finds_no_card_learns_what_to_do() {
        let text = missing(wgpu::Backends::VULKAN);
        for part in [
            "through Vulkan;",
            "adapters found: ",
            "mesa-vulkan-drivers",
            "processor",
        ] {
            assert!(text.contains(part), "{text}");
        }
    }
}
