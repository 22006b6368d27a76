//! Files that lie: no panic, and no memory beyond what their bytes account for.

use super::super::super::{MeshFile, Orientation, Orphans};
use super::super::grid::Grid;
use super::super::{legacy, write, xml};
use super::fuzz::EFFORT;
use super::variants_tests::{self as variants, Mode, Packing, Variant};
use std::path::{Path, PathBuf};

/// The most address space this process ever had, bytes; 0 where the system does not say.
fn most_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmPeak:"));
    let kilobytes = line.and_then(|l| l.split_whitespace().next()?.parse::<u64>().ok());
    1024 * kilobytes.unwrap_or(0)
}

/// Runs something that must not reserve more than this beside what other tests do meanwhile.
fn within_memory(what: &str, work: impl FnOnce()) {
    let before = most_memory();
    work();
    let grown = most_memory() - before;
    assert!(grown < 1 << 30, "{what}: {} MiB", grown >> 20);
}

/// A VTU of 27 points and 48 cells whose only binary array is `bone`.
fn vtu(compressor: &str, points: &str, header: &[u64], data: &[u8]) -> String {
    let mut binary = Vec::new();
    let header: Vec<u8> = header.iter().flat_map(|w| w.to_le_bytes()).collect();
    super::super::base64::encode(&header, &mut binary);
    super::super::base64::encode(data, &mut binary);
    let binary = String::from_utf8(binary).expect("base64");
    format!(
        "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
         compressor=\"{compressor}\"><UnstructuredGrid><Piece NumberOfPoints=\"{points}\" \
         NumberOfCells=\"0\"><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" \
         Name=\"bone\" format=\"binary\">{binary}</DataArray></Points></Piece></UnstructuredGrid>\
         </VTKFile>"
    )
}

#[test]
fn headers_that_announce_more_than_the_grid_are_refused_by_name() {
    const ZLIB: &str = "vtkZLibDataCompressor";
    within_memory("headers", || {
        for compressor in ["", ZLIB, "vtkLZ4DataCompressor", "vtkLZMADataCompressor"] {
            for header in [
                &[1_000_000_000_000][..],
                &[1, 1_000_000_000_000, 1_000_000_000_000, 19],
                &[1 << 20, 24_576, 0, 1],
                &[u64::MAX, u64::MAX, u64::MAX, 1],
                &[1 << 40, 0, 324, 1],
                &[0, 0, 0],
            ] {
                let text = vtu(compressor, "27", header, b"x");
                let error = xml::read(text.as_bytes()).err().expect("a lie").to_string();
                assert!(error.contains("\"bone\""), "{error}");
                assert!(!error.contains("damaged"), "{error}");
            }
        }
        // The grid itself lies: as many points as the header has bytes for.
        for points in [1_u64 << 31, 1 << 40, 1 << 60, u64::MAX] {
            let bytes = points.wrapping_mul(12);
            for (compressor, header) in [("", vec![bytes]), (ZLIB, vec![1, bytes, 0, 1])] {
                let text = vtu(compressor, &points.to_string(), &header, b"xxx");
                let error = xml::read(text.as_bytes()).err().expect("a lie").to_string();
                assert!(error.contains("\"bone\""), "{error}");
            }
        }
    });
}

/// Zeros pack to a thousandth: a block that unpacks to more than its size is stopped there.
#[test]
fn a_block_does_not_unpack_beyond_its_size() {
    let mut bombs = Vec::new();
    for packing in [Packing::Zlib, Packing::Lz4, Packing::Lzma] {
        let variant = Variant {
            mode: Mode::Inline,
            packing,
            wide_header: true,
            wide_ids: true,
            big_endian: false,
            block: 8 << 20,
        };
        bombs.push((packing, variant.pack(&vec![0; 8 << 20])));
    }
    for (packing, bomb) in &bombs {
        let compressor = match packing {
            Packing::Zlib => "vtkZLibDataCompressor",
            Packing::Lz4 => "vtkLZ4DataCompressor",
            _ => "vtkLZMADataCompressor",
        };
        let text = vtu(compressor, "27", &[1, 324, 0, bomb.len() as u64], bomb);
        let error = xml::read(text.as_bytes())
            .err()
            .expect("a bomb")
            .to_string();
        assert!(
            error.contains("\"bone\"") && error.contains("block 0"),
            "{error}"
        );
        // The same bytes are right where the grid is as large as they are.
        let (points, size) = ((8 << 20) / 12, 8 << 20);
        let text = vtu(
            compressor,
            &points.to_string(),
            &[1, size, 0, bomb.len() as u64],
            bomb,
        );
        let error = xml::read(text.as_bytes())
            .err()
            .expect("8 bytes too many")
            .to_string();
        assert!(error.contains("the grid needs 8388600"), "{error}");
    }
}

#[test]
fn legacy_counts_are_checked_against_the_bytes_there_are() {
    within_memory("legacy counts", || {
        for kind in ["ASCII", "BINARY"] {
            for line in [
                "POINTS 1000000000000 double",
                "POINTS 18446744073709551615 double",
                "CELLS 1000000000000 4000000000000",
                "CELLS 4 1000000000000\nOFFSETS vtktypeint64",
                "CELL_TYPES 1000000000000",
                "FIELD FieldData 1000000000000",
                "FIELD FieldData 1\nunits 1000000000 1000000000000 string",
                "FIELD FieldData 1\nx 1000000000000 1000000000000 int",
            ] {
                let text = format!(
                    "# vtk DataFile Version 5.1\nx\n{kind}\nDATASET UNSTRUCTURED_GRID\n{line}\n0 0 0\n"
                );
                assert!(legacy::read(text.as_bytes()).is_err(), "{kind} {line}");
            }
        }
    });
}

#[test]
fn a_deep_tree_is_no_deep_stack() {
    let deep = "<a>".repeat(300_000);
    assert!(xml::read(deep.as_bytes()).is_err());
    let closed = format!("{deep}{}", "</a>".repeat(300_000));
    assert!(xml::read(closed.as_bytes()).is_err());
}

/// Numbers for the mutations: xorshift64*.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) as usize % sides.max(1)
    }

    fn mutate(&mut self, bytes: &mut Vec<u8>) {
        const HUGE: [&str; 6] = [
            "0",
            "-1",
            "4294967296",
            "1000000000000",
            "18446744073709551615",
            "nan",
        ];
        let length = bytes.len();
        let at = self.roll(length);
        let end = (at + 1 + self.roll(16)).min(length);
        match self.roll(8) {
            0 => bytes[at] ^= 1 << self.roll(8),
            1 => bytes[at] = self.roll(256) as u8,
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(at..end)),
            4 => {
                let piece = bytes[at..end].to_vec();
                let to = self.roll(length);
                bytes.splice(to..to, piece);
            }
            5 => bytes[at..end].fill(0xFF),
            6 => bytes[at..end].fill(0),
            // A number of the text becomes another one.
            _ => {
                let digit = bytes[at..].iter().position(u8::is_ascii_digit);
                let Some(first) = digit.map(|k| at + k) else {
                    return;
                };
                let run = bytes[first..]
                    .iter()
                    .take_while(|b| b.is_ascii_digit())
                    .count();
                let other = HUGE[self.roll(HUGE.len())];
                bytes.splice(first..first + run, other.bytes());
            }
        }
    }
}

/// What a user of the file would do next, and how large it is for its bytes.
fn use_grid(grid: Grid, bytes: usize) {
    let file = MeshFile {
        path: PathBuf::new(),
        points: grid.points,
        connectivity: grid.connectivity,
        offsets: grid.offsets,
        cell_types: grid.types,
        point_data: grid.point_data,
        cell_data: grid.cell_data,
    };
    let arrays = file.point_data.iter().chain(&file.cell_data);
    let numbers = 3 * file.points.len()
        + file.connectivity.len()
        + file.cell_types.len()
        + arrays.map(|a| a.len()).sum::<usize>();
    assert!(numbers < 1 << 20, "{numbers} numbers of {bytes} bytes");
    let _ = file.tet_mesh(Orientation::Repair, Orphans::Allow);
    let _ = file.quadratic_tet_mesh(Orientation::Repair, Orphans::Allow);
    let _ = file.triangles();
    let _ = file.point_scalars("heat");
    let _ = file.cell_vectors::<3>("fiber");
    let _ = file.cell_integers("label");
    if write::check(&file).is_ok() {
        let _ = write::xml(&file);
        let _ = write::legacy(&file);
    }
}

fn mutations(name: &str, original: &[u8], rounds: usize, read: impl Fn(&[u8]) -> Option<Grid>) {
    assert!(read(original).is_some(), "{name}");
    let mut dice = Dice(0x9E37_79B9_7F4A_7C15 ^ original.len() as u64);
    for _ in 0..EFFORT * rounds {
        let mut bytes = original.to_vec();
        for _ in 0..=dice.roll(3) {
            if !bytes.is_empty() {
                dice.mutate(&mut bytes);
            }
        }
        if let Some(grid) = read(&bytes) {
            use_grid(grid, bytes.len());
        }
    }
}

#[test]
fn mutated_vtu_files_neither_panic_nor_take_memory() {
    within_memory("mutated VTU files", || {
        let file = variants::mesh();
        for variant in variants::all(256) {
            let name = format!("{variant:?}");
            let bytes = variant.written(&file);
            mutations(&name, &bytes, 300, |bytes| xml::read(bytes).ok());
        }
        mutations("own", &write::xml(&file), 2500, |bytes| {
            xml::read(bytes).ok()
        });
    });
}

#[test]
fn mutated_legacy_files_neither_panic_nor_take_memory() {
    within_memory("mutated legacy files", || {
        let read = |bytes: &[u8]| legacy::read(bytes).ok();
        mutations("own", &write::legacy(&variants::mesh()), 5_000, read);
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/mesh/vtk/samples");
        for name in ["42_ascii", "42_binary", "51_ascii", "51_binary"] {
            let bytes = std::fs::read(folder.join(format!("legacy_{name}.vtk"))).expect(name);
            mutations(name, &bytes, 7_500, read);
        }
    });
}
