//! The tables of a continuum's job and their keys.

use super::{
    BodyContact, Boundary, Face, Followed, Granular, Gravity, Grid, InitialStress, KnownBands, Load, LoadKind,
    Material, Membrane, Mesh, Mpm, Origin, Path, Region, RegionShape, RigidBody, Rves, Watch, Wave,
};
use crate::base::keys::{
    DAMPING, DENSITY, FORCE, Form, Key, LENGTH, NOT_NEGATIVE, POSITIVE, RATIO, Range, SPEED, STIFFNESS, STRESS, TIME,
    Table, Wants, choose, count, flag, key, number, size, text, variant, vector,
};
use crate::base::units::Dimension;
use crate::couple::oracle::{Laplacian, Oracle};
use crate::couple::zone::Enrichment;
use crate::job::assembly::{Assembly, Body, Packed, Source, corners, depth, keys_of_grains, space};
use crate::job::figures::bounds;
use crate::job::resolve::FILE;
use crate::job::schema::{list, section};
use crate::job::shear::{heterogeneity, keys_of_step, keys_of_subcycling, plane, skin};
use crate::job::stable::governing;
use crate::job::write::Page;
use crate::job::{Method, Output};
use crate::law::contact::Contact;
use crate::law::material::ConstitutiveLaw;
use crate::mpm::nonlocal::Nonlocal;
use crate::mpm::penalty::Coupling;
use crate::mpm::scheme::Scheme;

impl Mpm {
    /// The job in SI numbers with nothing left to a default. It parses back to an equal continuum.
    pub fn to_toml(&self) -> String {
        let (mut job, mut page) = (self.clone(), Page::new(self.grid.dimension));
        job.head(&mut page);
        match &mut job.mesh {
            Some(mesh) => page.section("mesh", |page| mesh.keys(&mut job.grid, page)),
            None => {
                page.section("grid", |page| job.grid.keys(page));
                page.section("scheme", |page| job.scheme.keys(page));
            }
        }
        page.section("material", |page| {
            job.material.keys(page, job.grains.is_some());
            if let Some(granular) = job.grains.as_mut().filter(|granular| !granular.method.has_rves()) {
                granular.keys_of_start(page);
            }
        });
        page.section("stress", |page| job.stress.keys(page));
        page.section("gravity", |page| job.gravity.keys(page));
        page.section("time", |page| job.keys_of_time(page));
        if let Some(watch) = &mut job.oracle {
            page.section("oracle", |page| watch.keys(page));
        }
        page.section("decomposition", |page| job.keys_of_decomposition(page));
        if let Some(nonlocal) = &mut job.nonlocal {
            page.section("nonlocal", |page| nonlocal.keys(page));
        }
        if let Some(granular) = &mut job.grains {
            let piece = &mut granular.piece;
            page.section("grains", |page| keys_of_grains(page, &mut piece.matter, &mut piece.source));
            if let Source::Packed(packed) = &mut piece.source {
                page.section("packing", |page| packed.keys(page));
            }
            page.section("contact", |page| piece.contact.keys(page, 0.0));
            match granular.method {
                Method::MpmDem | Method::FemDem => {
                    page.section("damping", |page| granular.piece.damping.keys(page));
                    page.section("rve", |page| granular.rves.keys(page));
                }
                Method::Hybrid | Method::Dem | Method::Mpm | Method::Fem => {
                    page.section("coupling", |page| granular.coupling.keys(page));
                    page.section("enrichment", |page| granular.keys_of_enrichment(page));
                    page.section("zone", |page| granular.enrichment.life.keys(page));
                }
            }
        }
        page.section("output", |page| job.output.keys(page, &mut job.ledger));
        let (mut named, mut parts) = (job.boundaries_named(), job.parts_of_bands());
        job.lists(&mut page, &mut named, &mut parts);
        page.text()
    }

    pub(in crate::job) fn head(&mut self, form: &mut dyn Form) {
        form.text(
            &mut self.name,
            text("name", "the job's name, also that of its run directory", "\"column_collapse\""),
        );
        let mut blank = form.describes().then(Granular::blank);
        if let Some(grains) = self.grains.as_deref_mut().or(blank.as_mut()) {
            grains.method.keys(form, "what a job with [grains] is made of: hybrid, dem, mpm or mpm_dem with [grid], fem_dem with [mesh]; refused without [grains]");
            let seed = count("seed", "the seed of every random number", (0, i64::MAX as u64), "1");
            form.count(&mut grains.piece.seed, seed.or("1"));
        }
    }

    pub(in crate::job) fn keys_of_time(&mut self, form: &mut dyn Form) {
        keys_of_step(&mut self.step, form);
        form.number(
            &mut self.end,
            number("end", "the simulated time at which the run ends", TIME, POSITIVE, "\"1 s\""),
        );
        if self.grains.is_some() || form.describes() {
            keys_of_subcycling(&mut self.grain_steps, form);
        }
        Self::safety(form);
    }

    /// The time step over the stable one, where it is typed.
    pub(in crate::job) fn safety(form: &mut dyn Form) -> Option<f64> {
        let mut safety = None;
        let about = "the time step over the stable one, in place of step";
        let key = number("safety", about, RATIO, Range::above(0.0, 1.0), "0.5");
        form.number_if_given(&mut safety, key.follows("0.5 where there is no step"));
        safety
    }

    pub(in crate::job) fn keys_of_decomposition(&mut self, form: &mut dyn Form) {
        let about = "the edge of a block in cells: at least 1 with [mesh], 2 on a grid, 3 with cubic shape functions";
        let cells = count("cells_per_block", about, (1, 64), "8")
            .follows("8 in the plane, 4 in space, the least there may be with RVEs, or what fits periods");
        size(form, &mut self.cells_per_block, cells);
        let mut blank = form.describes().then(Granular::blank);
        if let Some(grains) = self.grains.as_deref_mut().or(blank.as_mut()) {
            skin(form, &mut grains.piece.skin);
        }
    }

    /// Faces with what happens at them.
    fn boundaries_named(&self) -> Vec<(Face, Boundary)> {
        Face::all(self.grid.dimension)
            .map(|face| (face, self.boundaries[face.axis][usize::from(face.upper)]))
            .filter(|(_, boundary)| *boundary != Boundary::Periodic)
            .collect()
    }

    fn parts_of_bands(&self) -> Vec<[[f64; 2]; 2]> {
        self.grains.as_ref().and_then(|grains| grains.known.clone()).unwrap_or_default().parts
    }

    /// Tables of which there may be any number; faces with what happens at them, and parts of bands, stand beside the job.
    pub(in crate::job) fn lists(
        &mut self,
        form: &mut dyn Form,
        named: &mut Vec<(Face, Boundary)>,
        parts: &mut Vec<[[f64; 2]; 2]>,
    ) {
        let of = |name, about, example| key(name, about, Wants::Text, example).optional();
        let region =
            of("region", "where material is at the start", "[{shape = \"box\", lower = [0, 0], upper = [1, 1]}]");
        list(form, &mut self.regions, region, "material at the start", &Region::BLANK, Region::keys);
        let boundary =
            of("boundary", "what happens at the faces of the grid", "[{face = \"y_lower\", kind = \"fixed\"}]");
        let blank = (Face { axis: 0, upper: false }, Boundary::Fixed);
        list(form, named, boundary, "what happens at a face of the grid", &blank, Boundary::keys);
        let example = "[{face = \"y_upper\", kind = \"pressure\", pressure = \"1 kPa\"}]";
        let load = of("load", "loads on the material's surface", example);
        list(form, &mut self.loads, load, "a load on the material's surface", &Load::BLANK, Load::keys);
        let membrane = of("membrane", "elastic membranes that press on the material", "[]");
        let about = "an elastic membrane under pressure, in the plane";
        list(form, &mut self.membranes, membrane, about, &Membrane::BLANK, Membrane::keys);
        let body = of("body", "rigid bodies that the material touches", "[]");
        list(form, &mut self.bodies, body, "a rigid body", &RigidBody::BLANK, RigidBody::keys);
        let band = of("band", "straight parts of shear bands that are known", "[]");
        list(form, parts, band, "a straight part of a shear band that is known", &[[0.0; 2]; 2], keys_of_band);
        let follow =
            of("follow", "points with columns of their own in the series", "[{name = \"tip\", place = [0, 0]}]");
        let about = "a point with columns of its own in the series";
        let blank = Followed { frames: self.rves().is_some(), ..Followed::BLANK };
        list(form, &mut self.follow, follow, about, &blank, Followed::keys);
    }

    /// The tables of a job, with all their keys.
    pub(in crate::job) fn tables() -> Vec<Table> {
        let mut job = Self::blank();
        let (mut grains, mut packed) = (Granular::blank(), Packed::blank(2));
        let piece = &mut grains.piece;
        let mut watch = Watch::BLANK;
        vec![
            section("", "the job itself", |form| {
                job.head(form);
                job.lists(form, &mut Vec::new(), &mut Vec::new());
            }),
            section("grid", "the domain of a continuum and its cells", |form| job.grid.keys(form)),
            section("mesh", "a continuum of elements, in place of a grid", |form| {
                Mesh::BLANK.clone().keys(&mut Self::blank().grid, form)
            }),
            Scheme::table(),
            Material::table(),
            section("stress", "the stress at the start", |form| job.stress.keys(form)),
            section("gravity", "the acceleration of all material", |form| job.gravity.keys(form)),
            section("time", "the time step and the end", |form| job.keys_of_time(form)),
            section("decomposition", "how the domain is cut", |form| job.keys_of_decomposition(form)),
            section("oracle", "where a shear band would be replaced by grains", |form| watch.keys(form)),
            section("grains", "sizes and matter of the grains", |form| {
                keys_of_grains(form, &mut piece.matter, &mut piece.source);
            }),
            section("packing", "how a piece of packing is made, which is laid side by side", |form| packed.keys(form)),
            section("contact", "forces between grains", |form| piece.contact.keys(form, 0.0)),
            section("damping", "damping of grains of RVEs beside that of their contacts", |form| {
                piece.damping.keys(form)
            }),
            section("rve", "grains as the material of points", |form| grains.rves.keys(form)),
            section("nonlocal", "a mean of strain around every point", |form| Nonlocal::BLANK.clone().keys(form)),
            section("coupling", "how grains are held to nodes that they share with points or membranes", |form| {
                grains.coupling.keys(form);
            }),
            section("enrichment", "grains for points", |form| grains.keys_of_enrichment(form)),
            section("zone", "what becomes of the grains' zone", |form| grains.enrichment.life.keys(form)),
            section("output", "what is written and when", |form| job.output.keys(form, &mut job.ledger)),
        ]
    }

    /// What a job is before it is read.
    pub(in crate::job) fn blank() -> Self {
        Self {
            name: String::new(),
            grid: Grid {
                dimension: 2,
                lower: [0.0; 3],
                upper: [0.0; 3],
                cell: 0.0,
                cells: [1; 3],
                periodic: [false; 3],
                depth: 1.0,
            },
            mesh: None,
            scheme: Scheme::DEFAULT,
            material: Material { density: 0.0, law: ConstitutiveLaw::LAWS[0].1 },
            regions: Vec::new(),
            stress: InitialStress::None,
            gravity: Gravity { acceleration: [0.0; 3], ramp: 0.0 },
            boundaries: [[Boundary::Free; 2]; 3],
            loads: Vec::new(),
            membranes: Vec::new(),
            bodies: Vec::new(),
            follow: Vec::new(),
            oracle: None,
            nonlocal: None,
            grains: None,
            step: 0.0,
            grain_steps: 1,
            end: 0.0,
            cells_per_block: 0,
            output: Output::default(),
            ledger: false,
        }
    }
}

impl Grid {
    pub(in crate::job) fn keys(&mut self, form: &mut dyn Form) {
        space(form, &mut self.dimension, "plane for plane strain, solid for three dimensions");
        form.vector(&mut self.lower, vector("lower", "the lower corner", LENGTH, "\"0 m\"").follows("the origin"));
        form.vector(&mut self.upper, vector("upper", "the upper corner", LENGTH, "\"4 m\""));
        form.number(&mut self.cell, number("cell", "the edge of a cell", LENGTH, POSITIVE, "\"10 cm\""));
        depth(form, &mut self.depth, "a solid has");
        form.flags(
            &mut self.periodic,
            key("periodic", "which axes are periodic", Wants::Flags, "false").follows("none"),
        );
    }
}

impl Material {
    /// `[material]`.
    pub(in crate::job) fn table() -> Table {
        let mut material = Mpm::blank().material;
        section("material", "what the points are made of", |form| {
            material.keys(form, false);
            Granular::blank().keys_of_start(form);
            form.path_if_given(&mut None, FILE);
        })
    }

    /// Beside grains the density is theirs.
    pub(in crate::job) fn keys(&mut self, form: &mut dyn Form, beside_grains: bool) {
        self.law.keys(form);
        if !beside_grains {
            let about = "the density of the material with its pores";
            let density = number("density", about, DENSITY, POSITIVE, "\"2000 kg/m3\"");
            form.number(&mut self.density, density.required("in a job without grains"));
        } else if form.has("density") {
            form.note(
                "density",
                "is that of the packing in a job with grains: grains.density times its solid volume fraction. Remove the line.",
            );
        }
    }
}

impl InitialStress {
    /// The keys of `[stress]`.
    pub fn keys(&mut self, form: &mut dyn Form) {
        let kinds = [
            ("none", Self::None),
            ("isotropic", Self::Isotropic { pressure: 0.0 }),
            ("geostatic", Self::Geostatic { axis: 1, up: 1.0, surface: 0.0, k0: 0.0, surcharge: 0.0 }),
        ];
        let key = text("kind", "none, isotropic or geostatic", "\"geostatic\"").or("none");
        variant(form, self, "kind of stress", key, &kinds, |stress, form| match stress {
            Self::None => {}
            Self::Isotropic { pressure } => {
                form.number(pressure, number("pressure", "the pressure everywhere", STRESS, POSITIVE, "\"100 kPa\""));
            }
            Self::Geostatic { surface, k0, surcharge, .. } => {
                let about = "the coordinate of the surface along gravity";
                form.number(surface, number("surface", about, LENGTH, Range::ANY, "\"1 m\""));
                let about = "the stress across over the stress along gravity";
                form.number(k0, number("k0", about, RATIO, Range::closed(0.0, 10.0), "0.5"));
                let about = "the pressure on the surface";
                form.number(surcharge, number("surcharge", about, STRESS, NOT_NEGATIVE, "\"20 kPa\"").or("0.0"));
            }
        });
    }
}

impl Gravity {
    pub(in crate::job) fn keys(&mut self, form: &mut dyn Form) {
        let about = "the acceleration";
        form.vector(
            &mut self.acceleration,
            vector("acceleration", about, Dimension::ACCELERATION, "[0, \"-9.81 m/s2\"]"),
        );
        let about = "the time over which it rises from zero";
        form.number(&mut self.ramp, number("ramp", about, TIME, NOT_NEGATIVE, "\"0.1 s\"").or("0.0"));
    }
}

impl Region {
    pub(in crate::job) const BLANK: Self = Self {
        shape: RegionShape::Box { lower: [0.0; 3], upper: [0.0; 3] },
        fraction: f64::NAN,
        velocity: [0.0; 3],
        spin: [0.0; 3],
        waves: Vec::new(),
        grains_removed: 0,
    };

    /// Where it has no solid volume fraction of its own, it has that of the material; elastic ones, which have none, count as 1.
    pub(in crate::job) fn keys(&mut self, form: &mut dyn Form) {
        let [lower, upper, centre] = [[0.0; 3]; 3];
        let kinds = [
            ("box", RegionShape::Box { lower, upper }),
            ("ball", RegionShape::Ball { centre, radius: 0.0 }),
            ("polygon", RegionShape::Polygon { vertices: Vec::new() }),
            ("group", RegionShape::Group { name: String::new(), bits: 0, lower, upper }),
        ];
        let key_of_shape = text("shape", "box, ball, polygon or group", "\"box\"");
        variant(form, &mut self.shape, "shape", key_of_shape, &kinds, |shape, form| match shape {
            RegionShape::Box { lower, upper } => corners(form, lower, upper),
            RegionShape::Ball { centre, radius } => {
                form.vector(centre, vector("centre", "the centre", LENGTH, "\"1 m\""));
                form.number(radius, number("radius", "the radius", LENGTH, POSITIVE, "\"10 cm\""));
            }
            RegionShape::Polygon { vertices } => {
                let about = "the corners of a polygon in the plane";
                form.polygon(vertices, key("vertices", about, Wants::Polygon, "[[0, 0], [\"2 m\", 0], [0, \"1 m\"]]"));
            }
            RegionShape::Group { name, .. } => {
                form.text(name, text("group", "a physical group of elements of mesh.file", "\"weak row\""));
            }
        });
        let mut fraction = Some(self.fraction).filter(|fraction| *fraction < 1.0);
        let about = "the solid volume fraction that its points start with";
        let own = number("fraction", about, RATIO, Range::open(0.0, 1.0), "0.83").follows("that of the material");
        form.number_if_given(&mut fraction, own);
        self.fraction = fraction.unwrap_or(f64::NAN);
        form.vector(
            &mut self.velocity,
            vector("velocity", "the velocity at the start", SPEED, "\"1 cm/s\"").follows("none"),
        );
        let about = "the angular velocity about its centre at the start";
        form.spin(&mut self.spin, key("spin", about, Wants::Spin, "\"3 rad/s\"").follows("none"));
        let about = "grains taken out of the packing of its RVEs, which is brought back to the stress of the start: a weak place";
        if form.has("grains_removed") || form.describes() || self.grains_removed > 0 {
            form.count(&mut self.grains_removed, count("grains_removed", about, (1, 65_536), "25").optional());
        }
        let example = "[{direction = [1, 0], length = \"2 m\", amplitude = [\"1 mm/s\", 0]}]";
        let wave = key("wave", "sines added to its velocity at the start", Wants::Text, example).optional();
        list(form, &mut self.waves, wave, "a sine of the velocity at the start", &Wave::BLANK, Wave::keys);
    }
}

impl Wave {
    const BLANK: Self = Self { direction: [0.0; 3], length: 0.0, origin: [f64::NAN; 3], amplitude: [0.0; 3] };

    fn keys(&mut self, form: &mut dyn Form) {
        form.vector(&mut self.direction, vector("direction", "the direction that it changes along", RATIO, "1.0"));
        form.number(&mut self.length, number("length", "the wave length", LENGTH, POSITIVE, "\"2 m\""));
        let origin = vector("origin", "a place where it vanishes", LENGTH, "\"0 m\"");
        form.vector(&mut self.origin, origin.follows("the lower corner of the grid"));
        form.vector(&mut self.amplitude, vector("amplitude", "the velocity at its crest", SPEED, "\"1 mm/s\""));
    }
}

const NAMES_OF_FACES: [&str; 6] = ["x_lower", "x_upper", "y_lower", "y_upper", "z_lower", "z_upper"];

/// One of the faces that a domain has.
fn choose_face(face: &mut Face, form: &mut dyn Form, key: Key) {
    // In the plane those of z are unknown; a page and a schema are for space too.
    let axes = if form.describes() { 3 } else { form.axes() };
    let faces: Vec<(&'static str, Face)> = NAMES_OF_FACES.into_iter().zip(Face::all(axes)).collect();
    choose(form, face, "face", key, &faces);
}

/// A physical group, in place of a face.
fn keys_of_group(group: &mut Option<String>, form: &mut dyn Form, about: &'static str) {
    if !form.has("group") && group.is_none() && !form.describes() {
        return;
    }
    if form.has("group") && form.has("face") {
        form.note("face", "stands beside a group, and each says what bears the load. Keep one of them.");
    }
    form.text(group.get_or_insert_default(), text("group", about, "\"slope\"").optional());
}

impl Boundary {
    pub(in crate::job) fn keys((face, boundary): &mut (Face, Self), form: &mut dyn Form) {
        choose_face(face, form, text("face", "which face: x_lower, x_upper and so on", "\"y_lower\""));
        let kinds = [
            ("fixed", Self::Fixed),
            ("roller", Self::Roller),
            ("friction", Self::Friction { coefficient: 0.0 }),
            ("absorbing", Self::Absorbing),
            ("free", Self::Free),
        ];
        let key = text("kind", "fixed, roller, friction, absorbing or free", "\"fixed\"");
        variant(form, boundary, "kind of boundary", key, &kinds, |kind, form| {
            let Self::Friction { coefficient } = kind else { return };
            let about = "the Coulomb coefficient";
            form.number(coefficient, number("coefficient", about, RATIO, Range::closed(0.0, 5.0), "0.5"));
        });
    }
}

impl Load {
    const BLANK: Self = Self {
        face: Face { axis: 0, upper: false },
        group: None,
        lower: [f64::NAN; 3],
        upper: [f64::NAN; 3],
        kind: LoadKind::Pressure(0.0),
        ramp: 0.0,
        on_surface: true,
    };

    pub(in crate::job) fn keys(&mut self, form: &mut dyn Form) {
        let about = "a physical group of sides of mesh.file that bears it, in place of face";
        keys_of_group(&mut self.group, form, about);
        if self.group.is_none() || form.describes() {
            let about = "which side of the material: x_lower, x_upper and so on";
            choose_face(&mut self.face, form, text("face", about, "\"y_upper\"").required("unless group is given"));
        }
        let window = |name, about| vector(name, about, LENGTH, "\"1 m\"").follows("that of the grid");
        form.vector(&mut self.lower, window("lower", "the lower corner of what is loaded"));
        form.vector(&mut self.upper, window("upper", "the upper corner of what is loaded"));
        let kinds = [("traction", LoadKind::Traction([0.0; 3])), ("pressure", LoadKind::Pressure(0.0))];
        let key = text("kind", "traction or pressure", "\"pressure\"");
        variant(form, &mut self.kind, "kind of load", key, &kinds, |kind, form| match kind {
            LoadKind::Traction(traction) => {
                form.vector(traction, vector("traction", "the force per area of the start", STRESS, "\"10 kPa\""));
            }
            LoadKind::Pressure(pressure) => {
                let about = "the pressure against the surface's normal";
                form.number(pressure, number("pressure", about, STRESS, POSITIVE, "\"10 kPa\""));
            }
        });
        let about = "the time over which it rises from zero";
        form.number(&mut self.ramp, number("ramp", about, TIME, NOT_NEGATIVE, "\"0.1 s\"").or("0.0"));
        let about = "where it acts: on the surface, wherever in a cell that is, or at the points behind it";
        let key = text("acts_at", about, "\"points\"").follows("surface; points of a traction and in a hybrid");
        choose(form, &mut self.on_surface, "place of a load", key, &[("points", false), ("surface", true)]);
    }
}

impl Membrane {
    const BLANK: Self = Self {
        name: String::new(),
        path: Path::Line { from: [0.0; 2], to: [0.0; 2] },
        spacing: f64::NAN,
        mass_per_area: 0.0,
        stiffness: 0.0,
        damping: 0.0,
        tension: 0.0,
        pressure: 0.0,
        ramp: 0.0,
    };

    pub(in crate::job) fn keys(&mut self, form: &mut dyn Form) {
        form.text(&mut self.name, text("name", "the membrane's name", "\"left\""));
        let kinds = [
            ("line", Path::Line { from: [0.0; 2], to: [0.0; 2] }),
            ("circle", Path::Circle { centre: [0.0; 2], radius: 0.0 }),
        ];
        variant(form, &mut self.path, "shape", text("shape", "line or circle", "\"line\""), &kinds, |path, form| {
            match path {
                Path::Line { from, to } => {
                    let about = "where a line begins; pressure pushes to the left when going from here to its end";
                    plane(form, from, vector("from", about, LENGTH, "\"0 m\""));
                    plane(form, to, vector("to", "where a line ends", LENGTH, "\"9 cm\""));
                }
                Path::Circle { centre, radius } => {
                    let about = "the centre of a circle; pressure pushes inwards";
                    plane(form, centre, vector("centre", about, LENGTH, "\"5 cm\""));
                    form.number(radius, number("radius", "the radius of a circle", LENGTH, POSITIVE, "\"4 cm\""));
                }
            }
        });
        let spacing = number("spacing", "the length of its segments", LENGTH, POSITIVE, "\"2 mm\"");
        form.number(&mut self.spacing, spacing.follows("half a cell"));
        // Latex of 0.3 mm.
        let mass = number("mass_per_area", "its mass per area", Dimension::MASS_PER_AREA, POSITIVE, "\"0.3 kg/m2\"");
        form.number(&mut self.mass_per_area, mass.or("0.3"));
        let about = "force on a segment per lengthening of it";
        form.number(&mut self.stiffness, number("stiffness", about, STIFFNESS, POSITIVE, "\"10 kN/m\""));
        let about = "force on a segment per speed of its lengthening";
        form.number(&mut self.damping, number("damping", about, DAMPING, NOT_NEGATIVE, "\"1 N s/m\"").or("0.0"));
        let about = "the force on a segment at the start";
        form.number(&mut self.tension, number("tension", about, FORCE, NOT_NEGATIVE, "\"2 N\"").or("0.0"));
        let about = "the pressure, to the left of its way";
        form.number(&mut self.pressure, number("pressure", about, STRESS, Range::ANY, "\"100 kPa\""));
        let about = "the time over which the pressure rises from zero";
        form.number(&mut self.ramp, number("ramp", about, TIME, NOT_NEGATIVE, "\"0.1 s\"").or("0.0"));
    }
}

impl RigidBody {
    const BLANK: Self = Self {
        body: Body::BLANK,
        contact: BodyContact::Rough,
        separates: true,
        at_face: true,
        side: None,
        group: None,
        seat: 0.0,
    };

    pub(in crate::job) fn keys(&mut self, form: &mut dyn Form) {
        self.body.keys(form, false);
        let kinds = [
            ("rough", BodyContact::Rough),
            ("smooth", BodyContact::Smooth),
            ("coulomb", BodyContact::Coulomb { friction: 0.0 }),
        ];
        let key = text("contact", "how the material touches it: rough, smooth or coulomb", "\"rough\"");
        variant(form, &mut self.contact, "contact", key, &kinds, |contact, form| {
            let BodyContact::Coulomb { friction } = contact else { return };
            let about = "the Coulomb coefficient";
            form.number(friction, number("friction", about, RATIO, Range::closed(0.0, 5.0), "0.5"));
        });
        form.flag(&mut self.separates, flag("separates", "whether material may part from it", "true").or("true"));
        let about =
            "where contact is enforced: at the nodes that lie in it, or at its face, wherever in a cell that is";
        let key = text("contact_at", about, "\"nodes\"")
            .follows("face for boxes and planes across an axis of the grid, else nodes");
        choose(form, &mut self.at_face, "place of contact", key, &[("nodes", false), ("face", true)]);
        self.keys_of_side(form);
        let mut seat = Some(self.seat).filter(|seat| *seat > 0.0);
        let about = "the force that presses it along its first way on grains until they rest, before the run";
        form.number_if_given(&mut seat, number("seat", about, FORCE, POSITIVE, "\"60 N\"").optional());
        self.seat = seat.unwrap_or_default();
        self.body.motion.keys(form);
    }
}

impl RigidBody {
    /// What of a mesh is fastened to it.
    fn keys_of_side(&mut self, form: &mut dyn Form) {
        if form.has("side") || self.side.is_some() || form.describes() {
            let about = "the side of the mesh that is fastened to it, as contact says: rough along all axes, smooth across the side alone";
            let face = self.side.get_or_insert(Face { axis: 0, upper: false });
            choose_face(face, form, text("side", about, "\"y_upper\"").optional());
        }
        if form.has("side") && form.has("group") {
            form.note("side", "stands beside a group, and each says what is fastened to the body. Keep one of them.");
        }
        let about = "a physical group of sides of mesh.file that is fastened to it, in place of side";
        keys_of_group(&mut self.group, form, about);
    }
}

impl Watch {
    pub(in crate::job) const BLANK: Self = Self { diameter: f64::NAN, oracle: Oracle::DEFAULT };

    pub(in crate::job) fn keys(&mut self, form: &mut dyn Form) {
        let diameter = number("diameter", "D50 of those grains", LENGTH, POSITIVE, "\"1 mm\"");
        // Where the job has grains, it is theirs.
        let known = !self.diameter.is_nan();
        form.number(
            &mut self.diameter,
            if known { diameter.follows("that of the grains") } else { diameter.required("in a job without grains") },
        );
        self.oracle.keys(form, Laplacian::OF_GRID);
    }
}

fn keys_of_band([from, to]: &mut [[f64; 2]; 2], form: &mut dyn Form) {
    plane(form, from, vector("from", "where it begins", LENGTH, "\"0 m\""));
    plane(form, to, vector("to", "where it ends", LENGTH, "\"9 cm\""));
}

impl Followed {
    const BLANK: Self = Self { name: String::new(), place: [0.0; 3], frames: false };

    pub(in crate::job) fn keys(&mut self, form: &mut dyn Form) {
        form.text(&mut self.name, text("name", "the point's name", "\"tip\""));
        let about = "the place that it is nearest to at the start";
        form.vector(&mut self.place, vector("place", about, LENGTH, "\"1 m\""));
        let about = "writes the grains of its RVE and their contacts with every frame";
        let key = flag("frames", about, "true");
        form.flag(&mut self.frames, key.follows("true where it has an RVE"));
    }
}

impl Granular {
    /// Time step of the grains of RVEs, s.
    pub fn step_of_rves(&self) -> f64 {
        self.rves.safety * governing(&bounds(&self.piece)).step
    }

    pub(in crate::job) fn blank() -> Self {
        Self {
            method: Method::Hybrid,
            piece: Assembly { contact: Contact::ASLEEP, ..Assembly::blank() },
            coupling: Coupling::DEFAULT,
            enrichment: Enrichment::around(0.0),
            reference: Origin::Specimen,
            rves: Rves::DEFAULT,
            known: None,
            is_heterogeneous: false,
        }
    }

    /// Keys of `[material]` that only a material with grains has.
    pub(in crate::job) fn keys_of_start(&mut self, form: &mut dyn Form) {
        let about =
            "whether the solid volume fraction varies from place to place as that of the specimen's grains does";
        heterogeneity(form, &mut self.is_heterogeneous, about);
    }

    pub(in crate::job) fn keys_of_enrichment(&mut self, form: &mut dyn Form) {
        self.enrichment.keys(form);
        let names = [("specimen", Origin::Specimen), ("piece", Origin::Piece)];
        let key = text("reference", "where grains come from: specimen or piece", "\"specimen\"").or("specimen");
        choose(form, &mut self.reference, "origin", key, &names);
        let mut at = self.known.as_ref().map(|known| known.at);
        let about = "when grains take the places of points around every [[band]]";
        form.number_if_given(&mut at, number("at", about, TIME, POSITIVE, "\"0.1 s\"").optional());
        if let Some(at) = at {
            self.known.get_or_insert_with(KnownBands::default).at = at;
        }
    }
}
