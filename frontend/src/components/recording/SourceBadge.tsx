import { t } from "@lingui/core/macro";

import type { Recording } from "@/api/types";
import { Badge } from "@/components/feedback/Badge";
import { ActorMark } from "@/components/game/ActorMark";
import { playedBy } from "@/lib/actors";

/** Who played a recording. */
export function SourceBadge({ recording }: { recording: Recording }) {
  const { source, player } = recording;
  const name = {
    person: t`person`,
    scripted: t`scripted`,
    policy: t`imitator or clone`,
    varied: t`varied play`,
  }[source];
  return (
    <Badge>
      <ActorMark actor={playedBy(source)}>
        {source === "person" && player ? player : name}
      </ActorMark>
    </Badge>
  );
}
