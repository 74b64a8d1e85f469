import fc from "fast-check";

import type { Tiers } from "@/features/ranking/order/order";

/** Orders of up to 8 recordings, some of them tied. */
export const tiers: fc.Arbitrary<Tiers> = fc
  .uniqueArray(fc.integer({ min: 1, max: 30 }), { minLength: 1, maxLength: 8 })
  .chain((ids) =>
    fc.array(fc.boolean(), { minLength: ids.length, maxLength: ids.length }).map((breaks) => {
      const order: number[][] = [];
      ids.forEach((id, index) => {
        const last = order.at(-1);
        if (last && !breaks[index]) last.push(id);
        else order.push([id]);
      });
      return order;
    }),
  );
