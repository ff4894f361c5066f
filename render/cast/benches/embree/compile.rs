//! From `embree.cpp` to a program, on the machine that is measured.

use anyhow::{Context, Result, ensure};
use std::env;
use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What there is to run.
pub(crate) enum Compiled {
    /// The program.
    Ready(PathBuf),
    /// What is missing, and how to get it.
    Missing(String),
}

const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/embree/embree.cpp");
const HEADER: &str = "embree3/rtcore.h";

/// Everything that makes it fast here. Square roots need not set `errno`, so that whole vectors
/// are taken at once.
const FLAGS: [&str; 4] = ["-std=c++20", "-O3", "-march=native", "-fno-math-errno"];

/// Compiles the program into `folder` where a C++ compiler finds Embree.
///
/// # Errors
/// Where the compiler is there, finds Embree, and fails.
pub(crate) fn compiled(folder: &Path) -> Result<Compiled> {
    let compiler = env::var_os("CXX").unwrap_or_else(|| OsString::from("c++"));
    let missing = |what: String| Ok(Compiled::Missing(what));
    let header = Command::new(&compiler)
        .args(["-E", "-x", "c++", "-include", HEADER, "/dev/null"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    match header {
        Ok(status) if status.success() => {}
        Ok(_) => {
            return missing(format!(
                "{} finds no {HEADER}; on Debian 12: apt-get install libembree-dev",
                compiler.display()
            ));
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return missing(format!(
                "there is no C++ compiler {}; on Debian 12: apt-get install g++ libembree-dev",
                compiler.display()
            ));
        }
        Err(error) => {
            return Err(error).with_context(|| format!("cannot run {}", compiler.display()));
        }
    }
    let program = folder.join("embree");
    let status = Command::new(&compiler)
        .args(FLAGS)
        .arg(SOURCE)
        .args(["-lembree3", "-pthread", "-o"])
        .arg(&program)
        .status()
        .with_context(|| format!("cannot run {}", compiler.display()))?;
    ensure!(
        status.success(),
        "{} cannot compile {SOURCE}",
        compiler.display()
    );
    Ok(Compiled::Ready(program))
}
