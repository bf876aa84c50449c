//! Opening a graphics device without a window, and detecting its loss.

use super::GpuError;
use std::future::Future;
use std::pin::pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};

/// A device for rendering without a window.
#[derive(Clone, Debug)]
pub struct HeadlessDevice {
    /// Creates resources.
    pub device: wgpu::Device,
    /// Takes work for the GPU.
    pub queue: wgpu::Queue,
}

#[cfg(not(target_arch = "wasm32"))]
impl HeadlessDevice {
    /// Opens the best adapter of one of `backends`, hardware before software. `WGPU_BACKEND`
    /// narrows the choice.
    ///
    /// # Errors
    ///
    /// [`GpuError::Missing`] or [`GpuError::Refused`].
    pub fn open(backends: wgpu::Backends) -> Result<HeadlessDevice, GpuError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: wgpu::Backends::from_env().map_or(backends, |b| b & backends),
            // Without validation layers, which are for developers and slow.
            flags: wgpu::InstanceFlags::empty(),
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapters = pollster::block_on(instance.enumerate_adapters(backends));
        let mut names = Vec::new();
        let mut best: Option<(u8, wgpu::Adapter)> = None;
        for adapter in adapters {
            let info = adapter.get_info();
            names.push(format!("{} ({})", info.name, info.backend));
            let rank = rank(&info);
            if can_draw(&adapter) && best.as_ref().is_none_or(|b| rank < b.0) {
                best = Some((rank, adapter));
            }
        }
        let (_, adapter) = best.ok_or(GpuError::Missing { found: names })?;
        HeadlessDevice::from_adapter(&adapter)
    }

    fn from_adapter(adapter: &wgpu::Adapter) -> Result<HeadlessDevice, GpuError> {
        let info = adapter.get_info();
        let base = match info.backend {
            wgpu::Backend::Gl => wgpu::Limits::downlevel_webgl2_defaults(),
            _ => wgpu::Limits::downlevel_defaults(),
        };
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("azulejo without a window"),
            required_limits: base.using_resolution(adapter.limits()),
            ..wgpu::DeviceDescriptor::default()
        };
        let opened = pollster::block_on(adapter.request_device(&descriptor));
        let (device, queue) = opened.map_err(|e| GpuError::Refused {
            name: info.name,
            reason: e.to_string(),
        })?;
        Ok(HeadlessDevice { device, queue })
    }
}

/// Rank of an adapter: hardware before software, Vulkan before OpenGL.
#[cfg(not(target_arch = "wasm32"))]
fn rank(info: &wgpu::AdapterInfo) -> u8 {
    let kind = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    2 * kind + u8::from(info.backend != wgpu::Backend::Vulkan)
}

#[cfg(not(target_arch = "wasm32"))]
fn can_draw(adapter: &wgpu::Adapter) -> bool {
    let usages = |format| adapter.get_texture_format_features(format).allowed_usages;
    [super::target::COLOR, super::target::DEPTH]
        .into_iter()
        .all(|format| usages(format).contains(wgpu::TextureUsages::RENDER_ATTACHMENT))
}

/// Records uncaptured errors and the loss of a device; without it wgpu would panic.
#[derive(Clone, Debug, Default)]
pub(super) struct DeviceErrors {
    first: Arc<Mutex<Option<GpuError>>>,
}

impl DeviceErrors {
    pub fn new(device: &wgpu::Device) -> DeviceErrors {
        let listener = DeviceErrors::default();
        let ear = listener.clone();
        device.set_device_lost_callback(move |reason, message| {
            let reason = format!("{message} ({reason:?})");
            ear.note(GpuError::Lost { reason });
        });
        let ear = listener.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            ear.note(error.into());
        }));
        listener
    }

    /// Keeps the first error; a device loss overrides any other.
    fn note(&self, error: GpuError) {
        let mut first = self.first.lock().unwrap_or_else(PoisonError::into_inner);
        if first.is_none() || matches!(error, GpuError::Lost { .. }) {
            *first = Some(error);
        }
    }

    /// Returns and clears the error since the last call; a lost device stays lost.
    pub fn check(&self) -> Result<(), GpuError> {
        let mut first = self.first.lock().unwrap_or_else(PoisonError::into_inner);
        match &*first {
            None => Ok(()),
            Some(lost @ GpuError::Lost { .. }) => Err(lost.clone()),
            Some(_) => first.take().map_or(Ok(()), Err),
        }
    }
}

/// Runs `work` on the device and returns the first error that it causes.
pub(super) fn catch_errors<T>(
    device: &wgpu::Device,
    work: impl FnOnce() -> Result<T, GpuError>,
) -> Result<T, GpuError> {
    let filters = [
        wgpu::ErrorFilter::Internal,
        wgpu::ErrorFilter::Validation,
        wgpu::ErrorFilter::OutOfMemory,
    ];
    let scopes = filters.map(|filter| device.push_error_scope(filter));
    let done = work();
    // Innermost scope first: a failed allocation also causes a validation error, and the memory is
    // the actual reason.
    let mut first = None;
    for scope in scopes.into_iter().rev() {
        first = first.or(now(scope.pop()));
    }
    match first {
        Some(error) => Err(error.into()),
        None => done,
    }
}

/// The result of a future that is ready immediately, as wgpu's are on desktop systems.
fn now<T>(future: impl Future<Output = Option<T>>) -> Option<T> {
    let mut context = Context::from_waker(Waker::noop());
    match pin!(future).poll(&mut context) {
        Poll::Ready(result) => result,
        Poll::Pending => None,
    }
}
