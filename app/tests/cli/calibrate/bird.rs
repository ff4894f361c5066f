//! A simulated sensor, and the hand that moves it.

use super::table_from_tracker;
use crate::program::{Folder, Running, sandtable};
use glam::{DQuat, DVec3, EulerRot};
use sandtable_pose::Rigid;
use std::io::{BufRead, BufReader, Write};
use std::process::{ChildStdin, Stdio};

/// A simulated bird that goes where it is told.
pub(super) struct Bird {
    _program: Running,
    pub(super) orders: ChildStdin,
    answers: BufReader<std::process::ChildStdout>,
}

impl Bird {
    pub(super) fn start(folder: &Folder, arguments: &str) -> Self {
        let mut command = sandtable(folder.path());
        command.args("simulate flock --birds 1 --steer --link bird".split(' '));
        command.args(arguments.split(' ').filter(|argument| !argument.is_empty()));
        command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null());
        let mut program = command.spawn().expect("the program starts");
        let orders = program.stdin.take().expect("it is piped");
        let out = program.stdout.take().expect("it is piped");
        let mut bird = Self {
            _program: Running(program),
            orders,
            answers: BufReader::new(out),
        };
        assert_eq!(bird.answer(), "bird\n");
        bird
    }

    fn answer(&mut self) -> String {
        let mut line = String::new();
        self.answers.read_line(&mut line).expect("an answer");
        line
    }

    /// Puts the sensor there: tracker frame, and azimuth, elevation and roll in degrees.
    pub(super) fn put(&mut self, position: DVec3, [azimuth, elevation, roll]: [f64; 3]) {
        let inches = position / 0.0254;
        let line = format!(
            "1,{},{},{},{azimuth},{elevation},{roll}\n",
            inches.x, inches.y, inches.z
        );
        self.orders.write_all(line.as_bytes()).expect("it listens");
        assert_eq!(self.answer(), "1\n");
    }

    /// Puts `tip` of a stylus held at these angles on a place of the table.
    pub(super) fn touch(&mut self, place: DVec3, tip: DVec3, angles: [f64; 3]) {
        self.touch_from(&table_from_tracker(), place, tip, angles);
    }

    /// The same from a tracker that stands elsewhere.
    pub(super) fn touch_from(
        &mut self,
        table_from_tracker: &Rigid,
        place: DVec3,
        tip: DVec3,
        angles: [f64; 3],
    ) {
        let offset = rotation(angles) * tip;
        self.put(table_from_tracker.inverse().point(place) - offset, angles);
    }
}

/// The attitude of these angles.
pub(super) fn rotation([azimuth, elevation, roll]: [f64; 3]) -> DQuat {
    DQuat::from_euler(
        EulerRot::ZYX,
        azimuth.to_radians(),
        elevation.to_radians(),
        roll.to_radians(),
    )
}
