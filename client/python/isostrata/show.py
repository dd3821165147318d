"""What a notebook displays."""

from __future__ import annotations

import base64
import html
from typing import TYPE_CHECKING, Any, Iterable, Optional

from .scene import hex_of

if TYPE_CHECKING:
    from .session import Session


class View:
    """A picture of a session that draws itself where it is displayed, with the layers' swatches and ranges below it. The simple
    controls return the view, so that a cell may end with them: ``s.show().turn(30).zoom(1.5)``. ``interact()`` gives sliders."""

    def __init__(self, session: Session, width: int, height: int) -> None:
        self.session = session
        self.width = width
        self.height = height

    # ---- simple controls -------------------------------------------------------------------------------------------------------

    def turn(self, azimuth: float, elevation: float = 0.0) -> View:
        """To the right and upwards about what is looked at, in degrees."""
        self.session.camera = self.session.camera.turned(azimuth, elevation)
        return self

    def zoom(self, factor: float) -> View:
        self.session.camera = self.session.camera.zoomed(factor)
        return self

    def view(self, view: str = "reset") -> View:
        self.session.view(view)
        return self

    def interval(self, index: int, lower: Optional[float] = None, upper: Optional[float] = None, **changes: Any) -> View:
        """Changes a layer by its place in the list."""
        ends = {name: value for name, value in (("lower", lower), ("upper", upper)) if value is not None}
        self.session.intervals.patch(self.session.intervals[index], **ends, **changes)
        return self

    # ---- what Jupyter asks for ---------------------------------------------------------------------------------------------------

    def _repr_png_(self) -> bytes:
        return self.session.png(self.width, self.height)

    def _repr_html_(self) -> str:
        return self._html(base64.b64encode(self._repr_png_()).decode())

    def _repr_mimebundle_(self, include: Optional[Iterable[str]] = None, exclude: Optional[Iterable[str]] = None) -> dict[str, str]:
        picture = base64.b64encode(self._repr_png_()).decode()
        bundle = {"image/png": picture, "text/html": self._html(picture), "text/plain": repr(self)}
        kept = {kind: data for kind, data in bundle.items() if include is None or kind in set(include)}
        return {kind: data for kind, data in kept.items() if kind not in set(exclude or ())}

    def __repr__(self) -> str:
        layers = ", ".join(f"{i.lower:g}:{i.upper:g}" for i in self.session.message.intervals)
        return f"<isostrata view {self.width}x{self.height} of {self.session.message.dataset}: {layers or 'no layers'}>"

    def _html(self, picture: str) -> str:
        state = self.session.message
        rows = "".join(
            f'<span style="display:inline-block;margin-right:1.2em;opacity:{1 if i.visible else 0.4}">'
            f'<span style="display:inline-block;width:0.9em;height:0.9em;vertical-align:-0.1em;background:{hex_of(i.color)}"></span> '
            f"{html.escape(i.name or i.color_map)} {i.lower:g} &hellip; {i.upper:g}</span>"
            for i in state.intervals
        )
        what = html.escape(f"{self.session.info.name or state.dataset}, {state.array}, revision {state.revision}")
        return (
            f'<figure style="margin:0"><img alt="{what}" width="{self.width}" height="{self.height}" src="data:image/png;base64,{picture}">'
            f'<figcaption style="font:13px sans-serif">{rows}<br><span style="opacity:0.6">{what}</span></figcaption></figure>'
        )

    def interact(self) -> Any:
        """Sliders for the layers and the camera, by ipywidgets (python3-ipywidgets), which is asked for only here."""
        import ipywidgets as widgets

        session = self.session
        lowest, highest = session.arrays.get(session.array, (0.0, 1.0))
        picture = widgets.Image(value=self._repr_png_(), format="png", width=self.width, height=self.height)

        def draw() -> None:
            picture.value = self._repr_png_()

        controls = []
        for layer in session.intervals:
            slider = widgets.FloatRangeSlider(
                value=(layer.lower, layer.upper),
                min=min(lowest, layer.lower),
                max=max(highest, layer.upper),
                step=(highest - lowest) / 500 or 1.0,
                description=layer.name or f"{session.array} {layer.id}",
                readout_format=".4g",
                continuous_update=False,
            )

            def moved(change: Any, which: int = layer.id) -> None:
                lower, upper = change["new"]
                if lower < upper:
                    session.intervals.move(which, lower, upper)
                    draw()

            slider.observe(moved, "value")
            controls.append(slider)
        buttons = []
        for text, act in (
            ("⟲", lambda: self.turn(-15)),
            ("⟳", lambda: self.turn(15)),
            ("+", lambda: self.zoom(1.25)),
            ("−", lambda: self.zoom(0.8)),
            ("reset", self.view),
        ):
            button = widgets.Button(description=text, layout=widgets.Layout(width="4em"))
            button.on_click(lambda _, act=act: (act(), draw()))
            buttons.append(button)
        return widgets.VBox([picture, widgets.HBox(buttons), *controls])
