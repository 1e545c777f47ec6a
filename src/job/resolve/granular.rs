//! Grains that the material of a continuum's job may be made of.

use super::assembly::read_grains;
use super::body::{AXES, BODIES_MAX, check_inside};
use super::checks::{PERIOD_IN_DIAMETERS, check_as_piece};
use super::mpm::domain;
use super::shear::{LEDGER_OF_LIVING_ZONE, check_life};
use super::{BLOCK_OF_DISCS, BLOCK_OF_SPHERES, SKIN_DEFAULT, digits};
use crate::base::digits::significant;
use crate::base::error::Error;
use crate::base::keys::Form;
use crate::base::math;
use crate::job::assembly::{Assembly, Body, Motion, Packed, Preparation, Shape, Source};
use crate::job::figures::{self, bounds, diameter_max, diameters, fraction_in_cell, margin, stresses_of_packing};
use crate::job::mpm::figures::{bounding_box, pressures_at_start};
use crate::job::mpm::forecast::FRACTION_OF_PACKING;
use crate::job::mpm::{
    BodyContact, Boundary, Face, Granular, Grid, InitialStress, KnownBands, Mpm, Origin, Path, RigidBody,
};
use crate::job::raw::{Reader, Typed};
use crate::job::schema::Kind;
use crate::job::{Method, stable};
use crate::law::material::ConstitutiveLaw;
use crate::mpm::penalty::Coupling;
use crate::mpm::scheme::{ShapeFunction, StressUpdate};

/// Tables and keys that only grains ask for.
const TABLES: [&str; 7] = ["packing", "contact", "coupling", "enrichment", "zone", "rve", "damping"];
/// Those among them that only RVEs ask for, and those that only grains in the place of points do.
const TABLES_OF_RVES: [&str; 2] = ["rve", "damping"];
const TABLES_OF_ZONES: [&str; 3] = ["coupling", "enrichment", "zone"];
/// Rounding of a stress that is that of the packing.
const STRESS_SLACK: f64 = 1e-9;
/// How far a plane that stands in for a face stands before it, in cells.
const BEFORE_FACE: f64 = 1e-9;
/// Skin in cells: a grain may come half of it out of its block, and nodes reach a little less than half a cell beyond.
const SKIN_MAX: f64 = 0.8;
/// Cells that a zone keeps between its flagged nodes and its rim, at least.
const CELLS_OF_ZONE: f64 = 1.25;

/// What `[grains]` and its like say, if the job has them.
pub fn granular(typed: &Typed, top: &Reader<'_>, grid: &Grid, time: &Reader<'_>) -> Result<Option<Granular>, Error> {
    let why = "a job with grains";
    let grains = typed.table("grains", false, why);
    if !grains.is_typed() {
        let asleep = TABLES.map(|name| typed.table(name, false, why));
        for table in asleep.iter().filter(|table| table.is_typed()) {
            table.add(
                table.refusal_of_table("is for jobs with grains, and this one has none. Add [grains], or remove it."),
            );
        }
        let cut = typed.table("decomposition", false, why);
        let only = [(top, "method"), (top, "seed"), (top, "band"), (time, "grain_steps"), (&cut, "skin")];
        for (table, key) in only.into_iter().filter(|(table, key)| table.has(key)) {
            let problem = "is for jobs with grains, and this one has none. Add [grains], or remove the line.";
            table.clone().note(key, problem);
        }
        return Ok(None);
    }
    let mut granular = Granular::blank();
    granular.method.keys(&mut top.clone(), "what a job with [grains] is made of: hybrid, dem, mpm or mpm_dem with [grid], fem_dem with [mesh]; refused without [grains]");
    if granular.method == Method::Hybrid && grid.dimension != 2 {
        return Err(grains.refusal_of_table("take the place of points in plane strain, and this grid is in space. Write grid.space = \"plane\", or method = \"dem\" or \"mpm\"."));
    }
    read_piece(&mut granular.piece, typed, grid);
    let is_meshed = typed.table("mesh", false, why).is_typed();
    if let Some(other) = super::mesh::other_method(granular.method, is_meshed) {
        top.add(top.refusal("method", other));
    }
    let has_rves = granular.method.has_rves();
    let (others, whose) = match has_rves {
        true => (&TABLES_OF_ZONES[..], "\"hybrid\", where grains take the place of points"),
        false if is_meshed => (&TABLES_OF_RVES[..], "\"fem_dem\", where every element has grains of its own"),
        false => (&TABLES_OF_RVES[..], "\"mpm_dem\", where every point has grains of its own"),
    };
    for table in others.iter().map(|name| typed.table(name, false, why)).filter(|table| table.is_typed()) {
        let problem = format!("is for method = {whose}, and this is {:?}. Remove it.", granular.method.name());
        table.add(table.refusal_of_table(&problem));
    }
    if has_rves {
        granular.piece.damping.keys(&mut typed.table("damping", false, why));
        granular.rves.keys(&mut typed.table("rve", false, why));
        // That of its packing; RVEs have one of their own.
        granular.piece.step = stable::step_default(&bounds(&granular.piece));
        return Ok(Some(granular));
    }
    granular.coupling.keys(&mut typed.table("coupling", false, why));
    granular.enrichment.distance = grid.cell;
    granular.keys_of_enrichment(&mut typed.table("enrichment", granular.method == Method::Hybrid, why));
    granular.enrichment.life.keys(&mut typed.table("zone", false, why));
    Ok(Some(granular))
}

/// Bands that are known, and when grains take their places.
pub fn place_bands(grains: &mut Granular, parts: Vec<[[f64; 2]; 2]>, top: &Reader<'_>, typed: &Typed) {
    let tables = top.list("band");
    match (&mut grains.known, tables.first()) {
        (Some(known), Some(_)) => known.parts = parts,
        (Some(_), None) => typed.note_together(typed.refusal("enrichment", "at", "is when grains take the places of points around every [[band]], and there is none. Add [[band]] with from and to, or remove the line: the oracle says when.")),
        (None, Some(first)) => typed.note_together(first.refusal_of_table("is known from the start, and nothing says when grains take its place. Write enrichment.at, or remove the table: the oracle finds bands.")),
        (None, None) => {}
    }
}

/// The piece of packing.
fn read_piece(piece: &mut Assembly, typed: &Typed, grid: &Grid) {
    let why = "a job with grains";
    piece.name = "packing".to_string();
    (piece.cell.dimension, piece.cell.depth) = (grid.dimension, grid.depth);
    piece.cell.periodic = std::array::from_fn(|axis| axis < grid.dimension);
    read_grains(piece, typed, why);
    if !matches!(piece.source, Source::Packed(Packed { preparation: Preparation::Compress { .. }, .. })) {
        let message = "must be compressed, so that pieces of packing can be laid side by side: write packing.preparation = \"compress\" and grains.count.";
        typed.note_together(typed.table("grains", false, why).refusal_of_table(message));
    }
    let radius = 0.5 * piece.matter.diameter_mean;
    let mass_mean = stable::grain_mass(piece.matter.density, radius, grid.depth, grid.dimension);
    piece.contact.keys(&mut typed.table("contact", true, why), mass_mean);
    piece.skin = SKIN_DEFAULT * piece.matter.diameter_mean;
    let block = if grid.dimension == 2 { BLOCK_OF_DISCS } else { BLOCK_OF_SPHERES };
    piece.block = block * piece.matter.diameter_mean;
    // A square or cube that its grains fill about as they will once they are compressed.
    let of_edge = |edge: f64| std::array::from_fn(|axis| if axis < grid.dimension { edge } else { 0.0 });
    piece.cell.upper = of_edge(1.0);
    let fraction = FRACTION_OF_PACKING[grid.dimension - 2];
    let share = fraction_in_cell(piece).unwrap_or(fraction) / fraction;
    piece.cell.upper = of_edge(if grid.dimension == 2 { share.sqrt() } else { math::cbrt(share) });
}

/// Grains do not feel faces: where some may move, planes that hold grains and nodes alike stand in the place of every face that holds
/// nodes, under its name.
pub fn stand_in_for_faces(job: &mut Mpm) {
    if !job.makes_specimen() {
        return;
    }
    for face in Face::all(job.grid.dimension) {
        let boundary = &mut job.boundaries[face.axis][usize::from(face.upper)];
        let (contact, separates) = match *boundary {
            Boundary::Fixed => (BodyContact::Rough, false),
            Boundary::Roller => (BodyContact::Smooth, false),
            Boundary::Friction { coefficient } => (BodyContact::Coulomb { friction: coefficient }, true),
            Boundary::Periodic | Boundary::Absorbing | Boundary::Free => continue,
        };
        *boundary = Boundary::Free;
        let (mut point, mut normal) = ([0.0; 3], [0.0; 3]);
        let inwards = if face.upper { -1.0 } else { 1.0 };
        let at = if face.upper { job.grid.upper } else { job.grid.lower };
        normal[face.axis] = inwards;
        // Nodes on the face are behind the plane, whatever rounding says.
        point[face.axis] = at[face.axis] + inwards * BEFORE_FACE * job.grid.cell;
        let shape = Shape::Plane { point, normal };
        let body =
            Body { name: face.name(), shape, motion: Motion { path: Vec::new(), oscillation: None, servo: None } };
        job.bodies.push(RigidBody { body, contact, separates, at_face: false, side: None, group: None, seat: 0.0 });
    }
}

/// Bands that grains are to take the place of must be met, in time and by material.
fn check_known_bands(job: &Mpm, grains: &Granular, typed: &Typed, top: &Reader<'_>) -> Result<(), Error> {
    let Some(KnownBands { at, parts }) = &grains.known else { return Ok(()) };
    if job.oracle.is_some() {
        return Err(top.list("band")[0]
            .refusal_of_table("is known, and [oracle] looks for one as well. Remove one of the two."));
    }
    if *at >= job.end {
        let message =
            format!("is not before the run ends: time.end = {} s. Write less, or let it go on.", digits(job.end));
        return Err(typed.refusal("enrichment", "at", &message));
    }
    let domain = domain(&job.grid);
    for ([from, to], table) in parts.iter().zip(&top.list("band")) {
        check_inside(table, "from", &[from[0], from[1], 0.0], &domain)?;
        check_inside(table, "to", &[to[0], to[1], 0.0], &domain)?;
        let way = [to[0] - from[0], to[1] - from[1]];
        let steps = (2.0 * (way[0] * way[0] + way[1] * way[1]).sqrt() / job.grid.cell).ceil().max(1.0);
        let place = |step: f64| [from[0] + way[0] * step / steps, from[1] + way[1] * step / steps, 0.0];
        if !(0..=steps as usize).any(|step| job.region_at(&place(step as f64)).is_some()) {
            return Err(table.refusal_of_table("lies in no [[region]], where there is nothing that grains could take the place of. Move its ends, or remove it."));
        }
    }
    Ok(())
}

/// Loads are borne by points.
fn check_loads(job: &Mpm, grains: &Granular, typed: &Typed, top: &Reader<'_>) {
    for (load, table) in job.loads.iter().zip(&top.list("load")) {
        if grains.method == Method::Dem {
            typed.note_together(table.refusal_of_table("is borne by points, and this job has grains alone. Press by a [[body]] with a servo, or in the plane by a [[membrane]]; or write method = \"hybrid\" or \"mpm\"."));
        } else if grains.reference == Origin::Specimen && load.ramp == 0.0 {
            typed.note_together(table.refusal_of_table("is all there from the start, and the specimen that grains of a zone are taken from equilibrates without it. Let it rise from zero over a time, its ramp, or write enrichment.reference = \"piece\"."));
        }
    }
}

/// Grains that are everywhere from the start are those of the specimen, and nothing acts at points alone.
fn check_everywhere(job: &Mpm, grains: &Granular, typed: &Typed, top: &Reader<'_>) {
    if !grains.enrichment.life.is_everywhere {
        return;
    }
    if grains.known.is_some() {
        typed.note_together(typed.refusal("zone", "begins", "is for bands that the grains find, and [[band]] says where they are. Write \"band\", or remove [[band]] and enrichment.at."));
    }
    if grains.reference == Origin::Piece {
        typed.note_together(typed.refusal("enrichment", "reference", "makes no specimen, and zone.begins = \"everywhere\" begins with all of its grains. Write \"specimen\", or zone.begins = \"band\"."));
    }
    if let (Some(_), Some(table)) = (job.loads.first(), top.list("load").first()) {
        typed.note_together(table.refusal_of_table("is borne by points, and zone.begins = \"everywhere\" has none at the start. Press by a [[body]] with a servo or by a [[membrane]], or write zone.begins = \"band\"."));
    }
}

/// Heterogeneity is that of grains which lie in the whole specimen.
fn check_heterogeneity(job: &Mpm, grains: &Granular, typed: &Typed) {
    if !grains.is_heterogeneous || grains.method == Method::Dem {
        return;
    }
    let refused = |problem: &str| typed.note_together(typed.refusal("material", "heterogeneity", problem));
    if grains.reference == Origin::Piece {
        refused(
            "is that of a specimen, and enrichment.reference = \"piece\" makes none. Write \"none\", or reference = \"specimen\".",
        );
    }
    if job.grid.dimension == 3 || job.mesh.is_some() {
        refused("is told to points of a grid in the plane. Write \"none\".");
    }
    if !job.material.law.yields() {
        let names = ConstitutiveLaw::yielding();
        refused(&format!(
            "is one of solid volume fractions, which this law does not know. Write \"none\", or material.law = {names}."
        ));
    }
}

/// Pieces of packing are joined across a period; what nothing presses, or ends at it, is not.
fn check_periods(job: &Mpm, grains: &Granular, typed: &Typed, top: &Reader<'_>) {
    let (grid, mut axes) = (&job.grid, 0..job.grid.dimension);
    let (most, margin) = (diameter_max(&grains.piece), margin(&grains.piece));
    let least = PERIOD_IN_DIAMETERS * most + margin;
    for axis in axes.clone().filter(|axis| grid.periodic[*axis] && grid.extent(*axis) < least) {
        typed.note_together(typed.refusal(
            "grid",
            "upper",
            &format!(
                "makes the grid {} mm long along {}, where it is periodic, but four of the largest grains and the skin need {} mm. Make it longer, or take smaller grains.",
                digits(1e3 * grid.extent(axis)),
                AXES[axis],
                digits(1e3 * least)
            ),
        ));
    }
    let fills = |axis: usize| {
        let boxes = job.regions.iter().map(|region| bounding_box(&region.shape));
        let (lower, upper): (Vec<_>, Vec<_>) = boxes.map(|(lower, upper)| (lower[axis], upper[axis])).unzip();
        lower.into_iter().fold(f64::INFINITY, f64::min) < grid.lower[axis] + 0.5 * most
            && upper.into_iter().fold(f64::NEG_INFINITY, f64::max) > grid.upper[axis] - 0.5 * most
    };
    if axes.all(|axis| grid.periodic[axis] && fills(axis)) {
        typed.note_together(typed.refusal(
            "grid",
            "periodic",
            "leaves no side from which anything presses the grains, so that nothing says what stress they are under. Write false along one axis and hold them there by faces or bodies, or take [cell] for [grid], which is held at a stress.",
        ));
    }
    if grains.method == Method::Hybrid && grid.periodic[1] && job.oracle.is_none() {
        typed.note_together(typed.refusal(
            "grid",
            "periodic",
            "is true along y, and a zone reaches across periods along x alone. Turn the job by a quarter, or write false there.",
        ));
    }
    for (membrane, table) in job.membranes.iter().zip(&top.list("membrane")) {
        let end = |axis: &usize| {
            let [lower, upper] = membrane.extent(*axis);
            grid.periodic[*axis]
                && (lower < grid.lower[*axis] + membrane.spacing || upper > grid.upper[*axis] - membrane.spacing)
        };
        if let Some(axis) = (0..2).find(end) {
            let key = if matches!(membrane.path, Path::Circle { .. }) { "centre" } else { "from" };
            typed.note_together(table.refusal(
                key,
                &format!(
                    "brings the membrane to where the grid is periodic along {}: membranes are not joined across a period, and grains would come through between its ends. Keep it a segment away, press by a [[body]] with a seat or a servo, or set grid.periodic to false there.",
                    AXES[axis]
                ),
            ));
        }
    }
}

/// What grains that move ask of material and scheme.
pub fn check_method(job: &Mpm, grains: &Granular, typed: &Typed) {
    if grains.method == Method::Hybrid && !job.material.law.yields() && grains.known.is_none() {
        let other =
            if typed.kind == Kind::Mpm { ", or say by [[band]] where grains take the place of points" } else { "" };
        let names = ConstitutiveLaw::yielding();
        let problem = format!("never yields, so that no oracle finds a band in it. Write {names}{other}.");
        typed.note_together(typed.refusal("material", "law", &problem));
    }
    if job.scheme.shape != ShapeFunction::Quadratic {
        typed.note_together(typed.refusal(
            "scheme",
            "shape",
            "is not that of grains, which share nodes by quadratic splines. Write \"quadratic\".",
        ));
    }
    if job.scheme.update != StressUpdate::Last {
        typed.note_together(typed.refusal(
            "scheme",
            "update",
            "goes to the nodes twice a step, and grains share them once. In a job with grains write \"last\".",
        ));
    }
    check_coupling(job, grains, typed);
}

/// Penalty springs that shake the lightest grain apart, and exchanges that do not fit into a step of the continuum.
fn check_coupling(job: &Mpm, grains: &Granular, typed: &Typed) {
    let (piece, coupling) = (&grains.piece, &grains.coupling);
    let lightest = figures::grain(piece, diameters(piece).smallest).mass;
    // Grains alone between plates know no cycles, and those in membranes do.
    let is_coupled = grains.method == Method::Hybrid || !job.membranes.is_empty();
    if is_coupled && !job.grain_steps.is_multiple_of(coupling.interval) {
        let problem = format!(
            "does not divide time.grain_steps = {}: nodes and grains are together at the end of every step of the continuum. Write a number that does.",
            job.grain_steps
        );
        typed.note_together(typed.refusal("coupling", "interval", &problem));
        return;
    }
    if coupling.interval > 1 {
        let (contact, weight) = (figures::springs_of_mean_grains(piece), grains.enrichment.weight);
        let is_stable =
            |interval: u64| Coupling { interval, ..*coupling }.is_stable(&contact, job.step, (lightest, weight));
        if !is_stable(coupling.interval) {
            let fits = |interval: &u64| job.grain_steps.is_multiple_of(*interval) && is_stable(*interval);
            let advice = match (1..coupling.interval).rev().find(fits) {
                Some(most) => format!("Write at most {most}"),
                None => "Write 1, and a lower coupling.stiffness".to_string(),
            };
            let problem = format!(
                "is too long: between contacts, penalty springs of coupling.stiffness = {} and coupling.damping = {} become unstable. {advice}.",
                digits(coupling.stiffness),
                digits(coupling.damping),
            );
            typed.note_together(typed.refusal("coupling", "interval", &problem));
        }
        return;
    }
    let most = coupling.stiffness_max(figures::springs_mean(piece).normal, job.step, lightest);
    if coupling.stiffness <= most {
        return;
    }
    let problem = format!(
        "makes springs that swing the lightest grain farther with every step: with coupling.damping = {} at most {}.",
        digits(coupling.damping),
        significant(most, 3)
    );
    typed.note_together(typed.refusal("coupling", "stiffness", &problem));
}

/// What RVEs ask of the rest of the job: a stress everywhere at the start, and none below that of their packing.
fn check_rves(job: &Mpm, grains: &Granular, typed: &Typed) {
    if job.grain_steps > 1 {
        typed.note_together(typed.refusal(
            "time",
            "grain_steps",
            "counts steps of grains that share nodes, and those of RVEs follow from [rve]. Remove the line.",
        ));
    }
    let packed = stresses_of_packing(&grains.piece).last().copied().unwrap_or_default();
    let words = |least: f64| {
        format!(
            "is more than the {} kPa that the point under the least stress begins with, and RVEs are compressed from their packing on. Write at most that.",
            significant(1e-3 * least, 3)
        )
    };
    match job.stress {
        InitialStress::None => typed.note_together(typed.refusal(
            "stress",
            "kind",
            "is none, and grains of RVEs touch each other under a stress. Write kind = \"isotropic\" or \"geostatic\".",
        )),
        InitialStress::Isotropic { pressure } if packed > pressure * (1.0 + STRESS_SLACK) => {
            typed.note_together(typed.refusal("packing", "stress", &words(pressure)));
        }
        InitialStress::Isotropic { .. } => {}
        InitialStress::Geostatic { k0, .. } => {
            if k0 > 1.0 {
                typed.note_together(typed.refusal(
                    "stress",
                    "k0",
                    "is more than 1, and RVEs are compressed along all axes alike (1) or along gravity alone (less, and their grains say how much they bear across). Write at most 1.",
                ));
            }
            let least = pressures_at_start(job).first().copied().unwrap_or_default();
            if packed > least * (1.0 + STRESS_SLACK) {
                typed.note_together(typed.refusal("packing", "stress", &words(least)));
            }
        }
    }
}

/// What grains ask of the rest of the job.
pub fn check(job: &Mpm, typed: &Typed, top: &Reader<'_>) {
    for (body, table) in job.bodies.iter().zip(&top.list("body")) {
        let moves = body.body.motion.path.iter().any(|at| at.velocity != [0.0; 3]);
        if body.seat > 0.0 && (job.grains.is_none() || !moves || body.body.motion.servo.is_some()) {
            typed.note_together(table.refusal(
                "seat",
                "presses a body that moves along a path on grains before the run, and this job has no grains, or the body no path. Remove the line.",
            ));
        }
        let first = body.body.motion.path.iter().map(|at| at.velocity).find(|velocity| *velocity != [0.0; 3]);
        if let (true, Some(way), Shape::Plane { normal, .. }) = (body.seat > 0.0, first, &body.body.shape)
            && way.iter().zip(normal).map(|(way, normal)| way * normal).sum::<f64>() <= 0.0
        {
            typed.note_together(table.refusal(
                "seat",
                "presses the body along its first way, and that leads away from the grains. Remove the line, or let the path begin towards them.",
            ));
        }
    }
    let Some(grains) = &job.grains else { return };
    typed.check(check_as_piece(&grains.piece, typed));
    check_heterogeneity(job, grains, typed);
    match grains.method {
        Method::Mpm if !grains.is_heterogeneous => return,
        Method::Fem => return,
        Method::MpmDem | Method::FemDem => return check_rves(job, grains, typed),
        Method::Hybrid | Method::Dem | Method::Mpm => {}
    }
    check_method(job, grains, typed);
    if let Some(table) = top.list("follow").first() {
        typed.note_together(table.refusal_of_table("follows a point, which grains may replace. Remove it; frames.vtkhdf has every grain and point with its id."));
    }
    for (region, table) in job.regions.iter().zip(&top.list("region")) {
        if region.velocity != [0.0; 3] || region.spin != [0.0; 3] || !region.waves.is_empty() {
            typed.note_together(table.refusal_of_table("gives points a velocity, and grains begin at rest. Remove velocity, spin and wave; move a [[body]] instead."));
        }
    }
    let most = SKIN_MAX * job.grid.cell;
    if grains.piece.skin > most {
        typed.note_together(typed.refusal(
            "decomposition",
            "skin",
            &format!(
                "lets grains leave the nodes of their block before lists are made anew. Write at most {} mm.",
                digits(1e3 * most)
            ),
        ));
    }
    if job.ledger && grains.method == Method::Hybrid {
        let life = grains.enrichment.life;
        if life.grows || life.dissolves {
            typed.note_together(typed.refusal("output", "energy_balance", LEDGER_OF_LIVING_ZONE));
        }
        if job.grain_steps > 1 {
            typed.note_together(typed.refusal("output", "energy_balance", "books what grains and points do to each other step by step, and time.grain_steps takes several steps of grains in one of points. Remove it, or write time.grain_steps = 1."));
        }
    }
    check_loads(job, grains, typed, top);
    for face in Face::all(job.grid.dimension) {
        if job.boundaries[face.axis][usize::from(face.upper)] == Boundary::Absorbing {
            typed.note_together(top.refusal(
                "boundary",
                &format!(
                    "takes waves from nodes at {}, and grains have no such dashpots. Write kind = \"fixed\", \"roller\" or \"friction\" for that face.",
                    face.name()
                ),
            ));
        }
    }
    if job.bodies.len() > BODIES_MAX {
        let [most, now] = [BODIES_MAX, job.bodies.len()];
        let message = format!(
            "makes {now} bodies with the planes that stand in for faces, and a job may have {most}. Write kind = \"free\" for faces that nothing reaches, or remove bodies."
        );
        typed.note_together(top.refusal("boundary", &message));
    }
    check_periods(job, grains, typed, top);
    let ramped = job.membranes.iter().zip(top.list("membrane")).find(|(membrane, _)| membrane.ramp > 0.0);
    if let Some((_, table)) = ramped {
        typed.note_together(table.refusal(
            "ramp",
            "lets go of grains that have equilibrated under the whole pressure before the run. Remove the line.",
        ));
    }
    if job.gravity.ramp > 0.0 {
        typed.note_together(typed.refusal(
            "gravity",
            "ramp",
            "lets go of grains that have equilibrated under all of gravity before the run. Remove the line.",
        ));
    }
    let (edge, least) =
        (job.cells_per_block as f64 * job.grid.cell, 2.0 * diameter_max(&grains.piece) + margin(&grains.piece));
    if edge < least {
        typed.note_together(typed.refusal(
            "decomposition",
            "cells_per_block",
            &format!(
                "makes blocks of {} mm, shorter than two of the largest grains and the skin, {} mm. Take more cells.",
                digits(1e3 * edge),
                digits(1e3 * least)
            ),
        ));
    }
    let distance = grains.enrichment.distance;
    if grains.method == Method::Hybrid {
        if job.oracle.is_none() && grains.known.is_none() {
            typed.note_together(top.refusal("method", "puts grains where a band persists, and nothing looks for one. Add [oracle], or [[band]] where one is known, or write \"mpm\" or \"dem\"."));
        }
        typed.check(check_known_bands(job, grains, typed, top));
        typed.check(check_life(&grains.enrichment, typed));
        if job.oracle.is_none() {
            let life = grains.enrichment.life;
            let key = if life.grows { Some("grows") } else { life.dissolves.then_some("dissolves") };
            if let Some(key) = key {
                typed.note_together(typed.refusal("zone", key, "lets a zone live by what the oracle sees, and bands that are known have none. Write false, or put [oracle] in the place of [[band]] and enrichment.at."));
            }
        }
        check_everywhere(job, grains, typed, top);
        if distance < CELLS_OF_ZONE * job.grid.cell {
            let least = CELLS_OF_ZONE * job.grid.cell;
            typed.note_together(typed.refusal(
                "enrichment",
                "distance",
                &format!(
                    "leaves no cell of grains alone between rims of one cell. Write at least {} m.",
                    digits(least)
                ),
            ));
        }
    }
}
