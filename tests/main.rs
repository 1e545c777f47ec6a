//! The index of what is claimed about the program, one line a claim. One binary, so that linking is paid once.

/// Wrong assemblies of grains are refused before any work, each with what is allowed and what to do.
mod bad_assemblies;
/// Wrong continua are refused before any work, each with what is allowed and what to do.
mod bad_continua;
/// Wrong jobs of planar shear are refused before any work, with file, line, value and remedy; exit code 2.
mod bad_shear;
/// Blocks follow the work that is measured: a bad deal is mended once, and a good one is kept.
mod balance;
/// Grains and rigid bodies: balances to round-off, mirrored bounces, held forces, paths, and spins that drive.
mod bodies;
/// Stress of the start outside of the cone and softening without a return are refused; the law bears what is not.
mod borne;
/// Calibration finds the law that made its data, and a small one gives a fragment that a job takes, twice the same.
mod calibrate;
/// Every job, checkpoint and run in `tests/bad_jobs/` is refused with exit code 2 and the message that stands beside it.
mod catalogue;
/// Cells that are periodic and deform: mean stress, affine motion, images across sheared faces, control of stress.
mod cells;
/// A free cluster keeps momentum and angular momentum, and every width of registers gives the same bits, under every law
/// in both spaces.
mod clusters;
/// Collisions and pull-off under every law: restitution, Hertz' duration and depth, cohesion, to closed forms.
mod collisions;
/// A hybrid of planar shear draws the curve that grains alone draw, through an enrichment that loses nothing.
mod comparison;
/// Mass and momentum of a run are what they were at its start and what has been given since, and its summary says so.
mod conservation;
/// A run that starts from the exported grains and contacts of another goes on as that one did; wrong files are refused by line.
mod contact_files;
/// What jobs of continua mean, key by key, and that writing and reading them again changes nothing.
mod continua;
/// Grains in membranes, alone and where points were: none leaks, momentum is kept, the same bits on any ranks and after a restart.
mod coupled;
/// Grains and points that share nodes keep their momentum to round-off, leave with one velocity, and translate rigidly; and the
/// grains' account of energy closes with what nodes do.
mod coupling;
/// Several steps of grains in one of the continuum keep momentum, and draw the curve that single steps draw.
mod cycles;
/// Nodes with next to no mass put no energy into a body under any scheme that is accepted; the others are refused.
mod empty_nodes;
/// A failure on all ranks, or on one other than the first, ends all within seconds, and its message is there once.
mod ends;
/// The account of a continuum's energy closes by what each scheme is known to lose, on any number of ranks and after resume.
mod energies;
/// Enrichment keeps mass and momentum to round-off; zones, rims and the choice of grains are what they are said to be.
mod enrichment;
/// Continua against exact solutions under every scheme: waves, columns, slides, balances, turns, with orders.
mod exact;
/// Disks that fill up and folders that go away end a run once, with the file and the reason; it goes on to the same end.
mod faults;
/// Worlds of a few grains alone that the tests of the grain engine share; it claims nothing itself.
mod few;
/// Nothing of a user's is ever lost: a run owns its folder and touches nothing else, whoever is killed leaves one that can go on,
/// and runs share packings.
mod folders;
/// Frames, contacts as lines and dumps of grains tell of one stress, are read by VTK, and are the same on any ranks.
mod frame_files;
/// A loaded contact that is carried along by a rigid motion keeps its force in the moving frame, under every law.
mod frames;
/// Short jobs of every kind end in the bits that they have always ended in: state, series and frames.
mod gate;
/// A grain that strikes a wall at any angle and with any spin gains no energy, under every law in both spaces.
mod grazing;
/// A run that has left physics stops and names the two that show it: grains, or a grain and a body.
mod guard;
/// Bodies that hold nodes bear what rests on them, keep the stress that they are to keep, and carry across periods.
mod held_nodes;
/// Stress of a cell is held where it is dense, soft, of spheres or without contacts, and a row of its series is of one instant.
mod held_stress;
/// Checkpoints of any bytes and of any tables are refused or are what they were: no panic, no hang, no memory without bound.
mod hostile_checkpoints;
/// Jobs of any bytes, and good jobs with one thing changed, are read or refused: no panic, no hang, no memory without bound.
mod hostile_jobs;
/// What a run leaves tells its program and its run; runs of former programs are gone on with; the schema is that of the columns.
mod identity;
/// Discs and spheres roll, slide and come to rest on planes as closed forms say, under every law.
mod inclines;
/// A plate pressed into a bed under gravity: bands on both sides of it are found and enriched up to the ground.
mod indentation;
/// Grains, continuum and hybrid end in the same bits on 1 to 4 ranks in one process, and from any of their checkpoints.
mod invariance;
/// Every job in `jobs/` is read, and its resolved form means the same.
mod jobs;
/// Hybrids of jobs too large for grains alone, in small: grains of a known band come from pieces of packing.
mod large;
/// Every material law in both spaces: many turns, large stretch, returns from random states, energies, starts.
mod laws;
/// Strip footings bear what Prandtl says, less what their few cells cost, on a load that stays flat.
mod limit_loads;
/// The continuum's law on uniaxial, shear and separating paths against closed forms, and under superposed rotation.
mod material;
/// Membranes bear their hoop tension and press on what they hold, keep momentum, and have the same bits on any ranks.
mod membranes;
/// The quickstart has the same digest and curve on 1 to 4 ranks, 1 and 2 threads, and through SIGTERM and resume.
mod mpirun;
/// A job to begin with runs at the first try, and the example of the README as printed; mistakes come all at once; keys explain themselves.
mod newcomer;
/// The oracle fires on an over-consolidated specimen, in its band only, and at the same strain at twice the speed; it
/// is silent on an under-consolidated one, beside plates, and on bands that do not persist; in a membrane it flags the diagonal
/// band and nothing else.
mod oracle;
/// Uniform stress stays uniform under every scheme, between walls too, and a linear velocity has one gradient.
mod patches;
/// Checkpoints that ranks hand over in pieces are the whole state, and a full disk ends all ranks with its message.
mod pieces;
/// A plan made from a run on one rank has the messages, bytes and loads of one on four; uniform blocks as by hand.
mod plans;
/// A pressure pulse through the rim of a zone: next to nothing of it comes back.
mod pulses;
/// One line starts a job and goes on with it, by the scripts for Slurm too, with and without mpirun.
mod queues;
/// Worlds made at random end in the same bits however many ranks hold them and however blocks are dealt between steps.
mod random_worlds;
/// A job that is right, broken in one place, and its refusal, which the tests of wrong jobs share; it claims nothing itself.
mod refusals;
/// Records of LAMMPS and YADE are repeated to round-off: collisions, a relaxing packing, a sheared cell.
mod replay;
/// A face-centred cubic array of spheres under triaxial compression bears 2 (1 + mu)/(1 - mu) of its lateral stress.
mod rowe;
/// Runs from the text of a job, and one job on other ranks and threads, that the tests below share; it claims nothing itself.
mod runs;
/// Every contact law, in the plane and in space, has the same bits on 1 to 4 ranks, 1 and 2 threads, and after resume.
mod same_bits;
/// A sample of grains that steps by itself, without ranks, is a world of one rank to the bit.
mod samples;
/// `scree bench scaling` measures jobs on several numbers of ranks, from a checkpoint on and wider, and leaves a page.
mod scaling;
/// Every scheme of the continuum, in the plane and in space, has the same bits on 1 to 4 ranks, 1 and 2 threads, with any
/// instructions, and after resume.
mod scheme_bits;
mod seams;
/// Points that are inverted, torn, no numbers, too fast for the step or outside of the grid stop the run with their id.
mod spoilt_points;
/// A packing in the making says how far it is, and stops when asked to, on one rank as on two; a run that stops itself
/// names its newest checkpoint.
mod stops;
/// The style that no compiler holds: one door to inexact mathematics, no ranks in physics, short files.
mod tidy;
/// Words that nobody can read end no run; signals that come early are heard; reports open runs that are alive or were killed;
/// exports are of the time that was asked for.
mod told;
/// Runs of four kinds that are killed, in their writing and packings too, unheard and damaged again and again end in the same bits,
/// or say which file is to blame.
mod torture;
/// Two grains: the damped oscillator's closed form, linear and angular momentum, and LAMMPS' record of two collisions.
mod two_grains;
/// A ring that is sheared to and fro inside a resting square by the body force that this takes: order 2 in the plane.
mod vortex;
/// Checkpoints and ends by signal, file and limit of time, whoever hears of it first; other ends and outputs for a run that goes
/// on; branches. None of it moves a bit of the state.
mod wishes;
/// Small worlds and short jobs that the tests below share; it claims nothing itself.
mod worlds;
/// A zone grows where the band goes and gives grains at rest back, with mass and momentum kept and the same bits on any ranks.
mod zones;
