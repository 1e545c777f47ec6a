//! What grains in the place of points do: the trained packing, the disturbance, stress over the strain inside the zone, speed.

use super::stress::drawn;
use super::{Part, Sheet, by_group, entry_of};
use crate::analysis::curve::{Averaged, Difference};
use crate::analysis::measures::Measures;
use crate::analysis::measures::disturbance::{Disturbed, STRAIN_DISTURBED, STRAIN_SETTLED};
use crate::analysis::measures::inside::Inside;
use crate::analysis::measures::speed::{Formula, Speed};
use crate::analysis::measures::trained::Trained;
use crate::analysis::snapshot::{Body, Snapshot};
use crate::analysis::strained::Valued;
use crate::analysis::zone::Zone;
use crate::base::error::Error;
use crate::plot::report::Drawn;
use crate::plot::report::chart::{self, Axis, Chart, Curve, Entry};
use crate::plot::report::numbers::{THIN, change, interval, kilopascal, percent, plain, relative, significant};
use crate::plot::report::pictures::{Colours, Picture, draw, strain_end};

/// The two parts of the grains alone, in words.
const OTHERS: [&str; 2] = ["same material", "where they shear most"];

fn with_training(run: &str, training: Option<f64>) -> String {
    format!("{run}, training {}", percent(training.unwrap_or(1.0)))
}

pub fn trained(measures: &Measures, all: &[Trained]) -> Result<Part, Error> {
    let groups = &measures.among.groups;
    let of = |pick: fn(&Trained) -> f64| all.iter().map(|trained| (&trained.who, pick(trained))).collect::<Vec<_>>();
    let sentence = format!(
        "Mean shear stress of the inserted grains: {}. It is off that of the same region of the grains alone at the same strain \
         by: {}.",
        by_group(groups, &of(|trained| trained.shear_stress_grains_pa), kilopascal),
        by_group(groups, &of(|trained| trained.off), change)
    );
    let frames = |trained: &Trained| match trained.interpolated_between_strains {
        None => "at that strain".to_owned(),
        Some([from, to]) => format!("between {} and {}", percent(from), percent(to)),
    };
    let sheet = Sheet::of(
        "Mean shear stress in the region of the inserted grains",
        all,
        |trained| with_training(&trained.who.run, trained.who.training),
        &[
            ("strain", &|trained| Some(percent(trained.strain))),
            ("grains, first frame", &|trained| Some(kilopascal(trained.shear_stress_grains_pa))),
            ("at the end of training", &|trained| trained.shear_stress_end_of_training_pa.map(kilopascal)),
            ("points before", &|trained| trained.shear_stress_points_pa.map(kilopascal)),
            ("grains alone", &|trained| Some(kilopascal(trained.shear_stress_region_pa))),
            ("off", &|trained| Some(change(trained.off))),
            ("frames of it", &|trained| Some(frames(trained))),
        ],
    );
    Ok(Part {
        sentences: vec![sentence],
        figures: vec![pictures(measures, all)?],
        sheets: vec![sheet],
        ..Part::default()
    })
}

/// The best trained packing that there is, an untrained one of the same specimen and packing, and the grains alone.
fn pictures(measures: &Measures, all: &[Trained]) -> Result<Drawn, Error> {
    let members = &measures.among.members;
    let most = |a: usize, b: usize| if all[b].who.training > all[a].who.training { b } else { a };
    let best = &all[(0..all.len()).reduce(most).unwrap_or(0)];
    let case = |trained: &Trained| (members[trained.who.index].case, trained.who.seed);
    let is_other = |other: &&Trained| case(other) == case(best) && other.who.index != best.who.index;
    let untrained = all.iter().filter(is_other).find(|other| other.who.training == Some(0.0));
    let coloured = |snapshot: &Snapshot, zone: Option<&Zone>| {
        let value = |body: &Body| match zone.is_none_or(|zone| zone.holds(body)) && body.is_inner() {
            true => body.shear_stress,
            false => f64::NAN,
        };
        snapshot.bodies.iter().map(|&body| Valued { body, value: value(&body) }).collect::<Vec<_>>()
    };
    let mut pictures = Vec::new();
    for trained in untrained.into_iter().chain([best]) {
        let run = members[trained.who.index].run;
        let snapshot = run.snapshot(run.enriched.unwrap_or(0))?;
        let title = format!("training {}", percent(trained.who.training.unwrap_or(1.0)));
        let titles = [title, format!("mean {}", kilopascal(trained.shear_stress_grains_pa))];
        pictures.push(Picture::of(run, &snapshot, coloured(&snapshot, None), titles));
    }
    let alone = members[best.partner].run;
    let frame = alone.frame_at(best.strain);
    let snapshot = alone.snapshot(frame)?;
    let mean = kilopascal(best.shear_stress_region_pa);
    let titles = ["grains alone".to_owned(), format!("mean {mean} (drawn at {})", percent(alone.at_frame(frame)))];
    pictures.push(Picture::of(alone, &snapshot, coloured(&snapshot, Some(&best.zone)), titles));
    let words = "shear stress of a grain, zero and below dark (kPa)";
    let colours = Colours { ends: [0.0, strain_end(&pictures)], unit: 1e3, words };
    Ok(Drawn {
        name: "training".to_owned(),
        drawing: draw("training", &pictures, None, &colours, "Shear stress of inserted grains and of grains alone"),
        caption: format!(
            "Shear stress of the grains inserted into {} at {} of strain, and of the same region of {}: its grains that began \
             where those of the hybrid did (Chen et al. 2021, figure 13). Grey: the rim, points, and what is not compared.",
            best.who.run,
            percent(best.strain),
            best.against
        ),
    })
}

pub fn recovery(found: &Disturbed) -> Option<String> {
    found.by.settled_pa?;
    Some(match found.by.strain_until_recovered {
        Some(0.0) => "never below".to_owned(),
        Some(strain) => percent(strain),
        None => "not reached".to_owned(),
    })
}

pub fn disturbance(measures: &Measures, all: &[Disturbed]) -> Part {
    let groups = &measures.among.groups;
    let against =
        |value: f64, found: &Disturbed| format!("{} ({})", kilopascal(value), relative(value, found.by.before_pa));
    let (lowest, highest) = (within("lowest average"), within("highest row"));
    let settled = format!("level from {} after", interval([STRAIN_DISTURBED, STRAIN_SETTLED]));
    let sheet = Sheet::of(
        &format!("Disturbance by the enrichment: {lowest}, {highest}, {settled}"),
        all,
        |found| with_training(&found.who.run, found.who.training),
        &[
            ("at strain", &|found| {
                Some(format!("{} (t = {}{THIN}s)", percent(found.by.strain), plain(found.by.time_s, 3)))
            }),
            ("before", &|found| Some(kilopascal(found.by.before_pa))),
            ("lowest average", &|found| Some(against(found.by.lowest_average_pa, found))),
            ("drop", &|found| Some(change(found.by.drop))),
            ("highest row", &|found| Some(against(found.by.highest_row_pa, found))),
            ("farthest row", &|found| found.by.excursion.map(change)),
            ("level after", &|found| found.by.settled_pa.map(|level| against(level, found))),
            ("strain until 90\u{2009}% of that", &recovery),
        ],
    );
    let drops: Vec<_> = all.iter().map(|found| (&found.who, found.by.drop)).collect();
    let recovered: Vec<_> =
        all.iter().filter_map(|found| Some((&found.who, found.by.strain_until_recovered?))).collect();
    let mut words = format!(
        "Within {} of strain after enrichment the moving average of stress changes by: {}.",
        percent(STRAIN_DISTURBED),
        by_group(groups, &drops, change)
    );
    if !recovered.is_empty() {
        words += &format!(" It recovers after a strain of: {}.", by_group(groups, &recovered, percent));
    }
    for found in all.iter().filter(|found| found.by.settled_pa.is_some() && found.by.strain_until_recovered.is_none()) {
        words += &format!(" That of {} does not recover.", found.who.run);
    }
    Part { sentences: vec![words], sheets: vec![sheet], ..Part::default() }
}

fn within(what: &str) -> String {
    format!("{what} within {}", percent(STRAIN_DISTURBED))
}

pub fn inside(measures: &Measures, all: &[Inside]) -> Part {
    let of = |inside: &Inside, which: usize| [inside.difference, inside.difference_sheared_most][which];
    let mut told = Vec::new();
    for (which, what) in OTHERS.into_iter().enumerate() {
        let pick = |pick: fn(&Difference) -> f64| -> Vec<_> {
            all.iter().filter_map(|inside| Some((&inside.who, pick(&of(inside, which)?)))).collect()
        };
        let (means, squares) = (pick(|of| of.mean_difference), pick(|of| of.rms_difference));
        if !means.is_empty() {
            told.push(format!(
                "Over the strain inside the zone the stress is off that of the grains alone, {what}, in the mean by: {}. \
                 Root-mean-square by: {}.",
                by_group(&measures.among.groups, &means, change),
                by_group(&measures.among.groups, &squares, percent)
            ));
        }
    }
    let rows: Vec<(&Inside, usize)> = all.iter().flat_map(|inside| [(inside, 0), (inside, 1)]).collect();
    let heights = |(inside, which): &(&Inside, usize)| {
        let heights = [inside.heights_m, inside.heights_sheared_most_m][*which];
        format!("{}{THIN}mm", heights.map(|height| format!("{:.1}", 1e3 * height)).join(" to "))
    };
    let sheet = Sheet::of(
        "Shear stress over the shear strain inside the zone",
        &rows,
        |(inside, which)| format!("{} \u{2013} {}, {}", inside.who.run, inside.against, OTHERS[*which]),
        &[
            ("grains alone at a height of", &|row| Some(heights(row))),
            ("strain inside", &|row| of(row.0, row.1).map(|of| interval([of.from_strain, of.to_strain]))),
            ("mean difference", &|row| of(row.0, row.1).map(|of| change(of.mean_difference))),
            ("root-mean-square", &|row| of(row.0, row.1).map(|of| percent(of.rms_difference))),
        ],
    );
    Part { sentences: told, figures: vec![curves_inside(measures, all)], sheets: vec![sheet], ..Part::default() }
}

/// Of every case the first of the best trained hybrids, and the grains alone of its packing.
fn curves_inside(measures: &Measures, all: &[Inside]) -> Drawn {
    let members = &measures.among.members;
    let case = |inside: &Inside| members[inside.who.index].case;
    let best = |of: usize| {
        let of_case = all.iter().filter(|inside| case(inside) == of);
        of_case.reduce(|best, other| if other.who.training > best.who.training { other } else { best })
    };
    let (mut curves, mut entries) = (Vec::new(), Vec::new());
    for inside in (0..members.len()).filter_map(best) {
        let mut add = |index: usize, curve: &Averaged, words: String, dash: &'static str| {
            let stroke = entry_of(measures, index, 1.8).stroke.dash(dash);
            curves.push(Curve { places: drawn(curve), stroke });
            entries.push(Entry { words, stroke });
        };
        let [own, same, most] = &inside.curves;
        let alone = |what: &str| format!("{}, {what}", inside.against);
        add(inside.who.index, own, inside.who.run.clone(), "");
        add(inside.partner, same, alone(OTHERS[0]), "");
        add(inside.partner, most, alone(OTHERS[1]), "6 4");
    }
    let places: Vec<[f64; 2]> = curves.iter().flat_map(|curve: &Curve| curve.places.clone()).collect();
    let places = || places.iter().filter(|place| place[0].is_finite());
    let chart = Chart {
        x: Axis::exact("shear strain inside the zone (%)", 0.0, places().map(|place| place[0]).fold(0.0, f64::max)),
        y: Axis::around("shear stress (kPa)", places().map(|place| place[1]).chain([0.0])),
        curves,
        ..Chart::default()
    };
    Drawn {
        name: "inside".to_owned(),
        drawing: chart::draw("inside", "Shear stress against the shear strain inside the zone", &entries, &[chart], 1),
        caption: "Shear stress against the shear strain inside the zone that the grains took over, of the hybrid and of the \
                  grains alone (Chen et al. 2021, figure 15 right), of these the same material, and the part of the zone\u{2019}s \
                  height that shears most: displacement between the edges over the height, from the frames, linear between \
                  them."
            .to_owned(),
    }
}

pub fn speed(measures: &Measures, all: &[Speed]) -> Part {
    let times = |factor: f64| significant(factor, 3);
    let of = |pick: &dyn Fn(&Speed) -> Option<f64>| {
        let values: Vec<_> = all.iter().filter_map(|speed| Some((&speed.who, pick(speed)?))).collect();
        by_group(&measures.among.groups, &values, times)
    };
    let formula = |tell: fn(&Formula) -> String| move |speed: &Speed| speed.formula.as_ref().map(tell);
    let told: Vec<String> = [
        ("Over the whole run", of(&|speed| speed.whole_run)),
        ("In steps with grains and points", of(&|speed| speed.after_enrichment)),
        ("By the formula of 6.4.1", of(&|speed| speed.formula.as_ref().map(|formula| formula.speed_up))),
    ]
    .into_iter()
    .filter(|(_, told)| !told.is_empty())
    .map(|(name, told)| format!("{name}: {told}."))
    .collect();
    let sheet = Sheet::of(
        "Speed-up over grains alone",
        all,
        |speed| format!("{} \u{2013} {}", speed.who.run, speed.against),
        &[
            ("ranks \u{d7} threads", &|speed| {
                let [own, other] = &speed.ranks_x_threads;
                Some(if own == other { own.clone() } else { format!("{own} against {other}") })
            }),
            ("whole run", &|speed| speed.whole_run.map(times)),
            ("steps with both", &|speed| speed.after_enrichment.map(times)),
            ("coupling, share of steps", &|speed| Some(percent(speed.coupling_share))),
            ("by 6.4.1", &formula(|formula| significant(formula.speed_up, 3))),
            ("C_D", &formula(|formula| format!("{}{THIN}ns", plain(1e9 * formula.c_d_s, 3)))),
            ("C_C", &formula(|formula| format!("{}{THIN}ns ({})", plain(1e9 * formula.c_c_s, 3), formula.c_c_from))),
            ("N_D", &formula(|formula| plain(formula.n_d, 3))),
            ("T_D/T", &formula(|formula| plain(formula.zone_share, 3))),
        ],
    );
    let sentence = (!told.is_empty()).then(|| format!("Times as fast as the grains alone. {}", told.join(" ")));
    Part { sentences: sentence.into_iter().collect(), sheets: vec![sheet], ..Part::default() }
}
