//! Requests and answers.

use anyhow::{Context, Result, bail, ensure};
use glam::DVec3;
use sandtable_terrain::Ground;
use sandtable_view::View;
use std::io::{BufRead, BufReader, BufWriter, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// How Embree holds a terrain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Geometry {
    /// Its geometry for grids of posts, in compressed form.
    Grid,
    /// Two triangles a cell.
    Triangles,
}

impl Geometry {
    /// Both.
    pub(crate) const ALL: [Self; 2] = [Self::Grid, Self::Triangles];

    fn request(self) -> &'static str {
        match self {
            Self::Grid => "grid",
            Self::Triangles => "triangles",
        }
    }
}

/// What building a geometry took, on one thread.
pub(crate) struct Built {
    /// Milliseconds.
    pub(crate) ms: f64,
    /// Bytes held afterwards, beside vertices and colours.
    pub(crate) bytes: u64,
    /// Bytes held at most meanwhile.
    pub(crate) peak_bytes: u64,
}

/// The process, with one terrain. It ends when this is dropped.
pub(crate) struct Embree {
    child: Child,
    requests: BufWriter<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Drop for Embree {
    fn drop(&mut self) {
        // It may be gone already; nothing is left to do then.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Embree {
    /// Starts `program`.
    pub(crate) fn start(program: &Path) -> Result<Self> {
        let mut child = Command::new(program)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .with_context(|| format!("cannot start {}", program.display()))?;
        let requests = child.stdin.take().context("a pipe was asked for")?;
        let answers = child.stdout.take().context("a pipe was asked for")?;
        Ok(Self {
            child,
            requests: BufWriter::new(requests),
            answers: BufReader::new(answers),
        })
    }

    /// Hands over the terrain, whose photograph has a pixel a post, and returns how many bytes
    /// Embree's caller holds for it: vertices and colours.
    pub(crate) fn load(&mut self, ground: &Ground) -> Result<u64> {
        let grid = ground.grid();
        let photo = ground.photo().context("the scenes have photographs")?;
        let pixels = &photo.pixels;
        ensure!(
            photo.origin.to_array() == [0.0; 2]
                && photo.spacing == grid.spacing
                && [pixels.cols(), pixels.rows()] == [grid.cols, grid.rows],
            "the scenes' photographs have a pixel a post"
        );
        writeln!(
            self.requests,
            "terrain {} {} {} {}",
            grid.cols, grid.rows, grid.spacing.x, grid.spacing.y
        )?;
        for row in 0..grid.rows {
            for col in 0..grid.cols {
                let height = ground.heights().post(col, row);
                self.requests.write_all(&height.to_ne_bytes())?;
            }
        }
        for row in 0..grid.rows {
            for col in 0..grid.cols {
                self.requests.write_all(&pixels.post(col, row))?;
            }
        }
        let [bytes] = self.answer("terrain")?;
        Ok(bytes as u64)
    }

    /// Builds a geometry.
    pub(crate) fn build(&mut self, geometry: Geometry) -> Result<Built> {
        writeln!(self.requests, "build {}", geometry.request())?;
        let [ms, bytes, peak_bytes] = self.answer("built")?;
        Ok(Built {
            ms,
            bytes: bytes as u64,
            peak_bytes: peak_bytes as u64,
        })
    }

    /// Looks through `view` from now on.
    pub(crate) fn look(&mut self, view: &View) -> Result<()> {
        let first = view.direction(0.5, 0.5);
        let right = view.direction(1.5, 0.5) - first;
        let down = view.direction(0.5, 1.5) - first;
        write!(self.requests, "view {} {}", view.size[0], view.size[1])?;
        for DVec3 { x, y, z } in [view.eye, first, right, down] {
            write!(self.requests, " {x} {y} {z}")?;
        }
        writeln!(self.requests)?;
        let [] = self.answer("view")?;
        Ok(())
    }

    /// Casts a frame on `threads` threads and returns its milliseconds.
    pub(crate) fn frame(&mut self, geometry: Geometry, threads: usize) -> Result<f64> {
        writeln!(self.requests, "frame {} {threads}", geometry.request())?;
        let [ms] = self.answer("frame")?;
        Ok(ms)
    }

    /// The last frame, row by row from the top: depths in metres, +∞ for sky, and colours, of
    /// which the fourth byte says nothing.
    pub(crate) fn image(&mut self) -> Result<(Vec<f32>, Vec<[u8; 4]>)> {
        writeln!(self.requests, "image")?;
        let [bytes] = self.answer("image")?;
        let mut image = vec![0; bytes as usize];
        self.answers.read_exact(&mut image)?;
        let (depth, colour) = image.split_at(image.len() / 2);
        Ok((
            bytemuck::pod_collect_to_vec(depth),
            bytemuck::pod_collect_to_vec(colour),
        ))
    }

    /// The numbers of the answer to what has been asked, which begins with `word`.
    fn answer<const N: usize>(&mut self, word: &str) -> Result<[f64; N]> {
        self.requests.flush()?;
        let mut line = String::new();
        self.answers.read_line(&mut line)?;
        let mut words = line.split_whitespace();
        if words.next() != Some(word) {
            bail!("Embree's process answers {line:?} where {word:?} is due");
        }
        let numbers = words.map(str::parse).collect::<Result<Vec<f64>, _>>();
        let numbers = numbers.ok().and_then(|numbers| numbers.try_into().ok());
        numbers.with_context(|| format!("{line:?} has not {N} numbers"))
    }
}
