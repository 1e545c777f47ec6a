//! `[contact]` of both kinds of jobs.

use crate::base::error::Error;
use crate::base::math::{PI, atan2, exp, ln, tan};
use crate::job::raw::Reader;
use crate::job::schema::OF_LAW;
use crate::law::contact::{
    Contact, ElasticRolling, HertzMindlin, LinearCohesive, LinearSpringDashpot, NormalForce, Sliding, TangentialForce,
};

/// The contact law. Asleep: the linear one with Table 1 of Chen et al. (2021) and the damping that is stable.
///
/// `mass_mean`: mass of the mean grain, kg, which turns a restitution into a damping.
pub fn contact(table: &Reader<'_>, mass_mean: f64) -> Result<Contact, Error> {
    let law = table.choice_or("law", "contact law", &OF_LAW.map(|(name, _)| (name, name)), "linear");
    table.note_keys_of_others("law", law, &OF_LAW);
    Ok(match law {
        "linear" => Contact::Linear(linear(table, mass_mean)?),
        "linear_cohesive" => Contact::LinearCohesive(LinearCohesive {
            linear: linear(table, mass_mean)?,
            cohesion_normal: table.number("cohesion_normal"),
            cohesion_tangential: table.number("cohesion_tangential"),
        }),
        "elastic_rolling" => Contact::ElasticRolling(ElasticRolling {
            young_modulus: table.number("young_modulus"),
            stiffness_ratio: table.number("stiffness_ratio"),
            friction: friction(table)?,
            rolling_stiffness: table.number_or("rolling_stiffness", 0.0),
            rolling_limit: table.number_or("rolling_limit", 0.0),
            sliding: table.choice_or(
                "sliding",
                "form of sliding",
                &[("surface", Sliding::Surface), ("scaled", Sliding::Scaled)],
                Sliding::Surface,
            ),
        }),
        "hertz_mindlin" => {
            let normal_force = normal_force(table);
            let damping_ratio = match restitution(table, &["damping_normal", "damping_tangential", "damping_ratio"])? {
                Some(restitution) => damping_of(restitution, normal_force, 1.0),
                None => table.number_or("damping_ratio", 0.0),
            };
            Contact::HertzMindlin(HertzMindlin {
                shear_modulus: table.number("shear_modulus"),
                poisson_ratio: table.number("poisson_ratio"),
                friction: friction(table)?,
                damping_normal: table.number_or("damping_normal", 0.0),
                damping_tangential: table.number_or("damping_tangential", 0.0),
                damping_ratio,
                normal_force,
                tangential_force: table.choice_or(
                    "tangential_force",
                    "form of the tangential force",
                    &TangentialForce::NAMES,
                    TangentialForce::default(),
                ),
            })
        }
        other => panic!("the schema has a law {other} that is not read"),
    })
}

fn linear(table: &Reader<'_>, mass_mean: f64) -> Result<LinearSpringDashpot, Error> {
    let stiffness_normal = table.number_awake("stiffness_normal", 1_772_093.8);
    let stiffness_tangential = table.number_awake("stiffness_tangential", 886_046.9);
    let normal_force = normal_force(table);
    let (damping_normal, damping_tangential) = damping(table, stiffness_normal, mass_mean, normal_force)?;
    let friction = friction(table)?;
    Ok(LinearSpringDashpot {
        stiffness_normal,
        stiffness_tangential,
        damping_normal,
        damping_tangential,
        friction,
        normal_force,
    })
}

fn normal_force(table: &Reader<'_>) -> NormalForce {
    table.choice_or("normal_force", "range of the normal force", &NormalForce::NAMES, NormalForce::TENSILE)
}

/// The restitution, which the keys of dampings cannot stand beside.
fn restitution(table: &Reader<'_>, dampings: &[&str]) -> Result<Option<f64>, Error> {
    let damped = dampings.iter().find(|key| table.has(key));
    match (table.number_if_given("restitution"), damped) {
        (Some(_), Some(key)) => {
            let [others @ .., last] = dampings else { unreachable!("there are dampings") };
            Err(table.refusal(
                "restitution",
                &format!(
                    "stands beside contact.{key}, and each says how contacts are damped. Keep restitution, or {} and {last}.",
                    others.join(", ")
                ),
            ))
        }
        (restitution, _) => Ok(restitution),
    }
}

/// Either both dampings, or the restitution of two mean grains.
fn damping(table: &Reader<'_>, stiffness: f64, mass_mean: f64, normal_force: NormalForce) -> Result<(f64, f64), Error> {
    let dampings = ["damping_normal", "damping_tangential"];
    if let Some(restitution) = restitution(table, &dampings)? {
        let critical = 2.0 * (stiffness * 0.5 * mass_mean).sqrt();
        let damping = damping_of(restitution, normal_force, critical);
        return Ok((damping, damping));
    }
    if table.is_awake() && !dampings.iter().any(|key| table.has(key)) {
        return Err(table.refusal_of_table(
            "does not say how contacts are damped. Add restitution, for example restitution = 0.5, or both damping_normal and damping_tangential, for example \"3.5 N s/m\".",
        ));
    }
    Ok((table.number_awake("damping_normal", 3.5), table.number_awake("damping_tangential", 3.5)))
}

/// Damping with which two grains rebound with that restitution, in the unit of `critical`, the critical damping of their
/// contact: 2 sqrt(k m) of linear springs, where the effective mass m is half that of each of two equal grains.
///
/// Their overlap is an oscillator with the damping ratio zeta that starts from rest length. Where the dashpot may pull, the
/// contact ends with the overlap; where it only repels, with the force (Schwager & Poeschel 2007, eq. 8 and 21):
///
/// ```text
/// tensile:    e = exp(-pi zeta/w)                                     w = sqrt(|1 - zeta^2|)
/// repulsive:  e = exp(-(zeta/w) atan2(2 zeta w, 2 zeta^2 - 1))        zeta < 1
///             e = exp(-2 (zeta/w) ln(zeta + w))                       zeta > 1
/// ```
///
/// Hertz contacts with a dashpot 2 sqrt(5/6) zeta sqrt(m k_n), k_n = dF_n/dd, are the same oscillator in d^(5/4) and a time
/// of their own, so that e does not depend on speed (Antypov & Elliott 2011; Tsuji et al. 1992 have the dashpot). Their force
/// is nought where that oscillator's acceleration is: both lines hold for them too.
fn damping_of(restitution: f64, normal_force: NormalForce, critical: f64) -> f64 {
    if normal_force == NormalForce::TENSILE {
        let logarithm = ln(restitution);
        return -logarithm * critical / (PI * PI + logarithm * logarithm).sqrt();
    }
    // The rebound falls with the damping ratio; at the upper end, above 1, it is below 1/zeta^2.
    let (mut lower, mut upper) = (0.0, 1.0 + 1.0 / restitution.sqrt());
    loop {
        let middle = 0.5 * (lower + upper);
        if middle <= lower || middle >= upper {
            return middle * critical;
        }
        if rebound_repulsive(middle) > restitution { lower = middle } else { upper = middle }
    }
}

/// Restitution of a contact that ends when its force is nought, by its damping ratio.
fn rebound_repulsive(ratio: f64) -> f64 {
    let root = (1.0 - ratio * ratio).abs().sqrt();
    if root == 0.0 {
        return exp(-2.0);
    }
    let angle = match ratio < 1.0 {
        true => atan2(2.0 * ratio * root, 2.0 * ratio * ratio - 1.0),
        false => 2.0 * ln(ratio + root),
    };
    exp(-ratio / root * angle)
}

/// The Coulomb coefficient, or the tangent of its angle.
fn friction(table: &Reader<'_>) -> Result<f64, Error> {
    let angle = table.number_if_given("friction_angle");
    match (angle, table.has("friction")) {
        (Some(_), true) => Err(table.refusal(
            "friction_angle",
            "stands beside contact.friction, and each says how rough grains are. Keep one of them.",
        )),
        (Some(angle), false) => Ok(tan(angle)),
        (None, _) => Ok(table.number_awake("friction", 0.5)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::Scenario;
    use super::*;

    /// The contact of a job of planar shear with these lines under `[contact]`.
    fn contact_of(lines: &str) -> Result<Contact, Error> {
        let text = format!(
            "name = \"small\"\nmethod = \"dem\"\n[specimen]\nwidth = 0.024\nheight = 0.03\n[grains]\ndiameter_mean = 1e-3\ndiameter_deviation = 0\ndensity = 2530\n[loading]\nstress_normal = 4e5\nspeed = 0.02\nspeed_ramp = 0\nstrain_end = 0.1\n[time]\nstep = 1e-8\n[contact]\n{lines}"
        );
        let scenario = Scenario::parse(&text, "small.toml", &[])?;
        let back = Scenario::parse(&scenario.to_toml(), "small.toml", &[])?;
        assert_eq!(back, scenario);
        Ok(scenario.contact)
    }

    const SPRINGS: &str = "stiffness_normal = 1772093.8\nstiffness_tangential = 886046.9\n";

    /// Table 1 of Chen et al. (2021): a restitution of 0.1 takes 4.96 N s/m; 7 N s/m follows only if m/2 is
    /// mistaken for m.
    #[test]
    fn a_restitution_becomes_a_damping() {
        let Contact::Linear(law) = contact_of(&format!("{SPRINGS}restitution = 0.1\nfriction = 0.5")).unwrap() else {
            panic!("linear is the default")
        };
        assert!((law.damping_normal - 4.96).abs() < 0.005, "{}", law.damping_normal);
        assert_eq!(law.damping_normal, law.damping_tangential);
    }

    #[test]
    fn a_friction_angle_becomes_a_coefficient() {
        let law = "law = \"elastic_rolling\"\nyoung_modulus = \"600 MPa\"\nstiffness_ratio = 0.8\n";
        let contact = contact_of(&format!("{law}friction_angle = \"28.6 deg\"")).unwrap();
        assert!((contact.friction() - 0.545_27).abs() < 1e-4, "{}", contact.friction());
        let Contact::ElasticRolling(rolling) = contact else { panic!("as it was asked for") };
        assert_eq!((rolling.rolling_stiffness, rolling.rolling_limit), (0.0, 0.0));
        assert_eq!(rolling.sliding, Sliding::Surface);
    }

    #[test]
    fn every_law_is_read() {
        let cohesive = format!(
            "law = \"linear_cohesive\"\n{SPRINGS}damping_normal = 1\ndamping_tangential = 0\nfriction = 0.5\ncohesion_normal = \"2 N\"\ncohesion_tangential = 1"
        );
        let Contact::LinearCohesive(law) = contact_of(&cohesive).unwrap() else { panic!("as it was asked for") };
        assert_eq!((law.cohesion_normal, law.cohesion_tangential, law.linear.damping_tangential), (2.0, 1.0, 0.0));
        let hertz = "law = \"hertz_mindlin\"\nshear_modulus = \"29 GPa\"\npoisson_ratio = 0.15\nfriction = 0.5";
        let Contact::HertzMindlin(law) = contact_of(hertz).unwrap() else { panic!("as it was asked for") };
        assert_eq!((law.shear_modulus, law.damping_normal, law.damping_ratio), (29e9, 0.0, 0.0));
        assert_eq!(law.normal_force, NormalForce::TENSILE);
    }
    /// A damping ratio that gives a rebound is found from it again, below and above critical damping, and a dashpot that only
    /// repels needs more of it: the end of a contact, where it would have pulled, slows nothing.
    #[test]
    fn a_restitution_becomes_the_damping_ratio_that_gives_it() {
        for ratio in [1e-6, 0.01, 0.3, 0.7, 0.99, 1.0, 1.01, 3.0, 1e4] {
            let restitution = rebound_repulsive(ratio);
            let found = damping_of(restitution, NormalForce::REPULSIVE, 1.0);
            assert!((found / ratio - 1.0).abs() < 1e-8, "{ratio}: {found} by {restitution}");
            assert!(found > damping_of(restitution, NormalForce::TENSILE, 1.0));
        }
        let hertz = "law = \"hertz_mindlin\"\nshear_modulus = \"29 GPa\"\npoisson_ratio = 0.15\nfriction = 0.5\n";
        let ratio = |lines: &str| match contact_of(&format!("{hertz}{lines}")).unwrap() {
            Contact::HertzMindlin(law) => (law.damping_ratio, law.normal_force),
            other => panic!("{other:?}"),
        };
        let (tensile, _) = ratio("restitution = 0.5");
        assert!((exp(-PI * tensile / (1.0 - tensile * tensile).sqrt()) - 0.5).abs() < 1e-12, "{tensile}");
        let (repulsive, normal_force) = ratio("restitution = 0.5\nnormal_force = \"repulsive\"");
        assert!((rebound_repulsive(repulsive) - 0.5).abs() < 1e-12 && normal_force == NormalForce::REPULSIVE);
        let two = contact_of(&format!("{hertz}restitution = 0.5\ndamping_normal = 1")).unwrap_err().to_string();
        assert!(two.contains("Keep restitution, or damping_normal, damping_tangential and damping_ratio."), "{two}");
        let rolling = "law = \"elastic_rolling\"\nyoung_modulus = 6e8\nstiffness_ratio = 0.8\nfriction = 0.5\n";
        let error = contact_of(&format!("{rolling}normal_force = \"repulsive\"")).unwrap_err().to_string();
        assert!(error.contains("contact.normal_force"), "{error}");
    }
}
