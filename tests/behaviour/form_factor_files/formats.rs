//! What each format holds: CSV by pairs, Matrix Market and NumPy by matrix entries.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use radiosity::output::{FactorEntry, FactorTable, OutputError, write_form_factors};
use radiosity::patches::{GroupBy, Groups};

use super::{csv_of, grouped, open_cube_with_a_sheet, pairs, traced, written};
use crate::scratch::{Scratch, names};

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
