//! scree: granular matter under `mpirun`, as grains, as a continuum, and as both where shear localises.
//!
//! Crate map, from the ground up; a room imports from those above it in this list, and never the other way round.
//!
//! * [`base`]: errors, numbers, spaces, vectors of registers, records.
//! * [`law`]: forces of contacts and stresses of materials, a file each.
//! * [`bodies`]: rigid bodies, and what holds the nodes that they meet.
//! * [`dem`], [`mpm`], [`fem`]: grains, and the continuum of points and of elements; [`rve`]: assemblies of grains that stand for a point of one; [`couple`]: grains where the continuum
//!   shears itself into a band. Physics: they know neither ranks nor the text of jobs.
//! * [`job`]: the job, its units, checks and figures.
//! * [`domain`]: the world in blocks and the step as a table of contents; who holds what, what must be kept, what tells that something is
//!   wrong. From here up the partition is known.
//! * [`store`]: a world as tables; [`prepare`]: every way to come by grains and points; [`adapt`]: grains for points while a run goes on.
//! * [`observe`]: frames and what is in them; [`run`]: start, loop, output, folder.
//! * [`analysis`]: numbers from runs; [`mod@bench`]: speed; [`plot`]: pages; [`export`]: grains for other programs; [`cli`]: a file per subcommand.
//!
//! One word, one thing: a *block* owns *cells*, a *tile* holds its *nodes*; a *grain* is DEM, a *point* is MPM, a *contact* a
//! touching pair with memory; a *ghost* is a copy of a row another rank owns; a *zone* is where grains replaced points and
//! its *rim* the reconciliation zone where both live.

#![deny(missing_docs)]

pub mod adapt;
pub mod analysis;
pub mod base;
pub mod bench;
pub mod bodies;
pub mod cli;
pub mod couple;
pub mod dem;
pub mod domain;
pub mod export;
pub mod fem;
pub mod job;
pub mod law;
pub mod mpm;
pub mod observe;
pub mod plot;
pub mod prepare;
pub mod run;
pub mod rve;
pub mod store;
