//! Blocks follow the work: a deal that has gone wrong is mended by itself, once, and one that is right is left alone.

use scree_partition::transport::threads;

use crate::coupling::shaken;

const LOOKS: usize = 60;
const STEPS_PER_LOOK: usize = 25;

/// Rank 1 has everything but one block; what it measures must make it share, and then both must keep what they have.
#[test]
fn a_bad_deal_is_mended_and_a_good_one_kept() {
    let seen = threads::run(2, |rank| {
        let mut world = shaken(&rank);
        let blocks = world.subdomain.layout.block_count();
        world.deal_by(&(0..blocks).map(|block| if block == 0 { 1 << 40 } else { 1 }).collect::<Vec<_>>()).unwrap();
        let mut seen = Vec::new();
        for _ in 0..LOOKS {
            (0..STEPS_PER_LOOK).for_each(|_| world.advance().unwrap());
            world.rebuild().unwrap();
            seen.push((world.load_balance.deals, world.assembly.grains.owned + world.continuum.points.len()));
        }
        seen
    });
    let deals: Vec<u64> = seen[0].iter().map(|(deals, _)| *deals).collect();
    assert_eq!(deals, seen[1].iter().map(|(deals, _)| *deals).collect::<Vec<_>>(), "ranks disagree on deals");
    let mended = deals.iter().position(|deals| *deals > 0).expect("nobody mended the deal");
    // Times are noisy where tests share the machine; to and fro would be a deal every look.
    assert!(deals[LOOKS - 1] <= LOOKS as u64 / 4, "blocks go to and fro: {deals:?}, mended after {mended} looks");
    let rows = [0, 1].map(|rank: usize| seen[rank][LOOKS - 1].1 as f64);
    assert!(rows[0].min(rows[1]) > 0.25 * (rows[0] + rows[1]), "the work is not shared: {rows:?}");
}

/// On one rank there is nothing to deal, and costs are measured all the same, for plans.
#[test]
fn one_rank_measures_what_rows_cost() {
    let mut world = shaken(&scree_partition::Solo);
    (0..200).for_each(|_| world.advance().unwrap());
    let map = world.load_map(200, 1, 0.0);
    let total = |counts: &[u32]| counts.iter().map(|count| u64::from(*count)).sum::<u64>();
    assert_eq!([total(&map.grains), total(&map.points)], [world.grains_total, world.points_total]);
    // Of a nanosecond to some microseconds: measured, in seconds.
    assert!(map.costs.iter().all(|cost| (1e-10..1e-4).contains(cost)), "{:?}", map.costs);
    assert_eq!(world.load_balance.deals, 0);
}
