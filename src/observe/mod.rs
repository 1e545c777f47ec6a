//! What a run tells of itself: energies, stress, strain, the thickness of a band, and where its time goes.

pub mod contact_frame;
pub mod element_frame;
pub mod fields;
pub mod frame;
pub mod local_strain;
pub mod point;
pub mod rve_frame;
pub mod space_share;
pub mod strain;
