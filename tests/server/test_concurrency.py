"""The bound on requests at work, and the queue behind it."""

from __future__ import annotations

import asyncio

import pytest
from fastapi import HTTPException

from server.concurrency import ConcurrencyLimit


async def _pass(limit: ConcurrencyLimit) -> None:
    async with limit.slot():
        pass


def test_requests_work_in_the_order_in_which_they_came() -> None:
    async def run() -> None:
        limit = ConcurrencyLimit(at_once=2, waiting=10, wait_s=60)
        order: list[int] = []
        at_work: set[int] = set()

        async def work(number: int) -> None:
            async with limit.slot():
                at_work.add(number)
                order.append(number)
                assert len(at_work) <= 2
                await asyncio.sleep(0)
                at_work.remove(number)

        await asyncio.gather(*(work(number) for number in range(12)))
        assert order == list(range(12))

    asyncio.run(run())


def test_more_than_may_wait_are_told_to_come_back() -> None:
    async def run() -> None:
        limit = ConcurrencyLimit(at_once=1, waiting=1, wait_s=60)
        async with limit.slot():
            waiting = asyncio.create_task(_pass(limit))
            await asyncio.sleep(0)
            with pytest.raises(HTTPException) as refused:
                await _pass(limit)
            assert refused.value.status_code == 503
            assert int((refused.value.headers or {})["Retry-After"]) > 0
        await waiting
        await _pass(limit)

    asyncio.run(run())


def test_one_that_waits_for_too_long_is_told_to_come_back_and_takes_no_slot() -> None:
    async def run() -> None:
        limit = ConcurrencyLimit(at_once=1, waiting=1, wait_s=0)
        async with limit.slot():
            with pytest.raises(HTTPException):
                await _pass(limit)
        await _pass(limit)

    asyncio.run(run())
