//! Bodies that hold nodes of a continuum: what rests on them, what they press, and what they carry across periods.

use crate::runs::{Ran, elastic};

/// A block of 400 by 600 mm on a rough table, under gravity.
fn on_a_table(scheme: &str, rest: &str) -> String {
    let grid = "space = \"plane\"\nupper = [0.4, 1.2]\ncell = 0.05\ndepth = 1";
    let block = r#"
        [gravity]
        acceleration = [0, -10]
        [[region]]
        shape = "box"
        lower = [0, 0.2]
        upper = [0.4, 0.8]
        [[body]]
        name = "table"
        shape = "box"
        lower = [0, 0]
        upper = [0.4, 0.2]
        contact = "rough"
        [time]
        safety = 0.4
        end = 1.5
    "#;
    elastic("table", grid, scheme, [1e6, 0.3], &format!("{block}\n{rest}"))
}

/// What rests on a body presses on it with its weight; a plate that is to bear a stress bears it.
#[test]
fn bodies_bear_what_they_must() {
    let lid = r#"
        [[body]]
        name = "lid"
        shape = "box"
        lower = [0, 0.8]
        upper = [0.4, 1.0]
        contact = "smooth"
        servo = { direction = [0, 1], stress = 5000, area = 0.4, mass = 50, damping = 500, speed_max = 1 }
        [output]
        series_interval = 0.05
        "#;
    let ran = Ran::of(&on_a_table("shape = \"quadratic\"\nupdate = \"last\"\nflip = 0.9", lid));
    let (table, lid) = (ran.series("table_force_y"), ran.series("lid_force_y"));
    let late = |values: &[f64]| values[values.len() - 4..].iter().sum::<f64>() / 4.0;
    println!("lid {} of 2000 N, table {} of -4400 N", late(&lid), late(&table));
    assert!((late(&lid) / 2000.0 - 1.0).abs() < 0.01 && (late(&table) / -4400.0 - 1.0).abs() < 0.015);
}

/// What carries a block across a periodic face does what it does elsewhere, and so does the account of its work, whether it
/// goes along with the block or spins below it: grains met its image there, nodes did not.
#[test]
fn a_body_across_a_periodic_face_holds_the_nodes_in_its_image() {
    let carried = |from: f64, body: &str| {
        let grid = "space = \"plane\"\nupper = [0.8, 0.6]\ncell = 0.05\nperiodic = [true, false]";
        let rest = format!(
            r#"
            [gravity]
            acceleration = [0, -10]
            [[region]]
            shape = "box"
            lower = [{}, 0.2]
            upper = [{}, 0.4]
            velocity = [1, 0]
            [[body]]
            name = "carrier"
            velocity = [1, 0]
            contact = "rough"
            {body}
            [time]
            safety = 0.4
            end = 0.2
            [output]
            series_interval = 0.005
            energy_balance = true
            "#,
            from + 0.1,
            from + 0.3,
        );
        Ran::of(&elastic("across", grid, "update = \"modified_last\"", [1e6, 0.3], &rest))
    };
    let table =
        |from: f64| carried(from, &format!("shape = \"box\"\nlower = [{from}, 0]\nupper = [{}, 0.2]", from + 0.4));
    let wheel = |from: f64| {
        carried(from, &format!("shape = \"cylinder\"\ncentre = [{}, 0]\nradius = 0.2\nspin = -5", from + 0.2))
    };
    let both: [(&str, [Ran; 2]); 2] = [("table", [0.0, 0.4].map(table)), ("wheel", [0.0, 0.4].map(wheel))];
    for (name, [inside, across]) in &both {
        for column in [
            "carrier_force_x",
            "carrier_force_y",
            "carrier_torque_z",
            "kinetic",
            "work_bodies",
            "dissipated_holds",
            "energy_lost",
        ] {
            let (wanted, found) = (inside.series(column), across.series(column));
            let size = wanted.iter().fold(0.0f64, |most, value| most.max(value.abs()));
            let apart = wanted.iter().zip(&found).fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
            println!("{name}, {column}: {apart:.1e} of {size:.1e}");
            assert!(size > 0.0 && apart < 1e-8 * size, "{name}: {column} is off by {apart:e} of {size:e}");
        }
    }
}

/// Stress first or modified last looks at the grid a second time. Whether a node parts from a body was told there by velocities
/// without forces, so that nodes under load parted and were held in turn and came to 150 J where 2 J are due.
#[test]
fn what_rests_on_a_body_stays_at_rest_whenever_stress_is_updated() {
    for update in ["first", "modified_last", "last"] {
        let scheme = format!("shape = \"quadratic\"\nupdate = \"{update}\"\nflip = 1.0");
        let ran = Ran::of(&on_a_table(&scheme, "[output]\nseries_interval = 0.01"));
        // At rest it holds 6.5 J, and swings about that from no stress at all: four times as much is the most there can be.
        let most = ran.series("elastic").iter().fold(0.0, |most: f64, now| most.max(*now));
        println!("{update}: {most:.2} J at most");
        assert!(most < 26.0, "{update}: {most} J");
    }
}
