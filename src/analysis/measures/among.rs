//! Who is compared with whom: runs of one specimen and test, of one packing, and runs that differ by their packing alone.

use serde::Serialize;
use toml::{Table, Value};

use crate::analysis::curve::range;
use crate::analysis::drive::material;
use crate::analysis::run::{Run, as_number, lookup};

/// What makes a specimen and its test, whatever it is simulated with; the random packing apart. A grid is behind all of it, and
/// material and regions' fractions are the continuum's.
const SAME: [&str; 16] = [
    "specimen",
    "loading.stress_normal",
    "loading.speed",
    "loading.speed_ramp",
    "cell",
    "grid.space",
    "grid.depth",
    "grains",
    "contact",
    "packing",
    "stress",
    "gravity",
    "load",
    "boundary",
    "body",
    "membrane",
];
/// What of that results do not depend on, or follows from the grid.
const ANY_BELOW: [&str; 2] = ["cache", "spacing"];
/// What a group may differ in beside its packing.
const ANY: [&str; 7] = ["name", "seed", "output", "decomposition", "packing.cache", "loading.strain_end", "time.end"];
/// Share of the specimen by which regions may differ, as whole cells make them.
const SLACK: f64 = 0.01;

/// A run as it is named in tables and in `comparison.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Who {
    /// Its place among the runs.
    #[serde(skip)]
    pub index: usize,
    /// The place of its group among the groups.
    #[serde(skip)]
    pub number: usize,
    /// Its label: name, and method where the name does not say it.
    pub run: String,
    /// Name of its group.
    pub group: String,
    /// None where the job has none.
    pub seed: Option<i64>,
    /// Share of the continuum's motion that a hybrid's grains were trained with; none of other methods.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub training: Option<f64>,
}

/// A run with what it is compared by.
pub struct Member<'a> {
    /// As it was read from its folder.
    pub run: &'a Run,
    /// How it is named.
    pub who: Who,
    /// Members of the same number are of the same specimen and test.
    pub case: usize,
}

impl Member<'_> {
    /// Its place among the runs.
    pub fn index(&self) -> usize {
        self.who.index
    }

    /// Whether it is of this method, as a job calls it: "dem", "mpm", "hybrid".
    pub fn is(&self, method: &str) -> bool {
        self.run.is(method)
    }

    /// Of the last row of the series; zero where there is none.
    pub fn strain_end(&self) -> f64 {
        self.run.drive.values.last().copied().unwrap_or(0.0)
    }

    /// Row by row, Pa.
    pub fn stress(&self) -> &[f64] {
        self.run.drive.stress.as_ref().map_or(&[], |stress| &stress.values)
    }
}

/// Runs that differ by their packing alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// By method and what it differs in from other groups.
    pub name: String,
    /// Members, in the order in which the runs were given.
    pub members: Vec<usize>,
}

/// All runs that are measured together.
pub struct Among<'a> {
    /// In the order in which the runs were given.
    pub members: Vec<Member<'a>>,
    /// In the order of their first members.
    pub groups: Vec<Group>,
    /// What makes a case another than that of the first run, a line each.
    pub apart: Vec<String>,
}

impl<'a> Among<'a> {
    /// Sorts runs into cases, by specimen and test, and into groups, by all but the packing.
    pub fn of(runs: &'a [Run]) -> Self {
        let (mut cases, mut kinds): (Vec<&Run>, Vec<Table>) = (Vec::new(), Vec::new());
        let (mut apart, mut of) = (Vec::new(), Vec::new());
        for run in runs {
            let case = cases.iter().position(|other| difference_of(other, run).is_none()).unwrap_or_else(|| {
                if let Some(what) = cases.first().and_then(|first| difference_of(first, run)) {
                    let [own, first] = [run, cases[0]].map(|run| run.directory.display());
                    apart.push(format!("{own} is not held against {first}: {what}."));
                }
                cases.push(run);
                cases.len() - 1
            });
            let kind = kind_of(run);
            let number = kinds.iter().position(|other| *other == kind).unwrap_or_else(|| {
                kinds.push(kind);
                kinds.len() - 1
            });
            of.push((case, number));
        }
        let members = |group: usize| (0..runs.len()).filter(|&index| of[index].1 == group).collect::<Vec<_>>();
        let first: Vec<(&Run, &Table)> =
            kinds.iter().enumerate().map(|(group, kind)| (&runs[members(group)[0]], kind)).collect();
        let name = |(group, name)| Group { name, members: members(group) };
        let groups: Vec<Group> = names(&first).into_iter().enumerate().map(name).collect();
        let member = |(index, run): (usize, &'a Run)| {
            let (case, number) = of[index];
            let group = groups[number].name.clone();
            let who = Who { index, number, run: run.label(), group, seed: run.seed(), training: run.training() };
            Member { run, who, case }
        };
        Self { members: runs.iter().enumerate().map(member).collect(), apart, groups }
    }

    /// The run of grains alone with the same specimen, test and packing.
    pub fn partner(&self, member: &Member) -> Option<&Member<'a>> {
        self.alone(member).find(|other| other.who.seed == member.who.seed)
    }

    /// The same, or else the first of another packing.
    pub fn stand_in(&self, member: &Member) -> Option<&Member<'a>> {
        self.partner(member).or_else(|| self.alone(member).next())
    }

    fn alone(&self, member: &Member) -> impl Iterator<Item = &Member<'a>> {
        self.of_method(member.case, "dem")
    }

    /// The members of a case that one method made.
    pub fn of_method(&self, case: usize, method: &str) -> impl Iterator<Item = &Member<'a>> {
        self.members.iter().filter(move |member| member.case == case && member.is(method))
    }

    /// In the order in which they were given, of all cases.
    pub fn hybrids(&self) -> impl Iterator<Item = &Member<'a>> {
        self.members.iter().filter(|member| member.is("hybrid"))
    }

    /// Hybrids that begin as a continuum, in which grains are to take the places of points.
    pub fn to_be_enriched(&self) -> impl Iterator<Item = &Member<'a>> {
        self.hybrids().filter(|member| !member.run.begins_as_grains())
    }

    /// The strain from which a member is compared: that from which it has grains and points, or of the last hybrid of its case; zero where
    /// there is none.
    pub fn compared_from(&self, member: &Member) -> f64 {
        let hybrids = self.of_method(member.case, "hybrid").filter_map(|hybrid| hybrid.run.has_both_at());
        member.run.has_both_at().unwrap_or_else(|| hybrids.fold(0.0, f64::max))
    }

    /// The strain that all runs reach, and that of the longest.
    pub fn ends(&self) -> [f64; 2] {
        range(self.members.iter().map(Member::strain_end)).unwrap_or_default()
    }

    /// Where all or some of the runs were enriched, strains at the first frame with grains.
    pub fn enriched(&self) -> impl Iterator<Item = f64> {
        self.members.iter().filter_map(|member| Some(member.run.at_frame(member.run.enriched?)))
    }

    /// Why their curves cannot be drawn over each other and compared, if they cannot.
    pub fn unlike(&self) -> Option<String> {
        let first = &self.members.first()?.run;
        if let Some(run) = self.members.iter().map(|member| member.run).find(|run| run.drive.stress.is_none()) {
            return Some(format!("no body of {} moves along a path over a length that is known", run.label()));
        }
        if let Some(other) = self.members.iter().find(|member| member.run.drive.words != first.drive.words) {
            let [own, words] = [&other.run.drive.words, &first.drive.words];
            return Some(format!(
                "curves of {} stand against {own}, those of {} against {words}",
                other.who.run,
                first.label()
            ));
        }
        let back = self.members.iter().find(|member| member.run.drive.turns_back)?;
        let what = back.run.drive.body.as_ref().map_or("its strain".to_owned(), |body| format!("`{body}`"));
        Some(format!("{}: {what} turns back on its way", back.run.directory.display()))
    }
}

/// What makes a run one of another specimen or test; nothing where it is of the same.
fn difference_of(first: &Run, other: &Run) -> Option<String> {
    let told = |path: &str| difference(path, lookup(&first.scenario, path), lookup(&other.scenario, path));
    SAME.into_iter().find_map(told).or_else(|| {
        let [ends, others] = [material(first)?, material(other)?];
        let slack = SLACK * ends.iter().map(|[lower, upper]| upper - lower).fold(0.0, f64::max);
        let off = |(a, b): (&f64, &f64)| (a - b).abs() > slack;
        let differ = ends.as_flattened().iter().zip(others.as_flattened()).any(off);
        let tell = |ends: &[[f64; 2]]| {
            ends.iter().map(|[lower, upper]| format!("{lower} to {upper}")).collect::<Vec<_>>().join(" and ")
        };
        let what =
            || format!("its material reaches from {} m, that of the other from {} m", tell(&others), tell(&ends));
        differ.then(what)
    })
}

/// The first place below a path at which two values differ, and how.
fn difference(path: &str, first: Option<&Value>, other: Option<&Value>) -> Option<String> {
    match (first, other) {
        (Some(Value::Table(first)), Some(Value::Table(other))) => {
            let keys = first.keys().chain(other.keys().filter(|key| !first.contains_key(*key)));
            let mut keys = keys.filter(|key| !ANY_BELOW.contains(&key.as_str()));
            keys.find_map(|key| difference(&format!("{path}.{key}"), first.get(key), other.get(key)))
        }
        (Some(Value::Array(first)), Some(Value::Array(other))) if has_tables(first) && first.len() == other.len() => {
            let name = |index: usize| {
                let name = first[index].get("name").and_then(Value::as_str);
                name.map_or_else(|| format!("{path}[{index}]"), |name| format!("{path}.{name}"))
            };
            let mut pairs = first.iter().zip(other).enumerate();
            pairs.find_map(|(index, (first, other))| difference(&name(index), Some(first), Some(other)))
        }
        (first, other) if first == other => None,
        (first, other) => {
            let tell = |value: Option<&Value>| match value {
                Some(Value::Array(list)) if has_tables(list) => format!("{} of them", list.len()),
                Some(Value::Table(_)) => "there".to_owned(),
                Some(value) => value.to_string(),
                None => "not there".to_owned(),
            };
            Some(format!("`{path}` is {} in it and {} in the other", tell(other), tell(first)))
        }
    }
}

fn has_tables(list: &[Value]) -> bool {
    list.first().is_some_and(Value::is_table)
}

/// The scenario without the packing's seed, and without what its method does not use or results do not depend on; of grains
/// alone regions are only where they lie, which is the same for all runs of a case.
fn kind_of(run: &Run) -> Table {
    let unused: &[&str] = match run.method.as_str() {
        "dem" => {
            &["continuum", "material", "region", "scheme.points_per_cell", "oracle", "enrichment", "time.grain_steps"]
        }
        "mpm" => &["oracle", "enrichment"],
        _ => &[],
    };
    let mut kind = run.scenario.clone();
    for path in ANY.iter().chain(unused) {
        match path.split_once('.') {
            None => kind.remove(*path),
            Some((table, key)) => kind.get_mut(table).and_then(Value::as_table_mut).and_then(|table| table.remove(key)),
        };
    }
    kind
}

/// Things that a group may be named by.
fn told_of(run: &Run) -> [Option<String>; 5] {
    let hybrid = |path: &str| run.number(path).filter(|_| run.is("hybrid"));
    let millimetres =
        |what: &str, length: Option<f64>| length.map(|length| format!("{what} {}\u{2009}mm", short(1e3 * length)));
    let coheres = ["contact.cohesion_normal", "contact.cohesion_tangential"];
    let is_cohesive = coheres.iter().any(|path| run.number(path).is_some_and(|cohesion| cohesion > 0.0));
    [
        Some(if is_cohesive { "cohesive" } else { "dry" }.to_owned()),
        run.training().map(|share| format!("training {}\u{2009}%", short(100.0 * share))),
        millimetres("distance", hybrid("enrichment.distance")),
        millimetres("cell", run.cell_edge()),
        run.number("loading.speed").map(|speed| format!("{}\u{2009}cm/s", short(100.0 * speed))),
    ]
}

/// To three digits.
fn short(value: f64) -> String {
    let digits = format!("{value:.2e}").parse::<f64>().unwrap_or(value);
    digits.to_string()
}

/// Keys that are named where groups differ by them; more would not be read.
const KEYS_NAMED: usize = 3;

/// Names of groups, each with its first run and its kind, by what they differ in. Those of the same name are told apart by the keys of
/// their jobs that differ, or by their first runs.
fn names(groups: &[(&Run, &Table)]) -> Vec<String> {
    let told: Vec<_> = groups.iter().map(|(run, _)| told_of(run)).collect();
    let differs = |thing: &usize| {
        let mut all: Vec<&String> = told.iter().filter_map(|told| told[*thing].as_ref()).collect();
        all.sort();
        all.dedup();
        all.len() > 1
    };
    let things: Vec<usize> = (0..told.first().map_or(0, |told| told.len())).filter(differs).collect();
    let name = |((run, _), told): (&(&Run, &Table), &[Option<String>; 5])| {
        let job = run.scenario.get("name").and_then(Value::as_str).unwrap_or(&run.name);
        let method = if run.method.is_empty() { job } else { &run.method };
        match things.iter().filter_map(|&thing| told[thing].clone()).collect::<Vec<_>>().join(", ") {
            told if told.is_empty() => method.to_owned(),
            told => format!("{method} ({told})"),
        }
    };
    let names: Vec<String> = groups.iter().zip(&told).map(name).collect();
    let tell_apart = |(index, name): (usize, &String)| {
        let alike: Vec<&Table> =
            groups.iter().zip(&names).filter(|(_, other)| *other == name).map(|((_, kind), _)| *kind).collect();
        let keys = keys_apart(&alike);
        let run = groups[index].0;
        match alike.len() {
            1 => name.clone(),
            _ if !keys.is_empty() && keys.len() <= KEYS_NAMED => {
                let words = |path: &String| {
                    format!("{} {}", path.rsplit('.').next().unwrap_or(path), shown(groups[index].1, path))
                };
                format!("{name}, {}", keys.iter().map(words).collect::<Vec<_>>().join(", "))
            }
            _ if run.name != *name => format!("{name}, {}", run.name),
            _ => name.clone(),
        }
    };
    names.iter().enumerate().map(tell_apart).collect()
}

/// Dotted paths of the values that are not the same in all of these tables.
fn keys_apart(tables: &[&Table]) -> Vec<String> {
    fn leaves(table: &Table, before: &str, found: &mut Vec<String>) {
        for (key, value) in table {
            let path = if before.is_empty() { key.clone() } else { format!("{before}.{key}") };
            match value {
                Value::Table(inner) => leaves(inner, &path, found),
                _ if !found.contains(&path) => found.push(path),
                _ => {}
            }
        }
    }
    let mut paths = Vec::new();
    tables.iter().for_each(|table| leaves(table, "", &mut paths));
    paths.retain(|path| tables.iter().any(|table| lookup(table, path) != lookup(tables[0], path)));
    paths
}

/// A value for a name; numbers to three digits.
fn shown(table: &Table, path: &str) -> String {
    let value = lookup(table, path);
    value
        .and_then(as_number)
        .map(short)
        .or_else(|| value.map(Value::to_string))
        .unwrap_or_else(|| "not given".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(method: &str, seed: i64, rest: &str) -> Run {
        Run::made(&format!("name = \"n{seed}\"\nmethod = \"{method}\"\nseed = {seed}\n{rest}"))
    }

    #[test]
    fn packings_make_groups_and_specimens_make_cases() {
        const SOFT: &str = "[continuum]\ncell = 0.003\n[packing]\ncache = \"a\"\n[time]\ngrain_steps = 1\n";
        const HARD: &str = "[continuum]\ncell = 0.002\n[packing]\ncache = \"b\"\n[time]\ngrain_steps = 8\n";
        const STICKY: &str =
            "[continuum]\ncell = 0.003\n[packing]\n[contact]\ncohesion_normal = 0.1\n[time]\ngrain_steps = 1\n";
        let runs = [
            run("dem", 1, SOFT),
            run("dem", 2, HARD),
            run("hybrid", 2, SOFT),
            run("hybrid", 2, STICKY),
            run("hybrid", 3, HARD),
            run("dem", 2, STICKY),
        ];
        let among = Among::of(&runs);
        let names: Vec<&str> = among.groups.iter().map(|group| &*group.name).collect();
        assert_eq!(
            names,
            [
                "dem (dry)",
                "hybrid (dry, cell 3\u{2009}mm)",
                "hybrid (cohesive, cell 3\u{2009}mm)",
                "hybrid (dry, cell 2\u{2009}mm)",
                "dem (cohesive)"
            ]
        );
        assert_eq!(among.groups[0].members, [0, 1]);
        let partner = |index: usize| Some(among.partner(&among.members[index])?.index());
        assert_eq!([partner(2), partner(3), partner(4)], [Some(1), Some(5), None]);
        assert_eq!(among.stand_in(&among.members[4]).unwrap().index(), 0);
        assert!(among.apart.len() == 1 && among.apart[0].contains("`contact`"), "{:?}", among.apart);
    }

    /// A sweep has groups that differ by a key which nobody foresaw; its seeds are one group.
    #[test]
    fn groups_are_told_apart_by_the_keys_that_differ() {
        let of = |seed: i64, friction: f64, stress: f64| {
            let cell = "[cell]\nspace = \"plane\"";
            Run::made(&format!(
                "name = \"few\"\nseed = {seed}\n{cell}\n[contact]\nfriction = {friction}\n[packing]\nstress = {stress}"
            ))
        };
        let name = |run: Run, name: &str| Run { name: name.to_owned(), ..run };
        let runs = [
            name(of(1, 0.3, 1e5), "a"),
            name(of(2, 0.3, 1e5), "b"),
            name(of(1, 0.5, 1e5), "c"),
            name(of(1, 0.5, 2e5), "d"),
        ];
        let among = Among::of(&runs);
        let names: Vec<&str> = among.groups.iter().map(|group| &*group.name).collect();
        assert_eq!(
            names,
            [
                "few, friction 0.3, stress 100000",
                "few, friction 0.5, stress 100000",
                "few, friction 0.5, stress 200000"
            ]
        );
        assert_eq!(among.groups[0].members, [0, 1]);
        assert_eq!(Among::of(&runs[..2]).groups[0].name, "few");
    }

    const JOB: &str = "[grid]\ndepth = 0.01\ncell = 0.003\n[grains]\ndensity = 2530.0\n[packing]\ncache = \"a\"\n[[region]]\n\
                       lower = [0.0, 0.0]\nupper = [0.06, 0.09]\n[[body]]\nname = \"base\"\npoint = [0.0, 0.0]\n[[body]]\n\
                       name = \"plate\"\npoint = [0.0, 0.09]\n[[membrane]]\nname = \"left\"\npressure = 1e5\nspacing = 0.0015\n";

    fn told(from: &str, to: &str) -> Option<String> {
        assert!(JOB.contains(from));
        difference_of(&Run::made(JOB), &Run::made(&JOB.replace(from, to)))
    }

    #[test]
    fn what_makes_another_test_is_named() {
        for (from, to) in
            [("0.003", "0.002"), ("\"a\"", "\"b\""), ("0.0015", "0.001"), ("[0.06, 0.09]", "[0.0605, 0.09]")]
        {
            assert_eq!(told(from, to), None, "{to}");
        }
        for (from, to, wanted) in [
            ("2530.0", "2600.0", "`grains.density` is 2600.0 in it and 2530.0 in the other"),
            ("point = [0.0, 0.09]", "point = [0.0, 0.1]", "`body.plate.point` is [0.0, 0.1] in it"),
            ("pressure = 1e5", "pressure = 2e5", "`membrane.left.pressure` is 200000.0"),
            ("density = 2530.0", "", "`grains.density` is not there in it"),
            ("[[body]]\nname = \"base\"\npoint = [0.0, 0.0]\n", "", "`body` is 1 of them in it and 2 of them"),
            (
                "upper = [0.06, 0.09]",
                "upper = [0.08, 0.09]",
                "reaches from 0 to 0.08 and 0 to 0.09 m, that of the other",
            ),
        ] {
            let told = told(from, to).unwrap_or_default();
            assert!(told.contains(wanted), "{told}");
        }
    }
}
