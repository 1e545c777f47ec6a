//! How long a point-step takes: a periodic block of material with friction under pressure, sheared by a wave of velocity so
//! that it yields, the whole step with its rebuilds and messages.

use scree_partition::{ExactSum, Transport};

use super::{Speed, Stretches, resident_bytes};
use crate::base::error::Error;
use crate::base::space::{Plane, Solid, Space};
use crate::job::{Job, Mpm};
use crate::mpm::stress::material_of;
use crate::prepare::point_world;

/// What is measured.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// About as many: whole blocks of cells are filled.
    pub points: u64,
    /// In space instead of the plane.
    pub solid: bool,
    /// The material law: `critical_drucker_prager` or `mobilised_friction`.
    pub law: String,
    /// Shape functions, stress update and transfer, as a job names them.
    pub shape: String,
    /// `scheme.update` of the job: "first", "last" or "modified_last".
    pub update: String,
    /// `scheme.transfer` of the job: "blend" or "affine".
    pub transfer: String,
    /// A step is one of every point.
    pub stretches: Stretches,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Of the block once its start is forgotten.
    pub speed: Speed,
    /// Mean plastic strain at the end: a yielding material, not an elastic one.
    pub plastic_strain: f64,
}

/// Points per cell and axis.
const PER_CELL: f64 = 2.0;
/// Steps before the first stretch, so that the start is forgotten.
const WARM_UP: u64 = 50;
/// Whole blocks, so that every axis can be periodic.
const BLOCK: [u64; 2] = [8, 4];

/// Runs the measurement on all ranks.
pub fn measure(wanted: &Wanted, transport: &dyn Transport) -> Result<Measured, Error> {
    match wanted.solid {
        false => measured::<Plane>(wanted, transport),
        true => measured::<Solid>(wanted, transport),
    }
}

/// The keys that the law has alone.
fn own_keys(law: &str) -> &'static str {
    match law {
        "mobilised_friction" => {
            "shear_modulus_degradation = 0.3\nshear_degradation_strain = 1e-3\nhardening_strain = 3e-4\nphase_transformation_factor = 3"
        }
        _ => "softening_rate = 3",
    }
}

fn job<S: Space>(wanted: &Wanted) -> Result<Mpm, Error> {
    let edge = match S::DIMENSION {
        2 => (wanted.points as f64).sqrt(),
        _ => crate::base::math::cbrt(wanted.points as f64),
    };
    let block = BLOCK[S::DIMENSION - 2];
    let cells = ((edge / PER_CELL / block as f64).round() as u64).max(2) * block;
    let all = |value: &str| format!("[{}]", vec![value; S::DIMENSION].join(", "));
    let length = format!("\"{cells} cm\"");
    let along = |first: &str, second: &str| {
        if S::DIMENSION == 2 { format!("[{first}, {second}]") } else { format!("[{first}, {second}, 0]") }
    };
    let text = format!(
        r#"
        name = "bench"
        [grid]
        space = "{space}"
        lower = {zero}
        upper = {upper}
        cell = "1 cm"
        periodic = {periodic}
        [scheme]
        shape = "{shape}"
        update = "{update}"
        transfer = "{transfer}"
        points_per_cell = 2
        [material]
        law = "{law}"
        density = "2000 kg/m3"
        bulk_modulus = "20 MPa"
        shear_modulus = "10 MPa"
        friction_angle_critical = "25 deg"
        fraction = 0.84
        fraction_critical = 0.8
        dilation_factor = 3
        cohesion = "1 kPa"
        {own}
        [[region]]
        shape = "box"
        lower = {zero}
        upper = {upper}
        wave = [{{direction = {y}, length = {length}, amplitude = {amplitude}}}]
        [stress]
        kind = "isotropic"
        pressure = "100 kPa"
        [time]
        end = "100 s"
        [decomposition]
        cells_per_block = {block}
        "#,
        law = wanted.law,
        own = own_keys(&wanted.law),
        space = S::NAME,
        zero = all("0"),
        upper = all(&length),
        periodic = all("true"),
        shape = wanted.shape,
        update = wanted.update,
        transfer = wanted.transfer,
        y = along("0", "1"),
        amplitude = along("\"5 m/s\"", "0"),
    );
    Ok(Job::parse(&text, "bench", &[])?.as_mpm().expect("the text has a [grid]").clone())
}

fn measured<S: Space>(wanted: &Wanted, transport: &dyn Transport) -> Result<Measured, Error> {
    let resident = resident_bytes();
    let job = job::<S>(wanted)?;
    let mut world = point_world::world::<S>(&job, &material_of(&job.material.law), transport)?;
    for _ in 0..WARM_UP.min(wanted.stretches.steps) {
        world.advance()?;
    }
    let speed = Speed::of(&mut world, wanted.stretches, resident, transport)?;
    let mut strain = ExactSum::<1>::new();
    for hot in &world.continuum.points.hot {
        strain.add(0, world.settings.material.plastic_strain(&hot.memory));
    }
    let plastic_strain = world.reduce(strain)?[0] / speed.rows as f64;
    Ok(Measured { speed, plastic_strain })
}
