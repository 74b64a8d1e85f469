import { useQuery } from "@tanstack/react-query";
import { useCallback, useEffect, useMemo, useRef, useState } from "react";

import { messageOf } from "@/api/client";
import { recordingsQuery } from "@/api/recordings";
import type { Behaviour, Ranking, Recording } from "@/api/types";
import { Button, ButtonLink, IconButton } from "@/components/controls/Button";
import { Empty, Failed, Loading, Notice } from "@/components/feedback/States";
import { RecordingScreen } from "@/components/recording/RecordingScreen";
import { useRecordingActions } from "@/components/recording/use-recording-actions";
import { WatchDialog } from "@/components/recording/WatchDialog";
import { applyMove, Board, Tray } from "@/features/ranking/board/Board";
import { DragBoard } from "@/features/ranking/board/DragBoard";
import { allPlaces, isGap, placeInWords, readPlace } from "@/features/ranking/board/places";
import { CardBody, type Move } from "@/features/ranking/board/RankCard";
import { judge, openPairs } from "@/features/ranking/order/branch-pairs";
import { place, tierOf, type Tiers } from "@/features/ranking/order/order";
import { rankingQuery } from "@/features/ranking/order/rankings";
import type { RankingSaver, SaverState } from "@/features/ranking/order/saver";
import { useRankingSaver } from "@/features/ranking/order/use-ranking";
import { recordingName, scoreInWords } from "@/lib/recordings";

import { ConflictDialog } from "./ConflictDialog";
import { Hints } from "./Hints";
import { Pairs } from "./Pairs";
import styles from "./RankPage.module.css";
import { useMedia } from "./use-media";

/** Puts a behaviour's recordings into tiers from best to worst. */
export function RankPage({ behaviour }: { behaviour: Behaviour }) {
  const ranking = useQuery(rankingQuery(behaviour.id));
  const recordings = useQuery(recordingsQuery(behaviour.id));
  const error = ranking.error ?? recordings.error;
  if (error && !(ranking.data && recordings.data)) {
    return (
      <Failed
        what="The ranking"
        error={error}
        onRetry={() => {
          void ranking.refetch();
          void recordings.refetch();
        }}
      />
    );
  }
  if (!ranking.data || !recordings.data) return <Loading what="the ranking" rows={4} />;
  const { tiers, unranked } = ranking.data;
  if (tiers.length === 0 && unranked.length === 0) return <NothingToRank behaviour={behaviour} />;
  return (
    <RankingDesk
      key={behaviour.id}
      behaviour={behaviour}
      ranking={ranking.data}
      recordings={recordings.data}
    />
  );
}

function NothingToRank({ behaviour }: { behaviour: Behaviour }) {
  return (
    <Empty
      title="Nothing to rank yet"
      actions={
        <ButtonLink kind="primary" to={`/behaviours/${behaviour.id}/play`}>
          Play a game
        </ButtonLink>
      }
    >
      <p>Games that you keep appear here. Two are enough to begin with.</p>
    </Empty>
  );
}

interface DeskProps {
  behaviour: Behaviour;
  ranking: Ranking;
  recordings: readonly Recording[];
}

function RankingDesk({ behaviour, ranking, recordings }: DeskProps) {
  const [state, saver] = useRankingSaver(ranking);
  const [looked, setLooked] = useState<number | null>(null);
  const [spoken, setSpoken] = useState("");
  const actions = useRecordingActions(behaviour.id);
  const byId = useMemo(() => new Map(recordings.map((one) => [one.id, one])), [recordings]);
  const narrow = useMedia("(max-width: 66rem)");
  const { tiers } = state;
  const unranked = unrankedOf(state);
  useUndoKeys(saver);
  const keepFocus = useKeptFocus(tiers);

  const nameOfItem = useCallback((item: string) => recordingName({ id: Number(item) }), []);
  const nameOfPlace = useCallback((to: string) => placeInWords(to, tiers), [tiers]);

  function move(id: number, kind: Move) {
    const next = applyMove(tiers, id, kind);
    keepFocus(id, kind);
    saver.change(next);
    setSpoken(`${recordingName({ id })}: ${standingInWords(next, id)}.`);
  }

  const desk = {
    tiers,
    recordings: byId,
    behaviour,
    looked,
    narrow,
    onLook: setLooked,
    onMove: move,
    onPerfect: (one: Recording) => actions.setPerfect(one, !one.perfect),
  };
  return (
    <DragBoard
      places={allPlaces(tiers)}
      isThin={isGap}
      nameOfItem={nameOfItem}
      nameOfPlace={nameOfPlace}
      onDrop={(item, to) => saver.change(place(tiers, Number(item), readPlace(to)))}
      renderDragged={(item) => {
        const recording = byId.get(Number(item));
        return recording && <CardBody recording={recording} behaviour={behaviour} />;
      }}
    >
      <div className={styles.page}>
        <section aria-label="Ranking">
          <Bar state={state} saver={saver} />
          <Pairs
            pairs={openPairs(tiers, unranked, byId)}
            behaviour={behaviour}
            onLook={setLooked}
            onJudge={(pair, verdict) => {
              const next = judge(tiers, pair, verdict);
              saver.change(next);
              setSpoken(
                [pair.after, pair.before]
                  .map(({ id }) => `${recordingName({ id })}: ${standingInWords(next, id)}.`)
                  .join(" "),
              );
            }}
          />
          <Board {...desk} />
        </section>
        <div className={styles.side}>
          {!narrow && (
            <Preview
              recording={byId.get(looked ?? tiers[0]?.[0] ?? unranked[0] ?? 0)}
              playing={looked !== null}
              behaviour={behaviour}
            />
          )}
          <Hints tiers={tiers} recordings={recordings} behaviour={behaviour} />
          <Tray {...desk} unranked={unranked} />
        </div>
      </div>
      <p role="status" className="visually-hidden">
        {spoken}
      </p>
      {state.conflict && (
        <ConflictDialog
          theirs={state.conflict.tiers}
          mine={tiers}
          onSettle={(whose) => saver.settle(whose)}
        />
      )}
    </DragBoard>
  );
}

/** All recordings of the saved ranking that are in none of the tiers shown. */
function unrankedOf({ saved, tiers }: SaverState): readonly number[] {
  const ranked = new Set(tiers.flat());
  return [...saved.unranked, ...saved.tiers.flat()].filter((id) => !ranked.has(id));
}

function standingInWords(tiers: Tiers, id: number): string {
  const at = tierOf(tiers, id);
  if (at < 0) return "unranked";
  const others = (tiers[at]?.length ?? 1) - 1;
  const tie = others === 0 ? "alone" : `tied with ${others}`;
  return `tier ${at + 1} of ${tiers.length}, ${tie}`;
}

function Bar({ state, saver }: { state: SaverState; saver: RankingSaver }) {
  const { saved, saving, error, conflict } = state;
  return (
    <>
      <div className={styles.bar}>
        <h2>Best to worst</h2>
        <span className={styles.saved} role="status">
          {saving ? "Saving…" : error ? "Not saved" : "Saved"}
        </span>
        <IconButton
          icon="undo"
          label="Undo (Ctrl+Z)"
          disabled={!saved.can_undo || conflict !== null}
          onClick={() => void saver.step("undo")}
        />
        <IconButton
          icon="redo"
          label="Redo (Ctrl+Shift+Z)"
          disabled={!saved.can_redo || conflict !== null}
          onClick={() => void saver.step("redo")}
        />
      </div>
      {error !== null && (
        <Notice tone="bad" live>
          <p>The order could not be saved: {messageOf(error)}</p>
          <Button onClick={() => saver.retry()}>Try again</Button>
        </Notice>
      )}
    </>
  );
}

const PREVIEW = { width: 352, height: 210 } as const;

function Preview({
  recording,
  playing,
  behaviour,
}: {
  recording: Recording | undefined;
  playing: boolean;
  behaviour: Behaviour;
}) {
  const [watching, setWatching] = useState(false);
  const nTargets = behaviour.target?.length ?? null;
  if (!recording) return null;
  return (
    <section className={styles.preview} aria-label="Preview">
      <button
        type="button"
        className={styles.screen}
        aria-label={`Watch ${recordingName(recording)}`}
        onClick={() => setWatching(true)}
      >
        <RecordingScreen key={recording.id} recording={recording} playing={playing} {...PREVIEW} />
      </button>
      <p className={styles.caption}>
        <strong>{recordingName(recording)}</strong>
        <span>
          {playing ? scoreInWords(recording, nTargets) : "Point at a recording and it plays here."}
        </span>
      </p>
      {watching && (
        <WatchDialog recording={recording} nTargets={nTargets} onClose={() => setWatching(false)} />
      )}
    </section>
  );
}

/** A card that moves into another tier is made anew: the button that moved it keeps the focus. */
function useKeptFocus(tiers: Tiers): (id: number, move: Move) => void {
  const wanted = useRef<{ id: number; move: Move } | null>(null);
  useEffect(() => {
    const { id, move } = wanted.current ?? {};
    wanted.current = null;
    if (id === undefined || document.activeElement !== document.body) return;
    const card = document.querySelector(`[data-recording="${id}"]`);
    const button = card?.querySelector<HTMLElement>(`[data-move="${move ?? ""}"]`);
    (button ?? card?.querySelector<HTMLElement>("button"))?.focus();
  }, [tiers]);
  return useCallback((id, move) => {
    wanted.current = { id, move };
  }, []);
}

/** Ctrl+Z takes back, Ctrl+Shift+Z (or Ctrl+Y) makes it again. */
function useUndoKeys(saver: RankingSaver): void {
  useEffect(() => {
    const down = (event: KeyboardEvent) => {
      const target = event.target as HTMLElement;
      if (!(event.ctrlKey || event.metaKey) || target.matches("input, textarea")) return;
      const key = event.key.toLowerCase();
      if (key !== "z" && key !== "y") return;
      event.preventDefault();
      void saver.step(key === "y" || event.shiftKey ? "redo" : "undo");
    };
    window.addEventListener("keydown", down);
    return () => window.removeEventListener("keydown", down);
  }, [saver]);
}
