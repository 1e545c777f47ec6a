//! Grains for points: what enters, what stays, and that nothing is made or lost on the way.

use proptest::prelude::*;
use scree::adapt::enrichment::{self, Enriched, Plan, Refusal, cell_grid};
use scree::adapt::watch;
use scree::couple::oracle::Memory;
use scree::couple::select::{Candidate, Selection, select};
use scree::couple::zone::{CellGrid, Enrichment, Label, Zone, ZoneLife};
use scree::dem::grains::Mover;
use scree::domain::accounts::ledger::Accounts;
use scree::domain::grid::body_impulse;
use scree::job::{Job, Scenario};
use scree::mpm::track::Instants;
use scree::prepare::reference::Lies;
use scree::prepare::{plates, sheared};
use scree::run::{Outcome, start};
use scree_partition::{Solo, Transport};

use crate::runs::options;
use crate::worlds::{PlanarWorld, Random, packed_job};

fn settings(distance: f64) -> Enrichment {
    let life = ZoneLife::FOR_GOOD;
    Enrichment { distance, weight: 0.5, training: 1.0, training_speed: 1.0, training_rest: 0.5, life }
}

/// Mass, momentum along x and y, and the sum of the momenta's magnitudes, of everything with its weight.
pub fn sums(world: &PlanarWorld) -> [f64; 4] {
    let grains = world.assembly.grains.hot[..world.assembly.grains.owned].iter();
    let grains = grains.map(|hot| (hot.weight * hot.mass, hot.velocity));
    let points = world.continuum.points.rows().map(|point| (point.hot.weight * point.hot.mass, point.hot.velocity));
    grains.chain(points).fold([0.0; 4], |[mass, x, y, scale], (more, velocity)| {
        [mass + more, x + more * velocity[0], y + more * velocity[1], scale + more * velocity.norm()]
    })
}

/// Grains for the points around these nodes.
pub fn enrich(
    world: &mut PlanarWorld,
    how: (&Enrichment, f64),
    flagged: &[u64],
    instants: &Instants,
    packing: (&std::path::Path, Lies<'_>),
) -> Enriched {
    let wanted = enrichment::around_band(world, flagged, how.0);
    let plan = Plan::of(world, how, wanted, instants, packing).unwrap();
    plan.unwrap_or_else(|Refusal(why)| panic!("{why}")).carry_out(world).unwrap()
}

/// A hybrid run up to the moment when the oracle fires.
pub fn up_to_the_band<'t>(
    scenario: &Scenario,
    transport: &'t dyn Transport,
    packing_file: &std::path::Path,
) -> (PlanarWorld<'t>, Vec<u64>, Instants) {
    let mut start = plates::prepare(scenario, transport).unwrap();
    let packing = sheared::state_of(&mut start.packing.grains, &scenario.contact, start.packing.height, &mut []);
    scree_io::store::write(packing_file, &packing).unwrap();
    let mut world = plates::world(scenario, transport, start).unwrap();
    let (mut memory, mut instants) = (Memory::default(), Instants { times: Vec::new(), every: 300 });
    loop {
        world.advance().unwrap();
        assert!(world.step < 20_000, "the oracle stays silent");
        enrichment::track(&mut world, &mut instants);
        let due = world.step.is_multiple_of(scenario.oracle.every);
        let diameter = scenario.grains.diameter_mean;
        if due && watch::watch(&mut world, &mut memory, &scenario.oracle, diameter).unwrap() {
            return (world, memory.flagged, instants);
        }
    }
}

#[test]
fn enrichment_keeps_mass_and_momentum_to_round_off() {
    let scenario = packed_job(&[]);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("packing.h5");
    let (mut world, flagged, instants) = up_to_the_band(&scenario, &Solo, &file);
    assert!(instants.times.len() > 3, "a path to train along: {:?}", instants.times);
    let zone = Zone::around(&flagged, cell_grid(&world), &scenario.enrichment);
    let (before, points_before) = (sums(&world), world.continuum.points.rows().collect::<Vec<_>>());
    let energy_before = world.energies().unwrap();

    let how = (&scenario.enrichment, scenario.specimen.depth);
    let enriched = enrich(&mut world, how, &flagged, &instants, (&file, Lies::Whole));
    let after = sums(&world);
    println!(
        "enrichment: mass {:.1e}, momentum {:.1e}, {:.1e}",
        after[0] / before[0] - 1.0,
        (after[1] - before[1]) / before[3],
        (after[2] - before[2]) / before[3]
    );
    assert!((after[0] / before[0] - 1.0).abs() < 1e-14, "mass {} became {}", before[0], after[0]);
    for axis in [1, 2] {
        assert!((after[axis] - before[axis]).abs() < 1e-14 * before[3], "momentum {before:?} became {after:?}");
    }
    assert!(before[1] > 0.1 * before[3], "the specimen should be moving: {before:?}");
    reported_as_it_is(&enriched, before, after);

    // Points: none left in the core, one weight in the rim, untouched elsewhere, but for what nobody asks for any more.
    let weight = world.continuum.points.rows().map(|point| point.hot.weight).fold(1.0, f64::min);
    assert!((weight - 0.5).abs() < 0.05, "rim points keep {weight}");
    for mut point in world.continuum.points.rows() {
        let was = points_before.iter().find(|was| was.cold.id == point.cold.id).expect("no new points");
        let wanted = match zone.at(point.hot.position[0], point.hot.position[1]) {
            Label::Continuum => 1.0,
            Label::Rim => weight,
            Label::Grains => panic!("point {} is in the core", point.cold.id.0),
        };
        assert_eq!(point.hot.weight, wanted);
        point.hot.weight = was.hot.weight;
        (point.cold.home, point.hot.position, point.cold.image) = (was.cold.home, was.hot.position, was.cold.image);
        assert_eq!(point, *was);
    }
    assert_eq!(points_before.len() as u64 - enriched.points_removed, world.points_total);

    // Grains: free, each once, w in the rim, whole in the core, and moving as the points did.
    let mut ids: Vec<u64> = world.assembly.grains.cold.iter().map(|cold| cold.id.0).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len() as u64, enriched.grains);
    assert!(world.assembly.grains.cold.iter().all(|cold| cold.mover == Mover::Free));
    let rim = world.assembly.grains.hot.iter().filter(|hot| hot.weight == 0.5).count() as u64;
    let core = world.assembly.grains.hot.iter().filter(|hot| hot.weight == 1.0).count() as u64;
    assert_eq!((rim, rim + core), (enriched.grains_rim, enriched.grains));
    assert!(rim > 30 && core > 60, "{rim} grains in the rim, {core} in the core");
    let kinetic = world.energies().unwrap();
    let kinetic = kinetic.kinetic_points + kinetic.kinetic_grains;
    assert!((kinetic / energy_before.kinetic_points - 1.0).abs() < 0.1, "{kinetic} J of motion after enrichment");

    // And so it goes on, with an account of the grains' energy.
    world.open_accounts(Accounts::GRAINS);
    for _ in 0..500 {
        world.advance().unwrap();
    }
    let balance = world.balance().unwrap();
    let unexplained = (balance.imbalance() + balance.made) / balance.elastic_start;
    println!("after enrichment: residual {:.1e}, unexplained {unexplained:.1e}: {balance:?}", balance.residual());
    assert!(unexplained.abs() < 1e-10 && balance.residual().abs() < 1e-2, "{balance:?}");
    assert!(balance.work_nodes.abs() > 1e-4 * balance.elastic_start, "{balance:?}");
    world.rebuild().unwrap();
    assert!((sums(&world)[0] / before[0] - 1.0).abs() < 1e-14);
    assert_eq!(world.grains_total, enriched.grains);
}

fn reported_as_it_is(enriched: &Enriched, before: [f64; 4], after: [f64; 4]) {
    for (sums, mass, momentum) in [
        (before, enriched.kept.mass[0], enriched.kept.momentum[0]),
        (after, enriched.kept.mass[1], enriched.kept.momentum[1]),
    ] {
        assert!((mass / sums[0] - 1.0).abs() < 1e-13, "{enriched:?}");
        assert!((momentum[0] - sums[1]).abs() + (momentum[1] - sums[2]).abs() < 1e-13 * sums[3], "{enriched:?}");
    }
    let ratio = enriched.training_energy_ratio;
    assert!(enriched.training_steps > 1000 && ratio > 0.0 && ratio < 1e-2, "{enriched:?}");
    assert!(enriched.stress_points[1] < 0.0 && enriched.stress_grains[1] < 0.0, "both are compressed: {enriched:?}");
}

/// The grains that are glued to a plate come with a zone that reaches it, where the plate has taken them, and bear what grains of the zone put on them; those of the other
/// plate stay away.
#[test]
fn a_zone_at_a_plate_has_the_grains_of_the_plate() {
    let at_plate = ["continuum.weak.0.lower=[0.0, 0.027]", "continuum.weak.0.upper=[0.012, 0.033]"];
    let scenario = packed_job(&at_plate);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("packing.h5");
    let (mut world, flagged, instants) = up_to_the_band(&scenario, &Solo, &file);
    let before = sums(&world);
    let how = (&scenario.enrichment, scenario.specimen.depth);
    let enriched = enrich(&mut world, how, &flagged, &instants, (&file, Lies::Whole));
    let after = sums(&world);
    assert!((after[0] / before[0] - 1.0).abs() < 1e-14, "mass {} became {}", before[0], after[0]);
    for axis in [1, 2] {
        assert!((after[axis] - before[axis]).abs() < 1e-14 * before[3], "momentum {before:?} became {after:?}");
    }
    // Nothing of the rim is at the plate.
    let highest = world.continuum.points.rows().map(|point| point.hot.position[1]).fold(0.0, f64::max);
    assert!(highest < world.bodies[1].face() - scenario.continuum.cell, "a point at {highest} m");
    let glued = |world: &PlanarWorld, plate| -> Vec<_> {
        let rows = world.grain_rows(0..world.assembly.grains.owned);
        rows.into_iter().filter(|row| row.cold.mover == Mover::Body(plate)).collect()
    };
    assert!(glued(&world, 0).is_empty());
    let of_upper = glued(&world, 1);
    assert!(of_upper.len() > 30, "{} grains of the upper plate", of_upper.len());
    assert_eq!(enriched.grains + of_upper.len() as u64, world.grains_total);
    let upper = &world.bodies[1];
    for row in &of_upper {
        assert_eq!(row.hot.weight, 0.0);
        let way = row.hot.position - row.cold.origin + world.assembly.cell.shift(row.cold.image);
        assert!((way - upper.displacement).norm() < 1e-12, "{way:?} for {:?}", upper.displacement);
    }
    let pressure = [enriched.stress_points, enriched.stress_grains].map(|[xx, yy, _]| xx + yy);
    assert!((pressure[1] / pressure[0] - 1.0).abs() < 0.15, "{pressure:?}");
    for _ in 0..2000 {
        world.advance().unwrap();
    }
    let load = |world: &mut PlanarWorld| body_impulse(&world.take_reactions().unwrap(), 1).0;
    load(&mut world);
    let steps = 2000;
    for _ in 0..steps {
        world.advance().unwrap();
    }
    let area = scenario.specimen.width * scenario.specimen.depth;
    let borne = load(&mut world)[1] / (f64::from(steps) * scenario.time.step * area);
    assert!((borne / scenario.loading.stress_normal - 1.0).abs() < 0.1, "the plate is pressed by {borne} Pa");
}

/// Glued grains, and nodes that grains share, push a plate in every step of grains; its servo moves it once in four of them, by what it foresees. What it does not foresee it is
/// given in the next four, so that the plate is pressed by what the job says.
#[test]
fn a_servo_is_given_what_acts_in_the_middle_of_a_cycle() {
    let at_plate = ["continuum.weak.0.lower=[0.0, 0.027]", "continuum.weak.0.upper=[0.012, 0.033]"];
    let scenario = packed_job(&[&at_plate[..], &["time.grain_steps=4"]].concat());
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("packing.h5");
    let (mut world, flagged, instants) = up_to_the_band(&scenario, &Solo, &file);
    let how = (&scenario.enrichment, scenario.specimen.depth);
    enrich(&mut world, how, &flagged, &instants, (&file, Lies::Whole));
    let cycles = 500;
    let advanced = |world: &mut PlanarWorld| (0..cycles).for_each(|_| world.advance().unwrap());
    advanced(&mut world);
    world.take_reactions().unwrap();
    let before = world.bodies[1].clone();
    advanced(&mut world);
    let (taken, _) = body_impulse(&world.take_reactions().unwrap(), 1);
    let (plate, servo) = (&world.bodies[1], before.servo.as_ref().unwrap());
    let load = servo.force * f64::from(4 * cycles) * scenario.time.step;
    let damped = servo.damping * (plate.displacement - before.displacement)[1];
    let wanted = servo.mass * (plate.velocity - before.velocity)[1] + load + damped;
    let off = (taken[1] - wanted) / load;
    println!("the plate has taken {} of its load, {off:e} of it more than moves it", taken[1] / load);
    // One cycle is still to come.
    assert!(off.abs() < 1e-4, "{off:e}");
}

/// A month's run is not ended by a zone that cannot be made: it is told, asked for again later, and the band stays continuum.
#[test]
fn a_run_whose_zones_are_refused_goes_on_as_a_continuum() {
    // A band so thick that a zone around it is all there is, and has no rim.
    let thick = ["continuum.weak.0.lower=[0.0, 0.009]", "continuum.weak.0.upper=[0.012, 0.027]"];
    let scenario = packed_job(&[&thick[..], &["enrichment.distance=14 mm", "loading.strain_end=0.06"]].concat());
    let folder = tempfile::tempdir().unwrap();
    let outcome = start::start(&Job::Shear(scenario), &options(folder.path()), &Solo).unwrap();
    let Outcome::Done(words) = outcome else { panic!("{outcome:?}") };
    assert!(words.contains("No grains have entered") && words.contains("no core or no rim"), "{words}");
    let log = std::fs::read_to_string(folder.path().join("log.jsonl")).unwrap();
    let refused = log.lines().filter(|line| line.contains("zone_refused")).count();
    println!("{words}");
    assert!((2..20).contains(&refused), "{refused} times in\n{log}");
    let run = scree::analysis::run::Run::read(folder.path()).unwrap();
    assert_eq!(run.told("zones_refused"), Some(refused as f64));
}

const CELL: f64 = 2.0;
const GRID: CellGrid = CellGrid { counts: [8, 24], cell: CELL, lower: [0.0, -6.0], periodic: true };

/// Label of a cell from the nearest flagged node, looked for in three periods.
fn label_by_hand(flagged: &[u64], column: usize, row: usize, distance: f64) -> Label {
    let centre = [(column as f64 + 0.5) * CELL, (row as f64 + 0.5) * CELL];
    let mut least = f64::INFINITY;
    for node in flagged {
        for image in [-1.0, 0.0, 1.0] {
            let x = ((node % 8) as f64 + 8.0 * image) * CELL - centre[0];
            let y = (node / 8) as f64 * CELL - centre[1];
            least = least.min((x * x + y * y).sqrt());
        }
    }
    match least {
        near if near <= distance - 0.5 * CELL => Label::Grains,
        near if near <= distance + 0.5 * CELL => Label::Rim,
        _ => Label::Continuum,
    }
}

/// Labels row by row as letters: `.` continuum, `+` rim, `o` grains.
fn drawn(zone: &Zone) -> Vec<String> {
    let letter = |label: &Label| match label {
        Label::Continuum => '.',
        Label::Rim => '+',
        Label::Grains => 'o',
    };
    zone.labels.chunks(8).map(|row| row.iter().map(letter).collect()).collect()
}

/// A flat band: whole rows, two of grains and one of rim on either side, mirrored about the band.
#[test]
fn a_flat_band_makes_flat_layers() {
    let flagged: Vec<u64> = (0..8).map(|column| 12 * 8 + column).collect();
    // Centres lie 0.71, 1.58, 2.55 and 3.54 cells from the nearest node.
    let rows = drawn(&Zone::around(&flagged, GRID, &settings(2.2 * CELL)));
    let wanted: Vec<&str> = (0..24)
        .map(|row| match row {
            10..14 => "oooooooo",
            9 | 14 => "++++++++",
            _ => "........",
        })
        .collect();
    assert_eq!(rows, wanted);
}

/// A diagonal band that leaves through the period: the same picture wherever the period is cut.
#[test]
fn a_diagonal_band_goes_on_across_the_period() {
    let around = |shift: u64| {
        let flagged: Vec<u64> = (0..6).map(|step| (8 + step) * 8 + (5 + step + shift) % 8).collect();
        let zone = Zone::around(&flagged, GRID, &settings(2.2 * CELL));
        for (cell, label) in zone.labels.iter().enumerate() {
            assert_eq!(*label, label_by_hand(&flagged, cell % 8, cell / 8, 2.2 * CELL), "cell {cell}, shift {shift}");
        }
        zone
    };
    let wanted = drawn(&around(0));
    assert!(wanted[8].contains("oo") && wanted[13].starts_with("oo"), "{wanted:#?}");
    for shift in 1..8 {
        for (row, wanted) in drawn(&around(shift)).iter().zip(&wanted) {
            let turned: String = (0..8).map(|column| row.as_bytes()[(column + shift as usize) % 8] as char).collect();
            assert_eq!(turned, *wanted, "shift {shift}");
        }
    }
    // A place is looked up across the period as well, and is continuum outside the grid.
    let zone = around(0);
    for y in [-5.0, 3.0, 11.0, 21.0, 40.0] {
        assert_eq!(zone.at(0.3, y), zone.at(16.3, y));
        assert_eq!(zone.at(-0.3, y), zone.at(15.7, y));
        assert_eq!(zone.distance([0.3, y]), zone.distance([16.3, y]));
    }
    assert_eq!((zone.at(3.0, -6.1), zone.at(3.0, 42.1)), (Label::Continuum, Label::Continuum));
}

/// Flagged nodes in the middle rows of the grid.
fn flagged_nodes() -> impl Strategy<Value = Vec<u64>> {
    prop::collection::btree_set(9 * 8u64..15 * 8, 1..25).prop_map(|nodes| nodes.into_iter().collect())
}

/// Grains all over the grid, jittered about a lattice of `spacing`, that weigh one unit per area on the average.
fn candidates(seed: u64, spacing: f64) -> Vec<Candidate> {
    let mut random = Random(seed);
    let mut candidates = Vec::new();
    let counts = [(16.0 / spacing).round() as usize, (48.0 / spacing).round() as usize];
    for row in 0..counts[1] {
        for column in 0..counts[0] {
            let place = [
                (column as f64 + 0.5 + 0.4 * random.signed()) * 16.0 / counts[0] as f64,
                (row as f64 + 0.5 + 0.4 * random.signed()) * 48.0 / counts[1] as f64 - 6.0,
            ];
            let number = candidates.len();
            let mass = spacing * spacing * (1.0 + 0.3 * random.signed());
            candidates.push(Candidate { row: number, id: 7 * number as u64 % 100_003, mass, place });
        }
    }
    candidates
}

/// What must hold of any choice: core whole, rim from the inside out, each grain once, masses equal.
fn check(zone: &Zone, candidates: &[Candidate], masses: [f64; 2], weight: f64, chosen: &Selection) {
    let [core, rim] = masses;
    let role = |row: usize| chosen.chosen.iter().find(|(at, _)| *at == row).map(|(_, in_rim)| *in_rim);
    let (mut inside, mut nearest_out, mut farthest_in, mut heaviest) = (0.0, f64::INFINITY, 0.0f64, 0.0f64);
    for candidate in candidates {
        let distance = zone.distance(candidate.place);
        heaviest = heaviest.max(candidate.mass);
        match (zone.at(candidate.place[0], candidate.place[1]), role(candidate.row)) {
            (Label::Grains, role) => {
                assert_eq!(role, Some(false), "all of the core enters");
                inside += candidate.mass;
            }
            (_, Some(in_rim)) => {
                assert!(in_rim, "what is not in the core is in the rim");
                inside += weight * candidate.mass;
                farthest_in = farthest_in.max(distance);
            }
            (_, None) => nearest_out = nearest_out.min(distance),
        }
    }
    assert!(farthest_in <= nearest_out, "the rim fills from the inside: {farthest_in} and {nearest_out}");
    let ids: Vec<u64> = chosen.chosen.iter().map(|(row, _)| candidates[*row].id).collect();
    assert!(ids.windows(2).all(|pair| pair[0] < pair[1]), "by id, each once");
    assert!((inside - chosen.mass).abs() < 1e-12 * inside);
    let left_over = core + weight * rim - chosen.mass;
    assert!(left_over.abs() <= 0.5 * weight * heaviest * (1.0 + 1e-12), "{left_over} left over, a grain is {heaviest}");
    let whole = chosen.mass + chosen.point_weight * rim;
    assert!((whole / (core + rim) - 1.0).abs() < 1e-14, "{} became {whole}", core + rim);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// The rim parts core from continuum: no cell of grains shares an edge with one of continuum.
    #[test]
    fn any_rim_is_closed(flagged in flagged_nodes(), distance in 1.5f64..4.0) {
        let zone = Zone::around(&flagged, GRID, &settings(distance * CELL));
        for row in 0..24 {
            for column in 0..8 {
                let here = zone.labels[row * 8 + column];
                prop_assert_eq!(here, label_by_hand(&flagged, column, row, distance * CELL));
                let beside = [(row * 8) + (column + 1) % 8, (row + 1).min(23) * 8 + column];
                for other in beside.map(|cell| zone.labels[cell]) {
                    let jump = [here, other].contains(&Label::Grains) && [here, other].contains(&Label::Continuum);
                    prop_assert!(!jump, "no rim at row {}, column {}: {:#?}", row, column, drawn(&zone));
                }
            }
        }
    }

    /// Whatever the zone, the grains and the weight: less than half a weighted grain is left over, and points carry it.
    #[test]
    fn chosen_grains_weigh_what_points_give_up(
        flagged in flagged_nodes(),
        (distance, spacing) in (1.5f64..4.0, 0.4f64..1.0),
        (seed, weight, density) in (any::<u64>(), 0.2f64..0.8, 0.97f64..1.03),
    ) {
        let zone = Zone::around(&flagged, GRID, &settings(distance * CELL));
        let area = |wanted: Label| {
            CELL * CELL * zone.labels.iter().filter(|label| **label == wanted).count() as f64
        };
        let masses = [Label::Grains, Label::Rim].map(|label| density * area(label));
        prop_assume!(masses[0] > 0.0);
        let candidates = candidates(seed, spacing);
        // Where the core's grains alone outweigh what the points give up, the rim has nothing to settle with; enrichment
        // refuses such a packing.
        let in_core = candidates.iter().filter(|grain| zone.at(grain.place[0], grain.place[1]) == Label::Grains);
        prop_assume!(in_core.map(|grain| grain.mass).sum::<f64>() < masses[0] + weight * masses[1]);
        let chosen = select(&zone, &candidates, masses[0], masses[1], weight);
        check(&zone, &candidates, masses, weight, &chosen);
        prop_assert!((chosen.point_weight - (1.0 - weight)).abs() * masses[1] < weight * 2.0 * spacing * spacing);
    }
}

/// Of a tall specimen only the zone is made of a packing, which lies about the band wherever that is.
#[test]
fn a_packing_lower_than_the_specimen_lies_about_the_band() {
    let tall = packed_job(&[
        "specimen.height=72 mm",
        "packing.height=36 mm",
        "continuum.weak.0.lower=[0.0, 0.045]",
        "continuum.weak.0.upper=[0.012, 0.051]",
    ]);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("packing.h5");
    let (mut world, flagged, instants) = up_to_the_band(&tall, &Solo, &file);
    let (_, height) = sheared::of_state(sheared::read_state(&file).unwrap(), 1).unwrap();
    assert!((height / 36e-3 - 1.0).abs() < 0.05, "the packing is {height} m high");
    let before = sums(&world);
    let how = (&tall.enrichment, tall.specimen.depth);
    let enriched = enrich(&mut world, how, &flagged, &instants, (&file, Lies::Around));
    let after = sums(&world);
    assert!((after[0] / before[0] - 1.0).abs() < 1e-14, "{before:?} {after:?}");
    let heights: Vec<f64> =
        world.assembly.grains.hot[..world.assembly.grains.owned].iter().map(|grain| grain.position[1]).collect();
    let middle = heights.iter().sum::<f64>() / heights.len() as f64;
    println!(
        "{} grains about {middle:.4} m, {:?} for {:?} Pa",
        heights.len(),
        enriched.stress_grains,
        enriched.stress_points
    );
    assert!((middle - 48e-3).abs() < 3e-3, "about {middle} m");
    // Half of so few grains are in the rim, and the other half strained by 3 %.
    let [points, grains] = [enriched.stress_points, enriched.stress_grains];
    assert!((grains[0] / points[0] - 1.0).abs() < 0.3 && (grains[1] / points[1] - 1.0).abs() < 0.6, "{enriched:?}");
}
