"""``tril people`` and ``tril audit``: who gets in, and what they did."""

from __future__ import annotations

from typing import Annotated
from urllib.parse import urlsplit

import typer

from cli.commands.services import page_url
from cli.output import JsonOption, console, errors, print_json
from cli.workspace import Workspace, find_behaviour, open_workspace
from server.web.security import invitation_link, load_secrets
from tril.addresses import is_loopback
from tril.errors import Invalid
from tril.store import audit as log
from tril.store import players
from tril.store.access import credentials, invitations, roles
from tril.store.models import AuditRow, CredentialKind, Role

app = typer.Typer(help="Say who gets in.", no_args_is_help=True)


@app.command()
def invite(
    name: Annotated[str, typer.Argument(help="Whom the link is for, to tell it from others.")],
    behaviour: Annotated[
        str | None, typer.Option(help="What they may play: a behaviour's short name or id.")
    ] = None,
    researcher: Annotated[bool, typer.Option(help="Let them in as researchers instead.")] = False,
    uses: Annotated[
        int,
        typer.Option(min=1, max=invitations.MAX_USES, help="How many people the link lets in."),
    ] = invitations.DEFAULT_USES,
    days: Annotated[
        int,
        typer.Option(min=1, max=invitations.MAX_DAYS, help="How many days it lets people in."),
    ] = invitations.DEFAULT_DAYS,
    address: Annotated[
        str | None,
        typer.Option(
            metavar="URL",
            help="Where others reach the server, such as https://tril.example, if that is not the"
            " address that `tril address` prints.",
        ),
    ] = None,
) -> None:
    """Make a link that lets people in, and print it; it is not shown again."""
    if researcher == (behaviour is not None):
        raise typer.BadParameter("Give either --behaviour or --researcher.")
    if address is not None:
        address = _checked(address)
    role = Role.RESEARCHER if researcher else Role.PARTICIPANT
    with open_workspace() as workspace:
        with workspace.database.writing() as session:
            behaviour_id = None if behaviour is None else find_behaviour(session, behaviour).id
            _, secret = invitations.make(
                session, name, role, behaviour_id, by_player_id=None, max_uses=uses, days=days
            )
        settings = workspace.settings
        url = address or page_url(settings)
        typer.echo(invitation_link(settings, url, secret))
    if is_loopback(urlsplit(url).hostname or ""):
        errors.print(
            "This link works on this machine alone. Where others reach the server by another"
            " address, put that in its place, or give it with --address."
        )


def _checked(address: str) -> str:
    parts = urlsplit(address)
    if parts.scheme not in {"http", "https"} or not parts.hostname or parts.query or parts.fragment:
        raise typer.BadParameter("Expected an address such as https://tril.example.")
    return address


@app.command("list")
def list_access(as_json: JsonOption = False) -> None:
    """List the people who were let in, their browsers, the invitations and the keys."""
    with open_workspace() as workspace, workspace.database.reading() as session:
        names = players.names(session)
        rows: list[dict[str, object]] = [
            {"what": "person", "id": person.id, "name": person.name, "role": str(person.role)}
            for person in roles.people(session)
        ]
        rows += [
            {
                "what": str(kind),
                "id": row.id,
                "name": row.name,
                "person": names.get(row.player_id),
                "seen": row.seen_at,
            }
            for kind in CredentialKind
            for row in credentials.listing(session, kind)
        ]
        rows += [
            {
                "what": "invitation",
                "id": row.id,
                "name": row.name,
                "used": row.n_used,
                "uses": row.max_uses,
                "until": row.expires_at,
            }
            for row in invitations.listing(session)
        ]
    for row in rows:
        if as_json:
            print_json(row)
        else:
            details = [f"{key} {value}" for key, value in row.items() if value is not None][1:]
            console.print(f"{row['what']:>10}  {', '.join(details)}")


@app.command()
def revoke(
    what: Annotated[str, typer.Argument(help="browser, invitation or key")],
    number: Annotated[int, typer.Argument(help="Its id, as `tril people list` prints it.")],
) -> None:
    """Sign a browser out, or revoke an invitation or a key; it takes effect within seconds."""
    with open_workspace() as workspace, workspace.database.writing() as session:
        if what == "invitation":
            invitations.revoke(session, number, by_player_id=None)
        elif what in set(CredentialKind):
            credentials.end(session, CredentialKind(what), number, by_player_id=None)
        else:
            raise Invalid(f"Say browser, invitation or key, not {what!r}.")


@app.command()
def role(
    person: Annotated[int, typer.Argument(help="Their id, as `tril people list` prints it.")],
    role: Annotated[str, typer.Argument(help="researcher or participant")],
    behaviour: Annotated[
        str | None,
        typer.Option(help="What a participant may play besides: a behaviour's short name or id."),
    ] = None,
) -> None:
    """Make somebody a researcher or a participant; it takes effect within seconds."""
    if role not in {Role.RESEARCHER, Role.PARTICIPANT}:
        raise typer.BadParameter(f"Say researcher or participant, not {role!r}.")
    with open_workspace() as workspace, workspace.database.writing() as session:
        behaviour_id = None if behaviour is None else find_behaviour(session, behaviour).id
        roles.change(session, person, Role(role), behaviour_id, by_player_id=None)


@app.command()
def key(
    name: Annotated[str, typer.Argument(help="What it is for.")],
    owner: Annotated[bool, typer.Option(help="Let it do everything.")] = False,
    worker: Annotated[
        bool, typer.Option(help="Let it do nothing but start workers on other machines.")
    ] = False,
) -> None:
    """Make a key for scripts, by default with a researcher's rights, and print it once."""
    if owner and worker:
        raise typer.BadParameter("Give either --owner or --worker.")
    role = Role.OWNER if owner else Role.WORKER if worker else Role.RESEARCHER
    with open_workspace() as workspace:
        with workspace.database.writing() as session:
            person = players.owner(session)
            _, secret = credentials.make_key(session, person.id, name, role)
        typer.echo(load_secrets(workspace.settings.token_file).signed(secret))


def audit(
    limit: Annotated[int, typer.Option(min=1, max=100_000, help="How many entries.")] = 50,
    before: Annotated[int | None, typer.Option(help="Only entries older than this id.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Print who did what, the newest first."""
    with open_workspace() as workspace:
        _print_entries(workspace, before, limit, as_json)


def _print_entries(workspace: Workspace, before: int | None, limit: int, as_json: bool) -> None:
    with workspace.database.reading() as session:
        entries = log.page(session, before, limit)
    for entry in entries:
        player = entry.player_name
        if as_json:
            print_json({**_facts(entry), "player": player})
        else:
            details = ", ".join(f"{name} {value}" for name, value in entry.details.items())
            line = f"{entry.id:>6}  {entry.at:%Y-%m-%d %H:%M:%S}  {player or 'terminal'}"
            console.print(f"{line} {entry.action} {entry.subject} {details}".rstrip())


def _facts(entry: AuditRow) -> dict[str, object]:
    return {
        "id": entry.id,
        "at": entry.at.isoformat(),
        "action": entry.action,
        "player_id": entry.player_id,
        "subject": entry.subject,
        "details": entry.details,
    }
