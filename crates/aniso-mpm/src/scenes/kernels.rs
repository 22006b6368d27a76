use super::Deviation;
use super::read::{Report, at, list, number, numbers, relative, vectors};
use crate::float::worse;
use crate::kernels::{Cubic, Linear, Quadratic, Spline, Stencil, for_each_node};
use serde_json::Value;
use std::collections::BTreeMap;

const TOLERANCE: f64 = 1e-12;

pub fn compare(file: &Value) -> Result<Vec<Deviation>, String> {
    let mut worst = BTreeMap::new();
    for case in list(file, "cases")? {
        match number(case, "dim")? as usize {
            2 => rows::<2>(case, &mut worst)?,
            3 => rows::<3>(case, &mut worst)?,
            other => return Err(format!("dimension {other}")),
        }
    }
    Ok(worst
        .into_iter()
        .map(|(name, error)| Deviation {
            name,
            error,
            tolerance: TOLERANCE,
        })
        .collect())
}

fn rows<const D: usize>(case: &Value, worst: &mut BTreeMap<String, f64>) -> Result<(), String> {
    let h = number(case, "h")?;
    let per_axis = number(case, "nodes_per_axis")? as usize;
    for row in list(case, "rows")? {
        match at(row, "kernel")?.as_str() {
            Some("linear") => one::<Linear, D>(row, h, per_axis, worst)?,
            Some("quadratic") => one::<Quadratic, D>(row, h, per_axis, worst)?,
            Some("cubic") => one::<Cubic, D>(row, h, per_axis, worst)?,
            other => return Err(format!("kernel {other:?}")),
        }
    }
    Ok(())
}

fn one<K: Spline, const D: usize>(
    row: &Value,
    h: f64,
    per_axis: usize,
    worst: &mut BTreeMap<String, f64>,
) -> Result<(), String> {
    let x = vectors::<D>(row, "x")?;
    let x = x.first().ok_or("`x` is empty")?;
    let stencil = Stencil::<f64, D>::new::<K>(x, h);
    let kernel = at(row, "kernel")?.as_str().unwrap_or_default();
    let mut report = Report {
        prefix: format!("{D}D/{kernel}"),
        deviations: Vec::new(),
    };
    let flat =
        |m: &[[f64; 4]; D]| -> Vec<f64> { m.iter().flat_map(|r| r[..K::WIDTH].to_vec()).collect() };
    let base = stencil.base.map(f64::from);
    report.push("base", relative(&base, &numbers(row, "base")?), TOLERANCE);
    for (key, ours) in [
        ("w", flat(&stencil.w)),
        ("dw", flat(&stencil.dw)),
        ("ddw", flat(&stencil.ddw)),
    ] {
        if row.get(key).is_some() {
            report.push(key, relative(&ours, &numbers(row, key)?), TOLERANCE);
        }
    }
    if let Some(full) = row.get("full") {
        let nodes: Vec<i128> = numbers(full, "nodes")?.iter().map(|&n| n as i128).collect();
        let (mut w, mut gradient, mut laplacian) = (
            vec![0.0; nodes.len()],
            vec![0.0; nodes.len() * D],
            vec![0.0; nodes.len()],
        );
        for_each_node::<D>(K::WIDTH, |n| {
            // Wide enough for what no file should hold.
            let along = |a: usize| i128::from(stencil.base[a]) + n[a] as i128;
            let stride = |a: usize| (per_axis as i128).wrapping_pow(a as u32);
            let place = (0..D).fold(0, |sum: i128, a| {
                sum.wrapping_add(along(a).wrapping_mul(stride(a)))
            });
            if let Some(at) = nodes.iter().position(|&node| node == place) {
                w[at] = stencil.weight(n);
                gradient[at * D..(at + 1) * D].copy_from_slice(&stencil.gradient(n));
                laplacian[at] = stencil.laplacian(n);
            }
        });
        for (key, ours) in [("w", w), ("grad", gradient), ("laplacian", laplacian)] {
            if full.get(key).is_some() {
                let name = format!("all nodes {key}");
                report.push(&name, relative(&ours, &numbers(full, key)?), TOLERANCE);
            }
        }
    }
    for deviation in report.deviations {
        let entry = worst.entry(deviation.name).or_insert(0.0f64);
        *entry = worse(*entry, deviation.error);
    }
    Ok(())
}
