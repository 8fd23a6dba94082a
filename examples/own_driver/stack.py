"""A driver in a process of its own: `cortexc crossing.scn --ego "process:python3 stack.py"`."""

import json
import os
from itertools import count

import numpy as np
from planner import drive

read = os.fdopen(int(os.environ["CORTEXC_READ"]), "rb")
write = os.fdopen(int(os.environ["CORTEXC_WRITE"]), "wb")

header = json.loads(read.readline())
n, wide = header["lanes"], len(header["observations"])
write.write(b'{"version": 1}\n')
write.flush()

QUESTION = np.dtype(
    [
        ("number", "<i8"),
        ("times", "<f8", n),
        ("keys", "<i8", (n, 6)),
        ("fresh", "u1", n),
        ("asked", "u1", n),
        ("observations", "<f8", (n, wide)),
    ]
)
for _ in count():
    message = read.read(QUESTION.itemsize)
    if len(message) < QUESTION.itemsize:
        break
    question = np.frombuffer(message, QUESTION)[0]
    write.write(drive(question["observations"]).astype("<f8").tobytes())
    write.flush()
