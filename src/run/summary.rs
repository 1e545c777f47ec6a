//! What a stretch of a run was like: figures for `summary.json`, and the same for a person at its end.

use serde_json::{Map, Value, json};

use crate::base::space::Space;
use crate::domain::accounts::conservation::Conservation;
use crate::domain::world::World;

/// From its start or its last resumption to now, as rank 0 has seen it.
#[derive(Clone, Copy, Debug)]
pub struct Stretch {
    /// Steps done before it.
    pub first_step: u64,
    /// Wall time, s.
    pub seconds: f64,
    /// Per rank.
    pub threads: usize,
    /// Steps of single grains and of single points.
    pub grain_steps: u64,
    /// Those of the continuum, however many steps of grains are in one.
    pub point_steps: u64,
    /// Checkpoints written, and the wall time that they took, s.
    pub checkpoints: u64,
    /// s.
    pub checkpoint_seconds: f64,
    /// Of the whole run.
    pub conservation: Conservation,
}

/// Its figures; collective, and of use on rank 0.
pub fn figures<S: Space>(world: &World<'_, S>, stretch: &Stretch) -> Value {
    let steps = (world.step - stretch.first_step).max(1) as f64;
    let mut sent =
        [world.subdomain.sent.messages as i64, world.subdomain.sent.bytes as i64, world.load_balance.rows_sent as i64];
    world.transport.sum(&mut sent);
    let [messages, bytes, rows_moved] = sent;
    let phases = world.phases.over_ranks(world.transport);
    let phase = |[least, mean, most]: [f64; 3]| json!({ "least": least, "mean": mean, "most": most });
    let phases: Map<String, Value> =
        phases.into_iter().map(|(name, seconds)| (name.to_string(), phase(seconds))).collect();
    json!({
        "program": crate::base::program::identity(),
        "steps": world.step,
        "simulated_time": world.time(),
        "wall_seconds": stretch.seconds,
        "ranks": world.transport.size(),
        "threads": stretch.threads,
        "grains": world.grains_total,
        "points": world.points_total,
        "rebuilds": world.rebuilds,
        "microseconds_per_step": 1e6 * stretch.seconds / steps,
        "grain_steps_per_second": stretch.grain_steps as f64 / stretch.seconds,
        "point_steps_per_second": stretch.point_steps as f64 / stretch.seconds,
        "checkpoints_written": stretch.checkpoints,
        "checkpoint_seconds": stretch.checkpoint_seconds,
        "phases": phases,
        "imbalance": world.phases.imbalance(world.transport),
        "messages_per_step": messages as f64 / steps,
        "bytes_per_step": bytes as f64 / steps,
        "rows_moved": rows_moved,
        "rebalances": world.load_balance.deals,
        "conservation": stretch.conservation.figures(),
    })
}

/// A table of phases and a line for everything else that is worth a look.
pub fn words(figures: &Value) -> String {
    let number = |key: &str| figures[key].as_f64().unwrap_or(0.0);
    let (seconds, ranks) = (number("wall_seconds"), number("ranks"));
    let mut lines = vec![format!("{:<10}{:>12}{:>9}{:>12}{:>12}", "phase", "mean, s", "share", "least", "most")];
    let mut phases: Vec<(&String, [f64; 3])> = Vec::new();
    for (name, of) in figures["phases"].as_object().into_iter().flatten() {
        phases.push((name, ["mean", "least", "most"].map(|key| of[key].as_f64().unwrap_or(0.0))));
    }
    phases.sort_by(|(_, [a, ..]), (_, [b, ..])| b.total_cmp(a));
    for (name, [mean, least, most]) in phases {
        let share = percent(mean, seconds);
        lines.push(format!("{name:<10}{mean:>12.3}{share:>9}{least:>12.3}{most:>12.3}"));
    }
    let mut rates = vec![format!("{:.1} us a step", number("microseconds_per_step"))];
    for (kind, key) in [("grain", "grain_steps_per_second"), ("point", "point_steps_per_second")] {
        if number(key) > 0.0 {
            rates.push(format!("{:.3} million {kind}-steps a second", 1e-6 * number(key)));
        }
    }
    if ranks > 1.0 {
        rates.push(format!("busiest rank {:.3} times the mean", number("imbalance")));
        rates.push(format!(
            "{:.1} kB a step in {:.1} messages",
            1e-3 * number("bytes_per_step"),
            number("messages_per_step")
        ));
    }
    lines.push(rates.join(", "));
    let (written, took) = (number("checkpoints_written"), number("checkpoint_seconds"));
    lines.push(format!(
        "{written} checkpoint{}: {took:.3} s, {} of the time",
        if written == 1.0 { "" } else { "s" },
        percent(took, seconds).trim_start()
    ));
    lines.join("\n")
}

fn percent(part: f64, whole: f64) -> String {
    if whole > 0.0 { format!("{:.1} %", 100.0 * part / whole) } else { "0.0 %".into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_person_sees_the_largest_phase_first_and_what_checkpoints_took() {
        let figures = json!({
            "wall_seconds": 10.0, "ranks": 2, "microseconds_per_step": 100.0, "grain_steps_per_second": 2.5e7,
            "point_steps_per_second": 0.0, "checkpoints_written": 1, "checkpoint_seconds": 0.05, "imbalance": 1.03,
            "bytes_per_step": 32_000.0, "messages_per_step": 6.0,
            "phases": {"agree": {"least": 0.5, "mean": 1.0, "most": 1.5}, "contacts": {"least": 6.0, "mean": 7.0, "most": 8.0}},
        });
        let told = words(&figures);
        let lines: Vec<&str> = told.lines().collect();
        assert!(
            lines[1].starts_with("contacts") && lines[1].ends_with("8.000") && lines[1].contains("70.0 %"),
            "{told}"
        );
        assert!(lines[2].starts_with("agree"), "{told}");
        assert_eq!(
            lines[3],
            "100.0 us a step, 25.000 million grain-steps a second, busiest rank 1.030 times the mean, 32.0 kB a step in 6.0 messages"
        );
        assert_eq!(lines[4], "1 checkpoint: 0.050 s, 0.5 % of the time");
    }
}
