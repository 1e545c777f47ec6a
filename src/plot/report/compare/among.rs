//! Who is compared with whom: runs of the same packing, and runs that differ by their packing alone.

use crate::plot::report::chart::percent;
use crate::plot::report::colour;
use crate::plot::report::figures::label;
use crate::plot::report::findings::{Enrichment, Findings};
use crate::plot::report::load::{Run, figure, lookup};
use crate::plot::report::svg::Stroke;
use crate::plot::report::words::{THIN, plain};

/// What makes a specimen and its test, whatever it is simulated with; the random packing apart.
const SPECIMEN: [&str; 7] =
    ["specimen", "grains", "contact", "packing", "loading.stress_normal", "loading.speed", "loading.speed_ramp"];
/// What a group may differ in beside its packing.
const ANY: [&str; 6] = ["name", "seed", "output", "decomposition", "packing.cache", "loading.strain_end"];

/// A run with what it is compared by.
pub struct Member<'a> {
    /// Its place among the members.
    pub index: usize,
    pub run: &'a Run,
    pub findings: &'a Findings,
    /// The first frame with its grains, of a hybrid that was enriched.
    pub enriched: Option<usize>,
    pub label: String,
    pub seed: Option<i64>,
    /// Members of the same number are of the same specimen and test.
    pub case: usize,
    pub group: usize,
}

impl Member<'_> {
    pub fn is(&self, method: &str) -> bool {
        self.run.method == method
    }

    pub fn enrichment(&self) -> Option<&Enrichment> {
        self.findings.enrichment.as_ref()
    }

    /// Share of the continuum's motion that its grains were trained with.
    pub fn training(&self) -> f64 {
        figure(&self.run.scenario, "enrichment.training").unwrap_or(1.0)
    }

    /// Edge of a grid cell, m.
    pub fn cell(&self) -> Option<f64> {
        figure(&self.run.scenario, "continuum.cell").filter(|_| !self.is("dem"))
    }

    pub fn strain_end(&self) -> f64 {
        self.findings.strain_end
    }

    /// Row of the series from which averages start anew.
    pub fn cut(&self) -> Option<usize> {
        self.enrichment().map(|enrichment| enrichment.row)
    }
}

/// Runs that differ by their packing alone.
pub struct Group {
    pub name: String,
    pub colour: &'static str,
    dash: &'static str,
    /// Members, in the order in which the runs were given.
    pub members: Vec<usize>,
}

impl Group {
    /// Groups by their names, and the members of each by the group that each member is of.
    pub fn list(names: Vec<String>, of: &[usize]) -> Vec<Self> {
        let members = |group: usize| (0..of.len()).filter(|&member| of[member] == group).collect();
        let group = |(group, name): (usize, String)| Self {
            name,
            colour: colour::line(group),
            dash: Self::dash_of(group),
            members: members(group),
        };
        names.into_iter().enumerate().map(group).collect()
    }

    /// Colours that come again are dashed.
    fn dash_of(number: usize) -> &'static str {
        ["", "7 4", "2 3"][number / colour::LINES.len() % 3]
    }

    /// A line of this group.
    pub fn stroke(&self, width: f64) -> Stroke<'static> {
        Stroke::new(self.colour, width).dash(self.dash)
    }
}

/// All runs of a comparison.
pub struct Among<'a> {
    pub members: Vec<Member<'a>>,
    pub groups: Vec<Group>,
}

impl<'a> Among<'a> {
    /// Runs with what was found in them and their first frames with grains.
    pub fn of(runs: &[(&'a Run, &'a Findings, Option<usize>)]) -> Self {
        let (mut cases, mut kinds) = (Vec::new(), Vec::new());
        let members: Vec<Member> = runs
            .iter()
            .enumerate()
            .map(|(index, &(run, findings, enriched))| Member {
                index,
                run,
                findings,
                enriched,
                label: label(run),
                seed: run.scenario.get("seed").and_then(toml::Value::as_integer),
                case: number_of(case_of(run), &mut cases),
                group: number_of(kind_of(run), &mut kinds),
            })
            .collect();
        let groups =
            Group::list(names(&members, kinds.len()), &members.iter().map(|member| member.group).collect::<Vec<_>>());
        Self { members, groups }
    }

    /// The run of grains alone with the same specimen, test and packing.
    pub fn partner(&self, member: &Member) -> Option<&Member<'a>> {
        let same = |other: &&Member| other.is("dem") && other.case == member.case && other.seed == member.seed;
        self.members.iter().find(same)
    }

    /// The members of a case that one method made.
    pub fn of_method(&self, case: usize, method: &str) -> Vec<&Member<'a>> {
        self.members.iter().filter(|member| member.case == case && member.is(method)).collect()
    }

    pub fn cases(&self) -> usize {
        self.members.iter().map(|member| member.case + 1).max().unwrap_or(0)
    }

    /// Why these members cannot be compared with grains alone, a line each.
    pub fn without_partner(&self) -> Vec<String> {
        let alone = |member: &&Member| !member.is("dem") && self.partner(member).is_none();
        let line = |member: &Member| {
            let seed = member.seed.map_or_else(String::new, |seed| format!(" with seed {seed}"));
            format!("{} is compared with no run of grains alone: none of this specimen{seed} is given.", member.label)
        };
        self.members.iter().filter(alone).map(line).collect()
    }

    /// The strain from which a member is compared: that of its enrichment, or of the last hybrid of its case; zero where
    /// there is none.
    pub fn compared_from(&self, member: &Member) -> f64 {
        let own = member.enrichment().map(|enrichment| enrichment.strain);
        own.unwrap_or_else(|| {
            let hybrids = self.of_method(member.case, "hybrid");
            hybrids.iter().filter_map(|hybrid| hybrid.enrichment()).map(|found| found.strain).fold(0.0, f64::max)
        })
    }
}

/// The place of a scenario in a list, which it joins where it is new.
pub fn number_of(wanted: toml::Table, known: &mut Vec<toml::Table>) -> usize {
    known.iter().position(|other| *other == wanted).unwrap_or_else(|| {
        known.push(wanted);
        known.len() - 1
    })
}

fn case_of(run: &Run) -> toml::Table {
    let mut case = toml::Table::new();
    for path in SPECIMEN {
        if let Some(value) = lookup(&run.scenario, path) {
            case.insert(path.to_owned(), value.clone());
        }
    }
    if let Some(packing) = case.get_mut("packing").and_then(toml::Value::as_table_mut) {
        packing.remove("cache");
    }
    case
}

/// The scenario without the packing's seed, and without what its method does not use or results do not depend on.
fn kind_of(run: &Run) -> toml::Table {
    let unused: &[&str] = match run.method.as_str() {
        "dem" => &["continuum", "oracle", "enrichment", "time.grain_steps"],
        "mpm" => &["oracle", "enrichment"],
        _ => &[],
    };
    without(&run.scenario, ANY.iter().chain(unused))
}

/// A scenario without what stands at these dotted paths.
pub fn without<'p>(scenario: &toml::Table, paths: impl Iterator<Item = &'p &'p str>) -> toml::Table {
    let mut kind = scenario.clone();
    for path in paths {
        match path.split_once('.') {
            None => kind.remove(*path),
            Some((table, key)) => {
                kind.get_mut(table).and_then(toml::Value::as_table_mut).and_then(|table| table.remove(key))
            }
        };
    }
    kind
}

/// Says one thing of a run, where it has it.
type Tell<'t> = &'t dyn Fn(&Member) -> Option<String>;

fn names(members: &[Member], groups: usize) -> Vec<String> {
    let told: [Tell; 4] = [
        &|member| Some(if is_cohesive(member.run) { "cohesive" } else { "dry" }.to_owned()),
        &|member| member.is("hybrid").then(|| format!("training {}", percent(member.training()))),
        &|member| member.cell().map(|cell| format!("cell {}{THIN}mm", plain(1e3 * cell, 3))),
        &|member| figure(&member.run.scenario, "loading.speed").map(|v| format!("{}{THIN}cm/s", plain(100.0 * v, 3))),
    ];
    let first = |group: usize| members.iter().find(|member| member.group == group).expect("a group has a member");
    let kind = |member: &Member| Told {
        method: member.run.method.clone(),
        run: member.run.name.clone(),
        of: told.iter().map(|tell| tell(member)).collect(),
    };
    named(&(0..groups).map(|group| kind(first(group))).collect::<Vec<_>>())
}

/// What a group can be named by: that of its first run.
pub struct Told {
    pub method: String,
    pub run: String,
    /// The same things of every group, where it has them.
    pub of: Vec<Option<String>>,
}

/// Names of groups by what they differ in; those of the same name are told apart by their first runs.
pub fn named(groups: &[Told]) -> Vec<String> {
    let things = groups.first().map_or(0, |group| group.of.len());
    let differs = |thing: &usize| {
        let mut all: Vec<&String> = groups.iter().filter_map(|group| group.of[*thing].as_ref()).collect();
        all.sort();
        all.dedup();
        all.len() > 1
    };
    let told: Vec<usize> = (0..things).filter(differs).collect();
    let name = |group: &Told| {
        let method = if group.method.is_empty() { "run" } else { &group.method };
        match told.iter().filter_map(|&thing| group.of[thing].clone()).collect::<Vec<_>>().join(", ") {
            told if told.is_empty() => method.to_owned(),
            told => format!("{method} ({told})"),
        }
    };
    let names: Vec<String> = groups.iter().map(name).collect();
    let twice = |name: &String| names.iter().filter(|other| *other == name).count() > 1;
    let tell_apart = |(group, name): (&Told, &String)| match name {
        name if twice(name) => format!("{name}, {}", group.run),
        name => name.clone(),
    };
    groups.iter().zip(&names).map(tell_apart).collect()
}

fn is_cohesive(run: &Run) -> bool {
    ["contact.cohesion_normal", "contact.cohesion_tangential"]
        .iter()
        .any(|path| figure(&run.scenario, path).is_some_and(|cohesion| cohesion > 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::report::findings::tests::hybrid;

    fn run(method: &str, seed: i64, rest: &str) -> Run {
        let mut run = hybrid(50e3);
        let scenario = format!("name = \"n{seed}\"\nmethod = \"{method}\"\nseed = {seed}\n{rest}");
        run.scenario = toml::from_str(&scenario).unwrap();
        (run.method, run.name) = (method.to_owned(), format!("n{seed}"));
        run
    }

    fn found(runs: &[Run]) -> Vec<Findings> {
        runs.iter().map(Findings::of).collect()
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
        let findings = found(&runs);
        let triples: Vec<_> = runs.iter().zip(&findings).map(|(run, findings)| (run, findings, None)).collect();
        let among = Among::of(&triples);
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
        let partner = |index: usize| Some(among.partner(&among.members[index])?.index);
        assert_eq!([partner(2), partner(3), partner(4)], [Some(1), Some(5), None]);
        assert_eq!(among.without_partner().len(), 1);
        assert!(among.without_partner()[0].contains("seed 3"));
        // From the enrichment on; grains alone from that of the hybrids of their case.
        assert!((among.compared_from(&among.members[0]) - 0.04).abs() < 1.5e-4);
    }
}
