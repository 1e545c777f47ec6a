//! Two grains against what is known of them: the damped oscillator, the conservation laws, and another program's record.

use std::path::Path;

use scree::base::math;
use scree::base::space::{Plane, Space};
use scree::export::grain_export::{self, Wanted};
use scree::job::Job;
use scree::law::contact::LinearSpringDashpot;
use scree::run::{Options, start};
use scree::store::checkpoint;
use scree_io::column::State;
use scree_io::store;
use scree_partition::{Solo, Transport};

use crate::worlds::{Grain, PlanarWorld, Vector, contact, grain, open_world, row_of, settings};

/// Mean grain of Table 1, a disc 1 cm deep.
const RADIUS: f64 = 5e-4;
const MASS: f64 = 1.987_057_353_395_544_3e-5;
/// Speed at which grains close, m/s.
const SPEED: f64 = 0.1;

fn pair_world(transport: &dyn Transport, dt: f64, contact: LinearSpringDashpot, pair: [Grain; 2]) -> PlanarWorld<'_> {
    open_world(transport, 1e-3, settings(dt, contact), pair.into(), Vec::new())
}

/// Overlap of a head-on collision, `m d'' + gamma d' + k d = 0` with the reduced mass m:
/// `d = exp(-b t) (d_0 cos(w t) + (v_0 + b d_0)/w sin(w t))`, `b = gamma/(2 m)`, `w^2 = k/m - b^2`.
#[derive(Clone, Copy)]
struct Oscillator {
    decay: f64,
    frequency: f64,
}

impl Oscillator {
    fn new(contact: &LinearSpringDashpot, mass: f64) -> Self {
        let decay = contact.damping_normal / (2.0 * mass);
        Self { decay, frequency: (contact.stiffness_normal / mass - decay * decay).sqrt() }
    }

    /// Overlap and its rate at `time`, from those at zero.
    fn at(&self, time: f64, [overlap, closing]: [f64; 2]) -> [f64; 2] {
        let (b, w) = (self.decay, self.frequency);
        let fade = math::exp(-b * time);
        let (sine, cosine) = (math::sin(w * time), math::cos(w * time));
        let second = (closing + b * overlap) / w;
        let now = overlap * cosine + second * sine;
        [fade * now, fade * (w * (second * cosine - overlap * sine) - b * now)]
    }

    /// Time from touch to separation. The law may pull, so a contact ends when its overlap does.
    fn duration(&self) -> f64 {
        math::PI / self.frequency
    }

    /// Speed after over speed before.
    fn restitution(&self) -> f64 {
        math::exp(-self.decay * self.duration())
    }
}

/// Two equal grains that close along x, mirrored about x = 8 mm.
fn head_on(overlap: f64, closing: f64) -> [Grain; 2] {
    [1.0, -1.0].map(|side| {
        let place = [8e-3 + side * (RADIUS - 0.5 * overlap), 0.0];
        let mut disc = grain(if side > 0.0 { 0 } else { 1 }, place, RADIUS, MASS);
        disc.hot.velocity[0] = -0.5 * side * closing;
        disc
    })
}

/// Overlap, and its rate half a step earlier.
fn overlap_of(world: &PlanarWorld) -> [f64; 2] {
    let [a, b] = [0, 1].map(|id| &world.assembly.grains.hot[row_of(world, id)]);
    let distance = a.position[0] - b.position[0];
    [a.radius + b.radius - distance, b.velocity[0] - a.velocity[0]]
}

/// Largest errors of overlap and velocity over the contact, as shares of the undamped collision's scales.
fn errors(contact: LinearSpringDashpot, steps: u32, mass_of: impl Fn(f64) -> f64) -> [f64; 2] {
    let start = [1e-8, SPEED];
    // Up to nine tenths of the contact, so that its end plays no part.
    let dt = 0.9 * Oscillator::new(&contact, 0.5 * MASS).duration() / f64::from(steps);
    let exact = Oscillator::new(&contact, mass_of(dt));
    let mut world = pair_world(&Solo, dt, contact, head_on(start[0], start[1]));
    let mut worst = [0.0f64; 2];
    for step in 1..=steps {
        world.advance().unwrap();
        let [overlap, closing] = overlap_of(&world);
        let time = f64::from(step) * dt;
        let frequency = (contact.stiffness_normal / (0.5 * MASS)).sqrt();
        worst[0] = worst[0].max((overlap - exact.at(time, start)[0]).abs() * frequency / SPEED);
        worst[1] = worst[1].max((closing - exact.at(time - 0.5 * dt, start)[1]).abs() / SPEED);
    }
    worst
}

/// Orders of convergence of overlap and velocity over three halvings of the step.
fn orders(contact: LinearSpringDashpot, mass_of: impl Fn(f64) -> f64 + Copy) -> Vec<f64> {
    let runs: Vec<[f64; 2]> = [100, 200, 400, 800].iter().map(|steps| errors(contact, *steps, mass_of)).collect();
    let order = |pair: &[[f64; 2]], which: usize| math::ln(pair[0][which] / pair[1][which]) / math::ln(2.0);
    runs.windows(2).flat_map(|pair| [order(pair, 0), order(pair, 1)]).collect()
}

fn assert_order(orders: &[f64], wanted: f64) {
    assert!(orders.iter().all(|order| (order - wanted).abs() < 0.1), "order {wanted} wanted: {orders:?}");
}

/// Springs are integrated to second order. A dashpot sees the velocity of half a step ago, which is first order: to second
/// order it makes the pair lighter by gamma dt/2.
#[test]
fn a_head_on_collision_follows_the_damped_oscillator() {
    let reduced = 0.5 * MASS;
    assert_order(&orders(contact(0.0), |_| reduced), 2.0);
    assert_order(&orders(contact(3.5), |_| reduced), 1.0);
    assert_order(&orders(contact(3.5), |dt| reduced - 0.5 * 3.5 * dt), 2.0);
    for error in errors(contact(3.5), 800, |dt| reduced - 0.5 * 3.5 * dt) {
        assert!(error < 1e-5, "{error}");
    }
}

/// Restitution and duration of a whole collision, from a gap and back to one.
#[test]
fn restitution_and_duration_follow_the_damping() {
    for damping in [0.0, 0.5, 2.0, 3.5, 4.96, 7.0] {
        let contact = contact(damping);
        let exact = Oscillator::new(&contact, 0.5 * MASS);
        let dt = exact.duration() / 4000.0;
        let mut world = pair_world(&Solo, dt, contact, head_on(-3.3 * SPEED * dt, SPEED));
        let mut touching = 0;
        for _ in 0..4100 {
            world.advance().unwrap();
            touching += u32::from(overlap_of(&world)[0] > 0.0);
        }
        let [overlap, closing] = overlap_of(&world);
        assert!(overlap < 0.0, "damping {damping}: they still touch");
        let restitution = -closing / SPEED;
        assert!((restitution - exact.restitution()).abs() < 5e-4, "damping {damping}: {restitution}");
        assert!((f64::from(touching) / 4000.0 - 1.0).abs() < 2e-3, "damping {damping}: {touching} steps");
    }
    let restitution = |damping| Oscillator::new(&contact(damping), 0.5 * MASS).restitution();
    // What a mean grain of Table 1 rebounds with: at the jobs' damping, and where it would be 0.1.
    assert!((restitution(3.5) - 0.24).abs() < 5e-3 && (restitution(4.96) - 0.1).abs() < 1e-3);
}

/// Momentum of a world: x, y, and angular about `centre`, each with the sum of the magnitudes that went into it.
fn momentum(world: &PlanarWorld, centre: [f64; 2]) -> [[f64; 2]; 3] {
    let mut sums = [[0.0; 2]; 3];
    for hot in &world.assembly.grains.hot {
        let arm = [hot.position[0] - centre[0], hot.position[1] - centre[1]];
        let inertia = Plane::grain_inertia(hot.mass, hot.radius);
        let terms = [
            hot.mass * hot.velocity[0],
            hot.mass * hot.velocity[1],
            hot.mass * arm[0] * hot.velocity[1],
            -hot.mass * arm[1] * hot.velocity[0],
            inertia * hot.spin[0],
        ];
        for (term, which) in terms.into_iter().zip([0, 1, 2, 2, 2]) {
            sums[which][0] += term;
            sums[which][1] += term.abs();
        }
    }
    sums
}

/// The arms `r - d/2` of the two torques add up to the distance of the centres, so the couple of the tangential forces is
/// exactly undone by the torques, about any fixed point and in every step. With the radii for arms, `d F_t dt` would be
/// lost per step.
#[test]
fn an_oblique_collision_keeps_linear_and_angular_momentum() {
    let mut a = grain(4, [8.05e-3, 0.1e-3], 5e-4, MASS);
    let mut b = grain(9, [7.4e-3, -0.524e-3], 4e-4, 0.64 * MASS);
    (a.hot.velocity[0], a.hot.velocity[1], a.hot.spin[0]) = (-0.31, -0.02, 170.0);
    (b.hot.velocity[0], b.hot.velocity[1], b.hot.spin[0]) = (0.07, 0.23, -90.0);
    let centres = [[0.0, 0.0], [8e-3, 0.0], [-0.02, 0.013]];
    let mut world = pair_world(&Solo, 5e-8, contact(3.5), [a, b]);
    let before = centres.map(|centre| momentum(&world, centre));
    let touching = |world: &PlanarWorld| world.assembly.grains.force.iter().any(|force| *force != Vector::zeros());
    let (spin_before, mut touched) = (world.assembly.grains.hot[row_of(&world, 4)].spin[0], 0);
    for _ in 0..400 {
        world.advance().unwrap();
        touched += u32::from(touching(&world));
        for (centre, before) in centres.iter().zip(&before) {
            for (now, before) in momentum(&world, *centre).iter().zip(before) {
                let scale = before[1].max(now[1]);
                assert!((now[0] - before[0]).abs() < 3e-13 * scale, "{centre:?}: {before:?} became {now:?}");
            }
        }
    }
    let spin = world.assembly.grains.hot[row_of(&world, 4)].spin[0];
    assert!(touched > 50 && !touching(&world), "they met for {touched} steps");
    assert!((spin - spin_before).abs() > 10.0, "friction did nothing: {spin_before} rad/s became {spin} rad/s");
}

/// A record of another program: constants from its header, then one row per step.
struct Record {
    radii: [f64; 2],
    masses: [f64; 2],
    damping: f64,
    dt: f64,
    rows: Vec<Vec<f64>>,
}

impl Record {
    fn parse(text: &str) -> Self {
        let constants = text.lines().nth(1).unwrap();
        let constant = |name: &str| -> f64 {
            let words = constants.split_whitespace();
            words.filter_map(|word| word.split_once('=')).find(|(key, _)| *key == name).unwrap().1.parse().unwrap()
        };
        let rows = text.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_digit()));
        Self {
            radii: [constant("radius1"), constant("radius2")],
            masses: [constant("mass1"), constant("mass2")],
            damping: constant("gamma"),
            dt: constant("dt"),
            rows: rows.map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect(),
        }
    }

    /// Columns 1 to 16 of a row as the world has them: x, y, vx, vy, spin of both, then force and torque of both.
    ///
    /// A world's velocities are half a step behind its positions; those of full steps follow from the forces.
    fn replay(&self) -> Vec<[f64; 16]> {
        let first = &self.rows[0];
        let pair = [0, 1].map(|disc| {
            let at = 1 + 5 * disc;
            let mut body = grain(disc as u64 + 1, [first[at], first[at + 1]], self.radii[disc], self.masses[disc]);
            (body.hot.velocity[0], body.hot.velocity[1]) = (first[at + 2], first[at + 3]);
            body.hot.spin[0] = first[at + 4];
            body
        });
        let mut world = pair_world(&Solo, self.dt, contact(self.damping), pair);
        let mut found = Vec::new();
        for _ in &self.rows {
            let rows = [1, 2].map(|id| row_of(&world, id));
            let places = rows.map(|row| world.assembly.grains.hot[row].position);
            world.advance().unwrap();
            let mut values = [0.0; 16];
            for (disc, row) in rows.into_iter().enumerate() {
                let hot = &world.assembly.grains.hot[row];
                let (force, torque) = (world.assembly.grains.force[row], world.assembly.grains.torque[row]);
                let velocity = hot.velocity - force * (0.5 * self.dt / hot.mass);
                let spin = hot.spin - torque * (0.5 * self.dt / Plane::grain_inertia(hot.mass, hot.radius));
                let state = [places[disc][0], places[disc][1], velocity[0], velocity[1], spin[0]];
                values[5 * disc..5 * disc + 5].copy_from_slice(&state);
                values[10 + 3 * disc..13 + 3 * disc].copy_from_slice(&[force[0], force[1], torque[0]]);
            }
            found.push(values);
        }
        found
    }
}

/// LAMMPS' pair granular has the same law and scheme; a file is met when every number of every step is, relative to the
/// largest of its column. The record's own coordinates are used: a shift would cost digits of the overlap.
#[test]
fn a_collision_computed_by_another_program_is_repeated() {
    for text in [include_str!("../data/two_discs_equal_nospin.csv"), include_str!("../data/two_discs_unequal_spin.csv")]
    {
        let record = Record::parse(text);
        assert!(record.rows.len() > 30);
        let mut worst = 0.0f64;
        for (row, found) in record.rows.iter().zip(record.replay()) {
            for (column, found) in found.iter().enumerate() {
                let scale = record.rows.iter().map(|row| row[column + 1].abs()).fold(0.0, f64::max);
                let error = (found - row[column + 1]).abs();
                assert!(
                    error <= 1e-12 * scale,
                    "step {}, column {column}: {found:e} for {:e}",
                    row[0],
                    row[column + 1]
                );
                worst = worst.max(if scale > 0.0 { error / scale } else { 0.0 });
            }
        }
        println!("replay: {worst:e}");
    }
}

/// Runs a job with a checkpoint at every step.
fn run_by_steps(text: &str, sets: &[String], out: &Path) -> f64 {
    let kept = ["output.checkpoint_interval=0.5 us", "output.checkpoints_kept=1000"].map(String::from);
    let job = Job::parse(text, "jobs/element/job.toml", &[&kept, sets].concat()).unwrap();
    start::start(&job, &Options::new(out.to_path_buf(), 1), &Solo).unwrap();
    job.step()
}

/// The state that a run has kept of a step.
pub fn state_after(out: &Path, step: u64) -> State {
    let kept = store::all(&checkpoint::folder(out)).unwrap();
    let (_, path) = kept.iter().find(|(of, _)| *of == step).unwrap_or_else(|| panic!("step {step}: {kept:?}"));
    store::read(path).unwrap()
}

/// Rows of numbers of the grains exported after a step, by id.
fn exported(out: &Path, step: u64, wanted: Wanted) -> Vec<Vec<f64>> {
    let state = state_after(out, step);
    let file = out.join("exported.csv");
    grain_export::write(&state, out, &file, wanted).unwrap();
    let text = std::fs::read_to_string(file).unwrap();
    text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

const FULL: Wanted = Wanted { velocities_now: true, forces: true };

/// The same record met by what a user can get at: a run from a file, and exports of its checkpoints.
#[test]
fn exports_at_full_steps_are_those_of_another_program() {
    for text in [include_str!("../data/two_discs_equal_nospin.csv"), include_str!("../data/two_discs_unequal_spin.csv")]
    {
        let record = Record::parse(text);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("discs.csv");
        let mut grains = String::from("id,x,y,radius,vx,vy,spin\n");
        for disc in [0, 1] {
            let row = &record.rows[0][1 + 5 * disc..];
            let [x, y, vx, vy, spin] = [row[0], row[1], row[2], row[3], row[4]];
            grains += &format!("{},{x:e},{y:e},{:e},{vx:e},{vy:e},{spin:e}\n", disc + 1, record.radii[disc]);
        }
        std::fs::write(&file, grains).unwrap();
        let end = (record.rows.len() - 1) as f64 * record.dt;
        let sets = [format!("grains.file={}", file.display()), format!("time.end={end:e}")];
        let out = folder.path().join("run");
        run_by_steps(include_str!("../../jobs/element/two_discs.toml"), &sets, &out);
        let mut worst = 0.0f64;
        for row in &record.rows[1..] {
            let found = exported(&out, row[0] as u64, FULL);
            for (disc, found) in found.iter().enumerate() {
                let found = [&found[1..3], &found[4..10]].concat();
                let columns = (1 + 5 * disc..6 + 5 * disc).chain(11 + 3 * disc..14 + 3 * disc);
                for (column, found) in columns.zip(found) {
                    let scale = record.rows.iter().map(|row| row[column].abs()).fold(0.0, f64::max);
                    worst = worst.max((found - row[column]).abs() / scale.max(f64::MIN_POSITIVE));
                }
            }
        }
        println!("exports: {worst:e}");
        assert!(worst < 1e-12, "{worst:e}");
    }
}

/// Under gravity, on a floor, beside glued grains and across the period: what the exports of two steps differ by is what
/// the forces of the first and gravity did, and full steps lie midway between the half steps.
#[test]
fn exported_forces_are_what_moves_grains() {
    const JOB: &str = r#"
name = "floor"
[cell]
space = "plane"
upper = ["3 mm", "6 mm"]
periodic = [true, false]
gravity = ["2 m/s2", "-9.81 m/s2"]
[grains]
density = "2530 kg/m3"
file = "FILE"
diameter_mean = "1 mm"
[contact]
law = "linear"
stiffness_normal = 1772093.8
stiffness_tangential = 886046.9
damping_normal = "3 N s/m"
damping_tangential = "3 N s/m"
friction = 0.5
[time]
step = "0.5 us"
end = "30 us"
allow_unstable = true
[[body]]
name = "floor"
shape = "plane"
point = [0, "1 mm"]
normal = [0, 1]
[[body]]
name = "lid"
shape = "layer"
lower = [0, "4 mm"]
upper = ["3 mm", "5 mm"]
path = [{ time = 0, velocity = ["0.1 m/s", 0] }, { time = "30 us", velocity = ["0.4 m/s", 0] }]
"#;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("grains.csv");
    let grains = "id,x,y,radius,vx,vy,spin\n\
        0,2.9999e-3,1.500001e-3,5e-4,0.5,-0.3,90\n1,0.92e-3,1.9e-3,5e-4,-0.4,-0.1,0\n2,1e-3,4.5e-3,5e-4,0,0,0\n";
    std::fs::write(&file, grains).unwrap();
    let out = folder.path().join("run");
    let dt = run_by_steps(&JOB.replace("FILE", &file.display().to_string()), &[], &out);
    let (mut pushed, mut crossed) = ([0; 2], 0);
    for step in 1..59 {
        let [half, now] = [Wanted::default(), FULL].map(|wanted| exported(&out, step, wanted));
        let next = exported(&out, step + 1, Wanted::default());
        for (id, now) in now.iter().enumerate() {
            let (half, next) = (&half[id][4..7], &next[id][4..7]);
            for axis in 0..3 {
                assert!((now[4 + axis] - 0.5 * (half[axis] + next[axis])).abs() < 1e-13, "step {step}, grain {id}");
            }
            if id == 2 {
                continue;
            }
            let mass = 25.3 * math::PI * 25e-8;
            let inertia = Plane::grain_inertia(mass, 5e-4);
            let push = [mass * 2.0, mass * -9.81, 0.0];
            for axis in 0..3 {
                let change = (next[axis] - half[axis]) * [mass, mass, inertia][axis] / dt;
                let wanted = now[7 + axis] + push[axis];
                assert!((change - wanted).abs() < 1e-8 * [1.0, 1.0, 1e-3][axis], "step {step}: {change} {wanted}");
            }
            pushed[id] += i32::from(now[8] > 1e-3);
        }
        crossed += i32::from(now[0][1] < 1e-3);
    }
    assert!(pushed.iter().all(|steps| *steps > 5) && crossed > 5, "{pushed:?} {crossed}");
}
