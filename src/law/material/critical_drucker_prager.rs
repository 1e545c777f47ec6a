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

use std::f64::consts::FRAC_PI_4;

use super::chosen::{FRACTION, Objection};
use super::hencky::{isotropic_strain, isotropic_stress, p_wave_modulus};
use super::measures::{Measures, Parts};
use super::{Described, Flow, MaterialLaw, MaterialMemory, alone, share_of_strength};
use crate::base::keys::{ANGLE, Form, Key, NOT_NEGATIVE, POSITIVE, RATIO, Range, STRESS, number};
use crate::base::lane::Real;
use crate::base::math;
use crate::base::record::{Record, Visitor};
use crate::base::space::{Space, Words};
use crate::base::symmetric::Symmetric;
use crate::numbers;

/// Critical-state Drucker-Prager plasticity (Chen et al. 2021, eq. 4 to 8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalConstants {
    /// K, Pa: in the plane that of p = tr(tau)/2, in space that of p = tr(tau)/3.
    pub bulk_modulus: f64,
    /// G, Pa.
    pub shear_modulus: f64,
    /// phi_cs, rad.
    pub friction_angle_critical: f64,
    /// Phi_cs.
    pub fraction_critical: f64,
    /// Phi that points start with, unless their region has its own; none where a packing tells it.
    pub fraction: Option<f64>,
    /// chi of tan(psi) = chi (Phi - Phi_cs), tan(phi) = tan(phi_cs) + chi (Phi - Phi_cs).
    pub dilation_factor: f64,
    /// xi of dPhi/dt = -(Phi - Phi_cs) Phi xi |deps_p/dt|.
    pub softening_rate: f64,
    /// c, Pa.
    pub cohesion: f64,
    /// A constant psi of plastic flow, rad, in place of that of chi, which is then zero: phi is phi_cs throughout.
    pub dilation_angle: Option<f64>,
}

impl CriticalConstants {
    /// Table 2 of Chen et al. (2021) without its moduli, for jobs that say nothing of a continuum because they have none.
    pub const CHEN: Self = Self {
        bulk_modulus: 630e6,
        shear_modulus: 460e6,
        friction_angle_critical: 0.27,
        fraction_critical: 0.815,
        fraction: None,
        dilation_factor: 7.0,
        softening_rate: 0.01,
        cohesion: 0.0,
        dilation_angle: None,
    };

    /// The keys of moduli, friction and flow. `still`: the dilation angle is constant, so that nothing need follow the solid volume
    /// fraction.
    fn keys_of_flow(&mut self, form: &mut dyn Form, still: bool) {
        if still && form.is_needed() {
            (self.dilation_factor, self.softening_rate) = (0.0, 0.0);
        }
        form.number(&mut self.bulk_modulus, number("bulk_modulus", "K", STRESS, POSITIVE, "\"630 MPa\""));
        form.number(&mut self.shear_modulus, number("shear_modulus", "G", STRESS, POSITIVE, "\"460 MPa\""));
        form.number(
            &mut self.friction_angle_critical,
            number("friction_angle_critical", "phi_cs", ANGLE, Range::below(0.0, 1.3734), "\"30 deg\""),
        );
        form.number(
            &mut self.fraction_critical,
            unless(still, number("fraction_critical", "Phi_cs", RATIO, Range::open(0.0, 1.0), "0.815")),
        );
        let (chi, xi) = (DILATION_FACTOR, "xi of dPhi/dt = -(Phi - Phi_cs) Phi xi |deps_p/dt|");
        form.number(
            &mut self.dilation_factor,
            unless(still, number("dilation_factor", chi, RATIO, Range::closed(0.0, 100.0), "7")),
        );
        form.number(
            &mut self.softening_rate,
            unless(still, number("softening_rate", xi, RATIO, Range::closed(0.0, 1000.0), "7")),
        );
        form.number(&mut self.cohesion, number("cohesion", "c", STRESS, NOT_NEGATIVE, "\"10 kPa\"").or("0.0"));
    }
}

impl Described for CriticalConstants {
    fn keys(&mut self, form: &mut dyn Form) {
        let angle = number(
            "dilation_angle",
            "a constant psi in place of that of chi",
            ANGLE,
            Range::closed(-FRAC_PI_4, FRAC_PI_4),
            "\"0 deg\"",
        );
        form.number_if_given(&mut self.dilation_angle, angle.optional());
        let still = self.dilation_angle.is_some();
        if still && form.is_needed() && !form.has("fraction_critical") {
            self.fraction_critical = FRACTION_STILL;
        }
        self.keys_of_flow(form, still);
        form.number_if_given(&mut self.fraction, unless(still, FRACTION));
        if still && self.dilation_factor != 0.0 {
            form.note(
                "dilation_angle",
                "stands beside material.dilation_factor, and each says how flow dilates. Drop dilation_factor for a constant angle of dilation and of friction, or dilation_angle for angles that follow the solid volume fraction.",
            );
        }
    }

    /// As it is given: that of the space it is for.
    fn bulk_modulus_in(&self, _: usize) -> f64 {
        self.bulk_modulus
    }

    fn shear_modulus(&self) -> f64 {
        self.shear_modulus
    }

    fn fraction(&self) -> Option<f64> {
        self.fraction
    }

    fn set_fraction(&mut self, fraction: Option<f64>) {
        self.fraction = fraction;
    }

    fn fraction_by_default(&self) -> Option<f64> {
        self.dilation_angle.map(|_| self.fraction_critical)
    }

    fn yields(&self) -> bool {
        true
    }

    fn objection(&self, axes: usize, fraction: f64) -> Option<Objection> {
        self.objection_to(axes, fraction)
    }

    fn k0(&self, axes: usize, fraction: f64, overburden: f64) -> Option<[f64; 2]> {
        Some(self.cone(axes, fraction).k0(axes, overburden, self.cohesion))
    }
}

/// What `dilation_factor` is, of every law that has it.
pub(super) const DILATION_FACTOR: &str = "chi of tan(phi) = tan(phi_cs) + chi (Phi - Phi_cs), and of dilation with it";
/// Phi_cs where nothing looks at it.
const FRACTION_STILL: f64 = 0.8;

/// A key that must be typed unless the dilation angle is constant.
fn unless(still: bool, key: Key) -> Key {
    if still { key.follows("nothing: the dilation angle is constant") } else { key }
}

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
#[repr(C)]
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

numbers!(impl[S: Space] CriticalMemory[S] {
    strain: S::Symmetric,
    fraction: f64,
    plastic_strain: f64,
    gap: f64,
});

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

/// Friction and dilation at a solid volume fraction, equation (7).
#[derive(Clone, Copy, Debug)]
struct Cone<R> {
    eta: R,
    eta_bar: R,
    zeta: R,
}

/// What the return makes of a trial strain.
#[derive(Clone, Copy, Debug)]
struct Return<R: Real> {
    /// Where anything flows; elsewhere the rest says nothing.
    flows: R::Mask,
    strain: Measures<R>,
    /// |deps_p|.
    plastic: R,
    /// Volume strain beyond the apex.
    opened: R,
    /// tau:deps_p with the returned stress, J/m3.
    work: R,
}

impl CriticalDruckerPrager {
    /// By the constants of a job, angles as their tangents; a constant dilation angle takes the place of chi.
    pub fn of(law: &CriticalConstants) -> Self {
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

    /// In space the cone through the corners of triaxial compression of the Mohr-Coulomb pyramid, which the plane's is.
    #[inline(always)]
    fn cone<S: Space, R: Real>(&self, fraction: R) -> Cone<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let change = R::splat(self.dilation_factor) * (fraction - R::splat(self.fraction_critical));
        let tan_psi = R::splat(self.dilation) + change;
        let tan_phi = (R::splat(self.friction_critical) + change).max(zero);
        let zeta = one / (one + tan_phi * tan_phi).sqrt();
        let (eta, eta_bar) = (tan_phi * zeta, tan_psi / (one + tan_psi * tan_psi).sqrt());
        if S::DIMENSION == 2 {
            return Cone { eta, eta_bar, zeta };
        }
        // 6/sqrt(3).
        let (factor, three) = (R::splat(3.464_101_615_137_754_6), R::splat(3.0));
        let (friction, dilation) = (factor / (three - eta), factor / (three - eta_bar));
        Cone { eta: eta * friction, eta_bar: eta_bar * dilation, zeta: zeta * friction }
    }

    /// Elastic energy of a logarithmic strain, J/m3.
    #[inline(always)]
    fn energy<R: Real, T>(&self, strain: &Parts<R, T>) -> R {
        let Measures { volume, shear } = strain.measures;
        R::splat(0.5 * self.bulk_modulus) * volume * volume + R::splat(2.0 * self.shear_modulus) * shear * shear
    }

    /// Solid volume fraction after plastic flow, equation (8).
    #[inline(always)]
    fn softened<R: Real>(&self, fraction: R, plastic: R) -> R {
        let excess = fraction - R::splat(self.fraction_critical);
        fraction - excess * fraction * R::splat(self.softening_rate) * plastic
    }

    #[inline(always)]
    fn return_to_cone<S: Space, R: Real>(&self, cone: &Cone<R>, trial: Measures<R>) -> Return<R> {
        let (zero, half, two) = (R::splat(0.0), R::splat(0.5), R::splat(2.0));
        let share = R::splat(2.0 / S::DIMENSION as f64);
        let (bulk, shear) = (R::splat(self.bulk_modulus), R::splat(self.shear_modulus));
        let pressure = bulk * trial.volume;
        let q = two * shear * trial.shear;
        let excess = q + cone.eta * pressure - cone.zeta * R::splat(self.cohesion);
        let flows = excess.above(zero);

        let multiplier = excess / (shear + bulk * cone.eta * cone.eta_bar);
        let q_returned = q - shear * multiplier;
        let q_on_cone = q_returned.max(zero);
        let volume = trial.volume - cone.eta_bar * multiplier;
        let on_cone = Return {
            flows,
            strain: Measures { volume, shear: q_on_cone / (two * shear) },
            plastic: multiplier * (half * (R::splat(1.0) + share * cone.eta_bar * cone.eta_bar)).sqrt(),
            opened: zero,
            work: multiplier * (q_on_cone + cone.eta_bar * (bulk * volume)),
        };
        // A material without friction has no apex.
        let beyond = R::both(flows, R::both(zero.above(q_returned), cone.eta.above(zero)));
        if !R::any(beyond) {
            return on_cone;
        }
        let apex = cone.zeta * R::splat(self.cohesion) / (cone.eta * bulk);
        let opened = trial.volume - apex;
        let plastic = (two * trial.shear * trial.shear + half * share * opened * opened).sqrt();
        let choose = |at_apex: R, on_cone: R| R::choose(beyond, at_apex, on_cone);
        Return {
            flows,
            strain: Measures { volume: choose(apex, on_cone.strain.volume), shear: choose(zero, on_cone.strain.shear) },
            plastic: choose(plastic, on_cone.plastic),
            opened: choose(opened, zero),
            work: choose(bulk * apex * opened, on_cone.work),
        }
    }

    /// The step of [`MaterialLaw::update_lanes`]: the state that it leaves, its stress and what it dissipated.
    #[inline(always)]
    fn step<S: Space, R: Real>(
        &self,
        gradient: &S::TensorOf<R>,
        dt: f64,
        before: &State<R, S::SymmetricOf<R>>,
    ) -> Stepped<R, S::SymmetricOf<R>> {
        let (zero, dimension) = (R::splat(0.0), R::splat(S::DIMENSION as f64));
        let mut state = *before;
        state.strain = state.strain.pushed(&gradient.scaled(R::splat(dt)));
        let mut strain = state.strain.half_logarithm();

        // Separated grains bear nothing until the gap is closed.
        let separated = state.gap.above(zero);
        let mut work = zero;
        if R::any(separated) {
            let left = state.gap + strain.trace();
            state.gap = R::choose(separated, left.max(zero), state.gap);
            let closed = S::SymmetricOf::<R>::isotropic(left.min(zero) / dimension);
            // What the apex held is lost with it; what has parted before holds nothing.
            let held = self.energy(&Parts::of(&before.strain.half_logarithm()));
            work = R::choose(separated, held, zero);
            strain = Words::choose(separated, &closed, &strain);
        }
        let trial = Parts::of(&strain);
        let returned = self.return_to_cone::<S, R>(&self.cone::<S, R>(state.fraction), trial.measures);
        if R::any(returned.flows) {
            let flow = |flowing: R, resting: R| R::choose(returned.flows, flowing, resting);
            strain = Words::choose(returned.flows, &trial.with(returned.strain), &strain);
            work = flow(work + returned.work, work);
            state.gap = flow(state.gap + returned.opened.max(zero), state.gap);
            state.plastic_strain = flow(state.plastic_strain + returned.plastic, state.plastic_strain);
            state.fraction = flow(self.softened(state.fraction, returned.plastic), state.fraction);
        }
        let changed = R::either(separated, returned.flows);
        if R::any(changed) {
            state.strain = Words::choose(changed, &(strain * R::splat(2.0)).exponential(), &state.strain);
        }
        (state, isotropic_stress(self.bulk_modulus, self.shear_modulus, &strain), work)
    }
}

/// State, Kirchhoff stress (Pa) and dissipated energy (J/m3) after a step.
type Stepped<R, T> = (State<R, T>, T, R);

/// [`CriticalMemory`] in lanes.
#[derive(Clone, Copy, Debug)]
struct State<R, T> {
    strain: T,
    fraction: R,
    plastic_strain: R,
    gap: R,
}

impl<R: Real, T: Symmetric<R>> State<R, T> {
    /// In the order of the fields of [`CriticalMemory`].
    #[inline(always)]
    fn of_words(words: &[R]) -> Self {
        let rest = &words[T::COUNT..];
        Self { strain: T::of_words(words), fraction: rest[0], plastic_strain: rest[1], gap: rest[2] }
    }

    #[inline(always)]
    fn to_words(self, words: &mut [R]) {
        self.strain.to_words(words);
        words[T::COUNT..].copy_from_slice(&[self.fraction, self.plastic_strain, self.gap]);
    }
}

impl<S: Space> MaterialLaw<S> for CriticalDruckerPrager {
    type Memory = CriticalMemory<S>;

    fn start(&self, stress: &S::Tensor, fraction: f64) -> CriticalMemory<S> {
        let strain = isotropic_strain(self.bulk_modulus, self.shear_modulus, &S::Symmetric::of(stress));
        let trial = Parts::of(&strain);
        let returned = self.return_to_cone::<S, f64>(&self.cone::<S, f64>(fraction), trial.measures);
        let strain = if returned.flows { trial.with(returned.strain) } else { strain };
        CriticalMemory { strain: (strain * 2.0).exponential(), fraction, plastic_strain: 0.0, gap: 0.0 }
    }

    fn update_counted(
        &self,
        gradient: &S::Tensor,
        dt: f64,
        memory: &mut CriticalMemory<S>,
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
        self.energy(&Parts::of(&memory.strain.half_logarithm()))
    }

    fn p_wave_modulus(&self) -> f64 {
        p_wave_modulus::<S>(self.bulk_modulus, self.shear_modulus)
    }

    fn shear_modulus(&self) -> f64 {
        self.shear_modulus
    }

    fn mobilised(&self, stress: &S::Symmetric, fraction: f64) -> f64 {
        // Loose material hardens to the cone of its critical state.
        let Cone { eta, zeta, .. } = self.cone::<S, f64>(fraction.max(self.fraction_critical));
        share_of_strength(stress, zeta * self.cohesion - eta * stress.trace() / S::DIMENSION as f64)
    }
}
