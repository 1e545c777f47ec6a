//! Representative volume elements (RVEs): periodic assemblies of grains, each of which stands for a material point or an element and
//! answers to its deformation gradient with a stress (Liang & Zhao 2019, section 2.3; Liu et al. 2016, section 2). It does not know what
//! it stands for, nor ranks.
//!
//! * [`drive`]: how the cell gets from one deformation to the next, and in how many steps of its grains.
//! * [`step`]: a step of grains in a cell whose edges go straight.
//! * [`kick_drift`]: how it moves them.
//! * [`measure`]: stress, fabric and the like, summed over contacts in the order of ids.
//! * [`levels`]: one assembly under several stresses.
//! * [`rest`]: all that an assembly is between two increments, in a few numbers.
//! * [`rows`]: RVEs beside the material points that they stand for.
//! * [`volume_element`]: an assembly with its deformation, its loose state and what becomes of a cell that gets too thin.

pub mod drive;
pub mod kick_drift;
pub mod levels;
pub mod measure;
pub mod renew;
pub mod rest;
pub mod rows;
pub mod step;
pub mod volume_element;

pub use drive::{Drive, Frame, Pace};
pub use measure::Measured;
pub use rest::{Packing, Resting, Template};
pub use rows::{GrainMaterial, Packings, PointRve, RveRow};
pub use step::{Scratch, Scratches};
pub use volume_element::{Bearing, Events, Response, Rve};
