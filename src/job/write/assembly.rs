//! Grains in a cell.

use super::{Page, list};
use crate::dem::motion::DampingForm;
use crate::job::assembly::{
    Assembly, Body, BodyServo, Cell, Packed, PathPoint, Preparation, Shape, Sizes, Source, Velocities,
};

pub fn assembly(assembly: &Assembly) -> String {
    let mut page = Page::new();
    let axes = assembly.cell.dimension;
    page.text("name", &assembly.name);
    page.count("seed", assembly.seed);
    cell(&mut page, &assembly.cell);
    page.numbers("gravity", &assembly.gravity[..axes]);

    grains(&mut page, assembly);
    page.contact(&assembly.contact);
    page.table("damping");
    page.number("local", assembly.damping.local);
    page.text(
        "form",
        match assembly.damping.form {
            DampingForm::Vector => "vector",
            DampingForm::Component => "component",
        },
    );
    page.number("mass", assembly.damping.mass);

    page.table("time");
    page.number("step", assembly.step);
    page.number("end", assembly.end);
    page.text(
        "velocities",
        match assembly.velocities {
            Velocities::Now => "now",
            Velocities::HalfStepBefore => "half_step_before",
        },
    );
    page.flag("allow_unstable", assembly.allow_unstable);
    page.table("decomposition");
    page.number("skin", assembly.skin);
    page.number("block", assembly.block);
    page.output(&assembly.output);
    page.flag("contact_frames", assembly.output.contact_frames);
    page.flag("ledger", assembly.ledger);
    for one in &assembly.bodies {
        page.line("\n[[body]]");
        body(&mut page, one, axes);
        servo(&mut page, one.motion.servo.as_ref(), axes);
    }
    page.text_of_all()
}

/// `[grains]`, and of grains that are made `[packing]`.
pub fn grains(page: &mut Page, assembly: &Assembly) {
    page.table("grains");
    page.number("density", assembly.matter.density);
    match &assembly.source {
        Source::File(read) => {
            page.path("file", &read.grains);
            if let Some(contacts) = &read.contacts {
                page.path("contacts", contacts);
            }
            page.number("diameter_mean", assembly.matter.diameter_mean);
        }
        Source::Packed(packed) => made(page, packed),
    }
}

fn cell(page: &mut Page, cell: &Cell) {
    let axes = cell.dimension;
    page.table("cell");
    page.space(axes);
    page.corners(&cell.lower[..axes], &cell.upper[..axes]);
    page.line(&format!("periodic = {:?}", &cell.periodic[..axes]));
    if axes == 2 {
        page.number("depth", cell.depth);
    }
    let rows: Vec<String> = cell.gradient[..axes].iter().map(|row| list(&row[..axes])).collect();
    page.line(&format!("velocity_gradient = [{}]", rows.join(", ")));
    if let Some(servo) = &cell.servo {
        let held: Vec<String> = servo.stress[..axes]
            .iter()
            .map(|stress| stress.map_or("\"free\"".to_string(), |stress| format!("{stress:?}")))
            .collect();
        page.line(&format!("stress = [{}]", held.join(", ")));
        page.number("rate_max", servo.rate_max);
        page.number("stress_gain", servo.gain);
        page.count("stress_interval", servo.interval);
    }
}

/// The rest of `[grains]`, and `[packing]`.
fn made(page: &mut Page, packed: &Packed) {
    page.count("count", packed.count);
    match &packed.sizes {
        Sizes::Normal { mean, deviation } => {
            page.text("distribution", "normal");
            page.number("diameter_mean", *mean);
            page.number("diameter_deviation", *deviation);
        }
        Sizes::Uniform { min, max } => {
            page.text("distribution", "uniform");
            page.number("diameter_min", *min);
            page.number("diameter_max", *max);
        }
        Sizes::List(sizes) => {
            page.text("distribution", "list");
            let pairs: Vec<String> = sizes.iter().map(|(diameter, share)| list(&[*diameter, *share])).collect();
            page.line(&format!("diameters = [{}]", pairs.join(", ")));
        }
    }
    page.table("packing");
    match packed.preparation {
        Preparation::Compress { stress, fraction, unloaded } => {
            page.text("preparation", "compress");
            page.number("stress", stress);
            if let Some(fraction) = fraction {
                page.number("fraction", fraction);
            }
            if let Some(unloaded) = unloaded {
                page.number("unloaded", unloaded);
            }
        }
        Preparation::Pour => page.text("preparation", "pour"),
    }
    page.number("friction", packed.friction);
    page.number("fraction_start", packed.fraction_start);
    page.number("energy_ratio_max", packed.energy_ratio_max);
    page.path("cache", &packed.cache);
}

/// A body within `[[body]]`, but for its servo.
pub fn body(page: &mut Page, body: &Body, axes: usize) {
    page.text("name", &body.name);
    match &body.shape {
        Shape::Plane { point, normal } => {
            page.text("shape", "plane");
            page.numbers("point", &point[..axes]);
            page.numbers("normal", &normal[..axes]);
        }
        Shape::Box { lower, upper } => {
            page.text("shape", "box");
            page.corners(&lower[..axes], &upper[..axes]);
        }
        Shape::Cylinder { centre, radius, axis } => {
            page.text("shape", "cylinder");
            page.numbers("centre", &centre[..axes]);
            page.number("radius", *radius);
            if axes == 3 {
                page.numbers("axis", axis);
            }
        }
        Shape::Layer { lower, upper } => {
            page.text("shape", "layer");
            page.corners(&lower[..axes], &upper[..axes]);
        }
    }
    if !body.motion.path.is_empty() {
        let points: Vec<String> = body.motion.path.iter().map(|point| path_point(point, axes)).collect();
        page.line(&format!("path = [{}]", points.join(", ")));
    }
}

fn path_point(point: &PathPoint, axes: usize) -> String {
    let spin = if axes == 2 { format!("{:?}", point.spin[2]) } else { list(&point.spin) };
    format!("{{time = {:?}, velocity = {}, spin = {spin}}}", point.time, list(&point.velocity[..axes]))
}

/// The table within a body, so the last of it.
pub fn servo(page: &mut Page, servo: Option<&BodyServo>, axes: usize) {
    let Some(servo) = servo else { return };
    page.line("[body.servo]");
    page.numbers("direction", &servo.direction[..axes]);
    page.number("force", servo.force);
    page.number("mass", servo.mass);
    page.number("damping", servo.damping);
    page.number("speed_max", servo.speed_max);
}
