import type { Behaviour, Recording } from "@/api/types";
import { Filters, Select } from "@/components/controls/Filters";

import { EVERYTHING, type Filter, isNarrow, ORDERS, SHOWN, SOURCES, VERIFIED } from "./filter";

const SHOW_NAMES: Readonly<Record<Filter["show"], string>> = {
  all: "All",
  perfect: "Perfect ones",
  ranked: "Ranked",
  unranked: "Not ranked yet",
  deleted: "Deleted",
};
const SOURCE_NAMES = {
  person: "A person",
  scripted: "The scripted player",
  policy: "A policy",
  varied: "Varied play",
} as const;
const VERIFIED_NAMES = { yes: "Verified", no: "Not verified" } as const;
const ORDER_NAMES: Readonly<Record<Filter["order"], string>> = {
  newest: "Newest first",
  oldest: "Oldest first",
  targets: "Most hits first",
  strays: "Fewest strays first",
  longest: "Longest first",
  shots: "Fewest shots first",
};
const MOST_STRAYS = 5;
/** Choices for the number of hits without a target. */
const MOST_HITS = 12;

/** Filters and sorts the recordings. */
export function FilterBar({
  filter,
  recordings,
  behaviour,
  onChange,
}: {
  filter: Filter;
  recordings: readonly Recording[];
  behaviour: Behaviour;
  onChange: (filter: Filter) => void;
}) {
  const players = [
    ...new Set(recordings.flatMap(({ player }) => (player === null ? [] : [player]))),
  ].sort();
  const nHits = behaviour.target?.length ?? MOST_HITS;
  const set = (change: Partial<Filter>) => onChange({ ...filter, ...change });
  return (
    <Filters
      label="Filters"
      role="group"
      onClear={
        isNarrow(filter) ? () => onChange({ ...EVERYTHING, order: filter.order }) : undefined
      }
    >
      <Select
        label="Show"
        value={filter.show}
        options={SHOWN.map((one) => [one, SHOW_NAMES[one]])}
        onChange={(show) => set({ show })}
      />
      <Select
        label="Played by"
        value={filter.source ?? ANY}
        options={[[ANY, "Anybody"], ...SOURCES.map((one) => [one, SOURCE_NAMES[one]] as const)]}
        onChange={(source) => set({ source: source === ANY ? null : source })}
      />
      {(players.length > 1 || filter.player !== null) && (
        <Select
          label="Player"
          value={filter.player ?? ANY}
          options={[
            [ANY, "All"],
            ...[...new Set([...players, filter.player ?? ANY])]
              .filter((one) => one !== ANY)
              .map((one) => [one, one] as const),
          ]}
          onChange={(player) => set({ player: player === ANY ? null : player })}
        />
      )}
      <Select
        label={behaviour.target ? "Targets" : "Aliens"}
        value={numbered(filter.hits)}
        options={[
          [ANY, "Any number"],
          ...upTo(nHits, filter.hits).map((n) => [String(n), `${n} or more`] as const),
        ]}
        onChange={(hits) => set({ hits: numberOf(hits) })}
      />
      {behaviour.target && (
        <Select
          label="Strays"
          value={numbered(filter.strays)}
          options={[
            [ANY, "Any number"],
            ["0", "None"],
            ...upTo(MOST_STRAYS, filter.strays).map((n) => [String(n), `At most ${n}`] as const),
          ]}
          onChange={(strays) => set({ strays: numberOf(strays) })}
        />
      )}
      <Select
        label="Replay"
        value={filter.verified ?? ANY}
        options={[
          [ANY, "Verified or not"],
          ...VERIFIED.map((one) => [one, VERIFIED_NAMES[one]] as const),
        ]}
        onChange={(verified) => set({ verified: verified === ANY ? null : verified })}
      />
      <Select
        label="Order"
        value={filter.order}
        options={ORDERS.map((one) => [one, ORDER_NAMES[one]])}
        onChange={(order) => set({ order })}
      />
    </Filters>
  );
}

/** No restriction; not a player's name, since names are not empty. */
const ANY = "";

function numbered(n: number | null): string {
  return n === null ? ANY : String(n);
}

function numberOf(text: string): number | null {
  return text === ANY ? null : Number(text);
}

/** Returns 1 to `most`, and the current value if an address asks for more. */
function upTo(most: number, present: number | null): number[] {
  const all = Array.from({ length: most }, (_, index) => index + 1);
  return present !== null && present > most ? [...all, present] : all;
}
