//! Which cells become grains: Chen et al. (2021), section 4.

use std::collections::BTreeSet;

use nalgebra::SVector;

use crate::base::keys::{Form, LENGTH, POSITIVE, RATIO, Range, choose, flag, number, text};

/// Grains for points (Chen et al. 2021, section 4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enrichment {
    /// phi_0, m.
    pub distance: f64,
    /// w of the reconciliation zone: the grains' share.
    pub weight: f64,
    /// Share of the continuum's motion that the packing is trained with, 0 to 1.
    pub training: f64,
    /// Training runs this many times faster than the motion it repeats.
    pub training_speed: f64,
    /// Rest after training with the rim held, in multiples of the training's own duration.
    pub training_rest: f64,
    /// What becomes of the zone later: the keys of `[zone]`.
    pub life: ZoneLife,
}

impl Enrichment {
    /// As Chen et al. (2021) have it, around a zone of that phi_0, m.
    pub const fn around(distance: f64) -> Self {
        Self {
            distance,
            weight: 0.5,
            training: 1.0,
            training_speed: 10.0,
            training_rest: 0.5,
            life: ZoneLife::FOR_GOOD,
        }
    }

    /// The keys of `[enrichment]`.
    pub fn keys(&mut self, form: &mut dyn Form) {
        form.number(&mut self.distance, number("distance", "phi_0", LENGTH, POSITIVE, "\"2.2 cm\""));
        let weight = "w, the grains' share in the rim";
        form.number(&mut self.weight, number("weight", weight, RATIO, Range::open(0.0, 1.0), "0.5").or("0.5"));
        let training = "the share of the motion trained";
        form.number(&mut self.training, number("training", training, RATIO, Range::closed(0.0, 1.0), "1.0").or("1.0"));
        let (speed, rest) = ("how much faster training runs", "rest after training");
        form.number(
            &mut self.training_speed,
            number("training_speed", speed, RATIO, Range::closed(0.01, 1e6), "10.0").or("10.0"),
        );
        form.number(
            &mut self.training_rest,
            number("training_rest", rest, RATIO, Range::closed(0.0, 1000.0), "0.5").or("0.5"),
        );
    }
}

impl ZoneLife {
    /// That of Chen et al. (2021), with the defaults of all else.
    pub const FOR_GOOD: Self = Self {
        is_everywhere: false,
        grows: false,
        dissolves: false,
        rest_strain: 0.05,
        rest_share: 0.02,
        rest_strength: 0.9,
    };

    /// The keys of `[zone]`.
    pub fn keys(&mut self, form: &mut dyn Form) {
        let begins = "where grains are first: about the band that the oracle finds, or everywhere from the start";
        let key = text("begins", begins, "\"band\"").or("band");
        choose(form, &mut self.is_everywhere, "begins", key, &[("band", false), ("everywhere", true)]);
        let grows = "whether it follows what shears beyond it";
        form.flag(&mut self.grows, flag("grows", grows, "false").or("false"));
        form.flag(
            &mut self.dissolves,
            flag("dissolves", "whether grains at rest turn back into points", "false").or("false"),
        );
        let (strain, share, strength) = (
            "the shear strain of the cell that shears most over which rest is judged",
            "the share of it below which a cell rests",
            "the share of the continuum's peak shear strength up to which grains at rest turn into points",
        );
        form.number(&mut self.rest_strain, number("rest_strain", strain, RATIO, POSITIVE, "0.05").or("0.05"));
        form.number(&mut self.rest_share, number("rest_share", share, RATIO, Range::open(0.0, 1.0), "0.02").or("0.02"));
        form.number(&mut self.rest_strength, number("rest_strength", strength, RATIO, POSITIVE, "0.9").or("0.9"));
    }
}

/// What becomes of a zone once it is there; those of Chen et al. (2021), which leave it as it is, are the defaults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZoneLife {
    /// Whether all of the specimen is grains at the start, and not where the oracle finds a band.
    pub is_everywhere: bool,
    /// Whether it grows: where the oracle finds a band beyond it, or, of one that begins everywhere, where cells that shear or are beside such cells are not of grains alone.
    pub grows: bool,
    /// Whether its grains turn back into points where they have come to rest.
    pub dissolves: bool,
    /// Shear strain of the cell that shears most over which rest is judged.
    pub rest_strain: f64,
    /// Share of that strain below which a cell rests.
    pub rest_share: f64,
    /// Grains at rest that bear more than this share of the continuum's peak shear strength do not turn into points.
    pub rest_strength: f64,
}

impl ZoneLife {
    /// Whether grains that have turned into points come back.
    pub fn returns(&self) -> bool {
        self.is_everywhere && self.grows
    }
}

/// What a cell holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Label {
    /// Points alone.
    Continuum,
    /// The reconciliation zone: grains and points at once.
    Rim,
    /// The core: grains alone.
    Grains,
}

/// The domain's cells, row by row in y. Lengths in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellGrid {
    /// Columns along x and rows along y.
    pub counts: [usize; 2],
    /// Edge of a cell.
    pub cell: f64,
    /// The lower corner.
    pub lower: [f64; 2],
    /// Whether the last column is beside the first.
    pub periodic: bool,
}

impl CellGrid {
    /// Length along x, m, whether the grid is periodic or not.
    pub fn period(&self) -> f64 {
        self.counts[0] as f64 * self.cell
    }

    /// Index of the cell at a place, wrapped in x where the grid is periodic; none beyond the grid.
    pub fn at(&self, x: f64, y: f64) -> Option<usize> {
        self.cell_at(((x - self.lower[0]) / self.cell).floor() as i64, ((y - self.lower[1]) / self.cell).floor() as i64)
    }

    fn cell_at(&self, column: i64, row: i64) -> Option<usize> {
        let columns = self.counts[0] as i64;
        let column = if self.periodic { column.rem_euclid(columns) } else { column };
        let inside = (0..self.counts[1] as i64).contains(&row) && (0..columns).contains(&column);
        inside.then(|| row as usize * self.counts[0] + column as usize)
    }

    /// Nodes, rising, within half a cell of one of the straight `parts`, given by their ends, m.
    pub fn nodes_along(&self, parts: &[[[f64; 2]; 2]]) -> Vec<u64> {
        // Nodes on both sides of a line half way between them count, whatever round-off says.
        let reach = (0.5 + 1e-9) * self.cell;
        let is_along = |node: &u64| {
            let [x, y] = self.place_of(*node);
            // The last column of nodes is the first where the last column of cells is beside the first.
            let mut images = [x, x + self.period()].into_iter().take(if self.periodic { 2 } else { 1 });
            images.any(|x| parts.iter().any(|part| distance_to(part, [x, y]) <= reach))
        };
        // As many nodes as cells: elsewhere the last row and column of nodes lie on the domain's border, where no material is.
        (0..(self.counts[0] * self.counts[1]) as u64).filter(is_along).collect()
    }

    /// Place of a node, m.
    fn place_of(&self, node: u64) -> [f64; 2] {
        let (column, row) = (node % self.counts[0] as u64, node / self.counts[0] as u64);
        [self.lower[0] + column as f64 * self.cell, self.lower[1] + row as f64 * self.cell]
    }

    /// The cells beside one along either axis.
    pub fn beside(&self, cell: usize) -> impl Iterator<Item = usize> {
        [[-1, 0], [1, 0], [0, -1], [0, 1]].into_iter().filter_map(move |step| self.step(cell, step))
    }

    /// The cells around one, corners counted, and itself, with their columns and rows from it.
    pub fn around(&self, cell: usize) -> impl Iterator<Item = (usize, [i64; 2])> {
        let steps = (-1..=1).flat_map(|row| (-1..=1).map(move |column| [column, row]));
        steps.filter_map(move |step| self.step(cell, step).map(|beside| (beside, step)))
    }

    /// Centre of a cell, m.
    pub fn centre(&self, cell: usize) -> SVector<f64, 2> {
        let [column, row] = [cell % self.counts[0], cell / self.counts[0]];
        SVector::from([0, 1].map(|axis| self.lower[axis] + ([column, row][axis] as f64 + 0.5) * self.cell))
    }

    /// Which cells have their centres within `reach`, m, of that of one of `cells`.
    pub fn near(&self, cells: &[u64], reach: f64) -> Vec<bool> {
        let most = (reach / self.cell).floor() as i64;
        let square = (reach / self.cell).powi(2) * (1.0 + 1e-9);
        let steps = (-most..=most).flat_map(|row| (-most..=most).map(move |column| [column, row]));
        let is_near = |[column, row]: &[i64; 2]| (column * column + row * row) as f64 <= square;
        let steps: Vec<[i64; 2]> = steps.filter(is_near).collect();
        let mut near = vec![false; self.counts[0] * self.counts[1]];
        for cell in cells {
            let beside = steps.iter().filter_map(|step| self.step(*cell as usize, *step));
            beside.for_each(|beside| near[beside] = true);
        }
        near
    }

    /// Which of `cells` lie in a square of `width` times `width` of them: what is narrower in any direction does not.
    pub fn wide(&self, cells: &[bool], width: usize) -> Vec<bool> {
        let steps: Vec<[i64; 2]> =
            (0..width as i64).flat_map(|row| (0..width as i64).map(move |column| [column, row])).collect();
        let mut wide = vec![false; cells.len()];
        for corner in (0..cells.len()).filter(|corner| cells[*corner]) {
            let square: Vec<usize> = steps.iter().filter_map(|step| self.step(corner, *step)).collect();
            if square.len() == steps.len() && square.iter().all(|cell| cells[*cell]) {
                square.into_iter().for_each(|cell| wide[cell] = true);
            }
        }
        wide
    }

    /// Nodes, rising, in sets that hang together along axes or across cells, each rising, in the order of their first nodes.
    pub fn connected(&self, nodes: &[u64]) -> Vec<Vec<u64>> {
        let cells: Vec<usize> = nodes.iter().map(|node| *node as usize).collect();
        let sets = self.sets(&cells);
        sets.into_iter().map(|set| set.into_iter().map(|node| node as u64).collect()).collect()
    }

    /// The same of cells, which are counted as nodes are.
    pub fn sets(&self, cells: &[usize]) -> Vec<Vec<usize>> {
        let mut is_left: BTreeSet<usize> = cells.iter().copied().collect();
        let mut sets = Vec::new();
        while let Some(first) = is_left.pop_first() {
            let (mut set, mut at) = (vec![first], 0);
            while at < set.len() {
                let beside: Vec<usize> = self.around(set[at]).map(|(beside, _)| beside).collect();
                set.extend(beside.into_iter().filter(|beside| is_left.remove(beside)));
                at += 1;
            }
            set.sort_unstable();
            sets.push(set);
        }
        sets
    }

    /// All nodes of the rows that these nodes, rising, are in and whose heights `is_wanted`, m, and the nodes themselves; rising.
    pub fn with_rows(&self, nodes: &[u64], is_wanted: impl Fn(f64) -> bool) -> Vec<u64> {
        let columns = self.counts[0] as u64;
        let mut all: BTreeSet<u64> = nodes.iter().copied().collect();
        for node in nodes.iter().filter(|node| is_wanted(self.place_of(**node)[1])) {
            let first = node / columns * columns;
            all.extend(first..first + columns);
        }
        all.into_iter().collect()
    }

    /// Whether a node has one of these cells beside it.
    pub fn touches(&self, node: u64, cells: &[bool]) -> bool {
        let (column, row) = ((node % self.counts[0] as u64) as i64, (node / self.counts[0] as u64) as i64);
        let beside = [[-1, -1], [0, -1], [-1, 0], [0, 0]].into_iter();
        beside.filter_map(|step| self.cell_at(column + step[0], row + step[1])).any(|cell| cells[cell])
    }

    /// The cell so many columns and rows from one.
    fn step(&self, cell: usize, [columns, rows]: [i64; 2]) -> Option<usize> {
        self.cell_at((cell % self.counts[0]) as i64 + columns, (cell / self.counts[0]) as i64 + rows)
    }
}

/// Distance of a place to a straight line between two ends, m.
fn distance_to([from, to]: &[[f64; 2]; 2], place: [f64; 2]) -> f64 {
    let along = [to[0] - from[0], to[1] - from[1]];
    let way = [place[0] - from[0], place[1] - from[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let share = if square > 0.0 { (way[0] * along[0] + way[1] * along[1]) / square } else { 0.0 };
    let share = share.clamp(0.0, 1.0);
    let [x, y] = [way[0] - share * along[0], way[1] - share * along[1]];
    (x * x + y * y).sqrt()
}

/// Labels of all cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// Of the whole domain.
    pub grid: CellGrid,
    /// By index of the cell.
    pub labels: Vec<Label>,
    /// Places around which grains come, m: those of the flagged nodes, or the centres of cells.
    seeds: Vec<[f64; 2]>,
}

/// Cells from the core, corners counted, within which its rim lies.
const CELLS_OF_RIM: f64 = 1.5;

impl Zone {
    /// Cells within `phi_0 - t_h/2` of a flagged node are grains, those within `phi_0 + t_h/2` the rim; t_h is one cell.
    pub fn around(flagged: &[u64], grid: CellGrid, settings: &Enrichment) -> Self {
        let places = flagged.iter().map(|node| grid.place_of(*node)).collect();
        let mut zone = Self { grid, labels: Vec::new(), seeds: places };
        let half = 0.5 * grid.cell;
        let label = |cell: usize| {
            let x = grid.lower[0] + ((cell % grid.counts[0]) as f64 + 0.5) * grid.cell;
            let y = grid.lower[1] + ((cell / grid.counts[0]) as f64 + 0.5) * grid.cell;
            let distance = zone.distance([x, y]);
            if distance <= settings.distance - half {
                Label::Grains
            } else if distance <= settings.distance + half {
                Label::Rim
            } else {
                Label::Continuum
            }
        };
        zone.labels = (0..grid.counts[0] * grid.counts[1]).map(label).collect();
        zone
    }

    /// Grains in all cells that are `wanted`, but for a rim, one cell wide, beside cells that are `filled` and not wanted. The `core` that there is stays one.
    pub fn of_cells(grid: CellGrid, wanted: &[bool], filled: &[bool], core: &[bool]) -> Self {
        let is_rim = |cell: usize| grid.around(cell).any(|(beside, _)| filled[beside] && !wanted[beside]);
        let label = |cell: usize| match wanted[cell] {
            true if core[cell] || !is_rim(cell) => Label::Grains,
            true => Label::Rim,
            false => Label::Continuum,
        };
        Self { grid, labels: (0..wanted.len()).map(label).collect(), seeds: Vec::new() }
    }

    /// What of it grains come to around these cells: the rest is left as it is.
    pub fn near_cells(&self, cells: &[usize]) -> Self {
        let grid = self.grid;
        let near = grid.near(&cells.iter().map(|cell| *cell as u64).collect::<Vec<u64>>(), CELLS_OF_RIM * grid.cell);
        let label = |(label, near): (&Label, bool)| if near { *label } else { Label::Continuum };
        let labels = self.labels.iter().zip(near).map(label).collect();
        Self { grid, labels, seeds: cells.iter().map(|cell| grid.centre(*cell).into()).collect() }
    }

    /// Which cells lie within so many cells of one of the zone, corners counted.
    pub fn within(&self, cells: usize) -> Vec<bool> {
        let mut near: Vec<bool> = self.labels.iter().map(|label| *label != Label::Continuum).collect();
        let grow = |near: &[bool], steps: [[i64; 2]; 2]| -> Vec<bool> {
            let beside = |cell: usize| steps.into_iter().filter_map(move |step| self.grid.step(cell, step));
            (0..near.len()).map(|cell| near[cell] || beside(cell).any(|beside| near[beside])).collect()
        };
        for _ in 0..cells {
            near = grow(&grow(&near, [[-1, 0], [1, 0]]), [[0, -1], [0, 1]]);
        }
        near
    }

    /// A cell of grains at a place is one of the rim instead.
    pub fn share(&mut self, x: f64, y: f64) {
        if let Some(cell) = self.grid.at(x, y).filter(|cell| self.labels[*cell] == Label::Grains) {
            self.labels[cell] = Label::Rim;
        }
    }

    /// Where the zone comes to the end of the material at a height, m, all of the row of cells there is grains, and so is what lies between it and the core: a rim
    /// would share with points what holds them. `up` is towards that end. Whether it comes there.
    pub fn close_at(&mut self, end: f64, up: bool) -> bool {
        let CellGrid { counts: [columns, rows], cell, lower, .. } = self.grid;
        let row_of = |height: f64| (height - lower[1]) / cell;
        // Points have their places up to half of their distance from the end, in whichever row of cells that is.
        let (outer, inner) = (row_of(end), row_of(if up { end - 0.5 * cell } else { end + 0.5 * cell }));
        if ![outer, inner].iter().all(|row| (0.0..rows as f64).contains(row)) {
            return false;
        }
        let (outer, inner) = (outer as usize, inner as usize);
        let cells = |row: usize| row * columns..(row + 1) * columns;
        let at_end = outer.min(inner)..outer.max(inner) + 1;
        if at_end.clone().flat_map(cells).all(|cell| self.labels[cell] == Label::Continuum) {
            return false;
        }
        // And the rim between there and the core.
        let inwards: Vec<usize> = if up { (0..inner).rev().collect() } else { (inner + 1..rows).collect() };
        let is_rim = |row: &usize| self.labels[cells(*row)].contains(&Label::Rim);
        let rim: Vec<usize> = inwards.into_iter().take_while(is_rim).collect();
        at_end.chain(rim).for_each(|row| self.labels[cells(row)].fill(Label::Grains));
        true
    }

    /// Mean height of the places around which grains come, m.
    pub fn middle(&self) -> f64 {
        self.seeds.iter().map(|place| place[1]).sum::<f64>() / self.seeds.len() as f64
    }

    /// Distance of a place to the nearest one around which grains come, across the period if there is one, m.
    pub fn distance(&self, place: [f64; 2]) -> f64 {
        let period = self.grid.period();
        self.seeds.iter().fold(f64::INFINITY, |least, node| {
            let x = if self.grid.periodic {
                let apart = (place[0] - node[0]).rem_euclid(period);
                apart.min(period - apart)
            } else {
                place[0] - node[0]
            };
            let y = place[1] - node[1];
            least.min((x * x + y * y).sqrt())
        })
    }

    /// Label of a place, continuum outside the grid.
    pub fn at(&self, x: f64, y: f64) -> Label {
        self.grid.at(x, y).map_or(Label::Continuum, |cell| self.labels[cell])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(periodic: bool) -> CellGrid {
        CellGrid { counts: [6, 5], cell: 0.5, lower: [1.0, -1.0], periodic }
    }

    #[test]
    fn nodes_on_either_side_of_a_line_between_them_are_along_it() {
        // Half way between the second and third row of nodes, from the third column of nodes to the fourth.
        let nodes = grid(false).nodes_along(&[[[2.0, -0.25], [2.5, -0.25]]]);
        assert_eq!(nodes, [8, 9, 14, 15]);
        // Along a row of nodes: that row alone. Two parts that share an end count their nodes once.
        let nodes = grid(false).nodes_along(&[[[2.0, -0.5], [2.2, -0.5]], [[2.2, -0.5], [2.5, -0.5]]]);
        assert_eq!(nodes, [8, 9]);
        // A part without length.
        assert_eq!(grid(false).nodes_along(&[[[1.1, -0.9], [1.1, -0.9]]]), [0]);
        // Up to the end of a period, where the first column is.
        assert_eq!(grid(false).nodes_along(&[[[3.5, -0.5], [4.0, -0.5]]]), [11]);
        assert_eq!(grid(true).nodes_along(&[[[3.5, -0.5], [4.0, -0.5]]]), [6, 11]);
    }

    #[test]
    fn sets_hang_together_across_corners_and_the_period() {
        let nodes = [0, 5, 7, 16, 21, 28];
        assert_eq!(grid(false).connected(&nodes), [vec![0, 7], vec![5], vec![16, 21, 28]]);
        assert_eq!(grid(true).connected(&nodes), [vec![0, 5, 7], vec![16, 21, 28]]);
    }

    #[test]
    fn what_is_narrow_in_any_direction_is_not_wide() {
        let cells = |rows: [&str; 5]| rows.concat().chars().map(|mark| mark == '#').collect::<Vec<bool>>();
        // A row of its own, a step in a border, a hole's surroundings; the last column is beside the first.
        let given = cells(["######", "......", "####.#", "#####.", "####.#"]);
        assert_eq!(grid(false).wide(&given, 1), given);
        assert_eq!(grid(false).wide(&given, 3), cells(["......", "......", "####..", "####..", "####.."]));
        let given = cells(["##..##", "##..##", "#...##", "##..##", "......"]);
        assert_eq!(grid(true).wide(&given, 3), cells(["#...##", "#...##", "#...##", "#...##", "......"]));
        assert!(!grid(false).wide(&given, 3).contains(&true));
    }

    #[test]
    fn a_zone_meets_the_end_of_material_with_grains_alone() {
        let letters = |zone: &Zone| -> Vec<char> {
            let letter = |label: &Label| match label {
                Label::Continuum => '.',
                Label::Rim => '+',
                Label::Grains => 'o',
            };
            zone.labels.iter().step_by(6).map(letter).collect()
        };
        let settings = Enrichment::around(0.75);
        // From the lowest row up. Its rim ends at the height of 1.5, where material may end as well.
        let flagged = grid(true).with_rows(&[19], |height| height > 0.0);
        assert_eq!(flagged, (18..24).collect::<Vec<u64>>());
        let mut zone = Zone::around(&flagged, grid(true), &settings);
        assert_eq!(letters(&zone), ['.', '+', 'o', 'o', '+']);
        assert!(!zone.close_at(-0.9, false) && !zone.close_at(9.0, true));
        assert!(zone.close_at(1.4, true));
        assert_eq!(letters(&zone), ['.', '+', 'o', 'o', 'o']);
        let mut zone = Zone::around(&flagged, grid(true), &settings);
        assert!(zone.close_at(-0.4, false));
        assert_eq!(letters(&zone), ['.', 'o', 'o', 'o', '+']);
        // Part of a row is not the whole of it.
        assert_eq!(grid(true).with_rows(&[1, 19], |height| height > 0.0), [1, 18, 19, 20, 21, 22, 23]);
    }

    /// Rows from below; `x` are cells that are wanted, `c` the core that is, in a specimen whose upper row is empty.
    #[test]
    fn a_zone_of_cells_has_its_rim_towards_continuum_alone() {
        let zone = |rows: [&str; 5]| {
            let marks = |mark: char| rows.concat().chars().map(|is| is == mark).collect::<Vec<bool>>();
            let (core, more, empty) = (marks('c'), marks('x'), marks(' '));
            let wanted: Vec<bool> = core.iter().zip(&more).map(|(core, more)| *core || *more).collect();
            let filled: Vec<bool> = empty.iter().map(|empty| !empty).collect();
            let zone = Zone::of_cells(grid(true), &wanted, &filled, &core);
            let letter = |label: &Label| match label {
                Label::Continuum => '.',
                Label::Rim => '+',
                Label::Grains => 'o',
            };
            let letters: Vec<char> = zone.labels.iter().map(letter).collect();
            let rows: Vec<String> = letters.chunks(6).map(|row| row.iter().collect()).collect();
            (rows, zone)
        };
        // Up to the end of the material there is no rim.
        let (rows, grown) = zone(["......", "cccccc", "xxxxxx", "xxxxxx", "      "]);
        assert_eq!(rows, ["......", "oooooo", "oooooo", "oooooo", "......"]);
        // Distances are to what comes, and what is farther from that than a rim is left out.
        let part = grown.near_cells(&[20]);
        assert_eq!((part.distance([2.25, 0.75]), part.middle()), (0.0, 0.75));
        let kept: Vec<usize> = (0..30).filter(|cell| part.labels[*cell] != Label::Continuum).collect();
        assert_eq!(kept, [13, 14, 15, 19, 20, 21]);
        let (rows, _) = zone(["xxx...", "xxx...", "xxx...", "......", "      "]);
        assert_eq!(rows, ["+o+...", "+o+...", "+++...", "......", "......"]);
        let (rows, _) = zone(["......", "......", "cccccc", "xxxxxx", "......"]);
        assert_eq!(rows, ["......", "......", "oooooo", "++++++", "......"]);
    }

    #[test]
    fn cells_near_others_and_nodes_beside_them_are_told() {
        let near = |periodic: bool, reach: f64| {
            let near = grid(periodic).near(&[6], reach);
            (0..30).filter(|cell| near[*cell]).collect::<Vec<usize>>()
        };
        assert_eq!(near(false, 0.5), [0, 6, 7, 12]);
        assert_eq!(near(true, 0.5), [0, 6, 7, 11, 12]);
        assert_eq!(near(false, 0.75), [0, 1, 6, 7, 12, 13]);
        let mut taken = vec![false; 30];
        taken[6] = true;
        let touches =
            |periodic: bool| (0..30).filter(|node| grid(periodic).touches(*node, &taken)).collect::<Vec<u64>>();
        assert_eq!(touches(false), [6, 7, 12, 13]);
    }

    #[test]
    fn cells_within_so_many_of_a_zone_go_around_corners_and_across_the_period() {
        let mut labels = vec![Label::Continuum; 30];
        labels[0] = Label::Rim;
        let near = |periodic: bool| {
            let zone = Zone { grid: grid(periodic), labels: labels.clone(), seeds: Vec::new() };
            (0..30).filter(|cell| zone.within(1)[*cell]).collect::<Vec<usize>>()
        };
        assert_eq!(near(false), [0, 1, 6, 7]);
        assert_eq!(near(true), [0, 1, 5, 6, 7, 11]);
    }
}
