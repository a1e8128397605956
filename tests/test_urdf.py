"""URDF: what is written comes back, moves as it says, and a file from elsewhere is read with care.

The oracle is forward kinematics of the text by scipy's rotations, apart from trundle's reader.
"""

import dataclasses
import math
import string
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import trundle
from catalogue import (
    ROBOTS,
    all_reversed,
    each_robot,
    feasible_twists,
    kinematics,
    steering_for,
)
from test_ros2_controllers import EQUATIONS
from test_ros2_controllers import settings as controller_settings
from trundle.errors import FileError, GuessWarning, RobotError, TrundleError
from trundle.exchange import joint_names, urdf
from trundle.robot import (
    WHEEL_KINDS,
    BallWheel,
    Body,
    CasterWheel,
    Encoder,
    FixedWheel,
    MecanumWheel,
    Motor,
    OmniWheel,
    Robot,
    SteeredWheel,
    SwedishWheel,
    Wheel,
)
from trundle.robot.urdf import MOST_BYTES, read_urdf

# Sums of a few products of numbers near 1, through sines and cosines.
AGREE = 1e-12
# Angles such as 1.5708 in files stand for a quarter turn: they are off by less than this [rad].
WRITTEN = 1e-5
# Contacts at some m/s, from the inverse's least squares: what rounding leaves of them [m/s].
HALTS = 1e-9
# A wheel speed [rad/s] above this tells its sign.
MOVES = 1e-3


def read(text: str) -> Robot:
    """Return the robot of a URDF that leaves nothing open."""
    reading = read_urdf(text.encode())
    assert reading.unknown == ()
    return reading.robot


# ---- what is written comes back -------------------------------------------------------------


@each_robot
def test_a_robot_comes_back_equal(robot: Robot) -> None:
    assert read(urdf(robot)) == robot


def test_all_that_a_wheel_can_have_comes_back(tmp_path) -> None:
    motor = Motor(torque_constant=0.02, resistance=1.5, gear=43.7, max_voltage=12.0)
    drive = {
        "radius": 0.1 / 3, "reversed": True, "measured": False, "max_speed": 17.3,
        "max_acceleration": 0.7, "max_torque": 1.1, "motor": motor, "mass": 0.3,
        "encoder": Encoder(ticks_per_motor_turn=64, gear=43.7), "spin_inertia": 0.01,
        "viscous_friction": 0.1, "coulomb_friction": 0.2, "friction": 0.9, "yaw_inertia": 1e-4,
    }  # fmt: skip
    robot = Robot(
        name="a <&> \"b\" 'c' ü\n\t-->",
        wheels=(
            FixedWheel(name="*", x=0.1, y=1 / 3, heading=7.0, skid=True, track_factor=1.5, **drive),
            SteeredWheel(
                name="a b", x=-1 / 7, y=0.2, heading=-4.0, steering_group="g & h",
                steering_ratio=-1.5, steering_min=-0.7, steering_max=0.3, steering_rate=2, **drive,
            ),
            SteeredWheel(
                name="a_b", x=-0.2, y=0.2, radius=0.1, steering_group="g & h", steering_max=3.0,
                max_speed=2e9,
            ),
            SteeredWheel(name="slow", x=-0.2, y=0.3, radius=0.1, steering_rate=0.1, driven=False),
            OmniWheel(name="int", x=0.3, y=0.0, roller=0.1, heading=4.0, **drive),
            MecanumWheel(name="none", x=0.4, y=0.0, roller=-3.0, heading=-9.5, **drive),
            CasterWheel(name="1", x=-0.3, y=0.1, radius=0.05, trail=0.1 / 7, heading=2.0, mass=1.0),
            CasterWheel(name="2", x=-0.3, y=-0.1, radius=0.05),
            BallWheel(name="ball", x=0.5, y=0.0, yaw_inertia=0.1),
            BallWheel(name="large", x=0.5, y=0.1, radius=0.07, mass=0.1),
        ),
        body=Body(length=1.3, width=0.7, x=0.1, y=-0.2, mass=9.0, com=(0.01, 0.02)),
    )  # fmt: skip
    assert read(urdf(robot)) == robot
    path = tmp_path / "robot.urdf"
    path.write_text(urdf(robot), encoding="utf-8")
    assert trundle.load(path) == robot


LETTERS = st.characters(
    codec="utf-8", exclude_categories=["Cc", "Cs"], exclude_characters="\ufffe\uffff"
)
TEXTS = st.text(LETTERS | st.sampled_from("\t\n\r ab<&\"'"), min_size=1, max_size=8).filter(
    str.strip
)
SIZES = st.floats(1e-6, 1e6)
PLACES = st.floats(-1e6, 1e6)
ANGLES = st.floats(-20.0, 20.0)


def _values(item: dataclasses.Field) -> st.SearchStrategy:
    kind = item.metadata
    if "flag" in kind:
        found = st.booleans()
    elif "text" in kind:
        found = TEXTS
    elif "part" in kind:
        found = st.builds(kind["part"], **_fields(kind["part"]))
    elif "point" in kind:
        found = st.tuples(PLACES, PLACES)
    elif item.name == "track_factor":
        found = st.just(1.0)
    elif kind["degrees"] and not kind["quantity"].positive:
        found = ANGLES
    elif kind["quantity"].positive or kind["quantity"].nonnegative:
        found = SIZES
    else:
        found = PLACES
    return found if item.default is dataclasses.MISSING else st.just(item.default) | found


def _fields(cls: type) -> dict[str, st.SearchStrategy]:
    return {item.name: _values(item) for item in dataclasses.fields(cls)}


@st.composite
def wheels(draw: st.DrawFn) -> Wheel:
    cls = draw(st.sampled_from(WHEEL_KINDS))
    values = {name: draw(each) for name, each in _fields(cls).items()}
    if cls in (CasterWheel, BallWheel):
        values["driven"] = False
    if issubclass(cls, SwedishWheel) and abs(math.cos(values["roller"])) < 1e-3:
        values["roller"] = 0.5
    if cls is SteeredWheel:
        if values["steering_group"] is None:
            values["steering_ratio"] = 1.0
        elif values["steering_ratio"] == 0:
            values["steering_ratio"] = -1.0
        ends = values["steering_min"], values["steering_max"]
        if None not in ends:
            values["steering_min"], values["steering_max"] = sorted(ends)
    return cls(**values)


@st.composite
def robots(draw: st.DrawFn) -> Robot:
    made = draw(st.lists(wheels(), min_size=1, max_size=5, unique_by=lambda wheel: wheel.name))
    made = [
        dataclasses.replace(each, steering_min=None, steering_max=None)
        if isinstance(each, SteeredWheel) and each.steering_group is not None
        else each
        for each in made
    ]
    size = draw(st.none() | SIZES)
    values = _fields(Body) | {"length": st.just(size), "width": st.just(size)}
    body = draw(st.none() | st.builds(Body, **values))
    return Robot(name=draw(TEXTS), wheels=tuple(made), body=body)


@given(robots())
@settings(max_examples=150)
def test_a_random_mixture_comes_back_equal(robot: Robot) -> None:
    assert read(urdf(robot)) == robot


def test_a_name_that_xml_cannot_hold_is_refused() -> None:
    robot = Robot(name="bell", wheels=(FixedWheel(name="a\x07", x=0.0, y=0.0, radius=0.1),))
    with pytest.raises(TrundleError, match="XML cannot hold"):
        urdf(robot)


def test_numbers_too_large_for_a_file_are_refused() -> None:
    body = Body(length=1e200, width=1e200, mass=1.0)
    with pytest.raises(TrundleError, match="too large"):
        urdf(dataclasses.replace(ROBOTS["omni3"], body=body))


# ---- the text moves as trundle says ---------------------------------------------------------


class Frames:
    """Forward kinematics of a URDF's text."""

    def __init__(self, text: str) -> None:
        self.root = ET.fromstring(text.encode())
        self.joints = {each.get("name"): each for each in self.root.findall("joint")}
        self.above = {each.find("child").get("link"): each for each in self.joints.values()}

    def vector(self, element: ET.Element | None, key: str, default: str) -> np.ndarray:
        text = default if element is None else element.get(key, default)
        return np.array([float(part) for part in text.split()])

    def link(self, name: str, angles: dict[str, float]) -> tuple[Rotation, np.ndarray]:
        """Return the frame of a link in the root link, at joint angles."""
        if name not in self.above:
            return Rotation.identity(), np.zeros(3)
        joint = self.above[name]
        origin = joint.find("origin")
        R, p = self.link(joint.find("parent").get("link"), angles)
        p = p + R.apply(self.vector(origin, "xyz", "0 0 0"))
        R = R * Rotation.from_euler("xyz", self.vector(origin, "rpy", "0 0 0"))  # about fixed axes
        axis = self.vector(joint.find("axis"), "xyz", "1 0 0")
        return R * Rotation.from_rotvec(angles.get(joint.get("name"), 0.0) * axis), p

    def axle(self, joint: str, angles: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
        """Return a joint's axis and the origin of its frame in the root link."""
        element = self.joints[joint]
        R, p = self.link(element.find("child").get("link"), angles)
        return R.apply(self.vector(element.find("axis"), "xyz", "1 0 0")), p

    def radius(self, joint: str) -> float:
        child = self.joints[joint].find("child").get("link")
        link = next(each for each in self.root.findall("link") if each.get("name") == child)
        return float(link.find("collision/geometry/cylinder").get("radius"))


def every_second_reversed(robot: Robot) -> Robot:
    wheels = [
        dataclasses.replace(w, reversed=not w.reversed) if hasattr(w, "reversed") and i % 2 else w
        for i, w in enumerate(robot.wheels)
    ]
    return dataclasses.replace(robot, wheels=tuple(wheels))


SIGNS = [lambda robot: robot, all_reversed, every_second_reversed]


@each_robot
@pytest.mark.parametrize("change", SIGNS, ids=["as it is", "all turned", "some turned"])
def test_a_joint_has_the_sign_of_its_motor(robot: Robot, change) -> None:
    """At the motors' speeds the contact points do not slip: velocity of the hub + omega x r."""
    twist = feasible_twists(robot, (), seed=3)
    if any(getattr(wheel, "skid", False) for wheel in robot.wheels):
        twist = np.array([0.7, 0.0, 0.0])  # turning, they slip
    steering = steering_for(robot, twist)
    robot = change(robot)
    frames, names = Frames(urdf(robot)), joint_names(robot)
    speeds = kinematics(robot).inverse(twist, steering=steering).wheel_speeds
    angles = {names[w.name].steering: a for w, a in zip(robot.steered, steering, strict=True)}
    for wheel, speed in zip(robot.driven, speeds, strict=True):
        joint = names[wheel.name].wheel
        axis, hub = frames.axle(joint, angles)
        down = np.array([0.0, 0.0, -frames.radius(joint)])
        hub_velocity = np.array([twist[0] - twist[2] * hub[1], twist[1] + twist[2] * hub[0], 0.0])
        slip = hub_velocity + np.cross(speed * axis, down)
        drive = np.cross(axis, [0.0, 0.0, 1.0])
        if isinstance(wheel, SwedishWheel):  # it slips along its roller's rim, not along its axis
            held = Rotation.from_rotvec([0.0, 0.0, wheel.roller]).apply(drive)
            slip = np.array([held @ slip])
        assert abs(speed) > MOVES
        assert np.linalg.norm(slip) == pytest.approx(0.0, abs=HALTS)


@pytest.mark.parametrize(("turned", "sign"), [(False, 1.0), (True, -1.0)])
def test_a_positive_turn_drives_ahead_and_back_where_it_is_reversed(turned, sign) -> None:
    wheel = FixedWheel(name="a", x=0.3, y=0.4, radius=0.1, reversed=turned)
    axis, hub = Frames(urdf(Robot(name="one", wheels=(wheel,)))).axle("a_joint", {})
    assert axis.tolist() == [0.0, sign, 0.0]
    assert hub.tolist() == [0.3, 0.4, 0.1]
    rim = np.cross(axis, [0.0, 0.0, -0.1])
    assert rim.tolist() == [-0.1 * sign, 0.0, 0.0]  # ahead: the rim pushes the ground back


def test_a_caster_trails_behind_its_pivot() -> None:
    caster = CasterWheel(name="c", x=-0.3, y=0.1, radius=0.04, trail=0.02, heading=math.pi / 2)
    frames = Frames(urdf(Robot(name="one", wheels=(caster,))))
    _, hub = frames.axle("c_joint", {})
    assert hub == pytest.approx([-0.3, 0.08, 0.04], abs=AGREE)  # it heads along +y
    _, hub = frames.axle("c_joint", {"c_steering_joint": math.pi / 2})
    assert hub == pytest.approx([-0.28, 0.1, 0.04], abs=AGREE)


def test_linked_steering_is_a_mimic() -> None:
    root = ET.fromstring(urdf(ROBOTS["curved"]).encode())
    mimics = {each.get("name"): each.find("mimic") for each in root.findall("joint")}
    assert mimics["front_steering_joint"] is None
    assert mimics["rear_steering_joint"].attrib == {
        "joint": "front_steering_joint", "multiplier": "-0.5", "offset": "0.0",
    }  # fmt: skip


HEAVY = ROBOTS["mixed"].with_wheels(mass=0.4, spin_inertia=0.5, yaw_inertia=0.001)


@pytest.mark.parametrize("robot", [*ROBOTS.values(), HEAVY], ids=lambda robot: robot.name)
def test_simulators_take_the_masses(robot: Robot) -> None:
    """Every moving link has a mass, and inertias that a solid can have; together the robot's."""
    root = ET.fromstring(urdf(robot).encode())
    if robot.body is None:
        assert root.findall("link/inertial") == []
        return
    moved = {
        each.find("child").get("link")
        for each in root.findall("joint")
        if each.get("type") != "fixed"
    }
    total = 0.0
    for link in root.findall("link"):
        part = link.find("inertial")
        if part is None:
            assert link.get("name") not in moved
            continue
        total += float(part.find("mass").get("value"))
        a, b, c = sorted(float(part.find("inertia").get(key)) for key in ("ixx", "iyy", "izz"))
        assert 0 < a <= b <= c <= a + b
    assert total == pytest.approx(robot.body.mass + sum(w.mass for w in robot.wheels))


def test_the_body_keeps_its_inertia_and_centre() -> None:
    body = Body(length=0.8, width=0.4, x=0.1, mass=20.0, inertia=1.7, com=(0.03, -0.02))
    robot = dataclasses.replace(HEAVY, body=body)
    part = ET.fromstring(urdf(robot).encode()).find("link[@name='base_link']/inertial")
    assert float(part.find("mass").get("value")) == 20.0
    assert float(part.find("inertia").get("izz")) == 1.7
    assert part.find("origin").get("xyz").split()[:2] == ["0.03", "-0.02"]


# ---- the controllers of ROS 2 move it -------------------------------------------------------

ONE_REVERSED = dataclasses.replace(
    ROBOTS["differential"],
    name="one_reversed",
    wheels=tuple(
        dataclasses.replace(wheel, reversed=True) if wheel.name == "right" else wheel
        for wheel in ROBOTS["differential"].wheels
    ),
)


@pytest.mark.parametrize(
    ("robot", "twist"),
    [
        (ONE_REVERSED, (0.8, 0.0, 0.0)), (ONE_REVERSED, (0.0, 0.0, 1.3)),
        (ONE_REVERSED, (-0.4, 0.0, 0.9)), (ROBOTS["omni4"], (0.8, 0.0, 0.0)),
        (ROBOTS["omni4"], (0.0, -0.6, 0.0)), (ROBOTS["omni4"], (0.3, 0.7, -1.1)),
        (ROBOTS["mecanum"], (0.3, 0.7, -1.1)), (every_second_reversed(ROBOTS["skid_steer"]),
        (0.7, 0.0, 0.0)),
    ],
)  # fmt: skip
def test_what_the_controller_commands_moves_the_urdf(robot: Robot, twist) -> None:
    """The YAML's joints are the URDF's, and their speeds hold the contacts where the twist is."""
    controller, parameters = controller_settings(robot)
    speeds, _ = EQUATIONS[controller](parameters, *twist)
    text = urdf(robot)
    frames = Frames(text)
    control = ET.fromstring(text.encode()).find("ros2_control")
    assert set(speeds) == {
        each.get("name") for each in control if each.find("command_interface") is not None
    }
    rollers = {joint_names(robot)[w.name].wheel: getattr(w, "roller", None) for w in robot.wheels}
    u, v, r = twist
    for joint, speed in speeds.items():
        axis, hub = frames.axle(joint, {})
        down = np.array([0.0, 0.0, -frames.radius(joint)])
        slip = np.array([u - r * hub[1], v + r * hub[0], 0.0]) + np.cross(speed * axis, down)
        if rollers[joint] is not None:
            turn = Rotation.from_rotvec([0.0, 0.0, rollers[joint]])
            slip = np.array([turn.apply(np.cross(axis, [0.0, 0.0, 1.0])) @ slip])
        assert abs(speed) > MOVES
        assert np.linalg.norm(slip) == pytest.approx(0.0, abs=HALTS)


# ---- <trundle>: what happens when the file is changed ---------------------------------------


def changed(robot: Robot, *swaps: tuple[str, str]) -> str:
    text = urdf(robot)
    for old, new in swaps:
        assert text.count(old) > 0, old
        text = text.replace(old, new)
    return text


def test_a_joint_that_is_moved_moves_the_wheel() -> None:
    text = changed(ROBOTS["differential"], ('xyz="0.0 0.2 0.05"', 'xyz="0.0 0.25 0.05"'))
    assert read(text).wheels[0].y == 0.25


def test_an_axis_that_is_turned_round_turns_the_wheel_round() -> None:
    text = urdf(ROBOTS["omni4"]).replace('axis xyz="0 -1 0"', 'axis xyz="0 2 0"', 1)
    first, given = read(text).wheels[0], ROBOTS["omni4"].wheels[0]
    assert math.remainder(first.heading - given.heading - math.pi, math.tau) == pytest.approx(0)
    assert first.reversed is given.reversed is True


def test_a_sign_that_is_changed_in_one_place_alone_turns_the_wheel_round() -> None:
    text = changed(ONE_REVERSED, (' reversed="true"', ""))
    assert [wheel.heading for wheel in read(text).wheels[:2]] == [0.0, -math.pi]
    both = text.replace('axis xyz="0 -1 0"', 'axis xyz="0 1 0"')
    assert read(both).wheels == ROBOTS["differential"].wheels


@pytest.mark.parametrize(
    ("swaps", "told"),
    [
        ([('joint="left_joint"', 'joint="left_join"')], "did you mean 'left_joint'"),
        ([('joint="left_joint"', 'joint="left_joint" radius="0.06"')], "radius is 0.06 in"),
        ([('joint="left_joint"', 'joint="left_joint" radius="big"')], "must be a number [m]"),
        ([('joint="left_joint"', 'joint="left_joint" radius="nan"')], "must be a number [m]"),
        ([('joint="left_joint"', 'joint="left_joint" color="red"')], "unknown key 'color'"),
        ([('joint="left_joint"', "")], "its joint is missing"),
        ([('kind="caster"', 'kind="castor"')], "did you mean 'caster'"),
        ([('kind="caster"', "")], "kind must be one of"),
        ([("<body", "<bodi")], "unknown element <bodi>"),
        ([("cylinder", "mesh")], "the mesh of link 'left_link' does not tell"),
        ([('axis xyz="0 1 0"', 'axis xyz="0 1 1"')], "must be level in the base frame"),
        ([('axis xyz="0 1 0"', 'axis xyz="0 0 0"')], "axis must not be zero"),
        ([("trundle>", "trundle><wheel/></trundle><trundle>")], ""),
    ],
)  # fmt: skip
def test_a_change_that_does_not_fit_is_told(swaps: list[tuple[str, str]], told: str) -> None:
    with pytest.raises(TrundleError) as error:
        read_urdf(changed(ROBOTS["differential"], *swaps).encode())
    assert told in str(error.value)


def test_a_list_of_wheels_answers_what_a_plain_urdf_leaves_open() -> None:
    told = (
        '<trundle><wheel name="fl" kind="mecanum" joint="wheel_left_joint" radius="0.03" '
        'roller_deg="-45" x="0.0"><encoder ticks_per_motor_turn="100"/></wheel></trundle>'
    )
    text = (
        turtle().replace("</robot>", f"{told}</robot>").replace('<cylinder radius="0.033"', "<mesh")
    )
    (wheel,) = read(text).wheels
    assert (wheel.name, wheel.kind, wheel.y, wheel.radius) == ("fl", "mecanum", 0.08, 0.03)
    assert wheel.encoder == Encoder(ticks_per_motor_turn=100)


# ---- URDF from elsewhere --------------------------------------------------------------------


def joint(name: str, kind: str, parent: str, child: str, xyz: str, rpy: str = "0 0 0",
          axis: str = "", more: str = "") -> str:  # fmt: skip
    about = f'<axis xyz="{axis}"/>' if axis else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/>{about}{more}</joint>'
    )


def cylinder(name: str, radius: float, rpy: str = "0 0 0", xyz: str = "0 0 0") -> str:
    return (
        f'<link name="{name}"><visual><geometry><mesh filename="package://x/tire.stl"/></geometry>'
        f'</visual><collision><origin xyz="{xyz}" rpy="{rpy}"/><geometry>'
        f'<cylinder radius="{radius}" length="0.02"/></geometry></collision></link>'
    )


def robot_text(*parts: str, name: str = "foreign") -> str:
    return f'<?xml version="1.0"?><robot name="{name}">{"".join(parts)}</robot>'


def turtle() -> str:
    """Return a small differential robot: wheel joints tipped by -1.57, a box as its caster."""
    box = '<collision><geometry><box size="0.03 0.009 0.02"/></geometry></collision>'
    return robot_text(
        '<link name="base_footprint"/><link name="base_link"/>',
        joint("base_joint", "fixed", "base_footprint", "base_link", "0 0 0.010"),
        cylinder("wheel_left_link", 0.033),
        joint("wheel_left_joint", "continuous", "base_link", "wheel_left_link",
              "0.0 0.08 0.023", "-1.57 0 0", "0 0 1"),
        cylinder("wheel_right_link", 0.033),
        joint("wheel_right_joint", "continuous", "base_link", "wheel_right_link",
              "0.0 -0.080 0.023", "-1.57 0 0", "0 0 1"),
        f'<link name="caster_back_link">{box}</link>',
        joint("caster_back_joint", "fixed", "base_link", "caster_back_link",
              "-0.081 0 -0.004", "-1.57 0 0"),
        '<link name="base_scan"/>',
        joint("scan_joint", "fixed", "base_link", "base_scan", "-0.032 0 0.172"),
        name="turtle",
    )  # fmt: skip


def husky() -> str:
    """Return a skid-steer robot: base at axle height, wheels with transmissions."""
    quarter = "1.5707963267948966 0 0"
    places = {
        "front_left": (1, 1),
        "front_right": (1, -1),
        "rear_left": (-1, 1),
        "rear_right": (-1, -1),
    }
    parts = ['<link name="base_link"/>', '<link name="base_footprint"/>']
    parts += [joint("base_footprint_joint", "fixed", "base_link", "base_footprint", "0 0 -0.13")]
    for name, (i, j) in places.items():
        parts += [
            cylinder(f"{name}_wheel_link", 0.1651, quarter),
            joint(f"{name}_wheel", "continuous", "base_link", f"{name}_wheel_link",
                  f"{i * 0.256} {j * 0.2854} 0.03282", "0 0 0", "0 1 0"),
            f'<transmission name="{name}_trans"><joint name="{name}_wheel"><hardwareInterface>'
            "hardware_interface/VelocityJointInterface</hardwareInterface></joint></transmission>",
        ]  # fmt: skip
    return robot_text(*parts, name="husky")


def car() -> str:
    """Return a car: hinges about -z on the right, a steering wheel that both hinges mimic."""
    quarter = "1.5707963267948966 0 0"
    parts = ['<link name="chassis"/><link name="column"/>',
             joint("column", "revolute", "chassis", "column", "1 0 1", "0 0.5 0", "0 0 1",
                   '<limit lower="-6" upper="6" effort="1" velocity="5"/>')]  # fmt: skip
    for side, y, up in (("left", 0.7, "0 0 1"), ("right", -0.7, "0 0 -1")):
        turn = 0.1 if side == "left" else -0.1
        parts += [
            f'<link name="{side}_hub"/>', cylinder(f"front_{side}", 0.3, quarter),
            cylinder(f"rear_{side}", 0.35, quarter),
            joint(f"{side}_hinge", "revolute", "chassis", f"{side}_hub", f"2.5 {y} 0.3", axis=up,
                  more='<limit lower="-0.6" upper="0.5" effort="10" velocity="0.7"/>'
                  f'<mimic joint="column" multiplier="{turn}"/>'),
            joint(f"front_{side}_joint", "continuous", f"{side}_hub", f"front_{side}", "0 0 0",
                  axis="0 1 0"),
            joint(f"rear_{side}_joint", "continuous", "chassis", f"rear_{side}", f"0 {y} 0.35",
                  axis="0 1 0", more='<limit effort="200" velocity="40"/>'),
        ]  # fmt: skip
    return robot_text(*parts, name="car")


def mecanum() -> str:
    """Return a mecanum base whose right wheels are mirrored: their axis points to the right."""
    parts = ['<link name="base_link"/>']
    for name, x, y in (
        ("fl", 0.2, 0.15),
        ("fr", 0.2, -0.15),
        ("rl", -0.2, 0.15),
        ("rr", -0.2, -0.15),
    ):
        tip = "-1.5708 0 0" if y > 0 else "1.5708 0 0"
        parts += [
            cylinder(f"{name}_link", 0.05), f'<link name="{name}_roller"/>',
            joint(f"{name}_joint", "continuous", "base_link", f"{name}_link", f"{x} {y} 0", tip,
                  "0 0 1", '<dynamics damping="0.1"/><limit effort="0" velocity="0"/>'),
            joint(f"{name}_roller_joint", "continuous", f"{name}_link", f"{name}_roller",
                  "0.05 0 0", axis="1 0 0"),
        ]  # fmt: skip
    command = '<command_interface name="velocity"/>'
    control = "".join(
        f'<joint name="{n}_joint">{command}</joint>' for n in ("fl", "fr", "rl", "rr")
    )
    return robot_text(*parts, f'<ros2_control name="r" type="system">{control}</ros2_control>')


def test_a_turtle() -> None:
    robot, unknown = read_urdf(turtle().encode())
    assert robot.name == "turtle"
    left, right = robot.wheels
    assert (left.name, left.kind, left.driven, left.reversed) == (
        "wheel_left",
        "fixed",
        True,
        False,
    )
    assert (left.x, left.y, left.radius) == (0.0, 0.08, 0.033)
    assert (right.x, right.y, right.heading) == (0.0, -0.08, 0.0)
    assert left.heading == pytest.approx(0.0, abs=WRITTEN)
    assert unknown[0] == (
        "which wheels are driven: the file does not say; taken as driven: 'wheel_left_joint', "
        "'wheel_right_joint'"
    )
    assert unknown[1].startswith("roller angles")
    assert "friction" in unknown[2]


def test_a_husky() -> None:
    robot, unknown = read_urdf(husky().encode())
    assert [w.name for w in robot.driven] == [
        "front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel",
    ]  # fmt: skip
    assert [(w.x, w.y, w.heading, w.radius) for w in robot.wheels] == [
        (0.256, 0.2854, 0.0, 0.1651), (0.256, -0.2854, 0.0, 0.1651),
        (-0.256, 0.2854, 0.0, 0.1651), (-0.256, -0.2854, 0.0, 0.1651),
    ]  # fmt: skip
    assert not any("driven" in each for each in unknown)


def test_a_car() -> None:
    robot, unknown = read_urdf(car().encode())
    at = {wheel.name: wheel for wheel in robot.wheels}
    left, right, rear = at["front_left"], at["front_right"], at["rear_left"]
    assert (left.kind, left.driven, left.x, left.y) == ("steered", False, 2.5, 0.7)
    assert (rear.kind, rear.driven, rear.radius, rear.max_speed) == ("fixed", True, 0.35, 40.0)
    assert rear.max_torque == 200.0
    assert left.steering_group == right.steering_group == "column"
    # The right hinge turns about -z by -0.1 of the column: about +z by 0.1.
    assert (left.steering_ratio, right.steering_ratio) == (0.1, 0.1)
    assert [left.steering_min, left.steering_max] == pytest.approx([-0.6, 0.5], abs=AGREE)
    assert [right.steering_min, right.steering_max] == pytest.approx([-0.5, 0.6], abs=AGREE)
    assert right.steering_rate == pytest.approx(0.7, abs=AGREE)
    assert "'rear_left_joint', 'rear_right_joint'" in unknown[0]


def test_a_mecanum_base() -> None:
    robot, unknown = read_urdf(mecanum().encode())
    assert [w.name for w in robot.driven] == ["fl", "fr", "rl", "rr"]
    # Turning the right wheels' joints positively drives them back.
    assert [w.reversed for w in robot.wheels] == [False, True, False, True]
    assert [w.heading for w in robot.wheels] == pytest.approx([0.0] * 4, abs=WRITTEN)
    assert [w.max_speed for w in robot.wheels] == [None] * 4
    assert unknown[0] == "4 joints beneath wheels, such as rollers, are not read"
    assert unknown[1] == (
        "a positive turn drives backwards at 'fr_joint', 'rr_joint': taken as reversed"
    )
    assert not any("driven" in each for each in unknown)


@pytest.mark.parametrize("ahead", [0.0, 0.02, 0.7, -1.2, math.pi / 2])
def test_wheels_on_mirrored_axles_have_one_heading(ahead: float) -> None:
    """A differential drive whose joints are drawn outwards from the body, seen in any frame."""
    parts, quarter = ['<link name="base"/>'], math.pi / 2
    for name, side in (("left", 1), ("right", -1)):
        place = (-0.2 * side * math.sin(ahead), 0.2 * side * math.cos(ahead), 0.05)
        tip = (-quarter * side, 0.0, ahead)
        parts += [
            cylinder(f"{name}_link", 0.05),
            joint(f"{name}_joint", "continuous", "base", f"{name}_link", spaced(np.array(place)),
                  spaced(np.array(tip)), "0 0 1"),
        ]  # fmt: skip
    robot, unknown = read_urdf(robot_text(*parts).encode())
    assert [wheel.reversed for wheel in robot.wheels] == [False, True]
    assert [wheel.heading for wheel in robot.wheels] == pytest.approx([ahead] * 2, abs=AGREE)
    assert "a positive turn drives backwards at 'right_joint': taken as reversed" in unknown


def test_a_mirrored_wheel_that_steers_with_an_offset_has_it_once() -> None:
    more = '<mimic joint="scan_joint" offset="0.25"/>'
    text = swivel(offset="0 0 -0.05", more=more).replace('axis xyz="0 1 0"', 'axis xyz="0 -1 0"')
    wheel = read_urdf(text.encode()).robot.wheels[2]
    assert wheel.reversed
    assert wheel.heading == pytest.approx(0.75, abs=AGREE)


FOREIGN = {"turtle": turtle(), "husky": husky(), "car": car(), "mecanum": mecanum()}


@pytest.mark.parametrize("text", FOREIGN.values(), ids=FOREIGN)
def test_foreign_joints_turn_as_their_axes_say(text: str) -> None:
    """The rim's velocity, omega x r from the text alone, is what the read wheel says."""
    frames = Frames(text)
    for wheel in read_urdf(text.encode()).robot.wheels:
        name = next(each for each in (wheel.name, f"{wheel.name}_joint") if each in frames.joints)
        axis, hub = frames.axle(name, {})
        rim = np.cross(axis, [0.0, 0.0, -frames.radius(name)])
        speed = wheel.radius * (-1 if wheel.reversed else 1)
        told = [-speed * math.cos(wheel.heading), -speed * math.sin(wheel.heading), 0.0]
        assert rim == pytest.approx(told, abs=1e-3 * wheel.radius)  # 1.57 for a quarter turn
        assert hub[:2] == pytest.approx([wheel.x, wheel.y], abs=AGREE)


@each_robot
def test_our_urdf_without_its_extension_drives_alike(robot: Robot) -> None:
    """What other programs see of it: same places, same driven wheels, same directions."""
    text = urdf(robot)
    begin, end = text.index("<trundle>"), text.index("</robot>")
    plain, unknown = read_urdf((text[:begin] + text[end:]).encode())
    assert any("roller angles" in each for each in unknown)
    assert not any("driven" in each for each in unknown)
    names = joint_names(robot)
    found = {wheel.name: wheel for wheel in plain.wheels}
    for wheel in robot.wheels:
        other = found[names[wheel.name].wheel.removesuffix("_joint")]
        assert (other.x, other.y, other.driven) == (wheel.x, wheel.y, wheel.driven)
        assert other.kind == {"omni": "fixed", "mecanum": "fixed"}.get(wheel.kind, wheel.kind)
        if isinstance(wheel, BallWheel):
            continue
        assert other.radius == wheel.radius
        back = [math.pi if getattr(each, "reversed", False) else 0.0 for each in (wheel, other)]
        apart = math.remainder(other.heading + back[1] - wheel.heading - back[0], math.tau)
        assert apart == pytest.approx(0.0, abs=AGREE)


def spaced(numbers: np.ndarray) -> str:
    return " ".join(repr(float(each)) for each in numbers)


@pytest.mark.parametrize("seed", range(8))
def test_a_chain_of_frames_that_lean_every_way(seed: int) -> None:
    """A wheel at a chosen place and heading hangs on two links with random frames."""
    random = np.random.default_rng(seed)
    heading = random.uniform(-2.5, 2.5)
    place = np.array([*random.uniform(-1, 1, 2), 0.2])
    first, second = Rotation.random(2, random_state=seed)
    offsets = random.uniform(-1, 1, (2, 3))
    # The wheel's frame is turned about its axle, too; the axle is the y axis of the frame.
    wheel = Rotation.from_euler("z", heading) * Rotation.from_euler("y", random.uniform(-3, 3))
    mount, mounted = first * second, offsets[0] + first.apply(offsets[1])
    last = (mount.inv() * wheel).as_euler("xyz"), mount.inv().apply(place - mounted)
    text = robot_text(
        '<link name="a"/><link name="b"/><link name="c"/>',
        joint("ab", "fixed", "a", "b", spaced(offsets[0]), spaced(first.as_euler("xyz"))),
        joint("bc", "fixed", "b", "c", spaced(offsets[1]), spaced(second.as_euler("xyz"))),
        cylinder("w", 0.2, "1.5707963267948966 0 0"),
        joint("turn", "continuous", "c", "w", spaced(last[1]), spaced(last[0]), "0 1 0"),
    )
    (found,) = read_urdf(text.encode()).robot.wheels
    assert [found.x, found.y, found.radius] == pytest.approx([*place[:2], 0.2], abs=AGREE)
    # Beyond a quarter turn a positive turn of the joint drives backwards.
    assert found.reversed is (abs(heading) > math.pi / 2)
    apart = found.heading + (math.pi if found.reversed else 0.0) - heading
    assert math.remainder(apart, math.tau) == pytest.approx(0.0, abs=AGREE)
    assert abs(found.heading) < math.pi / 2


def test_steering_that_follows_through_two_joints() -> None:
    """The leader turns about -z; the last joint stands at 2 (-3 q + 0.1) + 0.2, q the leader's."""
    quarter = "1.5707963267948966 0 0"
    follow = {
        "lead": "", "middle": '<mimic joint="lead" multiplier="-3" offset="0.1"/>',
        "last": '<mimic joint="middle" multiplier="2" offset="0.2"/>',
    }  # fmt: skip
    parts = ['<link name="base"/>']
    for x, (name, more) in enumerate(follow.items()):
        axis = "0 0 -1" if name == "lead" else "0 0 1"
        parts += [
            f'<link name="{name}_hub"/>', cylinder(f"{name}_wheel", 0.1, quarter),
            joint(name, "continuous", "base", f"{name}_hub", f"{x} 0 0.1", axis=axis, more=more),
            joint(f"{name}_roll", "continuous", f"{name}_hub", f"{name}_wheel", "0 0 0",
                  axis="0 1 0"),
        ]  # fmt: skip
    wheels = read_urdf(robot_text(*parts).encode()).robot.wheels
    assert [wheel.steering_group for wheel in wheels] == ["lead"] * 3
    # The group's angle is the leader's about +z, -q: the others turn by 3 and 6 of it.
    assert [wheel.steering_ratio for wheel in wheels] == [1.0, 3.0, 6.0]
    assert [w.heading for w in wheels] == pytest.approx([0.0, 0.1, 0.4], abs=AGREE)


def swivel(kind: str = "continuous", offset: str = "-0.02 0 -0.05", more: str = "") -> str:
    quarter = "1.5707963267948966 0 0"
    return turtle().replace(
        "</robot>",
        '<link name="fork"/>'
        + joint("swivel", kind, "base_link", "fork", "-0.1 0 0.053", "0 0 0.5", "0 0 1", more)
        + cylinder("small", 0.013, quarter)
        + joint("roll_joint", "continuous", "fork", "small", offset, axis="0 1 0")
        + "</robot>",
    )


def test_a_free_swivel_is_a_caster() -> None:
    caster = read_urdf(swivel().encode()).robot.wheels[2]
    assert (caster.name, caster.kind, caster.radius, caster.trail) == (
        "roll",
        "caster",
        0.013,
        0.02,
    )
    assert (caster.x, caster.y) == (-0.1, 0.0)
    assert caster.heading == pytest.approx(0.5, abs=AGREE)


def test_a_caster_that_is_drawn_ahead_of_its_pivot_heads_back() -> None:
    caster = read_urdf(swivel(offset="0.02 0 -0.05").encode()).robot.wheels[2]
    assert abs(math.remainder(caster.heading - 0.5, math.tau)) == pytest.approx(math.pi)


def test_a_caster_on_a_frame_that_stands_on_its_head() -> None:
    text = swivel(offset="-0.012 0.016 0.05")
    text = text.replace('rpy="0 0 0.5"', 'rpy="3.141592653589793 0 0.5"')
    caster = read_urdf(text.encode()).robot.wheels[2]
    assert caster.trail == pytest.approx(0.02)
    # The wheel is at (-0.012, -0.016) of the frame that is turned by 0.5 alone.
    assert caster.heading == pytest.approx(0.5 + math.atan2(0.016, 0.012), abs=AGREE)


def test_a_swivel_through_the_contact_point_steers() -> None:
    robot, unknown = read_urdf(swivel(offset="0 0 -0.05").encode())
    assert (robot.wheels[2].kind, robot.wheels[2].driven) == ("steered", False)
    assert not any("beside" in each for each in unknown)


def test_a_swivel_with_a_command_steers_and_its_offset_is_told() -> None:
    trans = '<transmission name="t"><joint name="swivel"/></transmission></robot>'
    robot, unknown = read_urdf(swivel().replace("</robot>", trans).encode())
    assert robot.wheels[2].kind == "steered"
    assert (robot.wheels[2].x, robot.wheels[2].y) == (-0.1, 0.0)
    assert any("steers 0.02 m beside the contact point" in each for each in unknown)


def test_an_offset_of_a_mimic_moves_the_zero() -> None:
    more = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    more += '<mimic joint="scan_joint" offset="0.25"/>'
    wheel = read_urdf(swivel("revolute", more=more).encode()).robot.wheels[2]
    assert (wheel.steering_group, wheel.steering_ratio) == ("scan_joint", 1.0)
    assert wheel.heading == pytest.approx(0.75, abs=AGREE)
    assert [wheel.steering_min, wheel.steering_max] == pytest.approx([-1.25, 0.75], abs=AGREE)


def test_a_sphere_on_the_ground_is_a_ball() -> None:
    ball = '<collision><geometry><sphere radius="0.01"/></geometry></collision>'
    text = turtle().replace(
        '<collision><geometry><box size="0.03 0.009 0.02"/></geometry></collision>', ball
    )
    text = text.replace('xyz="-0.081 0 -0.004"', 'xyz="-0.081 0 0.0"')
    found = read_urdf(text.encode()).robot.wheels[2]
    assert found == BallWheel(name="caster_back", x=-0.081, y=0.0, radius=0.01)


def test_masses_are_gathered() -> None:
    def inertial(mass: float, ixx: float, izz: float, xyz: str = "0 0 0") -> str:
        return (
            f'<inertial><origin xyz="{xyz}"/><mass value="{mass}"/><inertia ixx="{ixx}" ixy="0" '
            f'ixz="0" iyy="{ixx}" iyz="0" izz="{izz}"/></inertial>'
        )

    text = turtle().replace(
        '<link name="base_link"/>', f'<link name="base_link">{inertial(2, 1, 3)}</link>'
    )
    text = text.replace(
        '<link name="base_scan"/>', f'<link name="base_scan">{inertial(1, 0, 0.5)}</link>'
    )
    text = text.replace(
        '<link name="wheel_left_link">', f'<link name="wheel_left_link">{inertial(0.1, 0.2, 0.3)}'
    )
    robot = read_urdf(text.encode()).robot
    assert robot.body.mass == 3.0
    assert robot.body.com == pytest.approx((-0.032 / 3, 0.0))
    apart = 2.0 * 1.0 / 3.0 * 0.032**2  # two point masses: m1 m2 / (m1 + m2) d^2
    assert robot.body.inertia == pytest.approx(3.5 + apart)
    left = robot.wheels[0]
    assert left.mass == 0.1
    # The link's z axis lies along the axle, but for the 1.57.
    assert [left.yaw_inertia, left.spin_inertia] == pytest.approx([0.2, 0.3], rel=1e-5)


def test_load_warns_of_what_a_urdf_leaves_open(tmp_path) -> None:
    path = tmp_path / "turtle.URDF"
    path.write_text(turtle(), encoding="utf-8")
    with pytest.warns(GuessWarning, match="does not tell all") as told:
        robot = trundle.load(path)
    assert len(robot.wheels) == 2
    assert told[0].filename == __file__
    assert "\n  - which wheels are driven" in str(told[0].message)


def test_the_command_reads_a_urdf(trundle, tmp_path) -> None:
    path = tmp_path / "mine.urdf"
    path.write_text(urdf(ROBOTS["omni4"]), encoding="utf-8")
    code, out, err = trundle("show", path)
    assert (code, err) == (0, "")
    assert "front_left" in out


def test_the_command_tells_what_is_guessed_and_goes_on(trundle, tmp_path) -> None:
    path = tmp_path / "mine.urdf"
    path.write_text(turtle(), encoding="utf-8")
    code, out, err = trundle("show", path)
    assert code == 0
    assert "wheel_left" in out
    assert "which wheels are driven" in " ".join(err.split())
    assert "GuessWarning" not in err


# ---- what is wrong --------------------------------------------------------------------------

ONE = joint("j", "continuous", "a", "b", "0 0 0.1", axis="0 1 0")
LINKS = '<link name="a"/>' + cylinder("b", 0.1, "1.5707963 0 0")
BOMB = '<!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa">' + "".join(
    f'<!ENTITY {b} "{"&" + a + ";" * 1}{("&" + a + ";") * 9}">'
    for a, b in zip(string.ascii_lowercase[:12], string.ascii_lowercase[1:13], strict=True)
) + ']><robot name="&m;"/>'  # fmt: skip

WRONG = {
    "no XML": ("robot", "not valid XML"),
    "empty": ("", "no element found"),
    "cut off": (turtle()[:500], "not valid XML"),
    "bomb": (BOMB, "no <!DOCTYPE>"),
    "outside": (
        '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot>&x;</robot>',
        "DOCTYPE",
    ),
    "parameter": ('<!DOCTYPE r SYSTEM "http://x.invalid/a.dtd"><robot/>', "no <!DOCTYPE>"),
    "entity": ('<robot name="&x;"/>', "undefined entity"),
    "deep": ("<robot>" + "<a>" * 100_000, "50 deep"),
    "encoding": ('<?xml version="1.0" encoding="klingon"?><robot/>', "unknown encoding"),
    "SDF": ("<sdf version='1.6'/>", "an SDF file"),
    "xacro": (
        '<robot xmlns:xacro="http://ros.org/wiki/xacro"><xacro:macro name="m"/></robot>',
        "xacro robot.urdf.xacro",
    ),
    "xacro value": ('<robot><link name="${n}"/></robot>', "run it first"),
    "no links": ("<robot/>", "there is no <link>"),
    "no wheels": ('<robot><link name="a"/></robot>', "no wheel is found"),
    "no name": ("<robot><link/></robot>", "a <link> has no name"),
    "same link": (
        '<robot><link name="a"/><link name="a"/></robot>',
        "link 'a': the name is used 2 times",
    ),
    "same joint": (robot_text(LINKS, ONE, ONE), "joint 'j': the name is used 2 times"),
    "no type": (
        robot_text(LINKS, ONE.replace(' type="continuous"', "")),
        "joint 'j': type must be one of",
    ),
    "bad type": (
        robot_text(LINKS, ONE.replace("continuous", "continous")),
        "did you mean 'continuous'",
    ),
    "no parent": (
        robot_text(LINKS, ONE.replace('<parent link="a"/>', "")),
        "joint 'j': its parent is missing",
    ),
    "bad child": (
        robot_text(LINKS, ONE.replace('child link="b"', 'child link="bb"')),
        "its child 'bb' is no link",
    ),
    "two roots": (
        robot_text(LINKS, ONE, '<link name="c"/>'),
        "2 links are the child of no joint ('a', 'c')",
    ),
    "circle": (robot_text(LINKS, ONE, joint("k", "fixed", "b", "a", "0 0 0")), "run in a circle"),
    "far circle": (
        robot_text(
            LINKS,
            ONE,
            '<link name="c"/><link name="d"/>',
            joint("k", "fixed", "c", "d", "0 0 0"),
            joint("l", "fixed", "d", "c", "0 0 0"),
        ),
        "link 'c' does not hang on the base",
    ),
    "self": (
        robot_text(LINKS, joint("j", "continuous", "b", "b", "0 0 0", axis="0 1 0")),
        "does not hang",
    ),
    "two parents": (
        robot_text(LINKS, ONE, ONE.replace('"j"', '"k"')),
        "link 'b': it is the child of 2 joints",
    ),
    "NaN": (
        robot_text(LINKS, ONE.replace("0 0 0.1", "0 nan 0.1")),
        "origin xyz must be three finite numbers",
    ),
    "inf": (
        robot_text(LINKS, ONE.replace("0 0 0.1", "0 1e999 0.1")),
        "origin xyz must be three finite numbers",
    ),
    "two numbers": (robot_text(LINKS, ONE.replace("0 0 0.1", "0 0")), "got '0 0'"),
    "text": (
        robot_text(LINKS, ONE.replace("0 1 0", "0 y 0")),
        "axis xyz must be three finite numbers",
    ),
    "no axis": (robot_text(LINKS, ONE.replace("0 1 0", "0 0 0")), "axis must not be zero"),
    "upright": (robot_text(LINKS, ONE.replace("0 1 0", "0 0 1")), "no wheel is found"),
    "negative": (
        robot_text(LINKS.replace('"0.1"', '"-0.1"'), ONE),
        "radius must be a positive number",
    ),
    "no radius": (
        robot_text(LINKS.replace('radius="0.1"', ""), ONE),
        "radius of the cylinder is missing",
    ),
    "mesh": (
        robot_text(LINKS.replace("<cylinder", "<mesh"), ONE),
        "the mesh of link 'b' does not tell",
    ),
    "no shape": (robot_text('<link name="a"/><link name="b"/>', ONE), "has no cylinder or sphere"),
    "across": (robot_text(LINKS.replace("1.5707963", "0"), ONE), "does not turn about the axis"),
    "huge": (
        robot_text(LINKS, ONE.replace('rpy="0 0 0"', 'rpy="0 0 1e308"')),
        "heading_deg must be finite",
    ),
    "mimic": (swivel(more='<mimic joint="ghost"/>'), "mimics 'ghost', but it is no joint"),
    "mimic of itself": (swivel(more='<mimic joint="swivel"/>'), "in a circle"),
    "mimic by zero": (
        swivel(more='<mimic joint="scan_joint" multiplier="0"/>'),
        "must not be zero",
    ),
    "mimic by NaN": (
        swivel(more='<mimic joint="scan_joint" multiplier="nan"/>'),
        "must be a finite number",
    ),
    "limits": (
        swivel("revolute", more='<limit lower="1" upper="-1"/>'),
        "steering_min_deg must not exceed",
    ),
    "quaternion": (robot_text(LINKS, ONE.replace("rpy=", "quat_xyzw=")), "told by rpy"),
    "two trundles": (robot_text(LINKS, ONE, "<trundle/><trundle/>"), "2 elements <trundle>"),
    "empty trundle": (robot_text(LINKS, ONE, "<trundle/>"), "it has no <wheel>"),
}


@pytest.mark.parametrize(("text", "told"), WRONG.values(), ids=WRONG)
def test_a_wrong_file_is_told_in_words(text: str, told: str, tmp_path) -> None:
    path = tmp_path / "x.urdf"
    path.write_text(text, encoding="utf-8")
    with pytest.raises((FileError, RobotError)) as error:
        trundle.load(path)
    assert told in str(error.value)
    assert str(path) in str(error.value)
    assert len(str(error.value)) < 2000


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (b"<robot name='\xff'/>", "is not UTF-8"),
        ("<robot/>".encode("utf-16"), "there is no <link>"),
        (b"<robot>\x00</robot>", "not valid XML"),
        (b" " * (MOST_BYTES + 1), "more than 5 MB"),
        (b"\x89PNG\r\n\x1a\n", "not valid XML"),
    ],
)
def test_wrong_bytes_are_told_in_words(data: bytes, told: str) -> None:
    with pytest.raises((FileError, RobotError), match=told):
        read_urdf(data)


def test_a_file_that_is_not_there(tmp_path) -> None:
    with pytest.raises(FileError, match="No such file"):
        trundle.load("nothing_here.urdf")
    with pytest.raises(FileError, match="cannot be read"):
        trundle.load(tmp_path / "a\0.urdf")
    (tmp_path / "folder.urdf").mkdir()
    with pytest.raises(FileError, match="cannot be read"):
        trundle.load(tmp_path / "folder.urdf")


def test_a_large_file_is_read_in_time() -> None:
    many = 5000  # of the size that is still read; squares of it would take minutes
    links = "".join(f'<link name="l{i}"/>' for i in range(many))
    chain = "".join(joint(f"j{i}", "fixed", f"l{i}", f"l{i + 1}", "0 0 0") for i in range(many - 1))
    with pytest.raises(RobotError, match="more than 200 joints"):
        read_urdf(robot_text(links, chain).encode())
    with pytest.raises(RobotError) as error:
        read_urdf(robot_text(links, chain.replace('child link="', 'child link="x')).encode())
    assert len(error.value.faults) == 21
    assert error.value.faults[-1].endswith("more")
    wheels = "".join(
        cylinder(f"w{i}", 0.1, "1.5708 0 0")
        + joint(f"j{i}", "continuous", "l0", f"w{i}", f"{i} 0 0", axis="0 1 0")
        for i in range(many)
    )
    assert len(read_urdf(robot_text('<link name="l0"/>', wheels).encode()).robot.wheels) == many


PIECES = ("nan", "-1", "0", "1e308", "", "a", '"', "<", "0 0 0", "left_joint", "fixed", "none")


@given(st.data())
@settings(max_examples=300)
def test_no_mutation_ends_in_a_traceback(data: st.DataObject) -> None:
    text = data.draw(st.sampled_from([*FOREIGN.values(), urdf(ROBOTS["mixed"]), swivel()]))
    for _ in range(data.draw(st.integers(1, 4))):
        quotes = [i for i, c in enumerate(text) if c == '"']
        at = data.draw(st.integers(0, len(quotes) // 2 - 2))
        begin, end = quotes[2 * at] + 1, quotes[2 * at + 1]
        text = text[:begin] + data.draw(st.sampled_from(PIECES)) + text[end:]
    try:
        robot = read_urdf(text.encode()).robot
    except TrundleError:
        return
    for wheel in robot.wheels:
        assert math.isfinite(wheel.x)
        assert math.isfinite(wheel.y)
        assert getattr(wheel, "radius", None) is None or 0 < wheel.radius < math.inf
