//! Writing VTU files (zlib, base64) and legacy files (4.2, binary).

use super::super::array::{DataArray, Values};
use super::super::file::MeshFile;
use super::base64;
use std::borrow::Cow;

/// What neither format could hold, or hold so that it can be read again.
pub(super) fn check(file: &MeshFile) -> Result<(), String> {
    for array in file.point_data.iter().chain(&file.cell_data) {
        let control = |c: char| c.is_control() && !matches!(c, '\t' | '\n' | '\r');
        if array.name.is_empty() || array.name.contains(control) {
            let name = array.name.escape_debug();
            return Err(format!(
                "\"{name}\" cannot name an array: give it a name in letters"
            ));
        }
    }
    let whole = file.offsets.len() == file.cell_types.len()
        && file.offsets.is_sorted()
        && file.offsets.last().map_or(0, |&end| end as usize) == file.connectivity.len();
    if !whole {
        return Err("the offsets of its cells do not fit its connectivity and types".into());
    }
    let mut start = 0;
    for (cell, (&end, &kind)) in file.offsets.iter().zip(&file.cell_types).enumerate() {
        let (found, wanted) = (end - start, nodes_of(kind));
        if wanted.is_some_and(|wanted| wanted != found) {
            return Err(format!("cell {cell} of VTK type {kind} has {found} points"));
        }
        start = end;
    }
    Ok(())
}

/// How many points a cell has, where it is of a kind that this crate makes.
fn nodes_of(kind: u8) -> Option<u32> {
    match kind {
        5 => Some(3),
        10 => Some(4),
        22 => Some(6),
        24 => Some(10),
        _ => None,
    }
}

/// Bytes of a block before it is compressed, VTK's default.
const BLOCK: usize = 32_768;
const LEVEL: u8 = 5;

/// A VTU file with compressed arrays inside the XML, little-endian, with 64-bit headers.
pub(super) fn xml(file: &MeshFile) -> Vec<u8> {
    let mut out = Xml(Vec::new());
    out.text("<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" ");
    out.text("byte_order=\"LittleEndian\" header_type=\"UInt64\" ");
    out.text("compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n");
    out.text(&format!(
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
        file.points.len(),
        file.cell_types.len()
    ));
    for (section, arrays) in [
        ("PointData", &file.point_data),
        ("CellData", &file.cell_data),
    ] {
        out.text(&format!("<{section}>\n"));
        for array in arrays {
            let (kind, bytes) = match &array.values {
                Values::Floats(v) => ("Float64", little(v, |x| x.to_le_bytes())),
                Values::Integers(v) => ("Int64", little(v, |x| x.to_le_bytes())),
            };
            out.array(kind, &array.name, array.components, &bytes);
        }
        out.text(&format!("</{section}>\n"));
    }
    out.text("<Points>\n");
    let points = little(file.points.as_flattened(), |x| x.to_le_bytes());
    out.array("Float64", "Points", 3, &points);
    out.text("</Points>\n<Cells>\n");
    let wide = |x: u32| i64::from(x).to_le_bytes();
    out.array(
        "Int64",
        "connectivity",
        1,
        &little(&file.connectivity, wide),
    );
    out.array("Int64", "offsets", 1, &little(&file.offsets, wide));
    out.array("UInt8", "types", 1, &file.cell_types);
    out.text("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
    out.0
}

fn little<T: Copy, const N: usize>(values: &[T], bytes: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    values.iter().flat_map(|&v| bytes(v)).collect()
}

struct Xml(Vec<u8>);

impl Xml {
    fn text(&mut self, text: &str) {
        self.0.extend_from_slice(text.as_bytes());
    }

    fn array(&mut self, kind: &str, name: &str, components: usize, bytes: &[u8]) {
        let name = escape(name);
        self.text(&format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
             format=\"binary\">"
        ));
        let blocks: Vec<Vec<u8>> = bytes
            .chunks(BLOCK)
            .map(|block| miniz_oxide::deflate::compress_to_vec_zlib(block, LEVEL))
            .collect();
        // The size of the last block is 0 where it is full.
        let mut header = vec![blocks.len(), BLOCK, bytes.len() % BLOCK];
        header.extend(blocks.iter().map(Vec::len));
        let header = little(&header, |x| (x as u64).to_le_bytes());
        base64::encode(&header, &mut self.0);
        base64::encode(&blocks.concat(), &mut self.0);
        self.text("</DataArray>\n");
    }
}

/// An attribute of XML.
fn escape(text: &str) -> Cow<'_, str> {
    let special = |c: char| matches!(c, '&' | '<' | '>' | '"' | '\t' | '\n' | '\r');
    if !text.contains(special) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\t' | '\n' | '\r' => escaped.push_str(&format!("&#{};", u32::from(c))),
            _ => escaped.push(c),
        }
    }
    Cow::Owned(escaped)
}

/// A legacy file; 4.2 is what every program reads.
pub(super) fn legacy(file: &MeshFile) -> Vec<u8> {
    let cells = file.cell_types.len();
    let mut out = b"# vtk DataFile Version 4.2\nmesh\nBINARY\nDATASET UNSTRUCTURED_GRID\n".to_vec();
    out.extend_from_slice(format!("POINTS {} double\n", file.points.len()).as_bytes());
    big(&mut out, file.points.as_flattened(), |x| x.to_be_bytes());
    let size = cells + file.connectivity.len();
    out.extend_from_slice(format!("CELLS {cells} {size}\n").as_bytes());
    let mut start = 0;
    for &end in &file.offsets {
        out.extend_from_slice(&(end - start).to_be_bytes());
        for &node in &file.connectivity[start as usize..end as usize] {
            out.extend_from_slice(&node.to_be_bytes());
        }
        start = end;
    }
    out.extend_from_slice(format!("\nCELL_TYPES {cells}\n").as_bytes());
    big(&mut out, &file.cell_types, |x| i32::from(x).to_be_bytes());
    section(&mut out, "POINT_DATA", file.points.len(), &file.point_data);
    section(&mut out, "CELL_DATA", cells, &file.cell_data);
    out
}

/// The numbers in VTK's order of bytes, then the end of the line.
fn big<T: Copy, const N: usize>(out: &mut Vec<u8>, values: &[T], bytes: impl Fn(T) -> [u8; N]) {
    out.extend(values.iter().flat_map(|&v| bytes(v)));
    out.push(b'\n');
}

fn section(out: &mut Vec<u8>, keyword: &str, count: usize, arrays: &[DataArray]) {
    if arrays.is_empty() {
        return;
    }
    let head = format!("{keyword} {count}\nFIELD FieldData {}\n", arrays.len());
    out.extend_from_slice(head.as_bytes());
    for array in arrays {
        // meshio knows no 64-bit integers in 4.2, so that only those take them that need them.
        let narrow = |v: &[i64]| v.iter().map(|&x| i32::try_from(x).ok()).collect();
        let (kind, small): (_, Option<Vec<i32>>) = match &array.values {
            Values::Floats(_) => ("double", None),
            Values::Integers(v) => match narrow(v) {
                None => ("vtktypeint64", None),
                small => ("int", small),
            },
        };
        let name = encode_name(&array.name);
        let head = format!("{name} {} {count} {kind}\n", array.components);
        out.extend_from_slice(head.as_bytes());
        match (&array.values, small) {
            (_, Some(small)) => big(out, &small, i32::to_be_bytes),
            (Values::Floats(v), _) => big(out, v, f64::to_be_bytes),
            (Values::Integers(v), _) => big(out, v, i64::to_be_bytes),
        }
    }
}

/// As VTK does it: `%` and two digits for whatever is no plain character.
fn encode_name(name: &str) -> String {
    let mut encoded = String::with_capacity(name.len());
    for &byte in name.as_bytes() {
        match byte {
            b'"' | b'%' | 0..=32 | 127.. => encoded.push_str(&format!("%{byte:02X}")),
            plain => encoded.push(plain.into()),
        }
    }
    encoded
}
