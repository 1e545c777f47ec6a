//! `[rve]`: grains as the material of points ([`crate::rve`]).

use crate::base::keys::{Form, RATIO, Range, choose, count, number, text, variant};
use crate::rve::drive::{Drive, Frame, Pace, Relaxation};

/// How RVEs are made and driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rves {
    /// How they follow an increment of deformation.
    pub drive: Drive,
    /// What of the increment grains are driven by.
    pub frame: Frame,
    /// Different packings that points begin from; which has which is drawn by its id.
    pub packings: u64,
    /// Time step of their grains over the stable one.
    pub safety: f64,
}

/// Inertial number below which flow is quasi-static (da Cruz et al. 2005).
const INERTIAL_NUMBER: f64 = 5e-4;
/// Steps at rest after an increment, at most.
const RELAXATION_STEPS: u64 = 1000;

impl Rves {
    /// Of a job that says nothing of them.
    pub const DEFAULT: Self = Self {
        drive: Drive { pace: Pace::QuasiStatic { inertial_number: INERTIAL_NUMBER }, steps_min: 2, relaxation: None },
        frame: Frame::Full,
        packings: 1,
        safety: 0.5,
    };

    /// The drive by which RVEs come to the stresses of the start: that has no time of the continuum.
    pub fn drive_of_levels(&self) -> Drive {
        Drive { pace: Self::DEFAULT.drive.pace, ..self.drive }
    }

    /// The keys of `[rve]`.
    pub fn keys(&mut self, form: &mut dyn Form) {
        let Self { drive, frame, packings, safety } = self;
        let about = "the time that grains have for an increment: quasi_static, as much as keeps their inertial number small, or synchronous, that of the continuum";
        let key = text("drive", about, "\"quasi_static\"").or("quasi_static");
        let kinds = [
            ("quasi_static", Pace::QuasiStatic { inertial_number: INERTIAL_NUMBER }),
            ("synchronous", Pace::Synchronous),
        ];
        variant(form, &mut drive.pace, "drive", key, &kinds, |pace, form| {
            let Pace::QuasiStatic { inertial_number } = pace else { return };
            let about = "the inertial number that increments keep below, by more steps of grains";
            form.number(
                inertial_number,
                number("inertial_number", about, RATIO, Range::above(0.0, 0.1), "5e-4").or("5e-4"),
            );
        });
        let about = "what drives an RVE: full, all of the deformation, or of elements corotational, its rate in a frame that turns with R of F = R U (Liu et al. 2016, box B1)";
        let key = text("frame", about, "\"full\"").or("full");
        choose(form, frame, "frame", key, &Frame::NAMES);
        form.count(
            &mut drive.steps_min,
            count("steps_min", "steps of grains in an increment, at least", (1, 10_000), "2").or("2"),
        );
        let about = "the time step of their grains over the stable one";
        form.number(safety, number("safety", about, RATIO, Range::above(0.0, 1.0), "0.8").or("0.5"));
        let mut unbalanced = drive.relaxation.map(|relaxation| relaxation.unbalanced_max);
        let about = "the unbalanced force, as a share of that of contacts, above which grains take more steps at rest after an increment";
        let key = number("unbalanced_max", about, RATIO, Range::open(0.0, 1.0), "0.01");
        form.number_if_given(&mut unbalanced, key.optional());
        let mut steps_max = drive.relaxation.map_or(RELAXATION_STEPS, |relaxation| relaxation.steps_max);
        let about = "such steps after an increment, at most";
        form.count(&mut steps_max, count("relaxation_steps_max", about, (1, 1_000_000), "1000").or("1000"));
        drive.relaxation = unbalanced.map(|unbalanced_max| Relaxation { unbalanced_max, steps_max });
        let about = "different packings that points begin from, drawn by their ids; with as many as points each has its own, about";
        form.count(packings, count("packings", about, (1, 1_000_000), "1").or("1"));
    }
}
