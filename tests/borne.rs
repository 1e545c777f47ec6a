//! What a job is told of its material before a run is what the law then does.

use scree::law::material::{self, MaterialLaw};
use scree::scenario::mpm::CriticalDruckerPrager;
use scree::space::{Linear, Plane, Solid, Space};

/// Whether the law takes a stress up as it is.
fn bears<S: Space>(job: &CriticalDruckerPrager, overburden: f64, k0: f64) -> bool {
    let law = material::CriticalDruckerPrager::of_job(job);
    let mut stress = S::identity() * (-k0 * overburden);
    stress[0] = -overburden;
    let kept = MaterialLaw::<S>::stress(&law, &law.start(&stress, job.fraction));
    Linear::norm(&(kept - stress)) < 1e-9 * overburden
}

/// A job's stress is refused where the law would change it, and nowhere else.
#[test]
fn the_law_bears_what_the_cone_does() {
    for (cohesion, fraction) in [(0.0, 0.8), (0.0, 0.82), (2e3, 0.77)] {
        let job = CriticalDruckerPrager {
            bulk_modulus: 2e7,
            shear_modulus: 1e7,
            friction_angle_critical: 0.45,
            fraction_critical: 0.8,
            fraction,
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
