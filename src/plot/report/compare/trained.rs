//! Shear stress of the trained packing against the same region of grains alone at the same strain (Chen et al. 2021, figure
//! 13).

use serde_json::{Value, json};

use super::among::{Among, Member};
use super::pictures::{Colours, Picture, draw};
use super::zone::{Zone, is_inner};
use super::{Drawn, Part, Sheet, by_group, share};
use crate::base::error::Error;
use crate::plot::report::chart::percent;
use crate::plot::report::load::{Body, Snapshot, between};
use crate::plot::report::panels::{nearly_largest, round_up};
use crate::plot::report::scenes::Valued;
use crate::plot::report::words::kilopascal;

/// A frame this near to the wanted strain is taken as it is.
const STRAIN_SAME: f64 = 1e-5;
/// With fewer grains in common two runs are not of the same packing.
const SHARED_LEAST: f64 = 0.99;

/// A hybrid's packing and the same region of the grains alone.
struct Compared<'a> {
    hybrid: &'a Member<'a>,
    partner: &'a Member<'a>,
    zone: Zone,
    /// Horizontal strain of the enrichment.
    strain: f64,
    /// Mean shear stress of the hybrid's inner grains in the first frame, Pa.
    grains: f64,
    /// The same at the end of training and of the points before, from the summary, Pa.
    trained: Option<f64>,
    points: Option<f64>,
    /// Of the region in the grains alone at the same strain, Pa.
    region: f64,
    /// Share of the hybrid's grains that are the grains alone, too: all in the same packing.
    shared: f64,
    /// Strains of the two frames that this lies between, where none is at that strain.
    interpolated: Option<[f64; 2]>,
}

impl Compared<'_> {
    fn off(&self) -> f64 {
        self.grains / self.region - 1.0
    }

    fn name(&self) -> String {
        format!("{}, training {}", self.hybrid.label, percent(self.hybrid.training()))
    }
}

/// Mean of the shear stress over the area of bodies, Pa.
fn mean_stress<'b>(bodies: impl Iterator<Item = &'b Body>) -> Option<f64> {
    let (sum, area) =
        bodies.fold((0.0, 0.0), |(sum, area), body| (sum + body.area() * body.shear_stress, area + body.area()));
    (area > 0.0).then(|| sum / area)
}

fn region_stress(snapshot: &Snapshot, zone: &Zone) -> Option<f64> {
    mean_stress(snapshot.bodies.iter().filter(|body| is_inner(body) && zone.holds(body)))
}

/// Compares one hybrid, or tells why not.
fn compare<'a>(among: &'a Among, hybrid: &'a Member<'a>) -> Result<Result<Compared<'a>, String>, Error> {
    let fail = |why: &str| Ok(Err(format!("Stress of the trained packing of {}: {why}.", hybrid.label)));
    let (Some(enrichment), Some(frame)) = (hybrid.enrichment(), hybrid.enriched) else {
        return fail("it was not enriched, or has no frame before or after");
    };
    let Some(partner) = among.partner(hybrid) else {
        return fail("there is no run of grains alone with its packing");
    };
    let Some(zone) = Zone::of(hybrid)? else { return fail("the first frame has no grains outside of the rim") };
    let grains = mean_stress(hybrid.run.snapshot(frame)?.bodies.iter().filter(|body| is_inner(body)));
    let strain = enrichment.strain;
    let strains: Vec<f64> = (0..partner.run.frame_times.len()).map(|frame| partner.run.strain_of(frame)).collect();
    let there = strains.iter().copied().find(|other| (other - strain).abs() <= STRAIN_SAME).unwrap_or(strain);
    let Some((after, share)) = between(&strains, there) else {
        return fail("the run of grains alone has no frame as late");
    };
    if let Some(before) = after.checked_sub(1).filter(|_| share < 1.0 && strains[after] - strains[after - 1] > strain) {
        // Between them the stress rises and turns; a straight line through it says nothing.
        let [from, to] = [strains[before], strains[after]].map(percent);
        return fail(&format!(
            "the run of grains alone has frames at strains of {from} and {to} only, too far from {}; a short run of it \
             with a smaller output.frame_interval will do",
            percent(strain)
        ));
    }
    let later = region_stress(&partner.run.snapshot(after)?, &zone);
    let (region, interpolated) = match after.checked_sub(1).filter(|_| share < 1.0) {
        None => (later, None),
        Some(before) => {
            let earlier = region_stress(&partner.run.snapshot(before)?, &zone);
            (earlier.zip(later).map(|(a, b)| a + share * (b - a)), Some([strains[before], strains[after]]))
        }
    };
    let (Some(grains), Some(region)) = (grains, region.filter(|stress| *stress != 0.0)) else {
        return fail("there are no stresses of grains to compare");
    };
    let summary = |key: &str| hybrid.run.summary_figure(key);
    let (trained, points) = (summary("training_shear_stress_grains"), summary("training_shear_stress_points"));
    let shared = zone.shared_with(&partner.run.snapshot(0)?.bodies);
    Ok(Ok(Compared { hybrid, partner, zone, strain, grains, trained, points, region, shared, interpolated }))
}

pub fn part(among: &Among) -> Result<Part, Error> {
    let (mut all, mut left_out) = (Vec::new(), Vec::new());
    for hybrid in among.members.iter().filter(|member| member.is("hybrid")) {
        match compare(among, hybrid)? {
            Ok(compared) => {
                if compared.shared < SHARED_LEAST {
                    left_out.push(format!(
                        "{} and {} have the same seed, but only {} of the inserted grains are the other's: \
                         the packings differ, as they do where `loading.plate_damping` does.",
                        hybrid.label,
                        compared.partner.label,
                        percent(compared.shared)
                    ));
                }
                all.push(compared);
            }
            Err(why) => left_out.push(why),
        }
    }
    if all.is_empty() {
        return Ok(Part { left_out, ..Part::default() });
    }
    Ok(Part {
        sentences: vec![sentence(among, &all)],
        figures: vec![drawing(&all)?],
        sheets: vec![sheet(&all)],
        left_out,
        json: Value::Array(all.iter().map(json).collect()),
    })
}

fn sentence(among: &Among, all: &[Compared]) -> String {
    let of = |pick: fn(&Compared) -> f64| -> Vec<(usize, f64)> {
        all.iter().map(|compared| (compared.hybrid.group, pick(compared))).collect()
    };
    format!(
        "Mean shear stress of the inserted grains: {}. It is off that of the same region of the grains alone at the same strain \
         by: {}.",
        by_group(&among.groups, &of(|compared| compared.grains), kilopascal),
        by_group(&among.groups, &of(|compared| compared.off()), share)
    )
}

fn sheet(all: &[Compared]) -> Sheet {
    let mut sheet = Sheet::new(
        "Mean shear stress in the region of the inserted grains",
        &[
            "strain",
            "grains, first frame",
            "at the end of training",
            "points before",
            "grains alone",
            "off",
            "frames of it",
        ],
    );
    for compared in all {
        let frames = compared.interpolated.map_or_else(
            || "at that strain".to_owned(),
            |[from, to]| format!("between {} and {}", percent(from), percent(to)),
        );
        sheet.row(
            &compared.name(),
            vec![
                Some(percent(compared.strain)),
                Some(kilopascal(compared.grains)),
                compared.trained.map(kilopascal),
                compared.points.map(kilopascal),
                Some(kilopascal(compared.region)),
                Some(share(compared.off())),
                Some(frames),
            ],
        );
    }
    sheet
}

fn json(compared: &Compared) -> Value {
    json!({
        "run": compared.hybrid.label, "against": compared.partner.label, "seed": compared.hybrid.seed,
        "training": compared.hybrid.training(), "strain": compared.strain,
        "shear_stress_grains_pa": compared.grains,
        "shear_stress_end_of_training_pa": compared.trained,
        "shear_stress_points_pa": compared.points,
        "shear_stress_region_pa": compared.region,
        "off": compared.off(), "grains_in_common": compared.shared,
        "interpolated_between_strains": compared.interpolated,
    })
}

/// The best trained packing that there is, an untrained one of the same specimen and packing, and the grains alone.
fn drawing(all: &[Compared]) -> Result<Drawn, Error> {
    let most = |a: usize, b: usize| if all[b].hybrid.training() > all[a].hybrid.training() { b } else { a };
    let best = &all[(0..all.len()).reduce(most).unwrap_or(0)];
    let same = |other: &&Compared| other.hybrid.case == best.hybrid.case && other.hybrid.seed == best.hybrid.seed;
    let untrained = all.iter().filter(same).find(|other| other.hybrid.training() == 0.0);
    let untrained = untrained.filter(|other| other.hybrid.index != best.hybrid.index);
    let coloured = |snapshot: Snapshot, zone: Option<&Zone>| {
        let value = |body: &Body| match zone.is_none_or(|zone| zone.holds(body)) && is_inner(body) {
            true => body.shear_stress,
            false => f64::NAN,
        };
        snapshot.bodies.iter().map(|&body| Valued { body, value: value(&body) }).collect::<Vec<_>>()
    };
    let mut pictures = Vec::new();
    for compared in untrained.into_iter().chain([best]) {
        let snapshot = compared.hybrid.run.snapshot(compared.hybrid.enriched.unwrap_or(0))?;
        let titles = [
            format!("training {}", percent(compared.hybrid.training())),
            format!("mean {}", kilopascal(compared.grains)),
        ];
        pictures.push(Picture {
            span: compared.hybrid.run.span(),
            titles,
            bodies: coloured(snapshot, None),
            band: None,
        });
    }
    let frame = best.partner.run.frame_at(best.strain);
    let bodies = coloured(best.partner.run.snapshot(frame)?, Some(&best.zone));
    let titles = [
        "grains alone".to_owned(),
        format!("mean {} (drawn at {})", kilopascal(best.region), percent(best.partner.run.strain_of(frame))),
    ];
    pictures.push(Picture { span: best.partner.run.span(), titles, bodies, band: None });
    let upper = round_up(pictures.iter().map(|picture| nearly_largest(&picture.bodies)).fold(0.0, f64::max));
    let colours = Colours { upper, unit: 1e-3, words: "shear stress of a grain, zero and below dark (kPa)" };
    Ok(Drawn {
        name: "compare_training",
        drawing: draw("compare-training", &pictures, &colours, "Shear stress of inserted grains and of grains alone"),
        caption: format!(
            "Shear stress of the grains inserted into {} at {} of strain, and of the same region of {}: its grains that began \
             where those of the hybrid did (Chen et al. 2021, figure 13). Grey: the rim, points, and what is not compared.",
            best.hybrid.label,
            percent(best.strain),
            best.partner.label
        ),
    })
}
