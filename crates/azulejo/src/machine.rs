//! Resources of the machine.

/// Budget if the memory of the machine is unknown, bytes.
const UNKNOWN: u64 = 2 << 30;

/// Memory available to the process: that of the machine, or the limit of its container, in bytes.
/// `None` on other systems than Linux.
pub fn memory() -> Option<u64> {
    let machine = std::fs::read_to_string("/proc/meminfo")
        .ok()
        .and_then(|text| total_of(&text));
    let container = std::fs::read_to_string("/sys/fs/cgroup/memory.max")
        .ok()
        .and_then(|text| text.trim().parse().ok());
    match (machine, container) {
        (Some(a), Some(b)) => Some(u64::min(a, b)),
        (a, b) => a.or(b),
    }
}

/// The number of this process; 0 in a web page, which has none.
pub fn process() -> u32 {
    if cfg!(target_arch = "wasm32") {
        0
    } else {
        std::process::id()
    }
}

/// Default of [`FirstPass::memory`](crate::radiosity::FirstPass): half of the memory of the machine,
/// or 2 GiB if that is unknown, in bytes.
pub fn memory_budget() -> u64 {
    budget_of(memory())
}

/// The same for a machine of this many bytes.
pub fn budget_of(memory: Option<u64>) -> u64 {
    memory.map_or(UNKNOWN, |bytes| bytes / 2)
}

/// `MemTotal` of Linux's `/proc/meminfo`, in bytes.
fn total_of(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|l| l.strip_prefix("MemTotal:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kilobytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_of_the_machine() {
        assert_eq!(
            total_of("MemTotal:       16384 kB\nMemFree: 1 kB\n"),
            Some(16 << 20)
        );
        assert_eq!(total_of("MemFree: 1 kB\n"), None);
        assert!(memory_budget() > 1 << 20);
    }
}
