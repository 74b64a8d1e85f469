import { fileURLToPath } from "node:url";

import { defineConfig } from "vite";

/** Builds style and script of share pages, each as one file, which are put into the pages. */
export default defineConfig({
  publicDir: false,
  resolve: { alias: { "@": fileURLToPath(new URL("./src", import.meta.url)) } },
  build: {
    outDir: "../server/web/static/share",
    emptyOutDir: true,
    target: ["chrome123", "firefox128", "safari17.5"],
    lib: {
      entry: fileURLToPath(new URL("./src/features/share/main.ts", import.meta.url)),
      formats: ["iife"],
      name: "share",
      fileName: () => "share.js",
      cssFileName: "share",
    },
  },
});
