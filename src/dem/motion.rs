//! Motion of grains: leapfrog. Velocities live half a step behind positions, so that force at the position and
//! velocity known now kicks the velocity over the position (velocity Verlet with the forces' velocities lagging).

use crate::dem::grains::{Grains, Mover};
use crate::space::Space;

/// `v(n+1/2) = v(n-1/2) + f/(w m) dt` for free grains; `dt` is halved in the very first step of a run, whose velocities
/// are those of time zero.
pub fn kick<S: Space>(grains: &mut Grains<S>, dt: f64) {
    for row in 0..grains.owned {
        let cold = &grains.cold[row];
        if cold.mover != Mover::Free {
            continue;
        }
        let hot = &mut grains.hot[row];
        let mass = hot.weight * cold.mass;
        hot.velocity += grains.force[row] * (dt / mass);
        hot.spin += grains.torque[row] * (dt / S::grain_inertia(mass, hot.radius));
    }
}

/// `x(n+1) = x(n) + v(n+1/2) dt`; glued grains take their body's velocity, scripted ones their script's.
pub fn drift<S: Space>(grains: &mut Grains<S>, body_velocity: &[S::Vector], dt: f64) {
    for (hot, cold) in grains.hot[..grains.owned].iter_mut().zip(&grains.cold) {
        match cold.mover {
            Mover::Free => {}
            Mover::Body(body) => hot.velocity = body_velocity[body as usize],
            Mover::Script => hot.velocity = cold.script,
        }
        hot.position += hot.velocity * dt;
    }
}
