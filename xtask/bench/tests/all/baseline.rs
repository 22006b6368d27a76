//! Runs beside a saved one.

use bench::{Axis, Baseline, Claim, Curve, Point};
use std::collections::BTreeMap;

fn run(seconds: [f64; 2], errors: [f64; 2]) -> Baseline {
    let mut curve = Curve::new("c", Axis::Mesh, Claim::Nothing);
    for k in 0..2 {
        curve.points.push(Point {
            setting: k.to_string(),
            seconds: seconds[k],
            error: errors[k],
            ..Point::default()
        });
    }
    let counted = BTreeMap::from([("s".to_owned(), (1e6 * seconds[0]) as u64)]);
    Baseline::of(&[("s".to_owned(), vec![curve])], counted)
}

#[test]
fn ratios_are_those_of_the_points_that_both_runs_have() {
    let then = run([1.0, 2.0], [1e-3, 1e-12]);
    let mut now = run([2.0, 16.0], [2.1e-3, 1e-11]);
    now.seconds.insert("s / c / new".to_owned(), 1e9);
    let changes = now.changes_since(&then).expect("one machine");
    let [change] = &changes[..] else {
        panic!("{changes:?}")
    };
    assert_eq!((change.points, change.ratio.round()), (2, 4.0));
    assert_eq!(change.worst, ("s / c / 1".to_owned(), 8.0));
    assert_eq!(change.less_exact, ["s / c / 0"]);
    assert_eq!(change.instructions, Some(2.0));
}

#[test]
fn what_was_written_is_read_and_another_machine_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.json");
    let run = run([1.0, 2.0], [0.5, 0.25]);
    run.write(&path).expect("written");
    let mut read = Baseline::read(&path).expect("read");
    assert_eq!(read, run);
    read.machine.processor.push_str(" of another kind");
    let told = run.changes_since(&read).map(|_| ());
    let told = told.expect_err("another machine").to_string();
    assert!(told.contains("of another kind"), "{told}");
    assert!(Baseline::read(&folder.path().join("none")).is_err());
}
