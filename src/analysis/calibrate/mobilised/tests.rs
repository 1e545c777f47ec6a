//! The fit of data that the law itself made.

use super::*;
use crate::analysis::calibrate::path::sheared;
use crate::law::material::{MobilisedConstants, MobilisedFriction};

/// Of a law with other figures than the fit starts from.
fn law() -> MobilisedConstants {
    MobilisedConstants {
        shear_degradation: 0.62,
        shear_degradation_strain: 1.6e-3,
        friction_angle_critical: math::atan(0.31),
        fraction_critical: 0.812,
        dilation_factor: 6.1,
        hardening_strain: 6e-3,
        hardening_fraction_width: Some(0.012),
        hardening_start: 0.17,
        phase_transformation_factor: 3.9,
        ..MobilisedConstants::DISCS
    }
}

/// A compression whose Kirchhoff stress rises by a modulus.
fn pressed(modulus: f64) -> Vec<Row> {
    let row = |number: u32| {
        let strain = 1e-5 * f64::from(number);
        let stress = -(400e3 + modulus * strain) * math::exp(strain);
        Row { strain, stress: [stress, 0.0, stress], pressure: -stress, fraction: 0.843 * math::exp(strain) }
    };
    (0..=20).map(row).collect()
}

/// The tests of a packing as the law has them; every second of the rows of the shear stress is a little more or less.
fn specimen(constants: &MobilisedConstants, dry: Option<&MobilisedConstants>, noise: f64) -> Specimen {
    specimen_in(2, constants, dry, noise)
}

fn specimen_in(axes: usize, constants: &MobilisedConstants, dry: Option<&MobilisedConstants>, noise: f64) -> Specimen {
    let tested = |constants: &MobilisedConstants, kind: &Kind| {
        let law = MobilisedFriction::of(constants);
        let mut strains = vec![0.0];
        for leg in kind.course.legs(kind.strain(0.4)) {
            let from: f64 = *strains.last().unwrap();
            let count = ((leg.to - from).abs() / leg.row).round();
            strains.extend((1..=count as u32).map(|number| from + (leg.to - from) * f64::from(number) / count));
        }
        let (fraction, stress) = (if kind.loose { 0.802 } else { 0.843 }, kind.share * 400e3);
        let drive = Drive { axes, stress, fraction, kept: kind.kept(), increment: INCREMENT };
        let rows = sheared(&law, drive, strains.into_iter()).expect("the law bears it").into_iter();
        let rows = rows.enumerate().map(|(number, (row, volume))| {
            let sign = if number % 2 == 0 { 1.0 } else { -1.0 };
            let [xx, xy, yy] = row.stress;
            // A short unloading is compared from one row on, which noise of single rows would move as a whole.
            let noise = if kind.unloads() { 0.0 } else { sign * noise };
            Row { fraction: fraction / volume, stress: [xx, xy * (1.0 + noise), yy], ..row }
        });
        Tested { rows: rows.collect(), profiles: Vec::new() }
    };
    let all = |constants: &MobilisedConstants| KINDS.iter().map(|kind| tested(constants, kind)).collect();
    let fitted = |constants: &MobilisedConstants| {
        KINDS.iter().filter(|kind| kind.fitted).map(|kind| tested(constants, kind)).collect()
    };
    let shear = constants.shear_modulus * if axes == 2 { 1.0 } else { 4.0 / 3.0 };
    Specimen {
        axes,
        seed: 1,
        isotropic: pressed(constants.bulk_modulus),
        uniaxial: pressed(constants.bulk_modulus + shear),
        tests: all(constants),
        dry: dry.map_or(Vec::new(), fitted),
    }
}

fn of(fitted: Vec<Specimen>) -> Tests {
    Tests { wanted: WANTED, fitted, held: Vec::new() }
}

const WANTED: Wanted = Wanted { grains: 400, packings: 2, held: 0, strain: 0.4 };

fn off(found: f64, wanted: f64) -> f64 {
    (found / wanted - 1.0).abs()
}

/// Two packings, from two solid volume fractions under two stresses and with unloading, each with 4 % of noise.
#[test]
fn the_fit_finds_the_law_that_made_the_data() {
    finds_the_law(2);
}

/// The same of spheres: the law in space, in plane strain.
#[test]
fn the_fit_finds_the_law_of_spheres_that_made_the_data() {
    finds_the_law(3);
}

fn finds_the_law(axes: usize) {
    let wanted = law();
    let specimens = vec![specimen_in(axes, &wanted, None, 0.04), specimen_in(axes, &wanted, None, -0.03)];
    let found = fit_all(of(specimens), 400e3).unwrap();
    println!("{}", found.told());
    assert_eq!(found.fit.at_bound, [""; 0]);
    let constants = &found.fit.constants;
    let pairs = |law: &MobilisedConstants| {
        [
            (law.bulk_modulus, 1e-6),
            (law.shear_modulus, 1e-6),
            (law.friction_angle_critical, 3e-3),
            (law.fraction_critical, 3e-4),
            (law.dilation_factor, 0.02),
            (law.phase_transformation_factor, 0.02),
            (law.hardening_strain, 0.05),
            (law.hardening_fraction_width.unwrap(), 0.05),
            (law.hardening_start, 0.1),
            (law.shear_degradation, 0.02),
            (law.shear_degradation_strain, 0.06),
        ]
    };
    for ((found, bound), (wanted, _)) in pairs(constants).into_iter().zip(pairs(&wanted)) {
        assert!(off(found, wanted) < bound, "{found} for {wanted}");
    }
    // What was not fitted is the law's as well, and every bound is kept.
    assert_eq!(found.shown.iter().filter(|shown| !shown.kind.fitted).count(), 3);
    let all = musts::musts(&found);
    assert_eq!(all.len(), 2, "{all:?}");
    for must in all.iter().flat_map(|(_, musts)| musts) {
        assert!(must.is_met, "{must:?}");
    }
    // Three small cycles, an unloading before the peak and one from it, each with the modulus of the law's way there.
    let turns: Vec<&Unloading> = found.shown.iter().flat_map(|shown| &shown.unloadings).collect();
    assert_eq!(turns.iter().map(|turn| (1e4 * turn.strain).round() as u32).collect::<Vec<_>>(), [25, 200, 2, 10, 50]);
    for Unloading { modulus: [grains, law], .. } in &turns {
        assert!(off(*grains, *law) < 0.02, "{turns:?}");
    }
    assert!(turns[2].modulus[1] > turns[3].modulus[1] && turns[3].modulus[1] > turns[4].modulus[1], "{turns:?}");
    for shown in found.half_left_out.unwrap() {
        assert!(shown.quality.volume_largest[1] < 5e-4, "{:?}", shown.quality);
    }
}

/// Packings held back that are the fitted ones are off their mean by nothing; stronger ones by what they are stronger.
#[test]
fn packings_held_back_are_compared_with_those_that_are_fitted() {
    let stronger = MobilisedConstants { friction_angle_critical: math::atan(0.36), ..law() };
    let fitted = vec![specimen(&law(), None, 0.0), specimen(&law(), None, 0.0)];
    let packings = |held: Specimen| -> Vec<f64> {
        let found = fit_all(Tests { held: vec![held], ..of(fitted.clone()) }, 400e3).unwrap();
        let all = musts::musts(&found);
        let [(_, one), (_, other), (_, held)] = all.as_slice() else { panic!("{all:?}") };
        assert!(one.iter().chain(other).all(|must| must.of_packings.is_none()));
        let sines = held.iter().filter(|must| must.words.starts_with("sine") && must.test.starts_with("shear"));
        sines.map(|must| must.of_packings.as_ref().unwrap().parse().unwrap()).collect()
    };
    assert_eq!(packings(fitted[0].clone()), [0.0; 5]);
    // Critical states differ by 0.04 of the sine, peaks by as much; loose ones have mobilised half of it at 3 % of strain.
    let off = packings(specimen(&stronger, None, 0.0));
    assert!(off.len() == 5 && off.iter().all(|off| (0.01..0.06).contains(off)), "{off:?}");
}

/// c is what grains bear beyond the friction that they have without cohesion.
#[test]
fn cohesion_is_found_beyond_the_friction_of_dry_grains() {
    let dry = law();
    let wanted = MobilisedConstants { cohesion: 18e3, ..dry };
    let found = fit_all(of(vec![specimen(&wanted, Some(&dry), 0.0); 2]), 400e3).unwrap();
    println!("{}", found.told());
    let constants = found.fit.constants;
    assert!(off(constants.cohesion, wanted.cohesion) < 0.02, "{constants:?}");
    assert!(off(constants.friction_angle_critical, wanted.friction_angle_critical) < 2e-3, "{constants:?}");
}

/// Packings that differ give intervals; those that do not give none that is wide.
#[test]
fn intervals_are_those_of_the_packings() {
    let wanted = law();
    let looser = MobilisedConstants { fraction_critical: 0.814, ..wanted };
    let specimens = vec![specimen(&wanted, None, 0.0), specimen(&looser, None, 0.0), specimen(&wanted, None, 0.0)];
    let found = fit_all(of(specimens), 400e3).unwrap();
    let figure = |key: &str| *found.figures.iter().find(|figure| figure.key == key).unwrap();
    let fraction = figure("fraction_critical");
    // Three values of mean 0.8127, and Student's t of two degrees of freedom over sqrt(3).
    let wanted = 4.303 * 0.001_154_7 / 3.0_f64.sqrt();
    assert!((fraction.value - 0.812_667).abs() < 2e-4, "{fraction:?}");
    assert!(off(fraction.half_width.unwrap(), wanted) < 0.15, "{fraction:?} for {wanted}");
    assert!(figure("bulk_modulus").half_width.unwrap() < 1.0);
}

/// A layer that takes more than twice the mean ends the fit of dense packings, half of which must have one.
#[test]
fn softening_ends_where_a_band_begins() {
    let profiles = |largest: &[f64]| -> Vec<Profile> {
        let profile =
            |(number, share): (usize, &f64)| Profile { strain: 0.05 * (number + 1) as f64, shares: vec![*share] };
        largest.iter().enumerate().map(profile).collect()
    };
    let whole = specimen(&law(), None, 0.0);
    let with = |largest: &[f64]| {
        let mut one = whole.clone();
        one.tests.iter_mut().for_each(|tested| tested.profiles = profiles(largest));
        one
    };
    let specimens = [with(&[1.2, 1.5, 2.5, 3.0]), with(&[1.2, 1.3, 1.4, 2.2]), with(&[1.2, 1.3, 1.4, 1.9])];
    let all: Vec<&Specimen> = specimens.iter().collect();
    assert!((band(&all, 0, false).unwrap() - 0.15).abs() < 1e-12);
    assert_eq!(band(&all[2..], 0, false), None);
    assert_eq!(band(&all, 2, false), None, "loose packings do not soften");
    assert_eq!(band(&[&with(&[3.0])], 0, false), Some(THIRDS[0]), "the first third is fitted always");
}

/// A row of a test that has lost its stress is told, with the packing that it is of.
#[test]
fn a_packing_that_lost_its_stress_is_told() {
    let law = law();
    let mut packings = vec![specimen(&law, None, 0.0), specimen(&law, None, 0.0)];
    packings[1].seed = 2;
    let row = &mut packings[1].tests[LOOSE].rows[7];
    row.stress = row.stress.map(|stress| 0.44 * stress);
    let strain = row.strain;
    let calibration = fit_all(of(packings), 400e3).unwrap();
    let [only] = calibration.collapses()[..] else { panic!("one has") };
    assert_eq!((only.seed, only.kind, only.strain), (2, LOOSE, strain));
    assert!((only.share - 0.44).abs() < 1e-6, "{}", only.share);
    let told = format!("shear, loose, packing stress: {}", only.words());
    assert!(calibration.told().contains(&told) && told.contains("seed 2 collapsed: 44 %"), "{told}");
}
