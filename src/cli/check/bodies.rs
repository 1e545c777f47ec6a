//! Bodies, plates and membranes.

use super::Slots;
use super::page::{Page, figures};
use crate::job::assembly::{Body, Shape};
use crate::job::mpm::BodyContact;

pub fn membranes(page: &mut Page, slots: &Slots) {
    let Some(job) = slots.continuum.as_deref().filter(|job| !job.membranes.is_empty()) else { return };
    page.section("Membranes");
    for membrane in &job.membranes {
        let segments = format!("{} segments of {} mm", membrane.segments(), figures(1e3 * membrane.segment()));
        let kind = if membrane.is_closed() { "a ring" } else { "a line" };
        page.row(
            &membrane.name,
            &format!("{} kPa", figures(1e-3 * membrane.pressure)),
            &format!(
                "to the left of its way; {kind} of {segments}, {} g in all, {} N at the start",
                figures(1e3 * membrane.segments() as f64 * membrane.mass_of_segment(job.grid.depth)),
                figures(membrane.tension)
            ),
        );
    }
}

pub fn bodies(page: &mut Page, slots: &Slots) {
    let bodies = slots.job.bodies();
    if !bodies.is_empty() {
        page.section("Bodies");
    }
    for (number, body) in bodies.iter().enumerate() {
        let shape = match &body.shape {
            Shape::Plane { .. } => "plane",
            Shape::Box { .. } => "box",
            Shape::Cylinder { .. } => "cylinder",
            Shape::Layer { .. } => "layer of grains",
        };
        let held = slots.continuum.as_ref().map_or_else(String::new, |job| {
            let contact = match job.bodies[number].contact {
                BodyContact::Rough => "rough".to_string(),
                BodyContact::Smooth => "smooth".to_string(),
                BodyContact::Coulomb { friction } => format!("friction {}", figures(friction)),
            };
            let parts = if job.bodies[number].separates { "" } else { ", never parts" };
            format!(", {contact}{parts}{}", if job.bodies[number].at_face { ", contact at its face" } else { "" })
        });
        page.row(&body.name, &format!("{shape}{held}"), &motion(body));
    }
}

fn motion(body: &Body) -> String {
    let path = match body.motion.path.as_slice() {
        [] => None,
        [_] => Some("moves at one velocity".to_string()),
        [.., last] => Some(format!("follows a path of {} s", figures(last.time))),
    };
    let servo = body.motion.servo.as_ref().map(|servo| format!("held at {} N", figures(servo.force)));
    let told: Vec<String> = path.into_iter().chain(servo).collect();
    if told.is_empty() { "at rest".to_string() } else { told.join(", ") }
}

/// The upper one of two rough plates that shear what is between them.
pub fn plates(page: &mut Page, slots: &Slots) {
    let Some(loading) = slots.job.plates() else { return };
    page.section("Loading");
    page.keys(2, |form| loading.clone().keys(form));
}
