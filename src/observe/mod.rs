//! What a run tells of itself: energies, stress, strain, the thickness of a band, and where its time goes.

pub mod band;
pub mod conservation;
pub mod contact_frame;
pub mod energy;
pub mod frame;
pub mod guard;
pub mod instant;
pub mod ledger;
pub mod local_strain;
pub mod phases;
pub mod point;
pub mod point_guard;
pub mod space_share;
pub mod strain;
pub mod strip;
