//! Binary glTF 2.0 (`.glb`): one node, one mesh, one primitive, morph targets for expressions.
//!
//! After the glTF 2.0 specification (Khronos Group, 2021): chapter 3.6 accessors and alignment,
//! 3.7 meshes and morph targets, 4.4 the GLB container.

use serde_json::{Value, json};

use super::{ExportError, ExportPart, check, check_finite, point_normals};

/// A shape that the surface can be blended towards.
#[derive(Debug, Clone, Copy)]
pub struct MorphTarget<'a> {
    /// Name, for example `smile`; kept in `extras.targetNames`, where viewers look for it.
    pub name: &'a str,
    /// Displacement of every point from rest.
    pub displacements: &'a [[f64; 3]],
}

/// A surface to be written as glTF; glTF's unit is the meter and +y is up.
#[derive(Debug, Clone, Copy)]
pub struct GlbMesh<'a> {
    /// Name of the node and the mesh.
    pub name: &'a str,
    /// Points in meters.
    pub points: &'a [[f64; 3]],
    /// Triangles, counter-clockwise from outside.
    pub triangles: &'a [[u32; 3]],
    /// Linear base color of the material.
    pub base_color: [f32; 3],
    /// Expressions.
    pub targets: &'a [MorphTarget<'a>],
}

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Numbers of the file, gathered as one buffer with a view and an accessor for each array.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Adds an array of four-byte words (so every view stays aligned) and returns its accessor.
    fn add<T: Copy>(
        &mut self,
        values: &[T],
        to_bytes: impl Fn(T) -> [u8; 4],
        target: u32,
        mut accessor: Value,
    ) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend(values.iter().flat_map(|&v| to_bytes(v)));
        self.views.push(json!({
            "buffer": 0, "byteOffset": offset, "byteLength": self.bytes.len() - offset,
            "target": target,
        }));
        accessor["bufferView"] = json!(self.views.len() - 1);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Three-component vectors; the specification demands bounds for positions.
    fn vectors(&mut self, values: &[[f32; 3]]) -> usize {
        let bound = |start: f32, pick: fn(f32, f32) -> f32| -> [f32; 3] {
            [0, 1, 2].map(|k| values.iter().map(|v| v[k]).fold(start, pick))
        };
        let accessor = json!({
            "componentType": FLOAT, "type": "VEC3", "count": values.len(),
            "min": bound(f32::INFINITY, f32::min), "max": bound(f32::NEG_INFINITY, f32::max),
        });
        self.add(
            values.as_flattened(),
            f32::to_le_bytes,
            ARRAY_BUFFER,
            accessor,
        )
    }
}

/// The bytes of a `.glb` file.
///
/// # Errors
/// [`ExportError`] for indices out of range, coordinates that are not finite in single precision,
/// a color that is not finite, a target of the wrong length, or more than 4 GiB.
pub fn glb(mesh: &GlbMesh<'_>) -> Result<Vec<u8>, ExportError> {
    check_mesh(mesh)?;
    let mut buffer = Buffer::default();
    let positions = buffer.vectors(&single(mesh.points));
    let rest_normals = point_normals(mesh.points, mesh.triangles);
    let normals = buffer.vectors(&rest_normals);
    let indices = mesh.triangles.as_flattened();
    let accessor = json!({
        "componentType": UNSIGNED_INT, "type": "SCALAR", "count": indices.len(),
    });
    let indices = buffer.add(indices, u32::to_le_bytes, ELEMENT_ARRAY_BUFFER, accessor);
    let mut morph = |target: &MorphTarget| {
        let moved = mesh.points.iter().zip(target.displacements);
        let moved: Vec<[f64; 3]> = moved
            .map(|(p, d)| [p[0] + d[0], p[1] + d[1], p[2] + d[2]])
            .collect();
        let normals = point_normals(&moved, mesh.triangles);
        let turned: Vec<[f32; 3]> = (normals.iter().zip(&rest_normals))
            .map(|(a, b)| [a[0] - b[0], a[1] - b[1], a[2] - b[2]])
            .collect();
        json!({
            "POSITION": buffer.vectors(&single(target.displacements)),
            "NORMAL": buffer.vectors(&turned),
        })
    };
    let targets: Vec<Value> = mesh.targets.iter().map(&mut morph).collect();
    let mut primitive = json!({
        "attributes": { "POSITION": positions, "NORMAL": normals },
        "indices": indices, "material": 0, "mode": 4,
    });
    let mut shape = json!({ "name": mesh.name });
    if !targets.is_empty() {
        primitive["targets"] = Value::from(targets);
        shape["weights"] = json!(vec![0.0; mesh.targets.len()]);
        let names: Vec<&str> = mesh.targets.iter().map(|t| t.name).collect();
        shape["extras"] = json!({ "targetNames": names });
    }
    shape["primitives"] = json!([primitive]);
    let [r, g, b] = mesh.base_color.map(|c| c.clamp(0.0, 1.0));
    let document = json!({
        "asset": { "version": "2.0", "generator": concat!("face-rig ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": mesh.name, "mesh": 0 }],
        "meshes": [shape],
        "materials": [{
            "name": "skin",
            "doubleSided": true,
            "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.6,
            },
        }],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{ "byteLength": buffer.bytes.len() }],
    });
    container(document.to_string().into_bytes(), buffer.bytes)
}

fn single(v: &[[f64; 3]]) -> Vec<[f32; 3]> {
    v.iter().map(|p| p.map(|x| x as f32)).collect()
}

fn check_mesh(mesh: &GlbMesh<'_>) -> Result<(), ExportError> {
    check(mesh.points, mesh.triangles)?;
    // JSON has no NaN.
    if !mesh.base_color.iter().all(|c| c.is_finite()) {
        let value = mesh.base_color;
        return Err(ExportError::BadColor { value });
    }
    let expected = mesh.points.len();
    for target in mesh.targets {
        let what = || ExportPart::MorphTarget(target.name.to_owned());
        let found = target.displacements.len();
        if found != expected {
            return Err(ExportError::WrongLength {
                what: what(),
                found,
                expected,
            });
        }
        check_finite(what, target.displacements)?;
    }
    Ok(())
}

/// GLB: a 12-byte header, then the JSON and the binary chunk, each padded to four bytes.
fn container(mut json: Vec<u8>, mut binary: Vec<u8>) -> Result<Vec<u8>, ExportError> {
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let total = 12 + 8 + json.len() as u64 + 8 + binary.len() as u64;
    let length = u32::try_from(total).map_err(|_| ExportError::TooLarge { bytes: total })?;
    let mut file = Vec::with_capacity(length as usize);
    file.extend(b"glTF");
    file.extend(2u32.to_le_bytes());
    file.extend(length.to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &binary)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use gltf_json::validation::{Error, Validate};

    const POINTS: [[f64; 3]; 4] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.5],
    ];
    const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [1, 3, 2]];

    fn word(bytes: &[u8], at: usize) -> u32 {
        u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
    }

    /// Reads the container back after the rules of the specification, independent of the writer.
    fn parse(file: &[u8]) -> (Value, &[u8]) {
        assert_eq!(&file[..4], b"glTF");
        assert_eq!((word(file, 4), word(file, 8) as usize), (2, file.len()));
        let json_length = word(file, 12) as usize;
        assert_eq!((&file[16..20], json_length % 4), (&b"JSON"[..], 0));
        let document = serde_json::from_slice(&file[20..20 + json_length]).unwrap();
        let at = 20 + json_length;
        let binary_length = word(file, at) as usize;
        assert_eq!(
            (&file[at + 4..at + 8], binary_length % 4),
            (&b"BIN\0"[..], 0)
        );
        assert_eq!(at + 8 + binary_length, file.len());
        (document, &file[at + 8..])
    }

    fn read_vectors(document: &Value, binary: &[u8], accessor: &Value) -> Vec<[f32; 3]> {
        let a = &document["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &document["bufferViews"][a["bufferView"].as_u64().unwrap() as usize];
        let offset = view["byteOffset"].as_u64().unwrap() as usize;
        let count = a["count"].as_u64().unwrap() as usize;
        assert_eq!(
            (a["type"].as_str(), a["componentType"].as_u64()),
            (Some("VEC3"), Some(5126))
        );
        assert_eq!(offset % 4, 0);
        assert_eq!(view["byteLength"].as_u64().unwrap() as usize, 12 * count);
        let values: Vec<[f32; 3]> = (0..count)
            .map(|i| [0, 1, 2].map(|k| f32::from_bits(word(binary, offset + 12 * i + 4 * k))))
            .collect();
        for k in 0..3 {
            let low = values.iter().map(|v| v[k]).fold(f32::INFINITY, f32::min);
            assert_eq!(a["min"][k].as_f64().unwrap() as f32, low);
        }
        values
    }

    #[test]
    fn follows_the_rules_and_reads_back() {
        let up = [[0.0, 0.0, 0.25]; 4];
        let targets = [MorphTarget {
            name: "up",
            displacements: &up,
        }];
        let mesh = GlbMesh {
            name: "face",
            points: &POINTS,
            triangles: &TRIANGLES,
            base_color: [0.8, 0.5, 0.4],
            targets: &targets,
        };
        let file = glb(&mesh).unwrap();
        let (document, binary) = parse(&file);
        assert_eq!(document["asset"]["version"], "2.0");
        assert_eq!(
            document["buffers"][0]["byteLength"].as_u64().unwrap() as usize,
            binary.len()
        );
        let shape = &document["meshes"][0];
        let primitive = &shape["primitives"][0];
        let read = read_vectors(&document, binary, &primitive["attributes"]["POSITION"]);
        assert_eq!(read, POINTS.map(|p| p.map(|x| x as f32)));
        for n in read_vectors(&document, binary, &primitive["attributes"]["NORMAL"]) {
            assert!((n.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-5);
        }
        let moved = read_vectors(&document, binary, &primitive["targets"][0]["POSITION"]);
        assert_eq!(moved, [[0.0, 0.0, 0.25]; 4]);
        assert_eq!(shape["extras"]["targetNames"][0], "up");
        assert_eq!(shape["weights"].as_array().unwrap().len(), 1);
        let indices = &document["accessors"][primitive["indices"].as_u64().unwrap() as usize];
        let view = &document["bufferViews"][indices["bufferView"].as_u64().unwrap() as usize];
        let offset = view["byteOffset"].as_u64().unwrap() as usize;
        let read: Vec<u32> = (0..6).map(|i| word(binary, offset + 4 * i)).collect();
        assert_eq!(read, TRIANGLES.as_flattened());
        assert_eq!(view["target"], ELEMENT_ARRAY_BUFFER);
    }

    /// What `gltf-json`, written by others, finds against the specification.
    fn faults(document: &Value) -> Vec<(String, Error)> {
        let root: gltf_json::Root = serde_json::from_value(document.clone()).unwrap();
        let mut found = Vec::new();
        root.validate(&root, gltf_json::Path::new, &mut |path, error| {
            found.push((path().0, error));
        });
        found
    }

    #[test]
    fn the_same_surface_gives_the_same_bytes_and_a_valid_document() {
        let moved = [[0.0, 0.1, 0.25], [0.0; 3], [0.3, 0.0, 0.0], [0.0; 3]];
        let targets = ["a \"quoted\" smile", "öffnen"].map(|name| MorphTarget {
            name,
            displacements: &moved,
        });
        for targets in [&targets[..], &[]] {
            let mesh = GlbMesh {
                name: "face",
                points: &POINTS,
                triangles: &TRIANGLES,
                base_color: [0.8, -1.0, 4.0],
                targets,
            };
            let file = glb(&mesh).unwrap();
            assert_eq!(file, glb(&mesh).unwrap());
            let (mut document, binary) = parse(&file);
            let names: Vec<Value> = targets.iter().map(|t| json!(t.name)).collect();
            let stored = &document["meshes"][0]["extras"]["targetNames"];
            assert_eq!(stored.as_array().cloned().unwrap_or_default(), names);
            let mut end = 0;
            for view in document["bufferViews"].as_array().unwrap() {
                assert_eq!(view["byteOffset"], json!(end));
                end += view["byteLength"].as_u64().unwrap();
            }
            assert_eq!(end as usize, binary.len());
            assert_eq!(faults(&document), []);
            document["scene"] = json!(3);
            assert_eq!(
                faults(&document),
                [("scene".into(), Error::IndexOutOfBounds)]
            );
            let base_color = [0.5, f32::NAN, 0.5];
            let error = glb(&GlbMesh { base_color, ..mesh }).unwrap_err();
            assert!(error.to_string().contains("NaN"), "{error}");
        }
    }

    #[test]
    fn bad_targets_are_refused() {
        let short = [[0.0; 3]; 3];
        let targets = [MorphTarget {
            name: "short",
            displacements: &short,
        }];
        let mesh = GlbMesh {
            name: "face",
            points: &POINTS,
            triangles: &TRIANGLES,
            base_color: [0.5; 3],
            targets: &targets,
        };
        assert!(matches!(
            glb(&mesh),
            Err(ExportError::WrongLength { found: 3, .. })
        ));
        let huge = [[1e300, 0.0, 0.0]; 4];
        let targets = [MorphTarget {
            name: "huge",
            displacements: &huge,
        }];
        let error = glb(&GlbMesh {
            targets: &targets,
            ..mesh
        })
        .unwrap_err();
        assert!(error.to_string().contains("huge"), "{error}");
    }
}
