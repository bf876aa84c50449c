//! The machine on which reports are measured.

use crate::engine::{embree_version, fastest_card_name};
use crate::report::bytes;
use serde_json::{Value, json};

/// Properties of the machine.
pub struct MachineInfo {
    /// Model of the processor.
    pub processor: String,
    /// Number of threads.
    pub threads: usize,
    /// Memory in bytes.
    pub memory: Option<u64>,
    /// Version of Embree, or why there is none.
    pub embree: Result<String, String>,
    /// Name of the graphics card, or why there is none.
    pub card: Result<String, String>,
}

impl MachineInfo {
    /// Detects the properties.
    pub fn detect() -> MachineInfo {
        MachineInfo {
            processor: processor(),
            threads: rayon::current_num_threads(),
            memory: azulejo::machine::memory(),
            embree: embree_version(),
            card: fastest_card_name(),
        }
    }

    /// Names and values for the report.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let system = format!("{} on {}", std::env::consts::OS, std::env::consts::ARCH);
        let or_why = |name: &Result<String, String>| match name {
            Ok(name) => name.clone(),
            Err(why) => format!("none: {why}"),
        };
        vec![
            (
                "azulejo",
                format!("{}, {}", env!("CARGO_PKG_VERSION"), build()),
            ),
            ("processor", self.processor.clone()),
            ("threads", self.threads.to_string()),
            ("memory", self.memory.map_or("unknown".to_owned(), bytes)),
            ("system", system),
            ("Embree", or_why(&self.embree)),
            ("graphics card", or_why(&self.card)),
        ]
    }

    /// As JSON.
    pub fn json(&self) -> Value {
        json!({
            "azulejo": env!("CARGO_PKG_VERSION"),
            "build": build(),
            "processor": self.processor,
            "threads": self.threads,
            "memory_bytes": self.memory,
            "system": std::env::consts::OS,
            "architecture": std::env::consts::ARCH,
            "embree": self.embree.as_ref().ok(),
            "card": self.card.as_ref().ok(),
        })
    }
}

/// The kind of this build: times of a debug build are not comparable.
fn build() -> &'static str {
    if cfg!(debug_assertions) {
        "debug build: times are not meaningful"
    } else {
        "optimized build"
    }
}

/// The model of the processor, on Linux.
fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    model(&text).unwrap_or_else(|| "unknown".to_owned())
}

fn model(cpuinfo: &str) -> Option<String> {
    let line = cpuinfo.lines().find(|l| l.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_processor_has_a_name() {
        let name = model("processor\t: 0\nmodel name\t: A CPU @ 2 GHz\n");
        assert_eq!(name.as_deref(), Some("A CPU @ 2 GHz"));
        assert_eq!(model(""), None);
        assert!(
            MachineInfo::detect()
                .lines()
                .iter()
                .all(|(_, words)| !words.is_empty())
        );
    }
}
