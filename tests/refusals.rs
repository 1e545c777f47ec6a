//! A job that is right, and what the operator is told once it is broken. The whole message is compared: it is the interface.

use scree::job::Job;

/// The text of a job that is right; tests break it in one place.
pub struct Good(pub &'static str);

impl Good {
    #[track_caller]
    pub fn is_good(&self) {
        Job::parse(self.0, "job.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
    }

    /// The message that the good job with `right` replaced by `wrong` is refused with.
    #[track_caller]
    pub fn refused(&self, right: &str, wrong: &str, message: &str) {
        assert_eq!(self.0.matches(right).count(), 1, "the good job has {right} once");
        refused_text(&self.0.replace(right, wrong), &[], message);
    }

    /// A message that the good job with `right` replaced by `wrong` is refused with, where more than one thing may be wrong then.
    #[track_caller]
    pub fn refused_among(&self, right: &str, wrong: &str, message: &str) {
        assert_eq!(self.0.matches(right).count(), 1, "the good job has {right} once");
        let error = Job::parse(&self.0.replace(right, wrong), "job.toml", &[]).expect_err("the job is wrong");
        let told = without_excerpts(&error.to_string());
        assert!(told.split("\n\n").any(|one| one == message), "{told}");
    }

    /// The message that the good job is refused with under an override.
    #[track_caller]
    pub fn refused_set(&self, set: &str, message: &str) {
        refused_text(self.0, &[set], message);
    }
}

#[track_caller]
pub fn refused_text(text: &str, sets: &[&str], message: &str) {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
    let error = Job::parse(text, "job.toml", &sets).expect_err("the job is wrong");
    assert_eq!(error.exit_code(), 2);
    assert_eq!(without_excerpts(&error.to_string()), message);
}

/// A refusal without the lines of the job that it shows; the catalogue has them.
pub fn without_excerpts(told: &str) -> String {
    let is_shown = |line: &&str| {
        let bare = line.trim_start().trim_start_matches(|c: char| c.is_ascii_digit()).trim_start();
        line.starts_with("  ") && bare.starts_with('|')
    };
    told.lines().filter(|line| !is_shown(line)).collect::<Vec<_>>().join("\n")
}
