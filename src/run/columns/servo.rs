//! A servo that has kept its force and then moves as fast as it may keeps it no longer: the run says so, for its curves are not those of that force.

use crate::base::space::{Linear, Space};
use crate::bodies::body::Body;

/// A force within this share of what is to be kept is kept.
const KEPT: f64 = 0.1;
/// Rows of the series in a row at which a body moves as fast as it may before it is told.
const ROWS: u32 = 5;

/// What is known of each body's servo.
#[derive(Default)]
pub struct Watch {
    bodies: Vec<Watched>,
}

#[derive(Clone, Copy, Default)]
struct Watched {
    /// Whether it has kept its force once; one that comes up to the material has not.
    has_kept: bool,
    rows: u32,
}

impl Watch {
    /// Looks at a body with its mean force over a row, N, and warns once, if this rank speaks.
    pub fn tell<S: Space>(&mut self, number: usize, body: &Body<S>, force: &S::Vector, (step, speaks): (u64, bool)) {
        if let Some(words) = self.look(number, body, force).filter(|_| speaks) {
            tracing::warn!("warning: step {step}: {words}");
        }
    }

    /// What to say, once.
    fn look<S: Space>(&mut self, number: usize, body: &Body<S>, force: &S::Vector) -> Option<String> {
        let servo = body.servo.as_ref()?;
        if self.bodies.len() <= number {
            self.bodies.resize(number + 1, Watched::default());
        }
        let (watched, found) = (&mut self.bodies[number], force.dot(&servo.direction));
        let is_fastest = body.velocity.dot(&servo.direction).abs() >= servo.speed_max * (1.0 - 1e-9);
        watched.has_kept |= (found - servo.force).abs() <= KEPT * servo.force && !is_fastest;
        watched.rows = if is_fastest && watched.has_kept { watched.rows.saturating_add(1) } else { 0 };
        (watched.rows == ROWS).then(|| {
            format!(
                "body `{}` has moved at its servo.speed_max = {:e} m/s for {ROWS} rows of the series, and bears {found:.4e} N for the {:.4e} N that it is to keep; raise servo.speed_max, or load more slowly",
                body.name, servo.speed_max, servo.force
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::Plane;
    use crate::bodies::body::{Servo, Shape};

    type Vector = <Plane as Space>::Vector;

    /// One that comes up to the material at full speed is let be; one that had its force and cannot follow is told once.
    #[test]
    fn a_servo_that_cannot_follow_is_told_once() {
        let direction = Vector::new(0.0, 1.0);
        let mut lid = Body::<Plane>::new("lid", Shape::Layer);
        lid.servo = Some(Servo { direction, force: 100.0, mass: 1.0, damping: 0.0, speed_max: 0.1 });
        let mut watch = Watch::default();
        let mut told = |speed: f64, force: f64, rows: u32| -> u32 {
            lid.velocity = direction * speed;
            (0..rows).filter(|_| watch.look(1, &lid, &(direction * force)).is_some()).count() as u32
        };
        assert_eq!(told(-0.1, 0.0, 20), 0, "it comes down");
        assert_eq!(told(0.02, 101.0, 3), 0);
        assert_eq!(told(0.1, 130.0, 4), 0);
        assert_eq!(told(0.05, 105.0, 1), 0, "it follows again");
        assert_eq!(told(0.1, 150.0, 20), 1);
    }
}
