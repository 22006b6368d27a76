//! The stress table: every row of a quick run gives what it says, and a solver that stops after one
//! step turns the answers red.
#![allow(missing_docs)]

use verification::stress::{Expected, Record, Settings, Verdict, rows, run_rows};

fn quick(newton_limit: Option<usize>) -> Vec<Record> {
    let settings = Settings {
        quick: true,
        seed: 1,
        newton_limit,
    };
    let all = rows::all();
    // Without optimization faces take a minute; the tests of the rig and the program solve some.
    let quick = all.iter().filter(|row| row.quick && row.family != "faces");
    run_rows(quick, &settings, &mut |_| {}, &mut |_| {})
}

#[test]
fn every_quick_row_gives_what_it_says() {
    let failed: Vec<Record> = quick(None)
        .into_iter()
        .filter(|record| matches!(record.verdict, Verdict::Failed(_)))
        .collect();
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn a_solver_that_stops_after_a_step_turns_the_answers_red() {
    let records = quick(Some(1));
    let answers = records.iter().filter(|r| r.expected == Expected::Answer);
    let (red, green): (Vec<_>, Vec<_>) =
        answers.partition(|r| matches!(r.verdict, Verdict::Failed(_)));
    let names: Vec<&String> = green.iter().map(|r| &r.name).collect();
    assert!(red.len() >= 9 * green.len(), "still green: {names:?}");
}
