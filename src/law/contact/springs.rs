//! What a contact amounts to in an oscillator.

/// Stiffness and damping of a contact as it is: what bounds the step, and what a servo's answer is reckoned with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Springs {
    /// N/m.
    pub normal: f64,
    /// N/m, along the surface.
    pub tangential: f64,
    /// Moment per angle, N m.
    pub rolling: f64,
    /// N s/m, of a contact that closes: nothing limits its dashpots.
    pub damping_normal: f64,
    /// N s/m, along the surface.
    pub damping_tangential: f64,
}

impl Springs {
    /// That of the normal or of the tangential direction, whichever is more, N/m.
    pub fn stiffest(&self) -> f64 {
        self.normal.max(self.tangential)
    }

    /// The same of its dashpots, N s/m.
    pub fn most_damped(&self) -> f64 {
        self.damping_normal.max(self.damping_tangential)
    }

    /// Whether it has a dashpot, normal or tangential.
    pub fn damps(&self) -> bool {
        self.damping_normal + self.damping_tangential > 0.0
    }
}

/// What the stiffness of a law depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stiffening {
    /// Nothing: it is the same between any two grains.
    Constant,
    /// The radii of the two.
    WithSize,
    /// Their radii and how far they overlap.
    WithOverlap,
}
