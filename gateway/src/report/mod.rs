//! Devices, refusals and the outcome of a run, for people and for programs.

mod links;
mod summary;
mod terminal;

use serde_json::json;
use std::fmt::Display;

use crate::bus::{cia402, DeviceInfo};
use crate::cycle::{Ending, Outcome};
use crate::record::Written;
use crate::rules::Trip;
pub use terminal::Reporter;

impl Reporter {
    pub fn devices(&self, devices: &[DeviceInfo]) {
        for d in devices {
            let state = cia402::state(d.statusword).name();
            let id = format!("{:#x}/{:#x}", d.vendor_id, d.product_code);
            let text = format!("{:<14} {id:<16} serial {:<10} {state}", d.name, d.serial);
            self.line(&format!("drive {}", d.position), &text);
            self.event(
                "device",
                json!({"position": d.position, "name": d.name, "vendor": d.vendor_id,
                    "product": d.product_code, "revision": d.revision, "serial": d.serial,
                    "state": state}),
            );
        }
    }

    pub fn refused(&self, why: impl Display) {
        let why = why.to_string();
        self.mark(false, &why);
        self.event("refused", json!({ "message": why }));
    }

    /// How a run ended, with its figures.
    pub fn outcome(&self, out: &Outcome, written: &Written) {
        match &out.ending {
            Ending::Done => self.mark(out.good(), &ended("done", out)),
            Ending::StopRequested => {
                self.mark(out.good(), &ended("stopped on request", out));
            }
            Ending::Refused(why) => {
                self.mark(false, &why.to_string());
                self.event("refused", json!({ "message": why.to_string(), "kind": why.key() }));
            }
            Ending::Tripped(trip, detail) => self.trip(trip, detail, out),
        }
        summary::print(self, out, written);
    }

    fn trip(&self, trip: &Trip, detail: &str, out: &Outcome) {
        self.mark(false, &format!("tripped: {trip}"));
        if !detail.is_empty() {
            self.line("", detail);
        }
        let zero =
            format!("{}, zero torque {} cycles after the trip", out.reaction.key(), out.to_zero);
        self.line("reaction", &ended(&zero, out));
        self.event(
            "trip",
            json!({"reason": trip.reason.key(), "axis": trip.axis.map(|a| a + 1),
                "value": trip.value, "limit": trip.limit, "cycle": trip.cycle,
                "message": trip.to_string(), "detail": detail, "reaction": out.reaction.key(),
                "cycles_to_zero": out.to_zero, "cycles_to_disabled": out.to_disabled}),
        );
    }
}

/// How the run ended, and whether every drive was read back as disabled.
fn ended(how: &str, out: &Outcome) -> String {
    let cut = out.landing_trip.map_or(String::new(), |trip| match out.landing_detail.as_str() {
        "" => format!(", during the landing {trip}"),
        detail => format!(", during the landing {trip}: {detail}"),
    });
    match out.unconfirmed()[..] {
        [] => format!("{how}{cut}, drives disabled"),
        ref axes => format!(
            "{how}{cut}, drives not confirmed as disabled: axes {axes:?}: use the emergency stop"
        ),
    }
}
