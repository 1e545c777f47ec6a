//! What an assembly says of itself, from the forces at the end of an increment, summed over contacts in the order of ids.

use crate::base::space::{Linear, Space};
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

impl<S: Space> Measured<S> {
    /// At the evaluation just done, whose forces have been kept.
    pub fn of(sample: &Sample<S>) -> Self {
        let (contacts, grains) = (&sample.assembly.contacts, &sample.assembly.grains);
        let mut sums = Self { moment: S::Tensor::zero(), contacts: 0, forces: 0.0 };
        for row in 0..grains.owned {
            for term in contacts.neighbours.terms_of(row).iter().filter(|term| !term.is_b()) {
                let force = contacts.force_of(term.pair());
                if force == S::Vector::zero() {
                    continue;
                }
                let pair = &contacts.neighbours.pairs[term.pair()];
                let [a, b] = [pair.a, pair.b()].map(|row| &grains.hot[row as usize]);
                let branch = a.position - b.position + contacts.shift(pair).0;
                sums.moment -= S::outer(&force, &branch);
                sums.contacts += 1;
                sums.forces += force.dot(&force);
            }
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

/// Sum of k b (x) b over contacts that bear, J, k being the stiffest spring of each: over the volume no less than what the stress along any
/// direction answers to
/// a strain along it while grains move with the mean field (the affine stiffness), and so a bound on the P-wave modulus. At the evaluation
/// just done, whose forces have been kept.
pub fn affine_stiffness<S: Space>(sample: &Sample<S>) -> S::Tensor {
    let (law, contacts, grains) = (sample.constants.law(), &sample.assembly.contacts, &sample.assembly.grains);
    let mut sum = S::Tensor::zero();
    for row in 0..grains.owned {
        for term in contacts.neighbours.terms_of(row).iter().filter(|term| !term.is_b()) {
            if contacts.force_of(term.pair()) == S::Vector::zero() {
                continue;
            }
            let pair = &contacts.neighbours.pairs[term.pair()];
            let [a, b] = [pair.a, pair.b()].map(|row| &grains.hot[row as usize]);
            let branch = a.position - b.position + contacts.shift(pair).0;
            let overlap = a.radius + b.radius - branch.norm();
            let springs = law.stiffness([a.radius, b.radius], [a.mass, b.mass], overlap);
            sum += S::outer(&branch, &branch) * springs.stiffest();
        }
    }
    sum
}

/// Fabric and coordination.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fabric<S: Space> {
    /// Mean of n (x) n over contacts that bear (Liang & Zhao 2019, eq. 41).
    pub tensor: S::Tensor,
    /// Contacts of a grain on average.
    pub coordination: f64,
    /// The same of grains that have two or more, of contacts among which those of others do not count: the mechanical one (Thornton 2000).
    pub mechanical: f64,
}

impl<S: Space> Fabric<S> {
    /// Of grains that do not touch.
    pub fn none() -> Self {
        Self { tensor: S::Tensor::zero(), coordination: 0.0, mechanical: 0.0 }
    }

    /// At the evaluation just done, whose forces have been kept.
    pub fn of(sample: &Sample<S>) -> Self {
        let (contacts, grains) = (&sample.assembly.contacts, &sample.assembly.grains);
        let (mut tensor, mut count) = (S::Tensor::zero(), 0u64);
        let (mut none, mut one) = (0u64, 0u64);
        for row in 0..grains.owned {
            let mut own = 0u64;
            for term in contacts.neighbours.terms_of(row) {
                if contacts.force_of(term.pair()) == S::Vector::zero() {
                    continue;
                }
                own += 1;
                if !term.is_b() {
                    let pair = &contacts.neighbours.pairs[term.pair()];
                    let [a, b] = [pair.a, pair.b()].map(|row| &grains.hot[row as usize]);
                    let branch = a.position - b.position + contacts.shift(pair).0;
                    let normal = branch * (1.0 / branch.norm());
                    tensor += S::outer(&normal, &normal);
                    count += 1;
                }
            }
            none += u64::from(own == 0);
            one += u64::from(own == 1);
        }
        let owned = grains.owned as f64;
        let share = |part: f64, of: f64| if of > 0.0 { part / of } else { 0.0 };
        Self {
            tensor: tensor * share(1.0, count as f64),
            coordination: share(2.0 * count as f64, owned),
            mechanical: share(2.0 * count as f64 - one as f64, owned - (none + one) as f64),
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
