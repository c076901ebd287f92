//! Form factors as files: what is written can be read back, and means what it says.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;
use std::process::Output;

use radiosity::output::{FactorEntry, FactorTable, OutputError, write_form_factors};
use radiosity::patches::{GroupBy, Groups, PatchSize, Patches, Reach, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::{Material, Scene};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, GroupFactor, Keep, TraceOptions};
use serde_json::Value;

use crate::scenes::{flipped, quads, room};
use crate::scratch::{Scratch, names};

/// A cube from whose six objects its last one is missing, and a sheet in its middle.
fn open_cube_with_a_sheet() -> Scene {
    let sheet = [[0.2, 0.3, 0.5], [0.8, 0.3, 0.5], [0.8, 0.7, 0.5], [0.2, 0.7, 0.5]];
    let mut all: Vec<_> = room([0.0; 3], [1.0; 3])[..5].iter().map(|&quad| (quad, 0)).collect();
    all.push((sheet, 1));
    quads(&all, vec![Material::diffuse("wall", &[0.5]), Material::diffuse("sheet", &[0.0])])
}

fn traced(scene: &Scene, then: impl FnOnce(&Patches, &FormFactors)) {
    let tracer = Tracer::new(scene);
    let options =
        Tessellation { size: PatchSize::Count(200), reach: Reach::Everything, ..Default::default() };
    let mut patches = Patches::new(&tracer, &options).unwrap();
    let options = TraceOptions { rays: Some(64), lamp_rays: Some(0), keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    then(&patches, &factors);
}

/// Hands on what is known between the groups of a scene.
fn grouped(scene: &Scene, by: GroupBy, then: impl FnOnce(&FactorTable)) {
    traced(scene, |patches, factors| {
        let groups = Groups::new(patches, by, |_, _| true);
        let between = factors.between_groups(patches, groups.of_patch(), Progress::default()).unwrap();
        then(&FactorTable::between_groups(patches, &groups, &between, factors.rays()));
    });
}

/// A written file.
fn written(table: &FactorTable, name: &str) -> Scratch {
    let scratch = Scratch::new();
    write_form_factors(&scratch.path(name), table).unwrap();
    assert_eq!(names(scratch.folder()), [name]);
    scratch
}

/// The header of a CSV file, and its records.
fn csv_of(path: &Path) -> (String, Vec<Vec<String>>) {
    let text = fs::read_to_string(path).unwrap();
    let records = csv::Reader::from_reader(text.as_bytes()).into_deserialize();
    (text.lines().next().unwrap().to_owned(), records.map(|record| record.unwrap()).collect())
}

/// Form factor and standard error by the names of a pair.
fn pairs(path: &Path) -> BTreeMap<(String, String), (f64, f64)> {
    let (header, records) = csv_of(path);
    assert_eq!(header, "from,to,form_factor,standard_error,from_area,escape,escape_error,upper95");
    let number = |text: &String| text.parse().unwrap();
    let pair = |r: &Vec<String>| ((r[0].clone(), r[1].clone()), (number(&r[2]), number(&r[3])));
    records.iter().map(pair).collect()
}

/// An array of an NPZ file: its type and shape, and its bytes.
fn array(path: &Path, name: &str) -> Option<(String, Vec<usize>, Vec<u8>)> {
    let mut archive = zip::ZipArchive::new(File::open(path).unwrap()).unwrap();
    let mut bytes = Vec::new();
    archive.by_name(&format!("{name}.npy")).ok()?.read_to_end(&mut bytes).unwrap();
    assert_eq!(bytes[..8], *b"\x93NUMPY\x01\x00");
    let data = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!(data % 64, 0);
    let header = std::str::from_utf8(&bytes[10..data]).unwrap();
    assert!(header.starts_with('{') && header.ends_with('\n') && header.contains("'fortran_order': False"));
    let between = |from: &str, to: &str| header.split_once(from).unwrap().1.split_once(to).unwrap().0;
    let shape = between("'shape': (", ")").split(", ").map(|n| n.trim_end_matches(',').parse().unwrap());
    Some((between("'descr': '", "'").to_owned(), shape.collect(), bytes[data..].to_vec()))
}

/// The numbers of an array of this shape.
#[track_caller]
fn numbers(path: &Path, name: &str, shape: &[usize]) -> Vec<f64> {
    let (kind, found, bytes) = array(path, name).unwrap_or_else(|| panic!("no array {name}"));
    assert_eq!((kind.as_str(), &found[..]), ("<f8", shape), "{name}");
    let values: Vec<f64> = bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
    assert_eq!(values.len(), shape.iter().product::<usize>(), "{name}");
    values
}

/// The texts of an array of them.
fn texts(path: &Path, name: &str) -> Vec<String> {
    let (kind, shape, bytes) = array(path, name).unwrap();
    let width: usize = kind.strip_prefix("<U").unwrap().parse().unwrap();
    let letter = |b: &[u8]| char::from_u32(u32::from_le_bytes(b.try_into().unwrap())).unwrap();
    let letters: Vec<char> = bytes.chunks_exact(4).map(letter).collect();
    assert_eq!(letters.len(), width * shape[0]);
    letters.chunks(width).map(|text| text.iter().filter(|&&c| c != '\0').collect()).collect()
}

/// An entry of a sparse matrix, rows and columns from 1.
type Entry = (usize, usize, f64);

/// The size and the entries of a Matrix Market file, and its comments.
fn matrix_market(path: &Path) -> ([usize; 3], Vec<Entry>, Vec<String>) {
    let text = fs::read_to_string(path).unwrap();
    let (comments, rest): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with('%'));
    assert_eq!(comments[0], "%%MatrixMarket matrix coordinate real general");
    let words = |line: &str| line.split(' ').map(str::to_owned).collect::<Vec<String>>();
    let size = words(rest[0]).iter().map(|word| word.parse().unwrap()).collect::<Vec<usize>>();
    let entry = |line: &&str| {
        let words = words(line);
        (words[0].parse().unwrap(), words[1].parse().unwrap(), words[2].parse().unwrap())
    };
    let entries = rest[1..].iter().map(entry).collect();
    (size.try_into().unwrap(), entries, comments.iter().map(|&line| line.to_owned()).collect())
}

// What files say.

#[test]
fn csv_names_every_pair_of_objects() {
    grouped(&open_cube_with_a_sheet(), GroupBy::Object, |table| {
        let scratch = written(table, "f.csv");
        let pairs = pairs(&scratch.path("f.csv"));
        // The backs of the walls see nothing, the sheet has two sides.
        assert_eq!(pairs.len(), 49);
        let names: Vec<&str> = table.groups().all().iter().map(|group| group.name.as_str()).collect();
        assert_eq!(names[5..], ["quad 5", "quad 5 (back)"]);
        for (a, from) in names.iter().enumerate() {
            for (b, entry) in table.full_row(a).into_iter().enumerate() {
                let (read, read_error) = pairs[&((*from).into(), names[b].into())];
                assert!((read - entry.form_factor).abs() <= 1e-8 * entry.form_factor);
                assert!((read_error - entry.standard_error.unwrap()).abs() <= 1e-8 * read_error);
            }
        }
        assert_eq!(pairs[&("quad 5".into(), "quad 5".into())], (0.0, 0.0));
    });
}

#[test]
fn form_factors_between_objects_are_reciprocal_and_close_with_escape() {
    grouped(&open_cube_with_a_sheet(), GroupBy::Object, |table| {
        let scratch = written(table, "f.csv");
        let pairs = pairs(&scratch.path("f.csv"));
        let area = |name: &str| table.groups().all().iter().find(|group| group.name == name).unwrap().area;
        assert!((area("quad 0") - 1.0).abs() < 1e-12 && (area("quad 5") - 0.24).abs() < 1e-12);
        for ((a, b), (form_factor, _)) in &pairs {
            let (there, back) = (area(a) * form_factor, area(b) * pairs[&(b.clone(), a.clone())].0);
            assert!((there - back).abs() <= 2e-8 * there, "{a} {b}: {there} {back}");
        }
        for (a, group) in table.groups().all().iter().enumerate() {
            let row = pairs.iter().filter(|((from, _), _)| *from == group.name);
            let sum: f64 = row.map(|(_, (form_factor, _))| form_factor).sum();
            let FactorEntry { form_factor: escape, standard_error, .. } = table.escape(a);
            assert!((sum + escape - 1.0).abs() < 1e-8, "{}: {sum} {escape}", group.name);
            assert!(standard_error.unwrap() > 0.0, "{}: {escape}", group.name);
            // The sheet's back faces away from what is missing.
            let open = group.name != "quad 5 (back)";
            assert!(escape > 0.02 || !open, "{}: the cube is open: {escape}", group.name);
        }
    });
}

#[test]
fn csv_by_face_has_both_sides_of_an_open_sheet() {
    grouped(&open_cube_with_a_sheet(), GroupBy::Face, |table| {
        let scratch = written(table, "f.csv");
        let (header, records) = csv_of(&scratch.path("f.csv"));
        assert_eq!(
            header,
            "from,from_side,to,to_side,form_factor,standard_error,from_area,escape,escape_error,upper95"
        );
        let mut senders: Vec<[&str; 2]> = records.iter().map(|r| [r[0].as_str(), &r[1]]).collect();
        senders.dedup();
        let expected = (0..10).map(|face| (face, "front"));
        let sheet = [(10, "front"), (10, "back"), (11, "front"), (11, "back")];
        let expected: Vec<(String, &str)> =
            expected.chain(sheet).map(|(face, side)| (face.to_string(), side)).collect();
        assert_eq!(senders, expected.iter().map(|(face, side)| [face.as_str(), side]).collect::<Vec<_>>());
        assert!(
            records.iter().all(|r| r[9].parse::<f64>().unwrap() > 0.0),
            "only what may exchange anything"
        );
        // The sheet's front looks up and away from the floor, faces 4 and 5; its back looks down at it.
        let sees_floor = |side: &str| records.iter().any(|r| r[0] == "10" && r[1] == side && r[2] == "4");
        assert!(sees_floor("back") && !sees_floor("front"));
    });
}

#[test]
fn matrix_market_holds_every_digit_and_names_its_rows() {
    grouped(&open_cube_with_a_sheet(), GroupBy::Object, |table| {
        let scratch = written(table, "f.mtx");
        let (size, entries, comments) = matrix_market(&scratch.path("f.mtx"));
        assert_eq!(size, [7, 7, entries.len()]);
        let mut known = Vec::new();
        for a in 0..7 {
            table.for_row(a, |b, entry| known.push((a + 1, b + 1, entry.form_factor)));
        }
        assert_eq!(entries, known);
        assert!(comments.contains(&"% 7: quad 5 (back), 0.24 m2".to_owned()), "{comments:?}");
    });
}

#[test]
fn npz_holds_every_bit() {
    grouped(&open_cube_with_a_sheet(), GroupBy::Material, |table| {
        let scratch = written(table, "f.npz");
        let path = scratch.path("f.npz");
        assert_eq!(texts(&path, "names"), ["wall", "sheet", "sheet (back)"]);
        let groups = table.groups().all();
        assert_eq!(numbers(&path, "area", &[3]), [groups[0].area, groups[1].area, groups[2].area]);
        let rows: Vec<_> = (0..3).flat_map(|a| table.full_row(a)).collect();
        let column = |of: fn(&FactorEntry) -> f64| rows.iter().map(of).collect::<Vec<f64>>();
        assert_eq!(numbers(&path, "form_factor", &[3, 3]), column(|entry| entry.form_factor));
        assert_eq!(numbers(&path, "standard_error", &[3, 3]), column(|entry| entry.standard_error.unwrap()));
        assert_eq!(numbers(&path, "upper95", &[3, 3]), column(|entry| entry.upper95.unwrap()));
        let escapes = [0, 1, 2].map(|a| table.escape(a));
        assert_eq!(numbers(&path, "escape", &[3]), escapes.map(|entry| entry.form_factor));
        let errors = escapes.map(|entry| entry.standard_error.unwrap());
        assert_eq!(numbers(&path, "escape_standard_error", &[3]), errors);
    });
}

#[test]
fn patches_are_written_as_the_operator_holds_them() {
    traced(&open_cube_with_a_sheet(), |patches, factors| {
        let groups = Groups::new(patches, GroupBy::Patch, |_, _| true);
        let exchange = factors.exchange();
        let table = FactorTable::between_patches(patches, &groups, exchange);
        let (csv, mtx, npz) = (written(&table, "f.csv"), written(&table, "f.mtx"), written(&table, "f.npz"));
        let (n, path) = (patches.len(), npz.path("f.npz"));
        let all = numbers(&path, "form_factor", &[n, n]);
        let (area, escape) = (numbers(&path, "area", &[n]), numbers(&path, "escape", &[n]));
        for i in 0..n {
            let row = &all[i * n..(i + 1) * n];
            assert!((0..n).all(|j| row[j] == exchange.form_factor(i, j)));
            assert!((row.iter().sum::<f64>() + escape[i] - 1.0).abs() < 1e-9);
            assert!((0..n).all(|j| (area[i] * row[j] - area[j] * all[j * n + i]).abs() < 1e-15));
        }
        assert!(array(&path, "standard_error").is_none());
        assert_eq!(numbers(&path, "reflectance", &[n, 1]), patches.reflectances().as_slice());
        assert_eq!(numbers(&path, "emission", &[n, 1]), vec![0.0; n]);
        assert_eq!(numbers(&path, "centre", &[n, 3])[3..6], patches.centre(1).to_array());

        let (size, entries, _) = matrix_market(&mtx.path("f.mtx"));
        assert_eq!(size, [n, n, all.iter().filter(|f| **f > 0.0).count()]);
        assert!(entries.iter().all(|&(i, j, f)| f == all[(i - 1) * n + j - 1]));
        let (_, records) = csv_of(&csv.path("f.csv"));
        assert_eq!(records.len(), entries.len());
        assert_eq!([&records[0][0], &records[0][3]], ["0", ""], "numbers from 0, no standard errors");
    });
}

#[test]
fn an_unknown_ending_is_refused_with_the_known_ones() {
    grouped(&open_cube_with_a_sheet(), GroupBy::Object, |table| {
        for name in ["f.txt", "f", "csv"] {
            let scratch = Scratch::new();
            let refused = write_form_factors(&scratch.path(name), table).unwrap_err();
            assert!(matches!(refused, OutputError::Format { .. }));
            let message = refused.to_string();
            assert!([".csv", ".mtx", ".npz", name].iter().all(|word| message.contains(word)), "{message}");
            assert!(names(scratch.folder()).is_empty());
        }
    });
}

// What they are based on.

#[test]
fn a_black_speck_and_what_it_sees_know_of_each_other() {
    // No ray of a few thousand from the plate finds the speck; those of the speck find the plate.
    let square = |s: f64, z: f64| [[0.0, 0.0, z], [s, 0.0, z], [s, s, z], [0.0, s, z]];
    let scene = quads(
        &[(square(1.0, 0.0), 0), (flipped(square(1e-3, 1.0)), 0)],
        vec![Material::diffuse("black", &[0.0])],
    );
    grouped(&scene, GroupBy::Object, |table| {
        let [plate, speck] = [0, 1].map(|a| &table.groups().all()[a]);
        assert!((plate.area - 1.0).abs() < 1e-9 && (speck.area - 1e-6).abs() < 1e-15);
        // Howell, C-13: from a point to a parallel unit square, one of whose corners lies below it.
        let exact = 2f64.sqrt().recip().atan() / (std::f64::consts::PI * 2f64.sqrt());
        let FactorEntry { form_factor, standard_error, .. } = table.full_row(1)[0];
        let z = (form_factor - exact) / standard_error.unwrap();
        assert!(z.abs() < 3.5, "{form_factor} for {exact}, z = {z}");
    });
}

#[test]
fn the_balancing_of_noisy_rays_leaves_no_bias() {
    // Many patches of few rays each: without correction the mean is 2 standard errors off.
    let floor = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
    let wall = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]];
    let scene = quads(&[(floor, 0), (wall, 0)], vec![Material::diffuse("grey", &[0.5])]);
    let tracer = Tracer::new(&scene);
    const SEEDS: u64 = 20;
    let of_seed = |seed: u64| {
        let options = Tessellation {
            size: PatchSize::Count(4000),
            reach: Reach::Everything,
            seed,
            ..Default::default()
        };
        let mut patches = Patches::new(&tracer, &options).unwrap();
        let options = TraceOptions { rays: Some(64), seed, keep: Keep::Rays, ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let groups = Groups::new(&patches, GroupBy::Object, |_, _| true);
        let all = factors.between_groups(&patches, groups.of_patch(), Progress::default()).unwrap();
        let GroupFactor { form_factor, standard_error, .. } =
            *all.iter().find(|f| f.from == 0 && f.to == Some(1)).unwrap();
        (form_factor - 0.200043776075403) / standard_error
    };
    let mean = (0..SEEDS).map(of_seed).sum::<f64>() / SEEDS as f64;
    // Student's t with 7 degrees of freedom has variance 7/5.
    assert!(mean.abs() < 3.5 * (1.4 / SEEDS as f64).sqrt(), "mean z {mean}");
}

#[test]
fn the_usual_groups_are_objects_else_materials_else_faces() {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let grey = || Material::diffuse("grey", &[0.5]);
    let two = quads(&[(square, 0), (flipped(square), 0)], vec![grey()]);
    assert_eq!(GroupBy::usual(&two), GroupBy::Object);
    assert_eq!(GroupBy::usual(&quads(&[(square, 0)], vec![grey(), grey()])), GroupBy::Face);
    let scratch = scratch();
    scratch.write("a.obj", LIT_BY_NOTHING.replace("o roof\n", ""));
    assert_eq!(GroupBy::usual(&Scene::load(scratch.path("a.obj")).unwrap()), GroupBy::Material);
}

// The command.

/// Two plates that face each other.
const LIT_BY_NOTHING: &str = "mtllib a.mtl
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
o base\nusemtl dull\nf 1 2 3 4\no roof\nusemtl black\nf 8 7 6 5\n";

fn scratch() -> Scratch {
    Scratch::with(&[("a.obj", LIT_BY_NOTHING), ("a.mtl", "newmtl dull\nKd 0.5\nnewmtl black\nKd 0\n")])
}

fn form_factors(scratch: &Scratch, arguments: &str) -> Output {
    let mut command = assert_cmd::cargo::cargo_bin_cmd!("radiosity");
    let arguments = format!("form-factors {arguments}");
    command.current_dir(scratch.folder()).args(arguments.split_whitespace()).output().expect("it runs")
}

#[track_caller]
fn done(scratch: &Scratch, arguments: &str) -> String {
    let output = form_factors(scratch, &format!("{arguments} --patches 200 --rays 64"));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments}: {message}");
    String::from_utf8(output.stdout).unwrap()
}

#[track_caller]
fn refused(scratch: &Scratch, arguments: &str, status: i32, words: &[&str]) {
    let output = form_factors(scratch, arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(status), 0), "{arguments}: {message}");
    assert!(words.iter().all(|word| message.contains(word)), "{arguments}: {message}");
    assert!(status == 2 || message.starts_with("error: "), "{arguments}: {message}");
}

#[test]
fn the_command_needs_no_light_and_writes_one_file() {
    let scratch = scratch();
    let said = done(&scratch, "a.obj");
    assert_eq!(names(&scratch.path("out/a")), ["form_factors.csv"]);
    let pairs = pairs(&scratch.path("out/a/form_factors.csv"));
    let (form_factor, error) = pairs[&("base".into(), "roof".into())];
    assert!((form_factor - 0.199824895698387).abs() < 4.0 * error, "{form_factor} ± {error}");
    assert!(said.contains("from") && said.contains("(escape)") && said.contains("±"), "{said}");
    assert!(said.contains("wrote") && said.contains("form_factors.csv"), "{said}");

    done(&scratch, "a.obj -o deeper/still/F.MTX --by patch");
    done(&scratch, "a.obj -o f.npz --by material");
    assert_eq!(done(&scratch, "a.obj -o f.csv --by face --quiet"), "");
    assert_eq!(names(scratch.folder()), ["a.mtl", "a.obj", "deeper", "f.csv", "f.npz", "out"]);
    assert_eq!(names(&scratch.path("deeper/still")), ["F.MTX"]);
}

#[test]
fn the_summary_names_groups_with_their_areas() {
    let scratch = scratch();
    let summary: Value = serde_json::from_str(&done(&scratch, "a.obj -o f.csv --json --quiet")).unwrap();
    assert_eq!(
        (&summary["scene"], &summary["by"], &summary["file"]),
        (&"a".into(), &"object".into(), &"f.csv".into())
    );
    assert_eq!(summary["rays"], 64);
    assert!(summary["patches"].as_u64().unwrap() > 100);
    assert!(summary["closure"]["after"].as_f64().unwrap() < 1e-12);
    let groups = summary["groups"].as_array().unwrap();
    let of = |key: &str| groups.iter().map(|group| group[key].clone()).collect::<Vec<Value>>();
    assert_eq!(of("name"), ["base", "roof"]);
    assert!(of("area").iter().all(|area| (area.as_f64().unwrap() - 1.0).abs() < 1e-9));
    assert!(of("escape").iter().all(|escape| (0.75..0.85).contains(&escape.as_f64().unwrap())));
    let stages: Vec<&str> =
        summary["stages"].as_array().unwrap().iter().map(|s| s["name"].as_str().unwrap()).collect();
    assert_eq!(stages, ["load", "build", "patch", "trace", "balance", "errors", "write"]);
}

#[test]
fn the_same_seed_gives_the_same_bytes_whatever_the_number_of_threads() {
    let scratch = scratch();
    for by in ["object", "patch"] {
        for extension in ["csv", "mtx", "npz"] {
            let [one, two] = [1, 2].map(|threads| {
                let name = format!("{by}{threads}.{extension}");
                done(&scratch, &format!("a.obj -o {name} --by {by} --seed 7 --threads {threads}"));
                fs::read(scratch.path(&name)).unwrap()
            });
            assert!(one == two, "{by} {extension}");
        }
    }
}

#[test]
fn where_nothing_sees_anything_all_escapes() {
    let apart =
        LIT_BY_NOTHING.replace("f 8 7 6 5", "f 1 2 6").replace("v 0 0 1\nv 1 0 1", "v 2 5 0\nv 3 5 0");
    let scratch = scratch();
    scratch.write("a.obj", apart);
    let output = form_factors(&scratch, "a.obj -o f.csv --json");
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("no face sees another"));
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&summary["patches"], &summary["closure"]), (&0.into(), &Value::Null));
    assert_eq!(summary["groups"][1]["escape"], 1.0);
    assert!(pairs(&scratch.path("f.csv")).into_values().all(|values| values == (0.0, 0.0)));
}

#[test]
fn broken_input_is_refused_and_leaves_no_file() {
    let scratch = scratch();
    scratch.write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
    scratch.write("empty.obj", "v 0 0 0\n");
    let before = names(scratch.folder());
    for name in ["f.txt", "f", "folder/"] {
        refused(&scratch, &format!("a.obj -o {name}"), 2, &["--out", ".csv", ".mtx", ".npz"]);
    }
    refused(&scratch, "a.obj --by colour", 2, &["--by", "material"]);
    refused(&scratch, "a.obj --patches 0", 2, &["--patches"]);
    refused(&scratch, "a.obj --solver cg", 2, &["--solver"]);
    refused(&scratch, "none.obj", 1, &["cannot read", "none.obj"]);
    refused(&scratch, "bad.obj -o f.csv", 1, &["bad.obj:4", "vertex 4"]);
    refused(&scratch, "empty.obj -o f.csv", 1, &["no faces"]);
    refused(&scratch, "a.obj -o f.csv --rays 4", 1, &["4 rays", "between 8 and"]);
    refused(&scratch, "a.obj -o f.csv --memory 16MiB --edge 1e-4", 1, &["--memory"]);
    refused(&scratch, "a.obj -o a.obj/f.csv --rays 8 --patches 10", 1, &["cannot make the folder", "--out"]);
    assert_eq!(names(scratch.folder()), before);
}
