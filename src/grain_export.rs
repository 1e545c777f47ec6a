//! Grains of a state as text for other programs.

use std::path::Path;

use scree_io::column::State;

use crate::checkpoint::scenario_of;
use crate::dem::cell::Cell;
use crate::dem::grains::GrainRow;
use crate::error::Error;
use crate::scenario::Job;
use crate::space::{Components, Linear, Plane, Solid, Space};
use crate::transfer::Cargo;
use crate::{assembly, packing, tables};

/// Writes the grains of a state as CSV, 17 significant digits. Velocities are those of half a step before the time of the
/// positions.
pub fn write(state: &State, dir: &Path, file: &Path) -> Result<(), Error> {
    let job = Job::parse(&scenario_of(state)?, &dir.display().to_string(), &[])?;
    let text = match &job {
        Job::Shear(scenario) => {
            let layout = packing::layout_for(scenario, scenario.specimen.height)?;
            csv::<Plane>(state, &packing::cell_of(&layout), dir)?
        }
        Job::Assembly(job) if job.cell.dimension == 2 => csv(state, &cell::<Plane>(state, job)?, dir)?,
        Job::Assembly(job) => csv(state, &cell::<Solid>(state, job)?, dir)?,
    };
    std::fs::write(file, text).map_err(|error| Error::Run(format!("{}: {error}", file.display())))
}

/// The cell as the state left it.
fn cell<S: Space>(state: &State, job: &crate::scenario::Assembly) -> Result<Cell<S>, Error> {
    let mut cell = assembly::setup::cell_of::<S>(job);
    if let [moved] = &tables::rows(state, "cell", &cell)?[..] {
        cell.take_motion_of(moved);
    }
    Ok(cell)
}

fn csv<S: Space>(state: &State, cell: &Cell<S>, dir: &Path) -> Result<String, Error> {
    let mut grains: Vec<GrainRow<S, Components<f64, 1>>> = tables::rows(state, "grains", &GrainRow::blank())?;
    if grains.is_empty() {
        return Err(Error::User(format!(
            "{}: this state has no grains; a hybrid run has them after enrichment only",
            dir.display()
        )));
    }
    grains.sort_unstable_by_key(|grain| grain.cold.id);
    let mut text = String::from(header::<S>());
    text.push('\n');
    for grain in &mut grains {
        let hot = &mut grain.hot;
        cell.wrap(&mut hot.position, &mut hot.velocity);
        let place = (0..S::DIMENSION).map(|axis| hot.position[axis]);
        let motion = (0..S::DIMENSION).map(|axis| hot.velocity[axis]);
        let spin = (0..S::Spin::COMPONENTS).map(|axis| hot.spin[axis]);
        text.push_str(&grain.cold.id.0.to_string());
        for number in place.chain([hot.radius]).chain(motion).chain(spin) {
            text.push_str(&format!(",{number:.16e}"));
        }
        text.push('\n');
    }
    Ok(text)
}

/// First line of a CSV file of grains.
pub fn header<S: Space>() -> &'static str {
    match S::DIMENSION {
        2 => "id,x,y,radius,vx,vy,spin",
        _ => "id,x,y,z,radius,vx,vy,vz,wx,wy,wz",
    }
}
