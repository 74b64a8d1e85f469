import styles from "./Attention.module.css";

interface Option<Id extends string> {
  readonly id: Id;
  readonly name: string;
}

/** A select of a few named options. */
export function Choice<Id extends string>({
  label,
  options,
  value,
  onChange,
}: {
  label: string;
  options: readonly Option<Id>[];
  value: Id;
  onChange: (id: Id) => void;
}) {
  return (
    <label>
      <span className="visually-hidden">{label}</span>
      <select
        className={styles.choice}
        value={value}
        onChange={(event) => {
          const chosen = options.find(({ id }) => id === event.currentTarget.value);
          if (chosen) onChange(chosen.id);
        }}
      >
        {options.map(({ id, name }) => (
          <option key={id} value={id}>
            {name}
          </option>
        ))}
      </select>
    </label>
  );
}
