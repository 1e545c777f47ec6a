//! What no single key of an assembly can tell.

use super::body::AXES;
use super::{digits, digits_above, digits_below, limits, refuse_unstable};
use crate::base::error::Error;
use crate::job::assembly::{Assembly, GRAINS_MAX, Packed, Preparation, Shape, Source};
use crate::job::figures;
use crate::job::raw::Typed;
use crate::law::contact::Contact;

/// What lists reach beyond the grains themselves, as messages call it.
pub(crate) fn margin_in_words(contact: &Contact) -> &'static str {
    if contact.reach() > 0.0 { "the skin with the reach of cohesion" } else { "the skin" }
}

/// Length of a periodic axis in largest diameters: with less, a grain and its image could share a neighbour.
pub(super) const PERIOD_IN_DIAMETERS: f64 = 4.0;
/// Solid volume fraction that no packing of spheres has; of discs the key's own range says it.
const FRACTION_MAX_SPHERES: f64 = 0.74;
/// Spheres inserted one after the other jam at 0.38, discs at 0.547.
const FRACTION_START_MAX_SPHERES: f64 = 0.36;
/// Some records of other programs were made with unstable steps.
pub const BYPASS: &str = " Only to repeat an unstable run on purpose, write time.allow_unstable = true.";

pub fn check(assembly: &Assembly, typed: &Typed) {
    typed.check(check_deformation(assembly, typed));
    typed.check(check_cell(assembly, typed));
    typed.check(limits::refuse_size_of_cell(assembly, typed));
    typed.check(limits::refuse_speeds(assembly, typed));
    typed.check(check_copies(assembly, typed));
    if let Source::Packed(packed) = &assembly.source {
        typed.check(check_packing(&assembly.of_one_copy(), packed, typed));
    }
    typed.check(check_time(assembly, typed));
    typed.check(check_stress(assembly, typed));
}

/// The same of a piece of packing, whose cell is not the job's own.
pub fn check_as_piece(piece: &Assembly, typed: &Typed) -> Result<(), Error> {
    if let Source::Packed(packed) = &piece.source {
        check_packing(piece, packed, typed)?;
    }
    refuse_unstable(typed, piece.step, &figures::bounds(piece), "")?;
    check_stress(piece, typed)
}

/// The stress of the packing and that of the cell must press grains together, and not into each other.
fn check_stress(assembly: &Assembly, typed: &Typed) -> Result<(), Error> {
    let number = figures::pressure(assembly).and_then(|pressure| figures::stiffness_number(assembly, pressure));
    if let Some(number) = number {
        let held = assembly.cell.servo.is_some();
        limits::refuse_squeeze(typed, if held { ("cell", "stress_normal") } else { ("packing", "stress") }, number)?;
    }
    match &assembly.source {
        Source::Packed(Packed { preparation: Preparation::Compress { stress, unloaded, .. }, .. }) => {
            let time = |stress: f64| assembly.matter.diameter_mean * (assembly.matter.density / stress).sqrt();
            let step = assembly.of_one_copy().step;
            limits::refuse_faint_packing(typed, ("packing", "stress"), time(*stress), step)?;
            let Some(unloaded) = unloaded else { return Ok(()) };
            if unloaded >= stress {
                let message = format!("is no less than packing.stress = {stress} Pa. Write less, or remove the line.");
                return Err(typed.refusal("packing", "unloaded", &message));
            }
            limits::refuse_faint_packing(typed, ("packing", "unloaded"), time(*unloaded), step)
        }
        _ => Ok(()),
    }
}

/// Only periodic axes deform, and each by a rate or by a stress.
fn check_deformation(assembly: &Assembly, typed: &Typed) -> Result<(), Error> {
    let cell = &assembly.cell;
    let held = |axis: usize| cell.servo.as_ref().is_some_and(|servo| servo.stress[axis].is_some());
    for (axis, name) in AXES.iter().enumerate().take(cell.dimension) {
        let moved =
            (0..cell.dimension).any(|other| cell.gradient[axis][other] != 0.0 || cell.gradient[other][axis] != 0.0);
        if (moved || held(axis)) && !cell.periodic[axis] {
            return Err(typed.refusal(
                "cell",
                if moved { "velocity_gradient" } else { "stress_normal" },
                &format!(
                    "deforms the cell along {name}, which is not periodic. Set cell.periodic to true along {name}, or move bodies instead."
                ),
            ));
        }
        if held(axis) && cell.gradient[axis][axis] != 0.0 {
            return Err(typed.refusal(
                "cell",
                "stress_normal",
                &format!(
                    "holds {name} at a stress, and cell.velocity_gradient stretches {name} at a rate. Write \"free\" here, or 0 there."
                ),
            ));
        }
    }
    match &cell.servo {
        Some(servo) if servo.stress.iter().all(Option::is_none) => Err(typed.refusal(
            "cell",
            "stress_normal",
            "holds no axis at a stress. Remove cell.stress_normal and cell.rate_max.",
        )),
        _ => Ok(()),
    }
}

fn check_cell(assembly: &Assembly, typed: &Typed) -> Result<(), Error> {
    let cell = &assembly.cell;
    let diameter_max = figures::diameter_max(assembly);
    let reach = PERIOD_IN_DIAMETERS * diameter_max + figures::margin(assembly);
    let margin = margin_in_words(&assembly.contact);
    let known = matches!(assembly.source, Source::Packed(_));
    for axis in (0..cell.dimension).filter(|axis| known && cell.periodic[*axis]) {
        let length = cell.end()[axis] - cell.lower[axis];
        if length < reach {
            return Err(typed.refusal(
                "cell",
                "upper",
                &format!(
                    "makes the cell {} mm long along {}, where it is periodic, but four of the largest grains and {margin} need {} mm. Take a larger cell or smaller grains.",
                    digits(1e3 * length),
                    AXES[axis],
                    digits(1e3 * reach)
                ),
            ));
        }
    }
    let block_min = 2.0 * diameter_max + figures::margin(assembly);
    if assembly.block >= block_min {
        return Ok(());
    }
    Err(typed.refusal(
        "decomposition",
        "block",
        &format!(
            "is shorter than two of the largest grains and {margin}, which need {} mm. Take larger blocks.",
            digits(1e3 * block_min)
        ),
    ))
}

/// Copies are of what is compressed in a cell with all periods; where the run has none, layers hold their ends.
fn check_copies(assembly: &Assembly, typed: &Typed) -> Result<(), Error> {
    let cell = &assembly.cell;
    if cell.copies.is_none() {
        return Ok(());
    }
    let refused = |key: &str, problem: &str| Err(typed.refusal("cell", key, problem));
    match &assembly.source {
        Source::File(_) => {
            return refused(
                "copies",
                "are of a packing that the program makes, and grains.file gives the grains. Remove the line.",
            );
        }
        Source::Packed(Packed { preparation: Preparation::Pour, .. }) => {
            return refused(
                "copies",
                "are of a packing that is compressed in a periodic cell. Write packing.preparation = \"compress\", or remove the line.",
            );
        }
        Source::Packed(_) => {}
    }
    if figures::grains(assembly).is_some_and(|grains| grains > GRAINS_MAX) {
        return refused("copies", &format!("make more than {} grains of grains.count. Take fewer.", GRAINS_MAX as f64));
    }
    let open: Vec<usize> = (0..cell.dimension).filter(|axis| !cell.periodic[*axis]).collect();
    if !open.is_empty() && cell.servo.is_some() {
        return refused(
            "stress_normal",
            "holds a stress of the whole cell, and copies with an open end do not fill it. Hold a layer by its servo instead, or make every axis periodic.",
        );
    }
    let is_held = |axis: usize| {
        let layers = assembly.bodies.iter().filter_map(|body| match &body.shape {
            Shape::Layer { lower, upper } => Some((lower[axis], upper[axis])),
            _ => None,
        });
        let lowest = layers.clone().map(|(_, upper)| upper).fold(f64::INFINITY, f64::min);
        let highest = layers.map(|(lower, _)| lower).fold(f64::NEG_INFINITY, f64::max);
        highest > lowest || (assembly.gravity[axis] != 0.0 && lowest.is_finite())
    };
    let Some(axis) = open.into_iter().find(|axis| !is_held(*axis)) else { return Ok(()) };
    let problem = format!(
        "leaves the ends of the copies open along {}, and nothing holds them there. Add a [[body]] with shape = \"layer\" at either end, or make the axis periodic.",
        AXES[axis]
    );
    refused("periodic", &problem)
}

fn check_packing(assembly: &Assembly, packed: &Packed, typed: &Typed) -> Result<(), Error> {
    let cell = &assembly.cell;
    if cell.dimension == 3 && packed.fraction_start > FRACTION_START_MAX_SPHERES {
        let message = format!(
            "is more than spheres can be inserted to without overlap. Write at most {FRACTION_START_MAX_SPHERES}."
        );
        return Err(typed.refusal("packing", "fraction_start", &message));
    }
    match packed.preparation {
        Preparation::Compress { fraction, .. } => {
            if let Some(axis) = (0..cell.dimension).find(|axis| !cell.periodic[*axis]) {
                return Err(typed.refusal(
                    "packing",
                    "preparation",
                    &format!(
                        "compresses a cell that is periodic along every axis, and {} is not. Set cell.periodic to true there, write \"pour\", or lay copies of it side by side (cell.copies), whose ends may be open.",
                        AXES[axis]
                    ),
                ));
            }
            match fraction {
                Some(fraction) if cell.dimension == 3 && fraction > FRACTION_MAX_SPHERES => Err(typed.refusal(
                    "packing",
                    "fraction",
                    &format!("is more than spheres can fill. Write at most {FRACTION_MAX_SPHERES}."),
                )),
                _ => Ok(()),
            }
        }
        Preparation::Pour => check_pour(assembly, packed, typed),
    }
}

/// Grains fall somewhere, and find room in the cell at the start.
fn check_pour(assembly: &Assembly, packed: &Packed, typed: &Typed) -> Result<(), Error> {
    if assembly.gravity == [0.0; 3] {
        return Err(typed.refusal(
            "packing",
            "preparation",
            "lets grains fall, and there is no gravity. Add for example cell.gravity = [0, \"-9.81 m/s2\"].",
        ));
    }
    if assembly.bodies.is_empty() {
        return Err(typed.refusal(
            "packing",
            "preparation",
            "lets grains fall, and there is no body to fall on. Add a [[body]] as their floor.",
        ));
    }
    let fraction = figures::fraction_in_cell(assembly).unwrap_or_default();
    if fraction <= packed.fraction_start {
        return Ok(());
    }
    Err(typed.refusal(
        "grains",
        "count",
        &format!(
            "fills {} of the cell, and packing.fraction_start lets loose grains fill {} of it. Take fewer grains or a larger cell.",
            digits_below(fraction),
            packed.fraction_start
        ),
    ))
}

fn check_time(assembly: &Assembly, typed: &Typed) -> Result<(), Error> {
    if assembly.end < assembly.step {
        let message =
            format!("is shorter than one time step. Write at least time.step = {} s.", digits_above(assembly.step));
        return Err(typed.refusal("time", "end", &message));
    }
    // Sizes of a file are held to the step when it is read: the mean that the job states says too little.
    match assembly.allow_unstable || assembly.source.file().is_some() {
        true => Ok(()),
        false => refuse_unstable(typed, assembly.step, &figures::bounds(assembly), BYPASS),
    }
}
