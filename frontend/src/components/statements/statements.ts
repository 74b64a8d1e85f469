import type { StatementAnswer, UnderstoodStatement } from "@/api/types";

/** What names a statement when it is answered. */
export type Said = Pick<StatementAnswer, "subjects" | "sentence">;

/** Statements that are shown however improbable they are, and from which probability on others. */
const LEAST_SHOWN = 3;
const SHOWN_FROM = 0.02;

export function isAbout(answer: StatementAnswer, { subjects }: Pick<Said, "subjects">): boolean {
  return answer.subjects.join() === subjects.join();
}

/** Returns the statements that are worth a person's attention. */
export function shownOf<T extends UnderstoodStatement>(statements: readonly T[]): readonly T[] {
  return statements.filter(
    ({ probability }, place) => place < LEAST_SHOWN || probability >= SHOWN_FROM,
  );
}
