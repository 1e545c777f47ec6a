//! What is allowed and has a meaning, but is more likely a slip: told by `check` and at the start of a run.

use super::page::figures;
use crate::job::Job;
use crate::job::assembly::Assembly;
use crate::job::mpm::Mpm;
use crate::law::contact::Contact;

/// Solids and soils lie between these, kg/m3: from light foams to osmium.
const DENSITY_MIN: f64 = 20.0;
const DENSITY_MAX: f64 = 23_000.0;
/// kg/m3 in a g/cm3.
const GRAMS_PER_CUBIC_CENTIMETRE: f64 = 1000.0;

const AXES: [&str; 3] = ["x", "y", "z"];

/// One sentence each, with what to write instead.
pub fn doubts(job: &Job) -> Vec<String> {
    let mut doubts = Vec::new();
    if let Some(grains) = job.grains() {
        doubts.extend(pull(&grains));
        doubts.extend(density("grains.density", grains.matter.density));
        doubts.extend(gravity("cell.gravity", &grains.gravity, grains.cell.dimension));
        doubts.extend(idle_friction(&grains.contact));
    }
    if let Some(job) = job.continuum() {
        // Beside grains it is theirs.
        doubts.extend(
            job.grains.is_none().then(|| density("material.density", job.material.density)).into_iter().flatten(),
        );
        doubts.extend(gravity("gravity.acceleration", &job.gravity.acceleration, job.grid.dimension));
        doubts.extend(noise(&job));
    }
    doubts
}

/// Stresses of single points that nobody should trust.
fn noise(job: &Mpm) -> Option<String> {
    job.has_noisy_stresses().then(|| {
        format!(
            "with scheme.points_per_cell = {} the stresses of single points under gravity are noise about the mean of their cell: where material has flowed and come to rest many bear nothing and others several times the overburden. Leave scheme.volume_averaging at true, which ends it, or take points_per_cell = 1.",
            job.scheme.points_per_cell
        )
    })
}

/// A stress that pulls at grains which hold on to nothing.
fn pull(job: &Assembly) -> Vec<String> {
    let Some(servo) = job.cell.servo.as_ref().filter(|_| !job.contact.coheres()) else { return Vec::new() };
    let pulled: Vec<&str> =
        (0..3).filter(|axis| servo.stress[*axis].is_some_and(|stress| stress > 0.0)).map(|axis| AXES[axis]).collect();
    if pulled.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "cell.stress_normal pulls along {} (compression is positive) at grains without cohesion: nothing bears it, and the cell grows until the run stops. Write a positive stress to press, or take law = \"linear_cohesive\" or a contact.surface_energy.",
        pulled.join(" and ")
    )]
}

fn density(key: &str, density: f64) -> Vec<String> {
    let message = if density < DENSITY_MIN {
        let meant = density * GRAMS_PER_CUBIC_CENTIMETRE;
        format!(
            "{key} = {} kg/m3 is less than any solid has. If {} g/cm3 was meant, write \"{} kg/m3\".",
            figures(density),
            figures(density),
            figures(meant)
        )
    } else if density > DENSITY_MAX {
        format!(
            "{key} = {} kg/m3 is more than any solid has. Densities are in kg/m3; quartz has 2650.",
            figures(density)
        )
    } else {
        return Vec::new();
    };
    vec![message]
}

/// The last axis of a space points up.
fn gravity(key: &str, gravity: &[f64; 3], axes: usize) -> Vec<String> {
    let up = gravity[axes - 1];
    if up <= 0.0 {
        return Vec::new();
    }
    let name = AXES[axes - 1];
    vec![format!(
        "{key} points upwards: its component along {name} is {} m/s2. Write it negative for gravity that pulls down.",
        figures(up)
    )]
}

/// A limit to forces that the law does not make.
fn idle_friction(contact: &Contact) -> Vec<String> {
    // Of any two grains that overlap.
    let springs = contact.springs([1.0; 2], [1.0; 2], 0.1);
    let [_, stiffness] = contact.keys_of_stiffness();
    let mut doubts = Vec::new();
    if springs.tangential + springs.damping_tangential == 0.0 && contact.friction() > 0.0 {
        doubts.push(format!(
            "contact.friction = {} limits nothing: with contact.{stiffness} = 0 the law has no tangential force. Give it that stiffness, or write friction = 0.",
            figures(contact.friction())
        ));
    }
    if contact.rolling().is_some_and(|rolling| rolling.limit > 0.0) && springs.rolling == 0.0 {
        doubts.push(format!(
            "contact.rolling_limit limits nothing: with contact.rolling_stiffness or contact.{stiffness} = 0 the law has no resistance to rolling. Give it that stiffness, or remove the limit."
        ));
    }
    doubts
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLANE: &str = "name = \"slips\"\n[cell]\nspace = \"plane\"\nupper = [0.01, 0.01]\n[grains]\ndensity = 2500\nfile = \"grains.csv\"\ndiameter_mean = 1e-3\n[contact]\nlaw = \"linear\"\nstiffness_normal = 1e5\nstiffness_tangential = 5e4\nrestitution = 0.5\nfriction = 0.5\n[time]\nstep = 1e-7\nend = 1e-3\n";

    fn told(sets: &[&str]) -> Vec<String> {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
        doubts(&Job::parse(PLANE, "job.toml", &sets).unwrap_or_else(|error| panic!("{error}")))
    }

    /// Each of these ran to its end and told nothing.
    #[test]
    fn slips_are_told_with_what_to_write() {
        assert_eq!(told(&[]), Vec::<String>::new());
        let one = |sets: &[&str], wanted: &str| {
            let told = told(sets);
            assert!(told.len() == 1 && told[0].contains(wanted), "{told:?}");
        };
        let held = ["cell.stress_normal=[\"-1 MPa\", \"free\"]", "cell.rate_max=1"];
        one(&held, "cell.stress_normal pulls along x (compression is positive)");
        let cohesive =
            ["contact.law=linear_cohesive", "contact.cohesion_normal=\"0.1 N\"", "contact.cohesion_tangential=0"];
        assert_eq!(told(&[&held[..], &cohesive].concat()), Vec::<String>::new());
        one(&["grains.density=\"1.8 kg/m3\""], "If 1.8 g/cm3 was meant, write \"1800 kg/m3\".");
        one(&["grains.density=2.65e6"], "is more than any solid has");
        one(&["cell.gravity=[0, \"9.81 m/s2\"]"], "cell.gravity points upwards: its component along y is 9.81 m/s2");
        assert_eq!(told(&["cell.gravity=[0, \"-9.81 m/s2\"]"]), Vec::<String>::new());
        let smooth = ["contact.stiffness_tangential=0", "contact.damping_normal=1", "contact.damping_tangential=0"];
        let text = PLANE.replace("restitution = 0.5\n", "");
        let sets: Vec<String> = smooth.iter().map(|set| (*set).to_string()).collect();
        let told = doubts(&Job::parse(&text, "job.toml", &sets).unwrap());
        assert!(told.len() == 1 && told[0].contains("contact.friction = 0.5 limits nothing"), "{told:?}");
    }
}
