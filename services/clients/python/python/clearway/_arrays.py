"""Samples as numpy arrays."""

import numpy

#: A sample: seconds, metres, radians, metres per second, radians per second.
SAMPLE = numpy.dtype(
    [
        ("t", "<f8"),
        ("position", "<f8", (3,)),
        ("heading", "<f8"),
        ("velocity", "<f8", (3,)),
        ("yaw_rate", "<f8"),
    ]
)


def array(block):
    """The samples of a block where they lie; the array keeps them there."""
    return numpy.frombuffer(block, dtype=SAMPLE)


def join(blocks):
    """All samples: the only block as it is, several as a copy."""
    if len(blocks) == 1:
        return blocks[0]
    samples = numpy.concatenate(blocks) if blocks else numpy.empty(0, dtype=SAMPLE)
    samples.flags.writeable = False
    return samples
