"""Drawn worlds planned on all cores, and what came of them as a data set.

    python batch.py [FOLDER] [COUNT]
"""

from __future__ import annotations

import sys
from pathlib import Path

import scandent


def main(folder: Path, count: int) -> None:
    items = [
        {"item": f"ramp-{seed}", "family": "ramp", "world_seed": seed, "robot": "builtin:quadruped"}
        for seed in range(1, count + 1)
    ]
    rows = scandent.batch(items, folder, progress=lambda row: print(row["world"], row["ended"]))
    print(sum(row["ended"] == "solved" for row in rows), "of", len(rows), "solved")
    episodes = scandent.datasets.load(folder)
    print(len(episodes), "episodes,", sum(len(episode.t) for episode in episodes), "samples")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/batch"), int(sys.argv[2]) if len(sys.argv) > 2 else 4)
