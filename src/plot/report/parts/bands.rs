//! Incremental strain and bands.

use super::{Part, Sheet, by_group};
use crate::analysis::measures::Measures;
use crate::analysis::measures::among::Group;
use crate::analysis::measures::bands::{Bands, Box, Measured};
use crate::plot::report::Drawn;
use crate::plot::report::numbers::{D50, THIN, change, degrees, interval, percent, plain, tenths};
use crate::plot::report::pictures::{Colours, Picture, draw, strain_end};

/// Pictures and bodies in them, up to which all runs are drawn and not the first of each group.
const PICTURES_MAX: usize = 6;
const BODIES_MAX: usize = 60_000;

pub fn part(measures: &Measures) -> Part {
    let left_out = measures.bands.left_out.clone();
    match &measures.bands.of {
        None => Part { left_out, ..Part::default() },
        Some(bands) => Part {
            sentences: sentence(measures, bands).into_iter().collect(),
            figures: drawing(measures, bands).into_iter().collect(),
            sheets: vec![thickness(measures, bands), boxes(measures, bands)],
            left_out,
        },
    }
}

/// What lengths are told in.
fn unit(measures: &Measures) -> &'static str {
    if measures.among.members.iter().all(|member| member.run.has_grains()) { D50 } else { "cells" }
}

fn thickness(measures: &Measures, bands: &Bands) -> Sheet {
    let height = |band: &Measured| {
        let height = band.height_m?;
        let unit = band.span.map_or(1.0, |span| span.diameter);
        Some(format!("{} ({}{THIN}mm)", plain(height / unit, 2), plain(1e3 * height, 2)))
    };
    let pieces = |band: &Measured| {
        let piece = |thickness: Option<f64>| thickness.map_or("\u{2013}".to_owned(), tenths);
        let told: Vec<String> = band.pieces.iter().map(|of| piece(of.thickness_d50)).collect();
        (!told.is_empty()).then(|| told.join(", "))
    };
    let cells = |band: &Measured| {
        let all = [band.thickness_cells, band.thickness_cells_with_bodies, band.width_at_half_cells];
        let told: Vec<String> = all.into_iter().flatten().map(tenths).collect();
        (!told.is_empty()).then(|| told.join(", "))
    };
    Sheet::of(
        &format!("The band; lengths in {} unless said otherwise", unit(measures)),
        &bands.runs,
        |band| band.who.run.clone(),
        &[
            ("between strains", &|band| Some(interval(band.between_strains))),
            ("thickness", &|band| {
                let millimetres = |thickness: f64| 1e3 * thickness * band.span.map_or(0.0, |span| span.diameter);
                band.thickness_d50.map(|of| format!("{} ({}{THIN}mm)", tenths(of), plain(millimetres(of), 2)))
            }),
            ("in pieces of the interval", &pieces),
            ("slope", &|band| band.slope_deg.map(degrees)),
            ("length", &|band| band.length_d50.map(tenths)),
            ("centre above the lower edge", &height),
            ("share of all strain", &|band| band.share_of_strain.map(percent)),
            ("volume strain of it", &|band| band.volume_strain.map(change)),
            ("solid volume fraction at the end", &|band| band.packing_fraction_end.map(|share| format!("{share:.3}"))),
            ("width at half of the peak", &|band| band.width_at_half_d50.map(tenths)),
            ("in cells (with the bodies, at half)", &cells),
            ("of the band inside the zone", &|band| band.inside_zone.map(percent)),
            ("of all shear inside the zone", &|band| band.shear_inside_zone.map(percent)),
        ],
    )
}

fn boxes(measures: &Measures, bands: &Bands) -> Sheet {
    let size =
        |of: &Option<Box>| of.as_ref().map(|of| format!("{} ({})", tenths(of.thickness_d50), tenths(of.length_d50)));
    Sheet::of(
        &format!(
            "The box around the most strained 2{THIN}% (appendix A): thickness, in brackets length, {}",
            unit(measures)
        ),
        &bands.runs,
        |band| band.who.run.clone(),
        &[
            ("98th percentile", &|band| size(&band.box_98th)),
            ("97th", &|band| size(&band.box_97th)),
            ("99th", &|band| size(&band.box_99th)),
            ("dem\u{2019}s threshold", &|band| size(&band.box_dem_threshold)),
            ("slope by the 98th", &|band| band.box_98th.as_ref().map(|of| degrees(of.slope_deg))),
        ],
    )
}

fn sentence(measures: &Measures, bands: &Bands) -> Option<String> {
    let groups = &measures.among.groups;
    let of = |pick: fn(&Measured) -> Option<f64>| -> Vec<_> {
        bands.runs.iter().filter_map(|band| Some((&band.who, pick(band)?))).collect()
    };
    let thickness = of(|band| band.thickness_d50);
    let mut words = format!(
        "Thickness of the band from {} of {}: {}.",
        interval(bands.between_strains),
        measures.among.members[0].run.drive.words,
        by_group(groups, &thickness, |thickness| format!("{} {}", tenths(thickness), unit(measures))),
    );
    let is_straight = bands.runs.iter().any(|band| band.share_of_strain.is_some());
    for (what, told) in [
        ("slope", by_group(groups, &of(|band| Some(band.slope_deg?.abs())), degrees)),
        ("share of all shear strain", by_group(groups, &of(|band| band.share_of_strain), percent)),
        ("volume strain", by_group(groups, &of(|band| band.volume_strain), change)),
    ] {
        if is_straight && !told.is_empty() {
            words += &format!(" Its {what}: {told}.");
        }
    }
    (!thickness.is_empty()).then_some(words)
}

/// All runs, or the first that can be drawn of every group where they or their bodies are many.
fn drawing(measures: &Measures, bands: &Bands) -> Option<Drawn> {
    let among = &measures.among;
    let picture = |index: usize| {
        let (run, band) = (among.members[index].run, bands.of_run(index)?);
        Some(Picture {
            run,
            time: run.frame_times[run.frame_at(band.between_strains[1])],
            head: String::new(),
            titles: [band.who.run.clone(), interval(band.between_strains)],
            bodies: band.bodies.clone(),
            vertices: Vec::new(),
            corner: None,
            band: band.band.clone(),
        })
    };
    let bodies: usize = among.members.iter().map(|member| member.run.bodies).sum();
    let pictures: Vec<Picture> = match among.members.len() <= PICTURES_MAX && bodies <= BODIES_MAX {
        true => (0..among.members.len()).filter_map(picture).collect(),
        false => {
            let first = |group: &Group| group.members.iter().find_map(|&index| picture(index));
            among.groups.iter().filter_map(first).collect()
        }
    };
    let words = "incremental deviatoric strain |e\u{2032}|";
    let colours = Colours { ends: [0.0, strain_end(&pictures)], unit: 1.0, words };
    let is_periodic = among.members[0].run.period() > 0.0;
    let caption = if is_periodic {
        "the band by their appendix A with its thickness beside it: the smallest box around the centres of the most strained 2\u{2009}% of \
         the material (98th percentile by area) without outliers beyond two standard deviations, level and without ends where it closes \
         round the period; where they are one row of points it has no thickness. The tables have it by other percentiles of strain, in \
         pieces of the interval, with the threshold of the grains alone, and the width in which the mean strain of a height is at \
         least half of its largest."
    } else {
        "the strongest straight band with its thickness beside it: of strips 10\u{2009}D\u{2085}\u{2080} across in all directions the one with \
         the largest excess of mean strain over the specimen\u{2019}s times the root of its area, and the unbroken stretch across it in \
         which the mean along it is at least half of its largest. Where it has little of all strain there is no one band, and its \
         thickness is that of a part of a pattern. Its volume strain is that of the grains in it, by their shares of the space between \
         them, since strain fitted to the motions of grains that mix has no volume to be trusted. The box of appendix A holds the most \
         strained 2\u{2009}% without outliers: all bands at once, where there are several."
    };
    (!pictures.is_empty()).then(|| Drawn {
        name: "bands".to_owned(),
        drawing: draw("bands", &pictures, None, &colours, "Incremental deviatoric strain"),
        caption: format!(
            "Incremental deviatoric strain between two strains, body by body; bodies that were not there yet are grey (Chen et al. 2021, \
             figures 11, 12, 18 and 24), and {caption}"
        ),
    })
}

/// The band of one run, in a sentence.
pub fn told(measures: &Measures, index: usize) -> Option<String> {
    /// A band thicker than this share of the specimen is none.
    const LOCALISED: f64 = 0.5;
    /// A box thinner than this share of a diameter holds one row.
    const SINGLE_ROW: f64 = 1e-3;
    let found = measures.bands.of.as_ref()?.of_run(index)?;
    let between = format!("From a strain of {}", interval(found.between_strains));
    let (Some(band), Some(span), Some(height)) = (&found.band, found.span, found.height_m) else {
        return Some(format!(" {between} strain did not gather in a band that could be measured."));
    };
    let unit = unit(measures);
    let long = |length: f64| plain(length / span.diameter, 2);
    if band.thickness > LOCALISED * found.height {
        return Some(format!(
            " {between} the most strained 2{THIN}% of the material were spread over {} {unit} of the specimen's {} {unit}: not a band.",
            long(band.thickness),
            long(found.height),
        ));
    }
    let inside =
        found.inside_zone.map_or_else(String::new, |share| format!("; {} of it is inside the zone", percent(share)));
    let above = format!("{} {unit} above the specimen's lower edge{inside}", long(height));
    if found.thickness_d50.is_none() {
        return Some(format!(
            " {between} strain gathered in the continuum, which gives a band no thickness of its own, {above}."
        ));
    }
    // The box holds places and not the points about them.
    if band.thickness < SINGLE_ROW * span.diameter {
        return Some(format!(" {between} strain gathered in a single row, {above}."));
    }
    let slope =
        if span.is_periodic { String::new() } else { format!(" at {}", degrees(found.slope_deg.unwrap_or(0.0))) };
    Some(format!(
        " {between} strain gathered in a band {} {unit} ({}{THIN}mm) thick{slope}, centred {above}.",
        long(band.thickness),
        plain(1e3 * band.thickness, 2),
    ))
}
