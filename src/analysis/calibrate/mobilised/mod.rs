//! Calibration of the law with mobilised friction.
//!
//! Packings of the job's grains, under its packing stress and under half of it, dense as the job makes them and loose (made with
//! the friction of their contacts), are sheared at a constant normal stress; dense ones also to the peak and back, and in
//! small cycles. K and G_0 are slopes of compressions. The law follows the means over the packings, each third of a test by
//! the scatter of the packings there, and unloading from each turn on. Shear at constant volume and under a quarter of the
//! stress and biaxial compression are not fitted: they show the law, as do packings that are held back.

use rayon::prelude::*;

use super::Subject;
use super::element::{Course, ENERGY_RATIO_MOST, Element, Packing, Row, Test};
use super::fit::{moduli, sine};
use super::layers::Profile;
use super::model::Curve;
use super::path::{Drive, Kept};
use crate::analysis::interval::student;
use crate::base::error::Error;
use crate::base::math;
use crate::law::contact::Contact;

mod collapse;
pub mod fit;
pub mod kinds;
pub mod musts;
mod quality;
mod read;
#[cfg(test)]
mod tests;
mod written;

use fit::{COUNT, Fit, Given, fit};
pub use kinds::{KINDS, Kind, LOOSE};
pub use quality::{Quality, STRAIN_SMOOTH, averaged, quality};
pub use read::DATA;

/// Ends of the thirds of a test; the last has no other end than the test's.
pub const THIRDS: [f64; 2] = [0.05, 0.2];
/// Largest increment of shear strain that the law is driven by.
const INCREMENT: f64 = 2.5e-4;
/// Scatter of shear stress over normal stress and of the solid volume fraction is not thought smaller.
const SCATTER_LEAST: [f64; 2] = [0.005, 5e-4];
/// What stands for the scatter of a single packing.
const SCATTER_SINGLE: [f64; 2] = [0.02, 2e-3];
/// A layer that takes so many times the mean shear is a band.
pub const BAND: f64 = 2.0;
/// After a reversal the law is compared until the stress has fallen to this share.
const SHARE_UNLOADED: f64 = 0.5;
/// Share of a test, its end, that is taken for the critical state where the fit starts.
pub const SHARE_CRITICAL: f64 = 0.3;

/// What is wanted beside the job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Of each packing.
    pub grains: u64,
    /// Packings that are fitted, with the job's seed and those after it.
    pub packings: u64,
    /// Packings after those, which the law is shown on.
    pub held: u64,
    /// Shear strain at the end of the shear tests.
    pub strain: f64,
}

/// What one test gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Tested {
    /// From the packing at rest on.
    pub rows: Vec<Row>,
    /// One for every stretch of strain; empty of biaxial compression, of small cycles and of cells too low for layers.
    pub profiles: Vec<Profile>,
}

/// The tests of the packings of one seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Specimen {
    /// 2 of discs, 3 of spheres.
    pub axes: usize,
    /// Of its packings.
    pub seed: u64,
    /// Compression of all edges alike, of the dense packing under the packing stress.
    pub isotropic: Vec<Row>,
    /// The same packing compressed along y alone.
    pub uniaxial: Vec<Row>,
    /// Of each of [`KINDS`].
    pub tests: Vec<Tested>,
    /// Where grains cohere, those that are fitted, without cohesion; else none.
    pub dry: Vec<Tested>,
}

impl Specimen {
    /// K and G, Pa, by the first small part of the compressions.
    pub fn moduli(&self) -> [f64; 2] {
        moduli(self.axes, &self.isotropic, &self.uniaxial)
    }
}

/// A parameter and the half-width of its 95 % confidence interval, if there are several packings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// As `[material]` of a job calls it.
    pub key: &'static str,
    /// As files and reports print it.
    pub symbol: &'static str,
    /// "Pa", "rad", or nothing.
    pub unit: &'static str,
    /// In `unit`, of the fit to all packings that are not held back.
    pub value: f64,
    /// In `unit`, by the jackknife; none of a single packing, or where a fit without one packing fails.
    pub half_width: Option<f64>,
}

/// All tests, and the law that follows them.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// What was asked for.
    pub wanted: Wanted,
    /// Stress of the packings, Pa.
    pub stress: f64,
    /// Packings that the law is fitted to.
    pub fitted: Vec<Specimen>,
    /// Packings that are held back; empty where none were asked for.
    pub held: Vec<Specimen>,
    /// To the means over the packings that are fitted.
    pub fit: Fit,
    /// Of that fit, moduli first.
    pub figures: Vec<Figure>,
    /// Strain of each kind beyond which most packings shear in a band, and nothing is fitted; none where they do not.
    pub bands: Vec<Option<f64>>,
    /// Of each kind: mean curves of the packings that are fitted, and how the law follows them.
    pub shown: Vec<Shown>,
    /// The same of the packings that are held back.
    pub shown_held: Vec<Shown>,
    /// How a law fitted to the packing stress alone follows the tests under half of it.
    pub half_left_out: Option<Vec<Shown>>,
}

/// A mean curve, the law on its path, and how far they are apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// Which test.
    pub kind: Kind,
    /// Mean over the packings.
    pub curve: Curve,
    /// Standard deviation of the packings in each third, of the shear stress over the normal one; none of a single packing.
    pub scatter: Option<[f64; 3]>,
    /// The law's rows at the strains of the curve, with its volumes over that of the start.
    pub law: Vec<(Row, f64)>,
    /// How far the law is from the curve.
    pub quality: Quality,
    /// One for each turn of a test that unloads; else empty.
    pub unloadings: Vec<Unloading>,
}

/// A turn and the way back from it, while half of the stress is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unloading {
    /// Of the turn.
    pub strain: f64,
    /// Shear stress over shear strain of the way back, of grains and law, Pa.
    pub modulus: [f64; 2],
}

/// Packings that are fitted, and those that are held back.
#[derive(Clone, Debug, PartialEq)]
pub struct Tests {
    /// What was asked for when they were made.
    pub wanted: Wanted,
    /// Those of the first seeds.
    pub fitted: Vec<Specimen>,
    /// Those of the seeds after them; may be empty.
    pub held: Vec<Specimen>,
}

/// Makes the packings and tests them. Nothing depends on how many threads do it.
pub fn test(subject: &Subject, wanted: Wanted) -> Result<Tests, Error> {
    let seeds: Vec<u64> = (0..wanted.packings + wanted.held).map(|number| subject.piece.seed + number).collect();
    let mut fitted =
        seeds.into_par_iter().map(|seed| specimen(subject, wanted, seed)).collect::<Result<Vec<_>, _>>()?;
    let held = fitted.split_off(wanted.packings as usize);
    Ok(Tests { wanted, fitted, held })
}

/// The jobs of one seed that a person may run again, each a file.
pub fn elements(subject: &Subject, wanted: Wanted, seed: u64) -> Vec<Element<'_>> {
    let contact = subject.piece.contact;
    let mut elements = compressions(subject, wanted, seed).to_vec();
    elements.extend(sheared(subject, wanted, seed, contact));
    let dry = contact.without_cohesion();
    if dry != contact {
        let fitted = sheared(subject, wanted, seed, dry).into_iter().zip(&KINDS).filter(|(_, kind)| kind.fitted);
        elements.extend(fitted.map(|(element, _)| element));
    }
    elements
}

fn compressions(subject: &Subject, wanted: Wanted, seed: u64) -> [Element<'_>; 2] {
    let packing = Packing { stress: subject.stress, friction: None, energy_ratio_most: ENERGY_RATIO_MOST };
    let of = |test| Element { subject, contact: subject.piece.contact, test, grains: wanted.grains, seed, packing };
    [of(Test::Isotropic), of(Test::Uniaxial)]
}

fn sheared(subject: &Subject, wanted: Wanted, seed: u64, contact: Contact) -> Vec<Element<'_>> {
    let of = |kind: &Kind| {
        let stress = kind.share * subject.stress;
        let friction = kind.loose.then(|| subject.piece.contact.friction());
        let packing = Packing { stress, friction, energy_ratio_most: ENERGY_RATIO_MOST };
        let test = Test::Sheared { course: kind.course, strain: kind.strain(wanted.strain) };
        Element { subject, contact, test, grains: wanted.grains, seed, packing }
    };
    KINDS.iter().map(of).collect()
}

fn specimen(subject: &Subject, wanted: Wanted, seed: u64) -> Result<Specimen, Error> {
    let [isotropic, uniaxial] = compressions(subject, wanted, seed);
    let (isotropic, uniaxial) = (isotropic.measure()?, uniaxial.measure()?);
    let all = |contact, wants: fn(&Kind) -> bool| -> Result<Vec<Tested>, Error> {
        let measure = |(element, _): (&Element, _)| {
            let (rows, profiles) = element.measure_layers()?;
            Ok(Tested { rows, profiles })
        };
        let elements = sheared(subject, wanted, seed, contact);
        elements.iter().zip(&KINDS).filter(|(_, kind)| wants(kind)).map(measure).collect()
    };
    let contact = subject.piece.contact;
    let tests = all(contact, |_| true)?;
    let without = contact.without_cohesion();
    let dry = if without == contact { Vec::new() } else { all(without, |kind| kind.fitted)? };
    let specimen = Specimen { axes: subject.axes(), seed, isotropic, uniaxial, tests, dry };
    let [bulk, shear] = specimen.moduli();
    tracing::info!(
        "packings of seed {seed} are sheared: fractions {:.4} and {:.4}, K {:.1} MPa, G {:.1} MPa",
        specimen.tests[0].rows[0].fraction,
        specimen.tests[LOOSE].rows[0].fraction,
        1e-6 * bulk,
        1e-6 * shear
    );
    Ok(specimen)
}

/// What is fitted to tests that are there, and shown on those held back; `stress` is that of the packings, Pa.
pub fn fit_all(tests: Tests, stress: f64) -> Result<Calibration, Error> {
    let Tests { wanted, fitted, held } = tests;
    let all: Vec<&Specimen> = fitted.iter().collect();
    let refused = || {
        Error::Run(
            "the law with mobilised friction cannot follow the shear tests: from where the fit starts it does not bear them. Look at shear.toml and shear_loose.toml by `scree run`; more grains, more packings or more strain may help."
                .to_string(),
        )
    };
    let weighed = Weighed { stress, all: &all, use_half: true };
    let found = weighed.fit(&all, None).ok_or_else(refused)?;
    let figures = figures(&weighed, &found);
    let alone = Weighed { use_half: false, ..weighed };
    let half_left_out = alone.fit(&all, Some(&found)).map(|fit| {
        let kinds = KINDS.iter().enumerate().filter(|(_, kind)| kind.fitted && kind.share < 1.0);
        kinds.filter_map(|(index, _)| shown(&fit, stress, &all, index)).collect()
    });
    let bands = (0..KINDS.len()).map(|kind| band(&all, kind, false)).collect();
    let show = |specimens: &[&Specimen]| -> Vec<Shown> {
        (0..KINDS.len()).filter_map(|kind| shown(&found, stress, specimens, kind)).collect()
    };
    let shown_held = if held.is_empty() { Vec::new() } else { show(&held.iter().collect::<Vec<_>>()) };
    let shown = show(&all);
    Ok(Calibration { wanted, stress, fit: found, figures, bands, shown, shown_held, half_left_out, held, fitted })
}

/// Tests as they are fitted: weights are those of all packings, whichever are left out.
#[derive(Clone, Copy)]
struct Weighed<'a> {
    stress: f64,
    all: &'a [&'a Specimen],
    use_half: bool,
}

impl Weighed<'_> {
    /// The law that follows the means over some of the packings.
    fn fit(&self, some: &[&Specimen], start: Option<&Fit>) -> Option<Fit> {
        let is_dry = some.first()?.dry.is_empty();
        let mean = |of: &dyn Fn(&Specimen) -> f64| some.iter().map(|one| of(one)).sum::<f64>() / some.len() as f64;
        let moduli = [mean(&|one| one.moduli()[0]), mean(&|one| one.moduli()[1])];
        let from = start.map(|fit| &fit.at);
        let dry = self.curves(some, !is_dry);
        let given = Given { friction_critical: None, ..self.given(moduli, &dry) };
        if is_dry {
            return fit(&given, &dry, from);
        }
        let without = fit(&given, &dry, None)?;
        let curves = self.curves(some, false);
        let friction_critical = Some(math::tan(without.constants.friction_angle_critical));
        let mut fit = fit(&Given { friction_critical, ..self.given(moduli, &curves) }, &curves, from)?;
        let friction = "friction_angle_critical";
        fit.at_bound.extend(without.at_bound.contains(&friction).then_some(friction));
        Some(fit)
    }

    /// Critical friction and fraction as the ends of the tests have them: half way from loose ones to dense ones.
    fn given(&self, moduli: [f64; 2], curves: &[Curve]) -> Given {
        let end = |of: &dyn Fn(&Curve, &Row) -> f64| {
            let of_curve = |curve: &Curve| {
                let last = &curve.rows[((1.0 - SHARE_CRITICAL) * curve.rows.len() as f64) as usize..];
                last.iter().map(|row| of(curve, row)).sum::<f64>() / last.len() as f64
            };
            // Of those that go to the end; a reversal does not.
            let once: Vec<f64> = curves.iter().filter(|curve| goes_once(curve)).map(of_curve).collect();
            once.iter().sum::<f64>() / once.len() as f64
        };
        let sine = end(&|curve, row| curve.ratio(row)).clamp(0.05, 0.9);
        let critical = [sine / (1.0 - sine * sine).sqrt(), end(&|_, row| row.fraction)];
        let fraction_loosest = curves.iter().map(|curve| curve.drive.fraction).fold(1.0, f64::min);
        Given {
            axes: self.all[0].axes,
            moduli,
            friction_critical: None,
            critical,
            stress: self.stress,
            fraction_loosest,
        }
    }

    /// Of every kind that is fitted.
    fn curves(&self, some: &[&Specimen], dry: bool) -> Vec<Curve> {
        let kinds = KINDS.iter().enumerate().filter(|(_, kind)| kind.fitted && (self.use_half || kind.share == 1.0));
        kinds.map(|(index, _)| self.curve(some, index, dry)).collect()
    }

    fn curve(&self, some: &[&Specimen], kind: usize, dry: bool) -> Curve {
        let mut curve = mean_curve(self.stress, some, kind, dry);
        let scatter = scatter(self.all, kind, dry);
        let end = band(self.all, kind, dry).unwrap_or(f64::INFINITY);
        let parts = parts(&curve, KINDS[kind].course);
        // Of a test that turns the way up is one of the tests that do not, and volume on the way back is not the law's.
        let mut counts = [0.0; 3];
        let used = |part: Option<usize>, row: &Row| part.filter(|_| row.strain <= end);
        for (part, row) in parts.iter().zip(&curve.rows) {
            used(*part, row).into_iter().for_each(|part| counts[part] += 1.0);
        }
        let with_volume = f64::from(!KINDS[kind].unloads());
        for ((part, row), weights) in parts.iter().zip(&curve.rows).zip(&mut curve.weights) {
            if let Some(part) = used(*part, row) {
                let root = f64::sqrt(counts[part]);
                *weights = [1.0 / (scatter[part][0] * root), with_volume / (scatter[part][1] * root)];
            }
        }
        curve
    }
}

fn goes_once(curve: &Curve) -> bool {
    curve.drive.kept == Kept::NormalStress && curve.rows.windows(2).all(|pair| pair[1].strain > pair[0].strain)
}

/// Which third each row is of. Of tests that turn: which unloading, as long as it is one; the rest is none.
fn parts(curve: &Curve, course: Course) -> Vec<Option<usize>> {
    let rows = &curve.rows;
    if !matches!(course, Course::Reversal | Course::Cycles) {
        let third = |row: &Row| Some(THIRDS.iter().filter(|end| row.strain > **end).count());
        return rows.iter().map(third).collect();
    }
    let mut parts = vec![None; rows.len()];
    let turns = turns(rows);
    let mut part: Option<usize> = None;
    for (index, turn) in turns.iter().enumerate() {
        let Some(turn) = *turn else { continue };
        if turn + 1 == index {
            part = Some(part.map_or(0, |part| part + 1));
        }
        let is_unloading = curve.ratio(&rows[index]) >= SHARE_UNLOADED * curve.ratio(&rows[turn]);
        // Once it has ended it does not begin again.
        let goes_on = turn + 1 == index || parts[index - 1].is_some();
        parts[index] = part.filter(|_| is_unloading && goes_on);
    }
    parts
}

/// Of each row on a way back the row that it turned at.
fn turns(rows: &[Row]) -> Vec<Option<usize>> {
    let mut turns: Vec<Option<usize>> = vec![None; rows.len()];
    for index in 1..rows.len() {
        if rows[index].strain < rows[index - 1].strain {
            turns[index] = Some(turns[index - 1].unwrap_or(index - 1));
        }
    }
    turns
}

/// Of each unloading the secant modulus to its last row, of grains and law.
fn unloadings(curve: &Curve, law: &[(Row, f64)], kind: &Kind) -> Vec<Unloading> {
    if !kind.unloads() {
        return Vec::new();
    }
    let (parts, turns) = (parts(curve, kind.course), turns(&curve.rows));
    let is_last =
        |index: &usize| parts[*index].is_some() && parts.get(index + 1).is_none_or(|next| *next != parts[*index]);
    let of = |index: usize| {
        let turn = turns[index].expect("a part of an unloading has turned");
        let way = curve.rows[turn].strain - curve.rows[index].strain;
        let modulus = |turned: &Row, now: &Row| (curve.ratio(turned) - curve.ratio(now)) * curve.drive.stress / way;
        let of_law = modulus(&law[turn].0, &law[index].0);
        Unloading { strain: curve.rows[turn].strain, modulus: [modulus(&curve.rows[turn], &curve.rows[index]), of_law] }
    };
    (0..parts.len()).filter(is_last).map(of).collect()
}

fn of_kind(specimen: &Specimen, kind: usize, dry: bool) -> &Tested {
    if dry { &specimen.dry[kind] } else { &specimen.tests[kind] }
}

/// The mean over packings, without weights.
fn mean_curve(stress: f64, specimens: &[&Specimen], kind: usize, dry: bool) -> Curve {
    let count = specimens.len() as f64;
    let rows = (0..of_kind(specimens[0], kind, dry).rows.len()).map(|index| {
        let mean = |of: &dyn Fn(&Row) -> f64| {
            specimens.iter().map(|specimen| of(&of_kind(specimen, kind, dry).rows[index])).sum::<f64>() / count
        };
        Row {
            strain: mean(&|row| row.strain),
            stress: std::array::from_fn(|component| mean(&|row| row.stress[component])),
            pressure: mean(&|row| row.pressure),
            fraction: mean(&|row| row.fraction),
        }
    });
    let rows: Vec<Row> = rows.collect();
    let (stress, kept) = (KINDS[kind].share * stress, KINDS[kind].kept());
    let drive = Drive { axes: specimens[0].axes, stress, fraction: rows[0].fraction, kept, increment: INCREMENT };
    let since = if KINDS[kind].unloads() { turns(&rows) } else { vec![None; rows.len()] };
    Curve { drive, weights: vec![[0.0; 2]; rows.len()], rows, since }
}

/// Standard deviation over the packings of the shear stress over the normal one, of unloading of its change since the turn, and of
/// the change of the solid volume fraction, in each part of a test, at least [`SCATTER_LEAST`].
fn scatter(specimens: &[&Specimen], kind: usize, dry: bool) -> [[f64; 2]; 3] {
    if specimens.len() < 2 {
        return [SCATTER_SINGLE; 3];
    }
    let curve = mean_curve(1.0, specimens, kind, dry);
    let parts = parts(&curve, KINDS[kind].course);
    let (mut sums, mut counts) = ([[0.0; 2]; 3], [0.0_f64; 3]);
    for (index, part) in parts.iter().enumerate() {
        let Some(part) = *part else { continue };
        let of = |row: &Row, first: &Row| {
            let stress = match curve.drive.kept {
                Kept::NormalStress => row.stress[2],
                Kept::Volume => first.stress[2],
                Kept::LateralStress => return [sine(row), row.fraction - first.fraction],
            };
            [-row.stress[1] / stress, row.fraction - first.fraction]
        };
        let rows = |specimen: &&Specimen| {
            let rows = &of_kind(specimen, kind, dry).rows;
            let [ratio, fraction] = of(&rows[index], &rows[0]);
            [ratio - curve.since[index].map_or(0.0, |turn| of(&rows[turn], &rows[0])[0]), fraction]
        };
        for (column, sum) in sums[part].iter_mut().enumerate() {
            let mean = specimens.iter().map(|one| rows(one)[column]).sum::<f64>() / specimens.len() as f64;
            let square = specimens.iter().map(|one| (rows(one)[column] - mean) * (rows(one)[column] - mean));
            *sum += square.sum::<f64>() / (specimens.len() - 1) as f64;
        }
        counts[part] += 1.0;
    }
    std::array::from_fn(|part| {
        std::array::from_fn(|column| (sums[part][column] / counts[part].max(1.0)).sqrt().max(SCATTER_LEAST[column]))
    })
}

/// Where the softening of dense packings is a band's: the strain from which on the largest layer shear of half of the packings
/// exceeds [`BAND`] times the mean; not before the first third ends. Loose packings do not soften.
fn band(specimens: &[&Specimen], kind: usize, dry: bool) -> Option<f64> {
    if KINDS[kind].loose || !KINDS[kind].fitted || KINDS[kind].course != Course::Once {
        return None;
    }
    let mut before = 0.0;
    // A cell that is too low for layers has none.
    let profiles = specimens.iter().map(|specimen| of_kind(specimen, kind, dry).profiles.len()).min().unwrap_or(0);
    for index in 0..profiles {
        let profile = |specimen: &&Specimen| of_kind(specimen, kind, dry).profiles[index].clone();
        let banded = specimens.iter().filter(|specimen| profile(specimen).largest() > BAND).count();
        if 2 * banded >= specimens.len() {
            return Some(f64::max(before, THIRDS[0]));
        }
        before = profile(&specimens[0]).strain;
    }
    None
}

/// The parameters, with intervals by fits that leave out one packing each (the jackknife, Efron 1982).
fn figures(tests: &Weighed<'_>, found: &Fit) -> Vec<Figure> {
    let count = tests.all.len();
    let without = |left: usize| {
        let others: Vec<&Specimen> =
            tests.all.iter().enumerate().filter(|(index, _)| *index != left).map(|(_, one)| *one).collect();
        tests.fit(&others, Some(found))
    };
    let fits: Vec<Option<Fit>> = if count > 1 { (0..count).into_par_iter().map(without).collect() } else { Vec::new() };
    let fits: Option<Vec<Fit>> = fits.into_iter().collect();
    let figure = |(key, symbol, unit, of): &Named| {
        let half_width = fits.as_ref().filter(|fits| fits.len() > 1).map(|fits| {
            let values: Vec<f64> = fits.iter().map(of).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let square: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
            student(count - 1) * (square * (count - 1) as f64 / count as f64).sqrt()
        });
        Figure { key, symbol, unit, value: of(found), half_width }
    };
    NAMED.iter().map(figure).collect()
}

/// Key, symbol, unit and value of a parameter.
type Named = (&'static str, &'static str, &'static str, fn(&Fit) -> f64);

const NAMED: [Named; COUNT + 3] = [
    ("bulk_modulus", "K", "Pa", |fit| fit.constants.bulk_modulus),
    ("shear_modulus", "G_0", "Pa", |fit| fit.constants.shear_modulus),
    ("shear_modulus_degradation", "r", "", |fit| fit.constants.shear_degradation),
    ("shear_degradation_strain", "a_G", "", |fit| fit.constants.shear_degradation_strain),
    ("friction_angle_critical", "phi_cs", "rad", |fit| fit.constants.friction_angle_critical),
    ("fraction_critical", "Phi_cs", "", |fit| fit.constants.fraction_critical),
    ("dilation_factor", "chi", "", |fit| fit.constants.dilation_factor),
    ("hardening_strain", "a_cs", "", |fit| fit.constants.hardening_strain),
    ("hardening_fraction_width", "w", "", |fit| fit.constants.hardening_fraction_width.unwrap_or(f64::INFINITY)),
    ("hardening_start", "kappa_0", "", |fit| fit.constants.hardening_start),
    ("phase_transformation_factor", "k_d", "", |fit| fit.constants.phase_transformation_factor),
    ("cohesion", "c", "Pa", |fit| fit.constants.cohesion),
];

fn shown(fit: &Fit, stress: f64, specimens: &[&Specimen], index: usize) -> Option<Shown> {
    let curve = mean_curve(stress, specimens, index, false);
    let law = curve.response(&crate::law::material::MobilisedFriction::of(&fit.constants))?;
    let quality = quality(&curve, &law);
    let scatter = (specimens.len() > 1).then(|| scatter(specimens, index, false).map(|part| part[0]));
    let unloadings = unloadings(&curve, &law, &KINDS[index]);
    Some(Shown { kind: KINDS[index], curve, scatter, law, quality, unloadings })
}
