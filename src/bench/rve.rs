//! How long a grain-step takes in representative volume elements: many assemblies, each driven by increments of a few steps of their
//! grains, all told, beside the grains of a large packing ([`super::dem`]) in turns.

use std::time::Instant;

use rayon::prelude::*;
use scree_partition::Transport;

use super::{Stretches, dem, resident_bytes};
use crate::base::error::Error;
use crate::base::space::{Plane, Solid, Space};
use crate::job::{Assembly, Job};
use crate::prepare::grain_world;
use crate::rve::{Drive, Pace, Rve, Scratch};

/// What is measured.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// RVEs.
    pub elements: u64,
    /// Grains of each.
    pub grains: u64,
    /// In space instead of the plane.
    pub solid: bool,
    /// Steps of grains in an increment.
    pub sub_steps: u64,
    /// Steps are those of grains.
    pub stretches: Stretches,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Measured {
    /// "plane" or "solid".
    pub space: &'static str,
    /// RVEs.
    pub elements: u64,
    /// Grains of each RVE.
    pub grains: u64,
    /// Wall time of a grain's step, every stretch, ns.
    pub rve: Vec<f64>,
    /// The same of the large packing, after each of these.
    pub packing: Vec<f64>,
    /// Resident memory that the RVEs and their first increments took, bytes, over all their grains.
    pub bytes_resident_per_grain: f64,
    /// Contacts that bear in the first RVE at the end, each counted once, over its grains.
    pub contacts_per_grain: f64,
    /// Deviator over pressure at the end: RVEs that are sheared.
    pub stress_ratio: f64,
}

impl Measured {
    /// The median of how much longer a step takes in RVEs than in the packing, stretch by stretch.
    pub fn ratio(&self) -> f64 {
        let mut ratios: Vec<f64> = self.rve.iter().zip(&self.packing).map(|(rve, packing)| rve / packing).collect();
        ratios.sort_by(f64::total_cmp);
        ratios[ratios.len() / 2]
    }
}

/// Shear strain of a step: an inertial number of some 2e-4.
const STRAIN: f64 = 4e-6;
/// Steps before the first stretch.
const WARM_UP: u64 = 200;
/// Grains of the packing that is measured beside them.
const BESIDE: [u64; 2] = [7640, 100_000];

/// Runs the measurement on one rank, RVEs in turns with the large packing.
pub fn measure(wanted: &Wanted, transport: &dyn Transport) -> Result<Measured, Error> {
    match wanted.solid {
        false => measured::<Plane>(wanted, transport),
        true => measured::<Solid>(wanted, transport),
    }
}

/// Discs of Liang & Zhao (2019), Table 1, or the spheres of [`super::dem`], with a packing that is kept where that of `bench dem` is.
fn job<S: Space>(grains: u64) -> Result<Assembly, Error> {
    let mut job = match S::DIMENSION {
        2 => discs(grains)?,
        _ => dem::job::<S>(grains)?,
    };
    dem::keep_packing(&mut job);
    Ok(job)
}

fn discs(grains: u64) -> Result<Assembly, Error> {
    let text = format!(
        r#"
        name = "rve"
        [cell]
        space = "plane"
        upper = [{edge:?}, {edge:?}]
        depth = "10 cm"
        [grains]
        density = "2650 kg/m3"
        count = {grains}
        distribution = "uniform"
        diameter_min = "6 mm"
        diameter_max = "14 mm"
        [packing]
        preparation = "compress"
        stress = "100 kPa"
        energy_ratio_max = 1e-3
        [contact]
        law = "elastic_rolling"
        young_modulus = "600 MPa"
        stiffness_ratio = 0.8
        friction = 0.545
        [damping]
        local = 0.1
        form = "component"
        [time]
        end = "1 s"
        "#,
        edge = (grains as f64 * 1e-4).sqrt()
    );
    Ok(Job::parse(&text, "bench", &[])?.as_assembly().expect("the text has a [cell]").clone())
}

fn measured<S: Space>(wanted: &Wanted, transport: &dyn Transport) -> Result<Measured, Error> {
    let template = grain_world::volume_element::<S>(&job::<S>(wanted.grains)?, transport)?;
    let resident = resident_bytes();
    let mut elements: Vec<Rve<S>> = (0..wanted.elements).map(|_| template.clone()).collect();
    let duration = wanted.sub_steps as f64 * template.sample().constants.dt;
    let drive = Drive { pace: Pace::Synchronous, steps_min: wanted.sub_steps, relaxation: None };
    let mut increments = 0u64;
    let mut ratio = 0.0;
    let mut go_on = |elements: &mut [Rve<S>], count: u64| -> Result<(), Error> {
        for _ in 0..count {
            increments += 1;
            let gamma = STRAIN * (increments * wanted.sub_steps) as f64;
            let each = |scratch: &mut Scratch<S>, (number, rve): (usize, &mut Rve<S>)| {
                // No two go the same way, as no two points do.
                let mut deformation = S::identity();
                deformation[S::DIMENSION] = gamma * (1.0 + 1e-3 * number as f64 / wanted.elements as f64);
                rve.follow(&deformation, duration, &drive, scratch)
            };
            let answers: Result<Vec<_>, Error> =
                elements.par_iter_mut().enumerate().map_init(Scratch::default, each).collect();
            ratio = answers?.first().map_or(0.0, |answer| answer.deviator_over_pressure());
        }
        Ok(())
    };
    go_on(&mut elements, WARM_UP.div_ceil(wanted.sub_steps))?;
    let bytes = (resident_bytes() - resident) as f64 / (wanted.elements * wanted.grains) as f64;
    let per_increment = wanted.elements * wanted.grains * wanted.sub_steps;
    let count = (wanted.stretches.steps / per_increment).max(1);
    let beside = dem::Wanted {
        grains: BESIDE[S::DIMENSION - 2],
        solid: wanted.solid,
        stretches: Stretches { steps: (wanted.stretches.steps / BESIDE[S::DIMENSION - 2]).max(10), ..wanted.stretches },
    };
    let mut world = dem::warm::<S>(&beside, transport)?;
    let (mut rve, mut packing) = (Vec::new(), Vec::new());
    for _ in 0..wanted.stretches.count {
        let begun = Instant::now();
        go_on(&mut elements, count)?;
        rve.push(1e9 * begun.elapsed().as_secs_f64() / (count * per_increment) as f64);
        let begun = Instant::now();
        for _ in 0..beside.stretches.steps {
            world.advance()?;
        }
        packing.push(1e9 * begun.elapsed().as_secs_f64() / (beside.stretches.steps * world.grains_total) as f64);
    }
    let observed = elements[0].observe(&mut Scratch::default());
    Ok(Measured {
        space: S::NAME,
        elements: wanted.elements,
        grains: wanted.grains,
        rve,
        packing,
        bytes_resident_per_grain: bytes,
        contacts_per_grain: 0.5 * observed.fabric.coordination,
        stress_ratio: ratio,
    })
}
