//! What holds a node: walls of the domain and rigid bodies. Each acts on the velocity that the node would have, and what it
//! takes from it is its reaction.

use crate::base::space::{Linear, Space};

/// How a surface holds what presses on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Grip {
    /// Nothing moves along it.
    Rough,
    /// Everything may.
    Smooth,
    /// Friction up to this times what presses.
    Coulomb(f64),
}

/// A surface at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold<S: Space> {
    /// What it does to motion along it.
    pub grip: Grip,
    /// Whether what moves away is let go; otherwise it is held along the normal in both senses.
    pub separates: bool,
    /// Unit, from the surface into the material.
    pub normal: S::Vector,
    /// Of the surface, m/s.
    pub velocity: S::Vector,
}

impl<S: Space> Hold<S> {
    /// The velocity that a node of velocity `free` is left with; whether it parts is told by `pushed`, the velocity that it
    /// would have after the forces of a step. Where these have acted already the two are one.
    pub fn on(&self, free: &S::Vector, pushed: &S::Vector) -> S::Vector {
        if self.separates && (*pushed - self.velocity).dot(&self.normal) > 0.0 {
            return *free;
        }
        let relative = *free - self.velocity;
        let opening = relative.dot(&self.normal);
        let along = relative - self.normal * opening;
        match self.grip {
            Grip::Rough => self.velocity,
            Grip::Smooth => self.velocity + along,
            Grip::Coulomb(friction) => {
                let speed = along.norm();
                let stopped = friction * (-opening).max(0.0);
                let left = if speed > stopped { 1.0 - stopped / speed } else { 0.0 };
                self.velocity + along * left
            }
        }
    }
}

/// Impulse per velocity (kg) that a dashpot of Lysmer & Kuhlemeyer (1969), c of `dashpots` N s/m in all at a node, takes from
/// it within a step, of the velocity that points brought:
///
/// ```text
/// J = c dt v = c dt sum_p m_p N_p v_p/m,   v_p -= N_p J/m
/// ```
///
/// By what brings it, it goes back, so that points lose the symmetric form v c v and no energy is made. Of the velocity after
/// forces it would keep back a part of these too, while stress is strained by all of them wherever points average velocities
/// first: that makes energy.
///
/// A node that has less than a step would take is stopped, as by a wall. One with half a cell of material has enough as long as
/// `c dt = density c_wave dt <= density cell/2`, the bound in [`crate::job::mpm::figures::bounds`].
pub fn absorbed([dashpot, dashpots]: [f64; 2], mass: f64, dt: f64) -> f64 {
    dashpot * dt * (mass / (dashpots * dt)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::Plane;

    type Vector = <Plane as Space>::Vector;

    fn hold(grip: Grip, separates: bool) -> Hold<Plane> {
        Hold { grip, separates, normal: Vector::new(0.0, 1.0), velocity: Vector::new(1.0, 0.0) }
    }

    #[test]
    fn what_presses_is_held_and_what_leaves_is_let_go() {
        let (pressing, leaving) = (Vector::new(3.0, -1.0), Vector::new(3.0, 1.0));
        let on = |grip: Grip, separates: bool, free: &Vector| hold(grip, separates).on(free, free);
        assert_eq!(on(Grip::Rough, true, &pressing), Vector::new(1.0, 0.0));
        assert_eq!(on(Grip::Smooth, true, &pressing), Vector::new(3.0, 0.0));
        assert_eq!(on(Grip::Coulomb(0.5), true, &pressing), Vector::new(2.5, 0.0));
        assert_eq!(on(Grip::Coulomb(4.0), true, &pressing), Vector::new(1.0, 0.0));
        for grip in [Grip::Rough, Grip::Smooth, Grip::Coulomb(0.5)] {
            assert_eq!(on(grip, true, &leaving), leaving);
            assert_eq!(on(grip, false, &leaving)[1], 0.0);
            // What is pushed back within the step has not left.
            assert_eq!(hold(grip, true).on(&leaving, &pressing)[1], 0.0);
        }
        // Nothing presses, so nothing rubs.
        assert_eq!(on(Grip::Coulomb(0.5), false, &leaving), Vector::new(3.0, 0.0));
    }

    #[test]
    fn dashpots_take_momentum_and_never_turn_it_round() {
        assert_eq!(absorbed([3.0, 3.0], 12.0, 2.0), 6.0);
        assert_eq!([1.0, 3.0].map(|dashpot| absorbed([dashpot, 4.0], 2.0, 1.0)), [0.5, 1.5]);
        assert_eq!([[0.0, 0.0], [3.0, 3.0]].map(|dashpots| absorbed(dashpots, 1.0, 0.0)), [0.0; 2]);
    }
}
