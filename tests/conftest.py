"""Settings that all tests share."""

import json

import pytest
from hypothesis import settings

from trundle.cli.app import run

# The same examples at every run: a failure on one machine is a failure on all.
settings.register_profile("repeatable", derandomize=True, deadline=None, database=None)
settings.load_profile("repeatable")


@pytest.fixture
def trundle(capsys, monkeypatch):
    """Run the command; return exit code, stdout and stderr."""
    monkeypatch.setenv("COLUMNS", "200")

    def call(*args):
        code = run([str(arg) for arg in args])
        told = capsys.readouterr()
        return code, told.out, told.err

    return call


@pytest.fixture
def ask(trundle):
    """Run the command with --json and return the one value on stdout."""

    def call(*args):
        code, out, _ = trundle(*args, "--json")
        assert code == 0
        return json.loads(out)

    return call
