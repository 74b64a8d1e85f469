"""The image is built by make's own steps, and the compose file says what it should."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from tril.settings import Settings

ROOT = Path(__file__).resolve().parents[2]
SERVICES = ("server", "worker", "inference")


@pytest.fixture(scope="module")
def dockerfile() -> list[str]:
    """Return the Dockerfile's instructions, one a line."""
    text = (ROOT / "Dockerfile").read_text().replace("\\\n", " ")
    return [line for line in text.splitlines() if line.strip() and not line.startswith("#")]


@pytest.fixture(scope="module")
def compose() -> dict[str, Any]:
    """Return the compose file with its merge keys resolved."""
    document: dict[str, Any] = yaml.safe_load((ROOT / "docker-compose.yml").read_text())
    return document


def targets_of_run() -> set[str]:
    """Return the targets that `make run` goes through."""
    rule = re.search(r"^run: ([a-z -]+?) ##", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert rule is not None
    return set(rule[1].split())


def test_every_run_step_is_a_target_that_make_run_goes_through(dockerfile: list[str]) -> None:
    steps = [line.removeprefix("RUN ") for line in dockerfile if line.startswith("RUN ")]
    assert set(steps) == {f"make {target}" for target in targets_of_run()}


def test_every_copied_file_is_there_and_reaches_the_build(dockerfile: list[str]) -> None:
    ignore = (ROOT / ".dockerignore").read_text().splitlines()
    sources = set()
    for line in dockerfile:
        if line.startswith("COPY ") and "--from=" not in line:
            sources |= set(line.split()[1:-1])
    for source in sources:
        assert (ROOT / source).exists(), f"the Dockerfile copies {source}, which is not there"
        assert f"!{source.split('/')[0]}" in ignore, f".dockerignore keeps {source} from the build"


def test_the_whole_project_is_in_the_image(dockerfile: list[str]) -> None:
    for package in ("tril", "server", "trainer", "cli", "migrations"):
        assert f"COPY {package} {package}" in dockerfile


def test_the_image_runs_as_an_ordinary_user_who_owns_the_data_folder(
    dockerfile: list[str],
) -> None:
    last_stage = dockerfile[max(i for i, line in enumerate(dockerfile) if "FROM " in line) :]
    (user,) = [line.split()[1] for line in last_stage if line.startswith("USER ")]
    assert re.fullmatch(r"[1-9]\d*:[1-9]\d*", user)
    assert f"COPY --from=build --chown={user} /data /data" in last_stage
    assert "VOLUME /data" in last_stage
    assert any("TRIL_DATA=/data" in line and "TRIL_HOST=0.0.0.0" in line for line in last_stage)


@pytest.mark.parametrize("name", SERVICES)
def test_every_service_is_the_same_image_on_the_named_volume(
    compose: dict[str, Any], name: str
) -> None:
    service = compose["services"][name]
    assert service["image"] == "tril"
    assert service["volumes"] == ["data:/data"]
    assert "data" in compose["volumes"]
    assert service["healthcheck"]["test"] == ["CMD", "tril", "health", name]
    assert service["init"] is True


def test_only_the_server_is_published_and_only_on_this_machine(compose: dict[str, Any]) -> None:
    services = compose["services"]
    port = "${TRIL_PORT:-8000}"  # the same inside and outside, so that `tril address` is right
    assert services["server"]["ports"] == [f"127.0.0.1:{port}:{port}"]
    assert not any("ports" in services[name] for name in ("worker", "inference"))


def test_what_learns_waits_until_the_server_has_migrated(compose: dict[str, Any]) -> None:
    services = compose["services"]
    assert services["server"]["command"][-1].startswith("tril migrate && exec tril serve")
    for name in ("worker", "inference"):
        assert services[name]["depends_on"] == {"server": {"condition": "service_healthy"}}
        assert services[name]["command"] == ["tril", name]


@pytest.mark.parametrize("name", SERVICES)
def test_every_setting_reaches_every_service(
    compose: dict[str, Any], dockerfile: list[str], name: str
) -> None:
    environment = compose["services"][name]["environment"]
    passed_on = {variable for variable, value in environment.items() if value is None}
    of_the_image = set(re.findall(r"\b(TRIL_[A-Z_]+)=", "\n".join(dockerfile)))
    settings = {f"TRIL_{field.upper()}" for field in Settings.model_fields}
    of_a_joining_worker = {
        "TRIL_WORKER_KEY",
        "TRIL_WORKER_KEY_FILE",
    }  # these services join no server
    own = {"TRIL_DATA", "TRIL_HOST", "TRIL_PLAIN_HTTP"}
    assert passed_on == settings - own - of_a_joining_worker
    # Safe since the port is published to this machine alone.
    assert environment["TRIL_PLAIN_HTTP"] == "${TRIL_PLAIN_HTTP-1}"
    assert of_the_image == {"TRIL_DATA", "TRIL_HOST"}


def test_every_command_of_the_containers_exists(dockerfile: list[str]) -> None:
    from cli.main import COMMANDS

    compose_text = (ROOT / "docker-compose.yml").read_text()
    commands = [line for line in dockerfile if line.startswith("CMD ")] + [compose_text]
    named = set(re.findall(r'"tril", "([a-z]+)"|\btril ([a-z]+)', "\n".join(commands)))
    used = {first or second for first, second in named}
    assert used == {"serve", "worker", "inference", "migrate", "health", "address"}
    assert used <= COMMANDS.keys()
