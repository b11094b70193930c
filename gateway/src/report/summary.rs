//! The figures at the end of a run.

use serde_json::{json, Value};

use super::Teller;
use crate::cycle::{Histogram, Outcome};
use crate::record::Written;

pub fn tell(teller: &Teller, out: &Outcome, written: &Written) {
    if out.cycles > 0 {
        figures(teller, out);
    }
    for (what, path) in [("recorded", &written.recording), ("kept", &written.before_trip)] {
        if let Some(path) = path {
            teller.line(what, &format!("{}", path.display()));
        }
    }
    let c = out.counts;
    teller.event(
        "summary",
        json!({"cycles": out.cycles, "skipped": out.skipped, "lost": out.lost,
            "short": out.short, "late_threads": out.late_threads,
            "sent": c.sent, "answered": c.answered, "duplicated": c.duplicated,
            "late": c.late, "bad": c.bad, "not_recorded": out.overflowed,
            "wake_up_us": quantiles(&out.timing.wake_up),
            "round_trip_us": quantiles(&out.timing.round_trip),
            "compute_us": quantiles(&out.timing.compute),
            "after_reply_us": quantiles(&out.timing.after_reply),
            "largest_error_rad": out.most_error,
            "cycles_to_zero": out.to_zero, "cycles_to_disabled": out.to_disabled,
            "recording": written.recording, "before_trip": written.before_trip,
            "rows": written.rows}),
    );
}

fn figures(teller: &Teller, out: &Outcome) {
    teller.line("cycles", &format!("{}  ({} left out)", out.cycles, out.skipped));
    teller.line("", "                            p50       p99       max");
    for (what, h) in [
        ("wake-up", &out.timing.wake_up),
        ("round trip", &out.timing.round_trip),
        ("compute", &out.timing.compute),
        ("all after the reply", &out.timing.after_reply),
    ] {
        let (half, most) = (h.quantile_us(0.5), h.quantile_us(0.99));
        let top = h.most_us();
        teller.line("", &format!("{what:<19}{half:>8.1}  {most:>8.1}  {top:>8.1} us"));
    }
    let c = out.counts;
    teller.line(
        "frames",
        &format!(
            "{} lost, {} with a short working counter, {} duplicated, {} late, {} bad",
            out.lost, out.short, c.duplicated, c.late, c.bad
        ),
    );
    if out.late_threads > 0 {
        teller.line("threads", &format!("{} results came late", out.late_threads));
    }
    if out.overflowed > 0 {
        teller.line("recorder", &format!("{} rows did not fit in", out.overflowed));
    }
    let most = out.most_error.iter().fold(0.0, |a: f64, b| a.max(*b));
    teller.line("error", &format!("at most {:.2} urad", most * 1e6));
}

fn quantiles(h: &Histogram) -> Value {
    json!({"p50": h.quantile_us(0.5), "p99": h.quantile_us(0.99), "max": h.most_us()})
}
