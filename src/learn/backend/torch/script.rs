//! Networks as TorchScript modules, which PyTorch and libtorch load without specforge's code
//! (`torch.jit.load`).

use std::path::Path;

use tch::{CModule, Device, Kind, TchError, Tensor};

use crate::learn::network::{Activation, Layer, Network};

/// Writes a network as a TorchScript module whose `forward` maps f32 inputs, `rows` x inputs, to outputs,
/// `rows` x outputs. The weights are constants of its graph. Fails if libtorch cannot write the file.
pub fn save(network: &Network, path: &Path) -> Result<(), TchError> {
    let tensors = |layer: &Layer| {
        let shape = [layer.outputs as i64, layer.inputs as i64];
        (Tensor::from_slice(&layer.weight).view(shape), Tensor::from_slice(&layer.bias))
    };
    let layers: Vec<(Tensor, Tensor)> = network.layers.iter().map(tensors).collect();
    let last = layers.len() - 1;
    let mut forward = |inputs: &[Tensor]| {
        let mut x = inputs[0].shallow_clone();
        for (index, (weight, bias)) in layers.iter().enumerate() {
            x = x.linear(weight, Some(bias));
            if index < last {
                x = match network.activation {
                    Activation::Relu => x.relu(),
                    Activation::Tanh => x.tanh(),
                    Activation::Elu => x.elu(),
                };
            }
        }
        vec![x]
    };
    // Tracing records the operations on one row; none of them depends on the number of rows.
    let example = Tensor::zeros([1, network.inputs() as i64], (Kind::Float, Device::Cpu));
    CModule::create_by_tracing("policy", "forward", &[example], &mut forward)?.save(path)
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::super::adam::numbers;
    use super::*;
    use crate::learn::Scratch;
    use crate::stream::Stream;

    const ROWS: usize = 7;

    fn network(activation: Activation) -> Network {
        let mut network = Network::orthogonal(&[5, 24, 17, 3], activation, &mut Stream::new("test/script"));
        network.layers[2].weight.iter_mut().for_each(|x| *x *= 100.0);
        network.layers.iter_mut().for_each(|layer| layer.bias.iter_mut().for_each(|x| *x += 0.125));
        network
    }

    fn inputs() -> Vec<f32> {
        let mut stream = Stream::new("test/script/inputs");
        (0..ROWS * 5).map(|_| stream.normal() as f32).collect()
    }

    fn outputs(network: &Network) -> Vec<f32> {
        let mut outputs = vec![0.0; ROWS * 3];
        network.forward(&inputs(), &mut outputs, &mut Scratch::default());
        outputs
    }

    fn assert_close(found: &[f32], expected: &[f32]) {
        assert_eq!(found.len(), expected.len());
        let apart =
            found.iter().zip(expected).map(|(a, b)| (a - b).abs() / (1.0 + b.abs())).fold(0.0, f32::max);
        assert!(apart < 1e-6, "{apart:e}");
    }

    #[test]
    fn a_loaded_module_computes_what_the_network_does() {
        let folder = tempfile::tempdir().unwrap();
        for activation in [Activation::Relu, Activation::Tanh, Activation::Elu] {
            let (network, path) = (network(activation), folder.path().join("policy.pt"));
            save(&network, &path).unwrap();
            let module = CModule::load(&path).unwrap();
            let rows = Tensor::from_slice(&inputs()).view([ROWS as i64, 5]);
            assert_close(&numbers(&module.forward_ts(&[rows]).unwrap()), &outputs(&network));
        }
        assert!(save(&network(Activation::Relu), &folder.path().join("no/policy.pt")).is_err());
    }

    /// Prints the outputs of a module for rows of inputs, as `MODULE ROWS NUMBER...`.
    const PYTHON: &str = "\
import sys, torch
rows = torch.tensor([float(x) for x in sys.argv[3:]]).reshape(int(sys.argv[2]), -1)
print(*torch.jit.load(sys.argv[1])(rows).flatten().tolist())
";

    #[test]
    fn pytorch_loads_the_module() {
        let has_torch = Command::new("python3").args(["-c", "import torch"]).output();
        if !has_torch.is_ok_and(|output| output.status.success()) {
            eprintln!("skipped: python3 has no torch");
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        let (network, path) = (network(Activation::Elu), folder.path().join("policy.pt"));
        save(&network, &path).unwrap();
        let mut command = Command::new("python3");
        command
            .args(["-c", PYTHON])
            .arg(&path)
            .arg(ROWS.to_string())
            .args(inputs().iter().map(f32::to_string));
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let found: Vec<f32> = String::from_utf8(output.stdout)
            .unwrap()
            .split_whitespace()
            .map(|word| word.parse().unwrap())
            .collect();
        assert_close(&found, &outputs(&network));
    }
}
