//! The machine on which the numbers were measured.

use std::fs;

use clastic::output::run_record::CLASTIC_VERSION;
use time::OffsetDateTime;

/// Processor, memory, load and date, one fact per line. Facts that the system does not provide are
/// left out.
#[must_use]
pub fn describe() -> Vec<(&'static str, String)> {
    let today = OffsetDateTime::now_utc().date().to_string();
    let mut facts = vec![("date (UTC)", today), ("clastic", CLASTIC_VERSION.to_owned())];
    let field = |path: &str, name: &str| {
        let text = fs::read_to_string(path).ok()?;
        let line = text.lines().find(|line| line.starts_with(name))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    };
    facts.extend(field("/proc/cpuinfo", "model name").map(|model| ("processor", model)));
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    facts.push(("cores", cores.to_string()));
    facts.extend(field("/proc/meminfo", "MemTotal").map(|memory| ("memory", memory)));
    facts.push(("load at the start", load().unwrap_or_else(|| "unknown".to_owned())));
    facts
}

/// Load averages of 1, 5 and 15 minutes. Above the number of cores other programs slow the
/// measurement.
#[must_use]
pub fn load() -> Option<String> {
    let text = fs::read_to_string("/proc/loadavg").ok()?;
    Some(text.split_whitespace().take(3).collect::<Vec<_>>().join(" "))
}

/// Maximum memory of this process so far, bytes, since [`forget_peak_memory`]; Linux only.
#[must_use]
pub fn peak_memory() -> Option<f64> {
    let text = fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024.0 * kibibytes)
}

/// Restarts [`peak_memory`], if the system can.
pub fn forget_peak_memory() {
    // Only Linux has this file, and only there a peak is measured.
    let _ = fs::write("/proc/self/clear_refs", "5");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn memory_is_measured() {
        forget_peak_memory();
        let before = peak_memory().unwrap_or_default();
        let block = std::hint::black_box(vec![1_u8; 1 << 27]);
        let after = peak_memory().unwrap_or_default();
        drop(block);
        assert!(before > 0.0 && after - before > 1e8, "{before} {after}");
    }
}
