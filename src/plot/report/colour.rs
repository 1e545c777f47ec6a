//! Colours that stay apart for every kind of colour vision.

/// Lines of several runs: Okabe and Ito (2008), without yellow, which is too pale for a line.
pub const LINES: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#000000"];

/// Dashes of lines that share a colour.
pub const DASHES: [&str; 6] = ["", "7 3", "2 2", "8 2 2 2", "12 4", "8 2 2 2 2 2"];

/// Fill of a row whose strain is not known.
pub const UNKNOWN: &str = "#bdbdbd";
/// Fill of what belongs to a plate.
pub const PLATE: &str = "#6e6e6e";

/// Steps of the colour map that rows are drawn in; few enough to group rows by colour, enough to look smooth.
pub const STEPS: usize = 64;

/// The viridis map (van der Walt and Smith 2015), perceptually uniform, at eleven equal distances.
const VIRIDIS: [[u8; 3]; 11] = [
    [0x44, 0x01, 0x54],
    [0x48, 0x24, 0x75],
    [0x41, 0x44, 0x87],
    [0x35, 0x5f, 0x8d],
    [0x2a, 0x78, 0x8e],
    [0x21, 0x91, 0x8c],
    [0x22, 0xa8, 0x84],
    [0x44, 0xbf, 0x70],
    [0x7a, 0xd1, 0x51],
    [0xbd, 0xdf, 0x26],
    [0xfd, 0xe7, 0x25],
];

/// The colour of run number `index`; `#rrggbb`.
pub fn line(index: usize) -> &'static str {
    LINES[index % LINES.len()]
}

/// The step of the map that `share` (0 to 1, cut there) falls into.
pub fn step(share: f64) -> usize {
    ((share.clamp(0.0, 1.0) * STEPS as f64) as usize).min(STEPS - 1)
}

/// The map's colour at the middle of `step`; `#rrggbb`.
pub fn map(step: usize) -> String {
    assert!(step < STEPS, "step {step} of {STEPS}");
    let place = step as f64 / (STEPS - 1) as f64 * (VIRIDIS.len() - 1) as f64;
    let below = (place as usize).min(VIRIDIS.len() - 2);
    let share = place - below as f64;
    let [r, g, b] = [0, 1, 2].map(|channel| {
        let (from, to) = (f64::from(VIRIDIS[below][channel]), f64::from(VIRIDIS[below + 1][channel]));
        (from + share * (to - from)).round() as u8
    });
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_runs_from_dark_to_light() {
        assert_eq!(map(0), "#440154");
        assert_eq!(map(STEPS - 1), "#fde725");
        let lightness = |step| {
            let colour = u32::from_str_radix(&map(step)[1..], 16).unwrap();
            0.2126 * f64::from(colour >> 16) + 0.7152 * f64::from(colour >> 8 & 255) + 0.0722 * f64::from(colour & 255)
        };
        assert!((1..STEPS).all(|step| lightness(step) > lightness(step - 1)));
    }

    #[test]
    fn shares_beyond_the_map_are_cut() {
        assert_eq!((step(-1.0), step(0.0), step(1.0), step(7.0)), (0, 0, STEPS - 1, STEPS - 1));
    }
}
