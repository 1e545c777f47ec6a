//! A newcomer's shell: an empty folder, the program on the path, and what the handbook prints typed into it.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::mpirun::{SCREE, launching};

pub struct Shell {
    pub folder: tempfile::TempDir,
    path: OsString,
    /// What runs Python, if there is one with the packages.
    python: Option<String>,
}

impl Shell {
    pub fn new() -> Self {
        let beside = Path::new(SCREE).parent().unwrap();
        let old = std::env::var_os("PATH").unwrap_or_default();
        let paths: Vec<PathBuf> = [beside.to_path_buf()].into_iter().chain(std::env::split_paths(&old)).collect();
        Self {
            folder: tempfile::tempdir().unwrap(),
            path: std::env::join_paths(paths).unwrap(),
            python: std::env::var("SCREE_PYTHON").ok(),
        }
    }

    /// What it says; any line that fails ends the text, and the test. Python is left out where there is none.
    #[track_caller]
    pub fn types(&self, language: &str, text: &str) -> String {
        let mut command = match (language, &self.python) {
            ("python", Some(python)) => Command::new(python),
            ("python", None) => return String::new(),
            _ => Command::new("bash"),
        };
        let text = if language == "python" { text.to_owned() } else { format!("set -e\n{text}") };
        launching(&mut command);
        let ended = command
            .args(["-c", &text])
            .current_dir(self.folder.path())
            .env("PATH", &self.path)
            .env("PYTHONPATH", Path::new(env!("CARGO_MANIFEST_DIR")).join("io/python"))
            .stdin(Stdio::null())
            .output()
            .unwrap();
        let words = String::from_utf8_lossy(&ended.stdout).into_owned() + &String::from_utf8_lossy(&ended.stderr);
        assert!(ended.status.success(), "{text}\n{words}");
        words
    }
}
