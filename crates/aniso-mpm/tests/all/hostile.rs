//! Scene files that someone has damaged: compared, or refused with a word; never a panic.

use crate::fuzz::EFFORT;
use aniso_mpm::scenes;
use serde_json::{Value, json};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Marsaglia's xorshift: the same damage in every run.
struct Damage(u64);

impl Damage {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % bound.max(1)
    }

    fn other(&mut self) -> Value {
        let numbers = [
            0.0,
            -0.0,
            -1.0,
            1.0,
            2.5,
            1e-320,
            1e-300,
            1e300,
            -1e300,
            4294967296.0,
            1.8e19,
        ];
        match self.below(16) {
            0 => Value::Null,
            1 => json!("?"),
            2 => json!([]),
            3 => json!({}),
            4 => json!([[1, 2], [3]]),
            _ => json!(numbers[self.below(numbers.len())]),
        }
    }

    /// Changes something in a value: a leaf, the length of a list, a field.
    fn of(&mut self, value: &mut Value) {
        let deeper = self.below(8) != 0;
        match value {
            Value::Array(items) if deeper && !items.is_empty() => {
                let at = self.below(items.len());
                match self.below(6) {
                    0 => drop(items.remove(at)),
                    1 => {
                        let twice = items[at].clone();
                        items.insert(at, twice);
                    }
                    2 => items.truncate(at),
                    _ => self.of(&mut items[at]),
                }
            }
            Value::Object(fields) if deeper && !fields.is_empty() => {
                let names: Vec<String> = fields.keys().cloned().collect();
                let name = &names[self.below(names.len())];
                match self.below(12) {
                    0 => drop(fields.remove(name)),
                    _ => self.of(&mut fields[name]),
                }
            }
            _ => *value = self.other(),
        }
    }
}

const H: f64 = 0.1;
/// Nodes on each axis of the files' grid.
const PER_AXIS: usize = 12;

fn places<const D: usize>(count: usize) -> Vec<Vec<f64>> {
    let at = |p: usize, a: usize| 0.45 + 0.037 * ((p * (3 + 2 * a)) % 7) as f64;
    let place = |p| (0..D).map(|a| at(p, a)).collect();
    (0..count).map(place).collect()
}

/// A few numbers that differ.
fn some(count: usize) -> Vec<f64> {
    (0..count).map(|k| 0.1 + 0.07 * (k % 5) as f64).collect()
}

fn rows(count: usize, width: usize) -> Vec<Vec<f64>> {
    (0..count).map(|k| some(width + k)[k..].to_vec()).collect()
}

fn kernels() -> Value {
    let row = |kernel: &str| {
        json!({ "kernel": kernel, "x": [0.51, 0.62], "base": [4, 5], "w": rows(2, 4),
            "dw": rows(2, 4), "full": { "nodes": [64, 65], "w": some(2), "grad": rows(2, 2) } })
    };
    let kernels = ["linear", "quadratic", "cubic"].map(row);
    json!({ "cases": [{ "dim": 2, "h": H, "nodes_per_axis": PER_AXIS, "rows": kernels }] })
}

fn damage<const D: usize>() -> Value {
    let count = 3;
    let flat = |k: usize| PER_AXIS.pow(k as u32);
    let node = 5 * (0..D).map(flat).sum::<usize>();
    let list = some(count);
    let implicit = json!({ "c": some(2), "c_particle_d": some(2), "A_diagonal": some(2),
        "B_mls_diagonal": some(2), "B_bspline_diagonal": some(2), "B_mls_times_probe": some(2),
        "B_bspline_times_probe": some(2), "probe": some(2),
        "solutions": { "mls/grid_d": { "d_grid": some(2), "d_particles": list } } });
    let given = json!({ "symmetry": "two", "alpha": [-0.5, 0.5], "a1": rows(count, D),
        "a2": rows(count, D), "l0": 0.05, "zeta": 1.0, "sigma_crit": 1.0, "eta": 0.4,
        "x": places::<D>(count), "d": list, "h": H, "F": rows(count, D * D),
        "sigma": rows(count, D * D), "V": list, "D_history": list });
    let found = json!({ "structural_tensor": [], "sigma_plus": [], "Phi": list, "D_tilde": list,
        "nodes_per_axis": PER_AXIS, "active_nodes": [node, node + 1], "d_grid": some(2),
        "laplacian": list, "dt_explicit": 0.002, "D_c": list, "d_explicit": list,
        "dt_implicit": 0.1, "implicit": implicit });
    let uniform = json!({ "eta": 0.4, "d": 0.1, "D_tilde": 2.0, "dt": 0.1, "d_new": 0.3,
        "dt_explicit": 0.01, "explicit_d_new": 0.2 });
    json!({ "uniform_closed_form": uniform, "cases": [both(given, found)] })
}

/// The fields of two objects.
fn both(mut a: Value, mut b: Value) -> Value {
    if let (Some(a), Some(b)) = (a.as_object_mut(), b.as_object_mut()) {
        a.append(b);
    }
    a
}

fn inextensibility<const D: usize>() -> Value {
    let count = 5;
    let flat = |k: usize| PER_AXIS.pow(k as u32);
    let node = 5 * (0..D).map(flat).sum::<usize>();
    let first = |k: usize| (0..D).map(|a| f64::from(u8::from(a == k % D))).collect();
    let directions: Vec<Vec<f64>> = (0..count).map(first).collect();
    let given = json!({ "fibres": "some", "nodes_per_axis": PER_AXIS, "x": places::<D>(count),
        "V": some(count), "a": directions, "h": H, "nodes": [node, node + 1],
        "cells": [node, node - 1], "probe_cells": some(2), "particle_mass": some(count) });
    let found = json!({ "dt": 0.01, "node_mass": some(2), "v_n": rows(2, D),
        "sigma": rows(count, D * D), "b": rows(2, D), "r": some(2), "Bt_times_probe": rows(2, D),
        "L_times_probe": some(2), "L_diagonal": some(2), "v": rows(2, D) });
    json!({ "cases": [both(given, found)] })
}

fn kkt() -> Value {
    json!({ "H": [[3.0, 0.5], [0.5, 2.0]], "g": [1.0, -1.0], "kappa": 0.3, "G": [[1.0, 2.0]],
        "h0": [0.4], "exact": { "x": some(2), "lambda": some(1) },
        "relaxed": [{ "eta": -1e3, "x": some(2), "lambda": some(1), "x_iterates": rows(2, 2),
            "checks": { "distance_to_exact": 0.1 } }] })
}

#[test]
fn damaged_scenes_are_compared_or_refused() {
    let files = [
        ("c1_kernels", kernels()),
        ("c2_damage_2d", damage::<2>()),
        ("c2_damage_3d", damage::<3>()),
        ("c3_inextensibility_2d", inextensibility::<2>()),
        ("c3_inextensibility_3d", inextensibility::<3>()),
        ("c4_kkt", kkt()),
    ];
    let mut damage = Damage(0x5931_a7b3_f7df_b7fd);
    for (name, file) in &files {
        // Whole as far as a reader can tell: everything is compared, and nothing agrees.
        let whole = scenes::compare(name, file).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(whole.iter().any(|d| !d.is_good()), "{name}");
        let (mut compared, mut refused) = (0, 0);
        for _ in 0..400 * EFFORT {
            let mut broken = file.clone();
            (0..=damage.below(3)).for_each(|_| damage.of(&mut broken));
            let result = catch_unwind(AssertUnwindSafe(|| scenes::compare(name, &broken)));
            match result.unwrap_or_else(|_| panic!("{name}: {broken}")) {
                Ok(_) => compared += 1,
                Err(message) => {
                    assert!(!message.is_empty(), "{name}: {broken}");
                    refused += 1;
                }
            }
        }
        assert!(
            compared > 10 && refused > 10,
            "{name}: {compared}, {refused}"
        );
    }
}
