import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { type ReactNode, useId, useState } from "react";
import { Link, NavLink, useSearchParams } from "react-router";

import { behaviourQuery, behavioursQuery } from "@/api/behaviours";
import { gameQuery } from "@/games/catalogue";
import { isNotFound, messageOf } from "@/api/client";
import { runsQuery } from "@/api/runs";
import type { Behaviour } from "@/api/types";
import { ButtonLink, IconButton } from "@/components/controls/Button";
import { Icon } from "@/components/controls/Icon";
import { LostGame } from "@/components/feedback/LostGame";
import { Empty, Failed, Loading } from "@/components/feedback/States";
import { PageTitle } from "@/components/PageTitle";
import { useOnlyPlays } from "@/components/people/use-only-plays";
import { GameProvider } from "@/games/game";
import { useAccent } from "@/games/use-accent";
import { classes } from "@/lib/classes";
import { continuing, isActive, withSearch } from "@/lib/runs";

import styles from "./BehaviourFrame.module.css";
import { EditBehaviour } from "./EditBehaviour";
import { GameMark } from "./GameMark";
import { type PathStep, pathOf, type StepId, trainingStatus } from "./path";

interface BehaviourFrameProps {
  behaviourId: number;
  /** Marks the last step as current on a page whose address is not below it. */
  looking?: boolean;
  children: (behaviour: Behaviour) => ReactNode;
}

/** The header of every page of a behaviour: its name and the path through the four steps. */
export function BehaviourFrame({ behaviourId, looking = false, children }: BehaviourFrameProps) {
  const { data: behaviour, error, refetch } = useQuery(behaviourQuery(behaviourId));
  const { data: all } = useQuery(behavioursQuery);
  const name = behaviour?.game;
  const taught = useQuery({ ...gameQuery(name ?? ""), enabled: name !== undefined });
  const game = taught.data;
  useAccent(game?.picture_url);
  if (isNotFound(error)) {
    return (
      <Empty
        level="h1"
        title={t`Behaviour not found`}
        picture={<LostGame />}
        actions={
          <ButtonLink to="/">
            <Trans>All behaviours</Trans>
          </ButtonLink>
        }
      >
        <p>
          <Trans>The address is wrong, or it has been deleted.</Trans>
        </p>
      </Empty>
    );
  }
  if (error && !behaviour) {
    return <Failed what={t`The behaviour`} error={error} onRetry={() => void refetch()} />;
  }
  if (behaviour && isNotFound(taught.error) && !game) {
    return (
      <Empty
        level="h1"
        title={behaviour.name}
        actions={
          <ButtonLink to="/">
            <Trans>All behaviours</Trans>
          </ButtonLink>
        }
      >
        <p>
          <Trans>
            Its game {behaviour.game} is not installed here. Games and trainings are kept, and can
            be opened again once it is.
          </Trans>
        </p>
        <p>{messageOf(taught.error)}</p>
      </Empty>
    );
  }
  if (behaviour && taught.error && !game) {
    return (
      <Failed
        what={t`The game ${behaviour.game}`}
        error={taught.error}
        onRetry={() => void taught.refetch()}
      />
    );
  }
  if (!behaviour || !game) return <Loading what={t`the behaviour`} rows={2} height="5rem" />;
  const isOneOfSeveral = all?.some((one) => one.game !== game.name) ?? false;
  return (
    <GameProvider game={game} settings={behaviour.settings}>
      <PageTitle>{t`${behaviour.name} · Tril`}</PageTitle>
      <div className={styles.head}>
        <Name behaviour={behaviour}>
          {isOneOfSeveral && (
            <Link to={`/games/${encodeURIComponent(game.name)}`}>{game.title}</Link>
          )}
        </Name>
        <Path behaviour={behaviour} looking={looking} />
      </div>
      <div className={styles.body}>{children(behaviour)}</div>
    </GameProvider>
  );
}

/** What the behaviour is called; what else there is to say of it is folded where there is little room. */
function Name({ behaviour, children: game }: { behaviour: Behaviour; children: ReactNode }) {
  const onlyPlays = useOnlyPlays();
  const [open, setOpen] = useState(false);
  const aboutId = useId();
  return (
    <div className={styles.name}>
      <div className={styles.mark}>
        <GameMark target={behaviour.target} />
      </div>
      <div className={styles.title}>
        <h1>{behaviour.name}</h1>
        <Training behaviourId={behaviour.id} />
      </div>
      <IconButton
        className={styles.unfold}
        icon={open ? "up" : "more"}
        label={t`About this behaviour`}
        aria-expanded={open}
        aria-controls={aboutId}
        onClick={() => setOpen(!open)}
      />
      <div id={aboutId} className={classes(styles.about, !open && styles.folded)}>
        {game}
        <p>{behaviour.description}</p>
        {!onlyPlays && <EditBehaviour behaviour={behaviour} />}
      </div>
    </div>
  );
}

/** A link to the run that is under way, where the path has no room to name it. */
function Training({ behaviourId }: { behaviourId: number }) {
  const { data: runs = [] } = useQuery({
    ...runsQuery(behaviourId),
    enabled: useOnlyPlays() === false,
  });
  const active = runs.find(isActive);
  if (!active) return null;
  return (
    <Link className={styles.training} to={`/runs/${active.id}`}>
      {trainingStatus(active)}
    </Link>
  );
}

const PAGES: Readonly<Record<StepId, string>> = {
  play: "play",
  rank: "rank",
  train: "train",
  look: "runs",
};

function Path({ behaviour, looking }: { behaviour: Behaviour; looking: boolean }) {
  const onlyPlays = useOnlyPlays();
  const { data: runs } = useQuery({ ...runsQuery(behaviour.id), enabled: onlyPlays === false });
  const steps = pathOf(behaviour, runs ?? []);
  const at = `/behaviours/${behaviour.id}`;
  const further = continuing(useSearchParams()[0]);
  const [play, ...others] = steps;
  if (!play) return null;
  return (
    <nav className={styles.path} aria-label={t`Path`}>
      <ol className={styles.steps}>
        <li>
          <StepLink step={play} number={1} to={`${at}/play`} />
        </li>
        <li>
          <NavLink className={classes(styles.step)} to={`${at}/recordings`}>
            <span className={classes(styles.marker, styles.plain)} aria-hidden="true">
              {behaviour.n_recordings}
            </span>
            <span className={styles.stepName}>
              <Trans>Recordings</Trans>
            </span>
            <span className={styles.caption}>
              <Trans>watch, mark, import</Trans>
            </span>
          </NavLink>
        </li>
        {(onlyPlays ? [] : others).map((step, index) => {
          const to = `${at}/${PAGES[step.id]}`;
          return (
            <li key={step.id}>
              <StepLink
                step={step}
                number={index + 2}
                to={step.id === "look" ? to : withSearch(to, further)}
                current={looking && step.id === "look"}
              />
            </li>
          );
        })}
      </ol>
    </nav>
  );
}

function StepLink({
  step,
  number,
  to,
  current = false,
}: {
  step: PathStep;
  number: number;
  to: string;
  current?: boolean;
}) {
  const look = classes(styles.step, step.done && styles.done, step.next && styles.next);
  const content = (
    <>
      <span className={styles.marker} aria-hidden="true">
        {step.done ? <Icon name="check" /> : number}
      </span>
      <span className={styles.stepName}>
        {step.name}{" "}
        {step.done && (
          <span className="visually-hidden">
            <Trans>(done)</Trans>
          </span>
        )}
        {step.next && (
          <span className="visually-hidden">
            <Trans>(next)</Trans>
          </span>
        )}
      </span>
      <span className={styles.caption}>
        {step.next && (
          <span className={styles.nextWord} aria-hidden="true">
            <Trans>Next:</Trans>{" "}
          </span>
        )}
        {step.caption}
      </span>
    </>
  );
  // A NavLink is current only below its own address; the page of a run belongs to the last step.
  return current ? (
    <Link to={to} className={look} aria-current="page">
      {content}
    </Link>
  ) : (
    <NavLink to={to} className={look}>
      {content}
    </NavLink>
  );
}
