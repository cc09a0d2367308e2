//! Layout of a network's parameters in one flat array. Checkpoints hold Adam's moments in this layout.

use std::ops::Range;

use crate::learn::network::{Activation, Layer, Network};

/// Parameters start at multiples of this many numbers: 64 bytes, one cache line.
const ALIGNMENT: usize = 16;

/// The layout of one network.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub activation: Activation,
    pub layers: Vec<Place>,
    /// Numbers in the array, with the padding.
    pub len: usize,
}

/// Position of one layer's parameters in the array.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub inputs: usize,
    pub outputs: usize,
    /// Row-major, `outputs` rows of `inputs` numbers.
    pub weight: Range<usize>,
    pub bias: Range<usize>,
}

impl Layout {
    pub fn new(network: &Network) -> Self {
        let mut len = 0;
        let mut take = |size: usize| {
            let start = len;
            len += size.next_multiple_of(ALIGNMENT);
            start..start + size
        };
        let place = |layer: &Layer| Place {
            inputs: layer.inputs,
            outputs: layer.outputs,
            weight: take(layer.inputs * layer.outputs),
            bias: take(layer.outputs),
        };
        let layers = network.layers.iter().map(place).collect();
        Self { activation: network.activation, layers, len }
    }

    /// Number of the network's inputs.
    pub fn inputs(&self) -> usize {
        self.layers[0].inputs
    }

    /// Index at which the last layer's parameters begin; that layer can have its own step size.
    pub fn last_layer(&self) -> usize {
        self.layers.last().map_or(0, |place| place.weight.start)
    }

    /// Writes a network's parameters.
    pub fn write(&self, network: &Network, flat: &mut [f32]) {
        for (layer, place) in network.layers.iter().zip(&self.layers) {
            flat[place.weight.clone()].copy_from_slice(&layer.weight);
            flat[place.bias.clone()].copy_from_slice(&layer.bias);
        }
    }

    /// The network with these parameters.
    pub fn network(&self, flat: &[f32]) -> Network {
        let layer = |place: &Place| Layer {
            weight: flat[place.weight.clone()].to_vec(),
            bias: flat[place.bias.clone()].to_vec(),
            inputs: place.inputs,
            outputs: place.outputs,
        };
        Network { layers: self.layers.iter().map(layer).collect(), activation: self.activation }
    }
}
