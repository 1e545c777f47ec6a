"""The package against runs of the program, which SCREE names; without it these tests are skipped."""

import csv
import importlib
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

import scree

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = os.environ.get("SCREE")

#: Discs that are sheared in a periodic cell.
JOB = """
name = "cell"
seed = 3
[cell]
space = "plane"
upper = ["22 mm", "22 mm"]
periodic = [true, true]
velocity_gradient = [[0, 20], [0, 0]]
[grains]
density = 2650
count = 400
diameter_mean = "1 mm"
diameter_deviation = "0.1 mm"
[packing]
preparation = "compress"
stress = "100 kPa"
energy_ratio_max = 1e-2
cache = "cache"
[contact]
stiffness_normal = 1e5
stiffness_tangential = 5e4
damping_normal = 0.5
damping_tangential = 0.5
friction = 0.5
[time]
step = "1 us"
end = "2 ms"
[output]
series_interval = "0.1 ms"
frame_interval = "1 ms"
checkpoint_interval = "1 ms"
contact_frames = true
"""


UNITS = {"1", "s", "m", "m/s", "m3", "rad", "rad/s", "kg", "N", "N m", "N s", "J", "Pa"}


class Units(unittest.TestCase):
    def test_the_page_in_the_package_is_that_of_the_documentation(self):
        self.assertEqual((ROOT / "docs/columns.md").read_text(), (ROOT / "io/python/scree/columns.md").read_text())

    def test_columns_have_their_units(self):
        wanted = {"time": "s", "stress_xy": "Pa", "plate_force_y": "N", "base_displacement_x": "m", "grains": "1", "shear_stress": "Pa", "edge_xx": "m", "A_void_ratio": "1"}
        self.assertEqual({name: scree.unit_of(name) for name in wanted}, wanted)
        self.assertIsNone(scree.unit_of("nobody"))

    def test_every_column_of_the_page_has_a_unit(self):
        from scree.units import _table

        self.assertEqual({unit for _, unit in _table()} - UNITS, set())
        self.assertEqual([scree.unit_of(name) for name in ("work_bodies", "energy_stored", "stress_error_yy", "points_dissipated")], ["J", "J", "Pa", "J"])


def imported(test, name):
    """A package that a test can do without."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        return test.skipTest(f"there is no {name}")


#: A block of elements that is pulled.
ELEMENTS = """
name = "block"
[mesh]
space = "plane"
upper = ["1 m", "50 cm"]
elements = [4, 2]
[material]
law = "hencky"
density = "2000 kg/m3"
young_modulus = "10 MPa"
poisson_ratio = 0.3
[gravity]
acceleration = [0, "-9.81 m/s2"]
[[region]]
shape = "box"
lower = [0, 0]
upper = ["1 m", "50 cm"]
[[boundary]]
face = "x_upper"
kind = "free"
[[boundary]]
face = "y_upper"
kind = "free"
[time]
end = "10 ms"
[output]
frame_interval = "10 ms"
"""


class Quantities(unittest.TestCase):
    def test_pressure_and_deviator_of_the_plane_and_of_space(self):
        self.assertEqual(scree.pressure(np.array([-3.0, -1.0, 0.5])), 2.0)
        self.assertAlmostEqual(scree.deviatoric_stress(np.array([-3.0, -1.0, 1.0])), 2**0.5)
        # xx, yy, xy, zz, yz, xz. Compressed along z: q is the difference of the axial and the lateral stress.
        self.assertAlmostEqual(scree.deviatoric_stress(np.array([-1.0, -1.0, 0.0, -4.0, 0.0, 0.0])), 3.0)
        self.assertAlmostEqual(scree.pressure(np.array([-1.0, -2.0, 0.5, -3.0, 0.0, 0.0])), 2.0)
        for shear in (2, 4, 5):
            stress = np.zeros(6)
            stress[shear] = 2.0
            self.assertAlmostEqual(scree.deviatoric_stress(stress), 12**0.5)
        with self.assertRaises(ValueError):
            scree.pressure(np.zeros(4))

    def test_curves_of_several_runs_have_a_mean_and_its_error(self):
        x = np.linspace(0, 1, 11)
        table = scree.mean_curve([(x, x), (x, 3 * x), (x[:6], 2 * x[:6])], np.array([0.25, 0.75]))
        self.assertAlmostEqual(table["mean"].iloc[0], 0.5)
        self.assertAlmostEqual(table["error"].iloc[0], 0.25 / 3**0.5)
        self.assertTrue(np.isnan(table["mean"].iloc[1]))


@unittest.skipUnless(PROGRAM, "SCREE names no program")
class CoarseGrained(unittest.TestCase):
    """Fields of rows whose fields are known."""

    DEPTH = 0.01

    def frame(self, edges, periodic, counts, velocity):
        """A lattice of material points in a cell of the plane."""
        index = np.stack(np.meshgrid(*(np.arange(count) + 0.5 for count in counts), indexing="ij"), axis=-1).reshape(-1, 2)
        places = np.zeros((len(index), 3))
        places[:, :2] = (index / counts) @ np.array(edges)
        area = abs(np.linalg.det(edges)) / np.prod(counts)
        rows = len(places)
        fields = {
            "kind": np.zeros(rows, dtype=int), "weight": np.ones(rows), "mass": np.full(rows, 2000 * area * self.DEPTH), "radius": np.full(rows, np.sqrt(area / np.pi)),
            "velocity": velocity(places), "stress": np.tile([-1e3, -2e3, 3e2], (rows, 1)), "fraction": np.full(rows, 0.8),
        }
        whole = np.zeros((3, 3))
        whole[:2, :2], whole[2, 2] = edges, self.DEPTH
        cell = {"cell_corner": np.array([0, 0, -0.5 * self.DEPTH]), "cell_edges": whole.ravel(), "cell_periodic": np.array([*periodic, 0])}
        return scree.Frame(0.5, places[:, None, :], fields, cell)

    def test_uniform_matter_and_its_velocity_gradient_come_out(self):
        gradient = np.array([[1.0, 2.0], [-3.0, 0.5]])
        frame = self.frame([[40e-3, 0], [0, 30e-3]], [0, 0], [80, 60], lambda x: np.column_stack([x[:, :2] @ gradient.T, 0 * x[:, 0]]))
        fields = scree.coarse_grain(frame, 1e-3)
        self.assertAlmostEqual(fields.total("density") / frame["mass"].sum(), 1, delta=1e-13)
        at = fields.lattice.points
        inside = (at[..., 0] > 4e-3) & (at[..., 0] < 36e-3) & (at[..., 1] > 4e-3) & (at[..., 1] < 26e-3)
        for name, wanted in {"density": 2000, "fraction": 0.8, "stress": [-1e3, -2e3, 3e2], "velocity_gradient": gradient.ravel()}.items():
            np.testing.assert_allclose(fields[name][inside], np.broadcast_to(wanted, fields[name][inside].shape), rtol=1e-10)
        np.testing.assert_allclose(fields["velocity"][inside], at[inside] @ gradient.T, atol=1e-12)
        np.testing.assert_allclose(fields.strain_rate[inside], np.broadcast_to([1.0, 0.5, -0.5], (*fields["density"][inside].shape, 3)), rtol=1e-9)

    def test_a_sheared_periodic_cell_has_no_border(self):
        frame = self.frame([[40e-3, 0], [12e-3, 30e-3]], [1, 1], [80, 65], lambda x: np.tile([0.1, -0.2, 0.0], (len(x), 1)))
        fields = scree.coarse_grain(frame, 1e-3)
        np.testing.assert_allclose(fields["density"], 2000, rtol=1e-10)
        np.testing.assert_allclose(fields["velocity"], np.broadcast_to([0.1, -0.2], fields["velocity"].shape), rtol=1e-10)
        np.testing.assert_allclose(fields["velocity_gradient"], 0, atol=1e-10)
        np.testing.assert_allclose(fields["temperature"], 0, atol=1e-15)
        with self.assertRaises(ValueError):
            scree.write_images("never.vtkhdf", [fields])


class Runs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.job = Path(cls.folder.name) / "job.toml"
        cls.job.write_text(JOB)
        cls.run_of = scree.run(cls.job, {"cell.velocity_gradient": [[0, 25.0], [0, 0]]}, out=Path(cls.folder.name) / "run", program=PROGRAM, threads=1)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_series_are_the_numbers_of_the_file(self):
        with open(self.run_of.folder / "series.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(list(self.run_of.series.columns), list(rows[0]))
        for name in rows[0]:
            self.assertEqual([float(row[name]) for row in rows], list(self.run_of.series[name]), name)
            self.assertIn(self.run_of.units[name], UNITS, name)
        self.assertEqual(self.run_of.job["cell"]["velocity_gradient"][0][1], 25.0)
        self.assertEqual(self.run_of.summary["outcome"], "done")
        self.assertEqual(self.run_of.events("started")[0]["grains"], 400)

    def test_frames_are_those_of_the_file(self):
        frames = self.run_of.frames
        self.assertTrue(np.allclose(frames.times, [0, 1e-3, 2e-3], atol=1e-6))
        with h5py.File(frames.path) as file:
            positions, velocities = file["VTKHDF/Points"][:], file["VTKHDF/PointData/velocity"][:]
        for index, frame in enumerate(frames):
            self.assertEqual(len(frame.grains), 400)
            rows = slice(400 * index, 400 * (index + 1))
            np.testing.assert_array_equal(frame.places[:, 0], positions[rows])
            np.testing.assert_array_equal(frame["velocity"], velocities[rows])
        self.assertEqual(frames.at(0.9e-3).time, frames.times[1])
        self.assertEqual(len(frames[-1].points), 0)
        self.assertEqual([frame.time for frame in frames[1:]], list(frames.times[1:]))

    def test_frames_tell_what_they_are_and_whose(self):
        for frames in (self.run_of.frames, self.run_of.contacts):
            self.assertEqual((set(frames.units), set(frames.meanings)), (set(frames.names), set(frames.names)))
            self.assertLessEqual(set(frames.units.values()), UNITS)
        self.assertEqual((self.run_of.frames.units["velocity"], self.run_of.contacts.units["force"]), ("m/s", "N"))
        begun = self.run_of.events("started")[0]
        provenance = self.run_of.frames.provenance
        self.assertEqual((provenance["program"], provenance["job"]), (begun["program"], begun["job"]))

    def test_exports_are_read_by_the_programs_they_are_for(self):
        """Frames for ParaView before 5.12 by VTK's oldest reader and by PyVista, with all their times; the dump by OVITO."""
        with tempfile.TemporaryDirectory() as folder:
            files, dump = Path(folder) / "vtu", Path(folder) / "grains.dump"
            for arguments in (("--vtu", files), ("--lammps-dump", dump, "--all")):
                subprocess.run([PROGRAM, "export", self.run_of.folder, *arguments], check=True, capture_output=True)
            frames = self.run_of.frames
            with self.subTest(reader="vtk"):
                vtk = imported(self, "vtk")
                reader = vtk.vtkXMLUnstructuredGridReader()
                reader.SetFileName(str(files / "frames_0002.vtu"))
                reader.Update()
                fields = reader.GetOutput().GetPointData()
                self.assertEqual(sorted(fields.GetArrayName(at) for at in range(fields.GetNumberOfArrays())), frames.names)
                unit = lambda name: fields.GetArray(name).GetInformation().Get(vtk.vtkDataArray.UNITS_LABEL())
                self.assertEqual({name: unit(name) for name in frames.names}, frames.units)
            with self.subTest(reader="pyvista"):
                reader = imported(self, "pyvista").get_reader(files / "frames.pvd")
                self.assertEqual(reader.time_values, list(frames.times))
                for frame in frames:
                    reader.set_active_time_value(frame.time)
                    mesh = reader.read()[0]
                    np.testing.assert_array_equal(mesh.points, frame.positions)
                    np.testing.assert_array_equal(mesh.point_data["stress"], frame["stress"])
            with self.subTest(reader="ovito"):
                pipeline = imported(self, "ovito.io").import_file(dump)
                self.assertEqual(pipeline.source.num_frames, len(frames))
                particles = pipeline.compute(2).particles
                # Of single precision.
                self.assertEqual(particles.count, 400)
                order, wanted = np.argsort(particles["Particle Identifier"][...]), np.argsort(frames[2]["id"])
                np.testing.assert_allclose(particles["Radius"][...][order], frames[2]["radius"][wanted], rtol=1e-6)
                np.testing.assert_allclose(particles["Velocity"][...][order], frames[2]["velocity"][wanted], rtol=1e-6, atol=1e-9)

    def test_frames_of_several_files_are_one_list(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("frames.vtkhdf", "frames.2.vtkhdf"):
                shutil.copy(self.run_of.frames.path, Path(folder) / name)
            frames = scree.Frames(Path(folder) / "frames.vtkhdf")
            self.assertEqual(len(frames), 6)
            np.testing.assert_array_equal(frames[4]["velocity"], self.run_of.frames[1]["velocity"])
            # Of two of one time the run went on with the later one.
            self.assertEqual(frames.at(2e-3).time, self.run_of.frames.times[2])

    def test_force_chains_bear_the_stress_of_the_series(self):
        """Love and Weber: the sum of force by branch over the volume is the mean stress."""
        contacts, frame = self.run_of.contacts[-1], self.run_of.frames[-1]
        self.assertEqual(len(contacts), int(self.run_of.series["contacts"].iloc[-1]))
        branch = (contacts.places[:, 1] - contacts.places[:, 0])[:, :2]
        force = contacts["force"][:, :2]
        edges, depth = frame.cell["cell_edges"].reshape(3, 3)[:2, :2], frame.cell["cell_edges"][8]
        stress = np.einsum("ci,cj->ij", force, branch) / (abs(np.linalg.det(edges)) * depth)
        series = self.run_of.series.iloc[-1]
        for i, j, name in ((0, 0, "stress_xx"), (1, 1, "stress_yy"), (0, 1, "stress_xy")):
            self.assertAlmostEqual(abs(stress[i, j] / series[name]), 1, places=6, msg=name)
        strong = contacts.where(contacts["force_normal"] > contacts["force_normal"].mean())
        self.assertEqual(len(strong["force"]), len(strong.places))
        fabric = scree.fabric(contacts, 2)
        self.assertAlmostEqual(np.trace(fabric), 1)
        # Grains that are sheared lean on each other across the shear.
        self.assertLess(fabric[0, 1], 0)

    def test_fields_keep_mass_momentum_and_stress(self):
        frame, contacts = self.run_of.frames[-1], self.run_of.contacts[-1]
        gradient = np.array([[0.0, 25.0], [0.0, 0.0]])
        fields = scree.coarse_grain(frame, 2e-3, contacts=contacts, velocity_gradient=gradient, samples=3)
        mass, corner = frame["mass"], fields.lattice.corner[:2]
        own = frame["velocity"][:, :2] - (frame.positions[:, :2] - corner) @ gradient.T
        velocity = fields["velocity"] - (fields.lattice.points - corner) @ gradient.T
        self.assertAlmostEqual(fields.total("density") / mass.sum(), 1, delta=1e-13)
        momentum = (fields["density"][..., None] * velocity).sum(axis=(0, 1)) * fields.lattice.volume
        np.testing.assert_allclose(momentum, mass @ own, atol=1e-13 * (mass @ abs(own)).sum())
        # Love and Weber's mean over the cell is the integral of the field.
        branch = contacts.places[:, 1] - contacts.places[:, 0]
        moment = np.einsum("c,ci,cj->ij", contacts["weight"], contacts["force"], branch)[:2, :2]
        wanted = np.array([moment[0, 0], moment[1, 1], 0.5 * (moment[0, 1] + moment[1, 0])])
        np.testing.assert_allclose(fields.total("stress"), wanted, atol=1e-12 * abs(moment).max())
        # Flux of momentum is the mean motion's and the rest.
        flux = np.einsum("r,ri,rj->ij", mass, own, own)
        of_mean = np.einsum("xy,xyi,xyj->ij", fields["density"], velocity, velocity) * fields.lattice.volume
        kinetic = fields.total("kinetic_stress")
        np.testing.assert_allclose(of_mean[0, 0] - kinetic[0], flux[0, 0], rtol=1e-12)
        self.assertTrue((fields["temperature"] > 0).all())
        np.testing.assert_allclose(fields["fabric"][..., 0] + fields["fabric"][..., 1], 1, rtol=1e-12)
        # The cell is sheared at 25/s, and its grains by no more than noise beside it.
        self.assertAlmostEqual(np.mean(fields["velocity_gradient"][..., 1]) / 25, 1, delta=0.2)
        self.assertIn("fraction", fields.values)
        np.testing.assert_allclose(fields.total("fraction"), (np.pi * frame["radius"] ** 2).sum() * np.linalg.norm(fields.lattice.edges[2]), rtol=1e-12)

    def test_a_grain_that_leaves_a_deforming_cell_moves_as_its_image(self):
        gradient = np.array([[0.0, 25.0], [0.0, 0.0]])
        run = scree.run(self.job, {"cell.velocity_gradient": gradient.tolist(), "output.frame_interval": "0.1 ms"}, out=Path(self.folder.name) / "leaving", program=PROGRAM, threads=1)
        beside = []
        for frame in run.frames:
            places = frame.positions[:, :2] - frame.cell["cell_corner"][:2]
            beside.append(abs(frame["velocity"][:, :2] - places @ gradient.T).max())
        # At 1.9 ms one has just left: drawn at the other side with its old velocity it would be faster than all by the cell's 0.55 m/s.
        self.assertLess(beside[19], 1.5 * max(beside[18], beside[20]))
        self.assertEqual(len(beside), 21)

    def test_fields_over_time_are_an_image_that_vtk_reads(self):
        try:
            from vtkmodules.util.numpy_support import vtk_to_numpy
            from vtkmodules.vtkIOHDF import vtkHDFReader
        except ModuleNotFoundError:
            self.skipTest("there is no vtk")
        job = Path(self.folder.name) / "column.toml"
        job.write_text(subprocess.run([PROGRAM, "new", "continuum"], check=True, capture_output=True, text=True).stdout)
        run = scree.run(job, {"time.end": "20 ms"}, out=Path(self.folder.name) / "column", program=PROGRAM)
        fields = [scree.coarse_grain(frame, 2e-2) for frame in run.frames]
        path = Path(self.folder.name) / "fields.vtkhdf"
        scree.write_images(path, fields)
        reader = vtkHDFReader()
        reader.SetFileName(str(path))
        reader.Update()
        self.assertEqual(reader.GetNumberOfSteps(), len(fields))
        reader.SetStep(len(fields) - 1)
        reader.Update()
        image, last = reader.GetOutput(), fields[-1]
        self.assertEqual(image.GetPointData().GetNumberOfArrays(), len(last.values))
        density = vtk_to_numpy(image.GetPointData().GetArray("density")).reshape(image.GetDimensions()[::-1])[0].T
        stress = vtk_to_numpy(image.GetPointData().GetArray("stress"))
        np.testing.assert_allclose(stress.sum(axis=0), last["stress"].sum(axis=(0, 1)), rtol=1e-10)
        self.assertAlmostEqual(density.sum() / last["density"].sum(), 1, delta=1e-12)
        place = np.array(np.unravel_index(density.argmax(), density.shape))
        at = np.array(image.GetOrigin())[:2] + place * np.array(image.GetSpacing())[:2]
        own = last.lattice.points[np.unravel_index(last["density"].argmax(), last["density"].shape)]
        np.testing.assert_allclose(at, own, atol=1e-12)

    def test_checkpoints_have_their_tables(self):
        last = self.run_of.checkpoints[-1]
        self.assertEqual(last.step, 2000)
        grains = last.table("grains")
        self.assertEqual(len(grains), 400)
        order = np.argsort(grains["id"].to_numpy())
        frame = self.run_of.frames[-1]
        np.testing.assert_array_equal(
            grains[["velocity_0", "velocity_1"]].to_numpy()[order], frame["velocity"][np.argsort(frame["id"]), :2]
        )
        self.assertIn("[contact]", last.job)

    def test_elements_are_quadrilaterals_with_their_fields(self):
        job = Path(self.folder.name) / "elements.toml"
        job.write_text(ELEMENTS)
        run = scree.run(job, {"time.end": np.float64(2e-2)}, out=Path(self.folder.name) / "elements", program=PROGRAM)
        frame = run.elements[-1]
        self.assertEqual(frame.places.shape, (8, 4, 3))
        self.assertEqual(len(frame["stress"]), 8)
        edges = np.linalg.norm(np.diff(frame.places, axis=1), axis=2)
        np.testing.assert_allclose(edges, 0.25, rtol=1e-2)

    def test_several_runs_are_an_ensemble(self):
        ensemble = scree.Ensemble([self.run_of, self.run_of])
        curve = ensemble.curve("time", "stress_xy", self.run_of.series["time"].to_numpy())
        np.testing.assert_allclose(curve["mean"], self.run_of.series["stress_xy"])
        error = self.run_of.summary["conservation"]["mass"]["error"]
        self.assertEqual(list(ensemble.summary("conservation", "mass", "error")), [error, error])

    def test_a_sweep_is_a_table_and_its_runs(self):
        folder = Path(self.folder.name) / "sweep"
        line = [PROGRAM, "sweep", self.job, "--out", folder, "--vary", "cell.velocity_gradient=[[0, 20], [0, 0]],[[0, 25.0], [0, 0]]", "--vary", "contact.friction=0.3,0.5"]
        subprocess.run(line, check=True, capture_output=True)
        sweep = scree.Sweep(folder)
        self.assertEqual((len(sweep), sweep.keys), (4, ["cell.velocity_gradient", "contact.friction"]))
        self.assertEqual(list(sweep.table["state"]), ["done"] * 4)
        wanted = {"cell.velocity_gradient": "[[0, 25.0], [0, 0]]", "contact.friction": 0.5}
        [run] = sweep.runs(wanted)
        np.testing.assert_array_equal(run.series["stress_xy"], self.run_of.series["stress_xy"])
        self.assertEqual(sweep.rows(wanted)["stress_xy_end"].item(), run.series["stress_xy"].iloc[-1])
        self.assertEqual(len(sweep.ensemble({"contact.friction": 0.3})), 2)
        with self.assertRaises(KeyError):
            sweep.rows({"seed": 1})
        with self.assertRaises(FileNotFoundError):
            scree.Sweep(self.run_of.folder)

    def test_figures_are_drawn_from_runs(self):
        imported(self, "matplotlib")
        sys.path.insert(0, str(ROOT / "io/python/examples"))
        self.addCleanup(sys.path.pop, 0)
        plot = importlib.import_module("plot")
        run, out = str(self.run_of.folder), Path(self.folder.name) / "figure.png"
        for arguments in (
            ["curves", out, "time", "0-stress_xy/1e3; 0-stress_yy/1e3", f"a={run}", f"a={run}", f"b={run}", "--smooth", "3"],
            ["curves", out, "time", "edge_yy/edge_yy[0]-1", run, "--labels", "t (s),strain"],
            ["map", out, "deviatoric_strain", run, run, "--times", "50%,100%", "--since", "0"],
            ["map", out, "displacement", run],
            ["chains", out, run, "--times", "1e-3"],
            ["profile", out, "velocity", run],
            ["mohr", out, run, run],
        ):
            with self.subTest(figure=arguments[:1]):
                plot.main([str(argument) for argument in arguments])
                self.assertEqual(out.read_bytes()[1:4], b"PNG")
                out.unlink()
        # Circles of a material with c = 2 kPa and 30 degrees: s1 = 3 s3 + 2 sqrt(3) c.
        minor = np.array([1e4, 5e4, 2e5])
        angle, cohesion = plot.envelope(np.column_stack([3 * minor + 2 * np.sqrt(3) * 2e3, minor]))
        self.assertAlmostEqual(np.degrees(angle), 30)
        self.assertAlmostEqual(cohesion, 2e3, places=6)

    def test_what_the_program_refuses_is_told(self):
        with self.assertRaises(scree.Failed) as refused:
            scree.run(self.job, {"time.step": "1 km"}, out=Path(self.folder.name) / "other", program=PROGRAM)
        self.assertIn("time.step", str(refused.exception))
        with self.assertRaises(FileNotFoundError):
            scree.Run(self.folder.name)

    def test_frames_are_seen_by_pyvista(self):
        try:
            import pyvista
        except ModuleNotFoundError:
            self.skipTest("there is no pyvista")
        mesh = self.run_of.frames[-1].to_pyvista()
        self.assertIsInstance(mesh, pyvista.PolyData)
        self.assertEqual((mesh.n_points, mesh.n_cells), (400, 400))
        contacts = self.run_of.contacts[-1]
        mesh = contacts.to_pyvista()
        self.assertEqual(mesh.n_cells, len(contacts))
        np.testing.assert_array_equal(mesh.cell_data["force"], contacts["force"])


if __name__ == "__main__":
    unittest.main()
