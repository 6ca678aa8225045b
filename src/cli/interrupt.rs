//! Ctrl-C: the first one asks the run to stop after its increment, the second one kills it.

use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::exit::{Exit, complain};

/// Whether somebody wants the run to stop.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens to Ctrl-C from now on. Where that is impossible, Ctrl-C kills at once, as ever.
    pub fn listen() -> Self {
        let interrupt = Self::default();
        let flag = interrupt.clone();
        let listening = ctrlc::set_handler(move || {
            if flag.0.swap(true, Ordering::Relaxed) {
                process::exit(Exit::Interrupted as i32);
            }
            complain(
                "\nfinishing the increment; Ctrl-C again stops at once, without what is new since the last \
                 checkpoint",
            );
        });
        if let Err(error) = listening {
            complain(format_args!("Ctrl-C will not wait for the increment: {error}"));
        }
        interrupt
    }

    /// Whether Ctrl-C was pressed.
    pub fn requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
