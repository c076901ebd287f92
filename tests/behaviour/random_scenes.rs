//! Laws on random scenes: the first of those that the example `random_scenes` tests with `--all`.

#[path = "../../examples/random_scenes/generator.rs"]
mod generator;
#[path = "../../examples/random_scenes/laws.rs"]
mod laws;
#[path = "../../examples/random_scenes/mesh.rs"]
mod mesh;
#[path = "../../examples/random_scenes/tally.rs"]
mod tally;

use crate::scratch::Scratch;

#[test]
fn energy_balances_solvers_agree_and_bounds_hold_on_random_scenes() {
    let scratch = Scratch::new();
    let outcomes = laws::check_all(0..60, scratch.folder(), |_| {}).expect("a writable folder");
    let tally = tally::Tally(outcomes);
    let failures = tally.failures();
    assert!(failures.is_empty(), "{}\n{}", failures.join("\n"), tally.table());
}
