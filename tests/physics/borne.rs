//! Stress and softening that a material does not bear are refused, and the law would not have borne them.

use scree::base::space::{Linear, Plane, Solid, Space};
use scree::job::Job;
use scree::law::material::{self, CriticalConstants, MaterialLaw};

use crate::bad_continua::GOOD;
use crate::refusals::refused_text;

/// Whether the law takes a stress up as it is.
fn bears<S: Space>(job: &CriticalConstants, overburden: f64, k0: f64) -> bool {
    let law = material::CriticalDruckerPrager::of(job);
    let mut stress = S::identity() * (-k0 * overburden);
    stress[0] = -overburden;
    let kept = MaterialLaw::<S>::stress(&law, &law.start(&stress, job.fraction.unwrap()));
    Linear::norm(&(kept - stress)) < 1e-9 * overburden
}

/// A job's stress is refused where the law would change it, and nowhere else.
#[test]
fn the_law_bears_what_the_cone_does() {
    for (cohesion, fraction) in [(0.0, 0.8), (0.0, 0.82), (2e3, 0.77)] {
        let job = CriticalConstants {
            bulk_modulus: 2e7,
            shear_modulus: 1e7,
            friction_angle_critical: 0.45,
            fraction_critical: 0.8,
            fraction: Some(fraction),
            dilation_factor: 5.0,
            softening_rate: 1.0,
            cohesion,
            dilation_angle: None,
        };
        for axes in [2, 3] {
            let borne = |k0| if axes == 2 { bears::<Plane>(&job, 1e4, k0) } else { bears::<Solid>(&job, 1e4, k0) };
            let [least, most] = job.cone(axes, fraction).k0(axes, 1e4, cohesion);
            assert!(borne(least * (1.0 + 1e-6)) && !borne(least * (1.0 - 1e-6)), "{axes} axes, k0 = {least}");
            assert!(borne(most * (1.0 - 1e-6)) && !borne(most * (1.0 + 1e-6)), "{axes} axes, k0 = {most}");
        }
    }
}

/// The run gained energy without end.
#[test]
fn softening_that_has_no_return() {
    let soft = |right: &str, wrong: &str| {
        let text = GOOD.0.replace("shear_modulus = \"10 MPa\"", "shear_modulus = \"1 MPa\"");
        assert_eq!(text.matches(right).count(), 1, "the job has {right} once");
        text.replace(right, wrong)
    };
    refused_text(
        &soft("dilation_factor = 7", "dilation_angle = \"-35 deg\""),
        &[],
        "job.toml:26: material.dilation_angle = \"-35 deg\" softens more than the shear modulus can bear: flow is divided by G + K eta etabar, which must be positive and is -4740000 Pa at a solid volume fraction of 0.82. Write a shear_modulus of more than 5735765 Pa, or write a dilation angle nearer to zero.",
    );
    refused_text(
        &soft("spin = \"1 rad/s\"", "fraction = 0.77"),
        &[],
        "job.toml:57: region.fraction = 0.77 softens more than the shear modulus can bear: flow is divided by G + K eta etabar, which must be positive and is -417000 Pa at a solid volume fraction of 0.77. Write a shear_modulus of more than 1417330 Pa, or bring the fraction nearer to fraction_critical, or lower dilation_factor.",
    );
    // Neither at the start, where there is next to no friction, nor at the end, where nothing dilates.
    refused_text(
        &soft("spin = \"1 rad/s\"", "fraction = 0.7177"),
        &[],
        "job.toml:57: region.fraction = 0.7177 softens more than the shear modulus can bear: flow is divided by G + K eta etabar, which must be positive and is -538000 Pa at a solid volume fraction of 0.7588. Write a shear_modulus of more than 1538462 Pa, or bring the fraction nearer to fraction_critical, or lower dilation_factor.",
    );
    let still = soft("spin = \"1 rad/s\"", "fraction = 0.7177").replace("softening_rate = 5", "softening_rate = 0");
    Job::parse(&still, "job.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
}

/// It was brought back to the cone, and the run began with another stress than the job's.
#[test]
fn a_stress_that_the_material_does_not_bear() {
    let with = |k0: &str| format!("stress.k0={k0}");
    refused_text(
        GOOD.0,
        &[&with("0.05")],
        "--set: stress.k0 = 0.05 makes a stress that friction and cohesion do not bear where 19.1 kPa lie above, and it would not be the stress of the start. Write at least 0.2099, or give the material more friction or cohesion.",
    );
    refused_text(
        GOOD.0,
        &[&with("5")],
        "--set: stress.k0 = 5 makes a stress that friction and cohesion do not bear where 19.1 kPa lie above, and it would not be the stress of the start. Write at most 3.9985, or give the material more friction or cohesion.",
    );
    let loose = GOOD.0.replace("fraction = 0.82", "fraction = 0.8");
    refused_text(
        &loose,
        &[&with("0.25")],
        "--set: stress.k0 = 0.25 makes a stress that friction and cohesion do not bear where 19.1 kPa lie above, and it would not be the stress of the start. Write at least 0.273, or give the material more friction or cohesion.",
    );
    Job::parse(GOOD.0, "job.toml", &[with("0.21")]).unwrap_or_else(|error| panic!("{error}"));
}
