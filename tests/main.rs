//! The index of what is claimed about the program, one line a claim, by topic. One binary, so that linking is paid once.

// Laws, schemes and bodies against closed forms, other codes and exact balances.

/// Volume strain averaged as material flows ends the noise of points at rest, is booked, and leaves elastic material alone to the bit.
#[path = "physics/averaging.rs"]
mod averaging;
/// Grains and rigid bodies: balances to round-off, mirrored bounces, held forces, paths, and spins that drive.
#[path = "physics/bodies.rs"]
mod bodies;
/// Stress of the start outside of the cone and softening without a return are refused; the law bears what is not.
#[path = "physics/borne.rs"]
mod borne;
/// Cells that are periodic and deform: mean stress, affine motion, images across sheared faces, control of stress.
#[path = "physics/cells.rs"]
mod cells;
/// A free cluster keeps momentum and angular momentum, and every width of registers gives the same bits, under every law
/// in both spaces.
#[path = "physics/clusters.rs"]
mod clusters;
/// Collisions and pull-off under every law: restitution, Hertz' duration and depth, cohesion, to closed forms.
#[path = "physics/collisions.rs"]
mod collisions;
/// Continua of elements: states at rest, waves, bending, turns, sides on plates, accounts, the same bits.
#[path = "physics/elements.rs"]
mod elements;
/// Nodes with next to no mass put no energy into a body under any scheme that is accepted; the others are refused.
#[path = "physics/empty_nodes.rs"]
mod empty_nodes;
/// The account of a continuum's energy closes by what each scheme is known to lose, on any number of ranks and after resume.
#[path = "physics/energies.rs"]
mod energies;
/// Continua against exact solutions under every scheme: waves, columns, slides, balances, turns, with orders.
#[path = "physics/exact.rs"]
mod exact;
/// Bodies that meet points at their own face: uniform states, loads over cells, momentum, friction, parting.
#[path = "physics/faces.rs"]
mod faces;
/// The same of round bodies and planes askew to the grid: uniform states, Hertz' contact, slopes, parting, momentum, bits.
#[path = "physics/faces_askew.rs"]
mod faces_askew;
/// A loaded contact that is carried along by a rigid motion keeps its force in the moving frame, under every law.
#[path = "physics/frames.rs"]
mod frames;
/// A grain that strikes a wall at any angle and with any spin gains no energy, under every law in both spaces.
#[path = "physics/grazing.rs"]
mod grazing;
/// Bodies that hold nodes bear what rests on them, keep the stress that they are to keep, and carry across periods.
#[path = "physics/held_nodes.rs"]
mod held_nodes;
/// Stress of a cell is held where it is dense, soft, of spheres or without contacts, and a row of its series is of one instant.
#[path = "physics/held_stress.rs"]
mod held_stress;
/// Discs and spheres roll, slide and equilibrate on planes as closed forms say, under every law.
#[path = "physics/inclines.rs"]
mod inclines;
/// Every material law in both spaces: many turns, large stretch, returns from random states, energies, starts.
#[path = "physics/laws.rs"]
mod laws;
/// Strip footings bear what Prandtl says, less what their few cells cost, on a load that stays flat.
#[path = "physics/limit_loads.rs"]
mod limit_loads;
/// The continuum's law on uniaxial, shear and separating paths against closed forms, and under superposed rotation.
#[path = "physics/material.rs"]
mod material;
/// Membranes bear their hoop tension and press on what they hold, keep momentum, and have the same bits on any ranks.
#[path = "physics/membranes.rs"]
mod membranes;
/// Meshes of files: distorted patches, order of convergence, Cook's membrane, physical groups, the same bits without the file.
#[path = "physics/meshes.rs"]
mod meshes;
/// Uniform stress stays uniform under every scheme, between walls too, and a linear velocity has one gradient.
#[path = "physics/patches.rs"]
mod patches;
/// Records of LAMMPS and YADE are repeated to round-off: collisions, a relaxing packing, a sheared cell.
#[path = "physics/replay.rs"]
mod replay;
/// A face-centred cubic array of spheres under triaxial compression bears 2 (1 + mu)/(1 - mu) of its lateral stress.
#[path = "physics/rowe.rs"]
mod rowe;
/// Representative volume elements go along with F: turns, shear, affine steps, separation, cells that get thin.
#[path = "physics/rve.rs"]
mod rve;
/// A sample of grains that steps by itself, without ranks, is a world of one rank to the bit.
#[path = "physics/samples.rs"]
mod samples;
/// A contact law, a material law and a method are added in one file of a test, by what the library makes public.
#[path = "physics/seams.rs"]
mod seams;
/// Loads on the surface of the material: in balance with its own stress wherever in a cell that is, and all there.
#[path = "physics/surface_loads.rs"]
mod surface_loads;
/// Two grains: the damped oscillator's closed form, linear and angular momentum, and LAMMPS' record of two collisions.
#[path = "physics/two_grains.rs"]
mod two_grains;
/// A ring that is sheared to and fro inside a resting square by the body force that this takes: order 2 in the plane.
#[path = "physics/vortex.rs"]
mod vortex;

// Grains and continuum together.

/// The element test of an RVE by itself.
#[path = "coupling/alone.rs"]
mod alone;
/// Elements that carry grain assemblies: their RVEs are those that stand alone, a weak row, and the same bits.
#[path = "coupling/fem_dem.rs"]
mod fem_dem;
/// Material points that carry grain assemblies.
#[path = "coupling/mpm_dem.rs"]
mod mpm_dem;

/// The experiments of Liang & Zhao (2019), made small.
#[path = "coupling/mpm_dem_jobs.rs"]
mod mpm_dem_jobs;

/// A hybrid of planar shear draws the curve that grains alone draw, through an enrichment that loses nothing.
#[path = "coupling/comparison.rs"]
mod comparison;
/// Grains in membranes, alone and where points were: none leaks, momentum is kept, the same bits on any ranks and after a restart.
#[path = "coupling/coupled.rs"]
mod coupled;
/// Grains and points that share nodes keep their momentum to round-off, leave with one velocity, and translate rigidly; and the
/// grains' account of energy closes with what nodes do.
#[path = "coupling/coupling.rs"]
mod coupling;
/// Several steps of grains in one of the continuum keep momentum, and draw the curve that single steps draw.
#[path = "coupling/cycles.rs"]
mod cycles;
/// Enrichment keeps mass and momentum to round-off; zones, rims and the choice of grains are what they are said to be.
#[path = "coupling/enrichment.rs"]
mod enrichment;
/// A plate pressed into a bed under gravity: bands on both sides of it are found and enriched up to the ground.
#[path = "coupling/indentation.rs"]
mod indentation;
/// Hybrids of jobs too large for grains alone, in small: grains of a known band come from pieces of packing.
#[path = "coupling/large.rs"]
mod large;
/// The oracle fires on an over-consolidated specimen, in its band only, and at the same strain at twice the speed; it
/// is silent on an under-consolidated one, beside plates, and on bands that do not persist; in a membrane it flags the diagonal
/// band and nothing else.
#[path = "coupling/oracle.rs"]
mod oracle;
/// Pieces of packing are joined across the periods of a grid, as dense and as firm there as elsewhere, and jobs of them, hybrids too, have
/// the same bits on any ranks.
#[path = "coupling/periods.rs"]
mod periods;
/// A pressure pulse through the rim of a zone: next to nothing of it comes back.
#[path = "coupling/pulses.rs"]
mod pulses;
/// Grains that have turned into points come back as they stood where cells shear, with mass and momentum kept and the same bits on any ranks.
#[path = "coupling/returns.rs"]
mod returns;
/// A zone grows where the band goes and gives grains at rest back, with mass and momentum kept and the same bits on any ranks.
#[path = "coupling/zones.rs"]
mod zones;

// The same bits on any number of ranks and threads, and what is kept.

/// Blocks follow the work that is measured: a bad deal is mended once, and a good one is kept.
#[path = "invariance/balance.rs"]
mod balance;
/// Mass and momentum of a run are what they were at its start and what has been given since, and its summary says so.
#[path = "invariance/conservation.rs"]
mod conservation;
/// Short jobs of every kind end in the bits that they have always ended in: state, series and frames.
#[path = "invariance/gate.rs"]
mod gate;
/// Grains, continuum and hybrid end in the same bits on 1 to 4 ranks in one process, and from any of their checkpoints.
#[path = "invariance/invariance.rs"]
mod invariance;
/// The quickstart has the same digest and curve on 1 to 4 ranks, 1 and 2 threads, and through SIGTERM and resume.
#[path = "invariance/mpirun.rs"]
mod mpirun;
/// A plan made from a run on one rank has the messages, bytes and loads of one on four; uniform blocks as by hand.
#[path = "invariance/plans.rs"]
mod plans;
/// Worlds made at random end in the same bits however many ranks hold them and however blocks are dealt between steps.
#[path = "invariance/random_worlds.rs"]
mod random_worlds;
/// Every contact law, in the plane and in space, has the same bits on 1 to 4 ranks, 1 and 2 threads, and after resume.
#[path = "invariance/same_bits.rs"]
mod same_bits;
/// Every scheme of the continuum, in the plane and in space, has the same bits on 1 to 4 ranks, 1 and 2 threads, with any
/// instructions, and after resume.
#[path = "invariance/scheme_bits.rs"]
mod scheme_bits;

// Runs that stop, go on, branch, and read what others left.

/// A run that starts from the exported grains and contacts of another goes on as that one did; wrong files are refused by line.
#[path = "restart/contact_files.rs"]
mod contact_files;
/// What a run leaves tells its program and its run; runs of former programs are gone on with; the schema is that of the columns.
#[path = "restart/identity.rs"]
mod identity;
/// Checkpoints that ranks hand over in pieces are the whole state, and a full disk ends all ranks with its message.
#[path = "restart/pieces.rs"]
mod pieces;
/// One line starts a job and goes on with it, by the scripts for Slurm too, with and without mpirun.
#[path = "restart/queues.rs"]
mod queues;
/// A packing in the making says how far it is, and stops when asked to, on one rank as on two; a run that stops itself
/// names its newest checkpoint.
#[path = "restart/stops.rs"]
mod stops;
/// Checkpoints and ends by signal, file and limit of time, whoever hears of it first; other ends and outputs for a run that goes
/// on; branches. None of it moves a bit of the state.
#[path = "restart/wishes.rs"]
mod wishes;

// What a job may say, and what it is told.

/// Wrong assemblies of grains are refused before any work, each with what is allowed and what to do.
#[path = "input/bad_assemblies.rs"]
mod bad_assemblies;
/// Wrong continua are refused before any work, each with what is allowed and what to do.
#[path = "input/bad_continua.rs"]
mod bad_continua;
/// Wrong jobs of planar shear are refused before any work, with file, line, value and remedy; exit code 2.
#[path = "input/bad_shear.rs"]
mod bad_shear;
/// Every job, checkpoint and run in `tests/bad_jobs/` is refused with exit code 2 and the message that stands beside it.
#[path = "input/catalogue.rs"]
mod catalogue;
/// What jobs of continua mean, key by key, and that writing and reading them again changes nothing.
#[path = "input/continua.rs"]
mod continua;
/// The first hour of the handbook runs as printed: jobs, reports, restarts, two ranks, Python.
#[path = "input/first_hour.rs"]
mod first_hour;
/// Jobs of any bytes, and good jobs with one thing changed, are read or refused: no panic, no hang, no memory without bound.
#[path = "input/hostile_jobs.rs"]
mod hostile_jobs;
/// The commands of the how-tos run as printed.
#[path = "input/howtos.rs"]
mod howtos;
/// Every job in `jobs/` is read, and its resolved form means the same.
#[path = "input/jobs.rs"]
mod jobs;
/// A job to begin with runs at the first try, and the example of the handbook as printed; mistakes come all at once; keys explain themselves.
#[path = "input/newcomer.rs"]
mod newcomer;
/// Every link of every page leads somewhere, the contents of the handbook name all of its pages, and the theory names files that exist.
#[path = "input/pages.rs"]
mod pages;
/// A newcomer's shell, into which the handbook is typed.
#[path = "input/shell.rs"]
mod shell;

// Whatever may go wrong on a machine or in a run.

/// A failure on all ranks, or on one other than the first, ends all within seconds, and its message is there once.
#[path = "faults/ends.rs"]
mod ends;
/// Disks that fill up and folders that go away end a run once, with the file and the reason; it goes on to the same end.
#[path = "faults/faults.rs"]
mod faults;
/// Nothing of a user's is ever lost: a run owns its folder and touches nothing else, whoever is killed leaves one that can go on,
/// and runs share packings.
#[path = "faults/folders.rs"]
mod folders;
/// A run that has left physics stops and names the two that show it: grains, or a grain and a body.
#[path = "faults/guard.rs"]
mod guard;
/// Checkpoints of any bytes and of any tables are refused or are what they were: no panic, no hang, no memory without bound.
#[path = "faults/hostile_checkpoints.rs"]
mod hostile_checkpoints;
/// Points that are inverted, torn, no numbers, too fast for the step or outside of the grid stop the run with their id.
#[path = "faults/spoilt_points.rs"]
mod spoilt_points;
/// Runs of four kinds that are killed, in their writing and packings too, unheard and damaged again and again end in the same bits,
/// or say which file is to blame.
#[path = "faults/torture.rs"]
mod torture;

// What commands write, and how the source is kept.

/// Calibration finds the law that made its data, and a small one gives a fragment that a job takes, twice the same.
#[path = "cli/calibrate.rs"]
mod calibrate;
/// Frames, contacts as lines and dumps of grains tell of one stress, are read by VTK, and are the same on any ranks.
#[path = "cli/frame_files.rs"]
mod frame_files;
/// The Python package reads runs as the program wrote them, to the bit, and starts some.
#[path = "cli/python.rs"]
mod python;
/// `scree bench scaling` measures jobs on several numbers of ranks, from a checkpoint on and wider, and leaves a page.
#[path = "cli/scaling.rs"]
mod scaling;
/// `scree sweep` runs a job with many values, marks what fails, and goes on after kills; its table and report tell means of packings.
#[path = "cli/sweep.rs"]
mod sweep;
/// The style that no compiler holds: one door to inexact mathematics, no ranks in physics, short files.
#[path = "cli/tidy.rs"]
mod tidy;
/// Words that nobody can read end no run; signals that come early are heard; reports open runs that are alive or were killed;
/// exports are of the time that was asked for.
#[path = "cli/told.rs"]
mod told;

// What tests share.

/// Worlds of a few grains alone that the tests of the grain engine share; it claims nothing itself.
mod few;
/// A job that is right, broken in one place, and its refusal, which the tests of wrong jobs share; it claims nothing itself.
mod refusals;
/// Runs from the text of a job, and one job on other ranks and threads, that the tests below share; it claims nothing itself.
mod runs;
/// Small worlds and short jobs that the tests below share; it claims nothing itself.
mod worlds;
