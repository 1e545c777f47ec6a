//! The Python package of `io/python` against runs of the program.

use std::path::Path;
use std::process::{Command, Output};

/// What the package needs of the interpreter.
const NEEDED: &str = "import sys, numpy, pandas, h5py\nif sys.version_info < (3, 11): import tomli";

/// Its own tests, by the interpreter that has what it needs. Whoever names one promises that.
#[test]
fn runs_are_arrays_in_python() {
    let named = std::env::var("SCREE_PYTHON").ok();
    let python = |arguments: &[&str]| -> std::io::Result<Output> {
        Command::new(named.as_deref().unwrap_or("python3"))
            .args(arguments)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .env("PYTHONPATH", Path::new(env!("CARGO_MANIFEST_DIR")).join("io/python"))
            .env("PYTHONDONTWRITEBYTECODE", "1")
            .env("SCREE", env!("CARGO_BIN_EXE_scree"))
            .output()
    };
    let has_all = python(&["-c", NEEDED]).is_ok_and(|output| output.status.success());
    if !has_all {
        assert!(named.is_none(), "SCREE_PYTHON has no numpy, pandas, h5py or (before Python 3.11) tomli");
        return println!("skipped: no Python with numpy, pandas and h5py");
    }
    let output =
        python(&["-W", "error::DeprecationWarning:scree", "-m", "unittest", "discover", "-s", "io/python/tests"]);
    let output = output.expect("it has just been started");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.contains("OK"), "{said}");
    println!("{said}");
}
