//! The element test of an RVE by itself, under the boundary conditions of the element: compressed along y as far as it is told, under a
//! constant stress along x, without shear stress on any side.

use nalgebra::{DMatrix, DVector};
use scree::base::space::Space;
use scree::base::symmetric::Symmetric;
use scree::rve::{Drive, Rve, Scratch};

/// What is left of a stress that ought not to be there, over the pressure, where grains let it in so many tries.
const TOLERANCE: f64 = 1e-5;
const TRIES: usize = 16;

/// A stretch of no meaning: what an RVE comes apart from itself by, whose path is as much longer, is the least that two tests agree to.
const SHAKEN: f64 = 1e-9;
/// To half a per cent few grains rearrange.
const EARLY: f64 = 0.995;

/// The largest differences of stress along y over that along x, as shares.
pub struct Off {
    /// Between the element and its RVE alone, to half a per cent of strain or to the peak; to the peak.
    pub early: f64,
    pub to_peak: f64,
    /// Between the RVE on the element's path and on the same times [`SHAKEN`] more, as far.
    pub shaken_early: f64,
    pub shaken: f64,
    /// Of the lateral stress of the element from the pressure; what is left of stresses that ought not to be there of the RVE alone, over it.
    pub across: f64,
    pub left: f64,
    /// Largest ratio of the RVE alone, and the stretch there.
    pub peak: [f64; 2],
}

impl std::fmt::Display for Off {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [ratio, along] = self.peak;
        write!(
            f,
            "off its RVE alone by {:.1e} to {EARLY}, {:.1e} to the peak of {ratio:.3} at {along:.5}; an RVE whose path is {SHAKEN:e} longer off itself by {:.1e}, {:.1e}; lateral stress of the element {:.1e} off, stresses left of the RVE {:.1e}",
            self.early, self.to_peak, self.shaken_early, self.shaken, self.across, self.left
        )
    }
}

/// An element beside its RVE alone.
pub struct Beside<S: Space> {
    alone: Alone<S>,
    /// On the element's own path, and on one that is no other.
    along: [Rve<S>; 2],
    pressure: f64,
    /// Stretch along y, ratio of the RVE alone, what the element is off it by, and the shaken RVE off the other.
    rows: Vec<[f64; 4]>,
    across: f64,
    left: f64,
}

impl<S: Space> Beside<S> {
    pub fn new(rve: &Rve<S>, pressure: f64, drive: Drive) -> Self {
        let alone = Alone::new(rve.clone(), pressure, drive);
        Self { alone, along: [rve.clone(), rve.clone()], pressure, rows: Vec::new(), across: 0.0, left: 0.0 }
    }

    /// Stretch along y by now.
    pub fn along(&self) -> f64 {
        self.rows.last().map_or(1.0, |row| row[0])
    }

    /// What an element bears along x and y (Pa, compression positive) where it has come to by an increment that lasted `duration` (s).
    pub fn compare(&mut self, borne: [f64; 2], deformation: &S::Tensor, duration: f64) {
        let along = deformation[S::DIMENSION + 1];
        let (ratio, left) = self.alone.compress(along, duration);
        let Alone { drive, scratch, .. } = &mut self.alone;
        let [one, other] = [(0, 1.0), (1, 1.0 + SHAKEN)].map(|(row, stretch)| {
            let rve: &mut Rve<S> = &mut self.along[row];
            let answer = rve.follow(&(*deformation * stretch), duration, drive, scratch).unwrap().kirchhoff.tensor();
            answer[S::DIMENSION + 1] / answer[0]
        });
        self.rows.push([along, ratio, (borne[1] / borne[0] / ratio - 1.0).abs(), (other / one - 1.0).abs()]);
        self.across = self.across.max((borne[0] / self.pressure - 1.0).abs());
        self.left = self.left.max(left);
    }

    pub fn off(&self) -> Off {
        let peak =
            self.rows.iter().fold([0.0, 1.0], |most, row| if row[1] > most[0] { [row[1], row[0]] } else { most });
        let worst = |column: usize, since: f64| {
            self.rows.iter().filter(|row| row[0] >= since).fold(0.0_f64, |most, row| most.max(row[column]))
        };
        let [early, to_peak] = [EARLY.max(peak[1]), peak[1]].map(|since| worst(2, since));
        let [shaken_early, shaken] = [EARLY.max(peak[1]), peak[1]].map(|since| worst(3, since));
        Off { early, to_peak, shaken_early, shaken, across: self.across, left: self.left, peak }
    }
}

/// An RVE that finds the parts of F which its sides are free to take: that along x, and those by which smooth sides slide.
pub struct Alone<S: Space> {
    rve: Rve<S>,
    /// Pa.
    pressure: f64,
    drive: Drive,
    /// Places in F, column by column, and what they are now and were before.
    free: Vec<usize>,
    now: DVector<f64>,
    before: DVector<f64>,
    /// What stresses there change by with them, Pa: by what was tried so far (Broyden 1965).
    tangent: DMatrix<f64>,
    scratch: Scratch<S>,
}

impl<S: Space> Alone<S> {
    pub fn new(rve: Rve<S>, pressure: f64, drive: Drive) -> Self {
        // xx, xy, and in space zx and zy: walls hold what else there is.
        let free = if S::DIMENSION == 2 { vec![0, 2] } else { vec![0, 3, 2, 5] };
        let modulus = rve.observe(&mut Scratch::default()).modulus_most();
        let stiffness = |at: usize| if at == 0 { modulus } else { modulus / 3.0 };
        let tangent = DMatrix::from_diagonal(&DVector::from_iterator(free.len(), free.iter().map(|&at| stiffness(at))));
        let now = DVector::from_iterator(free.len(), free.iter().map(|&at| rve.deformation()[at]));
        Self { rve, pressure, drive, free, before: now.clone(), now, tangent, scratch: Scratch::default() }
    }

    /// Goes to a stretch along y in an increment that lasts `duration` (s): stress along y over that along x, and what is left of the
    /// stresses that ought not to be there over the pressure.
    pub fn compress(&mut self, along: f64, duration: f64) -> (f64, f64) {
        let mut at = &self.now * 2.0 - &self.before;
        let (mut ratio, mut left, mut rve) = self.tried(&at, along, duration);
        let mut best = (at.clone(), ratio, left.amax(), rve);
        for _ in 1..TRIES {
            if best.2 < TOLERANCE * self.pressure {
                break;
            }
            let Some(step) = self.tangent.clone().lu().solve(&-&left) else { break };
            let last = left.clone();
            at += &step;
            (ratio, left, rve) = self.tried(&at, along, duration);
            let missed = &left - &last - &self.tangent * &step;
            self.tangent += missed * step.transpose() / step.norm_squared();
            if left.amax() < best.2 {
                best = (at.clone(), ratio, left.amax(), rve);
            }
        }
        let (at, ratio, left, rve) = best;
        self.rve = rve;
        self.before = std::mem::replace(&mut self.now, at);
        (ratio, left / self.pressure)
    }

    /// Stress along y over that along x, stresses that ought not to be there (Pa), and the RVE there.
    fn tried(&mut self, free: &DVector<f64>, along: f64, duration: f64) -> (f64, DVector<f64>, Rve<S>) {
        let mut rve = self.rve.clone();
        let next = S::DIMENSION + 1;
        let mut deformation = S::identity();
        deformation[next] = along;
        self.free.iter().zip(free).for_each(|(&at, value)| deformation[at] = *value);
        let answer = rve.follow(&deformation, duration, &self.drive, &mut self.scratch).unwrap().kirchhoff.tensor();
        let cauchy = |at: usize| answer[at] / S::determinant(rve.deformation());
        let wanted = |at: usize| if at == 0 { -self.pressure } else { 0.0 };
        let left = DVector::from_iterator(self.free.len(), self.free.iter().map(|&at| cauchy(at) - wanted(at)));
        (answer[next] / answer[0], left, rve)
    }
}
