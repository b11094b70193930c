use super::error::RecordError;
use super::ring::ring;
use super::writer::Writer;
use super::{time_of, vacant, Columns, Plan};
use std::path::PathBuf;

#[test]
fn a_full_ring_drops_the_newest_and_counts() {
    let (mut sink, mut source) = ring(2, 1);
    for n in 0..5 {
        sink.push(&[f64::from(n)]);
    }
    let mut row = [0.0];
    let mut got = Vec::new();
    while source.take(&mut row) {
        got.push(row[0]);
    }
    assert_eq!((got, sink.overflowed()), (vec![0.0, 1.0], 3));
}

#[test]
fn a_ring_without_a_reader_holds_nobody_up() {
    let (mut sink, source) = ring(1, 1);
    sink.push(&[1.0]);
    assert!(!sink.has_room());
    drop(source);
    assert!(sink.has_room());
    sink.push(&[2.0]);
    assert_eq!(sink.overflowed(), 1);
}

#[test]
fn rows_come_in_order_across_threads() {
    let (mut sink, mut source) = ring(64, 2);
    let reader = std::thread::spawn(move || {
        let (mut row, mut next) = ([0.0; 2], 0.0);
        while next < 10_000.0 {
            if source.take(&mut row) {
                assert_eq!(row, [next, -next]);
                next += 1.0;
            }
        }
    });
    let mut n = 0.0;
    while n < 10_000.0 {
        let before = sink.overflowed();
        sink.push(&[n, -n]);
        n += f64::from(u8::from(sink.overflowed() == before));
    }
    reader.join().unwrap();
}

fn plan(name: &str, keep: usize) -> Plan {
    let folder = std::env::temp_dir().join(format!("flexhex-{}-{name}", std::process::id()));
    let mut columns = Columns::with(&[]);
    columns.names = ["time", "theta[1]", "phase"].map(str::to_owned).into();
    columns.units = ["s", "rad", "1"].map(str::to_owned).into();
    Plan {
        columns,
        meta: vec![("run".to_owned(), "7".to_owned())],
        recording: Some(folder.join("run.csv")),
        before_trip: folder.join("trip.csv"),
        keep,
        reaction: 4,
    }
}

#[test]
fn recordings_read_back_to_the_last_bit() {
    let values = [0.1 + 0.2, -1.0 / 3.0, 1e-9 / 7.0, 123456.789, f64::MIN_POSITIVE];
    let (mut sink, source) = ring(16, 3);
    let writer = Writer::start(plan("bits", 4), source).unwrap();
    for v in values {
        sink.push(&[v, -v, 1.0]);
    }
    let written = writer.finish(None).unwrap();
    let text = std::fs::read_to_string(written.recording.unwrap()).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("# run: 7"));
    assert_eq!(lines.next(), Some("time,theta[1],phase"));
    assert_eq!(lines.next(), Some("s,rad,1"));
    for v in values {
        let fields: Vec<f64> =
            lines.next().unwrap().split(',').map(|f| f.parse().unwrap()).collect();
        assert_eq!(fields, [v, -v, 1.0]);
    }
    assert!(written.before_trip.is_none());
}

#[test]
fn a_trip_keeps_the_rows_before_it_the_reaction_and_the_reason() {
    let (mut sink, source) = ring(64, 3);
    let writer = Writer::start(plan("trip", 3), source).unwrap();
    for n in 0..10 {
        // the last three belong to the reaction
        sink.push(&[f64::from(n), 0.0, if n < 7 { 1.0 } else { 2.0 }]);
    }
    let written = writer.finish(Some("axis 2: speed".to_owned())).unwrap();
    let recorded = std::fs::read_to_string(written.recording.unwrap()).unwrap();
    assert!(recorded.ends_with("6,0,1\n# trip: axis 2: speed\n"), "{recorded}");
    let text = std::fs::read_to_string(written.before_trip.unwrap()).unwrap();
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines[1], "# trip: axis 2: speed");
    let wanted = ["4,0,1", "5,0,1", "6,0,1", "7,0,2", "8,0,2", "9,0,2"];
    assert_eq!(lines[4..], wanted, "three before it, however many after it");
}

#[test]
fn a_trip_is_kept_although_the_recording_failed() {
    let (mut sink, source) = ring(64, 3);
    let mut plan = plan("full", 3);
    let folder = plan.before_trip.parent().unwrap().to_owned();
    plan.recording = Some(PathBuf::from("/dev/full"));
    let writer = Writer::start(plan, source).unwrap();
    for n in 0..5 {
        sink.push(&[f64::from(n), 0.0, 1.0]);
    }
    let why = writer.finish(Some("jump".to_owned())).unwrap_err().to_string();
    assert!(why.starts_with("the recording is incomplete: /dev/full: "), "{why}");
    let kept = PathBuf::from(why.rsplit(" is in ").next().unwrap());
    let text = std::fs::read_to_string(kept).unwrap();
    assert!(text.contains("# trip: jump") && text.ends_with("2,0,1\n3,0,1\n4,0,1\n"), "{text}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_recording_without_a_row_leaves_no_file() {
    let (mut sink, source) = ring(64, 3);
    let plan = plan("refused", 3);
    let file = plan.recording.clone().unwrap();
    let writer = Writer::start(plan, source).unwrap();
    assert!(vacant(&file).is_err(), "it is there while it may get rows");
    // one of the reaction, which belongs into the trip file only
    sink.push(&[0.0, 0.0, 2.0]);
    assert_eq!(writer.finish(None).unwrap().recording, None);
    vacant(&file).unwrap();
    assert!(!file.parent().unwrap().exists(), "nor the folder that it made");
}

#[test]
fn folders_that_hold_no_file_at_the_end_go_those_that_were_there_stay() {
    let (sink, source) = ring(64, 3);
    let mut plan = plan("folders", 3);
    let there = plan.before_trip.parent().unwrap().to_owned();
    std::fs::create_dir_all(&there).unwrap();
    plan.recording = Some(there.join("new/deeper/run.csv"));
    plan.before_trip = there.join("new/deeper/run-trip.csv");
    let writer = Writer::start(plan.clone(), source).unwrap();
    drop(sink);
    writer.finish(None).unwrap();
    assert!(there.exists() && !there.join("new").exists());
    let (mut sink, source) = ring(64, 3);
    let writer = Writer::start(plan, source).unwrap();
    sink.push(&[0.0, 0.0, 1.0]);
    assert!(writer.finish(None).unwrap().recording.unwrap().exists());
    std::fs::remove_dir_all(there).unwrap();
}

#[test]
fn a_trip_that_could_not_be_kept_is_refused_before_the_run() {
    let (_sink, source) = ring(64, 3);
    let mut plan = plan("nowhere", 3);
    let folder = plan.before_trip.parent().unwrap().to_owned();
    plan.before_trip = PathBuf::from("/dev/null/trip.csv");
    let why = Writer::start(plan, source).err().unwrap();
    assert!(matches!(why, RecordError::NotBegun(_)), "{why}");
    assert!(!folder.exists(), "nothing was begun");
}

#[test]
fn cycles_that_the_clock_missed_stand_in_the_recorded_time() {
    let step = 0.00025;
    // two beginnings are missed before cycle 3, one before cycle 5
    let missed = [0, 0, 0, 2, 2, 3];
    let (mut sink, source) = ring(16, 3);
    let writer = Writer::start(plan("missed", 4), source).unwrap();
    for (n, missed) in missed.iter().enumerate() {
        let theta = if n == 4 { f64::NAN } else { 0.0 };
        sink.push(&[time_of(n as i64, *missed, step), theta, 1.0]);
    }
    let text = std::fs::read_to_string(writer.finish(None).unwrap().recording.unwrap()).unwrap();
    assert!(text.ends_with(",NaN,1\n0.002,0,1\n"), "what was not measured is no number: {text}");
    let times: Vec<f64> =
        text.lines().skip(3).map(|line| line.split(',').next().unwrap().parse().unwrap()).collect();
    assert_eq!(times, [0, 1, 2, 5, 6, 8].map(|k| f64::from(k) * step));
    // nothing missed: the bits of n times the step, as the simulation has them
    for n in 0..40_000_i64 {
        assert_eq!(time_of(n, 0, step).to_bits(), (n as f64 * step).to_bits());
    }
}
