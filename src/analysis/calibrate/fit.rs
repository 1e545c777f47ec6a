//! Figures of the continuum's law from what the element tests measured.

use super::NAMES;
use super::element::{ROW_SHEAR, Row, STRAIN_SMALL};
use super::least_squares::Parameter;
use super::model::{Curve, Model, follow};
use super::path::{Drive, sheared};
use crate::base::error::Error;
use crate::base::math;
use crate::law::material::CriticalDruckerPrager;

/// Strain over which the curves of grains are averaged to see their peak.
const STRAIN_SMOOTH: f64 = 0.01;
/// Share of a shear test, its end, that is taken for the critical state where the fit starts.
const SHARE_CRITICAL: f64 = 0.4;
/// Where the fit starts: the excess of friction at the peak over its critical value, softened within some ten per cent.
const SOFTENING_START: f64 = 10.0;
const DILATION_START: f64 = 8.0;
/// Solid volume fractions are compared in shares of the fall that a test shows, at least this.
const FALL_LEAST: f64 = 2e-3;

/// A law that follows tests, and the keys of its figures that stopped at a bound of the fit: the tests do not tell them.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// K, G and, of grains that cohere, phi_cs as given; the rest as found.
    pub law: CriticalDruckerPrager,
    /// As `[material]` of a job calls them; empty where the tests tell all.
    pub at_bound: Vec<&'static str>,
}

/// A shear test of grains.
#[derive(Clone, Debug, PartialEq)]
pub struct Shear {
    /// 2 of discs, 3 of spheres.
    pub axes: usize,
    /// Normal stress kept, Pa, compression positive.
    pub stress: f64,
    /// By shear strain; the first one is the packing at rest, not sheared yet.
    pub rows: Vec<Row>,
}

impl Shear {
    /// The path of the law.
    pub fn drive(&self) -> Drive {
        Drive::shear(self.axes, self.stress, self.rows[0].fraction)
    }
}

/// The law's response on the path of a shear test.
pub struct Response {
    /// At the strains of the test; `fraction` is the law's own Phi.
    pub rows: Vec<Row>,
    /// Volume over that at the start, by the law's flow.
    pub volumes: Vec<f64>,
}

/// Mean of the normal stresses of a row, and the normal stress along y; Pa, compression positive.
pub fn pressure(row: &Row) -> f64 {
    row.pressure
}

/// The normal stress of a row along y, Pa, compression positive.
pub fn axial(row: &Row) -> f64 {
    -row.stress[2]
}

/// Volume strain and Kirchhoff stress, by the volume at the start (Pa, compression positive), of a compression: what the law's
/// moduli are slopes of. The stress itself rises by the pressure more, because the volume shrinks.
pub fn compression(rows: &[Row], stress: fn(&Row) -> f64) -> Vec<[f64; 2]> {
    rows.iter().map(|row| [row.strain, stress(row) * rows[0].fraction / row.fraction]).collect()
}

/// Slope of a Kirchhoff stress against volume strain over its first small part, by least squares; Pa.
pub fn modulus(rows: &[Row], stress: fn(&Row) -> f64) -> f64 {
    let mut small = compression(rows, stress);
    small.retain(|[strain, _]| *strain <= STRAIN_SMALL);
    let count = small.len() as f64;
    let mean = |axis: usize| small.iter().map(|at| at[axis]).sum::<f64>() / count;
    let middle = [mean(0), mean(1)];
    let sum = |axis: usize| small.iter().map(|at| (at[0] - middle[0]) * (at[axis] - middle[axis])).sum::<f64>();
    sum(1) / sum(0)
}

/// tau/sigma_n of a row: shear stress over the normal stress along y as it was.
pub fn friction(row: &Row) -> f64 {
    -row.stress[1] / row.stress[2]
}

/// K and G, Pa, of an isotropic and of a uniaxial compression by their first small part: M = K + G in the plane, K + 4 G/3 in space.
pub fn moduli(axes: usize, isotropic: &[Row], uniaxial: &[Row]) -> [f64; 2] {
    let (bulk, p_wave) = (modulus(isotropic, pressure), modulus(uniaxial, axial));
    [bulk, (p_wave - bulk) * axes as f64 / (2.0 * (axes as f64 - 1.0))]
}

/// The sine of the mobilised friction angle in the plane of the shear.
pub fn sine(row: &Row) -> f64 {
    let [xx, xy, yy] = row.stress;
    let difference = 0.5 * (xx - yy);
    (difference * difference + xy * xy).sqrt() / (-0.5 * (xx + yy))
}

/// The law on the path of a test, from the test's own solid volume fraction.
pub fn response(law: &CriticalDruckerPrager, shear: &Shear) -> Option<Response> {
    let strains = shear.rows.iter().map(|row| row.strain);
    let (rows, volumes) = sheared(law, shear.drive(), strains)?.into_iter().unzip();
    Some(Response { rows, volumes })
}

/// The law that follows these tests with the least squares of tau/sigma_n, over its mean, and of Phi, over the fall that the
/// test shows. `moduli` are K and G, Pa. Of grains that do not cohere phi_cs, Phi_cs, chi and xi are found. Of those that do,
/// friction and cohesion cannot be told apart under one stress: tan(phi_cs) is given, as the same grains have it without
/// cohesion, and Phi_cs, chi, xi and c are found.
pub fn fit(tests: &[&Shear], moduli: [f64; 2], friction_critical: Option<f64>) -> Result<Fit, Error> {
    let curve = |test: &&Shear| {
        let [ratio, fall] = scales(test);
        let weight = 1.0 / (test.rows.len() as f64).sqrt();
        let weights = vec![[weight / ratio, weight / fall]; test.rows.len()];
        Curve { drive: test.drive(), rows: test.rows.clone(), weights, since: vec![None; test.rows.len()] }
    };
    let curves: Vec<Curve> = tests.iter().map(curve).collect();
    let model = Critical { moduli, friction_critical, parameters: parameters(tests, friction_critical) };
    let (found, at_bound) = follow(&model, &curves, None).ok_or_else(|| {
        Error::Run(
            "the continuum's law cannot follow the shear test: it does not keep the normal stress with what the fit starts from. Look at the shear test by `scree run`; more grains or more strain may help."
                .to_string(),
        )
    })?;
    Ok(Fit { law: model.law_of(&found), at_bound })
}

/// The critical-state law with its moduli, and with tan(phi_cs) where that is given.
struct Critical {
    moduli: [f64; 2],
    friction_critical: Option<f64>,
    parameters: [Parameter; 4],
}

impl Critical {
    fn law_of(&self, &[fraction, dilation, softening, last]: &[f64; 4]) -> CriticalDruckerPrager {
        CriticalDruckerPrager {
            bulk_modulus: self.moduli[0],
            shear_modulus: self.moduli[1],
            friction_critical: self.friction_critical.unwrap_or(last),
            fraction_critical: fraction,
            dilation_factor: dilation,
            dilation: 0.0,
            softening_rate: softening,
            cohesion: if self.friction_critical.is_some() { last } else { 0.0 },
        }
    }
}

impl Model<4> for Critical {
    type Law = CriticalDruckerPrager;

    fn parameters(&self) -> [(&'static str, Parameter); 4] {
        let [_, _, friction, fraction, dilation, softening, cohesion] = NAMES;
        let keys = [fraction, dilation, softening, if self.friction_critical.is_some() { cohesion } else { friction }];
        std::array::from_fn(|index| (keys[index], self.parameters[index]))
    }

    fn law(&self, at: &[f64; 4]) -> Option<CriticalDruckerPrager> {
        Some(self.law_of(at))
    }
}

/// What residuals of tau/sigma_n and of Phi are shares of.
fn scales(test: &Shear) -> [f64; 2] {
    let mean = |of: fn(&Row) -> f64| test.rows.iter().map(of).sum::<f64>() / test.rows.len() as f64;
    let fall = test.rows[0].fraction - mean(|row| row.fraction);
    [mean(friction), fall.abs().max(FALL_LEAST)]
}

/// Phi_cs, chi, xi, and tan(phi_cs) or c: where they start, by the end of the tests, and their bounds.
fn parameters(tests: &[&Shear], friction_critical: Option<f64>) -> [Parameter; 4] {
    let end = |of: fn(&Row) -> f64| {
        let of_test = |test: &&Shear| {
            let last = &test.rows[((1.0 - SHARE_CRITICAL) * test.rows.len() as f64) as usize..];
            last.iter().map(of).sum::<f64>() / last.len() as f64
        };
        tests.iter().map(of_test).sum::<f64>() / tests.len() as f64
    };
    let parameter = |start, lower, upper, scale| Parameter { start, lower, upper, scale };
    // tau = sin(phi_cs) sigma_n + cos(phi_cs) c.
    let last = match friction_critical {
        Some(tangent) => {
            let stress = tests[0].stress;
            let cohesion = stress * (end(friction) * (1.0 + tangent * tangent).sqrt() - tangent);
            parameter(cohesion, 0.0, 10.0 * stress, 0.1 * stress)
        }
        None => {
            let sine = end(friction).clamp(0.02, 0.95);
            parameter(sine / (1.0 - sine * sine).sqrt(), 0.01, 5.0, 0.1)
        }
    };
    let fraction = end(|row| row.fraction);
    let fall = tests.iter().map(|test| (test.rows[0].fraction - fraction).abs()).fold(FALL_LEAST, f64::max);
    [
        // Not further beyond the end than the end is from the start: a short test does not know its critical state.
        parameter(fraction, fraction - fall, fraction + fall, 0.01),
        parameter(DILATION_START, 0.0, 100.0, 1.0),
        parameter(SOFTENING_START, 0.0, 1000.0, 1.0),
        last,
    ]
}

/// How a law follows shear tests, means over the tests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Root mean square of the differences in tau/sigma_n and in Phi.
    pub friction_off: f64,
    /// Root mean square of the differences in Phi.
    pub fraction_off: f64,
    /// Largest tau/sigma_n and its strain, of the grains' moving average and of the law.
    pub peak: [[f64; 2]; 2],
    /// Secant shear modulus where half of the peak is reached, grains and law, Pa.
    pub secant: [f64; 2],
    /// Volume strain at the end, grains and law's flow.
    pub volume_end: [f64; 2],
}

impl Quality {
    /// None where the law does not bear one of the tests.
    pub fn of(law: &CriticalDruckerPrager, tests: &[&Shear]) -> Option<Self> {
        let singles: Vec<Self> = tests.iter().map(|test| Self::of_test(law, test)).collect::<Option<_>>()?;
        let mean = |of: &dyn Fn(&Self) -> f64| singles.iter().map(of).sum::<f64>() / singles.len() as f64;
        let pair = |of: fn(&Self) -> [f64; 2]| [mean(&|one| of(one)[0]), mean(&|one| of(one)[1])];
        Some(Self {
            friction_off: mean(&|one| one.friction_off * one.friction_off).sqrt(),
            fraction_off: mean(&|one| one.fraction_off * one.fraction_off).sqrt(),
            peak: [pair(|one| one.peak[0]), pair(|one| one.peak[1])],
            secant: pair(|one| one.secant),
            volume_end: pair(|one| one.volume_end),
        })
    }

    fn of_test(law: &CriticalDruckerPrager, test: &Shear) -> Option<Self> {
        let model = response(law, test)?;
        let off = |of: fn(&Row) -> f64| {
            let square = |(a, b): (&Row, &Row)| (of(a) - of(b)) * (of(a) - of(b));
            (test.rows.iter().zip(&model.rows).map(square).sum::<f64>() / test.rows.len() as f64).sqrt()
        };
        let smooth = smoothed(&test.rows);
        let sharp: Vec<[f64; 2]> = model.rows.iter().map(|row| [row.strain, friction(row)]).collect();
        let highest = |curve: &[[f64; 2]]| {
            let [strain, most] = curve.iter().fold([0.0; 2], |most, at| if at[1] > most[1] { *at } else { most });
            [most, strain]
        };
        let peak = [highest(&smooth), highest(&sharp)];
        let half = 0.5 * peak[0][0];
        let first = test.rows[0].fraction;
        let last = test.rows.last().map_or(first, |row| row.fraction);
        Some(Self {
            friction_off: off(friction),
            fraction_off: off(|row| row.fraction),
            peak,
            secant: [secant(&test.rows, half), secant(&model.rows, half)].map(|ratio| ratio * test.stress),
            volume_end: [math::ln(first / last), math::ln(model.volumes.last().copied().unwrap_or(1.0))],
        })
    }
}

/// tau/sigma_n over shear strain where it first reaches `half`, between two rows.
fn secant(rows: &[Row], half: f64) -> f64 {
    let found = rows.windows(2).find(|pair| friction(&pair[1]) >= half);
    found.map_or(f64::NAN, |pair| {
        let [low, high] = [friction(&pair[0]), friction(&pair[1])];
        let strain = pair[0].strain + (pair[1].strain - pair[0].strain) * (half - low) / (high - low);
        half / strain
    })
}

/// Strain and tau/sigma_n, averaged over a stretch of strain around each row; shorter towards the ends.
pub fn smoothed(rows: &[Row]) -> Vec<[f64; 2]> {
    let reach = (0.5 * STRAIN_SMOOTH / ROW_SHEAR).round() as usize;
    let around = |index: usize| {
        let reach = reach.min(index).min(rows.len() - 1 - index);
        let near = &rows[index - reach..=index + reach];
        near.iter().map(friction).sum::<f64>() / near.len() as f64
    };
    rows.iter().enumerate().map(|(index, row)| [row.strain, around(index)]).collect()
}
