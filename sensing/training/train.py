#!/usr/bin/env python3
"""Trains the networks by which the sorting task's camera and matrix tell their eight kinds of parts.

    cargo run --release -p sorting -- --data-set train.csv --parts 24000 --seed 101
    python3 sensing/training/train.py train.csv tasks/sorting/assets/parts.onnx

    cargo run --release -p sorting -- --sensor ultrasonic --data-set train.csv --parts 3700 --seed 101
    python3 sensing/training/train.py train.csv tasks/sorting/assets/reliefs.onnx

Needs numpy, scikit-learn and onnx (PyPI). One hidden layer of 24, rectified; scores by softmax. The features are brought to mean 0 and
deviation 1; that is folded into the first layer, so that the network takes them as they are. A line of the table is a kind and the
features of one part. A tenth of the table is held back and tells how good the network is. Seeds are fixed and one thread adds up, so that the same table gives the
same file to the byte on one machine with one version of these packages (numpy 2.4.6, scikit-learn 1.9.1, onnx 1.23.2, say).
"""

import os
import sys

# Before numpy is loaded: sums by several threads depend on how many there are.
for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[threads] = "1"

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper
from sklearn.neural_network import MLPClassifier

SEED = 7
HIDDEN = 24


def main(table: str, out: str) -> None:
    data = np.loadtxt(table, delimiter=",")
    kinds, features = data[:, 0].astype(int), data[:, 1:]
    order = np.random.default_rng(SEED).permutation(len(kinds))
    held, used = order[: len(order) // 10], order[len(order) // 10 :]

    mean, deviation = features[used].mean(0), features[used].std(0) + 1e-6
    network = MLPClassifier((HIDDEN,), alpha=1e-3, batch_size=256, learning_rate_init=3e-3, max_iter=200, random_state=SEED)
    network.fit((features[used] - mean) / deviation, kinds[used])
    told = network.predict((features[held] - mean) / deviation)
    print(f"{len(used)} parts learned; of {len(held)} others {np.mean(told == kinds[held]):.2%} are told rightly")

    (first, last), (first_bias, last_bias) = network.coefs_, network.intercepts_
    folded = first / deviation[:, None]
    weights = {
        "w1": folded,
        "b1": first_bias - mean @ folded,
        "w2": last,
        "b2": last_bias,
    }
    count = last.shape[1]
    assert count == kinds.max() + 1 and count > 2
    nodes = [
        helper.make_node("Gemm", ["features", "w1", "b1"], ["sums"]),
        helper.make_node("Relu", ["sums"], ["hidden"]),
        helper.make_node("Gemm", ["hidden", "w2", "b2"], ["raw"]),
        helper.make_node("Softmax", ["raw"], ["scores"], axis=1),
    ]
    value = lambda name, size: helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, size])
    stored = [numpy_helper.from_array(array.astype(np.float32), name) for name, array in weights.items()]
    graph = helper.make_graph(nodes, "parts", [value("features", features.shape[1])], [value("scores", count)], stored)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], producer_name="train.py")
    model.ir_version = 8
    onnx.checker.check_model(model)
    onnx.save(model, out)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
