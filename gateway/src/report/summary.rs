//! The figures at the end of a run.

use serde_json::{json, Value};
use std::collections::BTreeMap;

use super::links;
use super::terminal::Reporter;
use crate::cycle::{Histogram, Outcome};
use crate::record::Written;
use crate::tasks::Task;

pub fn print(reporter: &Reporter, out: &Outcome, written: &Written) {
    if out.cycles > 0 {
        figures(reporter, out);
    }
    for (k, time) in out.brakes.iter().enumerate() {
        let Some(time) = time else { continue };
        let why = match out.passed[k] {
            false => "to stay within its position limits",
            true => "no sooner by landing.torque_N_m: it passed its position limits",
        };
        reporter.line("braked", &format!("axis {} in {:.0} ms, {why}", k + 1, time * 1e3));
    }
    links::print(reporter, &out.links, links::IN_THE_RUN);
    links::print_clocks(reporter, &out.clocks);
    let stood = if let Task::Poses(poses) = &out.task { poses.stood.as_slice() } else { &[] };
    for (k, stood) in stood.iter().enumerate() {
        let shown = |values: &[f64], digits: usize| {
            let words: Vec<_> = values.iter().map(|v| format!("{v:9.digits$}")).collect();
            words.join(" ")
        };
        reporter.line(&format!("pose {}", k + 1), &format!("{} rad", shown(&stood.pose, 5)));
        reporter.line("measured", &format!("{} rad", shown(&stood.theta, 5)));
        reporter.line("", &format!("{} N m", shown(&stood.tau_meas, 3)));
        reporter.event(
            "pose",
            json!({"pose": stood.pose, "theta": stood.theta, "tau_meas": stood.tau_meas,
                "cycles": stood.cycles}),
        );
    }
    for (label, path) in [("recording", &written.recording), ("trip file", &written.before_trip)] {
        if let Some(path) = path {
            reporter.line(label, &format!("{}", path.display()));
        }
    }
    let c = out.counts;
    reporter.event(
        "summary",
        json!({"cycles": out.cycles, "lifted": out.lifted, "skipped": out.skipped, "lost": out.lost,
            "short": out.short, "late_threads": out.late_threads,
            "frozen": out.frozen,
            "remarks": out.remarked(),
            "share_of_limits": out.shares.iter().copied().collect::<BTreeMap<_, _>>(),
            "sent": c.sent, "answered": c.answered, "duplicated": c.duplicated,
            "links": links::ports(&out.links), "links_unread": out.links.unread,
            "clocks": links::clocks(&out.clocks),
            "late": c.late, "bad": c.bad, "not_recorded": out.overflowed,
            "wake_up_us": quantiles(&out.timing.wake_up),
            "round_trip_us": quantiles(&out.timing.round_trip),
            "compute_us": quantiles(&out.timing.compute),
            "after_reply_us": quantiles(&out.timing.after_reply),
            "largest_error_rad": out.most_error,
            "cycles_to_zero": out.to_zero, "cycles_to_disabled": out.to_disabled,
            "reaction": out.reaction.key(), "not_disabled": out.unconfirmed(),
            "brakes_s": out.brakes, "passed_limits": out.passed,
            "landing_trip": out.landing_trip.map(|trip| trip.to_string()),
            "landing_detail": out.landing_detail,
            "recording": written.recording, "before_trip": written.before_trip,
            "rows": written.rows}),
    );
}

fn figures(reporter: &Reporter, out: &Outcome) {
    reporter.line("cycles", &format!("{}  ({} skipped)", out.cycles, out.skipped));
    reporter.line("", "                            p50       p99       max");
    for (name, h) in [
        ("wake-up delay", &out.timing.wake_up),
        ("round trip", &out.timing.round_trip),
        ("FMU computation", &out.timing.compute),
        ("work after reply", &out.timing.after_reply),
    ] {
        let (p50, p99, max) = (h.quantile_us(0.5), h.quantile_us(0.99), h.most_us());
        reporter.line("", &format!("{name:<19}{p50:>8.1}  {p99:>8.1}  {max:>8.1} us"));
    }
    let c = out.counts;
    reporter.line(
        "frames",
        &format!(
            "{} without a reply, {} with a short working counter, {} duplicated, {} late, {} \
             invalid",
            out.lost, out.short, c.duplicated, c.late, c.bad
        ),
    );
    if out.late_threads > 0 {
        let text = format!("{} results of components in their own thread late", out.late_threads);
        reporter.line("threads", &text);
    }
    let nearest = out.shares.iter().take(3);
    let nearest: Vec<_> = nearest.map(|(rule, s)| format!("{rule} {:.0} %", 100.0 * s)).collect();
    reporter.line("of limits", &nearest.join(", "));
    for (axis, remark, cycles) in out.remarked() {
        reporter.line("drive", &format!("axis {axis}: {remark} in {cycles} cycles"));
    }
    for why in &out.frozen {
        reporter.line("frozen", why);
    }
    if out.overflowed > 0 {
        let text = format!("{} rows dropped: the disk is too slow", out.overflowed);
        reporter.line("recorder", &text);
    }
    let error = out.most_error.iter().fold(0.0, |a: f64, b| a.max(*b));
    reporter.line("error", &format!("largest following error {:.2} urad", error * 1e6));
}

fn quantiles(h: &Histogram) -> Value {
    json!({"p50": h.quantile_us(0.5), "p99": h.quantile_us(0.99), "max": h.most_us()})
}
