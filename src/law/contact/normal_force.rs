//! Whether a dashpot may pull.

/// Which normal forces a spring and its dashpot may come to together. A dashpot slows a contact that opens and so may pull
/// at its end, which grains without cohesion do not (Schwager & Poeschel 2007); LAMMPS has the limit as `limit_damping`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalForce {
    /// N: a number in place of a name, so that laws limit forces without a branch.
    least: f64,
}

impl NormalForce {
    /// The force may turn tensile while a contact opens, as in the sources of the laws.
    pub const TENSILE: Self = Self { least: f64::NEG_INFINITY };
    /// The dashpot makes no tension: F_n = max(F_spring + F_dashpot, 0).
    pub const REPULSIVE: Self = Self { least: 0.0 };
    /// As jobs name them.
    pub const NAMES: [(&'static str, Self); 2] = [("tensile", Self::TENSILE), ("repulsive", Self::REPULSIVE)];

    /// The least normal force, N, repulsive positive: zero, or minus infinity.
    pub fn least(self) -> f64 {
        self.least
    }

    /// As jobs name it.
    pub fn name(self) -> &'static str {
        let (name, _) = Self::NAMES.iter().find(|(_, of)| *of == self).expect("there are no others");
        name
    }
}
