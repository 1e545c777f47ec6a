//! Zones that live: they grow where the band goes, and give back the grains that rest.

use std::path::Path;

use scree::adapt::enrichment::{Enriched, cell_grid, dissolve, grain_stress};
use scree::adapt::shear::{look_for_rest, watched_inside_zones};
use scree::base::ids::PointId;
use scree::base::space::{Plane, Space};
use scree::couple::kept::KeptGrains;
use scree::couple::rest::RestWatch;
use scree::couple::zone::{Enrichment, ZoneLife};
use scree::dem::grains::Mover;
use scree::domain::accounts::energy::Energies;
use scree::job::{Job, Scenario};
use scree::mpm::points::Hot;
use scree::mpm::track::Instants;
use scree::prepare::reference::Lies;
use scree::run::start::{self, Continuation};
use scree::store::checkpoint;
use scree_partition::Solo;

use crate::coupled::triaxial;
use crate::enrichment::{enrich, sums, up_to_the_band};
use crate::runs::{Ran, done, options, parse, replaced, same};
use crate::worlds::{PlanarPoint, PlanarWorld, contact, grain, open_world, packed_job, settings};

/// A zone too small for its band, which grows along it; and judged so strictly that it gives grains back as well. Its oracle finds the
/// band where volume strain is not averaged, within a few milliseconds; its specimen is at the peak, where grains would stay.
pub fn restless(end: f64) -> String {
    let zone = r#"distance = "4.5 mm"
        [zone]
        grows = true
        dissolves = true
        rest_share = 0.9
        rest_strength = 10
        rest_strain = 0.01"#;
    replaced(
        triaxial("hybrid", end),
        &[
            ("recent_strain = 4e-3", "recent_strain = 8e-3"),
            ("distance = \"6 mm\"", zone),
            ("[scheme]", "[scheme]\n        volume_averaging = false"),
        ],
    )
}

#[test]
fn a_zone_that_grows_and_gives_back_keeps_mass_and_momentum() {
    let ran = Ran::of(&restless(8e-3));
    let (grains, points) = (ran.series("grains"), ran.series("points"));
    let steps = || grains.windows(2).zip(points.windows(2));
    let grown = steps().filter(|(grains, points)| grains[0] > 0.0 && grains[1] > grains[0] && points[1] < points[0]);
    let shrunk = steps().filter(|(grains, points)| grains[1] < grains[0] && points[1] > points[0]);
    let (grown, shrunk) = (grown.count(), shrunk.count());
    println!("grains {grains:?}, points {points:?}");
    assert!(grown > 0 && shrunk > 0, "the zone grew {grown} times and shrank {shrunk} times: {grains:?}");
    let kept = &ran.summary["conservation"];
    assert!(kept["mass"]["error"].as_f64().unwrap().abs() < 1e-13, "{kept}");
    assert!(kept["momentum"]["error"].as_f64().unwrap().abs() < 1e-12, "{kept}");
}

#[test]
fn a_zone_that_lives_has_the_same_bits_on_any_ranks_and_after_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let (_, series) = same(&parse(&restless(3.84e-3)), folder.path(), "a zone that grows and gives back");
    // Of the part that was gone through again after the restart, from a third on.
    let grains: Vec<f64> =
        series.lines().skip(15).map(|line| line.split(',').nth(2).unwrap().parse().unwrap()).collect();
    assert!(
        grains.windows(2).any(|pair| pair[1] > pair[0]) && grains.windows(2).any(|pair| pair[1] < pair[0]),
        "{grains:?}"
    );
}

/// Grains everywhere, those at rest of which turn into points once a band has formed.
pub fn everywhere(sets: &[&str]) -> Scenario {
    let here = [
        "zone.begins=everywhere",
        "zone.dissolves=true",
        "zone.rest_share=0.3",
        "enrichment.distance=4 mm",
        "loading.strain_end=0.2",
        "time.grain_steps=4",
    ];
    packed_job(&[&here, sets].concat())
}

#[test]
fn a_zone_that_begins_everywhere_is_grains_alone_until_some_rest() {
    let ran = Ran::of_job(&Job::Shear(everywhere(&[])));
    let alone = Ran::of_job(&Job::Shear(everywhere(&["method=dem"])));
    let (points, grains) = (ran.series("points"), ran.series("grains"));
    let rested = points.iter().position(|points| *points > 0.0).expect("some grains rest");
    assert!(rested > 10 && points[..rested].iter().all(|points| *points == 0.0));
    for name in ["shear_stress", "normal_stress", "volume_strain", "kinetic_grains", "elastic_grains"] {
        assert_eq!(ran.series(name)[..rested], alone.series(name)[..rested], "{name} is not that of grains alone");
    }
    assert!(grains.last().unwrap() < &(0.9 * grains[0]), "grains {grains:?}");
    let kept = &ran.summary["conservation"];
    assert!(kept["mass"]["error"].as_f64().unwrap().abs() < 1e-13, "{kept}");
    assert!(kept["momentum"]["error"].as_f64().unwrap().abs() < 1e-12, "{kept}");
    // What rests is beside the band.
    let inside = &ran.series("shear_in_zones")[rested..];
    let mean = inside.iter().sum::<f64>() / inside.len() as f64;
    assert!(mean > 0.7, "{mean} of the shear is inside the zone");
}

/// A judgement after which all grains stayed rebuilt the cells, and the run had other bits than grains alone from there on.
#[test]
fn judgements_that_change_nothing_leave_the_bits_of_grains_alone() {
    let ran = Ran::of_job(&Job::Shear(everywhere(&["zone.rest_strength=1e-3", "loading.strain_end=0.1"])));
    let alone = Ran::of_job(&Job::Shear(everywhere(&["method=dem", "loading.strain_end=0.1"])));
    for name in ["shear_stress", "normal_stress", "volume_strain", "kinetic_grains", "elastic_grains"] {
        assert_eq!(ran.series(name), alone.series(name), "{name} is not that of grains alone");
    }
    let events = ran.events("zone_cannot_shrink");
    assert!(!events.is_empty(), "no judgement was refused");
    for event in events {
        let shares = event["strength_mobilised"].as_array().unwrap();
        assert!(!shares.is_empty() && shares.iter().all(|share| share.as_f64().unwrap() > 0.1), "{event}");
        assert!(event["strain"].as_f64().unwrap() > 0.0 && event["without_pressure"] == 0, "{event}");
    }
}

#[test]
fn a_zone_that_begins_everywhere_has_the_same_bits_on_any_ranks_and_after_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let (_, series) = same(&Job::Shear(everywhere(&[])), folder.path(), "a zone that begins everywhere");
    let last: Vec<&str> = series.lines().last().unwrap().split(',').collect();
    let at =
        series.lines().find(|line| line.starts_with("step,")).unwrap().split(',').position(|name| name == "points");
    assert!(last[at.unwrap()].parse::<u64>().unwrap() > 0, "no grains came to rest: {last:?}");
}

/// Whoever has sheared grains alone up to their band goes on from there; what began with points cannot begin with grains.
#[test]
fn grains_alone_go_on_as_a_zone_that_has_begun_everywhere() {
    let folder = tempfile::tempdir().unwrap();
    let [alone, branch, follows, points, other] =
        ["alone", "branch", "follows", "points", "other"].map(|name| folder.path().join(name));
    let short = "loading.strain_end=0.02";
    done(start::start(&Job::Shear(everywhere(&["method=dem", short])), &options(&alone), &Solo));
    let sets = [
        "method=hybrid",
        "loading.strain_end=0.04",
        "zone.rest_strain=0.005",
        "zone.rest_share=0.9",
        "zone.rest_strength=10",
    ]
    .map(String::from);
    let on = |trunk: &Path, branch: &Path, sets: &[String]| {
        start::resume(trunk, Continuation { sets, branch: Some(branch) }, &options(branch), &Solo)
    };
    done(on(&alone, &branch, &sets));
    let (_, state) = checkpoint::latest_state(&branch).unwrap();
    let rows = |name: &str| state.tables.iter().find(|table| table.name == name).unwrap().rows;
    assert!(rows("points") > 0 && rows("grains") > 0);
    let grows = [&sets[..], &["zone.grows=true".to_owned()]].concat();
    // Grains that come back need nothing from before they left.
    done(on(&alone, &follows, &grows));
    let (_, state) = checkpoint::latest_state(&follows).unwrap();
    let rows = |name: &str| state.tables.iter().find(|table| table.name == name).unwrap().rows;
    assert!(rows("points") > 0 && rows("kept_grains") > rows("grains"));

    done(start::start(&Job::Shear(packed_job(&["method=mpm", short])), &options(&points), &Solo));
    let sets =
        ["method=hybrid", "zone.begins=everywhere", "zone.dissolves=true", "loading.strain_end=0.04"].map(String::from);
    let told = on(&points, &other, &sets).unwrap_err().to_string();
    assert!(told.contains("the run has begun with points"), "{told}");
    let told = on(&alone, &other, &["method=hybrid", "zone.begins=band"].map(String::from)).unwrap_err().to_string();
    assert!(told.contains("the run has begun with grains"), "{told}");
}

#[test]
fn a_specimen_in_membranes_that_begins_as_grains_gives_back_those_that_rest() {
    let text = replaced(restless(6e-3), &[("grows = true", "begins = \"everywhere\"")]);
    let folder = tempfile::tempdir().unwrap();
    same(&parse(&text), folder.path(), "a specimen that begins as grains");
    let ran = Ran::of(&text);
    let (grains, points) = (ran.series("grains"), ran.series("points"));
    assert_eq!(points[0], 0.0);
    assert!(points.last().unwrap() > &0.0 && grains.last() < grains.first(), "grains {grains:?}, points {points:?}");
    let kept = &ran.summary["conservation"];
    assert!(kept["mass"]["error"].as_f64().unwrap().abs() < 1e-13, "{kept}");
    assert!(kept["momentum"]["error"].as_f64().unwrap().abs() < 1e-12, "{kept}");
}

/// Membranes go with nodes, and grains begin with half a kick: the account of momentum took half a kick for both.
#[test]
fn gravity_on_membranes_around_grains_is_in_the_account_of_momentum() {
    let text = replaced(
        restless(6e-3),
        &[
            ("grows = true", "begins = \"everywhere\""),
            ("[scheme]", "[gravity]\n        acceleration = [3, -9.81]\n        [scheme]"),
        ],
    );
    let ran = Ran::of(&text);
    assert!(ran.series("points").last().unwrap() > &0.0);
    let kept = &ran.summary["conservation"]["momentum"];
    assert!(kept["error"].as_f64().unwrap().abs() < 1e-12, "{kept}");
}

/// A specimen that has grains in its band.
fn enriched<'t>(scenario: &Scenario, folder: &Path) -> (PlanarWorld<'t>, Instants, Vec<u64>, Enriched) {
    let file = folder.join("packing.h5");
    let (mut world, flagged, instants) = up_to_the_band(scenario, &Solo, &file);
    let how = (&scenario.enrichment, scenario.specimen.depth);
    let enriched = enrich(&mut world, how, &flagged, &instants, (&file, Lies::Whole));
    (world, instants, flagged, enriched)
}

/// A few grains that had strayed into the continuum and moved as they liked were the busiest cell, beside which all of the band was at rest: the zone dissolved.
#[test]
fn grains_that_stray_do_not_make_all_others_rest() {
    let (cell, edge, radius) = (3e-3, 0.5e-3, 0.25e-3);
    // Two cells full of grains that shear by 1 /s, and three grains that fly apart.
    let places = (0..72).map(|number| [f64::from(number % 12), f64::from(number / 12)].map(|at| (at + 0.5) * edge));
    // Beside one of them.
    let strays = [[6.2e-3, 0.2e-3], [7.0e-3, 0.3e-3], [6.5e-3, 2.0e-3]];
    let mut grains: Vec<_> =
        (0..).zip(places.chain(strays)).map(|(id, place)| grain(id, place, radius, 1e-6)).collect();
    for (number, grain) in grains.iter_mut().enumerate() {
        let rate = if number < 72 { 1.0 } else { 100.0 };
        grain.hot.velocity[0] = rate * grain.hot.position[1];
    }
    let world = open_world(&Solo, cell, settings(1e-7, contact(0.0)), grains, Vec::new());
    let mut watch = RestWatch::default();
    look_for_rest(&world, &mut watch, 1.0).unwrap();
    assert!((watch.most() - 1.0).abs() < 1e-9, "{watch:?}");
    assert_eq!(watch.busy(0.2).count(), 2, "{watch:?}");
}

/// Bands were wider by two cells when a cell was judged together with those around it.
#[test]
fn a_cell_rests_beside_one_that_shears() {
    let (cell, edge, radius) = (3e-3, 0.5e-3, 0.25e-3);
    // Two full cells side by side, of which the first shears.
    let places = (0..72).map(|number| [f64::from(number % 12), f64::from(number / 12)].map(|at| (at + 0.5) * edge));
    let mut grains: Vec<_> = (0..).zip(places).map(|(id, place)| grain(id, place, radius, 1e-6)).collect();
    for grain in grains.iter_mut().filter(|grain| grain.hot.position[0] < cell) {
        grain.hot.velocity[0] = grain.hot.position[1];
    }
    let world = open_world(&Solo, cell, settings(1e-7, contact(0.0)), grains, Vec::new());
    let mut watch = RestWatch::default();
    look_for_rest(&world, &mut watch, 1.0).unwrap();
    assert_eq!(watch.busy(0.01).count(), 1, "{watch:?}");
    assert!((watch.most() - 1.0).abs() < 1e-9, "{watch:?}");
}

/// Velocities of points are of an instant in which the continuum rings: summed up over looks they made a seventh of the shear of a specimen whose points did not shear.
#[test]
fn points_that_ring_have_not_sheared() {
    let (cell, edge, radius) = (3e-3, 0.5e-3, 0.25e-3);
    // A cell full of grains that shear by 1 /s, and one of points whose velocities do by 10.
    let place = |number: usize, across: usize| [number % across, number / across].map(|at| (at as f64 + 0.5) * edge);
    let mut grains: Vec<_> = (0..36).map(|number| grain(number as u64, place(number, 6), radius, 1e-6)).collect();
    grains.iter_mut().for_each(|grain| grain.hot.velocity[0] = grain.hot.position[1]);
    let point = |number: usize| {
        let [x, y] = place(number, 2).map(|at| 3.0 * at);
        let mut point = PlanarPoint::resting(PointId(number as u64), [x + cell, y].into(), 9e-6, 2.25e-8);
        point.hot.velocity[0] = 10.0 * y;
        point
    };
    let world = open_world(&Solo, cell, settings(1e-7, contact(0.0)), grains, (0..4).map(point).collect());
    let mut watch = RestWatch::default();
    let flows = look_for_rest(&world, &mut watch, 0.1).unwrap();
    assert!((watch.most() - 0.1).abs() < 1e-9, "{watch:?}");
    let busy: Vec<u64> = watch.busy(0.2).collect();
    assert_eq!((busy.len(), watch.busiest()), (1, busy.first().copied()));
    assert!(flows[&busy[0]].is_inside());
    assert!((watched_inside_zones(&watch, &flows) - 1.0).abs() < 1e-9);
}

/// A number of a point.
type Figure = dyn Fn(&Hot<Plane>) -> f64;

pub fn advance(world: &mut PlanarWorld, steps: u64) {
    for _ in 0..steps {
        world.advance().unwrap();
    }
}

#[test]
fn grains_at_rest_turn_into_points_that_bear_what_they_bore() {
    let scenario = packed_job(&["enrichment.distance=9 mm"]);
    let folder = tempfile::tempdir().unwrap();
    let (mut world, mut instants, flagged, _) = enriched(&scenario, folder.path());
    advance(&mut world, 1000);
    let depth = scenario.specimen.depth;
    let fraction = 0.84;
    let grid = cell_grid(&world);
    // One row of cells in the middle of the band shears; all others, more than two and a half cells away, do not.
    let columns = grid.counts[0] as u64;
    let row = flagged[flagged.len() / 2] / columns;
    let busy: Vec<u64> = (row * columns..(row + 1) * columns).collect();
    let up_to = |strength: f64| {
        let life = ZoneLife { rest_strength: strength, ..scenario.enrichment.life };
        Enrichment { distance: 3e-3, life, ..scenario.enrichment }
    };
    let near = up_to(10.0);
    let stays = grid.near(&busy, 7.5e-3);
    let is_left = |place: &<Plane as Space>::Vector| !stays[grid.at(place[0], place[1]).unwrap()];
    let stress = grain_stress(&mut world, depth).unwrap();
    let (before, energies, points) = (sums(&world), world.energies().unwrap(), world.points_total);
    let last_id = world.continuum.points.cold.iter().map(|cold| cold.id.0).max().unwrap();
    let moved = world
        .assembly
        .grains
        .hot
        .iter()
        .zip(&world.assembly.grains.cold)
        .map(|(hot, cold)| hot.position[0] - cold.origin[0]);
    let most = moved.clone().fold(0.0, f64::max);
    let gone: Vec<f64> = moved
        .zip(&world.assembly.grains.hot)
        .filter(|(_, hot)| hot.weight == 1.0 && is_left(&hot.position))
        .map(|(moved, _)| moved)
        .collect();
    let gone = gone.iter().sum::<f64>() / gone.len() as f64;
    let leaving = world.assembly.grains.hot.iter().filter(|hot| is_left(&hot.position)).count();
    assert!(leaving > 50, "only {leaving} of {} grains lie far from the band", world.grains_total);

    // Grains that bear more than a thousandth of the strength stay, which is told.
    let (rest, mut kept) = (RestWatch::default(), KeptGrains::default());
    let past = (&mut instants, &mut kept);
    let told = dissolve(&mut world, (&up_to(1e-3), depth, fraction), past, (&rest, &busy)).unwrap();
    let told = told.expect("it is told");
    assert!(told.mass_factors.is_empty() && told.grains == 0, "{told:?}");
    assert!(!told.mobilised.is_empty() && told.mobilised.iter().all(|share| (0.1..2.0).contains(share)), "{told:?}");
    assert_eq!(world.points_total, points);
    assert!((sums(&world)[0] / before[0] - 1.0).abs() < 1e-14);

    let past = (&mut instants, &mut kept);
    let done = dissolve(&mut world, (&near, depth, fraction), past, (&rest, &busy)).unwrap();
    let done = done.expect("grains that rest");
    assert!(kept.is_empty(), "a zone that does not grow keeps no grains");
    let after = sums(&world);
    println!("{done:?}: stress of grains {stress:?}");
    assert!((after[0] / before[0] - 1.0).abs() < 1e-14, "mass {} became {}", before[0], after[0]);
    for axis in [1, 2] {
        assert!((after[axis] - before[axis]).abs() < 1e-14 * before[3], "momentum {before:?} became {after:?}");
    }
    assert_eq!(world.points_total, points + done.points);
    assert!(done.refused.is_empty() && !done.mass_factors.is_empty(), "{done:?}");
    assert!(done.mass_factors.iter().all(|factor| (factor - 1.0).abs() < 0.08), "{done:?}");
    assert!(done.grains_rim > 10 && done.points_whole > 0, "a rim is left and a rim is made: {done:?}");
    let left = world.assembly.grains.hot.iter().filter(|hot| is_left(&hot.position)).count();
    assert!(left < leaving / 20, "{left} grains are left behind");

    // What was made stands as the grains did, and has come from where they came.
    let rows: Vec<_> = world.continuum.points.rows().collect();
    assert!(rows.iter().all(|point| !is_left(&point.hot.position) || point.hot.weight == 1.0), "a rim far away");
    let made: Vec<_> = rows.iter().filter(|point| point.cold.id.0 > last_id).collect();
    assert_eq!(made.len() as u64, done.points);
    for point in &made {
        let wanted = if is_left(&point.hot.position) { 1.0 } else { 0.5 };
        assert_eq!(point.hot.weight, wanted, "{point:?}");
    }
    let law = world.settings.material.clone();
    let fraction_of = move |hot: &Hot<Plane>| law.fraction(&hot.memory);
    let volume: f64 = made.iter().map(|point| point.hot.volume).sum();
    let mean = |of: &Figure| made.iter().map(|point| of(&point.hot) * point.hot.volume).sum::<f64>() / volume;
    let stress_of = |component: usize| mean(&move |hot| hot.stress.0[component]);
    let of_points = [stress_of(0), stress_of(1), stress_of(2)];
    println!("stress of points {of_points:?}, fraction {}", mean(&fraction_of));
    for (points, grains) in of_points.iter().zip(stress) {
        assert!((points - grains).abs() < 0.2 * stress[1].abs(), "{of_points:?} Pa of points for {stress:?} of grains");
    }
    assert!((mean(&fraction_of) / fraction - 1.0).abs() < 0.02);
    let moved = |point: &PlanarPoint| point.hot.position[0] - point.cold.origin[0];
    let whole: Vec<_> = made.iter().filter(|point| point.hot.weight == 1.0).collect();
    let mean = whole.iter().map(|point| moved(point)).sum::<f64>() / whole.len() as f64;
    println!("points have come {mean:.3e} m, grains {gone:.3e} m");
    assert!((mean - gone).abs() < 0.1 * most, "{mean} m for {gone} m of grains, of {most} m");
    assert!(made.iter().all(|point| (point.past.track.displacements[0][0] / moved(point)) < 1.0));
    let now = world.energies().unwrap();
    let kinetic = |of: &Energies| of.kinetic_grains + of.kinetic_points;
    assert!((kinetic(&now) / kinetic(&energies) - 1.0).abs() < 0.2, "{now:?} after {energies:?}");

    // And so it goes on.
    advance(&mut world, 2000);
    let later = world.energies().unwrap();
    println!("kinetic {} J, {} J, then {} J", kinetic(&energies), kinetic(&now), kinetic(&later));
    assert!(kinetic(&later) < 2.0 * kinetic(&energies), "the change stirred things up: {later:?} after {energies:?}");
    world.rebuild().unwrap();
    assert!((sums(&world)[0] / before[0] - 1.0).abs() < 1e-13);
}

#[test]
fn a_zone_grows_around_grains_that_stay_as_they_are() {
    let scenario = packed_job(&["enrichment.distance=4.5 mm"]);
    let folder = tempfile::tempdir().unwrap();
    let (mut world, instants, flagged, first) = enriched(&scenario, folder.path());
    advance(&mut world, 500);
    world.rebuild().unwrap();
    let before = sums(&world);
    let mut residents = world.rows().0;
    residents.sort_unstable_by_key(|row| row.cold.id);
    let energies = world.energies().unwrap();

    // Two cells up.
    let up = 2 * cell_grid(&world).counts[0] as u64;
    let higher: Vec<u64> = flagged.iter().map(|node| node + up).collect();
    let how = (&scenario.enrichment, scenario.specimen.depth);
    let file = folder.path().join("packing.h5");
    let grown = enrich(&mut world, how, &higher, &instants, (&file, Lies::Whole));
    let after = sums(&world);
    println!("{grown:?}");
    assert!((after[0] / before[0] - 1.0).abs() < 1e-14, "mass {} became {}", before[0], after[0]);
    for axis in [1, 2] {
        assert!((after[axis] - before[axis]).abs() < 1e-14 * before[3], "momentum {before:?} became {after:?}");
    }
    assert_eq!(world.grains_total, first.grains + grown.grains);
    assert!(grown.grains > 50, "{grown:?}");

    let mut rows = world.rows().0;
    rows.sort_unstable_by_key(|row| row.cold.id);
    assert!(rows.windows(2).all(|pair| pair[0].cold.id < pair[1].cold.id), "a grain came twice");
    assert!(rows.iter().all(|row| row.cold.mover == Mover::Free));
    let (mut raised, mut joined) = (0, 0);
    for resident in &residents {
        let at = rows.binary_search_by_key(&resident.cold.id, |row| row.cold.id).expect("residents stay");
        let now = &rows[at];
        assert_eq!((now.hot.position, now.hot.velocity), (resident.hot.position, resident.hot.velocity));
        raised += usize::from(now.hot.weight > resident.hot.weight);
        // Old contacts have their memories, and there are new ones.
        for contact in &resident.contacts {
            let kept = now.contacts.iter().find(|(partner, _)| *partner == contact.0);
            let kept = kept.unwrap_or_else(|| panic!("a contact of grain {} is gone", now.cold.id.0));
            assert_eq!(kept.1, contact.1, "a contact of grain {} lost its memory", now.cold.id.0);
        }
        joined += usize::from(now.contacts.len() > resident.contacts.len());
    }
    println!("{raised} grains of the rim are of the core now, {joined} touch new ones");
    assert!(raised > 20 && joined > 5, "{raised} raised, {joined} joined");
    let pressed = grown.stress_grains[1] / grown.stress_points[1];
    assert!((pressed - 1.0).abs() < 0.5, "new grains bear {pressed} of what points bore");

    advance(&mut world, 2000);
    let later = world.energies().unwrap();
    println!("before {energies:?}, later {later:?}");
    assert!(later.kinetic_grains + later.kinetic_points < 2.0 * (energies.kinetic_grains + energies.kinetic_points));
    assert_eq!(world.grains_total, first.grains + grown.grains);
}
