//! Tells the program who it is: the commit and the source that it is built from, and how.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// All that decides what the program computes.
const SOURCES: [&str; 7] =
    ["src", "partition/src", "io/src", "Cargo.toml", "Cargo.lock", "partition/Cargo.toml", "io/Cargo.toml"];

fn main() {
    let root = PathBuf::from(variable("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for source in SOURCES {
        println!("cargo:rerun-if-changed={source}");
        collect(&root.join(source), &mut files);
    }
    // The commit may change while no file does.
    for name in ["HEAD", "logs/HEAD"] {
        if let Some(path) = git(&root, &["rev-parse", "--git-path", name]).filter(|path| root.join(path).exists()) {
            println!("cargo:rerun-if-changed={path}");
        }
    }
    tell("SCREE_COMMIT", &commit(&root));
    tell("SCREE_SOURCE", &format!("{:016x}", digest(&root, &mut files)));
    tell("SCREE_BUILD", &build());
}

fn tell(name: &str, value: &str) {
    println!("cargo:rustc-env={name}={value}");
}

fn variable(name: &str) -> String {
    env::var(name).unwrap_or_default()
}

fn collect(path: &Path, files: &mut Vec<PathBuf>) {
    match fs::read_dir(path) {
        Ok(entries) => entries.flatten().for_each(|entry| collect(&entry.path(), files)),
        Err(_) => files.push(path.to_owned()),
    }
}

/// FNV-1a over names and contents, in the order of the names.
fn digest(root: &Path, files: &mut [PathBuf]) -> u64 {
    files.sort();
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for file in files.iter() {
        let name = file.strip_prefix(root).unwrap_or(file).to_string_lossy().into_owned();
        for byte in name.bytes().chain(fs::read(file).unwrap_or_default()) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
    hash
}

fn git(root: &Path, arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").arg("-C").arg(root).args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_string())
}

/// The commit, and whether the source differs from it. A source that was unpacked from an archive has none; one that lies in
/// somebody else's repository has not theirs.
fn commit(root: &Path) -> String {
    let top = git(root, &["rev-parse", "--show-toplevel"]).map(PathBuf::from);
    let is_ours = top.and_then(|top| top.canonicalize().ok()) == root.canonicalize().ok();
    let Some(commit) = git(root, &["rev-parse", "--short=10", "HEAD"]).filter(|_| is_ours) else {
        return "unknown".to_string();
    };
    let status = [&["status", "--porcelain", "--untracked-files=no", "--"][..], &SOURCES].concat();
    match git(root, &status) {
        Some(changes) if changes.is_empty() => commit,
        _ => format!("{commit}+changes"),
    }
}

/// Profile, features, target and compiler.
fn build() -> String {
    let features: Vec<String> = env::vars()
        .filter_map(|(name, _)| Some(name.strip_prefix("CARGO_FEATURE_")?.to_lowercase()))
        .filter(|name| name != "default")
        .collect();
    let features = if features.is_empty() { "no features".to_string() } else { features.join(" ") };
    let compiler = Command::new(variable("RUSTC")).arg("--version").output();
    let compiler = compiler.map(|output| String::from_utf8_lossy(&output.stdout).into_owned()).unwrap_or_default();
    let version = compiler.split_whitespace().nth(1).unwrap_or("unknown").to_string();
    let flags = variable("CARGO_ENCODED_RUSTFLAGS").replace('\u{1f}', " ");
    let flags = if flags.is_empty() { String::new() } else { format!(", flags {flags}") };
    format!(
        "{} (optimisation {}), {features}, {}, rustc {version}{flags}",
        variable("PROFILE"),
        variable("OPT_LEVEL"),
        variable("TARGET")
    )
}
