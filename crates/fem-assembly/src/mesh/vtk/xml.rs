//! Reading VTU files: unstructured grids in VTK's XML.

use super::super::array::{DataArray, Values};
use super::base64;
use super::blocks::{Compressor, Encoding, Source};
use super::grid::{Grid, Problem};
use super::scalar::{Scalar, Unreadable};
use roxmltree::{Document, Node};
use std::borrow::Cow;

pub(super) fn read(bytes: &[u8]) -> Result<Grid, Problem> {
    let (text, appended) = split(bytes)?;
    let document = Document::parse(&text).map_err(|error| Problem::Xml(error.to_string()))?;
    let root = document.root_element();
    if !root.has_tag_name("VTKFile") {
        return Err(Problem::Other("the file is no VTK file".into()));
    }
    if root.attribute("type") != Some("UnstructuredGrid") {
        return Err(Problem::NoGrid);
    }
    let file = File {
        encoding: encoding(root)?,
        appended,
    };
    let grid = child(root, "UnstructuredGrid").ok_or(Problem::NoGrid)?;
    let mut pieces = grid.children().filter(|n| n.has_tag_name("Piece"));
    match (pieces.next(), pieces.next()) {
        (Some(piece), None) => file.piece(piece),
        (Some(_), Some(_)) => Err(Problem::Other(
            "the grid comes in several pieces; merge them first".into(),
        )),
        _ => Err(Problem::Other("the grid is empty".into())),
    }
}

/// What stands behind the underscore of `AppendedData`; it need not be text.
enum Appended<'a> {
    None,
    Raw(&'a [u8]),
    Base64(&'a [u8]),
}

/// The XML, and the appended data that would spoil it.
fn split(bytes: &[u8]) -> Result<(Cow<'_, str>, Appended<'_>), Problem> {
    const TAG: &[u8] = b"<AppendedData";
    let text = |bytes| {
        str::from_utf8(bytes)
            .map_err(|_| Problem::Other("the file is damaged, or its text is not UTF-8".into()))
    };
    let starts = |&at: &usize| bytes[at] == b'<' && bytes[at..].starts_with(TAG);
    let Some(start) = (0..bytes.len()).find(starts) else {
        return Ok((Cow::Borrowed(text(bytes)?), Appended::None));
    };
    let cut_off = || Problem::Other("the file is cut off in its appended data".into());
    let tag = &bytes[start..];
    let end = tag.iter().position(|&b| b == b'>').ok_or_else(cut_off)?;
    let first = tag[end..]
        .iter()
        .position(|&b| b == b'_')
        .ok_or_else(cut_off)?;
    let data = &tag[end + first + 1..];
    let attributes = text(&tag[TAG.len()..end])?;
    let appended = if attributes.contains("raw") {
        Appended::Raw(data)
    } else {
        let end = data.iter().position(|&b| b == b'<').unwrap_or(data.len());
        Appended::Base64(&data[..end])
    };
    let head = text(&bytes[..start])?;
    Ok((Cow::Owned(format!("{head}</VTKFile>")), appended))
}

fn encoding(root: Node<'_, '_>) -> Result<Encoding, Problem> {
    let unknown = |what: &str, value: &str| {
        let cure = "write it as ASCII, uncompressed binary, zlib, LZ4 or LZMA";
        Err(Problem::Other(format!(
            "{what} \"{value}\" is not known; {cure}"
        )))
    };
    let compressor = match root.attribute("compressor") {
        None | Some("") => None,
        Some("vtkZLibDataCompressor") => Some(Compressor::Zlib),
        Some("vtkLZ4DataCompressor") => Some(Compressor::Lz4),
        Some("vtkLZMADataCompressor") => Some(Compressor::Lzma),
        Some(other) => return unknown("the compressor", other),
    };
    Ok(Encoding {
        little_endian: match root.attribute("byte_order") {
            None | Some("LittleEndian") => true,
            Some("BigEndian") => false,
            Some(other) => return unknown("the byte order", other),
        },
        wide_header: match root.attribute("header_type") {
            None | Some("UInt32") => false,
            Some("UInt64") => true,
            Some(other) => return unknown("the header type", other),
        },
        compressor,
    })
}

fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    node.children().find(|n| n.has_tag_name(name))
}

/// The data arrays of a section; none where there is no such section.
fn arrays<'a, 'input>(piece: Node<'a, 'input>, section: &str) -> Vec<Node<'a, 'input>> {
    let nodes = child(piece, section).into_iter().flat_map(|n| n.children());
    nodes.filter(|n| n.has_tag_name("DataArray")).collect()
}

/// What all arrays of a file have in common.
struct File<'a> {
    encoding: Encoding,
    appended: Appended<'a>,
}

impl File<'_> {
    fn piece(&self, piece: Node<'_, '_>) -> Result<Grid, Problem> {
        let count = |name: &str| {
            let text = piece.attribute(name).map(str::trim);
            let number = text.and_then(|text| text.parse::<usize>().ok());
            number.ok_or_else(|| Problem::Other(format!("its Piece does not say its {name}")))
        };
        let (points, cells) = (count("NumberOfPoints")?, count("NumberOfCells")?);
        let mut grid = Grid::default();
        match arrays(piece, "Points").first() {
            Some(&array) => grid.set_points(self.values(array, "Points", points, Some(3))?.1)?,
            None if points == 0 => {}
            None => return Err(Problem::Missing("Points")),
        }
        let of_cells = arrays(piece, "Cells");
        let named = |name| {
            let found = of_cells.iter().find(|n| n.attribute("Name") == Some(name));
            found.copied().ok_or(Problem::Missing(name))
        };
        if cells > 0 {
            let (_, ends) = self.values(named("offsets")?, "Cells", cells, Some(1))?;
            let last = grid.set_offsets(ends)?;
            let (_, nodes) = self.values(named("connectivity")?, "Cells", last, Some(1))?;
            grid.set_connectivity(nodes)?;
            grid.set_types(self.values(named("types")?, "Cells", cells, Some(1))?.1)?;
        }
        grid.point_data = self.data(piece, "PointData", points)?;
        grid.cell_data = self.data(piece, "CellData", cells)?;
        Ok(grid)
    }

    fn data(
        &self,
        piece: Node<'_, '_>,
        section: &'static str,
        count: usize,
    ) -> Result<Vec<DataArray>, Problem> {
        let mut made = Vec::new();
        for array in arrays(piece, section) {
            // Text is nothing that a mesh could use.
            if array.attribute("type") == Some("String") {
                continue;
            }
            let (components, values) = self.values(array, section, count, None)?;
            made.push(DataArray {
                name: array.attribute("Name").unwrap_or_default().to_owned(),
                components,
                values,
            });
        }
        Ok(made)
    }

    /// The numbers of an array with `tuples` entries, and how many each entry has.
    fn values(
        &self,
        array: Node<'_, '_>,
        section: &'static str,
        tuples: usize,
        wanted: Option<usize>,
    ) -> Result<(usize, Values), Problem> {
        let problem = |reason: String| Problem::Array {
            section,
            name: array.attribute("Name").unwrap_or_default().to_owned(),
            reason,
        };
        let kind = array.attribute("type").unwrap_or_default();
        let scalar = Scalar::of_xml(kind)
            .ok_or_else(|| problem(format!("its type \"{kind}\" is not known")))?;
        let components = match array.attribute("NumberOfComponents").map(str::trim) {
            None => 1,
            Some(text) => text
                .parse::<usize>()
                .map_err(|_| problem(format!("\"{text}\" is no number of components")))?,
        };
        if wanted.is_some_and(|wanted| wanted != components) {
            return Err(problem(format!("it has {components} components")));
        }
        let sizes = tuples
            .checked_mul(components)
            .and_then(|count| Some((count, scalar.bytes_of(count)?)));
        let (count, bytes) = sizes.ok_or_else(|| {
            problem(format!(
                "{tuples} times {components} numbers are more than fit anywhere"
            ))
        })?;
        let text = text_of(array);
        let source = match array.attribute("format") {
            None | Some("ascii") => {
                let values = ascii(scalar, text.as_bytes(), count);
                return values.map(|v| (components, v)).map_err(problem);
            }
            Some("binary") => Source::Base64(base64::Decoder::new(text.as_bytes())),
            Some("appended") => self.appended(array).map_err(problem)?,
            Some(other) => return Err(problem(format!("its format \"{other}\" is not known"))),
        };
        let bytes = self
            .encoding
            .read(source, bytes)
            .map_err(|e| problem(e.to_string()))?;
        let values = scalar.decode(&bytes, self.encoding.little_endian, count);
        Ok((components, values))
    }

    fn appended(&self, array: Node<'_, '_>) -> Result<Source<'_>, String> {
        let offset = array.attribute("offset").map(str::trim);
        let offset = offset.and_then(|text| text.parse::<usize>().ok());
        let offset = offset.ok_or("it is appended, but its offset is missing")?;
        let beyond = || format!("its offset {offset} lies behind the end of the file");
        match self.appended {
            Appended::None => Err("it is appended, but the file has no AppendedData".into()),
            Appended::Raw(data) => data.get(offset..).map(Source::Raw).ok_or_else(beyond),
            Appended::Base64(data) => {
                let text = data.get(offset..).ok_or_else(beyond)?;
                Ok(Source::Base64(base64::Decoder::new(text)))
            }
        }
    }
}

fn ascii(scalar: Scalar, text: &[u8], count: usize) -> Result<Values, String> {
    let mut words = text
        .split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty());
    let values = scalar
        .parse(&mut words, count, text.len())
        .map_err(|why| match why {
            Unreadable::End { found } => format!("it has {found} numbers, the grid needs {count}"),
            Unreadable::Word(word) => format!("\"{word}\" is no number of its type"),
        })?;
    match words.count() {
        0 => Ok(values),
        more => Err(format!(
            "it has {} numbers, the grid needs {count}",
            count + more
        )),
    }
}

/// The text of an array beside what VTK says about it in elements.
fn text_of<'a>(array: Node<'a, '_>) -> Cow<'a, str> {
    let mut all = Cow::Borrowed("");
    for text in array
        .children()
        .filter(Node::is_text)
        .filter_map(|n| n.text())
    {
        if all.trim_ascii().is_empty() {
            all = Cow::Borrowed(text);
        } else if !text.trim_ascii().is_empty() {
            all.to_mut().push_str(text);
        }
    }
    all
}
