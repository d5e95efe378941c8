"""Correcting a segmentation by hand: edits, undo, project files, and formats that other tools read."""
