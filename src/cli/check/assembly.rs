//! Grains in a cell.

use super::page::{Page, figures, whole};
use super::{INERTIAL_NUMBER_QUASI_STATIC, STEP_SHARE_MIN, STIFFNESS_NUMBER_MIN};
use crate::dem::motion::DampingForm;
use crate::job::assembly::{Assembly, Body, Packed, Preparation, Shape, Sizes, Source};
use crate::job::figures as of;
use crate::job::stable::{Bound, HERTZ_OVERLAP, governing};
use crate::law::contact::Stiffening;

/// Share of the cell that it may deform by in one step before contacts are followed too coarsely.
const STRAIN_OF_STEP_MAX: f64 = 1e-4;

/// The whole printout.
///
/// `bounds`: what bounds the step.
pub fn page(assembly: &Assembly, bounds: &[Bound]) -> String {
    let mut page = Page(String::new());
    let grains = if assembly.cell.dimension == 2 { "discs in the plane" } else { "spheres in space" };
    page.line(&format!("{}: an assembly of grains, {grains}", assembly.name));
    contacts(&mut page, assembly);
    cell(&mut page, assembly);
    matter(&mut page, assembly);
    bodies(&mut page, assembly);
    steps(&mut page, assembly, bounds);
    cost(&mut page, assembly);
    for warning in warnings(assembly, bounds) {
        page.line(&format!("\nwarning: {warning}"));
    }
    page.0
}

/// The law of contacts.
pub(super) fn contacts(page: &mut Page, assembly: &Assembly) {
    page.section("Contact");
    page.keys(assembly.cell.dimension, |form| assembly.contact.clone().keys(form, 0.0));
    if assembly.contact.stiffening() != Stiffening::Constant {
        let springs = of::springs_mean(assembly);
        let note = match assembly.contact.stiffening() {
            Stiffening::WithOverlap => format!("of two mean grains at an overlap of {} %", 100.0 * HERTZ_OVERLAP),
            _ => "of two mean grains".to_string(),
        };
        page.row("k_n and k_t", &pair(springs.normal, springs.tangential, "N/m"), &note);
    }
    let damping = &assembly.damping;
    if damping.local > 0.0 {
        let form = match damping.form {
            DampingForm::Vector => "against the velocity vector",
            DampingForm::Component => "component by component",
        };
        page.row("local damping", &figures(damping.local), form);
    }
    if damping.mass > 0.0 {
        page.row("damping by mass", &format!("{} 1/s", figures(damping.mass)), "-c m v");
    }
}

fn pair(first: f64, second: f64, unit: &str) -> String {
    format!("{} and {} {unit}", figures(first), figures(second))
}

fn cell(page: &mut Page, assembly: &Assembly) {
    let cell = &assembly.cell;
    let axes = 0..cell.dimension;
    let names: Vec<&str> = axes.clone().filter(|axis| cell.periodic[*axis]).map(|axis| AXES[axis]).collect();
    let edges: Vec<String> = axes.clone().map(|axis| figures(1e3 * (cell.upper[axis] - cell.lower[axis]))).collect();
    page.section("Cell");
    page.row(
        "edges",
        &format!("{} mm", edges.join(" x ")),
        &if names.is_empty() { "open".to_string() } else { format!("periodic in {}", names.join(", ")) },
    );
    if cell.dimension == 2 {
        page.row("depth", &format!("{} mm", figures(1e3 * cell.depth)), "out of the plane");
    }
    for row in axes.clone().filter(|row| cell.gradient[*row] != [0.0; 3]) {
        let rates: Vec<String> = cell.gradient[row][axes.clone()].iter().map(|rate| figures(*rate)).collect();
        page.row(
            &format!("velocity gradient, row {}", AXES[row]),
            &format!("{} 1/s", rates.join(", ")),
            "dh/dt = L h of the edges",
        );
    }
    if let Some(servo) = &cell.servo {
        for axis in axes.clone() {
            if let Some(stress) = servo.stress[axis] {
                page.row(
                    &format!("stress held along {}", AXES[axis]),
                    &format!("{} kPa", figures(1e-3 * stress)),
                    &format!(
                        "tension positive; {} of what is missing made up every {} steps, at most {} 1/s",
                        figures(servo.gain),
                        servo.interval,
                        figures(servo.rate_max)
                    ),
                );
            }
        }
    }
    if assembly.gravity != [0.0; 3] {
        let gravity: Vec<String> = assembly.gravity[axes].iter().map(|component| figures(*component)).collect();
        page.row("gravity", &format!("{} m/s2", gravity.join(", ")), "");
    }
    if let Some(number) = of::inertial_number(assembly) {
        page.row("inertial number", &figures(number), "rate d sqrt(rho/p)");
    }
}

const AXES: [&str; 3] = ["x", "y", "z"];

fn matter(page: &mut Page, assembly: &Assembly) {
    page.section("Grains");
    let count = of::grains(assembly).map_or("as many as the file has".to_string(), |grains| whole(grains as f64));
    match &assembly.source {
        Source::File(read) => {
            page.row("grains", &count, &format!("read from {}", read.grains.display()));
            if let Some(contacts) = &read.contacts {
                page.row("contacts", "as they were", &format!("read from {}", contacts.display()));
            }
        }
        Source::Packed(packed) => made(page, assembly, packed, &count),
    }
    let mean = assembly.matter.diameter_mean;
    let mass = of::grain(assembly, mean).mass;
    page.row("mean diameter", &format!("{} mm", figures(1e3 * mean)), "");
    page.row(
        "mass of the mean grain",
        &format!("{} kg", figures(mass)),
        if assembly.cell.dimension == 2 { "rho pi r^2 depth" } else { "rho 4/3 pi r^3" },
    );
}

fn made(page: &mut Page, assembly: &Assembly, packed: &Packed, count: &str) {
    let how = match packed.preparation {
        Preparation::Compress { stress, fraction, unloaded } => {
            let fraction = fraction.map_or_else(String::new, |of| format!(", packing fraction {}", figures(of)));
            let unloaded = unloaded.map_or_else(String::new, |to| format!(", unloaded to {} kPa", figures(1e-3 * to)));
            format!("compressed to {} kPa{fraction}{unloaded}", figures(1e-3 * stress))
        }
        Preparation::Pour => "poured onto the bodies".to_string(),
    };
    page.row("grains", count, &how);
    page.row(
        "diameters",
        &format!("{} to {} mm", figures(1e3 * packed.sizes.min()), figures(1e3 * packed.sizes.max())),
        match &packed.sizes {
            Sizes::Normal { .. } => "normal, cut at three deviations",
            Sizes::Uniform { .. } => "uniform",
            Sizes::List(_) => "in classes",
        },
    );
    let fraction = of::fraction_in_cell(assembly).unwrap_or_default();
    page.row("packing fraction", &figures(fraction), "of these grains in the cell as the job gives it");
    page.row("friction while packing", &figures(packed.friction), "");
}

fn bodies(page: &mut Page, assembly: &Assembly) {
    if assembly.bodies.is_empty() {
        return;
    }
    page.section("Bodies");
    for body in &assembly.bodies {
        let shape = match &body.shape {
            Shape::Plane { .. } => "plane",
            Shape::Box { .. } => "box",
            Shape::Cylinder { .. } => "cylinder",
            Shape::Layer { .. } => "layer of grains",
        };
        page.row(&body.name, shape, &motion(body));
    }
}

pub(super) fn motion(body: &Body) -> String {
    let path = match body.motion.path.as_slice() {
        [] => None,
        [_] => Some("moves at one velocity".to_string()),
        [.., last] => Some(format!("follows a path of {} s", figures(last.time))),
    };
    let servo = body.motion.servo.as_ref().map(|servo| format!("held at {} N", figures(servo.force)));
    match (path, servo) {
        (None, None) => "at rest".to_string(),
        (Some(path), Some(servo)) => format!("{path}, {servo}"),
        (path, servo) => path.or(servo).unwrap_or_default(),
    }
}

fn steps(page: &mut Page, assembly: &Assembly, bounds: &[Bound]) {
    page.section("Time step");
    page.row("step of the job", &format!("{} s", figures(assembly.step)), "");
    page.bounds("stable step", bounds);
}

fn cost(page: &mut Page, assembly: &Assembly) {
    page.section("Cost");
    page.row("simulated time", &format!("{} s", figures(assembly.end)), "");
    page.row("steps", &whole(of::steps(assembly) as f64), "");
    if let Some(grains) = of::grains(assembly) {
        let seconds = of::wall_time(assembly, grains);
        page.row(
            "time to run",
            &format!("{} h ({} s)", figures(seconds / 3600.0), figures(seconds)),
            &format!(
                "on one core, without the packing, at {} ns a grain and step",
                whole(1e9 * of::cost_of_grain(assembly))
            ),
        );
        let grains = grains as f64;
        page.pictures(&assembly.output, assembly.end, [grains; 2], assembly.cell.dimension);
    }
}

/// What is allowed, but probably not meant.
fn warnings(assembly: &Assembly, bounds: &[Bound]) -> Vec<String> {
    let mut warnings = warnings_of_step(assembly, bounds);
    if let Some(number) = of::inertial_number(assembly).filter(|number| *number > INERTIAL_NUMBER_QUASI_STATIC) {
        warnings.push(format!(
            "the inertial number is {}; above {INERTIAL_NUMBER_QUASI_STATIC} stress depends on the rate. Lower cell.velocity_gradient to at most {} 1/s for quasi-static deformation.",
            figures(number),
            figures(of::rate_max(assembly) * INERTIAL_NUMBER_QUASI_STATIC / number)
        ));
    }
    if let Some(stiffness) = of::stiffness_number(assembly).filter(|stiffness| *stiffness < STIFFNESS_NUMBER_MIN) {
        warnings.push(format!(
            "contacts are soft for their load: their stiffness is {} times the stress across a grain, so mean overlaps exceed a hundredth of a diameter. Take stiffer contacts or a lower stress.",
            figures(stiffness)
        ));
    }
    let falls_for_ever = assembly.bodies.is_empty() && assembly.gravity != [0.0; 3];
    if falls_for_ever {
        warnings
            .push("there is gravity and no body to rest on, so grains gather speed until the run ends.".to_string());
    }
    warnings
}

fn warnings_of_step(assembly: &Assembly, bounds: &[Bound]) -> Vec<String> {
    let mut warnings = Vec::new();
    let governing = governing(bounds);
    if assembly.step > governing.step {
        warnings.push(format!(
            "the time step is {} times the stable one, {} s ({}), and time.allow_unstable lets it pass.",
            figures(assembly.step / governing.step),
            figures(governing.step),
            governing.cause
        ));
    }
    if assembly.step < STEP_SHARE_MIN * governing.step {
        warnings.push(format!(
            "the time step is {} of the stable one, {} s. A longer time.step would save time.",
            figures(assembly.step / governing.step),
            figures(governing.step)
        ));
    }
    let strain = of::rate_max(assembly) * assembly.step;
    if strain > STRAIN_OF_STEP_MAX {
        warnings.push(format!(
            "the cell deforms by {} in one step; above {STRAIN_OF_STEP_MAX} grains cannot follow. Lower cell.velocity_gradient or time.step.",
            figures(strain)
        ));
    }
    warnings
}
