//! Meshes of files against closed forms: distorted patches, order of convergence, Cook's membrane, physical groups; and the same bits whoever has them,
//! with and without the file.

use std::path::{Path, PathBuf};

use scree::base::math::{PI, cos, sin};
use scree::job::Job;
use scree::run::start;
use scree_partition::Solo;
use scree_partition::transport::threads;

use crate::runs::{Ran, done, options, orders, parse, result, same, words};

/// A mesh as Gmsh would write it, each part of its own group.
#[derive(Default)]
struct Msh {
    axes: usize,
    vertices: Vec<[f64; 3]>,
    cells: Vec<(&'static str, Vec<usize>)>,
    sides: Vec<(&'static str, Vec<usize>)>,
}

impl Msh {
    /// A block of cells along natural axes from 0 to 1 that `place` puts anywhere; its six (four) sides are groups "x0", "x1" and so on.
    fn block(axes: usize, cells: [usize; 3], place: impl Fn([usize; 3]) -> [f64; 3]) -> Self {
        let cells = std::array::from_fn(|axis| if axis < axes { cells[axis] } else { 0 });
        let counts = cells.map(|count| count + 1);
        let number = |[x, y, z]: [usize; 3]| (z * counts[1] + y) * counts[0] + x;
        let grid = |counts: [usize; 3]| {
            (0..counts[2]).flat_map(move |z| (0..counts[1]).flat_map(move |y| (0..counts[0]).map(move |x| [x, y, z])))
        };
        let shifted = |index: [usize; 3], way: [usize; 3]| std::array::from_fn(|axis| index[axis] + way[axis]);
        let square = |index: [usize; 3], [u, v]: [usize; 2]| {
            [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[along, across]| {
                let mut way = [0; 3];
                (way[u], way[v]) = (along, across);
                number(shifted(index, way))
            })
        };
        let mut mesh = Self { axes, vertices: grid(counts).map(place).collect(), ..Self::default() };
        for index in grid(cells.map(|count| count.max(1))) {
            let mut corners = square(index, [0, 1]).to_vec();
            if axes == 3 {
                corners.extend(square(shifted(index, [0, 0, 1]), [0, 1]));
            }
            mesh.cells.push(("material", corners));
        }
        for axis in 0..axes {
            for (upper, name) in [["x0", "y0", "z0"], ["x1", "y1", "z1"]].iter().enumerate() {
                let mut along = cells.map(|count| count.max(1));
                along[axis] = 1;
                for mut index in grid(along) {
                    index[axis] = upper * cells[axis];
                    let (u, v) = ((axis + 1) % axes, (axis + 2) % 3);
                    let corners = match axes {
                        2 => {
                            let mut way = [0; 3];
                            way[u] = 1;
                            vec![number(index), number(shifted(index, way))]
                        }
                        _ => square(index, [u, v]).to_vec(),
                    };
                    mesh.sides.push((name[axis], corners));
                }
            }
        }
        mesh
    }

    /// Numbers of nodes have gaps and run backwards, and every second cell is wound the other way round.
    fn text(&self) -> String {
        let number = |vertex: &usize| {
            1000 - 3 * vertex.min(&300) + 7 * vertex.saturating_sub(300) + 1_000_000 * usize::from(*vertex > 300)
        };
        let mut names: Vec<(usize, &str)> = Vec::new();
        let parts = [(self.axes, &self.cells), (self.axes - 1, &self.sides)];
        for (axes, list) in parts {
            for (name, _) in list {
                if !names.contains(&(axes, name)) {
                    names.push((axes, name));
                }
            }
        }
        let mut text = format!("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n{}\n", names.len());
        names.iter().enumerate().for_each(|(at, (axes, name))| text += &format!("{axes} {} \"{name}\"\n", at + 1));
        let of = |axes: usize| names.iter().filter(move |(of, _)| *of == axes).count();
        text += &format!("$EndPhysicalNames\n$Entities\n0 {} {} {}\n", of(1), of(2), of(3));
        for axes in 1..4 {
            for (at, _) in names.iter().enumerate().filter(|(_, (of, _))| *of == axes) {
                text += &format!("{0} 0 0 0 1 1 1 1 {0} 0\n", at + 1);
            }
        }
        text += &format!("$EndEntities\n$Nodes\n1 {0} 1 9999999\n{1} 1 0 {0}\n", self.vertices.len(), self.axes);
        (0..self.vertices.len()).for_each(|vertex| text += &format!("{}\n", number(&vertex)));
        self.vertices.iter().for_each(|[x, y, z]| text += &format!("{x:?} {y:?} {z:?}\n"));
        text += &format!("$EndNodes\n$Elements\n{} {} 1 9999\n", names.len(), self.cells.len() + self.sides.len());
        for (at, (axes, name)) in names.iter().enumerate() {
            let list = parts.iter().find(|(of, _)| of == axes).unwrap().1;
            let own: Vec<&Vec<usize>> = list.iter().filter(|(of, _)| of == name).map(|(_, corners)| corners).collect();
            let kind = [1, 3, 5][axes - 1];
            text += &format!("{axes} {} {kind} {}\n", at + 1, own.len());
            for (row, corners) in own.iter().enumerate() {
                let mut corners = (*corners).clone();
                if row % 2 == 1 && *axes == 2 && self.axes == 2 {
                    corners.reverse();
                }
                let words: Vec<String> = corners.iter().map(|corner| number(corner).to_string()).collect();
                text += &format!("{} {}\n", 1000 * (at + 1) + row, words.join(" "));
            }
        }
        text + "$EndElements\n"
    }

    fn write(&self, folder: &Path) -> PathBuf {
        let path = folder.join("a.msh");
        std::fs::write(&path, self.text()).unwrap();
        path
    }
}

/// Somewhere between -1 and 1, by a number.
fn scattered(number: usize) -> f64 {
    ((number * 7919 + 17) % 101) as f64 / 50.0 - 1.0
}

/// A box whose inner nodes are moved by a quarter of a cell at most.
fn distorted(axes: usize, upper: [f64; 3], cells: [usize; 3]) -> Msh {
    Msh::block(axes, cells, |index| {
        let inside = |axis: usize| axis >= axes || index[axis] > 0 && index[axis] < cells[axis];
        let is_inner = (0..axes).all(inside);
        std::array::from_fn(|axis| {
            let number = (index[2] * 37 + index[1]) * 41 + index[0] + 13 * axis;
            let moved = if is_inner && axis < axes { 0.25 * scattered(number) } else { 0.0 };
            if axis < axes { upper[axis] * (index[axis] as f64 + moved) / cells[axis] as f64 } else { 0.0 }
        })
    })
}

fn job(mesh: &Path, axes: usize, [young, poisson]: [f64; 2], rest: &str) -> String {
    let space = if axes == 2 { "plane" } else { "solid" };
    format!(
        "name = \"meshes\"\n[material]\nlaw = \"hencky\"\ndensity = 1000\nyoung_modulus = {young:?}\npoisson_ratio = {poisson:?}\n\
         [mesh]\nspace = \"{space}\"\nfile = \"{}\"\n{rest}",
        mesh.display()
    )
}

fn free(axes: usize, but: &[&str]) -> String {
    let faces = ["x_lower", "x_upper", "y_lower", "y_upper", "z_lower", "z_upper"];
    let named = faces[..2 * axes].iter().filter(|face| !but.contains(face));
    named.map(|face| format!("[[boundary]]\nface = \"{face}\"\nkind = \"free\"\n")).collect()
}

/// A uniform stress is in balance in a distorted mesh with the pressure on its sides, which are groups.
#[test]
fn a_pressure_on_groups_holds_its_own_stress() {
    for axes in [2, 3] {
        let folder = tempfile::tempdir().unwrap();
        let mesh = distorted(axes, [1.0, 0.7, 0.6], [5, 4, 3]).write(folder.path());
        let sides = ["x0", "x1", "y0", "y1", "z0", "z1"];
        let load = |side: &&str| format!("[[load]]\ngroup = \"{side}\"\nkind = \"pressure\"\npressure = 1000\n");
        let loads: String = sides[..2 * axes].iter().map(load).collect();
        let rest =
            format!("{}{loads}[stress]\nkind = \"isotropic\"\npressure = 1000\n[time]\nend = 0.05\n", free(axes, &[]));
        let ran = Ran::of(&job(&mesh, axes, [1e6, 0.3], &rest));
        for velocity in ran.rows_of("nodes", "velocity") {
            assert!(velocity.iter().all(|component| component.abs() < 1e-13), "{axes}: {velocity:?}");
        }
    }
}

/// A distorted mesh that a plate presses uniformly has the same F everywhere.
#[test]
fn a_distorted_mesh_strains_uniformly() {
    for axes in [2, 3] {
        let folder = tempfile::tempdir().unwrap();
        let mesh = distorted(axes, [1.0, 1.0, 1.0], [4, 4, 4]).write(folder.path());
        let (down, normal) = if axes == 2 { ("[0, -1e-2]", "[0, -1]") } else { ("[0, -1e-2, 0]", "[0, -1, 0]") };
        let zero = if axes == 2 { "[0, 1]" } else { "[0, 1, 0]" };
        let path =
            "[{time = 0, velocity = VELOCITY}, {time = 0.1, velocity = VELOCITY}, {time = 0.1000001, velocity = ZERO}]"
                .replace("VELOCITY", down)
                .replace("ZERO", if axes == 2 { "[0, 0]" } else { "[0, 0, 0]" });
        let rest = format!(
            "local_damping = 0.7\n[[body]]\nname = \"plate\"\nshape = \"plane\"\npoint = {zero}\nnormal = {normal}\ngroup = \"y1\"\ncontact = \"smooth\"\n\
             path = {path}\n[[boundary]]\nface = \"y_upper\"\nkind = \"free\"\n[time]\nend = 3\nsafety = 0.9\n"
        );
        let ran = Ran::of(&job(&mesh, axes, [1e6, 0.3], &rest));
        // The plate comes as far as whole steps take it.
        let height = 1.0 + displacements(&ran).iter().map(|moved| moved[1]).fold(0.0, f64::min);
        assert!((height - 0.999).abs() < 5e-5, "{height}");
        let wanted = |at: usize| if at == axes + 1 { height } else { f64::from(at.is_multiple_of(axes + 1)) };
        let off = |deformation: &Vec<f64>| -> f64 {
            deformation.iter().enumerate().map(|(at, entry)| (entry - wanted(at)).abs()).fold(0.0, f64::max)
        };
        let worst = ran.points("deformation").iter().map(off).fold(0.0, f64::max);
        println!("distorted mesh, {axes} axes: F off by {worst:.1e} of a strain of 1e-3");
        assert!(worst < 1e-12, "{axes}: {worst}");
    }
}

/// A quarter of a thick pipe under a pressure on its curved inner side: the radial displacement of Lame, and how its error falls.
#[test]
fn a_pipe_under_pressure_converges_with_order_two() {
    let (inner, outer, pressure, young, poisson) = (1.0, 2.0, 10.0, 1e6, 0.3);
    for (axes, counts) in [(2, vec![4, 8, 16]), (3, vec![4, 8])] {
        let error = |count: &usize| {
            let folder = tempfile::tempdir().unwrap();
            let place = |index: [usize; 3]| {
                // Denser towards the inside.
                let along = index[0] as f64 / *count as f64;
                let radius = inner + (outer - inner) * along * (0.7 + 0.3 * along);
                let angle = 0.5 * PI * index[1] as f64 / *count as f64;
                let at = |side: f64, end: usize| if index[1] == end { 0.0 } else { radius * side };
                [at(cos(angle), *count), at(sin(angle), 0), index[2] as f64 * 0.1]
            };
            let mesh = Msh::block(axes, [*count, *count, 1], place);
            let path = mesh.write(folder.path());
            let rest = format!(
                "local_damping = 0.7\n{}[[load]]\ngroup = \"x0\"\nkind = \"pressure\"\npressure = {pressure}\nramp = 0.5\n[time]\nend = 4\nsafety = 0.9\n",
                free(axes, &["x_lower", "y_lower", "z_lower", "z_upper"])
            );
            let ran = Ran::of(&job(&path, axes, [young, poisson], &rest));
            let (displacements, vertices) = (displacements(&ran), nodes_in_order(&mesh));
            let radial = |[place, moved]: [&[f64]; 2]| {
                let radius = (place[0] * place[0] + place[1] * place[1]).sqrt();
                let found = (place[0] * moved[0] + place[1] * moved[1]) / radius;
                let scale = (1.0 + poisson) * pressure * inner * inner / (young * (outer * outer - inner * inner));
                let wanted = scale * ((1.0 - 2.0 * poisson) * radius + outer * outer / radius);
                (found / wanted - 1.0) * (found / wanted - 1.0)
            };
            let square: f64 = vertices.iter().zip(&displacements).map(|(place, moved)| radial([place, moved])).sum();
            (square / vertices.len() as f64).sqrt()
        };
        let errors: Vec<f64> = counts.iter().map(error).collect();
        let orders = orders(&errors);
        println!("pipe, {axes} axes, {counts:?} elements: rms {}, order {orders:.2?}", words(&errors));
        assert!(errors[0] < 0.02 && orders.iter().all(|order| *order > 1.85), "{axes}: {errors:?} {orders:?}");
    }
}

/// Places of nodes in the order of their ids: that of their numbers in the file.
fn nodes_in_order(mesh: &Msh) -> Vec<[f64; 3]> {
    let text = mesh.text();
    let mut lines = text.lines().skip_while(|line| *line != "$Nodes").skip(3);
    let numbers: Vec<u64> = lines.by_ref().take(mesh.vertices.len()).map(|line| line.parse().unwrap()).collect();
    let mut order: Vec<usize> = (0..numbers.len()).collect();
    order.sort_unstable_by_key(|at| numbers[*at]);
    order.into_iter().map(|at| mesh.vertices[at]).collect()
}

/// Displacements of nodes in the order of their ids.
fn displacements(ran: &Ran) -> Vec<Vec<f64>> {
    let mut found: Vec<_> =
        ran.wholes_of("nodes", "id").into_iter().zip(ran.rows_of("nodes", "displacement")).collect();
    found.sort_unstable_by_key(|(id, _)| *id);
    found.into_iter().map(|(_, moved)| moved).collect()
}

/// Cook's membrane (Cook 1974), whose plane stress of E = 1 and nu = 1/3 is the plane strain of E = 15/16 and nu = 1/4: the middle of the loaded side goes
/// up by 23.96 for a force of 1 per thickness.
#[test]
fn cooks_membrane_goes_where_others_have_it() {
    let mut found = Vec::new();
    for count in [2, 4, 8, 16] {
        let folder = tempfile::tempdir().unwrap();
        let place = |index: [usize; 3]| {
            let [along, across] = [index[0], index[1]].map(|at| at as f64 / count as f64);
            let (lower, upper) = (44.0 * along, 44.0 + 16.0 * along);
            [48.0 * along, lower + (upper - lower) * across, 0.0]
        };
        let mesh = Msh::block(2, [count, count, 1], place);
        let path = mesh.write(folder.path());
        // Small enough to be linear.
        let (scale, force) = (1e6, 1e-5);
        let rest = format!(
            "local_damping = 0.5\n[[boundary]]\nface = \"x_lower\"\nkind = \"fixed\"\n{}\
             [[load]]\ngroup = \"x1\"\nkind = \"traction\"\ntraction = [0, {}]\nramp = 20\n[time]\nend = 400\nsafety = 0.9\n",
            free(2, &["x_lower"]),
            force * scale / 16.0
        );
        let ran = Ran::of(&job(&path, 2, [scale * 15.0 / 16.0, 0.25], &rest));
        let middle = nodes_in_order(&mesh).iter().position(|place| place[0] == 48.0 && place[1] == 52.0).unwrap();
        found.push(displacements(&ran)[middle][1] / force);
    }
    println!("Cook's membrane, 2, 4, 8, 16 elements a side: {found:.2?} (23.96)");
    // Elements that are far from boxes bend more stiffly than boxes do.
    assert!((found[3] / 23.96 - 1.0).abs() < 0.01 && found.is_sorted(), "{found:?}");
}

/// A job whose groups bear loads, are fastened and are regions.
fn with_groups(folder: &Path, axes: usize) -> Job {
    let mut mesh = distorted(axes, [1.2, 0.7, 0.6], [6, 5, 4]);
    let count = mesh.cells.len();
    mesh.cells[count / 2..].iter_mut().for_each(|(name, _)| *name = "upper half");
    let path = mesh.write(folder);
    let zero = if axes == 2 { "" } else { ", 0" };
    parse(&job(
        &path,
        axes,
        [1e6, 0.3],
        &format!(
            "{}[[region]]\nshape = \"group\"\ngroup = \"material\"\n[[region]]\nshape = \"group\"\ngroup = \"upper half\"\nvelocity = [0.1, 0.2{zero}]\n\
             [[load]]\ngroup = \"y1\"\nkind = \"pressure\"\npressure = 2000\n\
             [[body]]\nname = \"wall\"\nshape = \"plane\"\npoint = [0, 0{zero}]\nnormal = [1, 0{zero}]\ngroup = \"x0\"\ncontact = \"rough\"\nvelocity = [0, 0.5{zero}]\n\
             [[body]]\nname = \"rail\"\nshape = \"plane\"\npoint = [1.2, 0{zero}]\nnormal = [-1, 0{zero}]\ngroup = \"x1\"\ncontact = \"smooth\"\n\
             [time]\nend = \"25 ms\"\n[decomposition]\ncells_per_block = 2\n[output]\ncheckpoint_interval = \"10 ms\"\nframe_interval = \"10 ms\"\nenergy_balance = true\n",
            free(axes, &[])
        ),
    ))
}

#[test]
fn meshes_of_files_end_in_the_same_bits() {
    for axes in [2, 3] {
        let folder = tempfile::tempdir().unwrap();
        same(&with_groups(folder.path(), axes), folder.path(), &format!("{axes}D"));
    }
}

/// What is fastened goes with its body, and a rail holds across alone.
#[test]
fn groups_are_held_as_their_bodies_say() {
    let folder = tempfile::tempdir().unwrap();
    let ran = Ran::of_job(&with_groups(folder.path(), 2));
    let mut mesh = distorted(2, [1.2, 0.7, 0.6], [6, 5, 4]);
    mesh.cells.clear();
    let last = *ran.series("time").last().unwrap();
    let places = nodes_in_order(&mesh);
    let moved = displacements(&ran);
    let mut slid: f64 = 0.0;
    for (place, moved) in places.iter().zip(&moved) {
        if place[0] == 0.0 {
            assert!(moved[0] == 0.0 && (moved[1] / (0.5 * last) - 1.0).abs() < 1e-12, "{place:?} {moved:?}");
        } else if place[0] == 1.2 {
            assert!(moved[0].abs() < 1e-15, "{place:?} {moved:?}");
            slid = slid.max(moved[1].abs());
        }
    }
    assert!(slid > 1e-3, "{slid}");
}

/// What is fastened to a body has no boundary, though the job says nothing of the face that it is on.
#[test]
fn a_group_that_is_fastened_has_no_boundary() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = distorted(2, [1.0, 1.0, 0.0], [3, 3, 1]);
    let path = mesh.write(folder.path());
    let rest = "[[body]]\nname = \"plate\"\nshape = \"plane\"\npoint = [0, 1]\nnormal = [0, -1]\ngroup = \"y1\"\ncontact = \"rough\"\nvelocity = [0, -0.01]\n\
                [time]\nend = 0.1\n";
    let ran = Ran::of(&job(&path, 2, [1e6, 0.3], rest));
    let time = *ran.series("time").last().unwrap();
    for (place, moved) in nodes_in_order(&mesh).iter().zip(displacements(&ran)).filter(|(place, _)| place[1] == 1.0) {
        assert!(moved[0] == 0.0 && (moved[1] / (-0.01 * time) - 1.0).abs() < 1e-12, "{place:?} {moved:?}");
    }
}

/// A copy stands in for the mesh of its own job alone: not for one that is not there, and not for one that is asked for anew.
#[test]
fn a_copy_is_taken_for_its_own_mesh_alone() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("run.msh"), distorted(2, [1.0, 1.0, 0.0], [3, 3, 1]).text()).unwrap();
    let other = folder.path().join("other");
    std::fs::create_dir(&other).unwrap();
    let other = distorted(2, [1.0, 1.0, 0.0], [5, 5, 1]).write(&other);
    let file = folder.path().join("scenario.toml").display().to_string();
    let text = job(&folder.path().join("gone.msh"), 2, [1e6, 0.3], "[time]\nend = 0.1\n");
    let error = Job::parse(&text, &file, &[]).unwrap_err().to_string();
    assert!(error.contains("names no file that can be read"), "{error}");
    let own = Job::parse(&text.replace("gone.msh", "run.msh"), &file, &[]).unwrap();
    let resolved = own.to_toml().replace("run.msh", "gone.msh");
    let count = |job: &Job| job.as_mpm().unwrap().drawn().unwrap().elements.len();
    assert_eq!(count(&Job::parse(&resolved, &file, &[]).unwrap()), 9);
    let set = format!("mesh.file={}", other.display());
    assert_eq!(count(&Job::parse(&resolved, &file, &[set]).unwrap()), 25);
}

/// A run keeps its mesh: it goes on to the same bits where the file is gone, and where it is another by now.
#[test]
fn a_run_goes_on_without_the_file_of_its_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let job = with_groups(folder.path(), 2);
    let whole = folder.path().join("whole");
    done(start::start(&job, &options(&whole), &Solo));
    for is_gone in [true, false] {
        let (out, file) = (folder.path().join(format!("run {is_gone}")), folder.path().join("a.msh"));
        done(start::start(&job, &options(&out), &Solo));
        let listed = std::fs::read_dir(scree::store::checkpoint::folder(&out)).unwrap();
        let mut kept: Vec<_> = listed.map(|entry| entry.unwrap().path()).filter(|path| path.is_file()).collect();
        kept.sort();
        kept[1..].iter().for_each(|later| std::fs::remove_file(later).unwrap());
        match is_gone {
            true => std::fs::remove_file(&file).unwrap(),
            false => std::fs::write(&file, distorted(2, [2.0, 1.0, 1.0], [3, 3, 3]).text()).unwrap(),
        }
        threads::run(2, |rank| done(start::resume(&out, Default::default(), &options(&out), &rank)));
        assert!(result(&out) == result(&whole), "{is_gone}");
        with_groups(folder.path(), 2);
    }
}
