import { Trans } from "@lingui/react/macro";
import type { ReactNode } from "react";

import { useMedia } from "@/lib/browser/use-media";

import { Button } from "./Button";
import styles from "./Filters.module.css";

interface FiltersProps {
  label: string;
  role: "search" | "group";
  /** Undefined while nothing is left out. */
  onClear: (() => void) | undefined;
  /** Whether a narrow page shows one row that opens, since the list is what people come for. */
  folds?: boolean;
  children: ReactNode;
}

/** A row of menus and fields that narrow a list, with a button that clears them. */
export function Filters({ label, role, onClear, folds = false, children }: FiltersProps) {
  const narrow = useMedia("(max-width: 40rem)");
  const fields = (
    <div className={styles.filters} role={role} aria-label={label}>
      {children}
      {onClear && (
        <Button kind="quiet" icon="close" onClick={onClear}>
          <Trans>Clear the filters</Trans>
        </Button>
      )}
    </div>
  );
  if (!folds || !narrow) return fields;
  return (
    <details className={styles.folded}>
      <summary>
        {label}
        {onClear && <Trans>(some are set)</Trans>}
      </summary>
      {fields}
    </details>
  );
}

interface SelectProps<T extends string> {
  label: string;
  value: T;
  options: readonly (readonly [T, string])[];
  onChange: (value: T) => void;
}

/** A labelled menu of a filter bar. */
export function Select<T extends string>({ label, value, options, onChange }: SelectProps<T>) {
  return (
    <label className={styles.labelled}>
      <span>{label}</span>
      <select
        className={styles.menu}
        value={value}
        onChange={(event) => onChange(event.currentTarget.value as T)}
      >
        {options.map(([one, name]) => (
          <option key={one} value={one}>
            {name}
          </option>
        ))}
      </select>
    </label>
  );
}

interface SearchProps {
  label: string;
  value: string;
  onChange: (value: string) => void;
}

/** A labelled search field of a filter bar. */
export function Search({ label, value, onChange }: SearchProps) {
  return (
    <label className={styles.labelled}>
      <span>{label}</span>
      <input
        className={styles.search}
        type="search"
        value={value}
        onChange={(event) => onChange(event.currentTarget.value)}
      />
    </label>
  );
}
