"""An engine that flies in this process, for tests that are not about processes: a pool takes seconds to start."""

from __future__ import annotations

import itertools
from typing import Any

from uavftc.jobs.campaign.evaluate import evaluate, prepare


class InProcess:
    """Stands for what `uavftc.jobs.campaign.engine.engine_of` returns: flights end in another order than given."""

    def __init__(self, plan: Any, *, timeout_s: float, workers: int, cluster: str | None = None) -> None:
        self._workers = workers
        prepare(plan)

    def __enter__(self):
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def fly(self, jobs):
        while ahead := list(itertools.islice(jobs, 4 * self._workers)):
            for job in reversed(ahead):
                yield None
                yield evaluate(job)
