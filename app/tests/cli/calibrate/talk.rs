//! The program while it asks, and whoever answers.

use crate::program::{Ended, Folder, Running, isolate, sandtable};
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// `sandtable calibrate` while it asks.
pub(super) struct Talk {
    program: Running,
    answers: Option<ChildStdin>,
    prompts: Receiver<String>,
    said: String,
}

impl Talk {
    pub(super) fn start(folder: &Folder, arguments: &str) -> Self {
        let mut command = sandtable(folder.path());
        command.arg("calibrate").args(arguments.split(' '));
        command.args("--device flock=bird".split(' '));
        Self::with(command)
    }

    /// The same where no file may grow above 8 KiB, as on a disk that fills up.
    pub(super) fn start_on_a_full_disk(folder: &Folder, arguments: &str) -> Self {
        let program = env!("CARGO_BIN_EXE_sandtable");
        let script = format!(
            "trap '' XFSZ; ulimit -f 16; exec '{program}' calibrate {arguments} --device flock=bird"
        );
        let mut command = Command::new("sh");
        isolate(&mut command, folder.path());
        command.args(["-c", &script]);
        Self::with(command)
    }

    fn with(mut command: Command) -> Self {
        command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let mut program = command.spawn().expect("the program starts");
        let err = program.stderr.take().expect("it is piped");
        let (sender, prompts) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(err).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
        Self {
            answers: program.stdin.take(),
            program: Running(program),
            prompts,
            said: String::new(),
        }
    }

    /// Reads on until a line contains `part`, and returns it.
    #[track_caller]
    pub(super) fn hear(&mut self, part: &str) -> String {
        self.hear_one(&[part])
    }

    /// The same with any of `parts`.
    #[track_caller]
    fn hear_one(&mut self, parts: &[&str]) -> String {
        loop {
            match self.prompts.recv_timeout(Duration::from_secs(60)) {
                Ok(line) => {
                    self.said += &format!("{line}\n");
                    if parts.iter().any(|part| line.contains(part)) {
                        return line;
                    }
                }
                Err(_) => panic!("no {parts:?} in\n{}", self.said),
            }
        }
    }

    pub(super) fn say(&mut self, line: &str) {
        let answers = self.answers.as_mut().expect("not ended");
        answers
            .write_all(format!("{line}\n").as_bytes())
            .expect("it listens");
    }

    /// Answers the prompt that is there until the measurement is taken: a busy machine may show the
    /// sensor where it was a moment ago.
    #[track_caller]
    pub(super) fn measure(&mut self) {
        for _ in 0..20 {
            self.say("");
            if self.hear_one(&["got it", "again: "]).contains("got it") {
                return;
            }
            self.hear("Enter");
        }
        panic!("never taken:\n{}", self.said);
    }

    /// No more answers: it must end with 1 and an error that says all of `says`. Prompts and
    /// refusals before it may come several times.
    #[track_caller]
    pub(super) fn fails(self, says: &[&str]) -> Ended {
        let ended = self.end();
        assert_eq!(ended.status.code(), Some(1), "{ended:#?}");
        let last = ended.err.lines().last().unwrap_or_default();
        assert!(last.starts_with("sandtable: "), "{ended:#?}");
        for part in says {
            assert!(last.contains(part), "no {part:?} in {ended:#?}");
        }
        ended
    }

    /// No more answers; how it ends.
    pub(super) fn end(mut self) -> Ended {
        drop(self.answers.take());
        let status = self.program.end();
        let mut out = String::new();
        let pipe = self.program.0.stdout.as_mut().expect("it is piped");
        pipe.read_to_string(&mut out).expect("text");
        while let Ok(line) = self.prompts.recv() {
            self.said += &format!("{line}\n");
        }
        Ended {
            status,
            out,
            err: self.said,
        }
    }
}
