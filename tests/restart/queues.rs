//! The scripts of `jobs/cluster/` and what they rest on: one line that starts a job and goes on with it.
//!
//! Slurm is played by two small programs: `srun` starts the ranks by mpirun, `scontrol` notes what it was asked.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::mpirun::{SCREE, a_rank_of, signal, turn, words};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// Nothing here takes a tenth of this, unless a machine has much else to do.
const PATIENCE: Duration = Duration::from_secs(400);

/// A sheared cell of discs that runs for some seconds.
pub const JOB: &str = r#"name = "queued"
[cell]
space = "plane"
upper = ["2 cm", "2 cm"]
velocity_gradient = [[0, "2 1/s"], [0, 0]]
[grains]
density = 2530
count = 400
distribution = "normal"
diameter_mean = "1 mm"
diameter_deviation = "0.08 mm"
[packing]
preparation = "compress"
stress = "100 kPa"
energy_ratio_max = 1e-2
cache = "cache"
[contact]
stiffness_normal = 1772093.8
stiffness_tangential = 886046.9
restitution = 0.3
friction = 0.5
[time]
step = "0.4 us"
end = "40 ms"
[output]
series_interval = "0.2 ms"
checkpoint_interval = "30 ms"
"#;

/// A folder with the job, its packing, and the two programs in `bin`.
struct Cluster {
    folder: tempfile::TempDir,
    digest: String,
}

impl Cluster {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        std::fs::create_dir(folder.path().join("bin")).unwrap();
        write("job.toml", JOB);
        // Options out, ranks by mpirun, whose number the test reads.
        write(
            "bin/srun",
            "#!/usr/bin/env bash\nwhile [ \"${1#-}\" != \"$1\" ]; do shift; done\nmpirun $MPIRUN_OPTIONS -n \"$SLURM_NTASKS\" \"$@\" &\necho $! >mpirun.pid\nwait $!\n",
        );
        write("bin/scontrol", "#!/usr/bin/env bash\necho \"$@\" >>scontrol.log\n");
        for name in ["bin/srun", "bin/scontrol"] {
            let made = Command::new("chmod").arg("+x").arg(folder.path().join(name)).status().unwrap();
            assert!(made.success());
        }
        let mut cluster = Self { folder, digest: String::new() };
        let ended = cluster.scree(&["run", "job.toml", "--out", "reference", "--threads", "1"]);
        assert!(ended.status.success(), "{}", words(&ended));
        cluster.digest = cluster.digest_of("reference");
        cluster
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn scree(&self, arguments: &[&str]) -> Output {
        Command::new(SCREE).args(arguments).current_dir(self.folder.path()).output().unwrap()
    }

    fn digest_of(&self, run: &str) -> String {
        String::from_utf8(self.scree(&["digest", run]).stdout).unwrap()
    }

    /// The line that is typed first and again.
    fn line(&self, script: &str, run: &str) -> Child {
        let path = format!("{}:{}", self.path("bin").display(), std::env::var("PATH").unwrap());
        Command::new("bash")
            .arg(Path::new(ROOT).join("jobs/cluster").join(script))
            .args(["job.toml", run])
            .current_dir(self.folder.path())
            .env("PATH", path)
            .env("SCREE", SCREE)
            .env("SLURM_JOB_ID", "77")
            .env("SLURM_NTASKS", "2")
            .env("SLURM_CPUS_PER_TASK", "1")
            .env("MPIRUN_OPTIONS", "--oversubscribe --bind-to none")
            .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
            .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
            .env("OMPI_MCA_btl", "self,vader")
            .env("OMPI_MCA_btl_vader_single_copy_mechanism", "none")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    }

    /// Starts, stops by a signal to whom `whom` makes of the script's process, and types the line again.
    fn starts_and_goes_on(&self, script: &str, name: &str, whom: impl Fn(&Self, u32) -> u32) {
        let run = format!("run_of_{script}");
        let child = self.line(script, &run);
        let started = Instant::now();
        while !std::fs::read_to_string(self.path(&run).join("series.csv")).is_ok_and(|text| text.lines().count() > 3) {
            assert!(started.elapsed() < PATIENCE, "{script}: no rows");
            std::thread::sleep(Duration::from_millis(5));
        }
        signal(whom(self, child.id()), name);
        let ended = child.wait_with_output().unwrap();
        assert!(ended.status.success(), "{script}: {}", words(&ended));
        let asked = || std::fs::read_to_string(self.path("scontrol.log")).unwrap_or_default();
        assert_eq!(asked(), "requeue 77\n", "{script}: {}", words(&ended));
        assert!(words(&ended).contains("back into the queue"), "{}", words(&ended));
        assert_ne!(self.digest_of(&run), self.digest);

        let ended = self.line(script, &run).wait_with_output().unwrap();
        assert!(ended.status.success(), "{script}: {}", words(&ended));
        assert_eq!(asked(), "requeue 77\n", "{script} asked again although it was done");
        assert_eq!(self.digest_of(&run), self.digest, "{script}: another state");
        std::fs::remove_file(self.path("scontrol.log")).unwrap();

        // Once more: it is done, and nothing happens to it.
        let ended = self.line(script, &run).wait_with_output().unwrap();
        assert!(ended.status.success() && words(&ended).contains("done already"), "{}", words(&ended));
    }
}

#[test]
fn scripts_are_good_shell() {
    let mut found = 0;
    for entry in std::fs::read_dir(Path::new(ROOT).join("jobs/cluster")).unwrap() {
        let path = entry.unwrap().path();
        // Recipes of containers lie beside.
        if path.extension().is_none_or(|extension| extension != "sbatch") {
            continue;
        }
        let ended = Command::new("bash").arg("-n").arg(&path).output().unwrap();
        assert!(ended.status.success(), "{}", words(&ended));
        found += 1;
    }
    assert_eq!(found, 3);
}

#[test]
fn the_same_line_starts_and_goes_on() {
    let _turn = turn();
    let cluster = Cluster::new();
    // Slurm signals the ranks of a step; one that hears it is enough.
    cluster.starts_and_goes_on("many_nodes.sbatch", "TERM", |cluster, _| {
        let mpirun = std::fs::read_to_string(cluster.path("mpirun.pid")).unwrap();
        a_rank_of(mpirun.trim().parse().unwrap())
    });
    // Slurm signals the script, which tells mpirun.
    cluster.starts_and_goes_on("one_node.sbatch", "USR2", |_, script| script);
}

/// What `--continue` finds, it goes on with, clears away or leaves alone.
#[test]
fn a_run_goes_on_where_there_is_one_of_this_job() {
    let cluster = Cluster::new();
    let run = |more: &[&str]| {
        let line = [&["run", "job.toml", "--out", "again", "--continue", "--threads", "1"], more].concat();
        cluster.scree(&line)
    };
    let ended = run(&[]);
    assert!(ended.status.success() && cluster.digest_of("again") == cluster.digest, "{}", words(&ended));

    let ended = run(&["--set", "contact.friction=0.4"]);
    assert_eq!(ended.status.code(), Some(2));
    let told = words(&ended);
    assert!(
        told.contains("again holds a run of another job: it has `friction = 0.5` where this one has `friction = 0.4`"),
        "{told}"
    );

    // A job with a byte that is no text is another one.
    let scenario = cluster.path("again/scenario.toml");
    let whole = std::fs::read(&scenario).unwrap();
    std::fs::write(&scenario, [&whole[..], &[0xff]].concat()).unwrap();
    let ended = run(&[]);
    assert_eq!(ended.status.code(), Some(2));
    assert!(words(&ended).contains("again holds a run of another job"), "{}", words(&ended));
    std::fs::write(&scenario, &whole).unwrap();

    // Its first checkpoint was never written: there is nothing to lose.
    std::fs::remove_dir_all(cluster.path("again/checkpoints")).unwrap();
    for name in ["series.csv", "summary.json"] {
        std::fs::remove_file(cluster.path("again").join(name)).unwrap();
    }
    let ended = run(&[]);
    let told = words(&ended);
    assert!(told.contains("again: no checkpoint yet; the run begins"), "{told}");
    assert!(ended.status.success() && cluster.digest_of("again") == cluster.digest, "{told}");

    std::fs::create_dir(cluster.path("other")).unwrap();
    std::fs::write(cluster.path("other/letter.txt"), "mine").unwrap();
    let ended = cluster.scree(&["run", "job.toml", "--out", "other", "--continue"]);
    assert_eq!(ended.status.code(), Some(2));
    assert!(words(&ended).contains("is no run of scree"), "{}", words(&ended));
}
