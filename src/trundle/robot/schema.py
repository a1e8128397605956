"""The pydantic models of robot files, made from the same dataclasses that build robots."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Union

from pydantic import BaseModel, ConfigDict, Field, create_model

from trundle.robot.quantity import key
from trundle.robot.robot import Body
from trundle.robot.wheels import WHEEL_KINDS, MecanumWheel, OmniWheel, Wheel

# "swedish" is another name for omni and mecanum wheels; its roller angle tells which.
SWEDISH = "swedish"
CLASSES: Mapping[str, type[Wheel]] = {cls.kind: cls for cls in WHEEL_KINDS} | {
    SWEDISH: MecanumWheel
}

_CONFIG = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


def wheel_class(kind: str, values: Mapping[str, Any]) -> type[Wheel]:
    """Return the class that a wheel of a kind belongs to."""
    if kind == SWEDISH and values.get("roller_deg") == 0:
        return OmniWheel
    return CLASSES[kind]


def fields_by_key(cls: type) -> dict[str, dataclasses.Field[Any]]:
    """Return a dataclass's fields by the names that they have in files."""
    return {key(item): item for item in dataclasses.fields(cls)}


def _annotation(item: dataclasses.Field[Any]) -> Any:
    if "quantity" in item.metadata:
        return float
    if item.metadata.get("flag"):
        return bool
    if "point" in item.metadata:
        return Annotated[list[float], Field(min_length=2, max_length=2)]
    if "part" in item.metadata:
        return _model(item.metadata["part"], item.metadata["part"].__name__)
    return str


def _entry(item: dataclasses.Field[Any]) -> tuple[Any, Any]:
    required = item.default is dataclasses.MISSING
    rule = item.metadata.get("quantity") or item.metadata.get("point")
    told = item.metadata.get("help", "")
    if rule is not None and rule.unit:
        told += f" [{'deg' + rule.unit[3:] if item.metadata.get('degrees') else rule.unit}]"
    return _annotation(item), Field(
        default=... if required else item.default,
        gt=0 if rule is not None and rule.positive else None,
        ge=0 if rule is not None and rule.nonnegative else None,
        description=told or None,
    )


def _model(cls: type, name: str, **extra: Any) -> type[BaseModel]:
    entries: dict[str, Any] = {key(item): _entry(item) for item in dataclasses.fields(cls)}
    model: type[BaseModel] = create_model(name, __config__=_CONFIG, **extra, **entries)
    return model


def wheel_model(kind: str) -> type[BaseModel]:
    """Return the model of one ``[[wheel]]`` table of a kind."""
    literal: Any = Literal.__getitem__(kind)
    return _model(CLASSES[kind], f"{kind.capitalize()}Wheel", kind=(literal, ...))


def body_model() -> type[BaseModel]:
    """Return the model of the ``[body]`` table."""
    model = _model(Body, "Body")
    outline: Any = {"length": ["width"], "width": ["length"]}
    model.model_config["json_schema_extra"] = {"dependentRequired": outline}
    return model


def robot_model() -> type[BaseModel]:
    """Return the model of a whole robot file."""
    kinds: Any = Union.__getitem__(tuple(wheel_model(kind) for kind in CLASSES))
    wheel = Annotated[kinds, Field(discriminator="kind")]
    entries: dict[str, Any] = {
        "name": (str, Field(default=None, description="name of the robot (default: the file's)")),
        "body": (
            body_model(),
            Field(default=None, description="outline and mass of the body"),
        ),
        "wheel": (
            list[wheel],
            Field(min_length=1, description="the wheels, in order"),
        ),
    }
    model: type[BaseModel] = create_model("Robot", __config__=_CONFIG, **entries)
    return model


def json_schema() -> dict[str, Any]:
    """Return the JSON schema with which editors complete and check robot files."""
    schema = robot_model().model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    _drop_null_defaults(schema)
    return schema


def _drop_null_defaults(node: Any) -> None:
    """Remove ``default: null``: TOML has no null, an optional key is simply left out."""
    if isinstance(node, dict):
        if "default" in node and node["default"] is None:
            del node["default"]
        for child in node.values():
            _drop_null_defaults(child)
    elif isinstance(node, list):
        for child in node:
            _drop_null_defaults(child)
