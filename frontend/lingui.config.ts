import { defineConfig } from "@lingui/cli";
import { formatter } from "@lingui/format-po";

export default defineConfig({
  sourceLocale: "en",
  locales: ["de"],
  catalogs: [{ path: "<rootDir>/src/texts/{locale}", include: ["src"] }],
  // Without line numbers, so that moving code leaves the catalogues as they are.
  format: formatter({ lineNumbers: false }),
  orderBy: "origin",
  runtimeConfigModule: {
    i18n: ["@/lib/i18n", "i18n"],
    Trans: ["@/lib/i18n", "Trans"],
  },
});
