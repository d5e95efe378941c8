"""The method: pure functions from a mesh to its segments. Runs without Jupyter.

Data flows downwards: mesh, preprocess, items, dihedral, operators, features, distances, kmedoids,
ensemble, consensus, segmentation, pipeline.
"""
