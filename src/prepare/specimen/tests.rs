//! A small specimen between plates and membranes.

use scree_partition::Solo;

use super::*;
use crate::domain::stop::lives;
use crate::job::Job;
use crate::law::contact::LinearSpringDashpot as Law;

const TRIAXIAL: &str = r#"
name = "small"
method = "dem"
[grid]
space = "plane"
upper = ["48 mm", "36 mm"]
cell = "3 mm"
[scheme]
flip = 0.95
[material]
law = "critical_drucker_prager"
bulk_modulus = "86.4 MPa"
shear_modulus = "39.3 MPa"
friction_angle_critical = "0.35 rad"
fraction_critical = 0.815
fraction = 0.842
dilation_factor = 5
softening_rate = 10
[stress]
kind = "isotropic"
pressure = "100 kPa"
[[region]]
shape = "box"
lower = ["15 mm", "6 mm"]
upper = ["24 mm", "9 mm"]
fraction = 0.816
[[region]]
shape = "box"
lower = ["15 mm", 0]
upper = ["24 mm", "15 mm"]
[[boundary]]
face = "x_lower"
kind = "free"
[[boundary]]
face = "x_upper"
kind = "free"
[[boundary]]
face = "y_lower"
kind = "free"
[[boundary]]
face = "y_upper"
kind = "free"
[[body]]
name = "base"
shape = "plane"
point = [0, 0]
normal = [0, 1]
contact = "rough"
[[body]]
name = "plate"
shape = "plane"
point = [0, "15 mm"]
normal = [0, -1]
velocity = [0, "-20 cm/s"]
ramp = "0.2 ms"
contact = "smooth"
seat = "9 N"
[[membrane]]
name = "left"
shape = "line"
from = ["15 mm", "15 mm"]
to = ["15 mm", 0]
stiffness = "10 kN/m"
damping = "1 N s/m"
tension = "0.5 N"
pressure = "100 kPa"
[[membrane]]
name = "right"
shape = "line"
from = ["24 mm", 0]
to = ["24 mm", "15 mm"]
stiffness = "10 kN/m"
damping = "1 N s/m"
tension = "0.5 N"
pressure = "100 kPa"
[grains]
density = 2530
count = 80
diameter_mean = "1 mm"
diameter_deviation = "0.08 mm"
[contact]
stiffness_normal = 1772093.8
stiffness_tangential = 886046.9
damping_normal = 3.5
damping_tangential = 3.5
friction = 0.5
[packing]
preparation = "compress"
stress = "100 kPa"
energy_ratio_max = 1e-2
cache = "cache"
[time]
step = "0.4 us"
grain_steps = 4
end = 1e-3
[decomposition]
cells_per_block = 4
"#;

/// The specimen of a job with a cache of its own, and in how many lives of so many steps it has been made.
fn made(steps: u64) -> (String, u64) {
    let folder = tempfile::tempdir().unwrap();
    let cache = [format!("packing.cache={}", folder.path().display())];
    let Ok(Job::Mpm(job)) = Job::parse(TRIAXIAL, "job.toml", &cache) else { panic!("a job on a grid") };
    let granular = job.grains.as_deref().unwrap();
    let (made, lives) = lives::of(steps, || specimen::<Law>(&job, granular, &Solo));
    let moved: Vec<Vector> = made.bodies.iter().map(|body| body.displacement).collect();
    (format!("{:?} {moved:?} {:?}", made.grains, made.vertices), lives)
}

/// Piece and specimen, with seats that take several attempts: whatever looks have set is saved with them.
#[test]
fn a_specimen_in_short_lives_is_that_of_one_life() {
    let (wanted, _) = made(u64::MAX);
    let (found, lives) = made(9973);
    assert!(lives > 10, "{lives} lives");
    assert!(found == wanted, "another specimen after {lives} lives");
}
