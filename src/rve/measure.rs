//! What an assembly says of itself, from the forces at the end of an increment, summed over contacts in the order of ids.

use crate::base::math;
use crate::base::space::{Linear, Space};
use crate::dem::grains::Hot;
use crate::dem::sample::Sample;

/// Sums over the contacts that bear force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured<S: Space> {
    /// Love-Weber sum (Liang & Zhao 2019, eq. 30), J, tension positive: over the volume the mean stress.
    pub moment: S::Tensor,
    /// Contacts that bear.
    pub contacts: u64,
    /// Sum of the squares of their forces, N2.
    pub forces: f64,
}

/// A contact that bears, of the grain with the lower id.
pub(super) struct Touching<'a, S: Space> {
    /// Rows, which are ids.
    pub rows: [usize; 2],
    pub grains: [&'a Hot<S>; 2],
    pub force: S::Vector,
    /// From the centre of the other grain to its own, m.
    pub branch: S::Vector,
}

/// All of them in the order of ids, at the evaluation just done, whose forces have been kept.
pub(super) fn bearing<S: Space>(sample: &Sample<S>) -> impl Iterator<Item = Touching<'_, S>> {
    let (contacts, grains) = (&sample.assembly.contacts, &sample.assembly.grains);
    contacts.forces_in_order().filter_map(|(pair, force)| {
        let [a, b] = [pair.a, pair.b()].map(|row| &grains.hot[row as usize]);
        let branch = || a.position - b.position + contacts.shift(pair).0;
        let rows = [pair.a as usize, pair.b() as usize];
        (force != S::Vector::zero()).then(|| Touching { rows, grains: [a, b], force, branch: branch() })
    })
}

impl<S: Space> Measured<S> {
    /// At the evaluation just done, whose forces have been kept.
    pub fn of(sample: &Sample<S>) -> Self {
        let (contacts, hot) = (&sample.assembly.contacts, &sample.assembly.grains.hot);
        let mut sums = Self { moment: S::Tensor::zero(), contacts: 0, forces: 0.0 };
        // Pairs that bear nothing add nothing: which do is not to be foreseen, and asked in every increment.
        for (pair, force) in contacts.forces_in_order() {
            let branch = hot[pair.a as usize].position - hot[pair.b() as usize].position + contacts.shift(pair).0;
            sums.moment -= S::outer(&force, &branch);
            sums.contacts += u64::from(force != S::Vector::zero());
            sums.forces += force.dot(&force);
        }
        sums
    }

    /// I_uf: root mean square of what is out of balance on grains over that of the forces of contacts (Liu et al. 2016, eq. 57); none
    /// without contacts.
    pub fn unbalanced(&self, sample: &Sample<S>) -> Option<f64> {
        let grains = &sample.assembly.grains;
        let squares: f64 = grains.force.iter().map(|force| force.dot(force)).sum();
        let (nets, forces) = (squares / grains.owned as f64, self.forces / self.contacts as f64);
        (self.contacts > 0).then(|| (nets / forces).sqrt())
    }
}

/// Sum of k b (x) b over contacts that bear, J, k being the stiffest spring of each: over the volume no less than what the stress along
/// any direction answers to a strain along it while grains move with the mean field (the affine stiffness, as [`crate::dem::strained`] has
/// it along the axes), and so a bound on the P-wave modulus. At the evaluation just done, whose forces have been kept.
pub fn affine_stiffness<S: Space>(sample: &Sample<S>) -> S::Tensor {
    let law = sample.constants.law();
    bearing(sample).fold(S::Tensor::zero(), |sum, Touching { grains: [a, b], branch, .. }| {
        let overlap = a.radius + b.radius - branch.norm();
        let springs = law.stiffness([a.radius, b.radius], [a.mass, b.mass], overlap);
        sum + S::outer(&branch, &branch) * springs.stiffest()
    })
}

/// Fabric and coordination.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fabric<S: Space> {
    /// Mean of n (x) n over contacts that bear (Liang & Zhao 2019, eq. 41).
    pub tensor: S::Tensor,
    /// Contacts of a grain on average.
    pub coordination: f64,
    /// The mechanical one (Thornton 2000), (2 C - N_1)/(N - N_0 - N_1): without grains that have none or one.
    pub mechanical: f64,
}

impl<S: Space> Fabric<S> {
    /// Of grains that do not touch.
    pub fn none() -> Self {
        Self { tensor: S::Tensor::zero(), coordination: 0.0, mechanical: 0.0 }
    }

    /// At the evaluation just done, whose forces have been kept.
    pub fn of(sample: &Sample<S>) -> Self {
        let mut own = vec![0u32; sample.assembly.grains.owned];
        let (tensor, count) =
            bearing(sample).fold((S::Tensor::zero(), 0u64), |(sum, count), Touching { rows, branch, .. }| {
                rows.iter().for_each(|row| own[*row] += 1);
                let normal = branch * (1.0 / branch.norm());
                (sum + S::outer(&normal, &normal), count + 1)
            });
        let [none, one] = [0, 1].map(|wanted| own.iter().filter(|own| **own == wanted).count());
        let owned = own.len() as f64;
        let share = |part: f64, of: f64| if of > 0.0 { part / of } else { 0.0 };
        Self {
            tensor: tensor * share(1.0, count as f64),
            coordination: share(2.0 * count as f64, owned),
            mechanical: share(2.0 * count as f64 - one as f64, owned - (none + one) as f64),
        }
    }

    /// In the plane the angle from x, -pi/2 to pi/2, about which most contacts point, rad; 0 in space.
    pub fn direction(&self) -> f64 {
        match S::DIMENSION {
            2 => 0.5 * math::atan2(self.tensor[1] + self.tensor[2], self.tensor[0] - self.tensor[3]),
            _ => 0.0,
        }
    }

    /// sqrt(F_a:F_a/2) of F_a = D (D + 2)/2 (phi - I/D), which is 4 (phi - I/2) in the plane (Liang & Zhao 2019, eq. 42 and 43).
    pub fn anisotropy(&self) -> f64 {
        if self.coordination == 0.0 {
            return 0.0;
        }
        let axes = S::DIMENSION as f64;
        let deviator = self.tensor - S::identity() * (S::trace(&self.tensor) / axes);
        let anisotropic = deviator * (0.5 * axes * (axes + 2.0));
        (0.5 * anisotropic.dot(&anisotropic)).sqrt()
    }
}
