//! Volume strain of the whole, where the series has it, and of the band (Chen et al. 2021, figures 17 and 20): of what lies in the
//! strongest strip of each run, and of the grains of a hybrid's zone, which can be found again where they are alone. Of two strips
//! the stronger one dilates sooner; the same grains are the same material.

use serde::Serialize;

use super::Found;
use super::among::{Among, Member, Who};
use super::bands::{Bands, END_SLACK};
use crate::analysis::curve::linear;
use crate::analysis::run::Run;
use crate::analysis::snapshot::{Body, Snapshot};
use crate::analysis::space::Spaces;
use crate::analysis::strained::Span;
use crate::analysis::zone::SAME;
use crate::base::error::Error;

/// Volume strain of some bodies of a run, at frames from one strain on.
#[derive(Clone, Debug)]
pub struct Swelling {
    /// Of the run at each frame, rising.
    pub strain: Vec<f64>,
    /// Change of the bodies' area since the first frame as a share of it, dilation positive.
    pub volume: Vec<f64>,
}

impl Swelling {
    fn of(run: &Run, span: &Span, members: &[Body], first: usize) -> Result<Option<Self>, Error> {
        if members.is_empty() {
            return Ok(None);
        }
        let start = run.snapshot(first)?;
        let start = Spaces::of(&start, span);
        let mut curve = Self { strain: vec![run.at_frame(first)], volume: vec![0.0] };
        for frame in first + 1..run.frame_times.len() {
            if let Some(swelling) = Spaces::of(&run.snapshot(frame)?, span).swelling(&start, members) {
                curve.strain.push(run.at_frame(frame));
                curve.volume.push(swelling);
            }
        }
        Ok((curve.strain.len() > 1).then_some(curve))
    }

    /// Held a little beyond the frames that it has: they come at other times than rows.
    fn at(&self, strain: f64) -> Option<f64> {
        let [first, last] = [self.strain[0], self.strain[self.strain.len() - 1]];
        let is_near = (first - END_SLACK * last..=last + END_SLACK * last).contains(&strain);
        is_near.then(|| linear(&self.strain, &self.volume, strain.clamp(first, last))).flatten()
    }
}

/// Volume strains at three strains: where bands are measured from and to, and at the common end.
#[derive(Clone, Debug, Serialize)]
pub struct Volume {
    /// The run.
    #[serde(flatten)]
    pub who: Who,
    /// At which volume strain is told; without bands the first is half of the common end, and the second that end.
    pub strains: [f64; 3],
    /// Of the whole, dilation positive; none where the series has none there.
    pub volume_strain: [Option<f64>; 3],
    /// Strain from which that of the band is counted; none where it has none.
    pub band_since_strain: Option<f64>,
    /// Of what lies in the strongest strip, since then.
    pub volume_strain_band: Option<[Option<f64>; 3]>,
    /// Of the grains that first replaced points in a hybrid, since then, and of the very same grains where they are alone.
    pub zone_since_strain: Option<f64>,
    /// Label of the run of grains alone.
    pub zone_alone_in: Option<String>,
    /// Of the hybrid's grains; none at a strain that frames do not reach.
    pub volume_strain_zone: Option<[Option<f64>; 3]>,
    /// Of the same grains where they are alone.
    pub volume_strain_zone_alone: Option<[Option<f64>; 3]>,
    /// Of what lies in the strongest strip, frame by frame.
    #[serde(skip)]
    pub band: Option<Swelling>,
    /// The zone's, that of the same grains alone, and which run that is.
    #[serde(skip)]
    pub zone: Option<(Swelling, Swelling, usize)>,
}

/// Of the zone's grains of one hybrid, or why not.
fn of_zone(among: &Among, hybrid: &Member) -> Result<Result<(Swelling, Swelling, usize), String>, Error> {
    let who = &hybrid.who.run;
    let fail = |why: &str| Ok(Err(format!("Volume strain of the zone\u{2019}s grains of {who}: {why}.")));
    let Some((first, span)) = hybrid.run.enriched.zip(hybrid.run.span) else {
        return fail("it was not enriched, or has no frame before or after");
    };
    let Some(partner) = among.partner(hybrid) else {
        return fail("there is no run of grains alone with its packing");
    };
    let members = lasting(hybrid.run, first)?;
    let start = partner.run.frame_at(hybrid.run.at_frame(first));
    if !are_same(&members, &partner.run.snapshot(start)?, span.diameter) {
        return fail("its grains are not those of the grains alone");
    }
    let own = Swelling::of(hybrid.run, &span, &members, first)?;
    match own.zip(Swelling::of(partner.run, &span, &members, start)?) {
        Some((own, alone)) => Ok(Ok((own, alone, partner.index()))),
        None => fail("no grain outside of the rim stays to the end, or a run has no frame after the enrichment"),
    }
}

/// Grains outside of the rim that a frame has and that are grains still at the end.
fn lasting(hybrid: &Run, first: usize) -> Result<Vec<Body>, Error> {
    let end = hybrid.snapshot(hybrid.frame_times.len() - 1)?;
    let mut members = hybrid.snapshot(first)?.bodies;
    members.retain(|body| body.is_inner() && end.row_of(body).is_some());
    Ok(members)
}

/// Whether `grains` are among others by id, and began where those did: a piece of packing has other grains than a specimen.
fn are_same(grains: &[Body], others: &Snapshot, diameter: f64) -> bool {
    let is_there = |grain: &Body| {
        others.row_of(grain).is_some_and(|row| {
            let (own, other) = (grain.origin(), others.bodies[row].origin());
            let apart = [0, 1].map(|axis| own[axis] - other[axis]);
            apart[0] * apart[0] + apart[1] * apart[1] < SAME * SAME * diameter * diameter
        })
    };
    grains.iter().all(is_there)
}

/// Without bands from half of the strain that all runs reach on; an error where a frame cannot be read.
pub fn measured(among: &Among, bands: Option<&Bands>) -> Result<Found<Vec<Volume>>, Error> {
    let since = among.enriched().fold(0.0, f64::max);
    let [end, _] = among.ends();
    let [from, to] = bands.map_or([0.5 * end, end], |bands| bands.between_strains);
    let strains = [from, to, end];
    let (mut all, mut left_out) = (Vec::new(), Vec::new());
    for member in &among.members {
        let run = member.run;
        // Shares of a triangulation have no neighbours across sides that are joined.
        let is_apart = run.span.is_some_and(|span| !span.is_periodic);
        let measured = bands.and_then(|bands| bands.of_run(member.index())).filter(|_| is_apart);
        let first = run.frame_at(since).max(run.enriched.unwrap_or(0));
        let band = measured.zip(run.span).map(|(own, span)| Swelling::of(run, &span, &own.members(), first));
        let band = band.transpose()?.flatten();
        let zone = if member.is("hybrid") && !run.begins_as_grains() && is_apart {
            Some(of_zone(among, member)?)
        } else {
            None
        };
        let zone = zone.and_then(|zone| zone.map_err(|why| left_out.push(why)).ok());
        let whole = run.column("volume_strain");
        let places = if whole.is_empty() { &[] } else { run.drive.values.as_slice() };
        let at = |curve: &Swelling| strains.map(|strain| curve.at(strain));
        all.push(Volume {
            who: member.who.clone(),
            strains,
            volume_strain: strains.map(|strain| linear(places, whole, strain)),
            band_since_strain: band.as_ref().map(|curve| curve.strain[0]),
            volume_strain_band: band.as_ref().map(at),
            zone_since_strain: zone.as_ref().map(|(own, ..)| own.strain[0]),
            zone_alone_in: zone.as_ref().map(|(.., partner)| among.members[*partner].who.run.clone()),
            volume_strain_zone: zone.as_ref().map(|(own, ..)| at(own)),
            volume_strain_zone_alone: zone.as_ref().map(|(_, alone, _)| at(alone)),
            band,
            zone,
        });
    }
    if among.members.iter().any(|member| member.run.column("volume_strain").is_empty()) {
        left_out.push("Volume strain of the whole is left out: no membranes enclose it.".to_owned());
    }
    if all.iter().all(|volume| volume.band.is_none()) && !among.members[0].run.drive.is_shear() {
        left_out.push("Volume strain of bands is left out: none was measured.".to_owned());
    }
    all.retain(|volume| {
        volume.volume_strain.iter().any(Option::is_some) || volume.band.is_some() || volume.zone.is_some()
    });
    Ok(Found::of(all, left_out))
}
