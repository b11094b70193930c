//! Before power: an FMU that never returns ends the command.

use flexhex_system::busy;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use std::thread::JoinHandle;

use crate::attend::{Stillness, LOOK};
use crate::exit::Exit;
use crate::report::Reporter;
use crate::watch::HANG_S;

/// While it is there, another thread looks whether each FMU returns. Nothing has power and no file is open.
pub struct Preparing {
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Preparing {
    pub fn begin(reporter: Reporter) -> Preparing {
        let over = Arc::new(AtomicBool::new(false));
        let theirs = Arc::clone(&over);
        // without a thread nobody looks: Ctrl-C ends an FMU that hangs, too
        let thread = std::thread::Builder::new().name("preparing".to_owned());
        let thread = thread.spawn(move || look(reporter, &theirs)).ok();
        Preparing { over, thread }
    }
}

impl Drop for Preparing {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // it panics nowhere
            let _ = thread.join();
        }
    }
}

fn look(reporter: Reporter, over: &AtomicBool) {
    let mut stillness = Stillness::default();
    while !over.load(Ordering::Relaxed) {
        std::thread::park_timeout(LOOK);
        // one thread prepares, so one FMU computes
        let Some(watch) = busy().into_iter().next() else {
            stillness.note(None);
            continue;
        };
        if stillness.note(Some(watch.calls())) >= HANG_S * 10 {
            reporter.live_over();
            reporter.refused(format!(
                "{} hangs: no answer for {HANG_S} s; no drive has power yet: mend this FMU, or take it out of the \
                 system description",
                watch.component().unwrap_or("an FMU")
            ));
            std::process::exit(i32::from(Exit::BadInput as u8));
        }
    }
}
