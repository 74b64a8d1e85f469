import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { useState } from "react";
import { Link } from "react-router";

import { behavioursQuery } from "@/api/behaviours";
import { gameQuery } from "@/games/catalogue";
import { isNotFound } from "@/api/client";
import type { Behaviour, ReadyMade, TaughtGame } from "@/api/types";
import { Button, ButtonLink } from "@/components/controls/Button";
import { LostGame } from "@/components/feedback/LostGame";
import { Empty, Failed, Loading } from "@/components/feedback/States";
import { PageTitle } from "@/components/PageTitle";
import { useOnlyPlays } from "@/components/people/use-only-plays";
import { type BehaviourDraft, draftOf, EMPTY_DRAFT } from "@/features/behaviours/draft";
import { NewBehaviourDialog } from "@/features/behaviours/NewBehaviourDialog";
import { buttonName } from "@/games/actions";
import { measureSentence } from "@/games/measures";
import { useAccent } from "@/games/use-accent";

import styles from "./GamesPage.module.css";

/** A game: its behaviours, what it lacks, and the way to a new behaviour. */
export function GamePage({ name }: { name: string }) {
  const { data: game, error, refetch } = useQuery(gameQuery(name));
  useAccent(game?.picture_url);
  const { data: behaviours } = useQuery(behavioursQuery);
  const onlyPlays = useOnlyPlays();
  const [making, setMaking] = useState<BehaviourDraft | null>(null);
  if (isNotFound(error)) {
    return (
      <Empty level="h1" title={t`Game not found`} picture={<LostGame />} actions={<AllGames />}>
        <p>
          <Trans>The address is wrong, or the package with this game is not installed.</Trans>
        </p>
      </Empty>
    );
  }
  if (error && !game)
    return <Failed what={t`The game`} error={error} onRetry={() => void refetch()} />;
  if (!game || !behaviours) return <Loading what={t`the game`} rows={2} height="9rem" />;
  const own = behaviours.filter((one) => one.game === game.name);
  return (
    <>
      <PageTitle>{t`${game.title} · Tril`}</PageTitle>
      <div className={styles.game}>
        <img
          className={styles.picture}
          src={game.picture_url}
          alt={t`${game.title}, some seconds after its start`}
          style={{ aspectRatio: (game.width * game.pixel_aspect) / game.height }}
        />
        <div className={styles.words}>
          <h1>{game.title}</h1>
          {own.length > 0 ? (
            <ul className={styles.behaviours} aria-label={t`Behaviours`}>
              {own.map((behaviour) => (
                <li key={behaviour.id}>
                  <Link to={`/behaviours/${behaviour.id}`}>{behaviour.name}</Link>
                  <p>{behaviour.description}</p>
                  <p>
                    {plural(behaviour.n_recordings, { one: "# recording", other: "# recordings" })}
                  </p>
                </li>
              ))}
            </ul>
          ) : (
            <p>
              <Trans>Nothing has been taught in it yet.</Trans>
            </p>
          )}
          {onlyPlays === false && (
            <Button
              kind="primary"
              icon="plus"
              onClick={() => setMaking({ ...EMPTY_DRAFT, game: game.name })}
            >
              <Trans>Teach a behaviour</Trans>
            </Button>
          )}
          {onlyPlays === false && (
            <Offered
              game={game}
              own={own}
              onTake={(offered) => setMaking(draftOf(offered, game))}
            />
          )}
          <Facts game={game} />
          <AllGames />
        </div>
      </div>
      {making && (
        <NewBehaviourDialog
          title={t`Teach a behaviour in ${game.title}`}
          initial={making}
          onClose={() => setMaking(null)}
        />
      )}
    </>
  );
}

interface OfferedProps {
  game: TaughtGame;
  /** The behaviours that are there already. */
  own: readonly Behaviour[];
  onTake: (offered: ReadyMade) => void;
}

/** The behaviours that come with the game, without those that are there. */
function Offered({ game, own, onTake }: OfferedProps) {
  const names = new Set(own.map(({ name }) => name));
  const offered = game.ready_made.filter(({ name }) => !names.has(name));
  if (offered.length === 0) return null;
  return (
    <section className={styles.offered} aria-labelledby="ready-made">
      <h2 id="ready-made">
        <Trans>Ready-made</Trans>
      </h2>
      <ul>
        {offered.map((one) => (
          <li key={one.slug}>
            <h3>{one.name}</h3>
            <p>{one.description}</p>
            <ul className={styles.asked}>
              {one.measures.map((measure, index) => (
                <li key={index}>{measureSentence(measure, game)}</li>
              ))}
            </ul>
            <Button icon="plus" aria-label={t`Teach ${one.name}`} onClick={() => onTake(one)}>
              <Trans>Teach this</Trans>
            </Button>
          </li>
        ))}
      </ul>
    </section>
  );
}

function AllGames() {
  return (
    <ButtonLink kind="quiet" icon="arrowLeft" to="/games">
      <Trans>All games</Trans>
    </ButtonLink>
  );
}

/** How the game is played, and what it lacks and why. */
function Facts({ game }: { game: TaughtGame }) {
  const buttons = game.buttons.map(buttonName).join(", ");
  return (
    <div className={styles.facts}>
      <p>
        <Trans>
          Its buttons: {buttons}. {game.frame_rate_hz} frames a second, {game.frames_per_step} of
          them for a decision of the imitator.
        </Trans>
      </p>
      {game.waits && (
        <p>
          <Trans>
            It stands still until you press a button, since it has no action for waiting.
          </Trans>
        </p>
      )}
      {!game.items && (
        <p>
          <Trans>
            Nothing in it is counted, so there are no targets: what you rank is what it learns.
          </Trans>
        </p>
      )}
      {!game.has_player && (
        <p>
          <Trans>Nobody has written a scripted player for it, so there are no examples.</Trans>
        </p>
      )}
      {!game.saves_states && (
        <p>
          <Trans>
            Its states can&rsquo;t be saved, so a game can&rsquo;t be rewound while you play.
          </Trans>
        </p>
      )}
      {!game.has_memory && (
        <p>
          <Trans>
            It shows no memory: replays are checked by the screen, and a recording shows no memory.
          </Trans>
        </p>
      )}
      {game.attribution && <p>{game.attribution}</p>}
    </div>
  );
}
