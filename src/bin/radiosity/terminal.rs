//! Terminal: what the user sees while and after the library works. An [`Observer`] that draws progress, keeps
//! the time of every stage, and passes Ctrl-C and SIGTERM on.

use std::io::{self, IsTerminal, Write};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use std::{process, thread};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use radiosity::output::Stage;
use radiosity::progress::{Observer, Progress};
use radiosity::scene::Scene;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

/// Any error, ready to be printed.
pub type Failure = Box<dyn std::error::Error>;

/// How long a signal waits for a step to end.
const PATIENCE: Duration = Duration::from_secs(5);

/// A stage shorter than this draws no bar.
const BRIEF: Duration = Duration::from_millis(700);

pub struct Terminal {
    prints: bool,
    warns: bool,
    draws: bool,
    /// The status with which to end since a signal asked for it; 0 before.
    stopped: Arc<AtomicUsize>,
    run: Mutex<Run>,
}

/// The stages so far; the last is under way.
struct Run {
    stages: Vec<Stage>,
    began: Instant,
    bar: Option<ProgressBar>,
}

impl Terminal {
    pub fn new(quiet: bool, json: bool) -> Self {
        Self {
            prints: !quiet && !json,
            warns: !quiet,
            draws: !quiet && std::io::stderr().is_terminal(),
            stopped: Arc::default(),
            run: Mutex::new(Run { stages: Vec::new(), began: Instant::now(), bar: None }),
        }
    }

    /// The first Ctrl-C or SIGTERM ends the run at the next report of progress, or after [`PATIENCE`] where
    /// none comes; a second one ends it at once.
    pub fn stop_on_signals(&self) -> io::Result<()> {
        let mut signals = Signals::new([SIGINT, SIGTERM])?;
        let stopped = Arc::clone(&self.stopped);
        thread::spawn(move || {
            for signal in signals.forever() {
                let status = if signal == SIGINT { 130 } else { 143 };
                if stopped.swap(status, Ordering::Relaxed) > 0 {
                    process::exit(status as i32);
                }
                thread::spawn(move || {
                    thread::sleep(PATIENCE);
                    eprintln!("stopped within a long step; results of earlier runs are as they were");
                    process::exit(status as i32);
                });
            }
        });
        Ok(())
    }

    /// The exit status of a run that a signal ended, if one did.
    pub fn stopped(&self) -> Option<u8> {
        Some(self.stopped.load(Ordering::Relaxed) as u8).filter(|&status| status > 0)
    }

    pub fn progress(&self) -> Progress<'_> {
        Progress::to(self)
    }

    /// Prints lines of results, unless --quiet or --json is given.
    pub fn say(&self, lines: impl std::fmt::Display) -> Result<(), Failure> {
        if self.prints { self.print(lines) } else { Ok(()) }
    }

    /// Prints to standard output; that a reader has gone away is no error.
    pub fn print(&self, lines: impl std::fmt::Display) -> Result<(), Failure> {
        self.clear();
        match writeln!(io::stdout().lock(), "{lines}") {
            Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(format!("cannot print: {e}").into()),
            _ => Ok(()),
        }
    }

    /// Prints a warning; only --quiet silences it.
    pub fn warn(&self, line: impl std::fmt::Display) {
        if self.warns {
            self.complain(format_args!("warning: {line}"));
        }
    }

    /// Prints to standard error; where that fails there is no one left to tell.
    pub fn complain(&self, line: impl std::fmt::Display) {
        self.clear();
        let _ = writeln!(io::stderr().lock(), "{line}");
    }

    /// Tells what reading a scene brought to light.
    pub fn warn_of(&self, scene: &Scene) {
        scene.warnings().iter().for_each(|warning| self.warn(warning));
    }

    /// Notes the bytes that the result of the stage under way takes.
    pub fn takes(&self, bytes: u64) {
        if let Some(stage) = self.run().stages.last_mut() {
            stage.bytes = bytes;
        }
    }

    /// Ends the stage under way; answers all stages so far.
    pub fn stages(&self) -> Vec<Stage> {
        let mut run = self.run();
        run.close();
        run.stages.clone()
    }

    /// Takes the progress bar off the screen.
    pub fn clear(&self) {
        if let Some(bar) = self.run().bar.take() {
            bar.finish_and_clear();
        }
    }

    fn run(&self) -> MutexGuard<'_, Run> {
        self.run.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Run {
    fn close(&mut self) {
        if let Some(stage) = self.stages.last_mut() {
            stage.seconds += self.began.elapsed().as_secs_f64();
        }
        self.began = Instant::now();
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }

    /// Goes on to a stage, anew or where it was left.
    fn open(&mut self, name: &'static str) {
        self.close();
        let stage = match self.stages.iter().position(|s| s.name == name) {
            Some(known) => self.stages.remove(known),
            None => Stage { name, seconds: 0.0, bytes: 0 },
        };
        self.stages.push(stage);
    }

    fn draw(&mut self, done: f64) {
        const STEPS: f64 = 1000.0;
        if self.began.elapsed() < BRIEF || done <= 0.0 {
            return;
        }
        let Run { stages, began, bar } = self;
        let bar = bar.get_or_insert_with(|| {
            let style = ProgressStyle::with_template("{msg:>8} {bar:40} {percent:>3} %  {prefix}");
            let bar = ProgressBar::with_draw_target(Some(STEPS as u64), ProgressDrawTarget::stderr());
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.set_message(stages.last().map_or("", |s| s.name));
            bar
        });
        let left = began.elapsed().as_secs_f64() * (1.0 - done) / done;
        bar.set_prefix(format!("{left:.0} s left"));
        bar.set_position((done * STEPS) as u64);
    }
}

impl Observer for Terminal {
    fn at(&self, stage: &'static str, done: f64) -> ControlFlow<()> {
        if self.stopped().is_some() {
            return ControlFlow::Break(());
        }
        let mut run = self.run();
        if run.stages.last().is_none_or(|s| s.name != stage) {
            run.open(stage);
        }
        if self.draws {
            run.draw(done);
        }
        ControlFlow::Continue(())
    }
}

/// The first few names of a list, and how many more there are: `a, b and 12 more`.
pub fn first_few(names: &[&str], most: usize) -> String {
    let named = names[..names.len().min(most)].join(", ");
    match names.len().saturating_sub(most) {
        0 => named,
        more => format!("{named} and {more} more"),
    }
}
