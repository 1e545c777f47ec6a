//! What is generic over the space is compiled anew by every crate that calls it, and a step reaches all of the engine. Such functions are
//! compiled here, once for each space, and whoever calls them for either is given the pointer.

use std::any::Any;

/// Of a function for the plane and the same for space, that of the space which `F` is of.
pub fn of_space<F: Copy + 'static>(both: [&'static dyn Any; 2]) -> F {
    *both.into_iter().find_map(|function| function.downcast_ref()).expect("a function of either space")
}
