//! The continuum against exact solutions: what is kept, and orders of what is not exact.

use scree::base::math::{PI, cos, ln};

use crate::runs::{Ran, SHAPES, TRANSFERS, UPDATES, elastic, list, orders, schemes, words};

/// Scheme of Chen et al. (2021) without damping, and with APIC.
const CHEN: &str = "shape = \"quadratic\"\nupdate = \"last\"\ntransfer = \"blend\"\nflip = 1.0";
const APIC: &str = "shape = \"quadratic\"\nupdate = \"last\"\ntransfer = \"affine\"";
const BOTH: [(&str, &str); 2] = [("FLIP", CHEN), ("APIC", APIC)];

fn space(dimension: usize) -> &'static str {
    if dimension == 2 { "plane" } else { "solid" }
}

/// A free block of edge 0.4 m that spins and shakes.
fn free(dimension: usize, scheme: &str) -> String {
    let solid = dimension == 3;
    let grid = format!(
        "space = \"{}\"\nlower = {}\nupper = {}\ncell = 0.1",
        space(dimension),
        list(dimension, [-0.8; 3]),
        list(dimension, [0.8; 3]),
    );
    let rest = format!(
        r#"
        [[region]]
        shape = "box"
        lower = {}
        upper = {}
        velocity = {}
        spin = {}
        wave = [{{direction = {}, length = 0.8, amplitude = {}}}]
        [time]
        step = 1e-3
        end = 0.2
        [output]
        series_interval = 1e-3
        checkpoint_interval = 0.05
        "#,
        list(dimension, [-0.2; 3]),
        list(dimension, [0.2; 3]),
        list(dimension, [0.3, -0.2, 0.4]),
        if solid { "[1.0, -2.0, 3.0]" } else { "3.0" },
        list(dimension, [1.0, 0.0, 0.0]),
        list(dimension, [0.3, 0.1, 0.2]),
    );
    elastic("free", &grid, scheme, [1e5, 0.3], &rest)
}

fn cross(a: &[f64], b: &[f64]) -> [f64; 3] {
    let at = |v: &[f64], axis: usize| v.get(axis).copied().unwrap_or(0.0);
    std::array::from_fn(|axis| {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        at(a, next) * at(b, last) - at(a, last) * at(b, next)
    })
}

/// Angular momentum about the origin, N m s, with that of affine fields: quadratic splines have second moments of a
/// quarter of a squared cell, cubic ones of a third.
fn angular(ran: &Ran, dimension: usize, moment: f64) -> [f64; 3] {
    let [places, velocities, masses, affines] = ["position", "velocity", "mass", "affine"].map(|name| ran.points(name));
    let mut sum = [0.0; 3];
    for ((place, velocity), (mass, affine)) in places.iter().zip(&velocities).zip(masses.iter().zip(&affines)) {
        let orbital = cross(place, velocity);
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            // Column by column: row `last`, column `next` turns positively.
            let at = |row: usize, column: usize| {
                if row < dimension && column < dimension { affine[column * dimension + row] } else { 0.0 }
            };
            sum[axis] += mass[0] * (orbital[axis] + moment * (at(last, next) - at(next, last)));
        }
    }
    sum
}

/// Mass and momentum under every scheme, and angular momentum with affine fields and splines.
#[test]
fn a_free_block_keeps_what_it_must() {
    for dimension in [2, 3] {
        for scheme in schemes() {
            let ran = Ran::of(&free(dimension, &scheme));
            let of = |name: &str| ran.series(name);
            let mass = of("mass");
            assert!(mass.iter().all(|now| *now == mass[0]), "mass changes: {scheme}");
            let mut lost = 0.0f64;
            for axis in ["x", "y", "z"].iter().take(dimension) {
                let momentum = of(&format!("momentum_{axis}"));
                momentum.iter().for_each(|now| lost = lost.max((now - momentum[0]).abs() / (mass[0] * 0.5)));
            }
            assert!(lost < 1e-13, "momentum changes by {lost:e}: {scheme}");
            let energy = ran.energy();
            let gained = energy.last().unwrap() / energy[0] - 1.0;
            println!("{dimension}D {:60} momentum {lost:.1e} energy {gained:+.2e}", scheme.replace('\n', " "));
            // Linear functions are left out: points that cross cells heat them.
            let flip_kept = scheme.contains("blend") && !scheme.contains("\"last\"");
            let limits = if flip_kept { -5e-3..5e-3 } else { -0.15..0.0 };
            assert!(scheme.contains("linear") || limits.contains(&gained), "energy changes by {gained:e}: {scheme}");
        }
        for (shape, moment) in [("quadratic", 0.25), ("cubic", 1.0 / 3.0)] {
            for update in UPDATES {
                let scheme = format!("shape = \"{shape}\"\nupdate = \"{update}\"\n{}", TRANSFERS[1]);
                let text = free(dimension, &scheme);
                let early = text.replace("end = 0.2", "end = 0.001");
                let [first, last] = [early, text].map(|text| angular(&Ran::of(&text), dimension, moment * 0.01));
                let change = (0..3).map(|axis| (last[axis] - first[axis]).abs()).fold(0.0, f64::max);
                let all = first.iter().map(|component| component * component).sum::<f64>().sqrt();
                println!(
                    "{dimension}D {shape} {update} APIC: angular momentum {first:?}, changed by {:.1e}",
                    change / all
                );
                assert!(change < 1e-12 * all, "angular momentum changes by {change:e}: {scheme}");
            }
        }
    }
}

/// Cubic functions reach three nodes beyond a block. With two cells in each, what fell on the last of them was summed by
/// nobody.
#[test]
fn momentum_is_kept_in_the_smallest_blocks() {
    for (shape, block) in [("quadratic", 2), ("cubic", 3)] {
        for update in UPDATES {
            for transfer in TRANSFERS {
                let scheme = format!("shape = \"{shape}\"\nupdate = \"{update}\"\n{transfer}");
                let text = free(2, &scheme)
                    .replace("lower = [-0.8, -0.8]", "lower = [-0.9, -0.9]")
                    .replace("upper = [0.8, 0.8]", "upper = [0.9, 0.9]")
                    .replace("cell = 0.1", "cell = 0.1\nperiodic = [true, true]");
                let text = text.replace("velocity = [0.3, -0.2]", "velocity = [3, -2]")
                    + &format!("[decomposition]\ncells_per_block = {block}\n");
                let ran = Ran::of(&text);
                let mass = ran.series("mass")[0];
                for axis in ["x", "y"] {
                    let momentum = ran.series(&format!("momentum_{axis}"));
                    let lost = momentum.iter().map(|now| (now - momentum[0]).abs() / (mass * 3.6)).fold(0.0, f64::max);
                    assert!(lost < 1e-13, "momentum along {axis} changes by {lost:e}: {scheme}");
                }
            }
        }
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Times at which a series rises through zero.
fn crossings(time: &[f64], values: &[f64]) -> Vec<f64> {
    let rises = |at: &usize| values[*at] < 0.0 && values[at + 1] >= 0.0;
    let when = |at: usize| time[at] - values[at] * (time[at + 1] - time[at]) / (values[at + 1] - values[at]);
    (0..values.len() - 1).filter(rises).map(when).collect()
}

/// The mean period of a series.
fn period(time: &[f64], values: &[f64]) -> f64 {
    let times = crossings(time, values);
    (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64
}

/// A bar of 1 m between two rollers with c = 100 m/s, one wave of its first mode.
fn bar(scheme: &str, cells: usize, end: f64) -> String {
    let cell = 1.0 / cells as f64;
    let (height, step) = (4.0 * cell, 0.2 * cell / 100.0);
    let grid = format!("space = \"plane\"\nupper = [1, {height}]\ncell = {cell}\ndepth = 1\nperiodic = [false, true]");
    let rest = format!(
        r#"
        [[region]]
        shape = "box"
        lower = [0, 0]
        upper = [1, {height}]
        wave = [{{direction = [1, 0], length = 2, amplitude = [1e-3, 0]}}]
        [[follow]]
        name = "middle"
        place = [0.5, 0]
        [time]
        step = {step}
        end = {end}
        [output]
        series_interval = {step}
        frame_interval = 1
        checkpoint_interval = 1
        "#
    );
    elastic("bar", &grid, scheme, [1e7, 0.0], &rest)
}

/// Error of the frequency over ten periods at 8, 16 and 32 cells, and the drift of the energy at 16.
fn standing(scheme: &str) -> ([f64; 3], f64) {
    let mut drift = 0.0;
    let errors = [8, 16, 32].map(|cells| {
        let ran = Ran::of(&bar(scheme, cells, 0.21));
        let time = ran.series("time");
        if cells == 16 {
            let energy = ran.energy();
            // The mean over the last period against that over the first, so that the half step between both shows not.
            let whole = (0.02 / (time[1] - time[0])).round() as usize;
            drift = mean(&energy[energy.len() - whole..]) / mean(&energy[..whole]) - 1.0;
        }
        0.02 / period(&time, &ran.series("middle_displacement_x")) - 1.0
    });
    (errors, drift)
}

#[test]
fn a_standing_wave_has_its_frequency_and_keeps_its_energy() {
    for scheme in schemes() {
        let (errors, drift) = standing(&scheme);
        println!(
            "{:60} frequency {} orders {:.2?} energy {drift:+.1e}",
            scheme.replace('\n', " "),
            words(&errors),
            orders(&errors)
        );
        let [coarse, _, fine] = errors;
        assert!(ln(coarse / fine) > 3.2 * ln(2.0), "less than second order: {scheme}");
        assert!(fine.abs() < 6e-3 && (-0.15..1e-4).contains(&drift), "frequency or energy: {scheme}");
    }
}

/// A pressed end sends a step through the bar: speed and size against c and sigma/(rho c).
#[test]
fn a_step_travels_with_the_speed_of_waves() {
    for (name, scheme) in BOTH {
        let text = bar(scheme, 128, 0.0095)
            .replace("periodic = [false, true]", "lower = [-0.125, 0]\nperiodic = [false, true]")
            .replace(
                "wave = [{direction = [1, 0], length = 2, amplitude = [1e-3, 0]}]",
                "[[load]]\nface = \"x_lower\"\nkind = \"traction\"\ntraction = [100, 0]\nramp = 1e-3\n[[follow]]\nname = \"quarter\"\nplace = [0.25, 0]\n[[follow]]\nname = \"late\"\nplace = [0.75, 0]",
            );
        let ran = Ran::of(&text);
        let time = ran.series("time");
        let wanted = 100.0 / (1000.0 * 100.0);
        let half = |name: &str| {
            let values: Vec<f64> = ran.series(&format!("{name}_velocity_x")).iter().map(|v| v - 0.5 * wanted).collect();
            crossings(&time, &values)[0]
        };
        let speed =
            (ran.series("late_place_x")[0] - ran.series("quarter_place_x")[0]) / (half("late") - half("quarter"));
        let level = ran.series("quarter_velocity_x");
        let level = mean(&level[level.len() * 3 / 4..]);
        println!("{name}: speed {:+.2e}, velocity behind the front {:+.2e}", speed / 100.0 - 1.0, level / wanted - 1.0);
        assert!((speed / 100.0 - 1.0).abs() < 0.02 && (level / wanted - 1.0).abs() < 1e-3);
    }
}

/// Pulses that run out of the bar at both ends: what comes back, at a fifth of a cell a step and at nearly the longest step
/// that is accepted; there what is left must not grow, for 30 times the way through. Dashpots on the velocity after forces made
/// energy where points average velocities: 1.5 of the pulses' by then (hats and uGIMP, flip = 1).
#[test]
fn absorbing_faces_return_little() {
    let cubic = CHEN.replace("quadratic", "cubic");
    let mut schemes: Vec<[String; 2]> = BOTH.map(|(name, scheme)| [name.into(), scheme.into()]).into();
    schemes.push(["cubic FLIP".into(), cubic]);
    for shape in ["generalised", "quadratic"] {
        for update in ["first", "modified_last"] {
            for flip in ["1.0", "0.9995", "0.99"] {
                let scheme = CHEN.replace("quadratic", shape).replace("\"last\"", &format!("\"{update}\""));
                schemes.push([format!("{shape} {update} FLIP {flip}"), scheme.replace("1.0", flip)]);
            }
        }
    }
    for [name, scheme] in &schemes {
        let pulses = bar(scheme, 64, 0.012)
            .replace("lower = [0, 0]\n        upper = [1,", "lower = [0.25, 0]\n        upper = [0.75,")
            .replace("length = 2,", "length = 1, origin = [0.25, 0],");
        let rest = "\n[[region]]\nshape = \"box\"\nlower = [0, 0]\nupper = [1, 0.0625]\n[[boundary]]\nface = \"x_lower\"\nkind = \"absorbing\"\n[[boundary]]\nface = \"x_upper\"\nkind = \"absorbing\"\n[time]";
        let short = pulses.replace("\n        [time]", rest);
        let step = 0.2 / 64.0 / 100.0;
        let long = short
            .replace(&format!(" step = {step}"), " safety = 0.99")
            .replace(&format!("series_interval = {step}"), "series_interval = 2e-4")
            .replace("end = 0.012", "end = 0.3");
        let energies = [&short, &long].map(|text| {
            let ran = Ran::of(text);
            let early = ran.series("time").partition_point(|time| *time < 0.0119);
            let energy = ran.energy();
            [early, energy.len() - 1].map(|row| energy[row] / energy[0])
        });
        let [[back, _], [back_long, late]] = energies;
        println!(
            "{name}: of the pulses' energy {back:.1e} comes back, at the longest step {back_long:.1e}, late {late:.1e}"
        );
        assert!(back < 5e-4 && back_long < 5e-4 && late < 0.5 * back_long, "{name}");
    }
}

/// Material in two corners of a box whose every face absorbs, a layer of points thick on the faces and standing off them by
/// less than a cell, so that nodes on faces have next to nothing: no face makes energy, and all goes out in the end.
#[test]
fn absorbing_faces_stop_what_is_thin() {
    for dimension in [2, 3] {
        let grid = format!("space = \"{}\"\nupper = {}\ncell = 0.1", space(dimension), list(dimension, [0.8; 3]));
        let faces: String = ["x_lower", "x_upper", "y_lower", "y_upper", "z_lower", "z_upper"][..2 * dimension]
            .iter()
            .map(|face| format!("[[boundary]]\nface = \"{face}\"\nkind = \"absorbing\"\n"))
            .collect();
        let region = |lower: [f64; 3], upper: [f64; 3], velocity: [f64; 3]| {
            let [lower, upper, velocity] = [lower, upper, velocity].map(|values| list(dimension, values));
            let wave = list(dimension, [0.02, 0.01, -0.01]);
            let along = list(dimension, [1.0, 1.0, 0.0]);
            format!(
                "[[region]]\nshape = \"box\"\nlower = {lower}\nupper = {upper}\nvelocity = {velocity}\nwave = [{{direction = {along}, length = 0.15, amplitude = {wave}}}]\n"
            )
        };
        let rest = [
            region([0.0; 3], [0.4, 0.05, 0.4], [0.02, -0.05, 0.01]),
            region([0.05, 0.3, 0.05], [0.3, 0.4, 0.3], [-0.05, 0.0, -0.05]),
            region([0.55, 0.55, 0.05], [0.75, 0.75, 0.75], [0.1, 0.1, 0.1]),
            region([0.75, 0.1, 0.1], [0.8, 0.5, 0.3], [0.0; 3]),
            faces,
            "[time]\nsafety = 0.99\nend = 0.4\n[output]\nenergy_balance = true\nseries_interval = 1e-2\nframe_interval = 1\ncheckpoint_interval = 1".into(),
        ];
        for flip in ["1.0", "0.9995", "0.99", "0.95", "0.0"] {
            for scheme in schemes() {
                let scheme = scheme.replace("flip = 1.0", &format!("flip = {flip}"));
                if scheme.contains("affine") && flip != "1.0" {
                    continue;
                }
                let ran = Ran::of(&elastic("thin", &grid, &scheme, [1e5, 0.3], &rest.concat()));
                let energy = ran.energy();
                let most = energy.iter().fold(0.0f64, |most, now| most.max(*now)) / energy[0];
                let late = energy[energy.len() - 1] / energy[0];
                let name = format!("{dimension}D {} flip {flip}", scheme.replace('\n', " "));
                println!("{name}: most {most:.4}, late {late:.1e}");
                assert!(most < 1.0 + 1e-6 && late < 0.1, "{name}: {most}, {late}");
            }
        }
    }
}

/// Standing P and S waves along the diagonal of a periodic square.
#[test]
fn oblique_waves_have_their_frequencies() {
    let (bulk, shear, density) = (1e5 / (3.0 * 0.4), 1e5 / 2.6, 1000.0f64);
    let speeds = [((bulk + 4.0 / 3.0 * shear) / density).sqrt(), (shear / density).sqrt()];
    for (name, scheme) in BOTH {
        for (wave, speed, across) in [("P", speeds[0], "[1e-3, 1e-3]"), ("S", speeds[1], "[1e-3, -1e-3]")] {
            let length = 0.5f64.sqrt();
            let errors = [8, 16, 32].map(|cells| {
                let cell = 1.0 / cells as f64;
                let step = 0.2 * cell / speeds[0];
                let grid = format!("space = \"plane\"\nupper = [1, 1]\ncell = {cell}\nperiodic = [true, true]");
                let rest = format!(
                    r#"
                    [[region]]
                    shape = "box"
                    lower = [0, 0]
                    upper = [1, 1]
                    wave = [{{direction = [1, 1], length = {length}, amplitude = {across}}}]
                    [[follow]]
                    name = "loud"
                    place = [0.125, 0.125]
                    [time]
                    step = {step}
                    end = {}
                    [output]
                    series_interval = {step}
                    frame_interval = 10
                    checkpoint_interval = 10
                    "#,
                    5.2 * length / speed
                );
                let ran = Ran::of(&elastic("oblique", &grid, scheme, [1e5, 0.3], &rest));
                length / speed / period(&ran.series("time"), &ran.series("loud_displacement_x")) - 1.0
            });
            println!("{name} {wave}: frequency {} orders {:.2?}", words(&errors), orders(&errors));
            assert!(orders(&errors)[1] > 1.9);
        }
    }
}

/// A column under its own weight, in the plane, with P = M ln(l)/l = -rho g (H - Z) for the stretch l at the depth.
#[test]
fn a_column_under_its_own_weight_has_the_exact_profile() {
    let (density, gravity, young, height) = (1000.0, 10.0, 1e5f64, 1.0);
    let modulus = young * 0.7 / (1.3 * 0.4);
    // ln(l)/l = s by bisection.
    let stretch = |s: f64| -> f64 {
        let (mut low, mut high) = (0.3f64, 1.0f64);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if ln(middle) / middle < s { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    };
    for shape in SHAPES {
        let errors = [8, 16, 32].map(|cells| {
            let cell = height / cells as f64;
            let width = 4.0 * cell;
            let grid = format!("space = \"plane\"\nupper = [{width}, 1.25]\ncell = {cell}\nperiodic = [true, false]");
            let scheme = format!("shape = \"{shape}\"\nupdate = \"modified_last\"\nflip = 0.5");
            let rest = format!(
                r#"
                [gravity]
                acceleration = [0, -{gravity}]
                ramp = 3.45
                [[region]]
                shape = "box"
                lower = [0, 0]
                upper = [{width}, 1]
                [[boundary]]
                face = "y_upper"
                kind = "free"
                [time]
                safety = 0.5
                end = 6
                [output]
                series_interval = 0.01
                [[follow]]
                name = "top"
                place = [0, {top}]
                [[follow]]
                name = "middle"
                place = [0, {middle}]
                "#,
                top = height - 0.25 * cell,
                middle = 0.5 * height + 0.25 * cell,
            );
            let ran = Ran::of(&elastic("column", &grid, &scheme, [young, 0.3], &rest));
            // What still swings is averaged away over the last 2.4 s.
            let time = ran.series("time");
            let hann = |now: f64| if now < 3.6 { 0.0 } else { 1.0 - cos(2.0 * PI * (now - 3.6) / 2.4) };
            let averaged = |name: &str| {
                let values = ran.series(name);
                let weighted: f64 = time.iter().zip(&values).map(|(now, value)| hann(*now) * value).sum();
                weighted / time.iter().map(|now| hann(*now)).sum::<f64>()
            };
            let at = |z: f64| stretch(-density * gravity * (height - z) / modulus);
            // Simpson's rule.
            let integral = |top: f64, of: &dyn Fn(f64) -> f64| -> f64 {
                let weight = |n: usize| match n {
                    0 | 40 => 1.0,
                    _ if n % 2 == 1 => 4.0,
                    _ => 2.0,
                };
                (0..=40).map(|n| weight(n) * of(top * n as f64 / 40.0)).sum::<f64>() * top / 120.0
            };
            let volume = integral(height, &at);
            let stress = integral(height, &|z| modulus * ln(at(z))) / volume;
            let top = averaged("top_place_y") - integral(height - 0.25 * cell, &at);
            let middle = averaged("middle_place_y") - integral(0.5 * height + 0.25 * cell, &at);
            let settled = height - volume;
            [top / settled, middle / settled, averaged("stress_yy") / stress - 1.0]
        });
        let [top, middle, stress] = [0, 1, 2].map(|which| errors.map(|all| all[which]));
        println!(
            "{shape}: top {} orders {:.2?}, middle {} orders {:.2?}, mean stress {} orders {:.2?}",
            words(&top),
            orders(&top),
            words(&middle),
            orders(&middle),
            words(&stress),
            orders(&stress)
        );
        // Points that cross cells of linear functions make it the worse the finer they are.
        let limits = match shape {
            "linear" => [0.3, 0.2, 0.02],
            "generalised" => [2e-3, 3e-3, 2e-3],
            _ => [1e-3, 1e-3, 3e-5],
        };
        assert!([top, middle, stress].iter().zip(limits).all(|(errors, limit)| errors[2].abs() < limit), "{shape}");
        assert!(shape != "quadratic" || orders(&stress)[0] > 1.9);
    }
}

/// A block on a plane that is tilted: a = g (sin - mu cos) above the angle of friction, rest below it.
#[test]
fn a_block_slides_as_friction_lets_it() {
    for (slope, friction) in [(0.5f64, 0.3), (0.25, 0.3)] {
        let (sin, cos) = (slope / (1.0 + slope * slope).sqrt(), 1.0 / (1.0 + slope * slope).sqrt());
        for shape in SHAPES {
            let grid = "space = \"plane\"\nupper = [4, 1]\ncell = 0.1\ndepth = 1";
            let scheme = format!("shape = \"{shape}\"\nupdate = \"modified_last\"\nflip = 0.95");
            let rest = format!(
                r#"
                [gravity]
                acceleration = [{}, {}]
                [[region]]
                shape = "box"
                lower = [0.2, 0]
                upper = [1.0, 0.4]
                [[boundary]]
                face = "y_lower"
                kind = "friction"
                coefficient = {friction}
                [[boundary]]
                face = "y_upper"
                kind = "free"
                [time]
                safety = 0.4
                end = 1
                [output]
                series_interval = 0.1
                "#,
                10.0 * sin,
                -10.0 * cos
            );
            let ran = Ran::of(&elastic("incline", grid, &scheme, [1e6, 0.3], &rest));
            let speed = ran.series("momentum_x").last().unwrap() / ran.series("mass")[0];
            let wanted = 10.0 * (sin - friction * cos).max(0.0);
            let force = ran.series("y_lower_force_y");
            let press = mean(&force[3..]);
            let weight = ran.series("mass")[0] * 10.0 * cos;
            println!("{shape}, slope {slope}: speed {speed:.4}, wanted {wanted:.4} m/s; presses {:.4}", press / weight);
            assert!((speed - wanted).abs() < 0.025 && (press / weight + 1.0).abs() < 0.02, "{shape}");
        }
    }
}

/// Three turns of a stiff free block: its points have turned by as much as the block, and the mean stress is that of the
/// virial, rho omega^2 a^2/12, turn by turn.
#[test]
fn many_turns_leave_only_what_spinning_makes() {
    for (name, transfer) in [("FLIP", TRANSFERS[0]), ("APIC", TRANSFERS[1])] {
        let spin = 20.0;
        let text = free(2, &format!("shape = \"quadratic\"\nupdate = \"modified_last\"\n{transfer}"))
            .replace("young_modulus = 1e5", "young_modulus = 1e7")
            .replace("spin = 3.0", "spin = 20.0")
            .replace("velocity = [0.3, -0.2]", "velocity = [0, 0]")
            .replace("amplitude = [0.3, 0.1]", "amplitude = [0, 0]")
            .replace("step = 1e-3", "step = 2e-4")
            .replace("end = 0.2", "end = 0.942\n[[follow]]\nname = \"corner\"\nplace = [0.175, 0.175]");
        let ran = Ran::of(&text);
        let [x, y] = ["corner_place_x", "corner_place_y"].map(|name| ran.series(name));
        let mut turned = 0.0;
        for at in 1..x.len() {
            turned += (x[at - 1] * y[at] - y[at - 1] * x[at]) / (x[at] * x[at] + y[at] * y[at]);
        }
        let time = ran.series("time");
        let wanted = spin * (time[time.len() - 1] - time[0]);
        let virial = 1000.0 * spin * spin * 0.4 * 0.4 / 12.0;
        let last = x.len() * 2 / 3;
        let stress: Vec<f64> =
            ran.series("stress_xx").iter().zip(ran.series("stress_yy")).map(|(x, y)| 0.5 * (x + y)).collect();
        let mean = mean(&stress[last..]);
        println!(
            "{name}: turned {:+.1e}, mean stress in the third turn {:+.1e}",
            turned / wanted - 1.0,
            mean / virial - 1.0
        );
        // Increments alone lose spin at the edges of a body four cells across: what is left is stated, not claimed.
        if name == "APIC" {
            assert!((turned / wanted - 1.0).abs() < 5e-3 && (mean / virial - 1.0).abs() < 0.02);
        }
    }
}
