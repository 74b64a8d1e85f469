/** Checks that the catalogues are those of the source, and that complete languages are complete. */
import { getCatalogs } from "@lingui/cli/api";
import { getConfig } from "@lingui/conf";

/** What each language has to have a translation for; the rest may still be in English. */
const COMPLETE = {
  de: [
    "src/app",
    "src/components",
    "src/features/behaviours",
    "src/features/people",
    "src/features/play",
    "src/features/ranking",
    "src/games",
    "src/lib",
  ],
};

const config = getConfig();
const problems = [];
for (const catalog of await getCatalogs(config)) {
  const found = await catalog.collect();
  if (!found) throw new Error("The source can't be read; see above.");
  for (const locale of config.locales) {
    const written = (await catalog.read(locale)) ?? {};
    const file = catalog.getFilename(locale);
    if (described(written) !== described(found)) {
      problems.push(`${file} is not the source's catalogue: run make texts`);
    }
    for (const [id, { message, origin, translation }] of Object.entries(written)) {
      const required = (COMPLETE[locale] ?? []).some((folder) =>
        origin.some(([path]) => path.startsWith(`${folder}/`)),
      );
      if (required && !translation)
        problems.push(`${file} has no translation of: ${message ?? id}`);
    }
  }
}
process.stderr.write(problems.map((problem) => `${problem}\n`).join(""));
process.exitCode = problems.length > 0 ? 1 : 0;

/** Returns which messages there are, and which files they are from. */
function described(messages) {
  const rows = Object.entries(messages).map(([id, { origin, obsolete }]) => [
    id,
    Boolean(obsolete),
    [...new Set(origin.map(([path]) => path))].sort(),
  ]);
  return JSON.stringify(rows.sort(([a], [b]) => (a < b ? -1 : 1)));
}
