import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import { IconButton } from "@/components/controls/Button";
import { useGame } from "@/games/game";

import { type Area, withEdge } from "./areas";
import styles from "./HiddenAreas.module.css";

const edgeNames = () => [t`Left`, t`Top`, t`Right`, t`Bottom`] as const;

interface AreaFieldsProps {
  /** Its number among several. */
  number?: number;
  area: Area;
  readOnly: boolean;
  onChange: (area: Area) => void;
  /** Removes it; none for an area that has to be there. */
  onRemove?: () => void;
}

/** The edges of an area as numbers. */
export function AreaFields({ number, area, readOnly, onChange, onRemove }: AreaFieldsProps) {
  const screen = useGame();
  return (
    <fieldset className={styles.fields}>
      <legend>{number === undefined ? <Trans>Area</Trans> : <Trans>Area {number}</Trans>}</legend>
      {edgeNames().map((name, edge) => (
        <label key={name}>
          <span>{name}</span>
          <input
            type="number"
            readOnly={readOnly}
            min={0}
            max={edge % 2 === 0 ? screen.width : screen.height}
            value={area[edge]}
            onChange={(event) => {
              const typed = event.currentTarget.valueAsNumber;
              if (Number.isInteger(typed)) onChange(withEdge(area, edge, typed, screen));
            }}
          />
        </label>
      ))}
      {!readOnly && onRemove && number !== undefined && (
        <IconButton icon="trash" label={t`Remove area ${number}`} onClick={onRemove} />
      )}
    </fieldset>
  );
}
