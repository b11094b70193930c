//! FMUs that step inside the cycle, on one bus.
//!
//! A component of a longer period takes its inputs at its tick and publishes its outputs one period
//! later. The base step in which it computes has no effect on the results, so components of equal
//! period take turns and no base step computes all of them.

use std::ops::Range;
use std::time::{Duration, Instant};

use crate::component::Component;
use crate::error::Error;
use crate::executor::Executor;
use crate::layout::Layout;
use crate::system::System;
use crate::trip::Trip;
use crate::unit::Unit;

/// A component with its place on the bus.
struct Member {
    name: String,
    period: i64,
    /// Base steps from its tick to that in which it computes, less than its period.
    turn: i64,
    slots: Range<usize>,
}

pub(crate) struct Inline {
    executor: Executor,
    members: Vec<Member>,
}

impl Inline {
    pub fn open(system: &System, members: &[&Component], layout: &Layout) -> Result<Inline, Error> {
        Inline::named(system, members, layout, |name| name.to_owned())
    }

    /// Instances of their own beside those of the run: FMI wants each to have a name of its own, `F-model`.
    pub fn beside(
        system: &System,
        members: &[&Component],
        layout: &Layout,
        purpose: &str,
    ) -> Result<Inline, Error> {
        Inline::named(system, members, layout, |name| format!("{name}-{purpose}"))
    }

    fn named(
        system: &System,
        members: &[&Component],
        layout: &Layout,
        name: impl Fn(&str) -> String,
    ) -> Result<Inline, Error> {
        let unit = |m: &&Component| {
            layout.unit(system, m).map(|unit| Unit { name: name(&unit.name), ..unit })
        };
        let units = members.iter().map(unit).collect::<Result<Vec<_>, _>>()?;
        let turns = turns(&units.iter().map(|unit| unit.period).collect::<Vec<_>>());
        let member = |(unit, turn): (&Unit, i64)| Member {
            name: unit.name.clone(),
            period: unit.period,
            turn,
            slots: unit.slot..unit.slot + unit.outputs.len(),
        };
        let members: Vec<_> = units.iter().zip(turns).map(member).collect();
        let executor = Executor::open(units, layout.names.len(), system.base_step())?;
        Ok(Inline { executor, members })
    }

    pub fn bus(&self) -> &[f64] {
        self.executor.bus()
    }

    pub fn bus_mut(&mut self) -> &mut [f64] {
        self.executor.bus_mut()
    }

    /// Components due at n take their inputs; those whose turn it is step from their tick to one
    /// period after it.
    pub fn step(&mut self, n: i64, limit: Option<Duration>) -> Result<(), Trip> {
        let stepped = self.step_each(n, limit);
        self.executor.watch().end();
        stepped
    }

    fn step_each(&mut self, n: i64, limit: Option<Duration>) -> Result<(), Trip> {
        let mut begin = limit.map(|_| Instant::now());
        for (k, member) in self.members.iter().enumerate() {
            self.executor.watch().begin(k);
            if n % member.period == 0 && !self.executor.feed(k, n) {
                return Err(Trip::refused(&member.name, n, self.executor.message()));
            }
            let tick = n - member.turn;
            if tick % member.period != 0 {
                continue;
            }
            if !self.executor.advance(k, tick) {
                return Err(Trip::refused(&member.name, n, self.executor.message()));
            }
            if let (Some(limit), Some(started)) = (limit, begin) {
                let spent = started.elapsed();
                if spent > limit {
                    return Err(Trip::overrun(&member.name, n, spent, limit));
                }
                begin = Some(Instant::now());
            }
        }
        Ok(())
    }

    /// Components due at n publish their outputs, which must be finite.
    pub fn publish(&mut self, n: i64, layout: &Layout) -> Result<(), Trip> {
        let published = self.publish_each(n, layout);
        self.executor.watch().end();
        published
    }

    fn publish_each(&mut self, n: i64, layout: &Layout) -> Result<(), Trip> {
        for (k, member) in self.members.iter().enumerate() {
            if n % member.period != 0 {
                continue;
            }
            self.executor.watch().begin(k);
            if !self.executor.publish(k, n) {
                return Err(Trip::refused(&member.name, n, self.executor.message()));
            }
            check_finite(&member.name, n, member.slots.clone(), self.executor.bus(), layout)?;
        }
        Ok(())
    }
}

/// Turns of components with these periods: 0, 1, ... among those of equal period, then from 0 again.
fn turns(periods: &[i64]) -> Vec<i64> {
    let before = |k: usize| periods[..k].iter().filter(|p| **p == periods[k]).count() as i64;
    (0..periods.len()).map(|k| before(k) % periods[k]).collect()
}

/// Outputs that a component shows at n: a Trip for the first that is NaN or infinite.
pub(crate) fn check_finite(
    component: &str,
    now: i64,
    slots: Range<usize>,
    bus: &[f64],
    layout: &Layout,
) -> Result<(), Trip> {
    let Some(slot) = slots.clone().find(|s| !bus[*s].is_finite()) else {
        return Ok(());
    };
    Err(Trip::not_finite(component, now, &layout.names[slot], bus[slot]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_of_equal_period_take_turns() {
        assert_eq!(turns(&[1, 2, 2, 1, 120, 2, 2, 3]), [0, 0, 1, 0, 0, 0, 1, 0]);
    }
}
