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

use laws::Outcome;
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
    let tally = Tally(laws::check_all(seeds, &folder, show)?);
    println!("\n{}\n{:.0} s", tally.table(), began.elapsed().as_secs_f64());
    let failures = tally.failures();
    failures.iter().for_each(|failure| eprintln!("{failure}"));
    if failures.is_empty() { Ok(()) } else { Err("laws are broken".into()) }
}

/// Prints how one scene fared, in one piece: several are at work at a time.
fn show(outcome: &Outcome) {
    let features: Vec<&str> = outcome.features.iter().copied().collect();
    let state = match outcome.is_refused {
        true => "refused",
        false if outcome.broken.is_empty() => "good",
        false => "broken",
    };
    let mut text =
        format!("{:4} {state:7} {:5.1} s  {}\n", outcome.seed, outcome.seconds, features.join(", "));
    outcome.broken.iter().for_each(|(law, how)| text += &format!("       {law:?}: {how}\n"));
    outcome.warnings.iter().for_each(|warning| text += &format!("       warning: {warning}\n"));
    print!("{text}");
}
