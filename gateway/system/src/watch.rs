//! Which FMU computes at the moment, for another thread that sees it take too long.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// Every watch of this process.
static ALL: Mutex<Vec<Weak<Watch>>> = Mutex::new(Vec::new());

/// Which of some components computes.
#[derive(Debug)]
pub struct Watch {
    names: Vec<String>,
    busy: AtomicUsize,
    calls: AtomicU64,
}

impl Watch {
    pub(crate) fn new(names: Vec<String>) -> Arc<Watch> {
        let (busy, calls) = (AtomicUsize::new(usize::MAX), AtomicU64::new(0));
        let watch = Arc::new(Watch { names, busy, calls });
        let mut all = ALL.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|known| known.strong_count() > 0);
        all.push(Arc::downgrade(&watch));
        watch
    }

    /// None between two steps.
    pub fn component(&self) -> Option<&str> {
        self.names.get(self.busy.load(Ordering::Relaxed)).map(String::as_str)
    }

    /// Number of the newest step.
    pub fn calls(&self) -> u64 {
        self.calls.load(Ordering::Relaxed)
    }

    pub(crate) fn begin(&self, member: usize) {
        self.calls.fetch_add(1, Ordering::Relaxed);
        self.busy.store(member, Ordering::Relaxed);
    }

    pub(crate) fn end(&self) {
        self.busy.store(usize::MAX, Ordering::Relaxed);
    }
}

/// The watches whose components compute, of all that are open in this process.
pub fn busy() -> Vec<Arc<Watch>> {
    let all = ALL.lock().unwrap_or_else(PoisonError::into_inner);
    let open = all.iter().filter_map(Weak::upgrade);
    open.filter(|watch| watch.component().is_some()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_computes_is_busy() {
        let found = || busy().into_iter().filter(|watch| watch.names[0] == "this test").count();
        let watch = Watch::new(vec!["this test".to_owned(), "F".to_owned()]);
        assert_eq!((found(), watch.component()), (0, None));
        watch.begin(1);
        assert_eq!((found(), watch.component(), watch.calls()), (1, Some("F"), 1));
        watch.end();
        assert_eq!(found(), 0);
        watch.begin(0);
        drop(watch);
        assert_eq!(found(), 0, "what is closed is forgotten");
    }
}
