//! Profiles over the height of what is sheared, at the end (Liu et al. 2016, figure 14): how far it has gone along the shear, and void ratios.

use super::Drawn;
use super::chart::{Axis, Chart, Curve, Entry, draw};
use super::panels::Runs;
use super::svg::Stroke;
use crate::analysis::curve::{mean, range};
use crate::analysis::run::Run;
use crate::analysis::snapshot::{Body, Kind, Snapshot};
use crate::base::error::Error;
use crate::base::math::PI;
use crate::base::space::AXES;

/// Rows of points or elements up to which each has a place of its own.
const ROWS_MAX: usize = 60;
/// Layers of the displacement of what has more, and the mean diameters that a layer is high at least.
const LAYERS: usize = 60;
const LAYER_OF_DISPLACEMENT: f64 = 2.0;
/// The same of void ratios, which need more grains.
const LAYER_OF_VOIDS: f64 = 10.0;

/// The figure of runs that are sheared along x while the height grows, each at the last frame of the strain that all have come to.
pub fn figures(runs: &Runs, number: &str) -> Result<Vec<Drawn>, Error> {
    if !runs.iter().all(|(run, _)| run.drive.shear == Some([0, run.up()])) {
        return Ok(Vec::new());
    }
    let end = runs.iter().map(|(run, _)| run.last_frame()).fold(f64::INFINITY, f64::min);
    let (mut gone, mut voids, mut entries) = (Vec::new(), Vec::new(), Vec::new());
    for (run, colour) in runs {
        let frame = run.frame_at(end);
        let snapshot = run.snapshot(frame)?;
        let stroke = Stroke::new(colour, 1.8);
        let places = |profile: Vec<[f64; 2]>, unit: f64| profile.iter().map(|[x, y]| [x / unit, 1e3 * y]).collect();
        gone.push(Curve { places: places(displacements(&snapshot), 1e-3), stroke });
        let profile = void_ratios(&snapshot, run.dimension(), across(run, snapshot.time));
        voids.extend((!profile.is_empty()).then(|| Curve { places: places(profile, 1.0), stroke }));
        let at = super::scenes::place(run, frame);
        let words = if runs.len() > 1 { format!("{}, {at}", run.label()) } else { at };
        entries.push(Entry { words, stroke });
    }
    let chart = |title: &str, label: &str, curves: Vec<Curve<'static>>| {
        let all = || curves.iter().flat_map(|curve: &Curve| &curve.places);
        Chart {
            title: title.to_owned(),
            x: Axis::around(label, all().map(|place| place[0])),
            y: Axis::around("height (mm)", all().map(|place| place[1])),
            curves: curves.clone(),
            ..Chart::default()
        }
    };
    let has_voids = !voids.is_empty();
    let mut charts = vec![chart(if has_voids { "(a)" } else { "" }, "displacement along the shear (mm)", gone)];
    let mut caption = "Displacement along the shear, mean of what began at a height".to_owned();
    if has_voids {
        charts.push(chart("(b)", "void ratio", voids));
        caption = format!(
            "(a) {caption}; (b) void ratio of rows of elements or points, of grains that of layers ten mean diameters high"
        );
    }
    let name = format!("profiles{number}");
    let drawing = draw(&name, "Profiles over the height", &entries, &charts, charts.len());
    Ok(vec![Drawn { name, drawing, caption: format!("{caption}.") }])
}

/// Area that a height cuts out of what is sheared at a time, m2, or in the plane the length, m; none where the domain has no periods there.
fn across(run: &Run, time: f64) -> Option<f64> {
    if let Some(width) = run.number("specimen.width") {
        return Some(width);
    }
    let (row, periodic) = (run.row_at(time), run.value("cell.periodic")?.as_array()?);
    let edge = |axis: usize| {
        let is_periodic = periodic.get(axis)?.as_bool()?;
        run.column(&format!("edge_{0}{0}", AXES[axis])).get(row).copied().filter(|_| is_periodic)
    };
    (0..run.dimension()).filter(|axis| *axis != run.up()).map(edge).product()
}

/// Means of a value over layers of equal heights, or over rows where these are few: mean value and mean height, from below.
fn layers(values: &[[f64; 2]], thickness: f64) -> Vec<[f64; 2]> {
    let Some([low, high]) = range(values.iter().map(|[_, height]| *height)).filter(|[low, high]| high > low) else {
        return Vec::new();
    };
    let mut heights: Vec<f64> = values.iter().map(|[_, height]| *height).collect();
    heights.sort_by(f64::total_cmp);
    heights.dedup_by(|a, b| (*a - *b).abs() < 1e-6 * (high - low));
    let count = if heights.len() <= ROWS_MAX {
        // Rows that are evenly apart are layers of their own.
        heights.len()
    } else {
        LAYERS.min(((high - low) / thickness) as usize).max(1)
    };
    let mut of: Vec<Vec<[f64; 2]>> = vec![Vec::new(); count];
    for [value, height] in values {
        let layer = ((height - low) / (high - low) * count as f64) as usize;
        of[layer.min(count - 1)].push([*value, *height]);
    }
    let middle = |part: &Vec<[f64; 2]>| [0, 1].map(|at| mean(&part.iter().map(|pair| pair[at]).collect::<Vec<_>>()));
    of.iter().filter(|part| !part.is_empty()).map(middle).collect()
}

fn displacements(snapshot: &Snapshot) -> Vec<[f64; 2]> {
    let place = |body: &Body| [body.displacement[0], body.origin()[1]];
    let values: Vec<[f64; 2]> = snapshot.bodies.iter().map(place).collect();
    layers(&values, LAYER_OF_DISPLACEMENT * diameter(snapshot))
}

/// Of RVEs those that they have; of free grains by what they fill of each layer between two heights.
fn void_ratios(snapshot: &Snapshot, dimension: usize, across: Option<f64>) -> Vec<[f64; 2]> {
    let of_rves: Vec<[f64; 2]> = snapshot
        .bodies
        .iter()
        .filter(|body| body.void_ratio > 0.0)
        .map(|body| [body.void_ratio, body.origin()[1]])
        .collect();
    if !of_rves.is_empty() {
        return layers(&of_rves, LAYER_OF_DISPLACEMENT * diameter(snapshot));
    }
    let grains: Vec<&Body> = snapshot.bodies.iter().filter(|body| body.kind == Kind::Grain).collect();
    let is_all = snapshot.bodies.iter().all(|body| body.kind.is_grain());
    let ends = range(grains.iter().map(|body| body.position[1])).filter(|_| is_all);
    let (Some([low, high]), Some(across)) = (ends, across) else { return Vec::new() };
    let count = ((high - low) / (LAYER_OF_VOIDS * diameter(snapshot))) as usize;
    let height = (high - low) / count as f64;
    let mut solid = vec![0.0; count];
    for body in &grains {
        let r = body.radius;
        let measure = if dimension == 3 { 4.0 / 3.0 * PI * r * r * r } else { PI * r * r };
        let layer = ((body.position[1] - low) / height) as usize;
        if let Some(sum) = solid.get_mut(layer) {
            *sum += measure;
        }
    }
    let layer = |(number, solid): (usize, &f64)| [across * height / solid - 1.0, low + (number as f64 + 0.5) * height];
    solid.iter().enumerate().filter(|(_, solid)| **solid > 0.0).map(layer).collect()
}

fn diameter(snapshot: &Snapshot) -> f64 {
    let radii: Vec<f64> = snapshot.bodies.iter().map(|body| body.radius).collect();
    2.0 * mean(&radii)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(kind: Kind, place: [f64; 2], displacement: [f64; 2], radius: f64) -> Body {
        let position = [place[0] + displacement[0], place[1] + displacement[1]];
        Body { kind, position, displacement, radius, weight: 1.0, ..Body::default() }
    }

    /// Twelve rows of five elements, of which one shears, are twelve places; its void ratio is there.
    #[test]
    fn rows_of_elements_have_places_of_their_own() {
        let element = |number: usize| {
            let (row, column) = (number / 5, number % 5);
            let displacement = [
                if row > 8 {
                    0.02
                } else if row == 8 {
                    0.01
                } else {
                    0.0
                },
                0.0,
            ];
            let place = [0.01 * column as f64, 0.0049 + 0.0098 * row as f64];
            Body { void_ratio: if row == 8 { 0.64 } else { 0.53 }, ..body(Kind::Point, place, displacement, 5e-3) }
        };
        let snapshot = Snapshot { bodies: (0..60).map(element).collect(), ..Snapshot::default() };
        let gone = displacements(&snapshot);
        assert_eq!(gone.len(), 12);
        assert!(gone.iter().enumerate().all(|(row, [x, _])| (*x > 0.0) == (row >= 8)));
        let voids = void_ratios(&snapshot, 2, None);
        assert!((voids[8][0] - 0.64).abs() < 1e-12 && (voids[7][0] - 0.53).abs() < 1e-12 && voids.len() == 12);
    }

    /// A square lattice of discs, cut by a glued row at either end: 4/pi - 1, and displacements that rise with height.
    #[test]
    fn layers_of_grains_have_the_void_ratio_of_their_lattice() {
        let (across, along) = (40, 200);
        let grain = |number: usize| {
            let (row, column) = (number / across, number % across);
            let kind = if row == 0 || row == along - 1 { Kind::Glued } else { Kind::Grain };
            let place = [1e-3 * (column as f64 + 0.5), 1e-3 * (row as f64 + 0.5)];
            body(kind, place, [0.1 * place[1], 0.0], 0.5e-3)
        };
        let snapshot = Snapshot { bodies: (0..across * along).map(grain).collect(), ..Snapshot::default() };
        let voids = void_ratios(&snapshot, 2, Some(0.04));
        assert!(voids.len() > 10, "{}", voids.len());
        let inner = mean(&voids.iter().map(|[void, _]| *void).collect::<Vec<_>>());
        assert!((inner / (4.0 / PI - 1.0) - 1.0).abs() < 0.03, "{inner}");
        let gone = displacements(&snapshot);
        assert!(gone.len() == LAYERS && gone.iter().all(|[x, y]| (x - 0.1 * y).abs() < 1e-12));
        assert!(void_ratios(&snapshot, 2, None).is_empty());
    }
}
