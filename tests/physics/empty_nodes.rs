//! Nodes with next to no mass put no energy into a body that moves freely through the grid, under every scheme that is
//! accepted, at the step that a job gets by itself and at the longest that `check` allows.

use scree::job::Job;

use crate::runs::{Ran, SHAPES, TRANSFERS, UPDATES, parse, refused, schemes};

const ELASTIC: &str = "law = \"hencky\"\nyoung_modulus = 1e5\npoisson_ratio = 0.3";
const PLASTIC: &str = "law = \"critical_drucker_prager\"\nbulk_modulus = 8e4\nshear_modulus = 4e4\nfriction_angle_critical = \"30 deg\"\ncohesion = 2000\ndilation_angle = 0";

/// A block in a periodic grid of 1.6 m that flies, spins and shakes; waves take 35 ms across 0.4 m of it.
struct Flight {
    dimension: usize,
    edge: f64,
    spin: f64,
    safety: f64,
    end: f64,
}

impl Flight {
    fn text(&self, scheme: &str, law: &str) -> String {
        let Self { dimension, edge, spin, safety, end } = *self;
        let list = |values: [f64; 3]| format!("{:?}", &values[..dimension]);
        let [space, spin] = match dimension {
            2 => ["plane".to_string(), format!("{spin:?}")],
            _ => ["solid".to_string(), format!("[{:?}, {:?}, {spin:?}]", 0.3 * spin, -0.6 * spin)],
        };
        format!(
            r#"
            name = "flight"
            [grid]
            space = "{space}"
            upper = {}
            cell = 0.1
            periodic = {:?}
            [scheme]
            {scheme}
            [material]
            density = 1000
            {law}
            [[region]]
            shape = "box"
            lower = {}
            upper = {}
            velocity = {}
            spin = {spin}
            wave = [{{direction = {}, length = 0.8, origin = {}, amplitude = {}}}]
            [time]
            safety = {safety}
            end = {end}
            [output]
            series_interval = 0.01
            "#,
            list([1.6; 3]),
            &[true; 3][..dimension],
            list([0.6; 3]),
            list([0.6 + edge; 3]),
            list([0.31, -0.23, 0.41]),
            list([1.0, 0.0, 0.0]),
            list([0.8; 3]),
            list([0.3, 0.1, 0.2]),
        )
    }

    /// The most that kinetic and elastic energy come to over what they are in the first row, and at the end.
    fn growth(&self, scheme: &str, law: &str) -> [f64; 2] {
        let ran = Ran::of(&self.text(scheme, law));
        let energy = ran.energy();
        let most = energy.iter().copied().fold(0.0, f64::max);
        [most / energy[0], energy[energy.len() - 1] / energy[0]]
    }
}

/// `kinetic` leaves out the energy of affine fields, and kinetic energy is that of half a step before elastic energy.
const TOLERANCE: f64 = 0.05;

/// At the default step, about a thousand of them.
#[test]
fn a_body_that_flies_spins_and_shakes_gains_no_energy() {
    // In space, where a step costs many times as much, of one law: what nodes do to energy is no law's doing.
    for (dimension, end, laws) in [(2, 3.0, &[ELASTIC, PLASTIC][..]), (3, 0.4, &[ELASTIC])] {
        let flight = Flight { dimension, edge: 0.4, spin: 3.0, safety: 0.5, end };
        for scheme in schemes() {
            // Points that cross cells of linear functions heat them, which is not the nodes' doing: held as jobs have it.
            let scheme = if scheme.contains("linear") { scheme.replace("flip = 1.0", "flip = 0.99") } else { scheme };
            for law in laws {
                let [most, last] = flight.growth(&scheme, law);
                println!("{dimension}D {:56} {} {most:.3} {last:.3}", scheme.replace('\n', " "), &law[7..13]);
                assert!(most < 1.0 + TOLERANCE, "energy grows to {most}: {dimension}D {scheme} {law}");
            }
        }
    }
}

/// Two points to an edge alone among empty nodes, under pressure, at the longest step that is allowed.
#[test]
fn points_alone_are_not_thrown_apart_at_the_longest_step() {
    for dimension in [2, 3] {
        let flight = Flight { dimension, edge: 0.1, spin: 0.0, safety: 0.999, end: 1.0 };
        for scheme in schemes().filter(|scheme| scheme.contains("\"last\"")) {
            let text = format!("{ELASTIC}\n[stress]\nkind = \"isotropic\"\npressure = 2000");
            let [most, last] = flight.growth(&scheme, &text);
            println!("{dimension}D {:56} {most:.3} {last:.3}", scheme.replace('\n', " "));
            assert!(most < 1.0 + 2.0 * TOLERANCE, "energy grows to {most}: {dimension}D {scheme}");
        }
    }
}

/// Strained by the gradient over places already left, a turning body grew by (omega dt)^2 a step and pumped energy from it.
#[test]
fn stress_updated_first_takes_no_energy_from_turning() {
    let flight = Flight { dimension: 2, edge: 0.4, spin: 6.0, safety: 0.8, end: 3.0 };
    for shape in ["quadratic", "cubic"] {
        for transfer in TRANSFERS {
            let scheme = format!("shape = \"{shape}\"\nupdate = \"first\"\n{transfer}");
            // As long a step as the other updates have.
            let text = flight.text(&scheme, ELASTIC).replace("safety = 0.8", "step = 3.3e-3");
            let ran = Ran::of(&text);
            let energy = ran.energy();
            let most = energy.iter().copied().fold(0.0, f64::max) / energy[0];
            println!("{shape} {} {most:.3}", &transfer[12..17]);
            assert!(most < 1.0 + TOLERANCE, "energy grows to {most}: {scheme}");
        }
    }
}

/// What cannot be made sound is not accepted, and everything else is.
#[test]
fn schemes_that_throw_nodes_about_are_refused() {
    let flight = Flight { dimension: 2, edge: 0.4, spin: 0.0, safety: 0.5, end: 1.0 };
    for shape in SHAPES {
        for update in UPDATES {
            for transfer in TRANSFERS {
                let scheme = format!("shape = \"{shape}\"\nupdate = \"{update}\"\n{transfer}");
                let text = flight.text(&scheme, ELASTIC);
                match Job::parse(&text, "job", &[]) {
                    Err(error) => assert!(refused(&scheme) && error.to_string().contains("thrown about"), "{error}"),
                    Ok(job) => assert!(!refused(&scheme) && job == parse(&text), "{scheme} goes on"),
                }
            }
        }
    }
}
