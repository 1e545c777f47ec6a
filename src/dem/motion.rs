//! Motion of grains: leapfrog. Velocities live half a step behind positions, so that force at the position and
//! velocity known now kicks the velocity over the position (velocity Verlet with the forces' velocities lagging).

use rayon::prelude::*;

use crate::base::keys::{Form, NOT_NEGATIVE, RATIO, Range, choose, number, text};
use crate::base::lane::{LANES, Pack, Real};
use crate::base::numbers::{Lanes, Numbers};
use crate::base::parallel::larger;
use crate::base::space::{Lanewise, Linear, Space};
use crate::base::units::Dimension;
use crate::bodies::body::Body;
use crate::dem::cell::Cell;
use crate::dem::columns::{columns, splat, times};
use crate::dem::grains::{Grains, Hot, Mover, PenaltySpring, lanes, vector};
use crate::dem::kernel::Side;
use crate::dem::segments::{Finish, Resting};

/// Damping of grains against the mean field of the cell, beside that of their contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Damping {
    /// Local non-viscous damping, 0 to below 1 (Liang & Zhao 2019, eq. 29); 0 is none.
    pub local: f64,
    /// Which of the two laws local damping is.
    pub form: DampingForm,
    /// Mass-proportional damping c of -c m v, 1/s (Liu et al. 2016, 2.3.1).
    pub mass: f64,
}

impl Damping {
    /// The keys of `[damping]`.
    pub fn keys(&mut self, form: &mut dyn Form) {
        let about = "local damping, a share of the force on a grain";
        form.number(&mut self.local, number("local", about, RATIO, Range::below(0.0, 1.0), "0.1").or("0.0"));
        let key = text("form", "the law of local damping: vector or component", "\"vector\"").or("vector");
        let forms = [("vector", DampingForm::Vector), ("component", DampingForm::Component)];
        choose(form, &mut self.form, "form of local damping", key, &forms);
        let about = "c of the damping force -c m v";
        form.number(&mut self.mass, number("mass", about, Dimension::RATE, NOT_NEGATIVE, "\"10 1/s\"").or("0.0"));
    }
}

/// Two laws go by the name of local damping.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DampingForm {
    /// Opposes the velocity vector with a share of the force's magnitude (Liang & Zhao 2019, eq. 29).
    #[default]
    Vector,
    /// Scales each component of acceleration by 1 -+ damping, by the sign of its power at mid-step.
    Component,
}

/// Forces on grains beside those of contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field<S: Space> {
    /// m/s2.
    pub gravity: S::Vector,
    /// Of free grains.
    pub damping: Damping,
}

impl<S: Space> Default for Field<S> {
    fn default() -> Self {
        Self { gravity: S::Vector::zero(), damping: Damping::default() }
    }
}

impl<S: Space> Field<S> {
    /// Whether gravity is all there is.
    pub fn is_plain(&self) -> bool {
        self.damping.local == 0.0 && self.damping.mass == 0.0
    }
}

/// Rows that one task handles; a constant, so that nothing depends on the number of threads.
const CHUNK: usize = 1024;

/// What a kick adds to the velocity of a free grain: `v(n+1/2) = v(n-1/2) + a dt`, `a = f/(w m) + g` and what else there is; `dt` is
/// halved in the very first step of a run, whose velocities are those of time zero.
pub trait Kick<S: Space>: Sync {
    /// One grain or eight, by the force and the torque on each.
    fn kick<R: Real>(&self, grain: &mut Side<S, R>, given: (S::VectorOf<R>, S::SpinOf<R>), dt: f64);

    /// Of a grain as it lies among others.
    #[inline(always)]
    fn kick_one(&self, hot: &mut Hot<S>, (force, torque): (&S::Vector, &S::Spin), dt: f64) {
        let mut grain = Side::<S, f64>::scalar(hot);
        self.kick(&mut grain, (lanes(force), lanes(torque)), dt);
        (hot.velocity, hot.spin) = (vector(&grain.velocity), vector(&grain.spin));
    }
}

/// Forces and gravity, m/s2.
pub struct Falling<S: Space> {
    /// m/s2.
    pub gravity: S::Vector,
}

impl<S: Space> Kick<S> for Falling<S> {
    #[inline(always)]
    fn kick<R: Real>(&self, grain: &mut Side<S, R>, (force, torque): (S::VectorOf<R>, S::SpinOf<R>), dt: f64) {
        let (mass, dt) = (grain.weight * grain.mass, R::splat(dt));
        let gravity: S::VectorOf<R> = splat(&self.gravity);
        grain.velocity = grain.velocity + (force * (dt / mass) + gravity * dt);
        grain.spin = grain.spin + torque * (dt / S::grain_inertia(mass, grain.radius));
    }
}

/// Damping as well. In a cell that deforms with the gradient L, a grain that stays where it is in the cell accelerates by L v
/// too, and damping acts on the velocity against the mean field L x.
pub struct Damped<S: Space> {
    /// Gravity and damping.
    pub field: Field<S>,
    /// Its gradient L, 1/s, and its corner, from which x is.
    pub cell: Cell<S>,
}

impl<S: Space> Kick<S> for Damped<S> {
    #[inline(always)]
    fn kick<R: Real>(&self, grain: &mut Side<S, R>, (force, torque): (S::VectorOf<R>, S::SpinOf<R>), dt: f64) {
        let (mass, one) = (grain.weight * grain.mass, R::splat(1.0));
        let gravity: S::VectorOf<R> = splat(&self.field.gravity);
        let linear = force * (one / mass) + gravity;
        let angular = torque * (one / S::grain_inertia(mass, grain.radius));
        let (linear, angular) = self.field.damping.of_grain(grain, (linear, angular), &self.cell, dt);
        let dt = R::splat(dt);
        grain.velocity = grain.velocity + (linear + times::<S, R>(&self.cell.gradient, &grain.velocity)) * dt;
        grain.spin = grain.spin + angular * dt;
    }
}

/// The kick of a grain with that of its penalty spring, and where nothing stands between these and its drift that as well: its record is touched once. Glued
/// grains wait for their bodies.
pub struct Moves<K, const DRIFTS: bool> {
    /// What changes velocities.
    pub kick: K,
    /// Share of what penalty springs give until the next exchange with nodes that this step has; 0 where grains share none.
    pub spring_share: f64,
    /// Time over which velocities change, s: less than the step in the first of a run, where these are of time zero.
    pub dt_kick: f64,
    /// Time of the drift, s.
    pub dt: f64,
}

impl<S: Space, K: Kick<S>, const DRIFTS: bool> Finish<S> for Moves<K, DRIFTS> {
    #[inline(always)]
    fn finish(&self, row: usize, hot: &mut Hot<S>, given: (&S::Vector, &S::Spin), resting: &Resting<S>) -> f64 {
        match resting.movers[row] {
            Mover::Free => {
                self.kick.kick_one(hot, given, self.dt_kick);
                if self.spring_share > 0.0 {
                    hot.velocity += resting.springs[row].given * self.spring_share;
                }
            }
            Mover::Body(_) => return 0.0,
            Mover::Script if DRIFTS => hot.velocity = resting.cold[row].script,
            Mover::Script => return 0.0,
        }
        if DRIFTS { drifted(hot, &resting.homes[row], self.dt) } else { 0.0 }
    }

    #[inline(always)]
    fn finish_eight<P: Pack>(
        &self,
        hot: &mut [Hot<S>; LANES],
        (force, torque): (S::VectorOf<P>, S::SpinOf<P>),
        (homes, springs): (&[S::Vector; LANES], &[PenaltySpring<S>]),
    ) -> P {
        let mut record = Lanes::<P>::zero();
        record.load(&std::array::from_fn(|lane| &hot[lane]), Hot::<S>::WIDTH);
        let mut grain = Side::<S, P>::of_record(&record);
        self.kick.kick(&mut grain, (force, torque), self.dt_kick);
        if self.spring_share > 0.0 {
            let given: S::VectorOf<P> = columns(&std::array::from_fn::<_, LANES, _>(|lane| springs[lane].given));
            grain.velocity = grain.velocity + given * P::splat(self.spring_share);
        }
        record.set_words(S::DIMENSION, &grain.velocity);
        record.set_words(2 * S::DIMENSION, &grain.spin);
        let mut square = P::splat(0.0);
        if DRIFTS {
            let position = grain.position + grain.velocity * P::splat(self.dt);
            record.set_words(0, &position);
            let homes: S::VectorOf<P> = columns(homes);
            let moved = position - homes;
            square = moved.dot(&moved);
        }
        record.store(hot.as_mut_slice());
        square
    }
}

/// Glued grains go on with their bodies; returns as [`drift`] does.
pub fn follow_and_drift<S: Space>(grains: &mut Grains<S>, bodies: &[Body<S>], dt: f64) -> f64 {
    let Grains { hot, movers, homes, glued, .. } = grains;
    glued.iter().map(|row| *row as usize).fold(0.0, |most, row| {
        if let Mover::Body(body) = movers[row] {
            follow(&mut hot[row], &bodies[body as usize]);
        }
        larger(most, drifted(&mut hot[row], &homes[row], dt))
    })
}

/// Drifts; the square of the way from home, m2.
#[inline(always)]
fn drifted<S: Space>(hot: &mut Hot<S>, home: &S::Vector, dt: f64) -> f64 {
    hot.position += hot.velocity * dt;
    let moved = hot.position - *home;
    moved.dot(&moved)
}

/// A glued grain moves as its body does there.
#[inline(always)]
fn follow<S: Space>(hot: &mut Hot<S>, body: &Body<S>) {
    hot.velocity = body.velocity_at(&hot.position);
    hot.spin = body.spin;
}

impl Damping {
    /// Accelerations of grains (m/s2, rad/s2) with damping, from those without it, in a kick over `dt`.
    #[inline(always)]
    pub fn of_grain<S: Space, R: Real>(
        &self,
        grain: &Side<S, R>,
        (linear, angular): (S::VectorOf<R>, S::SpinOf<R>),
        cell: &Cell<S>,
        dt: f64,
    ) -> (S::VectorOf<R>, S::SpinOf<R>) {
        // The mean field at the middle of the step, when the velocity is known.
        let corner: S::VectorOf<R> = splat(&cell.corner);
        let fluctuation = grain.velocity - times::<S, R>(&cell.gradient, &(grain.position - corner));
        (self.opposed(linear, &fluctuation, dt), self.opposed(angular, &grain.spin, dt))
    }

    /// Acceleration with damping of what moves with that velocity against the mean field, from that without it, in a kick over `dt`.
    #[inline(always)]
    pub fn opposed<R: Real, V: Lanewise<R>>(&self, acceleration: V, velocity: &V, dt: f64) -> V {
        let share = R::splat(self.local);
        let opposed = match self.form {
            DampingForm::Component => oppose_by_component(acceleration, velocity, share, R::splat(0.5 * dt)),
            DampingForm::Vector => oppose_by_vector(acceleration, velocity, share),
        };
        opposed - *velocity * R::splat(self.mass)
    }
}

/// Each component of acceleration scaled by 1 - damping sign(a (u + dt a/2)): less where it adds to the motion, more where
/// it takes from it (Cundall 1987, by components).
#[inline(always)]
fn oppose_by_component<R: Real, V: Lanewise<R>>(acceleration: V, velocity: &V, share: R, dt_half: R) -> V {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let mut opposed = acceleration;
    for axis in 0..V::COUNT {
        let a = acceleration.word(axis);
        let power = a * (velocity.word(axis) + dt_half * a);
        let sign = R::choose(power.above(zero), one, zero) - R::choose(zero.above(power), one, zero);
        opposed.set_word(axis, a * (one - share * sign));
    }
    opposed
}

/// f_damp = -alpha |f| v/|v| (Liang & Zhao 2019, eq. 29).
#[inline(always)]
fn oppose_by_vector<R: Real, V: Lanewise<R>>(acceleration: V, velocity: &V, share: R) -> V {
    // sqrt(v.v) also of a single component, so that one whose square underflows counts as at rest here as it does in lanes.
    let (speed, size) = (velocity.dot(velocity).sqrt(), acceleration.dot(&acceleration).sqrt());
    let opposed = acceleration - *velocity * (share * size / speed);
    V::choose(speed.above(R::splat(0.0)), &opposed, &acceleration)
}

/// `v += dL x`: the mean field follows a change of the cell's velocity gradient at once, and every spin its vorticity.
pub fn follow_gradient<S: Space>(grains: &mut Grains<S>, cell: &Cell<S>, change: &S::Tensor) {
    let spin = S::vorticity(change);
    for (hot, cold) in grains.hot[..grains.owned].iter_mut().zip(&grains.cold) {
        if cold.mover == Mover::Free {
            hot.velocity += *change * (hot.position - cell.corner);
            hot.spin += spin;
        }
    }
}

/// `x(n+1) = x(n) + v(n+1/2) dt`; glued grains move with their body, scripted ones by their script. Returns the square
/// of the longest way that a grain has come from home, m2; what is not a number stays so.
pub fn drift<S: Space>(grains: &mut Grains<S>, bodies: &[Body<S>], dt: f64) -> f64 {
    let owned = grains.owned;
    let Grains { hot, cold, movers, homes, glued, scripted, .. } = grains;
    for row in glued.iter().map(|row| *row as usize) {
        if let Mover::Body(body) = movers[row] {
            follow(&mut hot[row], &bodies[body as usize]);
        }
    }
    for row in scripted.iter().map(|row| *row as usize) {
        hot[row].velocity = cold[row].script;
    }
    let chunk = |(rows, homes): (&mut [Hot<S>], &[S::Vector])| {
        // One maximum after the other would wait for each other.
        let mut most = [0.0; LANES];
        for (rows, homes) in rows.chunks_mut(LANES).zip(homes.chunks(LANES)) {
            for ((most, hot), home) in most.iter_mut().zip(rows).zip(homes) {
                *most = larger(*most, drifted(hot, home, dt));
            }
        }
        most.into_iter().fold(0.0, larger)
    };
    hot[..owned].par_chunks_mut(CHUNK).zip(homes[..owned].par_chunks(CHUNK)).map(chunk).reduce(|| 0.0, larger)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::lane::{Instructions, Packed};
    use crate::base::space::{Plane, Solid};
    use crate::dem::cell::Cell;

    struct Eight<'a, S: Space, F>(
        &'a F,
        &'a mut [Hot<S>; LANES],
        [&'a [S::Vector; LANES]; 2],
        (&'a [S::Spin; LANES], &'a [PenaltySpring<S>]),
    );

    impl<S: Space, F: Finish<S>> Packed for Eight<'_, S, F> {
        type Outcome = [f64; LANES];
        #[inline(always)]
        fn run<P: Pack>(self) -> [f64; LANES] {
            let Self(finish, hot, [force, homes], (torque, springs)) = self;
            finish.finish_eight::<P>(hot, (columns(force), columns(torque)), (homes, springs)).numbers()
        }
    }

    /// Numbers between -1 and 1 that no two places share.
    fn number(place: usize) -> f64 {
        (place as f64 * 0.754_877_666_246_692_7).fract() * 2.0 - 1.0
    }

    fn eights_move_as_single_ones_do<S: Space>(finish: &impl Finish<S>) {
        let vector = |of: usize| {
            let mut vector = S::Vector::zero();
            (0..S::DIMENSION).for_each(|axis| vector[axis] = number(100 * of + axis + 7));
            vector
        };
        let spin = |of: usize| {
            let mut spin = S::Spin::zero();
            (0..S::Spin::COMPONENTS).for_each(|axis| spin[axis] = number(100 * of + axis + 31));
            spin
        };
        let hot = |lane: usize| Hot::<S> {
            position: vector(lane),
            velocity: vector(lane + 10),
            spin: spin(lane),
            radius: 1.0 + 0.3 * number(lane),
            // Of the reconciliation zone as well.
            weight: if lane.is_multiple_of(3) { 0.5 } else { 1.0 },
            mass: 2.0 + number(lane + 3),
            spare: S::Spare::default(),
        };
        let start: [Hot<S>; LANES] = std::array::from_fn(hot);
        let (force, torque) =
            (std::array::from_fn(|lane| vector(lane + 20)), std::array::from_fn(|lane| spin(lane + 20)));
        let homes = std::array::from_fn(|lane| vector(lane + 30));
        let (movers, waits) = ([Mover::Free; LANES], [false; LANES]);
        let spring = |lane: usize| PenaltySpring { spring: vector(lane + 40), given: vector(lane + 50) };
        let springs: [PenaltySpring<S>; LANES] = std::array::from_fn(spring);
        let resting =
            Resting { movers: &movers, waits: &waits, alike: &[true], homes: &homes, springs: &springs, cold: &[] };
        let mut single = start;
        let ways: [f64; LANES] =
            std::array::from_fn(|lane| finish.finish(lane, &mut single[lane], (&force[lane], &torque[lane]), &resting));
        assert!(single != start);
        for instructions in Instructions::here() {
            let mut eight = start;
            let found = instructions.run(Eight(finish, &mut eight, [&force, &homes], (&torque, &springs)));
            assert_eq!((eight, found), (single, ways), "{instructions:?}");
        }
    }

    fn in_space<S: Space>() {
        let mut gravity = S::Vector::zero();
        gravity[1] = -9.81;
        let mut cell = Cell::<S>::cuboid(S::Vector::zero(), S::Vector::zero(), [false; 3]);
        (0..S::Tensor::COMPONENTS).for_each(|component| cell.gradient[component] = number(component + 50));
        (0..S::DIMENSION).for_each(|axis| cell.corner[axis] = number(axis + 60));
        let (dt_kick, dt) = (0.05, 0.1);
        for spring_share in [0.0, 0.25] {
            eights_move_as_single_ones_do(&Moves::<_, true> {
                kick: Falling::<S> { gravity },
                spring_share,
                dt_kick,
                dt,
            });
            eights_move_as_single_ones_do(&Moves::<_, false> {
                kick: Falling::<S> { gravity },
                spring_share,
                dt_kick,
                dt,
            });
        }
        for form in [DampingForm::Vector, DampingForm::Component] {
            let field = Field { gravity, damping: Damping { local: 0.3, form, mass: 0.7 } };
            eights_move_as_single_ones_do(&Moves::<_, true> {
                kick: Damped { field, cell },
                spring_share: 1.0,
                dt_kick,
                dt,
            });
        }
    }

    #[test]
    fn eight_grains_move_as_each_of_them_does_to_the_bit_whatever_the_registers() {
        in_space::<Plane>();
        in_space::<Solid>();
    }
}
