//! The Hilbert curve of any dimension, after J. Skilling, "Programming the Hilbert curve", AIP
//! Conf. Proc. 707 (2004).

/// Distance along the Hilbert curve of the cube of side `2^bits` at which `point` is met.
///
/// Points next to each other on the curve are next to each other in space, so a stretch of the
/// curve is a compact region.
///
/// # Panics
/// When the key would not fit 64 bits or the point lies outside the cube.
pub fn key<const D: usize>(point: [usize; D], bits: u32) -> u64 {
    assert!(D as u32 * bits <= 64, "a Hilbert key of {D} axes with {bits} bits each does not fit 64 bits");
    assert!(point.iter().all(|&x| (x as u64) >> bits == 0), "{point:?} lies outside a cube of side 2^{bits}");
    if bits == 0 {
        return 0;
    }
    interleave(transpose(point.map(|x| x as u64), bits), bits)
}

/// Skilling's transposed form: the key's bits dealt in turn to the axes, most significant first.
fn transpose<const D: usize>(mut x: [u64; D], bits: u32) -> [u64; D] {
    // Undo, from the coarsest level down, the reflections and swaps that orient each sub-cube.
    for level in (1..bits).rev() {
        let bit = 1 << level;
        let below = bit - 1;
        for axis in 0..D {
            if x[axis] & bit != 0 {
                x[0] ^= below;
            } else {
                let swapped = (x[0] ^ x[axis]) & below;
                x[0] ^= swapped;
                x[axis] ^= swapped;
            }
        }
    }
    // Gray code, so that neighbouring keys differ in one coordinate.
    for axis in 1..D {
        x[axis] ^= x[axis - 1];
    }
    let flips = (1..bits).filter(|level| x[D - 1] >> level & 1 != 0).fold(0, |flips, level| flips ^ ((1 << level) - 1));
    x.map(|axis| axis ^ flips)
}

fn interleave<const D: usize>(x: [u64; D], bits: u32) -> u64 {
    (0..bits).rev().fold(0, |key, level| x.iter().fold(key, |key, axis| key << 1 | (axis >> level & 1)))
}
