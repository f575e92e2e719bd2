"""Maps as free space."""

import numpy

from . import _clearway


def free_space_of_grid(cells, resolution, origin=(0.0, 0.0, 0.0), *, free_most=25, unknown="occupied"):
    """The ``free_space`` of ``drive`` scenes on an occupancy grid, with its name. What is not free
    is solid, and the border of the grid a wall.

    cells: rows and columns of percentages from the least y and x on, as in ROS'
        nav_msgs/OccupancyGrid: an array of two dimensions, integers. What is not from 0 to 100 (-1)
        is unknown.
    resolution: the side of a cell, metres.
    origin: x and y (metres) of the outer corner of the first cell, and the yaw (radians) by which
        the grid is turned about it.
    free_most: cells from 0 to this percentage are free, up to 99.
    unknown: "occupied" or "free": what unknown cells count as.

    Raises ValueError if this is no map. To plan often on the same map, send it once, and after that
    its name alone, ``{"named": free_space["named"]}``; ``UnknownFreeSpace`` is raised when the
    planner has to be sent the whole once more.
    """
    cells = numpy.asarray(cells)
    if cells.ndim != 2 or cells.dtype.kind not in "iu":
        raise ValueError(
            f"cells must be integers in two dimensions, not {cells.dtype} in {cells.ndim}"
        )
    if cells.dtype.itemsize > 1 or cells.dtype.kind == "u":
        cells = numpy.where((cells < 0) | (cells > 100), -1, cells).astype(numpy.int8)
    rows, columns = cells.shape
    return _clearway.free_space_of_cells(
        cells.tobytes(), (columns, rows), resolution, tuple(origin), free_most, unknown
    )
