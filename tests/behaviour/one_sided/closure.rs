//! Rows sum to one with what escapes, and form factors are reciprocal.

use std::collections::BTreeMap;

use radiosity::patches::Reach;

use super::{Effort, FRONTS, by_object, data, factor, records};
use crate::scenes::{grey, quads, room};
use crate::scratch::Scratch;

#[test]
fn rows_and_what_escapes_sum_to_one_and_groups_are_reciprocal() {
    let sheet = [[0.2, 0.3, 0.5], [0.8, 0.3, 0.5], [0.8, 0.7, 0.5], [0.2, 0.7, 0.5]];
    let mut all: Vec<_> = room([0.0; 3], [1.0; 3])[..5].iter().map(|&quad| (quad, 0)).collect();
    all.push((sheet, 0));
    let open = quads(&all, grey(0.5));
    for reach in [FRONTS, Reach::Everything] {
        by_object(&open, reach, Effort { patches: 300, rays: 64, seed: 1 }, |table| {
            let groups = table.groups().all();
            assert_eq!(groups.len(), 7, "light lands on the sheet's back");
            assert_eq!(table.senders().count(), if reach == FRONTS { 6 } else { 7 });
            assert_eq!(table.receivers().count(), 7);
            let onto_back = factor(table, "quad 2", "quad 5 (back)").form_factor;
            assert!(onto_back > 0.1, "the floor sees the sheet from below: {onto_back}");
            for a in table.senders() {
                let row = table.full_row(a);
                let sum: f64 = row.iter().map(|entry| entry.form_factor).sum();
                assert!((sum + table.escape(a).form_factor - 1.0).abs() < 1e-9, "{}", groups[a].name);
                for b in table.senders() {
                    let there = groups[a].area * row[b].form_factor;
                    let back = groups[b].area * table.full_row(b)[a].form_factor;
                    assert!((there - back).abs() <= 1e-9 * there, "{} {}", groups[a].name, groups[b].name);
                }
            }
        });
    }
}

#[test]
fn rows_of_files_sum_to_one_with_what_escapes() {
    for name in ["slit_boxes", "raystrack_canyon", "ratio_1e6"] {
        for sides in ["front", "back", "both"] {
            let scratch = Scratch::new();
            let file = data(name);
            let (records, _) = records(&scratch, &format!("{} --by object --sides {sides}", file.display()));
            let mut sums: BTreeMap<String, f64> = BTreeMap::new();
            let number = |record: &BTreeMap<String, String>, key: &str| record[key].parse::<f64>().unwrap();
            for record in &records {
                let sum = sums.entry(record["from"].clone()).or_insert(number(record, "escape"));
                *sum += number(record, "form_factor");
                assert!(number(record, "upper95") >= number(record, "form_factor"));
                assert!(number(record, "from_area") > 0.0 && number(record, "escape_error") >= 0.0);
            }
            assert!(!sums.is_empty());
            for (from, sum) in sums {
                assert!((sum - 1.0).abs() < 1e-9, "{name} {sides}: {from}: {sum}");
            }
        }
    }
}
