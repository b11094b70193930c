//! Before and after power: an FMU that never returns ends the command.

use flexhex_system::hanging;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use std::thread::JoinHandle;

use crate::attend::LOOK;
use crate::exit::Exit;
use crate::report::Reporter;
use crate::watch::{HANG_LOOKS, HANG_S};

/// While it is there, another thread looks whether each FMU returns. No drive has power.
pub struct Answering {
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// What is said of an FMU that hangs, and the exit code.
type End = (&'static str, Exit);

impl Answering {
    /// Nothing has been sent yet, and no file is open.
    pub fn before_power(reporter: Reporter) -> Answering {
        let text =
            "no drive has power yet: mend this FMU, or take it out of the system description";
        Answering::begin(reporter, (text, Exit::BadInput))
    }

    /// The run has been reported and its files are closed.
    pub fn after_power(reporter: Reporter) -> Answering {
        let text = "the run is over and ended as reported, but this FMU does not end: mend it";
        Answering::begin(reporter, (text, Exit::Failed))
    }

    fn begin(reporter: Reporter, end: End) -> Answering {
        let over = Arc::new(AtomicBool::new(false));
        let theirs = Arc::clone(&over);
        // without a thread nobody looks: Ctrl-C ends an FMU that hangs, too
        let thread = std::thread::Builder::new().name("answering".to_owned());
        let thread = thread.spawn(move || look(reporter, &theirs, end)).ok();
        Answering { over, thread }
    }
}

impl Drop for Answering {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // it panics nowhere
            let _ = thread.join();
        }
    }
}

fn look(reporter: Reporter, over: &AtomicBool, (text, exit): End) {
    while !over.load(Ordering::Relaxed) {
        std::thread::park_timeout(LOOK);
        if let Some(component) = hanging(HANG_LOOKS) {
            reporter.live_over();
            reporter.refused(format!("{component} hangs: no answer for {HANG_S} s; {text}"));
            end(exit);
        }
    }
}

/// Ends the process. What is called at an orderly exit would wait for an FMU that hangs while it is
/// loaded.
fn end(exit: Exit) -> ! {
    let _ = std::io::stdout().flush();
    // SAFETY: it takes a number and does not return.
    unsafe { libc::_exit(i32::from(exit as u8)) }
}
