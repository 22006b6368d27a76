//! A table as curves: the first column to the right, one curve for each other column, cells that hold no
//! number left out.
//!
//! `cargo run -p face-pictures --example plot_csv -- TABLE.csv PICTURE.svg TITLE "WHAT IS UP"`

use face_pictures::{LinePlot, Series};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let [table, picture, title, upwards] = given.as_slice() else {
        return Err("give a table, a picture, a title and what the curves show".into());
    };
    let text = std::fs::read_to_string(table)?;
    let mut rows = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let names = rows.next().ok_or("the table is empty")?;
    let rows: Vec<Vec<&str>> = rows.collect();
    let number = |cell: Option<&&str>| cell.and_then(|c| c.trim().parse::<f64>().ok());
    let (first, others) = names.split_first().ok_or("the table has no columns")?;
    let mut plot = LinePlot::new(title, *first, upwards);
    for (k, name) in others.iter().enumerate() {
        let point = |row: &Vec<&str>| Some([number(row.first())?, number(row.get(k + 1))?]);
        plot = plot.series(Series {
            name: (*name).to_owned(),
            points: rows.iter().filter_map(point).collect(),
        });
    }
    plot.save(Path::new(picture))?;
    Ok(())
}
