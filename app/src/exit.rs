//! How the program ends: 0 done, 1 failed, 2 bad usage.

use std::fmt;
use std::process::ExitCode;

/// What was asked for cannot be meant; the message says what can.
#[derive(Debug)]
struct Usage(String);

impl fmt::Display for Usage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Usage {}

/// An error of usage, which ends the program with 2.
pub(crate) fn usage(message: impl fmt::Display) -> anyhow::Error {
    anyhow::Error::new(Usage(message.to_string()))
}

/// Prints why the program fails, if it does, and gives its exit code.
pub(crate) fn report(result: anyhow::Result<()>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("sandtable: {}", in_words(&error));
            ExitCode::from(if error.is::<Usage>() { 2 } else { 1 })
        }
    }
}

/// The error and its causes, outermost first, each said once: many messages quote their cause.
fn in_words(error: &anyhow::Error) -> String {
    let mut words = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if !words.contains(&cause) {
            if !words.is_empty() {
                words += ": ";
            }
            words += &cause;
        }
    }
    words
}

/// Whoever read our output has had enough of it; that is no failure.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<std::io::Error>()
        .is_some_and(|error| error.kind() == std::io::ErrorKind::BrokenPipe)
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context;

    #[test]
    fn a_quoted_cause_is_not_said_again() {
        let cause = std::io::Error::other("no such thing");
        let error = Err::<(), _>(cause).context("cannot read x: no such thing; look again");
        let error = error.context("while opening").unwrap_err();
        assert_eq!(
            in_words(&error),
            "while opening: cannot read x: no such thing; look again"
        );
    }
}
