"""The transforms of a cell, as Cyclone DDS hears them: a DDS implementation that is neither ours nor rclpy's.

In: the file to write to, and for how long [s]. Out: a line of JSON for each transform: whether it is static, its stamp [ns], parent, child, and
seven numbers, position and quaternion x, y, z, w.
"""

import json
import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float64, int32, sequence, uint32
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class Transform(IdlStruct, typename="geometry_msgs::msg::dds_::Transform_"):
    translation: Vector3
    rotation: Quaternion


@dataclass
class TransformStamped(IdlStruct, typename="geometry_msgs::msg::dds_::TransformStamped_"):
    header: Header
    child_frame_id: str
    transform: Transform


@dataclass
class TFMessage(IdlStruct, typename="tf2_msgs::msg::dds_::TFMessage_"):
    transforms: sequence[TransformStamped]


def reader(participant, name, durability):
    qos = Qos(Policy.Reliability.Reliable(duration(seconds=1)), durability, Policy.History.KeepLast(1000))
    return DataReader(participant, Topic(participant, name, TFMessage, qos=qos), qos=qos)


def main(file, domain, seconds):
    participant = DomainParticipant(int(domain))
    readers = [
        (False, reader(participant, "rt/tf", Policy.Durability.Volatile)),
        (True, reader(participant, "rt/tf_static", Policy.Durability.TransientLocal)),
    ]
    print("ready", flush=True)
    until = time.monotonic() + float(seconds)
    with open(file, "w") as lines:
        while time.monotonic() < until:
            for is_static, one in readers:
                for message in one.take(N=100):
                    for each in message.transforms:
                        stamp = each.header.stamp.sec * 10**9 + each.header.stamp.nanosec
                        p, q = each.transform.translation, each.transform.rotation
                        numbers = [p.x, p.y, p.z, q.x, q.y, q.z, q.w]
                        line = [is_static, stamp, each.header.frame_id, each.child_frame_id, numbers]
                        print(json.dumps(line), file=lines)
            time.sleep(0.005)


main(*sys.argv[1:])
