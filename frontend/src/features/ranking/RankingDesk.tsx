import { plural, t } from "@lingui/core/macro";
import { Plural, Trans } from "@lingui/react/macro";
import { useCallback, useEffect, useMemo, useState } from "react";
import { useLocation, useSearchParams } from "react-router";

import type { Behaviour, LibraryEntry, Ranking, Recording } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { useToast } from "@/components/feedback/Toasts";
import { useBorrowing } from "@/components/recording/use-borrowing";
import { usePerfectMark } from "@/components/recording/use-perfect-mark";
import { useRecordingActions } from "@/components/recording/use-recording-actions";
import { applyMove, Board, focusTray, Tray } from "@/features/ranking/board/Board";
import { DragBoard } from "@/features/ranking/board/DragBoard";
import {
  allPlaces,
  describePlace,
  describePosition,
  describeStep,
  findPlace,
  isGap,
} from "@/features/ranking/board/places";
import { DraggedCard } from "@/features/ranking/board/ShownCard";
import type { Move } from "@/features/ranking/board/RankCard";
import { useKeptFocus } from "@/features/ranking/board/use-kept-focus";
import { canCompare, CompareDialog } from "@/features/ranking/comparing/CompareDialog";
import { AwaitedOpinion, Opinion } from "@/features/ranking/opinion/Opinion";
import { OpinionBar } from "@/features/ranking/opinion/OpinionBar";
import { useOpinions } from "@/features/ranking/opinion/use-opinions";
import { judge, openPairs } from "@/features/ranking/order/branch-pairs";
import { place, placeAll, tierOf, type Tiers, turnRound } from "@/features/ranking/order/order";
import type { SaverState } from "@/features/ranking/order/saver";
import { useRankingSaver } from "@/features/ranking/order/use-ranking";
import { useUndoKeys } from "@/features/ranking/order/use-undo-keys";
import { UnderstandingPanel } from "@/features/ranking/understanding/UnderstandingPanel";
import { isReadByStatements } from "@/features/ranking/understanding/use-understanding";
import { useMedia } from "@/lib/browser/use-media";
import { classes } from "@/lib/classes";
import { KnownRecordings } from "@/features/ranking/recording-names";
import { recordingName, whyUnrankable } from "@/lib/recordings";
import { selectedBy } from "@/lib/selection";

import { ConflictDialog } from "./ConflictDialog";
import { Hints } from "./Hints";
import { Pairs } from "./Pairs";
import { Preview } from "./Preview";
import styles from "./RankingDesk.module.css";
import { SaveBar } from "./SaveBar";
import { SelectionBar } from "./SelectionBar";
import { TakeOver } from "./TakeOver";
import { VariedGames } from "./VariedGames";

interface RankingDeskProps {
  behaviour: Behaviour;
  ranking: Ranking;
  /** The library and what is borrowed, in brief, newest first. */
  recordings: readonly LibraryEntry[];
  /** Whether these are all; else they are the newest, and all that is borrowed. */
  isWhole: boolean;
}

/** The board; beside it the preview and the tray, and what Tril understood. */
export function RankingDesk({ behaviour, ranking, recordings, isWhole }: RankingDeskProps) {
  const [state, saver] = useRankingSaver(ranking);
  const [previewed, setPreviewed] = useState<number | null>(null);
  const [spoken, setSpoken] = useState("");
  const toast = useToast();
  const [advised, setAdvised] = useState(true);
  const [kept, setKept] = useState<ReadonlySet<number>>(new Set());
  const isRead = isReadByStatements(behaviour);
  const opinions = useOpinions(behaviour.id, state, advised && !isRead);
  const perfect = useMemo(
    () =>
      isWhole ? recordings.flatMap((one) => (one.perfect && !one.deleted ? [one.id] : [])) : null,
    [recordings, isWhole],
  );
  const { setPerfect } = useRecordingActions(behaviour.id);
  const { mark, question } = usePerfectMark(behaviour);
  const { giveBack } = useBorrowing(behaviour.id);
  const byId = useMemo(() => new Map(recordings.map((one) => [one.id, one])), [recordings]);
  const narrow = useMedia("(max-width: 66rem)");
  const { tiers } = state;
  const unranked = useMemo(() => unrankedOf(recordings, tiers), [recordings, tiers]);
  const nRanked = useMemo(() => tiers.flat().length, [tiers]);
  const borrowed = useMemo(() => recordings.filter((one) => one.borrowed), [recordings]);
  const nUnranked = isWhole ? unranked.length : behaviour.n_recordings + borrowed.length - nRanked;
  const arrivedWith: unknown = useLocation().state;
  const [chosen, setChosen] = useState<ReadonlySet<number>>(
    () => new Set(selectedBy(arrivedWith).filter((id) => unranked.includes(id))),
  );
  const selected = useMemo(
    () => [...tiers.flat(), ...unranked].filter((id) => chosen.has(id)),
    [tiers, unranked, chosen],
  );
  const varied = useMemo(() => unranked.filter((id) => isVaried(byId.get(id))), [unranked, byId]);
  const [search, setSearch] = useSearchParams();
  const [compared, setCompared] = useState(
    search.has("compare") && canCompare(state, unranked) ? unranked : null,
  );
  const [dragging, setDragging] = useState(false);
  useChangesElsewhere(state);
  const refocus = useKeptFocus(tiers);
  /** The card that was moved last, which is laid out even out of sight, to keep the focus. */
  const [moved, setMoved] = useState<number | null>(null);
  const keepFocus: typeof refocus = useCallback(
    (id, kind) => {
      setMoved(id);
      refocus(id, kind);
    },
    [refocus],
  );

  const nameOf = useCallback((id: number) => recordingName(byId.get(id)), [byId]);
  const step = useCallback(
    (which: "undo" | "redo") => {
      // What was said before may be the same, and is to be heard again.
      setSpoken("");
      void saver.step(which).then((stepped) => {
        if (stepped) setSpoken(describeStep(which, stepped, nameOf));
      });
    },
    [saver, nameOf],
  );
  useUndoKeys(step, compared === null && !dragging);
  const nameOfItem = useCallback((item: string) => nameOf(Number(item)), [nameOf]);
  const nameOfPlace = useCallback((to: string) => describePlace(to, tiers), [tiers]);

  const show = useCallback(
    (id: number, next: Tiers) => {
      saver.change(next);
      setSpoken(`${nameOf(id)}: ${describePosition(next, id)}.`);
    },
    [saver, nameOf],
  );
  const move = useCallback(
    (id: number, kind: Move) => {
      keepFocus(id, kind);
      show(id, applyMove(tiers, id, kind));
    },
    [tiers, keepFocus, show],
  );
  const select = useCallback((id: number, on: boolean) => {
    setChosen((before) => new Set(on ? [...before, id] : [...before].filter((one) => one !== id)));
  }, []);
  const togglePerfect = useCallback(
    (one: Recording) => {
      if (one.perfect) setPerfect(one, false);
      else mark([one], () => setPerfect(one, true));
    },
    [setPerfect, mark],
  );
  const { of: opinionOf, current: isCurrent, awaited } = opinions;
  const renderOpinion = useCallback(
    (id: number) => {
      const opinion = opinionOf.get(id);
      const at = tierOf(tiers, id);
      const tier = at < 0 ? null : at + 1;
      if (!opinion) return awaited && <AwaitedOpinion tier={tier} />;
      return (
        <Opinion
          opinion={opinion}
          tier={tier}
          kept={kept.has(id)}
          current={isCurrent}
          onMove={(to) => {
            keepFocus(id);
            show(id, place(tiers, id, { kind: "tier", tier: to - 1 }));
          }}
          onKeep={() => setKept((before) => new Set([...before, id]))}
        />
      );
    },
    [opinionOf, awaited, isCurrent, tiers, kept, keepFocus, show],
  );

  function putSelected(to: string) {
    const [first] = selected;
    if (first === undefined) return;
    keepFocus(first);
    const at = findPlace(to, tiers);
    if (!at) return;
    saver.change(placeAll(tiers, selected, at));
    setSpoken(
      t`Dropped ${plural(selected.length, { one: "# recording", other: "# recordings" })}: ${nameOfPlace(to)}.`,
    );
    setChosen(new Set());
  }

  const pairs = useMemo(() => openPairs(tiers, unranked, byId), [tiers, unranked, byId]);
  const isComparable = isWhole && canCompare(state, unranked);
  const selectedUnranked = useMemo(
    () => unranked.filter((id) => chosen.has(id)),
    [unranked, chosen],
  );
  const placeByComparing = () =>
    setCompared(selectedUnranked.length > 0 ? selectedUnranked : unranked);

  function endComparing() {
    setCompared(null);
    setChosen(new Set(selectedUnranked));
    if (!search.has("compare")) return;
    search.delete("compare");
    setSearch(search, { replace: true });
  }

  const desk = {
    tiers,
    moved,
    recordings: byId,
    isWhole,
    behaviour,
    previewed,
    narrow,
    onPreview: setPreviewed,
    onMove: move,
    selected: chosen,
    onSelect: select,
    onPerfect: togglePerfect,
    onGiveBack: giveBack,
    renderOpinion,
  };
  const asked = tiers.length > 0 && (
    <Pairs
      pairs={pairs}
      behaviour={behaviour}
      onPreview={setPreviewed}
      onJudge={(pair, verdict) => {
        const next = judge(tiers, pair, verdict);
        saver.change(next);
        setSpoken(
          [pair.after, pair.before]
            .map(({ id }) => `${nameOf(id)}: ${describePosition(next, id)}.`)
            .join(" "),
        );
      }}
    />
  );
  return (
    <KnownRecordings value={byId}>
      <DragBoard
        places={allPlaces(tiers)}
        isThin={isGap}
        nameOfItem={nameOfItem}
        nameOfPlace={nameOfPlace}
        onDragging={(now) => {
          setDragging(now);
          if (now) saver.hold();
          else saver.release();
        }}
        onDrop={(item, to, byKeyboard) => {
          const at = findPlace(to, tiers);
          if (byKeyboard) keepFocus(Number(item));
          if (at) saver.change(place(tiers, Number(item), at));
        }}
        renderDragged={(item) => {
          return <DraggedCard recordingId={Number(item)} behaviour={behaviour} />;
        }}
      >
        <div className={classes(styles.page, selected.length > 0 && styles.selecting)}>
          <section className={styles.ranking} aria-label={t`Ranking`}>
            <SaveBar
              state={state}
              saver={saver}
              onStep={step}
              onTurnRound={() => {
                saver.change(turnRound(tiers));
                setSpoken(t`The order is reversed: what was worst is best.`);
              }}
            >
              <Hints
                tiers={tiers}
                nPerfect={perfect?.length ?? behaviour.n_perfect}
                borrowed={borrowed}
                behaviour={behaviour}
              />
            </SaveBar>
            {narrow && asked}
            {narrow && tiers.length > 0 && nUnranked > 0 && (
              <Button className={styles.toUnranked} icon="down" onClick={focusTray}>
                <Plural
                  value={nUnranked}
                  one="# game not ranked yet"
                  other="# games not ranked yet"
                />
              </Button>
            )}
            <Board {...desk} />
            {tiers.length === 0 && (
              <TakeOver
                behaviour={behaviour}
                recordings={recordings}
                onTaken={(taken) => saver.change(taken)}
              />
            )}
          </section>
          <div className={styles.side}>
            {!narrow && (
              <Preview
                recordingId={previewed ?? tiers[0]?.[0] ?? unranked[0]}
                playing={previewed !== null}
                behaviour={behaviour}
              />
            )}
            {!narrow && asked}
            <Tray
              {...desk}
              unranked={unranked}
              nUnranked={nUnranked}
              above={
                isComparable && (
                  <div>
                    <Button icon="compare" onClick={placeByComparing}>
                      <Trans>Place by comparing</Trans>
                    </Button>
                  </div>
                )
              }
              below={
                <VariedGames
                  behaviour={behaviour}
                  varied={isWhole ? varied : []}
                  onAdded={(added) => {
                    // One that hits a target may be better than the worst.
                    const ids = added.filter(({ targets }) => !targets).map(({ id }) => id);
                    setChosen(new Set(ids));
                    const games = plural(added.length, {
                      one: "# varied game added",
                      other: "# varied games added",
                    });
                    const done = t`${games}, ${ids.length} of them selected: those that hit no target.`;
                    setSpoken(done);
                    toast(done);
                  }}
                  onSelect={(ids) => setChosen(new Set(ids))}
                />
              }
            />
          </div>
          <div className={styles.understood}>
            {isRead ? (
              <UnderstandingPanel
                behaviourId={behaviour.id}
                tiers={state.tiers}
                perfect={perfect}
                onRank={isComparable ? (id) => setCompared([id]) : null}
              />
            ) : (
              <OpinionBar
                behaviour={behaviour}
                opinions={opinions}
                shown={advised}
                onShow={setAdvised}
              />
            )}
          </div>
        </div>
        <SelectionBar
          tiers={tiers}
          selected={selected}
          onPut={putSelected}
          onCompare={isComparable && selectedUnranked.length > 0 ? placeByComparing : null}
          onSelectNone={() => setChosen(new Set())}
        />
        <p role="status" className="visually-hidden">
          {spoken}
        </p>
        {question}
        {compared && (
          <CompareDialog
            ids={compared}
            behaviour={behaviour}
            recordings={byId}
            opinions={opinions.of}
            state={state}
            saver={saver}
            onClose={endComparing}
          />
        )}
        {state.conflict && !dragging && (
          <ConflictDialog
            theirs={state.conflict.tiers}
            mine={tiers}
            onSettle={(whose) => saver.settle(whose)}
          />
        )}
      </DragBoard>
    </KnownRecordings>
  );
}

/** Says that an order was saved elsewhere, and whether it is shown already. */
function useChangesElsewhere({ waiting, nReplaced }: SaverState): void {
  const toast = useToast();
  const [before] = useState(nReplaced);
  useEffect(() => {
    if (waiting)
      toast(t`Another tab or person changed the order. You see it when this drag is over.`);
  }, [waiting, toast]);
  useEffect(() => {
    if (nReplaced > before) toast(t`Another tab or person changed the order. This is the new one.`);
  }, [nReplaced, before, toast]);
}

/** Whether a game was added to make a ranking more varied. */
function isVaried(one: LibraryEntry | undefined): boolean {
  return one !== undefined && ((one.borrowed && one.run_id === null) || one.source === "varied");
}

/** Returns the recordings that can be ranked and are in none of the tiers. */
function unrankedOf(recordings: readonly LibraryEntry[], tiers: Tiers): readonly number[] {
  const ranked = new Set(tiers.flat());
  return recordings.flatMap((one) =>
    !ranked.has(one.id) && whyUnrankable(one) === null ? [one.id] : [],
  );
}
