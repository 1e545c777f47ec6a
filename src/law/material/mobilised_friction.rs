//! Drucker-Prager plasticity whose friction is mobilised by plastic shear, with a shear modulus that falls on the way:
//! hardening of the kind of Vermeer (1978) and of Schanz, Vermeer and Bonnier (1999), Taylor's (1948) stress-dilatancy
//! about a line of phase transformation that follows the solid volume fraction (Manzari and Dafalias 1997), Hencky
//! elasticity. In plane strain and in space.
//!
//! Tension positive; tau is the Kirchhoff stress, eps = ln(b_e)/2 the elastic logarithmic strain, d the dimension, Phi
//! the solid volume fraction. g is the plastic shear since loading began, s all of it, both engineering shear strains:
//! dg is twice the plastic change of h.
//!
//! ```text
//! tau = K tr(eps) I + 2 G dev(eps)
//! P = C - tr(tau)/d,  q = sqrt(J2) = 2 G h,  h = sqrt(dev(eps):dev(eps)/2)
//! q <= m P,  m = m_b kappa,  kappa = kappa_0 + (1 - kappa_0) g/(a + g)                          mobilised friction
//! a = a_cs (1 - x/sqrt(1 + x^2)),  x = (Phi - Phi_cs)/w                                        strain of hardening
//! m_b = M(sin(phi_b)),  tan(phi_b) = tan(phi_cs) + chi max(Phi - Phi_cs, 0)                    peak friction
//! m_d = M(sin(phi_d)),  sin(phi_d) = sin(phi_cs) - k_d (Phi - Phi_cs), within 0 and 2 sin(phi_cs) and 1
//! D = m - m_d,  dV = D dg,  V = tr(eps_p)                                                      stress-dilatancy
//! dPhi = -Phi dV                                                                               mass
//! G = G_0 (1 - r s/(a_G + s)),  s = sqrt(2) (integral of |deps_p/dt|)                          degradation
//! in the plane M(x) = x,  in space M(x) = 6 x/(sqrt(3) (3 - x))
//! ```
//!
//! Below the line of phase transformation material contracts as it is sheared, above it dilates; where both lines meet,
//! at Phi_cs, is the critical state `q = M(sin(phi_cs)) P`, which every Phi comes to. Phi follows plastic volume alone,
//! so that solid is neither made nor lost. In space both lines, and with them D, are those of the same angles in
//! triaxial compression, where the cone goes through the edges of Mohr-Coulomb's pyramid; the critical state is one
//! there because both angles are phi_cs. K of the plane is the plane's, flow has no part across it, and the stress
//! there is `(K - G) tr(eps)`.
//!
//! Loose material mobilises its friction over a longer strain than dense: a is a_cs at Phi_cs, less above it, and up to
//! twice that below, within some w. Without w it is a_cs at any Phi. An exponential of x would also grow without bound in
//! loose material, and follows tests of discs less well.
//!
//! kappa_0 is the elastic range: within that share of the peak friction nothing flows. Without it loose material is too
//! soft at the first strains, for friction rises from nothing.
//!
//! Cohesion c is an attraction, `C = c cot(phi_cs)`: it shifts P and leaves angles alone. The apex is `q = 0, p = C`,
//! and in the critical state the cone is `q = M(sin(phi_cs)) (c cot(phi_cs) - p)`, Mohr-Coulomb's. Where the mean
//! stress pulls (P < C) nothing contracts plastically, and contraction ends where it stops pressing: it would take work
//! from the stress.
//!
//! **Return.** With m_b, a and D of the start of the step the hardening is exact. Along flow by Delta,
//! `q - G_e Delta = m_b (g + Delta)/(a + g + Delta) (P + K D Delta)`, where g stands for `g + kappa_0 a` and a for
//! `(1 - kappa_0) a`, and `G_e = G + 2 h G_0 r a_G/(a_G + s)^2 (ds/dg)` also has what q loses by the modulus; cleared of
//! the fraction,
//!
//! ```text
//! A Delta^2 - B Delta - F = 0,  A = G_e + m_b K D,  B = q - G_e (a + g) - m_b (P + g K D),  F = q (a + g) - m_b g P
//! ```
//!
//! with one positive root where F > 0 and A > 0. As D >= -m_d, it is the only one wherever `G_0 (1 - r) > K m_b m_d`,
//! which jobs are held to ([`MobilisedConstants::stiffness_least`]). Where the root would carry P below zero the stress
//! returns to the apex, and what is expanded beyond opens a gap, as in [`super::CriticalDruckerPrager`].
//!
//! **Unloading** is elastic with the modulus as it is. Strain is what is remembered, not stress: when G falls q falls
//! with it, and the energy `2 (G_before - G) h^2` is dissipated beside `tau:deps_p`; a stress that was kept would make
//! energy. A new loading begins where q/P falls below half of the mobilised m: g is at most what mobilises `2 q/P`.
//! Small cycles leave g alone and are elastic; after a reversal, or out of stress, friction is mobilised again from
//! nothing. Half, because a cone that follows the stress itself ratchets under small cycles.
//!
//! |deps_p| is the Frobenius norm, `Delta sqrt(1/2 + D^2/d)` on the cone. The memory is that of the critical-state law
//! and g.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use super::hencky::{isotropic_strain, p_wave_modulus};
use super::measures::{Measures, Parts};
use super::{Flow, MaterialLaw, MaterialMemory, alone, share_of_strength};
use crate::base::lane::Real;
use crate::base::math;
use crate::base::record::{Record, Visitor};
use crate::base::space::{Space, Words};
use crate::base::symmetric::Symmetric;
use crate::numbers;

mod constants;
#[cfg(test)]
mod tests;
pub use constants::MobilisedConstants;

/// The share of the mobilised m that q/P must fall below for a new loading to begin.
pub const RELOADING_SHARE: f64 = 0.5;
/// The largest share of m_b that a stress may have mobilised at the start; g is infinite at one.
const MOBILISED_MOST: f64 = 1.0 - 1e-9;

/// The law with its constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MobilisedFriction {
    /// K, Pa.
    pub bulk_modulus: f64,
    /// G_0, Pa.
    pub shear_modulus: f64,
    /// r, the share of G_0 that is lost in the end.
    pub shear_degradation: f64,
    /// a_G.
    pub shear_degradation_strain: f64,
    /// tan(phi_cs).
    pub friction_critical: f64,
    /// Phi_cs.
    pub fraction_critical: f64,
    /// chi.
    pub dilation_factor: f64,
    /// a_cs.
    pub hardening_strain: f64,
    /// 1/w; 0 where a is a_cs at any Phi.
    pub hardening_sharpness: f64,
    /// kappa_0.
    pub hardening_start: f64,
    /// k_d.
    pub phase_transformation_factor: f64,
    /// C = c cot(phi_cs), Pa.
    pub attraction: f64,
    /// sin(phi_cs).
    sine_critical: f64,
}

/// State of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct MobilisedMemory<S: Space> {
    /// Elastic strain `b_e - I`.
    pub strain: S::Symmetric,
    /// Phi.
    pub fraction: f64,
    /// Integral of |deps_p/dt|.
    pub plastic_strain: f64,
    /// Volume strain gained by separation and not yet closed, >= 0.
    pub gap: f64,
    /// g, plastic shear since loading began, >= 0.
    pub hardening: f64,
}

impl<S: Space> Default for MobilisedMemory<S> {
    fn default() -> Self {
        Self { strain: S::Symmetric::isotropic(0.0), fraction: 0.0, plastic_strain: 0.0, gap: 0.0, hardening: 0.0 }
    }
}

numbers!(impl[S: Space] MobilisedMemory[S] {
    strain: S::Symmetric,
    fraction: f64,
    plastic_strain: f64,
    gap: f64,
    hardening: f64,
});

impl<S: Space> Record for MobilisedMemory<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("strain", self.strain.as_mut_slice());
        visitor.f64s("fraction", std::slice::from_mut(&mut self.fraction));
        visitor.f64s("plastic_strain", std::slice::from_mut(&mut self.plastic_strain));
        visitor.f64s("gap", std::slice::from_mut(&mut self.gap));
        visitor.f64s("hardening", std::slice::from_mut(&mut self.hardening));
    }
}

impl<S: Space> MaterialMemory for MobilisedMemory<S> {
    fn plastic_strain(&self) -> f64 {
        self.plastic_strain
    }
    fn fraction(&self) -> f64 {
        self.fraction
    }
}

/// [`MobilisedMemory`] in lanes.
#[derive(Clone, Copy, Debug)]
struct State<R, T> {
    strain: T,
    fraction: R,
    plastic_strain: R,
    gap: R,
    hardening: R,
}

impl<R: Real, T: Symmetric<R>> State<R, T> {
    /// In the order of the fields of [`MobilisedMemory`].
    #[inline(always)]
    fn of_words(words: &[R]) -> Self {
        let rest = &words[T::COUNT..];
        let (fraction, plastic_strain, gap, hardening) = (rest[0], rest[1], rest[2], rest[3]);
        Self { strain: T::of_words(words), fraction, plastic_strain, gap, hardening }
    }

    #[inline(always)]
    fn to_words(self, words: &mut [R]) {
        self.strain.to_words(words);
        let rest = [self.fraction, self.plastic_strain, self.gap, self.hardening];
        words[T::COUNT..].copy_from_slice(&rest);
    }
}

/// State, Kirchhoff stress (Pa) and dissipated energy (J/m3) after a step.
type Stepped<R, T> = (State<R, T>, T, R);

/// What the return starts from.
#[derive(Clone, Copy, Debug)]
struct Trial<R> {
    strain: Measures<R>,
    /// m_b.
    peak: R,
    /// m_d.
    transformation: R,
    /// (1 - kappa_0) a.
    hardening_strain: R,
    /// G, Pa.
    shear_modulus: R,
    plastic_strain: R,
    /// g + kappa_0 a, so that kappa is this over the sum of both.
    hardening: R,
}

/// What it comes to; where nothing flows, the trial.
#[derive(Clone, Copy, Debug)]
struct Return<R: Real> {
    flows: R::Mask,
    strain: Measures<R>,
    shear_modulus: R,
    plastic_strain: R,
    hardening: R,
    /// Plastic volume strain, which Phi follows.
    dilated: R,
    /// Volume strain beyond the apex.
    opened: R,
    /// What was dissipated, J/m3.
    work: R,
}

impl MobilisedFriction {
    /// By the constants of a job: phi_cs as its tangent and sine, w as 1/w, c as C.
    pub fn of(law: &MobilisedConstants) -> Self {
        let tangent = math::tan(law.friction_angle_critical);
        Self {
            bulk_modulus: law.bulk_modulus,
            shear_modulus: law.shear_modulus,
            shear_degradation: law.shear_degradation,
            shear_degradation_strain: law.shear_degradation_strain,
            friction_critical: tangent,
            fraction_critical: law.fraction_critical,
            dilation_factor: law.dilation_factor,
            hardening_strain: law.hardening_strain,
            hardening_sharpness: law.hardening_fraction_width.map_or(0.0, |width| 1.0 / width),
            hardening_start: law.hardening_start,
            phase_transformation_factor: law.phase_transformation_factor,
            attraction: law.cohesion / tangent,
            sine_critical: tangent / (1.0 + tangent * tangent).sqrt(),
        }
    }

    /// M: q/P of a friction angle, by its sine.
    #[inline(always)]
    fn ratio<S: Space, R: Real>(sine: R) -> R {
        if S::DIMENSION == 2 {
            return sine;
        }
        // 6/sqrt(3).
        R::splat(3.464_101_615_137_754_6) * sine / (R::splat(3.0) - sine)
    }

    /// m_b.
    #[inline(always)]
    fn peak<S: Space, R: Real>(&self, fraction: R) -> R {
        let surplus = (fraction - R::splat(self.fraction_critical)).max(R::splat(0.0));
        let tangent = R::splat(self.friction_critical) + R::splat(self.dilation_factor) * surplus;
        Self::ratio::<S, R>(tangent / (R::splat(1.0) + tangent * tangent).sqrt())
    }

    /// m_d.
    #[inline(always)]
    fn transformation<S: Space, R: Real>(&self, fraction: R) -> R {
        let surplus = fraction - R::splat(self.fraction_critical);
        let sine = R::splat(self.sine_critical) - R::splat(self.phase_transformation_factor) * surplus;
        let most = R::splat((2.0 * self.sine_critical).min(1.0));
        Self::ratio::<S, R>(sine.max(R::splat(0.0)).min(most))
    }

    /// a; without w it is a_cs to the bit.
    #[inline(always)]
    fn hardening_strain_at<R: Real>(&self, fraction: R) -> R {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let x = (fraction - R::splat(self.fraction_critical)) * R::splat(self.hardening_sharpness);
        let root = (one + x * x).sqrt();
        // Whichever form adds two numbers of one sign.
        let is_dense = x.above(zero);
        let share = R::choose(is_dense, one, root - x) / (root * R::choose(is_dense, root + x, one));
        R::splat(self.hardening_strain) * share
    }

    /// g at the end of a first loading that has mobilised such a share of m_b.
    fn hardening_of(&self, fraction: f64, mobilised: f64) -> f64 {
        let mobilised = mobilised.min(MOBILISED_MOST);
        let beyond = (mobilised - self.hardening_start).max(0.0);
        self.hardening_strain_at(fraction) * beyond / (1.0 - mobilised)
    }

    /// G after the plastic strain so far.
    #[inline(always)]
    fn shear_modulus_at<R: Real>(&self, plastic_strain: R) -> R {
        let slip = R::splat(SQRT_2) * plastic_strain;
        let lost = slip / (R::splat(self.shear_degradation_strain) + slip);
        R::splat(self.shear_modulus) * (R::splat(1.0) - R::splat(self.shear_degradation) * lost)
    }

    /// Elastic energy, J/m3.
    #[inline(always)]
    fn energy<R: Real>(&self, shear_modulus: R, strain: Measures<R>) -> R {
        let Measures { volume, shear } = strain;
        R::splat(0.5 * self.bulk_modulus) * volume * volume + R::splat(2.0) * shear_modulus * shear * shear
    }

    #[inline(always)]
    fn stress_of<R: Real, T: Symmetric<R>>(&self, shear_modulus: R, strain: &T) -> T {
        let twice = R::splat(2.0) * shear_modulus;
        let lambda = R::splat(self.bulk_modulus) - twice * R::splat(1.0 / T::DIMENSION as f64);
        *strain * twice + T::isotropic(lambda * strain.trace())
    }

    /// Delta, the positive root of the quadratic, with dD and ds over it.
    #[inline(always)]
    fn plastic_shear<R: Real>(&self, trial: &Trial<R>, excess: R, dilation: R, norm: R) -> R {
        let (zero, two) = (R::splat(0.0), R::splat(2.0));
        let Trial { peak, hardening, .. } = *trial;
        let reach = trial.hardening_strain + hardening;
        let half = R::splat(self.shear_degradation_strain);
        let beyond = half + R::splat(SQRT_2) * trial.plastic_strain;
        let slope = R::splat(self.shear_modulus * self.shear_degradation) * half / (beyond * beyond) * norm;
        let stiffness = trial.shear_modulus + two * trial.strain.shear * slope;
        let q = two * trial.shear_modulus * trial.strain.shear;
        let swells = R::splat(self.bulk_modulus) * dilation;
        let second = stiffness + peak * swells;
        let first = q - stiffness * reach - peak * (self.pressure(trial.strain.volume) + hardening * swells);
        let root = (first * first + R::splat(4.0) * second * excess).max(zero).sqrt();
        // Whichever form adds two numbers of one sign.
        let falls = zero.above(first);
        R::choose(falls, two * excess, first + root) / R::choose(falls, root - first, two * second)
    }

    /// P.
    #[inline(always)]
    fn pressure<R: Real>(&self, volume: R) -> R {
        R::splat(self.attraction) - R::splat(self.bulk_modulus) * volume
    }

    #[inline(always)]
    fn return_to_cone<S: Space, R: Real>(&self, trial: &Trial<R>) -> Return<R> {
        let (zero, two) = (R::splat(0.0), R::splat(2.0));
        let Measures { volume, shear } = trial.strain;
        let (bulk, attraction) = (R::splat(self.bulk_modulus), R::splat(self.attraction));
        let pressure = self.pressure(volume);
        let reach = trial.hardening_strain + trial.hardening;
        let excess = two * trial.shear_modulus * shear * reach - trial.peak * trial.hardening * pressure;
        // With g = 0 the cone is the axis of pressures, and nothing that is not sheared exceeds it.
        let flows = R::either(excess.above(zero), zero.above(pressure));
        let mut returned = Return {
            flows,
            strain: trial.strain,
            shear_modulus: trial.shear_modulus,
            plastic_strain: trial.plastic_strain,
            hardening: trial.hardening,
            dilated: zero,
            opened: zero,
            work: zero,
        };
        if !R::any(flows) {
            return returned;
        }
        let ratio = trial.peak * trial.hardening / reach - trial.transformation;
        let dilation = R::choose(attraction.above(pressure), ratio.max(zero), ratio);
        // ds/dg.
        let norm = (R::splat(1.0) + R::splat(2.0 / S::DIMENSION as f64) * dilation * dilation).sqrt();
        let slipped = self.plastic_shear(trial, excess, dilation, norm);
        returned.hardening = trial.hardening + slipped;
        returned.plastic_strain = trial.plastic_strain + R::splat(FRAC_1_SQRT_2) * norm * slipped;
        returned.dilated = dilation * slipped;
        let mut pressed = pressure + bulk * returned.dilated;
        let floor = pressure.min(attraction);
        let floored = floor.above(pressed);
        if R::any(floored) {
            pressed = pressed.max(floor);
            let contracted = (pressed - pressure) * R::splat(1.0 / self.bulk_modulus);
            returned.dilated = R::choose(floored, contracted, returned.dilated);
        }
        returned.shear_modulus = self.shear_modulus_at(returned.plastic_strain);
        let stiffness = two * returned.shear_modulus;
        let mobilised = trial.peak * returned.hardening / (trial.hardening_strain + returned.hardening);
        let q = (mobilised * pressed).min(stiffness * (shear - R::splat(0.5) * slipped)).max(zero);
        returned.strain = Measures { volume: volume - returned.dilated, shear: q / stiffness };
        let beyond = R::both(flows, zero.above(pressed));
        if R::any(beyond) {
            self.return_to_apex::<S, R>(trial, beyond, &mut returned);
        }
        let Measures { volume: kept, shear: left } = returned.strain;
        let degraded = two * (trial.shear_modulus - returned.shear_modulus) * left * left;
        let slid = two * two * returned.shear_modulus * left * (shear - left);
        returned.work = slid + bulk * kept * (volume - kept) + degraded;
        returned
    }

    /// What has expanded beyond the cone: no shear is left and nothing mobilised, and the volume is a gap and not of
    /// Phi.
    #[inline(always)]
    fn return_to_apex<S: Space, R: Real>(&self, trial: &Trial<R>, beyond: R::Mask, returned: &mut Return<R>) {
        let zero = R::splat(0.0);
        let Measures { volume, shear } = trial.strain;
        let apex = R::splat(self.attraction / self.bulk_modulus);
        let opened = volume - apex;
        let norm = (R::splat(2.0) * shear * shear + R::splat(1.0 / S::DIMENSION as f64) * opened * opened).sqrt();
        let plastic_strain = trial.plastic_strain + norm;
        let choose = |at_apex: R, on_cone: R| R::choose(beyond, at_apex, on_cone);
        returned.strain.volume = choose(apex, returned.strain.volume);
        returned.strain.shear = choose(zero, returned.strain.shear);
        returned.plastic_strain = choose(plastic_strain, returned.plastic_strain);
        returned.shear_modulus = choose(self.shear_modulus_at(plastic_strain), returned.shear_modulus);
        returned.hardening = choose(zero, returned.hardening);
        returned.dilated = choose(zero, returned.dilated);
        returned.opened = choose(opened, zero);
    }

    /// g, or less where the stress has fallen so far that a new loading begins; `start` is kappa_0 a.
    #[inline(always)]
    fn reset<R: Real>(hardening: R, trial: &Trial<R>, start: R, q: R, pressure: R) -> R {
        let zero = R::splat(0.0);
        let (most, reached) = (trial.peak * pressure, q * R::splat(1.0 / RELOADING_SHARE));
        let left = most - reached;
        let falls = left.above(zero);
        let reach = trial.hardening_strain * reached / R::choose(falls, left, R::splat(1.0));
        let bound = (reach - start).max(zero);
        // Without pressure there is nothing to be mobilised.
        let kept = R::choose(falls, hardening.min(bound), hardening);
        R::choose(pressure.above(zero), kept, zero)
    }

    /// The step of [`MaterialLaw::update_lanes`]: the state that it leaves, its stress and what it dissipated.
    #[inline(always)]
    fn step<S: Space, R: Real>(
        &self,
        gradient: &S::TensorOf<R>,
        dt: f64,
        before: &State<R, S::SymmetricOf<R>>,
    ) -> Stepped<R, S::SymmetricOf<R>> {
        let (zero, one, dimension) = (R::splat(0.0), R::splat(1.0), R::splat(S::DIMENSION as f64));
        let mut state = *before;
        state.strain = state.strain.pushed(&gradient.scaled(R::splat(dt)));
        let mut strain = state.strain.half_logarithm();
        let shear_modulus = self.shear_modulus_at(state.plastic_strain);

        // Separated grains bear nothing until the gap is closed.
        let separated = state.gap.above(zero);
        let mut work = zero;
        if R::any(separated) {
            let left = state.gap + strain.trace();
            state.gap = R::choose(separated, left.max(zero), state.gap);
            let closed = S::SymmetricOf::<R>::isotropic(left.min(zero) / dimension);
            // What the apex held is lost with it; what has parted before holds nothing.
            let held = self.energy(shear_modulus, Parts::of(&before.strain.half_logarithm()).measures);
            work = R::choose(separated, held, zero);
            strain = Words::choose(separated, &closed, &strain);
        }
        let parts = Parts::of(&strain);
        let hardening_strain = self.hardening_strain_at(state.fraction);
        let start = R::splat(self.hardening_start) * hardening_strain;
        let trial = Trial {
            strain: parts.measures,
            peak: self.peak::<S, R>(state.fraction),
            transformation: self.transformation::<S, R>(state.fraction),
            hardening_strain: hardening_strain - start,
            shear_modulus,
            plastic_strain: state.plastic_strain,
            hardening: state.hardening + start,
        };
        let returned = self.return_to_cone::<S, R>(&trial);
        let flow = |flowing: R, resting: R| R::choose(returned.flows, flowing, resting);
        if R::any(returned.flows) {
            strain = Words::choose(returned.flows, &parts.with(returned.strain), &strain);
            work = flow(work + returned.work, work);
            state.gap = flow(state.gap + returned.opened.max(zero), state.gap);
            state.plastic_strain = flow(returned.plastic_strain, state.plastic_strain);
            state.hardening = flow((returned.hardening - start).max(zero), state.hardening);
            // The exponential, to the last place of what a step flows.
            let x = returned.dilated;
            let series = one
                + x * (one + x * R::splat(1.0 / 2.0) * (one + x * R::splat(1.0 / 3.0) * (one + x * R::splat(0.25))));
            state.fraction = flow(state.fraction / series, state.fraction);
        }
        let changed = R::either(separated, returned.flows);
        if R::any(changed) {
            state.strain = Words::choose(changed, &(strain * R::splat(2.0)).exponential(), &state.strain);
        }
        let shear_modulus = flow(returned.shear_modulus, shear_modulus);
        let volume = flow(returned.strain.volume, parts.measures.volume);
        let q = R::splat(2.0) * shear_modulus * flow(returned.strain.shear, parts.measures.shear);
        state.hardening = Self::reset(state.hardening, &trial, start, q, self.pressure(volume));
        (state, self.stress_of(shear_modulus, &strain), work)
    }
}

impl<S: Space> MaterialLaw<S> for MobilisedFriction {
    type Memory = MobilisedMemory<S>;

    /// The stress lies on the cone, at the end of a first loading: g follows from q/P. More shear than m_b P is cut to
    /// it, and what pulls beyond the apex returns there.
    fn start(&self, stress: &S::Tensor, fraction: f64) -> MobilisedMemory<S> {
        let strain = isotropic_strain(self.bulk_modulus, self.shear_modulus, &S::Symmetric::of(stress));
        let parts = Parts::of(&strain);
        let Measures { volume, shear } = parts.measures;
        let (pressure, stiffness) = (self.pressure(volume), 2.0 * self.shear_modulus);
        let most = self.peak::<S, f64>(fraction) * pressure;
        let (strain, hardening) = if pressure > 0.0 {
            let hardening = self.hardening_of(fraction, stiffness * shear / most);
            let is_borne = stiffness * shear <= MOBILISED_MOST * most;
            let cut = Measures { volume, shear: MOBILISED_MOST * most / stiffness };
            (if is_borne { strain } else { parts.with(cut) }, hardening)
        } else {
            (parts.with(Measures { volume: self.attraction / self.bulk_modulus, shear: 0.0 }), 0.0)
        };
        MobilisedMemory { strain: (strain * 2.0).exponential(), fraction, plastic_strain: 0.0, gap: 0.0, hardening }
    }

    /// A cone that has gone so far out stays there while q/P does not fall below half of it.
    fn harden(&self, memory: &mut MobilisedMemory<S>, mobilised: f64) {
        memory.hardening = memory.hardening.max(self.hardening_of(memory.fraction, mobilised));
    }

    fn update_counted(
        &self,
        gradient: &S::Tensor,
        dt: f64,
        memory: &mut MobilisedMemory<S>,
        work: &mut f64,
    ) -> S::Tensor {
        alone::<S, _>(self, gradient, dt, memory, work)
    }

    #[inline(always)]
    fn update_lanes<R: Real>(
        &self,
        gradient: &S::TensorOf<R>,
        dt: f64,
        memory: &mut [R],
        work: &mut R,
    ) -> S::SymmetricOf<R> {
        let (state, stress, dissipated) = self.step::<S, R>(gradient, dt, &State::of_words(memory));
        state.to_words(memory);
        *work = *work + dissipated;
        stress
    }

    #[inline(always)]
    fn flow<R: Real>(&self, memory: &[R], stress: &S::SymmetricOf<R>) -> Option<Flow<R>> {
        let State { plastic_strain, gap, .. } = State::<R, S::SymmetricOf<R>>::of_words(memory);
        let volume = stress.trace() * R::splat(1.0 / (self.bulk_modulus * S::DIMENSION as f64)) + gap;
        Some(Flow { volume, plastic_strain })
    }

    fn stress(&self, memory: &MobilisedMemory<S>) -> S::Tensor {
        self.stress_of(self.shear_modulus_at(memory.plastic_strain), &memory.strain.half_logarithm()).tensor()
    }

    /// Elastic strain and flow have no part along the normal of the plane: `(K - G) tr(eps)`.
    fn out_of_plane(&self, memory: &MobilisedMemory<S>) -> f64 {
        let lambda = self.bulk_modulus - self.shear_modulus_at(memory.plastic_strain);
        match S::DIMENSION {
            2 => lambda * memory.strain.half_logarithm().trace(),
            _ => 0.0,
        }
    }

    fn elastic_energy(&self, memory: &MobilisedMemory<S>) -> f64 {
        let parts = Parts::of(&memory.strain.half_logarithm());
        self.energy(self.shear_modulus_at(memory.plastic_strain), parts.measures)
    }

    /// Of the first loading: it only falls.
    fn p_wave_modulus(&self) -> f64 {
        p_wave_modulus::<S>(self.bulk_modulus, self.shear_modulus)
    }

    fn shear_modulus(&self) -> f64 {
        self.shear_modulus
    }

    fn mobilised(&self, stress: &S::Symmetric, fraction: f64) -> f64 {
        let pressure = self.attraction - stress.trace() / S::DIMENSION as f64;
        share_of_strength(stress, self.peak::<S, f64>(fraction) * pressure)
    }
}
