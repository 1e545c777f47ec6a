//! The region that a hybrid's grains took over, by where they began: the same material can be found in any other run.

use super::run::Run;
use super::snapshot::Body;
use crate::base::error::Error;

/// A body lies in the zone if it began within this many mean diameters of where a grain of the zone began: near enough to
/// leave out the next grain of the same packing, far enough to leave no holes in another one.
const REACH: f64 = 0.75;

/// Grains that began this near to each other, mean diameters, are the same.
pub const SAME: f64 = 0.01;

/// Places where the grains of a zone began, m.
#[derive(Clone, Debug)]
pub struct Zone {
    /// By rising height.
    origins: Vec<[f64; 2]>,
    /// Mean diameter of a grain, m.
    diameter: f64,
    period: f64,
}

impl Zone {
    /// Of the grains that are there alone, without points, just after a hybrid's enrichment.
    pub fn of(run: &Run) -> Result<Option<Self>, Error> {
        let Some(frame) = run.enriched else { return Ok(None) };
        let snapshot = run.snapshot(frame)?;
        let origins = snapshot.bodies.iter().filter(|body| body.is_inner()).map(Body::origin).collect();
        Ok(Self::around(origins, run.grain()?, run.period()))
    }

    fn around(mut origins: Vec<[f64; 2]>, diameter: f64, period: f64) -> Option<Self> {
        origins.sort_by(|a, b| a[1].total_cmp(&b[1]));
        (!origins.is_empty()).then_some(Self { origins, diameter, period })
    }

    /// Heights of the lowest and the highest origin, m.
    pub fn heights(&self) -> [f64; 2] {
        [self.origins[0][1], self.origins[self.origins.len() - 1][1]]
    }

    /// Whether it began in the zone: within three quarters of a mean diameter of where one of its grains did.
    pub fn holds(&self, body: &Body) -> bool {
        self.is_near(body.origin(), REACH * self.diameter)
    }

    /// Share of its grains that began where one of `bodies` did: all of them in the same packing.
    pub fn shared_with(&self, bodies: &[Body]) -> f64 {
        let origins = bodies.iter().filter(|body| body.kind.is_grain()).map(Body::origin).collect();
        let Some(others) = Self::around(origins, self.diameter, self.period) else { return 0.0 };
        let shared = self.origins.iter().filter(|origin| others.is_near(**origin, SAME * self.diameter)).count();
        shared as f64 / self.origins.len() as f64
    }

    /// Whether a grain of it began within `reach` of a place, m.
    fn is_near(&self, [x, y]: [f64; 2], reach: f64) -> bool {
        let from = self.origins.partition_point(|origin| origin[1] < y - reach);
        self.origins[from..].iter().take_while(|origin| origin[1] <= y + reach).any(|origin| {
            let apart = (origin[0] - x).rem_euclid(self.period);
            let (dx, dy) = (apart.min(self.period - apart), origin[1] - y);
            dx * dx + dy * dy <= reach * reach
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::snapshot::Kind;
    use super::*;

    #[test]
    fn a_zone_holds_what_began_in_it_across_the_period() {
        let zone = Zone::around(vec![[0.1, 5.0], [3.0, 6.0]], 0.5 / REACH, 10.0).unwrap();
        let body = |origin: [f64; 2]| Body {
            kind: Kind::Grain,
            position: [(origin[0] + 17.0).rem_euclid(10.0), origin[1] + 1.0],
            displacement: [17.0, 1.0],
            ..Body::default()
        };
        assert_eq!(zone.heights(), [5.0, 6.0]);
        assert_eq!(zone.shared_with(&[body([0.101, 5.0]), body([3.0, 6.2])]), 0.5);
        assert_eq!(zone.shared_with(&[]), 0.0);
        assert!(zone.holds(&body([9.8, 5.0])) && zone.holds(&body([3.0, 5.6])));
        assert!(!zone.holds(&body([9.4, 5.0])) && !zone.holds(&body([3.0, 5.4])) && !zone.holds(&body([3.4, 6.4])));
    }
}
