//! Worlds of a few grains alone, in any space and under any law, that the tests of the grain engine build theirs from.

use scree::base::ids::GrainId;
use scree::base::space::{Linear as _, Plane, Solid, Space};
use scree::bodies::body::Body;
use scree::dem::assembly::Constants;
use scree::dem::cell::Cell;
use scree::dem::grains::{GrainRow, Hot, Mover};
use scree::dem::law::law_of;
use scree::domain::layout::{Ground, Layout};
use scree::domain::parts::Parts;
use scree::domain::world::{Settings, World};
use scree::law::contact::{
    Adhesion, Contact, ElasticRolling, HertzMindlin, LinearCohesive, LinearSpringDashpot, NormalForce,
    RollingResistance, Sliding, TangentialForce,
};
use scree::prepare::grain_world;
use scree_partition::{Solo, Transport};

pub type GrainWorld<'t, S> = grain_world::GrainWorld<'t, S>;

/// Radius (m) and mass (kg) of a grain that fits the laws below.
pub const RADIUS: f64 = 5e-4;
pub const MASS: f64 = 2e-5;

/// Table 1 of Chen et al. (2021) at half its damping.
pub fn linear() -> LinearSpringDashpot {
    LinearSpringDashpot {
        stiffness_normal: 1_772_093.8,
        stiffness_tangential: 886_046.9,
        damping_normal: 3.5,
        damping_tangential: 3.5,
        friction: 0.5,
        normal_force: NormalForce::TENSILE,
    }
}

/// The same with a pull-off force of 0.4 N and a shear strength of 0.2 N.
pub fn cohesive() -> LinearCohesive {
    let linear = linear();
    LinearCohesive { linear, cohesion_normal: 0.4, cohesion_tangential: 0.2 }
}

/// Of the stiffness of the linear law between two grains of [`RADIUS`].
pub fn elastic() -> ElasticRolling {
    ElasticRolling {
        young_modulus: 3.5e9,
        stiffness_ratio: 0.8,
        friction: 0.5,
        rolling_stiffness: 1.0,
        rolling_limit: 0.05,
        sliding: Sliding::Scaled,
    }
}

/// As stiff as the others at an overlap of a micrometre.
pub fn hertz() -> HertzMindlin {
    HertzMindlin {
        shear_modulus: 3e10,
        poisson_ratio: 0.2,
        friction: 0.5,
        damping_normal: 2.0,
        damping_tangential: 2.0,
        damping_ratio: 0.0,
        normal_force: NormalForce::TENSILE,
        tangential_force: TangentialForce::Incremental,
    }
}

/// The laws that have a dashpot, with one that only repels; that of Hertz contacts follows from masses as well.
pub fn linear_repulsive() -> LinearSpringDashpot {
    LinearSpringDashpot { normal_force: NormalForce::REPULSIVE, ..linear() }
}

pub fn cohesive_repulsive() -> LinearCohesive {
    let linear = linear_repulsive();
    LinearCohesive { linear, ..cohesive() }
}

pub fn hertz_repulsive() -> HertzMindlin {
    let normal_force = NormalForce::REPULSIVE;
    HertzMindlin { damping_ratio: 0.3, normal_force, ..hertz() }
}

/// Laws with the parts that go with any: resistance to rolling, adhesion, and both.
pub fn rolling() -> Contact {
    Contact { rolling: Some(RollingResistance { stiffness: 1.0, limit: 0.05 }), ..linear_repulsive().into() }
}

pub fn adhesive() -> Contact {
    Contact { adhesion: Some(Adhesion { surface_energy: 20.0 }), ..hertz().into() }
}

pub fn adhesive_rolling() -> Contact {
    Contact { adhesion: adhesive().adhesion, ..rolling() }
}

/// What is claimed of every law in every space.
pub trait Claim {
    fn hold<S: Space>(law: Contact);
}

pub fn for_every_law<T: Claim>() {
    in_space::<T, Plane>();
    in_space::<T, Solid>();
}

fn in_space<T: Claim, S: Space>() {
    T::hold::<S>(linear().into());
    T::hold::<S>(cohesive().into());
    T::hold::<S>(elastic().into());
    T::hold::<S>(hertz().into());
    T::hold::<S>(linear_repulsive().into());
    T::hold::<S>(cohesive_repulsive().into());
    T::hold::<S>(hertz_repulsive().into());
    T::hold::<S>(rolling());
    T::hold::<S>(adhesive());
    T::hold::<S>(adhesive_rolling());
}

/// The components of three that a space has.
pub fn vector<S: Space>(components: [f64; 3]) -> S::Vector {
    let mut vector = S::Vector::zero();
    for axis in 0..S::DIMENSION {
        vector[axis] = components[axis];
    }
    vector
}

/// A spin about the axes that a space has: in the plane about z.
pub fn spin<S: Space>(components: [f64; 3]) -> S::Spin {
    let mut spin = S::Spin::zero();
    for axis in 0..S::Spin::COMPONENTS {
        spin[axis] = components[3 - S::Spin::COMPONENTS + axis];
    }
    spin
}

/// What a world of grains alone is made from.
#[derive(Clone)]
pub struct Few<S: Space> {
    pub grains: Vec<GrainRow<S>>,
    pub bodies: Vec<Body<S>>,
    pub cell: Cell<S>,
    pub settings: Settings<S>,
}

impl<S: Space> Few<S> {
    /// No grains yet, in an open cube of `edge` m about the origin.
    pub fn new(contact: impl Into<Contact>, dt: f64, edge: f64) -> Self {
        let cell = Cell::cuboid(vector::<S>([-0.5 * edge; 3]), vector::<S>([edge; 3]), [false; 3]);
        let settings = Settings::of_grains(Constants::new(dt, 0.02 * edge, law_of(&contact.into())));
        Self { grains: Vec::new(), bodies: Vec::new(), cell, settings }
    }

    /// The same in a box that is periodic along every axis.
    pub fn periodic(contact: impl Into<Contact>, dt: f64, corner: [f64; 3], lengths: [f64; 3]) -> Self {
        let cell = Cell::cuboid(vector::<S>(corner), vector::<S>(lengths), [true; 3]);
        Self { cell, ..Self::new(contact, dt, lengths[0]) }
    }

    /// A free grain at rest; ids count up from 0.
    pub fn add(&mut self, position: [f64; 3], radius: f64, mass: f64) -> &mut GrainRow<S> {
        let id = GrainId(self.grains.len() as u64);
        self.grains.push(GrainRow::<S>::resting(id, vector::<S>(position), radius, mass, Mover::Free));
        self.grains.last_mut().expect("one was added")
    }

    pub fn world(self) -> GrainWorld<'static, S> {
        self.world_on(&Solo)
    }

    pub fn world_on(self, transport: &dyn Transport) -> GrainWorld<'_, S> {
        let Self { grains, bodies, cell, settings } = self;
        let corner = std::array::from_fn(|axis| if axis < S::DIMENSION { cell.corner[axis] } else { 0.0 });
        let edge = cell.edges[0];
        let ground = Ground::open([8; 3], 4, edge / 8.0, corner, cell.periodic);
        let layout = Layout::new::<S>(ground).unwrap();
        World::new(settings, layout, transport, 0, Parts::fresh(grains, Vec::new(), bodies, cell)).unwrap()
    }
}

/// Row of a grain in a world on one rank.
pub fn row_of<S: Space>(world: &GrainWorld<S>, id: u64) -> usize {
    world.assembly.grains.cold.iter().position(|cold| cold.id == GrainId(id)).expect("the grain is here")
}

pub fn hot_of<S: Space>(world: &GrainWorld<S>, id: u64) -> Hot<S> {
    world.assembly.grains.hot[row_of(world, id)]
}

/// Force and torque of the last evaluation on a grain; gone at a rebuild.
pub fn load_on<S: Space>(world: &GrainWorld<S>, id: u64) -> (S::Vector, S::Spin) {
    let row = row_of(world, id);
    (world.assembly.grains.force[row], world.assembly.grains.torque[row])
}

/// After the last of them the forces may be asked for.
pub fn steps<S: Space>(world: &mut GrainWorld<S>, count: usize) {
    for step in 0..count {
        world.assembly.forces_wanted = step + 1 == count;
        world.advance().unwrap();
    }
}
