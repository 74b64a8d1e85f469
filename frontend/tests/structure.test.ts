import { posix } from "node:path";

import { describe, expect, it } from "vitest";

const LARGEST_FOLDER = 12;
const SHARED = /^(api|components|lib)\//;

/** Every module below src/ by its path, with the modules it imports, types included. */
const graph = new Map<string, readonly string[]>();
const texts = import.meta.glob<string>("../src/**/*.{ts,tsx}", {
  query: "?raw",
  import: "default",
  eager: true,
});
const modules = Object.keys(texts).map((path) => path.replace("../src/", ""));
for (const module of modules) {
  const text = texts[`../src/${module}`] ?? "";
  const paths = [...text.matchAll(/(?:from |import\()"(@|\.)\/([^"]+)"/g)].map(([, root, path]) =>
    posix.join(root === "@" ? "" : posix.dirname(module), path ?? ""),
  );
  const found = paths.flatMap((path) => [".ts", ".tsx", ".d.ts"].map((end) => path + end));
  graph.set(
    module,
    found.filter((path) => modules.includes(path)),
  );
}

/** What some modules import, directly or not; modules that match `but` are not entered. */
function reachable(starts: readonly string[], but?: RegExp): Set<string> {
  const found = new Set<string>();
  const open = [...starts];
  for (let next = open.pop(); next !== undefined; next = open.pop()) {
    for (const one of graph.get(next) ?? []) {
      if (found.has(one) || but?.test(one)) continue;
      found.add(one);
      open.push(one);
    }
  }
  return found;
}

describe("the source tree", () => {
  it("has no import cycle", () => {
    expect(modules.filter((module) => reachable([module]).has(module))).toEqual([]);
  });

  it("shares only what the app or a feature and another feature use", () => {
    const owner = /^(?:app|features\/\w+)\//;
    const owners = new Set(modules.flatMap((module) => owner.exec(module)?.[0] ?? []));
    const uses = [...owners].map((folder) =>
      reachable(
        modules.filter((module) => module.startsWith(folder)),
        /^features\//,
      ),
    );
    const shared = modules.filter((module) => SHARED.test(module));
    expect(shared.length).toBeGreaterThan(20);
    expect(shared.filter((one) => uses.filter((all) => all.has(one)).length < 2)).toEqual([]);
  });

  it(`has at most ${LARGEST_FOLDER} modules in a folder`, () => {
    const folders = modules.map((module) => posix.dirname(module));
    const sizeOf = (folder: string) => folders.filter((one) => one === folder).length;
    expect(folders.filter((folder) => sizeOf(folder) > LARGEST_FOLDER)).toEqual([]);
  });

  it("keeps what is in a game in the folder of the game", () => {
    const words = /aliens?\b|cannon|space.?invaders/i;
    const elsewhere = modules.filter(
      (module) =>
        !/^games\/(space-invaders\/|views\.ts)/.test(module) && module !== "api/schema.d.ts",
    );
    const knowing = elsewhere.filter((module) => {
      const text = (texts[`../src/${module}`] ?? "").replaceAll('"space_invaders"', "");
      return words.test(text);
    });
    expect(elsewhere.length).toBeGreaterThan(100);
    expect(knowing).toEqual([]);
  });
});
