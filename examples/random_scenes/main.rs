//! Laws on random scenes: boxes in a room that intersect, share corners, lie flush, are thin to 10⁻⁶ m, of
//! all materials, under tiny and turned lamps.
//!
//! Energy adds up, solvers agree, coincident surfaces answer as if one were lifted, and finer answers lie
//! within the error bounds. Exits with an error where a law is broken.
//!
//! ```text
//! cargo run --release --example random_scenes                          # 60 scenes
//! cargo run --release --example random_scenes -- --all                 # 500
//! cargo run --release --example random_scenes -- --seed 7 --keep DIR   # one, its files kept
//! ```

mod generator;
mod laws;
mod mesh;
mod tally;

use std::ops::Range;
use std::path::PathBuf;
use std::time::Instant;

use tally::Tally;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scratch = tempfile::tempdir()?;
    let mut seeds: Range<u64> = 0..60;
    let mut folder = scratch.path().to_owned();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--all" => seeds = 0..500,
            "--seed" => {
                let seed = value()?.parse()?;
                seeds = seed..seed + 1;
            }
            "--keep" => folder = PathBuf::from(value()?),
            _ => return Err(format!("{argument}: known are --all, --seed N and --keep FOLDER").into()),
        }
    }
    std::fs::create_dir_all(&folder)?;
    let began = Instant::now();
    let mut outcomes = Vec::new();
    for seed in seeds {
        let began = Instant::now();
        let outcome = laws::check(seed, &folder)?;
        let features: Vec<&str> = outcome.features.iter().copied().collect();
        let state = match outcome.is_refused {
            true => "refused",
            false if outcome.broken.is_empty() => "good",
            false => "broken",
        };
        println!("{seed:4} {state:7} {:5.1} s  {}", began.elapsed().as_secs_f64(), features.join(", "));
        outcome.broken.iter().for_each(|(law, how)| println!("       {law:?}: {how}"));
        outcome.warnings.iter().for_each(|warning| println!("       warning: {warning}"));
        outcomes.push(outcome);
    }
    let tally = Tally(outcomes);
    println!("\n{}\n{:.0} s", tally.table(), began.elapsed().as_secs_f64());
    let failures = tally.failures();
    failures.iter().for_each(|failure| eprintln!("{failure}"));
    if failures.is_empty() { Ok(()) } else { Err("laws are broken".into()) }
}
