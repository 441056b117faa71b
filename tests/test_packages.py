"""What is packaged, and what packages say of the project: the same everywhere."""

from __future__ import annotations

import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import jinja2
import pytest
import yaml

import pcsmooth

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]

#: Names of packages that conda calls otherwise.
OF_CONDA = {"lazrs": "lazrs-python", "matplotlib": "matplotlib-base"}


def recipe() -> Any:
    """The recipe for conda, with the names that conda-build has for programs."""
    text = (ROOT / "conda" / "meta.yaml").read_text()
    return yaml.safe_load(jinja2.Template(text).render(PYTHON="python"))


def for_conda(requirement: str) -> set[str]:
    """A requirement and those of its extras, as conda would have them."""
    found = re.fullmatch(r"([\w-]+)(?:\[([\w,]+)\])?(>=[\d.]+)?", requirement)
    assert found is not None
    name, extras, bound = found.groups()
    others = {OF_CONDA.get(extra, extra) for extra in extras.split(",")} if extras else set()
    return {f"{OF_CONDA.get(name, name)} {bound or ''}".strip(), *others}


def workflow(name: str) -> Any:
    return yaml.safe_load((ROOT / ".github" / "workflows" / f"{name}.yml").read_text())


class TestConda:
    def test_it_is_the_same_version_and_command(self) -> None:
        assert recipe()["package"] == {"name": PROJECT["name"], "version": PROJECT["version"]}
        scripts = [f"{name} = {call}" for name, call in PROJECT["scripts"].items()]
        assert recipe()["build"]["entry_points"] == scripts

    def test_it_needs_the_same(self) -> None:
        needed = set().union(*map(for_conda, PROJECT["dependencies"]))
        assert set(recipe()["requirements"]["run"]) == {
            f"python {PROJECT['requires-python']}",
            *needed,
        }

    def test_it_is_constrained_by_the_extras(self) -> None:
        extras = PROJECT["optional-dependencies"]
        names = ("colors", "dask", "e57", "plot", "zst")
        wanted = {each for name in names for each in extras[name]}
        constrained = set(recipe()["requirements"]["run_constrained"])
        assert constrained == set().union(*map(for_conda, wanted))

    def test_it_is_built_by_the_same(self) -> None:
        needed = tomllib.loads((ROOT / "pyproject.toml").read_text())["build-system"]["requires"]
        built_with = recipe()["requirements"]["host"]
        assert set(built_with) - {"pip"} == {
            f"python {PROJECT['requires-python'].removeprefix('>=')}",
            *set().union(*map(for_conda, needed)),
        }

    def test_it_says_the_same(self) -> None:
        about = recipe()["about"]
        assert about["summary"] == PROJECT["description"]
        assert about["license"] == PROJECT["license"]
        assert [about["license_file"]] == PROJECT["license-files"]


def test_all_extras_are_in_all() -> None:
    extras = PROJECT["optional-dependencies"]
    (whole,) = extras["all"]
    of_users = set(extras) - {"all", "dev", "docs", "peers"}
    assert whole == f"pcsmooth[{','.join(sorted(of_users))}]"
    assert "pcsmooth[all]" in extras["dev"]


def test_all_extras_that_pages_name_are_there() -> None:
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    named = {
        extra
        for page in pages
        for extras in re.findall(r"pcsmooth\[([\w,]+)\]", page.read_text())
        for extra in extras.split(",")
    }
    assert "e57" in named
    assert named <= set(PROJECT["optional-dependencies"])


def test_all_versions_agree() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert PROJECT["version"] == pcsmooth.__version__ == citation["version"]
    assert PROJECT["license"] == citation["license"]


def test_every_python_that_is_named_is_tested() -> None:
    lowest = PROJECT["requires-python"].removeprefix(">=")
    named = [
        line.rpartition(" ")[2] for line in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", line)
    ]
    assert named == workflow("test")["jobs"]["test"]["strategy"]["matrix"]["python"]
    assert named[0] == lowest
    assert recipe()["requirements"]["run"][0] == f"python >={lowest}"
    image = (ROOT / "Dockerfile").read_text()
    assert set(re.findall(r"^FROM python:(\S+)-slim", image, re.MULTILINE)) <= set(named)


def test_the_image_keeps_kernels_where_they_are_looked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from pcsmooth.kernels.cache import installed_folder

    image = (ROOT / "Dockerfile").read_text()
    prefix = re.search(r"-m venv --without-pip (\S+)", image)
    cache = re.search(r"NUMBA_CACHE_DIR=(\S+)", image)
    assert prefix is not None
    assert cache is not None
    monkeypatch.setattr(sys, "prefix", prefix[1])
    assert installed_folder("grid").parent == Path(cache[1], "pcsmooth")
    levels = set(re.findall(r"NUMBA_CPU_NAME=(\S+)", image))
    assert levels == {"x86-64-v3"}
    assert len(re.findall(r"NUMBA_CPU_NAME=", image)) == 2


def test_the_image_is_made_of_all_that_a_wheel_needs() -> None:
    sent = re.findall(r"^!(.+)$", (ROOT / ".dockerignore").read_text(), re.MULTILINE)
    assert set(sent) == {"src", "pyproject.toml", PROJECT["readme"], *PROJECT["license-files"]}


def test_publishing_needs_no_secret() -> None:
    text = (ROOT / ".github" / "workflows" / "publish.yml").read_text()
    assert "secrets." not in text
    jobs = workflow("publish")["jobs"]
    assert jobs["publish"]["permissions"] == {"id-token": "write"}
    assert "permissions" not in jobs["build"]


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with an sdist, and a wheel made of it."""
    folder = tmp_path_factory.mktemp("built")
    building: list[str | Path] = [
        sys.executable,
        "-m",
        "build",
        "--no-isolation",
        "--outdir",
        folder,
        ROOT,
    ]
    subprocess.run(building, check=True, capture_output=True)
    return folder


def files_in(*folders: str) -> set[str]:
    """Files of the project, by their paths in it."""
    return {
        path.relative_to(ROOT).as_posix()
        for folder in folders
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts and "egg-info" not in str(path)
    }


@pytest.mark.slow
def test_the_sdist_holds_what_its_tests_need(built: Path) -> None:
    (path,) = built.glob("*.tar.gz")
    with tarfile.open(path) as sdist:
        held = {member.name.partition("/")[2] for member in sdist if member.isfile()}
    assert files_in("src", "tests", "data", "conda", ".ci", ".github") <= held
    others = {path.name for path in ROOT.iterdir() if path.is_file()} - {".git"}
    assert others <= held
    assert not any(name.endswith((".pyc", ".nbc", ".nbi")) for name in held)


@pytest.mark.slow
def test_the_wheel_holds_the_package_and_nothing_else(built: Path) -> None:
    (path,) = built.glob("*.whl")
    assert path.name.endswith("-py3-none-any.whl")
    with zipfile.ZipFile(path) as wheel:
        held = {name for name in wheel.namelist() if ".dist-info/" not in name}
        (licence,) = [name for name in wheel.namelist() if name.endswith("/LICENSE")]
        assert wheel.read(licence) == (ROOT / "LICENSE").read_bytes()
    assert held == {name.removeprefix("src/") for name in files_in("src")}
    assert {"pcsmooth/bodies/presets.toml", "pcsmooth/py.typed"} <= held
    assert {"pcsmooth/plots/viewer/page.html", "pcsmooth/plots/viewer/main.js"} <= held
