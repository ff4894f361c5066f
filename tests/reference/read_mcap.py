#!/usr/bin/env python3
"""Reads a recording with the reference MCAP reader and checks each JSON message by its schema.

    python3 -m venv venv && venv/bin/pip install mcap jsonschema
    venv/bin/python tests/reference/read_mcap.py today.mcap
"""

import collections
import json
import sys

import jsonschema
from mcap.reader import make_reader

counts = collections.Counter()
last = collections.defaultdict(int)
with open(sys.argv[1], "rb") as file:
    reader = make_reader(file, validate_crcs=True)
    for schema, channel, message in reader.iter_messages(log_time_order=False):
        counts[channel.topic] += 1
        if channel.message_encoding != "json":
            continue
        value = json.loads(message.data)
        if schema is None:
            continue
        assert schema.encoding == "jsonschema", schema.encoding
        jsonschema.validate(value, json.loads(schema.data))
        if schema.name == "foxglove.PoseInFrame":
            stamp = value["timestamp"]
            time = stamp["sec"] * 10**9 + stamp["nsec"]
            assert time == message.log_time, (channel.topic, time, message.log_time)
            assert time > last[channel.topic], f"{channel.topic} goes back"
            last[channel.topic] = time
            q = value["pose"]["orientation"]
            norm = sum(part * part for part in q.values())
            assert abs(norm - 1) < 1e-9, q
for topic, count in sorted(counts.items()):
    print(f"{topic}: {count}")
