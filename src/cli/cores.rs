//! Which cores the ranks of this run have, how many threads that makes, and words about what is wrong with it.

use std::fs;

use scree_partition::transport::Transport;

/// Where the ranks of a run are and what they have.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Placement {
    /// Threads of this rank.
    pub threads: usize,
    /// All ranks, for a person: "2 ranks of 1 thread on 2 cores".
    pub words: String,
    /// What makes it slower than it needs to be.
    pub warnings: Vec<String>,
}

/// What a rank knows about itself.
#[derive(Clone, Debug, PartialEq)]
struct Seat {
    machine: String,
    /// Numbers of the cores it may run on: all of the machine, or those that a launcher bound it to.
    cores: Vec<usize>,
    /// Of them, what limits on processor time leave.
    usable: usize,
    /// Cores of the machine that are switched on.
    online: usize,
    /// Threads that were asked for; 0: none were.
    asked: usize,
}

impl Placement {
    /// Of all ranks; collective.
    pub fn of(transport: &dyn Transport, asked: Option<u16>) -> Self {
        let mine = Seat::mine(asked.map_or(0, usize::from));
        let seats: Vec<Seat> =
            transport.all_gather(&mine.to_bytes()).iter().map(|bytes| Seat::from_bytes(bytes)).collect();
        Self::among(&seats, transport.rank())
    }

    /// Of rank `rank` among these.
    fn among(seats: &[Seat], rank: usize) -> Self {
        let threads: Vec<usize> = (0..seats.len()).map(|rank| threads_of(seats, rank)).collect();
        Self { threads: threads[rank], words: words(seats, &threads), warnings: warnings(seats, &threads) }
    }
}

impl Seat {
    fn mine(asked: usize) -> Self {
        let usable = std::thread::available_parallelism().map_or(1, usize::from);
        let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
        let allowed = status.lines().find_map(|line| line.strip_prefix("Cpus_allowed_list:")).map(numbers);
        let online = fs::read_to_string("/sys/devices/system/cpu/online").ok().map(|list| numbers(&list).len());
        let machine = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default().trim().to_string();
        let cores = allowed.filter(|cores| !cores.is_empty()).unwrap_or_else(|| (0..usable).collect());
        Self {
            machine,
            usable: usable.min(cores.len()),
            online: online.unwrap_or(usable).max(cores.len()),
            cores,
            asked,
        }
    }

    fn to_bytes(&self) -> Vec<u8> {
        let cores: Vec<String> = self.cores.iter().map(usize::to_string).collect();
        format!("{}\n{}\n{}\n{}\n{}", self.machine, cores.join(","), self.usable, self.online, self.asked).into_bytes()
    }

    fn from_bytes(bytes: &[u8]) -> Self {
        let text = String::from_utf8_lossy(bytes);
        let mut lines = text.lines();
        let machine = lines.next().unwrap_or_default().to_string();
        let cores = numbers(lines.next().unwrap_or_default());
        let mut number = || lines.next().and_then(|line| line.parse().ok()).unwrap_or(1);
        Self { machine, cores, usable: number(), online: number(), asked: number() }
    }
}

/// Numbers of a list such as `0-3,8`.
fn numbers(list: &str) -> Vec<usize> {
    let mut numbers = Vec::new();
    for part in list.trim().split(',').filter(|part| !part.is_empty()) {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        if let (Ok(first), Ok(last)) = (first.parse::<usize>(), last.parse::<usize>()) {
            numbers.extend(first..=last);
        }
    }
    numbers
}

/// Ranks on the same machine as one of them.
fn beside<'a>(seats: &'a [Seat], seat: &'a Seat) -> impl Iterator<Item = (usize, &'a Seat)> {
    seats.iter().enumerate().filter(move |(_, other)| other.machine == seat.machine)
}

/// Cores that the ranks of a machine have together.
fn cores_of(seats: &[Seat], seat: &Seat) -> usize {
    let mut all: Vec<usize> = beside(seats, seat).flat_map(|(_, other)| other.cores.iter().copied()).collect();
    all.sort_unstable();
    all.dedup();
    // A limit on processor time is one for all ranks of the machine.
    if seat.usable < seat.cores.len() { all.len().min(seat.usable) } else { all.len() }
}

/// As asked, or an equal share of the cores: a rank that was bound shares with those that were bound to the same cores.
fn threads_of(seats: &[Seat], rank: usize) -> usize {
    let seat = &seats[rank];
    if seat.asked > 0 {
        return seat.asked;
    }
    let claims = |core: &usize| beside(seats, seat).filter(|(_, other)| other.cores.contains(core)).count();
    // A sum of fractions that makes a whole number must not be rounded below it.
    let share = seat.cores.iter().map(|core| 1.0 / claims(core).max(1) as f64).sum::<f64>();
    let share = (share + 1e-9) as usize;
    let limit = if seat.usable < seat.cores.len() { seat.usable / beside(seats, seat).count() } else { share };
    share.min(limit).max(1)
}

/// "1 rank", "2 ranks".
pub(super) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn words(seats: &[Seat], threads: &[usize]) -> String {
    let (least, most) = (threads.iter().min().copied().unwrap_or(1), threads.iter().max().copied().unwrap_or(1));
    let threads = if least == most { counted(most, "thread") } else { format!("{least} to {most} threads") };
    let mut machines: Vec<&str> = seats.iter().map(|seat| seat.machine.as_str()).collect();
    machines.sort_unstable();
    machines.dedup();
    let cores: Vec<usize> = seats.iter().map(|seat| cores_of(seats, seat)).collect();
    let (fewest, largest) = (cores.iter().min().copied().unwrap_or(1), cores.iter().max().copied().unwrap_or(1));
    let place = match machines.len() {
        0 | 1 => {
            let online = seats.first().map_or(1, |seat| seat.online);
            let rest = if online > largest { format!(" of this machine's {online}") } else { String::new() };
            format!("{}{rest}", counted(largest, "core"))
        }
        count if fewest == largest => format!("{count} machines, {} each", counted(largest, "core")),
        count => format!("{count} machines, {fewest} to {largest} cores each"),
    };
    format!("{} of {threads} on {place}", counted(seats.len(), "rank"))
}

fn no_more_than(cores: usize) -> String {
    format!("no more than {}", counted(cores, "rank"))
}

fn warnings(seats: &[Seat], threads: &[usize]) -> Vec<String> {
    let bound = (0..seats.len())
        .find(|rank| threads[*rank] > seats[*rank].cores.len() && seats[*rank].online > seats[*rank].cores.len());
    if let Some(rank) = bound {
        let (seat, wanted) = (&seats[rank], threads[rank]);
        return vec![format!(
            "rank {rank} has {} but is bound to {} of its machine's {}, where they take turns. mpirun binds each of one or two ranks to a core: start it by `mpirun --map-by slot:PE={wanted}`, or `--bind-to none`; srun by `--cpus-per-task={wanted}`. Or take --threads {}.",
            counted(wanted, "thread"),
            counted(seat.cores.len(), "core"),
            seat.online,
            seat.cores.len()
        )];
    }
    let crowded = (0..seats.len()).find_map(|rank| {
        let wanted: usize = beside(seats, &seats[rank]).map(|(other, _)| threads[other]).sum();
        let cores = cores_of(seats, &seats[rank]);
        (wanted > cores).then_some((rank, wanted, cores))
    });
    crowded.map_or(Vec::new(), |(rank, wanted, cores)| {
        let ranks = beside(seats, &seats[rank]).count();
        let threads = (cores / ranks).max(1);
        // Fewer threads help where ranks have more than one alone.
        let remedy = match beside(seats, &seats[rank]).any(|(other, _)| threads_of(seats, other) > threads) {
            true if ranks > cores => format!("take {}, each with --threads 1", no_more_than(cores)),
            true => format!("take fewer ranks, or --threads {threads}"),
            false => format!("take {}", no_more_than(cores)),
        };
        vec![format!(
            "{} with {wanted} threads together share {}. They wait for each other and the run is slower than with one thread a core: {remedy}.",
            counted(ranks, "rank"),
            counted(cores, "core"),
        )]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seat(cores: &[usize], online: usize, asked: usize) -> Seat {
        Seat { machine: "one".into(), cores: cores.to_vec(), usable: cores.len(), online, asked }
    }

    #[test]
    fn lists_of_cores_are_read_and_seats_travel() {
        assert_eq!(numbers("0-3,8\n"), [0, 1, 2, 3, 8]);
        assert_eq!(numbers(""), [0_usize; 0]);
        let seat = seat(&[1, 2, 5], 8, 3);
        assert_eq!(Seat::from_bytes(&seat.to_bytes()), seat);
        let mine = Seat::mine(0);
        assert!(!mine.cores.is_empty() && mine.usable >= 1 && mine.online >= mine.cores.len());
    }

    /// Ranks that are bound have what they are bound to; ranks that are not share the machine.
    #[test]
    fn threads_are_a_share_of_the_cores_that_a_rank_has() {
        let all = [0, 1, 2, 3];
        let of = |seats: &[Seat]| (0..seats.len()).map(|rank| threads_of(seats, rank)).collect::<Vec<_>>();
        assert_eq!(of(&[seat(&all, 4, 0)]), [4]);
        assert_eq!(of(&[seat(&all, 4, 0), seat(&all, 4, 0)]), [2, 2]);
        assert_eq!(of(&[seat(&[0, 1], 4, 0), seat(&[2, 3], 4, 0)]), [2, 2]);
        assert_eq!(of(&[seat(&[0], 4, 0), seat(&[1], 4, 0)]), [1, 1]);
        assert_eq!(of(&vec![seat(&[0, 1], 2, 0); 3]), [1, 1, 1]);
        let many: Vec<usize> = (0..64).collect();
        assert_eq!(of(&vec![seat(&many, 64, 0); 32]), [2; 32]);
        assert_eq!(of(&[seat(&[0], 4, 3)]), [3]);
        // Six cores and processor time for two.
        assert_eq!(of(&[Seat { usable: 2, ..seat(&[0, 1, 2, 3, 4, 5], 6, 0) }]), [2]);
    }

    #[test]
    fn the_words_count_ranks_threads_and_cores() {
        let words = |seats: &[Seat]| Placement::among(seats, 0).words;
        assert_eq!(words(&[seat(&[0, 1], 2, 0)]), "1 rank of 2 threads on 2 cores");
        assert_eq!(words(&[seat(&[0], 2, 0)]), "1 rank of 1 thread on 1 core of this machine's 2");
        assert_eq!(words(&[seat(&[0], 2, 0), seat(&[1], 2, 0)]), "2 ranks of 1 thread on 2 cores");
        let far = Seat { machine: "two".into(), ..seat(&[0, 1], 2, 0) };
        assert_eq!(words(&[seat(&[0, 1], 2, 0), far]), "2 ranks of 2 threads on 2 machines, 2 cores each");
    }

    /// mpirun binds a single rank to one core, which two threads would share while another core idles.
    #[test]
    fn threads_that_share_a_core_are_told() {
        let warnings = |seats: &[Seat]| Placement::among(seats, 0).warnings.join(" ");
        let bound = warnings(&[seat(&[0], 2, 2)]);
        assert!(bound.contains("rank 0 has 2 threads but is bound to 1 core of its machine's 2"), "{bound}");
        assert!(
            bound.contains("--map-by slot:PE=2`, or `--bind-to none`") && bound.contains("--cpus-per-task=2"),
            "{bound}"
        );
        let crowded = warnings(&vec![seat(&[0, 1], 2, 0); 4]);
        assert!(crowded.contains("4 ranks with 4 threads together share 2 cores"), "{crowded}");
        assert!(crowded.ends_with("a core: take no more than 2 ranks."), "{crowded}");
        let crowded = warnings(&vec![seat(&[0, 1], 2, 2); 2]);
        assert!(
            crowded.contains("2 ranks with 4 threads together share 2 cores") && crowded.contains("--threads 1"),
            "{crowded}"
        );
        assert_eq!(warnings(&[seat(&[0, 1], 2, 2)]), "");
        assert_eq!(warnings(&[seat(&[0], 2, 0), seat(&[1], 2, 0)]), "");
        // Nothing else is there to be bound to.
        assert!(warnings(&[seat(&[0], 1, 2)]).contains("1 rank with 2 threads together share 1 core."));
    }
}
