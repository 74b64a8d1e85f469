import { readdirSync } from "node:fs";

import js from "@eslint/js";
import jsxA11y from "eslint-plugin-jsx-a11y";
import reactHooks from "eslint-plugin-react-hooks";
import lingui from "eslint-plugin-lingui";
import globals from "globals";
import tseslint from "typescript-eslint";

const PARENTS = { group: ["../*"], message: "Import another folder's modules by @/." };
const features = readdirSync(new URL("./src/features", import.meta.url));

export default tseslint.config(
  { ignores: ["node_modules", "src/api/schema.d.ts", "public"] },
  js.configs.recommended,
  ...tseslint.configs.strictTypeChecked,
  ...tseslint.configs.stylisticTypeChecked,
  reactHooks.configs.flat.recommended,
  jsxA11y.flatConfigs.recommended,
  {
    languageOptions: {
      globals: globals.browser,
      parserOptions: { projectService: true, tsconfigRootDir: import.meta.dirname },
    },
    rules: {
      "@typescript-eslint/consistent-type-imports": "error",
      "@typescript-eslint/restrict-template-expressions": ["error", { allowNumber: true }],
      "@typescript-eslint/no-confusing-void-expression": ["error", { ignoreArrowShorthand: true }],
      "no-console": "error",
    },
  },
  {
    files: ["src/**"],
    ignores: ["src/lib/browser/storage.ts"],
    rules: {
      "no-restricted-globals": [
        "error",
        ...["localStorage", "sessionStorage"].map((name) => ({
          name,
          message: "Access may throw: use @/lib/browser/storage.",
        })),
      ],
    },
  },
  {
    files: ["src/**"],
    plugins: { lingui },
    rules: {
      "no-restricted-imports": ["error", { patterns: [PARENTS] }],
      // At the top of a module a text is read before the language is known.
      "lingui/t-call-in-function": "error",
      "lingui/no-single-tag-to-translate": "error",
      "lingui/no-single-variables-to-translate": "error",
    },
  },
  ...features.map((feature) => ({
    files: [`src/features/${feature}/**`],
    rules: {
      "no-restricted-imports": [
        "error",
        {
          patterns: [
            PARENTS,
            {
              group: ["@/app/**", "@/features/*", `!@/features/${feature}`],
              message: "A feature imports neither another feature nor the app.",
            },
          ],
        },
      ],
    },
  })),
  ...[
    ["components", ["app", "features"]],
    ["api", ["app", "features", "components"]],
    ["lib", ["app", "features", "components", "api"]],
  ].map(([layer, above]) => ({
    files: [`src/${layer}/**`],
    rules: {
      "no-restricted-imports": [
        "error",
        {
          patterns: [
            PARENTS,
            {
              group: above.map((name) => `@/${name}/**`),
              message: `${layer} imports only from the layers below it.`,
            },
          ],
        },
      ],
    },
  })),
  { files: ["*.js"], ...tseslint.configs.disableTypeChecked },
  { files: ["check-texts.js"], languageOptions: { globals: globals.node } },
);
