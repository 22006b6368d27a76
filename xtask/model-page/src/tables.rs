//! The tables as Markdown.

use crate::Summary;
use fem_materials::registry::Parameter;

/// A row for each model.
pub fn at_a_glance(models: &[Summary]) -> String {
    let rows = models.iter().map(|model| {
        let dimensions: Vec<String> = model.dimensions.iter().map(usize::to_string).collect();
        row(&[
            names(model.name, model.aliases),
            with_units(model.parameters),
            dimensions.join(", "),
            model.domain.to_owned(),
            if model.decomposes { "SVD" } else { "–" }.to_owned(),
            model.about.to_owned(),
        ])
    });
    let head = "| model | parameters | dim | domain | needs | choose it for |\n|---|---|---|---|---|---|\n";
    head.to_owned() + &rows.collect::<String>()
}

/// A row for each meaning of a parameter, in alphabetical order of the names.
pub fn parameters(models: &[Summary]) -> String {
    let mut meanings: Vec<(&Parameter, Vec<String>)> = Vec::new();
    for model in models {
        for parameter in model.parameters {
            let of = format!("`{}` ({})", model.name, parameter.default);
            match meanings.iter_mut().find(|(p, _)| same(p, parameter)) {
                Some((_, models)) => models.push(of),
                None => meanings.push((parameter, vec![of])),
            }
        }
    }
    meanings.sort_by_key(|(p, _)| p.name.to_lowercase());
    let rows = meanings.iter().map(|(parameter, models)| {
        let unit = if parameter.unit.is_empty() {
            "–"
        } else {
            parameter.unit
        };
        row(&[
            names(parameter.name, parameter.aliases),
            unit.to_owned(),
            parameter.about.to_owned(),
            models.join(", "),
        ])
    });
    let head = "| parameter | unit | meaning | of (a sensible value) |\n|---|---|---|---|\n";
    head.to_owned() + &rows.collect::<String>()
}

/// Whether two parameters are one but for their defaults.
fn same(a: &Parameter, b: &Parameter) -> bool {
    let default = a.default;
    *a == Parameter { default, ..*b }
}

/// Name and other names as code.
fn names(name: &str, aliases: &[&str]) -> String {
    let others: Vec<String> = aliases.iter().map(|alias| format!("`{alias}`")).collect();
    match others.is_empty() {
        true => format!("`{name}`"),
        false => format!("`{name}` ({})", others.join(", ")),
    }
}

/// "`c`, `K` [Pa]; `k2`": neighbors of one unit share it.
fn with_units(parameters: &[Parameter]) -> String {
    let runs = parameters.chunk_by(|a, b| a.unit == b.unit);
    let texts = runs.map(|run| {
        let names: Vec<String> = run.iter().map(|p| names(p.name, p.aliases)).collect();
        let unit = match run.first().map_or("", |p| p.unit) {
            "" => String::new(),
            unit => format!(" [{unit}]"),
        };
        names.join(", ") + &unit
    });
    texts.collect::<Vec<_>>().join("; ")
}

/// One line of a table; a bar in a text does not end its cell.
fn row(cells: &[String]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
    format!("| {} |\n", cells.join(" | "))
}
