import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useMemo, useState } from "react";
import { Link } from "react-router";

import type { AttentionMap, Faithfulness, Recording, RunResults } from "@/api/types";
import type { Watched } from "@/features/results/watched";
import { useGame } from "@/games/game";
import { fixed, percent } from "@/lib/format";
import { useScreenSize } from "@/lib/game/use-screen-size";
import { recordingName } from "@/lib/recordings";

import styles from "./Attention.module.css";
import { AnyPercentile } from "./AnyPercentile";
import { momentPath } from "./moment";
import { MapImage, ScreenImage } from "./PixelImage";
import { useLevel } from "./use-level";

type ColourMap = "perceptual" | "red-blue";

const colourMaps = (): readonly { readonly id: ColourMap; readonly name: string }[] => [
  { id: "perceptual", name: t`Perceptual` },
  { id: "red-blue", name: t`Red-blue` },
];

/** The most that a map and its screen take, in CSS pixels; a narrow column makes both smaller. */
const MAP_BOX = { width: 340, height: 252 };

interface AttentionProps {
  results: RunResults;
  onWatch: (watched: Watched) => void;
}

/** Attention maps of the reward model, from the state of lowest R to that of highest. */
export function Attention({ results, onWatch }: AttentionProps) {
  const recordings = useMemo(
    () => new Map(results.check?.returns.map(({ recording }) => [recording.id, recording])),
    [results],
  );
  const [colours, setColours] = useState<ColourMap>("perceptual");
  const levelOf = useLevel(results);
  return (
    <>
      <p className={styles.note}>
        <Trans>
          The more the learned reward R changes when a patch of the screen is covered, the brighter
          (or redder) the patch. Four moments of the ranked games, from the lowest R to the highest.
          R is 0 where demonstrations begin and 1 where the best ones end.
        </Trans>
      </p>
      <fieldset className={styles.bar}>
        <legend className="visually-hidden">
          <Trans>Colour map</Trans>
        </legend>
        <span aria-hidden="true">
          <Trans>Colours</Trans>
        </span>
        <span className={styles.choice}>
          {colourMaps().map(({ id, name }) => (
            <label key={id}>
              <input
                type="radio"
                name="colour-map"
                checked={colours === id}
                onChange={() => setColours(id)}
              />
              {name}
            </label>
          ))}
        </span>
      </fieldset>
      <div className={styles.maps}>
        {results.attention.map((map) => (
          <MapFigure
            key={map.state}
            map={map}
            colours={colours}
            level={levelOf(map.reward)}
            recording={recordings.get(map.recording_id)}
            runId={results.run.id}
            onWatch={onWatch}
          />
        ))}
      </div>
      {results.percentiles.length > 0 && (
        <AnyPercentile
          states={results.percentiles}
          levelOf={levelOf}
          recordings={recordings}
          runId={results.run.id}
        />
      )}
    </>
  );
}

/** Whether the map's bright pixels matter to R: the deletion and insertion tests in words. */
function FaithfulnessFacts({ map, random }: Faithfulness) {
  const brightest = percent(map.hidden_fifth, 0);
  const anyFifth = percent(random.hidden_fifth, 0);
  const [deletion, randomDeletion] = [fixed(map.deletion, 2), fixed(random.deletion, 2)];
  const [insertion, randomInsertion] = [fixed(map.insertion, 2), fixed(random.insertion, 2)];
  return (
    <>
      <span>
        <Trans>
          Hide the brightest fifth of the pixels, and R changes by {brightest} of its range; hide a
          random fifth, and it changes by {anyFifth}.
        </Trans>
      </span>
      <span
        title={t`How far R is off while pixels are hidden (deletion) or filled into an empty screen (insertion), brightest first, as a share of its range; in brackets, in random order. A faithful map has a larger deletion and a smaller insertion.`}
      >
        <Trans>
          Deletion {deletion} ({randomDeletion}), insertion {insertion} ({randomInsertion})
        </Trans>
      </span>
    </>
  );
}

function MapFigure({
  map,
  colours,
  level,
  recording,
  runId,
  onWatch,
}: {
  map: AttentionMap;
  colours: ColourMap;
  level: string;
  recording: Recording | undefined;
  runId: string;
  onWatch: (watched: Watched) => void;
}) {
  const game = useGame();
  const name = recordingName(recording);
  const size = useScreenSize(MAP_BOX.width, MAP_BOX.height, game);
  const frame = (
    <ScreenImage src={map.frame_url} alt={t`Screen at the ${map.state} of R`} size={size} />
  );
  return (
    <figure className={styles.map} aria-label={t`Attention at the ${map.state} of R`}>
      <MapImage
        src={colours === "perceptual" ? map.map_url : map.red_blue_url}
        alt={t`Attention map at the ${map.state} of R`}
        size={size}
      />
      {recording ? (
        <button
          type="button"
          className={styles.frame}
          aria-label={t`Watch ${name} from step ${map.step}`}
          onClick={() =>
            onWatch({ recording, title: name, frame: map.step * game.frames_per_step })
          }
        >
          {frame}
        </button>
      ) : (
        frame
      )}
      <figcaption>
        <strong>{map.state}</strong>
        <span>R {level}</span>
        <Link to={momentPath(map, runId)}>
          <Trans>
            {name}, step {map.step}
          </Trans>
        </Link>
        {map.faithfulness && <FaithfulnessFacts {...map.faithfulness} />}
      </figcaption>
    </figure>
  );
}
