//! From what was typed to what it means: defaults filled in, every number within its range, and the checks that need more
//! than one key. Tables that the method leaves asleep take the values of seed 000, so that nothing later is optional.

use std::path::{Path, PathBuf};

use super::raw::{Job, Reader};
use super::{
    Contact, Continuum, Decomposition, Enrichment, Grains, Loading, Method, Oracle, Output, Packing, Scenario,
    Specimen, Time, WeakRegion, derived,
};
use crate::error::Error;

const DEPTH_DEFAULT: f64 = 0.01;
/// Cundall 1989.
const PACKING_FRICTION_DEFAULT: f64 = 0.01;
/// Thrown without overlap one after the other, discs jam at 0.547.
const PACKING_FRACTION_DEFAULT: f64 = 0.45;
const PACKING_ENERGY_RATIO_DEFAULT: f64 = 1e-4;
const FLIP_DEFAULT: f64 = 0.95;
/// Skin of the neighbour list in mean diameters.
const SKIN_DEFAULT: f64 = 0.1;
/// Edge of a block in mean diameters where only grains ask for blocks.
const BLOCK_OF_GRAINS: f64 = 12.0;
/// Looks of the oracle within its recent window when a band one cell thick takes the whole speed.
const LOOKS_PER_WINDOW: f64 = 16.0;
/// Rows, frames and checkpoints of a run.
const ROWS_DEFAULT: f64 = 500.0;
const FRAMES_DEFAULT: f64 = 20.0;
const CHECKPOINTS_DEFAULT: f64 = 10.0;
/// How exactly the cells must fill the width.
const FIT_TOLERANCE: f64 = 1e-9;

/// The checked scenario of a job; `file` is the job's path, whose folder relative paths start from.
pub fn scenario(job: &Job, file: &str) -> Result<Scenario, Error> {
    let top = job.table("", true, "a job")?;
    let method = method(&top)?;
    let why = format!("method = \"{}\"", method.name());
    let folder = folder_of(file);

    let specimen = specimen(&job.table("specimen", true, &why)?)?;
    let grains = grains(&job.table("grains", true, &why)?, &folder)?;
    let loading_table = job.table("loading", true, &why)?;
    let stress_normal = loading_table.number("stress_normal")?;
    let speed = loading_table.number("speed")?;
    let step = job.table("time", true, &why)?.number("step")?;

    let fraction_start = job.table("continuum", method.has_points(), &why)?.number_if_given("fraction_start")?;
    let packed = method.has_grains() || fraction_start.is_none();
    let why_packed = match method.has_grains() {
        true => why.clone(),
        false => format!("{why} without continuum.fraction_start makes a packing, which"),
    };
    let contact = contact(&job.table("contact", packed, &why_packed)?)?;
    let packing = packing(&job.table("packing", false, &why)?, stress_normal, &folder)?;
    let cut = job.table("decomposition", false, &why)?;
    let decomposition = Decomposition {
        cells_per_block: cut.count_or("cells_per_block", 2)? as usize,
        skin: cut.number_or("skin", SKIN_DEFAULT * grains.diameter_mean)?,
    };
    let continuum =
        continuum(&job.table("continuum", method.has_points(), &why)?, &specimen, &grains, &contact, &decomposition)?;
    let oracle = oracle(&job.table("oracle", method == Method::Hybrid, &why)?, continuum.cell / (speed * step))?;
    let enrichment =
        enrichment(&job.table("enrichment", method == Method::Hybrid, &why)?, 22.0 * grains.diameter_mean)?;

    let mut scenario = Scenario {
        name: name(&top)?,
        method,
        seed: top.count_or("seed", 1)?,
        specimen,
        grains,
        contact,
        packing,
        continuum,
        loading: Loading {
            stress_normal,
            speed,
            speed_ramp: loading_table.number("speed_ramp")?,
            strain_end: loading_table.number("strain_end")?,
            plate_mass: 0.0,
            plate_damping: 0.0,
        },
        oracle,
        enrichment,
        time: Time { step },
        decomposition,
        output: Output { series_interval: 0.0, frame_interval: 0.0, checkpoint_interval: 0.0, checkpoints_kept: 0 },
    };
    fill_plate(&mut scenario, &loading_table)?;
    fill_output(&mut scenario, &job.table("output", false, &why)?)?;
    check_together(&scenario, job)?;
    Ok(scenario)
}

fn method(top: &Reader<'_>) -> Result<Method, Error> {
    match top.text("method")? {
        "hybrid" => Ok(Method::Hybrid),
        "dem" => Ok(Method::Dem),
        "mpm" => Ok(Method::Mpm),
        _ => Err(top.refusal("method", "is no method: write \"hybrid\", \"dem\" or \"mpm\".")),
    }
}

/// The name becomes a folder, so it keeps to letters that every file system takes.
fn name(top: &Reader<'_>) -> Result<String, Error> {
    let name = top.text("name")?;
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
    if name.chars().all(plain) && name.starts_with(|c: char| c.is_ascii_alphanumeric()) && name.len() <= 100 {
        return Ok(name.to_string());
    }
    Err(top.refusal(
        "name",
        "is refused: it names the run's folder, so write letters, digits, \"_\", \"-\" and \".\" only, a letter or digit first.",
    ))
}

fn folder_of(file: &str) -> PathBuf {
    let folder = Path::new(file).parent().unwrap_or(Path::new(""));
    let folder = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf())
}

fn specimen(table: &Reader<'_>) -> Result<Specimen, Error> {
    Ok(Specimen {
        width: table.number("width")?,
        height: table.number("height")?,
        depth: table.number_or("depth", DEPTH_DEFAULT)?,
    })
}

fn grains(table: &Reader<'_>, folder: &Path) -> Result<Grains, Error> {
    let grains = Grains {
        diameter_mean: table.number("diameter_mean")?,
        diameter_deviation: table.number("diameter_deviation")?,
        density: table.number("density")?,
        file: table.text_if_given("file")?.map(|path| folder.join(path)),
    };
    if grains.diameter_deviation > 0.25 * grains.diameter_mean {
        return Err(table.refusal(
            "diameter_deviation",
            &format!(
                "is too wide: sizes are cut at three deviations, and the smallest must keep a quarter of the mean. Write at most \"{} mm\".",
                digits(250.0 * grains.diameter_mean)
            ),
        ));
    }
    Ok(grains)
}

/// Asleep: Table 1 of seed 000, with the damping that is stable.
fn contact(table: &Reader<'_>) -> Result<Contact, Error> {
    Ok(Contact {
        stiffness_normal: table.number_awake("stiffness_normal", 1_772_093.8)?,
        stiffness_tangential: table.number_awake("stiffness_tangential", 886_046.9)?,
        damping_normal: table.number_awake("damping_normal", 3.5)?,
        damping_tangential: table.number_awake("damping_tangential", 3.5)?,
        friction: table.number_awake("friction", 0.5)?,
    })
}

fn packing(table: &Reader<'_>, stress: f64, folder: &Path) -> Result<Packing, Error> {
    let cache = table.text_if_given("cache")?.unwrap_or("cache");
    Ok(Packing {
        friction: table.number_or("friction", PACKING_FRICTION_DEFAULT)?,
        fraction_start: table.number_or("fraction_start", PACKING_FRACTION_DEFAULT)?,
        stress: table.number_or("stress", stress)?,
        energy_ratio_max: table.number_or("energy_ratio_max", PACKING_ENERGY_RATIO_DEFAULT)?,
        cache: folder.join(cache),
    })
}

/// Asleep: moduli of the contact law, Table 2 of seed 000 for the rest, and cells that make blocks fit for grains.
fn continuum(
    table: &Reader<'_>,
    specimen: &Specimen,
    grains: &Grains,
    contact: &Contact,
    decomposition: &Decomposition,
) -> Result<Continuum, Error> {
    let fraction_start = table.number_if_given("fraction_start")?;
    let fraction = fraction_start.unwrap_or(derived::FRACTION_DENSE);
    let moduli = derived::moduli_affine(contact, fraction, specimen.depth);
    let cells_per_block = decomposition.cells_per_block as f64;
    let blocks = (specimen.width / (BLOCK_OF_GRAINS * grains.diameter_mean)).floor();
    let cell_of_grains = specimen.width / (blocks.max(2.0) * cells_per_block);
    let cell = table.number_awake("cell", cell_of_grains)?;
    Ok(Continuum {
        bulk_modulus: table.number_awake("bulk_modulus", moduli.bulk)?,
        shear_modulus: table.number_awake("shear_modulus", moduli.shear)?,
        friction_angle_critical: table.number_awake("friction_angle_critical", 0.27)?,
        fraction_critical: table.number_awake("fraction_critical", 0.815)?,
        dilation_factor: table.number_awake("dilation_factor", 7.0)?,
        softening_rate: table.number_awake("softening_rate", 0.01)?,
        cohesion: table.number_or("cohesion", 0.0)?,
        fraction_start,
        cell: fitted_cell(table, cell, specimen.width, decomposition.cells_per_block)?,
        points_per_cell: table.count_or("points_per_cell", 2)? as usize,
        flip: table.number_or("flip", FLIP_DEFAULT)?,
        weak: weak_regions(table, specimen)?,
    })
}

/// The width over a whole number of cells, which the typed cell must equal to within rounding.
fn fitted_cell(table: &Reader<'_>, cell: f64, width: f64, cells_per_block: usize) -> Result<f64, Error> {
    let cells = width / cell;
    let per_block = cells_per_block as f64;
    let blocks = (cells / per_block).round();
    let fits = (cells - blocks * per_block).abs() <= FIT_TOLERANCE * cells;
    if fits && blocks >= 2.0 {
        return Ok(width / (blocks * per_block));
    }
    let below = (cells / per_block).floor().max(2.0);
    let choices: Vec<String> = [below, below + 1.0]
        .iter()
        .map(|blocks| {
            let cells = blocks * per_block;
            format!("\"{} mm\" ({cells} cells)", digits(1e3 * width / cells))
        })
        .collect();
    Err(table.refusal(
        "cell",
        &format!(
            "does not fit: blocks of {cells_per_block} cells (decomposition.cells_per_block) must fill specimen.width = {} mm exactly, at least two of them. Write {}.",
            digits(1e3 * width),
            choices.join(" or ")
        ),
    ))
}

fn weak_regions(table: &Reader<'_>, specimen: &Specimen) -> Result<Vec<WeakRegion>, Error> {
    let regions = table.regions("weak")?;
    regions
        .iter()
        .map(|region| {
            let weak = WeakRegion {
                lower: region.corner("lower")?,
                upper: region.corner("upper")?,
                fraction_deficit: region.number("fraction_deficit")?,
            };
            let size = [specimen.width, specimen.height];
            for axis in 0..2 {
                if weak.lower[axis] < 0.0 {
                    return Err(region.refusal(
                        "lower",
                        "lies outside of the specimen, whose lower left corner is [0, 0]. Move it inside.",
                    ));
                }
                if weak.upper[axis] > size[axis] * (1.0 + FIT_TOLERANCE) {
                    let problem = format!(
                        "lies outside of the specimen, whose upper right corner is [{}, {}] in m. Move it inside.",
                        digits(size[0]),
                        digits(size[1])
                    );
                    return Err(region.refusal("upper", &problem));
                }
                if weak.upper[axis] <= weak.lower[axis] {
                    return Err(
                        region.refusal("upper", "encloses nothing: it must lie above and to the right of lower.")
                    );
                }
            }
            Ok(weak)
        })
        .collect()
}

/// Asleep: Table 4 of seed 000. `steps_per_strain`: steps in which a band one cell thick shears by 1 at full speed.
fn oracle(table: &Reader<'_>, steps_per_strain: f64) -> Result<Oracle, Error> {
    let window = table.number_awake("window", 8e-4)?;
    let every = (window * steps_per_strain / LOOKS_PER_WINDOW).clamp(1.0, 1e9);
    Ok(Oracle {
        laplacian: table.number_awake("laplacian", 1e-6)?,
        recent_strain: table.number_awake("recent_strain", 1e-4)?,
        window,
        persistence: table.number_awake("persistence", 1.2e-3)?,
        every: table.count_or("every", every as u64)?,
    })
}

fn enrichment(table: &Reader<'_>, distance_asleep: f64) -> Result<Enrichment, Error> {
    Ok(Enrichment {
        distance: table.number_awake("distance", distance_asleep)?,
        weight: table.number_or("weight", 0.5)?,
        training: table.number_or("training", 1.0)?,
        training_speed: table.number_or("training_speed", 10.0)?,
        training_rest: table.number_or("training_rest", 0.5)?,
    })
}

fn fill_plate(scenario: &mut Scenario, table: &Reader<'_>) -> Result<(), Error> {
    let specimen_mass = derived::specimen_mass(scenario);
    let mass = table.number_or("plate_mass", derived::plate_mass_default(specimen_mass))?;
    let modulus_p = scenario.continuum.bulk_modulus + scenario.continuum.shear_modulus;
    let size = [scenario.specimen.width, scenario.specimen.height, scenario.specimen.depth];
    let damping = derived::plate_damping_default(modulus_p, size, mass, specimen_mass);
    scenario.loading.plate_mass = mass;
    scenario.loading.plate_damping = table.number_or("plate_damping", damping)?;
    Ok(())
}

fn fill_output(scenario: &mut Scenario, table: &Reader<'_>) -> Result<(), Error> {
    let duration = derived::duration(scenario);
    let step = scenario.time.step;
    let interval = |key: &str, count: f64| -> Result<f64, Error> {
        let interval = table.number_or(key, (duration / count).max(step))?;
        if interval < step {
            let problem = format!("is shorter than one time step. Write at least time.step = {} s.", digits(step));
            return Err(table.refusal(key, &problem));
        }
        Ok(interval)
    };
    scenario.output = Output {
        series_interval: interval("series_interval", ROWS_DEFAULT)?,
        frame_interval: interval("frame_interval", FRAMES_DEFAULT)?,
        checkpoint_interval: interval("checkpoint_interval", CHECKPOINTS_DEFAULT)?,
        checkpoints_kept: table.count_or("checkpoints_kept", 2)? as usize,
    };
    Ok(())
}

/// What no single key can tell.
fn check_together(scenario: &Scenario, job: &Job) -> Result<(), Error> {
    check_height(scenario, job)?;
    if scenario.moves_grains() {
        check_block_edge(scenario, job)?;
    }
    if scenario.method == Method::Hybrid {
        check_zone(scenario, job)?;
    }
    check_step(scenario, job)
}

fn check_height(scenario: &Scenario, job: &Job) -> Result<(), Error> {
    let block = derived::block_edge(scenario);
    if scenario.specimen.height >= block {
        return Ok(());
    }
    let message = format!(
        "is lower than one block, which is {} mm ({} cells of {} mm). Make the specimen higher or continuum.cell smaller.",
        digits(1e3 * block),
        scenario.decomposition.cells_per_block,
        digits(1e3 * scenario.continuum.cell)
    );
    Err(job.refusal("specimen", "height", &message))
}

/// A block's ghosts come from its neighbours alone, so a contact must not reach across one.
fn check_block_edge(scenario: &Scenario, job: &Job) -> Result<(), Error> {
    let edge = derived::block_edge(scenario);
    let edge_min = 2.0 * derived::diameter_max(scenario) + scenario.decomposition.skin;
    if edge >= edge_min {
        return Ok(());
    }
    let message = format!(
        "makes blocks of {} mm, but two of the largest grains and the skin need {} mm. Take larger cells, more decomposition.cells_per_block, or smaller grains.",
        digits(1e3 * edge),
        digits(1e3 * edge_min)
    );
    Err(job.refusal("continuum", "cell", &message))
}

fn check_zone(scenario: &Scenario, job: &Job) -> Result<(), Error> {
    let cell = scenario.continuum.cell;
    let height = scenario.specimen.height;
    if 2.0 * (scenario.enrichment.distance + cell) < height {
        return Ok(());
    }
    let message = format!(
        "leaves no continuum: twice this distance and twice a cell must be less than specimen.height = {} mm, so less than {} mm is allowed. For grains everywhere write method = \"dem\".",
        digits(1e3 * height),
        digits(1e3 * (0.5 * height - cell).max(0.0))
    );
    Err(job.refusal("enrichment", "distance", &message))
}

fn check_step(scenario: &Scenario, job: &Job) -> Result<(), Error> {
    let bounds = derived::bounds(scenario);
    let governing = derived::governing(&bounds);
    if scenario.time.step <= governing.step {
        return Ok(());
    }
    let message = format!(
        "is unstable: at most {} s is allowed ({}: {}). {}",
        digits_below(governing.step),
        governing.cause,
        governing.formula,
        governing.remedy
    );
    Err(job.refusal("time", "step", &message))
}

/// A number for a sentence, without the noise of binary fractions.
pub fn digits(value: f64) -> String {
    significant(value, 10)
}

/// Three digits, cut and not rounded, so that a limit copied from a message is within the limit.
pub fn digits_below(value: f64) -> String {
    let exact = format!("{value:.16e}");
    let (mantissa, exponent) = exact.split_once('e').expect("scientific notation has an e");
    let cut: f64 = format!("{}e{exponent}", &mantissa[..4]).parse().expect("a shortened number parses");
    significant(cut, 3)
}

/// At most `count` digits, trailing zeros dropped.
fn significant(value: f64, count: usize) -> String {
    let rounded: f64 = format!("{value:.*e}", count - 1).parse().expect("a formatted number parses");
    match (1e-3..1e7).contains(&rounded.abs()) || rounded == 0.0 {
        true => format!("{rounded}"),
        false => format!("{rounded:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = r#"
        name = "small"
        method = "dem"
        [specimen]
        width = "24 mm"
        height = "30 mm"
        [grains]
        diameter_mean = "1 mm"
        diameter_deviation = "0.08 mm"
        density = 2530
        [loading]
        stress_normal = "400 kPa"
        speed = "2 cm/s"
        speed_ramp = 0
        strain_end = 0.1
        [time]
        step = "0.4 us"
    "#;
    const CONTACT: &str = r#"
        [contact]
        stiffness_normal = 1772093.8
        stiffness_tangential = 886046.9
        damping_normal = 3.5
        damping_tangential = 3.5
        friction = 0.5
    "#;

    fn parse(text: &str, sets: &[&str]) -> Result<Scenario, Error> {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
        Scenario::parse(text, "small.toml", &sets)
    }

    /// A job of grains alone need not speak of a continuum, and gets blocks that fit grains.
    #[test]
    fn tables_that_sleep_may_be_missing() {
        let scenario = parse(&format!("{HEAD}{CONTACT}"), &[]).unwrap();
        assert_eq!(derived::blocks(&scenario), [2, 3]);
        assert_eq!(scenario.continuum.weak, []);
        assert_eq!(scenario.packing.stress, 400e3);
        let error = parse(HEAD, &[]).unwrap_err().to_string();
        assert!(error.contains("needs the table [contact]"), "{error}");
    }

    /// A continuum alone makes a packing only if it is not told its fraction.
    #[test]
    fn a_continuum_needs_contacts_only_for_its_packing() {
        let continuum = r#"
            [continuum]
            bulk_modulus = "100 MPa"
            shear_modulus = "60 MPa"
            friction_angle_critical = 0.27
            fraction_critical = 0.815
            dilation_factor = 7
            softening_rate = 1
            cell = "3 mm"
        "#;
        let text = format!("{HEAD}{continuum}");
        let error = parse(&text, &["method=mpm"]).unwrap_err().to_string();
        assert!(error.contains("needs the table [contact]"), "{error}");
        let scenario = parse(&text, &["method=mpm", "continuum.fraction_start=0.855"]).unwrap();
        assert_eq!(scenario.continuum.fraction_start, Some(0.855));
    }

    #[test]
    fn the_resolved_job_parses_back_to_the_same_scenario() {
        let text = format!("{HEAD}{CONTACT}");
        let sets = [
            "grains.file=\"a \\\" b.csv\"",
            "continuum.weak=[{lower=[0, 0], upper=[0.024, \"1 cm\"], fraction_deficit=0.02}]",
            "time.step=3.3333333333333e-7",
        ];
        let scenario = parse(&text, &sets).unwrap();
        assert_eq!(scenario.continuum.weak[0].upper, [0.024, 0.01]);
        let back = Scenario::parse(&scenario.to_toml(), "elsewhere/job.toml", &[]).unwrap();
        assert_eq!(back, scenario);
    }

    #[test]
    fn paths_start_from_the_folder_of_the_job() {
        let text = format!("{HEAD}{CONTACT}");
        let scenario = Scenario::parse(&text, "/jobs/small.toml", &[]).unwrap();
        assert_eq!(scenario.packing.cache, Path::new("/jobs/cache"));
    }

    /// Limits in messages are cut, so that they can be copied.
    #[test]
    fn a_limit_in_a_message_is_within_the_limit() {
        assert_eq!(digits_below(4.479_9e-7), "4.47e-7");
        assert_eq!(digits_below(0.999_99), "0.999");
        assert_eq!(digits(7.499_999_999_999_999), "7.5");
    }
}
