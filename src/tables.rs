//! Rows as tables: what checkpoints and cached packings are made of.

use scree_io::column::{State, Table};

use crate::dem::grains::{ContactRow, GrainRow};
use crate::error::Error;
use crate::ids::GrainId;
use crate::record::{from_table, to_table};
use crate::space::{Space, Words};
use crate::transfer::Cargo;

/// Tables `grains` and `contacts` of rows in canonical order. A contact stands once, with the grain of the lower id.
pub fn of_grains<S: Space, M: Words<f64>>(rows: &mut [GrainRow<S, M>]) -> [Table; 2] {
    let mut contacts: Vec<ContactRow<M>> = Vec::new();
    for row in rows.iter() {
        let lower = row.cold.id;
        let ours = row.contacts.iter().filter(|(partner, _)| *partner > lower);
        contacts.extend(ours.map(|(higher, memory)| ContactRow { lower, higher: *higher, memory: *memory }));
    }
    let mut blank = ContactRow { lower: GrainId(0), higher: GrainId(0), memory: M::zero() };
    [to_table("grains", rows, &mut GrainRow::blank()), to_table("contacts", &mut contacts, &mut blank)]
}

/// Rows of the tables that [`of_grains`] made, in their order.
pub fn to_grains<S: Space, M: Words<f64>>(state: &State) -> Result<Vec<GrainRow<S, M>>, Error> {
    let blank = ContactRow { lower: GrainId(0), higher: GrainId(0), memory: M::zero() };
    let mut rows: Vec<GrainRow<S, M>> = rows(state, "grains", &GrainRow::blank())?;
    let contacts: Vec<ContactRow<M>> = self::rows(state, "contacts", &blank)?;
    let mut order: Vec<(GrainId, usize)> = rows.iter().enumerate().map(|(at, row)| (row.cold.id, at)).collect();
    order.sort_unstable();
    let find = |id: GrainId| {
        let at = order.binary_search_by_key(&id, |(id, _)| *id);
        at.map(|at| order[at].1)
            .map_err(|_| Error::User(format!("table `contacts` names grain {}, which table `grains` lacks", id.0)))
    };
    for contact in contacts {
        let (lower, higher) = (find(contact.lower)?, find(contact.higher)?);
        rows[lower].contacts.push((contact.higher, contact.memory));
        rows[higher].contacts.push((contact.lower, contact.memory));
    }
    for row in &mut rows {
        row.contacts.sort_unstable_by_key(|(partner, _)| *partner);
    }
    Ok(rows)
}

/// Rows of a table by name.
pub fn rows<R: crate::record::Record + Clone>(state: &State, name: &str, blank: &R) -> Result<Vec<R>, Error> {
    let table = state
        .tables
        .iter()
        .find(|table| table.name == name)
        .ok_or_else(|| Error::User(format!("there is no table `{name}`; the file is not of this kind")))?;
    from_table(table, blank).map_err(Error::User)
}
