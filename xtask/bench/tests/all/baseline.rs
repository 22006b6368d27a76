//! Runs beside a saved one.

use crate::fuzz::{Damage, EFFORT};
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

/// Angles of cracks: errors of both signs.
#[test]
fn errors_are_compared_by_their_size() {
    let less_exact = |then: [f64; 2], now: [f64; 2]| -> Vec<String> {
        let (then, now) = (run([1.0; 2], then), run([1.0; 2], now));
        let changes = now.changes_since(&then).expect("one machine");
        changes.into_iter().flat_map(|c| c.less_exact).collect()
    };
    assert_eq!(less_exact([-2.0, 2.0], [-5.0, -1.0]), ["s / c / 0"]);
    assert_eq!(less_exact([-2.0, 2.0], [3.0, -5.0]), ["s / c / 1"]);
    assert!(less_exact([-2.0, -2.0], [3.0, -3.0]).is_empty());
    assert_eq!(less_exact([1.0, 0.0], [f64::NAN, 1e-10]), ["s / c / 0"]);
}

#[test]
fn a_baseline_without_a_common_point_is_an_error() {
    let now = run([1.0, 2.0], [0.5, 0.25]);
    let mut then = now.clone();
    then.seconds = BTreeMap::from([("s / another / 0".to_owned(), 1.0)]);
    let told = now.changes_since(&then).map(|_| ());
    let told = told.expect_err("nothing in common").to_string();
    assert!(told.contains("no point of this run"), "{told}");
    then.seconds.insert("s / c / 1".to_owned(), 1.0);
    assert_eq!(now.changes_since(&then).expect("one point").len(), 1);
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

/// A saved run that someone has damaged is compared, or refused by the file's name.
#[test]
fn damaged_baselines_are_compared_or_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.json");
    let own = run([1.0, 2.0], [0.5, 0.25]);
    own.write(&path).expect("written");
    let text = std::fs::read_to_string(&path).expect("readable");
    let mut damage = Damage(0x1357_9bdf_0246_8ace);
    let (mut compared, mut refused) = (0, 0);
    for _ in 0..EFFORT * 5000 {
        let bytes = damage.of(&text);
        std::fs::remove_file(&path).expect("there");
        std::fs::write(&path, &bytes).expect("writable");
        match Baseline::read(&path) {
            Ok(then) => match own.changes_since(&then) {
                Ok(changes) => {
                    assert!(changes.iter().all(|c| c.points > 0), "{changes:?}");
                    compared += 1;
                }
                Err(error) => assert!(error.to_string().contains("baseline"), "{error}"),
            },
            Err(error) => {
                let told = error.to_string();
                assert!(told.contains(&path.display().to_string()), "{told}");
                refused += 1;
            }
        }
    }
    assert!(compared > 10 && refused > 10, "{compared}, {refused}");
}
