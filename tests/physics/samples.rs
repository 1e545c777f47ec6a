//! A sample of grains that steps by itself, without ranks, is a world of one rank to the bit.

use scree::base::ids::GrainId;
use scree::base::numbers::Numbers;
use scree::base::space::Space;
use scree::dem::drive::{Response, StressServo};
use scree::dem::grains::Grains;
use scree::dem::motion::{Damping, DampingForm};
use scree::dem::sample::Sample;
use scree::law::contact::Contact;

use crate::clusters::cluster;
use crate::few::{Claim, Few, RADIUS, for_every_law, steps};

/// Rows in their order: ids, and everything that moves as bits.
fn bits<S: Space>(grains: &Grains<S>) -> Vec<(GrainId, Vec<u64>)> {
    let rows = grains.cold[..grains.owned].iter().zip(&grains.hot);
    rows.map(|(cold, hot)| (cold.id, hot.numbers().iter().map(|word| word.to_bits()).collect())).collect()
}

struct IsAWorld;

impl Claim for IsAWorld {
    fn hold<S: Space>(law: Contact) {
        let per_axis = if S::DIMENSION == 2 { 12 } else { 5 };
        let edge = 1.97 * RADIUS * per_axis as f64;
        let mut few = Few::<S>::periodic(law, 2e-7, [0.0; 3], [edge; 3]);
        few.settings.grains.skin = 0.05 * RADIUS;
        cluster(&mut few, per_axis, 0.0, 31);
        let mut sheared = few.clone();
        sheared.settings.grains.field.damping = Damping { local: 0.2, form: DampingForm::Component, mass: 0.0 };
        sheared.settings.grains.drive.gradient[S::DIMENSION] = 50.0;
        sheared.settings.grains.drive.servo = Some(StressServo {
            stress: [None, Some(-100e3), None],
            response: Response::Contacts { gain: 0.5 },
            interval: 5,
            rate_max: 20.0,
            depth: 0.01,
        });
        for few in [few, sheared] {
            let what = format!("{:?} under {law:?} in {}", few.settings.grains.drive, S::NAME);
            let mut world = few.clone().world();
            let layout = world.subdomain.layout.clone();
            let parts = layout.parts_of_cell(few.settings.grains.skin);
            let order = move |fraction: &S::Vector| layout.place::<S>(fraction, parts).unwrap();
            let mut sample =
                Sample::new(&few.grains, few.cell, few.settings.grains.clone(), std::sync::Arc::new(order)).unwrap();
            for _ in 0..6 {
                steps(&mut world, 50);
                (0..50).for_each(|_| sample.advance().unwrap());
                assert_eq!(sample.step, world.step);
                assert!(sample.assembly.cell == world.assembly.cell, "another cell: {what}");
                assert!(bits(&sample.assembly.grains) == bits(&world.assembly.grains), "other bits: {what}");
                assert!(sample.contact_moment() == world.contact_moment().unwrap(), "another stress: {what}");
            }
            assert!(world.rebuilds > 2, "{} rebuilds: {what}", world.rebuilds);
        }
    }
}

#[test]
fn a_sample_steps_as_a_world_of_one_rank_does() {
    for_every_law::<IsAWorld>();
}

/// Each thread steps samples of its own.
#[test]
fn samples_may_go_to_any_thread() {
    fn goes<T: Send>() {}
    goes::<Sample<scree::base::space::Plane>>();
    goes::<Sample<scree::base::space::Solid>>();
}
