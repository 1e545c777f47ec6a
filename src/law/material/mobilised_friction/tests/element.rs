//! Element tests of one point: what is held and what is led.

use super::*;

/// A point after an increment.
pub struct Row<S: Space> {
    pub strain: f64,
    /// Of shear stress to normal stress; in triaxial compression the axial stress, Pa.
    pub ratio: f64,
    /// det F since the start.
    pub volume: f64,
    pub memory: MobilisedMemory<S>,
}

/// The root of a rising function, by secants from a guess and its neighbour.
fn root(missing: impl Fn(f64) -> f64, guess: f64, aside: f64) -> f64 {
    let (mut at, mut next) = (guess, guess + aside);
    let (mut below, mut found) = (missing(at), missing(next));
    for _ in 0..80 {
        if found.abs() < 1e-12 || found == below {
            break;
        }
        (at, next, below) = (next, next - found * (next - at) / (found - below), found);
        found = missing(next);
    }
    assert!(found.abs() < 1e-9, "the stress cannot be kept: {found}");
    next
}

/// Simple shear under a constant normal stress: L = [[0, g], [0, l]] with l such that the Cauchy stress along y stays.
pub struct Shear<'a> {
    law: &'a MobilisedFriction,
    /// Pa, compression positive.
    normal: f64,
    pub memory: MobilisedMemory<Plane>,
    pub volume: f64,
    /// Shear stress over normal stress.
    pub last: f64,
    /// Stretch of the last increment over its shear.
    dilation: f64,
}

impl<'a> Shear<'a> {
    pub fn begin(law: &'a MobilisedFriction, normal: f64, fraction: f64) -> Self {
        Self { law, normal, memory: isotropic::<Plane>(law, normal, fraction), volume: 1.0, last: 0.0, dilation: 0.0 }
    }

    fn stepped(&self, shear: f64, stretch: f64) -> (MobilisedMemory<Plane>, <Plane as Space>::Tensor) {
        let mut memory = self.memory;
        let stress = carry::<Plane>(self.law, &mut memory, &<Plane as Space>::Tensor::new(0.0, shear, 0.0, stretch));
        (memory, stress * (1.0 / (self.volume * (1.0 + stretch))))
    }

    pub fn step(&mut self, shear: f64) {
        let missing = |stretch: f64| self.stepped(shear, stretch).1[(1, 1)] / self.normal + 1.0;
        let stretch = root(missing, self.dilation * shear, 1e-3 * shear.abs());
        let (memory, stress) = self.stepped(shear, stretch);
        (self.memory, self.volume) = (memory, self.volume * (1.0 + stretch));
        (self.last, self.dilation) = (stress[(0, 1)] / self.normal, stretch / shear);
    }
}

pub fn simple_shear(law: &MobilisedFriction, normal: f64, fraction: f64, step: f64, end: f64) -> Vec<Row<Plane>> {
    let mut path = Shear::begin(law, normal, fraction);
    let steps = (end / step).round() as u32;
    let row = |count: u32| {
        path.step(step);
        Row { strain: step * f64::from(count), ratio: path.last, volume: path.volume, memory: path.memory }
    };
    (1..=steps).map(row).collect()
}

/// Simple shear without a change of volume.
pub fn constant_volume(law: &MobilisedFriction, pressure: f64, fraction: f64, step: f64, end: f64) -> Vec<Row<Plane>> {
    let mut memory = isotropic::<Plane>(law, pressure, fraction);
    let steps = (end / step).round() as u32;
    let row = |count: u32| {
        let stress = carry::<Plane>(law, &mut memory, &<Plane as Space>::Tensor::new(0.0, step, 0.0, 0.0));
        Row { strain: step * f64::from(count), ratio: -stress[(0, 1)] / stress[(1, 1)], volume: 1.0, memory }
    };
    (1..=steps).map(row).collect()
}

/// Pressed along x under a constant stress across.
pub fn triaxial_compression(
    law: &MobilisedFriction,
    across: f64,
    fraction: f64,
    step: f64,
    end: f64,
) -> Vec<Row<Solid>> {
    let (mut memory, mut volume, mut widening) = (isotropic::<Solid>(law, across, fraction), 1.0, 0.3 * step);
    let steps = (end / step).round() as u32;
    let row = |count: u32| {
        let stepped = |wide: f64| {
            let mut after = memory;
            let mut increment = <Solid as Space>::Tensor::identity() * wide;
            increment[(0, 0)] = -step;
            let stress = carry::<Solid>(law, &mut after, &increment);
            let volume = volume * (1.0 - step) * (1.0 + wide) * (1.0 + wide);
            (after, volume, stress * (1.0 / volume))
        };
        widening = root(|wide| stepped(wide).2[(1, 1)] / across + 1.0, widening, 1e-3 * step);
        let (after, grown, stress) = stepped(widening);
        (memory, volume) = (after, grown);
        Row { strain: step * f64::from(count), ratio: -stress[(0, 0)], volume, memory }
    };
    (1..=steps).map(row).collect()
}
