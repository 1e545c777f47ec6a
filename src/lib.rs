//! scree: granular matter under `mpirun`, as grains, as a continuum, and as both where shear localises.
//!
//! Crate map, from the operator inwards; imports run one way.
//!
//! * [`cli`]: one file per subcommand; [`scenario`]: the job, checked once.
//! * [`run`]: the loop of step, observe, save, stop; [`checkpoint`]: a world as tables; [`soundness`]: whether they are one.
//! * [`world`]: the state in blocks and the step as a table of contents; [`rebuild`], [`balance`] and [`layout`]: who holds what; [`plan`]: what it would cost elsewhere;
//!   [`enrichment`]: grains for points, [`adapt`]: when. These alone call the partition.
//! * [`dem`], [`mpm`], [`hybrid`]: grains, continuum, and what couples them. They do not know ranks.
//! * [`calibrate`]: the figures of the continuum from element tests of a job's grains.
//! * [`law`]: forces and stresses; [`space`], [`symmetric`], [`lane`], [`numbers`], [`zeroed`], [`math`], [`ids`]: the ground.
//!
//! One word, one thing: a *block* owns *cells*, a *tile* holds its *nodes*; a *grain* is DEM, a *point* is MPM, a *contact* a
//! touching pair with memory; a *ghost* is a copy of a row another rank owns; a *zone* is where grains replaced points and
//! its *rim* the reconciliation zone where both live.

pub mod adapt;
pub mod assembly;
pub mod balance;
pub mod bench;
pub mod body;
pub mod burden;
pub mod calibrate;
pub mod changes;
pub mod checkpoint;
pub mod cli;
pub mod continuum;
pub mod coupled;
pub mod cycle;
pub mod dem;
pub mod enrichment;
pub mod error;
pub mod full_step;
pub mod grain_dump;
pub mod grain_export;
pub mod grain_file;
pub mod grid;
pub mod grid_step;
pub mod hybrid;
pub mod ids;
pub mod lane;
pub mod law;
pub mod layout;
pub mod log;
pub mod math;
pub mod membrane_step;
pub mod mpm;
pub mod numbers;
pub mod observe;
pub mod output;
pub mod packing;
pub mod parallel;
pub mod plan;
pub mod planar_shear;
pub mod prepare;
pub mod program;
pub mod rebuild;
pub mod record;
pub mod reference;
pub mod results;
pub mod run;
pub mod scenario;
pub mod servo;
pub mod soundness;
pub mod space;
pub mod specimen;
pub mod start;
pub mod stop;
pub mod summary;
pub mod symmetric;
pub mod tables;
pub mod transfer;
pub mod watch;
pub mod world;
pub mod zeroed;
