//! Counts of valgrind.

use bench::instructions::collected;

#[test]
fn the_count_is_found_in_what_valgrind_says() {
    let told = "==7== Events    : Ir\n==7== Collected : 567100123\n==7== \n";
    assert_eq!(collected(told), Some(567_100_123));
    assert_eq!(collected("==7== cannot execute"), None);
}
