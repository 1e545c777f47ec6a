//! Bodies that hold nodes of a continuum: what rests on them, what they press, and what they carry across periods.

use crate::runs::Ran;

/// What rests on a body presses on it with its weight; a plate that is to bear a stress bears it.
#[test]
fn bodies_bear_what_they_must() {
    let text = r#"
        name = "bodies"
        [grid]
        space = "plane"
        upper = [0.4, 1.2]
        cell = 0.05
        depth = 1
        [scheme]
        shape = "quadratic"
        update = "last"
        flip = 0.9
        points_per_cell = 2
        [material]
        law = "hencky"
        density = 1000
        young_modulus = 1e6
        poisson_ratio = 0.3
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
        [[body]]
        name = "lid"
        shape = "box"
        lower = [0, 0.8]
        upper = [0.4, 1.0]
        contact = "smooth"
        servo = { direction = [0, 1], stress = 5000, area = 0.4, mass = 50, damping = 500, speed_max = 1 }
        [time]
        safety = 0.4
        end = 1.5
        [output]
        series_interval = 0.05
        "#;
    let ran = Ran::of(text);
    let (table, lid) = (ran.series("table_force_y"), ran.series("lid_force_y"));
    let late = |values: &[f64]| values[values.len() - 4..].iter().sum::<f64>() / 4.0;
    println!("lid {} of 2000 N, table {} of -4400 N", late(&lid), late(&table));
    assert!((late(&lid) / 2000.0 - 1.0).abs() < 0.01 && (late(&table) / -4400.0 - 1.0).abs() < 0.015);
}

/// A table that carries a block across a periodic face does what it does elsewhere: grains met its image there, nodes did not.
#[test]
fn a_body_across_a_periodic_face_holds_the_nodes_in_its_image() {
    let carried = |from: f64| {
        Ran::of(&format!(
            r#"
            name = "across"
            [grid]
            space = "plane"
            upper = [0.8, 0.6]
            cell = 0.05
            periodic = [true, false]
            [scheme]
            update = "modified_last"
            [material]
            law = "hencky"
            density = 1000
            young_modulus = 1e6
            poisson_ratio = 0.3
            [gravity]
            acceleration = [0, -10]
            [[region]]
            shape = "box"
            lower = [{}, 0.2]
            upper = [{}, 0.4]
            velocity = [1, 0]
            [[body]]
            name = "table"
            shape = "box"
            lower = [{from}, 0]
            upper = [{}, 0.2]
            velocity = [1, 0]
            contact = "rough"
            [time]
            safety = 0.4
            end = 0.2
            [output]
            series_interval = 0.005
            "#,
            from + 0.1,
            from + 0.3,
            from + 0.4
        ))
    };
    let [inside, across] = [0.0, 0.4].map(carried);
    for column in ["table_force_x", "table_force_y", "table_torque_z", "kinetic"] {
        let (wanted, found) = (inside.series(column), across.series(column));
        let size = wanted.iter().fold(0.0f64, |most, value| most.max(value.abs()));
        let apart = wanted.iter().zip(&found).fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
        println!("{column}: {apart:.1e} of {size:.1e}");
        assert!(apart < 1e-8 * size, "{column} is off by {apart:e} of {size:e}");
    }
}

/// Stress first or modified last looks at the grid a second time. Whether a node parts from a body was told there by velocities
/// without forces, so that nodes under load parted and were held in turn and came to 150 J where 2 J are due.
#[test]
fn what_rests_on_a_body_stays_at_rest_whenever_stress_is_updated() {
    for update in ["first", "modified_last", "last"] {
        let text = format!(
            r#"
            name = "table"
            [grid]
            space = "plane"
            upper = [0.4, 1.2]
            cell = 0.05
            depth = 1
            [scheme]
            shape = "quadratic"
            update = "{update}"
            flip = 1.0
            points_per_cell = 2
            [material]
            law = "hencky"
            density = 1000
            young_modulus = 1e6
            poisson_ratio = 0.3
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
            [output]
            series_interval = 0.01
            "#
        );
        let ran = Ran::of(&text);
        // At rest it holds 6.5 J, and swings about that from no stress at all: four times as much is the most there can be.
        let most = ran.series("elastic").iter().fold(0.0, |most: f64, now| most.max(*now));
        println!("{update}: {most:.2} J at most");
        assert!(most < 26.0, "{update}: {most} J");
    }
}
