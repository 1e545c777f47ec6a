//! What the columns of a series are: words, what they count, and in which unit they are shown. Everything that is drawn of a series
//! is chosen from this list, whatever job wrote it.

use crate::base::math;

/// A column of a series, in SI units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column {
    /// As the header of the series has it; of what was derived, as [`with_derived`] calls it.
    pub name: String,
    /// Row by row; not a number where a row ends before it.
    pub values: Vec<f64>,
}

/// What a number is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Shown in per cent.
    Strain,
    /// Tension is positive in the columns that have two axes, and compression where one is shown.
    Stress,
    /// N.
    Force,
    /// J.
    Energy,
    /// A displacement, m.
    Length,
    /// Shown as it is: without a unit, or in one that is not known here.
    Number,
}

impl Quantity {
    /// What it is called, the unit that it is shown in, and what one of that is.
    pub fn shown(self) -> (&'static str, &'static str, f64) {
        match self {
            Self::Strain => ("strain", "%", 1e-2),
            Self::Stress => ("stress", "kPa", 1e3),
            Self::Force => ("force", "N", 1.0),
            Self::Energy => ("energy", "J", 1.0),
            Self::Length => ("displacement", "m", 1.0),
            Self::Number => ("", "", 1.0),
        }
    }
}

/// What a column says.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// For axes and legends, without a unit.
    pub words: String,
    /// Tells the unit that it is shown in.
    pub quantity: Quantity,
    /// -1 of what is shown with its sign turned.
    pub sign: f64,
    /// A mean over an interval that is noise enough to be averaged over several rows.
    pub is_noisy: bool,
}

/// Names with their words. A star stands for the name of a face, of a body or of what is followed.
const KNOWN: [(&str, &str, Quantity); 57] = {
    use Quantity::*;
    [
        ("shear_stress", "shear stress", Stress),
        ("normal_stress", "normal stress", Stress),
        ("volume_strain", "volume strain", Strain),
        ("volume_change", "change of volume", Strain),
        ("fraction", "solid volume fraction", Number),
        ("contacts_of_a_grain", "contacts of a grain", Number),
        ("stress_xx", "\u{2212}xx", Stress),
        ("stress_yy", "\u{2212}yy", Stress),
        ("stress_zz", "\u{2212}zz", Stress),
        ("stress_xy", "xy", Stress),
        ("elastic", "elastic", Energy),
        ("elastic_grains", "elastic, grains", Energy),
        ("elastic_points", "elastic, points", Energy),
        ("kinetic", "kinetic", Energy),
        ("kinetic_grains", "kinetic, grains", Energy),
        ("kinetic_points", "kinetic, points", Energy),
        ("kinetic_translation", "kinetic, translation", Energy),
        ("kinetic_rotation", "kinetic, rotation", Energy),
        ("dissipated", "dissipated", Energy),
        ("change_of_potential", "potential", Energy),
        ("change_of_all", "sum of all", Energy),
        ("change_of_work_loads", "work of loads", Energy),
        ("change_of_work_bodies", "work of bodies", Energy),
        ("change_of_work_ramp", "work of the ramp of gravity", Energy),
        ("change_of_work_nodes", "work of shared nodes", Energy),
        ("change_of_work_gravity", "work of gravity", Energy),
        ("change_of_work_cell", "work of the cell", Energy),
        ("change_of_dissipated_holds", "lost at faces and bodies", Energy),
        ("change_of_energy_lost", "lost by the scheme", Energy),
        ("change_of_energy_stored", "stored", Energy),
        ("change_of_dissipated_viscous", "taken by dashpots", Energy),
        ("change_of_dissipated_friction", "taken by friction", Energy),
        ("change_of_dissipated_damping", "taken by damping", Energy),
        ("change_of_dissipated_levers", "taken by levers", Energy),
        ("change_of_ledger_residual", "not explained", Energy),
        ("change_of_points_work_grains", "work of grains on points", Energy),
        ("change_of_points_dissipated", "dissipated, points", Energy),
        ("change_of_points_energy_lost_averaging", "lost by averaging of volume strain, points", Energy),
        ("change_of_points_energy_lost_transfer", "lost by the transfer, points", Energy),
        ("x_*_force", "face x_*", Force),
        ("y_*_force", "face y_*", Force),
        ("z_*_force", "face z_*", Force),
        ("*_force", "*", Force),
        ("*_moved", "*", Length),
        ("*_p", "*", Stress),
        ("*_q", "*", Stress),
        ("*_deviatoric_strain", "*", Number),
        ("rve_void_ratio", "all RVEs", Number),
        ("*_void_ratio", "*", Number),
        ("*_fabric_anisotropy", "*", Number),
        ("rve_mechanical_coordination", "all RVEs", Number),
        ("*_mechanical_coordination", "*", Number),
        ("*_grains_turned", "grains of *", Number),
        ("*_turned", "*", Number),
        ("rve_loose", "without contacts", Number),
        ("rve_replicated", "replicated", Number),
        ("rve_unbalanced_max", "the largest I_uf", Number),
    ]
};
const NOISY: [&str; 2] = ["shear_stress", "normal_stress"];

/// What is between the ends of a pattern with a star.
fn starred<'n>(name: &'n str, pattern: &str) -> Option<&'n str> {
    match pattern.split_once('*') {
        None => (name == pattern).then_some(""),
        Some((before, after)) => name.strip_prefix(before)?.strip_suffix(after),
    }
}

/// Whether a name is meant by one with a star.
pub fn is_meant(name: &str, pattern: &str) -> bool {
    starred(name, pattern).is_some()
}

/// What a column of that name says.
pub fn describe(name: &str) -> Description {
    let of_face = |pattern: &str| pattern.find('*') == Some(2);
    let known = |name: &str| {
        KNOWN.iter().find_map(|&(pattern, words, quantity)| {
            let star = starred(name, pattern).filter(|star| !of_face(pattern) || ["lower", "upper"].contains(star))?;
            Some((words.replace('*', star), quantity))
        })
    };
    // The account of points beside grains has the words of that of points alone.
    let of_points = || known(&alone(name)?).map(|(words, quantity)| (format!("{words}, points"), quantity));
    let found = known(name).or_else(of_points);
    let (words, quantity) = found.unwrap_or_else(|| match starred(name, "*_plastic_strain") {
        Some(followed) => (followed.to_owned(), Quantity::Number),
        None => (name.replace('_', " "), Quantity::Number),
    });
    let turned = name.ends_with("_p") || ["stress_xx", "stress_yy", "stress_zz"].contains(&name);
    Description { words, quantity, sign: if turned { -1.0 } else { 1.0 }, is_noisy: NOISY.contains(&name) }
}

/// The name that a column of the account of points has where there are no grains.
fn alone(name: &str) -> Option<String> {
    name.strip_prefix("change_of_points_").map(|rest| format!("change_of_{rest}"))
}

/// Columns with those that follow from them: lengths of vectors, changes since the first row, ratios.
pub fn with_derived(mut columns: Vec<Column>) -> Vec<Column> {
    let of = |name: &str| columns.iter().find(|column| column.name == name).map(|column| column.values.as_slice());
    let mut derived = Vec::new();
    let mut add = |name: &str, values: Vec<f64>| derived.push(Column { name: name.to_owned(), values });
    if let Some((contacts, grains)) = of("contacts").zip(of("grains")) {
        add(
            "contacts_of_a_grain",
            contacts.iter().zip(grains).map(|(contacts, grains)| 2.0 * contacts / grains).collect(),
        );
    }
    for (name, volume) in [("volume_change", of("volume")), ("volume_strain", of("enclosed_volume"))] {
        if let Some(volume) = volume {
            add(name, volume.iter().map(|now| now / volume[0] - 1.0).collect());
        }
    }
    let vector = |name: &str| -> Vec<&[f64]> {
        ["x", "y", "z"].iter().filter_map(|axis| of(&format!("{name}_{axis}"))).collect()
    };
    for name in columns.iter().filter_map(|column| column.name.strip_suffix("_x")) {
        if name.ends_with("_force") {
            add(name, lengths(&vector(name)));
        }
        if let Some(followed) = name.strip_suffix("_place") {
            add(&format!("{followed}_moved"), lengths(&vector(&format!("{followed}_displacement"))));
            for (of_what, turned) in [("rotation", "turned"), ("grain_rotation", "grains_turned")] {
                if let Some(angles) = of(&format!("{followed}_{of_what}")) {
                    add(&format!("{followed}_{turned}"), unwound(angles).map(f64::to_degrees).collect());
                }
            }
        }
    }
    if let [Some(potential), Some(kinetic), Some(elastic), Some(dissipated)] =
        ["potential", "kinetic", "elastic", "dissipated"].map(of)
    {
        add("change_of_potential", change(potential));
        let sum = |row: usize| potential[row] + kinetic[row] + elastic[row] + dissipated[row];
        add("change_of_all", change(&(0..potential.len()).map(sum).collect::<Vec<_>>()));
    }
    for (pattern, ..) in KNOWN {
        let account = pattern.strip_prefix("change_of_").filter(|name| !["potential", "all"].contains(name));
        if let Some((name, values)) = account.and_then(|name| Some((name, of(name)?))) {
            add(&format!("change_of_{name}"), change(values));
        }
    }
    for column in columns.iter().filter(|column| column.name.starts_with("points_")) {
        let name = format!("change_of_{}", column.name);
        if describe(&name).quantity == Quantity::Energy {
            add(&name, change(&column.values));
        }
    }
    columns.extend(derived);
    columns
}

/// Of a vector whose components are columns.
fn lengths(components: &[&[f64]]) -> Vec<f64> {
    let rows = components.first().map_or(0, |first| first.len());
    (0..rows).map(|row| components.iter().map(|of| of[row] * of[row]).sum::<f64>().sqrt()).collect()
}

/// rad.
const TURN: f64 = 2.0 * math::PI;

/// Angles that are told within a turn, rad, with the whole turns that they have come through: rows are less than half a turn apart.
fn unwound(angles: &[f64]) -> impl Iterator<Item = f64> {
    let mut before = angles.first().copied().unwrap_or_default();
    let mut turns = 0.0;
    angles.iter().map(move |angle| {
        turns -= ((angle - before) / TURN).round();
        before = *angle;
        angle + turns * TURN
    })
}

/// Since the first row.
fn change(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| value - values[0]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_known_by_their_names() {
        let told = |name: &str| describe(name).words;
        assert_eq!(
            [told("x_lower_force"), told("x_wall_force"), told("corner_p")],
            ["face x_lower", "x_wall", "corner"]
        );
        assert_eq!(
            (describe("stress_yy").sign, describe("stress_xy").sign, describe("corner_p").sign),
            (-1.0, 1.0, -1.0)
        );
        assert_eq!(describe("corner_plastic_strain").words, "corner");
        assert_eq!(describe("energy_lost_transfer").quantity, Quantity::Number);
        assert_eq!(told("change_of_points_work_loads"), "work of loads, points");
        assert_eq!(told("change_of_points_work_grains"), "work of grains on points");
    }

    #[test]
    fn angles_go_on_beyond_a_turn() {
        let wound: Vec<f64> =
            (0..20).map(|row| 0.9 * f64::from(row)).map(|angle: f64| angle - TURN * (angle / TURN).round()).collect();
        let back: Vec<f64> = unwound(&wound).collect();
        assert!(back.iter().enumerate().all(|(row, angle)| (angle - 0.9 * row as f64).abs() < 1e-12), "{back:?}");
    }

    #[test]
    fn lengths_changes_and_ratios_follow() {
        let column = |name: &str, values: [f64; 2]| Column { name: name.to_owned(), values: values.to_vec() };
        let columns = with_derived(vec![
            column("wall_force_x", [3.0, 0.0]),
            column("wall_force_y", [-4.0, 2.0]),
            column("volume", [2.0, 2.1]),
            column("contacts", [6.0, 9.0]),
            column("grains", [3.0, 3.0]),
            column("work_loads", [1.0, 1.5]),
            column("points_energy_lost", [0.5, 0.75]),
            column("points_removed", [0.0, 4.0]),
        ]);
        let of = |name: &str| columns.iter().find(|column| column.name == name).unwrap().values.clone();
        assert_eq!((of("wall_force"), of("contacts_of_a_grain")), (vec![5.0, 2.0], vec![4.0, 6.0]));
        assert!((of("volume_change")[1] - 0.05).abs() < 1e-12);
        assert_eq!(of("change_of_work_loads"), [0.0, 0.5]);
        assert_eq!(of("change_of_points_energy_lost"), [0.0, 0.25]);
        assert!(columns.iter().all(|column| column.name != "change_of_points_removed"));
    }
}
