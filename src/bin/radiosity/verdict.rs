//! Verdict: what a command says of how far its answer can be relied on, and its exit status.

use radiosity::measure::{Level, Verdict};

use crate::terminal::{Failure, Terminal};

/// What to do about a bad answer.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Run")]
pub struct StrictArgs {
    /// Exit with status 1 if the verdict on the answer is bad; results are written all the same
    #[arg(long)]
    strict: bool,
}

impl StrictArgs {
    /// Fails if the answer is bad and that matters.
    pub fn conclude(&self, verdict: &Verdict) -> Result<(), Failure> {
        match verdict.level {
            Level::Bad if self.strict => Err(format!("the answer is {}", phrase(verdict)).into()),
            _ => Ok(()),
        }
    }
}

/// Warns of everything that is wrong with an answer, in a line each.
pub fn warn(verdict: &Verdict, terminal: &Terminal) {
    for reason in &verdict.reasons {
        match reason.level {
            Level::Good => terminal.warn(format_args!("{reason}")),
            level => terminal.warn(format_args!("{} answer: {reason}", level.name())),
        }
    }
}

/// The level, and the causes where it is not good: `doubtful: slack, truncation`.
pub fn phrase(verdict: &Verdict) -> String {
    match verdict.level {
        level @ Level::Good => level.name().into(),
        level => format!("{}: {}", level.name(), verdict.causes()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_bad_answers_fail_and_only_where_that_is_asked_for() {
        for level in [Level::Good, Level::Truncated, Level::Doubtful, Level::Bad] {
            let verdict = Verdict { level, reasons: Vec::new() };
            assert!(StrictArgs { strict: false }.conclude(&verdict).is_ok());
            assert_eq!(StrictArgs { strict: true }.conclude(&verdict).is_err(), level == Level::Bad);
        }
    }
}
