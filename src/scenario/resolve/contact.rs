//! `[contact]` of both kinds of jobs.

use crate::error::Error;
use crate::math::{PI, ln, tan};
use crate::scenario::raw::Reader;
use crate::scenario::schema::OF_LAW;
use crate::scenario::{Contact, ElasticRolling, HertzMindlin, Linear, LinearCohesive, Sliding};

/// The contact law. Asleep: the linear one with Table 1 of seed 000 and the damping that is stable.
///
/// `mass_mean`: mass of the mean grain, kg, which turns a restitution into a damping.
pub fn contact(table: &Reader<'_>, mass_mean: f64) -> Result<Contact, Error> {
    let law = table.choice_or("law", "contact law", &OF_LAW.map(|(name, _)| (name, name)), "linear")?;
    table.refuse_keys_of_others("law", law, &OF_LAW)?;
    Ok(match law {
        "linear" => Contact::Linear(linear(table, mass_mean)?),
        "linear_cohesive" => Contact::LinearCohesive(LinearCohesive {
            linear: linear(table, mass_mean)?,
            cohesion_normal: table.number("cohesion_normal")?,
            cohesion_tangential: table.number("cohesion_tangential")?,
        }),
        "elastic_rolling" => Contact::ElasticRolling(ElasticRolling {
            young_modulus: table.number("young_modulus")?,
            stiffness_ratio: table.number("stiffness_ratio")?,
            friction: friction(table)?,
            rolling_stiffness: table.number_or("rolling_stiffness", 0.0)?,
            rolling_limit: table.number_or("rolling_limit", 0.0)?,
            sliding: table.choice_or(
                "sliding",
                "form of sliding",
                &[("surface", Sliding::Surface), ("scaled", Sliding::Scaled)],
                Sliding::Surface,
            )?,
        }),
        "hertz_mindlin" => Contact::HertzMindlin(HertzMindlin {
            shear_modulus: table.number("shear_modulus")?,
            poisson_ratio: table.number("poisson_ratio")?,
            friction: friction(table)?,
            damping_normal: table.number_or("damping_normal", 0.0)?,
            damping_tangential: table.number_or("damping_tangential", 0.0)?,
        }),
        other => panic!("the schema has a law {other} that is not read"),
    })
}

fn linear(table: &Reader<'_>, mass_mean: f64) -> Result<Linear, Error> {
    let stiffness_normal = table.number_awake("stiffness_normal", 1_772_093.8)?;
    let stiffness_tangential = table.number_awake("stiffness_tangential", 886_046.9)?;
    let (damping_normal, damping_tangential) = damping(table, stiffness_normal, mass_mean)?;
    let friction = friction(table)?;
    Ok(Linear { stiffness_normal, stiffness_tangential, damping_normal, damping_tangential, friction })
}

/// Either both dampings, or the restitution of two mean grains.
fn damping(table: &Reader<'_>, stiffness: f64, mass_mean: f64) -> Result<(f64, f64), Error> {
    let damped = ["damping_normal", "damping_tangential"].into_iter().find(|key| table.has(key));
    match (table.number_if_given("restitution")?, damped) {
        (Some(_), Some(key)) => Err(table.refusal(
            "restitution",
            &format!(
                "stands beside contact.{key}, and each says how contacts are damped. Keep restitution, or damping_normal and damping_tangential."
            ),
        )),
        (Some(restitution), None) => {
            let damping = damping_of(restitution, stiffness, mass_mean);
            Ok((damping, damping))
        }
        (None, None) if table.is_awake() => Err(table.refusal_of_table(
            "does not say how contacts are damped. Add restitution, for example restitution = 0.5, or both damping_normal and damping_tangential, for example \"3.5 N s/m\".",
        )),
        (None, _) => {
            Ok((table.number_awake("damping_normal", 3.5)?, table.number_awake("damping_tangential", 3.5)?))
        }
    }
}

/// Damping with which two grains of mass `mass` rebound with that restitution, N s/m.
///
/// Their distance is an oscillator of mass m/2 with half a period of contact:
/// e = exp(-pi zeta/sqrt(1 - zeta^2)), zeta = gamma/(2 sqrt(k m/2)).
fn damping_of(restitution: f64, stiffness: f64, mass: f64) -> f64 {
    let logarithm = ln(restitution);
    -2.0 * logarithm * (stiffness * 0.5 * mass).sqrt() / (PI * PI + logarithm * logarithm).sqrt()
}

/// The Coulomb coefficient, or the tangent of its angle.
fn friction(table: &Reader<'_>) -> Result<f64, Error> {
    let angle = table.number_if_given("friction_angle")?;
    match (angle, table.has("friction")) {
        (Some(_), true) => Err(table.refusal(
            "friction_angle",
            "stands beside contact.friction, and each says how rough grains are. Keep one of them.",
        )),
        (Some(angle), false) => Ok(tan(angle)),
        (None, _) => table.number_awake("friction", 0.5),
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

    /// Table 1 of seed 000: a restitution of 0.1 takes 4.96 N s/m (reference/dem/README.md); 7 N s/m follows only if m/2 is
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
        assert_eq!((law.shear_modulus, law.damping_normal), (29e9, 0.0));
    }
}
