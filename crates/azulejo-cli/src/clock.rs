//! Seconds by the clock on the wall, seconds of the processor, memory.

use std::time::Instant;

/// Measures from its creation on.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    start: Instant,
    cpu: f64,
}

impl Clock {
    /// Starts now.
    pub fn start() -> Clock {
        Clock {
            start: Instant::now(),
            cpu: cpu_seconds(),
        }
    }

    /// Seconds on the wall.
    pub fn wall(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Seconds of all threads of the process; 0 where the system does not say.
    pub fn cpu(&self) -> f64 {
        cpu_seconds() - self.cpu
    }
}

#[cfg(unix)]
fn usage() -> Option<nix::sys::resource::Usage> {
    nix::sys::resource::getrusage(nix::sys::resource::UsageWho::RUSAGE_SELF).ok()
}

/// Processor seconds of the whole process so far.
#[cfg(unix)]
fn cpu_seconds() -> f64 {
    let seconds = |t: nix::sys::time::TimeVal| t.tv_sec() as f64 + t.tv_usec() as f64 * 1e-6;
    usage().map_or(0.0, |u| seconds(u.user_time()) + seconds(u.system_time()))
}

#[cfg(not(unix))]
fn cpu_seconds() -> f64 {
    0.0
}

/// Most bytes of memory that the process has held at once, where the system says.
#[cfg(unix)]
pub fn peak_memory() -> Option<u64> {
    // Kilobytes everywhere but on Apple's systems, which count bytes.
    let unit = if cfg!(target_vendor = "apple") {
        1
    } else {
        1024
    };
    // A process inherits the account of the one that started it, but not its memory.
    own_peak().or_else(|| usage().map(|u| u.max_rss().max(0) as u64 * unit))
}

/// Most bytes that the memory of this program alone has held, where Linux says.
#[cfg(unix)]
fn own_peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kilobytes * 1024)
}

/// Most bytes of memory that the process has held at once, where the system says.
#[cfg(not(unix))]
pub fn peak_memory() -> Option<u64> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn work_costs_processor_time() {
        let clock = Clock::start();
        let mut x = 1u64;
        while clock.cpu() < 0.02 {
            x = std::hint::black_box(x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1));
            assert!(clock.wall() < 60.0, "the processor clock stands still");
        }
        assert!(peak_memory().unwrap() > 100_000);
    }
}
