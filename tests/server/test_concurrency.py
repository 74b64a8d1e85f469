"""The bound on requests at work, and the queue behind it."""

from __future__ import annotations

import asyncio
from collections import Counter

import pytest
from fastapi import HTTPException

from server.concurrency import ConcurrencyLimit


async def _pass(limit: ConcurrencyLimit, client: str = "browser") -> None:
    async with limit.slot(client):
        pass


def test_requests_work_in_the_order_in_which_they_came() -> None:
    async def run() -> None:
        limit = ConcurrencyLimit(at_once=2, per_client=2, waiting=12, wait_s=60)
        order: list[int] = []
        at_work: set[int] = set()

        async def work(number: int) -> None:
            async with limit.slot("browser"):
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
        limit = ConcurrencyLimit(at_once=1, per_client=1, waiting=1, wait_s=60)
        async with limit.slot("browser"):
            waiting = asyncio.create_task(_pass(limit))
            await asyncio.sleep(0)
            with pytest.raises(HTTPException) as refused:
                await _pass(limit)
            assert refused.value.status_code == 503
            assert int((refused.value.headers or {})["Retry-After"]) > 0
            # Another client's may still wait.
            another = asyncio.create_task(_pass(limit, "another browser"))
            await asyncio.sleep(0)
        await asyncio.gather(waiting, another)
        await _pass(limit)

    asyncio.run(run())


def test_one_that_waits_for_too_long_is_told_to_come_back_and_takes_no_slot() -> None:
    async def run() -> None:
        limit = ConcurrencyLimit(at_once=1, per_client=1, waiting=1, wait_s=0)
        async with limit.slot("browser"):
            with pytest.raises(HTTPException):
                await _pass(limit)
        await _pass(limit)

    asyncio.run(run())


def test_clients_take_turns_and_each_has_its_share_of_the_slots() -> None:
    async def run() -> None:
        limit = ConcurrencyLimit(at_once=2, per_client=1, waiting=60, wait_s=60)
        order: list[str] = []
        at_work: Counter[str] = Counter()

        async def work(client: str) -> None:
            async with limit.slot(client):
                order.append(client)
                at_work[client] += 1
                assert at_work[client] == 1
                await asyncio.sleep(0)
                at_work[client] -= 1

        many = [work("many") for _ in range(20)]
        await asyncio.gather(*many, work("few"), work("few"), work("another"))
        # Those who ask for little do not wait for the twenty that came before them.
        assert order.index("another") <= 4
        assert len(order) - 1 - order[::-1].index("few") <= 6
        assert order.count("many") == 20

    asyncio.run(run())


def test_a_request_that_is_given_up_takes_no_slot() -> None:
    async def run() -> None:
        limit = ConcurrencyLimit(at_once=1, per_client=1, waiting=10, wait_s=60)
        async with limit.slot("browser"):
            given_up = [asyncio.create_task(_pass(limit)) for _ in range(3)]
            stays = asyncio.create_task(_pass(limit))
            await asyncio.sleep(0)
            for task in given_up:
                task.cancel()
        # The slot became free before those who gave up have noticed it.
        await asyncio.wait_for(stays, 1)
        assert all(
            isinstance(found, asyncio.CancelledError)
            for found in await asyncio.gather(*given_up, return_exceptions=True)
        )
        await asyncio.wait_for(_pass(limit), 1)

    asyncio.run(run())
