"""The examples run, and what they draw is there."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parent.parent / "examples"


def run(name, *arguments, **environment):
    command = [sys.executable, EXAMPLES / name, *map(str, arguments)]
    done = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout


def needs(*modules):
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    return pytest.mark.skipif(bool(missing), reason=f"not installed: {', '.join(missing)}")


@needs("matplotlib")
def test_the_tutorial_draws_its_three_jobs(tmp_path):
    said = run("tutorial.py", tmp_path)
    for name in ("terrain.png", "thickness.png", "inside.png"):
        picture = (tmp_path / name).read_bytes()
        assert picture.startswith(b"\x89PNG") and len(picture) > 10_000
    assert "of 150000 pulses return" in said and "walls are" in said and "points are on the surface" in said


@needs("ray")
def test_actors_of_ray_answer_as_one_process():
    assert "by 2 processes as by one" in run("ray_scene.py")


def program():
    """The command trisect, where it has been built."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", EXAMPLES / "../../../target"))
    built = [target / profile / "trisect" for profile in ("release", "debug")]
    return next((str(path.resolve()) for path in built if path.exists()), None)


@needs("distributed")
@pytest.mark.skipif(program() is None, reason="the command trisect is not built")
def test_a_survey_on_dask_is_that_of_one_run(tmp_path):
    survey = ["stress", "--methods", "exact", "--exact", "200000"]
    records = []
    for count in (1, 3):
        run("shards_dask.py", tmp_path / f"{count}.jsonl", count, *survey, TRISECT=program())
        records.append((tmp_path / f"{count}.jsonl").read_text().splitlines())
    # The first line says when it was taken.
    assert len(records[0]) > 3 and records[0][1:] == records[1][1:]
