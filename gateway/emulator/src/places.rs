//! The place of each device on the bus.
use crate::options::Options;

impl Options {
    /// Number of devices on the bus.
    pub fn devices(&self) -> usize {
        self.drives.count + self.drives.others.len()
    }

    /// Axis of each position on the bus; None: no drive.
    pub fn order(&self) -> Vec<Option<usize>> {
        let mut axes = self.axes().into_iter();
        let axis = |position| match self.drives.others.contains(&position) {
            true => None,
            false => axes.next(),
        };
        (0..self.devices()).map(axis).collect()
    }

    /// Axis of each drive.
    pub(crate) fn axes(&self) -> Vec<usize> {
        if self.drives.order.is_empty() {
            return (0..self.drives.count).collect();
        }
        self.drives.order.clone()
    }
}
