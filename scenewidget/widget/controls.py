"""The settings below the picture: every option of `Params`, what it does, and when it does nothing.

Goes in: `Params`. Comes out: new `Params`, whenever a person is done with an input, and, while a thumb still
moves, those that it passes over.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import anywidget
import traitlets

from scenewidget.engine.checks import KnownNames
from scenewidget.engine.params import Params
from scenewidget.widget.bundle import bundled
from scenewidget.widget.settings import (
    PRESETS,
    SETTINGS,
    changes_from,
    idle_reasons,
    nearest_preset,
    params_code,
)

__all__ = ["ParamsControls"]


class ParamsControls(KnownNames, anywidget.AnyWidget):
    """Sliders and inputs for `Params`; ``observe`` its ``params``, or set them.

    Parameters
    ----------
    params : Params

    Examples
    --------
    >>> import scenewidget as sw
    >>> controls = ParamsControls(sw.Params(n_segments=20))
    >>> controls.params.n_segments
    20
    >>> controls.close()
    """

    _esm = traitlets.Unicode().tag(sync=True)
    _css = traitlets.Unicode().tag(sync=True)

    params = traitlets.Instance(Params)
    """As they are set."""

    can_rerun = traitlets.Bool(False).tag(sync=True)
    """Whether "Segment again" is offered: after a cancel the picture isn't what the settings say."""

    can_suggest = traitlets.Bool(False).tag(sync=True)
    """Whether "Next suggestion" is offered."""

    # --- told by Python alone ---------------------------------------------------------------------

    code = traitlets.Unicode(read_only=True).tag(sync=True)
    """Python that makes these parameters."""

    fields: Any = traitlets.List(read_only=True).tag(sync=True)
    """The inputs, as `Setting.to_json` describes each."""

    values = traitlets.Dict(read_only=True).tag(sync=True)
    """Of the options, as JSON, by name."""

    k_bounds: Any = traitlets.List(read_only=True).tag(sync=True)
    """The k-range in force."""

    idle = traitlets.Dict(read_only=True).tag(sync=True)
    """Why options have no effect, by name."""

    problems = traitlets.Dict(read_only=True).tag(sync=True)
    """What was wrong with the last value, by name."""

    changed: Any = traitlets.List(read_only=True).tag(sync=True)
    """Names of the options that differ from the preset."""

    preset = traitlets.Unicode(read_only=True).tag(sync=True)
    """Name of the preset that these parameters are nearest to."""

    presets: Any = traitlets.List(read_only=True).tag(sync=True)
    """Names of all presets."""

    family: Any = traitlets.List(read_only=True).tag(sync=True)
    """Fewest and most segments that granularity can choose, and how many the result has; empty = not yet."""

    scores: Any = traitlets.List(read_only=True).tag(sync=True)
    """Rows of the comparison with the truth, see `scenewidget.widget.scores.score_rows`."""

    revision = traitlets.Int(read_only=True).tag(sync=True)
    """The inputs are drawn anew when it grows."""

    _channel = traitlets.Unicode().tag(sync=True)
    """On which it speaks to the picture."""

    def _place_to_set(self, name: str) -> str:
        is_option = name in Params.__dataclass_fields__
        return f"write w.params = w.params.replace({name}=…)" if is_option else super()._place_to_set(name)

    def __init__(self, params: Params | None = None, **options: Any) -> None:
        self._on_move: Callable[[str, Params], None] | None = None
        self._on_leave: Callable[[], None] | None = None
        self._on_rerun: Callable[[], None] | None = None
        super().__init__(
            _esm=bundled("controls.js"), _css=bundled("controls.css"), params=params or Params(), **options
        )
        self.set_trait("fields", [setting.to_json() for setting in SETTINGS])
        self.set_trait("presets", list(PRESETS))
        self.observe(self._show, "params")
        self._show()
        self.on_msg(self._handle)

    def __repr__(self) -> str:
        return f"ParamsControls({self.code})"

    def connect(
        self,
        *,
        on_move: Callable[[str, Params], None] | None = None,
        on_leave: Callable[[], None] | None = None,
        on_rerun: Callable[[], None] | None = None,
    ) -> None:
        """Be told of what people do beside setting `params`.

        Parameters
        ----------
        on_move : callable (name, params)
            A thumb moves; so would the parameters be if it were let go here.
        on_leave : callable ()
            It is back where it was, or where it can't be.
        on_rerun : callable ()
            "Segment again" was pressed.
        """
        self._on_move, self._on_leave, self._on_rerun = on_move, on_leave, on_rerun

    def set(self, name: str, value: Any) -> None:
        """Do what a person does who sets one input.

        A value that can't be is not taken; `problems` says why. Another S takes the granularity back to
        that of the result.
        """
        try:
            params = self._with(name, value)
        except (TypeError, ValueError) as error:
            self.set_trait("problems", {name: str(error)})
            self._redraw()
            if self._on_leave is not None:
                self._on_leave()
            return
        if params == self.params:
            self._show()
            if self._on_leave is not None:
                self._on_leave()
        else:
            self.params = params

    def use_preset(self, name: str) -> None:
        """Take all options from a preset, apart from the number of segments and the seed."""
        if name not in PRESETS:
            raise ValueError(f"name must be one of {', '.join(map(repr, PRESETS))}, got {name!r}")
        p = self.params
        self.params = PRESETS[name].replace(n_segments=p.n_segments, seed=p.seed)

    def offer_family(self, bounds: Sequence[int]) -> None:
        """Let the granularity be chosen: fewest and most segments, and those of the result; () = not now."""
        self.set_trait("family", list(bounds))
        self._show()

    def show_scores(self, scores: Sequence[dict[str, str]]) -> None:
        """Show how the segments compare with the truth, each a dict of name, text, tip and trend."""
        self.set_trait("scores", list(scores))

    def _with(self, name: str, value: Any) -> Params:
        if isinstance(value, list):
            value = tuple(value)
        if name in WHOLE and isinstance(value, float) and value.is_integer():
            value = int(value)
        changes = {name: value}
        if name == "n_segments":
            changes["granularity"] = None
        if name == "granularity" and self.family and value == self.family[2]:
            changes["granularity"] = None
        return self.params.replace(**changes)

    def _show(self, _: Any = None) -> None:
        params = self.params
        idle = idle_reasons(params)
        if not self.family:
            idle["granularity"] = "It can be chosen once the clusterings behind the result are there."
        elif self.family[0] == self.family[1]:
            idle["granularity"] = "All runs agree on these segments: there are no coarser or finer ones."
        preset = nearest_preset(params)
        with self.hold_sync():
            self.set_trait("values", dataclasses.asdict(params))
            self.set_trait("k_bounds", list(params.k_bounds))
            self.set_trait("idle", idle)
            self.set_trait("problems", {})
            self.set_trait("preset", preset)
            self.set_trait("changed", list(changes_from(preset, params)))
            self.set_trait("code", params_code(params))
            self._redraw()

    def _redraw(self) -> None:
        self.set_trait("revision", self.revision + 1)

    def _handle(self, _: Any, message: Any, __: Any) -> None:
        kind = message.get("kind") if isinstance(message, dict) else None
        if kind == "set":
            self.set(message["name"], message["value"])
        elif kind == "move" and self._on_move is not None:
            try:
                params = self._with(message["name"], message["value"])
            except (TypeError, ValueError):
                return  # it is said when the thumb rests
            self._on_move(message["name"], params)
        elif kind == "leave" and self._on_leave is not None:
            self._on_leave()
        elif kind == "rerun" and self._on_rerun is not None:
            self._on_rerun()
        elif kind == "preset":
            self.use_preset(message["name"])


WHOLE = {setting.name for setting in SETTINGS if isinstance(getattr(Params(), setting.name), int)} | {
    "granularity"
}
