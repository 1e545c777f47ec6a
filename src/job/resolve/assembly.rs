//! Grains in a cell.

use super::body::{Domain, check_bodies};
use super::checks::check;
use super::limits::{refuse_speed_of_body, refuse_steps};
use super::{BLOCK_OF_DISCS, BLOCK_OF_SPHERES, SKIN_DEFAULT, check_name, output, refuse_wide_sizes};
use crate::base::error::Error;
use crate::base::keys::Form;
use crate::job::assembly::{Assembly, Packed, Sizes, Source, keys_of_grains};
use crate::job::figures;
use crate::job::raw::{Reader, Typed};
use crate::job::stable;

/// Edge of a block in mean diameters: fewer than of discs, so that a block holds some hundred grains in both.
/// How exactly shares of sizes add up to 1.
const SHARES_TOLERANCE: f64 = 1e-9;

/// The checked assembly of a job.
pub fn assembly(typed: &Typed) -> Result<Assembly, Error> {
    let why = "an assembly of grains";
    let mut job = Assembly::blank();
    let mut top = typed.table("", true, why);
    job.head(&mut top);
    check_name(&top, &job.name);

    let mut cell = typed.table("cell", true, why);
    job.keys_of_cell(&mut cell);
    if (0..job.cell.dimension).any(|axis| job.cell.upper[axis] <= job.cell.lower[axis]) {
        typed.note_together(cell.refusal("upper", "encloses nothing: it must be more than lower along every axis."));
    }
    read_grains(&mut job, typed, why);
    let discs = job.cell.dimension == 2;
    let diameter = job.matter.diameter_mean;
    let mass_mean = stable::grain_mass(job.matter.density, 0.5 * diameter, job.cell.depth, job.cell.dimension);
    job.contact.keys(&mut typed.table("contact", true, why), mass_mean);
    job.damping.keys(&mut typed.table("damping", false, why));
    let mut time = typed.table("time", true, why);
    job.keys_of_time(&mut time);
    (job.skin, job.block) = (SKIN_DEFAULT * diameter, if discs { BLOCK_OF_DISCS } else { BLOCK_OF_SPHERES } * diameter);
    job.keys_of_decomposition(&mut typed.table("decomposition", false, why));

    let mut top = top.with_axes(job.cell.dimension);
    crate::job::assembly::Body::list(&mut job.bodies, &mut top);
    let domain = Domain {
        name: "cell",
        dimension: job.cell.dimension,
        lower: job.cell.lower,
        upper: job.cell.end(),
        periodic: job.cell.periodic,
        coheres: job.contact.coheres(),
    };
    check_bodies(job.bodies.iter_mut(), &top, &domain);
    if !time.has("step") {
        job.step = stable::step_default(&figures::bounds(&job));
    }
    for (body, table) in job.bodies.iter().zip(&top.list("body")) {
        typed.check(refuse_speed_of_body(body, table, job.step, diameter));
    }
    refuse_steps(typed, job.end, job.step, "time.end")?;
    (job.output, job.ledger) = output(&mut typed.table("output", false, why), job.end, job.step)?;
    typed.stop_if_wrong()?;
    check(&job, typed);
    Ok(job)
}

/// `[grains]`, and of those that are made `[packing]`.
pub(super) fn read_grains(job: &mut Assembly, typed: &Typed, why: &str) {
    let mut grains = typed.table("grains", true, why);
    job.source = Source::Packed(Packed::blank(job.cell.dimension));
    keys_of_grains(&mut grains, &mut job.matter, &mut job.source);
    let mut packing = typed.table("packing", matches!(job.source, Source::Packed(_)), why);
    match &mut job.source {
        Source::Packed(packed) => {
            packed.keys(&mut packing);
            typed.check(check_sizes(&packed.sizes, &grains));
        }
        Source::File(_) if packing.is_typed() => typed.note_together(
            packing.refusal_of_table("makes grains, and grains.file says that they are read. Remove one of the two."),
        ),
        Source::File(_) => {}
    }
}

fn check_sizes(sizes: &Sizes, table: &Reader<'_>) -> Result<(), Error> {
    match sizes {
        Sizes::Normal { mean, deviation } => refuse_wide_sizes(table, *mean, *deviation),
        Sizes::Uniform { min, max } if min > max => {
            Err(table.refusal("diameter_max", "is less than grains.diameter_min. Exchange them."))
        }
        Sizes::Uniform { .. } => Ok(()),
        Sizes::List(list) => {
            let sum: f64 = list.iter().map(|(_, share)| share).sum();
            if (sum - 1.0).abs() <= SHARES_TOLERANCE {
                return Ok(());
            }
            let sum = super::digits(sum);
            let problem = format!("does not add up: the shares of all diameters make {sum}, and 1 is wanted.");
            Err(table.refusal("diameters", &problem))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Job;
    use std::path::Path;

    use crate::dem::motion::Damping;
    use crate::job::assembly::{BodyServo, CellServo, PathPoint, Read, Shape};
    use crate::law::contact::Force;

    const PLANE: &str = r#"
        name = "small"
        [cell]
        space = "plane"
        upper = ["2 cm", "3 cm"]
        [grains]
        density = 2500
        count = 300
        diameter_mean = "1 mm"
        diameter_deviation = "0.1 mm"
        [packing]
        preparation = "compress"
        stress = "100 kPa"
        [contact]
        stiffness_normal = 1e6
        stiffness_tangential = 5e5
        restitution = 0.3
        friction = 0.5
        [time]
        step = "0.2 us"
        end = "10 ms"
    "#;
    const SOLID: &str = r#"
        name = "small"
        [cell]
        space = "solid"
        lower = [-0.1, -0.1, 0]
        upper = [0.1, 0.1, 0.5]
        periodic = [true, true, false]
        gravity = [0, "9.81 m/s2", "-9.81 m/s2"]
        [grains]
        density = 2500
        count = 300
        distribution = "list"
        diameters = [["4 mm", 0.3], ["5 mm", 0.7]]
        [packing]
        preparation = "pour"
        [contact]
        law = "hertz_mindlin"
        shear_modulus = "100 MPa"
        poisson_ratio = 0.2
        friction = 0.5
        [damping]
        local = 0.2
        [time]
        step = "2 us"
        end = 1
        [[body]]
        name = "floor"
        shape = "plane"
        point = [0, 0, 0]
        normal = [0, 0, 2]
        [[body]]
        name = "rod"
        shape = "cylinder"
        centre = [0, 0, "10 cm"]
        radius = "2 cm"
        axis = [1, 1, 0]
        spin = [3, 3, 0]
        ramp = "0.1 s"
        [[body]]
        name = "lid"
        shape = "box"
        lower = [-0.1, -0.1, 0.4]
        upper = [0.1, 0.1, 0.45]
        path = [{time = 0}, {time = 0.5, velocity = ["1 cm/s", 0, 0]}]
        [body.servo]
        direction = [0, 0, 3]
        stress = "1 kPa"
        area = "400 cm2"
        mass = "2 kg"
        damping = "50 N s/m"
        speed_max = "5 cm/s"
    "#;

    /// Resolved twice, so that every test of a good job is one of its written form.
    fn assembly_of(text: &str, sets: &[&str]) -> Assembly {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
        let job = Job::parse(text, "/jobs/small.toml", &sets).unwrap_or_else(|error| panic!("{error}"));
        let back = Job::parse(&job.to_toml(), "elsewhere/job.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(back, job);
        assert_eq!(back.to_toml(), job.to_toml());
        match job {
            Job::Assembly(assembly) => assembly,
            Job::Shear(_) | Job::Mpm(_) => panic!("it has a cell"),
        }
    }

    #[test]
    fn defaults_in_the_plane() {
        let assembly = assembly_of(PLANE, &[]);
        assert_eq!((assembly.cell.depth, assembly.cell.periodic, assembly.seed), (0.01, [true, true, false], 1));
        assert_eq!((assembly.cell.lower, assembly.cell.gradient), ([0.0; 3], [[0.0; 3]; 3]));
        assert_eq!((assembly.skin, assembly.block, assembly.damping), (1e-4, 0.012, Damping::default()));
        assert!(!assembly.allow_unstable && assembly.bodies.is_empty() && assembly.gravity == [0.0; 3]);
        let Source::Packed(packed) = &assembly.source else { panic!("as it was asked for") };
        assert_eq!((packed.fraction_start, packed.friction), (0.45, 0.01));
        assert_eq!(packed.cache, Path::new("/jobs/cache"));
        assert_eq!(assembly.output.series_interval, 0.01 / 500.0);
    }

    #[test]
    fn a_cell_that_deforms() {
        let sets = [
            "cell.velocity_gradient=[[0, \"2 1/s\"], [0, -0.1]]",
            "cell.stress_normal=[\"50 kPa\", \"free\"]",
            "cell.rate_max=3",
            "cell.stress_gain=0.25",
        ];
        let assembly = assembly_of(PLANE, &sets);
        assert_eq!(assembly.cell.gradient[0], [0.0, 2.0, 0.0]);
        let servo =
            CellServo { stress: [Some(-50e3), None, None], rate_max: 3.0, gain: 0.25, interval: CellServo::INTERVAL };
        assert_eq!(assembly.cell.servo, Some(servo));
    }

    #[test]
    fn bodies_and_gravity_in_space() {
        let assembly = assembly_of(SOLID, &["body.0.velocity=[0, \"1 m/s\", 0]"]);
        assert_eq!(assembly.gravity, [0.0, 9.81, -9.81]);
        assert!((assembly.matter.diameter_mean - 4.7e-3).abs() < 1e-18);
        let [floor, rod, lid] = assembly.bodies.as_slice() else { panic!("three bodies") };
        assert_eq!(floor.shape, Shape::Plane { point: [0.0; 3], normal: [0.0, 0.0, 1.0] });
        assert_eq!(floor.motion.path, [PathPoint { time: 0.0, velocity: [0.0, 1.0, 0.0], spin: [0.0; 3] }]);
        let Shape::Cylinder { axis, .. } = rod.shape else { panic!("as it was asked for") };
        assert_eq!(axis, [1.0 / 2.0f64.sqrt(), 1.0 / 2.0f64.sqrt(), 0.0]);
        let [rest, full] = rod.motion.path.as_slice() else { panic!("a ramp has two ends") };
        assert_eq!((rest.spin, full.time, full.spin), ([0.0; 3], 0.1, [3.0, 3.0, 0.0]));
        assert_eq!(lid.motion.path[1].velocity, [0.01, 0.0, 0.0]);
        let servo = BodyServo { direction: [0.0, 0.0, 1.0], force: 40.0, mass: 2.0, damping: 50.0, speed_max: 0.05 };
        assert_eq!(lid.motion.servo, Some(servo));
    }

    #[test]
    fn a_layer_and_a_disc_in_the_plane() {
        let bodies = "body=[{name = \"rough\", shape = \"layer\", lower = [0, 0], upper = [0.02, 0.003], velocity = [1, 0]}, {name = \"drum\", shape = \"cylinder\", centre = [0.01, 0.02], radius = \"2 mm\", spin = \"-3 rad/s\"}]";
        let assembly = assembly_of(PLANE, &[bodies]);
        assert_eq!(assembly.bodies[1].motion.path[0].spin, [0.0, 0.0, -3.0]);
        assert_eq!(
            assembly.bodies[1].shape,
            Shape::Cylinder { centre: [0.01, 0.02, 0.0], radius: 2e-3, axis: [0.0, 0.0, 1.0] }
        );
    }

    /// A file's grains are not known here, so the job says how large they are in the mean.
    #[test]
    fn grains_from_a_file() {
        let text = PLANE.replace("count = 300", "file = \"g.csv\"").replace("diameter_deviation = \"0.1 mm\"", "");
        let text = text.replace("[packing]\n        preparation = \"compress\"\n        stress = \"100 kPa\"", "");
        let assembly = assembly_of(&text, &[]);
        assert_eq!(assembly.source, Source::File(Read { grains: "/jobs/g.csv".into(), contacts: None }));
        let Force::Linear(law) = assembly.contact.force else { panic!("by default") };
        assert!(law.damping_normal > 0.0);
        assert_eq!(assembly.matter.diameter_mean, 1e-3);
    }

    #[test]
    fn uniform_sizes_and_an_unstable_step() {
        let text = PLANE
            .replace("diameter_mean = \"1 mm\"", "distribution = \"uniform\"\ndiameter_min = 8e-4")
            .replace("diameter_deviation = \"0.1 mm\"", "diameter_max = \"1.2 mm\"");
        let assembly = assembly_of(&text, &["time.step=\"2 us\"", "time.allow_unstable=true", "packing.fraction=0.85"]);
        assert_eq!(assembly.matter.diameter_mean, 1e-3);
        assert!(assembly.allow_unstable);
    }
}
