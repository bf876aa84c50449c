//! Wall-clock time, CPU time and peak memory of the process.

use std::time::Instant;

/// Measures time since its creation.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    start: Instant,
    cpu: f64,
}

impl Clock {
    /// Starts the measurement.
    pub fn start() -> Clock {
        Clock {
            start: Instant::now(),
            cpu: cpu_seconds(),
        }
    }

    /// Elapsed wall-clock time, seconds.
    pub fn wall(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// CPU time of all threads of the process, seconds; 0 where the system does not provide it.
    pub fn cpu(&self) -> f64 {
        cpu_seconds() - self.cpu
    }
}

#[cfg(unix)]
fn usage() -> Option<nix::sys::resource::Usage> {
    nix::sys::resource::getrusage(nix::sys::resource::UsageWho::RUSAGE_SELF).ok()
}

/// CPU time of the process so far, seconds.
#[cfg(unix)]
fn cpu_seconds() -> f64 {
    let seconds = |t: nix::sys::time::TimeVal| t.tv_sec() as f64 + t.tv_usec() as f64 * 1e-6;
    usage().map_or(0.0, |u| seconds(u.user_time()) + seconds(u.system_time()))
}

#[cfg(not(unix))]
fn cpu_seconds() -> f64 {
    0.0
}

/// Peak memory of the process in bytes, where the system provides it.
#[cfg(unix)]
pub fn peak_memory() -> Option<u64> {
    // Kilobytes everywhere but on Apple's systems, which count bytes.
    let unit = if cfg!(target_vendor = "apple") {
        1
    } else {
        1024
    };
    // `ru_maxrss` includes the peak of the parent process, from which it is inherited; VmHWM does not.
    own_peak().or_else(|| usage().map(|u| u.max_rss().max(0) as u64 * unit))
}

/// Peak memory of this program alone in bytes, on Linux.
#[cfg(unix)]
fn own_peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kilobytes * 1024)
}

/// Peak memory of the process in bytes, where the system provides it.
#[cfg(not(unix))]
pub fn peak_memory() -> Option<u64> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn work_takes_cpu_time() {
        let clock = Clock::start();
        let mut x = 1u64;
        while clock.cpu() < 0.02 {
            x = std::hint::black_box(x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1));
            assert!(clock.wall() < 60.0, "the CPU clock does not advance");
        }
        assert!(peak_memory().unwrap() > 100_000);
    }
}
