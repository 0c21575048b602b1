"""Definitions of the ROS 2 messages that are written, as they have been since ROS 2 Humble.

Constants of the definitions are left out: they are no part of a message.
"""

from __future__ import annotations

import re
from typing import Final

DEFINITIONS: Final = {
    "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec\n",
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z\n",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
    "geometry_msgs/PoseStamped": "std_msgs/Header header\ngeometry_msgs/Pose pose\n",
    "geometry_msgs/Quaternion": "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
    "geometry_msgs/Transform": (
        "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"
    ),
    "geometry_msgs/TransformStamped": (
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"
    ),
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z\n",
    "nav_msgs/MapMetaData": (
        "builtin_interfaces/Time map_load_time\n"
        "float32 resolution\n"
        "uint32 width\n"
        "uint32 height\n"
        "geometry_msgs/Pose origin\n"
    ),
    "nav_msgs/OccupancyGrid": ("std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data\n"),
    "nav_msgs/Path": "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n",
    "rcl_interfaces/Log": (
        "builtin_interfaces/Time stamp\n"
        "uint8 level\n"
        "string name\n"
        "string msg\n"
        "string file\n"
        "string function\n"
        "uint32 line\n"
    ),
    "sensor_msgs/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data\n",
    "std_msgs/ColorRGBA": "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n",
    "std_msgs/Float64": "float64 data\n",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms\n",
    "visualization_msgs/Marker": (
        "std_msgs/Header header\n"
        "string ns\n"
        "int32 id\n"
        "int32 type\n"
        "int32 action\n"
        "geometry_msgs/Pose pose\n"
        "geometry_msgs/Vector3 scale\n"
        "std_msgs/ColorRGBA color\n"
        "builtin_interfaces/Duration lifetime\n"
        "bool frame_locked\n"
        "geometry_msgs/Point[] points\n"
        "std_msgs/ColorRGBA[] colors\n"
        "string texture_resource\n"
        "sensor_msgs/CompressedImage texture\n"
        "visualization_msgs/UVCoordinate[] uv_coordinates\n"
        "string text\n"
        "string mesh_resource\n"
        "visualization_msgs/MeshFile mesh_file\n"
        "bool mesh_use_embedded_materials\n"
    ),
    "visualization_msgs/MarkerArray": "visualization_msgs/Marker[] markers\n",
    "visualization_msgs/MeshFile": "string filename\nuint8[] data\n",
    "visualization_msgs/UVCoordinate": "float32 u\nfloat32 v\n",
}
"""The fields of each message, one a line."""

_BORDER: Final = "=" * 80
_MESSAGE_TYPE: Final = re.compile(r"^(\w+/\w+)(?:\[\])? ", re.MULTILINE)


def definition_of(name: str) -> str:
    """Return the whole definition of a message, with those of the messages in it.

    Parameters
    ----------
    name : str
        A key of `DEFINITIONS`.

    Returns
    -------
    str
        The definition, with those of all types that it uses.

    Examples
    --------
    >>> print(definition_of("std_msgs/Header").replace("=" * 80, "===="))
    builtin_interfaces/Time stamp
    string frame_id
    ====
    MSG: builtin_interfaces/Time
    int32 sec
    uint32 nanosec
    <BLANKLINE>
    """
    needed, waiting = {name: None}, [name]
    while waiting:
        for inner in _MESSAGE_TYPE.findall(DEFINITIONS[waiting.pop(0)]):
            if inner not in needed:
                needed[inner] = None
                waiting.append(inner)
    first, *others = needed
    return DEFINITIONS[first] + "".join(
        f"{_BORDER}\nMSG: {other}\n{DEFINITIONS[other]}" for other in others
    )
