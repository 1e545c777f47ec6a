//! The contact law of a job: one of some laws, and the parts that go with any of them.

use super::adhesion::Adhesive;
use super::rolling::Rolling;
use super::{
    Adhesion, ContactLaw, ElasticRolling, ForAnyLaw, HertzMindlin, LinearCohesive, LinearSpringDashpot,
    RollingResistance, Springs, Stiffening,
};
use crate::base::keys::{Form, text, variant};
use crate::base::space::{Plane, Space};

/// What a law says of itself, whatever the space.
pub trait Described {
    /// Its keys. `mass_mean`: mass of the mean grain, kg, which turns a restitution into a damping.
    fn keys(&mut self, form: &mut dyn Form, mass_mean: f64);
    /// mu.
    fn friction(&mut self) -> &mut f64;
    /// Takes what makes grains cohere.
    fn without_cohesion(&mut self) {}
    /// Takes what loses energy beside friction: dashpots, and rolling that slips.
    fn without_loss(&mut self);
    /// Resistance to rolling of a law that has it by itself.
    fn rolling(&self) -> Option<RollingResistance> {
        None
    }
    /// What its stiffness depends on.
    fn stiffening(&self) -> Stiffening;
    /// The keys that its stiffness follows from, normal and tangential.
    fn keys_of_stiffness(&self) -> [&'static str; 2];
}

/// A law with its constants; each law's file beside this one has its equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Force {
    /// `law = "linear"`.
    Linear(LinearSpringDashpot),
    /// `law = "linear_cohesive"`.
    LinearCohesive(LinearCohesive),
    /// `law = "elastic_rolling"`.
    ElasticRolling(ElasticRolling),
    /// `law = "hertz_mindlin"`.
    HertzMindlin(HertzMindlin),
}

impl Force {
    /// The laws as jobs name them, with constants for jobs that say nothing of contacts because nothing of them touches.
    pub const LAWS: [(&'static str, Self); 4] = {
        let linear = LinearSpringDashpot::CHEN;
        [
            ("linear", Self::Linear(linear)),
            (
                "linear_cohesive",
                Self::LinearCohesive(LinearCohesive { linear, cohesion_normal: 0.0, cohesion_tangential: 0.0 }),
            ),
            ("elastic_rolling", Self::ElasticRolling(ElasticRolling::ASLEEP)),
            ("hertz_mindlin", Self::HertzMindlin(HertzMindlin::ASLEEP)),
        ]
    };

    /// The law as it tells of itself, whichever it is.
    pub fn described(&mut self) -> &mut dyn Described {
        match self {
            Self::Linear(law) => law,
            Self::LinearCohesive(law) => law,
            Self::ElasticRolling(law) => law,
            Self::HertzMindlin(law) => law,
        }
    }

    fn apply<S: Space, W: ForAnyLaw<S>>(&self, parts: &Contact, work: W) -> W::Outcome {
        match self {
            Self::Linear(law) => parts.beside(law, work),
            Self::LinearCohesive(law) => parts.beside(law, work),
            // It has its resistance to rolling by itself.
            Self::ElasticRolling(law) => parts.adhering(*law, work),
            Self::HertzMindlin(law) => parts.beside(law, work),
        }
    }
}

/// The contact law with its parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Springs, dashpots and friction.
    pub force: Force,
    /// None where rolling is not resisted, or where the law resists it by itself.
    pub rolling: Option<RollingResistance>,
    /// None where surfaces do not attract each other.
    pub adhesion: Option<Adhesion>,
}

impl<L: Into<Force>> From<L> for Contact {
    fn from(law: L) -> Self {
        Self { force: law.into(), rolling: None, adhesion: None }
    }
}

impl Contact {
    /// For jobs that say nothing of contacts because nothing of them touches.
    pub const ASLEEP: Self = Self { force: Force::LAWS[0].1, rolling: None, adhesion: None };

    /// The keys of `[contact]`. `mass_mean`: mass of the mean grain, kg, which turns a restitution into a damping.
    pub fn keys(&mut self, form: &mut dyn Form, mass_mean: f64) {
        let about = "the contact law: linear, linear_cohesive, elastic_rolling or hertz_mindlin";
        let key = text("law", about, "\"linear\"").or("linear");
        let Self { force, rolling, adhesion } = self;
        variant(form, force, "contact law", key, &Force::LAWS, |force, form| {
            let law = force.described();
            law.keys(form, mass_mean);
            if law.rolling().is_none() {
                RollingResistance::keys(rolling, form);
            }
            Adhesion::keys(adhesion, form);
        });
    }

    /// The law as jobs name it.
    pub fn law(&self) -> &'static str {
        let is_this = |of: &Force| std::mem::discriminant(of) == std::mem::discriminant(&self.force);
        Force::LAWS.iter().find(|(_, of)| is_this(of)).map(|(name, _)| *name).expect("every law has a name")
    }

    /// Does the work with the law and its parts: the one place where these are told apart.
    pub fn apply<S: Space, W: ForAnyLaw<S>>(&self, work: W) -> W::Outcome {
        self.force.apply(self, work)
    }

    fn beside<S: Space, C: ContactLaw<S>, W: ForAnyLaw<S>>(&self, law: &C, work: W) -> W::Outcome {
        match self.rolling {
            Some(resistance) => self.adhering(Rolling { law: *law, resistance }, work),
            None => self.adhering(*law, work),
        }
    }

    fn adhering<S: Space, C: ContactLaw<S>, W: ForAnyLaw<S>>(&self, law: C, work: W) -> W::Outcome {
        match self.adhesion {
            Some(adhesion) => work.with(&Adhesive { law, adhesion }),
            None => work.with(&law),
        }
    }

    /// Springs and dashpots of a contact as it is. Radii in m, masses in kg, [`super::FLAT`] of what a body moves.
    pub fn springs(&self, radii: [f64; 2], masses: [f64; 2], overlap: f64) -> Springs {
        self.apply::<Plane, _>(SpringsOf { radii, masses, overlap })
    }

    /// How far apart surfaces may be and still hold on to each other, m.
    pub fn reach(&self) -> f64 {
        self.apply::<Plane, _>(Reach)
    }

    /// What the law says of itself.
    fn told<T>(mut self, of: impl FnOnce(&mut dyn Described) -> T) -> T {
        of(self.force.described())
    }

    /// What the stiffness of contacts depends on.
    pub fn stiffening(&self) -> Stiffening {
        self.told(|law| law.stiffening())
    }

    /// The keys that its stiffness follows from, normal and tangential.
    pub fn keys_of_stiffness(&self) -> [&'static str; 2] {
        self.told(|law| law.keys_of_stiffness())
    }

    /// Resistance to rolling, be it the law's own.
    pub fn rolling(&self) -> Option<RollingResistance> {
        self.told(|law| law.rolling()).or(self.rolling)
    }

    /// Whether contacts may bear tension for longer than a dashpot pulls.
    pub fn coheres(&self) -> bool {
        *self != self.without_cohesion()
    }

    /// mu.
    pub fn friction(&self) -> f64 {
        self.told(|law| *law.friction())
    }

    /// The same law with another friction coefficient.
    pub fn with_friction(mut self, friction: f64) -> Self {
        *self.force.described().friction() = friction;
        self
    }

    /// The same law between grains that do not cohere.
    pub fn without_cohesion(mut self) -> Self {
        self.force.described().without_cohesion();
        Self { adhesion: None, ..self }
    }

    /// The law while grains are compressed to a packing: with that packing's friction, and without cohesion, which would hold
    /// them where they were inserted. Whatever touches at the end coheres from the first step of the run on.
    pub fn while_compressed(self, friction: f64) -> Self {
        self.with_friction(friction).without_cohesion()
    }

    /// The same law without friction, dashpots, cohesion and resistance to rolling: contacts that keep a gas as hot as it is.
    pub fn without_loss(self) -> Self {
        let mut contact = self.while_compressed(0.0);
        contact.force.described().without_loss();
        Self { rolling: None, ..contact }
    }
}

struct SpringsOf {
    radii: [f64; 2],
    masses: [f64; 2],
    overlap: f64,
}

impl<S: Space> ForAnyLaw<S> for SpringsOf {
    type Outcome = Springs;

    fn with<C: ContactLaw<S>>(self, law: &C) -> Springs {
        law.stiffness(self.radii, self.masses, self.overlap)
    }
}

struct Reach;

impl<S: Space> ForAnyLaw<S> for Reach {
    type Outcome = f64;

    fn with<C: ContactLaw<S>>(self, law: &C) -> f64 {
        law.reach()
    }
}
