//! Grains in a cell.

use std::path::Path;

use super::body::bodies;
use super::checks::check;
use super::contact::contact;
use super::{
    DEPTH_DEFAULT, PACKING_ENERGY_RATIO_DEFAULT, PACKING_FRACTION_DEFAULT, PACKING_FRICTION_DEFAULT, SKIN_DEFAULT,
    folder_of, name, output, refuse_wide_sizes,
};
use crate::error::Error;
use crate::scenario::assembly::{
    Assembly, Cell, CellServo, Damping, DampingForm, Matter, Packed, Preparation, Sizes, Source,
};
use crate::scenario::raw::{Reader, Typed};
use crate::scenario::stable;

/// Packing fraction of a loose start of spheres; thrown one after the other they jam at 0.38.
const PACKING_FRACTION_SPHERES: f64 = 0.3;
/// Edge of a block in mean diameters: in space fewer, so that a block holds some hundred grains in both.
const BLOCK_OF_DISCS: f64 = 12.0;
const BLOCK_OF_SPHERES: f64 = 6.0;
/// How exactly shares of sizes add up to 1.
const SHARES_TOLERANCE: f64 = 1e-9;

/// How the keys of `[grains]` part by how diameters are spread.
const OF_DISTRIBUTION: [(&str, &[&str]); 3] = [
    ("normal", &["diameter_mean", "diameter_deviation"]),
    ("uniform", &["diameter_min", "diameter_max"]),
    ("list", &["diameters"]),
];
/// Keys of `[grains]` that only grains to be made need.
const OF_MADE: [&str; 6] = ["count", "distribution", "diameter_deviation", "diameter_min", "diameter_max", "diameters"];
/// How the keys of `[packing]` part by the preparation.
const OF_PREPARATION: [(&str, &[&str]); 2] = [("compress", &["stress", "fraction"]), ("pour", &[])];

/// The checked assembly of a job; `file` is the job's path, whose folder relative paths start from.
pub fn assembly(typed: &Typed, file: &str) -> Result<Assembly, Error> {
    let why = "an assembly of grains";
    let top = typed.table("", true, why)?;
    let folder = folder_of(file);

    let (cell, gravity) = cell(typed.table("cell", true, why)?)?;
    let grains = typed.table("grains", true, why)?;
    let packing = typed.table("packing", false, why)?;
    let (matter, source) = source(&grains, &packing, &cell, &folder)?;
    let mass_mean = stable::grain_mass(matter.density, 0.5 * matter.diameter_mean, cell.depth, cell.dimension);
    let contact = contact(&typed.table("contact", true, why)?, mass_mean)?;
    let time = typed.table("time", true, why)?;
    let step = time.number("step")?;
    let end = time.number("end")?;
    let cut = typed.table("decomposition", false, why)?;
    let block = if cell.dimension == 2 { BLOCK_OF_DISCS } else { BLOCK_OF_SPHERES };

    let assembly = Assembly {
        name: name(&top)?,
        seed: top.count_or("seed", 1)?,
        matter,
        source,
        contact,
        damping: damping(&typed.table("damping", false, why)?)?,
        gravity,
        bodies: bodies(&top.with_axes(cell.dimension), &cell)?,
        step,
        end,
        allow_unstable: time.flag_or("allow_unstable", false)?,
        skin: cut.number_or("skin", SKIN_DEFAULT * matter.diameter_mean)?,
        block: cut.number_or("block", block * matter.diameter_mean)?,
        output: output(&typed.table("output", false, why)?, end, step)?,
        cell,
    };
    check(&assembly, typed)?;
    Ok(assembly)
}

/// The cell and the acceleration in it.
fn cell(table: Reader<'_>) -> Result<(Cell, [f64; 3]), Error> {
    let dimension = table.choose("space", "space", &[("plane", 2), ("solid", 3)])?;
    let table = table.with_axes(dimension);
    if dimension == 3 && table.has("depth") {
        return Err(table.refusal("depth", "belongs to space = \"plane\"; spheres have no depth. Remove the line."));
    }
    let cell = Cell {
        dimension,
        lower: table.vector_if_given("lower")?.unwrap_or_default(),
        upper: table.vector("upper")?,
        periodic: table.flags_or("periodic", true)?,
        depth: table.number_or("depth", if dimension == 2 { DEPTH_DEFAULT } else { 1.0 })?,
        gradient: table.gradient("velocity_gradient")?,
        servo: cell_servo(&table)?,
    };
    if (0..dimension).any(|axis| cell.upper[axis] <= cell.lower[axis]) {
        return Err(table.refusal("upper", "encloses nothing: it must be more than lower along every axis."));
    }
    Ok((cell, table.vector_if_given("gravity")?.unwrap_or_default()))
}

fn cell_servo(table: &Reader<'_>) -> Result<Option<CellServo>, Error> {
    match (table.stresses("stress")?, table.has("rate_max")) {
        (Some(stress), _) => Ok(Some(CellServo { stress, rate_max: table.number("rate_max")? })),
        (None, true) => Err(table.refusal(
            "rate_max",
            "bounds the rate of axes held at a stress, and there is no cell.stress. Add it, or remove the line.",
        )),
        (None, false) => Ok(None),
    }
}

fn source(grains: &Reader<'_>, packing: &Reader<'_>, cell: &Cell, folder: &Path) -> Result<(Matter, Source), Error> {
    let density = grains.number("density")?;
    if let Some(file) = grains.text_if_given("file")? {
        if let Some(key) = OF_MADE.into_iter().find(|key| grains.has(key)) {
            return Err(grains.refusal(
                key,
                "is for grains to be made, and grains.file says that they are read. Remove one of the two.",
            ));
        }
        if packing.is_typed() {
            return Err(packing
                .refusal_of_table("makes grains, and grains.file says that they are read. Remove one of the two."));
        }
        let matter = Matter { density, diameter_mean: grains.number("diameter_mean")? };
        return Ok((matter, Source::File(folder.join(file))));
    }
    let Some(count) = grains.count_if_given("count")? else {
        return Err(grains.refusal_of_table(
            "says neither where grains are read from nor how many are made. Add file = \"grains.csv\", or count = 400.",
        ));
    };
    let sizes = sizes(grains)?;
    let matter = Matter { density, diameter_mean: sizes.mean() };
    Ok((matter, Source::Packed(packed(packing, sizes, count, cell, folder)?)))
}

fn sizes(grains: &Reader<'_>) -> Result<Sizes, Error> {
    let names = OF_DISTRIBUTION.map(|(name, _)| (name, name));
    let distribution = grains.choice_or("distribution", "distribution", &names, "normal")?;
    grains.refuse_keys_of_others("distribution", distribution, &OF_DISTRIBUTION)?;
    match distribution {
        "normal" => {
            let (mean, deviation) = (grains.number("diameter_mean")?, grains.number("diameter_deviation")?);
            refuse_wide_sizes(grains, mean, deviation)?;
            Ok(Sizes::Normal { mean, deviation })
        }
        "uniform" => {
            let (min, max) = (grains.number("diameter_min")?, grains.number("diameter_max")?);
            match min <= max {
                true => Ok(Sizes::Uniform { min, max }),
                false => Err(grains.refusal("diameter_max", "is less than grains.diameter_min. Exchange them.")),
            }
        }
        _ => {
            let list = grains.shares("diameters")?;
            let sum: f64 = list.iter().map(|(_, share)| share).sum();
            match (sum - 1.0).abs() <= SHARES_TOLERANCE {
                true => Ok(Sizes::List(list)),
                false => Err(grains.refusal(
                    "diameters",
                    &format!(
                        "does not add up: the shares of all diameters make {}, and 1 is wanted.",
                        super::digits(sum)
                    ),
                )),
            }
        }
    }
}

fn packed(table: &Reader<'_>, sizes: Sizes, count: u64, cell: &Cell, folder: &Path) -> Result<Packed, Error> {
    let names = OF_PREPARATION.map(|(name, _)| (name, name));
    let Some(preparation) = table.choice("preparation", "preparation", &names)? else {
        return Err(table.refusal_of_table(
            "must say how the grains of grains.count are made. Add preparation = \"compress\" with a stress, or preparation = \"pour\".",
        ));
    };
    table.refuse_keys_of_others("preparation", preparation, &OF_PREPARATION)?;
    let preparation = match preparation {
        "compress" => {
            Preparation::Compress { stress: table.number("stress")?, fraction: table.number_if_given("fraction")? }
        }
        _ => Preparation::Pour,
    };
    let fraction_start = if cell.dimension == 2 { PACKING_FRACTION_DEFAULT } else { PACKING_FRACTION_SPHERES };
    Ok(Packed {
        sizes,
        count,
        preparation,
        friction: table.number_or("friction", PACKING_FRICTION_DEFAULT)?,
        fraction_start: table.number_or("fraction_start", fraction_start)?,
        energy_ratio_max: table.number_or("energy_ratio_max", PACKING_ENERGY_RATIO_DEFAULT)?,
        cache: folder.join(table.text_if_given("cache")?.unwrap_or("cache")),
    })
}

fn damping(table: &Reader<'_>) -> Result<Damping, Error> {
    let forms = [("vector", DampingForm::Vector), ("component", DampingForm::Component)];
    Ok(Damping {
        local: table.number_or("local", 0.0)?,
        form: table.choice_or("form", "form of local damping", &forms, DampingForm::Vector)?,
        mass: table.number_or("mass", 0.0)?,
    })
}
