use crate::operations;
use scree_partition::Solo;

#[test]
fn alone() {
    operations::check_all(&Solo);
}
