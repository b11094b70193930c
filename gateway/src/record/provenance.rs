//! Where a recording comes from: date, version and configuration.

/// Lines for the head of a recording.
pub fn provenance(config_hash: u64) -> Vec<(String, String)> {
    vec![
        ("date".to_owned(), now()),
        ("version".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
        ("config_hash".to_owned(), format!("fnv1a64 {config_hash:016x}")),
    ]
}

/// Universal time, `2026-11-24T00:20:05Z`.
pub fn now() -> String {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    date(since.map_or(0, |since| since.as_secs() as libc::time_t))
}

fn date(seconds: libc::time_t) -> String {
    // SAFETY: an all-zero tm is a valid value; the call writes into it and reads only `seconds`.
    let t = unsafe {
        let mut t: libc::tm = std::mem::zeroed();
        libc::gmtime_r(&seconds, &mut t);
        t
    };
    format!(
        "{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z",
        t.tm_year + 1900,
        t.tm_mon + 1,
        t.tm_mday,
        t.tm_hour,
        t.tm_min,
        t.tm_sec
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_reference() {
        assert_eq!(date(0), "1970-01-01T00:00:00Z");
        assert_eq!(date(951_782_400 + 3661), "2000-02-29T01:01:01Z");
    }
}
