//! Repetitions.

use bench::timing::fastest_with;

#[test]
fn what_is_prepared_is_new_for_each_run_and_the_number_of_runs_is_kept() {
    let mut made = 0;
    let prepare = || {
        made += 1;
        Ok(made)
    };
    let timed = fastest_with(3, prepare, |n| Ok(*n)).expect("nothing fails");
    assert_eq!(timed.value, 3);
    assert!(timed.seconds < 1.0);
}
