"""Messages of ROS 2 that are known without their `.msg` files, and the text of a message with all that is in it.

Field by field as in ros2/common_interfaces, ros2/rcl_interfaces, ros2/geometry2 and autoware_auto_msgs, without their
constants and comments: those do not change what stands in the data.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from protocols.xrce.cdr.definitions import MessageDefinition, parse_message
from protocols.xrce.errors import LocalProtocolError

__all__ = ["INTERFACES", "definition_of", "full_text"]

_LINE = "=" * 80
"""What stands between the messages of a full text (mcap.dev/spec/registry, ros2msg)."""

_HEADER = "std_msgs/Header header, "
_STAMP = "builtin_interfaces/Time stamp, "
_XYZ = "float64 x, float64 y, float64 z"
_LAYOUT = "MultiArrayLayout layout, "
_SINGLE = {
    "Bool": "bool",
    "Byte": "byte",
    "Char": "char",
    "Float32": "float32",
    "Float64": "float64",
    "Int8": "int8",
    "Int16": "int16",
    "Int32": "int32",
    "Int64": "int64",
    "String": "string",
    "UInt8": "uint8",
    "UInt16": "uint16",
    "UInt32": "uint32",
    "UInt64": "uint64",
}
_STD = {
    **{name: f"{kind} data" for name, kind in _SINGLE.items()},
    **{f"{name}MultiArray": f"{_LAYOUT}{kind}[] data" for name, kind in _SINGLE.items() if name[-1].isdigit()},
    "ByteMultiArray": f"{_LAYOUT}byte[] data",
    "ColorRGBA": "float32 r, float32 g, float32 b, float32 a",
    "Empty": "",
    "Header": f"{_STAMP}string frame_id",
    "MultiArrayDimension": "string label, uint32 size, uint32 stride",
    "MultiArrayLayout": "MultiArrayDimension[] dim, uint32 data_offset",
}
_GEOMETRY = {
    "Accel": "Vector3 linear, Vector3 angular",
    "Point": _XYZ,
    "Point32": "float32 x, float32 y, float32 z",
    "Pose": "Point position, Quaternion orientation",
    "Pose2D": "float64 x, float64 y, float64 theta",
    "PoseStamped": f"{_HEADER}Pose pose",
    "PoseWithCovariance": "Pose pose, float64[36] covariance",
    "PoseWithCovarianceStamped": f"{_HEADER}PoseWithCovariance pose",
    "Quaternion": f"{_XYZ}, float64 w",
    "Transform": "Vector3 translation, Quaternion rotation",
    "TransformStamped": f"{_HEADER}string child_frame_id, Transform transform",
    "Twist": "Vector3 linear, Vector3 angular",
    "TwistStamped": f"{_HEADER}Twist twist",
    "TwistWithCovariance": "Twist twist, float64[36] covariance",
    "Vector3": _XYZ,
    "Vector3Stamped": f"{_HEADER}Vector3 vector",
    "Wrench": "Vector3 force, Vector3 torque",
}
_SENSOR = {
    "BatteryState": f"{_HEADER}float32 voltage, float32 temperature, float32 current, float32 charge, "
    "float32 capacity, float32 design_capacity, float32 percentage, uint8 power_supply_status, "
    "uint8 power_supply_health, uint8 power_supply_technology, bool present, float32[] cell_voltage, "
    "float32[] cell_temperature, string location, string serial_number",
    "FluidPressure": f"{_HEADER}float64 fluid_pressure, float64 variance",
    "Illuminance": f"{_HEADER}float64 illuminance, float64 variance",
    "Imu": f"{_HEADER}geometry_msgs/Quaternion orientation, float64[9] orientation_covariance, "
    "geometry_msgs/Vector3 angular_velocity, float64[9] angular_velocity_covariance, "
    "geometry_msgs/Vector3 linear_acceleration, float64[9] linear_acceleration_covariance",
    "JointState": f"{_HEADER}string[] name, float64[] position, float64[] velocity, float64[] effort",
    "Joy": f"{_HEADER}float32[] axes, int32[] buttons",
    "LaserScan": f"{_HEADER}float32 angle_min, float32 angle_max, float32 angle_increment, float32 time_increment, "
    "float32 scan_time, float32 range_min, float32 range_max, float32[] ranges, float32[] intensities",
    "MagneticField": f"{_HEADER}geometry_msgs/Vector3 magnetic_field, float64[9] magnetic_field_covariance",
    "NavSatFix": f"{_HEADER}NavSatStatus status, float64 latitude, float64 longitude, float64 altitude, "
    "float64[9] position_covariance, uint8 position_covariance_type",
    "NavSatStatus": "int8 status, uint16 service",
    "Range": f"{_HEADER}uint8 radiation_type, float32 field_of_view, float32 min_range, float32 max_range, "
    "float32 range",
    "RelativeHumidity": f"{_HEADER}float64 relative_humidity, float64 variance",
    "Temperature": f"{_HEADER}float64 temperature, float64 variance",
    "TimeReference": f"{_HEADER}builtin_interfaces/Time time_ref, string source",
}
_VEHICLE = {
    "ControlModeReport": f"{_STAMP}uint8 mode",
    "HazardLightsCommand": f"{_STAMP}uint8 command",
    "HazardLightsReport": f"{_STAMP}uint8 report",
    "SteeringReport": f"{_STAMP}float32 steering_tire_angle",
    "TurnIndicatorsCommand": f"{_STAMP}uint8 command",
    "TurnIndicatorsReport": f"{_STAMP}uint8 report",
    "VelocityReport": f"{_HEADER}float32 longitudinal_velocity, float32 lateral_velocity, float32 heading_rate",
}
_CONTROL = {
    "AckermannControlCommand": f"{_STAMP}AckermannLateralCommand lateral, LongitudinalCommand longitudinal",
    "AckermannLateralCommand": f"{_STAMP}float32 steering_tire_angle, float32 steering_tire_rotation_rate",
    "LongitudinalCommand": f"{_STAMP}float32 speed, float32 acceleration, float32 jerk",
}
_PACKAGES = {
    "autoware_auto_control_msgs": _CONTROL,
    "autoware_auto_vehicle_msgs": _VEHICLE,
    "builtin_interfaces": dict.fromkeys(("Duration", "Time"), "int32 sec, uint32 nanosec"),
    "geometry_msgs": _GEOMETRY,
    "nav_msgs": {
        "Odometry": f"{_HEADER}string child_frame_id, geometry_msgs/PoseWithCovariance pose, "
        "geometry_msgs/TwistWithCovariance twist",
        "Path": f"{_HEADER}geometry_msgs/PoseStamped[] poses",
    },
    "rosgraph_msgs": {"Clock": "builtin_interfaces/Time clock"},
    "sensor_msgs": _SENSOR,
    "std_msgs": _STD,
    "tf2_msgs": {"TFMessage": "geometry_msgs/TransformStamped[] transforms"},
}

INTERFACES: Mapping[str, str] = MappingProxyType(
    {
        f"{package}/msg/{name}": fields.replace(", ", "\n")
        for package, messages in _PACKAGES.items()
        for name, fields in messages.items()
    }
)
"""What would stand in the `.msg` file of a message, by its full name."""


def definition_of(name: str) -> MessageDefinition:
    """A message of `INTERFACES`.

    Raises:
        LocalProtocolError: there is none of this name.
    """
    if name not in INTERFACES:
        raise LocalProtocolError(f"{name} is not known here")
    return parse_message(name, INTERFACES[name])


def full_text(name: str, text_of: Callable[[str], str | None]) -> str:
    """The text of a message, and of all that are in it, as recordings have it.

    Args:
        name: of the message, such as ``std_msgs/msg/Header``.
        text_of: what stands in the `.msg` file of a message; None where that is not known.

    Raises:
        LocalProtocolError: one of them is not known, or cannot be read.
    """
    texts: dict[str, str] = {}
    wanted = [name]
    while wanted:
        one = wanted.pop(0)
        if one in texts:
            continue
        text = text_of(one)
        if text is None:
            raise LocalProtocolError(f"{one} is not known here")
        texts[one] = text
        fields = parse_message(one, text).fields
        wanted += [field.type.base for field in fields if field.type.is_message]
    first, *others = texts.items()
    return "\n".join((first[1], *(f"{_LINE}\nMSG: {one.replace('/msg/', '/')}\n{text}" for one, text in others)))
