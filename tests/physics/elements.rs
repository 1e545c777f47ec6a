//! Continua of elements against closed forms: states at rest, waves, bending, turns, bodies, accounts; and the same bits whoever has them.

use scree::base::math::{PI, sin};
use scree::job::Job;

use crate::runs::{Ran, list, parse, same};

/// An elastic mesh in a box from the origin on.
fn elastic(dimension: usize, upper: [f64; 3], elements: [usize; 3], rest: &str) -> String {
    let (space, upper) = (if dimension == 2 { "plane" } else { "solid" }, list(dimension, upper));
    let elements = list(dimension, elements.map(|count| count as f64));
    format!(
        "name = \"elements\"\n[material]\nlaw = \"hencky\"\ndensity = 1000\nyoung_modulus = 1e6\npoisson_ratio = 0.3\n\
         [mesh]\nspace = \"{space}\"\nupper = {upper}\nelements = {elements}\n{rest}"
    )
}

/// All sides of a mesh.
fn free(dimension: usize, but: &[&str]) -> String {
    let faces = ["x_lower", "x_upper", "y_lower", "y_upper", "z_lower", "z_upper"];
    let named = faces[..2 * dimension].iter().filter(|face| !but.contains(face));
    named.map(|face| format!("[[boundary]]\nface = \"{face}\"\nkind = \"free\"\n")).collect()
}

/// The last displacement of the node nearest to a place, m.
fn displacement_at(ran: &Ran, (counts, edges): ([usize; 3], [f64; 3]), place: [f64; 3]) -> Vec<f64> {
    let index: Vec<usize> = (0..3).map(|axis| (place[axis] / edges[axis]).round() as usize).collect();
    let wanted = ((index[2] * (counts[1] + 1) + index[1]) * (counts[0] + 1) + index[0]) as u64;
    let ids = ran.wholes_of("nodes", "id");
    let row = ids.iter().position(|id| *id == wanted).unwrap();
    ran.rows_of("nodes", "displacement")[row].clone()
}

/// A pressure all around holds material that has its stress at rest, whatever the edges of elements are.
#[test]
fn a_pressure_holds_its_own_stress() {
    for dimension in [2, 3] {
        let faces = ["x_lower", "x_upper", "y_lower", "y_upper", "z_lower", "z_upper"];
        let load = |face: &&str| format!("[[load]]\nface = \"{face}\"\nkind = \"pressure\"\npressure = 1000\n");
        let loads: String = faces[..2 * dimension].iter().map(load).collect();
        let rest = format!(
            "{}{loads}[stress]\nkind = \"isotropic\"\npressure = 1000\n[time]\nend = 0.05\n",
            free(dimension, &[])
        );
        let ran = Ran::of(&elastic(dimension, [1.0, 0.7, 0.4], [4, 3, 2], &rest));
        for velocity in ran.rows_of("nodes", "velocity") {
            assert!(velocity.iter().all(|component| component.abs() < 1e-13), "{velocity:?}");
        }
        for stress in ran.points("stress") {
            let off = |(at, component): (usize, &f64)| component + if at < dimension { 1000.0 } else { 0.0 };
            assert!(stress.iter().enumerate().map(off).all(|off| off.abs() < 1e-9), "{stress:?}");
        }
    }
}

/// Standing waves of compression and of shear go round as discrete equations say, `sin(w dt/2) = (c dt/h) sin(k h/2)`.
#[test]
fn waves_have_the_speed_of_their_mesh() {
    for (dimension, along) in [(2, true), (2, false), (3, true), (3, false)] {
        let (count, length, speed) = (12, 1.2, 1e-6);
        let amplitude = list(dimension, if along { [speed, 0.0, 0.0] } else { [0.0, speed, 0.0] });
        let direction = list(dimension, [1.0, 0.0, 0.0]);
        let lower = list(dimension, [0.0; 3]);
        let upper = list(dimension, [length, 0.2, 0.2]);
        let rest = format!(
            "periodic = {}\n[[region]]\nshape = \"box\"\nlower = {lower}\nupper = {upper}\n\
             wave = [{{direction = {direction}, length = {length}, amplitude = {amplitude}}}]\n[time]\nend = 0.05\n",
            list(dimension, [1.0; 3]).replace('1', "true")
        );
        let text = elastic(dimension, [length, 0.2, 0.2], [count, 2, 2], &rest);
        let Job::Mpm(job) = parse(&text) else { panic!("it has no mesh") };
        let ran = Ran::of(&text);
        let law = &job.material.law;
        let modulus = if along { law.modulus_longitudinal(dimension) } else { law.shear_modulus() };
        let (wave, edge) = ((modulus / 1000.0).sqrt(), length / count as f64);
        let half = wave * job.step / edge * sin(PI / count as f64);
        // The inverse of the sine, by Newton's way.
        let mut angle = half;
        (0..20).for_each(|_| angle -= (sin(angle) - half) / scree::base::math::cos(angle));
        let steps = *ran.series("step").last().unwrap();
        let wanted = speed * job.step * sin(2.0 * angle * steps) / sin(2.0 * angle);
        let crest = [0.25 * length, 0.0, 0.0];
        let found = displacement_at(&ran, ([count, 2, 2], [edge, 0.1, 0.1]), crest)[usize::from(!along)];
        assert!((found - wanted).abs() < 1e-5 * (speed * 0.05), "{dimension}D {along}: {found:e} {wanted:e}");
    }
}

/// A cantilever with a single element over its height hangs as a beam does (plane strain, with shear).
#[test]
fn a_cantilever_bends_as_a_beam() {
    let (height, force) = (0.1, 20.0);
    for elements in [[10, 1, 1], [20, 2, 1], [40, 4, 1]] {
        let rest = format!(
            "local_damping = 0.5\n[[boundary]]\nface = \"x_lower\"\nkind = \"fixed\"\n{}\
             [[load]]\nface = \"x_upper\"\nkind = \"traction\"\ntraction = [0, {}]\n[time]\nend = 12\nsafety = 0.9\n",
            free(2, &["x_lower"]),
            -force / height / 0.01 * 1e-4
        );
        let ran = Ran::of(&elastic(2, [1.0, height, 0.0], elements, &rest));
        let edges = [1.0 / elements[0] as f64, height / elements[1] as f64, 1.0];
        let found = displacement_at(&ran, (elements, edges), [1.0, 0.0, 0.0])[1];
        let (plate, shear, per_depth) = (1e6 / (1.0 - 0.09), 1e6 / 2.6, force * 1e-2);
        let inertia = height * height * height / 12.0;
        let wanted = -per_depth * (1.0 / (3.0 * plate * inertia) + 1.2 / (shear * height)) * 1e-0;
        let ratio = found / wanted;
        println!("cantilever of {elements:?}: {found:.4e} for {wanted:.4e} m, {ratio:.4}");
        assert!((ratio - 1.0).abs() < 0.02, "{elements:?}: {ratio}");
    }
}

/// A block that turns freely keeps its energy, its stress and its angular momentum.
#[test]
fn a_spinning_block_keeps_what_it_has() {
    let rest = format!(
        "{}[[region]]\nshape = \"box\"\nlower = [0, 0]\nupper = [1, 1]\nspin = 2.0\n[time]\nend = 3.2\n\
         [output]\nenergy_balance = true\nseries_interval = 0.05\n",
        free(2, &[])
    );
    let ran = Ran::of(&elastic(2, [1.0, 1.0, 0.0], [6, 6, 1], &rest));
    let (energy, lost) = (ran.energy(), ran.series("energy_lost"));
    let off = energy.iter().map(|now| (now / energy[0] - 1.0).abs()).fold(0.0, f64::max);
    let lost = lost.iter().map(|lost| (lost / energy[0]).abs()).fold(0.0, f64::max);
    let momentum = |name: &str| *ran.series(name).last().unwrap();
    println!("a turn and a half ... energy off by {off:.1e}, lost {lost:.1e}");
    assert!(off < 1e-3 && lost < 1e-3, "{off} {lost}");
    assert!(momentum("momentum_x").abs() < 1e-12 && momentum("momentum_y").abs() < 1e-12);
}

/// Steps are of second order: a body that falls freely is where it should be, with the momentum that it should have, and what two halves bring
/// along is kept.
#[test]
fn the_first_step_is_half_a_kick() {
    let rest = |gravity: f64| {
        format!(
            "{}[[region]]\nshape = \"box\"\nlower = [0, 0]\nupper = [0.5, 1]\nvelocity = [0, 1]\n[[region]]\nshape = \"box\"\nlower = [0.5, 0]\nupper = [1, 1]\nvelocity = [0, -1]\n\
             [gravity]\nacceleration = [0.0, {gravity:?}]\n[time]\nend = 0.1\n[output]\nenergy_balance = true\n",
            free(2, &[])
        )
    };
    let ran = Ran::of(&elastic(2, [1.0, 1.0, 0.0], [4, 4, 1], &rest(-9.81)));
    let (time, centre) = (ran.series("time"), ran.series("centre_y"));
    let last = time.len() - 1;
    // The first row is that of the first step.
    let fallen = centre[last] - 0.5;
    assert!((fallen / (-0.5 * 9.81 * time[last] * time[last]) - 1.0).abs() < 1e-10, "{fallen}");
    let error = ran.summary["conservation"]["momentum"]["error"].as_f64().unwrap();
    assert!(error < 1e-12, "{error}");
}

/// Where nodes are on rollers, damping acts along these.
#[test]
fn damping_acts_along_rollers() {
    let rest = "local_damping = 0.5\n[[boundary]]\nface = \"y_upper\"\nkind = \"free\"\n[gravity]\nacceleration = [0.0, -9.81, 0.0]\n[time]\nend = 2\n";
    let ran = Ran::of(&elastic(3, [1.0, 1.0, 0.25], [4, 4, 1], rest));
    let kinetic = ran.series("kinetic");
    let largest = kinetic.iter().copied().fold(0.0, f64::max);
    assert!(kinetic.last().unwrap() / largest < 1e-6, "{kinetic:?}");
}

/// Slow loading comes to the same state with a hundred times the inertia, in as many steps for ten times the time, and nodes are in balance there.
#[test]
fn mass_scaling_changes_no_state_of_rest() {
    let rest = |scaling: f64| {
        format!(
            "local_damping = 0.6\nmass_scaling = {scaling:?}\n[[boundary]]\nface = \"y_lower\"\nkind = \"fixed\"\n{}\
             [[load]]\nface = \"x_upper\"\nkind = \"traction\"\ntraction = [0, -200]\nramp = {}\n\
             [gravity]\nacceleration = [0.0, -9.81]\n[time]\nend = {}\nsafety = 0.9\n",
            free(2, &["y_lower"]),
            0.2 * scaling.sqrt(),
            4.0 * scaling.sqrt()
        )
    };
    let ran = [1.0, 100.0].map(|scaling| Ran::of(&elastic(2, [0.5, 1.0, 0.0], [4, 8, 1], &rest(scaling))));
    let [own, scaled] =
        ran.each_ref().map(|ran| displacement_at(ran, ([4, 8, 1], [0.125, 0.125, 1.0]), [0.5, 1.0, 0.0]));
    let off = own.iter().zip(&scaled).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / own[1].abs();
    let [steps, fewer] = ran.each_ref().map(|ran| *ran.series("step").last().unwrap());
    let last = |ran: &Ran, name: &str| *ran.series(name).last().unwrap();
    println!(
        "mass scaling: {own:?}, off by {off:.1e}, {steps} and {fewer} steps, I_uf {:.1e}",
        last(&ran[1], "nodes_unbalanced")
    );
    assert!(off < 1e-6 && (steps / fewer - 1.0).abs() < 0.01, "{off} {steps} {fewer}");
    assert!((last(&ran[1], "mass") / last(&ran[0], "mass") - 100.0).abs() < 1e-9);
    for ran in &ran {
        let unbalanced = ran.series("nodes_unbalanced");
        assert!(last(ran, "nodes_unbalanced") < 1e-6 && unbalanced.iter().any(|share| *share > 1e-2), "{unbalanced:?}");
        let weight = 0.5 * 0.01 * 1000.0 * 9.81;
        let borne = -last(ran, "y_lower_force_y");
        assert!((borne / (weight + 200.0 * 0.01) - 1.0).abs() < 1e-6, "{borne} {weight}");
    }
}

/// A pressure acts on sides that two elements have across a period.
#[test]
fn loads_act_beside_short_periods() {
    for count in [1, 2, 3] {
        let rest = "periodic = [true, false]\n[[boundary]]\nface = \"y_upper\"\nkind = \"free\"\n[[load]]\nface = \"y_upper\"\nkind = \"pressure\"\npressure = 1000\n\
             [stress]\nkind = \"isotropic\"\npressure = 1000\n[time]\nend = 0.05\n";
        let ran = Ran::of(&elastic(2, [1.0, 1.0, 0.0], [count, 3, 1], rest));
        for velocity in ran.rows_of("nodes", "velocity") {
            assert!(velocity.iter().all(|component| component.abs() < 1e-13), "{count}: {velocity:?}");
        }
    }
}

/// A plate that is fastened to a side and keeps a force by a servo presses the material by that force; what it takes is what the ground gives.
#[test]
fn a_side_fastened_to_a_plate_bears_what_its_servo_keeps() {
    for contact in ["rough", "smooth"] {
        let rest = format!(
            "local_damping = 0.3\n[[boundary]]\nface = \"y_lower\"\nkind = \"fixed\"\n{}\
             [[body]]\nname = \"plate\"\nshape = \"plane\"\npoint = [0, 1]\nnormal = [0, -1]\nside = \"y_upper\"\ncontact = \"{contact}\"\n\
             servo = {{direction = [0, 1], force = 10, mass = 5, damping = 300, speed_max = 1}}\n[time]\nend = 3\n",
            free(2, &["y_lower"])
        );
        let ran = Ran::of(&elastic(2, [1.0, 1.0, 0.0], [4, 4, 1], &rest));
        let [plate, ground] = ["plate_force_y", "y_lower_force_y"].map(|name| *ran.series(name).last().unwrap());
        assert!(
            (plate / 10.0 - 1.0).abs() < 1e-3 && (ground / -10.0 - 1.0).abs() < 1e-3,
            "{contact}: {plate} {ground}"
        );
        // Damping is no load on what is held.
        let borne = *ran.series("stress_yy").last().unwrap() * 0.01;
        assert!((borne / -10.0 - 1.0).abs() < 0.01, "{contact}: {borne}");
        let across = *ran.series("plate_force_x").last().unwrap();
        assert!(across.abs() < 1e-6, "{contact}: {across}");
    }
}

/// What the account of energy does not close by falls with the square of the step.
#[test]
fn the_account_of_energy_closes() {
    let lost = |safety: f64| {
        let rest = format!(
            "[[boundary]]\nface = \"y_lower\"\nkind = \"fixed\"\n{}[gravity]\nacceleration = [0.0, -9.81]\n\
             [time]\nend = 0.3\nsafety = {safety}\n[output]\nenergy_balance = true\n",
            free(2, &["y_lower"])
        );
        let ran = Ran::of(&elastic(2, [0.5, 2.0, 0.0], [3, 8, 1], &rest));
        ran.series("energy_lost").iter().map(|lost| lost.abs()).fold(0.0, f64::max)
            / ran.series("elastic").into_iter().fold(0.0, f64::max)
    };
    let errors = [0.8, 0.4, 0.2].map(lost);
    println!("energy lost: {errors:?}");
    assert!(errors[0] < 1e-3 && errors[1] < 0.35 * errors[0] && errors[2] < 0.35 * errors[1], "{errors:?}");
}

/// The same bits on ranks and threads, through restarts; in the plane and in space, of laws that flow, across periods.
#[test]
fn elements_end_in_the_same_bits() {
    let sand = "law = \"critical_drucker_prager\"\ndensity = 1500\nbulk_modulus = 2e6\nshear_modulus = 1e6\n\
                friction_angle_critical = \"25 deg\"\nfraction_critical = 0.6\nfraction = 0.62\ndilation_factor = 3\nsoftening_rate = 1\n";
    let current = "[nonlocal]\nradius = 0.45\nplaces = \"current\"\n";
    for (dimension, law, nonlocal) in [(2, "", ""), (3, "", ""), (2, sand, ""), (2, sand, current)] {
        let output = "[output]\ncheckpoint_interval = \"10 ms\"\nframe_interval = \"10 ms\"\nenergy_balance = true\n";
        let periodic = if dimension == 2 { "periodic = [true, false]" } else { "periodic = [false, false, true]" };
        let named = if dimension == 2 {
            ""
        } else {
            "[[boundary]]\nface = \"x_lower\"\nkind = \"friction\"\ncoefficient = 0.3\n"
        };
        let zero = if dimension == 2 { "" } else { ", 0" };
        let rest = format!(
            "{periodic}\n{named}[[boundary]]\nface = \"y_lower\"\nkind = \"fixed\"\n[[boundary]]\nface = \"y_upper\"\nkind = \"free\"\n\
             [[load]]\nface = \"y_upper\"\nkind = \"pressure\"\npressure = 5000\n[stress]\nkind = \"isotropic\"\npressure = 5000\n\
             [[body]]\nname = \"plate\"\nshape = \"plane\"\npoint = [0, 0.7{zero}]\nnormal = [0, -1{zero}]\nside = \"y_upper\"\ncontact = \"rough\"\nvelocity = [1.0, 0{zero}]\n\
             [time]\nend = \"25 ms\"\n[decomposition]\ncells_per_block = 2\n{output}{nonlocal}"
        );
        let mut text = elastic(dimension, [1.2, 0.7, 0.8], [6, 5, 4], &rest);
        if !law.is_empty() {
            let (from, to) = (text.find("law = ").unwrap(), text.find("[mesh]").unwrap());
            text.replace_range(from..to, law);
        }
        let folder = tempfile::tempdir().unwrap();
        same(&parse(&text), folder.path(), &format!("{dimension}D {law}{nonlocal}"));
    }
}

/// A layer 1 m high of a material that softens and is looser in its middle, sheared by 4 % between 100 kPa: work of the plate, J, and the height over which it
/// has flowed, (sum k)^2/sum k^2 of plastic strains k, m.
fn softening_layer(elements: usize, nonlocal: &str) -> [f64; 2] {
    let region = |lower: f64, upper: f64, fraction: &str| {
        format!("[[region]]\nshape = \"box\"\nlower = [0, {lower}]\nupper = [0.05, {upper}]\n{fraction}")
    };
    let text = format!(
        "name = \"layer\"\n[mesh]\nspace = \"plane\"\nupper = [0.05, 1.0]\nelements = [1, {elements}]\nperiodic = [true, false]\nlocal_damping = 0.5\n\
         [material]\nlaw = \"critical_drucker_prager\"\ndensity = 1500\nbulk_modulus = 2e7\nshear_modulus = 1e7\n\
         friction_angle_critical = \"25 deg\"\nfraction_critical = 0.6\nfraction = 0.62\ndilation_factor = 3\nsoftening_rate = 50\n\
         [stress]\nkind = \"isotropic\"\npressure = \"100 kPa\"\n{}{}\
         [[boundary]]\nface = \"y_lower\"\nkind = \"fixed\"\n[[boundary]]\nface = \"y_upper\"\nkind = \"free\"\n\
         [[body]]\nname = \"top\"\nshape = \"plane\"\npoint = [0, 1]\nnormal = [0, -1]\nside = \"y_upper\"\ncontact = \"rough\"\nvelocity = [0.02, 0]\nramp = 0.1\n\
         servo = {{ direction = [0, 1], force = 50, mass = 0.2, damping = 100, speed_max = 1 }}\n\
         [time]\nend = 2\nsafety = 0.8\n[output]\nseries_interval = 0.02\nenergy_balance = true\n{nonlocal}",
        region(0.45, 0.55, "fraction = 0.618\n"),
        region(0.0, 1.0, "")
    );
    let ran = Ran::of(&text);
    let sums = ran
        .points("plastic_strain")
        .iter()
        .fold([0.0, 0.0], |[sum, squares], strain| [sum + strain[0], squares + strain[0] * strain[0]]);
    let [work, lost] = ["work_bodies", "energy_lost"].map(|column| *ran.series(column).last().unwrap());
    assert!(lost.abs() < 1e-4 * work, "{lost} J of {work} are in no account");
    [work, sums[0] * sums[0] / sums[1] / elements as f64]
}

/// `../../docs/validation/fem_dem.md`: with a nonlocal strain, energy and width within 2 % over three meshes; local ones have one row of elements.
#[test]
fn a_softening_layer_has_a_width_of_its_own() {
    let found = [20, 40, 80].map(|elements| softening_layer(elements, "[nonlocal]\nradius = 0.2\n"));
    println!("nonlocal: work (J) and width (m) of 20, 40, 80 elements {found:.4?}");
    for which in [0, 1] {
        let of = found.map(|of| of[which]);
        let spread = of.iter().copied().fold(0.0, f64::max) / of.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(spread < 1.02, "{found:?}");
    }
    let local = [20, 40].map(|elements| softening_layer(elements, ""));
    println!("local: {local:.4?}");
    assert!(local[0][1] > 1.8 * local[1][1], "{local:?}");
}
