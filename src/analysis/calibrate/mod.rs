//! `scree calibrate`: the material parameters of the continuum from simulated element tests of a job's own grains (Chen et al. 2021, 2.2).
//!
//! Packings of these grains in a periodic cell are compressed isotropically, which gives K, and uniaxially, which gives
//! M = K + G (of spheres K + 4 G/3), and sheared at a constant normal stress. The law that follows the shear tests with the least squares has the
//! other figures: it is the program's own law, driven along the same path ([`path`]). Where the grains cohere, the same
//! packings are sheared without cohesion as well: their phi_cs is kept, and c is what the others bear beyond it.

use rayon::prelude::*;

use crate::base::error::Error;
use crate::base::math;
use crate::law::material::CriticalDruckerPrager;

mod columns;
pub mod element;
pub mod fit;
pub mod fragment;
pub mod layers;
mod least_squares;
pub mod mobilised;
pub mod model;
pub mod path;
mod subject;

pub use subject::Subject;

use element::{ENERGY_RATIO_MOST, Element, Packing, Row, Test};
use fit::{Fit, Quality, Shear, fit, moduli};

/// What is wanted beside the job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Of each packing.
    pub grains: u64,
    /// Packings, with the job's seed and those after it.
    pub packings: u64,
    /// Shear strain at the end of the shear tests.
    pub strain: f64,
}

/// The tests of one packing and what they say by themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct Specimen {
    /// Of the packing.
    pub seed: u64,
    /// Compression of all edges alike: tells K.
    pub isotropic: Vec<Row>,
    /// Compression along y alone: tells G, with K.
    pub uniaxial: Vec<Row>,
    /// At a constant normal stress, with the contacts of the job.
    pub shear: Shear,
    /// Where grains cohere, that of the same packing without cohesion.
    pub dry: Option<Shear>,
    /// To the tests of this packing alone.
    pub fit: Fit,
}

/// All tests, and the law that follows them all.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// What was asked for.
    pub wanted: Wanted,
    /// Normal stress of the packings, Pa.
    pub stress: f64,
    /// One a packing, by rising seed.
    pub specimens: Vec<Specimen>,
    /// To the shear tests of all packings at once, with the means of their K and G.
    pub fit: Fit,
    /// How that law follows the shear tests of all packings.
    pub quality: Quality,
}

/// One figure of the law, as a job calls it.
pub struct Key {
    /// As `[material]` of a job calls it.
    pub name: &'static str,
    /// As files and reports print it.
    pub symbol: &'static str,
    /// "Pa", "rad", or nothing.
    pub unit: &'static str,
    /// Its value in a law, in `unit`: of friction the angle and not the tangent.
    pub of: fn(&CriticalDruckerPrager) -> f64,
    /// Table 2 of Chen et al. (2021).
    pub table_2: f64,
}

/// As `[material]` of a job calls them.
const NAMES: [&str; 7] = [
    "bulk_modulus",
    "shear_modulus",
    "friction_angle_critical",
    "fraction_critical",
    "dilation_factor",
    "softening_rate",
    "cohesion",
];

/// All figures that the tests tell, in the order of files and tables.
pub const KEYS: [Key; 7] = {
    const fn key([name, symbol, unit]: [&'static str; 3], of: fn(&CriticalDruckerPrager) -> f64, table_2: f64) -> Key {
        Key { name, symbol, unit, of, table_2 }
    }
    let [bulk, shear, friction, fraction, dilation, softening, cohesion] = NAMES;
    [
        key([bulk, "K", "Pa"], |law| law.bulk_modulus, 630e6),
        key([shear, "G", "Pa"], |law| law.shear_modulus, 460e6),
        key([friction, "phi_cs", "rad"], |law| math::atan(law.friction_critical), 0.27),
        key([fraction, "Phi_cs", ""], |law| law.fraction_critical, 0.815),
        key([dilation, "chi", ""], |law| law.dilation_factor, 7.0),
        key([softening, "xi", ""], |law| law.softening_rate, 0.01),
        key([cohesion, "c", "Pa"], |law| law.cohesion, 0.0),
    ]
};

/// Makes the packings, tests them and fits. Nothing depends on how many threads do it.
pub fn calibrate(subject: &Subject, wanted: Wanted) -> Result<Calibration, Error> {
    let seeds: Vec<u64> = (0..wanted.packings).map(|number| subject.piece.seed + number).collect();
    let specimens =
        seeds.into_par_iter().map(|seed| specimen(subject, wanted, seed)).collect::<Result<Vec<Specimen>, Error>>()?;
    let mean = |of: fn(&CriticalDruckerPrager) -> f64| {
        specimens.iter().map(|specimen| of(&specimen.fit.law)).sum::<f64>() / specimens.len() as f64
    };
    let moduli = [mean(|law| law.bulk_modulus), mean(|law| law.shear_modulus)];
    let tests: Vec<&Shear> = specimens.iter().map(|specimen| &specimen.shear).collect();
    let dry: Vec<&Shear> = specimens.iter().filter_map(|specimen| specimen.dry.as_ref()).collect();
    let fit = fit_with(&dry, &tests, moduli)?;
    let quality = Quality::of(&fit.law, &tests).expect("the law that was fitted follows the tests");
    Ok(Calibration { wanted, stress: subject.stress, specimens, fit, quality })
}

/// The tests of one packing, in the order that they are done in: two compressions, the shear, and where grains cohere the
/// shear without.
pub fn elements(subject: &Subject, wanted: Wanted, seed: u64) -> Vec<Element<'_>> {
    let packing = Packing { stress: subject.stress, friction: None, energy_ratio_most: ENERGY_RATIO_MOST };
    let of = |test, contact| Element { subject, contact, test, grains: wanted.grains, seed, packing };
    let (contact, shear) = (subject.piece.contact, Test::Shear { strain: wanted.strain });
    let mut elements = vec![of(Test::Isotropic, contact), of(Test::Uniaxial, contact), of(shear, contact)];
    let dry = contact.without_cohesion();
    elements.extend((dry != contact).then(|| of(shear, dry)));
    elements
}

/// The fit to tests, with phi_cs of those of the same grains without cohesion, if there are any.
fn fit_with(dry: &[&Shear], tests: &[&Shear], moduli: [f64; 2]) -> Result<Fit, Error> {
    if dry.is_empty() {
        return fit(tests, moduli, None);
    }
    let without = fit(dry, moduli, None)?;
    let mut fit = fit(tests, moduli, Some(without.law.friction_critical))?;
    let [_, _, friction, ..] = NAMES;
    fit.at_bound.extend(without.at_bound.into_iter().filter(|key| *key == friction));
    Ok(fit)
}

fn specimen(subject: &Subject, wanted: Wanted, seed: u64) -> Result<Specimen, Error> {
    let elements = elements(subject, wanted, seed);
    let [isotropic, uniaxial, shear, without @ ..] = elements.as_slice() else { unreachable!("three tests at least") };
    let (isotropic, uniaxial) = (isotropic.measure()?, uniaxial.measure()?);
    let moduli = moduli(subject.axes(), &isotropic, &uniaxial);
    tracing::info!(
        "packing of seed {seed}: fraction {:.4}, K {:.1} MPa, G {:.1} MPa; now it is sheared",
        isotropic[0].fraction,
        1e-6 * moduli[0],
        1e-6 * moduli[1]
    );
    let shear = shear.shear()?;
    let dry = without.first().map(Element::shear).transpose()?;
    let fit = fit_with(&dry.iter().collect::<Vec<_>>(), &[&shear], moduli)?;
    let law = &fit.law;
    tracing::info!(
        "packing of seed {seed} is sheared: phi_cs {:.4} rad, Phi_cs {:.4}, chi {:.2}, xi {:.2}",
        math::atan(law.friction_critical),
        law.fraction_critical,
        law.dilation_factor,
        law.softening_rate
    );
    Ok(Specimen { seed, isotropic, uniaxial, shear, dry, fit })
}

impl Calibration {
    /// A figure of the fit to all packings, and its standard deviation over those to single ones, if there are several.
    pub fn figure(&self, key: &Key) -> (f64, Option<f64>) {
        let singles = || self.specimens.iter().map(|specimen| (key.of)(&specimen.fit.law));
        let count = self.specimens.len() as f64;
        let mean = singles().sum::<f64>() / count;
        let square: f64 = singles().map(|single| (single - mean) * (single - mean)).sum();
        let spread = (self.specimens.len() > 1).then(|| (square / (count - 1.0)).sqrt());
        ((key.of)(&self.fit.law), spread)
    }
}
