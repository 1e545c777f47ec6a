//! Critical-state Drucker-Prager plasticity with Hencky elasticity: in plane strain that of Chen et al. (2021), section
//! 2.2, and its counterpart in space.
//!
//! Tension positive; tau is the Kirchhoff stress, eps = ln(b_e)/2 the elastic logarithmic strain, d the dimension.
//!
//! ```text
//! tau = K tr(eps) I + 2 G dev(eps)                                                              (4)
//! p = tr(tau)/d,  q = sqrt(J2),  f = q + eta p - zeta c,  g = q + etabar p                      (5, 6)
//! in the plane  eta = sin(phi),        zeta = cos(phi),        etabar = sin(psi)
//! in space      eta = 6 sin(phi)/n,    zeta = 6 cos(phi)/n,    n = sqrt(3) (3 - sin(phi)),
//!               etabar = 6 sin(psi)/(sqrt(3) (3 - sin(psi)))
//! tan(psi) = tan(psi_0) + chi (Phi - Phi_cs),  tan(phi) = tan(phi_cs) + chi (Phi - Phi_cs)      (7)
//! dPhi/dt = -(Phi - Phi_cs) Phi xi |deps_p/dt|                                                   (8)
//! ```
//!
//! In the plane the cone is Mohr-Coulomb's wedge itself, flow has no part across the plane, and the stress there is
//! `(K - G) tr(eps)`, between the other two. In space the cone goes through the edges of Mohr-Coulomb's pyramid where it
//! is compressed triaxially; it is stronger than the pyramid elsewhere, for instance in plane strain, where without
//! dilation it comes to bear what the plane's law does of `sin(phi_plane) = eta`.
//! psi_0 is 0 in the paper. With chi = 0 friction and dilation are constant: Mohr-Coulomb (Drucker-Prager in space) with
//! phi_cs, psi_0 and c; with phi_cs = 0 as well, a cohesive material (Tresca's in the plane) that has no apex.
//!
//! In Hencky strain the return is closed form. f is linear in (q, p), and plastic flow moves q by -G dlambda and p by
//! -K etabar dlambda, so `dlambda = f_trial/(G + K eta etabar)`; a loose material needs that to be positive. Where that
//! would carry q below zero the stress returns to the apex of the cone, `q = 0, p = zeta c/eta` (stress free without
//! cohesion). Expansion beyond the apex opens a gap, remembered as volume strain, and must be closed before the material
//! bears pressure again.
//! |deps_p| is the Frobenius norm: `dlambda sqrt(1/2 + etabar^2/d)` on the cone. The memory is
//! `b_e - I`, which keeps the digits of small strains and needs no exponential in an elastic step.

use super::hencky::{isotropic_strain, isotropic_stress, p_wave_modulus};
use super::{MaterialLaw, MaterialMemory};
use crate::math;
use crate::record::{Record, Visitor};
use crate::scenario;
use crate::space::Space;
use crate::symmetric::Symmetric;

/// The law with its constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalDruckerPrager {
    /// K, Pa.
    pub bulk_modulus: f64,
    /// G, Pa.
    pub shear_modulus: f64,
    /// tan(phi_cs).
    pub friction_critical: f64,
    /// Phi_cs.
    pub fraction_critical: f64,
    /// chi.
    pub dilation_factor: f64,
    /// Constant part of tan(psi), without a part in tan(phi); 0 in the critical-state law.
    pub dilation: f64,
    /// xi.
    pub softening_rate: f64,
    /// c, Pa.
    pub cohesion: f64,
}

/// State of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalMemory<S: Space> {
    /// Elastic strain `b_e - I`.
    pub strain: S::Symmetric,
    /// Phi.
    pub fraction: f64,
    /// Integral of |deps_p/dt|.
    pub plastic_strain: f64,
    /// Volume strain gained by separation and not yet closed, >= 0.
    pub gap: f64,
}

impl<S: Space> Default for CriticalMemory<S> {
    fn default() -> Self {
        Self { strain: S::Symmetric::isotropic(0.0), fraction: 0.0, plastic_strain: 0.0, gap: 0.0 }
    }
}

impl<S: Space> Record for CriticalMemory<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("strain", self.strain.as_mut_slice());
        visitor.f64s("fraction", std::slice::from_mut(&mut self.fraction));
        visitor.f64s("plastic_strain", std::slice::from_mut(&mut self.plastic_strain));
        visitor.f64s("gap", std::slice::from_mut(&mut self.gap));
    }
}

impl<S: Space> MaterialMemory for CriticalMemory<S> {
    fn plastic_strain(&self) -> f64 {
        self.plastic_strain
    }
    fn fraction(&self) -> f64 {
        self.fraction
    }
}

/// Friction and dilation at a packing fraction, equation (7).
#[derive(Clone, Copy, Debug)]
struct Cone {
    eta: f64,
    eta_bar: f64,
    zeta: f64,
}

/// Invariants of an elastic logarithmic strain: all that the return needs.
#[derive(Clone, Copy, Debug)]
struct Measures {
    /// tr(eps).
    volume: f64,
    /// sqrt(dev(eps):dev(eps)/2) >= 0; in the plane half of the difference of the principal strains.
    shear: f64,
}

/// What the return makes of a trial strain.
#[derive(Clone, Copy, Debug)]
struct Return {
    strain: Measures,
    /// |deps_p|.
    plastic: f64,
    /// Volume strain beyond the apex.
    opened: f64,
    /// tau:deps_p with the returned stress, J/m3.
    work: f64,
}

/// A logarithmic strain, taken apart.
#[derive(Clone, Copy, Debug)]
struct Parts<S: Space> {
    measures: Measures,
    deviator: S::Symmetric,
}

impl<S: Space> Parts<S> {
    #[inline(always)]
    fn of(strain: &S::Symmetric) -> Self {
        let deviator = strain.deviator();
        let measures = Measures { volume: strain.trace(), shear: (0.5 * deviator.square()).sqrt() };
        Self { measures, deviator }
    }

    /// The strain with other invariants.
    #[inline(always)]
    fn after(&self, returned: &Return) -> S::Symmetric {
        let Measures { volume, shear } = returned.strain;
        let isotropic = S::Symmetric::isotropic(volume / S::DIMENSION as f64);
        if shear > 0.0 { self.deviator * (shear / self.measures.shear) + isotropic } else { isotropic }
    }
}

impl CriticalDruckerPrager {
    pub fn of_job(law: &scenario::mpm::CriticalDruckerPrager) -> Self {
        // A constant dilation takes the place of chi's.
        let (factor, dilation) = match law.dilation_angle {
            Some(angle) => (0.0, math::tan(angle)),
            None => (law.dilation_factor, 0.0),
        };
        Self {
            bulk_modulus: law.bulk_modulus,
            shear_modulus: law.shear_modulus,
            friction_critical: math::tan(law.friction_angle_critical),
            fraction_critical: law.fraction_critical,
            dilation_factor: factor,
            dilation,
            softening_rate: law.softening_rate,
            cohesion: law.cohesion,
        }
    }

    pub fn new(continuum: &scenario::Continuum) -> Self {
        Self {
            bulk_modulus: continuum.bulk_modulus,
            shear_modulus: continuum.shear_modulus,
            friction_critical: math::tan(continuum.friction_angle_critical),
            fraction_critical: continuum.fraction_critical,
            dilation_factor: continuum.dilation_factor,
            dilation: 0.0,
            softening_rate: continuum.softening_rate,
            cohesion: continuum.cohesion,
        }
    }

    /// In space the cone through the corners of triaxial compression of the Mohr-Coulomb pyramid, which the plane's is.
    #[inline(always)]
    fn cone<S: Space>(&self, fraction: f64) -> Cone {
        let change = self.dilation_factor * (fraction - self.fraction_critical);
        let (tan_psi, tan_phi) = (self.dilation + change, (self.friction_critical + change).max(0.0));
        let zeta = 1.0 / (1.0 + tan_phi * tan_phi).sqrt();
        let (eta, eta_bar) = (tan_phi * zeta, tan_psi / (1.0 + tan_psi * tan_psi).sqrt());
        if S::DIMENSION == 2 {
            return Cone { eta, eta_bar, zeta };
        }
        // 6/sqrt(3).
        let factor = 3.464_101_615_137_754_6;
        let (friction, dilation) = (factor / (3.0 - eta), factor / (3.0 - eta_bar));
        Cone { eta: eta * friction, eta_bar: eta_bar * dilation, zeta: zeta * friction }
    }

    /// Packing fraction after plastic flow, equation (8).
    fn softened(&self, fraction: f64, plastic: f64) -> f64 {
        fraction - (fraction - self.fraction_critical) * fraction * self.softening_rate * plastic
    }

    #[inline(always)]
    fn return_to_cone<S: Space>(&self, cone: &Cone, trial: Measures) -> Return {
        let share = 2.0 / S::DIMENSION as f64;
        let (bulk, shear) = (self.bulk_modulus, self.shear_modulus);
        let pressure = bulk * trial.volume;
        let q = 2.0 * shear * trial.shear;
        let excess = q + cone.eta * pressure - cone.zeta * self.cohesion;
        if excess <= 0.0 {
            return Return { strain: trial, plastic: 0.0, opened: 0.0, work: 0.0 };
        }
        let multiplier = excess / (shear + bulk * cone.eta * cone.eta_bar);
        let q_returned = q - shear * multiplier;
        if q_returned >= 0.0 || cone.eta == 0.0 {
            let q_returned = q_returned.max(0.0);
            let volume = trial.volume - cone.eta_bar * multiplier;
            return Return {
                strain: Measures { volume, shear: q_returned / (2.0 * shear) },
                plastic: multiplier * (0.5 * (1.0 + share * cone.eta_bar * cone.eta_bar)).sqrt(),
                opened: 0.0,
                work: multiplier * (q_returned + cone.eta_bar * (bulk * volume)),
            };
        }
        let apex = cone.zeta * self.cohesion / (cone.eta * bulk);
        let opened = trial.volume - apex;
        let plastic = (2.0 * trial.shear * trial.shear + 0.5 * share * opened * opened).sqrt();
        let strain = Measures { volume: apex, shear: 0.0 };
        Return { strain, plastic, opened, work: bulk * apex * opened }
    }
}

impl<S: Space> MaterialLaw<S> for CriticalDruckerPrager {
    type Memory = CriticalMemory<S>;

    fn start(&self, stress: &S::Tensor, fraction: f64) -> CriticalMemory<S> {
        let strain = isotropic_strain(self.bulk_modulus, self.shear_modulus, &S::Symmetric::of(stress));
        let trial = Parts::<S>::of(&strain);
        let returned = self.return_to_cone::<S>(&self.cone::<S>(fraction), trial.measures);
        let strain = if returned.plastic > 0.0 { trial.after(&returned) } else { strain };
        CriticalMemory { strain: (strain * 2.0).exponential(), fraction, plastic_strain: 0.0, gap: 0.0 }
    }

    #[inline(always)]
    fn update_counted(
        &self,
        gradient: &S::Tensor,
        dt: f64,
        memory: &mut CriticalMemory<S>,
        work: &mut f64,
    ) -> S::Tensor {
        let (bulk, shear) = (self.bulk_modulus, self.shear_modulus);
        memory.strain = memory.strain.pushed(&(*gradient * dt));
        let mut strain = memory.strain.half_logarithm();

        let separated = memory.gap > 0.0;
        if separated {
            // Separated grains bear nothing until the gap is closed.
            let left = memory.gap + strain.trace();
            memory.gap = left.max(0.0);
            strain = S::Symmetric::isotropic(left.min(0.0) / S::DIMENSION as f64);
        }
        let trial = Parts::<S>::of(&strain);
        let returned = self.return_to_cone::<S>(&self.cone::<S>(memory.fraction), trial.measures);
        if returned.plastic > 0.0 {
            strain = trial.after(&returned);
            *work += returned.work;
            memory.gap += returned.opened.max(0.0);
            memory.plastic_strain += returned.plastic;
            memory.fraction = self.softened(memory.fraction, returned.plastic);
        }
        if separated || returned.plastic > 0.0 {
            memory.strain = (strain * 2.0).exponential();
        }
        isotropic_stress(bulk, shear, &strain).tensor()
    }

    fn stress(&self, memory: &CriticalMemory<S>) -> S::Tensor {
        isotropic_stress(self.bulk_modulus, self.shear_modulus, &memory.strain.half_logarithm()).tensor()
    }

    /// Elastic strain and flow have no part along the normal of the plane: `(K - G) tr(eps)`.
    fn out_of_plane(&self, memory: &CriticalMemory<S>) -> f64 {
        match S::DIMENSION {
            2 => (self.bulk_modulus - self.shear_modulus) * memory.strain.half_logarithm().trace(),
            _ => 0.0,
        }
    }

    fn elastic_energy(&self, memory: &CriticalMemory<S>) -> f64 {
        let Measures { volume, shear } = Parts::<S>::of(&memory.strain.half_logarithm()).measures;
        0.5 * self.bulk_modulus * volume * volume + 2.0 * self.shear_modulus * shear * shear
    }

    fn p_wave_modulus(&self) -> f64 {
        p_wave_modulus::<S>(self.bulk_modulus, self.shear_modulus)
    }

    fn shear_modulus(&self) -> f64 {
        self.shear_modulus
    }
}
