//! Grains in a cell.

use std::path::Path;

use super::body::{Domain, bodies};
use super::checks::check;
use super::contact::contact;
use super::limits::{refuse_speed_of_body, refuse_steps};
use super::{
    BLOCK_OF_DISCS, CACHE_DEFAULT, DEPTH_DEFAULT, PACKING_ENERGY_RATIO_DEFAULT, PACKING_FRACTION_DEFAULT, PACKING_FRICTION_DEFAULT,
    SKIN_DEFAULT, folder_of, name, output_with_contacts, refuse_wide_sizes,
};
use crate::base::error::Error;
use crate::dem::motion::{Damping, DampingForm};
use crate::job::assembly::{Assembly, Cell, CellServo, Matter, Packed, Preparation, Read, Sizes, Source, Velocities};
use crate::job::raw::{Reader, Typed};
use crate::job::stable;

/// Packing fraction of a loose start of spheres; thrown one after the other they jam at 0.38.
const PACKING_FRACTION_SPHERES: f64 = 0.25;
/// Edge of a block in mean diameters: fewer than of discs, so that a block holds some hundred grains in both.
const BLOCK_OF_SPHERES: f64 = 6.0;
/// How exactly shares of sizes add up to 1.
const SHARES_TOLERANCE: f64 = 1e-9;

/// Keys of `[cell]` that only axes held at a stress need.
const OF_SERVO: [&str; 3] = ["rate_max", "stress_gain", "stress_interval"];

/// How the keys of `[grains]` part by how diameters are spread.
const OF_DISTRIBUTION: [(&str, &[&str]); 3] = [
    ("normal", &["diameter_mean", "diameter_deviation"]),
    ("uniform", &["diameter_min", "diameter_max"]),
    ("list", &["diameters"]),
];
/// Keys of `[grains]` that only grains to be made need.
const OF_MADE: [&str; 6] = ["count", "distribution", "diameter_deviation", "diameter_min", "diameter_max", "diameters"];
/// How the keys of `[packing]` part by the preparation.
const OF_PREPARATION: [(&str, &[&str]); 2] = [("compress", &["stress", "fraction", "unloaded"]), ("pour", &[])];

/// The checked assembly of a job; `file` is the job's path, whose folder relative paths start from.
pub fn assembly(typed: &Typed, file: &str) -> Result<Assembly, Error> {
    let why = "an assembly of grains";
    let top = typed.table("", true, why);
    let (name, seed) = (name(&top)?, top.count_or("seed", 1));
    let folder = folder_of(file);

    let (cell, gravity) = cell(typed.table("cell", true, why))?;
    let grains = typed.table("grains", true, why);
    let packing = typed.table("packing", false, why);
    let (matter, source) = source(&grains, &packing, &cell, &folder)?;
    let mass_mean = stable::grain_mass(matter.density, 0.5 * matter.diameter_mean, cell.depth, cell.dimension);
    let contact = contact(&typed.table("contact", true, why), mass_mean)?;
    let time = typed.table("time", true, why);
    let step = time.number("step");
    let end = time.number("end");
    let cut = typed.table("decomposition", false, why);
    let shown = typed.table("output", false, why);
    let block = if cell.dimension == 2 { BLOCK_OF_DISCS } else { BLOCK_OF_SPHERES };

    let domain = Domain {
        name: "cell",
        dimension: cell.dimension,
        lower: cell.lower,
        upper: cell.upper,
        periodic: cell.periodic,
    };
    let bodies = bodies(&top.with_axes(cell.dimension), &domain);
    for (body, table) in &bodies {
        typed.check(refuse_speed_of_body(body, table, step, matter.diameter_mean));
    }
    let bodies = bodies.into_iter().map(|(body, _)| body).collect();

    refuse_steps(typed, end, step, "time.end")?;
    let assembly = Assembly {
        name,
        seed,
        matter,
        source,
        contact,
        damping: damping(&typed.table("damping", false, why)),
        gravity,
        bodies,
        step,
        end,
        velocities: time.choice_or("velocities", "time of velocities", &VELOCITIES, Velocities::Now),
        allow_unstable: time.flag_or("allow_unstable", false),
        skin: cut.number_or("skin", SKIN_DEFAULT * matter.diameter_mean),
        block: cut.number_or("block", block * matter.diameter_mean),
        output: output_with_contacts(&shown, end, step)?,
        ledger: shown.flag_or("ledger", false),
        cell,
    };
    typed.stop_if_wrong()?;
    check(&assembly, typed);
    Ok(assembly)
}

/// The cell and the acceleration in it.
fn cell(table: Reader<'_>) -> Result<(Cell, [f64; 3]), Error> {
    let dimension = table.choose("space", "space", &[("plane", 2), ("solid", 3)]);
    let table = table.with_axes(dimension);
    if dimension == 3 && table.has("depth") {
        return Err(table.refusal("depth", "belongs to space = \"plane\"; spheres have no depth. Remove the line."));
    }
    let cell = Cell {
        dimension,
        lower: table.vector_if_given("lower").unwrap_or_default(),
        upper: table.vector("upper"),
        periodic: table.flags_or("periodic", true),
        depth: table.number_or("depth", if dimension == 2 { DEPTH_DEFAULT } else { 1.0 }),
        gradient: table.gradient("velocity_gradient"),
        servo: cell_servo(&table)?,
    };
    if (0..dimension).any(|axis| cell.upper[axis] <= cell.lower[axis]) {
        return Err(table.refusal("upper", "encloses nothing: it must be more than lower along every axis."));
    }
    Ok((cell, table.vector_if_given("gravity").unwrap_or_default()))
}

fn cell_servo(table: &Reader<'_>) -> Result<Option<CellServo>, Error> {
    let Some(stress) = table.stresses("stress") else {
        return match OF_SERVO.into_iter().find(|key| table.has(key)) {
            Some(key) => Err(table
                .refusal(key, "is of axes held at a stress, and there is no cell.stress. Add it, or remove the line.")),
            None => Ok(None),
        };
    };
    let rate_max = table.number("rate_max");
    let gain = table.number_or("stress_gain", CellServo::GAIN);
    let interval = table.count_or("stress_interval", CellServo::INTERVAL);
    Ok(Some(CellServo { stress, rate_max, gain, interval }))
}

pub(super) fn source(
    grains: &Reader<'_>,
    packing: &Reader<'_>,
    cell: &Cell,
    folder: &Path,
) -> Result<(Matter, Source), Error> {
    let density = grains.number("density");
    if let Some(file) = grains.text_if_given("file") {
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
        let matter = Matter { density, diameter_mean: grains.number("diameter_mean") };
        let contacts = grains.text_if_given("contacts").map(|contacts| folder.join(contacts));
        return Ok((matter, Source::File(Read { grains: folder.join(file), contacts })));
    }
    if grains.has("contacts") {
        return Err(grains.refusal(
            "contacts",
            "is what contacts of grains from a file remember, and there is no grains.file. Add it, or remove the line.",
        ));
    }
    let Some(count) = grains.count_if_given("count") else {
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
    let distribution = grains.choice_or("distribution", "distribution", &names, "normal");
    grains.note_keys_of_others("distribution", distribution, &OF_DISTRIBUTION);
    match distribution {
        "normal" => {
            let (mean, deviation) = (grains.number("diameter_mean"), grains.number("diameter_deviation"));
            refuse_wide_sizes(grains, mean, deviation)?;
            Ok(Sizes::Normal { mean, deviation })
        }
        "uniform" => {
            let (min, max) = (grains.number("diameter_min"), grains.number("diameter_max"));
            match min <= max {
                true => Ok(Sizes::Uniform { min, max }),
                false => Err(grains.refusal("diameter_max", "is less than grains.diameter_min. Exchange them.")),
            }
        }
        _ => {
            let list = grains.shares("diameters");
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
    let Some(preparation) = table.choice("preparation", "preparation", &names) else {
        return Err(table.refusal_of_table(
            "must say how the grains of grains.count are made. Add preparation = \"compress\" with a stress, or preparation = \"pour\".",
        ));
    };
    table.note_keys_of_others("preparation", preparation, &OF_PREPARATION);
    let preparation = match preparation {
        "compress" => Preparation::Compress {
            stress: table.number("stress"),
            fraction: table.number_if_given("fraction"),
            unloaded: table.number_if_given("unloaded"),
        },
        _ => Preparation::Pour,
    };
    let fraction_start = if cell.dimension == 2 { PACKING_FRACTION_DEFAULT } else { PACKING_FRACTION_SPHERES };
    Ok(Packed {
        sizes,
        count,
        preparation,
        friction: table.number_or("friction", PACKING_FRICTION_DEFAULT),
        fraction_start: table.number_or("fraction_start", fraction_start),
        energy_ratio_max: table.number_or("energy_ratio_max", PACKING_ENERGY_RATIO_DEFAULT),
        cache: folder.join(table.text_if_given("cache").unwrap_or_else(|| CACHE_DEFAULT.into())),
    })
}

const VELOCITIES: [(&str, Velocities); 2] =
    [("now", Velocities::Now), ("half_step_before", Velocities::HalfStepBefore)];

fn damping(table: &Reader<'_>) -> Damping {
    let forms = [("vector", DampingForm::Vector), ("component", DampingForm::Component)];
    Damping {
        local: table.number_or("local", 0.0),
        form: table.choice_or("form", "form of local damping", &forms, DampingForm::Vector),
        mass: table.number_or("mass", 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Job;
    use crate::job::assembly::{BodyServo, PathPoint, Shape};
    use crate::law::contact::Contact;

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
            "cell.stress=[\"-50 kPa\", \"free\"]",
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
        let Contact::Linear(law) = assembly.contact else { panic!("by default") };
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
