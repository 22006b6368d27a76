//! VTU and legacy VTK files through `vtkio`, guarded against what that crate lets slip.
//!
//! Known traits of vtkio 0.7.0-rc2, all met here: its reader leaves out data arrays that it cannot
//! decode without a word (so the names are counted again in the file's text); it panics on some damaged
//! files (caught); its compressor writes an empty last block for arrays of a multiple of 32,768
//! bytes, which VTK itself takes for a full one (such files are written uncompressed).

use super::atomic;
use super::file::{DataArray, MeshFile, MeshFileError, Values};
use std::io;
use std::path::Path;
use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataSet, ElementType, IOBuffer, Piece,
    UnstructuredGridPiece, Version, VertexNumbers, Vtk,
};
use vtkio::xml::Compressor;

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Xml,
    Legacy,
}

fn format_of(path: &Path) -> Result<Format, MeshFileError> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("vtu") => Ok(Format::Xml),
        Some("vtk") => Ok(Format::Legacy),
        _ => Err(damaged(path, "mesh files end in .vtu or .vtk")),
    }
}

fn damaged(path: &Path, reason: impl Into<String>) -> MeshFileError {
    MeshFileError::Format {
        path: path.to_path_buf(),
        reason: reason.into(),
    }
}

fn system(path: &Path) -> impl FnOnce(io::Error) -> MeshFileError {
    |source| MeshFileError::Io {
        path: path.to_path_buf(),
        source,
    }
}

pub(super) fn read(path: &Path) -> Result<MeshFile, MeshFileError> {
    let format = format_of(path)?;
    let bytes = std::fs::read(path).map_err(system(path))?;
    let parsed = std::panic::catch_unwind(|| match format {
        Format::Xml => Vtk::parse_xml(bytes.as_slice()),
        Format::Legacy => Vtk::parse_legacy_be(bytes.as_slice()),
    });
    let data = match parsed {
        Ok(Ok(vtk)) => vtk.data,
        Ok(Err(error)) => return Err(damaged(path, format!("not a readable VTK file: {error}"))),
        Err(_) => {
            return Err(damaged(
                path,
                "the file is cut off or damaged; write it again",
            ));
        }
    };
    let DataSet::UnstructuredGrid { mut pieces, .. } = data else {
        return Err(damaged(
            path,
            "the file holds no unstructured grid; convert it to one",
        ));
    };
    let piece = match (pieces.pop(), pieces.is_empty()) {
        (Some(Piece::Inline(piece)), true) => *piece,
        (Some(Piece::Inline(_)), false) => {
            return Err(damaged(
                path,
                "the grid comes in several pieces; merge them first",
            ));
        }
        _ => return Err(damaged(path, "the grid is empty or refers to other files")),
    };
    let file = from_piece(path, piece)?;
    if format == Format::Xml {
        let text = String::from_utf8_lossy(&bytes);
        for (section, arrays) in [
            ("PointData", &file.point_data),
            ("CellData", &file.cell_data),
        ] {
            for name in declared_arrays(&text, section) {
                if !arrays.iter().any(|a| a.name == name) {
                    let reason = format!(
                        "the {section} array \"{name}\" cannot be decoded: its length is not that of \
                         the grid, its data is damaged, or its encoding is not supported (LZMA is \
                         not: write it as ASCII, uncompressed binary, zlib or LZ4)"
                    );
                    return Err(damaged(path, reason));
                }
            }
        }
    }
    Ok(file)
}

fn from_piece(path: &Path, piece: UnstructuredGridPiece) -> Result<MeshFile, MeshFileError> {
    let Values::Floats(coordinates) = numbers(piece.points) else {
        return Err(damaged(
            path,
            "the point coordinates are whole numbers; write them as floats",
        ));
    };
    let (points, rest) = coordinates.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(damaged(
            path,
            "the point coordinates are no multiple of three",
        ));
    }
    let (connectivity, offsets) = cells(piece.cells.cell_verts)
        .ok_or_else(|| damaged(path, "the cells' offsets do not fit their connectivity"))?;
    if offsets.len() != piece.cells.types.len() {
        return Err(damaged(path, "there are not as many cell types as cells"));
    }
    Ok(MeshFile {
        path: path.to_path_buf(),
        points: points.to_vec(),
        connectivity,
        offsets,
        cell_types: piece.cells.types.iter().map(|&t| t as u8).collect(),
        point_data: arrays(piece.data.point),
        cell_data: arrays(piece.data.cell),
    })
}

/// Connectivity and the end of each cell, checked to ascend to the length of the connectivity.
fn cells(vertices: VertexNumbers) -> Option<(Vec<u32>, Vec<u32>)> {
    fn narrow(v: Vec<u64>) -> Option<Vec<u32>> {
        v.into_iter().map(|i| u32::try_from(i).ok()).collect()
    }
    let (connectivity, offsets): (Vec<u32>, Vec<u32>) = match vertices {
        VertexNumbers::XML {
            connectivity,
            offsets,
        } => (narrow(connectivity)?, narrow(offsets)?),
        VertexNumbers::Legacy { vertices, .. } => {
            let (mut connectivity, mut offsets) = (Vec::new(), Vec::new());
            let mut rest = vertices.as_slice();
            while let Some((&count, after)) = rest.split_first() {
                let (cell, after) = after.split_at_checked(count as usize)?;
                connectivity.extend_from_slice(cell);
                offsets.push(u32::try_from(connectivity.len()).ok()?);
                rest = after;
            }
            (connectivity, offsets)
        }
    };
    let ascending = offsets.is_sorted();
    let complete = offsets.last().map_or(0, |&end| end as usize) == connectivity.len();
    (ascending && complete).then_some((connectivity, offsets))
}

fn arrays(attributes: Vec<Attribute>) -> Vec<DataArray> {
    let mut arrays = Vec::new();
    for attribute in attributes {
        match attribute {
            Attribute::DataArray(array) => arrays.push(DataArray {
                components: array.elem.num_comp() as usize,
                name: array.name,
                values: numbers(array.data),
            }),
            Attribute::Field { data_array, .. } => {
                arrays.extend(data_array.into_iter().map(|array| DataArray {
                    name: array.name,
                    components: array.elem as usize,
                    values: numbers(array.data),
                }));
            }
        }
    }
    arrays
}

fn numbers(buffer: IOBuffer) -> Values {
    fn whole<T: Into<i64>>(v: Vec<T>) -> Values {
        Values::Integers(v.into_iter().map(Into::into).collect())
    }
    match buffer {
        IOBuffer::F64(v) => Values::Floats(v),
        IOBuffer::F32(v) => Values::Floats(v.into_iter().map(f64::from).collect()),
        IOBuffer::Bit(v) | IOBuffer::U8(v) => whole(v),
        IOBuffer::I8(v) => whole(v),
        IOBuffer::U16(v) => whole(v),
        IOBuffer::I16(v) => whole(v),
        IOBuffer::U32(v) => whole(v),
        IOBuffer::I32(v) => whole(v),
        IOBuffer::I64(v) => Values::Integers(v),
        // Ids beyond 2⁶³ do not occur; what VTK writes there is −1.
        IOBuffer::U64(v) => Values::Integers(v.into_iter().map(|x| x as i64).collect()),
    }
}

/// The names of the arrays that the text of a VTU file declares in a section.
fn declared_arrays(text: &str, section: &str) -> Vec<String> {
    let (open, close) = (format!("<{section}"), format!("</{section}>"));
    let Some(start) = text.find(&open) else {
        return Vec::new();
    };
    let body = &text[start..];
    let body = &body[..body.find(&close).unwrap_or(body.len())];
    let name_of = |tag: &str| {
        let tag = &tag[..tag.find('>')?];
        let after = &tag[tag.find("Name=")? + "Name=".len()..];
        let quote = after.chars().next().filter(|q| matches!(q, '"' | '\''))?;
        after[1..].split(quote).next().map(str::to_owned)
    };
    body.split("<DataArray")
        .skip(1)
        .filter_map(name_of)
        .collect()
}

pub(super) fn write(file: &MeshFile, path: &Path) -> Result<(), MeshFileError> {
    let format = format_of(path)?;
    let named = MeshFile {
        path: path.to_path_buf(),
        ..file.clone()
    };
    named.check_arrays()?;
    if let Some(point) = named
        .points
        .iter()
        .position(|x| !x.iter().all(|v| v.is_finite()))
    {
        return Err(damaged(
            path,
            format!("point {point} is not finite; nothing was written"),
        ));
    }
    let types = named
        .cell_types
        .iter()
        .map(|&t| cell_type(t))
        .collect::<Option<Vec<_>>>()
        .ok_or_else(|| damaged(path, "only triangles and tetrahedra can be written"))?;
    let compressible = can_compress(&named);
    let vtk = Vtk {
        version: match format {
            Format::Xml => Version::new_xml(1, 0),
            Format::Legacy => Version::new_legacy(3, 0),
        },
        title: "tetrahedral mesh".into(),
        byte_order: match format {
            Format::Xml => ByteOrder::LittleEndian,
            Format::Legacy => ByteOrder::BigEndian,
        },
        file_path: None,
        data: DataSet::inline(UnstructuredGridPiece {
            points: IOBuffer::F64(named.points.as_flattened().to_vec()),
            cells: Cells {
                cell_verts: VertexNumbers::XML {
                    connectivity: named.connectivity.iter().map(|&n| n.into()).collect(),
                    offsets: named.offsets.iter().map(|&n| n.into()).collect(),
                },
                types,
            },
            data: Attributes {
                point: named.point_data.iter().map(attribute).collect(),
                cell: named.cell_data.iter().map(attribute).collect(),
            },
        }),
    };
    // Into memory first: vtkio's writer ignores short writes.
    let mut bytes = Vec::new();
    let written = match format {
        Format::Legacy => vtk.write_legacy(&mut bytes).map_err(|e| e.to_string()),
        Format::Xml => vtk
            .try_into_xml_format(
                if compressible {
                    Compressor::ZLib
                } else {
                    Compressor::None
                },
                5,
            )
            .and_then(|xml| xml.write(&mut bytes))
            .map_err(|e| e.to_string()),
    };
    written.map_err(|reason| damaged(path, reason))?;
    atomic::write_bytes(path, &bytes).map_err(system(path))
}

fn cell_type(code: u8) -> Option<CellType> {
    [CellType::Triangle, CellType::Tetra]
        .into_iter()
        .find(|&t| t as u8 == code)
}

fn attribute(array: &DataArray) -> Attribute {
    Attribute::DataArray(vtkio::model::DataArray {
        name: array.name.clone(),
        elem: ElementType::Generic(array.components as u32),
        data: match &array.values {
            Values::Floats(v) => IOBuffer::F64(v.clone()),
            Values::Integers(v) => IOBuffer::I64(v.clone()),
        },
    })
}

/// Whether no array of the file is a whole number of compression blocks long (see above).
fn can_compress(file: &MeshFile) -> bool {
    let wide = [
        3 * file.points.len(),
        file.connectivity.len(),
        file.offsets.len(),
    ];
    let data = file
        .point_data
        .iter()
        .chain(&file.cell_data)
        .map(DataArray::len);
    let mut lengths = wide.into_iter().chain(data).map(|n| 8 * n);
    !file.cell_types.len().is_multiple_of(32_768) && lengths.all(|n| !n.is_multiple_of(32_768))
}

#[cfg(test)]
mod tests;
