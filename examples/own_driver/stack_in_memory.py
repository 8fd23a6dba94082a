"""`stack.py` for questions about many scenes: they are not sent, but stand in memory that both processes see."""

import json
import mmap
import os

import numpy as np
from planner import drive

read = os.fdopen(int(os.environ["CORTEXC_READ"]), "rb")
write = os.fdopen(int(os.environ["CORTEXC_WRITE"]), "wb", buffering=0)

header = json.loads(read.readline())
lanes, starts = header["lanes"], header["memory"]
memory = mmap.mmap(int(os.environ["CORTEXC_MEMORY"]), starts["size"])
seen = np.ndarray((lanes, len(header["observations"])), "<f8", memory, starts["observations"])
done = np.ndarray((lanes, len(header["actions"])), "<f8", memory, starts["actions"])
write.write(b'{"version": 1, "memory": true}\n')

while len(read.read(8)) == 8:
    done[:] = drive(seen)
    write.write(b"!")
