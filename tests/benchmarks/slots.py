"""Does it matter how dot products are mapped to slots, and on which mesh partitions are counted?

python tests/benchmarks/slots.py [--scans kitchen_25mm bedroom …]

The thesis asks for both in chapter 5. A row for each annotated scan, mapping and mesh: dihedral partitions,
those of at least 1 % of the faces, the share of faces that lie in a partition which is mostly of another true
segment, the share of k and S of the largest component, seconds; then the errors of ``Params.thesis()`` with
it. The scans lie beside the repository; the shipped room always is there.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pandas as pd

sys.path.insert(0, str(Path(__file__).parent))

import scenewidget as sw
from scenewidget.engine.dihedral import SLOT_MAPPINGS, dihedral_partition

DATA = Path(__file__).parents[3] / "shared" / "data"
SCANS = ("room", "kitchen_25mm", "kitchen_12mm", "bedroom", "bedroom_noisy")
ERRORS = ["rand_index_error", "global_consistency_error", "local_consistency_error"]


def read(name: str) -> tuple[sw.Mesh, np.ndarray] | None:
    """Scan and true segment of each face; None where its file is missing."""
    if name == "room":
        mesh, truth = sw.datasets.load_room()
        return mesh, truth.labels.astype(np.int64)
    fused = DATA / "real" / f"{name}.npz"
    if fused.exists():
        arrays = np.load(fused)
        return sw.Mesh(arrays["vertices"], arrays["faces"]), arrays["instances"].astype(np.int64)
    if not (DATA / f"{name}.ply").exists():
        return None
    return sw.load_mesh(DATA / f"{name}.ply"), np.load(DATA / f"{name}_instances.npy").astype(np.int64)


def impurity(partition: np.ndarray, truth: np.ndarray) -> float:
    """Share of the annotated faces that are not of the segment which most of their partition is of."""
    keep = (truth >= 0) & (partition >= 0)
    cell, count = np.unique(np.stack([partition[keep], truth[keep]]), axis=1, return_counts=True)
    best = np.zeros(int(partition.max()) + 1, dtype=np.int64)
    np.maximum.at(best, cell[0], count)
    return 1.0 - best.sum() / keep.sum()


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scans", nargs="+", default=SCANS)
    warnings.simplefilter("ignore")
    rows = []
    for name in parser.parse_args().scans:
        found = read(name)
        if found is None:
            print(f"{name} is not there: left out", flush=True)
            continue
        mesh, truth = found
        pipe = sw.Pipeline(mesh)
        for mapping in SLOT_MAPPINGS:
            for where in ("simplified", "raw"):
                allocation = "raw" if where == "raw" else "dihedral"
                params = sw.Params.thesis(slot_mapping=mapping, allocation=allocation)
                items = pipe.get("items", params)
                start = time.process_time()
                part = dihedral_partition(mesh if where == "raw" else items.mesh, mapping=mapping)
                seconds = time.process_time() - start
                size = np.bincount(part)
                on_raw = part if where == "raw" else np.append(part, -1)[items.face_map]
                result = pipe.run(params)
                errors = sw.evaluate({"": result}, truth, mesh, metrics=ERRORS).iloc[0]
                rows.append(
                    [name, mapping, where, len(size), int((size >= 0.01 * len(part)).sum()),
                     impurity(on_raw, truth), pipe.get("allocation", params).max(), seconds, *errors[ERRORS]]
                )  # fmt: skip
                print(*rows[-1], flush=True)
    columns = ["scan", "slots by", "mesh", "partitions", "large", "impure", "largest share", "s"]
    table = pd.DataFrame(rows, columns=[*columns, "1-RI", "GCE", "LCE"])
    print(table.round(4).to_string(index=False))
    print(table.groupby(["slots by", "mesh"])[["impure", "1-RI", "GCE", "LCE"]].mean().round(4).to_string())


if __name__ == "__main__":
    main()
