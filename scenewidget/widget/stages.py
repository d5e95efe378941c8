"""What a person reads of the stages of the pipeline while they run."""

from __future__ import annotations

__all__ = ["STAGE_NAMES"]

STAGE_NAMES = {
    "adjacency": "Finding neighbouring faces",
    "items": "Gathering faces into items",
    "dihedral": "Partitioning by dihedral angle",
    "allocation": "Sharing out clusters over components",
    "eigenbasis": "Solving for eigenfunctions",
    "features": "Computing features",
    "distances": "Measuring distances",
    "graph_runs": "Segmenting the graph many times",
    "ensemble": "Clustering many times",
    "coassociation": "Comparing the clusterings",
    "tree": "Building the consensus tree",
    "trees": "Building the consensus trees",
    "consensus": "Finding the consensus",
    "finish": "Tidying segments up",
    "segmentation": "Labelling every face",
    "family": "Finding coarser and finer segments",
    "granularity": "Choosing the granularity",
}
