"""Runs as jobs: put into a durable queue, cancelled, resumed, followed, kept in step.

The run's row in the application's database is the truth. The job queue (DBOS, a database of its
own) only brings a run's id to a worker, at least once; the worker asks the row what to do.
"""

from tril.jobs.delivery import Jobs
from tril.jobs.eta import Estimate, RunEta, estimate
from tril.jobs.queue import APPLICATION, QUEUE, VERSION, WORKFLOW, prepare_queue
from tril.jobs.stages import overall_progress

__all__ = [
    "APPLICATION",
    "QUEUE",
    "VERSION",
    "WORKFLOW",
    "Estimate",
    "Jobs",
    "RunEta",
    "estimate",
    "overall_progress",
    "prepare_queue",
]
