//! Critical-state Drucker-Prager plasticity with Hencky elasticity in plane strain: Chen et al. (2021), section 2.2.
//!
//! Tension positive; tau is the Kirchhoff stress, eps = ln(b_e)/2 the elastic logarithmic strain.
//!
//! ```text
//! tau = K tr(eps) I + 2 G dev(eps)                                                              (4)
//! p = tr(tau)/2,  q = sqrt(J2),  f = q + eta p - zeta c,  g = q + etabar p                      (5, 6)
//! eta = sin(phi), zeta = cos(phi), etabar = sin(psi)
//! tan(psi) = chi (Phi - Phi_cs),  tan(phi) = tan(phi_cs) + tan(psi)                              (7)
//! dPhi/dt = -(Phi - Phi_cs) Phi xi |deps_p/dt|                                                   (8)
//! ```
//!
//! In Hencky strain the return is closed form. f is linear in (q, p), and plastic flow moves q by -G dlambda and p by
//! -K etabar dlambda, so `dlambda = f_trial/(G + K eta etabar)`. Where that would carry q below zero the stress returns
//! to the apex of the cone, `q = 0, p = zeta c/eta` (stress free without cohesion). Expansion beyond the apex opens a
//! gap, remembered as volume strain, and must be closed before the material bears pressure again.
//! |deps_p| is the Frobenius norm: `dlambda sqrt((1 + etabar^2)/2)` on the cone.

use super::{MaterialLaw, MaterialMemory};
use crate::math;
use crate::record::{Record, Visitor};
use crate::scenario;
use crate::space::{Plane, Space};

type Tensor = <Plane as Space>::Tensor;

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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CriticalMemory {
    /// Elastic left Cauchy-Green strain b_e: xx, yy, xy.
    pub elastic: [f64; 3],
    /// Phi.
    pub fraction: f64,
    /// Integral of |deps_p/dt|.
    pub plastic_strain: f64,
    /// Volume strain gained by separation and not yet closed, >= 0.
    pub gap: f64,
}

impl Record for CriticalMemory {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("elastic", &mut self.elastic);
        visitor.f64s("fraction", std::slice::from_mut(&mut self.fraction));
        visitor.f64s("plastic_strain", std::slice::from_mut(&mut self.plastic_strain));
        visitor.f64s("gap", std::slice::from_mut(&mut self.gap));
    }
}

impl MaterialMemory for CriticalMemory {
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
    at_apex: bool,
    /// |deps_p|.
    plastic: f64,
    /// Volume strain beyond the apex.
    opened: f64,
    /// tau:deps_p with the returned stress, J/m3.
    work: f64,
}

/// Logarithmic strain ln(b)/2 of a symmetric tensor by its invariants, without eigenvectors.
#[derive(Clone, Copy, Debug)]
struct Hencky {
    measures: Measures,
    /// Unit direction of the deviator, (xx - yy)/2 and xy; zero where there is none.
    direction: [f64; 2],
}

impl Hencky {
    fn of(elastic: &[f64; 3]) -> Self {
        let mean = 0.5 * (elastic[0] + elastic[1]);
        let deviator = [0.5 * (elastic[0] - elastic[1]), elastic[2]];
        let radius = (deviator[0] * deviator[0] + deviator[1] * deviator[1]).sqrt();
        let (major, minor) = (math::ln(mean + radius), math::ln(mean - radius));
        let direction = if radius > 0.0 { [deviator[0] / radius, deviator[1] / radius] } else { [0.0, 0.0] };
        let measures = Measures { volume: 0.5 * (major + minor), shear: 0.25 * (major - minor) };
        Self { measures, direction }
    }

    /// Volume strain alone.
    fn isotropic(volume: f64) -> Self {
        Self { measures: Measures { volume, shear: 0.0 }, direction: [0.0, 0.0] }
    }

    fn after(self, returned: &Return) -> Self {
        if returned.at_apex {
            return Self::isotropic(returned.strain.volume);
        }
        Self { measures: returned.strain, ..self }
    }

    fn to_elastic(self) -> [f64; 3] {
        let Measures { volume, shear } = self.measures;
        let major = math::exp(volume + 2.0 * shear);
        let minor = math::exp(volume - 2.0 * shear);
        let (mean, radius) = (0.5 * (major + minor), 0.5 * (major - minor));
        [mean + radius * self.direction[0], mean - radius * self.direction[0], radius * self.direction[1]]
    }
}

impl CriticalDruckerPrager {
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

    fn cone(&self, fraction: f64) -> Cone {
        let change = self.dilation_factor * (fraction - self.fraction_critical);
        let (tan_psi, tan_phi) = (self.dilation + change, (self.friction_critical + change).max(0.0));
        let zeta = 1.0 / (1.0 + tan_phi * tan_phi).sqrt();
        Cone { eta: tan_phi * zeta, eta_bar: tan_psi / (1.0 + tan_psi * tan_psi).sqrt(), zeta }
    }

    /// Packing fraction after plastic flow, equation (8).
    fn softened(&self, fraction: f64, plastic: f64) -> f64 {
        fraction - (fraction - self.fraction_critical) * fraction * self.softening_rate * plastic
    }

    /// `share` is 2/d: 1 in the plane, 2/3 in space.
    fn return_to_cone(&self, cone: &Cone, share: f64, trial: Measures) -> Return {
        let (bulk, shear) = (self.bulk_modulus, self.shear_modulus);
        let pressure = bulk * trial.volume;
        let q = 2.0 * shear * trial.shear;
        let excess = q + cone.eta * pressure - cone.zeta * self.cohesion;
        if excess <= 0.0 {
            return Return { strain: trial, at_apex: false, plastic: 0.0, opened: 0.0, work: 0.0 };
        }
        let multiplier = excess / (shear + bulk * cone.eta * cone.eta_bar);
        let q_returned = q - shear * multiplier;
        if q_returned >= 0.0 || cone.eta == 0.0 {
            let q_returned = q_returned.max(0.0);
            let volume = trial.volume - cone.eta_bar * multiplier;
            return Return {
                strain: Measures { volume, shear: q_returned / (2.0 * shear) },
                at_apex: false,
                plastic: multiplier * (0.5 * (1.0 + share * cone.eta_bar * cone.eta_bar)).sqrt(),
                opened: 0.0,
                work: multiplier * (q_returned + cone.eta_bar * (bulk * volume)),
            };
        }
        let apex = cone.zeta * self.cohesion / (cone.eta * bulk);
        let opened = trial.volume - apex;
        let plastic = (2.0 * trial.shear * trial.shear + 0.5 * share * opened * opened).sqrt();
        let strain = Measures { volume: apex, shear: 0.0 };
        Return { strain, at_apex: true, plastic, opened, work: bulk * apex * opened }
    }

    fn kirchhoff(&self, strain: &Hencky) -> Tensor {
        let pressure = self.bulk_modulus * strain.measures.volume;
        let q = 2.0 * self.shear_modulus * strain.measures.shear;
        let (x, xy) = (q * strain.direction[0], q * strain.direction[1]);
        Tensor::new(pressure + x, xy, xy, pressure - x)
    }
}

impl MaterialLaw<Plane> for CriticalDruckerPrager {
    type Memory = CriticalMemory;

    fn start(&self, stress: &Tensor, fraction: f64) -> CriticalMemory {
        let half = 0.5 * (stress[(0, 0)] - stress[(1, 1)]);
        let off = 0.5 * (stress[(0, 1)] + stress[(1, 0)]);
        let q = (half * half + off * off).sqrt();
        let volume = 0.5 * (stress[(0, 0)] + stress[(1, 1)]) / self.bulk_modulus;
        let direction = if q > 0.0 { [half / q, off / q] } else { [0.0, 0.0] };
        let strain = Hencky { measures: Measures { volume, shear: q / (2.0 * self.shear_modulus) }, direction };
        let returned = self.return_to_cone(&self.cone(fraction), 1.0, strain.measures);
        CriticalMemory { elastic: strain.after(&returned).to_elastic(), fraction, plastic_strain: 0.0, gap: 0.0 }
    }

    fn update_counted(&self, gradient: &Tensor, dt: f64, memory: &mut CriticalMemory, work: &mut f64) -> Tensor {
        let step = Plane::identity() + gradient * dt;
        let [xx, yy, xy] = memory.elastic;
        let trial = step * Tensor::new(xx, xy, xy, yy) * step.transpose();
        let mut strain = Hencky::of(&[trial[(0, 0)], trial[(1, 1)], 0.5 * (trial[(0, 1)] + trial[(1, 0)])]);

        if memory.gap > 0.0 {
            // Separated grains bear nothing until the gap is closed.
            let left = memory.gap + strain.measures.volume;
            memory.gap = left.max(0.0);
            strain = Hencky::isotropic(left.min(0.0));
        }
        let cone = self.cone(memory.fraction);
        let returned = self.return_to_cone(&cone, 1.0, strain.measures);
        *work += returned.work;
        memory.gap += returned.opened.max(0.0);
        memory.plastic_strain += returned.plastic;
        memory.fraction = self.softened(memory.fraction, returned.plastic);
        let strain = strain.after(&returned);
        memory.elastic = strain.to_elastic();
        self.kirchhoff(&strain)
    }

    fn stress(&self, memory: &CriticalMemory) -> Tensor {
        self.kirchhoff(&Hencky::of(&memory.elastic))
    }

    /// Elastic strain and flow have no part along the normal: `(K - G) tr(eps)`.
    fn out_of_plane(&self, memory: &CriticalMemory) -> f64 {
        (self.bulk_modulus - self.shear_modulus) * Hencky::of(&memory.elastic).measures.volume
    }

    fn elastic_energy(&self, memory: &CriticalMemory) -> f64 {
        let Measures { volume, shear } = Hencky::of(&memory.elastic).measures;
        0.5 * self.bulk_modulus * volume * volume + 2.0 * self.shear_modulus * shear * shear
    }

    fn p_wave_modulus(&self) -> f64 {
        self.bulk_modulus + self.shear_modulus
    }

    fn shear_modulus(&self) -> f64 {
        self.shear_modulus
    }
}
