//! `cargo xtask models`: renews the tables of `docs/models.md`.

use std::error::Error;
use std::fs;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/models.md");
    let page = fs::read_to_string(&path)?;
    let renewed = model_page::renewed(&page)?;
    if renewed == page {
        println!("docs/models.md is as the models say");
    } else {
        fs::write(&path, renewed)?;
        println!("docs/models.md: tables renewed");
    }
    Ok(())
}
