//! Cutting a curve of weighted blocks into stretches of nearly equal weight.

use std::ops::Range;

/// Cuts blocks of these weights into `parts` contiguous ranges that cover them all, in order.
///
/// The heaviest part is as light as any contiguous cut can make it; among parts of equal weight the
/// number of blocks is levelled, so blocks without weight spread evenly too. Within that bound each
/// part is drawn towards the mean of what is left. No part is empty unless there are fewer blocks
/// than parts; then each block is a part, and the last parts are empty. Integers only: every rank
/// that cuts the same weights finds the same ranges.
///
/// # Panics
/// When `parts` is zero.
pub fn cut(weights: &[u64], parts: usize) -> Vec<Range<usize>> {
    assert!(parts > 0, "blocks cannot be dealt to 0 parts");
    let blocks = weights.len();
    if blocks <= parts {
        return (0..parts).map(|part| part.min(blocks)..(part + 1).min(blocks)).collect();
    }
    let load = Load::new(weights);
    let bound = load.bottleneck(parts);
    let needed = load.parts_needed(bound);

    let mut ranges = Vec::with_capacity(parts);
    let mut start = 0;
    for left in (1..parts).rev() {
        // The rest must fit `left` parts under the bound, and leave each of them a block.
        let end_max = load.reach(start, bound).min(blocks - left);
        let end_min = (start + 1) + needed[start + 1..].partition_point(|&parts| parts > left);
        let end = load.nearest(start, load.between(start, blocks) / (left as u128 + 1), end_min, end_max);
        ranges.push(start..end);
        start = end;
    }
    ranges.push(start..blocks);
    ranges
}

/// Running totals of the weights. A block counts `weight * blocks + 1`, which makes the number of
/// blocks in a part the penalty spring-breaker below any difference of weight; u128 holds that for any u64
/// weights of up to 2^32 blocks.
struct Load {
    before: Vec<u128>,
}

impl Load {
    fn new(weights: &[u64]) -> Self {
        let scale = weights.len() as u128;
        let mut total = 0;
        let mut before = vec![0];
        before.extend(weights.iter().map(|&weight| {
            total += u128::from(weight) * scale + 1;
            total
        }));
        Self { before }
    }

    fn blocks(&self) -> usize {
        self.before.len() - 1
    }

    fn between(&self, start: usize, end: usize) -> u128 {
        self.before[end] - self.before[start]
    }

    /// The furthest end of a part from `start` that stays within `bound`.
    fn reach(&self, start: usize, bound: u128) -> usize {
        let limit = self.before[start] + bound;
        start + self.before[start..].partition_point(|&total| total <= limit) - 1
    }

    /// The smallest load of the heaviest part over all cuts into `parts`.
    fn bottleneck(&self, parts: usize) -> u128 {
        let heaviest = (0..self.blocks()).map(|k| self.between(k, k + 1)).max().unwrap_or(0);
        let mean = self.between(0, self.blocks()).div_ceil(parts as u128);
        // Filling each part up to mean + heaviest always suffices.
        let (mut low, mut high) = (heaviest.max(mean), heaviest + mean);
        while low < high {
            let middle = low + (high - low) / 2;
            if self.fits(parts, middle) { high = middle } else { low = middle + 1 }
        }
        low
    }

    fn fits(&self, parts: usize, bound: u128) -> bool {
        (0..parts).fold(0, |start, _| self.reach(start, bound)) == self.blocks()
    }

    /// How few parts under `bound` hold the blocks from each start on.
    fn parts_needed(&self, bound: u128) -> Vec<usize> {
        let mut needed = vec![0; self.blocks() + 1];
        for start in (0..self.blocks()).rev() {
            needed[start] = 1 + needed[self.reach(start, bound)];
        }
        needed
    }

    /// The end in `end_min..=end_max` whose load from `start` is nearest to `target`, the smaller
    /// one of two.
    fn nearest(&self, start: usize, target: u128, end_min: usize, end_max: usize) -> usize {
        debug_assert!(end_min <= end_max, "a feasible bound leaves a feasible end");
        let over =
            end_min + self.before[end_min..end_max].partition_point(|&total| total < self.before[start] + target);
        if over == end_min {
            return over;
        }
        let under = over - 1;
        let (short, long) = (target.abs_diff(self.between(start, under)), target.abs_diff(self.between(start, over)));
        if short <= long { under } else { over }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn heaviest(weights: &[u64], ranges: &[Range<usize>]) -> u64 {
        ranges.iter().map(|range| weights[range.clone()].iter().sum()).max().unwrap()
    }

    /// The lightest possible heaviest part, by trying every cut.
    fn heaviest_by_force(weights: &[u64], parts: usize) -> u64 {
        if parts == 1 {
            return weights.iter().sum();
        }
        (0..=weights.len())
            .map(|end| weights[..end].iter().sum::<u64>().max(heaviest_by_force(&weights[end..], parts - 1)))
            .min()
            .unwrap()
    }

    fn covers(ranges: &[Range<usize>], blocks: usize, parts: usize) {
        assert_eq!(ranges.len(), parts);
        assert_eq!((ranges[0].start, ranges[parts - 1].end), (0, blocks));
        assert!(ranges.windows(2).all(|pair| pair[0].end == pair[1].start));
        if blocks >= parts {
            assert!(ranges.iter().all(|range| !range.is_empty()), "{ranges:?}");
        }
    }

    #[test]
    fn weightless_blocks_spread_evenly() {
        for (blocks, parts) in [(12, 4), (13, 4), (100, 7), (7, 7)] {
            let ranges = cut(&vec![0; blocks], parts);
            covers(&ranges, blocks, parts);
            assert!(ranges.iter().all(|range| range.len() == blocks / parts || range.len() == blocks.div_ceil(parts)));
        }
    }

    #[test]
    fn fewer_blocks_than_parts_leave_the_last_parts_empty() {
        assert_eq!(cut(&[5, 1], 4), [0..1, 1..2, 2..2, 2..2]);
        assert_eq!(cut(&[], 2), [0..0, 0..0]);
    }

    #[test]
    fn the_largest_weights_do_not_overflow() {
        covers(&cut(&[u64::MAX; 1000], 3), 1000, 3);
    }

    proptest! {
        #[test]
        fn no_cut_has_a_lighter_heaviest_part(
            weights in prop::collection::vec(prop_oneof![Just(0), 0_u64..4, 0_u64..100], 0..10),
            parts in 1_usize..5,
        ) {
            let ranges = cut(&weights, parts);
            covers(&ranges, weights.len(), parts);
            prop_assert_eq!(heaviest(&weights, &ranges), heaviest_by_force(&weights, parts));
        }

        #[test]
        fn every_part_gets_blocks(weights in prop::collection::vec(0_u64..1000, 1..200), parts in 1_usize..40) {
            covers(&cut(&weights, parts), weights.len(), parts);
        }
    }
}
