//! A continuum of material points on a grid.

use super::assembly::{body, grains, servo};
use super::shear::{enrichment, oracle, zone};
use super::{Page, list};
use crate::job::mpm::{
    BodyContact, Boundary, Elastic, Face, Granular, InitialStress, Load, LoadKind, MaterialLaw, Membrane, Mpm, Path,
    Region, RegionShape, Wave,
};
use crate::mpm::scheme::{ShapeFunction, StressUpdate, Transfer};

pub fn mpm(job: &Mpm) -> String {
    let mut page = Page::new();
    let axes = job.grid.dimension;
    page.text("name", &job.name);
    if let Some(grains) = &job.grains {
        page.text("method", grains.method.name());
        page.count("seed", grains.piece.seed);
    }
    grid(&mut page, job);
    scheme(&mut page, job);
    material(&mut page, job);
    stress(&mut page, &job.stress);
    page.table("gravity");
    page.numbers("acceleration", &job.gravity.acceleration[..axes]);
    page.number("ramp", job.gravity.ramp);
    page.table("time");
    page.number("step", job.step);
    page.number("end", job.end);
    if job.grains.is_some() {
        page.count("grain_steps", job.grain_steps);
    }
    if let Some(watch) = &job.oracle {
        page.table("oracle");
        page.number("diameter", watch.diameter);
        oracle(&mut page, &watch.oracle);
    }
    page.table("decomposition");
    page.count("cells_per_block", job.cells_per_block as u64);
    if let Some(Granular { piece, enrichment: of_zones, reference, known, .. }) = job.grains.as_deref() {
        page.number("skin", piece.skin);
        grains(&mut page, piece);
        page.contact(&piece.contact);
        enrichment(&mut page, of_zones);
        page.text("reference", reference.name());
        if let Some(known) = known {
            page.number("at", known.at);
        }
        zone(&mut page, &of_zones.life);
    }
    page.output(&job.output);
    page.flag("ledger", job.ledger);
    for one in &job.regions {
        region(&mut page, one, job);
    }
    for face in Face::all(axes) {
        boundary(&mut page, face, &job.boundaries[face.axis][usize::from(face.upper)]);
    }
    for one in &job.loads {
        load(&mut page, one, axes);
    }
    for one in &job.membranes {
        membrane(&mut page, one);
    }
    for [from, to] in job.grains.iter().filter_map(|grains| grains.known.as_ref()).flat_map(|known| &known.parts) {
        page.line("\n[[band]]");
        page.numbers("from", from);
        page.numbers("to", to);
    }
    for one in &job.bodies {
        page.line("\n[[body]]");
        body(&mut page, &one.body, axes);
        match one.contact {
            BodyContact::Rough => page.text("contact", "rough"),
            BodyContact::Smooth => page.text("contact", "smooth"),
            BodyContact::Coulomb { friction } => {
                page.text("contact", "coulomb");
                page.number("friction", friction);
            }
        }
        page.flag("separates", one.separates);
        if one.seat > 0.0 {
            page.number("seat", one.seat);
        }
        servo(&mut page, one.body.motion.servo.as_ref(), axes);
    }
    for one in &job.follow {
        page.line("\n[[follow]]");
        page.text("name", &one.name);
        page.numbers("place", &one.place[..axes]);
    }
    page.text_of_all()
}

fn grid(page: &mut Page, job: &Mpm) {
    let (grid, axes) = (&job.grid, job.grid.dimension);
    page.table("grid");
    page.space(axes);
    page.corners(&grid.lower[..axes], &grid.upper[..axes]);
    page.number("cell", grid.cell);
    if axes == 2 {
        page.number("depth", grid.depth);
    }
    page.line(&format!("periodic = {:?}", &grid.periodic[..axes]));
}

fn scheme(page: &mut Page, job: &Mpm) {
    page.table("scheme");
    page.text(
        "shape",
        match job.scheme.shape {
            ShapeFunction::Linear => "linear",
            ShapeFunction::Generalised => "generalised",
            ShapeFunction::Quadratic => "quadratic",
            ShapeFunction::Cubic => "cubic",
        },
    );
    page.text(
        "update",
        match job.scheme.update {
            StressUpdate::First => "first",
            StressUpdate::Last => "last",
            StressUpdate::ModifiedLast => "modified_last",
        },
    );
    match job.scheme.transfer {
        Transfer::Blend { flip } => {
            page.text("transfer", "blend");
            page.number("flip", flip);
        }
        Transfer::Affine => page.text("transfer", "affine"),
    }
    page.count("points_per_cell", job.scheme.points_per_cell as u64);
}

fn material(page: &mut Page, job: &Mpm) {
    page.table("material");
    match &job.material.law {
        MaterialLaw::LinearElastic(law) => {
            page.text("law", "linear_elastic");
            moduli(page, law);
        }
        MaterialLaw::Hencky(law) => {
            page.text("law", "hencky");
            moduli(page, law);
        }
        MaterialLaw::CriticalDruckerPrager(law) => {
            page.text("law", "critical_drucker_prager");
            page.number("bulk_modulus", law.bulk_modulus);
            page.number("shear_modulus", law.shear_modulus);
            page.number("friction_angle_critical", law.friction_angle_critical);
            page.number("fraction_critical", law.fraction_critical);
            page.number("fraction", law.fraction);
            page.number("dilation_factor", law.dilation_factor);
            page.number("softening_rate", law.softening_rate);
            page.number("cohesion", law.cohesion);
            if let Some(angle) = law.dilation_angle {
                page.number("dilation_angle", angle);
            }
        }
    }
    if job.grains.is_none() {
        page.number("density", job.material.density);
    }
}

fn moduli(page: &mut Page, law: &Elastic) {
    page.number("bulk_modulus", law.bulk_modulus);
    page.number("shear_modulus", law.shear_modulus);
}

fn stress(page: &mut Page, stress: &InitialStress) {
    page.table("stress");
    match stress {
        InitialStress::None => page.text("kind", "none"),
        InitialStress::Isotropic { pressure } => {
            page.text("kind", "isotropic");
            page.number("pressure", *pressure);
        }
        InitialStress::Geostatic { surface, k0, surcharge, .. } => {
            page.text("kind", "geostatic");
            page.number("surface", *surface);
            page.number("k0", *k0);
            page.number("surcharge", *surcharge);
        }
    }
}

fn region(page: &mut Page, region: &Region, job: &Mpm) {
    let axes = job.grid.dimension;
    page.line("\n[[region]]");
    match &region.shape {
        RegionShape::Box { lower, upper } => {
            page.text("shape", "box");
            page.corners(&lower[..axes], &upper[..axes]);
        }
        RegionShape::Ball { centre, radius } => {
            page.text("shape", "ball");
            page.numbers("centre", &centre[..axes]);
            page.number("radius", *radius);
        }
        RegionShape::Polygon { vertices } => {
            page.text("shape", "polygon");
            let corners: Vec<String> = vertices.iter().map(|vertex| list(vertex)).collect();
            page.line(&format!("vertices = [{}]", corners.join(", ")));
        }
    }
    if matches!(job.material.law, MaterialLaw::CriticalDruckerPrager(_)) {
        page.number("fraction", region.fraction);
    }
    page.numbers("velocity", &region.velocity[..axes]);
    match axes {
        2 => page.number("spin", region.spin[2]),
        _ => page.numbers("spin", &region.spin),
    }
    if !region.waves.is_empty() {
        let waves: Vec<String> = region.waves.iter().map(|one| wave(one, axes)).collect();
        page.line(&format!("wave = [{}]", waves.join(", ")));
    }
}

fn wave(wave: &Wave, axes: usize) -> String {
    format!(
        "{{direction = {}, length = {:?}, origin = {}, amplitude = {}}}",
        list(&wave.direction[..axes]),
        wave.length,
        list(&wave.origin[..axes]),
        list(&wave.amplitude[..axes])
    )
}

fn boundary(page: &mut Page, face: Face, boundary: &Boundary) {
    let kind = match boundary {
        Boundary::Periodic => return,
        Boundary::Fixed => "fixed",
        Boundary::Roller => "roller",
        Boundary::Friction { .. } => "friction",
        Boundary::Absorbing => "absorbing",
        Boundary::Free => "free",
    };
    page.line("\n[[boundary]]");
    page.text("face", &face.name());
    page.text("kind", kind);
    if let Boundary::Friction { coefficient } = boundary {
        page.number("coefficient", *coefficient);
    }
}

fn membrane(page: &mut Page, membrane: &Membrane) {
    page.line("\n[[membrane]]");
    page.text("name", &membrane.name);
    match &membrane.path {
        Path::Line { from, to } => {
            page.text("shape", "line");
            page.numbers("from", from);
            page.numbers("to", to);
        }
        Path::Circle { centre, radius } => {
            page.text("shape", "circle");
            page.numbers("centre", centre);
            page.number("radius", *radius);
        }
    }
    page.number("spacing", membrane.spacing);
    page.number("mass_per_area", membrane.mass_per_area);
    page.number("stiffness", membrane.stiffness);
    page.number("damping", membrane.damping);
    page.number("tension", membrane.tension);
    page.number("pressure", membrane.pressure);
    page.number("ramp", membrane.ramp);
}

fn load(page: &mut Page, load: &Load, axes: usize) {
    page.line("\n[[load]]");
    page.text("face", &load.face.name());
    page.corners(&load.lower[..axes], &load.upper[..axes]);
    match &load.kind {
        LoadKind::Traction(traction) => {
            page.text("kind", "traction");
            page.numbers("traction", &traction[..axes]);
        }
        LoadKind::Pressure(pressure) => {
            page.text("kind", "pressure");
            page.number("pressure", *pressure);
        }
    }
    page.number("ramp", load.ramp);
}
