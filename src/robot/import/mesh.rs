//! Meshes: the box around the points of an STL, OBJ or COLLADA file. Ignores materials and the use of the
//! mesh.

use std::path::Path;

use nalgebra::Vector3;

use super::block::Block;
use super::collada;
use crate::bounded::{self, ReadError};

/// Maximum size of a mesh file in bytes.
pub(super) const LARGEST: u64 = 64 << 20;

/// Start of a Git LFS pointer file.
const LFS_POINTER: &[u8] = b"version https://git-lfs.github.com/spec/";

/// Why a mesh has no box.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum MeshError {
    /// It is too large for a collision mesh.
    TooLarge(String),
    /// Its extension is none of the three.
    Format,
    /// Its content does not match its extension.
    Broken(String),
}

/// The box around a mesh file's points in the file's own axes; in m if the file states its unit (COLLADA),
/// else in the file's unit. Adds the bytes read to `read`.
pub(super) fn bounds(path: &Path, read: &mut u64) -> Result<Block, MeshError> {
    around(corners(path, read)?.iter())
}

/// The points of a mesh file, in the same units as [`bounds`].
pub(super) fn points(path: &Path) -> Result<Vec<Vector3<f64>>, MeshError> {
    let points = corners(path, &mut 0)?;
    if points.iter().flatten().any(|number| !number.is_finite()) {
        return Err(MeshError::Broken("a point of it is not finite".to_owned()));
    }
    Ok(points.into_iter().map(|point| shortest(&Vector3::from(point))).collect())
}

fn corners(path: &Path, read: &mut u64) -> Result<Vec<[f32; 3]>, MeshError> {
    let broken = |error: std::io::Error| MeshError::Broken(error.to_string());
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if !matches!(ending.as_str(), "stl" | "obj" | "dae") {
        return Err(MeshError::Format);
    }
    let mut bytes = bounded::bytes(path, LARGEST).map_err(|error| match error {
        ReadError::TooLarge { .. } => MeshError::TooLarge(error.to_string()),
        _ => MeshError::Broken(error.to_string()),
    })?;
    *read += bytes.len() as u64;
    if bytes.starts_with(LFS_POINTER) {
        return Err(MeshError::Broken(
            "it is the pointer that Git LFS leaves in its place; `git lfs pull` fetches it".to_owned(),
        ));
    }
    if ending == "dae" {
        let text = String::from_utf8(bytes).map_err(|error| MeshError::Broken(error.to_string()))?;
        return collada::corners(&text).map_err(MeshError::Broken);
    }
    let scene = if ending == "stl" {
        // Some programs start the free-form header of a binary file with `solid`, like a text file.
        if is_binary_stl(&bytes) {
            bytes[..80].fill(0);
        } else if !is_text_stl(&bytes) {
            return Err(MeshError::Broken(miscounted(&bytes)));
        }
        mesh_loader::stl::from_slice(&bytes)
    } else {
        // Materials do not affect the shape, so their files are not read.
        mesh_loader::obj::from_slice(&of_points(&bytes), None, |_| {
            Err::<Vec<u8>, _>(std::io::ErrorKind::NotFound.into())
        })
    };
    Ok(scene.map_err(broken)?.meshes.into_iter().flat_map(|mesh| mesh.vertices).collect())
}

/// Whether the length of an STL file matches the triangle count that binary files have after their first 80
/// bytes.
fn is_binary_stl(bytes: &[u8]) -> bool {
    let count = bytes.get(80..84).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes);
    count.is_some_and(|count| bytes.len() as u64 == 84 + 50 * u64::from(count))
}

/// Whether an STL file is ASCII.
fn is_text_stl(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().starts_with(b"solid") && !bytes.contains(&0)
}

/// The error for a binary STL file whose length does not match its triangle count.
fn miscounted(bytes: &[u8]) -> String {
    let length = bytes.len();
    let count = bytes.get(80..84).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes);
    match count {
        Some(count) => {
            let whole = 84 + 50 * u64::from(count);
            format!("it has {length} bytes, and the {count} triangles of its header take {whole}")
        }
        None => format!("it has {length} bytes, and the header of a binary STL file alone takes 84"),
    }
}

/// Reduces the faces of an OBJ file to point indices and removes indentation: a box needs neither normals nor
/// textures, and the reader rejects files in which only some faces have them, and skips indented lines.
fn of_points(bytes: &[u8]) -> Vec<u8> {
    let mut plain = Vec::with_capacity(bytes.len());
    let mut goes_on = false;
    for line in bytes.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii) {
        if !(goes_on || matches!(line, [b'f', b' ' | b'\t', ..])) {
            plain.extend_from_slice(line);
            plain.push(b'\n');
            continue;
        }
        // A trailing backslash continues the line.
        let whole = line.strip_suffix(b"\\");
        goes_on = whole.is_some();
        let mut is_point = true;
        for byte in whole.unwrap_or(line) {
            is_point = byte.is_ascii_whitespace() || (is_point && *byte != b'/');
            if is_point {
                plain.push(*byte);
            }
        }
        plain.push(if goes_on { b' ' } else { b'\n' });
    }
    plain
}

fn around<'a>(points: impl Iterator<Item = &'a [f32; 3]>) -> Result<Block, MeshError> {
    let mut corners: Option<[Vector3<f32>; 2]> = None;
    for point in points {
        let point = Vector3::from(*point);
        if !point.iter().all(|number| number.is_finite()) {
            return Err(MeshError::Broken("a point of it is not finite".to_owned()));
        }
        corners = Some(corners.map_or([point; 2], |[low, high]| [low.inf(&point), high.sup(&point)]));
    }
    let [low, high] = corners.ok_or_else(|| MeshError::Broken("it has no triangles".to_owned()))?;
    let [low, high] = [low, high].map(|corner| shortest(&corner));
    Ok(Block { centre: 0.5 * (low + high), half: 0.5 * (high - low) })
}

/// Uses the shortest decimals of a point, which the file intended: 0.1, not 0.10000000149.
fn shortest(point: &Vector3<f32>) -> Vector3<f64> {
    point.map(|x| x.to_string().parse::<f64>().unwrap_or(f64::from(x)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron with corners at the origin and at 0.1, 0.2 and 0.3 m along the axes.
    const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.3]];
    const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

    fn binary() -> Vec<u8> {
        let mut bytes = vec![0; 80];
        bytes.extend((FACES.len() as u32).to_le_bytes());
        for face in FACES {
            bytes.extend([0; 12]);
            face.iter()
                .flat_map(|corner| CORNERS[*corner])
                .for_each(|number| bytes.extend(number.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    fn ascii() -> String {
        let facet = |face: [usize; 3]| {
            let corners: String = face
                .iter()
                .map(|corner| CORNERS[*corner])
                .map(|[x, y, z]| format!("vertex {x} {y} {z}\n"))
                .collect();
            format!("facet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\n")
        };
        format!("solid t\n{}endsolid t\n", FACES.map(facet).concat())
    }

    fn wavefront() -> String {
        let corners = CORNERS.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
        let faces = FACES.map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1)).concat();
        format!("mtllib /etc/passwd\n{corners}usemtl x\n{faces}")
    }

    #[test]
    fn binary_and_ascii_stl_and_obj_have_the_same_box() {
        let folder = tempfile::tempdir().unwrap();
        let mut titled = binary();
        titled[..9].copy_from_slice(b"solid foo");
        let texts = [("b.STL", ascii().into_bytes()), ("c.obj", wavefront().into_bytes())];
        for (name, bytes) in [("a.stl", binary()), ("titled.stl", titled)].into_iter().chain(texts) {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            let block = bounds(&path, &mut 0).unwrap_or_else(|error| panic!("{name}: {error:?}"));
            assert!((block.half - Vector3::new(0.05, 0.1, 0.15)).norm() < 1e-8, "{name}");
            assert!((block.centre - Vector3::new(0.05, 0.1, 0.15)).norm() < 1e-8, "{name}");
        }
    }

    #[test]
    fn faces_of_an_obj_file_may_have_different_forms() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        let plain = wavefront();
        let head = plain.split("f ").next().unwrap().to_owned() + "vt 0 0\nvn 0 0 1\n";
        for faces in [
            "f 1 3/1 2/1/1\nf 1//1 2//1 4//1\nf 1 4 3\n",
            "f 1/1/1 3/1/1 2/1/1\nf 1//1 2//1 4\n",
            "f -4/-1 -2 -3//-1\nf -4 -3 -1/1\n",
            "f\t1/1\t3/1\t2/1\r\nf 1 2/1/ 4/1\r\n",
            "f 1/1 3/1 \\\n2/1\nf 1/1/1 2/1/1 \\\n  4/1/1\n",
            "  f 1/1 2/1 3/1 4/1/1\n",
            "f 1 2 3\n\tf 1 2 4\n",
        ] {
            std::fs::write(&path, format!("{head}{faces}")).unwrap();
            let block = bounds(&path, &mut 0).unwrap_or_else(|error| panic!("{faces}: {error:?}"));
            assert!((block.half - Vector3::new(0.05, 0.1, 0.15)).norm() < 1e-8, "{faces}: {block:?}");
        }
        // Lines other than faces keep their slashes.
        assert_eq!(of_points(b"# a/b\nmtllib a/b.mtl\nf 1/2 2//3 3"), b"# a/b\nmtllib a/b.mtl\nf 1 2 3\n");
    }

    #[test]
    fn what_is_no_mesh_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let said = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            bounds(&path, &mut 0).unwrap_err()
        };
        assert_eq!(said("a.ply", b"ply"), MeshError::Format);
        assert!(matches!(said("a.dae", b"<COLLADA/>"), MeshError::Broken(_)));
        assert!(matches!(said("a.stl", b"hello"), MeshError::Broken(_)));
        let mut half = binary();
        half.truncate(84 + 2 * 50);
        let broken =
            |what: &str| matches!(said("half.stl", &half), MeshError::Broken(why) if why.contains(what));
        assert!(broken("it has 184 bytes, and the 4 triangles of its header take 284"));
        for count in [1, 4_000_000_000] {
            let mut lie = binary();
            lie[80..84].copy_from_slice(&u32::to_le_bytes(count));
            assert!(
                matches!(said("lie.stl", &lie), MeshError::Broken(why) if why.contains("of its header take"))
            );
        }
        let pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 100\n";
        assert!(
            matches!(said("c.stl", pointer), MeshError::Broken(reason) if reason.contains("git lfs pull"))
        );
        assert!(matches!(said("b.stl", b"solid x\nfacet normal 0 0 1\n"), MeshError::Broken(_)));
        assert!(matches!(said("a.obj", b"f 1 2 3\n"), MeshError::Broken(_)));
        let mut nan = binary();
        nan[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(matches!(said("nan.stl", &nan), MeshError::Broken(_)));
        // A sparse file of 1 GB is not opened at all.
        let path = folder.path().join("huge.stl");
        std::fs::File::create(&path).unwrap().set_len(1 << 30).unwrap();
        assert!(matches!(bounds(&path, &mut 0), Err(MeshError::TooLarge(why)) if why.contains("1024 MiB")));
    }
}
