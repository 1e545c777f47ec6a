//! Small worlds and short jobs that the tests build theirs from.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use scree::checkpoint::PlanarPoint;
use scree::dem::grains::Mover;
use scree::ids::GrainId;
use scree::law::contact::LinearSpringDashpot;
use scree::law::material::CriticalDruckerPrager;
use scree::layout::Layout;
use scree::packing::{Grain, PlanarWorld};
use scree::rebuild::Parts;
use scree::scenario::{Contact, Scenario};
use scree::space::{Plane, Space};
use scree::world::Settings;
use scree_partition::Transport;

pub type Vector = <Plane as Space>::Vector;
pub type Tensor = <Plane as Space>::Tensor;

/// Table 1 of seed 000, with a damping to choose.
pub fn contact(damping: f64) -> Contact {
    Contact {
        stiffness_normal: 1_772_093.8,
        stiffness_tangential: 886_046.9,
        damping_normal: damping,
        damping_tangential: damping,
        friction: 0.5,
    }
}

/// The continuum of the quickstart.
pub fn material() -> CriticalDruckerPrager {
    CriticalDruckerPrager {
        bulk_modulus: 100e6,
        shear_modulus: 60e6,
        friction_critical: scree::math::tan(0.27),
        fraction_critical: 0.815,
        dilation_factor: 11.0,
        softening_rate: 3.0,
        cohesion: 0.0,
    }
}

/// A free grain, at rest.
pub fn grain(id: u64, position: [f64; 2], radius: f64, mass: f64) -> Grain {
    Grain::resting(GrainId(id), Vector::new(position[0], position[1]), radius, mass, Mover::Free)
}

pub fn settings(dt: f64, contact: Contact, radius_max: f64) -> Settings<LinearSpringDashpot, CriticalDruckerPrager> {
    Settings {
        dt,
        skin: 2e-4,
        radius_max,
        flip: 0.95,
        contact: LinearSpringDashpot { constants: contact },
        material: material(),
    }
}

/// A world without plates, 16 by 16 cells of `cell` m in blocks of 2, with y = 0 in the middle.
pub fn open_world<'t>(
    transport: &'t dyn Transport,
    cell: f64,
    settings: Settings<LinearSpringDashpot, CriticalDruckerPrager>,
    grains: Vec<Grain>,
    points: Vec<PlanarPoint>,
) -> PlanarWorld<'t> {
    let layout = Layout::plane([16, 16], 2, cell, [0.0, -8.0 * cell]).unwrap();
    PlanarWorld::new(settings, layout, transport, 0, Parts { grains, points, plates: Vec::new() }).unwrap()
}

/// Row of a grain that this rank owns.
pub fn row_of(world: &PlanarWorld, id: u64) -> usize {
    world.grains.cold[..world.grains.owned].iter().position(|cold| cold.id == GrainId(id)).expect("the grain is here")
}
