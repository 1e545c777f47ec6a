//! What is run: the world of a job at its start or at a checkpoint, and what is told of it. A kind of job is a [`Setup`]; the loop,
//! start and resume know no other.

use scree_partition::Transport;

use crate::base::error::Error;
use crate::base::ids::PointId;
use crate::base::space::Space;
use crate::dem::law::SharedLaw;
use crate::domain::accounts::ledger::Accounts;
use crate::domain::parts::Parts;
use crate::domain::world::World;
use crate::job::Output;
use crate::mpm::membrane::Vertex;
use crate::mpm::stress::SharedMaterial;
use crate::run::Core;
use crate::run::columns::Columns;
use crate::run::folder::{CONTACTS_OF, Folder, GRAINS_OF};
use crate::run::output::FrameSeries;
use crate::store::checkpoint::{Drawn, Progress};

/// A kind of job: how its world comes about. All ranks call these together.
pub trait Setup {
    /// The plane or space.
    type Space: Space;

    /// What is told of the run, and what happens between its steps.
    fn experiment(&self) -> Experiment<'_, Self::Space>;
    /// The law of contacts between grains.
    fn law(&self) -> SharedLaw<Self::Space>;
    /// The law of the points' material.
    fn material(&self) -> SharedMaterial<Self::Space>;
    /// The world at time zero. `folder` is where rank 0 keeps what a later state is made of.
    fn begin<'t>(
        &self,
        folder: &mut Option<Folder>,
        transport: &'t dyn Transport,
    ) -> Result<(WorldOf<'t, Self>, Progress), Error>;
    /// Cell, bodies and membranes as they are drawn, these with vertices as they are now.
    fn drawn(&self, progress: &Progress, vertices: Vec<Vertex<Self::Space>>) -> Result<Drawn<Self::Space>, Error>;
    /// The world of a state.
    fn world_at<'t>(
        &self,
        progress: &Progress,
        parts: Parts<Self::Space>,
        transport: &'t dyn Transport,
    ) -> Result<WorldOf<'t, Self>, Error>;
}

/// The world of a kind of job.
pub type WorldOf<'t, M> = World<'t, <M as Setup>::Space>;

/// What happens between two steps beside observing.
type Watch<'s, S> = Box<dyn for<'t> FnMut(&mut Core<'t, S>) -> Result<(), Error> + 's>;

type Strain<'s, S> = Box<dyn Fn(&World<S>) -> f64 + 's>;

/// What is told of a run.
pub struct Experiment<'s, S: Space> {
    /// The resolved job.
    pub job: String,
    /// How often rows, frames and checkpoints are written: `[output]`.
    pub output: &'s Output,
    /// Steps of the whole run.
    pub steps: u64,
    /// Accounts of energy that are kept from the first step on, and anew once grains have entered.
    pub accounts: Accounts,
    /// An unstable step was allowed, so that energy which grows is told and stops nothing.
    pub allows_unstable: bool,
    /// What frames are drawn with.
    pub picture: Picture,
    /// Points whose RVEs are drawn with every frame, by the names of their files.
    pub drawn_rves: Vec<(String, PointId)>,
    /// Those of `series.csv`, in their order.
    pub columns: Vec<Columns<'s, S>>,
    /// After every pass of the loop, before anything of it is written. Collective.
    pub watch: Watch<'s, S>,
    /// Horizontal strain, where the job has one; it is told in the place of time.
    pub strain: Option<Strain<'s, S>>,
}

impl<S: Space> Experiment<'_, S> {
    /// The files of frames that it writes, each with a frame at every time that there is one.
    pub fn frame_series(&self) -> Vec<FrameSeries> {
        let of = |name: String, is_of_contacts| FrameSeries::of(name, is_of_contacts);
        let mut frame_series = vec![of("frames".into(), false)];
        frame_series.extend(self.picture.has_elements.then(|| of("elements".into(), false)));
        frame_series.extend(self.output.contact_frames.then(|| of("contacts".into(), true)));
        for (name, _) in &self.drawn_rves {
            frame_series.extend([of(format!("{GRAINS_OF}{name}"), false), of(format!("{CONTACTS_OF}{name}"), true)]);
        }
        frame_series
    }

    /// Names of the columns of `series.csv`.
    pub fn header(&self) -> Vec<String> {
        self.columns.iter().flat_map(|columns| columns.names.clone()).collect()
    }

    /// How far the run is, for a person.
    pub fn told(&self, world: &World<S>) -> String {
        let (grains, points) = (world.grains_total, world.points_total);
        let counts = match (self.picture.may_have_grains, self.picture.may_have_points) {
            (true, false) => format!("{grains} grains"),
            (false, _) => format!("{points} points"),
            (true, true) => format!("{grains} grains and {points} points"),
        };
        match &self.strain {
            Some(strain) => format!("horizontal strain {:.2} %, {counts}", 100.0 * strain(world)),
            None => format!("time {:.4e} s, {counts}", world.time()),
        }
    }
}

/// What frames show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picture {
    /// Out-of-plane depth, m.
    pub depth: f64,
    /// Whether their number is told; of a job with grains and no RVEs also where it has points alone.
    pub may_have_grains: bool,
    /// At some time of the run; frames have their fields then.
    pub may_have_points: bool,
    /// Points are those of elements, which are drawn as well.
    pub has_elements: bool,
    /// Points near the nodes that the oracle has flagged are marked.
    pub flagged: bool,
}
