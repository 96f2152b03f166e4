"""Standard ROS 2 message definitions that a recording uses: field names and order, no more.

A recording carries them in itself, so a tool that opens it needs no ROS.
"""

_DEFINITIONS = {
    "builtin_interfaces/msg/Time": "int32 sec\nuint32 nanosec",
    "builtin_interfaces/msg/Duration": "int32 sec\nuint32 nanosec",
    "std_msgs/msg/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "std_msgs/msg/String": "string data",
    "std_msgs/msg/Int32": "int32 data",
    "std_msgs/msg/ColorRGBA": "float32 r\nfloat32 g\nfloat32 b\nfloat32 a",
    "sensor_msgs/msg/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data",
    "geometry_msgs/msg/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/msg/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/msg/Quaternion": "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1",
    "geometry_msgs/msg/Pose": "Point position\nQuaternion orientation",
    "geometry_msgs/msg/PoseStamped": "std_msgs/Header header\nPose pose",
    "geometry_msgs/msg/Twist": "Vector3 linear\nVector3 angular",
    "geometry_msgs/msg/TwistStamped": "std_msgs/Header header\nTwist twist",
    "geometry_msgs/msg/Accel": "Vector3 linear\nVector3 angular",
    "geometry_msgs/msg/AccelStamped": "std_msgs/Header header\nAccel accel",
    "diagnostic_msgs/msg/KeyValue": "string key\nstring value",
    "diagnostic_msgs/msg/DiagnosticStatus": (
        "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\n"
        "byte level\nstring name\nstring message\nstring hardware_id\nKeyValue[] values"
    ),
    "diagnostic_msgs/msg/DiagnosticArray": "std_msgs/Header header\nDiagnosticStatus[] status",
    "visualization_msgs/msg/ImageMarker": (
        "int32 CIRCLE=0\nint32 LINE_STRIP=1\nint32 LINE_LIST=2\nint32 POLYGON=3\nint32 POINTS=4\n"
        "int32 ADD=0\nint32 REMOVE=1\n"
        "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n"
        "geometry_msgs/Point position\nfloat32 scale\nstd_msgs/ColorRGBA outline_color\n"
        "uint8 filled\nstd_msgs/ColorRGBA fill_color\nbuiltin_interfaces/Duration lifetime\n"
        "geometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] outline_colors"
    ),
}
"""Definitions by full name, in the language of .msg files."""

_SEPARATOR = "=" * 80


def definition(name: str) -> str:
    """A message's definition, followed by those of the messages in it: what an MCAP schema holds.

    Parameters
    ----------
    name : str
        Full name, such as ``"geometry_msgs/msg/PoseStamped"``.

    Returns
    -------
    str
        The text.

    Examples
    --------
    >>> print(definition("geometry_msgs/msg/Twist"))
    Vector3 linear
    Vector3 angular
    ================================================================================
    MSG: geometry_msgs/Vector3
    float64 x
    float64 y
    float64 z
    """
    needed = [name]
    for of in needed:  # grows while it is gone through
        needed += [part for part in _parts(of) if part not in needed]
    texts = [_DEFINITIONS[name]]
    texts += [f"MSG: {part.replace('/msg/', '/')}\n{_DEFINITIONS[part]}" for part in needed[1:]]
    return f"\n{_SEPARATOR}\n".join(texts)


def _parts(name: str) -> list[str]:
    """Full names of the messages that are fields of a message."""
    package = name.partition("/")[0]
    kinds = [line.split(" ", 1)[0].removesuffix("[]") for line in _DEFINITIONS[name].splitlines()]
    full = [
        kind.replace("/", "/msg/") if "/" in kind else f"{package}/msg/{kind}" for kind in kinds
    ]
    return [kind for kind in dict.fromkeys(full) if kind in _DEFINITIONS]
