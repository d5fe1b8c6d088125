"""Writes messages.json: messages as rosbags (0.11.9, PyPI), an implementation of its own of ROS 2's CDR, serialises them, in both byte orders.

`python3 messages.py > messages.json`. Types of `common.msg` have the fields that rosbags has for Jazzy; numbers are those of a generator whose seed is the type's name.
"""

import json
import random
import sys
from pathlib import Path

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.interfaces import Nodetype

OWN = {
    "own_msgs/msg/Inner": "uint8 a\nfloat64 b\nstring c\n",
    "own_msgs/msg/Everything": (
        "bool on\nint8 i8\nuint8 u8\nint16 i16\nuint16 u16\nint32 i32\nuint32 u32\nint64 i64\nuint64 u64\nfloat32 f32\nfloat64 f64\n"
        "byte b\nchar c\nstring text\nstring<=9 short\nInner inner\nInner[2] two\nInner[] many\nInner[<=4] few\nbool[3] flags\n"
        "int16[5] odd\nfloat64[] none\nuint8[] bytes\nfloat64[] numbers\nstring[] texts\nstring<=4[2] pair\nuint8 tail\nfloat64 last\n"
    ),
    "own_msgs/msg/Nothing": "",
}

store = get_typestore(Stores.ROS2_JAZZY)
for name, text in OWN.items():
    store.register(get_types_from_msg(text, name))


def base(kind):
    """A number of a kind, which an f64 has exactly."""
    match kind:
        case "bool":
            return random.random() < 0.5
        case "float64":
            return random.uniform(-1e3, 1e3)
        case "float32":
            return float(np.float32(random.uniform(-1e3, 1e3)))
        case "byte" | "char":
            return random.randrange(128)  # rosbags has a sign where ROS 2 has none
    bits = int(kind.removeprefix("uint").removeprefix("int"))
    bits = min(bits, 53)
    return random.randrange(2**bits) if kind.startswith("u") else random.randrange(-(2 ** (bits - 1)), 2 ** (bits - 1))


def value(kind, desc, path, told):
    """A value of a type, whose numbers are told by their paths."""
    match kind:
        case Nodetype.BASE if desc[0] == "string":
            return "".join(random.choices("abcxyz", k=random.randrange(min(desc[1] or 9, 9))))
        case Nodetype.BASE:
            told[path] = base(desc[0])
            return told[path]
        case Nodetype.NAME:
            return message(desc, f"{path}.", told)
    (of, what), count = desc
    if kind == Nodetype.SEQUENCE:
        count = 0 if path.endswith("none") else random.randrange(1, (count or 6) + 1)
    items = [value(of, what, f"{path}[{i}]", told) for i in range(count)]
    if of == Nodetype.BASE and what[0] not in ("string", "bool"):
        return np.array(items, dtype={"byte": "uint8", "char": "uint8"}.get(what[0], what[0]))
    return np.array(items, dtype=bool) if of == Nodetype.BASE and what[0] == "bool" else items


def message(name, path, told):
    fields = {field: value(*of, f"{path}{field}", told) for field, of in store.fielddefs[name][1]}
    return store.types[name](**fields)


common = (Path(__file__).parents[1] / "src/definitions/common.msg").read_text()
names = [line.removeprefix("MSG: ") for line in common.splitlines() if line.startswith("MSG: ")]
messages = []
for name in names + list(OWN):
    # One more type changes no message of another.
    random.seed(f"39 {name}")
    told = {}
    made = message(name, "", told)
    order = {key: bytes(store.serialize_cdr(made, name, little_endian=little)).hex() for key, little in [("little", True), ("big", False)]}
    messages.append({"type": name, **order, "values": told})
text = json.dumps({"own": OWN, "messages": messages}, separators=(",", ":"))
sys.stdout.write(text.replace('{"type"', '\n{"type"') + "\n")
