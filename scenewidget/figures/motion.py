"""Eigenfunctions as vibrations: the surface swings along its normals, as a drum skin does.

A membrane swings with the frequency √λ, so each mode of an eigenbasis is given its own pace. The browser
swings it by itself, between the mesh at rest and a displaced copy; Python is asked only when the slider
chooses another eigenfunction.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import ipywidgets as widgets
import numpy as np
import numpy.typing as npt

from scenewidget.engine.mesh import FloatArray, Mesh
from scenewidget.engine.operators import Eigenbasis
from scenewidget.figures.drawing import Drawing, at_most, corner_normals, draw, nearest_vertices
from scenewidget.figures.orbit import Figure, Panel

__all__ = ["Vibration", "displaced", "vibration"]

PERIOD = 2.4  # seconds that a swing to and fro takes; in an eigenbasis, that of the lowest tone
N_KEYS = 33  # the sine is given at so many times, and the browser goes straight from one to the next


def vibration(
    mesh: Mesh,
    eigenfunction: npt.ArrayLike | Eigenbasis,
    *,
    start: int = 0,
    amplitude: float | None = None,
    title: str = "",
    edges: bool = False,
    back_faces: bool | None = None,
    view: tuple[float, float] = (-60.0, 30.0),
    width: int = 520,
    height: int = 380,
    max_faces: int = 20_000,
) -> Vibration:
    """A mesh that swings: each point moves along its normal by the eigenfunction there, to and fro.

    Press the triangle below it. The picture that stands in for it shows the largest displacement.

    Parameters
    ----------
    mesh : Mesh
    eigenfunction : Eigenbasis, or (n_vertices,) or (n_vertices, k) float
        With k columns, a slider chooses the column. Those of an eigenbasis swing at the pace √λ, as a
        membrane does (u″ = −Δu), the lowest tone once in 2.4 seconds; φ with λ = 0 stays where it is. Bare
        arrays all swing at that pace.
    start : int
        Column that is shown first.
    amplitude : float, optional
        Largest displacement in metres; a twelfth of the diagonal by default.
    title : str
        ``{i}`` in it stands for the column.
    edges, back_faces, view, width, height, max_faces
        As in `show`.

    Returns
    -------
    Figure

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> swinging = vibration(mesh, mesh.vertices[:, 0], amplitude=0.1)
    >>> type(swinging).__name__
    'Vibration'
    """
    paces: FloatArray | None = None
    if isinstance(eigenfunction, Eigenbasis):
        if eigenfunction.is_per_component:
            raise ValueError("eigenfunction must be a basis of the whole mesh, got one per component")
        tones = np.sqrt(np.maximum(eigenfunction.values, 0.0))
        paces = tones / min(tones[tones > 0], default=1.0)
        eigenfunction = eigenfunction.vectors
    phi = np.asarray(eigenfunction, np.float64)
    if phi.ndim not in (1, 2) or len(phi) != mesh.n_vertices or phi.size == 0:
        raise ValueError(
            f"eigenfunction must have shape ({mesh.n_vertices},) or ({mesh.n_vertices}, k), got {phi.shape}"
        )
    phi = phi.reshape(mesh.n_vertices, -1)
    paces = np.ones(phi.shape[1]) if paces is None else paces
    if not 0 <= start < phi.shape[1]:
        raise ValueError(f"start must lie in 0..{phi.shape[1] - 1}, the columns, got {start}")
    drawn, _ = at_most(mesh, max_faces)
    phi = phi[nearest_vertices(mesh, drawn)]
    if amplitude is None:
        low, high = (end(drawn.vertices[drawn.faces], axis=(0, 1)) for end in (np.min, np.max))
        amplitude = float(np.linalg.norm(high - low)) / 12
    options = {"edges": edges, "back_faces": back_faces}
    return Vibration(
        drawn, phi, paces, start, amplitude, title, options, view=view, width=width, height=height
    )


class Vibration(Figure):
    """A figure that swings; made by `vibration`.

    Attributes
    ----------
    at_rest : Drawing
        The mesh where it stands still; ``drawings`` shows it at its largest displacement.
    seconds : float
        That a swing to and fro takes.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> isinstance(vibration(mesh, mesh.vertices), Vibration)  # a slider chooses among three columns
    True
    """

    def __init__(
        self,
        mesh: Mesh,
        phi: FloatArray,
        paces: FloatArray,
        column: int,
        amplitude: float,
        title: str,
        options: dict[str, Any],
        **size: Any,
    ) -> None:
        self._mesh, self._phi, self._paces, self._amplitude = mesh, phi, paces, amplitude
        self._title, self._options = title, options
        super().__init__([self._drawing(column, 1.0)], **size)
        self._column = column

    @property
    def at_rest(self) -> Drawing:
        """The drawing of no displacement."""
        return self._drawing(self._column, 0.0)

    @property
    def seconds(self) -> float:
        """That the eigenfunction which is shown takes for a swing to and fro; infinite for λ = 0."""
        pace = float(self._paces[self._column])
        return PERIOD / pace if pace > 0 else float("inf")

    @cached_property
    def widget(self) -> Any:
        """The figure, its play button and its slider."""
        import pythreejs as three

        panel = Panel(self.at_rest, self.stage, morph=self.drawings[0])
        times = np.linspace(0.0, PERIOD, N_KEYS)
        track = three.NumberKeyframeTrack(
            name=".morphTargetInfluences[0]",
            times=times.astype(np.float32),
            values=np.sin(2 * np.pi * times / PERIOD).astype(np.float32),
        )
        clip = three.AnimationClip(tracks=[track], duration=PERIOD)
        swinging = panel.layers[0].object
        action = three.AnimationAction(three.AnimationMixer(swinging), clip, swinging)
        action.timeScale = float(self._paces[self._column])
        handles: list[Any] = [action]
        if self._phi.shape[1] > 1:
            slider = widgets.IntSlider(
                self._column, 0, self._phi.shape[1] - 1, description="index i", continuous_update=True
            )
            slider.observe(lambda change: self._choose(panel, action, change["new"]), "value")
            handles.append(slider)
        return widgets.VBox([panel.widget, widgets.HBox(handles)])

    def _choose(self, panel: Panel, action: Any, column: int) -> None:
        self._column = column
        action.timeScale = float(self._paces[column])
        self.drawings = (self._drawing(column, 1.0),)
        panel.draw(self.at_rest, morph=self.drawings[0])

    def _drawing(self, column: int, share: float) -> Drawing:
        phi = self._phi[:, column]
        peak = float(np.abs(phi).max()) or 1.0
        moved = displaced(self._mesh, share * self._amplitude / peak * phi)
        low, high = (end(self._mesh.vertices[self._mesh.faces], axis=(0, 1)) for end in (np.min, np.max))
        return draw(
            moved, values=phi, low=-peak, high=peak, colormap="RdBu_r", smooth=True,
            title=self._title.replace("{i}", str(column)), middle=(low + high) / 2,
            max_faces=moved.n_faces, **self._options,
        )  # fmt: skip


def displaced(mesh: Mesh, heights: FloatArray) -> Mesh:
    """The mesh with each vertex moved by its height along its normal, the mean of its faces' by area.

    Examples
    --------
    >>> import numpy as np
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> displaced(mesh, np.full(mesh.n_vertices, 0.5)).vertices[0]
    array([0. , 0. , 0.5])
    """
    corners = mesh.vertices[mesh.faces]
    normals = np.zeros((mesh.n_vertices, 3))
    normals[mesh.faces] = corner_normals(corners, mesh.faces, smooth=True)
    return Mesh(mesh.vertices + heights[:, None] * normals, mesh.faces)
