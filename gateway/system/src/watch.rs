//! Which FMU is called at the moment, for another thread that sees it take too long.

use std::sync::atomic::{AtomicU32, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// Every watch of this process.
static ALL: Mutex<Vec<Weak<Watch>>> = Mutex::new(Vec::new());
/// No component is called.
const IDLE: usize = usize::MAX;

/// Which of some components is called.
#[derive(Debug)]
pub(crate) struct Watch {
    names: Vec<String>,
    busy: AtomicUsize,
    calls: AtomicU64,
    /// Number of the call at the last look, and looks in a row at which it went on.
    seen: AtomicU64,
    looks: AtomicU32,
}

impl Watch {
    pub fn new(names: Vec<String>) -> Arc<Watch> {
        let watch = Arc::new(Watch {
            names,
            busy: AtomicUsize::new(IDLE),
            calls: AtomicU64::new(0),
            seen: AtomicU64::new(0),
            looks: AtomicU32::new(0),
        });
        let mut all = ALL.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|known| known.strong_count() > 0);
        all.push(Arc::downgrade(&watch));
        watch
    }

    /// A call begins, or goes over to another component.
    pub fn begin(&self, member: usize) {
        self.calls.fetch_add(1, Ordering::Relaxed);
        self.busy.store(member, Ordering::Relaxed);
    }

    pub fn end(&self) {
        self.busy.store(IDLE, Ordering::Relaxed);
    }

    /// Looks in a row at which the same call went on; the component.
    fn look(&self) -> (u32, &str) {
        let calls = self.calls.load(Ordering::Relaxed);
        let name = self.names.get(self.busy.load(Ordering::Relaxed));
        let same = self.seen.swap(calls, Ordering::Relaxed) == calls;
        let looks = match name {
            Some(_) if same => self.looks.load(Ordering::Relaxed) + 1,
            _ => 0,
        };
        self.looks.store(looks, Ordering::Relaxed);
        (looks, name.map_or("", String::as_str))
    }
}

/// A look at all calls of FMUs that go on: the component of one that went on at so many looks in a row.
/// For one thread, which looks at intervals. Steps of components with a thread of their own are not seen here.
pub fn hanging(looks: u32) -> Option<String> {
    let all = ALL.lock().unwrap_or_else(PoisonError::into_inner);
    let open: Vec<_> = all.iter().filter_map(Weak::upgrade).collect();
    drop(all);
    // every one is looked at, whichever hangs
    let seen: Vec<_> = open.iter().map(|watch| watch.look()).collect();
    let hangs = seen.into_iter().find(|(so_many, _)| *so_many >= looks);
    hangs.map(|(_, name)| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_call_that_goes_on_hangs() {
        let watch = Watch::new(vec!["this test".to_owned(), "F".to_owned()]);
        let seen = |act: &dyn Fn()| {
            act();
            watch.look()
        };
        assert_eq!(seen(&|| {}), (0, ""), "nothing is called");
        assert_eq!(seen(&|| watch.begin(1)), (0, "F"));
        assert_eq!(seen(&|| {}), (1, "F"));
        assert_eq!(seen(&|| watch.begin(0)), (0, "this test"), "another call");
        assert_eq!(seen(&|| {}), (1, "this test"));
        assert_eq!(hanging(2).as_deref(), Some("this test"));
        assert_eq!(seen(&|| watch.end()), (0, ""));
        watch.begin(0);
        drop(watch);
        assert_eq!(hanging(0), None, "what is closed is forgotten");
    }
}
