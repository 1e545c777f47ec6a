//! Material points that carry grain assemblies: the RVE of a point is the one that stands alone, and nothing of ranks, threads, blocks or
//! restarts shows.

use scree::base::space::{Plane, Space};
use scree::domain::world::World;
use scree::export::rve_export;
use scree::job::{Job, Mpm};
use scree::run::experiment::Setup;
use scree::run::grid::Points;
use scree::run::start;
use scree::rve::{Rve, Scratch};
use scree::store::checkpoint;
use scree_io::column::Values;
use scree_partition::Solo;

use crate::alone::Beside;
use crate::runs::{Ran, UPDATES, done, options, parse, same};

const GRAINS: &str = r#"
    [material]
    law = "grains"
    [grains]
    density = "2650 kg/m3"
    count = 100
    distribution = "uniform"
    diameter_min = "6 mm"
    diameter_max = "14 mm"
    [packing]
    preparation = "compress"
    stress = "100 kPa"
    friction = 0.1
    [contact]
    law = "elastic_rolling"
    young_modulus = "60 MPa"
    stiffness_ratio = 0.8
    friction = 0.545
    [damping]
    local = 0.1
    form = "component"
"#;

const SPHERES: &str = r#"
    [material]
    law = "grains"
    [grains]
    density = "2650 kg/m3"
    count = 200
    distribution = "uniform"
    diameter_min = "8 mm"
    diameter_max = "12 mm"
    [packing]
    preparation = "compress"
    stress = "100 kPa"
    energy_ratio_max = 1e-2
    [contact]
    law = "hertz_mindlin"
    shear_modulus = "290 MPa"
    poisson_ratio = 0.15
    friction = 0.5
"#;

/// A block between a rough ground and a rough plate that presses it, under a pressure at its sides.
fn pressed(dimension: usize, scheme: &str, rest: &str) -> String {
    let (space, grains) = if dimension == 2 { ("plane", GRAINS) } else { ("solid", SPHERES) };
    let (grid, region, plate) = match dimension {
        2 => (
            "upper = [1.2, 0.8]\ndepth = \"10 cm\"",
            "lower = [0.4, 0]\nupper = [0.8, 0.4]",
            "lower = [0.1, 0.4]\nupper = [1.1, 0.7]",
        ),
        _ => (
            "upper = [1.2, 0.8, 0.8]",
            "lower = [0.4, 0, 0.2]\nupper = [0.8, 0.4, 0.6]",
            "lower = [0.1, 0.4, 0]\nupper = [1.1, 0.7, 0.8]",
        ),
    };
    let cache = std::env::temp_dir().join("scree-test-mpm-dem");
    let grains = grains.replace("[packing]", &format!("[packing]\n    cache = {:?}", cache.display().to_string()));
    let sides: String = ["x_lower", "x_upper"]
        .map(|face| format!("[[load]]\nface = \"{face}\"\nkind = \"pressure\"\npressure = \"100 kPa\"\n"))
        .concat();
    format!(
        r#"
        name = "pressed"
        method = "mpm_dem"
        [grid]
        space = "{space}"
        {grid}
        cell = 0.2
        [scheme]
        points_per_cell = 1
        {scheme}
        {grains}
        [stress]
        kind = "isotropic"
        pressure = "100 kPa"
        [[region]]
        shape = "box"
        {region}
        [[boundary]]
        face = "y_lower"
        kind = "fixed"
        {sides}
        [[body]]
        name = "plate"
        shape = "box"
        {plate}
        velocity = [{velocity}]
        ramp = "5 ms"
        contact = "rough"
        {rest}
        "#,
        velocity = if dimension == 2 { "0.1, -0.4" } else { "0.1, -0.4, 0" }
    )
}

const QUIET: &str = "shape = \"generalised\"\nupdate = \"first\"\ntransfer = \"blend\"\nflip = 0.9";

fn job(text: &str) -> Mpm {
    let Job::Mpm(job) = parse(text) else { panic!("it has no grid") };
    job
}

fn begun<S: Space>(job: &Mpm) -> World<'static, S> {
    Points::<S>::new(job).begin(&mut None, &Solo).unwrap().0
}

/// The RVE of a point, driven by the deformation gradients that the point had, comes to the same bits by itself.
#[test]
fn an_rve_alone_follows_its_point() {
    for update in UPDATES {
        let scheme = format!("shape = \"quadratic\"\nupdate = \"{update}\"");
        let job = job(&pressed(2, &scheme, "[time]\nend = 1\nsafety = 0.3\n[decomposition]\ncells_per_block = 2"));
        let mut world = begun::<Plane>(&job);
        let last = world.rves.len() - 1;
        let id = world.continuum.points.cold[last].id;
        let mut alone: Rve<Plane> = world.rves[last].rve.clone();
        let drive = job.grains.as_ref().unwrap().rves.drive;
        let scratch = &mut Scratch::default();
        for step in 0..60 {
            world.advance().unwrap();
            let row = world.continuum.points.cold.iter().position(|cold| cold.id == id).unwrap();
            let hot = &world.continuum.points.hot[row];
            let answer = alone.follow(&hot.deformation, job.step, &drive, scratch).unwrap();
            assert_eq!(answer.kirchhoff, hot.stress, "{update}, step {step}");
            assert!(world.rves[row].rve.rest() == alone.rest(), "{update}, step {step}");
        }
        assert!((alone.deformation().determinant() - 1.0).abs() > 1e-4, "{update}: {}", alone.deformation());
    }
}

/// Four points between walls, a plate and a pressure answer as their RVE does that is compressed by itself (Liang & Zhao 2019, 3.1).
#[test]
fn an_element_is_its_rve() {
    const PRESSURE: f64 = 100e3;
    let cache = std::env::temp_dir().join("scree-test-mpm-dem").display().to_string();
    let text = include_str!("../../jobs/mpm_dem/element.toml").replace("\"../cache\"", &format!("{cache:?}"));
    let job = job(&text);
    let mut world = begun::<Plane>(&job);
    let mut beside = Beside::new(&world.rves[0].rve, PRESSURE, job.grains.as_ref().unwrap().rves.drive);
    for _ in 0..(job.end / job.step) as usize {
        world.advance().unwrap();
        let hot = &world.continuum.points.hot;
        let cauchy = |point: usize, axis: usize| -hot[point].kirchhoff()[3 * axis] / hot[point].volume_ratio();
        let borne = [0, 1].map(|axis| (0..4).map(|point| cauchy(point, axis)).sum::<f64>() / 4.0);
        let mean = (0..4).fold(<Plane as Space>::Tensor::zeros(), |sum, point| sum + hot[point].deformation * 0.25);
        beside.compare(borne, &mean, job.step);
    }
    let off = beside.off();
    println!("an element of four points: {off}");
    // Beyond half a per cent grains rearrange, and one RVE differs from itself by as much.
    assert!(off.early < 2e-3 && off.to_peak < 0.02 && off.across < 3e-3 && off.left < 1e-3, "{off}");
}

/// The same bits on ranks and threads, through restarts, with RVEs of several packings; in the plane and in space, and with a mean strain.
#[test]
fn rves_end_in_the_same_bits() {
    let reference = "[nonlocal]\nradius = 0.45\n";
    let current = "[nonlocal]\nradius = 0.45\nplaces = \"current\"\n";
    let lagging = "[nonlocal]\nradius = 0.45\nlag = 1\n";
    let cases = [
        (2, "first", ""),
        (2, "last", reference),
        (2, "modified_last", current),
        (2, "first", lagging),
        (3, "first", ""),
    ];
    for (dimension, update, nonlocal) in cases {
        let scheme = format!("shape = \"quadratic\"\nupdate = \"{update}\"\ntransfer = \"affine\"");
        let rest = "[time]\nend = \"25 ms\"\n[decomposition]\ncells_per_block = 2\n[rve]\npackings = 2\nsafety = 0.8\n[output]\ncheckpoint_interval = \"10 ms\"\nframe_interval = \"10 ms\"\n[[follow]]\nname = \"corner\"\n";
        let place = if dimension == 2 { "place = [0.5, 0.3]" } else { "place = [0.5, 0.3, 0.5]" };
        let folder = tempfile::tempdir().unwrap();
        let text = pressed(dimension, &scheme, &format!("{nonlocal}{rest}{place}"));
        same(&parse(&text), folder.path(), &format!("{dimension}D {update} {nonlocal}"));
    }
}

/// A bed under gravity whose RVEs have been compressed to what lies above them stays at rest.
#[test]
fn a_bed_of_rves_rests_under_gravity() {
    let scheme = "shape = \"quadratic\"\nupdate = \"last\"\npoints_per_cell = 2";
    let text = pressed(2, scheme, "[time]\nend = \"0.2 s\"\n[gravity]\nacceleration = [0, \"-9.81 m/s2\"]\n");
    let (before, after) = (text.find("[[region]]").unwrap(), text.find("[time]").unwrap());
    let geostatic = "[[region]]\nshape = \"box\"\nlower = [0, 0]\nupper = [1.2, 0.6]\n[[boundary]]\nface = \"y_upper\"\nkind = \"free\"\n";
    let bed = format!("{}{geostatic}{}", &text[..before], &text[after..])
        .replace("points_per_cell = 1", "")
        .replace("kind = \"isotropic\"\n        pressure = \"100 kPa\"", "kind = \"geostatic\"\nsurface = 0.6\nk0 = 1")
        .replace("stress = \"100 kPa\"", "stress = \"1 kPa\"");
    let ran = Ran::of(&bed);
    let speeds = ran
        .points("velocity")
        .into_iter()
        .map(|velocity| (velocity[0] * velocity[0] + velocity[1] * velocity[1]).sqrt());
    let fastest = speeds.fold(0.0, f64::max) / (9.81_f64 * 0.6).sqrt();
    println!("the fastest point has {fastest:.1e} of sqrt(g h)");
    assert!(fastest < 1e-3, "{fastest}");
}

/// The series tells of all RVEs together, and of those of points that are followed.
#[test]
fn all_rves_are_told_of() {
    let rest = "[time]\nend = \"20 ms\"\n[[follow]]\nname = \"corner\"\nplace = [0.5, 0.3]";
    let ran = Ran::of(&pressed(2, QUIET, rest));
    let [steps, pairs, loose] =
        ["rve_steps", "rve_pair_steps", "rve_loose"].map(|name| *ran.series(name).last().unwrap());
    assert!(steps > 0.0 && pairs > 100.0 * steps && loose == 0.0, "{steps} {pairs} {loose}");
    let of = |name: &str| *ran.series(&format!("corner_{name}")).last().unwrap();
    assert!((2.0..5.5).contains(&of("coordination")), "{}", of("coordination"));
    assert!((0.1..0.3).contains(&of("void_ratio")), "{}", of("void_ratio"));
    // Of all together by what solid they stand for.
    for what in ["void_ratio", "coordination", "mechanical_coordination"] {
        let (all, one) = (*ran.series(&format!("rve_{what}")).last().unwrap(), of(what));
        assert!((all / one - 1.0).abs() < 0.05, "{what}: {all} {one}");
    }
    // What the void ratio says, and what the law remembers.
    assert!((1.0 / (1.0 + of("void_ratio")) / of("fraction") - 1.0).abs() < 1e-12, "{}", of("fraction"));
}

/// The RVE of a point can be looked at after the run: its grains, and the lines along which they push each other.
#[test]
fn an_rve_is_exported_as_grains_and_force_chains() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let text = pressed(2, QUIET, "[time]\nend = \"5 ms\"\n[[follow]]\nname = \"corner\"\nplace = [0.5, 0.3]");
    done(start::start(&parse(&text), &options(&out), &Solo));
    let (state, _) = checkpoint::state_at(&out, None).unwrap();
    let file = folder.path().join("corner.vtkhdf");
    let beside = rve_export::write(state.clone(), &out, "corner", &file).unwrap();
    let [grains, contacts] = [&file, &beside].map(|path| scree_io::frames::read(path).unwrap().remove(0));
    assert_eq!((grains.rows(), contacts.rows() > 100), (100, true));
    // The lines bear the stress of the point.
    let column = |name: &str| contacts.fields.iter().find(|field| field.name == name).unwrap().values.clone();
    let Values::F64(force) = column("force") else { panic!("forces are numbers") };
    let moment = |i: usize, j: usize| -> f64 {
        let lines = contacts.positions.chunks(2).zip(force.chunks(3));
        lines.map(|(ends, force)| force[i] * (ends[1][j] - ends[0][j])).sum()
    };
    let Values::F64(edges) = &grains.whole[0].values else { panic!("edges are numbers") };
    let volume = (edges[0] * edges[4] - edges[1] * edges[3]) * 0.1;
    let series = std::fs::read_to_string(out.join("series.csv")).unwrap();
    let rows: Vec<Vec<&str>> =
        series.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').collect()).collect();
    let told = |name: &str| -> f64 {
        let at = rows[0].iter().position(|column| *column == format!("corner_{name}")).unwrap();
        rows.last().unwrap()[at].parse().unwrap()
    };
    let pressure = told("p");
    let found = 0.5 * (moment(0, 0) + moment(1, 1)) / volume;
    assert!((found / pressure - 1.0).abs() < 1e-9, "{found} {pressure}");
    for (name, [i, j]) in [("stress_xx", [0, 0]), ("stress_xy", [0, 1]), ("stress_yy", [1, 1])] {
        let found = 0.5 * (moment(i, j) + moment(j, i)) / volume;
        assert!((found - told(name)).abs() < 1e-9 * pressure.abs(), "{name}: {found} {}", told(name));
    }
    let volumetric = told("strain_xx") + told("strain_yy");
    assert!((volumetric - told("volumetric_strain")).abs() < 1e-12 && told("strain_xy") != 0.0, "{volumetric}");
    assert!(rve_export::write(state, &out, "nobody", &folder.path().join("other.vtkhdf")).is_err());
}
