"""What a round trip costs without shared memory: pickled numpy over a Unix-domain socket between two
processes. socket_round_trip.py SCENE.json SAMPLES CALLS prints the median and the 99th percentile,
microseconds; see services/clients/round_trip.sh. Nothing is planned."""

import json
import os
import pickle
import socket
import struct
import sys
import time

import numpy
from clearway._arrays import SAMPLE

_, path, samples, calls = sys.argv
scene = json.load(open(path))
ours, others = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)


def send(end, value):
    text = pickle.dumps(value, protocol=pickle.HIGHEST_PROTOCOL)
    end.sendall(struct.pack("<Q", len(text)) + text)


def receive(end):
    def take(count):
        text = bytearray(count)
        view = memoryview(text)
        while len(view):
            if not (came := end.recv_into(view)):
                raise EOFError
            view = view[came:]
        return text

    return pickle.loads(take(struct.unpack("<Q", take(8))[0]))


if os.fork() == 0:
    ours.close()
    reply = numpy.zeros(int(samples), SAMPLE)
    try:
        while True:
            receive(others)
            send(others, reply)
    except (EOFError, ConnectionError):
        os._exit(0)
others.close()
times = []
for _ in range(int(calls)):
    begin = time.perf_counter()
    send(ours, scene)
    receive(ours)["t"][0]
    times.append(time.perf_counter() - begin)
ours.close()
os.wait()
times.sort()
print(f"{times[len(times) // 2] * 1e6:.1f} {times[len(times) * 99 // 100] * 1e6:.1f}")
