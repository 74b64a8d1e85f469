/** Where labels at the ends of lines stand. */

interface Block {
  /** The labels that touch each other, from the top. */
  readonly labels: readonly number[];
  readonly top: number;
  readonly height: number;
}

/**
 * Returns the tops of labels that stand as near to their lines' ends as they can without overlapping.
 *
 * @param centres Heights of the lines' ends, from the top in pixels.
 * @param heights Heights of the labels.
 * @param limit Height of the chart, which the labels do not leave while there is room for them.
 */
export function spreadLabels(
  centres: readonly number[],
  heights: readonly number[],
  limit: number,
): number[] {
  const heightOf = (label: number) => heights[label] ?? 0;
  // The top at which the labels of a block are nearest to their lines' ends in the mean.
  const blockOf = (labels: readonly number[]): Block => {
    let height = 0;
    let sum = 0;
    for (const label of labels) {
      sum += (centres[label] ?? 0) - heightOf(label) / 2 - height;
      height += heightOf(label);
    }
    const top = Math.max(0, Math.min(sum / labels.length, limit - height));
    return { labels, top, height };
  };
  const order = centres.map((_, label) => label);
  order.sort((a, b) => (centres[a] ?? 0) - (centres[b] ?? 0));
  const blocks: Block[] = [];
  for (const label of order) {
    let block = blockOf([label]);
    for (
      let above = blocks.at(-1);
      above && above.top + above.height > block.top;
      above = blocks.at(-1)
    ) {
      blocks.pop();
      block = blockOf([...above.labels, ...block.labels]);
    }
    blocks.push(block);
  }
  const tops = centres.map(() => 0);
  for (const { labels, top } of blocks) {
    let next = top;
    for (const label of labels) {
      tops[label] = next;
      next += heightOf(label);
    }
  }
  return tops;
}
