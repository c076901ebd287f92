//! Values: how numbers with units are written on the command line.

use std::str::FromStr;
use std::time::Duration;

pub fn positive(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|&n| n > 0).ok_or_else(|| "must be a whole number above 0".into())
}

pub fn whole<T: FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| "must be a whole number, 0 or more".into())
}

pub fn positive_length(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|x: &f64| x.is_finite() && *x > 0.0)
        .ok_or_else(|| "must be a number above 0".into())
}

/// Each takes a stack, and more than a few hundred help no machine.
const MOST_THREADS: usize = 1024;

pub fn threads(text: &str) -> Result<usize, String> {
    positive(text)
        .ok()
        .filter(|&n| n <= MOST_THREADS)
        .ok_or_else(|| format!("must be a whole number from 1 to {MOST_THREADS}"))
}

pub fn tolerance(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x| (0.0..1.0).contains(x)).ok_or_else(|| "must lie between 0 and 1".into())
}

pub fn size(text: &str) -> Result<(usize, usize), String> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    parsed.filter(|&(w, h)| w > 0 && h > 0).ok_or_else(|| "write it as 800x600".into())
}

pub fn memory(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit: u64 = match &text[digits.len()..] {
        "" | "B" => 1,
        "KiB" => 1 << 10,
        "MiB" => 1 << 20,
        "GiB" => 1 << 30,
        "TiB" => 1 << 40,
        "kB" => 1_000,
        "MB" => 1_000_000,
        "GB" => 1_000_000_000,
        _ => return Err(MEMORY.into()),
    };
    let number: f64 = digits.parse().map_err(|_| MEMORY)?;
    let bytes = number * unit as f64;
    if bytes >= LEAST_MEMORY as f64 { Ok(bytes as u64) } else { Err(MEMORY.into()) }
}

/// With less than this nothing can be solved.
const LEAST_MEMORY: u64 = 16 << 20;

const MEMORY: &str =
    "write it as 4GiB or 500MB, at least 16MiB; units are B, kB, MB, GB, KiB, MiB, GiB and TiB";

/// A share of one, as 0.02 or 2%.
pub fn share(text: &str) -> Result<f64, String> {
    let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 0.01));
    let share = number.trim().parse().ok().map(|x: f64| x * unit);
    share.filter(|x| *x > 0.0 && *x < 1.0).ok_or_else(|| "write it as 2% or 0.02; between 0 and 1".into())
}

/// A time, as 90, 90s, 5min or 1h.
pub fn duration(text: &str) -> Result<Duration, String> {
    let units = [("min", 60.0), ("h", 3600.0), ("s", 1.0)];
    let with_unit = units.iter().find_map(|(unit, seconds)| Some((text.strip_suffix(unit)?, *seconds)));
    let (number, unit) = with_unit.unwrap_or((text, 1.0));
    let seconds = number.trim().parse().ok().map(|x: f64| x * unit);
    let sound = seconds.filter(|s| *s > 0.0 && *s <= 1e7);
    sound.map(Duration::from_secs_f64).ok_or_else(|| "write it as 90s, 5min or 1h; above 0".into())
}
