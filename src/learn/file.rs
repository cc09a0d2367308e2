//! Networks as safetensors files: `actor.0.weight`, `actor.0.bias`, ... in f32, with the activation in the
//! header.

use std::collections::BTreeMap;

use safetensors::tensor::{Dtype, SafeTensors, TensorView};

use super::network::{Activation, Layer, Network};

/// Largest header in bytes. A policy's header holds its contract and its environment, a few hundred
/// kilobytes.
const LARGEST_HEADER: u64 = 32 << 20;
/// Largest number of tensors: a checkpoint has one for each environment.
const MOST_TENSORS: usize = 100_000;
/// The key that occurs once per tensor in a header.
const TENSOR: &[u8] = b"\"data_offsets\"";

/// Reasons why a file is not a network.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// Not a safetensors file.
    #[error("not a safetensors file: {0}")]
    Format(String),
    /// A tensor is missing or has another shape or type.
    #[error("tensor `{0}` is missing, is not f32, or has a shape that does not fit")]
    Tensor(String),
    /// The activation in the header is missing or unknown.
    #[error("the header names no known activation")]
    Activation,
}

/// Numbers with a name and a shape.
pub type Tensors = BTreeMap<String, (Vec<usize>, Vec<f32>)>;

/// Tensors in double precision, for data other than networks.
pub type Doubles = BTreeMap<String, (Vec<usize>, Vec<f64>)>;

impl Network {
    /// The network as a safetensors file; `name` (`actor`, `critic`) is the prefix of its tensors.
    pub fn to_safetensors(&self, name: &str) -> Vec<u8> {
        let mut tensors = Tensors::new();
        self.insert_into(name, &mut tensors);
        write(&tensors, &[(&format!("{name}.activation"), self.activation.word())])
    }

    /// The network of this name in a safetensors file.
    pub fn from_safetensors(name: &str, bytes: &[u8]) -> Result<Self, FileError> {
        let (tensors, header) = read(bytes)?;
        let activation = header.get(&format!("{name}.activation")).and_then(|word| Activation::named(word));
        Self::take_from(name, &tensors, activation.ok_or(FileError::Activation)?)
    }

    /// Adds the network's tensors.
    pub fn insert_into(&self, name: &str, tensors: &mut Tensors) {
        for (index, layer) in self.layers.iter().enumerate() {
            let shape = vec![layer.outputs, layer.inputs];
            tensors.insert(format!("{name}.{index}.weight"), (shape, layer.weight.clone()));
            tensors.insert(format!("{name}.{index}.bias"), (vec![layer.outputs], layer.bias.clone()));
        }
    }

    /// Reads the network of this name among tensors.
    pub fn take_from(name: &str, tensors: &Tensors, activation: Activation) -> Result<Self, FileError> {
        let mut layers: Vec<Layer> = Vec::new();
        while let Some((shape, weight)) = tensors.get(&format!("{name}.{}.weight", layers.len())) {
            let key = format!("{name}.{}.bias", layers.len());
            let (_, bias) = tensors.get(&key).ok_or_else(|| FileError::Tensor(key.clone()))?;
            let fits = shape.len() == 2
                && bias.len() == shape[0]
                && layers.last().is_none_or(|l| l.outputs == shape[1]);
            if !fits {
                return Err(FileError::Tensor(key));
            }
            layers.push(Layer {
                weight: weight.clone(),
                bias: bias.clone(),
                inputs: shape[1],
                outputs: shape[0],
            });
        }
        if layers.is_empty() {
            Err(FileError::Tensor(format!("{name}.0.weight")))
        } else {
            Ok(Self { layers, activation })
        }
    }
}

/// Serializes tensors and header texts as a safetensors file; the bytes depend on nothing else.
pub fn write(tensors: &Tensors, header: &[(&str, &str)]) -> Vec<u8> {
    write_with(tensors, &Doubles::new(), header)
}

/// As [`write`], with further tensors in double precision. All names must be different.
pub fn write_with(tensors: &Tensors, doubles: &Doubles, header: &[(&str, &str)]) -> Vec<u8> {
    let single = tensors.iter().map(|(name, (shape, data))| {
        (name, Dtype::F32, shape, data.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>())
    });
    let double = doubles.iter().map(|(name, (shape, data))| {
        (name, Dtype::F64, shape, data.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>())
    });
    let entries: Vec<_> = single.chain(double).collect();
    let views = entries.iter().map(|(name, dtype, shape, bytes)| {
        let view = TensorView::new(*dtype, shape.to_vec(), bytes)
            .expect("a tensor holds as many numbers as its shape");
        (name.as_str(), view)
    });
    // A single header text, so that the order of a hash map cannot affect the file.
    let header =
        serde_json::to_string(&header.iter().copied().collect::<BTreeMap<_, _>>()).expect("texts are JSON");
    let metadata = [("specforge".to_owned(), header)].into_iter().collect();
    safetensors::serialize(views, Some(metadata)).expect("names are unique and shapes fit")
}

/// Tensors and header texts of a safetensors file.
pub fn read(bytes: &[u8]) -> Result<(Tensors, BTreeMap<String, String>), FileError> {
    let (tensors, doubles, header) = read_with(bytes)?;
    match doubles.into_keys().next() {
        Some(name) => Err(FileError::Tensor(name)),
        None => Ok((tensors, header)),
    }
}

/// The header texts of a safetensors file.
pub fn header(bytes: &[u8]) -> Result<BTreeMap<String, String>, FileError> {
    small_header(bytes)?;
    let (_, metadata) =
        SafeTensors::read_metadata(bytes).map_err(|error| FileError::Format(error.to_string()))?;
    let header = metadata.metadata().as_ref().and_then(|map| map.get("specforge"));
    Ok(header.and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default())
}

/// Tensors, numbers in double precision and header texts of a safetensors file.
pub fn read_with(bytes: &[u8]) -> Result<(Tensors, Doubles, BTreeMap<String, String>), FileError> {
    small_header(bytes)?;
    let file = SafeTensors::deserialize(bytes).map_err(|error| FileError::Format(error.to_string()))?;
    let header = header(bytes)?;
    let (mut tensors, mut doubles) = (Tensors::new(), Doubles::new());
    for (name, view) in file.iter() {
        let (name, shape) = (name.to_owned(), view.shape().to_vec());
        let (singles, pairs) = (view.data().as_chunks::<4>().0, view.data().as_chunks::<8>().0);
        match view.dtype() {
            Dtype::F32 => {
                tensors.insert(name, (shape, singles.iter().map(|four| f32::from_le_bytes(*four)).collect()));
            }
            Dtype::F64 => {
                doubles.insert(name, (shape, pairs.iter().map(|eight| f64::from_le_bytes(*eight)).collect()));
            }
            _ => return Err(FileError::Tensor(name)),
        }
    }
    Ok((tensors, doubles, header))
}

/// Refuses a file with an oversized header before it is parsed: each tensor takes many times the memory of
/// its text.
fn small_header(bytes: &[u8]) -> Result<(), FileError> {
    let Some((length, rest)) = bytes.split_first_chunk() else { return Ok(()) };
    let length = u64::from_le_bytes(*length);
    if length > LARGEST_HEADER {
        let mib = LARGEST_HEADER >> 20;
        return Err(FileError::Format(format!(
            "its header has {length} bytes, more than the {mib} MiB allowed"
        )));
    }
    let header = &rest[..rest.len().min(length as usize)];
    let tensors = header.windows(TENSOR.len()).filter(|window| *window == TENSOR).count();
    if tensors > MOST_TENSORS {
        let message = format!("its header lists {tensors} tensors, more than the {MOST_TENSORS} allowed");
        return Err(FileError::Format(message));
    }
    Ok(())
}

/// Whether all numbers of a safetensors file are finite; unknown if the file cannot be read.
pub fn is_finite(bytes: &[u8]) -> bool {
    let file = small_header(bytes).ok().and_then(|()| SafeTensors::deserialize(bytes).ok());
    let Some(file) = file else { return true };
    file.iter().all(|(_, view)| match view.dtype() {
        Dtype::F32 => view.data().as_chunks::<4>().0.iter().all(|four| f32::from_le_bytes(*four).is_finite()),
        Dtype::F64 => {
            view.data().as_chunks::<8>().0.iter().all(|eight| f64::from_le_bytes(*eight).is_finite())
        }
        _ => true,
    })
}

/// BLAKE3, as hex, of everything in a file: names, shapes, numbers, and header texts with their keys. The
/// caller leaves out the text that holds the digest.
pub fn digest(tensors: &Tensors, doubles: &Doubles, header: &[(&str, &str)]) -> String {
    let mut hasher = blake3::Hasher::new_derive_key("specforge file digest v2");
    let mut part = |bytes: &[u8]| {
        hasher.update(&(bytes.len() as u64).to_le_bytes()).update(bytes);
    };
    let mut tensor = |name: &str, shape: &[usize], data: Vec<u8>| {
        part(name.as_bytes());
        part(&shape.iter().flat_map(|size| (*size as u64).to_le_bytes()).collect::<Vec<u8>>());
        part(&data);
    };
    for (name, (shape, data)) in tensors {
        tensor(name, shape, data.iter().flat_map(|x| x.to_le_bytes()).collect());
    }
    for (name, (shape, data)) in doubles {
        tensor(name, shape, data.iter().flat_map(|x| x.to_le_bytes()).collect());
    }
    for (key, text) in header {
        part(key.as_bytes());
        part(text.as_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::Stream;

    #[test]
    fn a_network_survives_its_file_and_writes_the_same_bytes_again() {
        let network = Network::orthogonal(&[5, 8, 3], Activation::Tanh, &mut Stream::new("test/file"));
        let bytes = network.to_safetensors("actor");
        assert_eq!(Network::from_safetensors("actor", &bytes).unwrap(), network);
        assert_eq!(network.to_safetensors("actor"), bytes);
    }

    #[test]
    fn doubles_lie_beside_tensors_and_keep_their_bits() {
        let tensors = Tensors::from([("a".to_owned(), (vec![2], vec![1.0_f32, -0.5]))]);
        let doubles = Doubles::from([("b".to_owned(), (vec![1, 2], vec![0.1, 1e-300]))]);
        let bytes = write_with(&tensors, &doubles, &[("key", "text")]);
        let header = BTreeMap::from([("key".to_owned(), "text".to_owned())]);
        assert_eq!(read_with(&bytes).unwrap(), (tensors, doubles, header));
        assert!(matches!(read(&bytes), Err(FileError::Tensor(name)) if name == "b"));
    }

    #[test]
    fn a_digest_is_that_of_names_shapes_numbers_and_texts() {
        let tensor = |name: &str, shape: &[usize], first: f32| {
            Tensors::from([(name.to_owned(), (shape.to_vec(), vec![first, 2.0, 3.0, 4.0]))])
        };
        let none = Doubles::new();
        let digests = [
            digest(&tensor("a", &[2, 2], 1.0), &none, &[("key", "text")]),
            digest(&tensor("b", &[2, 2], 1.0), &none, &[("key", "text")]),
            digest(&tensor("a", &[4, 1], 1.0), &none, &[("key", "text")]),
            digest(&tensor("a", &[2, 2], 0.5), &none, &[("key", "text")]),
            digest(&tensor("a", &[2, 2], 1.0), &none, &[("key", "texts")]),
            digest(&tensor("a", &[2, 2], 1.0), &none, &[("keys", "text")]),
            digest(&tensor("a", &[2, 2], 1.0), &Doubles::from([("b".to_owned(), (vec![0], vec![]))]), &[]),
        ];
        let different: std::collections::BTreeSet<_> = digests.iter().collect();
        assert_eq!(different.len(), digests.len(), "{digests:?}");
    }

    #[test]
    fn a_header_of_very_many_tensors_is_refused_before_it_is_parsed() {
        let tensors: Vec<String> = (0..900_000)
            .map(|index| format!("\"t{index}\":{{\"dtype\":\"F32\",\"shape\":[0],\"data_offsets\":[0,0]}}"))
            .collect();
        let file = |header: &str| [&(header.len() as u64).to_le_bytes()[..], header.as_bytes()].concat();
        let refused = |header: &str| match read(&file(header)) {
            Err(FileError::Format(why)) => why,
            other => panic!("{other:?}"),
        };
        assert!(refused(&format!("{{{}}}", tensors.join(","))).contains("more than the 32 MiB allowed"));
        assert!(refused(&format!("{{{}}}", tensors[..200_000].join(","))).contains("lists 200000 tensors"));
        // The library refuses a wrong length.
        assert!(matches!(read(&[0xff; 16]), Err(FileError::Format(_))));
        assert!(matches!(read(&[1, 0]), Err(FileError::Format(_))));
    }

    #[test]
    fn a_damaged_file_is_refused() {
        let network = Network::orthogonal(&[5, 8, 3], Activation::Relu, &mut Stream::new("test/file"));
        let bytes = network.to_safetensors("actor");
        assert!(matches!(
            Network::from_safetensors("actor", &bytes[..bytes.len() - 1]),
            Err(FileError::Format(_))
        ));
        assert!(Network::from_safetensors("critic", &bytes).is_err());
        assert!(matches!(Network::from_safetensors("actor", b"hello"), Err(FileError::Format(_))));
    }
}
