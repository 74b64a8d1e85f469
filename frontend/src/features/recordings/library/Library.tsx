import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { useCallback, useMemo, useState } from "react";
import { useSearchParams } from "react-router";

import { libraryQuery } from "@/api/library";
import { exportUrl } from "@/api/recordings";
import type { Behaviour, LibraryEntry, Recording } from "@/api/types";
import { Button, DownloadLink } from "@/components/controls/Button";
import { Failed, Loading } from "@/components/feedback/States";
import { WindowList } from "@/components/list/VirtualList";
import { whyUnrankable } from "@/lib/recordings";

import { filtered, EVERYTHING, type Filter, isNarrow, readFilter, writeFilter } from "./filter";
import { FilterBar } from "./FilterBar";
import styles from "./Library.module.css";
import { ShownRecording } from "./RecordingCard";
import { NOTHING, selectedOf, toggled } from "./selection";
import { SelectionBar } from "./SelectionBar";

/** About as high as a card is. */
const CARD_PX = 498;
const GAP_PX = 16;

interface LibraryProps {
  /** Without deleted ones. */
  recordings: readonly LibraryEntry[];
  /** Whether these are all; else they are the newest. */
  isWhole: boolean;
  behaviour: Behaviour;
  onWatch: (recording: Recording) => void;
  /** Without it there is no import, and no export of all. */
  onImport: (() => void) | undefined;
}

/** The grid of recordings, with filters kept in the address and a selection. */
export function Library({ recordings, isWhole, behaviour, onWatch, onImport }: LibraryProps) {
  const [search, setSearch] = useSearchParams();
  const filter = useMemo(() => readFilter(search), [search]);
  const setFilter = (next: Filter) => setSearch(writeFilter(next), { replace: true });
  const nOthers = useMemo(
    () => recordings.filter((one) => whyUnrankable(one) !== null).length,
    [recordings],
  );
  const nRankable = isWhole ? recordings.length - nOthers : behaviour.n_recordings;
  const isOfNewest = !isNarrow(filter) && filter.order === EVERYTHING.order;
  return (
    <>
      <div className={styles.bar}>
        <h2>
          {plural(nRankable, { one: "# recording", other: "# recordings" })}
          {nOthers > 0 && (
            <>
              {" "}
              <small>
                <Trans>and {nOthers} that can&rsquo;t be ranked yet</Trans>
              </small>
            </>
          )}
        </h2>
        {onImport && (
          <>
            <Button icon="upload" onClick={onImport}>
              <Trans>Import</Trans>
            </Button>
            <DownloadLink href={exportUrl(behaviour.id)}>
              <Trans>Export</Trans>
            </DownloadLink>
          </>
        )}
      </div>
      <FilterBar
        filter={filter}
        recordings={recordings}
        behaviour={behaviour}
        onChange={setFilter}
      />
      {filter.show === "deleted" ? (
        <Deleted behaviour={behaviour} filter={filter} onWatch={onWatch} onClear={setFilter} />
      ) : !isWhole && !isOfNewest ? (
        <Loading what={t`the recordings`} rows={2} height="18rem" />
      ) : (
        <Grid
          recordings={recordings}
          isWhole={isWhole}
          behaviour={behaviour}
          filter={filter}
          onWatch={onWatch}
          onClear={setFilter}
        />
      )}
    </>
  );
}

interface GridProps {
  recordings: readonly LibraryEntry[];
  isWhole: boolean;
  behaviour: Behaviour;
  filter: Filter;
  onWatch: (recording: Recording) => void;
  onClear: (filter: Filter) => void;
}

function Deleted(props: Omit<GridProps, "recordings" | "isWhole">) {
  const { data, error, refetch } = useQuery(libraryQuery(props.behaviour.id, { deleted: true }));
  if (error && !data) {
    return <Failed what={t`The recordings`} error={error} onRetry={() => void refetch()} />;
  }
  if (!data) return <Loading what={t`the deleted recordings`} rows={2} height="18rem" />;
  return <Grid recordings={data.entries} isWhole {...props} />;
}

function Grid({ recordings, isWhole, behaviour, filter, onWatch, onClear }: GridProps) {
  const [selection, setSelection] = useState(NOTHING);
  const shown = useMemo(() => filtered(recordings, filter), [recordings, filter]);
  const ids = useMemo(() => shown.map(({ id }) => id), [shown]);
  const select = useCallback(
    (id: number, range: boolean) => setSelection((before) => toggled(before, ids, id, range)),
    [ids],
  );
  const selected = useMemo(() => new Set(selectedOf(selection, ids)), [selection, ids]);
  if (shown.length === 0) {
    return (
      <p className={styles.none}>
        <Trans>No recording matches the filters.</Trans>{" "}
        {isNarrow(filter) && (
          <Button onClick={() => onClear({ ...EVERYTHING, order: filter.order })}>
            <Trans>Show all</Trans>
          </Button>
        )}
      </p>
    );
  }
  return (
    <>
      <SelectionBar
        behaviour={behaviour}
        shown={shown}
        total={recordings.length}
        isWhole={isWhole}
        selected={shown.filter(({ id }) => selected.has(id))}
        onSelect={(some) => setSelection({ ids: new Set(some), anchor: null })}
      />
      <WindowList
        label={t`Recordings`}
        ids={ids}
        rowPx={CARD_PX}
        gapPx={GAP_PX}
        className={styles.cards}
        renderItem={(id) => (
          <ShownRecording
            recordingId={id}
            behaviour={behaviour}
            onWatch={onWatch}
            selected={selected.has(id)}
            onSelect={select}
          />
        )}
      />
    </>
  );
}
