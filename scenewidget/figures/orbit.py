"""Drawings in the browser, to be turned with the mouse: one camera for all panels of a figure.

Goes in: drawings. Comes out: a `Figure`, which a cell shows; its ``widget`` goes into other widgets. Drawn
by pythreejs, with plain materials: the light is in the colours already.
"""

from __future__ import annotations

import html
import itertools
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import ipywidgets as widgets
import numpy as np

from scenewidget.figures.drawing import Drawing
from scenewidget.figures.picture import camera_for, color_bar, png
from scenewidget.figures.raster import FIELD_OF_VIEW, Camera
from scenewidget.figures.scale import ColorScale

__all__ = ["Figure"]

# On a page that is narrower than a figure, the figure is drawn smaller instead of cut off.
SHRINKING = (
    "<style>.scenewidget-figure canvas { max-width: 100% !important; height: auto !important }</style>"
)


class Figure:
    """One or more drawings with one camera; it displays itself as the last value of a cell.

    Parameters
    ----------
    drawings : sequence of Drawing
    view : (azimuth, elevation)
        Degrees: from where it is looked at first.
    width, height : int
        Pixels of each panel.

    Attributes
    ----------
    widget : ipywidgets.Widget
        What the browser shows, made on first use; put it in boxes with other widgets.

    Examples
    --------
    >>> from scenewidget.datasets import analytic
    >>> mesh = analytic.square(2)  # 8 triangles
    >>> from scenewidget.figures.drawing import draw
    >>> figure = Figure([draw(mesh)], view=(0.0, 90.0))
    >>> figure.png()[1:4]
    b'PNG'
    """

    def __init__(
        self,
        drawings: Sequence[Drawing],
        *,
        view: tuple[float, float] = (-60.0, 30.0),
        width: int = 520,
        height: int = 380,
    ) -> None:
        self.drawings = tuple(drawings)
        self.view = view
        self.width, self.height = width, height

    def __repr__(self) -> str:
        n = len(self.drawings)
        return f"Figure({n} panel{'s' * (n > 1)})"

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        from base64 import b64encode

        bundle: dict[str, Any] = self.widget._repr_mimebundle_() or {}
        return {**bundle, "text/plain": repr(self), "image/png": b64encode(self.png()).decode()}

    def png(self) -> bytes:
        """The first view as a PNG, for places where no browser draws it."""
        return png(self.drawings, view=self.view, width=self.width, height=self.height)

    def redraw(self, figure: Figure | Drawing) -> None:
        """Show what another figure shows in place of this, from where it is looked at now.

        The cheap way to follow a slider: same number of panels, and only colours and positions are sent.
        """
        drawings = (figure,) if isinstance(figure, Drawing) else figure.drawings
        if len(drawings) != len(self.drawings):
            raise ValueError(f"figure must have {len(self.drawings)} panels, got {len(drawings)}")
        self.drawings = drawings
        if "panels" in vars(self):
            for panel, drawing in zip(self.panels, drawings):
                panel.draw(drawing)

    @cached_property
    def widget(self) -> Any:
        """The figure as an ipywidgets widget."""
        row = widgets.HBox(
            [panel.widget for panel in self.panels], layout=widgets.Layout(flex_flow="row wrap")
        )
        return row if len(self.panels) > 1 else self.panels[0].widget

    @cached_property
    def panels(self) -> list[Panel]:
        """What the browser draws, one for each drawing."""
        return [Panel(drawing, self.stage) for drawing in self.drawings]

    @cached_property
    def stage(self) -> Stage:
        """The camera and the mouse's hold on it, both shared, so that turning one panel turns all."""
        return Stage(self.drawings, self.view, self.width, self.height)


class Stage:
    """A camera that looks at the origin, the mouse's hold on it, and where a drawing's origin is put.

    The controls turn the camera towards the origin as soon as they exist, so it is the drawings that move.
    """

    def __init__(
        self, drawings: Sequence[Drawing], view: tuple[float, float], width: int, height: int
    ) -> None:
        import pythreejs as three

        self.width, self.height = width, height
        place = camera_for(drawings, view, width / height)
        x, y, z = place.target
        self.shift = (-x, -y, -z)
        self.camera = three.PerspectiveCamera(
            fov=FIELD_OF_VIEW,
            aspect=width / height,
            near=0.02 * place.distance,
            far=8 * place.distance,
            up=(0.0, 0.0, 1.0),
            position=tuple((place.position + self.shift).tolist()),
            quaternion=_quaternion(place),
        )
        self.controls = three.OrbitControls(controlling=self.camera)


class Panel:
    """One drawing with its title, colour bar and note.

    The surface and what is drawn on it are two objects, so that a mark can move without the surface being
    sent again. With ``morph``, a drawing of as many triangles, they are one, and the browser can move its
    corners towards those of that drawing.
    """

    def __init__(
        self,
        drawing: Drawing,
        stage: Stage,
        *,
        morph: Drawing | None = None,
    ) -> None:
        import pythreejs as three

        self._shift = stage.shift
        self.scene = three.Scene(background="#ffffff")
        self.renderer = three.Renderer(
            scene=self.scene,
            camera=stage.camera,
            controls=[stage.controls],
            width=stage.width,
            height=stage.height,
            antialias=True,
            background="#ffffff",
        )
        self.title, self.legend = widgets.HTML(), widgets.HTML()
        self.layers: list[_Layer] = []
        self.draw(drawing, morph=morph)
        self.widget = widgets.VBox(
            [self.title, self.renderer, self.legend],
            layout=widgets.Layout(width=f"{stage.width + 8}px", max_width="100%"),
        )
        self.widget.add_class("scenewidget-figure")

    def draw(self, drawing: Drawing, *, morph: Drawing | None = None) -> None:
        """Show it; of a layer with as many triangles as the last, only what differs is sent."""
        cuts = [0, len(drawing.corners)] if morph else [0, drawing.n_surface, len(drawing.corners)]
        layers = []
        for i, (start, end) in enumerate(itertools.pairwise(cuts)):
            arrays = {
                "position": _rows(drawing.corners[start:end]),
                "color": np.ascontiguousarray(drawing.colors[start:end].reshape(-1, 3)),
            }
            if i == 0 and drawing.faces is not None and morph is None:
                arrays = _at_points(arrays, drawing.faces)
            if morph is not None:
                arrays["morph"] = _rows(morph.corners)
            old = self.layers[i] if i < len(self.layers) else None
            if old is not None and (end == start or old.takes(arrays, _side(drawing))):
                old.object.visible = end > start  # what isn't drawn for now comes back at once
                layers.append(old)
            elif end > start:
                layers.append(_Layer(arrays, _side(drawing), self._shift, order=i))
        if layers != self.layers:
            self.layers = layers
            self.scene.children = [layer.object for layer in layers]
        for box, text in ((self.title, _title(drawing)), (self.legend, _legend(drawing))):
            value = SHRINKING + text if box is self.title else text
            if box.value != value:
                box.value = value
            box.layout.display = "" if text else "none"


class _Layer:
    """Triangles that the browser has, with the arrays in which they came."""

    def __init__(
        self, arrays: dict[str, Any], side: str, shift: tuple[float, float, float], *, order: int
    ) -> None:
        import pythreejs as three

        self.side = side
        self.attributes = {
            name: three.BufferAttribute(array, normalized=array.dtype == np.uint8)
            for name, array in arrays.items()
        }
        plain = {name: self.attributes[name] for name in ("position", "color")}
        shared = {"index": self.attributes["index"]} if "index" in arrays else {}
        target = {"position": [self.attributes["morph"]]} if "morph" in arrays else {}
        geometry = three.BufferGeometry(attributes=plain, morphAttributes=target, **shared)
        material = three.MeshBasicMaterial(vertexColors="VertexColors", side=side, morphTargets=bool(target))
        self.object = three.Mesh(
            geometry,
            material,
            position=shift,
            morphTargetInfluences=[0.0] if target else [],
            renderOrder=order,  # what is drawn on a surface comes after it
        )

    def takes(self, arrays: dict[str, Any], side: str) -> bool:
        """Take over other arrays, if they are as long; whether they are."""
        shapes = {name: attribute.array.shape for name, attribute in self.attributes.items()}
        if side != self.side or shapes != {name: array.shape for name, array in arrays.items()}:
            return False
        for name, attribute in self.attributes.items():
            if not np.array_equal(attribute.array, arrays[name]):
                attribute.array = arrays[name]
        return True


def _side(drawing: Drawing) -> str:
    return "FrontSide" if drawing.hides_back else "DoubleSide"


def _rows(corners: Any) -> Any:
    """(3 n_triangles, 3) float32."""
    return corners.reshape(-1, 3).astype(np.float32)


def _at_points(arrays: dict[str, Any], faces: Any) -> dict[str, Any]:
    """A row a point instead of one a corner, and the points of each triangle."""
    index = faces.ravel().astype(np.uint32)
    rows = {
        name: np.zeros((int(index.max()) + 1, *array.shape[1:]), array.dtype)
        for name, array in arrays.items()
    }
    for name, array in arrays.items():
        rows[name][index] = array
    return {**rows, "index": index}


def _quaternion(camera: Camera) -> tuple[float, float, float, float]:
    """The camera's rotation as x, y, z, w; it looks along its own −z."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(camera.axes.T).as_quat()
    return float(x), float(y), float(z), float(w)


def _title(drawing: Drawing) -> str:
    if not drawing.title:
        return ""
    return f'<div style="text-align:center;font-weight:600">{html.escape(drawing.title)}</div>'


def _legend(drawing: Drawing) -> str:
    parts = [] if drawing.scale is None else [_bar(drawing.scale)]
    if drawing.note:
        parts.append(
            f'<div style="text-align:center;opacity:.65;font-size:12px">{html.escape(drawing.note)}</div>'
        )
    return "".join(parts)


def _bar(scale: ColorScale) -> str:
    stops = ",".join("#{:02x}{:02x}{:02x}".format(*color) for color in color_bar(scale, 17))
    low, middle, high = scale.ticks()
    texts = "".join(f"<span>{html.escape(text)}</span>" for text in (low, scale.title or middle, high))
    return (
        '<div style="width:62%;margin:auto;font-size:12px;line-height:1.4">'
        f'<div style="height:10px;background:linear-gradient(to right,{stops})"></div>'
        f'<div style="display:flex;justify-content:space-between">{texts}</div></div>'
    )
