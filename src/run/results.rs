//! Files that a command writes where its user says: pages, drawings, tables, grains for other codes. What is there already and
//! was not written by the program is refused, all of it before anything is written.

use std::fs;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use crate::base::error::Error;
use crate::run::folder;

/// What every file has that may be written again.
const MARK: &str = "written by scree";
/// The same in a file of numbers, where a comment cannot stand.
const MARKS_OF_DATA: [&str; 2] = ["\"program\": \"scree ", "\"program\":\"scree "];

/// Files that are written together.
#[derive(Debug, Default)]
pub struct Results {
    files: Vec<(PathBuf, String)>,
}

impl Results {
    /// A text to be written there, with the mark of the program. Nothing is written yet.
    pub fn add(&mut self, path: PathBuf, text: &str) {
        let text = marked(&path, text);
        self.files.push((path, text));
    }

    /// Writes all of them, each as a whole. Those of the program's own `place`, where nobody else puts files of these names, are
    /// not looked at before.
    pub fn write(self, is_own_place: bool) -> Result<(), Error> {
        self.files.iter().filter(|_| !is_own_place).try_for_each(|(path, _)| refuse_other(path))?;
        self.files.iter().try_for_each(|(path, text)| replace(path, text.as_bytes()))
    }
}

/// What is there and was not written by the program, of a command that will write it.
pub fn refuse_other(path: &Path) -> Result<(), Error> {
    refuse_file_of_a_run(path)?;
    if path.symlink_metadata().is_err() || is_ours(path) {
        return Ok(());
    }
    Err(Error::User(format!(
        "{} is there already and was not written by scree, so it is not replaced. Give another place with --out, or move it away.",
        path.display()
    )))
}

/// A new file, or with `overwrite` one that takes the place of another; never one of a run's own.
pub fn refuse_existing(path: &Path, overwrite: bool) -> Result<(), Error> {
    refuse_file_of_a_run(path)?;
    if overwrite || path.symlink_metadata().is_err() {
        return Ok(());
    }
    Err(Error::User(format!(
        "{} is there already. Give another name, or write over it with --overwrite.",
        path.display()
    )))
}

fn refuse_file_of_a_run(path: &Path) -> Result<(), Error> {
    match folder::is_of_a_run(path) {
        false => Ok(()),
        true => Err(Error::User(format!(
            "{} is a file of the run in that folder, and nothing but the run writes it. Give another name.",
            path.display()
        ))),
    }
}

/// Writes a file as a whole: what had its name, a link or a file, is replaced, or left as it was.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let aside = Aside::of(path);
    fs::write(aside.partial(), bytes).map_err(|error| unwritable(path, &error))?;
    aside.name()
}

/// A file in the making beside the name that it is to have; dropped before it is named, nothing is left of it.
pub struct Aside {
    path: PathBuf,
    aside: PathBuf,
}

impl Aside {
    /// Under a name that no other process has.
    pub fn of(path: &Path) -> Self {
        let mut name = std::ffi::OsString::from(".");
        name.push(path.file_name().unwrap_or_default());
        name.push(format!(".{}.tmp", std::process::id()));
        Self { path: path.to_owned(), aside: path.with_file_name(name) }
    }

    /// Where the file is made.
    pub fn partial(&self) -> &Path {
        &self.aside
    }

    /// Gives the file its name, in the place of whatever had it. [`Error::User`] where that cannot be.
    pub fn name(self) -> Result<(), Error> {
        fs::rename(&self.aside, &self.path).map_err(|error| unwritable(&self.path, &error))
    }
}

impl Drop for Aside {
    fn drop(&mut self) {
        // Once it has its name there is none of this.
        let _ = fs::remove_file(&self.aside);
    }
}

/// [`Error::User`] of a place that the user has chosen.
pub fn unwritable(path: &Path, error: &std::io::Error) -> Error {
    Error::User(format!("{} cannot be written: {error}. Give another place.", path.display()))
}

/// The text with what tells whose it is, as its kind of file can have it.
fn marked(path: &Path, text: &str) -> String {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("svg") => format!("{}\n<!-- {MARK} -->\n", text.trim_end_matches('\n')),
        Some("html") => text.replacen("<head>", &format!("<head>\n<meta name=\"generator\" content=\"{MARK}\">"), 1),
        Some("toml") => format!("# {MARK}\n{text}"),
        Some("json") => text.to_string(),
        _ => format!("{}\n({MARK})\n", text.trim_end_matches('\n')),
    }
}

/// Whether the program has written a file, as far as it tells.
fn is_ours(path: &Path) -> bool {
    const LOOKED_AT: u64 = 64 << 20;
    let mut text = Vec::new();
    let read = fs::File::open(path).and_then(|file| file.take(LOOKED_AT).read_to_end(&mut text));
    match read {
        Ok(_) => {
            let text = String::from_utf8_lossy(&text);
            [MARK].iter().chain(&MARKS_OF_DATA).any(|mark| text.contains(mark))
        }
        // A link to nothing leads nowhere.
        Err(error) => error.kind() == ErrorKind::NotFound && !path.is_symlink(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_written_again_and_a_users_file_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let all = || {
            let mut results = Results::default();
            results.add(at("page.html"), "<html><head></head></html>");
            results.add(at("page.svg"), "<svg/>");
            results.add(at("page.txt"), "words\n");
            results.add(at("page.toml"), "x = 1\n");
            results.add(at("page.json"), &format!("{{\"program\": \"{}\"}}", crate::base::program::identity()));
            results
        };
        all().write(false).unwrap();
        all().write(false).unwrap();
        for name in ["page.html", "page.svg", "page.txt", "page.toml", "page.json"] {
            fs::remove_file(at("page.html")).unwrap();
            let before = fs::read(at(name)).ok();
            fs::write(at(name), "mine").unwrap();
            let words = all().write(false).unwrap_err().to_string();
            assert!(words.contains(name) && words.contains("was not written by scree"), "{words}");
            assert_eq!(fs::read_to_string(at(name)).unwrap(), "mine");
            // Nothing else was written before.
            assert!(name == "page.html" || !at("page.html").exists());
            all().write(true).unwrap();
            drop(before);
        }
    }

    #[test]
    fn a_file_of_a_run_is_never_written_over() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("scenario.toml"), "name = \"x\"\n").unwrap();
        for name in ["scenario.toml", "series.csv", "frames.2.vtkhdf", "run.lock", "log.jsonl"] {
            let words = refuse_existing(&folder.path().join(name), true).unwrap_err().to_string();
            assert!(words.contains("is a file of the run"), "{name}: {words}");
        }
        assert!(refuse_existing(&folder.path().join("grains.csv"), false).is_ok());
        fs::write(folder.path().join("grains.csv"), "").unwrap();
        assert!(refuse_existing(&folder.path().join("grains.csv"), false).is_err());
        assert!(refuse_existing(&folder.path().join("grains.csv"), true).is_ok());
    }
}
