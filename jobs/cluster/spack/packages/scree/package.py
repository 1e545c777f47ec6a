# A recipe for Spack 0.22 and newer. From the folder of the project:
#
#     spack repo add jobs/cluster/spack
#     spack dev-build --source-path . scree@develop            # with the cluster's MPI: scree@develop ^openmpi, ^mpich, ^intel-oneapi-mpi
#     spack load scree
#
# Where Spack has no Rust so new: `spack external find rust`, after rustup has installed it.

from spack.package import *


class Scree(Package):
    """Granular matter under mpirun: grains (DEM), continuum (MPM, FEM), and the two coupled where shear localises."""

    has_code = True

    license("MIT OR Apache-2.0", checked_by="the scree developers")

    # The folder that dev-build is given.
    version("develop")

    variant("mpi", default=True, description="Several ranks under mpirun; without it threads on one machine")

    depends_on("c", type="build")
    depends_on("rust@1.89:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("hdf5@1.10: +shared")
    depends_on("mpi", when="+mpi")
    # The bindings to MPI are made from its headers.
    depends_on("llvm +clang", type="build", when="+mpi")

    def setup_build_environment(self, env):
        env.set("HDF5_DIR", self.spec["hdf5"].prefix)
        if self.spec.satisfies("+mpi"):
            env.set("MPICC", self.spec["mpi"].mpicc)
            env.set("LIBCLANG_PATH", self.spec["llvm"].prefix.lib)

    def install(self, spec, prefix):
        cargo = which("cargo", required=True)
        options = ["--path", ".", "--root", prefix, "--locked", "--profile", "dist"]
        if spec.satisfies("~mpi"):
            options.append("--no-default-features")
        cargo("install", *options)
        install_tree("jobs", prefix.share.scree.jobs)

    @run_after("install")
    @on_package_attributes(run_tests=True)
    def check_a_job(self):
        scree = Executable(self.prefix.bin.scree)
        scree("--version")
        scree("check", join_path(self.prefix.share.scree.jobs, "quickstart.toml"))
