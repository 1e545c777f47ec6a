//! Columns of `series.csv`: groups of numbers that are told together, from which a kind of job makes its series.

use crate::adapt::shear;
use crate::base::error::Error;
use crate::base::space::{AXES, Space};
use crate::domain::accounts::ledger::{Balance, SPENT};
use crate::run::Core;

pub mod grid;
pub mod servo;

/// Numbers of a group, by all ranks together.
type Row<'s, S> = Box<dyn for<'t> FnMut(&mut Core<'t, S>) -> Result<Vec<f64>, Error> + 's>;

/// Columns that are told together.
pub struct Columns<'s, S: Space> {
    /// As in the header of `series.csv`.
    pub names: Vec<String>,
    row: Row<'s, S>,
}

impl<'s, S: Space> Columns<'s, S> {
    /// `row` makes a number for each name. Collective.
    pub fn new<N: ToString>(
        names: impl IntoIterator<Item = N>,
        row: impl for<'t> FnMut(&mut Core<'t, S>) -> Result<Vec<f64>, Error> + 's,
    ) -> Self {
        Self { names: names.into_iter().map(|name| name.to_string()).collect(), row: Box::new(row) }
    }

    /// Numbers now, as many as there are names. Collective.
    pub fn row(&mut self, core: &mut Core<S>) -> Result<Vec<f64>, Error> {
        let row = (self.row)(core)?;
        assert_eq!(row.len(), self.names.len(), "a number for each of {:?}", self.names);
        Ok(row)
    }
}

/// Components of a vector.
pub fn of_vector<S: Space>(name: &str) -> Vec<String> {
    AXES[..S::DIMENSION].iter().map(|axis| format!("{name}_{axis}")).collect()
}

/// Components of a tensor, row by row.
pub fn of_tensor<S: Space>(name: &str) -> Vec<String> {
    let axes = &AXES[..S::DIMENSION];
    axes.iter().flat_map(|i| axes.iter().map(move |j| format!("{name}_{i}{j}"))).collect()
}

/// Components of a symmetric tensor, row by row from the diagonal on.
pub fn of_symmetric<S: Space>(name: &str) -> Vec<String> {
    let axes = &AXES[..S::DIMENSION];
    let of_row = |(row, i): (usize, &&str)| axes[row..].iter().map(|j| format!("{name}_{i}{j}")).collect::<Vec<_>>();
    axes.iter().enumerate().flat_map(of_row).collect()
}

/// Those of a tensor, which is symmetric.
pub fn row_of_symmetric<S: Space>(tensor: &S::Tensor) -> Vec<f64> {
    (0..S::DIMENSION).flat_map(|i| (i..S::DIMENSION).map(move |j| tensor[j * S::DIMENSION + i])).collect()
}

/// A tensor that lies column by column, row by row.
pub fn row_of_tensor<S: Space>(tensor: impl Fn(usize) -> f64) -> Vec<f64> {
    let axes = 0..S::DIMENSION;
    axes.clone().flat_map(|i| axes.clone().map(move |j| j * S::DIMENSION + i)).map(tensor).collect()
}

/// A body's force (N), torque (N m) and how far it has come (m).
pub fn of_body<S: Space>(name: &str) -> Vec<String> {
    let spins: &[&str] = if S::DIMENSION == 2 { &AXES[2..] } else { &AXES };
    let torques = spins.iter().map(|axis| format!("{name}_torque_{axis}"));
    let forces = of_vector::<S>(&format!("{name}_force"));
    forces.into_iter().chain(torques).chain(of_vector::<S>(&format!("{name}_displacement"))).collect()
}

/// Grains and points that there are.
pub fn counts<'s, S: Space>() -> Columns<'s, S> {
    Columns::new(["grains", "points"], |core| Ok(vec![core.world.grains_total as f64, core.world.points_total as f64]))
}

/// Share of all shear of the instant that is inside a hybrid's zones; 0 before there is one. Of the plane alone.
pub fn shear_in_zones<'s, S: Space>() -> Columns<'s, S> {
    Columns::new(["shear_in_zones"], |core| {
        let has_zones = core.progress.enriched_step > 0;
        Ok(vec![if has_zones { shear::share_inside_zones(&core.world)? } else { 0.0 }])
    })
}

/// Energies at the positions of now, J.
pub fn energies<'s, S: Space>() -> Columns<'s, S> {
    Columns::new(["kinetic_grains", "elastic_grains", "kinetic_points", "elastic_points"], |core| {
        let of = core.world.energies()?;
        Ok(vec![of.kinetic_grains, of.elastic_grains, of.kinetic_points, of.elastic_points])
    })
}

/// A kind of work by its column, J.
pub type Work = (&'static str, fn(&Balance) -> f64);

/// The account of the grains' energy ([`crate::domain::accounts::ledger`]) since the start or since they entered, J: work of what there
/// is, by its name, and what has become of it.
pub fn account_of_grains<'s, S: Space>(works: &'s [Work]) -> Columns<'s, S> {
    let names = works.iter().map(|(name, _)| *name).chain(SPENT);
    Columns::new(names, |core| {
        // None before the first step, nor right after grains have entered.
        let balance = if core.world.has_balance() { core.world.balance()? } else { Balance::default() };
        Ok(works.iter().map(|(_, work)| work(&balance)).chain(balance.spent()).collect())
    })
}
