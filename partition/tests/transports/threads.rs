use crate::operations;
use scree_partition::transport::threads::run;
use scree_partition::{Transport, in_turn};
use std::sync::atomic::{AtomicUsize, Ordering};

#[test]
fn one_to_five_threads() {
    for size in 1..6 {
        let results = run(size, |ranks| {
            operations::check_all(&ranks);
            ranks.rank()
        });
        assert_eq!(results, (0..size).collect::<Vec<_>>());
    }
}

#[test]
#[should_panic(expected = "grain 17 is lost")]
fn a_panic_on_one_rank_ends_all() {
    run(4, |ranks| {
        ranks.barrier();
        assert!(ranks.rank() != 2, "grain 17 is lost");
        ranks.barrier();
        ranks.barrier();
    });
}

#[test]
#[should_panic(expected = "rank 1 ended the run with exit code 3")]
fn abort_on_one_rank_ends_all() {
    run(3, |ranks| {
        if ranks.rank() == 1 {
            ranks.abort(3);
        }
        ranks.sum(&mut [1]);
    });
}

#[test]
#[should_panic(expected = "which has ended")]
fn a_rank_that_leaves_early_is_noticed() {
    run(2, |ranks| {
        if ranks.rank() == 0 {
            ranks.barrier();
        }
    });
}

#[test]
#[should_panic(expected = "never read a message")]
fn an_unread_message_is_noticed() {
    run(2, |ranks| {
        if ranks.rank() == 1 {
            ranks.gather(&[1, 2]);
        }
    });
}

#[test]
#[should_panic(expected = "out of step")]
fn ranks_in_different_operations_are_noticed() {
    run(2, |ranks| {
        if ranks.rank() == 0 {
            ranks.barrier();
        } else {
            ranks.all_gather(&[]);
        }
    });
}

#[test]
#[should_panic(expected = "bytes from rank")]
fn a_message_of_another_length_is_noticed() {
    run(2, |ranks| {
        let other = 1 - ranks.rank();
        ranks.exchange(&[(other, &[0; 4])], &mut [(other, &mut [0; 5])], &mut || {});
    });
}

#[test]
fn a_rank_makes_a_piece_when_rank_0_has_taken_the_one_before() {
    let (made, taken) = (AtomicUsize::new(0), AtomicUsize::new(0));
    run(4, |ranks| {
        let mut left = 50;
        let next = || {
            left -= 1;
            assert_eq!(made.fetch_add(usize::from(left > 0), Ordering::SeqCst), taken.load(Ordering::SeqCst));
            (left > 0).then(|| vec![7; 100])
        };
        let take = |_, _| -> Result<(), ()> {
            taken.fetch_add(1, Ordering::SeqCst);
            Ok(())
        };
        in_turn(&ranks, next, take).unwrap();
    });
    assert_eq!(taken.into_inner(), 4 * 49);
}
