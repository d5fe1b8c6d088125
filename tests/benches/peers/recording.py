"""What another implementation of MCAP reads in a recording of mrroc.

In: a recording, and the values that an observer of the drives saw in the same run: step, robot, joint, demanded, measured,
with the digits that give each number back. Out: the channels with their counts, and whether every message fits its schema, every value is
the observer's to the bit, times and steps never go back, and the summary counts what is there. Exit status 1 if not.
"""

import collections
import csv
import json
import sys

import jsonschema
from mcap.reader import make_reader


def main(recording, values):
    wrong = []

    def check(holds, what):
        if not holds and len(wrong) < 10:
            wrong.append(what)

    counts, steps, times = collections.Counter(), {}, {}
    images, validators = {}, {}
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
            check(body["step"] >= steps.get(topic, 0), f"{topic}: steps go back at {body['step']}")
            times[topic], steps[topic] = message.log_time, body["step"]
            parts = topic.split("/")
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
    print(f"{compared} values compared with the drives' own to the bit")
    for what in wrong:
        print(f"wrong: {what}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
