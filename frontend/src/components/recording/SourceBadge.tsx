import { t } from "@lingui/core/macro";

import type { Recording } from "@/api/types";
import { Badge } from "@/components/feedback/Badge";
import { ThingMark } from "@/components/game/ThingMark";
import { playedBy } from "@/lib/things";

/** Who played a recording. */
export function SourceBadge({ recording }: { recording: Recording }) {
  const { source, player } = recording;
  const name = {
    person: t`person`,
    scripted: t`scripted`,
    policy: t`policy`,
    varied: t`varied play`,
  }[source];
  return (
    <Badge>
      <ThingMark thing={playedBy(source)}>
        {source === "person" && player ? player : name}
      </ThingMark>
    </Badge>
  );
}
