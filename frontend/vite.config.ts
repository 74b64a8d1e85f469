import { fileURLToPath } from "node:url";

import react from "@vitejs/plugin-react";
import { defineConfig } from "vitest/config";

// `npm run dev` serves the pages and passes /api and the token exchange (/?token=…) on to a running
// `tril up`.
const server = process.env.TRIL_SERVER ?? "http://127.0.0.1:8000";
const passedOn = { target: server, ws: true, changeOrigin: true, headers: { origin: server } };

export default defineConfig({
  plugins: [react()],
  resolve: { alias: { "@": fileURLToPath(new URL("./src", import.meta.url)) } },
  build: {
    // Inside the package, so that a wheel and a clone have the page in the same place.
    outDir: "../server/web/static",
    emptyOutDir: true,
    target: ["chrome123", "firefox128", "safari17.5"],
    // Everything is a file: the server's content security policy allows no data: scripts or styles.
    assetsInlineLimit: 0,
  },
  server: {
    host: "127.0.0.1",
    proxy: { "/api": passedOn, "^/\\?token=": passedOn },
  },
  test: {
    restoreMocks: true,
    // Pages are searched by role, which is slow in jsdom on a machine that has other work.
    testTimeout: 30_000,
    css: false,
    // As many processes as cores; by default one fewer, which on two cores leaves half idle.
    maxWorkers: "100%",
    projects: [
      {
        extends: true,
        test: { name: "logic", environment: "node", include: ["tests/**/*.test.ts"] },
      },
      {
        extends: true,
        test: {
          name: "pages",
          environment: "jsdom",
          include: ["tests/**/*.test.tsx"],
          setupFiles: ["tests/support/setup.ts"],
        },
      },
    ],
  },
});
