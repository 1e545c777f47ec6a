//! Volume strain, averaged over nodes where material flows.
//!
//! Two points per axis and cell have more volume strains than the nodes have velocities for. What single points gain and lose against the
//! mean of their cell is undone by elastic material, and kept for ever by one that flows in between: stresses of single points become
//! noise about the mean of their cell, without effect on forces at nodes. So the volume strain that a point remembers, that of its mean
//! stress and of what has opened, is drawn towards the mean of those around it, as far as they flow:
//!
//! ```text
//! theta_p = p_p/K + gap_p,   r_p = min(1, lambda_p/lambda_c),   q_p = w_p m_p r_p
//! theta_i = sum_p q_p N_i(x_p) theta_p / sum_p q_p N_i(x_p)
//! theta_p <- theta_p + r_p (sum_i N_i(x_p) theta_i - theta_p)
//! ```
//!
//! p: mean stress, lambda: plastic strain of the last step, w: weight of the point. The change is part of the velocity gradient,
//! `(dtheta/(d dt)) I`, for the law and for F alike, d being the dimension. `sum q theta` stays what it is; points that do not flow take no
//! part, so that elastic material is left alone to the bit, and within the plastic strain lambda_c they forget what is finer than the
//! grid, whatever the length of a step.
//!
//! The law's energy changes by `V_0 p dtheta` in it: without cohesion it falls, since squares of averages are less than averages of
//! squares. It is counted per point.

use crate::base::lane::Real;
use crate::law::material::Flow;
use crate::numbers;

/// lambda_c.
pub const STRAIN_FORGOTTEN: f64 = 1e-3;

/// What the averaging knows of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Volumetric {
    /// theta, as of the last stress.
    pub strain: f64,
    /// r, of the last step.
    pub flowing: f64,
    /// Energy that averaging has taken from the point since the start, J per initial volume (m3).
    pub lost: f64,
}

numbers!(impl[] Volumetric[] { strain: f64, flowing: f64, lost: f64 });

/// `sum q N` (kg) and `sum q N theta` (kg) of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VolumetricNode(pub [f64; 2]);

impl VolumetricNode {
    /// Of a node around which nothing flows.
    pub const ZERO: Self = Self([0.0; 2]);

    /// What another tile brings to the same node.
    pub fn add(&mut self, other: &Self) {
        self.0[0] += other.0[0];
        self.0[1] += other.0[1];
    }

    /// theta_i; zero where nothing flows.
    pub fn mean(&self) -> f64 {
        if self.0[0] > 0.0 { self.0[1] / self.0[0] } else { 0.0 }
    }
}

/// r of a step between what the law said before it and what it says after it.
#[inline(always)]
pub fn flowing<R: Real>(before: &Flow<R>, after: &Flow<R>) -> R {
    let share = (after.plastic_strain - before.plastic_strain) * R::splat(1.0 / STRAIN_FORGOTTEN);
    share.min(R::splat(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::ids::PointId;
    use crate::base::lane::Instructions;
    use crate::base::space::{Linear, Plane, Solid, Space};
    use crate::mpm::look::for_each_node;
    use crate::mpm::points::{Hot, Point};
    use crate::mpm::scatter::{Scattered, TileFrame, scatter_points};
    use crate::mpm::scheme::ShapeFunction;
    use crate::mpm::shape::Axis;
    use crate::mpm::tile::Gathered;

    const EDGE: usize = 9;

    /// Points at random in the middle of a tile, some of which flow.
    fn points<S: Space>(count: usize) -> (Vec<Hot<S>>, Vec<Volumetric>) {
        let mut state = 1.0_f64;
        let mut random = || {
            state = (state * 16_807.0) % 2_147_483_647.0;
            state / 2_147_483_647.0
        };
        let mut point = |number: usize| {
            let mut place = S::Vector::zero();
            (0..S::DIMENSION).for_each(|axis| place[axis] = 1.2 + 1.4 * random());
            let mut hot = Point::<S>::resting(PointId(number as u64), place, 0.5 + random(), 1.0).hot;
            hot.weight = 0.5 + 0.5 * random();
            let flowing = if random() < 0.3 { 0.0 } else { random() };
            (hot, Volumetric { strain: random() - 0.7, flowing, lost: 0.0 })
        };
        (0..count).map(&mut point).unzip()
    }

    fn conserves<S: Space>(shape: ShapeFunction) {
        let frame = TileFrame::<S> {
            corner: S::Vector::zero(),
            cell: 0.5,
            cell_inverse: 2.0,
            edge: EDGE,
            inside: [[2.0, 6.0]; 3],
            axes: [Axis { half: 0.25, ..Axis::default() }; 3],
        };
        let nodes = EDGE.pow(S::DIMENSION as u32);
        let (hot, volumetric) = points::<S>(35);
        let (mut tile, mut sums) = (vec![Gathered::zero(); nodes], vec![VolumetricNode::ZERO; nodes]);
        let scattered = Scattered { points: &hot, beside: &[], volumetric: &volumetric };
        scatter_points(&frame, (shape, false, Instructions::best()), scattered, (&mut tile, &mut sums));
        let (mut moved, mut volume, mut before, mut after) = (0.0, 0.0, 0.0, 0.0);
        for (hot, point) in hot.iter().zip(&volumetric) {
            let mut mean = 0.0;
            for_each_node(&frame, shape, &hot.position, |node, value| mean += value * sums[node].mean());
            let (mass, change) = (hot.weight * hot.mass, point.flowing * (mean - point.strain));
            assert!(point.flowing > 0.0 || change == 0.0);
            moved += mass * change;
            volume += mass * change.abs();
            before += mass * point.strain * point.strain;
            after += mass * (point.strain + change) * (point.strain + change);
        }
        assert!(volume > 1.0, "nothing was averaged");
        assert!(moved.abs() < 1e-14 * volume, "{shape:?}: {moved} of {volume} have gone");
        assert!(after < 0.999 * before, "{shape:?}: squares grew from {before} to {after}");
    }

    /// What one point gains others lose, and what is elastic in a volume strain never gains energy, whatever flows beside what does not.
    #[test]
    fn averaging_keeps_volume_and_loses_energy() {
        for (_, shape) in ShapeFunction::NAMES {
            conserves::<Plane>(shape);
            conserves::<Solid>(shape);
        }
    }

    /// A step of the length lambda_c forgets all, half of it half.
    #[test]
    fn points_forget_with_their_plastic_strain() {
        let at = |plastic_strain: f64| Flow { volume: 0.0, plastic_strain };
        assert_eq!(flowing(&at(0.25), &at(0.25)), 0.0);
        assert!((flowing(&at(0.0), &at(0.5 * STRAIN_FORGOTTEN)) - 0.5).abs() < 1e-15);
        assert_eq!(flowing(&at(0.0), &at(3.0 * STRAIN_FORGOTTEN)), 1.0);
    }
}
