"""Pages that need no script: whoever is not signed in sees them, in English or German."""

from __future__ import annotations

import secrets
from collections.abc import Collection
from dataclasses import dataclass
from html import escape

from starlette.requests import Request
from starlette.responses import HTMLResponse, Response

MAX_LANGUAGES = 32
"""Most languages of a request that are looked at; browsers name few."""


@dataclass(frozen=True)
class Texts:
    """What small pages say in a language, as HTML; the fields' names say where."""

    language: str
    key: str = "Key, or the whole address"
    sign_in: str = "Sign in"
    wrong_key: str = "This key does not fit"
    wrong_key_why: str = (
        "It is not the key of this server. <code>tril address</code> in a terminal prints the "
        "address that contains the right one."
    )
    signed_out: str = "You are not signed in"
    signed_out_why: str = (
        "Open the address that Tril printed when it started; it contains the key. "
        "<code>tril address</code> in a terminal prints it again. If somebody invited you, ask "
        "them for a link."
    )
    welcome: str = "Welcome to Tril"
    invited_researcher: str = "You are invited to teach and rank here, as a researcher."
    invited_player: str = (
        "You are invited to play a game: <strong>{behaviour}</strong>. Your games are "
        "recorded, and an agent may learn from them."
    )
    present: str = (
        "This browser is signed in as {player} already. If you go on, it is signed in as you "
        "instead."
    )
    name: str = "What is your name?"
    name_missing: str = "Give a name, so that your games can be told from those of others."
    name_refused: str = (
        "The name has a character that can't be seen or changes how others are seen ({character}). "
        "Type the name instead of pasting it."
    )
    name_too_long: str = "A name can have at most 80 characters."
    too_many: str = "There are as many people as this server takes. Ask whoever sent the link."
    begin: str = "Begin"
    over: str = "This invitation is over"
    over_why: str = (
        "It was revoked, has expired, or has let in as many people as it was made for. Ask the "
        "person who sent it to you for a new link. If you have "
        "already used it, you are still signed in, in the browser that you used."
    )
    incomplete: str = "This link is not complete"
    incomplete_why: str = (
        "Part of it is missing, or it belongs to another server. Copy the whole link, or ask the "
        "person who sent it to you for a new one."
    )
    to_tril: str = "To Tril"


_ENGLISH = Texts("en")
_GERMAN = Texts(
    "de",
    key="Schlüssel oder die ganze Adresse",
    sign_in="Anmelden",
    wrong_key="Dieser Schlüssel passt nicht",
    wrong_key_why="Er ist nicht der dieses Servers. <code>tril address</code> in einem Terminal "
    "gibt die Adresse aus, die ihn enthält.",
    signed_out="Du bist nicht angemeldet",
    signed_out_why="Öffne die Adresse, die Tril beim Start ausgegeben hat; sie enthält den "
    "Schlüssel. <code>tril address</code> in einem Terminal gibt sie noch einmal aus. Wenn dich "
    "jemand eingeladen hat, bitte um einen Link.",
    welcome="Willkommen bei Tril",
    invited_researcher="Du bist eingeladen, hier zu lehren und zu ordnen, als forschende Person.",
    invited_player="Du bist eingeladen, ein Spiel zu spielen: <strong>{behaviour}</strong>. "
    "Deine Spiele werden aufgezeichnet, und ein Agent kann von ihnen lernen.",
    present="Dieser Browser ist schon als {player} angemeldet. Wenn du weitermachst, bist danach "
    "du angemeldet.",
    name="Wie heißt du?",
    name_missing="Gib einen Namen an, damit man deine Spiele von denen anderer unterscheiden kann.",
    name_refused="Der Name hat ein Zeichen, das man nicht sieht oder das andere anders aussehen "
    "lässt ({character}). Tippe den Namen, statt ihn einzufügen.",
    name_too_long="Ein Name kann höchstens 80 Zeichen haben.",
    too_many="Mehr Leute nimmt dieser Server nicht auf. Wende dich an die Person, von der du den "
    "Link hast.",
    begin="Los",
    over="Diese Einladung gilt nicht mehr",
    over_why="Sie wurde zurückgezogen, ist abgelaufen oder hat schon so viele hereingelassen, wie "
    "sie sollte. Bitte die Person, die sie dir geschickt hat, um "
    "einen neuen Link. Wenn du schon vorher damit hereingekommen bist, bist du weiterhin "
    "angemeldet, in dem Browser von damals.",
    incomplete="Dieser Link ist nicht vollständig",
    incomplete_why="Ein Teil fehlt, oder er gehört zu einem anderen Server. Kopiere den ganzen "
    "Link, oder bitte die Person, die ihn dir geschickt hat, um einen neuen.",
    to_tril="Zu Tril",
)
_LANGUAGES = {texts.language: texts for texts in (_ENGLISH, _GERMAN)}

# The colours, spaces and the base of text come from the page's own stylesheets.
_STYLE = """
main { display: grid; gap: var(--s4); max-width: 32rem; margin: 12vh auto 2rem; padding: 0 1rem }
.tril { display: flex; align-items: center; gap: .5rem; font-weight: 600 }
.tril img { width: 1.5rem; height: 1.5rem; border-radius: 4px }
form { display: grid; gap: var(--s3); padding: var(--s5); border: 1px solid var(--line);
  border-radius: var(--radius); background: var(--surface) }
label { font-weight: 500 }
input { width: 100%; min-height: 2.75rem; padding: .25rem .75rem;
  border: 1px solid var(--line-strong); border-radius: var(--radius); background: var(--paper) }
.go { display: inline-block; justify-self: start; min-height: 2.75rem; padding: .6rem 1.25rem;
  border: 0; border-radius: var(--radius); background: var(--accent); color: var(--on-accent);
  font-weight: 500; text-decoration: none }
.go:hover { background: var(--accent-strong) }
.wrong { color: var(--bad) }
:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px }
"""
_PAGE = """<!doctype html>
<html lang="{language}">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">{head}
<title>{title} · Tril</title>
<link rel="icon" href="/icon.svg" type="image/svg+xml">
<script src="/theme.js"></script>
{stylesheets}
<style>{style}</style>
<body>
<main>
<p class="tril"><img src="/icon.svg" alt="">Tril</p>
<h1>{title}</h1>
{content}
</main>
"""


class SmallPages:
    """Makes small pages in the language of a request.

    Args:
        request: Names the browser's languages.
        stylesheets: Paths of the page's own stylesheets.

    Attributes:
        texts: Texts of the pages.
    """

    def __init__(self, request: Request, stylesheets: Collection[str]) -> None:
        self.texts = _LANGUAGES[language_of(request.headers.get("accept-language", ""))]
        self._stylesheets = stylesheets

    def key_page(self, title: str, text: str, head: str = "") -> Response:
        """Return a page (401) that asks for the key; its texts are HTML."""
        form = f"""<form action="/">
<label for="key">{self.texts.key}</label>
<input id="key" name="token" type="password" autocomplete="off" required autofocus>
<button class="go">{self.texts.sign_in}</button>
</form>"""
        return self.page(401, title, f"<p>{text}</p>{form}", head)

    def name_page(
        self,
        path: str,
        invitation: str,
        behaviour: str | None,
        player: str | None,
        wrong: str | None,
    ) -> Response:
        """Return the page that asks somebody who is invited for a name.

        Args:
            path: Where the name is sent to.
            invitation: Signed secret of the invitation.
            behaviour: Behaviour of the invitation; None for a researcher.
            player: Player signed in with this browser; None for nobody.
            wrong: Error of the name entered before, as HTML; None if there is none.
        """
        texts = self.texts
        invited = texts.invited_researcher
        if behaviour is not None:
            invited = texts.invited_player.format(behaviour=escape(behaviour))
        if player is not None:
            invited += f"</p><p>{texts.present.format(player=escape(player))}"
        described, why = ("", "")
        if wrong is not None:
            described = 'aria-invalid="true" aria-describedby="why"'
            why = f'\n<p class="wrong" id="why">{wrong}</p>'
        return self.page(
            200,
            texts.welcome,
            f"""<p>{invited}</p>
<form action="{path}" method="post">
<label for="name">{texts.name}</label>
<input id="name" name="name" maxlength="80" autocomplete="nickname" required autofocus
  {described}>{why}
<input type="hidden" name="invitation" value="{escape(invitation)}">
<input type="hidden" name="form" value="{secrets.token_urlsafe(16)}">
<button class="go">{texts.begin}</button>
</form>""",
        )

    def no_invitation(self, is_over: bool, is_signed_in: bool) -> Response:
        """Return the page (404) of a link that lets nobody in."""
        texts = self.texts
        title, why = texts.incomplete, texts.incomplete_why
        if is_over:
            title, why = texts.over, texts.over_why
        go = f'<a class="go" href="/">{texts.to_tril}</a>' if is_signed_in else ""
        return self.page(404, title, f"<p>{why}</p>{go}")

    def page(self, status: int, title: str, content: str, head: str = "") -> Response:
        """Return a page; title, content and head are HTML."""
        links = (f'<link rel="stylesheet" href="{escape(path)}">' for path in self._stylesheets)
        text = _PAGE.format(
            language=self.texts.language,
            head=head,
            title=title,
            stylesheets="\n".join(links),
            style=_STYLE,
            content=content,
        )
        headers = {"Cache-Control": "no-store", "Vary": "Accept-Language"}
        return HTMLResponse(text, status, headers=headers)


def language_of(accepted: str) -> str:
    """Return the language that a browser's Accept-Language prefers of those there are."""
    accepted_languages = []
    for part in accepted.split(",", MAX_LANGUAGES)[:MAX_LANGUAGES]:
        name, _, quality = part.partition(";")
        language = name.strip().lower().partition("-")[0]
        try:
            weight = float(quality.strip().removeprefix("q=")) if quality else 1.0
        except ValueError:
            continue
        if language in _LANGUAGES and weight > 0:
            accepted_languages.append((weight, language))
    # The first of equal ones.
    return max(accepted_languages, key=lambda weighted: weighted[0], default=(1.0, "en"))[1]
