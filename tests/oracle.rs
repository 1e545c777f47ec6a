//! scratch
use crate::worlds::job;
use scree::enrichment;
use scree::hybrid::oracle::Memory;
use scree::scenario::derived;
use scree::specimen;
use scree_partition::Solo;

fn explore(sets: &[&str]) {
    let mut all = vec!["method=mpm"];
    all.extend(sets);
    let s = job(&all);
    let start = specimen::prepare(&s, &Solo).unwrap();
    let mut world = specimen::world(&s, &Solo, start).unwrap();
    let mut memory = Memory::default();
    let t = std::time::Instant::now();
    let mut looks = 0;
    for _ in 0..derived::steps(&s) {
        world.advance().unwrap();
        if world.step.is_multiple_of(s.oracle.every) {
            let found = enrichment::watch(&mut world, &mut memory, &s.oracle, s.grains.diameter_mean).unwrap();
            if memory.looks != looks {
                looks = memory.looks;
                let strain = world.plates[1].displacement[0] / s.specimen.width;
                let rows: Vec<u64> = memory.flagged.iter().map(|n| n / 4).collect();
                println!(
                    "look {looks} strain {strain:.4} clock {:.4} since {:.4} flagged {} {:?}",
                    memory.clock,
                    memory.unchanged_since,
                    rows.len(),
                    rows
                );
            }
            if found {
                println!("FOUND {:?} at strain {}", memory.flagged, world.plates[1].displacement[0] / s.specimen.width);
                break;
            }
        }
    }
    let mut rows = std::collections::BTreeMap::new();
    for p in &world.points {
        let e = rows.entry((p.origin[1] * 1e5) as i64).or_insert((
            0.0,
            p.position[1],
            p.memory.fraction,
            p.stress[0],
            p.stress[3],
            p.stress[1],
            0.0,
        ));
        e.0 += p.memory.plastic_strain / 8.0;
        e.6 += (p.memory.plastic_strain - p.window.samples[memory.slot_last().unwrap_or(0)]) / 8.0;
    }
    for (k, v) in rows {
        println!("{k} {v:?}");
    }
    println!("{:?} steps {} every {} {:?}", t.elapsed(), world.step, s.oracle.every, sets);
}

#[test]
fn explore_all() {
    explore(&[
        "continuum.fraction_start=0.79",
        "continuum.fraction_critical=0.815",
        "loading.strain_end=0.05",
        "continuum.dilation_factor=7",
        "continuum.weak.0.fraction_deficit=0",
    ]);
    explore(&[
        "continuum.fraction_start=0.79",
        "continuum.fraction_critical=0.815",
        "loading.strain_end=0.05",
        "continuum.dilation_factor=3",
        "continuum.weak.0.fraction_deficit=0",
    ]);
}
