"""Attack project files: splices of true states, copies while somebody edits, kills while one is upgraded.

python tests/benchmarks/attack.py --splices 5000 --copies 500 --kills 200
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[1] / "editing"))

from attacks import try_live_copies, try_migration_kills, try_splices


def main() -> None:
    """Try them all and print what became of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--splices", type=int, default=5_000)
    parser.add_argument("--copies", type=int, default=500)
    parser.add_argument("--kills", type=int, default=200, help="of migrations; kill.py kills edits")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    n_wrong = 0
    for title, attack, n in (
        ("splices", try_splices, arguments.splices),
        ("live copies", try_live_copies, arguments.copies),
    ):
        begin = time.perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            n_true, n_refused, wrong = attack(folder, n, seed=arguments.seed)
        seconds = time.perf_counter() - begin
        print(f"{n} {title} in {seconds:.0f} s: {n_true} true, {n_refused} refused, {len(wrong)} wrong")
        print("".join(f"  {what}\n" for what in wrong[:20]), end="")
        n_wrong += len(wrong)
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        not_yet, done = try_migration_kills(folder, arguments.kills, seed=arguments.seed)
    seconds = time.perf_counter() - begin
    print(
        f"{arguments.kills} kills of migrations in {seconds:.0f} s: {not_yet} not begun, {done} done, 0 lost"
    )
    sys.exit(n_wrong > 0)


if __name__ == "__main__":
    main()
