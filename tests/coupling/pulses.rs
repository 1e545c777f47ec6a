//! A pressure pulse through the rim of a zone: what of it comes back.

use scree::base::ids::PointId;
use scree::base::math::{PI, sin};
use scree::base::space::{Plane, Space};
use scree::base::symmetric::Symmetric;
use scree::domain::grid::Grid;
use scree::domain::layout::Layout;
use scree::domain::parts::Parts;
use scree::domain::world::Settings;
use scree::law::material::CriticalDruckerPrager;
use scree::mpm::stress::StressModel;
use scree::prepare::sheared::cell_of;
use scree_partition::Solo;

use crate::worlds::{Grain, PlanarPoint, PlanarWorld, Vector, contact, exchanging, grain, material, settings};

const CELL: f64 = 3e-3;
const COLUMNS: usize = 4;
const ROWS: usize = 112;
const DEPTH: f64 = 0.01;
const DENSITY: f64 = 2530.0;
const FRACTION: f64 = 0.85;
const DT: f64 = 4e-7;
/// Grains on a square lattice a millimetre apart that just touch: a bar of modulus k_n/depth, 177 MPa.
const SPACING: f64 = 1e-3;
const RADIUS: f64 = 0.5 * SPACING + 1e-12;
/// Of the pulse, m/s.
const SPEED: f64 = 0.01;

/// Where the bar is grains: above y = 0, with a rim of one cell below it. `turned` is the bar upside down.
#[derive(Clone, Copy)]
struct Bar {
    turned: bool,
}

impl Bar {
    /// Height along the way of the pulse, which goes up.
    fn of_grains(self, y: f64) -> f64 {
        let along = if self.turned { -y } else { y };
        match along {
            along if along > 0.0 => 1.0,
            along if along > -CELL => 0.5,
            _ => 0.0,
        }
    }
}

/// Elastic whatever happens.
fn elastic() -> CriticalDruckerPrager {
    CriticalDruckerPrager { cohesion: 1e12, ..material() }
}

/// Speed of the pulse at a height before it starts: `length` long, its end two cells before the rim.
fn pulse(y: f64, length: f64) -> f64 {
    let within = (y + 3.0 * CELL + length) / length;
    if (0.0..1.0).contains(&within) { SPEED * sin(PI * within).powi(2) } else { 0.0 }
}

/// How far a bar of wave speed `wave` is ahead of its rest where the pulse is yet to come: the integral of its compression above `y`.
fn ahead(y: f64, length: f64, wave: f64) -> f64 {
    let parts = 400;
    let step = length / f64::from(parts);
    let bottom = -3.0 * CELL - length;
    let places = (0..parts).map(|part| bottom + (f64::from(part) + 0.5) * step).filter(|place| *place > y);
    places.map(|place| pulse(place, length) * step).sum::<f64>() / wave
}

fn grains(bar: Bar, length: f64) -> Vec<Grain> {
    let mass = DENSITY * PI * RADIUS * RADIUS * DEPTH;
    let wave = (contact(0.0).stiffness_normal / DEPTH * SPACING * SPACING * DEPTH / mass).sqrt();
    let mut grains = Vec::new();
    for row in -160..160 {
        let y = (f64::from(row) + 0.5) * SPACING;
        let weight = bar.of_grains(y);
        for column in (0..12).filter(|_| weight > 0.0) {
            let place = [(f64::from(column) + 0.5) * SPACING, y + ahead(y, length, wave)];
            let mut grain = grain(grains.len() as u64, place, RADIUS, mass);
            grain.hot.weight = weight;
            grain.hot.velocity = Vector::new(0.0, pulse(y, length));
            grains.push(grain);
        }
    }
    grains
}

fn points(bar: Bar, length: f64) -> Vec<PlanarPoint> {
    let law = elastic();
    let volume = 0.25 * CELL * CELL * DEPTH;
    let density = FRACTION * DENSITY;
    let modulus = law.bulk_modulus + law.shear_modulus;
    let wave = (modulus / density).sqrt();
    let mut points = Vec::new();
    for row in -106..106 {
        let y = (f64::from(row) + 0.5) * 0.5 * CELL;
        let weight = 1.0 - bar.of_grains(y);
        for column in (0..2 * COLUMNS as i32).filter(|_| weight > 0.0) {
            let place = Vector::new((f64::from(column) + 0.5) * 0.5 * CELL, y);
            let mut point = PlanarPoint::resting(PointId(points.len() as u64), place, density * volume, volume);
            let stress = -density * wave * pulse(y, length);
            let mut tensor = Plane::identity() * stress;
            tensor[0] *= (law.bulk_modulus - law.shear_modulus) / modulus;
            point.hot.weight = weight;
            point.hot.velocity = Vector::new(0.0, pulse(y, length));
            point.hot.memory = StressModel::<Plane>::start(&law, &tensor, FRACTION);
            point.hot.stress = Symmetric::of(&StressModel::<Plane>::stress(&law, &point.hot.memory));
            points.push(point);
        }
    }
    points
}

/// Kinetic energy of everything below a height, J.
fn energy_below(world: &PlanarWorld, height: f64) -> f64 {
    let kinetic = |weight: f64, mass: f64, position: &Vector, velocity: &Vector| match position[1] < height {
        true => 0.5 * weight * mass * velocity.dot(velocity),
        false => 0.0,
    };
    let grains = world.assembly.grains.hot[..world.assembly.grains.owned].iter();
    let of_grains: f64 = grains.map(|hot| kinetic(hot.weight, hot.mass, &hot.position, &hot.velocity)).sum();
    let points = world.continuum.points.hot.iter();
    of_grains + points.map(|hot| kinetic(hot.weight, hot.mass, &hot.position, &hot.velocity)).sum::<f64>()
}

/// Shares of a pulse's energy that have come back from the rim and that have gone on, once it has passed; grains exchange with nodes after every
/// so many of their steps.
fn passed(bar: Bar, length: f64, exchange: u64) -> [f64; 2] {
    let layout = Layout::plane([COLUMNS, ROWS], 2, CELL, [0.0, -0.5 * ROWS as f64 * CELL]).unwrap();
    let cell = cell_of(&layout);
    let mut settings: Settings<Plane> = settings(DT, contact(0.0));
    settings.grid = Grid { penalty: exchanging(exchange, DT), ..Grid::blend(1.0) };
    settings.grain_steps = exchange;
    settings.material = std::sync::Arc::new(elastic());
    let parts = Parts::fresh(grains(bar, length), points(bar, length), Vec::new(), cell);
    let mut world = PlanarWorld::new(settings, layout, &Solo, 0, parts).unwrap();
    let before = energy_below(&world, f64::INFINITY);
    // Its end is then two cells beyond the rim, at a mean wave speed.
    let way = length + 9.0 * CELL;
    let steps = (way / 285.0 / DT).round() as u64;
    while world.step < steps {
        world.advance().unwrap();
    }
    let back = energy_below(&world, -1.5 * CELL);
    [back / before, (energy_below(&world, f64::INFINITY) - back) / before]
}

/// Less than 2 per cent of a pulse of many cells comes back, from the continuum into grains and out of them; the impedances of the two
/// differ by a per cent, which alone sends back 4e-5. Short ones do come back: the rim is a cell wide and its penalty springs are stiff.
#[test]
fn a_pulse_of_many_cells_passes_the_rim() {
    for (turned, exchange) in [(false, 1), (true, 1), (false, 4), (true, 4)] {
        let way = if turned { "grains into points" } else { "points into grains" };
        let shares = [4.0, 8.0, 16.0, 32.0].map(|cells| {
            let [back, on] = passed(Bar { turned }, cells * CELL, exchange);
            println!(
                "{way}, exchange after {exchange}, {cells} cells long: {:.2} % came back, {:.1} % went on",
                100.0 * back,
                100.0 * on
            );
            [back, on]
        });
        let falling = if exchange == 1 { &shares[..] } else { &shares[..3] };
        assert!(falling.windows(2).all(|pair| pair[1][0] < pair[0][0]), "{way}: {shares:?}");
        for [back, on] in &shares[2..] {
            assert!(*back < 0.02 && *on > 0.85, "{way}: {back} came back and {on} went on");
        }
    }
}
