//! Lists the adapters of graphics drivers for Vulkan and OpenGL, one per line; exit status 1 if
//! there are none.
//!
//! It asks wgpu alone: an adapter that `Card::open` wrongly refused would still be listed, so that
//! tests can be required to pass on it.

use std::process::ExitCode;

#[allow(clippy::print_stdout, reason = "the list is what it is for")]
fn main() -> ExitCode {
    let backends = wgpu::Backends::VULKAN | wgpu::Backends::GL;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        flags: wgpu::InstanceFlags::empty(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let adapters = pollster::block_on(instance.enumerate_adapters(backends));
    for adapter in &adapters {
        let info = adapter.get_info();
        println!("{:?}: {} ({:?})", info.backend, info.name, info.device_type);
    }
    if adapters.is_empty() {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    }
}
