//! Ctrl-C, SIGTERM and SIGHUP ask the run to stop after its increment; a second Ctrl-C kills it.
//!
//! Batch queues and machines that shut down send SIGTERM, and a terminal that closes sends SIGHUP.
//! Both may arrive twice (`timeout` and shells send them to the process and to its group), so only
//! Ctrl-C counts as the second request. Ctrl-C after any of them stops the run at once.

use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::exit::{Exit, complain};

/// Whether the user or the system has asked the run to stop.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens to Ctrl-C and the signals from now on. If that is impossible, they keep their
    /// default effect and end the process.
    pub fn listen() -> Self {
        let interrupt = Self::default();
        let ours = interrupt.clone();
        let listening = ctrlc::set_handler(move || {
            if ours.ask("") {
                process::exit(Exit::Interrupted as i32);
            }
        });
        if let Err(error) = listening {
            complain(format_args!(
                "Ctrl-C will stop the run in the middle of an increment: {error}"
            ));
        }
        #[cfg(unix)]
        if let Err(error) = signals::listen(interrupt.clone()) {
            complain(format_args!(
                "SIGTERM will stop the run in the middle of an increment: {error}"
            ));
        }
        interrupt
    }

    /// Asks the run to stop because of `what`. Returns whether an earlier request exists.
    fn ask(&self, what: &str) -> bool {
        let again = self.0.swap(true, Ordering::Relaxed);
        if !again {
            complain(format_args!(
                "\n{what}finishing the increment; a second Ctrl-C stops at once and loses what came after the \
                 last checkpoint"
            ));
        }
        again
    }

    pub(crate) fn requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The signals other than Ctrl-C that end a process.
#[cfg(unix)]
mod signals {
    use std::fs;
    use std::io;
    use std::thread;

    use signal_hook::consts::{SIGHUP, SIGTERM};
    use signal_hook::iterator::Signals;

    use super::Interrupt;

    /// Passes the signals on to `interrupt` from now on.
    pub fn listen(interrupt: Interrupt) -> io::Result<()> {
        let mut signals = Signals::new([SIGTERM])?;
        // With `nohup` the run must survive its terminal. If the system does not tell whether
        // SIGHUP is ignored, its handling does not change.
        let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
        if ignores(&status, SIGHUP) == Some(false) {
            signals.add_signal(SIGHUP)?;
        }
        thread::Builder::new().name("signals".to_owned()).spawn(move || {
            for signal in signals.forever() {
                interrupt.ask(if signal == SIGHUP { "SIGHUP: " } else { "SIGTERM: " });
            }
        })?;
        Ok(())
    }

    /// Whether a signal is in the mask of ignored signals of a Linux process status; `None` if it
    /// has no mask.
    fn ignores(status: &str, signal: i32) -> Option<bool> {
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
        let mask = u64::from_str_radix(mask.trim(), 16).ok()?;
        // Bit 0 is signal 1.
        Some(mask >> (signal - 1) & 1 == 1)
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn the_mask_of_ignored_signals_is_read() {
            let status = "Name:\tclastic\nSigIgn:\t0000000000001001\nSigCgt:\t0000000000000002\n";
            assert_eq!(
                [SIGHUP, SIGTERM, 2].map(|s| ignores(status, s)),
                [Some(true), Some(false), Some(false)]
            );
            assert_eq!(ignores("Name:\tclastic\n", SIGHUP), None);
        }
    }
}
