//! The body that presses, its way and its breadth, and the extents of the material, as a scenario has them.

use toml::{Table, Value};

use crate::plot::report::records::{AXES, numbers};

/// A body that moves along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Press {
    pub name: String,
    /// The axis nearer to its way, and which way it goes along that: 1 or -1.
    axis: usize,
    sign: f64,
    /// Area that its force is borne by, m2.
    area: f64,
    /// Length that its way is a strain of, m.
    pub length: f64,
    /// It is a plane, and that length the height of the material; otherwise its own breadth.
    pub is_plane: bool,
}

impl Press {
    /// The first body of a job that moves: of boxes and discs, or else of planes, since a wall that moves beside a plate loads the
    /// far field.
    pub fn of(scenario: &Table) -> Option<Self> {
        let bodies = scenario.get("body").and_then(Value::as_array)?.iter().filter_map(Value::as_table);
        let moving: Vec<Self> = bodies.filter_map(|body| Self::of_body(body, scenario)).collect();
        moving.iter().find(|body| !body.is_plane).or(moving.first()).cloned()
    }

    fn of_body(body: &Table, scenario: &Table) -> Option<Self> {
        let path = body.get("path").and_then(Value::as_array)?;
        let velocities = path.iter().filter_map(|point| <[f64; 2]>::try_from(numbers(point.get("velocity"))).ok());
        let speed = |[x, y]: &[f64; 2]| x * x + y * y;
        let fastest =
            velocities.max_by(|a, b| speed(a).total_cmp(&speed(b))).filter(|velocity| speed(velocity) > 0.0)?;
        let axis = usize::from(fastest[1].abs() > fastest[0].abs());
        let material = material(scenario)?;
        let pair = |key: &str| <[f64; 2]>::try_from(numbers(body.get(key))).ok();
        let own = match (pair("lower").zip(pair("upper")), body.get("radius").and_then(Value::as_float)) {
            (Some((lower, upper)), _) => Some(upper[1 - axis] - lower[1 - axis]),
            (None, radius) => radius.map(|radius| 2.0 * radius),
        };
        let extent = |axis: usize| material[axis][1] - material[axis][0];
        let depth = scenario.get("grid").and_then(|grid| grid.get("depth")).and_then(Value::as_float)?;
        Some(Self {
            name: body.get("name").and_then(Value::as_str)?.to_owned(),
            axis,
            sign: fastest[axis].signum(),
            area: own.unwrap_or(extent(1 - axis)) * depth,
            length: own.unwrap_or(extent(axis)),
            is_plane: own.is_none(),
        })
    }

    /// Columns of its force and of its displacement.
    pub fn columns(&self) -> [String; 2] {
        ["force", "displacement"].map(|what| format!("{}_{what}_{}", self.name, AXES[self.axis]))
    }

    /// Of its displacement, m.
    pub fn strain(&self, displacement: f64) -> f64 {
        self.sign * displacement / self.length
    }

    /// Of the material's force on it, N: Pa, compression positive.
    pub fn stress(&self, force: f64) -> f64 {
        -self.sign * force / self.area
    }

    /// What its strain is.
    pub fn strain_words(&self) -> &'static str {
        match self.is_plane {
            true => "axial strain",
            false => "displacement over breadth",
        }
    }
}

/// Lower and upper ends of all regions, m, along either axis.
pub fn material(scenario: &Table) -> Option<[[f64; 2]; 2]> {
    let mut ends = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    let regions = scenario.get("region").and_then(Value::as_array)?.iter().filter_map(Value::as_table);
    for region in regions {
        let pair = |key: &str| <[f64; 2]>::try_from(numbers(region.get(key))).ok();
        let radius = region.get("radius").and_then(Value::as_float).unwrap_or(0.0);
        let corners = region.get("vertices").and_then(Value::as_array).into_iter().flatten();
        let corners = corners.filter_map(|corner| <[f64; 2]>::try_from(numbers(Some(corner))).ok());
        for place in ["lower", "upper", "centre"].into_iter().filter_map(pair).chain(corners) {
            for (ends, at) in ends.iter_mut().zip(place) {
                *ends = [ends[0].min(at - radius), ends[1].max(at + radius)];
            }
        }
    }
    ends.iter().all(|[lower, upper]| upper > lower).then_some(ends)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scenario(body: &str) -> Table {
        let rest = "[grid]\ndepth = 0.01\n[[region]]\nlower = [0.1, 0.0]\nupper = [0.2, 0.3]\n[[region]]\ncentre = [0.2, 0.1]\n\
                    radius = 0.05\n[[body]]\nname = \"base\"\nnormal = [0.0, 1.0]\n";
        toml::from_str(&format!("{rest}[[body]]\nname = \"plate\"\n{body}")).unwrap()
    }

    #[test]
    fn planes_press_on_the_breadth_of_the_material_and_boxes_on_their_own() {
        let path = "path = [{time = 0.0, velocity = [0.0, 0.0]}, {time = 1.0, velocity = [0.0, -0.02]}]";
        let plane = Press::of(&scenario(&format!("normal = [0.0, -1.0]\n{path}"))).unwrap();
        assert_eq!((plane.name.as_str(), plane.is_plane, plane.length), ("plate", true, 0.3));
        assert!((plane.strain(-0.03) - 0.1).abs() < 1e-15 && (plane.stress(150.0) - 1e5).abs() < 1e-9);
        assert_eq!(plane.columns(), ["plate_force_y", "plate_displacement_y"]);
        let solid = Press::of(&scenario(&format!("lower = [0.1, 0.3]\nupper = [0.15, 0.4]\n{path}"))).unwrap();
        assert!(!solid.is_plane && (solid.length - 0.05).abs() < 1e-15 && (solid.stress(50.0) - 1e5).abs() < 1e-9);
        let disc = Press::of(&scenario(&format!("centre = [0.1, 0.3]\nradius = 0.01\n{path}"))).unwrap();
        assert!((disc.strain(-0.02) - 1.0).abs() < 1e-15);
        // To the right: what holds it pushes to the left.
        let sideways = Press::of(&scenario("path = [{time = 0.0, velocity = [0.5, 0.1]}]")).unwrap();
        assert!(sideways.strain(0.1) > 0.0 && sideways.stress(-1.0) > 0.0);
        assert_eq!(sideways.columns()[0], "plate_force_x");
        assert_eq!(Press::of(&scenario("path = [{time = 0.0, velocity = [0.0, 0.0]}]")), None);
        assert_eq!(Press::of(&scenario("")), None);
    }
}
