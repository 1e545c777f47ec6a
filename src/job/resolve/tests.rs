//! Numbers in messages, `[contact]` as it is read, and what the law with mobilised friction rules out.

use super::{digits, digits_above, digits_below};
use crate::base::error::Error;
use crate::base::math::{PI, exp};
use crate::job::Scenario;
use crate::law::contact::{Adhesion, Contact, Force, NormalForce, RollingResistance, Sliding};

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
    let Force::Linear(law) = contact_of(&format!("{SPRINGS}restitution = 0.1\nfriction = 0.5")).unwrap().force else {
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
    let Force::ElasticRolling(rolling) = contact.force else { panic!("as it was asked for") };
    assert_eq!((rolling.rolling_stiffness, rolling.rolling_limit), (0.0, 0.0));
    assert_eq!(rolling.sliding, Sliding::Surface);
}

#[test]
fn every_law_is_read() {
    let cohesive = format!(
        "law = \"linear_cohesive\"\n{SPRINGS}damping_normal = 1\ndamping_tangential = 0\nfriction = 0.5\ncohesion_normal = \"2 N\"\ncohesion_tangential = 1"
    );
    let Force::LinearCohesive(law) = contact_of(&cohesive).unwrap().force else { panic!("as it was asked for") };
    assert_eq!((law.cohesion_normal, law.cohesion_tangential, law.linear.damping_tangential), (2.0, 1.0, 0.0));
    let hertz = "law = \"hertz_mindlin\"\nshear_modulus = \"29 GPa\"\npoisson_ratio = 0.15\nfriction = 0.5";
    let Force::HertzMindlin(law) = contact_of(hertz).unwrap().force else { panic!("as it was asked for") };
    assert_eq!((law.shear_modulus, law.damping_normal, law.damping_ratio), (29e9, 0.0, 0.0));
    assert_eq!(law.normal_force, NormalForce::TENSILE);
}

/// Any law may resist rolling, and its grains adhere.
#[test]
fn parts_go_with_every_law() {
    let linear = format!("{SPRINGS}restitution = 0.5\nfriction = 0.5\n");
    let hertz = "law = \"hertz_mindlin\"\nshear_modulus = \"29 GPa\"\npoisson_ratio = 0.15\nfriction = 0.5\n";
    for law in [linear.as_str(), hertz] {
        let plain = contact_of(law).unwrap();
        assert_eq!((plain.rolling, plain.adhesion, plain.coheres()), (None, None, false));
        let parts = "rolling_stiffness = 1.0\nrolling_limit = 0.05\nsurface_energy = \"50 mJ/m2\"";
        let contact = contact_of(&format!("{law}{parts}")).unwrap();
        assert_eq!(contact.rolling, Some(RollingResistance { stiffness: 1.0, limit: 0.05 }));
        assert_eq!(contact.adhesion, Some(Adhesion { surface_energy: 0.05 }));
        assert!(contact.coheres() && contact.without_cohesion().rolling == contact.rolling);
        let lone = contact_of(&format!("{law}rolling_limit = 0.05")).unwrap_err().to_string();
        assert!(lone.contains("stands alone. Add contact.rolling_stiffness = 1.0"), "{lone}");
    }
}

#[test]
fn a_restitution_of_hertz_contacts_becomes_a_damping_ratio() {
    let hertz = "law = \"hertz_mindlin\"\nshear_modulus = \"29 GPa\"\npoisson_ratio = 0.15\nfriction = 0.5\n";
    let ratio = |lines: &str| match contact_of(&format!("{hertz}{lines}")).unwrap().force {
        Force::HertzMindlin(law) => (law.damping_ratio, law.normal_force),
        other => panic!("{other:?}"),
    };
    let (tensile, _) = ratio("restitution = 0.5");
    assert!((exp(-PI * tensile / (1.0 - tensile * tensile).sqrt()) - 0.5).abs() < 1e-12, "{tensile}");
    let (repulsive, normal_force) = ratio("restitution = 0.5\nnormal_force = \"repulsive\"");
    assert!(repulsive > tensile && normal_force == NormalForce::REPULSIVE, "{repulsive}");
    let two = contact_of(&format!("{hertz}restitution = 0.5\ndamping_normal = 1")).unwrap_err().to_string();
    assert!(two.contains("Keep restitution, or damping_normal, damping_tangential and damping_ratio."), "{two}");
    let rolling = "law = \"elastic_rolling\"\nyoung_modulus = 6e8\nstiffness_ratio = 0.8\nfriction = 0.5\n";
    let error = contact_of(&format!("{rolling}normal_force = \"repulsive\"")).unwrap_err().to_string();
    assert!(error.contains("contact.normal_force"), "{error}");
}

/// Limits in messages are cut, so that they can be copied.
#[test]
fn a_limit_in_a_message_is_within_the_limit() {
    assert_eq!(digits_below(4.479_9e-7), "4.47e-7");
    assert_eq!(digits_below(0.999_99), "0.999");
    assert_eq!(digits(7.499_999_999_999_999), "7.5");
    assert_eq!(digits_above(4e-7), "4e-7");
    assert_eq!(digits_above(3.160_231_572_372_892_6e-5), "3.160231573e-5");
    assert_eq!(digits_above(9.999_999_999_4e-6), "1e-5");
}

/// A slope of the law with mobilised friction, and what its constants rule out.
fn slope(sets: &[&str]) -> Result<crate::job::Job, Error> {
    let text = r#"
        name = "slope"
        [grid]
        space = "plane"
        upper = [4, 2]
        cell = 0.1
        depth = 1
        [material]
        law = "mobilised_friction"
        density = 2000
        bulk_modulus = 86.4e6
        shear_modulus = 55.7e6
        shear_modulus_degradation = 0.7
        shear_degradation_strain = 1e-3
        friction_angle_critical = 0.27486
        fraction = 0.843
        fraction_critical = 0.8165
        dilation_factor = 7.68
        hardening_strain = 2.75e-4
        phase_transformation_factor = 4.86
        [[region]]
        shape = "box"
        lower = [0, 0]
        upper = [4, 1]
        [gravity]
        acceleration = [0, -9.81]
        [stress]
        kind = "geostatic"
        surface = 1
        k0 = 0.6
        [time]
        end = 1
        "#;
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
    crate::job::Job::parse(text, "slope.toml", &sets)
}

#[test]
fn mobilised_friction_is_read_and_held_to_one_return() {
    let job = slope(&[]).unwrap();
    let back = crate::job::Job::parse(&job.to_toml(), "slope.toml", &[]).unwrap();
    assert_eq!(back.as_mpm(), job.as_mpm());
    let refused = |sets: &[&str]| match slope(sets) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("{sets:?} is taken"),
    };
    let soft = refused(&["material.shear_modulus=\"20 MPa\""]);
    for part in ["material.shear_modulus = ", "6000000 Pa, must be more than K m_b m_d", "Write more than"] {
        assert!(soft.contains(part), "{soft}");
    }
    // What it asks for is enough.
    let (_, least) = soft.split_once("Write more than ").unwrap();
    let least: f64 = least.split_once(' ').unwrap().0.parse().unwrap();
    slope(&[&format!("material.shear_modulus={}", least + 1.0)]).unwrap();
    let worn = refused(&["material.shear_modulus_degradation=0.95"]);
    assert!(worn.contains("material.shear_modulus = "), "{worn}");
    let steep = refused(&["stress.k0=0.2"]);
    assert!(steep.contains("stress.k0 = 0.2 makes a stress that friction and cohesion do not bear"), "{steep}");
    let without = refused(&["material.friction_angle_critical=0"]);
    assert!(without.contains("material.friction_angle_critical = 0 is out of range"), "{without}");
}
