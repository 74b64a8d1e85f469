import { t } from "@lingui/core/macro";
import { useMemo } from "react";

import type { Behaviour, LibraryEntry, TaughtGame } from "@/api/types";
import { Filters, Search, Select } from "@/components/controls/Filters";
import { useGame } from "@/games/game";

import { EVERYTHING, type Filter, isNarrow, ORDERS, SHOWN, SOURCES, VERIFIED } from "./filter";

const showNames = (): Readonly<Record<Filter["show"], string>> => ({
  all: t`All`,
  perfect: t`Perfect ones`,
  ranked: t`Ranked`,
  unranked: t`Not ranked yet`,
  deleted: t`Deleted`,
});
const sourceNames = () =>
  ({
    person: t`A person`,
    scripted: t`The scripted player`,
    policy: t`Imitator or clone`,
    varied: t`Varied play`,
  }) as const;
const verifiedNames = () => ({ yes: t`Verified`, no: t`Not verified` }) as const;
const orderNames = (): Readonly<Record<Filter["order"], string>> => ({
  newest: t`Newest first`,
  oldest: t`Oldest first`,
  targets: t`Most hits first`,
  strays: t`Fewest strays first`,
  longest: t`Longest first`,
  shots: t`Fewest shots first`,
  score: t`Highest score first`,
});
const MOST_STRAYS = 5;

/** Filters and sorts the recordings. */
export function FilterBar({
  filter,
  recordings,
  behaviour,
  onChange,
}: {
  filter: Filter;
  recordings: readonly LibraryEntry[];
  behaviour: Behaviour;
  onChange: (filter: Filter) => void;
}) {
  const players = useMemo(
    () => [...new Set(recordings.map(({ player }) => player))].filter((one) => one !== null).sort(),
    [recordings],
  );
  const game = useGame();
  const orders = ORDERS.filter((one) => one === filter.order || isFor(one, game, behaviour));
  const set = (change: Partial<Filter>) => onChange({ ...filter, ...change });
  return (
    <Filters
      label={t`Filters`}
      role="group"
      folds
      onClear={
        isNarrow(filter) ? () => onChange({ ...EVERYTHING, order: filter.order }) : undefined
      }
    >
      <Select
        label={t`Show`}
        value={filter.show}
        options={SHOWN.map((one) => [one, showNames()[one]])}
        onChange={(show) => set({ show })}
      />
      <Select
        label={t`Played by`}
        value={filter.source ?? ANY}
        options={[[ANY, t`Anybody`], ...SOURCES.map((one) => [one, sourceNames()[one]] as const)]}
        onChange={(source) => set({ source: source === ANY ? null : source })}
      />
      {(players.length > 1 || filter.player !== null) && (
        <Select
          label={t`Player`}
          value={filter.player ?? ANY}
          options={[
            [ANY, t`All`],
            ...[...new Set([...players, filter.player ?? ANY])]
              .filter((one) => one !== ANY)
              .map((one) => [one, one] as const),
          ]}
          onChange={(player) => set({ player: player === ANY ? null : player })}
        />
      )}
      {behaviour.target && (
        <Select
          label={t`Targets`}
          value={numbered(filter.hits)}
          options={[
            [ANY, t`Any number`],
            ...upTo(behaviour.target.length, filter.hits).map(
              (n) => [String(n), t`${n} or more`] as const,
            ),
          ]}
          onChange={(hits) => set({ hits: numberOf(hits) })}
        />
      )}
      {behaviour.target && (
        <Select
          label={t`Strays`}
          value={numbered(filter.strays)}
          options={[
            [ANY, t`Any number`],
            ["0", t`None`],
            ...upTo(MOST_STRAYS, filter.strays).map((n) => [String(n), t`At most ${n}`] as const),
          ]}
          onChange={(strays) => set({ strays: numberOf(strays) })}
        />
      )}
      <Select
        label={t`Replay`}
        value={filter.verified ?? ANY}
        options={[
          [ANY, t`Verified or not`],
          ...VERIFIED.map((one) => [one, verifiedNames()[one]] as const),
        ]}
        onChange={(verified) => set({ verified: verified === ANY ? null : verified })}
      />
      <Search
        label={t`Number`}
        value={filter.number ?? ANY}
        onChange={(text) => set({ number: text.replaceAll(/\D/g, "").slice(0, 10) || null })}
      />
      <Select
        label={t`Order`}
        value={filter.order}
        options={orders.map((one) => [one, orderNames()[one]])}
        onChange={(order) => set({ order })}
      />
    </Filters>
  );
}

/** Whether games of a behaviour differ in what an order goes by. */
function isFor(
  order: Filter["order"],
  { items, counters }: TaughtGame,
  { target }: Behaviour,
): boolean {
  if (order === "shots") return "shots" in counters;
  if (order === "score") return items === null;
  return target !== null || (order !== "targets" && order !== "strays");
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
