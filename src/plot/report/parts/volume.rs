//! Volume strain of the whole, of the band and of the zone.

use super::stress::sentence_case;
use super::{Part, Sheet, entry_of, runs};
use crate::analysis::measures::Measures;
use crate::analysis::measures::volume::{Swelling, Volume};
use crate::plot::report::Drawn;
use crate::plot::report::chart::{self, Axis, Chart, Curve, Entry};
use crate::plot::report::numbers::{change, percent};
use crate::plot::report::panels::{axis_of, places};

pub fn part(measures: &Measures, volumes: &[Volume]) -> Part {
    let three = |of: &[Option<f64>; 3]| {
        let told: Option<Vec<String>> = of.iter().map(|strain| strain.map(change)).collect();
        told.map(|told| told.join(", "))
    };
    let sheet = Sheet::of(
        "Volume strain, of the whole, of the band since the last enrichment, and of the grains that first replaced points since then, \
         at three strains",
        volumes,
        |volume| volume.who.run.clone(),
        &[
            ("strains", &|volume| Some(volume.strains.map(percent).join(", "))),
            ("of the whole", &|volume| three(&volume.volume_strain)),
            ("of the band", &|volume| three(volume.volume_strain_band.as_ref()?)),
            ("of the zone\u{2019}s grains", &|volume| three(volume.volume_strain_zone.as_ref()?)),
            ("the same grains alone", &|volume| three(volume.volume_strain_zone_alone.as_ref()?)),
        ],
    );
    let figures = drawing(measures, volumes).into_iter().collect();
    Part { figures, sheets: vec![sheet], ..Part::default() }
}

/// What the series does not have: that of the whole is drawn with the other columns.
fn drawing(measures: &Measures, volumes: &[Volume]) -> Option<Drawn> {
    let (x, unit) = axis_of(&runs(measures));
    let curve = |index: usize, of: &Swelling| Curve {
        places: places(&of.strain, &of.volume, [unit, 0.01], None),
        stroke: entry_of(measures, index, 1.6).stroke,
    };
    let bands = volumes.iter().filter_map(|volume| Some(curve(volume.who.index, volume.band.as_ref()?)));
    let zones = volumes.iter().filter_map(|volume| Some((volume.who.index, volume.zone.as_ref()?)));
    let zones = zones.flat_map(|(index, (own, alone, partner))| [curve(index, own), curve(*partner, alone)]);
    let of = [("of the band", bands.collect::<Vec<_>>()), ("of the zone\u{2019}s grains", zones.collect())];
    let of: Vec<_> = of.into_iter().filter(|(_, curves)| !curves.is_empty()).collect();
    let several = of.len() > 1;
    let chart = |((title, curves), letter): ((&str, Vec<Curve<'static>>), char)| Chart {
        title: if several { format!("({letter}) {title}") } else { sentence_case(title) },
        x: x.clone(),
        y: {
            let values = curves.iter().flat_map(|curve| &curve.places).map(|place| place[1]);
            Axis::around("volume strain (%)", values.chain([0.0]))
        },
        curves,
        ..Chart::default()
    };
    let charts: Vec<Chart> = of.into_iter().zip('a'..).map(chart).collect();
    let entries: Vec<Entry> = (0..measures.among.members.len()).map(|index| entry_of(measures, index, 1.6)).collect();
    let since = measures.among.enriched().fold(0.0, f64::max);
    (!charts.is_empty()).then(|| Drawn {
        name: "volume_of_bands".to_owned(),
        drawing: chart::draw(
            "volume-of-bands",
            "Volume strain of the band and of the zone against strain",
            &entries,
            &charts,
            charts.len(),
        ),
        caption: format!(
            "Volume strain, positive in dilation (Chen et al. 2021, figure 17), of the bodies that lie in the band, since {} of strain; \
             and of the grains that first replaced points, without the rim, since then, beside that of the very same grains in the run \
             of grains alone. By the space that they fill: of grains a third of every triangle between neighbours, of points their \
             volume.",
            percent(since)
        ),
    })
}
