//! Sums that belong to cells of the plane: shared among the ranks, and added up around a cell.

use std::collections::BTreeMap;

use scree_partition::{ParcelError, Reader, Transport, Writer};

use crate::base::error::Error;
use crate::base::numbers::Numbers;
use crate::base::space::{Plane, Space};
use crate::couple::patch::Patch;
use crate::couple::zone::CellGrid;

/// Sums of this rank's cells, with those of all others. A cell belongs to one rank. Collective.
pub fn everywhere<T: Numbers + Default>(
    transport: &dyn Transport,
    mine: &BTreeMap<u64, T>,
) -> Result<BTreeMap<u64, T>, Error> {
    let mut parcel = Writer::new();
    for (cell, sums) in mine {
        parcel.u64(*cell);
        sums.numbers().iter().for_each(|number| parcel.f64(*number));
    }
    let mut all = BTreeMap::new();
    for bytes in transport.all_gather(parcel.as_bytes()) {
        read(&bytes, &mut all).map_err(|error| Error::Run(error.to_string()))?;
    }
    Ok(all)
}

fn read<T: Numbers + Default>(bytes: &[u8], into: &mut BTreeMap<u64, T>) -> Result<(), ParcelError> {
    let mut reader = Reader::plain(bytes);
    while reader.left() > 0 {
        let (cell, mut sums) = (reader.u64()?, T::default());
        for number in sums.numbers_mut() {
            *number = reader.f64()?;
        }
        let before = into.insert(cell, sums);
        assert!(before.is_none(), "a cell belongs to one rank");
    }
    Ok(())
}

/// Those of the cells around one, and of itself, about its centre.
pub fn around(grid: &CellGrid, patches: &BTreeMap<u64, Patch>, cell: u64) -> Patch {
    let mut sum = Patch::default();
    for (beside, step) in grid.around(cell as usize) {
        if let Some(patch) = patches.get(&(beside as u64)) {
            let way = step.map(|cells| cells as f64 * grid.cell);
            sum.add(patch, &<Plane as Space>::Vector::new(way[0], way[1]));
        }
    }
    sum
}
