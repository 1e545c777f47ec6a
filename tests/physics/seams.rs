//! Whoever adds a contact law, a material law or a method writes it beside the program: this file adds one of each by what the library
//! makes public, and touches nothing else. The method lets two discs collide under the one law beside a block of fluid that is
//! the other.

use std::f64::consts::PI;
use std::sync::Arc;

use scree::base::error::Error;
use scree::base::ids::{GrainId, PointId};
use scree::base::lane::Real;
use scree::base::record::{Record, Visitor};
use scree::base::space::{Components, Plane, Space, Words};
use scree::base::symmetric::Symmetric;
use scree::dem::assembly::Constants;
use scree::dem::grains::{GrainRow, Mover};
use scree::dem::law::SharedLaw;
use scree::domain::accounts::ledger::Accounts;
use scree::domain::grid::Grid;
use scree::domain::layout::Layout;
use scree::domain::parts::Parts;
use scree::domain::world::{Settings, World};
use scree::job::Output;
use scree::law::contact::{Answer, ContactLaw, Springs as Stiffness, Touch};
use scree::law::material::{MaterialLaw, MaterialMemory};
use scree::mpm::membrane::{Membranes, Vertex};
use scree::mpm::points::Point;
use scree::mpm::stress::{SharedMaterial, StressModel};
use scree::numbers;
use scree::prepare::sheared::cell_of;
use scree::run::Core;
use scree::run::columns::{self, Columns};
use scree::run::experiment::{Experiment, Picture, Setup};
use scree::run::folder::Folder;
use scree::run::start::{start_setup, world_of};
use scree::store::checkpoint::{self, Drawn, Progress};
use scree_partition::transport::threads;
use scree_partition::{Solo, Transport};

use crate::runs::{done, options, result};
use crate::worlds::Vector;

/// A contact law: springs that repel, and nothing else.
#[derive(Clone, Copy, Debug)]
struct Springs {
    /// k, N/m.
    stiffness: f64,
}

impl<S: Space> ContactLaw<S> for Springs {
    type Memory<R: Real> = Components<R, 1>;

    fn force<R: Real>(&self, touch: &Touch<S, R>, _: &mut Self::Memory<R>) -> Answer<S, R> {
        let normal = touch.overlap * R::splat(self.stiffness);
        Answer { normal, tangential: Words::zero(), moment: Words::zero() }
    }
    fn springs(&self, touch: &Touch<S, f64>, memory: &Self::Memory<f64>) -> Answer<S, f64> {
        self.force(touch, &mut memory.clone())
    }
    fn stiffness(&self, _: [f64; 2], _: [f64; 2], _: f64) -> Stiffness {
        Stiffness { normal: self.stiffness, ..Stiffness::default() }
    }
    fn friction_limit(&self, _: &Touch<S, f64>, _: f64) -> f64 {
        0.0
    }
    fn elastic_energy(&self, touch: &Touch<S, f64>, _: &Self::Memory<f64>) -> f64 {
        0.5 * self.stiffness * touch.overlap * touch.overlap
    }
}

/// A material law: a fluid without viscosity, `tau = K (J - 1) I`.
#[derive(Clone, Copy, Debug)]
struct Fluid {
    /// K, Pa.
    bulk_modulus: f64,
}

/// J - 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
struct Dilation {
    dilation: f64,
}

numbers!(impl[] Dilation[] { dilation: f64 });

impl Record for Dilation {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("dilation", std::slice::from_mut(&mut self.dilation));
    }
}

impl MaterialMemory for Dilation {
    fn plastic_strain(&self) -> f64 {
        0.0
    }
    fn fraction(&self) -> f64 {
        1.0 / (1.0 + self.dilation)
    }
}

impl<S: Space> MaterialLaw<S> for Fluid {
    type Memory = Dilation;

    fn start(&self, stress: &S::Tensor, _: f64) -> Dilation {
        Dilation { dilation: S::Symmetric::of(stress).trace() / S::DIMENSION as f64 / self.bulk_modulus }
    }
    fn update_counted(&self, gradient: &S::Tensor, dt: f64, memory: &mut Dilation, _: &mut f64) -> S::Tensor {
        let step = S::identity() + *gradient * dt;
        let ratio = S::determinant(&step);
        memory.dilation = (1.0 + memory.dilation) * ratio - 1.0;
        MaterialLaw::<S>::stress(self, memory)
    }
    fn stress(&self, memory: &Dilation) -> S::Tensor {
        S::identity() * (self.bulk_modulus * memory.dilation)
    }
    fn out_of_plane(&self, memory: &Dilation) -> f64 {
        self.bulk_modulus * memory.dilation
    }
    fn elastic_energy(&self, memory: &Dilation) -> f64 {
        0.5 * self.bulk_modulus * memory.dilation * memory.dilation
    }
    fn p_wave_modulus(&self) -> f64 {
        self.bulk_modulus
    }
    fn shear_modulus(&self) -> f64 {
        0.0
    }
}

const CELL: f64 = 0.01;
const STEP: f64 = 1e-6;
const STEPS: u64 = 400;
const RADIUS: f64 = 2e-3;
const MASS: f64 = 1e-4;
const SPEED: f64 = 0.5;
const SPRINGS: Springs = Springs { stiffness: 1e5 };
const FLUID: Fluid = Fluid { bulk_modulus: 1e6 };
const DENSITY: f64 = 1000.0;
/// Of the fluid's motion towards its middle, 1/s.
const RATE: f64 = -20.0;

/// A method: discs and a fluid.
struct DiscsAndFluid {
    output: Output,
}

impl DiscsAndFluid {
    fn layout() -> Result<Layout, Error> {
        Layout::plane([24, 16], 4, CELL, [0.0, -8.0 * CELL]).map_err(Error::User)
    }

    /// Discs on the right that meet, and on the left a block of fluid that is squeezed.
    fn parts(transport: &dyn Transport) -> Result<Parts<Plane>, Error> {
        let cell = cell_of(&Self::layout()?);
        if transport.rank() > 0 {
            return Ok(Parts::fresh(Vec::new(), Vec::new(), Vec::new(), cell));
        }
        let disc = |id: u64, side: f64| {
            let place = Vector::new(0.2 + side * (RADIUS + 1e-5), 0.0);
            let mut disc = GrainRow::resting(GrainId(id), place, RADIUS, MASS, Mover::Free);
            disc.hot.velocity = Vector::new(-side * SPEED, 0.0);
            disc
        };
        let volume = 0.25 * CELL * CELL;
        let middle = Vector::new(0.06, 0.0);
        let point = |number: u64| {
            let at = Vector::new((number % 12) as f64, (number / 12) as f64) * (0.5 * CELL);
            let place = at + Vector::new(0.25 * CELL, 0.25 * CELL) + middle - Vector::new(3.0 * CELL, 3.0 * CELL);
            let mut point = Point::resting(PointId(number), place, DENSITY * volume, volume);
            point.hot.velocity = (place - middle) * RATE;
            point.hot.memory = StressModel::<Plane>::start(&FLUID, &(Plane::identity() * 0.0), 1.0);
            point
        };
        Ok(Parts::fresh(vec![disc(0, -1.0), disc(1, 1.0)], (0..144).map(point).collect(), Vec::new(), cell))
    }
}

impl Setup for DiscsAndFluid {
    type Space = Plane;

    fn experiment(&self) -> Experiment<'_, Plane> {
        let clock = Columns::new(["step", "time"], |core| Ok(vec![core.world.step as f64, core.world.time()]));
        let approach = Columns::new(["approach"], |core: &mut Core<Plane>| {
            let grains = &core.world.assembly.grains;
            let mut of_discs = [0.0_f64; 2];
            for (hot, cold) in grains.hot[..grains.owned].iter().zip(&grains.cold) {
                of_discs[cold.id.0 as usize] = hot.velocity[0];
            }
            // Each disc is on one rank, and zero elsewhere.
            let mut bits = of_discs.map(|velocity| velocity.to_bits() as i64);
            core.world.transport.sum(&mut bits);
            let [left, right] = bits.map(|bits| f64::from_bits(bits as u64));
            Ok(vec![left - right])
        });
        Experiment {
            job: "name = \"discs and fluid\"\n".to_string(),
            output: &self.output,
            steps: STEPS,
            accounts: Accounts::GRAINS,
            allows_unstable: false,
            picture: Picture {
                depth: 1.0,
                may_have_grains: true,
                may_have_points: true,
                has_elements: false,
                flagged: false,
            },
            drawn_rves: Vec::new(),
            columns: vec![clock, approach, columns::counts(), columns::energies()],
            watch: Box::new(|_| Ok(())),
            strain: None,
        }
    }

    fn law(&self) -> SharedLaw<Plane> {
        Arc::new(SPRINGS)
    }

    fn material(&self) -> SharedMaterial<Plane> {
        Arc::new(FLUID)
    }

    fn begin<'t>(
        &self,
        _: &mut Option<Folder>,
        transport: &'t dyn Transport,
    ) -> Result<(World<'t, Plane>, Progress), Error> {
        let progress = Progress { fraction_start: 1.0, ..Progress::default() };
        Ok((self.world_at(&progress, Self::parts(transport)?, transport)?, progress))
    }

    fn drawn(&self, _: &Progress, _: Vec<Vertex<Plane>>) -> Result<Drawn<Plane>, Error> {
        Ok(Drawn { cell: cell_of(&Self::layout()?), bodies: Vec::new(), membranes: Membranes::default() })
    }

    fn world_at<'t>(
        &self,
        progress: &Progress,
        parts: Parts<Plane>,
        transport: &'t dyn Transport,
    ) -> Result<World<'t, Plane>, Error> {
        let settings = Settings {
            grid: Grid::blend(1.0),
            material: self.material(),
            ..Settings::of_grains(Constants::new(STEP, 0.1 * RADIUS, self.law()))
        };
        World::new(settings, Self::layout()?, transport, progress.step, parts)
    }
}

/// The laws do what they say, and the method has the same bits on three ranks and from a checkpoint.
#[test]
fn a_contact_law_a_material_law_and_a_method_are_added_beside_the_program() {
    let duration = STEPS as f64 * STEP;
    let method = DiscsAndFluid { output: Output { series_interval: STEP, ..Output::of_run(duration, STEP) } };
    let folder = tempfile::tempdir().unwrap();
    let alone = folder.path().join("alone");
    done(start_setup(&method, &options(&alone), &Solo));

    // Two masses on a spring: half a period of sqrt(2 k/m), after which each has gone the other way as fast.
    let series = std::fs::read_to_string(alone.join("series.csv")).unwrap();
    let mut lines = series.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(names[..5], ["step", "time", "approach", "grains", "points"]);
    let approach: Vec<f64> = lines.map(|line| line.split(',').nth(2).unwrap().parse().unwrap()).collect();
    assert!((approach.last().unwrap() / (-2.0 * SPEED) - 1.0).abs() < 1e-3, "{:?}", approach.last());
    let touching = approach.iter().filter(|speed| speed.abs() < 2.0 * SPEED * (1.0 - 1e-9)).count() as f64 * STEP;
    let wanted = PI * (MASS / (2.0 * SPRINGS.stiffness)).sqrt();
    assert!((touching - wanted).abs() < 4.0 * STEP, "{touching} s for {wanted}");

    // Squeezed from all sides by the same rate, the middle of the fluid bears what its volume says.
    let (_, state) = checkpoint::latest_state(&alone).unwrap();
    let (world, progress) = world_of(&method, Some(state), &Solo).unwrap();
    assert_eq!(progress.step, STEPS);
    let middle = world.continuum.points.rows().find(|point| point.cold.id == PointId(5 * 12 + 5)).unwrap();
    let ratio = middle.hot.volume_ratio();
    assert!((ratio - (1.0 + 2.0 * RATE * duration)).abs() < 1e-3, "{ratio}");
    let pressure = -middle.hot.kirchhoff()[0];
    assert!((pressure / (FLUID.bulk_modulus * (1.0 - ratio)) - 1.0).abs() < 1e-9, "{pressure} Pa at {ratio}");

    let together = folder.path().join("together");
    threads::run(3, |rank| done(start_setup(&method, &options(&together), &rank)));
    assert!(result(&together) == result(&alone), "three ranks have other bits");
}
