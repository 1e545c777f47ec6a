//! Friction that was mobilised before a point was made.

use super::*;

/// What has borne more before is elastic up to there, and flows beyond.
#[test]
fn friction_that_was_mobilised_before_stays_mobilised() {
    let law = MobilisedFriction::of(&MobilisedConstants::DISCS);
    let fraction = 0.84;
    let of = |share: f64| {
        let q = share * law.peak::<Plane, f64>(fraction) * 400e3;
        <Plane as Space>::Tensor::new(-400e3, q, q, -400e3)
    };
    let flows = |hardened: Option<f64>, to: f64| {
        let mut memory: MobilisedMemory<Plane> = law.start(&of(0.6), fraction);
        if let Some(share) = hardened {
            MaterialLaw::<Plane>::harden(&law, &mut memory, share);
            // By less than it bears nothing is taken from it.
            MaterialLaw::<Plane>::harden(&law, &mut memory, 0.3);
        }
        let strain = (of(to) - of(0.6)) * (0.5 / law.shear_modulus);
        carry::<Plane>(&law, &mut memory, &strain);
        memory.plastic_strain > 0.0
    };
    assert_eq!([flows(None, 0.61), flows(Some(0.9), 0.89), flows(Some(0.9), 0.91)], [true, false, true]);
}
