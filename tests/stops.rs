//! A packing that takes long says how far it is, and SIGTERM ends it at once, on one rank as on two.

use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

use crate::mpirun::{SCREE, scree, signal, turn};

const JOB: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/jobs/element/rve_ensemble.toml");

/// Sends SIGTERM after the first word of progress on a packing that is far from rest; code and closing lines.
fn stopped(mut command: Command) -> (Option<i32>, String) {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let told = lines.find(|line| line.contains("compressing")).expect("it was told before it ended");
    assert!(["step=", "stress=", "fraction="].iter().all(|word| told.contains(word)), "{told}");
    signal(child.id(), "TERM");
    let mut text = String::new();
    child.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    // A launcher has its own word on the matter.
    lines.for_each(drop);
    (child.wait().unwrap().code(), text)
}

#[test]
fn a_packing_is_told_and_can_be_stopped() {
    let _turn = turn();
    let folder = tempfile::tempdir().unwrap();
    let cache = format!("packing.cache={}", folder.path().display());
    let outs = ["alone", "together"].map(|name| folder.path().join(name).display().to_string());
    let arguments = |out: &str| {
        let large = [
            "--set",
            "grains.count=10000",
            "--set",
            "cell.upper=[1.0, 1.0]",
            "--set",
            "packing.fraction_start=0.4",
            "--set",
            cache.as_str(),
        ];
        ["run", JOB, "--out", out, "--threads", "1"]
            .iter()
            .chain(&large)
            .map(|word| (*word).to_string())
            .collect::<Vec<String>>()
    };
    let mut alone = Command::new(SCREE);
    alone.args(arguments(&outs[0]));
    let together = scree(2, &arguments(&outs[1]).iter().map(String::as_str).collect::<Vec<&str>>());
    for (command, out, code) in [(alone, &outs[0], Some(4)), (together, &outs[1], None)] {
        let (found, text) = stopped(command);
        assert!(text.starts_with("Stopped on request while the packing was made, after "), "{text}");
        assert!(text.contains(&format!("remove {out} and start the run again")), "{text}");
        assert!(code.is_none() || found == code, "{found:?}");
    }
    assert!(
        std::fs::read_dir(folder.path()).unwrap().all(|entry| entry.unwrap().path().is_dir()),
        "a packing was kept"
    );
}
