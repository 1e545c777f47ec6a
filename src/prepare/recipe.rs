//! What a packing is named by in the cache: the job that makes it and does nothing else, written out. Whatever the making does not look
//! at has one value, so that jobs which differ there share their packings; what is new in a job makes packings of its own until it is
//! known here.

use std::path::PathBuf;

use crate::couple::oracle::{Criterion, Laplacian, Oracle};
use crate::couple::zone::{Enrichment, ZoneLife};
use crate::dem::motion::Damping;
use crate::job::assembly::{Assembly, Body, Cell, Motion, Packed, PathPoint, Preparation, Source, Velocities};
use crate::job::mpm::{Boundary, Granular, InitialStress, Material, Mpm, Origin, Region, RigidBody, Rves};
use crate::job::{Grains, Loading, Method, Output, Packing, Scenario, Time};
use crate::law::material::{ConstitutiveLaw, Elastic};
use crate::mpm::penalty::Coupling;
use crate::mpm::scheme::Scheme;

/// Of a packing between plates.
pub fn sheared(job: &Scenario) -> String {
    let recipe = Scenario {
        name: "packing".into(),
        method: Method::Dem,
        grains: Grains { file: None, ..job.grains.clone() },
        contact: job.contact.without_cohesion(),
        packing: Packing { height: None, cache: PathBuf::new(), ..job.packing.clone() },
        loading: Loading { stress_normal: 0.0, speed: 0.0, speed_ramp: 0.0, strain_end: 0.0, ..job.loading },
        oracle: NO_ORACLE,
        enrichment: NO_ZONE,
        coupling: Coupling { interval: 1, ..job.coupling },
        time: Time { grain_steps: 1, ..job.time },
        output: Output::default(),
        ledger: false,
        ..job.clone()
    };
    let text = recipe.to_toml();
    let (before, _) = text.split_once("\n[scheme]").expect("the continuum is written last");
    named("sheared 6", &format!("{before}{CONTINUUM}cell = {:?}\n{NO_SCHEME}", job.continuum.cell))
}

/// The continuum of a packing between plates, of which cells alone shape it, as these texts have had it since its law and scheme stood
/// in that table.
const CONTINUUM: &str = "\n[continuum]\nbulk_modulus = 0.0\nshear_modulus = 0.0\nfriction_angle_critical = 0.0\nfraction_critical = 0.0\ndilation_factor = 0.0\nsoftening_rate = 0.0\ncohesion = 0.0\n";
const NO_SCHEME: &str = "points_per_cell = 0\nflip = 0.0\n";

/// Of grains that are compressed in a cell, or poured into it.
pub fn packed(job: &Assembly, packed: &Packed) -> String {
    let falls = matches!(packed.preparation, Preparation::Pour);
    let body = |body: &Body| Body { name: String::new(), motion: AT_REST, ..body.clone() };
    let recipe = Assembly {
        contact: if falls { job.contact } else { job.contact.without_cohesion() },
        gravity: if falls { job.gravity } else { [0.0; 3] },
        bodies: job.bodies.iter().filter(|_| falls).map(body).collect(),
        ..piece(job, packed)
    };
    named("packed 3", &recipe.to_toml())
}

/// Of a piece of packing that has been laid side by side and has equilibrated between bodies and membranes. Ways that bodies go in the run do
/// not shape it, but for the first, along which they come up to the grains.
pub fn specimen(job: &Mpm, granular: &Granular, way_of_seat: impl Fn(&RigidBody) -> Option<[f64; 3]>) -> String {
    let Source::Packed(packed) = &granular.piece.source else { unreachable!("a checked job has its piece made") };
    let region = |region: &Region| Region {
        fraction: 1.0,
        velocity: [0.0; 3],
        spin: [0.0; 3],
        waves: Vec::new(),
        ..region.clone()
    };
    let body = |rigid: &RigidBody| {
        let way = way_of_seat(rigid).map(|velocity| PathPoint { time: 0.0, velocity, spin: [0.0; 3] });
        let motion = Motion { path: way.into_iter().collect(), oscillation: None, servo: rigid.body.motion.servo };
        // Grains meet bodies at their face, whatever points do.
        let at_face = false;
        RigidBody { body: Body { name: String::new(), motion, ..rigid.body.clone() }, at_face, ..rigid.clone() }
    };
    // Of the material only its stiffness is looked at.
    let stiffness =
        Elastic { bulk_modulus: job.material.law.modulus_longitudinal(job.grid.dimension), shear_modulus: 0.0 };
    let grains = Granular {
        method: Method::Dem,
        piece: Assembly { gravity: [0.0; 3], bodies: Vec::new(), ..piece(&granular.piece, packed) },
        coupling: Coupling { interval: 1, ..granular.coupling },
        enrichment: NO_ZONE,
        reference: Origin::Specimen,
        rves: Rves::DEFAULT,
        known: None,
        is_heterogeneous: false,
    };
    let recipe = Mpm {
        name: "specimen".into(),
        material: Material { density: 0.0, law: ConstitutiveLaw::Hencky(stiffness) },
        regions: job.regions.iter().map(region).collect(),
        stress: InitialStress::None,
        boundaries: [[Boundary::Free; 2]; 3],
        loads: Vec::new(),
        bodies: job.bodies.iter().map(body).collect(),
        follow: Vec::new(),
        oracle: None,
        nonlocal: None,
        grains: Some(Box::new(grains)),
        grain_steps: 1,
        scheme: Scheme { averages_volume: true, ..job.scheme },
        end: 0.0,
        output: Output::default(),
        ledger: false,
        ..job.clone()
    };
    named("specimen 6", &recipe.to_toml())
}

/// A key that has another name now stands under the one that it had, and one that no packing looks at is left out: what is in caches is
/// found.
fn named(how: &str, job: &str) -> String {
    let job = job
        .replace("\nenergy_balance = ", "\nledger = ")
        .replace("\nvolume_averaging = true", "")
        .replace("\ncriterion = \"laplacian\"", "")
        .replace("\ncontact_at = \"nodes\"", "")
        .replace("\nheterogeneity = \"none\"", "")
        .replace("\nrest_strength = 0.0", "")
        .replace("\ninterval = 1\n", "\n");
    format!("{how}\n{job}")
}

/// An assembly whose packing is made and that then does nothing.
fn piece(job: &Assembly, packed: &Packed) -> Assembly {
    Assembly {
        name: "packing".into(),
        cell: Cell { gradient: [[0.0; 3]; 3], servo: None, copies: None, ..job.cell.clone() },
        source: Source::Packed(Packed { cache: PathBuf::new(), ..packed.clone() }),
        damping: Damping::default(),
        end: 0.0,
        velocities: Velocities::Now,
        allow_unstable: false,
        output: Output::default(),
        ledger: false,
        ..job.clone()
    }
}

const AT_REST: Motion = Motion { path: Vec::new(), oscillation: None, servo: None };
const NO_ORACLE: Oracle = Oracle {
    criterion: Criterion::Laplacian(Laplacian {
        laplacian: 0.0,
        recent_strain: 0.0,
        window: 0.0,
        persistence: 0.0,
        tolerance: 0.0,
    }),
    every: 0,
};
const NO_ZONE: Enrichment = Enrichment {
    distance: 0.0,
    weight: 0.0,
    training: 0.0,
    training_speed: 0.0,
    training_rest: 0.0,
    life: ZoneLife {
        is_everywhere: false,
        grows: false,
        dissolves: false,
        rest_strain: 0.0,
        rest_share: 0.0,
        rest_strength: 0.0,
    },
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Job;

    const TRIAXIAL: &str = include_str!("../../tests/gate/triaxial.toml");
    const SHEAR: &str = include_str!("../../tests/gate/shear.toml");
    const POURED: &str = include_str!("../../tests/gate/poured.toml");

    fn of(text: &str, sets: &[&str]) -> String {
        let sets: Vec<String> = sets.iter().map(|set| set.to_string()).collect();
        match Job::parse(text, "job.toml", &sets).unwrap() {
            Job::Shear(job) => sheared(&job),
            Job::Assembly(job) => match &job.source {
                Source::Packed(of) => packed(&job, of),
                Source::File(_) => panic!("its grains are made"),
            },
            Job::Mpm(job) => specimen(&job, job.grains.as_deref().unwrap(), |_| None),
        }
    }

    /// Runs of one packing with other methods, loads, materials and outputs share it; another grain, law or size is another packing.
    #[test]
    fn jobs_share_a_packing_if_they_differ_in_nothing_that_makes_it() {
        let same: [(&str, &[&str]); 3] = [
            (
                SHEAR,
                &[
                    "name=other",
                    "method=mpm",
                    "loading.speed=0.1",
                    "material.cohesion=10",
                    "scheme.flip=0.5",
                    "enrichment.distance=5 mm",
                    "output.series_interval=1",
                    "packing.cache=elsewhere",
                ],
            ),
            (POURED, &["name=other", "time.end=1", "body.1.spin=3", "output.energy_balance=true", "damping.local=0.2"]),
            (
                TRIAXIAL,
                &[
                    "name=other",
                    "method=mpm",
                    "material.friction_angle_critical=0.4",
                    "oracle.every=10",
                    "time.end=1",
                    "body.1.velocity=[0, -0.3]",
                    "output.frame_interval=1",
                ],
            ),
        ];
        for (text, sets) in same {
            for set in sets {
                assert_eq!(of(text, &[*set]), of(text, &[]), "{set}");
            }
            assert_eq!(of(text, sets), of(text, &[]));
        }
        let other: [(&str, &[&str]); 3] = [
            (
                SHEAR,
                &[
                    "seed=2",
                    "grains.density=2600",
                    "contact.friction=0.4",
                    "packing.stress=300 kPa",
                    "specimen.height=39 mm",
                    "time.step=0.3 us",
                    "loading.plate_mass=0.01",
                ],
            ),
            (
                POURED,
                &[
                    "seed=2",
                    "contact.restitution=0.5",
                    "body.1.radius=1 mm",
                    "cell.gravity=[0, -5]",
                    "packing.friction=0.2",
                ],
            ),
            (
                TRIAXIAL,
                &[
                    "seed=2",
                    "membrane.0.pressure=90 kPa",
                    "body.1.seat=17 N",
                    "contact.friction=0.4",
                    "grains.count=310",
                    "material.bulk_modulus=90 MPa",
                ],
            ),
        ];
        for (text, sets) in other {
            for set in sets {
                assert_ne!(of(text, &[*set]), of(text, &[]), "{set}");
            }
        }
    }

    /// A packing is made without cohesion; contacts of a law that knows it remember more than those of one that does not.
    #[test]
    fn cohesion_is_not_of_the_packing() {
        let cohesive = |normal: &str| {
            of(
                SHEAR,
                &[
                    "contact.law=linear_cohesive",
                    &format!("contact.cohesion_normal={normal}"),
                    "contact.cohesion_tangential=1",
                ],
            )
        };
        assert_eq!(cohesive("1"), cohesive("2"));
        assert_ne!(cohesive("1"), of(SHEAR, &[]));
    }

    /// A packing's name hangs on what a job says, not on how the program calls it inside.
    #[test]
    fn recipes_are_written_as_jobs_are() {
        for text in [SHEAR, POURED, TRIAXIAL] {
            let recipe = of(text, &[]);
            assert!(recipe.contains("\n[contact]\nlaw = \"linear\"\n") && !recipe.contains('{'), "{recipe}");
        }
    }
}
