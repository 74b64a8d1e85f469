import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useMutation, useQuery, useQueryClient } from "@tanstack/react-query";
import { useNavigate } from "react-router";

import { messageOf } from "@/api/client";
import { createRun, recipesQuery } from "@/api/runs";
import type { Behaviour } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { useToast } from "@/components/feedback/Toasts";
import { describeEstimate, proposedSteps } from "@/lib/runs";

/** Starts a run on a scripted example: generated games, ranked automatically. */
export function ExampleButton({ behaviour }: { behaviour: Behaviour }) {
  const client = useQueryClient();
  const navigate = useNavigate();
  const toast = useToast();
  const { data: recipes } = useQuery(recipesQuery(behaviour));
  const recipe = recipes?.[0];
  const start = useMutation({
    mutationFn: createRun,
    onSuccess: async (run) => {
      await client.invalidateQueries({ queryKey: ["runs"] });
      await navigate(`/runs/${run.id}`);
    },
    onError: (error) => toast(messageOf(error)),
  });
  return (
    <Button
      large
      title={t`A scripted player makes the games; Tril ranks them and trains on them.`}
      disabled={!recipe || start.isPending}
      onClick={() => {
        if (!recipe) return;
        start.mutate({
          behaviour_id: behaviour.id,
          recipe: recipe.name,
          steps: proposedSteps(recipe, behaviour),
          training_seed: 0,
          // The user has no ranking of their own to improve first.
          go_on_anyway: true,
          device: "any",
          example: true,
          cancel_parent: false,
        });
      }}
    >
      <span>
        <Trans>Train an example</Trans>{" "}
        {recipe && <small>({describeEstimate(recipe, proposedSteps(recipe, behaviour))})</small>}
      </span>
    </Button>
  );
}
