"""What another implementation of MCAP reads in a recording of mrroc.

In: a recording, and the values that an observer of the drives saw in the same run: step, robot, joint, demanded, measured,
with the digits that give each number back. Out: the channels with their counts, and whether every message fits its schema, every value is
the observer's to the bit, times and steps never go back, the date is that of the run, and the summary counts what is there.
Messages of Foxglove's schemas are parsed by Foxglove's own, which know no other fields; frames are compared with the
recorded tool poses. Exit status 1 if not.
"""

import collections
import csv
import json
import math
import sys
import time

import jsonschema
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.json_format import ParseDict
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader

FOXGLOVE = {"foxglove.FrameTransforms": FrameTransforms, "foxglove.SceneUpdate": SceneUpdate}


def protobuf_of(body):
    """The same JSON with times and durations as protocol buffers write them."""
    if isinstance(body, dict):
        if body.keys() == {"sec", "nsec"}:
            return {"seconds": body["sec"], "nanos": body["nsec"]}
        return {key: protobuf_of(value) for key, value in body.items()}
    return [protobuf_of(value) for value in body] if isinstance(body, list) else body


def parsed(schema, body):
    """The message by Foxglove's schema; a field that it does not know is an error."""
    def texts(value, name=""):
        if isinstance(value, dict):
            if value.keys() == {"seconds", "nanos"}:
                if name == "lifetime":
                    return f"{value['seconds']}.{value['nanos']:09}s"
                date = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(value["seconds"]))
                return f"{date}.{value['nanos']:09}Z"
            return {key: texts(item, key) for key, item in value.items()}
        return [texts(item) for item in value] if isinstance(value, list) else value

    return ParseDict(texts(protobuf_of(body)), FOXGLOVE[schema]())


def product(a, b):
    """Of two poses, each a position and a quaternion x, y, z, w."""
    (p, q), (r, s) = a, b
    (x, y, z, w), (X, Y, Z, W) = q, s
    turned = product_of_quaternions(product_of_quaternions(q, (*r, 0.0)), (-x, -y, -z, w))[:3]
    return tuple(u + v for u, v in zip(p, turned)), product_of_quaternions(q, s)


def product_of_quaternions(a, b):
    (x, y, z, w), (X, Y, Z, W) = a, b
    return (w * X + x * W + y * Z - z * Y, w * Y - x * Z + y * W + z * X,
            w * Z + x * Y - y * X + z * W, w * W - x * X - y * Y - z * Z)


def main(recording, values):
    wrong = []

    def check(holds, what):
        if not holds and len(wrong) < 10:
            wrong.append(what)

    counts, steps, times = collections.Counter(), {}, {}
    images, validators, poses, drawn, dates = {}, {}, {}, [], []
    with open(recording, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        header, summary = reader.get_header(), reader.get_summary()
        about = {metadata.name: metadata.metadata for metadata in reader.iter_metadata()}
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            topic = channel.topic
            counts[topic] += 1
            check(schema.encoding == "jsonschema" and channel.message_encoding == "json", f"{topic}: its encoding")
            if topic not in validators:
                description = json.loads(schema.data)
                jsonschema.Draft202012Validator.check_schema(description)
                validators[topic] = jsonschema.Draft202012Validator(description)
            body = json.loads(message.data)
            error = next(validators[topic].iter_errors(body), None)
            check(error is None, f"{topic}: {error and error.message}")
            check(message.sequence == counts[topic], f"{topic}: sequence {message.sequence} is {counts[topic]}")
            check(message.log_time >= times.get(topic, 0), f"{topic}: time goes back at {message.log_time} ns")
            times[topic] = message.log_time
            dates.append(message.log_time)
            if schema.name in FOXGLOVE:
                try:
                    drawn.append((message.log_time, parsed(schema.name, body)))
                except Exception as error:
                    check(False, f"{topic}: {error}")
                continue
            check(body["step"] >= steps.get(topic, 0), f"{topic}: steps go back at {body['step']}")
            steps[topic] = body["step"]
            parts = topic.split("/")
            if len(parts) == 3 and parts[1] == "robots":
                poses[parts[2], message.log_time] = body["measured"]["pose"]
            if len(parts) == 3 and parts[1] == "robots":
                images[parts[2], body["step"]] = body

    compared = 0
    with open(values, newline="") as file:
        for step, robot, joint, demanded, measured in csv.reader(file):
            image = images.get((robot, int(step)))
            check(image is not None, f"{robot}: no image of step {step}")
            if image:
                found = image["demanded"]["joints"][int(joint)], image["measured"]["joints"][int(joint)]
                check(found == (float(demanded), float(measured)), f"{robot} step {step} joint {joint}: {found}")
                compared += 2

    frames = solids = 0
    origins = {}
    for date, picture in drawn:
        if isinstance(picture, FrameTransforms):
            at = {"world": ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))}
            for one in picture.transforms:
                v, r = one.translation, one.rotation
                check(one.timestamp.ToNanoseconds() == date, f"{one.child_frame_id}: its time")
                at[one.child_frame_id] = product(at[one.parent_frame_id], ((v.x, v.y, v.z), (r.x, r.y, r.z, r.w)))
            tool = next(name for name in at if name.endswith("/tool"))
            pose = poses[tool.split("/")[0], date]
            p, q = ([pose[part][name] for name in names] for part, names in (("position", "xyz"), ("orientation", "xyzw")))
            # Each of the frames on the way is rounded to a millionth.
            near = max(abs(a - b) for a, b in zip(at[tool][0], p)) < 3e-5
            sign = 1 if sum(a * b for a, b in zip(at[tool][1], q)) > 0 else -1
            turned = max(abs(a - sign * b) for a, b in zip(at[tool][1], q)) < 3e-5
            check(near and turned, f"{tool} at {date} ns: {at[tool]}, recorded {p} {q}")
            frames += len(picture.transforms)
            origins[tool.split("/")[0], date] = [p for p, _ in at.values()]
        else:
            for entity in picture.entities:
                check(entity.timestamp.ToNanoseconds() == date, f"{entity.id}: its time")
                # The links are between joints: three cylinders of an IRp-6 end where frames begin.
                ends = []
                for link in entity.cylinders:
                    p, r, half = link.pose.position, link.pose.orientation, link.size.z / 2
                    pose = ((p.x, p.y, p.z), (r.x, r.y, r.z, r.w))
                    ends += [product(pose, ((0, 0, way), (0, 0, 0, 1)))[0] for way in (-half, half)]
                near = [min(math.dist(end, origin) for origin in origins[entity.id, date]) < 1e-4 for end in ends]
                check(entity.frame_id == "world" and near.count(True) >= 6, f"{entity.id} at {date} ns: links {ends}")
                solids += len(entity.cylinders) + len(entity.spheres) + len(entity.cubes)
    check(frames > 0 and solids > 0, "nothing is drawn")
    start, now = int(about["mrroc.start"]["start_ns"]), time.time_ns()
    check(0 <= now - start < 3600e9, f"it started at {start} ns, now it is {now} ns")
    check(min(dates) >= start, "a message from before the start")
    with open(recording, "rb") as file:
        chunks = [record for record in StreamReader(file, emit_chunks=True).records if type(record).__name__ == "Chunk"]
    check(all(chunk.compression == "lz4" for chunk in chunks), "a chunk that is not compressed by lz4")
    packed, whole = (sum(sizes) for sizes in zip(*((len(c.data), c.uncompressed_size) for c in chunks)))
    statistics = summary.statistics
    check(header.profile == "mrroc", f"profile {header.profile}")
    check(statistics.message_count == sum(counts.values()), "the summary's count of messages")
    check(int(about["mrroc.end"]["messages"]) == sum(counts.values()), "the metadata's count of messages")
    check(int(about["mrroc.end"]["dropped"]) == 0, "messages were dropped")
    check(compared > 0, "no value was compared")
    for topic, count in sorted(counts.items()):
        schema = next(summary.schemas[c.schema_id].name for c in summary.channels.values() if c.topic == topic)
        print(f"{topic:<32}{schema:<24}{count:>8}")
    print(f"{sum(counts.values())} messages in {statistics.chunk_count} chunks, checked against their schemas")
    print(f"{whole} bytes in chunks of {packed} bytes, {whole / packed:.1f} times as many")
    print(f"{frames} frames and {solids} solids read by Foxglove's own schemas, tools where they are recorded")
    print(f"{compared} values compared with the drives' own to the bit")
    for what in wrong:
        print(f"wrong: {what}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
