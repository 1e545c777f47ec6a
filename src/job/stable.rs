//! The longest stable time step of grains: every contact law, in the plane and in space, translation and rotation,
//! springs and dashpots.
//!
//! Two grains move against each other at a contact, and each brings its own share to the square of the frequency. Summed
//! over z contacts that lie in all directions of D dimensions, with I = c m r^2, c = 1/2 of a disc and 2/5 of a sphere:
//!
//! ```text
//! translation: z (k_n + (D - 1) k_t)/(D m)
//! rotation:    (f/c) z (k_t + k_r/r^2)/m       f = 1 in the plane, 2/3 in space
//! ```
//!
//! f is the share of contacts that a spin slides: in space a contact on the spin's own axis does not slide. The largest
//! eigenvalue of a packing is at most the largest sum of these shares over the two grains of a contact (a row sum of the
//! matrix over contacts), and with equal grains it is attained: neighbours that all move against a grain, or grains that
//! all spin alike, which slides every contact by twice r w. With six equal discs or twelve equal spheres around each:
//!
//! ```text
//! plane: omega^2 = 6 (k_n + k_t)/m    and 24 (k_t + k_r/r^2)/m
//! space: omega^2 = 8 (k_n + 2 k_t)/m  and 40 (k_t + k_r/r^2)/m
//! ```
//!
//! Dashpots take the place of springs in the rate of decay, without rolling. Local damping bounds nothing: it scales forces
//! by less than two and changes its sign with the velocity.

use crate::base::math::{PI, atan2};
use crate::law::contact::{Contact, FLAT, Springs, Stiffening};

/// One reason why a time step cannot be longer.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// What moves or decays too fast, in a few words for a person.
    pub cause: &'static str,
    /// How it is computed.
    pub formula: &'static str,
    /// What happens beyond it, and what else than the step could be changed.
    pub remedy: &'static str,
    /// The longest stable step, s.
    pub step: f64,
}

/// The step over the stable one where a job does not say.
pub const SAFETY_DEFAULT: f64 = 0.5;

/// The step of a job that does not say, s.
pub fn step_default(bounds: &[Bound]) -> f64 {
    SAFETY_DEFAULT * governing(bounds).step
}

/// The tightest of some bounds.
pub fn governing(bounds: &[Bound]) -> &Bound {
    bounds.iter().min_by(|a, b| a.step.total_cmp(&b.step)).expect("every job has at least one bound")
}

/// The longest stable step of a damped oscillator `x'' = -omega^2 x - rate x'` when the damping force takes its velocity
/// half a step late, as the leapfrog here does: 2 / (sqrt(omega^2 + (rate/2)^2) + rate/2).
///
/// Without damping it is 2/omega, without a spring 2/rate.
pub fn oscillator_step_max(omega_squared: f64, rate: f64) -> f64 {
    let half_rate = 0.5 * rate;
    2.0 / ((omega_squared + half_rate * half_rate).sqrt() + half_rate)
}

/// Mass of a uniform grain, kg: a disc with its out-of-plane depth, or a sphere.
pub fn grain_mass(density: f64, radius: f64, depth: f64, dimension: usize) -> f64 {
    match dimension {
        2 => density * PI * radius * radius * depth,
        _ => density * (4.0 / 3.0) * PI * radius * radius * radius,
    }
}

/// A grain as the bounds see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrainScale {
    /// m.
    pub radius: f64,
    /// kg.
    pub mass: f64,
    /// 2 for a disc, 3 for a sphere.
    pub dimension: usize,
}

impl GrainScale {
    /// A grain of that size and density, kg/m3; `depth` is that of a disc, m.
    pub fn of(radius: f64, density: f64, depth: f64, dimension: usize) -> Self {
        Self { radius, mass: grain_mass(density, radius, depth, dimension), dimension }
    }

    /// Contacts that grains of one size can have at most.
    fn contacts_of_equals(&self) -> f64 {
        if self.dimension == 2 { 6.0 } else { 12.0 }
    }

    /// Grains of that radius that find room around this one: as many as share its circumference or its surface like six
    /// equal discs or twelve equal spheres do, but no fewer than hold it in place.
    fn contacts_among(&self, radius: f64) -> f64 {
        let sine = radius / (self.radius + radius);
        let cosine = (1.0 - sine * sine).sqrt();
        let equal_cap = 1.0 - 0.75f64.sqrt();
        let share = match self.dimension {
            2 => (PI / 6.0) / atan2(sine, cosine),
            _ => equal_cap / (1.0 - cosine),
        };
        (share * self.contacts_of_equals()).max(self.dimension as f64 + 1.0)
    }

    /// This grain's share of omega^2, or of the rate of decay, in translation.
    fn moving(&self, contacts: f64, normal: f64, tangential: f64) -> f64 {
        let axes = self.dimension as f64;
        contacts * (normal + (axes - 1.0) * tangential) / (axes * self.mass)
    }

    /// The same in rotation; `tangential` includes what resists rolling, over r^2.
    fn spinning(&self, contacts: f64, tangential: f64) -> f64 {
        let lever = if self.dimension == 2 { 2.0 } else { 5.0 / 3.0 };
        lever * contacts * tangential / self.mass
    }
}

/// Overlap at which Hertz contacts are taken, as a share of the harmonic mean of the radii: deeper than grains should ever
/// be, so that the bound also covers collisions.
pub const HERTZ_OVERLAP: f64 = 0.05;

/// Springs and dashpots between two grains, of Hertz contacts at [`HERTZ_OVERLAP`].
fn between(contact: &Contact, a: &GrainScale, b: &GrainScale) -> Springs {
    springs_at(contact, [a.radius, b.radius], [a.mass, b.mass], HERTZ_OVERLAP)
}

/// Of radii in m and masses in kg at `overlap`, a share of the harmonic mean of the radii.
pub fn springs_at(contact: &Contact, radii: [f64; 2], masses: [f64; 2], overlap: f64) -> Springs {
    let radius = 2.0 * radii[0] * radii[1] / (radii[0] + radii[1]);
    contact.springs(radii, masses, overlap * radius)
}

const STIFF: &str =
    "Beyond it contacts feed energy into the grains; shorten the step, or take softer contacts or heavier grains.";
const DAMPED_MOVING: &str = "Beyond it damping feeds energy into the grains; shorten the step, or lower contact.damping_normal and contact.damping_tangential (or raise contact.restitution).";
const DAMPED_SPINNING: &str = "Beyond it rotations flip at every step and friction is lost; shorten the step, or lower contact.damping_tangential.";

/// What bounds the step of the grains.
///
/// Springs are taken with the lightest grain. Where their stiffness does not depend on size, it lies among its own like.
/// Where stiffness grows with size, it lies among mean grains, which is stiffer a contact but leaves less room for
/// contacts. If sizes come in classes, ask for each class with `lightest` and `mean` the same.
///
/// Dashpots are taken with mean grains alone, six or twelve around each, and with the lightest grain among them: it has
/// fewer contacts but less mass, and chatters where the spread of sizes is wide.
///
/// Measured in a dense packing of Table 1 of Chen et al. (2021) (m = 1.987e-5 kg): gamma = 7 N s/m is clean at 2e-7 s and chatters at
/// 5e-7 s; gamma = 3.5 N s/m is clean at 4.5e-7 s and one grain in ten chatters at 5e-7 s. Here: 2.33e-7 s and 4.47e-7 s. A
/// dashpot alone bounds rotation by m/(2 z gamma_t). Discs of 6 to 14 mm with E = 600 MPa and k_t/k_n = 0.8 (Table 1 of
/// Liang & Zhao 2019, 0.1 m deep) are clean at 3.16e-5 s in YADE, and the stiffest mode of two packings of theirs (all
/// contacts sticking) allows 3.87e-5 s; here: 3.33e-5 s.
pub fn bounds(contact: &Contact, lightest: &GrainScale, mean: &GrainScale) -> Vec<Bound> {
    let is_constant = contact.stiffening() == Stiffening::Constant;
    let mut bounds = match is_constant {
        true => Vec::from(bounds_of_equals(contact, lightest)),
        false => Vec::from(bounds_of_unequals(contact, lightest, mean)),
    };
    let springs = between(contact, mean, mean);
    if springs.damps() || is_constant {
        let alike = bounds_with_dashpots(&springs, mean);
        let among = bounds_among_mean_grains(contact, lightest, mean);
        bounds.extend(alike.into_iter().zip(among).map(|(a, b)| if a.step <= b.step { a } else { b }));
    }
    bounds
}

/// The tightest [`bounds`] of grains of many sizes: of the lightest among mean ones, and of each class among its like, since
/// grains of one size can gather.
pub fn bounds_of_sizes(
    contact: &Contact,
    lightest: &GrainScale,
    mean: &GrainScale,
    classes: &[GrainScale],
) -> Vec<Bound> {
    classes.iter().fold(bounds(contact, lightest, mean), |tightest, class| {
        let alike = bounds(contact, class, class);
        if governing(&alike).step < governing(&tightest).step { alike } else { tightest }
    })
}

/// What resists the spin of a grain at its surface, N/m: tangential springs, and those against rolling over r^2.
fn sheared(springs: &Springs, grain: &GrainScale) -> f64 {
    springs.tangential + springs.rolling / (grain.radius * grain.radius)
}

/// Springs between grains that are all as light as the lightest.
fn bounds_of_equals(contact: &Contact, grain: &GrainScale) -> [Bound; 2] {
    let springs = between(contact, grain, grain);
    let contacts = grain.contacts_of_equals();
    let moving = 2.0 * grain.moving(contacts, springs.normal, springs.tangential);
    let spinning = 2.0 * grain.spinning(contacts, sheared(&springs, grain));
    let (plane, rolls) = (grain.dimension == 2, springs.rolling > 0.0);
    [
        Bound {
            cause: "contact springs, lightest grain moving",
            formula: if plane { "2/w, w^2 = 6 (k_n + k_t)/m" } else { "2/w, w^2 = 8 (k_n + 2 k_t)/m" },
            remedy: STIFF,
            step: oscillator_step_max(moving, 0.0),
        },
        Bound {
            cause: if rolls {
                "tangential and rolling springs, lightest grain spinning"
            } else {
                "tangential springs, lightest grain spinning"
            },
            formula: match (plane, rolls) {
                (true, false) => "2/w, w^2 = 24 k_t/m",
                (false, false) => "2/w, w^2 = 40 k_t/m",
                (true, true) => "2/w, w^2 = 24 (k_t + k_r/r^2)/m",
                (false, true) => "2/w, w^2 = 40 (k_t + k_r/r^2)/m",
            },
            remedy: STIFF,
            step: oscillator_step_max(spinning, 0.0),
        },
    ]
}

/// Springs between the lightest grain and a mean one, which has mean grains around it.
fn bounds_of_unequals(contact: &Contact, lightest: &GrainScale, mean: &GrainScale) -> [Bound; 2] {
    let shares = [(lightest, lightest.contacts_among(mean.radius)), (mean, mean.contacts_of_equals())].map(
        |(grain, contacts)| {
            let springs = between(contact, grain, mean);
            [
                grain.moving(contacts, springs.normal, springs.tangential),
                grain.spinning(contacts, sheared(&springs, grain)),
            ]
        },
    );
    let [moving, spinning] = [0, 1].map(|mode| shares[0][mode] + shares[1][mode]);
    let plane = lightest.dimension == 2;
    let hertz = contact.stiffening() == Stiffening::WithOverlap;
    [
        Bound {
            cause: if hertz {
                "contacts at an overlap of 5 %, lightest grain moving"
            } else {
                "contact springs, lightest grain moving"
            },
            formula: if plane {
                "2/w, w^2 = z (k_n + k_t)/2m of it and of a mean grain together"
            } else {
                "2/w, w^2 = z (k_n + 2 k_t)/3m of it and of a mean grain together"
            },
            remedy: STIFF,
            step: oscillator_step_max(moving, 0.0),
        },
        Bound {
            cause: if hertz {
                "contacts at an overlap of 5 %, lightest grain spinning"
            } else {
                "tangential and rolling springs, lightest grain spinning"
            },
            formula: if plane {
                "2/w, w^2 = 2 z (k_t + k_r/r^2)/m of it and of a mean grain together"
            } else {
                "2/w, w^2 = 5 z (k_t + k_r/r^2)/3m of it and of a mean grain together"
            },
            remedy: STIFF,
            step: oscillator_step_max(spinning, 0.0),
        },
    ]
}

fn bounds_with_dashpots(springs: &Springs, grain: &GrainScale) -> [Bound; 2] {
    let contacts = grain.contacts_of_equals();
    let moving = |normal, tangential| 2.0 * grain.moving(contacts, normal, tangential);
    let spinning = |tangential| 2.0 * grain.spinning(contacts, tangential);
    let plane = grain.dimension == 2;
    [
        Bound {
            cause: "springs and dashpots, mean grain moving",
            formula: if plane {
                "2/(sqrt(w^2 + b^2) + b), b = 3 (gamma_n + gamma_t)/m"
            } else {
                "2/(sqrt(w^2 + b^2) + b), b = 4 (gamma_n + 2 gamma_t)/m"
            },
            remedy: DAMPED_MOVING,
            step: oscillator_step_max(
                moving(springs.normal, springs.tangential),
                moving(springs.damping_normal, springs.damping_tangential),
            ),
        },
        Bound {
            cause: "tangential springs and dashpots, mean grain spinning",
            formula: if plane {
                "2/(sqrt(w^2 + b^2) + b), b = 12 gamma_t/m"
            } else {
                "2/(sqrt(w^2 + b^2) + b), b = 20 gamma_t/m"
            },
            remedy: DAMPED_SPINNING,
            step: oscillator_step_max(spinning(sheared(springs, grain)), spinning(springs.damping_tangential)),
        },
    ]
}

/// Springs and dashpots of the lightest grain and the mean ones around it, which move alike:
///
/// ```text
/// A = z/m of it, B = (2 z' - 1)/m' of a mean grain, C = 1/m' of one of its contacts
/// largest eigenvalue of [[A, A], [C, B]]
/// ```
///
/// The ring's grains have as many contacts as a packing without friction balances on, z' = 2 D, and their other neighbours
/// go along with them.
///
/// Measured: the fastest decay of packings of Table 1 under 400 kPa, all contacts sticking, in gamma/m of the mean disc, is
/// 21.6 with 8 % of normal deviation (lightest diameter 0.76 of the mean one), 28.4 with diameters of 0.60 to 1.40, 38.7
/// with 0.41 to 1.6 and 64.2 with 0.31 to 1.7. Here, with the six mean discs of [`bounds_with_dashpots`]: 24, 29.1, 50.9 and
/// 78.9.
fn bounds_among_mean_grains(contact: &Contact, lightest: &GrainScale, mean: &GrainScale) -> [Bound; 2] {
    let contacts = lightest.contacts_among(mean.radius);
    let balanced = 2.0 * mean.dimension as f64;
    let [own, ring] = [lightest, mean].map(|grain| between(contact, grain, mean));
    let both = |share: &dyn Fn(&GrainScale, f64, &Springs) -> f64| {
        let (a, c) = (share(lightest, contacts, &own), share(mean, 1.0, &ring));
        let b = (2.0 * balanced - 1.0) * c;
        0.5 * (a + b) + (0.25 * (a - b) * (a - b) + a * c).sqrt()
    };
    let moving = |grain: &GrainScale, z: f64, springs: &Springs| grain.moving(z, springs.normal, springs.tangential);
    let slowed = |grain: &GrainScale, z: f64, of: &Springs| grain.moving(z, of.damping_normal, of.damping_tangential);
    let spinning = |grain: &GrainScale, z: f64, springs: &Springs| grain.spinning(z, sheared(springs, grain));
    let braked = |grain: &GrainScale, z: f64, springs: &Springs| grain.spinning(z, springs.damping_tangential);
    let plane = mean.dimension == 2;
    [
        Bound {
            cause: "springs and dashpots, lightest grain moving among mean ones",
            formula: if plane {
                "2/(sqrt(w^2 + b^2) + b), b = z (gamma_n + gamma_t)/4m of it and of its ring together"
            } else {
                "2/(sqrt(w^2 + b^2) + b), b = z (gamma_n + 2 gamma_t)/6m of it and of its ring together"
            },
            remedy: DAMPED_MOVING,
            step: oscillator_step_max(both(&moving), both(&slowed)),
        },
        Bound {
            cause: "tangential springs and dashpots, lightest grain spinning among mean ones",
            formula: if plane {
                "2/(sqrt(w^2 + b^2) + b), b = z gamma_t/m of it and of its ring together"
            } else {
                "2/(sqrt(w^2 + b^2) + b), b = 5 z gamma_t/6m of it and of its ring together"
            },
            remedy: DAMPED_SPINNING,
            step: oscillator_step_max(both(&spinning), both(&braked)),
        },
    ]
}

/// A body that a servo moves on the contacts of `count` grains, which all press along the direction it moves in. The two sides
/// of a contact add up as those of two grains do, and the servo's own dashpot is implicit: it bounds nothing.
pub fn bound_of_servo(contact: &Contact, mean: &GrainScale, count: f64, mass: f64) -> Bound {
    // Against a flat face the harmonic mean of the radii is twice the grain's.
    let springs = springs_at(contact, [2.0 * mean.radius; 2], [mean.mass, FLAT], HERTZ_OVERLAP);
    let contacts = mean.contacts_of_equals();
    let both = |normal: f64, tangential: f64| mean.moving(contacts, normal, tangential) + count * normal / mass;
    Bound {
        cause: "grains on a body that its servo moves",
        formula: "2/(sqrt(w^2 + b^2) + b), w^2 = N k_n/M + that of a grain, 2 b = N gamma_n/M + that of a grain",
        remedy: "Beyond it the body bounces off its grains at every step; shorten the step, or raise the servo's mass.",
        step: oscillator_step_max(
            both(springs.normal, springs.tangential),
            both(springs.damping_normal, springs.damping_tangential),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::contact::{
        ElasticRolling, Force, HertzMindlin, LinearCohesive, LinearSpringDashpot, NormalForce, Sliding, TangentialForce,
    };

    fn table_1(damping: f64) -> Contact {
        Contact::from(LinearSpringDashpot {
            stiffness_normal: 1_772_093.8,
            stiffness_tangential: 886_046.9,
            damping_normal: damping,
            damping_tangential: damping,
            friction: 0.5,
            normal_force: NormalForce::TENSILE,
        })
    }

    fn seed_002(rolling_stiffness: f64) -> Contact {
        Contact::from(ElasticRolling {
            young_modulus: 600e6,
            stiffness_ratio: 0.8,
            friction: 0.545,
            rolling_stiffness,
            rolling_limit: 0.05,
            sliding: Sliding::Scaled,
        })
    }

    fn disc(radius: f64) -> GrainScale {
        GrainScale::of(radius, 2530.0, 0.01, 2)
    }

    fn step(contact: &Contact, lightest: &GrainScale, mean: &GrainScale) -> f64 {
        governing(&bounds(contact, lightest, mean)).step
    }

    /// With LAMMPS, on Table 1 of Chen et al. (2021).
    #[test]
    fn what_was_measured_with_dashpots() {
        let (lightest, mean) = (disc(0.38e-3), disc(0.5e-3));
        for (damping, clean, chatters) in [(7.0, 2e-7, 5e-7), (3.5, 4e-7, 5e-7)] {
            let step = step(&table_1(damping), &lightest, &mean);
            assert!(clean < step && step < chatters, "{damping}: {step}");
        }
        assert!((step(&table_1(7.0), &lightest, &mean) / 2.331e-7 - 1.0).abs() < 1e-3);
        assert!((step(&table_1(3.5), &lightest, &mean) / 4.477e-7 - 1.0).abs() < 1e-3);
        // A dashpot alone: gamma_t dt = m/(2 z).
        let mut free = table_1(7.0);
        if let Force::Linear(law) = &mut free.force {
            (law.stiffness_normal, law.stiffness_tangential) = (0.0, 0.0);
        }
        assert!((7.0 * step(&free, &lightest, &mean) / (mean.mass / 12.0) - 1.0).abs() < 1e-12);
    }

    /// The fastest decay of whole packings, see [`bounds_among_mean_grains`]: a guard that looks at mean grains alone lets
    /// the light ones of a wide spread chatter.
    #[test]
    fn the_lightest_grain_of_a_wide_spread_chatters_first() {
        let mean = disc(0.5e-3);
        let mut free = table_1(1.0);
        if let Force::Linear(law) = &mut free.force {
            (law.stiffness_normal, law.stiffness_tangential) = (0.0, 0.0);
        }
        for (radius, measured) in [(0.38e-3, 21.6), (0.302e-3, 28.4), (0.2034e-3, 38.7), (0.1533e-3, 64.2)] {
            let rate = 2.0 / step(&free, &disc(radius), &mean) * mean.mass;
            assert!((1.0..1.4).contains(&(rate / measured)), "{radius}: {rate} for {measured}");
        }
        // Diameters of 0.3 to 1.7 mm: tau/p was 0.326 at 0.44 us, 0.443 at 0.06 us.
        let wide = step(&table_1(3.5), &disc(0.15e-3), &mean);
        assert!(0.06e-6 < wide && wide < 0.44e-6, "{wide}");
        // Where one grain is as heavy as the others, the lattice is faster.
        assert_eq!(
            governing(&bounds(&free, &mean, &mean)).cause,
            "tangential springs and dashpots, mean grain spinning"
        );
    }

    /// A weight on springs alone has 2/w; grains that are light against it have their own bound, and a heavy body no part in it.
    #[test]
    fn a_light_body_on_many_contacts_is_bounded_by_them() {
        let heavy = GrainScale { mass: 1e9, ..disc(0.5e-3) };
        let mut springs = table_1(0.0);
        let bound = bound_of_servo(&springs, &heavy, 20.0, 1e-6).step;
        assert!((bound / (2.0 / (20.0f64 * 1_772_093.8 / 1e-6).sqrt()) - 1.0).abs() < 1e-12, "{bound}");
        if let Force::Linear(law) = &mut springs.force {
            law.damping_normal = 3.5;
        }
        assert!(bound_of_servo(&springs, &heavy, 20.0, 1e-6).step < bound);
        let mean = disc(0.5e-3);
        assert!(bound_of_servo(&springs, &mean, 20.0, 1.0).step > step(&springs, &mean, &mean));
    }

    /// YADE ran these discs at 3.16e-5 s; a grain alone among its like would not be let to.
    #[test]
    fn what_was_measured_with_stiffness_that_grows_with_size() {
        let grain = |radius| GrainScale::of(radius, 2650.0, 0.1, 2);
        let found = step(&seed_002(0.0), &grain(3.015e-3), &grain(5.005e-3));
        assert!(3.161e-5 < found && found < 3.4e-5, "{found}");
    }

    /// Grains of one size are a lattice, whose eigenvalue both ways of counting must give.
    #[test]
    fn equal_grains_are_bounded_alike() {
        for dimension in [2, 3] {
            let grain = GrainScale::of(1e-3, 2650.0, 0.1, dimension);
            let springs = springs_at(&seed_002(0.0), [1e-3; 2], [FLAT; 2], HERTZ_OVERLAP);
            let linear = Contact::from(LinearSpringDashpot {
                stiffness_normal: springs.normal,
                stiffness_tangential: springs.tangential,
                damping_normal: 0.0,
                damping_tangential: 0.0,
                friction: 0.5,
                normal_force: NormalForce::TENSILE,
            });
            let (one, other) = (step(&linear, &grain, &grain), step(&seed_002(0.0), &grain, &grain));
            assert!((one / other - 1.0).abs() < 1e-12, "{dimension}: {one} {other}");
            let omega_squared = (2.0 / one) * (2.0 / one);
            let factor = if dimension == 2 { 24.0 } else { 40.0 };
            assert!((omega_squared * grain.mass / (factor * springs.tangential) - 1.0).abs() < 1e-12);
        }
    }

    /// The twelve neighbours of a sphere in the densest packing: k_n along the contact, k_t across it.
    #[test]
    fn the_densest_packing_of_spheres_has_the_factors_of_the_formulas() {
        let mut normals = Vec::new();
        for (first, second) in [(0, 1), (0, 2), (1, 2)] {
            for (a, b) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let mut normal = [0.0f64; 3];
                (normal[first], normal[second]) = (a / 2.0f64.sqrt(), b / 2.0f64.sqrt());
                normals.push(normal);
            }
        }
        assert_eq!(normals.len(), 12);
        let along: f64 = normals.iter().map(|normal| normal[0] * normal[0]).sum();
        let across = 12.0 - along;
        let grain = GrainScale { radius: 1.0, mass: 1.0, dimension: 3 };
        // Neighbours move against it: twice the relative motion of one that moves alone.
        assert!((2.0 * grain.moving(12.0, 1.0, 0.0) - 2.0 * along).abs() < 1e-12);
        assert!((2.0 * grain.moving(12.0, 0.0, 1.0) - 2.0 * across).abs() < 1e-12);
        // All spin alike about x: contacts slide by twice the share of r that is across the axis, against I = 2/5.
        assert!((2.0 * grain.spinning(12.0, 1.0) - 2.0 * across / 0.4).abs() < 1e-12);
    }

    #[test]
    fn rolling_springs_and_cohesion() {
        let grain = disc(1e-3);
        let rolling = &bounds(&seed_002(1.0), &grain, &grain)[1];
        let free = &bounds(&seed_002(0.0), &grain, &grain)[1];
        assert!((free.step / rolling.step - 2.0f64.sqrt()).abs() < 1e-12, "beta = 1 doubles omega^2");
        let Force::Linear(linear) = table_1(3.5).force else { unreachable!("it was made so") };
        let cohesive = LinearCohesive { linear, cohesion_normal: 1.0, cohesion_tangential: 1.0 };
        let bounds_cohesive = bounds(&Contact::from(cohesive), &grain, &grain);
        assert_eq!(bounds_cohesive, bounds(&table_1(3.5), &grain, &grain));
    }

    /// Liu et al. (2016), Table I: G = 29 GPa, nu = 0.15, spheres of 0.43 to 1.18 mm.
    #[test]
    fn hertz_contacts() {
        let law = HertzMindlin {
            shear_modulus: 29e9,
            poisson_ratio: 0.15,
            friction: 0.5,
            damping_normal: 0.0,
            damping_tangential: 0.0,
            damping_ratio: 0.0,
            normal_force: NormalForce::TENSILE,
            tangential_force: TangentialForce::Incremental,
        };
        let sphere = |radius| GrainScale::of(radius, 2650.0, 0.0, 3);
        let springs = springs_at(&Contact::from(law), [1e-3; 2], [FLAT; 2], 0.01);
        let wanted = 2.0f64.sqrt() * 29e9 * (1e-3f64 * 1e-5).sqrt() / 0.85;
        assert!((springs.normal / wanted - 1.0).abs() < 1e-12);
        assert!((springs.tangential / springs.normal - 2.0 * 0.85 / 1.85).abs() < 1e-12);
        let undamped = bounds(&Contact::from(law), &sphere(0.2e-3), &sphere(0.4e-3));
        assert_eq!(undamped.len(), 2);
        let rayleigh = PI * 0.2e-3 * (2650.0f64 / 29e9).sqrt() / (0.1631 * 0.15 + 0.8766);
        let share = governing(&undamped).step / rayleigh;
        assert!((0.1..1.0).contains(&share), "of the Rayleigh time: {share}");
        let damped = HertzMindlin { damping_normal: 0.12, damping_tangential: 0.12, ..law };
        assert_eq!(bounds(&Contact::from(damped), &sphere(0.2e-3), &sphere(0.4e-3)).len(), 4);
        // A damping ratio bounds as the constants that it comes to at the overlap of the springs.
        let grain = sphere(0.4e-3);
        let ratio = Contact::from(HertzMindlin { damping_ratio: 0.3, ..law });
        let stiff = springs_at(&ratio, [0.4e-3; 2], [FLAT; 2], HERTZ_OVERLAP).normal;
        let damping = 2.0 * (5.0f64 / 6.0).sqrt() * 0.3 * (0.5 * grain.mass * stiff).sqrt();
        let constant = HertzMindlin { damping_normal: damping, damping_tangential: damping, ..law };
        let [by_ratio, by_constant] =
            [ratio, Contact::from(constant)].map(|of| governing(&bounds(&of, &grain, &grain)).step);
        assert!((by_ratio / by_constant - 1.0).abs() < 1e-12 && by_ratio < governing(&undamped).step);
    }

    /// Without a dashpot the bound is 2/omega, without a spring 2/rate.
    #[test]
    fn limits_of_the_damped_oscillator() {
        assert_eq!(oscillator_step_max(4.0, 0.0), 1.0);
        assert_eq!(oscillator_step_max(0.0, 4.0), 0.5);
    }

    #[test]
    fn fewer_large_grains_fit_around_a_small_one() {
        assert!((disc(1e-3).contacts_among(1e-3) - 6.0).abs() < 1e-12);
        assert!((disc(1e-3).contacts_among(1e3) - 3.0).abs() < 1e-12);
        let sphere = GrainScale::of(1e-3, 1.0, 0.0, 3);
        assert!((sphere.contacts_among(1e-3) - 12.0).abs() < 1e-12);
        assert!((sphere.contacts_among(1e3) - 4.0).abs() < 1e-12);
        let around = disc(3e-3).contacts_among(5e-3);
        assert!((4.0..5.0).contains(&around), "{around}");
    }
}
