import { zlibSync } from "fflate";
import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { Film } from "@/features/share/film";

const FORMAT = { width: 20, height: 10, palette: [] };

/** Encodes pictures as docs/protocol.md describes it, each changed byte as a run of its own. */
function encoded(pictures: readonly Uint8Array[]): Uint8Array {
  const bytes: number[] = [];
  let before: Uint8Array = new Uint8Array(200);
  for (const picture of pictures) {
    const changed = [...picture.keys()].filter((at) => picture[at] !== before[at]);
    bytes.push(...number(changed.length));
    let end = 0;
    for (const at of changed) {
      bytes.push(...number(at - end), ...number(1), (picture[at] ?? 0) ^ (before[at] ?? 0));
      end = at + 1;
    }
    before = picture;
  }
  return zlibSync(Uint8Array.from(bytes));
}

function number(value: number): number[] {
  return value < 128 ? [value] : [(value & 127) | 128, ...number(value >> 7)];
}

const pictures = fc.array(fc.uint8Array({ minLength: 200, maxLength: 200 }), { minLength: 1 });

describe("a film", () => {
  it("shows each frame as it was, in any order", () => {
    fc.assert(
      fc.property(pictures, fc.array(fc.nat(30)), (screens, visits) => {
        const film = new Film(FORMAT, encoded(screens), screens.length - 1);
        for (const visit of visits) {
          const shown = screens[Math.min(visit, screens.length - 1)];
          expect([...film.show(visit)]).toEqual([...(shown ?? [])]);
        }
      }),
    );
  });

  it("holds a picture for as many frames as it stands for", () => {
    const [first, second] = [new Uint8Array(200).fill(7), new Uint8Array(200).fill(200)];
    const film = new Film(FORMAT, encoded([first, second]), 5, 3);
    expect([0, 2, 3, 5].map((frame) => film.show(frame)[0])).toEqual([7, 7, 200, 200]);
    expect(film.show(1)[199]).toBe(7);
    expect(film.last).toBe(5);
  });
});
