//! The machine that the numbers were taken on: without it they mean little.

use std::fs;
use std::time::{SystemTime, UNIX_EPOCH};

/// Processor, memory, load and date, one fact a line; what the system does not tell is left out.
#[must_use]
pub fn describe() -> Vec<(&'static str, String)> {
    let mut facts = vec![("date (UTC)", today()), ("clastic", env!("CARGO_PKG_VERSION").into())];
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

/// Load averages of 1, 5 and 15 minutes: above the number of cores the machine is contended.
#[must_use]
pub fn load() -> Option<String> {
    let text = fs::read_to_string("/proc/loadavg").ok()?;
    Some(text.split_whitespace().take(3).collect::<Vec<_>>().join(" "))
}

/// Greatest memory of this process so far, bytes, since [`forget_peak_memory`]; Linux only.
#[must_use]
pub fn peak_memory() -> Option<f64> {
    let text = fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024.0 * kibibytes)
}

/// Lets [`peak_memory`] begin anew, where the system can.
pub fn forget_peak_memory() {
    // Elsewhere than on Linux there is no such file, and no peak either.
    let _ = fs::write("/proc/self/clear_refs", "5");
}

fn today() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let (year, month, day) = date(seconds / 86_400);
    format!("{year:04}-{month:02}-{day:02}")
}

/// Gregorian date of a day, counted from 1970-01-01 (years that begin in March end with the leap
/// day).
fn date(days: u64) -> (u64, u64, u64) {
    let day = days + 719_468;
    let (era, day) = (day / 146_097, day % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let date = day - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    (400 * era + year + next, month, date)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates() {
        assert_eq!(date(0), (1970, 1, 1));
        assert_eq!(date(11_016), (2000, 2, 29));
        assert_eq!(date(11_017), (2000, 3, 1));
        assert_eq!(date(20_778), (2026, 11, 21));
    }

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
