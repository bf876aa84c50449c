//! What the machine has.

/// Budget where the machine does not say what it has, bytes.
const UNKNOWN: u64 = 2 << 30;

/// Bytes of memory that the process may use: what the machine has, or what its container gets.
/// Nothing where the system does not say; Linux does.
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

/// What the rows of a first pass may take, for [`FirstPass::memory`](crate::radiosity::FirstPass):
/// half of what the machine has, 2 GiB where it does not say; bytes.
pub fn memory_budget() -> u64 {
    memory().map_or(UNKNOWN, |bytes| bytes / 2)
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
