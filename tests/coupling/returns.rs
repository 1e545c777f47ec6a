//! Grains that have turned into points and come back where cells shear that are not of grains alone.

use std::collections::BTreeMap;
use std::path::Path;

use scree::adapt::enrichment::{Plan, Refusal, around_shear, cell_grid, dissolve};
use scree::adapt::flow::flows;
use scree::base::space::{Plane, Space};
use scree::couple::kept::KeptGrains;
use scree::couple::rest::RestWatch;
use scree::job::Job;
use scree::prepare::reference::Lies;
use scree::prepare::sheared::Grain;
use scree::run::start;
use scree::store::checkpoint;
use scree_io::column::{State, Values};
use scree_partition::Solo;

use crate::enrichment::sums;
use crate::runs::{Ran, done, options, same};
use crate::zones::{advance, everywhere};

/// Grains that came were trained from the packing along the smooth way of the points, and stood in the places of those that had sheared by themselves: 0.76 to 1.2 MPa for 0.4.
#[test]
fn grains_come_back_as_they_stood() {
    let folder = tempfile::tempdir().unwrap();
    let high = ["specimen.height=36 mm", "zone.grows=true", "zone.rest_strength=10", "enrichment.distance=3 mm"];
    let alone = everywhere(&[&high[..], &["method=dem", "loading.strain_end=0.03"]].concat());
    done(start::start(&Job::Shear(alone), &options(&folder.path().join("alone")), &Solo));
    let (_, state) = checkpoint::latest_state(&folder.path().join("alone")).unwrap();
    let scenario = everywhere(&high);
    let (mut world, progress) = start::world_of(&scenario, Some(state), &Solo).unwrap();
    let (settings, depth) = (&scenario.enrichment, scenario.specimen.depth);
    let grid = cell_grid(&world);
    let columns = grid.counts[0] as u64;
    let of_rows = |rows: &[u64]| rows.iter().flat_map(|row| row * columns..(row + 1) * columns).collect::<Vec<u64>>();
    let (mut kept, mut instants) = (KeptGrains::default(), progress.instants.clone());
    let rest = RestWatch::default();
    let before = world.grains_total;
    // The third row from below shears, and all above the fifth turns into points.
    let past = (&mut instants, &mut kept);
    let left = dissolve(&mut world, (settings, depth, progress.fraction_start), past, (&rest, &of_rows(&[2]))).unwrap();
    let left = left.expect("grains that rest");
    assert!(left.grains > 100 && kept.grains.len() as u64 == before, "{left:?}");
    assert_eq!((instants.every, &instants.times[..]), (0, &[world.time()][..]));
    let stood: BTreeMap<u64, _> = kept.grains.iter().map(|grain| (grain.cold.id.0, grain.clone())).collect();
    // All of the world goes on by half a radius and more, some of it across the period.
    let shift = <Plane as Space>::Vector::new(3e-4, 0.0);
    world.assembly.grains.hot.iter_mut().for_each(|grain| grain.position += shift);
    world.continuum.points.hot.iter_mut().for_each(|point| point.position += shift);
    world.continuum.points.scattered = [false; 2];
    world.bodies.iter_mut().for_each(|body| body.displacement += shift);
    world.rebuild().unwrap();
    advance(&mut world, 10_000);
    world.rebuild().unwrap();
    let flows_now = flows(&world).unwrap();
    assert!(around_shear(grid, &flows_now, &of_rows(&[2]), settings).is_empty(), "all around the row is of grains");
    let mut wanted = around_shear(grid, &flows_now, &of_rows(&[4]), settings);
    assert_eq!(wanted.len(), 1, "one set of cells above what shears");
    let row_of = |place: &<Plane as Space>::Vector| grid.at(place[0], place[1]).unwrap() as u64 / columns;
    let rows = world.continuum.points.rows();
    let ways = rows.filter(|point| row_of(&point.hot.position) == 5).map(|point| {
        let moved = point.hot.position - point.cold.origin + world.assembly.cell.shift(point.cold.image);
        moved[0] - point.past.track.displacements[0][0]
    });
    let ways: Vec<f64> = ways.collect();
    let way = ways.iter().sum::<f64>() / ways.len() as f64;
    let (known, energies) = (sums(&world), world.energies().unwrap());
    let here: Vec<u64> = world.rows().0.iter().map(|grain| grain.cold.id.0).collect();
    let from = (Path::new("no packing is read"), Lies::Kept(&kept));
    let plan = Plan::of(&mut world, (settings, depth), wanted.remove(0), &instants, from).unwrap();
    let grown = plan.unwrap_or_else(|Refusal(why)| panic!("{why}")).carry_out(&mut world).unwrap();
    println!("{left:?}\n{grown:?}\nby {way} m");
    assert!(grown.grains > 60 && grown.grains_rim > 20 && grown.grains_rim < grown.grains, "{grown:?}");
    let rows = world.rows().0;
    let new: Vec<_> = rows.iter().filter(|grain| !here.contains(&grain.cold.id.0)).collect();
    assert_eq!(new.len() as u64, grown.grains);
    let mut came = Vec::new();
    for grain in new {
        let stood = &stood[&grain.cold.id.0];
        assert_eq!(grain.cold.origin, stood.cold.origin);
        let moved = |of: &Grain| of.hot.position - of.cold.origin + world.assembly.cell.shift(of.cold.image);
        let come = moved(grain) - moved(stood);
        assert!((come[0] - way).abs() < 0.5 * grain.hot.radius, "{come} m, and points {way} m");
        assert!(come[1].abs() < 0.3 * grain.hot.radius, "{come} m");
        came.push(come[0]);
    }
    assert!(rows.iter().any(|grain| stood[&grain.cold.id.0].cold.image != grain.cold.image), "some cross the period");
    let mean = came.iter().sum::<f64>() / came.len() as f64;
    assert!(way > shift[0] && (mean / way - 1.0).abs() < 0.15, "grains have come {mean} m, points {way} m");
    let pressure = |stress: [f64; 3]| -0.5 * (stress[0] + stress[1]);
    let borne = pressure(grown.stress_grains) / pressure(grown.stress_points);
    assert!((0.7..1.3).contains(&borne), "{grown:?}");
    let after = sums(&world);
    assert!((after[0] / known[0] - 1.0).abs() < 1e-14, "mass {} became {}", known[0], after[0]);
    for axis in [1, 2] {
        assert!((after[axis] - known[axis]).abs() < 1e-13 * known[3], "momentum {known:?} became {after:?}");
    }
    advance(&mut world, 2000);
    let later = world.energies().unwrap();
    println!("before {energies:?}, later {later:?}");
    assert!(later.kinetic_grains + later.kinetic_points < 2.0 * (energies.kinetic_grains + energies.kinetic_points));

    // All that have gone are kept at the second dissolution as well: those that are here as they stand, the others where points have taken them.
    let here: Vec<u64> = world.rows().0.iter().map(|grain| grain.cold.id.0).collect();
    let past = (&mut instants, &mut kept);
    let again =
        dissolve(&mut world, (settings, depth, progress.fraction_start), past, (&rest, &of_rows(&[2]))).unwrap();
    assert!(again.expect("grains that rest").grains > 60);
    assert_eq!(kept.grains.len() as u64, before);
    let gone = kept.grains.iter().filter(|grain| !here.contains(&grain.cold.id.0));
    for grain in gone.filter(|grain| row_of(&grain.hot.position) > 7) {
        let stood = &stood[&grain.cold.id.0];
        let moved = |of: &Grain| of.hot.position - of.cold.origin + world.assembly.cell.shift(of.cold.image);
        assert!((moved(grain) - moved(stood))[0] > way, "grains near the plate have come farther than those below");
        assert!(grain.contacts.iter().all(|(partner, _)| !here.contains(&partner.0)), "{:?}", grain.contacts);
    }
}

/// A zone as narrow as its band is at the time, judged so strictly that it is left by it and follows.
#[test]
fn a_zone_that_follows_the_shear_has_the_same_bits_on_any_ranks_and_after_a_restart() {
    let scenario = || everywhere(&["zone.grows=true", "zone.rest_strength=10", "zone.rest_share=0.6"]);
    let folder = tempfile::tempdir().unwrap();
    same(&Job::Shear(scenario()), folder.path(), "a zone that begins everywhere and follows the shear");
    let ran = Ran::of_job(&Job::Shear(scenario()));
    let (grew, shrank, judged) = (ran.events("zone_grew"), ran.events("zone_shrank"), ran.events("zone_judged"));
    assert!(!grew.is_empty() && !shrank.is_empty(), "{judged:?}");
    // The run that is gone on with is so from a third on: with grains that had been kept before, which come back behind.
    let (steps, step) = (61_251.0, |event: &serde_json::Value| event["step"].as_f64().unwrap());
    assert!(
        step(shrank[0]) < steps / 3.0 && grew.iter().any(|event| step(event) > steps / 3.0),
        "{shrank:?}, {grew:?}"
    );
    for event in &grew {
        assert!(judged.iter().any(|judgement| judgement["step"] == event["step"]), "{event}");
        assert!(event["grains"].as_u64().unwrap() > 0, "{event}");
    }
    for name in ["mass", "momentum"] {
        let kept = &ran.summary["conservation"][name]["error"];
        assert!(kept.as_f64().unwrap().abs() < 1e-12, "{name} {kept}");
    }
}

/// What is kept is looked up by ids and counted from bodies and an instant: a checkpoint where these do not belong together is refused, and not gone on with wrongly.
#[test]
fn a_checkpoint_whose_kept_grains_do_not_belong_together_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let sets = [
        "zone.grows=true",
        "zone.rest_strain=0.005",
        "zone.rest_share=0.9",
        "zone.rest_strength=10",
        "loading.strain_end=0.04",
    ];
    let scenario = everywhere(&sets);
    done(start::start(&Job::Shear(everywhere(&sets)), &options(folder.path()), &Solo));
    let (_, state) = checkpoint::latest_state(folder.path()).unwrap();
    let told = |change: &dyn Fn(&mut State)| {
        let mut state = state.clone();
        change(&mut state);
        start::world_of(&scenario, Some(state), &Solo).map(|_| ()).map_err(|error| error.to_string())
    };
    assert_eq!(told(&|_| ()), Ok(()));
    let table = |state: &mut State, name: &str| state.tables.iter().position(|table| table.name == name).unwrap();
    let refused = |change: &dyn Fn(&mut State), words: &str| {
        let told = told(change).unwrap_err();
        assert!(told.contains(words), "{told}, and not {words}");
    };
    let of_ids = |state: &mut State, change: &dyn Fn(&mut Vec<u64>)| {
        let at = table(state, "kept_grains");
        let ids = state.tables[at].columns.iter_mut().find(|column| column.name == "id").unwrap();
        if let Values::U64(ids) = &mut ids.values {
            change(ids);
        }
    };
    refused(&|state| of_ids(state, &|ids| ids.swap(3, 4)), "ids must rise");
    refused(&|state| of_ids(state, &|ids| ids[4] = ids[3]), "names grain");
    let empty = |state: &mut State, name: &str| {
        let at = table(state, name);
        state.tables[at].rows = 0;
        for column in &mut state.tables[at].columns {
            match &mut column.values {
                Values::F64(values) => values.clear(),
                Values::U64(values) => values.clear(),
                Values::I64(values) => values.clear(),
                Values::U8(values) => values.clear(),
            }
        }
    };
    refused(&|state| empty(state, "kept_bodies"), "0 displacements of 2 bodies");
    refused(&|state| empty(state, "instants"), "there must be one instant");
}
