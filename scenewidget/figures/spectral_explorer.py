"""The spectrum of a mesh to be played with: eigenfunctions, low-pass shapes, heat, on sliders.

`SpectralExplorer` holds traits and sliders and asks the engine for eigenpairs, once for each Laplacian;
what the sliders then show are sums over them, a few milliseconds each.
"""

from __future__ import annotations

from typing import Any

import ipywidgets as widgets
import numpy as np
import traitlets

from scenewidget.datasets import analytic
from scenewidget.engine.features import heat_kernel_signature, heat_kernel_times
from scenewidget.engine.mesh import FloatArray, Mesh, weld
from scenewidget.engine.operators import Eigenbasis, LaplacianKind, eigenbasis, vertex_components
from scenewidget.engine.readers import load_mesh
from scenewidget.figures.drawing import Drawing, at_most, draw
from scenewidget.figures.orbit import Figure
from scenewidget.figures.scale import DIVERGING

__all__ = ["SpectralExplorer", "heat_from", "low_pass"]

MODES = {  # label, and the sliders that it needs
    "eigenfunction": ("Eigenfunction", ("index",)),
    "low pass": ("Low-pass shape", ("n_functions",)),
    "heat": ("Heat from a point", ("time", "source")),
    "signature": ("Heat kernel signature", ("time",)),
}
KINDS = ("cotangent", "uniform")
SHOWN = (
    0.99  # of the vertices have a colour between the ends of the scale; a few extremes would pale the rest
)
SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


def low_pass(basis: Eigenbasis, values: FloatArray, n_functions: int) -> FloatArray:
    """Values rebuilt from the first eigenfunctions alone: Σ_i φ_i ⟨φ_i, values⟩, i < n_functions.

    Parameters
    ----------
    basis : Eigenbasis
        Of the whole mesh, not per component.
    values : (n_vertices, d) or (n_vertices,) float
    n_functions : int
        From 1 (the mean, on a connected mesh) to ``basis.k``.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> basis = eigenbasis(mesh, 3)
    >>> low_pass(basis, np.ones(mesh.n_vertices), 1).round(6)
    array([1., 1., 1., 1., 1., 1., 1., 1., 1.])
    """
    phi = basis.vectors[:, :n_functions]
    weighted = basis.mass[:, None] * values if values.ndim == 2 else basis.mass * values
    rebuilt: FloatArray = phi @ (phi.T @ weighted)
    return rebuilt


def heat_from(basis: Eigenbasis, vertex: int, time: float) -> FloatArray:
    """Heat at each vertex after a time, started as a unit at one: Σ_i exp(−λ_i t) φ_i(vertex) φ_i.

    A basis with few eigenpairs can't hold a sharp point: at short times there are ripples below 0.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(4)
    >>> heat = heat_from(eigenbasis(mesh, 10), vertex=0, time=0.05)
    >>> int(heat.argmax())
    0
    """
    heat: FloatArray = basis.vectors @ (np.exp(-basis.values * time) * basis.vectors[vertex])
    return heat


class SpectralExplorer(widgets.VBox):
    """A mesh with sliders through its spectrum; it displays itself as the last value of a cell.

    Left drag turns the mesh; a double click on it moves the source of the heat there.

    Parameters
    ----------
    mesh : Mesh, path, trimesh.Trimesh or (vertices, faces), optional
        An oval ring, closed and without symmetric twins among its eigenvalues, if not given. With more faces
        than ``max_faces`` it is simplified first, and of several pieces only the one with the largest area
        is taken, for eigenfunctions of the whole live on one piece each; the explorer says so.
    k : int
        Number of eigenpairs, at least 2; the constant one counts.
    laplacian : "cotangent" or "uniform"
    max_faces : int
        10 000 answer within a tenth of a second.
    view : (azimuth, elevation)
        Degrees: from where it is looked at first.
    width, height : int
        Pixels of the picture.

    Raises
    ------
    ValueError
        k is below 2: nothing would be left beside the constant eigenfunction.

    Attributes
    ----------
    mode : "eigenfunction", "low pass", "heat" or "signature"
        What is shown: φ_index; the shape rebuilt from the first ``n_functions`` eigenfunctions, coloured by
        how far it moved; heat spread from ``source`` after ``time``; heat left where it started.
    index, n_functions, source : int
        ``index`` begins at 1: φ₀ is constant, with λ = 0, and no vibration.
    time : float
        Square metres (cotangent), steps (uniform).
    laplacian : str
        Set any of these, or observe it.
    mesh : Mesh
        What is looked at.
    basis : Eigenbasis
        Of ``laplacian``; the first use of each takes a second at 10 000 faces.
    values : (n_vertices,) float64
        The numbers on show.
    vertices : (n_vertices, 3) float64
        The shape on show.

    Examples
    --------
    >>> import scenewidget as sw
    >>> from scenewidget.datasets import analytic
    >>> explorer = sw.SpectralExplorer(analytic.square(6), k=8)
    >>> explorer
    SpectralExplorer(72 faces, 8 eigenfunctions)
    >>> explorer.mode = "heat"
    >>> explorer.values.shape
    (49,)
    >>> explorer.close()
    """

    mode = traitlets.Enum(tuple(MODES), "eigenfunction")
    """What is shown, see above."""

    index = traitlets.Int(1, min=1)
    """Which eigenfunction; from 1, for φ₀ is constant."""

    n_functions = traitlets.Int(20, min=1)
    """How many eigenfunctions the low-pass shape is made of."""

    source = traitlets.Int(0, min=0)
    """Vertex at which the heat starts."""

    time = traitlets.Float(1.0, min=0.0)
    """How long the heat has spread: square metres (cotangent), steps (uniform)."""

    laplacian = traitlets.Enum(KINDS, "cotangent")
    """Whose eigenfunctions these are."""

    def __init__(
        self,
        mesh: Mesh | Any = None,
        *,
        k: int = 100,
        laplacian: LaplacianKind = "cotangent",
        max_faces: int = 10_000,
        view: tuple[float, float] = (-60.0, 30.0),
        width: int = 640,
        height: int = 420,
    ) -> None:
        if not k >= 2:
            raise ValueError(f"k must be at least 2, got {k}: the first eigenfunction is constant")
        given = _oval_ring() if mesh is None else load_mesh(mesh)
        self.mesh, n_pieces = _largest_piece(given)
        notes = []
        if n_pieces > 1:
            notes.append(
                f"the largest of {n_pieces} pieces, {self.mesh.n_faces / given.n_faces:.1%} of the faces"
            )
        n_faces = self.mesh.n_faces
        if n_faces > max_faces:  # what simplification tears off is a crumb again
            self.mesh, _ = _largest_piece(at_most(self.mesh, max_faces)[0])
            notes.append(f"simplified from {n_faces} to {self.mesh.n_faces} faces")
        self._note = "; ".join(notes)
        self._k = k
        self._bases: dict[str, Eigenbasis] = {}
        self._clocks: dict[str, widgets.FloatLogSlider] = {}
        self._is_held, self._is_read = False, True
        super().__init__(laplacian=laplacian)
        self.set_trait("source", int(self.mesh.faces[0, 0]))
        self._make_controls()
        self.figure = Figure([self._drawing()], view=view, width=width, height=height)
        self.children = [
            self._picture(),
            widgets.HBox([self._mode, self._kind], layout={"flex_flow": "row wrap"}),
            *self._sliders.values(),
        ]
        self.observe(self._take_basis, "laplacian")
        self.observe(self._set_clock, "time")
        self.observe(self._redraw, ["mode", "index", "n_functions", "source", "time", "laplacian"])
        self._show_sliders()

    def __repr__(self) -> str:
        return f"SpectralExplorer({self.mesh.n_faces} faces, {self.basis.k} eigenfunctions)"

    def _repr_mimebundle_(self, **options: Any) -> dict[str, Any]:
        from base64 import b64encode

        bundle = super()._repr_mimebundle_(**options) or {}
        return {**bundle, "image/png": b64encode(self.figure.png()).decode()}

    @property
    def basis(self) -> Eigenbasis:
        """Eigenpairs of the chosen Laplacian."""
        kind: Any = self.laplacian
        if kind not in self._bases:
            self._bases[kind] = eigenbasis(self.mesh, self._k, laplacian=kind)
        return self._bases[kind]

    @property
    def vertices(self) -> FloatArray:
        """(n_vertices, 3) the shape on show."""
        if self.mode != "low pass":
            return self.mesh.vertices
        return low_pass(self.basis, self.mesh.vertices, self.n_functions)

    @property
    def values(self) -> FloatArray:
        """(n_vertices,) the numbers on show."""
        if self.mode == "eigenfunction":
            return self.basis.vectors[:, self.index]
        if self.mode == "low pass":
            moved: FloatArray = np.linalg.norm(self.vertices - self.mesh.vertices, axis=1)
            return moved
        if self.mode == "heat":
            return heat_from(self.basis, self.source, self.time)
        return heat_kernel_signature(self.basis, np.array([self.time]))[:, 0]

    def _drawing(self) -> Drawing:
        basis, mode = self.basis, self.mode
        meter = self.laplacian == "cotangent"
        title, unit = {
            "eigenfunction": (
                f"φ{str(self.index).translate(SUBSCRIPTS)},  λ = {basis.values[self.index]:.4g}"
                + (" 1/m²" if meter else ""),
                "φ",
            ),
            "low pass": (f"the shape from {self.n_functions} of {basis.k} eigenfunctions", "moved by, m"),
            "heat": (f"heat from vertex {self.source} after t = {self.time:.3g}" + " m²" * meter, "heat"),
            "signature": (f"heat left where it started after t = {self.time:.3g}" + " m²" * meter, "HKS"),
        }[mode]
        values = self.values
        low, high = np.quantile(values, [1 - SHOWN, SHOWN])
        if mode in ("heat", "low pass"):
            low = 0.0
        elif mode == "eigenfunction":  # white is where it vanishes
            high = max(-low, high)
            low = -high
        shape = Mesh(self.vertices, self.mesh.faces) if mode == "low pass" else self.mesh
        return draw(
            shape, values=values, title=title, scale_title=unit, max_faces=shape.n_faces,
            colormap=DIVERGING if mode == "eigenfunction" else None,
            low=float(low) if high > low else None, high=float(high) if high > low else None,
            points=[self.source] if mode == "heat" else None,
            middle=self._middle, back_faces=True if mode == "low pass" else None,
        )  # fmt: skip

    @traitlets.validate("index", "n_functions", "source")
    def _inside(self, proposal: dict[str, Any]) -> int:
        name, value = proposal["trait"].name, int(proposal["value"])
        most = {
            "index": self.basis.k - 1,
            "n_functions": self.basis.k,
            "source": self.mesh.n_vertices - 1,
        }[name]
        if value > most:
            raise traitlets.TraitError(f"{name} must be at most {most}, got {value}")
        return value

    # --- sliders ------------------------------------------------------------------------------------

    def _make_controls(self) -> None:
        low, high = (end(self.mesh.vertices[self.mesh.faces], axis=(0, 1)) for end in (np.min, np.max))
        self._middle = (low + high) / 2

        last = self.basis.k - 1
        self.set_trait("index", min(self.index, last))
        self.set_trait("n_functions", min(self.n_functions, last + 1))
        self._mode = widgets.Dropdown(
            options=[(label, name) for name, (label, _) in MODES.items()], description="Show", **_wide()
        )
        self._kind = widgets.ToggleButtons(options=KINDS, style={"button_width": "90px"})
        self._sliders = {
            "index": widgets.IntSlider(self.index, 1, last, description="Eigenfunction", **_wide()),
            "n_functions": widgets.IntSlider(
                self.n_functions, 1, last + 1, description="Basis functions", **_wide()
            ),
            "time": self._clock(),
            "source": widgets.BoundedIntText(
                self.source, 0, self.mesh.n_vertices - 1, description="Source vertex", **_wide()
            ),
        }
        traitlets.link((self, "mode"), (self._mode, "value"))
        traitlets.link((self, "laplacian"), (self._kind, "value"))
        for name in ("index", "n_functions", "source"):
            traitlets.link((self, name), (self._sliders[name], "value"))
        self.time = self._sliders["time"].value
        self._remark = widgets.HTML(self._note)

    def _picture(self) -> Any:
        import pythreejs as three

        picture = self.figure.widget
        panel = self.figure.panels[0]
        picker = three.Picker(controlling=panel.scene, event="dblclick")
        picker.observe(self._move_source, "point")
        panel.renderer.controls = [*panel.renderer.controls, picker]
        return widgets.VBox([picture, self._remark]) if self._note else picture

    def _move_source(self, change: dict[str, Any]) -> None:
        if change["owner"].faceIndex is None:
            return
        place = np.array(change["new"]) - self.figure.stage.shift + self._middle
        used = np.unique(self.mesh.faces)
        self.source = int(used[np.linalg.norm(self.vertices[used] - place, axis=1).argmin()])

    def _take_basis(self, _: Any = None) -> None:
        """Take the eigenvalues' own time slider, with the time that it showed last.

        One slider with another range comes back from the page with a time of its own, to be drawn once more.
        """
        self._sliders["time"].layout.display = "none"
        self._sliders["time"] = clock = self._clock()
        if clock not in self.children:
            self.children = [*self.children, clock]
        self._is_held = True  # one picture for one click
        self.time = clock.value
        self._is_held = False

    def _clock(self) -> widgets.FloatLogSlider:
        """The time slider of this Laplacian, made when first asked for, with the range of its eigenvalues."""
        if self.laplacian not in self._clocks:
            step = 0.02
            lowest, middle, highest = np.round(np.log10(heat_kernel_times(self.basis, 3)) / step)
            clock = widgets.FloatLogSlider(
                10.0 ** (middle * step), min=lowest * step - 1, max=highest * step, step=step,
                description="Diffusion time t", readout_format=".3g", **_wide(),
            )  # fmt: skip
            clock.observe(self._read_clock, "value")
            self._clocks[self.laplacian] = clock
        return self._clocks[self.laplacian]

    def _set_clock(self, change: dict[str, Any]) -> None:
        self._is_read = False  # a time beyond the slider holds, with the slider at its end
        self._sliders["time"].value = change["new"]
        self._is_read = True

    def _read_clock(self, change: dict[str, Any]) -> None:
        if self._is_read:
            self.time = change["new"]

    def _redraw(self, change: dict[str, Any]) -> None:
        if self._is_held or (change["name"] in self._sliders and change["name"] not in MODES[self.mode][1]):
            return
        self._show_sliders()
        self.figure.redraw(self._drawing())

    def _show_sliders(self) -> None:
        for name, slider in self._sliders.items():
            slider.layout.display = "" if name in MODES[self.mode][1] else "none"


def _wide() -> dict[str, Any]:
    return {
        "layout": widgets.Layout(width="460px", max_width="calc(100% - 4px)"),
        "style": {"description_width": "150px"},
    }


def _oval_ring() -> Mesh:
    """A torus with a long and a short side: closed, smooth, and with hardly any multiple eigenvalue."""
    ring = analytic.torus(n_ring=96, n_tube=40)
    return Mesh(ring.vertices * [1.0, 0.7, 1.0], ring.faces)


def _largest_piece(mesh: Mesh) -> tuple[Mesh, int]:
    """The connected part with the largest area, and how many parts there were.

    Vertices at one place are one here: files of loose triangles would fall into dust.
    """
    if len(np.unique(vertex_components(mesh)[mesh.faces[:, 0]])) == 1:
        return mesh, 1
    welded = Mesh(mesh.vertices, weld(mesh)[mesh.faces], mesh.vertex_colors)
    part = vertex_components(welded)[welded.faces[:, 0]]
    areas = np.bincount(part, mesh.face_areas)
    return analytic.part_of(welded, part == areas.argmax()), len(np.unique(part))
