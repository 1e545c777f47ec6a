//! A packing that takes long says how far it is, and SIGTERM ends it at once, on one rank as on two, with what there is of it kept; a
//! run that stops itself says what it leaves.

use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

use crate::mpirun::{SCREE, scree, signal, turn};

const JOB: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/jobs/element/rve_ensemble.toml");

/// Sends SIGTERM after the first word of progress on a packing that is far from rest; code and closing lines.
fn stopped(mut command: Command) -> (Option<i32>, String) {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let told = lines.find(|line| line.contains("compressing: step ")).expect("it was told before it ended");
    let wanted = ["us a step", "kinetic over elastic energy ", "(goal 1.0e-", "of the stress, solid volume fraction "];
    assert!(wanted.iter().all(|word| told.contains(word)), "{told}");
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
    let outs = ["alone", "together"].map(|name| folder.path().join(name).display().to_string());
    let arguments = |out: &str| {
        let cache = format!("packing.cache=\"{out}_cache\"");
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
        assert!(text.contains(&format!("which are kept. `scree resume {out}` goes on.")), "{text}");
        assert!(code.is_none() || found == code, "{found:?}");
        let makings = std::fs::read_dir(format!("{out}_cache")).unwrap().map(|entry| entry.unwrap().path());
        let kept: Vec<_> = makings.map(|making| making.join("progress.h5")).collect();
        assert!(kept.len() == 1 && kept[0].exists(), "{kept:?}");
    }
}

/// A run that stops itself leaves more than a message: where it can be gone on from, or that it cannot.
#[test]
fn a_run_that_stops_itself_names_its_newest_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("one.csv"), "id,x,y,radius,vx,vy,spin\n0,5e-3,5e-3,5e-4,10,0,0\n").unwrap();
    let job = r#"name = "flies"
[cell]
space = "plane"
upper = ["1 cm", "1 cm"]
periodic = [false, false]
[grains]
density = 2500
file = "one.csv"
diameter_mean = "1 mm"
[contact]
stiffness_normal = "100 kN/m"
stiffness_tangential = "50 kN/m"
restitution = 0.5
friction = 0.5
[time]
step = "1 us"
end = "10 ms"
"#;
    std::fs::write(folder.path().join("job.toml"), job).unwrap();
    let stopped = |out: &str, interval: &str| {
        let mut run = Command::new(SCREE);
        run.current_dir(folder.path()).args(["run", "job.toml", "--threads", "1", "--out", out, "--set"]);
        let ended = run.arg(format!("output.checkpoint_interval={interval}")).output().unwrap();
        assert_eq!(ended.status.code(), Some(3));
        let words = String::from_utf8(ended.stderr).unwrap();
        assert!(words.contains("outside the domain") && words.contains("cell.lower and cell.upper"), "{words}");
        words
    };
    let words = stopped("kept", "0.2 ms");
    let newest = "The newest checkpoint is kept/checkpoints/step-000000000400.h5; `scree resume kept` goes on from it.";
    assert!(words.contains(newest), "{words}");
    // Before the first of them there is the state that it began with.
    let words = stopped("none", "5 ms");
    let first = "none/checkpoints/for_good/step-000000000000.h5; `scree resume none` goes on from it.";
    assert!(words.contains(first), "{words}");
}
