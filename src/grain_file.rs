//! Grains from a CSV file, held to the same bounds as grains of a job before any work is done (invariant 5).

use std::path::Path;

use crate::dem::grains::{GrainRow, Grains, Mover};
use crate::dem::neighbours::Neighbours;
use crate::dem::packing::{LOWER, UPPER, mass_of};
use crate::error::Error;
use crate::ids::GrainId;
use crate::packing::{cell_of, layout_for};
use crate::scenario::{Scenario, derived};
use crate::space::{Linear, Plane, Space, Words};

const HEADER: &str = "id,x,y,radius,vx,vy,spin";
/// Deepest overlap that a start may have, as a share of the smaller radius.
const OVERLAP_MAX: f64 = 0.5;

/// A file under examination: how it is named in messages, and the line of each grain.
struct Source<'a> {
    file: &'a Path,
    lines: Vec<usize>,
}

impl Source<'_> {
    fn bad(&self, line: usize, what: &str) -> Error {
        Error::User(format!("{}:{line}: {what}", self.file.display()))
    }
}

/// Grains of `id,x,y,radius,vx,vy,spin` in SI units, in the order of their ids. Centres below y = 0 are glued to the
/// lower plate, centres above `specimen.height` to the upper one.
pub fn read<M: Words<f64>>(scenario: &Scenario, file: &Path) -> Result<Vec<GrainRow<Plane, M>>, Error> {
    let text = std::fs::read_to_string(file).map_err(|error| {
        Error::User(format!("{}: {error}; `grains.file` must name a CSV file of grains", file.display()))
    })?;
    let mut source = Source { file, lines: Vec::new() };
    let mut lines = text.lines().enumerate();
    if lines.next().map(|(_, header)| header.trim()) != Some(HEADER) {
        return Err(source.bad(1, &format!("the first line must be `{HEADER}`")));
    }
    let mut grains = Vec::new();
    for (index, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let grain = parse(scenario, line).map_err(|what| source.bad(index + 1, &what))?;
        grains.push((grain, index + 1));
    }
    grains.sort_by_key(|(grain, _)| grain.cold.id);
    source.lines = grains.iter().map(|(_, line)| *line).collect();
    let grains: Vec<GrainRow<Plane, M>> = grains.into_iter().map(|(grain, _)| grain).collect();
    if !grains.iter().any(|grain| grain.cold.mover == Mover::Free) {
        return Err(
            source.bad(1, "there is no free grain in this file; export one from a run, or remove `grains.file`")
        );
    }
    refuse_repeated_ids(&source, &grains)?;
    refuse_heights(scenario, &source, &grains)?;
    refuse_sizes(scenario, &source, &grains)?;
    refuse_overlaps(scenario, &source, &grains)?;
    Ok(grains)
}

fn parse<M: Words<f64>>(scenario: &Scenario, line: &str) -> Result<GrainRow<Plane, M>, String> {
    let cells: Vec<&str> = line.split(',').map(str::trim).collect();
    if cells.len() != 7 {
        return Err(format!("{} values, 7 are wanted ({HEADER})", cells.len()));
    }
    let id: u64 = cells[0].parse().map_err(|_| format!("`{}` is not an id; whole numbers from 0 on are", cells[0]))?;
    let mut values = [0.0f64; 6];
    for (value, cell) in values.iter_mut().zip(&cells[1..]) {
        *value = cell
            .parse()
            .ok()
            .filter(|value: &f64| value.is_finite())
            .ok_or_else(|| format!("`{cell}` is not a finite number"))?;
    }
    let [x, y, radius, vx, vy, spin] = values;
    let width = scenario.specimen.width;
    if !(0.0..width).contains(&x) {
        return Err(format!("x = {x} m must be at least 0 and below specimen.width = {width} m"));
    }
    if radius <= 0.0 {
        return Err(format!("radius = {radius} m must be positive"));
    }
    let mover = if y < 0.0 {
        Mover::Body(LOWER)
    } else if y > scenario.specimen.height {
        Mover::Body(UPPER)
    } else {
        Mover::Free
    };
    let place = <Plane as Space>::Vector::new(x, y);
    let mut grain = GrainRow::resting(GrainId(id), place, radius, mass_of(scenario, radius), mover);
    grain.hot.velocity = <Plane as Space>::Vector::new(vx, vy);
    grain.hot.spin = <Plane as Space>::Spin::new(spin);
    Ok(grain)
}

fn refuse_repeated_ids<M: Words<f64>>(source: &Source, grains: &[GrainRow<Plane, M>]) -> Result<(), Error> {
    match grains.windows(2).position(|pair| pair[0].cold.id == pair[1].cold.id) {
        Some(at) => Err(source.bad(
            source.lines[at + 1],
            &format!("id {} stands in line {} already; ids must be unique", grains[at].cold.id.0, source.lines[at]),
        )),
        None => Ok(()),
    }
}

fn refuse_heights<M: Words<f64>>(
    scenario: &Scenario,
    source: &Source,
    grains: &[GrainRow<Plane, M>],
) -> Result<(), Error> {
    let [lower, upper] = layout_for(scenario, scenario.specimen.height)?.heights();
    let outside = |grain: &GrainRow<Plane, M>| !(lower..=upper).contains(&grain.hot.position[1]);
    match grains.iter().position(outside) {
        Some(at) => Err(source.bad(
            source.lines[at],
            &format!(
                "y = {} m lies outside the domain, which reaches from {lower:.4e} to {upper:.4e} m about plates at 0 and specimen.height = {} m",
                grains[at].hot.position[1], scenario.specimen.height
            ),
        )),
        None => Ok(()),
    }
}

/// Blocks must be wider than a contact reaches, and the step stable for the lightest grain.
fn refuse_sizes<M: Words<f64>>(
    scenario: &Scenario,
    source: &Source,
    grains: &[GrainRow<Plane, M>],
) -> Result<(), Error> {
    let by_radius = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1);
    let radii = || grains.iter().map(|grain| grain.hot.radius).enumerate();
    let (Some(smallest), Some(largest)) = (radii().min_by(by_radius), radii().max_by(by_radius)) else {
        return Ok(());
    };
    let block = scenario.decomposition.cells_per_block as f64 * scenario.continuum.cell;
    let reach = 2.0 * largest.1 + scenario.decomposition.skin;
    if reach > block {
        return Err(source.bad(
            source.lines[largest.0],
            &format!(
                "radius = {} m reaches {reach} m with its neighbours, but a block is {block} m wide; take larger continuum.cell or decomposition.cells_per_block",
                largest.1
            ),
        ));
    }
    let mut alike = scenario.clone();
    (alike.grains.diameter_mean, alike.grains.diameter_deviation) = (2.0 * smallest.1, 0.0);
    // Springs are taken with the lightest grain; a light grain cannot have six contacts, so dashpots are not.
    let bounds = derived::grain_bounds(&alike);
    let bound = derived::governing(&bounds[..2]);
    if scenario.time.step > bound.step {
        return Err(source.bad(
            source.lines[smallest.0],
            &format!(
                "a grain with radius = {} m is unstable with time.step = {} s; at most {:.3e} s ({})",
                smallest.1, scenario.time.step, bound.step, bound.cause
            ),
        ));
    }
    Ok(())
}

fn refuse_overlaps<M: Words<f64>>(
    scenario: &Scenario,
    source: &Source,
    grains: &[GrainRow<Plane, M>],
) -> Result<(), Error> {
    let all = Grains::<Plane> {
        hot: grains.iter().map(|grain| grain.hot).collect(),
        cold: grains.iter().map(|grain| grain.cold).collect(),
        owned: grains.len(),
        ..Grains::default()
    };
    let cell = cell_of(&layout_for(scenario, scenario.specimen.height)?);
    let mut neighbours = Neighbours::default();
    neighbours.build(&all, &cell, 0.0);
    for (_, pair) in neighbours.real_pairs() {
        let (a, b) = (&all.hot[pair.a as usize], &all.hot[pair.b() as usize]);
        let separation = a.position - b.position + cell.shift(pair.image().image());
        let overlap = a.radius + b.radius - separation.norm();
        let share = overlap / a.radius.min(b.radius);
        if share > OVERLAP_MAX {
            return Err(source.bad(
                source.lines[pair.b() as usize],
                &format!(
                    "this grain overlaps the one in line {} by {:.0} % of the smaller radius; at most {:.0} % can be started from",
                    source.lines[pair.a as usize],
                    100.0 * share,
                    100.0 * OVERLAP_MAX
                ),
            ));
        }
    }
    Ok(())
}

/// stub
pub fn read_assembly<S: Space, M: Words<f64>>(
    job: &crate::scenario::assembly::Assembly,
    file: &Path,
) -> Result<Vec<GrainRow<S, M>>, Error> {
    let text = std::fs::read_to_string(file).map_err(|error| {
        Error::User(format!("{}: {error}; `grains.file` must name a CSV file of grains", file.display()))
    })?;
    let mut grains = Vec::new();
    for line in text.lines().skip(1).filter(|line| !line.trim().is_empty()) {
        let v: Vec<f64> = line.split(',').map(|cell| cell.trim().parse().unwrap()).collect();
        let d = S::DIMENSION;
        let mut position = S::Vector::zero();
        for axis in 0..d {
            position[axis] = v[1 + axis];
        }
        let radius = v[1 + d];
        let mass = job.matter.density * S::grain_volume(radius, job.cell.depth);
        let mut row = GrainRow::<S, M>::resting(GrainId(v[0] as u64), position, radius, mass, Mover::Free);
        for axis in 0..d {
            row.hot.velocity[axis] = v[2 + d + axis];
        }
        for axis in 0..S::Spin::COMPONENTS {
            row.hot.spin[axis] = v[2 + 2 * d + axis];
        }
        grains.push(row);
    }
    grains.sort_by_key(|grain| grain.cold.id);
    Ok(grains)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(rows: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("grains.csv");
        std::fs::write(&file, format!("{HEADER}\n{rows}")).unwrap();
        let job = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("jobs/quickstart.toml");
        let scenario = Scenario::load(&job, &["method=dem".into()]).unwrap();
        let message = read::<crate::space::Components<f64, 1>>(&scenario, &file)
            .map(|grains| format!("{} grains", grains.len()))
            .unwrap_or_else(|error| {
                assert_eq!(error.exit_code(), 2);
                error.to_string()
            });
        message.replace(&format!("{}:", file.display()), "")
    }

    #[test]
    fn what_a_job_may_not_say_a_grain_file_may_not_either() {
        assert_eq!(refusal("0,0.01,0.02,0.0005,0,0,0\n1,0.012,-0.001,0.0005,0,0,0\n"), "2 grains");
        for (rows, wanted) in [
            ("", "1: there is no free grain"),
            ("0,0.01,0.02,0.0005,0,0\n", "2: 6 values, 7 are wanted"),
            ("0,0.01,nan,0.0005,0,0,0\n", "2: `nan` is not a finite number"),
            ("0,0.03,0.02,0.0005,0,0,0\n", "2: x = 0.03 m must be at least 0 and below specimen.width = 0.024 m"),
            ("0,0.01,0.02,-1,0,0,0\n", "2: radius = -1 m must be positive"),
            ("7,0.01,0.02,0.0005,0,0,0\n7,0.02,0.02,0.0005,0,0,0\n", "3: id 7 stands in line 2 already"),
            ("0,0.01,0.02,0.0005,0,0,0\n1,0.01,5,0.0005,0,0,0\n", "3: y = 5 m lies outside the domain"),
            ("0,0.01,0.02,0.0055,0,0,0\n", "2: radius = 0.0055 m reaches"),
            ("0,0.01,0.02,0.00001,0,0,0\n", "2: a grain with radius = 0.00001 m is unstable"),
            (
                "1,0.0238,0.02,0.0005,0,0,0\n0,0.0001,0.02,0.0005,0,0,0\n",
                "2: this grain overlaps the one in line 3 by 140 %",
            ),
        ] {
            let found = refusal(rows);
            assert!(found.starts_with(wanted), "{rows:?}: {found}");
        }
    }
}
