"""Kill an editing process many times at random moments and look for what is lost.

python tests/benchmarks/kill.py --rounds 200
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[1] / "editing"))

from saver import kill_rounds


def main() -> None:
    """Run the rounds and print what was found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        acknowledged, found = kill_rounds(folder, arguments.rounds, seed=arguments.seed, longest=0.5)
        size = (Path(folder) / "room.swproj").stat().st_size
    lost = sum(max(0, n - m) for n, m in zip(acknowledged, found))
    print(
        f"{arguments.rounds} kills in {time.perf_counter() - begin:.0f} s: {found[-1]} operations in "
        f"{size} bytes, {lost} acknowledged ones lost, the file opened every time"
    )
    sys.exit(lost > 0)


if __name__ == "__main__":
    main()
