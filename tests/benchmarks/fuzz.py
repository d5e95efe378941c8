"""Open damaged files for minutes, each reader; anything but reading and refusing them stops with the seed.

python tests/benchmarks/fuzz.py --minutes 5
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[1] / "editing"))

from fuzzing import READERS, Fuzzer


def main() -> None:
    """Attack each reader for so long and print how often it refused."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=5.0, help="for each reader")
    parser.add_argument("--readers", nargs="+", choices=READERS, default=READERS)
    parser.add_argument("--seed", type=int, default=1_000_000)
    arguments = parser.parse_args()
    print("reader               files   refused")
    with tempfile.TemporaryDirectory() as folder:
        fuzzer = Fuzzer(folder)
        for reader in arguments.readers:
            end, seed, refused = time.perf_counter() + 60 * arguments.minutes, arguments.seed, 0
            while time.perf_counter() < end:
                try:
                    refused += fuzzer.attack(reader, seed)
                except BaseException:
                    print(f"{reader}, seed {seed}:", flush=True)
                    raise
                seed += 1
            n = seed - arguments.seed
            print(f"{reader:16} {n:9} {refused / n:9.1%}", flush=True)


if __name__ == "__main__":
    main()
