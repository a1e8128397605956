"""The JSON schema that editors read: as committed, against the catalogue, and against bad files."""

import json
import tomllib
from importlib import resources

import pytest

from trundle.errors import RobotError
from trundle.robot import CATALOG, json_schema, load, robot_from_dict, to_toml

FIXED = {"name": "a", "kind": "fixed", "x": 0.0, "y": 0.1, "radius": 0.05}
CASTER = {"name": "c", "kind": "caster", "x": 0.0, "y": 0.0, "radius": 0.02}
ENCODER = {"ticks_per_motor_turn": 64}


def robot(*wheels, **more):
    return {"name": "made", "wheel": list(wheels)} | more


GOOD = {
    "whole numbers": robot(FIXED | {"x": 0, "radius": 1}),
    "swedish": robot(FIXED | {"kind": "swedish", "roller_deg": 45}),
    "encoder": robot(FIXED | {"encoder": ENCODER | {"gear": 43.7}}),
    "body": robot(FIXED, body={"length": 0.5, "width": 0.4}),
    "masses": robot(FIXED | {"mass": 0.2}, body={"mass": 5, "inertia": 0.1, "com": [0.1, 0]}),
    "motor": robot(FIXED | {"motor": {"torque_constant": 0.02, "resistance": 1.5}}),
}

# One mistake each. Faults that lie between two keys, such as equal names, no schema can tell.
BAD = {
    "no wheel": robot(),
    "wheels missing": {"name": "made"},
    "unknown key of the robot": robot(FIXED, mass=3),
    "unknown key of the wheel": robot(FIXED | {"diameter": 0.1}),
    "key of another kind": robot(FIXED | {"roller_deg": 45}),
    "encoder on a caster": robot(CASTER | {"encoder": ENCODER}),
    "mass of the body negative": robot(FIXED, body={"mass": -1}),
    "inertia of the body zero": robot(FIXED, body={"inertia": 0}),
    "com of one number": robot(FIXED, body={"com": [0.1]}),
    "com of texts": robot(FIXED, body={"com": ["a", "b"]}),
    "mass of a wheel negative": robot(FIXED | {"mass": -0.1}),
    "motor without resistance": robot(FIXED | {"motor": {"torque_constant": 0.02}}),
    "unknown kind": robot(FIXED | {"kind": "square"}),
    "kind missing": robot({key: value for key, value in FIXED.items() if key != "kind"}),
    "radius missing": robot({key: value for key, value in FIXED.items() if key != "radius"}),
    "radius zero": robot(FIXED | {"radius": 0}),
    "radius negative": robot(FIXED | {"radius": -0.05}),
    "text for a number": robot(FIXED | {"radius": "0.05"}),
    "number for a text": robot(FIXED | {"name": 1}),
    "number for true or false": robot(FIXED | {"reversed": 1}),
    "true for a number": robot(FIXED | {"x": True}),
    "mecanum without roller": robot(FIXED | {"kind": "mecanum"}),
    "encoder without ticks": robot(FIXED | {"encoder": {"gear": 2}}),
    "body without width": robot(FIXED, body={"length": 0.5}),
    "radians in a file": robot(FIXED | {"heading": 1.57}),
}


@pytest.fixture(scope="module")
def faults():
    """Return the faults that a validator of JSON schemas finds in a parsed file."""
    jsonschema = pytest.importorskip("jsonschema", reason="jsonschema is not installed")
    schema = json_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    return lambda data: [fault.message for fault in validator.iter_errors(data)]


def meaning(node):
    """Return a schema without what differs between releases of pydantic and says nothing."""
    if isinstance(node, list):
        return [meaning(item) for item in node]
    if not isinstance(node, dict):
        return node
    made = {key: meaning(item) for key, item in node.items()}
    if isinstance(made.get("title"), str):
        del made["title"]
    if "const" in made:
        made.pop("enum", None)
    if len(made.get("allOf", ())) == 1:
        made |= made.pop("allOf")[0]
    return made


def test_the_committed_schema_is_the_one_that_the_code_makes():
    committed = resources.files("trundle.robot").joinpath("robot.schema.json")
    text = committed.read_text(encoding="utf-8")
    assert text == json.dumps(json.loads(text), indent=2) + "\n"
    assert meaning(json.loads(text)) == meaning(json_schema()), (
        "write json.dumps(trundle.robot.json_schema(), indent=2) and a newline to "
        "src/trundle/robot/robot.schema.json"
    )


def test_every_key_is_described():
    for name, definition in json_schema()["$defs"].items():
        for key, item in definition["properties"].items():
            assert key in ("name", "kind") or item.get("description"), f"{name}: {key}"


@pytest.mark.parametrize("name", CATALOG)
def test_catalogue_robots_meet_the_schema(name, faults):
    assert faults(tomllib.loads(to_toml(load(name)))) == []


@pytest.mark.parametrize("case", GOOD)
def test_good_files_meet_the_schema_and_load(case, faults):
    robot_from_dict(GOOD[case])
    assert faults(GOOD[case]) == []


@pytest.mark.parametrize("case", BAD)
def test_bad_files_do_not_load(case):
    with pytest.raises(RobotError):
        robot_from_dict(BAD[case])


@pytest.mark.parametrize("case", BAD)
def test_bad_files_miss_the_schema(case, faults):
    assert faults(BAD[case])
