//! Representative volume elements: the assembly of Liang & Zhao (2019), Table 1, made smaller.

use scree::base::math::{cos, sin};
use scree::base::space::{Linear, Plane, Solid, Space};
use scree::base::symmetric::Symmetric;
use scree::job::Job;
use scree::prepare::grain_world;
use scree::rve::drive::Relaxation;
use scree::rve::levels::{Path, levels};
use scree::rve::renew::{is_drawn_out, renewed};
use scree::rve::{Drive, Pace, Response, Resting, Rve, Scratch};
use scree_partition::Solo;

type Tensor = <Plane as Space>::Tensor;

const DISCS: &str = r#"
    name = "discs"
    [cell]
    space = "plane"
    upper = ["12 cm", "12 cm"]
    depth = "10 cm"
    [grains]
    density = "2650 kg/m3"
    count = 100
    distribution = "uniform"
    diameter_min = "6 mm"
    diameter_max = "14 mm"
    [packing]
    preparation = "compress"
    stress = "100 kPa"
    friction = 0.1
    [contact]
    law = "elastic_rolling"
    young_modulus = "600 MPa"
    stiffness_ratio = 0.8
    friction = 0.545
    [damping]
    local = 0.1
    form = "component"
    [time]
    end = "1 s"
"#;

const SPHERES: &str = r#"
    name = "spheres"
    [cell]
    space = "solid"
    upper = ["7 mm", "7 mm", "7 mm"]
    [grains]
    density = "2650 kg/m3"
    count = 200
    distribution = "uniform"
    diameter_min = "0.8 mm"
    diameter_max = "1.2 mm"
    [packing]
    preparation = "compress"
    stress = "100 kPa"
    energy_ratio_max = 1e-3
    [contact]
    law = "hertz_mindlin"
    shear_modulus = "290 MPa"
    poisson_ratio = 0.15
    friction = 0.5
    damping_normal = 0.01
    damping_tangential = 0.01
    [time]
    end = "1 s"
"#;

const QUASI_STATIC: Drive = Drive { pace: Pace::QuasiStatic { inertial_number: 5e-4 }, steps_min: 2, relaxation: None };

fn made<S: Space>(text: &str) -> Rve<S> {
    let cache = std::env::temp_dir().join("scree-test-rve");
    let sets = [format!("packing.cache={}", cache.display())];
    let job = Job::parse(text, "rve.toml", &sets).unwrap_or_else(|error| panic!("{error}"));
    grain_world::volume_element(job.as_assembly().unwrap(), &Solo).unwrap()
}

fn follow<S: Space>(rve: &mut Rve<S>, deformation: &S::Tensor) -> Response<S> {
    rve.follow(deformation, f64::NAN, &QUASI_STATIC, &mut Scratch::default()).unwrap()
}

fn turn(angle: f64) -> Tensor {
    Tensor::new(cos(angle), -sin(angle), sin(angle), cos(angle))
}

fn shear(gamma: f64) -> Tensor {
    Tensor::new(1.0, gamma, 0.0, 1.0)
}

/// Whatever turns is not observed at by its grains: the stress turns along, whole turns included.
#[test]
fn a_rigid_turn_turns_the_stress() {
    let mut still = made::<Plane>(DISCS);
    let loaded = Tensor::new(0.9995, 2e-4, 0.0, 0.9998);
    follow(&mut still, &loaded);
    let mut turned = still.clone();
    for step in 1..=72 {
        let rotation = turn(std::f64::consts::TAU * f64::from(step) / 72.0);
        let [wanted, found] = [(&mut still, loaded), (&mut turned, rotation * loaded)]
            .map(|(rve, deformation)| follow(rve, &deformation).kirchhoff.tensor());
        let wanted = rotation * wanted * rotation.transpose();
        let off = (found - wanted).norm() / wanted.norm();
        assert!(off < 1e-12, "{step}: {found} {wanted}");
    }
}

/// The same path under a spin laid over it: stress turns with it, until round-off has grown where grains rearrange.
#[test]
fn a_spin_laid_over_a_path_turns_its_stress() {
    let (mut plain, mut spun) = (made::<Plane>(DISCS), made::<Plane>(DISCS));
    let mut last = 0.0;
    for step in 1..=10 {
        let deformation = shear(1e-3 * f64::from(step));
        let rotation = turn(0.02 * f64::from(step));
        let wanted = rotation * follow(&mut plain, &deformation).kirchhoff.tensor() * rotation.transpose();
        let found = follow(&mut spun, &(rotation * deformation)).kirchhoff.tensor();
        last = (found - wanted).norm() / wanted.norm();
        // Round-off grows where grains rearrange.
        let bound = if step <= 5 { 1e-10 } else { 1e-5 };
        assert!(last < bound, "{step}: {last:.1e}");
        println!("after {step} increments {last:.1e}");
    }
    assert!(last > 0.0, "the frames differ");
}

/// A rigid turn turns grains by its angle, whole turns included, and simple shear by about half of it: in the mean grains have the spin
/// of the material.
#[test]
fn grains_turn_with_the_material() {
    let mut still = made::<Plane>(DISCS);
    let mut turned = still.clone();
    for step in 1..=72 {
        let angle = std::f64::consts::TAU * f64::from(step) / 72.0;
        follow(&mut still, &Tensor::identity());
        follow(&mut turned, &turn(angle));
        let off = turned.grain_rotation() - still.grain_rotation() - angle;
        assert!(off.abs() < 1e-11, "{step}: {off:.1e}");
    }
    let mut sheared = made::<Plane>(DISCS);
    for step in 1..=300 {
        follow(&mut sheared, &shear(1e-3 * f64::from(step)));
    }
    let of_material = -0.5 * 0.3;
    let ratio = sheared.grain_rotation() / of_material;
    println!("after a shear of 0.3 grains have turned by {ratio:.3} of what the material has");
    assert!((0.8..1.2).contains(&ratio), "{ratio:.3}");
    let mut oblique = made::<Solid>(SPHERES);
    let axis = <Solid as Space>::Vector::new(1.0, 2.0, -2.0) / 3.0;
    let turn = |angle: f64| nalgebra::Rotation3::from_scaled_axis(axis * angle).into_inner();
    let mut plain = oblique.clone();
    for step in 1..=12 {
        follow(&mut oblique, &turn(0.25 * f64::from(step)));
        follow(&mut plain, &<Solid as Space>::Tensor::identity());
    }
    let off = oblique.grain_rotation() - 3.0;
    assert!(off.abs() < 1e-9 + plain.grain_rotation(), "{off:.1e}");
}

/// Hill-Mandel: what the stress does on a velocity gradient in the volume of an RVE is what contacts across its periodic borders do on the
/// velocities of its images, less what is out of balance on grains does on the mean field.
fn power_off<S: Space>(rve: &Rve<S>, gradient: &S::Tensor) -> f64 {
    let scratch = &mut Scratch::default();
    let seen = rve.observe(scratch);
    let volume_start = rve.volume() / S::determinant(rve.deformation());
    let of_stress = volume_start * seen.kirchhoff.tensor().dot(gradient);
    let (places, _) = rve.places();
    let (mut across, mut nets) = (0.0, vec![S::Vector::zero(); places.len()]);
    for bearing in rve.bearings(scratch) {
        let [a, b] = bearing.grains.map(|grain| grain as usize);
        // The image of either that this contact is with: as far from the grain in the cell as whole periods are.
        let shift = (bearing.end - places[b]) - (bearing.begin - places[a]);
        across += bearing.force.dot(&(*gradient * shift));
        nets[a] += bearing.force;
        nets[b] -= bearing.force;
    }
    let out_of_balance: f64 = nets.iter().zip(&places).map(|(net, place)| net.dot(&(*gradient * *place))).sum();
    (of_stress - (across - out_of_balance)).abs() / (volume_start * seen.kirchhoff.tensor().norm() * gradient.norm())
}

#[test]
fn work_of_the_stress_is_that_at_the_borders_of_the_cell() {
    let mut most = 0.0f64;
    let mut discs = made::<Plane>(DISCS);
    for step in 1..=300 {
        let strain = 2e-3 * f64::from(step);
        let deformation = turn(0.5 * strain) * Tensor::new(1.0 - 0.2 * strain, strain, 0.0, 1.0 + 0.1 * strain);
        follow(&mut discs, &deformation);
        // Of a gradient without a spin: moments on grains out of balance make the stress skew, and its symmetric part is what points have.
        most = most.max(power_off(&discs, &Tensor::new(-0.3, 0.8, 0.8, 0.5)));
    }
    let mut spheres = made::<Solid>(SPHERES);
    for step in 1..=20 {
        let mut deformation = <Solid as Space>::Tensor::identity();
        (deformation[(0, 1)], deformation[(2, 2)]) = (1e-3 * f64::from(step), 1.0 - 1e-3 * f64::from(step));
        follow(&mut spheres, &deformation);
        let gradient = <Solid as Space>::Tensor::new(0.1, 0.4, 0.0, 0.4, -0.7, 0.2, 0.0, 0.2, 0.3);
        most = most.max(power_off(&spheres, &gradient));
    }
    println!("power of the stress against that at the borders: {most:.1e}");
    assert!(most < 1e-10, "{most:.1e}");
}

/// One that has been drawn out to more copies of its packing than it may be of is renewed: its packing bears the same stress where its F is,
/// and goes on from there; rested and woken to the same bits.
#[test]
fn what_is_drawn_out_too_far_is_renewed() {
    let mut rve = made::<Plane>(DISCS);
    let mut deformation = Tensor::identity();
    let mut increments = 0;
    while !is_drawn_out(&rve) {
        // At a volume that grains keep to by a servo of their own.
        let pressure = rve.pressure();
        let swelling = 2e-4 * (pressure / 100e3 - 1.0).clamp(-1.0, 1.0);
        deformation = Tensor::new(1.01 + swelling, 0.0, 0.0, 1.0 / 1.01 + swelling) * deformation;
        follow(&mut rve, &deformation);
        increments += 1;
        assert!(increments < 2000 && rve.grains() <= 3200, "{} grains", rve.grains());
    }
    let scratch = &mut Scratch::default();
    let (fresh, jump) = renewed(&rve, &QUASI_STATIC, scratch).unwrap().expect("the packing is known");
    let [before, after] = [&rve, &fresh].map(|rve| rve.observe(&mut Scratch::default()).kirchhoff.tensor());
    let off = (after - before).norm() / before.norm();
    println!(
        "after {increments} increments, drawn out {:.1} times: {} grains and {:.0} kPa, {} grains after with a jump of {jump:.3}",
        deformation[(0, 0)],
        rve.grains(),
        1e-3 * rve.pressure(),
        fresh.grains()
    );
    assert_eq!((fresh.grains(), fresh.deformation()), (100, &deformation));
    assert!(jump < 0.05 && (off - jump).abs() < 0.01, "{jump} {off}");
    assert!(fresh.state().steps > rve.state().steps);
    let (resting, mut woken) = (fresh.rest(), Rve::wake(fresh.template(), &fresh.rest()).unwrap());
    let mut fresh = fresh;
    assert!(woken.rest() == resting);
    for step in 1..=20 {
        let next = shear(1e-3 * f64::from(step)) * deformation;
        let [one, other] = [&mut fresh, &mut woken].map(|rve| follow(rve, &next));
        assert_eq!(one, other, "{step}");
        assert!((fresh.volume() / (fresh.sample().assembly.cell.volume() * 0.1) - 1.0).abs() < 1e-12);
    }
    // What former programs have written does not say how the packing lay: such a run goes on as it did.
    let mut template = rve.template().clone();
    template.packing.laid = None;
    let old = Rve::wake(&template, &rve.rest()).unwrap();
    assert!(renewed(&old, &QUASI_STATIC, scratch).unwrap().is_none());
}

/// Simple shear by three turns the lattice several times; the cell is where F says, and the stress is that of friction.
#[test]
fn shear_by_three_goes_through() {
    let mut rve = made::<Plane>(DISCS);
    let (steps, mut ratio) = (3000, 0.0);
    for step in 1..=steps {
        let stress = follow(&mut rve, &shear(3.0 * f64::from(step) / f64::from(steps))).kirchhoff.tensor();
        if step > steps / 2 {
            ratio += 2.0 * stress[(0, 1)].abs() / (stress[(0, 0)] + stress[(1, 1)]).abs() / f64::from(steps / 2);
        }
        let cell = rve.sample().assembly.cell;
        assert!((cell.volume() * 0.1 / rve.volume() - 1.0).abs() < 1e-12, "{step}");
    }
    assert!((0.2..0.5).contains(&ratio), "mobilised friction {ratio:.3}");
}

/// Until grains rearrange, an isotropic squeeze changes every contact by what its overlap changes: the change of stress is that of the
/// closed form over the actual contacts.
#[test]
fn the_first_step_is_affine() {
    let rve = made::<Plane>(DISCS);
    let identity = <Plane as Space>::identity();
    let drive = Drive { pace: Pace::QuasiStatic { inertial_number: 1e9 }, steps_min: 1, relaxation: None };
    let strain = 1e-6;
    let mut sample = rve.sample().clone();
    sample.assembly.contacts.settle_images(&sample.assembly.cell);
    let (contacts, grains) = (&sample.assembly.contacts, &sample.assembly.grains);
    let mut wanted = 0.0;
    for (_, pair) in contacts.neighbours.real_pairs() {
        let [a, b] = [pair.a, pair.b()].map(|row| &grains.hot[row as usize]);
        let branch = (a.position - b.position + contacts.shift(pair).0).norm();
        let stiffness = 600e6 * 2.0 * a.radius * b.radius / (a.radius + b.radius);
        let borne = |branch: f64| stiffness * (a.radius + b.radius - branch).max(0.0) * branch;
        wanted -= borne(branch * (1.0 - strain)) - borne(branch);
    }
    let volume = rve.volume();
    // One step each, so that what velocities of their own make of it is the same in both.
    let [still, squeezed] = [identity, identity * (1.0 - strain)].map(|deformation| {
        rve.clone().follow(&deformation, f64::NAN, &drive, &mut Scratch::default()).unwrap().kirchhoff.trace()
    });
    let found = (squeezed - still) * volume;
    println!("change of the trace over the affine one {:.6}", found / wanted);
    assert!((found / wanted - 1.0).abs() < 1e-3, "{found:.6e} {wanted:.6e}");
}

/// Grains bear again at the density at which they ceased to, and nothing flies on in between.
#[test]
fn what_separates_meets_again_at_its_density() {
    let mut rve = made::<Plane>(DISCS);
    let identity = <Plane as Space>::identity();
    let pressure = |answer: &Response<Plane>| -0.5 * answer.kirchhoff.trace();
    let start = pressure(&follow(&mut rve, &identity));
    let (mut lost, mut back) = (0.0, 0.0);
    for step in 1..=500 {
        let stretch = 1.0 + 1e-4 * f64::from(step);
        let answer = follow(&mut rve, &(identity * stretch));
        if answer.events.loosened && lost == 0.0 {
            lost = stretch;
        }
        let is_carried = answer.steps == 0 && answer.kirchhoff.trace() == 0.0;
        assert!(lost == 0.0 || stretch == lost || is_carried, "{step}");
    }
    assert!(rve.is_loose() && lost > 1.0 && lost < 1.03, "{lost}");
    let mut last = 0.0;
    for step in (0..500).rev() {
        let stretch = 1.0 + 1e-4 * f64::from(step);
        let answer = follow(&mut rve, &(identity * stretch));
        last = pressure(&answer);
        if back == 0.0 && last > 0.01 * start {
            back = stretch;
        }
    }
    println!("lost at {lost:.5}, back at {back:.5}, {start:.4e} Pa before, {last:.4e} Pa after");
    assert!((back / lost - 1.0).abs() < 5e-3, "lost at {lost}, back at {back}");
    assert!((last / start - 1.0).abs() < 0.12, "{start:.4e} Pa before, {last:.4e} Pa after");
}

/// A cell that is drawn out is replicated before contacts reach around it: the stress does not feel it, and the cell is where F says,
/// whatever its volume does.
#[test]
fn a_thin_cell_is_replicated() {
    let mut rve = made::<Plane>(DISCS);
    let (grains, edges) = (rve.grains(), rve.sample().assembly.cell.edges);
    let (mut before, mut renewed, mut jump) = (0.0, 0, 0.0f64);
    let mut change = Vec::new();
    for step in 1..=700 {
        let stretch = 1.0 + 4e-3 * f64::from(step);
        // It is also squeezed, so that an increment that got lost would be missed.
        let volume = 1.0 - 2e-5 * f64::from(step);
        let answer = follow(&mut rve, &Tensor::new(stretch, 0.0, 0.0, volume / stretch));
        let pressure = -0.5 * answer.kirchhoff.trace();
        let changed = (pressure / before - 1.0f64).abs();
        match answer.events.replicated {
            0 => change.push(changed),
            times => (renewed, jump) = (renewed + times, jump.max(changed)),
        }
        before = pressure;
        let cell = rve.sample().assembly.cell;
        let wanted = edges.determinant() * volume * f64::from(1 << renewed);
        assert!((cell.volume() / wanted - 1.0).abs() < 1e-12, "{step}: {} for {wanted}", cell.volume());
        assert!((rve.volume() / (0.1 * wanted) - 1.0).abs() < 1e-12, "{step}");
    }
    change.sort_by(f64::total_cmp);
    let usual = change[change.len() * 9 / 10];
    println!("{renewed} times, a jump of {jump:.4}, {usual:.4} in one of ten increments");
    assert!(renewed >= 1 && rve.grains() == grains << renewed, "{renewed} times");
    assert!(jump < 2.0 * usual, "a jump of {jump:.4}, {usual:.4} in one of ten increments");
}

/// What flies apart, is drawn out and turned meanwhile and lands again has its volume, bears what its density makes it bear, and was not
/// shot apart by overlaps.
#[test]
fn what_lands_otherwise_than_it_flew_off_comes_to_rest() {
    let mut rve = made::<Plane>(DISCS);
    let edges = rve.sample().assembly.cell.edges;
    let identity = <Plane as Space>::identity();
    let flight = |share: f64| {
        let (stretch, swelling) = (1.0 + 1.2 * share, 1.0 + 0.3 * (1.0 - (2.0 * share - 1.0).abs()) - 0.012 * share);
        turn(2.0 * share) * Tensor::new(stretch, 0.0, 0.0, swelling / stretch)
    };
    follow(&mut rve, &identity);
    let mut pressure = 0.0;
    for step in 1..=400 {
        let deformation = flight(f64::from(step) / 400.0);
        let answer = follow(&mut rve, &deformation);
        pressure = -0.5 * answer.kirchhoff.trace();
        assert!(pressure.is_finite() && pressure < 5e6, "{step}: {pressure:.3e} Pa");
    }
    assert!(!rve.is_loose(), "it has landed");
    let volume = rve.sample().assembly.cell.volume() / edges.determinant();
    let copies = (rve.grains() / 100) as f64;
    assert!((volume / copies / flight(1.0).determinant() - 1.0).abs() < 1e-12, "{volume}, {copies} copies");
    println!("bears {:.1} kPa at a volume of {:.4}", 1e-3 * pressure, flight(1.0).determinant());
    assert!(pressure > 1e3, "{pressure:.3e} Pa");
}

/// Nothing that a thread has stepped before shows in what is told of a loose assembly.
#[test]
fn a_loose_assembly_shows_no_contacts() {
    let (mut bearing, mut loose) = (made::<Plane>(DISCS), made::<Plane>(DISCS));
    let scratch = &mut Scratch::default();
    for step in 1..=200 {
        let deformation = <Plane as Space>::identity() * (1.0 + 1e-4 * f64::from(step));
        loose.follow(&deformation, f64::NAN, &QUASI_STATIC, scratch).unwrap();
    }
    bearing.follow(&<Plane as Space>::identity(), f64::NAN, &QUASI_STATIC, scratch).unwrap();
    let answer = loose.follow(&(<Plane as Space>::identity() * 1.03), f64::NAN, &QUASI_STATIC, scratch).unwrap();
    let observed = loose.observe(scratch);
    assert!(loose.is_loose() && answer.steps == 0);
    assert_eq!((observed.fabric.coordination, observed.modulus_most(), observed.fabric.anisotropy()), (0.0, 0.0, 0.0));
}

/// Who looks at an assembly sees the stress that its last increment came to, and changes nothing.
fn looked_at<S: Space>(text: &str) {
    let mut rve = made::<S>(text);
    let scratch = &mut Scratch::default();
    for step in 1..=20 {
        let mut deformation = S::identity();
        deformation[S::DIMENSION] = 2e-4 * f64::from(step);
        let answer = rve.follow(&deformation, f64::NAN, &QUASI_STATIC, scratch).unwrap();
        let before = rve.rest();
        let observed = rve.observe(scratch);
        let off = (observed.kirchhoff - answer.kirchhoff).tensor().norm() / answer.kirchhoff.tensor().norm();
        let unbalanced = observed.unbalanced.unwrap() / answer.unbalanced.unwrap();
        assert!(off < 1e-13 && (unbalanced - 1.0).abs() < 1e-12, "{off:.1e} {unbalanced}");
        assert!(rve.rest() == before);
    }
}

#[test]
fn looking_at_discs_changes_nothing() {
    looked_at::<Plane>(DISCS);
}

#[test]
fn looking_at_spheres_changes_nothing() {
    // Dashpots push by the velocities before the last kick, so that spheres without them are looked at.
    looked_at::<Solid>(
        &SPHERES
            .replace("damping_normal = 0.01", "damping_normal = 0.0")
            .replace("damping_tangential = 0.01", "damping_tangential = 0.0"),
    );
}

/// What no assembly can follow is refused before anything has changed.
#[test]
fn what_is_turned_inside_out_is_refused() {
    let mut rve = made::<Plane>(DISCS);
    let before = rve.rest();
    for bad in [Tensor::new(-1.0, 0.0, 0.0, 1.0), Tensor::new(0.0, 0.0, 0.0, 1.0), Tensor::new(f64::NAN, 0.0, 0.0, 1.0)]
    {
        let refused = rve.follow(&bad, f64::NAN, &QUASI_STATIC, &mut Scratch::default()).unwrap_err().to_string();
        assert!(refused.contains("turned inside out"), "{refused}");
    }
    let synchronous = Drive { pace: Pace::Synchronous, ..QUASI_STATIC };
    for no_time in [0.0, -1.0, f64::NAN] {
        let identity = <Plane as Space>::identity();
        let refused = rve.follow(&identity, no_time, &synchronous, &mut Scratch::default()).unwrap_err().to_string();
        assert!(refused.contains("the time of the continuum"), "{refused}");
    }
    assert!(rve.rest() == before);
}

/// Both halves of what is replicated bear what the whole did.
#[test]
fn replicated_it_bears_the_same() {
    fn holds<S: Space>(text: &str) {
        let mut rve = made::<S>(text);
        let identity = S::identity();
        follow(&mut rve, &identity);
        for axis in 0..S::DIMENSION {
            let mut sample = rve.sample().clone();
            sample.assembly.restore_cold();
            let volume = sample.assembly.cell.volume();
            let before = sample.contact_moment() * (1.0 / volume);
            scree::rve::renew::double(&mut sample, axis).unwrap();
            let after = sample.contact_moment() * (1.0 / (2.0 * volume));
            assert!((after - before).norm() < 1e-12 * before.norm(), "{} {axis}: {after:?} {before:?}", S::NAME);
        }
    }
    holds::<Plane>(DISCS);
    holds::<Solid>(SPHERES);
}

/// Spheres turn as discs do, about any axis.
#[test]
fn spheres_turn_with_their_stress() {
    type Tensor = <Solid as Space>::Tensor;
    let mut still = made::<Solid>(SPHERES);
    let mut loaded = Tensor::identity();
    (loaded[(0, 0)], loaded[(2, 2)], loaded[(0, 1)]) = (0.9995, 0.9997, 3e-4);
    follow(&mut still, &loaded);
    let mut turned = still.clone();
    let axis = nalgebra::Unit::new_normalize(nalgebra::Vector3::new(1.0, 2.0, -0.5));
    for step in 1..=24 {
        let rotation = *nalgebra::Rotation3::from_axis_angle(&axis, 0.3 * f64::from(step)).matrix();
        let [wanted, found] = [(&mut still, loaded), (&mut turned, rotation * loaded)]
            .map(|(rve, deformation)| follow(rve, &deformation).kirchhoff.tensor());
        let wanted = rotation * wanted * rotation.transpose();
        assert!((found - wanted).norm() < 1e-12 * wanted.norm(), "{step}: {found} {wanted}");
    }
}

/// Whoever rests and wakes goes on to the same bits: in the middle of a shear, after it was replicated, and where nothing touches.
#[test]
fn it_rests_and_wakes_to_the_same_bits() {
    fn holds<S: Space>(text: &str, path: impl Fn(f64) -> S::Tensor, increments: u32, every: u32) -> Resting<S> {
        goes_on(text, path, [increments, every], &QUASI_STATIC)
    }
    fn goes_on<S: Space>(
        text: &str,
        path: impl Fn(f64) -> S::Tensor,
        [increments, every]: [u32; 2],
        drive: &Drive,
    ) -> Resting<S> {
        let mut rve = made::<S>(text);
        let template = rve.template().clone();
        let mut woken = rve.clone();
        for step in 1..=increments {
            let deformation = path(f64::from(step) / f64::from(increments));
            // Increments of different lengths, in no whole number of steps.
            let duration = rve.sample().constants.dt * (1.3 + f64::from(step % 3));
            let [wanted, found] = [&mut rve, &mut woken]
                .map(|rve| rve.follow(&deformation, duration, drive, &mut Scratch::default()).unwrap());
            assert_eq!(wanted, found, "{} {step}", S::NAME);
            if step % every == 0 {
                woken = Rve::wake(&template, &woken.rest()).unwrap();
            }
        }
        assert!(rve.rest() == woken.rest());
        let rest = rve.rest();
        println!("{}: {:.0} bytes a grain", S::NAME, rest.bytes() as f64 / rve.grains() as f64);
        rest
    }
    holds::<Plane>(DISCS, |share| shear(0.3 * share), 300, 7);
    let drawn = |share: f64| Tensor::new(1.0 + 2.8 * share, 0.0, 0.0, 1.0 / (1.0 + 2.8 * share));
    let thin = holds::<Plane>(DISCS, drawn, 400, 19);
    assert!(thin.motions.len() > 100 * 7, "it was replicated");
    let to_and_fro = |share: f64| Tensor::identity() * (1.0 + 0.02 * (1.0 - (2.0 * share - 1.0).abs()));
    holds::<Plane>(DISCS, to_and_fro, 200, 11);
    let synchronous = Drive { pace: Pace::Synchronous, ..QUASI_STATIC };
    goes_on::<Plane>(DISCS, |share| shear(0.02 * share), [300, 7], &synchronous);
    let relaxed = Drive { relaxation: Some(Relaxation { unbalanced_max: 0.01, steps_max: 50 }), ..QUASI_STATIC };
    goes_on::<Plane>(DISCS, |share| shear(0.02 * share), [50, 7], &relaxed);
    // Several segments of rows, and pairs between them.
    let many = DISCS.replace("count = 100", "count = 1600").replace("12 cm", "48 cm");
    holds::<Plane>(&many, |share| shear(0.02 * share), 60, 7);
    holds::<Solid>(
        SPHERES,
        |share| {
            let mut deformation = Solid::identity();
            deformation[3] = 0.05 * share;
            deformation
        },
        60,
        7,
    );
}

/// One path of compression gives every level, each a start of its own.
#[test]
fn one_path_gives_all_levels() {
    let start = made::<Plane>(DISCS);
    let scratch = &mut Scratch::default();
    let stresses = [100e3, 150e3, 300e3];
    let identity = <Plane as Space>::identity();
    let reached = levels(&start, Path::Isotropic, &stresses, &QUASI_STATIC, scratch).unwrap();
    let mut before = f64::INFINITY;
    for (mut rve, wanted) in reached.into_iter().zip(stresses) {
        assert!(rve.void_ratio() < before && *rve.deformation() == identity);
        before = rve.void_ratio();
        let kirchhoff = follow(&mut rve, &identity).kirchhoff;
        let pressure = -0.5 * kirchhoff.trace();
        println!("{wanted:.0} Pa: {pressure:.0} Pa, void ratio {before:.4}");
        assert!((pressure / wanted - 1.0).abs() < 5e-3, "{pressure} of {wanted}");
    }
    let mut at_rest = levels(&start, Path::Uniaxial { axis: 1 }, &[300e3], &QUASI_STATIC, scratch).unwrap();
    let stress = follow(&mut at_rest[0], &identity).kirchhoff.tensor();
    let ratio = stress[(0, 0)] / stress[(1, 1)];
    println!("K0 {ratio:.3} after a compression from isotropic");
    assert!((stress[(1, 1)] / -300e3 - 1.0).abs() < 5e-3 && (0.4..0.95).contains(&ratio), "{stress}");
}

/// The P-wave modulus of an assembly that is squeezed along an axis stays below the affine bound, and is most of it.
#[test]
fn the_affine_stiffness_bounds_the_modulus() {
    let mut rve = made::<Plane>(DISCS);
    let identity = <Plane as Space>::identity();
    let drive = Drive { steps_min: 50, ..QUASI_STATIC };
    let scratch = &mut Scratch::default();
    let start = rve.follow(&identity, f64::NAN, &drive, scratch).unwrap();
    let observed = rve.observe(scratch);
    let strain = 1e-5;
    let mut squeezed = identity;
    squeezed[(1, 1)] -= strain;
    let end = rve.follow(&squeezed, f64::NAN, &drive, scratch).unwrap();
    let modulus = (start.kirchhoff.tensor()[(1, 1)] - end.kirchhoff.tensor()[(1, 1)]) / strain;
    let bound = observed.modulus_most();
    println!(
        "P-wave modulus {:.1} MPa of at most {:.1}; coordination {:.2}, mechanical {:.2}, anisotropy {:.3}",
        modulus * 1e-6,
        bound * 1e-6,
        observed.fabric.coordination,
        observed.fabric.mechanical,
        observed.fabric.anisotropy()
    );
    assert!((0.2..1.0).contains(&(modulus / bound)), "{modulus:.3e} of {bound:.3e}");
}

/// A synchronous drive gives grains the time of the continuum, a quasi-static one what their inertia allows.
#[test]
fn steps_follow_the_pace() {
    let mut rve = made::<Plane>(DISCS);
    let dt = rve.sample().constants.dt;
    let synchronous = Drive { pace: Pace::Synchronous, steps_min: 1, relaxation: None };
    let answer = rve.follow(&shear(1e-5), 7.5 * dt, &synchronous, &mut Scratch::default()).unwrap();
    assert_eq!(answer.steps, 8);
    let slow = follow(&mut rve, &shear(2e-5)).steps;
    let fast = follow(&mut rve, &shear(1e-3)).steps;
    assert!(slow == 2 && fast > 20, "{slow} {fast}");
}

/// Sine of the mobilised angle of friction at its largest, of biaxial compression to 2.5 % under a lateral stress that is kept, and how
/// far that stress was off at most.
fn peak(seed: u64, inertial_number: f64) -> [f64; 2] {
    let text = DISCS
        .replace("count = 100", "count = 400")
        .replace("12 cm", "24 cm")
        .replace("[cell]", &format!("seed = {seed}\n[cell]"));
    let mut rve = made::<Plane>(&text);
    let drive = Drive { pace: Pace::QuasiStatic { inertial_number }, steps_min: 1, relaxation: None };
    let (target, modulus) = (-100e3, 40e6);
    let (mut lateral, mut rate, mut off, mut sines) = (1.0, 0.0, 0.0f64, Vec::new());
    let increment = 5e-6;
    let mut mean = 0.0;
    for step in 1..=5000 {
        let axial = 1.0 - increment * f64::from(step);
        lateral += rate;
        let kirchhoff = rve
            .follow(&Tensor::new(lateral, 0.0, 0.0, axial), f64::NAN, &drive, &mut Scratch::default())
            .unwrap()
            .kirchhoff;
        let stress = kirchhoff.tensor() * (1.0 / (lateral * axial));
        let missing = stress[(0, 0)] - target;
        // In proportion, and by what has been learnt of the flow.
        mean += 0.02 * (rate - mean);
        rate = mean - 0.2 * missing / modulus;
        sines.push((stress[(1, 1)] - stress[(0, 0)]).abs() / (stress[(1, 1)] + stress[(0, 0)]).abs());
        off = if step > 500 { off.max((missing / target).abs()) } else { 0.0 };
    }
    // Over a tenth of a per cent of strain: single maxima are those of noise.
    let mean = |window: &[f64]| window.iter().sum::<f64>() / window.len() as f64;
    [sines.windows(200).map(mean).fold(0.0, f64::max), off]
}

/// Twice and four times as many steps of grains find the same peak, to a seventh of what packings differ by.
#[test]
fn more_steps_find_the_same_peak() {
    for seed in 1..=3 {
        let [coarse, fine, finest] = [5e-4, 2.5e-4, 1.25e-4].map(|inertial_number| peak(seed, inertial_number));
        println!(
            "seed {seed}: sin phi {:.4}, {:.4}, {:.4}; lateral stress off by {:.1e}, {:.1e}, {:.1e} at most",
            coarse[0], fine[0], finest[0], coarse[1], fine[1], finest[1]
        );
        for other in [fine, finest] {
            assert!((coarse[0] / other[0] - 1.0).abs() < 0.03 && coarse[1] < 0.1, "{coarse:?} {other:?}");
        }
    }
}

/// One that has the time of the continuum, lost its contacts, rested meanwhile and comes back ends in the bits of one that did not rest:
/// how long its steps were before is forgotten.
#[test]
fn a_synchronous_assembly_comes_back_to_the_same_bits() {
    let drive = Drive { pace: Pace::Synchronous, steps_min: 1, relaxation: None };
    let scratch = &mut Scratch::default();
    let mut rve = made::<Plane>(DISCS);
    let duration = 7.3 * rve.template().grain.dt;
    let mut opened = 1.0;
    while !rve.is_loose() {
        opened += 1e-4;
        let deformation = <Plane as Space>::identity() * opened;
        rve.follow(&deformation, duration, &drive, scratch).unwrap();
    }
    let mut woken = Rve::<Plane>::wake(rve.template(), &rve.rest()).unwrap();
    // Sheared while loose, so that grains overlap where they come back.
    for step in 1..=60 {
        let squeezed = opened - 2e-4 * f64::from(step);
        let deformation = shear(5e-3 * f64::from(step)) * squeezed;
        let [one, other] =
            [&mut rve, &mut woken].map(|rve| rve.follow(&deformation, duration, &drive, scratch).unwrap());
        assert_eq!(one, other, "{step}");
        assert!(rve.rest() == woken.rest(), "{step}");
    }
    assert!(!rve.is_loose());
}
