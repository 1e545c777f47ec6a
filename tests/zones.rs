//! Zones that live: they grow where the band goes, and give back the grains that rest.

use scree::dem::grains::Mover;
use scree::enrichment::{Enriched, cell_grid, dissolve, enrich, grain_stress};
use scree::hybrid::track::Instants;
use scree::law::contact::ContactLaw;
use scree::observe::energy::Energies;
use scree::reference::Lies;
use scree::scenario::{Enrichment, Scenario};
use scree::space::{Plane, Space, Words};
use scree_partition::Solo;

use crate::coupled::triaxial;
use crate::enrichment::{sums, up_to_the_band};
use crate::runs::{Ran, parse, replaced, same};
use crate::worlds::{Law, PlanarWorld, packed_job};

/// A zone too small for its band, which grows along it; and judged so strictly that it gives grains back as well.
fn restless(end: f64) -> String {
    let zone = "distance = \"4.5 mm\"\n        [zone]\n        grows = true\n        dissolves = true\n        rest_share = 0.5";
    replaced(
        triaxial("hybrid", end),
        &[("recent_strain = 4e-3", "recent_strain = 8e-3"), ("distance = \"6 mm\"", zone)],
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
    same(&parse(&restless(8e-3)), folder.path(), "a zone that grows and gives back");
}

/// A specimen that has grains in its band.
fn enriched<'t>(scenario: &Scenario, folder: &std::path::Path) -> (PlanarWorld<'t>, Instants, Vec<u64>, Enriched) {
    let file = folder.join("packing.h5");
    let (mut world, flagged, instants) = up_to_the_band(scenario, &Solo, &file);
    let how = (&scenario.enrichment, scenario.specimen.depth);
    let enriched = enrich(&mut world, how, &flagged, &instants, (&file, Lies::Whole)).unwrap();
    (world, instants, flagged, enriched)
}

fn advance(world: &mut PlanarWorld, steps: u64) {
    for _ in 0..steps {
        world.advance().unwrap();
    }
}

#[test]
fn grains_at_rest_turn_into_points_that_bear_what_they_bore() {
    let scenario = packed_job(&["enrichment.distance=9 mm"]);
    let folder = tempfile::tempdir().unwrap();
    let (mut world, instants, flagged, _) = enriched(&scenario, folder.path());
    advance(&mut world, 1000);
    let depth = scenario.specimen.depth;
    let fraction = 0.84;
    let grid = cell_grid(&world);
    // One row of cells in the middle of the band shears; all others, more than two and a half cells away, do not.
    let columns = grid.counts[0] as u64;
    let row = flagged[flagged.len() / 2] / columns;
    let busy: Vec<u64> = (row * columns..(row + 1) * columns).collect();
    let near = Enrichment { distance: 3e-3, ..scenario.enrichment };
    let stays = grid.near(&busy, 7.5e-3);
    let is_left = |place: &<Plane as Space>::Vector| !stays[grid.at(place[0], place[1]).unwrap()];
    let stress = grain_stress(&mut world, depth).unwrap();
    let (before, energies, points) = (sums(&world), world.energies().unwrap(), world.points_total);
    let leaving = world.grains.hot.iter().filter(|hot| is_left(&hot.position)).count();
    assert!(leaving > 50, "only {leaving} of {} grains lie far from the band", world.grains_total);

    let done = dissolve(&mut world, (&near, depth, fraction), &instants, &busy).unwrap().expect("grains that rest");
    let after = sums(&world);
    println!("{done:?}: stress of grains {stress:?}");
    assert!((after[0] / before[0] - 1.0).abs() < 1e-14, "mass {} became {}", before[0], after[0]);
    for axis in [1, 2] {
        assert!((after[axis] - before[axis]).abs() < 1e-14 * before[3], "momentum {before:?} became {after:?}");
    }
    assert_eq!(world.points_total, points + done.points);
    assert!((done.mass_factor - 1.0).abs() < 0.05, "masses of points off by {}", done.mass_factor);
    assert!(world.grains.hot.iter().all(|hot| !is_left(&hot.position)), "grains are left behind");

    // What was made stands as the grains did.
    let made: Vec<_> = world
        .points
        .rows()
        .filter(|point| grid.at(point.hot.position[0], point.hot.position[1]).is_some_and(|cell| !stays[cell]))
        .collect();
    assert!(made.iter().all(|point| point.hot.weight == 1.0), "points of a rim among points alone");
    let volume: f64 = made.iter().map(|point| point.hot.volume).sum();
    let mean = |component: usize| {
        made.iter().map(|point| point.hot.stress.0[component] * point.hot.volume).sum::<f64>() / volume
    };
    println!("stress of points {:?}", [mean(0), mean(1), mean(2)]);
    assert!((mean(1) / stress[1] - 1.0).abs() < 0.25, "{} Pa of points for {} of grains", mean(1), stress[1]);

    // And so it goes on.
    advance(&mut world, 2000);
    let later = world.energies().unwrap();
    let kinetic = |of: &Energies| of.kinetic_grains + of.kinetic_points;
    println!("kinetic {} J, then {} J", kinetic(&energies), kinetic(&later));
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
    let grown = enrich(&mut world, how, &higher, &instants, (&file, Lies::Whole)).unwrap();
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
            let words =
                |of: &<Law as ContactLaw<Plane>>::Memory<f64>| (0..1).map(|word| of.word(word)).collect::<Vec<_>>();
            let kept = now.contacts.iter().find(|(partner, _)| *partner == contact.0);
            let kept = kept.unwrap_or_else(|| panic!("a contact of grain {} is gone", now.cold.id.0));
            assert_eq!(words(&kept.1), words(&contact.1), "a contact of grain {} lost its memory", now.cold.id.0);
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
