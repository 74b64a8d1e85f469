"""Runs as jobs: put into a durable queue, cancelled, resumed, kept in step.

The run's row in the application's database is the truth. The job queue (DBOS, a database of its
own) only brings a run's id to a worker, at least once; the worker asks the row what to do.
"""

from tril.jobs.delivery import Jobs
from tril.jobs.eta import CostEstimate, RunEta, SteadyRemaining, estimate, overall_progress
from tril.jobs.queue import QUEUES, WORKFLOW, executor_config, prepare_queue

__all__ = [
    "QUEUES",
    "WORKFLOW",
    "CostEstimate",
    "Jobs",
    "RunEta",
    "SteadyRemaining",
    "estimate",
    "executor_config",
    "overall_progress",
    "prepare_queue",
]
