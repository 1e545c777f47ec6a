//! stub
use crate::error::Error;
use crate::law::contact::ContactLaw;
use crate::rebuild::Row;
use crate::scenario::assembly::{Assembly, Packed};
use crate::space::Space;
use scree_partition::Transport;
pub fn make<S: Space, C: ContactLaw<S>>(
    _job: &Assembly,
    _packed: &Packed,
    _transport: &dyn Transport,
) -> Result<Vec<Row<S, C>>, Error> {
    Err(Error::User("not yet".into()))
}
