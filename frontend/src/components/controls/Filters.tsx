import { Trans } from "@lingui/react/macro";
import type { ReactNode } from "react";

import { Button } from "./Button";
import styles from "./Filters.module.css";

interface FiltersProps {
  label: string;
  role: "search" | "group";
  /** Undefined while nothing is left out. */
  onClear: (() => void) | undefined;
  children: ReactNode;
}

/** A row of menus and fields that narrow a list, with a button that clears them. */
export function Filters({ label, role, onClear, children }: FiltersProps) {
  return (
    <div className={styles.filters} role={role} aria-label={label}>
      {children}
      {onClear && (
        <Button kind="quiet" icon="close" onClick={onClear}>
          <Trans>Clear the filters</Trans>
        </Button>
      )}
    </div>
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
