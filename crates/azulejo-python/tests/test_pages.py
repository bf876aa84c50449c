"""What notebooks and browsers show: well-formed, shut in, and of limited size."""

from __future__ import annotations

import json
import sys
import tempfile
import webbrowser
from html.parser import HTMLParser
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from conftest import faces_of_cube

import pyazulejo as az

VOID = {"input", "link", "meta", "path", "br", "img"}
HOSTILE = '</iframe><script>alert("1")</script><!-- & \'"'


class Elements(HTMLParser):
    """All elements with their texts; tags that do not fit each other fail."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.texts: list[str] = []
        self.feed(text)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, {name: value or "" for name, value in attrs}))
        self.texts.append("")
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.texts:
            self.texts[-1] += data

    def named(self, name: str) -> list[tuple[dict[str, str], str]]:
        pairs = zip(self.elements, self.texts, strict=True)
        return [(attributes, text) for (tag, attributes), text in pairs if tag == name]


def frame(html: str) -> dict[str, str]:
    """The attributes of the only frame, beside which nothing runs."""
    outer = Elements(html)
    assert not outer.named("script")
    ((attributes, _),) = outer.named("iframe")
    return attributes


def head(page: str) -> dict:
    """The head of a page's data."""
    scripts = Elements(page).named("script")
    (text,) = [text for attributes, text in scripts if attributes.get("id") == "head"]
    return json.loads(text)


def lamp_room() -> az.Scene:
    materials = {"lid": az.Material(diffuse=0.5, emission=1), "*": az.Material(diffuse=0.5)}
    return az.Scene(faces_of_cube(), materials)


def grid(n: int, z: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """A square of n × n faces."""
    x, y = np.meshgrid(np.arange(n + 1), np.arange(n + 1))
    vertices = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, z)]).astype(float)
    first = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    return vertices, np.column_stack([first, first + 1, first + n + 2, first + n + 1])


def test_a_frame_is_shut_in(cube: az.Scene) -> None:
    attributes = frame(cube._repr_html_())
    # Without allow-same-origin, scripts reach neither the notebook nor what it stores.
    assert attributes["sandbox"] == "allow-scripts"
    assert "height: 480px" in attributes["style"] and attributes["title"] == repr(cube)
    page = attributes["srcdoc"]
    assert page.startswith("<!doctype html>") and "default-src 'none'" in page
    assert "http://" not in page and "https://" not in page


def test_names_stay_texts() -> None:
    square = faces_of_cube()["floor"]
    scene = az.Scene({HOSTILE: square})
    page = frame(scene._repr_html_())["srcdoc"]
    assert [mesh["name"] for mesh in head(page)["meshes"]] == [HOSTILE]
    assert "alert(" not in "".join(
        text for attributes, text in Elements(page).named("script") if "id" not in attributes
    )
    table = scene._summary()
    assert not Elements(table).named("script") and Elements(table).named("th")[-1][1] == HOSTILE


def test_scenes_show_the_light_that_they_have(cube: az.Scene) -> None:
    plain = head(frame(cube._repr_html_())["srcdoc"])
    assert plain["lightmaps"] == [] and not any(mesh["lit"] for mesh in plain["meshes"])
    assert plain["note"] == "The scene has no light on vertices: it is shown plain."
    scene = az.solve_light(lamp_room(), patches=50)
    lit = head(frame(scene._repr_html_())["srcdoc"])
    assert len(lit["lightmaps"]) == 1 and all(mesh["lit"] for mesh in lit["meshes"])
    assert "that of vertices, interpolated between them. It is known to" in lit["note"]
    # The peak is the largest channel; that of errors is a luminance, like them grey here.
    most = max(scene.mesh(name).irradiance.max() for name in scene.names)
    worst = max(scene.mesh(name).std_error.max() for name in scene.names)
    # Of each triangle, a fourth texel continues its light.
    assert most * (1 - 1e-6) <= lit["lightmaps"][0]["peak"] < 2 * most
    assert worst * (1 - 1e-5) <= lit["lightmaps"][0]["errorPeak"] < 2 * worst


def test_a_lightmap_is_shown(tmp_path: Path) -> None:
    lightmap = az.bake(lamp_room(), size=64, error=0.1)
    shown = head(frame(lightmap._repr_html_())["srcdoc"])
    assert [(m["width"], m["height"]) for m in shown["lightmaps"]] == [(64, 64)]
    assert shown["title"] == repr(lightmap) and "known to" in shown["note"]
    assert Elements(lightmap._summary()).named("td")[0][1] == "64"
    # A scene that is read with a lightmap is solved, but has nothing on its vertices.
    lightmap.save(tmp_path / "room.glb")
    again = az.load(tmp_path / "room.glb")
    assert again.is_solved and "shown plain" in head(frame(again._repr_html_())["srcdoc"])["note"]


def test_large_scenes_are_described(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pages of very many triangles are not written; the size of others is known when they are."""
    regular = az.Scene({"field": grid(300)})
    page = frame(regular._repr_html_())["srcdoc"]
    monkeypatch.setattr(az._page, "_LIMIT", "1M")
    # It would be small enough, but that is found out too late.
    assert len(page) < 2**20
    html = regular._repr_html_()
    assert len(html) < 2000 and not Elements(html).named("iframe")
    assert "about 1.0 MiB or more, and the limit is 1.0 MiB" in html
    assert "<th>field</th><td>9e+04</td><td>9e+04</td>" in html
    vertices, faces = grid(150)
    rough = np.random.default_rng(0).normal(size=vertices.shape) + vertices
    html = az.Scene({"rough": (rough, faces)})._repr_html_()
    assert "its page would take" in html and not Elements(html).named("iframe")


def test_many_objects_are_counted() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    scene = az.Scene({f"{k}": (square + [0, 0, k], [[0, 1, 2, 3]]) for k in range(25)})
    assert "and 5 more objects" in scene._summary() and "<th>20</th>" not in scene._summary()


def test_a_script_opens_a_browser(
    cube: az.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    path = az.show(cube)
    assert path is not None and Path(path).parent == tmp_path and path.endswith(".html")
    assert opened == [Path(path).as_uri()]
    assert head(Path(path).read_text(encoding="utf-8"))["title"] == repr(cube)


@pytest.fixture
def displayed(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, str]]:
    """What a notebook displays, without IPython."""
    seen: list[dict[str, str]] = []
    ipython, display = ModuleType("IPython"), ModuleType("IPython.display")
    ipython.get_ipython = lambda: SimpleNamespace(kernel=object())  # type: ignore[attr-defined]
    display.display = lambda data, raw: seen.append(data)  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    return seen


def test_a_notebook_displays_a_frame(cube: az.Scene, displayed: list[dict[str, str]]) -> None:
    assert az.show(cube, height=300) is None
    assert displayed[0]["text/plain"] == repr(cube)
    assert "height: 300px" in frame(displayed[0]["text/html"])["style"]
    large = az.Scene({"field": grid(400)})
    az.show(large, limit="1M")
    assert "and the limit is 1.0 MiB" in displayed[1]["text/html"]
    az.show(large, limit=None)
    assert frame(displayed[2]["text/html"])


def test_what_is_refused(cube: az.Scene, refuses) -> None:
    refuses("thing is a str, expected a Scene or a Lightmap", lambda: az.show("room"), TypeError)
    refuses("height is 0, expected 50 to 10000", lambda: az.show(cube, height=0))
    refuses('limit is "much"', lambda: az.show(cube, limit="much"))
