//! `scree digest`: one line that is equal for equal states.

use std::path::Path;

use crate::base::error::Error;
use crate::store::checkpoint;

pub(super) fn command(path: &Path) -> Result<String, Error> {
    if !path.exists() {
        return Err(Error::User(format!(
            "There is no {}. Give the folder of a run or one of its checkpoints.",
            path.display()
        )));
    }
    Ok(format!("{}\n", checkpoint::digest_of(path)?))
}
