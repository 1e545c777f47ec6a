//! Small packings from start to end.

use scree_partition::Solo;
use scree_partition::transport::threads;

use super::*;
use crate::law::contact::LinearSpringDashpot;
use crate::scenario::Job;
use crate::scenario::assembly::Source;
use crate::space::{Linear, Plane, Solid};

const DISCS: &str = r#"
name = "discs"
seed = 5
[cell]
space = "plane"
lower = ["-2 mm", "3 mm"]
upper = ["14 mm", "15 mm"]
depth = "1 cm"
[grains]
density = "2500 kg/m3"
count = 200
diameter_mean = "1 mm"
diameter_deviation = "0.1 mm"
[packing]
preparation = "compress"
stress = "1 MPa"
energy_ratio_max = 1e-3
[contact]
law = "linear"
stiffness_normal = "1000 kN/m"
stiffness_tangential = "500 kN/m"
restitution = 0.3
friction = 0.5
[time]
step = "0.4 us"
end = "1 ms"
"#;

fn job(text: &str, sets: &[&str], folder: &Path) -> Assembly {
    let cache = format!("packing.cache={}", folder.display());
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).chain([cache]).collect();
    match Job::parse(text, "job.toml", &sets) {
        Ok(Job::Assembly(job)) => job,
        other => panic!("{other:?}"),
    }
}

fn made<S: Space>(job: &Assembly, transport: &dyn Transport) -> Result<Packing<S, LinearSpringDashpot>, Error>
where
    LinearSpringDashpot: ContactLaw<S>,
{
    let Source::Packed(packed) = &job.source else { panic!("the job makes its grains") };
    make(job, packed, transport)
}

#[test]
fn probe() {
    let folder = tempfile::tempdir().unwrap();
    let sets = std::env::var("SETS").unwrap_or_default();
    let sets: Vec<&str> = sets.split(';').filter(|set| !set.is_empty()).collect();
    let text = std::env::var("JOB").ok().map(|file| std::fs::read_to_string(file).unwrap());
    let job = job(text.as_deref().unwrap_or(DISCS), &sets, folder.path());
    let start = std::time::Instant::now();
    struct Go<'a>(&'a Assembly, std::time::Instant);
    impl crate::law::contact::ForAnyLaw for Go<'_> {
        type Outcome = ();
        fn with<C: ContactLaw<Plane> + ContactLaw<Solid>>(self) {
            if self.0.cell.dimension == 2 { go::<Plane, C>(self.0, self.1) } else { go::<Solid, C>(self.0, self.1) }
        }
    }
    fn go<S: Space, C: ContactLaw<S>>(job: &Assembly, start: std::time::Instant) {
        let Source::Packed(packed) = &job.source else { panic!("the job makes its grains") };
        match make::<S, C>(job, packed, &Solo) {
            Ok(packing) => {
                let world = setup::world::<S, C>(job, &Solo).unwrap();
                eprintln!("{:?} {:?} {}", start.elapsed(), packing.cell.edges, setup::fraction(&world, job).unwrap());
            }
            Err(error) => eprintln!("{:?} {error}", start.elapsed()),
        }
    }
    crate::law::contact::with_law_of(&job.contact, Go(&job, start));
}
