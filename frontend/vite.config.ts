import { readFileSync, writeFileSync } from "node:fs";
import type { ClientRequest, IncomingMessage } from "node:http";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { brotliCompressSync, constants } from "node:zlib";

import { type PluginObj, transformAsync, types } from "@babel/core";
import macros from "@lingui/babel-plugin-lingui-macro";
import { compileMessageOrThrow } from "@lingui/message-utils/compileMessage";
import { lingui } from "@lingui/vite-plugin";
import react from "@vitejs/plugin-react";
import type { Plugin, ProxyOptions } from "vite";
import { defineConfig } from "vitest/config";

/** The running `tril up` that the development server passes the API and the sign-in on to. */
const tril = new URL(process.env.TRIL_SERVER ?? "http://127.0.0.1:8000").origin;

/**
 * Passes requests on to Tril as if they came from its own page: Tril compares Origin with Host.
 * Requests from any other page keep their Origin, so that Tril refuses them.
 */
const proxy: ProxyOptions = {
  target: tril,
  changeOrigin: true,
  configure: (server) => {
    const setOrigin = (outgoing: ClientRequest, { headers }: IncomingMessage) => {
      if (headers.origin === `http://${headers.host ?? ""}`) outgoing.setHeader("Origin", tril);
    };
    server.on("proxyReq", setOrigin);
    server.on("proxyReqWs", setOrigin);
  },
};

function withoutUndefined<T>(value: T): T {
  return JSON.parse(JSON.stringify(value)) as T;
}

/**
 * Compiles the messages that the macros leave in the code, so that the page needs no parser for
 * them. Those without parameters stay strings.
 */
const compileMessages: PluginObj = {
  visitor: {
    Program: {
      exit: (program) =>
        program.traverse({
          ObjectExpression({ node: { properties } }) {
            const named = (name: string) =>
              properties.find(
                (one) => types.isObjectProperty(one) && types.isIdentifier(one.key, { name }),
              );
            const message = named("message");
            if (!named("id") || !types.isObjectProperty(message)) return;
            if (!types.isStringLiteral(message.value)) return;
            const parts = compileMessageOrThrow(message.value.value);
            const isPlain = parts.every((part) => typeof part === "string");
            message.value = types.valueToNode(isPlain ? parts.join("") : withoutUndefined(parts));
          },
        }),
    },
  },
};

/**
 * Expands Lingui's macros. The English messages stay in the code: they are shown where a catalogue has none.
 * Types and JSX are left to Vite.
 */
const expandMacros: Plugin = {
  name: "expand-macros",
  enforce: "pre",
  transform: {
    filter: { id: /\/(src|tests)\/.*\.tsx?$/, code: /@lingui\/\w+\/macro/ },
    handler: async (code, id) => {
      const result = await transformAsync(code, {
        filename: id,
        babelrc: false,
        configFile: false,
        sourceMaps: true,
        parserOpts: { plugins: ["typescript", ...(id.endsWith("x") ? (["jsx"] as const) : [])] },
        plugins: [[macros, { stripMessageField: false }], compileMessages],
      });
      return result?.code ? { code: result.code, map: result.map } : null;
    },
  },
};

/** Puts the font's licence beside the font, as it demands. */
const fontLicence: Plugin = {
  name: "font-licence",
  apply: "build",
  generateBundle() {
    const licence = new URL("node_modules/@fontsource-variable/oxanium/LICENSE", import.meta.url);
    this.emitFile({ type: "asset", fileName: "assets/OFL.txt", source: readFileSync(licence) });
  },
};

interface Preload {
  /** Regular expression of a page's addresses; its group is the id. */
  readonly path: string;
  /** The page's module. */
  readonly page: string;
  /** What the id is of: "behaviour", "run" or "recording". */
  readonly shows?: string;
  /** What the page asks the API for at first; `{behaviour}`, `{game}`, `{run}` and `{recording}` are filled in. */
  readonly data: readonly string[];
}

/**
 * Writes down for the server which chunks each page of `preloads.json` needs beside the entry, so that
 * browsers load them and the page's data with the entry and not after it.
 */
const preloads: Plugin = {
  name: "preloads",
  apply: "build",
  generateBundle(_, bundle) {
    const chunks = Object.values(bundle).filter((one) => one.type === "chunk");
    const byFile = new Map(chunks.map((chunk) => [chunk.fileName, chunk]));
    const filesOf = (chunk: (typeof chunks)[number], files = new Set<string>()): Set<string> => {
      if (files.has(chunk.fileName)) return files;
      files.add(chunk.fileName);
      for (const name of chunk.imports) {
        const imported = byFile.get(name);
        if (imported) filesOf(imported, files);
      }
      return files;
    };
    const stylesOf = (files: ReadonlySet<string>) =>
      [...files].flatMap((name) => [...(byFile.get(name)?.viteMetadata?.importedCss ?? [])]);
    const entry = chunks.find(({ isEntry }) => isEntry);
    const first = entry ? filesOf(entry) : new Set<string>();
    const firstStyles = new Set(stylesOf(first));
    const source = new URL("preloads.json", import.meta.url);
    const pages = JSON.parse(readFileSync(source, "utf8")) as readonly Preload[];
    const preloaded = pages.map(({ path, page, shows, data }) => {
      const chunk = chunks.find((one) => one.facadeModuleId?.endsWith(`/${page}`));
      if (!chunk) throw new Error(`preloads.json: ${page} is no page with a chunk of its own.`);
      const files = new Set([...filesOf(chunk)].filter((name) => !first.has(name)));
      const styles = stylesOf(files).filter((name) => !firstStyles.has(name));
      return { path, shows, scripts: [...files], styles: [...new Set(styles)], data };
    });
    this.emitFile({
      type: "asset",
      fileName: "preloads.json",
      source: JSON.stringify(preloaded),
    });
  },
};

/** Below this a compressed file saves no packet. */
const MIN_BROTLI_BYTES = 1024;

/** Puts scripts and styles with Brotli beside them, at its best: the server sends them as they lie. */
const brotli: Plugin = {
  name: "brotli",
  apply: "build",
  writeBundle({ dir }, bundle) {
    for (const name of Object.keys(bundle).filter((one) => /\.(css|js)$/.test(one))) {
      const path = join(dir ?? "", name);
      const content = readFileSync(path);
      if (content.length < MIN_BROTLI_BYTES) continue;
      const params = { [constants.BROTLI_PARAM_SIZE_HINT]: content.length };
      writeFileSync(`${path}.br`, brotliCompressSync(content, { params }));
    }
  },
};

export default defineConfig({
  plugins: [
    expandMacros,
    react(),
    lingui({ failOnCompileError: true }),
    fontLicence,
    preloads,
    brotli,
  ],
  resolve: { alias: { "@": fileURLToPath(new URL("./src", import.meta.url)) } },
  build: {
    // Inside the package, so that a wheel and a clone have the page in the same place.
    outDir: "../server/web/static",
    emptyOutDir: true,
    target: ["chrome123", "firefox128", "safari17.5"],
    // Never inline assets: the server's content security policy forbids data: URLs of scripts.
    assetsInlineLimit: 0,
    rolldownOptions: {
      output: {
        codeSplitting: {
          // Two files of what every page needs: each takes the server 10 ms, and a browser gets six at a time.
          groups: [
            { name: "libraries", tags: ["$initial"], test: /node_modules|rolldown/, priority: 1 },
            { name: "page", tags: ["$initial"] },
            // What several pages need, in one file and not in twenty.
            { name: "shared", minShareCount: 3, test: /\/src\// },
          ],
        },
      },
    },
  },
  server: {
    host: "127.0.0.1",
    // The second entry is the sign-in, which sets the cookie and redirects to the page.
    proxy: { "/api": { ...proxy, ws: true }, "^/\\?token=": proxy },
  },
  test: {
    restoreMocks: true,
    // Queries by role are slow in jsdom, more so on a busy machine.
    testTimeout: 30_000,
    css: false,
    // One process per core; the default is one fewer, which leaves half of two cores idle.
    maxWorkers: "100%",
    // Files of one process share the modules, which halves the time.
    isolate: false,
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
