"""The client: what is native, and what needs Python's event loop."""

import asyncio
import weakref

from . import _clearway
from ._errors import PlanTimeoutError

# Requests of `plan_async` that are open at a time; each takes one of the planner's places.
_OPEN_ASYNC = 4

# Wake-ups can be lost and planners can die: look so often anyway, seconds.
_NET = 0.1


class Client(_clearway.Client):
    """Client(domain=None, *, wait="hybrid", connect_timeout=0.0)

    Asks the planner of a domain (None: the default domain). Threads can share a client; the
    interpreter is free while it waits. After a fork, the child needs a client of its own.

    wait: "hybrid" spins for 50 microseconds, then sleeps; "event" sleeps; "poll" never sleeps.
    connect_timeout: seconds to wait for a planner that is not there yet.

    Raises NoPlannerError if there is none, and ConnectError if it can't be reached.
    """

    def plan_many(self, scenes, timeout=10.0):
        """Plans several scenes, a few at a time, and returns the replies in the order of the
        scenes. In place of the reply to a request that is refused stands its RefusedError.

        timeout: seconds for each (None: no limit).
        """
        return super().plan_many(list(scenes), timeout)

    async def plan_async(self, scene, timeout=10.0):
        """Plans a scene, as ``plan`` does, while the event loop goes on. Cancelling the task
        cancels the request."""
        loop = asyncio.get_running_loop()
        async with self._places(loop):
            return await self._plan_in(loop, scene, timeout)

    def _places(self, loop):
        """What limits the requests that are open in an event loop; others wait their turn."""
        places = self.__dict__.setdefault("_loops", weakref.WeakKeyDictionary())
        return places.setdefault(loop, asyncio.Semaphore(_OPEN_ASYNC))

    async def _plan_in(self, loop, scene, timeout):
        until = None if timeout is None else loop.time() + timeout
        # Connecting takes milliseconds, which are not the loop's.
        ready = self.is_ready()
        pending = self.start(scene) if ready else await asyncio.to_thread(self.start, scene)
        descriptor = pending.fileno()
        rung = asyncio.Event()
        if descriptor >= 0:
            loop.add_reader(descriptor, rung.set)
        try:
            while True:
                rung.clear()
                reply = pending.poll()
                if reply is not None:
                    return reply
                left = _NET if until is None else min(_NET, until - loop.time())
                if left <= 0:
                    raise PlanTimeoutError(f"no reply within {timeout} s")
                if descriptor < 0:
                    await asyncio.sleep(0)
                    continue
                try:
                    await asyncio.wait_for(rung.wait(), left)
                except TimeoutError:
                    pass
        finally:
            if descriptor >= 0:
                loop.remove_reader(descriptor)
            pending.cancel()

