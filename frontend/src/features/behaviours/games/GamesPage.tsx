import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { type KeyboardEvent, useRef, useState } from "react";
import { Link, useNavigate } from "react-router";

import { catalogueQuery } from "@/games/catalogue";
import type { Title } from "@/api/types";
import { Search } from "@/components/controls/Filters";
import { Empty, Failed, Loading } from "@/components/feedback/States";
import { PageTitle } from "@/components/PageTitle";

import styles from "./GamesPage.module.css";
import { cardAt, foundGames } from "./search";

/** All games that can be taught, with a picture; those played last first. */
export function GamesPage() {
  const { data: games, error, refetch } = useQuery(catalogueQuery);
  const [typed, setTyped] = useState("");
  const navigate = useNavigate();
  if (error && !games)
    return <Failed what={t`The games`} error={error} onRetry={() => void refetch()} />;
  if (!games) return <Loading what={t`the games`} rows={4} height="9rem" />;
  const found = foundGames(games, typed);
  const [first] = found;
  return (
    <>
      <PageTitle>{t`Games · Tril`}</PageTitle>
      <div className={styles.head}>
        <h1>
          <Trans>Games</Trans>
        </h1>
        <form
          role="search"
          onSubmit={(event) => {
            event.preventDefault();
            if (first && typed.trim() !== "") void navigate(pathOf(first));
          }}
        >
          <Search label={t`Find a game`} value={typed} onChange={setTyped} />
        </form>
      </div>
      <p className="visually-hidden" role="status">
        {plural(found.length, { one: "# game", other: "# games" })}
      </p>
      {found.length === 0 ? (
        <Empty level="h2" title={t`No game of this name`}>
          <p>
            <Trans>Type another part of its title.</Trans>
          </p>
        </Empty>
      ) : (
        <Cards games={found} />
      )}
    </>
  );
}

function Cards({ games }: { games: readonly Title[] }) {
  const list = useRef<HTMLUListElement>(null);

  function move(event: KeyboardEvent, index: number) {
    const items = [...(list.current?.children ?? [])] as HTMLElement[];
    const top = items[0]?.offsetTop;
    const columns = items.filter((one) => one.offsetTop === top).length;
    const to = cardAt(index, event.key, columns, items.length);
    if (to === null) return;
    event.preventDefault();
    items[to]?.querySelector<HTMLElement>("a")?.focus();
  }

  return (
    <ul className={styles.games} ref={list}>
      {games.map((game, index) => (
        <li key={game.name} className={styles.card}>
          <Link className={styles.link} to={pathOf(game)} onKeyDown={(event) => move(event, index)}>
            <img
              className={styles.picture}
              src={game.picture_url}
              alt=""
              width={160}
              height={105}
              loading="lazy"
              decoding="async"
            />
            <span className={styles.title}>{game.title}</span>
          </Link>
          {game.n_behaviours > 0 && (
            <span className={styles.count}>
              {plural(game.n_behaviours, { one: "# behaviour", other: "# behaviours" })}
            </span>
          )}
        </li>
      ))}
    </ul>
  );
}

function pathOf({ name }: Title): string {
  return `/games/${encodeURIComponent(name)}`;
}
