"""The notebook widgets: a thin skin over the engine."""
