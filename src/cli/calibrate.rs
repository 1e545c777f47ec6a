//! `scree calibrate`: the material parameters of a job's continuum from simulated element tests of its own grains.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use scree_partition::Transport;

use super::cores::Placement;
use super::start_threads_of;
use crate::analysis::calibrate::element::Element;
use crate::analysis::calibrate::fragment::in_unit;
use crate::analysis::calibrate::mobilised::{self, DATA, Tests};
use crate::analysis::calibrate::{self, Calibration, KEYS, Subject, Wanted, elements};
use crate::base::error::Error;
use crate::job::Job;
use crate::law::material::CriticalDruckerPrager;
use crate::plot::report;
use crate::run::results::{Results, refuse_other, unwritable};

#[derive(Args)]
pub(super) struct Calibrate {
    /// A job of planar shear, or one with [grid] and [grains]; with --law mobilised_friction any that makes its
    /// grains. A TOML file.
    job: PathBuf,
    /// The material law: critical_drucker_prager or mobilised_friction.
    #[arg(long, value_name = "LAW", default_value = "critical_drucker_prager")]
    law: Fitted,
    /// Folder for the fragment, the page and the data. Default: runs/calibrate_<job name>.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Grains of each packing. Default: 2000, of mobilised_friction 400.
    #[arg(long, value_parser = clap::value_parser!(u32).range(50..=1_000_000))]
    grains: Option<u32>,
    /// Random packings, with the job's seed and those after it. Default: 3, of mobilised_friction 12.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1000))]
    packings: Option<u16>,
    /// Packings after those that are tested and not fitted, so that the law is shown on them; of mobilised_friction alone.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1000))]
    held_back: u16,
    /// The folder of an earlier calibration of this job, whose tests are fitted again instead of being done anew; of
    /// mobilised_friction alone. Default of --out: this folder.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["grains", "packings", "held_back", "strain"])]
    tests: Option<PathBuf>,
    /// Shear strain at the end of the shear tests. Default: 0.6, of mobilised_friction 0.4.
    #[arg(long)]
    strain: Option<f64>,
    /// Override one key of the job, for example --set contact.friction=0.3. May be repeated.
    #[arg(long, value_name = "KEY.PATH=VALUE")]
    set: Vec<String>,
    /// Threads, of which each takes a packing. Default: the cores of this machine.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) threads: Option<u16>,
}

/// Files of a calibration.
const FRAGMENT: &str = "calibrated.toml";
const STRING: &str = "a string takes every line";

pub(super) fn command(typed: &Calibrate, placement: &Placement, transport: &dyn Transport) -> Result<String, Error> {
    if transport.size() > 1 {
        return Err(Error::User(
            "scree calibrate is done by one process: its worlds are small, and packings share the threads. Start it without mpirun, and use --threads."
                .to_string(),
        ));
    }
    let strain = typed.strain();
    if !(0.1..=10.0).contains(&strain) {
        return Err(Error::User(format!(
            "--strain {strain} is refused: the shear tests must pass their peak, and end. Write 0.1 to 10, for example --strain 0.6."
        )));
    }
    let is_mobilised = typed.law == Fitted::MobilisedFriction;
    if typed.held_back > 0 && !is_mobilised {
        return Err(Error::User(
            "--held-back is of --law mobilised_friction, whose law is shown on packings that it is not fitted to. Add that law, or remove --held-back."
                .to_string(),
        ));
    }
    if typed.tests.is_some() && !is_mobilised {
        return Err(Error::User(
            "--tests is of --law mobilised_friction, whose calibration keeps its tests. Add that law, or remove --tests."
                .to_string(),
        ));
    }
    let subject = Subject::of(&Job::load(&typed.job, &typed.set)?, &typed.job.display().to_string(), is_mobilised)?;
    let own = || Path::new("runs").join(format!("calibrate_{}", subject.name));
    let out = typed.out.clone().or_else(|| typed.tests.clone()).unwrap_or_else(own);
    if is_mobilised { mobilised(typed, &subject, &out, placement) } else { critical(typed, &subject, &out, placement) }
}

fn critical(typed: &Calibrate, subject: &Subject, out: &Path, placement: &Placement) -> Result<String, Error> {
    let wanted = Wanted { grains: typed.grains(), packings: typed.packings(), strain: typed.strain() };
    begin(&elements(subject, wanted, subject.piece.seed), out, placement)?;
    let calibration = calibrate::calibrate(subject, wanted)?;
    let command = typed.words([wanted.grains, wanted.packings, 0], wanted.strain);
    let mut results = Results::default();
    results.add(out.join(FRAGMENT), &calibration.fragment(&subject.name, &command));
    results.add(out.join(DATA), &written(calibration.to_json(&subject.name, &command)));
    let page = report::write_calibration(&calibration, (subject, &command), out, results)?;
    Ok(told(&calibration, subject, out, &page))
}

fn mobilised(typed: &Calibrate, subject: &Subject, out: &Path, placement: &Placement) -> Result<String, Error> {
    let earlier = typed.tests.as_ref().map(|folder| Tests::of(folder, subject)).transpose()?;
    let held = u64::from(typed.held_back);
    let asked = mobilised::Wanted { grains: typed.grains(), packings: typed.packings(), held, strain: typed.strain() };
    let wanted = earlier.as_ref().map_or(asked, |earlier| earlier.wanted);
    begin(&mobilised::elements(subject, wanted, subject.piece.seed), out, placement)?;
    let command = typed.words([wanted.grains, wanted.packings, wanted.held], wanted.strain);
    let (tests, kept) = match earlier {
        Some(tests) => (tests, String::new()),
        None => {
            let tests = mobilised::test(subject, wanted)?;
            let kept = keep(&tests, (&subject.name, &command), out)?;
            (tests, kept)
        }
    };
    let calibration = mobilised::fit_all(tests, subject.stress).map_err(|error| match error {
        Error::Run(words) => Error::Run(words + &kept),
        other => other,
    })?;
    let mut results = Results::default();
    results.add(out.join(FRAGMENT), &calibration.fragment(&subject.name, &command));
    results.add(out.join(DATA), &written(calibration.to_json(&subject.name, &command)));
    let page = report::write_calibration_mobilised(&calibration, (subject, &command), out, results)?;
    let mut text = calibration.told();
    subject.other_stress.iter().for_each(|other| writeln!(text, "{other}").expect(STRING));
    let space = if subject.axes() == 3 { " in space" } else { "" };
    writeln!(
        text,
        "The page is {}. In the [material] of a job on a grid{space}, file = \"{}\" takes the place of law and these keys.",
        page.display(),
        out.join(FRAGMENT).display()
    )
    .expect(STRING);
    Ok(text)
}

/// Tests took hours, and perhaps no law follows them: they are written before one is fitted. What to say if none does.
fn keep(tests: &Tests, (job, command): (&str, &str), out: &Path) -> Result<String, Error> {
    let mut results = Results::default();
    results.add(out.join(DATA), &written(tests.to_json(job, command)));
    results.write(false)?;
    let (fitted, kept) =
        (out.join(FRAGMENT), format!(" The tests are kept: --tests {} fits them again.", out.display()));
    match fitted.is_file() {
        true => Ok(format!("{kept} {} is of an earlier calibration.", fitted.display())),
        false => Ok(kept),
    }
}

/// Makes the folder with the tests as jobs; a job that cannot be tested leaves none behind, and what may not be written over is told
/// before anything is tested.
fn begin(elements: &[Element], out: &Path, placement: &Placement) -> Result<(), Error> {
    let job = |element: &Element| Ok((format!("{}.toml", element.name()), element.job()?.to_toml()));
    let jobs = elements.iter().map(job).collect::<Result<Vec<_>, Error>>()?;
    fs::create_dir_all(out).map_err(|error| unwritable(out, &error))?;
    start_threads_of(placement)?;
    [FRAGMENT, DATA, report::CALIBRATION].iter().try_for_each(|file| refuse_other(&out.join(file)))?;
    let mut results = Results::default();
    for (file, job) in &jobs {
        results.add(out.join(file), job);
    }
    results.write(false)
}

/// As text, the program first: a file is known by its beginning as one that may be written again.
fn written(mut value: serde_json::Value) -> String {
    let program = value.as_object_mut().and_then(|map| map.remove("program")).expect("data name the program");
    let rest = serde_json::to_string(&value).expect("numbers are written");
    format!("{{\"program\":{program},{}\n", &rest[1..])
}

/// Laws that are fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
#[value(rename_all = "snake_case")]
enum Fitted {
    CriticalDruckerPrager,
    MobilisedFriction,
}

impl Calibrate {
    /// What suits the law: few large packings, or many small ones that tell the start as well for half of the work.
    fn of_law<T>(&self, critical: T, mobilised: T) -> T {
        if self.law == Fitted::MobilisedFriction { mobilised } else { critical }
    }

    fn grains(&self) -> u64 {
        self.grains.map_or(self.of_law(2000, 400), u64::from)
    }

    fn packings(&self) -> u64 {
        self.packings.map_or(self.of_law(3, 12), u64::from)
    }

    fn strain(&self) -> f64 {
        self.strain.unwrap_or(self.of_law(0.6, 0.4))
    }

    /// The line that does the same again, tests as well, of so many grains, packings and packings held back to that strain; folders
    /// and threads change nothing.
    fn words(&self, [grains, packings, held]: [u64; 3], strain: f64) -> String {
        let law = match self.law {
            Fitted::CriticalDruckerPrager => "",
            Fitted::MobilisedFriction => " --law mobilised_friction",
        };
        let mut words = format!(
            "scree calibrate {}{law} --grains {grains} --packings {packings} --strain {strain}",
            self.job.display()
        );
        if held > 0 {
            write!(words, " --held-back {held}").expect(STRING);
        }
        for set in &self.set {
            write!(words, " --set '{set}'").expect(STRING);
        }
        words
    }
}

fn told(calibration: &Calibration, subject: &Subject, out: &Path, page: &Path) -> String {
    let mut text = String::new();
    let mut line = |words: String| writeln!(text, "{words}").expect(STRING);
    line(format!("{:<26}{:>28}{:>14}{:>14}{:>14}", "", "calibrated", "deviation", "Table 2", "the job now"));
    let now = subject.now.as_ref().map(CriticalDruckerPrager::of);
    let or_none = |told: Option<String>| told.unwrap_or_else(|| "-".to_string());
    for key in &KEYS {
        let (_, spread) = calibration.figure(key);
        line(format!(
            "{:<26}{:>28}{:>14}{:>14}{:>14}",
            key.name,
            calibration.fit.told(key),
            or_none(spread.map(|spread| in_unit(key, spread, 2))),
            in_unit(key, key.table_2, 3),
            or_none(now.as_ref().map(|law| in_unit(key, (key.of)(law), 4)))
        ));
    }
    subject.other_stress.iter().cloned().for_each(&mut line);
    let quality = &calibration.quality;
    let [grains, law] = quality.peak;
    line(format!(
        "tau/sigma_n: the law is off by {:.3} (root mean square); peak of the grains {:.3} at {:.1} % of strain, of the law {:.3} at {:.1} %",
        quality.friction_off,
        grains[0],
        100.0 * grains[1],
        law[0],
        100.0 * law[1]
    ));
    line(format!(
        "fraction: off by {:.4}; volume strain at the end {:.2} % (grains), {:.2} % (flow of the law); secant G at half the peak {:.1} MPa (grains), {:.1} MPa (law)",
        quality.fraction_off,
        100.0 * quality.volume_end[0],
        100.0 * quality.volume_end[1],
        1e-6 * quality.secant[0],
        1e-6 * quality.secant[1]
    ));
    line(format!(
        "The page is {}. In the job's [material], file = \"{}\" takes the place of these keys.",
        page.display(),
        out.join(FRAGMENT).display()
    ));
    text
}
