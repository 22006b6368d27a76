//! All 128 ways to write a VTU, by a writer that shares nothing with the crate's own.

use super::super::super::{DataArray, MeshFile, Orientation, Orphans, Values, kuhn_grid};
use super::super::xml;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mode {
    Ascii,
    Inline,
    Raw,
    Base64,
}
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Packing {
    Plain,
    Zlib,
    Lz4,
    Lzma,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Variant {
    pub(super) mode: Mode,
    pub(super) packing: Packing,
    pub(super) wide_header: bool,
    pub(super) wide_ids: bool,
    pub(super) big_endian: bool,
    /// Bytes of a block before it is packed.
    pub(super) block: usize,
}

pub(super) fn all(block: usize) -> Vec<Variant> {
    let mut variants = Vec::new();
    for mode in [Mode::Ascii, Mode::Inline, Mode::Raw, Mode::Base64] {
        for packing in [Packing::Plain, Packing::Zlib, Packing::Lz4, Packing::Lzma] {
            for bits in 0..8 {
                variants.push(Variant {
                    mode,
                    packing,
                    wide_header: bits & 1 != 0,
                    wide_ids: bits & 2 != 0,
                    big_endian: bits & 4 != 0,
                    block,
                });
            }
        }
    }
    variants
}

impl Variant {
    fn bytes(&self, number: f64, kind: &str) -> Vec<u8> {
        let mut bytes = match kind {
            "Float64" => number.to_le_bytes().to_vec(),
            "Float32" => (number as f32).to_le_bytes().to_vec(),
            "Int64" => (number as i64).to_le_bytes().to_vec(),
            "Int32" => (number as i32).to_le_bytes().to_vec(),
            _ => vec![number as u8],
        };
        if self.big_endian {
            bytes.reverse();
        }
        bytes
    }

    fn header(&self, words: &[usize]) -> Vec<u8> {
        let word = |&w: &usize| match (self.wide_header, self.big_endian) {
            (true, true) => (w as u64).to_be_bytes().to_vec(),
            (true, false) => (w as u64).to_le_bytes().to_vec(),
            (false, true) => (w as u32).to_be_bytes().to_vec(),
            (false, false) => (w as u32).to_le_bytes().to_vec(),
        };
        words.iter().flat_map(word).collect()
    }

    /// Header and data, as they stand in the file.
    fn binary(&self, data: &[u8]) -> Vec<u8> {
        let raw = self.mode == Mode::Raw;
        let text = |bytes: &[u8]| if raw { bytes.to_vec() } else { base64(bytes) };
        if self.packing == Packing::Plain {
            return text(&[self.header(&[data.len()]), data.to_vec()].concat());
        }
        let packed: Vec<Vec<u8>> = data.chunks(self.block).map(|b| self.pack(b)).collect();
        let mut words = vec![packed.len(), self.block, data.len() % self.block];
        words.extend(packed.iter().map(Vec::len));
        [text(&self.header(&words)), text(&packed.concat())].concat()
    }

    pub(super) fn pack(&self, block: &[u8]) -> Vec<u8> {
        match self.packing {
            Packing::Plain => block.to_vec(),
            Packing::Zlib => miniz_oxide::deflate::compress_to_vec_zlib(block, 6),
            Packing::Lz4 => lz4_flex::block::compress(block),
            Packing::Lzma => xz(block),
        }
    }

    /// A VTU file with the given arrays of numbers: (kind, name, components, numbers).
    fn file(&self, sections: &[(&str, Vec<Array<'_>>)], points: usize, cells: usize) -> Vec<u8> {
        let order = if self.big_endian {
            "BigEndian"
        } else {
            "LittleEndian"
        };
        let header = if self.wide_header { "UInt64" } else { "UInt32" };
        let packer = match self.packing {
            Packing::Plain => String::new(),
            other => {
                let name = format!("{other:?}")
                    .replace("Zlib", "ZLib")
                    .replace("Lz", "LZ");
                format!(
                    " compressor=\"vtk{}DataCompressor\"",
                    name.replace("LZma", "LZMA")
                )
            }
        };
        let mut out = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" \
             byte_order=\"{order}\" header_type=\"{header}\"{packer}><UnstructuredGrid>\
             <Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">"
        )
        .into_bytes();
        let mut appended = Vec::new();
        for (section, arrays) in sections {
            out.extend(format!("<{section}>\n").bytes());
            for &(kind, name, components, ref numbers) in arrays {
                let head = format!(
                    "<DataArray type=\"{kind}\" Name=\"{name}\" \
                     NumberOfComponents=\"{components}\" format="
                );
                out.extend(head.bytes());
                let data: Vec<u8> = numbers.iter().flat_map(|&x| self.bytes(x, kind)).collect();
                match self.mode {
                    Mode::Ascii => {
                        let text: String = numbers.iter().map(|x| format!(" {x:?}")).collect();
                        let text = if kind.starts_with('F') {
                            text
                        } else {
                            text.replace(".0", "")
                        };
                        out.extend(format!("\"ascii\">\n{text}\n</DataArray>\n").bytes());
                    }
                    Mode::Inline => {
                        out.extend(b"\"binary\">\n  ");
                        out.extend(self.binary(&data));
                        out.extend(b"\n</DataArray>\n");
                    }
                    _ => {
                        out.extend(
                            format!("\"appended\" offset=\"{}\"/>\n", appended.len()).bytes(),
                        );
                        appended.extend(self.binary(&data));
                    }
                }
            }
            out.extend(format!("</{section}>\n").bytes());
        }
        out.extend(b"</Piece></UnstructuredGrid>");
        if matches!(self.mode, Mode::Raw | Mode::Base64) {
            let encoding = if self.mode == Mode::Raw {
                "raw"
            } else {
                "base64"
            };
            out.extend(format!("<AppendedData encoding=\"{encoding}\">\n   _").bytes());
            out.extend(appended);
            out.extend(b"\n</AppendedData>");
        }
        out.extend(b"</VTKFile>\n");
        out
    }

    pub(super) fn written(&self, file: &MeshFile) -> Vec<u8> {
        fn arrays(of: &[DataArray]) -> Vec<Array<'_>> {
            let each = of.iter().map(|array| match &array.values {
                Values::Floats(v) => ("Float64", array.name.as_str(), array.components, v.clone()),
                Values::Integers(v) => {
                    let numbers = v.iter().map(|&x| x as f64).collect();
                    ("Int32", array.name.as_str(), array.components, numbers)
                }
            });
            each.collect()
        }
        let ids = if self.wide_ids { "Int64" } else { "Int32" };
        let whole = |v: &[u32]| v.iter().map(|&x| f64::from(x)).collect();
        let sections = [
            ("PointData", arrays(&file.point_data)),
            ("CellData", arrays(&file.cell_data)),
            (
                "Points",
                vec![("Float64", "Points", 3, file.points.as_flattened().to_vec())],
            ),
            (
                "Cells",
                vec![
                    (ids, "connectivity", 1, whole(&file.connectivity)),
                    (ids, "offsets", 1, whole(&file.offsets)),
                    (
                        "UInt8",
                        "types",
                        1,
                        file.cell_types.iter().map(|&t| t.into()).collect(),
                    ),
                ],
            ),
        ];
        self.file(&sections, file.points.len(), file.cell_types.len())
    }
}

type Array<'a> = (&'a str, &'a str, usize, Vec<f64>);

fn base64(bytes: &[u8]) -> Vec<u8> {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = Vec::new();
    for at in 0..(8 * bytes.len()).div_ceil(6) {
        let bit = |k: usize| {
            bytes
                .get(k / 8)
                .map_or(0, |b| usize::from(b >> (7 - k % 8) & 1))
        };
        text.push(DIGITS[(0..6).fold(0, |digit, k| 2 * digit + bit(6 * at + k))]);
    }
    text.resize(text.len().next_multiple_of(4), b'=');
    text
}

/// One block in an .xz container: header, LZMA2, CRC-32; VTK's reader wants the index behind it, ours does not.
fn xz(block: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let crc = |bytes: &[u8]| {
        let mut crc = !0_u32;
        for &byte in bytes {
            crc ^= u32::from(byte);
            for _ in 0..8 {
                crc = crc >> 1 ^ (0xEDB8_8320 * (crc & 1));
            }
        }
        (!crc).to_le_bytes()
    };
    let options = lzma_rust2::Lzma2Options::with_preset(6);
    let mut writer = lzma_rust2::Lzma2Writer::new(Vec::new(), options);
    writer.write_all(block).expect("in memory");
    let mut data = writer.finish().expect("in memory");
    data.resize(data.len().next_multiple_of(4), 0);
    let flags = [0, 1];
    // Twelve bytes with the check; no sizes; LZMA2 with a dictionary of 8 MiB.
    let head = [2, 0, 0x21, 1, 22, 0, 0, 0];
    let mut out = b"\xFD7zXZ\0".to_vec();
    out.extend(flags);
    out.extend(crc(&flags));
    out.extend(head);
    out.extend(crc(&head));
    out.extend(data);
    out.extend(crc(block));
    out
}

pub(super) fn mesh() -> MeshFile {
    let mesh = kuhn_grid(2, 2, 2, [0.1, 0.2, 0.3]).expect("a grid");
    let heat: Vec<f64> = mesh.nodes().iter().map(|x| x[2] / 3.0).collect();
    let fibers: Vec<[f64; 3]> = (0..mesh.num_elements())
        .map(|e| [1.0 / (e + 1) as f64, -0.0, 1e-300])
        .collect();
    MeshFile::from_tets(&mesh)
        .with_point_data(DataArray::scalars("heat", &heat))
        .with_cell_data(DataArray::vectors("fiber", &fibers))
        .with_cell_data(DataArray::integers("label", (0..48).map(|e| e % 5 - 1)))
}

/// Blocks of 256 bytes: some arrays end with a full one, whose size in the header is 0.
#[test]
fn every_way_to_write_a_vtu_is_read() {
    let file = mesh();
    for variant in all(256) {
        let grid = xml::read(&variant.written(&file))
            .unwrap_or_else(|error| panic!("{variant:?}: {error}"));
        let back = MeshFile {
            path: file.path.clone(),
            points: grid.points,
            connectivity: grid.connectivity,
            offsets: grid.offsets,
            cell_types: grid.types,
            point_data: grid.point_data,
            cell_data: grid.cell_data,
        };
        assert_eq!(back, file, "{variant:?}");
        back.tet_mesh(Orientation::Refuse, Orphans::Refuse)
            .expect("tets");
    }
}

/// Before the underscore of raw data there may be any space, and a later underscore is data.
#[test]
fn the_first_underscore_starts_the_appended_data() {
    let variant = all(32_768)
        .into_iter()
        .find(|v| v.mode == Mode::Raw)
        .expect("raw");
    let mut bytes = variant.written(&mesh());
    let tag = b"<AppendedData encoding=\"raw\">";
    let start = bytes.windows(tag.len()).position(|w| w == tag);
    let start = start.expect("appended data") + tag.len();
    let underscore = bytes[start..].iter().position(|&b| b == b'_');
    let at = start + underscore.expect("an underscore");
    bytes.splice(at..at, b"\r\n\t  ".iter().copied());
    assert!(xml::read(&bytes).is_ok());
    bytes[at + 5] = b' ';
    assert!(xml::read(&bytes).is_err());
}
